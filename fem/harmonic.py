"""The driven stator at one frequency: from the scene's geometry to the surface motion per volt, with its error.

The problem is solved on two discretisations, one a level finer than the other.  Their difference, less the gain that a
level is sure to bring, is the error reported.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fem.audit import audit
from fem.convergence import ConvergenceError
from fem.geometry import Stator, Transducer, check_layout
from fem.materials import fields
from fem.readout import surface_wave
from fem.section import Resolution
from fem.slowness import stretch_absorbs
from fem.solution import solved
from fem.surface import SurfaceWave
from fem.threads import one_blas_thread

# From coarse to fine: measured on the seed's stator (admittance and surface motion move together).
LEVELS = (
    Resolution(order=5, edge_layers=0, lossy_elements=5),
    Resolution(order=6, edge_layers=1, lossy_elements=6),
    Resolution(order=7, edge_layers=2, lossy_elements=8),
    Resolution(order=8, edge_layers=3, lossy_elements=10),
    Resolution(order=9, edge_layers=4, lossy_elements=12),
    Resolution(order=10, edge_layers=5, lossy_elements=14),
)
EXPECTED = (
    np.inf,
    5e-3,
    2e-4,
    2e-5,
    2e-6,
    3e-7,
)  # estimate at each level on an ordinary motor: where to begin
GAIN = 8.0  # a level divides the error by more: 6.7 per edge layer, and more by the order (11 to 25 seen)
CORNER_GAIN = 2.0  # where clamped and free sides meet the stress is singular, and only the order helps
LOSSY_GAIN = 1.5  # where a lossy layer stands for the half-space its thickness decides, squared


@one_blas_thread
def driven_wave(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    driven: str,
    source_impedance: complex = 0.0,
    tolerance: float,
    places: tuple[float, ...] = (),
    progress: Callable[[str], None] | None = None,
) -> SurfaceWave:
    """Surface motion, admittance and power of the driven stator, per volt of the source.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
    frequency : float
        Hz.
    driven : str
        Name of the driven transducer.
    source_impedance : complex
        Ohm.
    tolerance : float
        Relative, of the surface motion at ``places``.
    places : tuple of float
        m from the left end; mid-stator if empty.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    SurfaceWave

    Raises
    ------
    ValueError
        For a geometry or a solid that cannot be driven.
    ConvergenceError
        If the finest discretisation does not reach the tolerance; what was reached comes with it.
    """
    check_layout(stator, transducers)
    if "phi" not in fields(stator.solid):
        why = "uncouples phi in this orientation" if stator.solid.is_piezoelectric else "is not piezoelectric"
        raise ValueError(f"a transducer needs a piezoelectric stator, and {stator.solid.name} {why}")
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"tolerance must be positive and finite, got {tolerance!r}")
    if not (np.isfinite(frequency) and frequency > 0):
        raise ValueError(f"drive.frequency must be positive and finite, got {frequency!r} Hz")
    begun = time.perf_counter()
    at = np.array(places or (stator.length / 2,))
    say = progress or (lambda text: None)

    def at_level(resolution: Resolution) -> SurfaceWave:
        say(f"stator: order {resolution.order}, {resolution.edge_layers} edge layers")
        return surface_wave(
            solved(
                stator,
                transducers,
                frequency=frequency,
                driven=driven,
                source_impedance=source_impedance,
                resolution=resolution,
            )
        )

    wave, refusal = _climbed(at_level, first_level(tolerance), tolerance, at, _gain(stator))
    wave = _audited(wave, begun, say)
    if wave.relative_error > tolerance:
        raise ConvergenceError(
            f"the stator's surface motion is known to {wave.relative_error:.1e} only, {tolerance:.1e} was asked for: "
            f"ask for less, or {refusal}",
            reached=wave,
        )
    return wave


def _climbed(
    at_level: Callable[[Resolution], SurfaceWave], level: int, tolerance: float, at: np.ndarray, gain: float
) -> tuple[SurfaceWave, str]:
    """Climb the levels to the tolerance, or as far as they go; return the wave and why it went no further."""
    coarse = reached = None
    for resolution in LEVELS[level:]:
        try:
            wave = at_level(resolution)
        except ConvergenceError as error:
            if reached is not None:
                return reached, f"finer, {error}"
            if level == 0:
                raise
            return _climbed(at_level, level - 1, tolerance, at, gain)  # a coarser pair says how far it got
        if coarse is not None:
            wave = reached = replace(
                wave,
                relative_error=orbit_difference(wave, coarse, at) / (gain - 1),
                admittance_error=abs(wave.admittance / coarse.admittance - 1) / (gain - 1),
            )
            if wave.relative_error <= tolerance:
                break
        coarse = wave
    return reached, "make the fingers less extreme"


def _audited(wave: SurfaceWave, begun: float, say: Callable[[str], None]) -> SurfaceWave:
    """Return a wave with its powers and the time since it was begun."""
    say("stator: power balance")
    powers = audit(wave.solution)
    return replace(
        wave,
        power_input=powers.input,
        power_dissipated=powers.dissipated,
        power_radiated=powers.radiated,
        power_residual=powers.residual,
        seconds=time.perf_counter() - begun,
    )


def _gain(stator: Stator) -> float:
    """By how much a level divides the error, at least."""
    if stator.absorbs_below and not stretch_absorbs(stator.solid):
        return LOSSY_GAIN
    corners = stator.ends == "clamped" or (stator.ends == "free" and stator.bottom == "clamped")
    return CORNER_GAIN if corners else GAIN


def first_level(tolerance: float) -> int:
    """Coarser of the two levels to begin with."""
    enough = [level for level, error in enumerate(EXPECTED) if error <= tolerance]
    return (enough[0] if enough else len(EXPECTED) - 1) - 1


def planned_levels(stator: Stator, tolerance: float) -> range:
    """Levels that an ordinary layout on this stator is solved at; where the estimate demands it one more follows."""
    first = first_level(tolerance)
    slower = (GAIN - 1) / (_gain(stator) - 1)
    enough = [level for level, error in enumerate(EXPECTED) if error * slower <= tolerance]
    return range(first, max(first + 1, enough[0] if enough else len(LEVELS) - 1) + 1)


def orbit_difference(wave: SurfaceWave, other: SurfaceWave, at: np.ndarray) -> float:
    """Largest relative difference of the orbits at places; a common phase, which moves nothing, does not count."""
    return motion_difference(wave.motion(at), other.motion(at))


def motion_difference(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest relative difference of orbits, u_x and u_z by place, shape (2, places), but for a common phase."""
    turn = np.exp(1j * np.angle(np.sum(np.conj(theirs) * ours, axis=0)))
    size = abs(ours).max(axis=0)
    change = abs(ours - turn * theirs).max(axis=0)
    return float(np.max(change / size))
