"""Flat punches: closed forms by hand, rows of springs, and every method against the others."""

import math

import numpy as np
import pytest

from contact import burst, mean_motion, release_amplitude, riding_height, steady, threshold_amplitude
from studies.evidence.stability.cross_check import cross_check
from tests.contact.motors import FREQUENCY, HEAVY, orbit, slider, steady_map
from tests.oracles.contact_springs import velocity_from_rest
from tests.seed_motor import PRELOAD

PUNCH = {"shape": "punch", "radius": 2e-6}
Z0 = PRELOAD / (2.0 * 2e-6 * 64e9)  # preload/2 a E, by hand: 3.41 nm


def trio(A):
    """Return three orbits of different size and phase."""
    return tuple(orbit(A * f).scaled(np.exp(1j * t)) for f, t in ((1.0, 0.0), (0.9, 2.0), (1.1, -1.3)))


def test_a_punch_that_keeps_contact_rides_where_it_rests_and_parts_at_its_rest_approach():
    # The mean of a linear force is the force at the mean
    assert riding_height(slider(**PUNCH), orbit(0.9 * Z0)) == pytest.approx(Z0, rel=1e-13)
    assert release_amplitude(slider(mass=HEAVY, **PUNCH), orbit(1e-9)) == pytest.approx(Z0, rel=1e-8)
    # hopping: A (sin b - b cos b)/pi = Z0 with h = -A cos b; b = 2
    A = Z0 * math.pi / (math.sin(2.0) - 2.0 * math.cos(2.0))
    assert riding_height(slider(**PUNCH), orbit(A)) == pytest.approx(-A * math.cos(2.0), rel=1e-12)


@pytest.mark.parametrize("ratio", [0.1, 0.7, 2.0])
def test_the_threshold_in_quadrature_is_the_closed_form(ratio):
    # A sqrt(r^2 + c^2) = c z0, for h does not move
    s = slider(mass=HEAVY, **PUNCH)
    A = s.limit_slope * Z0 / math.hypot(ratio, s.limit_slope)
    assert threshold_amplitude(s, orbit(1e-9, ratio)) == pytest.approx(A, rel=1e-7)


def test_a_loaded_threshold_is_the_closed_form():
    # The spring is linear: the load takes x0 = load/8 a G of the room c z0
    share = 0.4
    s = slider(mass=HEAVY, load=share * 0.08 * PRELOAD, **PUNCH)
    A = (1.0 - share) * s.limit_slope * Z0 / math.hypot(0.7, s.limit_slope)
    assert threshold_amplitude(s, orbit(1e-9)) == pytest.approx(A, rel=1e-7)


@pytest.mark.parametrize(("limit", "inside"), [(threshold_amplitude, "stick"), (release_amplitude, "slip")])
def test_the_simulated_limits_are_the_closed_forms(limit, inside):
    # The slider is heavy but not infinitely so
    s = slider(**PUNCH)
    A = limit(s, orbit(1e-9))
    assert steady(s, orbit(0.999 * A), tolerance=1e-3).regime == inside
    assert steady(s, orbit(1.001 * A), tolerance=1e-3).regime != inside


@pytest.mark.parametrize("changed", [{}, {"contact_damping": 2e-4}])
def test_three_punches_move_as_rows_of_springs_do(changed):
    s, cycles = slider(**PUNCH, **changed), 40
    found = burst(s, trio(15e-9), duration=cycles / FREQUENCY, after=0.0, tolerance=1e-6, samples=2)
    springs = velocity_from_rest(
        [-1j * o.normal for o in trio(15e-9)], [-1j * o.tangential for o in trio(15e-9)], FREQUENCY, cycles=cycles,
        per_cycle=6400, springs=1,
        slider={
            "radius": s.radius, "E": s.effective_modulus, "G": s.tangential_modulus, "mu": s.friction_coefficient,
            "mass": s.mass, "preload": s.preload, "load": 0.0, "normal_damping": s.normal_damping,
            "tangential_damping": s.tangential_damping, "chi": s.contact_damping, "punch": True,
        },
    )  # fmt: skip
    assert found.status == "ok"
    assert found.velocity_at_burst_end == pytest.approx(springs, rel=1e-5)


@pytest.mark.parametrize("A", [3e-9, *(pytest.param(each, marks=pytest.mark.slow) for each in (1e-9, 10e-9))])
def test_a_long_run_settles_at_the_steady_velocity(A):
    found = steady(slider(**PUNCH), trio(A), tolerance=1e-6)
    assert found.status == "ok"
    assert found.ledger.relative_residual < 1e-8
    assert abs(found.ledger.leak) < 1e-9 * abs(found.ledger.wave)  # the punch's springs have a potential
    other = cross_check(found)
    assert other.method == "stepped"
    assert found.velocity == pytest.approx(other.velocity, abs=3.0 * other.error)
    assert other.error < 3e-4 * abs(found.velocity)


def test_every_door_has_the_same_steady_state():
    s = slider(**PUNCH)
    mean = mean_motion(s, trio(5e-9))
    assert steady(s, trio(5e-9), tolerance=1e-6).velocity == pytest.approx(mean.velocity, rel=1e-8)
    mapped = steady_map(s, trio(5e-9), factors=np.ones(1), preloads=np.array([s.preload]))
    assert mapped.velocity[0, 0] == mean.velocity


@pytest.mark.parametrize(("A", "per_cycle"), [(3e-9, 48), (10e-9, 48), (20e-9, 48)])
def test_fixed_steps_keep_five_digits(A, per_cycle):
    from contact.answers.rest_motion import rest, rest_problem
    from contact.stepping.time_stepping import steps

    problem = rest_problem(slider(**PUNCH), trio(A))
    motion = rest(slider(**PUNCH), trio(A), problem, nodes=14, truncation=1e-11)
    state = motion.state.copy()
    motion.turn(400)
    steps(problem, state, 400, per_cycle)
    assert state[2] == pytest.approx(motion.state[2], rel=1e-4)


def test_averaged_bursts_keep_their_error():
    s, found = slider(**PUNCH), {}
    for method in ("exact", "averaged"):
        found[method] = burst(s, trio(8e-9), duration=1e-3, after=0.0, tolerance=1e-6, samples=2, method=method)
    exact, averaged = found["exact"], found["averaged"]
    reference = max(abs(exact.velocity_at_burst_end), trio(8e-9)[0].omega * 1.1 * 0.7 * 8e-9 / 10.0)
    apart = abs(averaged.velocity_at_burst_end - exact.velocity_at_burst_end) / reference
    assert apart < 2.0 * averaged.relative_error < 1e-4


def test_the_reciprocal_force_of_a_punch_is_nothing():
    one, two = (steady(slider(reciprocal=r, **PUNCH), trio(5e-9), tolerance=1e-6) for r in (False, True))
    assert two.velocity == pytest.approx(one.velocity, rel=1e-8)
