"""The driven stator of ``twente`` with other ends, and its answers by discretisations that nothing else shares.

Its admittance and u_z per volt at the slider (160 x 5 mm, left transducer driven, right one open).  For absorbing ends:
charges on the fingers of an infinite plate by exact partial waves (`strip_charges`, known to 1e-12).  For free ends:
NGSolve at its finest, stored here, known to 2e-7.
"""

import math
from dataclasses import replace

from tests.fem.stators import constants
from tests.validation.attempt import Attempt
from tests.validation.contenders import Problem

__all__ = ["problem", "reference", "seconds_at"]

SCENE = "twente"
ENDS = ("free", "absorbing")
LIMITS = {"free": ((1e-3, 50.0), (1e-5, 30.0)), "absorbing": ((1e-3, 20.0), (1e-5, 15.0))}  # error, times sooner
# NGSolve, order 11, 6 edge layers, elements of 0.6 wavelengths: `tests/benchmarks/stator_peers.py --reference`.
# Against order 10, 5 layers, 0.7: 5e-7 in Y, 2e-7 in u; each layer divides the difference by more than 3.
FREE_ENDS = (
    1.082183318e-02 + 2.495454775e-02j,
    (1.610602348e-10 + 3.827739847e-10j, 1.894090783e-10 - 8.220044438e-11j),
)
DIRECT = ("high order, no edge layers", "high order, edge layers")


def problem(ends: str) -> Problem:
    """Return the stator of the scene with other ends, the driven transducer first."""
    from studies.model import fem_objects, resolve
    from studies.model.model import Model
    from studies.scene import Scene

    scene = resolve.resolved(Scene.load(SCENE))
    transducers = sorted(Model(scene).transducers, key=lambda each: each.center)
    return Problem(
        stator=replace(fem_objects.stator(scene.stator), ends=ends),
        transducers=tuple(transducers),
        frequency=scene.frequency,
        wavelength=transducers[0].period,
        place=scene.slider.position,
    )


def reference(posed: Problem) -> tuple[complex, tuple[complex, complex]]:
    """Admittance (S) and u_x, u_z (m per V) from a discretisation that no contender shares."""
    if posed.stator.ends == "free":
        return FREE_ENDS
    import numpy as np

    from tests.oracles.fem_plate_response import PlateResponse
    from tests.validation.strip_charges import StripCharges

    solid = posed.stator.solid
    plate = PlateResponse(**constants(solid), thickness=posed.stator.thickness, frequency=posed.frequency)
    strips = StripCharges(
        plate=plate,
        centers=np.concatenate([each.fingers.mean(axis=1) for each in posed.transducers]),
        half_width=posed.transducers[0].finger_width / 2,
        terms=8,
    )
    owner = [2 * index + (sign == "-") for index, each in enumerate(posed.transducers) for sign in each.signs]
    charges, coefficients = strips.charges(np.array(owner), {0: 0.5, 1: -0.5})
    motion = strips.motion(coefficients, posed.place)
    admittance = 2j * np.pi * posed.frequency * posed.transducers[0].aperture * charges[0]
    return complex(admittance), (complex(motion[0]), complex(motion[1]))


def seconds_at(attempts: list[Attempt], truth, error: float) -> float:
    """Time a curve needs for an error of both outputs, between its points by powers; NaN if it never gets there."""
    points = sorted((max(each.errors(truth)), each.seconds) for each in attempts)[::-1]
    within = [index for index, point in enumerate(points) if point[0] <= error]
    if not within:
        return math.nan
    if within[0] == 0:
        return points[0][1]
    (before, slow), (after, fast) = points[within[0] - 1], points[within[0]]
    share = math.log(error / before) / math.log(after / before)
    return math.exp(math.log(slow) + share * math.log(fast / slow))
