"""Reflection and transmission of the surface wave at meshed pieces: one piece, a row of them, an end of the stator.

The pieces stand between uniform segments that continue without end.  Waves are scaled as in `fem.solve.p_matrix`, a
wave of amplitude a carries |a|^2 / 2 per metre of y, so that |R|^2 + |T|^2 is the share of the power that stays in the
surface wave; the rest goes into other modes of the section (bulk waves) or is lost in the solid.  Phases refer to the
outer interfaces of the pieces.  In a row all modes that survive the shortest gap are followed from piece to piece.
"""

from dataclasses import dataclass, field, replace

import numpy as np

from fem.convergence import ConvergenceError
from fem.discretize.elements import discretise
from fem.discretize.grading import Resolution
from fem.discretize.refinement import refine_stator
from fem.geometry import Stator
from fem.input_error import InputError
from fem.materials.christoffel import slowest_wavelength
from fem.mesh.layout import is_step
from fem.solve.p_matrix import waves_of
from fem.threads import one_blas_thread
from fem.waveguide.ends import Wall
from fem.waveguide.modes import GuidedModes, guided_modes
from fem.waveguide.network import NEGLIGIBLE, Scatterer
from fem.waveguide.row import CondensedPieces, condensed_pieces


@dataclass(frozen=True, kw_only=True)
class Reflector:
    """What the pieces of a stator do to its surface wave at one frequency.

    Attributes
    ----------
    frequency : float
        Hz.
    wavelength : float
        Of the surface wave, m.
    scattering : ndarray, shape (2 waves, 2 waves), or None
        Of all pieces between uniform segments together: surface waves at the left interface of the first, then at the
        right one of the last; in a plate of two like faces there are two waves, the first that of the surface.  None
        without such pieces.
    pieces : tuple of (str, ndarray)
        The same for each different piece alone, with its name.
    ends : tuple of (str, complex)
        Reflection of the surface wave at the ends that are meshes.
    relative_error : float
        Of the amplitudes, over 1, from two discretisations.
    """

    frequency: float
    wavelength: float
    scattering: np.ndarray | None = field(repr=False)
    pieces: tuple[tuple[str, np.ndarray], ...] = field(repr=False)
    ends: tuple[tuple[str, complex], ...]
    relative_error: float

    @property
    def reflection(self) -> complex:
        """Amplitude that the row sends back of a surface wave from the left."""
        return complex(self.scattering[0, 0])

    @property
    def transmission(self) -> complex:
        """Amplitude that passes the row."""
        return complex(self.scattering[len(self.scattering) // 2, 0])

    @property
    def scattered(self) -> float:
        """Share of the power of a surface wave from the left that leaves in no surface wave: scattered or lost."""
        return float(1 - np.sum(abs(self.scattering[:, 0]) ** 2))


@one_blas_thread
def reflector(stator: Stator, *, frequency: float, tolerance: float) -> Reflector:
    """Reflection of the surface wave at a stator's meshed pieces; its transducers are not looked at.

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
        If the stator has no pieces.
    ConvergenceError
        If the finest discretisation does not reach the tolerance.
    """
    if not stator.pieces:
        raise InputError("piece", "is missing: a reflection needs at least one meshed piece")

    def at_level(resolution: Resolution) -> Reflector:
        unit = slowest_wavelength(stator.solid, frequency)
        section = discretise(stator, resolution, wavelength=unit, surface_scale=np.inf)
        modes = guided_modes(section, frequency)
        return _of_row(stator, modes, condensed_pieces(stator, modes, resolution))

    refined = refine_stator(stator, at_level, differences=_difference, tolerance=tolerance)
    result = replace(refined.answer, relative_error=refined.errors[0])
    if result.relative_error > tolerance:
        raise ConvergenceError(
            f"the reflection is known to {result.relative_error:.1e} only, {tolerance:.1e} was asked for: ask for less",
            reached=result,
        )
    return result


def _of_row(stator: Stator, modes: GuidedModes, row: CondensedPieces) -> Reflector:
    chosen = modes.rayleigh
    right, left = waves_of(modes, chosen, modes.section.solid.stress_unit)
    scatterers = [
        Scatterer(superelement=piece, modes=modes, potentials=np.zeros((len(piece.ports), 0)))
        for _, piece in row.between
    ]
    starts = np.array([place for place, _ in row.between])
    stops = starts + [each.superelement.width for each in scatterers]
    gaps = starts[1:] - stops[:-1]
    kept = np.array(chosen)
    if len(gaps):
        alive = (abs(np.exp(-1j * modes.wavenumbers * gaps.min())) > NEGLIGIBLE) & (modes.wavenumbers != 0)
        kept = np.append(chosen, np.setdiff1d(np.flatnonzero(alive), chosen))
    alone: dict[int, np.ndarray] = {}
    for each in scatterers:
        if id(each.superelement) not in alone:
            alone[id(each.superelement)] = _response(each, kept)

    def in_waves(response: np.ndarray) -> np.ndarray:
        m, count = len(chosen), len(response) // 2
        rows = np.r_[0:m, count : count + m]
        turn_in = np.zeros((2 * m, 2 * m), dtype=complex)
        turn_out = np.zeros_like(turn_in)
        turn_in[:m, :m], turn_in[m:, m:] = right, left
        turn_out[:m, :m], turn_out[m:, m:] = left, right
        return np.linalg.solve(turn_out, response[np.ix_(rows, rows)] @ turn_in)

    names: dict[int, str] = {}
    for piece, each in zip(stator.placement.between, scatterers, strict=True):
        names.setdefault(id(each.superelement), piece.name)
    together = None
    if scatterers:
        together = in_waves(_joined(modes, kept, [alone[id(each.superelement)] for each in scatterers], gaps))
    ends = []
    for side, (piece, wall) in enumerate(zip(stator.placement.ends, row.ends, strict=True)):
        if piece is None or not isinstance(wall, Wall):
            continue
        sent = wall.sent_back(modes, side, chosen)[chosen]
        turned = np.linalg.solve(right, sent @ left) if side == 0 else np.linalg.solve(left, sent @ right)
        kind = "step" if is_step(piece, stator.thickness) else "end"
        ends.append((f"{piece.name} ({kind})", complex(turned[0, 0])))
    surface = modes.wavenumbers[chosen].real.mean() / modes.section.length_unit
    return Reflector(
        frequency=modes.frequency,
        wavelength=float(2 * np.pi / surface),
        scattering=together,
        pieces=tuple((names[key], in_waves(response)) for key, response in alone.items()),
        ends=tuple(ends),
        relative_error=np.nan,
    )


def _response(scatterer: Scatterer, kept: np.ndarray) -> np.ndarray:
    """Amplitudes that leave to the left, then to the right, for modes that arrive from the left, then the right."""
    modes, n, m = scatterer.modes, scatterer.superelement.size, len(kept)
    incoming = np.zeros((2 * n, 2 * m), dtype=complex)
    incoming[:n, :m], incoming[n:, m:] = modes.right[:, kept], modes.left[:, kept]
    out = scatterer.sides(incoming, np.zeros((len(scatterer.potentials), 2 * m))) - incoming
    return np.concatenate([modes.left_amplitudes(out[:n])[kept], modes.right_amplitudes(out[n:])[kept]])


def _joined(modes: GuidedModes, kept: np.ndarray, parts: list[np.ndarray], gaps: np.ndarray) -> np.ndarray:
    """Response of a row from those of its parts, with gaps between them (length units): Redheffer's star product."""
    m = len(kept)
    whole = parts[0]
    for part, gap in zip(parts[1:], gaps, strict=True):
        onwards = np.exp(-1j * modes.wavenumbers[kept] * gap)[:, None]
        back = np.exp(1j * modes.backwards[kept] * gap)[:, None]
        # p leaves the left part to the right, q the right part to the left:
        # p = whole_21 a + whole_22 (back q),  q = part_11 (onwards p) + part_12 b
        system = np.eye(2 * m, dtype=complex)
        system[:m, m:] = -whole[m:, m:] * back.T
        system[m:, :m] = -part[:m, :m] * onwards.T
        load = np.zeros((2 * m, 2 * m), dtype=complex)
        load[:m, :m], load[m:, m:] = whole[m:, :m], part[:m, m:]
        p, q = np.split(np.linalg.solve(system, load), 2)
        new = np.concatenate([whole[:m, m:] @ (back * q), part[m:, :m] @ (onwards * p)])
        new[:m, :m] += whole[:m, :m]
        new[m:, m:] += part[m:, m:]
        whole = new
    return whole


def _difference(fine: Reflector, coarse: Reflector) -> tuple[float]:
    apart = [abs(one[1] - other[1]) for one, other in zip(fine.ends, coarse.ends, strict=True)]
    if fine.scattering is not None:
        if fine.scattering.shape != coarse.scattering.shape:
            return (1.0,)
        apart.append(abs(fine.scattering - coarse.scattering).max())
    return (float(max(apart)),)
