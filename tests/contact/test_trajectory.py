"""Bursts: two independent integrators, the falling slope, the ring, both ways of following the burst."""

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, burst, steady
from tests.contact.motors import orbit, slider
from tests.oracles.contact_steps import velocity_from_rest

CYCLES = 2200


def after_cycles(A, method="auto", tolerance=1e-8, **changed):
    return burst(
        slider(**changed), orbit(A), duration=CYCLES / 2.2e6, after=0.0, tolerance=tolerance, samples=2, method=method
    )


@pytest.mark.parametrize("A", [*(pytest.param(each, marks=pytest.mark.slow) for each in (1e-9, 5e-9)), 20e-9])
def test_velocity_after_2200_cycles_by_two_integrators(A):
    found = after_cycles(A)
    assert (found.status, found.method, found.cycles) == ("ok", "exact", CYCLES)
    # Oracle: fixed-step Runge-Kutta, 1000 steps per cycle; its error is 1e-8 and below there
    assert found.velocity_at_burst_end == pytest.approx(velocity_from_rest(A, CYCLES, 1000), rel=1e-8)
    # stated: what an iteration may leave out at this tolerance; the oracle at 4000 steps is within 1e-11
    assert found.relative_error < 3e-9


@pytest.mark.parametrize("A", [3e-9, 10e-9])
def test_stepped_and_exact_agree_within_the_stepped_estimate(A):
    exact = after_cycles(A).velocity_at_burst_end
    for tolerance in (1e-3, 1e-5):
        stepped = after_cycles(A, "stepped", tolerance)
        reference = max(abs(exact), 2.0 * np.pi * 2.2e6 * 0.7 * A / 10.0)
        assert stepped.method == "stepped"
        assert abs(stepped.velocity_at_burst_end - exact) / reference < 2.0 * stepped.relative_error
        assert stepped.relative_error < tolerance


def test_stepped_converges_to_the_exact_at_order_above_two():
    # Events fall anywhere in the step, so the order shows only over large refinements
    from contact.problem import scaled
    from contact.stepping.time_stepping import steps

    s, o = slider(), orbit(5e-9)
    problem = scaled(s, (o,), direction=1.0, start=-0.5 * np.pi)
    exact = burst(s, o, duration=200 / 2.2e6, after=0.0, tolerance=1e-8, samples=2).velocity_at_burst_end

    def error(per_cycle):
        state = np.array([-s.rest_approach(1) / problem.length, 0.0, 0.0, 0.0])
        steps(problem, state, 200, per_cycle)
        return state[2] * problem.speed / exact - 1.0

    # root mean square over neighbouring step numbers, which place the events differently in the step
    errors = np.array([np.sqrt(np.mean([error(n * k) ** 2 for k in range(20, 36)])) for n in (1, 4, 16)])
    orders = np.log(errors[:-1] / errors[1:]) / np.log(4.0)
    assert np.all(orders > 2.0), f"orders {orders}, errors {errors}"
    assert errors[-1] < 1e-6


def test_a_long_burst_reaches_the_steady_velocity():
    s = slider(tangential_damping=5e-3)  # forgets rest in 18 ms
    long = burst(s, orbit(5e-9), duration=0.16, after=0.0, tolerance=1e-3, samples=50)
    assert long.method == "averaged"
    assert long.velocity[-1] == pytest.approx(steady(s, orbit(5e-9), tolerance=1e-6).velocity, rel=5e-4)


def test_falling_slope_is_mu_preload_over_mass():
    # Closed form with R_t = 0, once the bounce has died: the wave of 20 nm leaves enough speed for that
    s = slider(tangential_damping=0.0, normal_damping=2.0)
    found = burst(s, orbit(20e-9), duration=20e-3, after=14e-3, tolerance=1e-2, samples=680)
    late = (found.time > found.duration + 6e-3) & (found.velocity > 1e-4)
    slope = np.diff(found.velocity[late]) / np.diff(found.time[late])
    assert late.sum() > 20
    # each difference carries rounding of 1e-16 * v/(0.05 ms); the mean of many stays below 1e-9
    whole = (found.velocity[late][-1] - found.velocity[late][0]) / (found.time[late][-1] - found.time[late][0])
    assert -whole == pytest.approx(s.friction_coefficient * s.preload / s.mass, rel=1e-9)
    assert -slope == pytest.approx(s.friction_coefficient * s.preload / s.mass, rel=1e-7)


def test_after_the_slope_the_slider_rings_and_stays():
    s = slider(tangential_damping=0.05)
    found = burst(s, orbit(3e-9), duration=1e-3, after=30e-3, tolerance=1e-6, samples=3000)
    ring = found.velocity[found.time > found.duration + 2e-3]
    crossings = np.flatnonzero(np.diff(np.sign(ring)) != 0)
    period = 2.0 * np.mean(np.diff(crossings[-20:])) * (found.time[-1] - found.time[-2])
    assert 1.0 / period == pytest.approx(s.tangential_resonance(1), rel=1e-2)  # counted in samples
    assert found.statistics["after_reversal"] > 100
    assert abs(found.position[-1]) == pytest.approx(s.rest_approach(1), rel=1e-12)


def test_mirrored_burst_is_the_negated_one():
    right, left = (
        burst(slider(load=1e-6), o, duration=2e-5, after=1e-4, tolerance=1e-6, samples=20)
        for o in (orbit(5e-9), orbit(5e-9).mirrored())
    )
    assert np.array_equal(left.velocity, -right.velocity)
    assert np.array_equal(left.position, right.position)


@pytest.mark.parametrize("method", ["exact", "stepped"])
def test_what_is_asked_for_does_not_change_the_motion(method):
    runs = [
        burst(slider(), orbit(10e-9), duration=2e-4, after=1e-4, tolerance=1e-6, samples=n, method=method)
        for n in (2, 37, 400)
    ]
    assert len({run.velocity_at_burst_end for run in runs}) == 1
    assert len({run.velocity[-1] for run in runs}) == 1


def test_times_and_shapes():
    found = burst(slider(), orbit(5e-9), duration=1e-4, after=5e-5, tolerance=1e-6, samples=30)
    assert found.time[0] == 0.0
    assert found.velocity[0] == 0.0
    assert found.time[-1] == pytest.approx(1.5e-4, rel=1e-12)
    assert np.all(np.diff(found.time) > 0.0)
    assert found.time.shape == found.velocity.shape == found.position.shape
    assert found.velocity_at_burst_end in found.velocity


def test_no_wave_means_no_motion():
    found = burst(slider(), orbit(0.0), duration=1e-5, after=1e-4, tolerance=1e-6, samples=10)
    assert np.all(found.velocity == 0.0)
    assert found.relative_error == 0.0


def test_held_by_friction_stays_within_its_elastic_reach():
    # Far below the threshold the slider only rings in its spring: no slip at all
    found = burst(slider(), orbit(0.3e-9), duration=3e-4, after=0.0, tolerance=1e-6, samples=10, method="exact")
    assert found.statistics["stick_to_slip"] == 0


def test_the_stepped_way_says_where_it_does_not_apply():
    with pytest.raises(ConvergenceError, match="stick_band"):
        after_cycles(3e-9, "stepped", stick_band=1e-4)
    with pytest.raises(ConvergenceError, match="too fast"):
        after_cycles(3e-9, "stepped", mass=1e-12)
    assert after_cycles(3e-9, stick_band=1e-4, tolerance=1e-6).method == "exact"


def test_three_contacts_apart_on_the_wave_move_together():
    trio = tuple(orbit(5e-9).scaled(np.exp(-2j * np.pi * k / 7.0)) for k in range(3))
    exact, stepped = (
        burst(slider(), trio, duration=4e-4, after=0.0, tolerance=1e-5, samples=2, method=m)
        for m in ("exact", "stepped")
    )
    assert exact.velocity_at_burst_end == pytest.approx(stepped.velocity_at_burst_end, rel=5e-5)
    assert exact.status == "ok"


def test_general_phase_by_both_ways():
    shape = Orbit(frequency=2.2e6, normal=6e-9, tangential=5e-9 * np.exp(-0.9j))
    exact, stepped = (
        burst(slider(), shape, duration=4e-4, after=0.0, tolerance=1e-5, samples=2, method=m)
        for m in ("exact", "stepped")
    )
    assert exact.velocity_at_burst_end == pytest.approx(stepped.velocity_at_burst_end, rel=5e-5)
