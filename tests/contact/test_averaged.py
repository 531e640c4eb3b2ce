"""The averaged way: steady states and v(t) against the full motion, its order, where it refuses."""

from itertools import chain, repeat

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, burst, mean_motion, steady
from contact.answers.burst_methods import BURST_METHODS
from contact.answers.burst_question import Burst
from contact.answers.rest_motion import rest_problem
from contact.averaged import riding_stage
from contact.averaged.averaged_state import AveragedMotion, Span, Stage
from contact.averaged.equilibrium import work_arrays
from contact.averaged.riding import Rule
from contact.codes import Status
from contact.orbit import as_orbits
from tests.contact.motors import orbit, slider, steady_map
from tests.seed_motor import PRELOAD


def over(difference, v, A):
    return abs(difference) / max(abs(v), 2.0 * np.pi * 2.2e6 * 0.07 * A)


@pytest.mark.parametrize("A", [0.75e-9, 1e-9, 3e-9, 4.17e-9, 5e-9, 10e-9, 20e-9])
def test_second_order_steady_velocity_is_the_full_one(A):
    full, found = steady(slider(), orbit(A), tolerance=1e-8), mean_motion(slider(), orbit(A))
    # harmonics above the eighth of the slider's own fast motion are left out
    assert over(found.velocity - full.velocity, full.velocity, A) < 2e-9
    assert found.regime == full.regime
    # the height is that of averaging: the slider's own motion is (f_n/f)^2 = 2e-5 of the wave's
    assert found.height == pytest.approx(full.height, abs=2e-5 * A)


def test_averaging_errors_fall_with_the_square_of_the_frequency_ratio():
    # Order: f_n/f halves with four times the mass; first order 2, second order at least 4 or below its harmonics
    first, second = [], []
    for mass in (0.02e-3, 0.08e-3, 0.32e-3):
        s = slider(mass=mass, preload=PRELOAD, contact_damping=0.0)
        full = steady(s, orbit(3e-9, frequency=0.5e6), tolerance=1e-9).velocity
        found = mean_motion(s, orbit(3e-9, frequency=0.5e6))
        first.append(abs(found.first_order / full - 1.0))
        second.append(abs(found.velocity / full - 1.0))
    orders = np.log2(np.array(first[:-1]) / np.array(first[1:]))
    assert orders == pytest.approx(2.0, abs=0.2)
    assert max(second) < 1e-3 * min(first) or max(second) < 1e-8


@pytest.mark.parametrize("changed", [{"load": 5e-6}, {"contact_damping": 0.05}, {"tangential_damping": 1e-3}])
def test_load_and_dampers(changed):
    full, found = (steady(slider(**changed), orbit(5e-9), tolerance=1e-8), mean_motion(slider(**changed), orbit(5e-9)))
    assert found.velocity == pytest.approx(full.velocity, rel=2e-8)


def test_a_load_that_drags_the_slider_back():
    full, found = (
        steady(slider(load=6e-5), orbit(3e-9), tolerance=1e-8), mean_motion(slider(load=6e-5), orbit(3e-9)),
    )  # fmt: skip
    assert full.velocity < 0.0
    assert found.velocity == pytest.approx(full.velocity, rel=2e-8)


def test_mirrored_wave_and_three_contacts():
    trio = tuple(orbit(5e-9).scaled(np.exp(-2j * np.pi * k / 7.0)) for k in range(3))
    full, found = steady(slider(), trio, tolerance=1e-8), mean_motion(slider(), trio)
    assert found.velocity == pytest.approx(full.velocity, rel=1e-7)
    assert mean_motion(slider(), tuple(o.mirrored() for o in trio)).velocity == -found.velocity


def test_held_below_the_threshold():
    found = mean_motion(slider(), orbit(0.7e-9))
    assert (found.velocity, found.held, found.regime) == (0.0, True, "stick")


# Oracle: the event-exact way
@pytest.mark.parametrize(
    ("A", "first", "second"),
    [pytest.param(2e-9, 2e-5, 2e-6, marks=pytest.mark.slow), (5e-9, 4e-5, 5e-7), (20e-9, 6e-5, 5e-7)],
)
def test_velocity_through_the_bounce(A, first, second):
    exact = burst(slider(), orbit(A), duration=2e-3, after=0.0, tolerance=1e-7, samples=2, method="exact")
    v = exact.velocity_at_burst_end
    problem = rest_problem(slider(), (orbit(A),))
    for tolerance, allowed in ((1e-4, first), (1e-7, second)):
        asked = Burst(slider(), as_orbits(orbit(A)), problem, 4400, 4400, tolerance, None)
        result = BURST_METHODS["averaged"].follow(asked)
        motion, _ = result.run
        error = over(motion.state[2] * problem.speed - v, v, A)
        assert error < allowed
        assert error < 2.0 * over(result.error * problem.speed, v, A)
        assert result.statistics["order"] == (2 if tolerance < 1e-5 else result.statistics["order"])


LIGHT = {"mass": 2e-6, "preload": 2e-4, "load": 0.6 * 0.08 * 2e-4, "normal_damping": 0.03, "tangential_damping": 1e-6}


# Oracle: the event-exact way. Hunt-Crossley's force at 10 nm is 7 P and more, and its mean is zero; the light slider
# hops under its load and gains speed all the time, so that all of the first-order error adds up.
@pytest.mark.parametrize(
    ("changed", "A", "cycles", "tolerance"),
    [({"contact_damping": 50.0}, 10e-9, 3000, 1e-5), (LIGHT, 12e-9, 4000, 1e-3)],
)
def test_stated_error_of_a_burst_holds_the_true_one(changed, A, cycles, tolerance):
    def run(method, allowed):
        return burst(
            slider(**changed), orbit(A), duration=cycles / 2.2e6, after=0.0, tolerance=allowed, samples=2, method=method
        )

    exact, found, chosen = run("exact", 1e-7), run("averaged", tolerance), run("auto", tolerance)
    v = exact.velocity_at_burst_end
    true = over(found.velocity_at_burst_end - v, v, A)
    assert true < 2.0 * found.relative_error
    assert true < tolerance or found.status != "ok"
    assert found.relative_error < 10.0 * tolerance, "the estimate must not be a blanket"
    assert chosen.status == "ok"
    assert over(chosen.velocity_at_burst_end - v, v, A) < tolerance


def test_samples_on_the_way_and_the_slide_after():
    runs = [
        burst(slider(), orbit(5e-9), duration=2e-3, after=1e-3, tolerance=1e-5, samples=60, method=m)
        for m in ("averaged", "stepped")
    ]
    assert np.array_equal(runs[0].time, runs[1].time)
    top = np.max(np.abs(runs[1].velocity))
    assert runs[0].velocity == pytest.approx(runs[1].velocity, abs=5e-5 * top)
    assert runs[0].position[5:-20] == pytest.approx(runs[1].position[5:-20], abs=1e-2 * 4.7e-9)


def test_what_is_asked_for_does_not_change_the_averaged_motion():
    runs = [
        burst(slider(), orbit(5e-9), duration=2e-3, after=1e-4, tolerance=1e-4, samples=n, method="averaged")
        for n in (2, 37, 400)
    ]
    assert len({run.velocity_at_burst_end for run in runs}) == 1


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [({"mass": 1e-9}, "too stiff"), ({"stick_band": 1e-4}, "stick_band"), ({"friction_coefficient": 0.0}, "friction"),
     ({"reciprocal": True}, "reciprocal"), ({"normal_damping": 1e3}, "dampers")],
)  # fmt: skip
def test_where_it_does_not_apply(changed, sentence):
    with pytest.raises(ConvergenceError, match=sentence):
        burst(slider(**changed), orbit(5e-9), duration=1e-4, after=0.0, tolerance=1e-3, samples=2, method="averaged")


def test_pure_stick_is_handed_over():
    def run(method):
        return burst(slider(), orbit(0.5e-9), duration=2e-3, after=0.0, tolerance=1e-4, samples=2, method=method)

    with pytest.raises(ConvergenceError, match="sticks through whole cycles"):
        run("averaged")
    assert run("auto").method == "stepped"


def test_auto_takes_the_way_that_keeps_the_tolerance():
    def run(tolerance, duration=1e-3, **changed):
        return burst(slider(**changed), orbit(5e-9), duration=duration, after=0.0, tolerance=tolerance, samples=2)

    assert run(1e-4, 4e-3).method == "averaged"
    assert run(1e-8).relative_error <= 1e-8
    assert run(1e-4, stick_band=1e-4).method == "exact"


def test_map_of_steady_states():
    factors, preloads = np.array([0.0, 0.2, 1.0, 4.0]), np.array([4e-4, PRELOAD, 3e-3])
    found = steady_map(slider(), orbit(3e-9), factors=factors, preloads=preloads)
    for i, preload in enumerate(preloads):
        assert found.velocity[i, 0] == 0.0
        for j, factor in enumerate(factors[1:], start=1):
            one = mean_motion(slider(preload=preload), orbit(3e-9 * factor))
            assert found.velocity[i, j] == pytest.approx(one.velocity, rel=1e-7)
            assert found.height[i, j] == pytest.approx(one.height, rel=1e-8, abs=1e-16)
            assert found.regime[i, j] == one.regime
    other = steady_map(slider(), orbit(3e-9), factors=factors, preloads=preloads, threads=1)
    assert np.array_equal(found.velocity, other.velocity)


def test_map_leaves_out_what_it_does_not_know():
    found = steady_map(slider(reciprocal=True), orbit(3e-9), factors=[1.0], preloads=[1e-3])
    assert found.regime[0, 0] == "unknown"
    assert np.isnan(found.velocity[0, 0])


def test_general_phase():
    shape = Orbit(frequency=2.2e6, normal=6e-9, tangential=5e-9 * np.exp(-0.9j))
    full = steady(slider(), shape, tolerance=1e-8)
    assert mean_motion(slider(), shape).velocity == pytest.approx(full.velocity, rel=1e-7)


@pytest.mark.parametrize("rate", [1e300, np.inf, np.nan])
def test_rates_that_no_step_can_follow_end_the_averaged_motion(rate, monkeypatch):
    rates = chain([1.0, 1.0], repeat(rate))
    monkeypatch.setattr(riding_stage, "averaged_rate", lambda _p, h, *_: (next(rates), h))
    problem, no_rule = rest_problem(slider(), (orbit(5e-9),)), Rule(np.empty(0), np.empty(0))
    span = Span(600.0, 1e-4, 8, no_rule, 1, np.empty(0), np.empty((0, 2)))
    start = Stage(Status.DONE, AveragedMotion(0.1, 0.0, 0.0), 0.0, 0)
    with np.errstate(all="ignore"):  # as in the compiled kernel
        ended = riding_stage.follow_velocity(problem, start, span, work_arrays(1), riding_stage.velocity_arrays())
    assert ended.status == Status.UNSETTLED
    assert ended.motion == start.motion
