"""Evaluation of a solution: amplitudes of the modes in the segments, nodal values in the columns of elements."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from fem.condense.column import ColumnField
from fem.results.solution import Solution
from fem.results.surface import CondensedPiece, Surface, UniformSegment
from fem.waveguide.ends import Wall
from fem.waveguide.network import SegmentWaves

ENDS = (-1, -2)  # "scatterer" numbers of the left and the right end where they are condensed pieces


def surface_of(solution: Solution, solve: Callable[[], Solution] | None = None) -> Surface:
    """Motion of the surface; ``solve`` returns the solution again, for the columns, if it is not to be kept."""
    fields = solution.fields
    modes, section = fields.modes, fields.section
    surface = modes.rayleigh
    shape = section.surface_rows @ modes.right[:, surface]
    speed = 2 * np.pi * modes.frequency * section.length_unit / np.mean(modes.wavenumbers[surface].real)
    return Surface(
        frequency=modes.frequency,
        length=fields.stator.length,
        pieces=_pieces(solution, solve or (lambda: solution)),
        phase_velocity=float(speed),
        surface_ratio=float(abs(np.mean(shape[0] / shape[1]))),
    )


def _pieces(solution: Solution, solve: Callable[[], Solution]) -> tuple:
    """Pieces of the surface from left to right, in m and m per volt."""
    fields = solution.fields
    network, length = fields.network, fields.stator.length
    segments = [[_segment(solution, part) for part in parts] for parts in fields.segments]

    def condensed(start: float, stop: float, index: int, **rest) -> CondensedPiece:
        unit = fields.section.length_unit
        origin = start if np.isfinite(start) else stop
        return CondensedPiece(
            start=start,
            stop=stop,
            recover=lambda: _in_metres(recovered(solve(), index), origin, unit),
            index=index,
            **rest,
        )

    pieces: list = [*segments[0]]
    for index, (before, after) in enumerate(pairwise(segments)):
        transducer = fields.owners[index] is not None
        pieces += [condensed(before[-1].stop, after[0].start, index, transducer=transducer), *after]
    for side, wall in enumerate(network.ends):
        if not isinstance(wall, Wall):
            continue
        beside = segments[-side][-side]
        meshed = fields.stator.placement.ends[side] if fields.stator.pieces else None
        span = (0.0, beside.start) if side == 0 else (beside.stop, length)
        if meshed is not None:
            low, high = meshed.extent
            span = (low, beside.start) if side == 0 else (beside.stop, high)
        piece = condensed(*span, ENDS[side], beside=None if meshed else beside, transducer=False)
        outside = [] if wall.beyond is None else [_beyond(solution, side, length)]
        pieces = [*outside, piece, *pieces] if side == 0 else [*pieces, piece, *outside]
    return tuple(pieces)


def _in_metres(field, origin: float, unit: float) -> Callable[[np.ndarray], np.ndarray]:
    """Surface motion of a recovered field as a function of x in m."""
    return lambda x: field.motion((x - origin) / unit)


def _beyond(solution: Solution, side: int, length: float) -> UniformSegment:
    """The stator of another thickness behind a step: what leaves there."""
    outside, unit = wall_of(solution, side).beyond, solution.fields.section.length_unit
    modes, line = outside.modes, outside.far_line @ end_line(solution, side)
    right, left = (np.zeros(len(line), dtype=complex) for _ in range(2))
    if side:
        right = modes.right_amplitudes(line)
    else:
        left = modes.left_amplitudes(line)
    place = outside.place * unit
    return UniformSegment(
        start=place if side else min(0.0, place),
        stop=max(length, place) if side else place,
        right=right,
        left=left,
        wavenumbers=modes.wavenumbers / unit,
        backwards=modes.backwards / unit,
        right_shapes=modes.section.surface_rows @ modes.right,
        left_shapes=modes.section.surface_rows @ modes.left,
        rayleigh=modes.rayleigh,
        beyond=True,
    )


def _segment(solution: Solution, part: SegmentWaves) -> UniformSegment:
    modes, section, unit = solution.fields.modes, solution.fields.section, solution.fields.section.length_unit
    return UniformSegment(
        start=part.start * unit,
        stop=part.stop * unit,
        right=part.right @ solution.weights,
        left=part.left @ solution.weights,
        wavenumbers=modes.wavenumbers / unit,
        backwards=modes.backwards / unit,
        right_shapes=section.surface_rows @ modes.right,
        left_shapes=section.surface_rows @ modes.left,
        rayleigh=modes.rayleigh,
    )


def end_line(solution: Solution, side: int) -> np.ndarray:
    """Unknowns of the line where the uniform stator meets an end that is a condensed piece."""
    modes = solution.fields.modes
    part = solution.fields.segments[-side][-side]
    place = part.stop if side else part.start
    right, left = (each(modes, place) @ solution.weights for each in (part.right_at, part.left_at))
    (left if side else right)[modes.wavenumbers == 0] = (
        0.0  # a matter of gauge: the potential refers to the transducer
    )
    return modes.right @ right + modes.left @ left


def wall_of(solution: Solution, side: int) -> Wall:
    """The left (0) or right (1) end, which is a condensed piece; a TypeError for another."""
    wall = solution.fields.network.ends[side]
    if not isinstance(wall, Wall):
        raise TypeError("the end is no condensed piece")
    return wall


def recovered(solution: Solution, index: int):
    """Field inside a scatterer or an end (`ENDS`): `fem.condense.piece.RecoveredField`."""
    network = solution.fields.network
    if index in ENDS:
        side = ENDS.index(index)
        return wall_of(solution, side).recover(end_line(solution, side))
    return network.scatterers[index].recover(solution.sides(index))


def left_edge(solution: Solution, index: int) -> float:
    """Where a scatterer or an end that is a condensed piece begins, m."""
    network, unit = solution.fields.network, solution.fields.section.length_unit
    if index not in ENDS:
        return network.places[index] * unit
    side = ENDS.index(index)
    ends = solution.fields.stator.placement.ends
    if side == 0:
        return 0.0 if ends[0] is None else ends[0].extent[0]
    return network.stop * unit


def column_fields(solution: Solution, index: int):
    """Columns of a transducer by kind: (recovery, left edges in m, sides (2 n + 2, places))."""
    unit = solution.fields.section.length_unit
    for recovery, starts, sides in recovered(solution, index).kinds:
        yield recovery, left_edge(solution, index) + starts * unit, sides


def columns_in_row(
    solution: Solution, index: int, of: Callable[[ColumnField, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a transducer or an end from left to right: left edges and widths (m), fields (columns, ...).

    ``of``: recovery and sides of some columns -> their fields, shape (..., columns).
    """
    unit = solution.fields.section.length_unit
    starts, widths, values = recovered(solution, index).in_row(of)
    return left_edge(solution, index) + starts * unit, widths * unit, values
