"""The driven stator at one frequency: from the scene's geometry to the surface motion per volt, with its error.

The problem is solved on two neighbouring levels of discretisation, and on finer ones until the tolerance is met.  The
difference of the last two answers divided by g - 1 is the error reported, where a level divides the error by at least g
(`fem.discretize.mesh_refinement`).  With an infinite tolerance only the coarsest level is solved.
"""

import logging
from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np

from fem.circuit import Drive
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import refine_stator
from fem.exceptions import refuse_above
from fem.geometry import Stator, Transducer
from fem.layout import check_layout
from fem.parameters import InputError, positive, refuses
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.field_evaluation import surface_of
from fem.results.power_balance import power_balance
from fem.results.stator_solution import Solution, driven_solution
from fem.threads import one_blas_thread
from fem.waveguide.port_fields import stator_cascade

LOGGER = logging.getLogger(__name__)


@one_blas_thread
def driven_wave(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    drive: str | Drive,
    tolerance: float,
    places: tuple[float, ...] = (),
) -> SurfaceWave:
    """Surface motion, admittance and power balance of the driven stator, per volt of the drive.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
    frequency : float
        Hz.
    drive : str or Drive
        Name of the driven transducer, or sources at several.
    tolerance : float
        Relative, of the surface motion at ``places``; infinite: the coarsest discretisation alone, whose error is not
        estimated (1.7 to 4.5 % on Feenstra and Breedveld's stator of 3.6 to 6.7 mm).
    places : tuple of float
        m from the left end; mid-stator if empty.

    Raises
    ------
    ValueError
        For a geometry or a solid that cannot be driven.
    ConvergenceError
        If the finest discretisation does not reach the tolerance; its ``reached`` is the best answer.
    """
    check_driven(stator, transducers, frequency, tolerance)
    return refined_wave(
        stator, transducers, frequency=frequency, drive=drive, tolerance=tolerance, places=places, solved={}
    )


def refined_wave(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    drive: str | Drive,
    tolerance: float,
    places: tuple[float, ...],
    solved: dict[Resolution, Solution],
) -> SurfaceWave:
    """Return what `driven_wave` does; ``solved`` holds the solutions by discretisation and receives the new ones."""
    at = np.array(places or (stator.length / 2,))

    def at_level(resolution: Resolution) -> tuple[Solution, np.ndarray]:
        LOGGER.debug(resolution.name)
        if resolution not in solved:
            solved[resolution] = solve_driven(
                stator, transducers, frequency=frequency, drive=drive, resolution=resolution
            )
        return solved[resolution], surface_of(solved[resolution]).motion(at)

    refined = refine_stator(stator, at_level, differences=solution_differences, tolerance=tolerance)
    solution, _ = refined.answer
    wave = surface_wave(
        solution,
        relative_error=refined.errors[0],
        admittance_error=refined.errors[1],
        balance=cache(lambda: power_balance(solution)),
    )
    shapes = "draw the meshes evener at corners" if stator.pieces else "make the fingers less extreme"
    finer = f"finer, {refined.obstacle}" if refined.obstacle else shapes
    what, advice = "the stator's surface motion is", f"ask for less, or {finer}"
    refuse_above(wave.relative_error, tolerance, what, advice=advice, reached=wave)
    return wave


def solve_driven(
    stator: Stator, transducers: tuple[Transducer, ...], *, frequency: float, drive: str | Drive, resolution: Resolution
) -> Solution:
    """Solve a driven stator on one discretisation, at a frequency in Hz."""
    cascade = stator_cascade(stator, transducers, frequency=frequency, resolution=resolution)
    return driven_solution(cascade.solved(), drive)


@refuses(InputError)
def check_driven(
    stator: Stator, transducers: tuple[Transducer, ...], frequency: float, tolerance: float
) -> Iterator[Any]:
    """Raise an InputError for a layout, solid, frequency (Hz) or tolerance with which no stator can be driven."""
    check_layout(stator, transducers)
    if "phi" not in stator.fields:
        piezoelectric = any(each.is_piezoelectric for each in stator.solids)
        why = "uncouples phi in this orientation" if piezoelectric else "is not piezoelectric"
        yield "transducer", f"needs a piezoelectric stator, and {stator.solid.name} {why}"
    positive("tolerance", tolerance, infinite=True)
    positive("frequency", frequency, "Hz")


def solution_differences(fine: tuple[Solution, np.ndarray], coarse: tuple[Solution, np.ndarray]) -> tuple[float, float]:
    """Relative differences of the motion at the requested positions and of the admittances at the sources."""
    ratios = fine[0].circuit.source_admittances / coarse[0].circuit.source_admittances
    return motion_difference(fine[1], coarse[1]), float(np.max(abs(ratios - 1)))


def motion_difference(fine: np.ndarray, coarse: np.ndarray) -> float:
    """Largest relative difference of orbits (u_x, u_z), shape (2, positions).

    The phase counts: where a beam's waves interfere, its amplitude changes by what their phases do in the section.
    """
    return float(np.max(abs(fine - coarse).max(axis=0) / abs(fine).max(axis=0)))
