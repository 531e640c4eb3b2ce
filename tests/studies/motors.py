"""A small driven stator that the tests of the comparison with peers share."""

from dataclasses import replace
from functools import cache

from fem.geometry import Stator, Transducer
from fem.materials import material
from tests.validation.contenders import Problem
from tests.validation.stator_reference import reference


def small_problem(ends: str = "absorbing", thickness: float = 0.7e-3) -> Problem:
    """Two transducers of two finger pairs on a thin plate of hard PZT.

    At 0.7 mm one of its modes is a backward wave, which exact ends absorb and matched layers amplify; at 0.35 mm none.
    """
    left = Transducer(name="left", center=3e-3, finger_pairs=2, period=0.98e-3, metallisation=0.5, aperture=0.02)
    return Problem(
        stator=Stator(solid=material("PZT-8"), length=12e-3, thickness=thickness, ends=ends),
        transducers=(left, replace(left, name="right", center=8e-3)),
        frequency=2.2e6,
        wavelength=left.period,
        place=5.6e-3,
    )


@cache
def truth(thickness: float = 0.7e-3):
    """Reference of the small stator, absorbing ends."""
    return reference(small_problem(thickness=thickness))
