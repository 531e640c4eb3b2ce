"""One slider on contacts of unequal radius, stiffness, slip limit and weight, by every method.

A ball of radius n^2 R is as stiff as n balls of radius R that move together (K ~ sqrt(R), Johnson, eq. 4.23), and has
the same slip limit: the independent programs, which know equal contacts only, follow the n balls.
"""

from dataclasses import replace

import numpy as np
import pytest

from contact import InputError, burst, contact_history, mean_forces, mean_motion, steady
from contact.averaged.equilibrium import mean_tangential_forces
from contact.averaged.event_equilibrium import mean_tangential_force
from contact.averaged.riding import riding_approach
from contact.problem import scaled
from tests.contact.motors import FREQUENCY, orbit, slider
from tests.contact.test_each_contact import brute
from tests.frozen import frozen
from tests.oracles.contact_motion import Motor
from tests.oracles.contact_springs import velocity_from_rest

SMALL = 0.4e-3
RADII, HEIGHTS = (SMALL, 4.0 * SMALL), (1.1e-9, 0.0)
# u_z in phase, because a burst begins where that of the first contact crosses zero
TWO = (orbit(12e-9), replace(orbit(9e-9), tangential=-6e-9j * np.exp(0.7j)))
BODY = slider(radius=RADII, heights=HEIGHTS, load=5e-6)
# the same motor on three small balls, of which the last two replace the large one
SAME, THREE = replace(BODY, radius=SMALL, heights=(HEIGHTS[0], HEIGHTS[1], HEIGHTS[1])), (TWO[0], TWO[1], TWO[1])
CYCLES = 300
METHODS = {"exact": 1e-8, "stepped": 1e-3, "averaged": 1e-3}  # tolerances


def after(body, orbits, method, tolerance):
    """Return (velocity at the end of the burst, its stated error), m/s."""
    found = burst(
        body, orbits, duration=CYCLES / FREQUENCY, after=0.0, tolerance=tolerance, samples=10, method=method
    )  # fmt: skip
    assert found.method == method
    return found.velocity_at_burst_end, found.answer.error


# Oracle: explicit Runge-Kutta of order 8 between located events, to 1e-8 of the velocity
@frozen([()])
def independent():
    """Velocity of the three small balls after the burst, m/s."""
    mu = BODY.friction_coefficient
    motor = Motor(
        mass=BODY.mass, preload=BODY.preload, frequency=FREQUENCY, normal=tuple(each.normal for each in THREE),
        tangential=tuple(each.tangential for each in THREE), load=BODY.load, radius=SMALL, E=BODY.effective_modulus,
        G=BODY.tangential_modulus, normal_damping=BODY.normal_damping, tangential_damping=BODY.tangential_damping,
        heights=SAME.heights, numbers=(mu, 1.0, 1.0, mu, 1.0, np.inf),
    )  # fmt: skip
    return motor.run(CYCLES)[1][-1, 0]


@pytest.mark.parametrize("method", METHODS)
def test_two_unequal_balls_move_as_an_independent_program_says(method):
    true, (velocity, error) = independent(), after(BODY, TWO, method, METHODS[method])
    assert velocity == pytest.approx(true, rel=1e-6, abs=1.05 * error)
    assert error < 0.02 * true
    equal, _ = after(replace(BODY, radius=SMALL), TWO, "exact", 1e-6)
    assert abs(equal - true) > 0.05 * true


@pytest.mark.parametrize("turned", [(1, 0)])
@pytest.mark.parametrize("method", METHODS)
def test_mirror_image_and_order_of_unequal_balls_are_names(method, turned):
    here, _ = after(BODY, TWO, method, METHODS[method])
    there, _ = after(BODY, tuple(each.mirrored() for each in TWO), method, METHODS[method])
    assert there == -here
    swapped = replace(BODY, radius=RADII[::-1], heights=HEIGHTS[::-1])
    other, _ = after(swapped, TWO[::-1], method, METHODS[method])
    assert other == pytest.approx(here, rel=1e-6)


LAWS = {
    "elastic": {}, "reciprocal": {"reciprocal": True}, "contact damper": {"contact_damping": 2.0},
    "hysteretic": {"law": "hysteretic"},
}  # fmt: skip


@pytest.mark.parametrize("law", LAWS)
def test_a_ball_of_four_times_the_radius_and_a_weight_of_two_are_two_balls(law):
    wanted = steady(replace(SAME, **LAWS[law]), THREE, tolerance=1e-6)
    weighted = replace(BODY, radius=SMALL, weights=(1.0, 2.0))
    for body in (replace(BODY, **LAWS[law]), replace(weighted, **LAWS[law])):
        found = steady(body, TWO, tolerance=1e-6)
        assert found.velocity == pytest.approx(wanted.velocity, rel=1e-9)
        size = np.max(np.abs(wanted.ledger))
        assert np.array(found.ledger) == pytest.approx(np.array(wanted.ledger), rel=1e-6, abs=1e-6 * size)
        assert found.height == pytest.approx(wanted.height, rel=1e-9)


def test_hysteretic_balls_of_unequal_radius_are_rows_of_springs():
    # Oracle: every contact as a row of springs in small steps; 3 in 1000 is what 400 springs leave
    body = replace(BODY, law="hysteretic", load=0.0)
    found = burst(body, TWO, duration=40 / FREQUENCY, after=0.0, tolerance=1e-6, samples=4)
    springs = {
        "radius": SMALL, "E": BODY.effective_modulus, "G": BODY.tangential_modulus, "mu": BODY.friction_coefficient,
        "mass": BODY.mass, "preload": BODY.preload, "load": 0.0, "normal_damping": BODY.normal_damping,
        "tangential_damping": BODY.tangential_damping, "chi": 0.0,
    }  # fmt: skip
    start = np.exp(1j * TWO[0].upward_zero)
    amplitudes = ([each.normal * start for each in THREE], [each.tangential * start for each in THREE])
    right = velocity_from_rest(
        *amplitudes, FREQUENCY, cycles=40, per_cycle=800, springs=400, slider=springs, heights=SAME.heights
    )
    assert found.velocity_at_burst_end == pytest.approx(right, rel=3e-3)


@pytest.mark.parametrize("speed", [0.1, -0.05])
def test_contacts_with_slip_limits_of_their_own_carry_what_small_steps_say(speed):
    # Oracle: the stop operator in small steps, each contact by itself
    own = {"normal_stiffness": [1.8e6, 1.1e6], "tangential_stiffness": [1.5e6, 0.4e6], "radius": None}
    own |= {"effective_modulus": None, "tangential_modulus": None, "shape": "punch", "weights": [1.0, 3.0]}
    body = slider(heights=(0.7e-9, 0.0), preload=0.02, **own)
    problem = scaled(body, TWO, direction=1.0, start=0.0)
    h, force = riding_approach(problem), body.mass * problem.omega**2 * problem.length
    expected = 0.0
    for i, (wave, height) in enumerate(zip(TWO, body.heights, strict=True)):
        alone = {name: own[name][i] for name in ("normal_stiffness", "tangential_stiffness")}
        one = slider(**own | alone | {"weights": 1.0})
        expected += own["weights"][i] * brute(one, wave, h * problem.length + height, speed)[2]
    friction = body.friction_coefficient * body.preload
    averaged = mean_tangential_forces(problem, [speed / problem.speed])[0]
    assert averaged * force == pytest.approx(expected, abs=3e-4 * friction)
    events, _ = mean_tangential_force(problem, h, speed / problem.speed, 0.0)
    assert events == pytest.approx(averaged, rel=1e-9)


def test_forces_of_weighted_contacts_are_those_of_one():
    weighted = replace(BODY, radius=SMALL, weights=(1.0, 2.0))
    row, each = (
        mean_forces(body, orbits, mean_motion(body, orbits)) for body, orbits in ((weighted, TWO), (SAME, THREE))
    )
    assert row.normal == pytest.approx(each.normal[:2], rel=1e-9)
    assert row.first_tangential == pytest.approx(each.first_tangential[:2], rel=1e-9)
    options = {"stage": "steady", "skip": 0, "cycles": 1, "points_per_cycle": 20}
    rows, all_three = (contact_history(body, orbits, **options) for body, orbits in ((weighted, TWO), (SAME, THREE)))
    assert rows.normal_force == pytest.approx(all_three.normal_force[:, :2], rel=1e-6, abs=1e-9)
    assert rows.tangential_force == pytest.approx(all_three.tangential_force[:, :2], rel=1e-6, abs=1e-9)


def test_friction_that_depends_on_the_radius_refuses_unequal_balls():
    from contact import FallingFriction

    with pytest.raises(InputError, match=r"slider\.radius must be equal for all contacts"):
        replace(BODY, friction=FallingFriction(high_pressure=0.05, pressure=1e8))
