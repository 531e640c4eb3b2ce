"""Stated errors of the three ways: at most half the true one in one answer of twenty, and no worse than useful."""

import math
from functools import cache

import numpy as np
import pytest

from contact import ConvergenceError, burst
from contact.answers.burst_question import largest_divisor
from contact.answers.rest_motion import rest_problem
from contact.answers.stepped_burst import STEPS, stepped_refusals
from contact.error_estimate import reference_speed
from tests.contact.calibration import ContactChecked, checked, kept, pessimism
from tests.contact.motors import orbit, slider
from tests.motors import TOLERANCES, around_the_seed

WAYS = ("burst, averaged", "burst, exact", "burst, stepped", "steady, averaged", "steady, exact")


def test_stated_errors_hold_on_random_motors():
    found = [each for number in range(2) for each in checked(number)]
    assert {each.way for each in found} == set(WAYS)
    assert min(kept(found).values()) >= 0.9  # of two draws; 0.95 of two hundred
    stated = pessimism(found)
    # of errors of 1e-12 and, of a motion that repeats, 1e-14: what is stated is the coarser run's
    for way, most in (("burst, exact", 1e3), ("steady, exact", 1e4)):
        assert stated.pop(way) < most, way
    assert max(stated.values()) < 60.0


@cache
def fifty(block):
    return [each for number in range(50 * block, 50 * block + 50) for each in checked(number)]


@pytest.mark.slow
@pytest.mark.parametrize("block", range(4))
def test_stated_errors_hold_on_fifty(block):
    """A quarter of the draws at a time, about a minute each."""
    assert min(kept(fifty(block)).values()) >= 0.93


@pytest.mark.slow
def test_stated_errors_hold_on_two_hundred():
    found = [each for block in range(4) for each in fifty(block)]
    assert min(kept(found).values()) >= 0.95
    stated = pessimism(found)
    for way, most in (("burst, exact", 1e3), ("steady, exact", 1e4)):
        assert stated.pop(way) < most, way
    assert max(stated.values()) < 11.0


def test_draws_are_those_of_their_number():
    assert around_the_seed(3) == around_the_seed(3)
    assert around_the_seed(3) != around_the_seed(4)
    assert len({len(around_the_seed(n)[1]) for n in range(12)}) == 2


def test_shares_and_medians_are_taken_way_by_way():
    made = [
        ContactChecked(number=0, way="a", tolerance=1e-3, true=true, estimate=1e-6)
        for true in (1e-7, 1e-6, 1.9e-6, 2.1e-6)
    ]
    made.append(ContactChecked(number=0, way="b", tolerance=1e-3, true=1e-6, estimate=1e-7))
    assert kept(made) == {"a": 0.75, "b": 0.0}
    assert pessimism(made)["a"] == pytest.approx(0.5 * (1.0 + 1.0 / 1.9), rel=1e-12)


@pytest.mark.parametrize("mass", [5e-11, 1e-10])
def test_stepped_wants_two_step_sizes_that_serve(mass):
    # with the last of the ladder alone there is nothing to compare, and no error to state
    light = slider(mass=mass, normal_damping=1e-6, tangential_damping=1e-6)
    problem = rest_problem(light, (orbit(5e-9),))
    usable = [n for n, _ in STEPS if not stepped_refusals(light, problem, n)]
    asked = {"duration": 5e-5, "after": 0.0, "samples": 2}
    if len(usable) < 2:
        with pytest.raises(ConvergenceError, match="too fast"):
            burst(light, orbit(5e-9), tolerance=1e-2, method="stepped", **asked)
        return
    found = burst(light, orbit(5e-9), tolerance=1e-2, method="stepped", **asked)
    exact = burst(light, orbit(5e-9), tolerance=1e-8, method="exact", **asked)
    reference = reference_speed(exact.velocity_at_burst_end, exact.orbits)
    difference = abs(found.velocity_at_burst_end - exact.velocity_at_burst_end)
    assert difference < 2.0 * found.relative_error * reference < math.inf


@pytest.mark.parametrize(("number", "most", "divisor"), [(12, 5, 4), (12, 12, 12), (13, 5, 1), (1, 7, 1)])
def test_largest_divisor_below_a_bound(number, most, divisor):
    assert largest_divisor(number, most) == divisor


def test_rows_are_the_same_whatever_is_compared_on_the_way():
    runs = [
        burst(slider(), orbit(5e-9), duration=600 / 2.2e6, after=0.0, tolerance=1e-3, samples=n, method="stepped")
        for n in (3, 7, 601)
    ]
    long = dict(zip(np.round(runs[2].time * 2.2e6), runs[2].velocity, strict=True))
    for run in runs[:2]:
        for t, v in zip(np.round(run.time * 2.2e6), run.velocity, strict=True):
            assert long[t] == v
    assert len(TOLERANCES) == 5
