"""Averaged motion in the plane against two independent routes of other authors, symmetries and the scalar kernels."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

from contact import ConvergenceError, InputError, Orbit
from contact import mean_motion as mean_along_x
from contact import threshold_factor as threshold_along_x
from contact.plane import (
    PlaneWave,
    PlaneWaves,
    SurfaceWaves,
    drift_per_degree,
    mean_forces,
    mean_motion,
    spin_moment,
    stall,
    stall_curve,
    stall_torque,
    steady,
    threshold_factor,
    yaw_stability,
)
from contact.plane.averaged import ANSWER, FIRST, Averaged
from contact.plane.cycle import Extra
from contact.plane.disc_contacts import Sum
from tests.contact.plane_motors import MU, R_X, F, ball, beams
from tests.oracles.contact_plane import PlaneContact, cycle_means
from tests.oracles.line_cycle import velocity_error

X, Y = np.array([6e-3, -3e-3, -3e-3]), np.array([0.0, 5.19615e-3, -5.19615e-3])


# v_x, v_y in m/s and slip power in W, from an event-driven integrator with Radau's method and Gauss quadrature and from
# fixed-step return mapping with Richardson's extrapolation; they agree to 3e-8 of v
CASES = {
    "P1": (ball(), beams(10, 0), (0.0683658806, 0.0, 1.69626e-7)),
    "P1b": (ball(), beams(3, 0), (0.0121882625, 0.0, 4.056007e-7)),
    "P2": (ball(), beams(10, 10), (0.0743296047, 0.0743296047, 1.98006e-8)),
    "P3": (ball(), beams(10, 10, math.pi / 2), (0.0202250455, 0.0816736288, 2.583232e-6)),
    "P3m": (ball(), beams(10, 10, -math.pi / 2), (0.0816736288, 0.0202250455, 2.583232e-6)),
    "P5": (ball(), beams(10, 10, 0.0, (2.2e6, 2.3e6)), (0.06470998, 0.06670011, 1.264341e-6)),
    "P7, 0.01": (ball(load=(0, 0.01 * MU * F)), beams(10, 0), (0.0683653023, -8.2248723e-5, 1.69708e-7)),
    "P7, 0.2": (ball(load=(0, 0.2 * MU * F)), beams(10, 0), (0.0681188558, -1.7441887e-3, 2.05871e-7)),
    "P7, 0.5": (ball(load=(0, 0.5 * MU * F)), beams(10, 0), (0.0666775340, -5.5188554e-3, 4.64264e-7)),
    "P10": (ball(shape="punch", radius=2e-6), beams(10, 10, math.pi / 2), (0.0202966810, 0.0801294384, 2.853338e-6)),
}


@pytest.mark.parametrize("name", CASES)
def test_one_ball_moves_as_two_other_integrators_say(name):
    slider, waves, (v_x, v_y, slip) = CASES[name]
    state = steady(slider, waves, tolerance=1e-7)
    speed = math.hypot(v_x, v_y)
    assert state.status == "ok"
    assert np.abs(state.velocity - (v_x, v_y)).max() < 1e-7 * speed
    assert state.slip_power == pytest.approx(slip, rel=2e-6)  # its digits in the table
    assert abs(state.powers.residual) < 1e-6 * state.power


def test_the_laws_own_loss_closes_the_balance_of_a_sphere_and_is_zero_for_a_punch():
    sphere, punch = (steady(*CASES[name][:2], tolerance=1e-7).powers for name in ("P3", "P10"))
    assert sphere.wave == pytest.approx(2.60069727e-6, rel=1e-7)
    assert sphere.law == pytest.approx(1.746506e-8, rel=1e-5)
    assert abs(punch.law) < 1e-15
    assert punch.slip == pytest.approx(2.85333774e-6, rel=1e-7)


@pytest.mark.parametrize("nm", [0.5, 0.8, 3.0, 10.0])
def test_along_one_line_it_is_the_scalar_motion(nm):
    along = Orbit(frequency=2.2e6, normal=nm * 1e-9, tangential=-1j * R_X * nm * 1e-9)
    scalar = mean_along_x(replace(ball(), freedom="x", load=0.0), along)
    plane = mean_motion(ball(), beams(nm, 0))
    assert plane.velocity[0] == pytest.approx(float(scalar.velocity), rel=5e-11, abs=1e-15)
    assert abs(plane.velocity[1]) < 1e-12
    assert plane.held == bool(scalar.held)


@pytest.mark.parametrize("nm", [2, 3, 5, 10, 20])
def test_along_one_line_it_is_the_zero_of_the_mean_friction_to_1e_12(nm):
    """By roots and quadrature apart from the product; the scalar motion, with 16 nodes, errs by 2e-11 at 3 nm."""
    slider = ball()
    given = dict(
        frequency=2.2e6, amplitude=nm * 1e-9, ratio=R_X, stiffness=float(slider.normal_stiffness),
        c=float(slider.limit_slope), preload=F,
    )  # fmt: skip
    speed = mean_motion(slider, beams(nm, 0)).velocity[0]
    turned = mean_motion(slider, beams(nm, 0).turned(0.7)).speed
    assert abs(velocity_error(speed, **given)) < 1e-12
    assert turned == pytest.approx(speed, rel=2e-12)
    along = Orbit(frequency=2.2e6, normal=nm * 1e-9, tangential=-1j * R_X * nm * 1e-9)
    scalar = float(mean_along_x(replace(slider, freedom="x", load=0.0), along).velocity)
    assert speed == pytest.approx(scalar, rel=1e-12 if nm >= 5 else 5e-11)


@pytest.mark.parametrize("angle", [0.3, 2.0, -1.1])
def test_a_turned_scene_has_the_turned_answer(angle):
    slider, waves, _ = CASES["P3"]
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    here, there = (mean_motion(slider, each).velocity for each in (waves, waves.turned(angle)))
    assert np.abs(there - turn @ here).max() < 1e-10


# v_x, v_y in m/s, yaw rate in rad/s, v_x with locked yaw
@pytest.mark.parametrize(
    ("slope", "expected"),
    [(0.2, (0.0642683813, -2.9628059e-4, -1.05647983, 0.0626530920)),
     (0.05, (0.0678147810, -7.9159e-6, -0.23243536, 0.0675120305))],
)  # fmt: skip
def test_three_balls_on_an_uneven_beam_turn(slope, expected):
    amplitudes = 10e-9 * (1.0 + slope * Y / 5.19615e-3)
    waves = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-1j * R_X * a, 0.0, a] for a in amplitudes]])
    body = ball(x=X, y=Y, preload=3 * F, tilt="free", freedom="xy yaw")
    state, locked = (mean_motion(replace(body, freedom=each), waves) for each in ("xy yaw", "xy"))
    assert np.abs(state.velocity - expected[:2]).max() < 1e-7 * expected[0]
    assert state.yaw_rate == pytest.approx(expected[2], rel=3e-7)  # the positions have six digits
    assert locked.velocity[0] == pytest.approx(expected[3], rel=1e-7)
    assert locked.yaw_rate == 0.0
    assert state.normal_loads == pytest.approx([F] * 3, rel=1e-10)


def ring(nm, **changes):
    """A dense ring of balls on two half-plane beams, towards -x for y > 0 and +x for y < 0.

    A quarter stands for all four; Gauss's rule in the angle gives positions and weights.
    """
    node, weight = np.polynomial.legendre.leggauss(96)
    angle, a = 0.25 * np.pi * (node + 1.0), nm * 1e-9
    x, y = 5.3e-3 * np.cos(angle), 5.3e-3 * np.sin(angle)
    rows = [[1j * R_X * a, 0.0, a]] * angle.size
    rotor = ball(x=x, y=y, weights=0.5 * weight, preload=F, freedom="axle", **changes)
    return rotor, SurfaceWaves(frequencies=[2.2e6], amplitudes=[rows])


@pytest.mark.parametrize(
    ("nm", "speed", "at_half", "force", "close"),
    [(3, 0.00409413550, 0.00197395, 3.12542911e-5, 3e-8), (10, 0.046385, 0.024705, 6.91668571e-5, 2e-5)],
)  # fmt: skip
def test_a_rotor_on_two_half_plane_beams(nm, speed, at_half, force, close):
    rotor, waves = ring(nm)
    torque = 5.3e-3 * 2 / math.pi * force
    assert steady(rotor, waves, tolerance=1e-6).yaw_rate * 5.3e-3 == pytest.approx(speed, rel=close)
    assert stall_torque(rotor, waves).value == pytest.approx(torque, rel=1e-6)
    half = steady(replace(rotor, torque=0.5 * torque), waves, tolerance=1e-6)
    assert half.yaw_rate * 5.3e-3 == pytest.approx(at_half, rel=2e-5)  # its digits in the table


def test_two_balls_each_on_its_own_beam_run_as_on_a_line():
    rotor = ball(x=[0.0, 0.0], y=[5.3e-3, -5.3e-3], preload=2 * F, freedom="axle")
    rows = [[[1j * R_X * 1e-8, 0.0, 1e-8], [-1j * R_X * 1e-8, 0.0, 1e-8]]]
    state = mean_motion(rotor, SurfaceWaves(frequencies=[2.2e6], amplitudes=rows))
    assert -state.yaw_rate * 5.3e-3 == pytest.approx(-0.0683658806, rel=1e-8)


def test_stall_is_a_curve_and_across_the_wave_there_is_no_threshold():
    waves = beams(10, 0)
    assert stall(ball(), waves, (1, 0)).value == pytest.approx(6.91668571e-5, rel=1e-7)
    assert abs(stall(ball(), waves, (0, 1)).value) < 1e-16
    curve = stall_curve(ball(), waves, points=8)
    assert curve.load == pytest.approx(-np.roll(curve.load, 4), abs=1e-12)  # the mirror image about y
    force = 1e-3 * MU * F
    across = -steady(ball(load=(0.0, force)), waves, tolerance=1e-7).velocity[1] / force
    assert across == pytest.approx(1.0 / 8.4940e-3, rel=1e-4)
    heavy = replace(ball(), mass=0.089e-3)
    assert drift_per_degree(heavy, waves, (0, 1)) == pytest.approx(across * 0.089e-3 * 9.81 * math.pi / 180, rel=1e-4)


def test_a_contact_that_never_slips_is_held_within_a_band():
    state = steady(ball(), beams(0.5, 0), tolerance=1e-6)
    assert state.held
    assert state.regimes == ("stick",)
    assert not state.velocity.any()
    assert state.band.least == pytest.approx(-state.band.largest, rel=1e-6)
    for share, held in ((0.99, True), (1.01, False)):
        pushed = steady(ball(load=(share * state.band.largest, 0.0)), beams(0.5, 0), tolerance=1)
        assert pushed.held == held


def test_the_band_of_a_slider_on_waves_that_cross_ends_where_it_moves():
    """A contact creeps to the force that resists most, and a load along a line may move the slider across it."""
    phases = np.exp(2j * np.pi * np.random.default_rng(3).random((2, 3)))
    x, y = 0.5e-9 * phases[0], 0.5e-9 * np.exp(1j) * phases[1]
    waves = SurfaceWaves(
        frequencies=[2.2e6], amplitudes=[np.stack([-1j * R_X * x, -1j * R_X * y, x + y], axis=-1)]
    )  # fmt: skip

    def loaded(size):
        return steady(ball(x=X, y=Y, preload=3 * F, load=(size, 0.0)), waves, tolerance=1e-3)

    band = loaded(1e-7).band
    assert loaded(0.99 * band.largest).held
    assert not loaded(1.01 * band.largest).held
    assert loaded(0.99 * band.least).held
    assert not loaded(1.01 * band.least).held


def test_a_held_contact_slips_only_where_friction_does_work():
    """A pushed ball that touches its limit sticks, as along x; one on a wave slips while one beside the wave holds."""
    pushed = steady(ball(load=(0.2 * MU * F, 0.0)), beams(0.3, 0), tolerance=1e-3)
    assert pushed.held
    assert pushed.regimes == ("stick",)
    pair = ball(x=(-1e-3, 1e-3), y=(0.0, 0.0), preload=2 * F)
    beside = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-1j * R_X * 1e-9, 0.0, 0.5e-9], [0.0, 0.0, 0.0]]])
    state = steady(pair, beside, tolerance=1e-3)
    assert state.held
    assert state.regimes == ("slip", "stick")


def test_coasting_without_a_wave_is_coulombs_friction():
    none = SurfaceWaves(frequencies=[2.2e6], amplitudes=np.zeros((1, 1, 3)))
    means = mean_forces(ball(), none, (0.03, -0.04))
    assert means.force == pytest.approx(MU * F * np.array([-0.6, 0.8]), rel=1e-12)


def test_yaw_is_stable_where_it_returns():
    beam = PlaneWave(frequency=2.2e6, wavelength=1.8e-3, direction=math.pi, normal=10e-9, ratio=R_X)

    class Narrow:  # a beam whose amplitude falls off beside its middle, y = 0
        def at(self, x, y):
            even = PlaneWaves(waves=(beam,)).at(x, y)
            return replace(even, amplitudes=even.amplitudes * (1.0 - 0.2 * (y / 5e-3) ** 2)[None, :, None])

    body = ball(x=X, y=Y, preload=3 * F, tilt="free", freedom="xy yaw")
    slope = yaw_stability(body, Narrow(), step=1e-4)
    rates = [
        mean_motion(replace(body, x=x, y=y), Narrow().at(x, y)).yaw_rate
        for x, y in ((X - psi * Y, Y + psi * X) for psi in (-1e-4, 1e-4))
    ]
    assert slope == pytest.approx((rates[1] - rates[0]) / 2e-4, rel=1e-6)
    assert yaw_stability(body, Narrow(), state=mean_motion(body, Narrow().at(X, Y))) == pytest.approx(slope, rel=1e-6)
    assert slope != 0.0


@pytest.mark.parametrize(("changes", "sentence"), [
    ({"freedom": "xy yaw"}, "slider.axis needs two contacts apart: one ball has no yaw stiffness"),
    ({"freedom": "xy yaw", "x": [0.0, 1e-3, 2e-3], "y": [0.0, 1e-3, 2e-3], "tilt": "free"},
     'three balls on a line do not fix the tilt: hold it with slider.tilt = "held"'),
    ({"law": "hysteretic"}, 'the hysteretic law has one direction: choose "elastic"'),
    ({"freedom": "xyz"}, "slider.freedom must be one of"),
    ({"load": 1e-6}, "slider.load must be a vector of two numbers in N"),
    ({"inertia": -1.0}, "slider.inertia must be positive and finite, got -1.0 kg m"),
    ({"reciprocal": True}, "slider.reciprocal must be false"),
])  # fmt: skip
def test_bad_input_gets_its_sentence(changes, sentence):
    with pytest.raises(InputError) as refused:
        ball(**changes)
    assert sentence in str(refused.value)


def test_a_slow_beat_is_not_averaged():
    heavy = replace(ball(), mass=0.089e-3)
    with pytest.raises(ConvergenceError, match=r"the beat of 5 kHz is slower than twice the contact resonance of 8.9"):
        steady(heavy, beams(10, 10, 0.0, (2.2e6, 2.205e6)), tolerance=1e-3)
    with pytest.raises(ConvergenceError, match=r"no common period of at most 400 cycles.* follow it through a burst"):
        steady(heavy, beams(10, 10, 0.0, (2.2e6, 2.205e6)), tolerance=1e-3, method="exact")


@pytest.mark.parametrize(("x_nm", "y_nm", "of_y", "friction"), [(3, 4, 2.25e6, 0.08), (7.4, 8.5, 2.24e6, 0.2)])
def test_the_bounce_at_the_beat_of_two_waves_is_in_the_stated_error(x_nm, y_nm, of_y, friction):
    slider = ball(mass=0.089e-3, normal_damping=0.5, friction_coefficient=friction)
    waves = beams(x_nm, y_nm, 0.0, (2.2e6, of_y))
    averaged, exact = steady(slider, waves, tolerance=1e-2), steady(slider, waves, tolerance=1e-4)
    assert (averaged.method, exact.method) == ("averaged", "exact")
    change = np.abs(averaged.velocity - exact.velocity)
    assert np.linalg.norm(change) < 2.0 * averaged.relative_error * averaged.reference
    assert np.all(change < 2.0 * averaged.error)
    assert np.linalg.norm(change) > 0.02 * averaged.relative_error * averaged.reference


def test_a_load_beyond_friction_runs_away_and_the_scalar_questions_refuse_the_plane():
    with pytest.raises(ConvergenceError, match="runaway"):
        steady(ball(load=(0.0, 1.1 * MU * F)), beams(10, 0), tolerance=1e-3)
    with pytest.raises(InputError, match=r"slider.freedom must be \"x\""):
        mean_along_x(ball(), Orbit(frequency=2.2e6, normal=1e-8, tangential=-6.7e-9j))


@pytest.mark.parametrize("share", [0.45, 0.55, 0.8])
def test_load_and_torque_together_run_away_where_one_of_two_balls_would_carry_more_than_its_friction(share):
    """Balls at (+-b, 0): a load F across them and a torque b F are the load F on one ball alone, half the limit."""
    b = 5e-3
    slider = ball(x=[b, -b], y=[0.0, 0.0], freedom="xy yaw", load=(0.0, share * MU * F), torque=share * MU * F * b)
    waves = beams(10, 0, contacts=2)
    if share < 0.5:
        state = steady(slider, waves, tolerance=1e-6)
        assert state.velocity[1] == pytest.approx(b * state.yaw_rate, rel=1e-6)  # the other ball runs along its wave
        assert state.velocity[1] < 0.0
        return
    with pytest.raises(ConvergenceError, match="runaway: load and torque together"):
        steady(slider, waves, tolerance=1e-6)


def test_a_damper_alone_limits_the_speed_under_a_load_beyond_friction():
    """Faster than the surface ever is, friction is mu N against the motion: V = -(F - mu N)/R."""
    waves = beams(10, 0)
    speed = 100.0 * waves.peak_speed
    slider = ball(load=(1.5 * MU * F, 0.0), tangential_damping=0.5 * MU * F / speed)
    state = steady(slider, waves, tolerance=1e-8)
    assert state.velocity == pytest.approx([-speed, 0.0], abs=1e-8 * speed)


@pytest.mark.parametrize(("share", "angle"), [(0.3, 3.0), (0.9, 2.0)])
def test_a_ball_that_flies_for_most_of_the_time_balances_a_pushing_load(share, angle):
    """Its friction hardly changes with velocity until it runs as fast as the surface at the touch."""
    slider = ball(load=share * MU * F * np.array([math.cos(angle), math.sin(angle)]))
    waves = beams(100, 0)
    state = steady(slider, waves, tolerance=1e-8)
    contact = PlaneContact(
        float(slider.normal_stiffness), MU, float(slider.limit_slope), (2.2e6,), waves.amplitudes[:, 0],
        float(state.heights[0]), tuple(state.velocity),
    )  # fmt: skip
    _, q_x, q_y, _ = cycle_means(contact, 1.0 / 2.2e6, 1e-9)
    assert [q_x, q_y] == pytest.approx(slider.load, abs=3e-7 * MU * F)


def test_the_spin_left_out_is_small():
    state = mean_motion(*CASES["P1b"][:2])
    moment = spin_moment(ball(), state)
    radius = math.sqrt(1e-3 * float(state.heights[0]))
    # Contensou's moment by the integral of mu p r over Hertz's pressure
    r = np.linspace(0.0, radius, 20001)
    pressure = 1.5 * F / (math.pi * radius**2) * np.sqrt(1.0 - (r / radius) ** 2)
    assert moment[0] == pytest.approx(MU * np.trapezoid(pressure * 2.0 * math.pi * r**2, r), rel=1e-5)
    assert moment[0] < 5e-4 * MU * F * 5.3e-3


@pytest.mark.parametrize("changes", [{}, {"load": (5e-6, 0.0)}], ids=["free", "pushed"])
def test_the_threshold_along_one_wave_is_that_of_the_scalar_law(changes):
    """Along one line the scalar solver's threshold, whose force of rest has a closed form."""
    slider = ball(**changes)
    line = replace(slider, freedom="x", load=slider.load[0])
    orbit = Orbit(frequency=2.2e6, normal=1e-9, tangential=-1j * R_X * 1e-9)
    expected = threshold_along_x(line, orbit)
    assert threshold_factor(slider, beams(1, 0)) == pytest.approx(expected, rel=6e-4)
    # the same wave and load turned
    turned_load = (0.0, slider.load[0])
    assert threshold_factor(replace(slider, load=turned_load), beams(1, 0).turned(np.pi / 2)) == pytest.approx(
        expected, rel=6e-4
    )


def rest_amplitude(slider, waves):
    """Return the factor at which one ball that carries no mean force meets its limit once in a period.

    Its deformation e + u(t) has the e for which the mean of Q = mu (P(z) - P(z - |e + u|/c)) vanishes.
    """
    k, c = float(slider.normal_stiffness), float(slider.contacts(1).limit_slope[0])
    phase = np.linspace(0.0, 1.0 / np.gcd.reduce(waves.frequencies.astype(int)), 2000, endpoint=False)
    turning = np.exp(2j * math.pi * waves.frequencies * phase[:, None])
    path = np.einsum("tw,wk->tk", turning, waves.amplitudes[:, 0]).real

    def margin(factor):
        u, lift = factor * path[:, :2], factor * path[:, 2]
        high = 3.0 * slider.rest_approach(1)
        height = brentq(lambda h: np.mean(k * (h + lift) ** 1.5) - F, -lift.min(), high, xtol=1e-20)
        z = height + lift

        def force(e):
            deformed = u + e * 1e-9
            size = np.hypot(*deformed.T)
            q = k * (z**1.5 - np.maximum(z - size / c, 0.0) ** 1.5)
            return (q[:, None] * deformed / size[:, None]).mean(axis=0) / F

        e = fsolve(force, np.zeros(2), xtol=1e-13)
        return float((np.hypot(*(u + e * 1e-9).T) / (c * z)).max()) - 1.0

    return brentq(margin, 0.05, 1.5, rtol=1e-6)


@pytest.mark.parametrize("frequencies", [(2.2e6,), (2.2e6, 4.4e6)])
def test_the_threshold_on_waves_that_cross_is_where_the_ball_meets_its_limit(frequencies):
    slider, waves = ball(), beams(1.0, 0.8, 1.1, frequencies)
    found, expected = threshold_factor(slider, waves), rest_amplitude(slider, waves)
    assert found == pytest.approx(expected, rel=1e-3)
    assert steady(slider, waves.scaled(0.99 * expected), tolerance=1e-6).regimes == ("stick",)
    assert not steady(slider, waves.scaled(1.02 * expected), tolerance=1e-6).held


def test_a_slider_turns_about_a_ball_beside_the_beam_that_carries_a_load_across():
    """Balls at (0, b), without a wave, and (0, -b): the second runs as if alone, the first holds the load."""
    b, wave = 5e-3, beams(3, 0).amplitudes
    waves = SurfaceWaves(frequencies=[2.2e6], amplitudes=np.concatenate([0.0 * wave, wave], axis=1))
    slider = ball(x=[0.0, 0.0], y=[b, -b], freedom="xy yaw", preload=2.0 * F, load=(0.0, 0.3 * MU * F))
    state = steady(slider, waves, tolerance=1e-8)
    alone = mean_motion(ball(preload=float(state.normal_loads[1])), beams(3, 0))
    assert state.regimes == ("stick", "slip")
    assert not state.held
    assert state.velocity == pytest.approx([0.5 * alone.velocity[0], 0.0], abs=1e-8 * alone.velocity[0])
    assert 2.0 * b * state.yaw_rate == pytest.approx(alone.velocity[0], rel=1e-8)
    assert state.force == pytest.approx(slider.load, abs=1e-8 * MU * F)
    pulled = steady(replace(slider, load=(0.0, 1.05 * MU * F)), waves, tolerance=1e-6)
    assert pulled.velocity[1] < 0.0
    assert "stick" not in pulled.regimes


def test_a_load_across_the_wave_lowers_the_threshold_and_full_friction_needs_none():
    limit = 0.08 * 0.87309e-3
    free, across = (threshold_factor(ball(load=(0.0, share * limit)), beams(1, 0)) for share in (0.0, 0.3))
    assert across < free
    assert threshold_factor(ball(load=(0.0, 1.01 * limit)), beams(1, 0)) == 0.0
    assert threshold_factor(ball(), beams(1, 0).scaled(0.0)) == np.inf
    state = steady(ball(load=(0.0, 0.3 * limit)), beams(1, 0).scaled(1.01 * across), tolerance=1e-6)
    assert state.velocity[1] < 0.0  # it yields to the force
    assert steady(ball(load=(0.0, 0.3 * limit)), beams(1, 0).scaled(0.99 * across), tolerance=1e-6).held


@pytest.mark.parametrize("flights", [False, True], ids=["short contacts", "short flights"])
def test_mean_loads_next_to_a_graze_are_those_of_quadrature(flights):
    """An approach whose extremum lies just beyond zero makes a contact, or a flight, of a fraction of a milliradian."""
    waves = SurfaceWaves(frequencies=[2.2e6, 2.3e6], amplitudes=[[[-6.7e-9j, 0, 10e-9]], [[0, -6.7e-9j, 9e-9j]]])
    averaged = Averaged.of(ball(), waves)
    problem = averaged.problem
    angle = problem.ratio * np.linspace(0.0, averaged.scaled.period, 100_000, endpoint=False)[:, None]
    u_z = np.cos(angle) @ problem.cos[:, 0, 2] + np.sin(angle) @ problem.sin[:, 0, 2]
    sign = -1.0 if flights else 1.0
    inner = sign * u_z[1:-1]
    extrema = np.sort(u_z[1:-1][(inner > sign * u_z[:-2]) & (inner > sign * u_z[2:])])
    for depth in np.geomspace(1e-6, 2e-3, 40):
        averaged.height = problem.height + extrema[len(extrema) // 2] - sign * depth
        means, repeats = averaged.contact_means(np.array([[0.05, 0.03]]))
        approach = problem.height - averaged.height + u_z
        load = float((problem.stiffness * np.mean(np.maximum(approach, 0.0) ** 1.5))[0])
        assert repeats
        assert means[0, Sum.NORMAL] == pytest.approx(load, rel=1e-6)


def uneven_three(nm):
    """Return a slider on three balls, and two waves of another phase at each ball: some contacts never open."""
    x, y = nm * 1e-9 * np.exp(2j * np.pi * np.random.default_rng(1).random((2, 3)))
    rows = np.stack([-1j * R_X * x, -1j * R_X * y, x + y], axis=-1)
    slider = ball(x=X, y=Y, preload=3 * F, freedom="xy yaw", tilt="free")
    return slider, SurfaceWaves(frequencies=[2.2e6], amplitudes=rows[None])


@pytest.mark.parametrize("nm", [3, 10], ids=["contacts that never open", "contacts that open too"])
def test_derivatives_of_the_mean_forces_are_their_differences(nm):
    """The variational equation against central differences of the same means, which it does not use."""
    averaged = Averaged.of(*uneven_three(nm))
    averaged.deformation = np.zeros((3, 2))
    at, step = np.array([0.12, 0.05, -0.02]), 1e-5
    slope = averaged.derivative(at, ANSWER)
    for k, along in enumerate(np.eye(3)):
        more, less = (averaged.residual(averaged.at(u, ANSWER), u) for u in (at + step * along, at - step * along))
        assert slope[:, k] == pytest.approx((more - less) / (2.0 * step), rel=1e-6, abs=1e-6 * np.abs(slope).max())


@pytest.mark.parametrize("share", [(0.318, 0.127), (0.208, 0.289), (0.128, 0.395), (0.414, -0.024)])
def test_coarse_means_do_not_end_a_slip_that_goes_on(share):
    """A coarse polynomial of lambda that fell below zero between its nodes ended slip 20 000 to 50 000 times a period.

    A stall of the slider of `twente-planar` then took 40 s. Truth: slips and forces of means with more nodes.
    """
    averaged = Averaged.of(ball(), beams(20, 20, 0.0, (2.2e6, 2.3e6)))
    unknown = np.append(averaged.top_speed * np.array(share), 0.0)
    coarse, fine = (averaged.at(unknown, how) for how in (FIRST[0], ANSWER))
    assert coarse.repeats
    assert coarse.contacts[0, Extra.SLIPS] <= fine.contacts[0, Extra.SLIPS] + 5
    assert coarse.force == pytest.approx(fine.force, abs=1e-3 * averaged.friction)
