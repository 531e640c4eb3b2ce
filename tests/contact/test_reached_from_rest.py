"""A periodic motion is an answer only if a start from rest comes to it; else the doubt is in the error."""

from dataclasses import replace

import numpy as np
import pytest

from contact import Orbit, burst, steady
from contact.answers.rest_motion import rest, rest_problem
from contact.error_estimate import reference_speed
from contact.orbit import towards_plus
from contact.periodic import settling
from contact.stepping.time_stepping import steps
from tests.contact.motors import slider

# transient chaos: near f_n/f = 0.34 a start from rest wanders for thousands of cycles
WANDERS = {
    "mass": 1.9038912868416152e-06, "preload": 2.4944007487339945e-05, "friction_coefficient": 0.45519645231782263,
    "normal_damping": 0.0025392158988536057, "tangential_damping": 0.0,
}  # fmt: skip
NORMAL, F = 1.9192794575286814e-08, 98013.26821400871
SLOW_WAVE = Orbit(frequency=F, normal=NORMAL, tangential=-1j * 0.29857257978382257 * NORMAL)
NEAR_BY = Orbit(frequency=F, normal=NORMAL, tangential=-1j * 0.2986 * NORMAL)


@pytest.mark.parametrize("wave", [SLOW_WAVE, NEAR_BY])
def test_transient_chaos_is_in_the_error(wave):
    answer = steady(slider(**WANDERS), wave, tolerance=1e-3)
    run = burst(
        slider(**WANDERS), wave, duration=12000 / F, after=0.0, tolerance=1e-8, samples=12000,
        method="exact",
    )  # fmt: skip
    from_rest = float(run.velocity[3000:].mean())
    error = abs(answer.velocity - from_rest) / reference_speed(answer.velocity, (wave,))
    assert 0.01 < error < 2.0 * answer.relative_error
    assert answer.status == "above tolerance"
    assert "matter of chance" in answer.message or "not reached from rest" in answer.message


@pytest.mark.parametrize(
    ("load", "cycles"),
    [(0.0, 2e4), (0.4, 3e3), *(pytest.param(*each, marks=pytest.mark.slow) for each in ((0.0, 3e3), (0.4, 2e4)))],
)
def test_a_bounce_that_dies_out_slowly_is_followed_until_it_has(cycles, load):
    """Truth: fixed steps from rest for ten decay times, at 192 steps per cycle."""
    f = 4e5
    body = slider(preload=2e-4, mass=1e-6, friction_coefficient=0.2, load=load * 0.2 * 2e-4, tangential_damping=0.0)
    mass = 1e-6 * (body.normal_resonance(1) / f / 0.2) ** 2
    body = replace(body, mass=mass, normal_damping=2 * mass * f / cycles)
    wave = Orbit(frequency=f, normal=3 * body.rest_approach(1), tangential=-1.6j * body.rest_approach(1))
    answer = steady(body, wave, tolerance=1e-3)
    side, driven = towards_plus((wave,))
    problem = rest_problem(body, driven)
    begin = rest(body, driven, problem, nodes=14, truncation=1e-10)
    rows = steps(problem, begin.state.copy(), int(10 * cycles), 192)
    truth = side * float(rows[-int(cycles) :, 2].mean()) * problem.speed
    error = abs(answer.velocity - truth) / reference_speed(truth, (wave,))
    assert error < 2.0 * answer.relative_error + 1e-4  # of the truth
    assert answer.status == "ok"


def test_what_could_not_be_seen_is_not_called_ok(monkeypatch):
    body = slider(mass=2e-6, preload=2e-4, normal_damping=0.03)
    wave = Orbit(frequency=3e5, normal=5e-9, tangential=-3e-9j)
    assert steady(body, wave, tolerance=1e-3).status == "ok"

    def fails(*given):
        raise settling.ConvergenceError("out of reach", "planted")

    monkeypatch.setattr(settling, "run_from", fails)
    answer = steady(body, wave, tolerance=1e-3)
    assert answer.status == "above tolerance"
    assert answer.relative_error >= 1.0
    assert "was not seen" in answer.message


def test_a_hysteretic_motion_that_repeats_has_the_error_of_another_order():
    """Two balls in opposite phase; the error was a constant before."""
    body = slider(law="hysteretic", mass=2e-6, preload=2e-4, normal_damping=0.05, tangential_damping=3e-2)
    wave = Orbit(frequency=3e5, normal=4e-9, tangential=-3e-9j)
    pair = (wave, wave.scaled(np.exp(2.1j)))
    problem, begin = settling.start_at_rest(body, pair, 1.0)
    run = settling.run_from(problem, begin, settling.relaxation_rate(problem))
    assert run.period
    finer = rest(body, pair, problem, nodes=20, truncation=1e-13)
    finer.turn(run.passed)
    finer.begin()
    finer.turn(run.period)
    true = abs(finer.sums[settling.EnergySum.DISPLACEMENT] / (2 * np.pi * run.period) - run.speed)
    assert true <= 2.0 * run.error
    assert run.error != pytest.approx(1e-9, rel=1e-3)


def test_a_held_slider_that_bounces_for_ever_may_move():
    """Balls at different heights, held at rest in the mean; nothing damps the bounce of a start from rest."""
    body = slider(normal_damping=0.0, heights=(0.0, 1e-9, 2e-9))
    wave = Orbit(frequency=2.2e6, normal=0.8e-9, tangential=-0.15e-9j)
    orbits = (wave, wave.scaled(np.exp(2.0j)), wave.scaled(np.exp(4.1j)))
    answer = steady(body, orbits, tolerance=1e-3)
    assert answer.velocity == 0.0
    run = burst(body, orbits, duration=4000 / 2.2e6, after=0.0, tolerance=1e-6, samples=400, method="exact")
    late = float(run.velocity[len(run.velocity) // 2 :].mean())
    assert abs(late) / reference_speed(0.0, orbits) < 2.0 * answer.relative_error + 1e-3


def test_a_bounce_that_is_not_found_is_not_dropped(monkeypatch):
    body = slider(normal_damping=0.0)
    monkeypatch.setattr("contact.answers.steady.speed_lost", lambda *given: float("nan"))
    answer = steady(body, Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j), tolerance=1e-3)
    assert answer.relative_error >= 1.0
    assert answer.status == "above tolerance"
    assert "was not found" in answer.message


def test_a_light_preload_lets_the_slider_fly_far_and_the_answer_says_so():
    # the turning point was looked for in equal steps, which ended after hours
    body = slider(preload=7.6e-8, normal_damping=0.0, effective_modulus=140e9, tangential_modulus=26.3e9)
    answer = steady(body, Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j), tolerance=1e-3)
    assert answer.velocity == pytest.approx(0.08 * 7.6e-8 / 1e-4, rel=1e-4)  # full slip: friction over the damper
    assert answer.status == "above tolerance"
    assert "was not found" in answer.message
