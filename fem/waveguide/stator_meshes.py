"""Meshed pieces of a stator: those between uniform segments, those that are its ends, or one that is the whole stator.

Pieces of equal mesh, materials and electrodes are assembled and condensed once.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from fem.condense.condensed_mesh import Assembly, MeshedPiece
from fem.condense.interpolated_piece import ReducedPiece
from fem.condense.mesh_assembly import assembled
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.geometry import Stator
from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.placement import is_step
from fem.waveguide.end_conditions import Beyond, End, Wall, closed
from fem.waveguide.guided_modes import GuidedModes, guided_modes


@dataclass(frozen=True, kw_only=True)
class CondensedPieces:
    """Meshed pieces at one frequency; lengths in the section's unit."""

    between: tuple[tuple[float, MeshedPiece | ReducedPiece], ...] = field(repr=False)  # left line, piece
    ends: tuple[End, End] = field(repr=False)
    # start, stop: where the uniform stator begins and ends
    start: float
    stop: float

    @property
    def whole(self) -> bool:
        """True if one piece is the whole stator from end to end, which has no lines."""
        return bool(self.between) and self.between[0][1].size == 0


def no_pieces(stator: Stator, unit: float) -> CondensedPieces:
    """A cascade without meshed pieces; ``unit``: the length unit in m."""
    return CondensedPieces(between=(), ends=(stator.ends,) * 2, start=0.0, stop=stator.length / unit)


class StatorMeshes:
    """The meshed pieces of a stator on one section, assembled for all frequencies up to one (Hz)."""

    def __init__(self, stator: Stator, section: Section, resolution: Resolution, frequency: float):
        self.stator, self.section, self.resolution = stator, section, resolution
        self.assemblies: dict[tuple, Assembly] = {}
        if not stator.pieces:
            return
        placed, line = stator.placement, {"left": section, "right": section}
        on_lines: list[tuple[MeshPiece | None, dict[str, Section]]] = [
            *((piece, line) for piece in placed.between),
            (placed.ends[0], {"right": section}),
            (placed.ends[1], {"left": section}),
            (placed.whole, {}),
        ]
        frame = _frame(stator)
        for piece, sections in on_lines:
            if piece is None or is_step(piece, stator.depth) or piece.contents in self.assemblies:
                continue
            self.assemblies[piece.contents] = assembled(
                piece, frame, section, sections, frequency=frequency, resolution=resolution
            )

    def condensed(self, frequency: float) -> dict[tuple, MeshedPiece]:
        """All distinct pieces at a frequency in Hz, except those at a step of thickness."""
        return {key: assembly.condensed(frequency) for key, assembly in self.assemblies.items()}

    def arranged(self, condensed: dict, modes: GuidedModes) -> CondensedPieces:
        """The pieces in cascade at the frequency of ``modes``; ``condensed``: result of the method of this name."""
        stator, unit = self.stator, self.section.length_unit
        if not stator.pieces:
            return no_pieces(stator, unit)
        placed = stator.placement
        ends: list[End] = [stator.ends, stator.ends]
        for side, piece in enumerate(placed.ends):
            if piece is None:
                continue
            if is_step(piece, stator.depth):
                ends[side] = _step(piece, side, stator, modes, self.resolution)
            else:
                end = condensed[piece.contents]
                ends[side] = Wall(matrix=end.matrix, recover=end.recover, floating_potential=end.floating_potential)
        inner = placed.between if placed.whole is None else (placed.whole,)
        return CondensedPieces(
            between=tuple((piece.extent[0] / unit, condensed[piece.contents]) for piece in inner),
            ends=(ends[0], ends[1]),
            start=placed.start / unit,
            stop=placed.stop / unit,
        )


def condensed_pieces(stator: Stator, modes: GuidedModes, resolution: Resolution) -> CondensedPieces:
    """Condense a stator's meshed pieces at the frequency of its modes."""
    meshes = StatorMeshes(stator, modes.section.full, resolution, modes.frequency)
    return meshes.arranged(meshes.condensed(modes.frequency), modes)


def _step(piece: MeshPiece, side: int, stator: Stator, modes: GuidedModes, resolution: Resolution) -> Wall:
    """Step of thickness as a wall: the radiation impedance of the section behind it terminates the piece's far line.

    The near line is the one towards the middle of the stator.  ``side``: 0 for the left end, 1 for the right.
    """
    near, far = ("right", "left") if side == 0 else ("left", "right")
    section, frequency, interface = modes.section.full, modes.frequency, piece.interface(far)
    if interface is None:
        raise ValueError(f"piece {piece.name!r} has no group {far}: nothing lies behind it")
    behind = replace(stator, thickness=interface[1], pieces=())
    other = discretise(behind, resolution, wavelength=section.length_unit, surface_scale=np.inf)
    outside = guided_modes(other, frequency)
    sections = {near: section, far: other}
    assembly = assembled(piece, _frame(stator), section, sections, frequency=frequency, resolution=resolution)
    # The condensed matrix has the left line first: at the left end (side 0) that is the far one, of size `other.size`.
    left_line, right_line = np.split(np.arange(section.size + other.size), [other.size if side == 0 else section.size])
    near_line, far_line = (right_line, left_line) if side == 0 else (left_line, right_line)
    impedance = outside.left_impedance if side == 0 else outside.right_impedance
    wall, far_from_near = closed(assembly.condensed(frequency), near_line, far_line, impedance)
    beyond = Beyond(modes=outside, position=interface[0] / section.length_unit, far_line=far_from_near)
    return replace(wall, beyond=beyond)


def _frame(stator: Stator) -> Stator:
    """Part of a stator on which the elements of a piece depend."""
    return replace(stator, length=1.0, ends="absorbing", pieces=())
