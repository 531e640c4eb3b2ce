"""Reflection and transmission of the surface wave at meshed pieces: one piece, a cascade of them, an end of the stator.

The pieces stand between uniform semi-infinite segments.  Waves are scaled as in `fem.solve.p_matrix_from_field`: a wave
of amplitude a carries the power |a|^2 / 2 per metre of y.  |R|^2 + |T|^2 is then the share of the power that stays in
the surface wave; the rest goes into other modes of the section (bulk waves) or is lost in the solid.  Phases refer to
the outer interfaces of the pieces.  A cascade couples its pieces by all modes that do not decay within the shortest
gap.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fem.condense.cascade_piece import Piece
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import refine_stator
from fem.exceptions import InputError, refuse_above
from fem.geometry import Stator
from fem.layout import check_beside_pieces, check_interfaces
from fem.mesh.placement import is_step
from fem.solve.p_matrix_from_field import PMatrix, of_segments, waves_of
from fem.threads import one_blas_thread
from fem.waveguide.end_conditions import Wall
from fem.waveguide.guided_modes import GuidedModes, guided_modes
from fem.waveguide.scattering_network import Network, Scatterer
from fem.waveguide.stator_meshes import CondensedPieces, condensed_pieces


@dataclass(frozen=True, kw_only=True)
class Reflector:
    """Reflection and transmission of the surface wave by the pieces of a stator at one frequency.

    Attributes
    ----------
    frequency : float
        Hz.
    wavelength : float
        Of the surface wave, m.
    cascade : PMatrix or None
        Of all pieces between uniform segments as one cascade, from the left interface of the first to the right one of
        the last, with short-circuited electrodes.  A plate with two equal faces has two waves; the first is that of the
        upper surface.  None without such pieces.
    pieces : tuple of (str, PMatrix)
        Name and P-matrix of each distinct piece alone.
    positions : tuple of (float, int)
        For every piece from left to right: its left interface in m and its index in ``pieces``.
    ends : tuple of (str, complex)
        Reflection of the surface wave at the ends that are meshes.
    relative_error : float
        Of the amplitudes, over 1, from two discretisations.
    """

    frequency: float
    wavelength: float
    cascade: PMatrix | None = field(repr=False)
    pieces: tuple[tuple[str, PMatrix], ...] = field(repr=False)
    positions: tuple[tuple[float, int], ...]
    ends: tuple[tuple[str, complex], ...]
    relative_error: float

    @property
    def scattering(self) -> np.ndarray | None:
        """S of the whole cascade, (2 waves, 2 waves): surface waves at its left edge first, then at its right one."""
        return None if self.cascade is None else self.cascade.scattering

    @property
    def reflection(self) -> complex:
        """Reflected amplitude for a surface wave of amplitude 1 from the left."""
        return complex(self._scattered[0])

    @property
    def transmission(self) -> complex:
        """Transmitted amplitude for a surface wave of amplitude 1 from the left."""
        return complex(self._scattered[len(self._scattered) // 2])

    @property
    def scattered(self) -> float:
        """Share of the incident power, from the left, that is scattered into bulk waves or lost in the solid."""
        return float(1 - np.sum(abs(self._scattered) ** 2))

    @property
    def _scattered(self) -> np.ndarray:
        """Amplitudes that leave the cascade for a surface wave of amplitude 1 from the left, (2 waves,)."""
        if self.cascade is None:
            raise InputError("piece", "must stand between the ends: the ends alone have no transmission")
        return self.cascade.scattering[:, 0]


@one_blas_thread
def reflector(stator: Stator, *, frequency: float, tolerance: float) -> Reflector:
    """Reflection of the surface wave at a stator's meshed pieces, without its transducers.

    Parameters
    ----------
    stator : Stator
        With ``pieces``.
    frequency : float
        Hz.
    tolerance : float
        Of the amplitudes, over 1.

    Raises
    ------
    InputError
        If the stator has no pieces, or one does not meet its section.
    ConvergenceError
        If the finest discretisation does not reach the tolerance.
    """
    if not stator.pieces:
        raise InputError("piece", "is missing: a reflection needs at least one meshed piece")
    check_interfaces(stator)
    check_beside_pieces(stator)

    def at_level(resolution: Resolution) -> Reflector:
        unit = stator.slowest_wavelength(frequency)
        section = discretise(stator, resolution, wavelength=unit, surface_scale=np.inf)
        modes = guided_modes(section, frequency)
        return _of_cascade(stator, modes, condensed_pieces(stator, modes, resolution))

    refined = refine_stator(stator, at_level, differences=_difference, tolerance=tolerance)
    result = replace(refined.answer, relative_error=refined.errors[0])
    refuse_above(result.relative_error, tolerance, "the reflection is", reached=result)
    return result


def _of_cascade(stator: Stator, modes: GuidedModes, meshed: CondensedPieces) -> Reflector:
    """Reflector on one discretisation, without an error."""
    waves = waves_of(modes, modes.rayleigh, modes.section.solid.stress_unit)

    def p_matrix_of(pieces: Sequence[tuple[float, Piece]]) -> PMatrix:
        network = Network(
            modes=modes,
            scatterers=tuple(
                Scatterer(piece=piece, modes=modes, potentials=np.zeros((len(piece.ports), 0))) for _, piece in pieces
            ),
            positions=tuple(position for position, _ in pieces),
            start=pieces[0][0],
            stop=pieces[-1][0] + pieces[-1][1].width,
            ends=("absorbing", "absorbing"),
            ports=(),
            numbers=(np.empty(0, dtype=int),) * len(pieces),
        )
        segments = network.solve(waves.modes).segments
        return of_segments(segments, waves, length=network.stop - network.start)

    # pieces of equal contents are one object (`StatorMeshes`), by which their P-matrix is looked up
    alone: dict[int, tuple[str, PMatrix]] = {}
    positions = []
    for piece, (position, condensed) in zip(stator.placement.between, meshed.between, strict=True):
        if id(condensed) not in alone:
            alone[id(condensed)] = piece.name, p_matrix_of([(position, condensed)])
        positions.append((position * modes.section.length_unit, list(alone).index(id(condensed))))
    ends = []
    for side, (end_piece, wall) in enumerate(zip(stator.placement.ends, meshed.ends, strict=True)):
        if end_piece is None or not isinstance(wall, Wall):
            continue
        reflected = wall.reflection(modes, side, waves.modes)[waves.modes]
        outgoing, incident = (waves.right, waves.left) if side == 0 else (waves.left, waves.right)
        kind = "step" if is_step(end_piece, stator.depth) else "end"
        # from amplitudes of modes to those of the scaled surface waves, which in a plate are mixtures of two modes
        reflection = np.linalg.solve(outgoing, reflected @ incident)[0, 0]
        ends.append((f"{end_piece.name} ({kind})", complex(reflection)))
    surface = modes.wavenumbers[waves.modes].real.mean() / modes.section.length_unit
    return Reflector(
        frequency=modes.frequency,
        wavelength=float(2 * np.pi / surface),
        cascade=p_matrix_of(meshed.between) if meshed.between else None,
        pieces=tuple(alone.values()),
        positions=tuple(positions),
        ends=tuple(ends),
        relative_error=np.nan,
    )


def _difference(fine: Reflector, coarse: Reflector) -> tuple[float]:
    differences = [abs(one[1] - other[1]) for one, other in zip(fine.ends, coarse.ends, strict=True)]
    if fine.scattering is not None and coarse.scattering is not None:
        if fine.scattering.shape != coarse.scattering.shape:
            return (1.0,)
        differences.append(abs(fine.scattering - coarse.scattering).max())
    return (float(max(differences)),)
