"""Propagated errors.  Oracle: made-up velocity laws whose derivatives are known."""

import math

import pytest

import contact
from contact import MIN_WAVE_STEP, Orbit
from studies.solve.velocity_error import velocity_sensitivities

ORBIT = Orbit(frequency=2.2e6, normal=3e-9 + 0j, tangential=-2.1e-9j)
SPEED = 2 * math.pi * 2.2e6 * 2.1e-9 / 10


def velocity_error(velocity, orbits, error, solve):
    """Return the error of a velocity as a run has it: the three changes in quadrature."""
    return error * velocity_sensitivities(velocity, orbits, error, solve)[1]


def test_reference_speed_is_the_larger_of_slider_and_tenth_of_surface():
    assert contact.reference_speed(-1.0, (ORBIT,)) == 1.0
    assert contact.reference_speed(0.0, (ORBIT, ORBIT.scaled(0.5))) == pytest.approx(SPEED, rel=1e-14)


@pytest.mark.parametrize("power", [1, 5, 20])
@pytest.mark.parametrize("error", [1e-7, 1e-4, 1e-3])
def test_a_power_law_multiplies_the_error_by_its_exponent(power, error):
    def solve(orbits):
        return abs(orbits[0].normal / ORBIT.normal) ** power

    step = max(error, MIN_WAVE_STEP)
    found = velocity_error(1.0, (ORBIT,), error, solve)
    assert found == pytest.approx(power * error, rel=power * step)


def test_ratio_and_phase_count_too():
    def ratio(orbits):
        return 1 + 3 * (abs(orbits[0].tangential / orbits[0].normal) / 0.7 - 1)

    def turned(orbits):
        angle = (orbits[0].tangential / orbits[0].normal / -0.7j).imag
        return 1 + 4 * angle

    # an error relative to |u_z| is 1 / 0.7 times as large relative to |u_x|
    assert velocity_error(1.0, (ORBIT,), 1e-5, ratio) == pytest.approx(3e-5 / 0.7, rel=1e-3)
    assert velocity_error(1.0, (ORBIT,), 1e-5, turned) == pytest.approx(4e-5 / 0.7, rel=1e-3)


def test_a_weak_normal_motion_errs_as_the_strong_tangential_one():
    for times in (2.0, 50.0):
        flat = Orbit(frequency=2.2e6, normal=1e-9 + 0j, tangential=-1e-9j * times)

        def ratio(orbits, times=times):
            return 1 + 3 * (abs(orbits[0].tangential / orbits[0].normal) / times - 1)

        assert velocity_error(1.0, (flat,), 1e-5, ratio) == pytest.approx(3e-5 * times, rel=1e-2)


def test_a_threshold_within_reach_is_felt_from_the_sticking_side():
    def solve(orbits):
        return 0.0 if abs(orbits[0].normal) <= 3e-9 else 10 * (abs(orbits[0].normal) / 3e-9 - 1)

    assert velocity_error(0.0, (ORBIT,), 1e-3, solve) == pytest.approx(10e-3 / SPEED, rel=1e-9)


def test_no_motion_and_no_error_give_no_error():
    still = ORBIT.scaled(0)
    assert velocity_error(0.0, (still,), 1e-3, lambda orbits: 1.0) == 0.0
    assert velocity_error(1.0, (ORBIT,), 0.0, lambda orbits: 2.0) == 0.0
