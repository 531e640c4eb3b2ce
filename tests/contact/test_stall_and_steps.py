"""The load at which the full motion stalls, load lines with errors, steps with errors."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from contact import (
    Answer,
    ConvergenceError,
    Envelope,
    FallingFriction,
    Orbit,
    Slider,
    blocked_thrust,
    cycles_for,
    load_line,
    stall,
    steady,
    step,
)
from contact.answers import load_and_stall as stalls
from contact.answers.rest_motion import rest, rest_problem, silence
from contact.answers.steps import QUIET_SPANS
from contact.error_estimate import averaged_stall_error
from contact.events.energy import EnergySum
from contact.events.motion import Motion
from contact.orbit import towards_plus
from contact.stepping.time_stepping import steps
from tests.contact.motors import orbit, slider, stop_motor, way_to_rest
from tests.motors import aimed
from tests.oracles.contact_stop import TRAVEL, V, extrapolated

LIGHT = {
    "mass": 2e-6,
    "preload": 2e-3,
    "friction_coefficient": 0.15,
    "normal_damping": 0.25678,
    "tangential_damping": 0.0,
}
WAVE = Orbit(frequency=756808.77, normal=4e-9, tangential=-2.8e-9j)  # f_n/f = 0.09


def test_a_light_motor_stalls_where_an_independent_integrator_says():
    answer = stall(slider(**LIGHT), WAVE, tolerance=1e-4)
    assert answer.value == pytest.approx(63.72e-6, abs=0.005e-6)
    assert (answer.status, answer.error < 1e-4 * answer.value) == ("ok", True)
    averaged, _ = blocked_thrust(slider(**LIGHT), WAVE)
    assert averaged == pytest.approx(62.81e-6, abs=0.005e-6)
    assert 0.01 * averaged < answer.value - averaged < averaged_stall_error(0.09) * averaged


@pytest.mark.parametrize(
    "changed", [{}, {"mass": 2e-5}, {"shape": "punch", "radius": 3e-6, "mass": 1e-5}, {"tangential_damping": 1e-3}]
)
@pytest.mark.parametrize("amplitude", [4e-9, 2e-8])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_the_full_motion_goes_on_below_the_stall_and_not_above(changed, amplitude, tolerance):
    wave = WAVE.scaled(amplitude / 4e-9)
    answer = stall(slider(**(LIGHT | changed)), wave, tolerance=tolerance)
    assert (answer.status, answer.error <= tolerance * answer.value) == ("ok", True)
    forward = steady(slider(**(LIGHT | changed)), wave, tolerance=1e-5).velocity
    below = slider(**(LIGHT | changed), load=answer.value - 3.0 * answer.error)
    assert steady(below, wave, tolerance=1e-5).velocity * forward > 0.0
    above = slider(**(LIGHT | changed), load=answer.value + 3.0 * answer.error)
    try:
        back = steady(above, wave, tolerance=1e-5)
        assert back.velocity * forward <= 0.0
        assert ("direction of the load" in back.message) == (back.velocity != 0.0)
    except ConvergenceError as refused:
        assert refused.status == "runaway"  # noqa: PT017


def test_a_stall_that_only_averaging_gives_has_its_error():
    heavy = stall(slider(), orbit(10e-9), tolerance=0.05)
    ratio = slider().normal_resonance(1) / 2.2e6
    assert heavy.error == pytest.approx(averaged_stall_error(ratio) * heavy.value, rel=1e-9)
    assert heavy.value == blocked_thrust(slider(), orbit(10e-9))[0]
    with pytest.raises(ConvergenceError, match="does not move the unloaded slider"):
        stall(slider(), orbit(0.5e-9), tolerance=1e-3)


def test_a_load_line_carries_the_errors_of_its_points():
    line = load_line(slider(**LIGHT), WAVE, points=4, tolerance=1e-4)
    assert line.status == "ok"
    assert line.blocked_thrust == line.stall.value == line.load[-1]
    for load, velocity, error in zip(line.load[:-1], line.velocity, line.relative_error, strict=False):
        state = steady(slider(**LIGHT, load=float(load)), WAVE, tolerance=1e-4)
        assert abs(state.velocity) == velocity
        assert state.relative_error == error
    assert line.relative_error[-1] == line.stall.error / line.stall.value
    undamped = load_line(slider(**(LIGHT | {"normal_damping": 0.0})), WAVE, points=3, tolerance=1e-4)
    assert undamped.status == "above tolerance"
    assert "bouncing" in undamped.message


@pytest.mark.parametrize("cycles", [40, 300])
@pytest.mark.parametrize("shaped", [False, True])
def test_the_error_of_a_step_holds(cycles, shaped):
    """Truth: the exact motion with 20 nodes; under an envelope four times as many steps."""
    body, wave = slider(**LIGHT), WAVE.scaled(2.0)
    f = WAVE.frequency
    shape = Envelope(time=[0.0, 30 / f], amplitude=[0.0, 1.0], phase=[0.0, 0.0]) if shaped else None
    found = step(body, wave, cycles=cycles, envelope=shape)
    side, driven = towards_plus((wave,))
    problem = rest_problem(body, driven)
    motion = rest(body, driven, problem, nodes=20, truncation=1e-13, factor=0.0 if shaped else 1.0)
    if shaped:
        rows = steps(problem, motion.state, cycles, 384, envelope=shape)
        during = 2.0 * np.pi * float(np.sum(rows[:, 2]))
    else:
        motion.turn(cycles)
        during = float(motion.sums[EnergySum.DISPLACEMENT])
    assert abs(side * during * problem.length - found.during) <= 2.0 * found.error + 1e-18
    assert found.answer.value == found.displacement
    assert found.error < (1e-2 if shaped else 1e-9) * abs(found.displacement)


@pytest.mark.parametrize(("draw", "parting", "cycles"), [(130, True, 54), (172, True, 54), (38, False, 60)])
def test_no_slip_is_missed_after_the_burst(draw, parting, cycles):
    """Slips shorter than any sampling, and one after 17 half ring periods without: bounce and ring beat."""
    body, wave, *_ = aimed(draw)
    if parting:  # so far that the punches just part
        reach = max(abs(each.normal) for each in wave)
        wave = tuple(each.scaled(min(1.0, 1.2 * body.rest_approach(len(wave)) / reach)) for each in wave)
    found = step(body, wave, cycles=cycles)
    side, driven = towards_plus(wave)
    problem = rest_problem(body, driven)
    motion = rest(body, driven, problem, nodes=16, truncation=1e-12)
    motion.turn(cycles)
    moved = float(motion.sums[EnergySum.DISPLACEMENT])
    still = silence(motion)
    still.move(0.0, 400.0 * problem.omega / body.tangential_resonance(len(wave)), np.empty(0))
    load = math.copysign(body.load, problem.load) / (body.friction_coefficient * body.normal_stiffness)
    on = way_to_rest(
        body.rest_approaches(len(wave)), still.state[3:] * problem.length, body.limit_slope,
        1.5 if body.shape == "sphere" else 1.0, load,
    )  # fmt: skip
    truth = side * ((moved + float(still.sums[EnergySum.DISPLACEMENT])) * problem.length + on)
    assert abs(found.displacement - truth) <= 2.0 * found.error
    assert found.error < 1e-10 * abs(truth)


def test_a_step_ends_where_the_springs_of_unequal_contacts_carry_just_the_load():
    """Two heights, so that the contacts slip and stick with other deformations; truth without events."""
    damped = LIGHT | {"normal_damping": 0.3, "tangential_damping": 0.3, "heights": (0.0, 1e-9), "load": 2e-5}
    waves = tuple(WAVE.scaled(0.5 * np.exp(1j * phase)) for phase in (0.0, 1.5))
    found = step(slider(**damped), waves, cycles=20)
    motor = stop_motor(slider(**damped), waves)

    def travel(per_cycle):
        _, state = motor.run(20, per_cycle)
        _, state = motor.run(300, per_cycle, state, silent=True)
        assert abs(state[1][V]) < 1e-9  # it is at rest
        return state[1][TRAVEL]

    truth, error = extrapolated(travel, 500)
    assert abs(found.displacement - truth) < 2.0 * found.error + 10.0 * error
    assert error < 1e-5 * abs(truth)


@pytest.mark.parametrize("cycles", [60, 200])
def test_a_hysteretic_step_ends_near_where_its_ring_dies_out(cycles):
    body = slider(law="hysteretic", normal_damping=2.0, tangential_damping=0.5)
    found = step(body, orbit(8e-9), cycles=cycles)
    problem = rest_problem(body, (orbit(8e-9),))
    motion = rest(body, (orbit(8e-9),), problem, nodes=16, truncation=1e-12)
    motion.turn(cycles)
    still, half = silence(motion), 0.5 * problem.omega / body.tangential_resonance(1)
    for k in range(40):
        still.move(k * half, (k + 1) * half, np.empty(0))
    travel = float(motion.sums[EnergySum.DISPLACEMENT] + still.sums[EnergySum.DISPLACEMENT]) * problem.length
    assert abs(float(still.state[2])) < 1e-5  # it is at rest
    assert abs(found.displacement - travel) < 2.0 * found.error
    assert 1e-12 < found.error < 0.7 * found.displacement


def test_a_step_with_friction_that_depends_on_pressure():
    # exact limit: no dependence; a warning about numbers that are not finite fails every test
    mu = slider().friction_coefficient
    plain, same, less = (
        step(slider(friction=friction), orbit(10e-9), cycles=20)
        for friction in (
            None,
            FallingFriction(high_pressure=mu, pressure=5e7),
            FallingFriction(high_pressure=0.9 * mu, pressure=5e7),
        )
    )
    assert abs(same.displacement - plain.displacement) < 1e-10 * plain.ring + plain.error + same.error
    assert abs(less.displacement - plain.displacement) > 1e-2 * abs(plain.displacement)


def test_a_load_moves_a_slider_that_bounces_for_ever():
    # measured: the travel of each half period stays within 2 % for 10 000 of them; with a damper the slider stops
    body, orbits, *_ = aimed(0)
    bouncing = replace(body, normal_damping=0.0, contact_damping=0.0)
    with pytest.raises(ConvergenceError, match="goes on slipping; give it normal damping"):
        step(bouncing, orbits, cycles=60)
    damper = 0.2 * body.mass * 2.0 * math.pi * body.normal_resonance(len(orbits))
    assert step(replace(bouncing, normal_damping=damper), orbits, cycles=60).displacement != 0.0


def test_steps_that_are_planned_have_errors_too():
    short, enough = cycles_for(slider(), orbit(10e-9), displacement=1e-8)
    assert enough == step(slider(), orbit(10e-9), cycles=enough.cycles)
    assert short.cycles == enough.cycles - 1
    assert 0.0 < enough.error < 1e-15


def test_stopping_takes_the_ring_down_and_the_braking():
    f, body, wave = WAVE.frequency, slider(**LIGHT), WAVE.scaled(2.0)
    ringing = 200 / f
    fading = Envelope(time=np.linspace(0, ringing, 50), amplitude=np.linspace(1.0, 0.0, 50), phase=np.zeros(50))
    rising = Envelope(time=[0.0], amplitude=[1.0], phase=[0.0])
    sudden = step(body, wave, cycles=400, envelope=rising)
    rung = step(body, wave, cycles=400, envelope=rising, after=fading)
    assert sudden.velocity == pytest.approx(rung.velocity, rel=1e-12)
    friction = 0.15 * 2e-3
    braking = abs(sudden.velocity) * 2e-6 / friction
    assert sudden.stopping_time == pytest.approx(braking, rel=0.3)
    assert braking < 0.5 * ringing
    assert rung.stopping_time > ringing * 0.98
    assert rung.stopping == pytest.approx(rung.displacement - rung.during, rel=1e-12)


@pytest.mark.parametrize("stall", [0.996, 1.0, 1.008, 1.05, 1.4])
def test_the_bracket_of_the_stall_is_widened_where_the_slider_still_moves(monkeypatch, stall):
    """The averaged load is 1.000 N with a stated error of 0.005 N; the velocity falls on a curve."""

    def moving(body, orbits, tolerance):
        left = (stall - body.load) * (1.0 + 0.3 * (stall - body.load))
        return SimpleNamespace(velocity=max(left, 0.0), relative_error=0.0, message="")

    monkeypatch.setattr(stalls, "steady", moving)
    monkeypatch.setattr(stalls, "mean_motion", lambda body, orbits: SimpleNamespace(velocity=1.0))
    body = replace(slider(), preload=100.0)
    answer = stalls.full_stall(body, (orbit(5e-9),), Answer(value=1.0, error=0.005, reasons=()), 1e-5)
    assert abs(answer.value - stall) <= answer.error < 2e-3 * stall


@pytest.mark.parametrize("cycles", [100, 242])
def test_a_ring_that_touches_the_slip_limit_for_ever_ends_when_the_bounce_has_died_out(cycles):
    """f_t = 0.994 f_n: 50 000 spans were followed, in each of which the slider slipped by its rounding."""
    even = Slider(
        radius=0.001028449953191421, mass=1.69657778831353e-07, preload=0.0003423371575357137, load=0.0,
        friction_coefficient=0.03256062494754735, effective_modulus=93866799227.80275,
        tangential_modulus=23175353646.46072, law="elastic", reciprocal=False, stick_band=0.0,
        contact_damping=0.05161618800477477, normal_damping=0.06416443123779275, tangential_damping=0.0,
    )  # fmt: skip
    wave = Orbit(
        frequency=953396.1477062881, normal=5.42931699417939e-09,
        tangential=2.71374564135568e-09 - 6.396904604600815e-09j,
    )  # fmt: skip
    counted, spans = Motion.move, []

    def move(motion, *given):
        spans.append(1)
        return counted(motion, *given)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Motion, "move", move)
        found = step(even, wave, cycles=cycles)
    assert 2 * QUIET_SPANS < len(spans) < 300
    # the ring is left at the slip limit
    assert found.ring == pytest.approx(even.limit_slope * even.rest_approach(1), rel=1e-4)
    # by integration without events to its extrapolated error
    motor = stop_motor(even, (wave,))

    def final(number):
        _, state = motor.run(cycles, number)
        _, (_, y, x, _) = motor.run(500, number, state=state, silent=True)
        return y[TRAVEL] + way_to_rest(np.array([even.rest_approach(1)]), x, even.limit_slope)

    right, unsure = extrapolated(final, 400)
    assert abs(found.displacement - right) < 2.0 * found.error + unsure
    assert unsure < 1e-4 * abs(right)


def test_a_slider_that_no_damper_brings_to_rest_is_refused_in_time():
    body = slider(
        mass=1.69657778831353e-07, preload=3.4e-4, normal_damping=0.0, tangential_damping=0.0, tangential_modulus=15.8e9
    )
    with pytest.raises(ConvergenceError, match="goes on slipping; give it normal damping"):
        step(body, orbit(5e-9, frequency=0.95e6), cycles=242)
