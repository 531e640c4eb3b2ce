"""Corners where a clamped face meets a free one: the stress is singular, and the stated error must know it.

Truth: the next level of discretisation; once the whole stator assembled by scikit-fem on a mesh of
its own along x.
"""

import numpy as np
import pytest

from fem.discretize.element_sizes import CORNER_RATIO
from fem.discretize.mesh_refinement import LEVELS
from fem.materials.christoffel import slowest_wavelength
from fem.results.field_evaluation import surface_of
from fem.solve.driven_stator import driven_wave, motion_difference, solve_driven
from tests.fem.direct import direct_solution
from tests.fem.stators import FREQUENCY, comb, cut, plate, section

STATORS = {
    "X-poled PZT-8, free ends": (plate(cut("PZT-8", "X"), length=6.0, ends="free", bottom="clamped"), 1e-3),
    "Z-poled PZT-4, free ends": (plate(cut("PZT-4", "Z"), length=6.0, ends="free", bottom="clamped"), 5e-3),
    "Z-poled PZT-8, clamped ends": (plate(cut("PZT-8", "Z"), length=6.0, ends="clamped"), 5e-3),
}


def answer(name):
    stator, tolerance = STATORS[name]
    transducer = comb(stator, "a", 2.0, finger_pairs=2)
    place = 0.75 * stator.length
    wave = driven_wave(stator, (transducer,), frequency=FREQUENCY, drive="a", tolerance=tolerance, places=(place,))
    return stator, transducer, place, wave


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * name.startswith("X")) for name in STATORS]
)
def test_stated_error_bounds_the_true_one(name):
    stator, transducer, place, wave = answer(name)
    level = LEVELS.index(wave.solution.fields.resolution)
    finer = solve_driven(stator, (transducer,), frequency=FREQUENCY, drive="a", resolution=LEVELS[level + 1])
    error = motion_difference(wave.motion([place]), surface_of(finer).motion([place]))
    assert wave.relative_error <= STATORS[name][1]
    assert error < 1.5 * wave.relative_error
    assert abs(wave.admittance / finer.circuit.admittance - 1) < 1.5 * wave.admittance_error


@pytest.mark.slow
def test_stated_error_bounds_the_distance_from_the_whole_stator_assembled_at_once():
    stator, transducer, place, wave = answer("X-poled PZT-8, free ends")
    whole = direct_solution(
        stator,
        (transducer,),
        frequency=FREQUENCY,
        resolution=LEVELS[3],
        wavelength=slowest_wavelength(stator.solid, FREQUENCY),
        segment_size=0.5,
        segment_layers=5,
    )
    motion = whole.surface(np.array([place]))[..., 0]
    assert motion_difference(wave.motion([place]), motion) < 1.5 * wave.relative_error
    admittance = whole.admittances[0, 0]
    assert abs(wave.admittance / admittance - 1) < 1.5 * wave.admittance_error


def test_only_a_singular_corner_is_graded():
    """Elements at the bottom become smaller by CORNER_RATIO where two faces of different kind meet, nowhere else."""
    solid = cut("PZT-8", "Z")

    def heights(bottom, ends, thickness=1.7):
        return section(plate(solid, thickness=thickness, bottom=bottom, ends=ends), layers=3).heights.real

    for bottom, ends in (("clamped", "free"), ("free", "clamped"), ("grounded", "clamped")):
        lowest = np.cumsum(heights(bottom, ends))[:3]
        assert lowest[1:] * CORNER_RATIO == pytest.approx(lowest[:-1], rel=1e-12)
    plain = heights("free", "absorbing")
    for bottom, ends in (("free", "free"), ("clamped", "clamped"), ("clamped", "absorbing"), ("grounded", "free")):
        assert np.array_equal(heights(bottom, ends), plain)
    half_space = heights("free", "absorbing", np.inf)
    assert np.array_equal(heights("free", "clamped", np.inf), half_space)
