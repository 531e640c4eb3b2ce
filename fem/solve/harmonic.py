"""The driven stator at one frequency: from the scene's geometry to the surface motion per volt, with its error.

The problem is solved on two discretisations, one a level finer than the other.  Their difference, less the gain that a
level is sure to bring, is the error reported.
"""

import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from fem.convergence import ConvergenceError
from fem.discretize.refinement import LEVELS, first_level, level_gain
from fem.discretize.section import Resolution
from fem.geometry import Stator, Transducer, check_layout
from fem.materials import fields
from fem.results.evaluation import surface_wave
from fem.results.power_balance import audit
from fem.results.surface import SurfaceWave
from fem.solution import solved
from fem.threads import one_blas_thread


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

    wave, refusal = _climbed(at_level, first_level(tolerance), tolerance, at, level_gain(stator))
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


def orbit_difference(wave: SurfaceWave, other: SurfaceWave, at: np.ndarray) -> float:
    """Largest relative difference of the orbits at places; a common phase, which moves nothing, does not count."""
    return motion_difference(wave.motion(at), other.motion(at))


def motion_difference(ours: np.ndarray, theirs: np.ndarray) -> float:
    """Largest relative difference of orbits, u_x and u_z by place, shape (2, places), but for a common phase."""
    turn = np.exp(1j * np.angle(np.sum(np.conj(theirs) * ours, axis=0)))
    size = abs(ours).max(axis=0)
    change = abs(ours - turn * theirs).max(axis=0)
    return float(np.max(change / size))
