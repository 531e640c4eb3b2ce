"""The steady velocity: against an independent integrator, symmetries, limits, refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, burst, steady, threshold_amplitude
from contact.answers.rest_motion import rest, rest_problem
from contact.averaged.closed_forms import closed_form
from contact.error_estimate import reference_speed
from tests.contact.motors import orbit, slider
from tests.frozen import frozen
from tests.oracles.contact_steps import steady_velocity
from tests.seed_motor import FRICTION as COEFFICIENT
from tests.seed_motor import PRELOAD

AMPLITUDES = (1e-9, 3e-9, 5e-9, 10e-9, 20e-9)


# Oracle: its own error is of order 2.5 per event
@frozen([(A, number) for A in AMPLITUDES for number in (2000, 4000)])
def small_step_velocity(A, number):
    """Steady velocity in m/s by so many steps per cycle, on a wave of the amplitude A in m."""
    return np.array(steady_velocity(A, number))


@pytest.mark.parametrize("A", AMPLITUDES)
def test_velocity_against_small_step_runge_kutta(A):
    found = steady(slider(), orbit(A), tolerance=1e-8)
    assert found.status == "ok"
    assert found.method == "exact"
    assert found.velocity == pytest.approx(small_step_velocity(A, 2000), rel=2e-8)


@pytest.mark.parametrize("A", AMPLITUDES)
def test_error_estimate_covers_the_true_error_and_averaging_is_as_small_as_theory(A):
    exact = steady(slider(), orbit(A), tolerance=1e-8)
    averaged = steady(slider(), orbit(A), tolerance=1e-3, method="averaged")
    truth = float(small_step_velocity(A, 4000))
    reference = reference_speed(truth, exact.orbits)
    assert abs(exact.velocity - truth) / reference < 2.0 * exact.relative_error + 1e-8  # the oracle's own
    assert abs(averaged.velocity - truth) / reference < 1.01 * averaged.relative_error + 1e-8
    ratio = (slider().normal_resonance(1) / 2.2e6) ** 2
    assert 0.0 < averaged.relative_error < 4.0 * ratio


@pytest.mark.parametrize("A", [0.5e-9, 0.9e-9, 3e-9, 10e-9])
def test_mirrored_wave_gives_the_negated_velocity(A):
    right, left = (steady(slider(), o, tolerance=1e-6) for o in (orbit(A), orbit(A).mirrored()))
    assert left.velocity == -right.velocity
    assert left.regime == right.regime


def test_crests_moving_towards_plus_x_drive_the_slider_there():
    assert orbit(3e-9).crest_velocity > 0.0
    assert steady(slider(), orbit(3e-9), tolerance=1e-6).velocity > 0.0


@pytest.mark.parametrize("turn", [0.3, 2.1, 4.4])
def test_the_origin_of_time_does_not_matter(turn):
    shape = Orbit(frequency=2.2e6, normal=3e-9, tangential=2.2e-9 * np.exp(-1.4j))
    one = steady(slider(), shape, tolerance=1e-9).velocity
    assert steady(slider(), shape.scaled(np.exp(1j * turn)), tolerance=1e-9).velocity == pytest.approx(one, rel=1e-9)


@pytest.mark.parametrize("A", [1.2e-9, 7e-9])
def test_three_contacts_in_phase_are_one_with_a_third_of_everything(A):
    three = slider(load=1e-6)
    names = ("mass", "preload", "load", "normal_damping", "tangential_damping")
    one = slider(**{name: getattr(three, name) / 3.0 for name in names})
    apart = steady(three, (orbit(A),) * 3, tolerance=1e-9)
    assert apart.velocity == pytest.approx(steady(one, orbit(A), tolerance=1e-9).velocity, rel=1e-9)


def test_contacts_on_different_phases_of_the_wave_still_drive():
    # With two contacts half a wave apart the sum of normal forces hardly varies, yet each sees its own cycle
    pair = (orbit(3e-9), orbit(3e-9).scaled(-1.0))
    found = steady(slider(), pair, tolerance=1e-6)
    assert found.status == "ok"
    assert found.velocity > 0.0


@pytest.mark.parametrize("unit", [1e-3, 1e4])
def test_units_do_not_matter(unit):
    # Property: lengths times L, times times T, masses times M; moduli M/(L T^2), forces M L/T^2, velocities L/T
    L, T, M = unit, unit**0.5, unit**-0.7
    F, s = M * L / T**2, slider(stick_band=2e-4, contact_damping=1e-3, load=1e-5)
    scaled = slider(
        radius=s.radius * L, mass=s.mass * M, preload=s.preload * F, load=s.load * F,
        effective_modulus=s.effective_modulus * F / L**2, tangential_modulus=s.tangential_modulus * F / L**2,
        stick_band=s.stick_band * L / T, contact_damping=s.contact_damping * T / L,
        normal_damping=s.normal_damping * M / T, tangential_damping=s.tangential_damping * M / T,
    )  # fmt: skip
    A = 5e-9
    moved = Orbit(frequency=2.2e6 / T, normal=A * L, tangential=-0.7j * A * L)
    assert steady(scaled, moved, tolerance=1e-9).velocity == pytest.approx(
        steady(s, orbit(A), tolerance=1e-9).velocity * L / T, rel=1e-8
    )  # rounding, through the Newton matrix of condition 1e5


def test_zero_amplitude_and_zero_friction_stand_still():
    still = steady(slider(), orbit(0.0), tolerance=1e-6)
    assert (still.velocity, still.regime, still.relative_error) == (0.0, "stick", 0.0)
    smooth = steady(slider(friction_coefficient=0.0), orbit(10e-9), tolerance=1e-6)
    assert (smooth.velocity, smooth.regime) == (0.0, "intermittent")
    loose = steady(slider(preload=0.0), orbit(10e-9), tolerance=1e-6)
    assert loose.velocity == 0.0


def test_held_below_the_threshold_is_exactly_zero():
    s = slider()
    edge = threshold_amplitude(s, orbit(1e-9))
    held = steady(s, orbit(0.99 * edge), tolerance=1e-6)
    assert (held.velocity, held.regime, held.status) == (0.0, "stick", "ok")
    assert steady(s, orbit(1.01 * edge), tolerance=1e-6).velocity > 0.0


def test_load_slows_stops_and_then_drags():
    s = slider()
    friction = s.friction_coefficient * s.preload
    velocities = [steady(slider(load=k * friction), orbit(3e-9), tolerance=1e-6).velocity for k in (0, 0.1, 0.3, 3.0)]
    assert velocities == sorted(velocities, reverse=True)
    assert velocities[2] < velocities[0]
    # beyond what friction can give, the damper alone bounds the speed
    assert velocities[3] == pytest.approx(-2.0 * friction / s.tangential_damping, rel=1e-6)


def test_a_load_without_friction_or_damper_runs_away_and_says_so():
    with pytest.raises(ConvergenceError, match="no tangential damping") as caught:
        steady(slider(load=1e-3, friction_coefficient=0.0, tangential_damping=0.0), orbit(3e-9), tolerance=1e-6)
    assert caught.value.status == "runaway"
    with pytest.raises(ConvergenceError, match="no tangential damping"):
        steady(slider(load=1.0, tangential_damping=0.0), orbit(3e-9), tolerance=1e-6)


def test_without_tangential_damping_the_traction_has_zero_mean():
    free = steady(slider(tangential_damping=0.0), orbit(3e-9), tolerance=1e-9)
    assert free.velocity > steady(slider(), orbit(3e-9), tolerance=1e-9).velocity
    assert free.velocity < 2.0 * math.pi * 2.2e6 * 0.7 * 3e-9


def test_the_stick_band_has_a_bias_that_vanishes_with_its_square():
    # The paper's DV; observed order between neighbouring bands
    exact = steady(slider(), orbit(3e-9), tolerance=1e-9).velocity
    bands = (8e-4, 4e-4, 2e-4)
    bias = [abs(steady(slider(stick_band=b), orbit(3e-9), tolerance=1e-8).velocity - exact) for b in bands]
    orders = np.log2(np.array(bias[:-1]) / np.array(bias[1:]))
    assert np.all(np.abs(orders - 2.0) < 0.2), f"orders {orders}, bias {bias}"


def test_events_are_counted_by_kind():
    slip = steady(slider(), orbit(3e-9), tolerance=1e-6).statistics
    assert (slip["contact"], slip["release"], slip["stick_to_slip"], slip["slip_to_stick"]) == (0, 0, 2, 2)
    parted = steady(slider(), orbit(10e-9), tolerance=1e-6).statistics
    assert (parted["contact"], parted["release"]) == (1, 1)


def test_an_estimate_above_the_tolerance_is_not_called_ok():
    rough = steady(slider(), orbit(1e-9), tolerance=1e-9, method="averaged")
    assert rough.status == "above tolerance"
    assert "exceeds" in rough.message


def test_an_orbit_without_tangential_motion_drives_nothing():
    found = steady(slider(), Orbit(frequency=2.2e6, normal=5e-9, tangential=0.0), tolerance=1e-6)
    assert (found.velocity, found.relative_error) == (0.0, 0.0)
    shear = steady(slider(), Orbit(frequency=2.2e6, normal=0.0, tangential=3e-9), tolerance=1e-6)
    assert shear.velocity == 0.0


@pytest.mark.parametrize(
    ("changed", "frequency", "status", "says"),
    [
        ({"mass": 1e-12}, 2.2e6, "out of reach", "raise the mass or lower the dampers"),
        ({"contact_damping": 1e6}, 2.2e6, "out of reach", "follow a burst"),
    ],
)
def test_what_cannot_be_found_is_refused_with_a_next_step(changed, frequency, status, says):
    with pytest.raises(ConvergenceError, match=says) as caught:
        steady(slider(**changed), orbit(3e-9, frequency=frequency), tolerance=1e-6)
    assert caught.value.status == status


def mean_from_rest(cycles, per_cycle, A, **changed):
    """Return the mean velocity over the last two thirds of a run by the witness, hops and all."""
    from tests.oracles.contact_steps import parameters, rest_height, run

    p = parameters(**changed)
    y, regime, s = (-rest_height(p), 0.0, 0.0, 0.0), 1, 1.0
    y, regime, s, _ = run(A, p, y, regime, s, 0.0, cycles * per_cycle, per_cycle)
    return run(A, p, y, regime, s, cycles / p[8], 2 * cycles * per_cycle, per_cycle)[3]


@pytest.mark.parametrize(("frequency", "period"), [pytest.param(6e3, 1, marks=pytest.mark.slow), (12e3, 2)])
def test_a_slider_that_hops_near_its_resonance_is_followed_until_it_repeats(frequency, period):
    # Oracle: the same from rest in small steps. At 12 kHz the motion of one cycle is unstable
    found = steady(slider(), orbit(3e-9, frequency=frequency), tolerance=1e-8)
    assert found.status == "ok"
    assert found.statistics.get("period_cycles", 1) == period
    assert found.velocity == pytest.approx(mean_from_rest(300, 2500, 3e-9, frequency=frequency), rel=1e-6)
    assert found.ledger.relative_residual < 1e-9


def test_a_motion_that_never_repeats_has_a_mean_with_its_spread():
    # Near its resonance the slider hops irregularly, and the witness's own mean has the same spread
    found = steady(slider(normal_damping=0.1), orbit(6e-9, frequency=8e3), tolerance=1e-2)
    assert found.statistics["period_cycles"] == 0
    assert found.status == "above tolerance"
    reference = reference_speed(found.velocity, found.orbits)
    witness = mean_from_rest(600, 300, 6e-9, frequency=8e3, normal_damping=0.1)
    assert 1e-2 < found.relative_error < 2.0
    assert abs(found.velocity - witness) < 2.0 * found.relative_error * reference


def test_the_motion_that_a_slider_from_rest_reaches_is_the_answer_and_the_other_is_named():
    # f_n/f = 0.4: a stable motion repeats every cycle (largest multiplier 0.998), but the witness from rest hops
    light = {"mass": 2e-6, "preload": 2e-4, "normal_damping": 1e-3, "tangential_damping": 1e-4}
    s = slider(**light)
    frequency = s.normal_resonance(1) / 0.4
    found = steady(s, orbit(10e-9, frequency=frequency), tolerance=1e-2)
    reference = reference_speed(found.velocity, found.orbits)
    witness = mean_from_rest(1000, 300, 10e-9, frequency=frequency, **light)
    assert abs(found.velocity - witness) < 2.0 * found.relative_error * reference
    assert found.status == "above tolerance"
    assert found.other_velocity > 4e-3
    assert abs(witness) < 0.5 * found.other_velocity
    assert "not reached from rest" in found.message


def test_a_motion_that_is_reached_from_rest_has_no_other():
    s = slider()
    found = steady(s, orbit(10e-9, frequency=s.normal_resonance(1) / 0.3), tolerance=1e-6)
    assert (found.status, found.other_velocity) == ("ok", None)
    assert steady(s, orbit(10e-9), tolerance=1e-6).other_velocity is None


@pytest.mark.parametrize("A", [5e-9, pytest.param(10e-9, marks=pytest.mark.slow)])
def test_a_bounce_that_nothing_damps_is_part_of_the_error(A):
    # Oracle: the slider from rest, event by event, at two speeds: where its mean velocity does not drift
    s = slider(normal_damping=0.0)
    found = steady(s, orbit(A), tolerance=1e-6)
    problem = rest_problem(s, (orbit(A),))
    drifts, speeds, cycles = [], [0.98 * found.other_velocity, 1.02 * found.other_velocity], 2000
    weight = np.sin(np.pi * (np.arange(cycles) + 0.5) / cycles) ** 4 / (0.375 * cycles)
    for speed in speeds:
        motion = rest(s, (orbit(A),), problem, nodes=9, truncation=1e-8)
        motion.set_state(motion.state[0], 0.0, speed / problem.speed, motion.state[3:])
        means = motion.turn(2 * cycles, stride=1)[:, 2]
        drifts.append(weight @ (means[cycles:] - means[:cycles]))
    reached = speeds[0] + (speeds[1] - speeds[0]) * drifts[0] / (drifts[0] - drifts[1])
    assert found.status == "above tolerance"
    assert found.other_velocity == pytest.approx(reached, rel=3e-3)
    assert abs(reached - found.velocity) < 2.0 * found.relative_error * reference_speed(reached, found.orbits)
    assert "bouncing" in found.message


@pytest.mark.parametrize("frequency", [1.0, 400.0, 1e3, 2e3])
def test_a_slow_wave_carries_the_slider_and_its_mean_velocity_is_exactly_zero(frequency):
    found = steady(slider(), orbit(3e-9, frequency=frequency), tolerance=1e-6)
    assert (found.velocity, found.regime, found.status) == (0.0, "stick", "ok")
    # by the motion itself: nothing slips
    moved = burst(
        slider(), orbit(3e-9, frequency=max(frequency, 400.0)), duration=20 / 400, after=0.0, tolerance=1e-3,
        samples=2, method="exact",
    )  # fmt: skip
    assert moved.statistics["stick_to_slip"] == 0


@pytest.mark.parametrize("reciprocal", [False, True])
def test_a_load_beyond_friction_drags_the_slider_at_a_speed_in_closed_form(reciprocal):
    # against the search, which finds the same where the load is not yet so large
    s = slider(load=1.5e-4, reciprocal=reciprocal, tangential_damping=8e-4)
    searched = steady(s, orbit(3e-9), tolerance=1e-8)
    assert "periodic" in searched.message
    mu, c = s.friction_coefficient, s.limit_slope
    friction = mu * s.preload / (1.0 + 0.5 * mu * c) if reciprocal else mu * s.preload
    expected = -(s.load - friction) / s.tangential_damping
    fast = replace(s, tangential_damping=1e-5)
    assert searched.velocity == pytest.approx(expected, rel=1e-9)
    dragged = steady(fast, orbit(3e-9), tolerance=1e-8)
    assert "dragged" in dragged.message
    assert dragged.velocity == pytest.approx(-(s.load - friction) / 1e-5, rel=1e-12)


@pytest.mark.parametrize(("without", "why"), [("friction_coefficient", "friction force"), ("preload", "preload")])
@pytest.mark.parametrize("backward", [False, True])
def test_without_friction_only_the_load_moves_the_slider_and_against_the_wave(without, why, backward):
    wave = orbit(3e-9)
    wave = replace(wave, tangential=-wave.tangential) if backward else wave
    found = steady(slider(load=1e-4, tangential_damping=1e-3, **{without: 0.0}), wave, tolerance=1e-6)
    assert found.velocity == pytest.approx(0.1 if backward else -0.1, rel=1e-12)
    assert found.message == f"no {why}: closed form"


@pytest.mark.parametrize("name", ["normal_damping", "tangential_damping"])
def test_dampers_that_act_within_a_radian_of_the_wave_are_followed(name):
    found = steady(slider(**{name: 1e6}), orbit(3e-9), tolerance=1e-6)
    assert (found.method, found.status) == ("exact", "ok")
    softer = steady(slider(**{name: 1e4}), orbit(3e-9), tolerance=1e-6)
    scale = 1.0 if name == "normal_damping" else 1e-2  # v = <Q>/R_t
    assert found.velocity == pytest.approx(scale * softer.velocity, rel=1e-4)


@pytest.mark.parametrize(
    "changed",
    [
        {"effective_modulus": 64e12, "tangential_modulus": 12e12},
        {"preload": 1e-6},
        {"mass": 1e-9},
        {"mass": 1.0},
        {"radius": 1.0},
        {"normal_damping": 1e3, "tangential_damping": 1e3},
        {"friction_coefficient": 5.0},
    ],
)
def test_extremes_are_answered_within_the_tolerance(changed):
    found = steady(slider(**changed), orbit(3e-9), tolerance=1e-6)
    assert found.status == "ok"
    assert abs(found.velocity) <= 2.0 * math.pi * 2.2e6 * 0.7 * 3e-9


@pytest.mark.parametrize(
    ("status", "method", "changed", "next_method"),
    [
        ("out of reach", "auto", {}, "averaged"),
        ("out of reach", "exact", {}, None),
        ("out of reach", "averaged", {}, "averaged"),
        ("unstable", "auto", {}, "long run"),
        ("unstable", "exact", {}, "long run"),
        ("unstable", "averaged", {}, "averaged"),
        ("out of reach", "auto", {"contact_damping": 1e5}, "long run"),
        ("out of reach", "auto", {"mass": 0.089e-8}, "long run"),
    ],
)
def test_the_method_after_shooting_depends_on_why_shooting_failed(monkeypatch, status, method, changed, next_method):
    def fails(with_status):
        def run(*arguments, **settings):
            raise ConvergenceError(with_status, "no result")

        return run

    monkeypatch.setattr("contact.answers.steady.quick_periodic", lambda balance, tolerance: None)
    monkeypatch.setattr("contact.answers.steady.fine_periodic", fails(status))
    monkeypatch.setattr("contact.answers.steady.long_run", fails("long run"))
    if next_method == "averaged":
        answer = steady(slider(**changed), orbit(3e-9), tolerance=1e-3, method=method)
        assert answer.method == "averaged"
        assert ("full motion was not found" in answer.message) == (method == "auto")
    else:
        with pytest.raises(ConvergenceError) as failure:
            steady(slider(**changed), orbit(3e-9), tolerance=1e-3, method=method)
        assert failure.value.status == (next_method or status)


OMEGA = 2.0 * np.pi * 400.0
FRICTION = COEFFICIENT * PRELOAD


@pytest.mark.parametrize(
    ("changed", "amplitude", "ratio"),
    [
        # each force alone, a tenth below and above half of what the contact bears
        (lambda share: {"load": share * FRICTION}, 3e-9, 0.7),
        (lambda share: {"tangential_damping": share * FRICTION / (OMEGA * 2.1e-9)}, 3e-9, 0.7),
        (lambda share: {"normal_damping": share * PRELOAD / (OMEGA * 3e-9)}, 3e-9, 1e-3),
        (lambda share: {"mass": share * FRICTION / (OMEGA**2 * 2.1e-9), "tangential_damping": 0.0}, 3e-9, 0.7),
        (lambda share: {"mass": share * PRELOAD / (OMEGA**2 * 3e-9), "normal_damping": 0.0}, 3e-9, 1e-6),
    ],
    ids=["load", "damper", "normal damper", "inertia along x", "inertia along z"],
)
def test_a_slider_is_carried_while_each_force_is_half_of_what_the_contact_bears(changed, amplitude, ratio):
    """The limits are those of a contact at rest: mu P along x, P along z;."""
    wave = (orbit(amplitude, ratio=ratio, frequency=400.0),)
    stiff = {"effective_modulus": 64e13, "tangential_modulus": 12e13}  # resonances 20 times higher
    for share, carried in ((0.45, True), (0.55, False)):
        body = slider(**(stiff | changed(share)))
        assert min(body.normal_resonance(1), body.tangential_resonance(1)) > 20 * 400.0
        assert (closed_form(body, wave) is not None) == carried


def test_only_equal_contacts_of_one_height_under_a_slow_wave_are_carried():
    wave, faster = orbit(3e-9, frequency=380.0), orbit(3e-9, frequency=390.0)
    limit = min(slider().normal_resonance(1), slider().tangential_resonance(1)) / 20
    assert 380.0 < limit < 390.0
    assert closed_form(slider(), (wave,))["why"].startswith("carried along")
    assert closed_form(slider(), (wave, wave)) is not None
    assert closed_form(slider(), (faster,)) is None
    assert closed_form(slider(), (wave, wave.scaled(1.1))) is None
    assert closed_form(slider(heights=(0.0, 1e-10)), (wave, wave)) is None
    assert closed_form(slider(law="hysteretic"), (wave,)) is None
