"""Friction that depends on slip speed and pressure, by all three methods."""

import math

import numpy as np
import pytest

from contact import FallingFriction, blocked_thrust, burst, mean_motion, steady, threshold_factor
from contact.exceptions import InputError
from tests.contact.motors import friction_motor, orbit, slider
from tests.frozen import frozen
from tests.oracles.contact_friction import follow

SPEED = FallingFriction(sliding=0.15, speed=0.05)
PRESSURE = FallingFriction(high_pressure=0.1, pressure=5e7)
BOTH = FallingFriction(sliding=0.15, speed=0.02, high_pressure=0.4, pressure=5e7)
# the same as functions of pressure and speed, static coefficient 0.3
COEFFICIENTS = {
    SPEED: lambda p, w: 0.15 + 0.15 * math.exp(-w / 0.05),
    PRESSURE: lambda p, w: 0.1 + 0.2 / (1.0 + p / 5e7),
    BOTH: lambda p, w: (0.4 - 0.1 / (1.0 + p / 5e7)) * (0.5 + 0.5 * math.exp(-w / 0.02)),
}


FRICTIONS, SHAPES = {"speed": SPEED, "pressure": PRESSURE, "both": BOTH}, ["sphere", "punch"]


def motor(friction, shape="sphere"):
    return friction_motor(friction, COEFFICIENTS.get(friction), shape)


# Oracle: DOP853 between events, which is good to some 1e-7 where the sphere's force has a root
@frozen([(name, shape) for name in FRICTIONS for shape in SHAPES])
def followed(name, shape):
    """Velocity in m/s after six cycles from rest, and the work of the wave along z and x in J."""
    _, _, same = motor(FRICTIONS[name], shape)
    state, _, normal, tangential, _ = follow(same, 6)
    return np.array([state[2], normal, tangential])


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", FRICTIONS)
def test_the_motion_is_that_of_an_independent_integrator(name, shape):
    s, waves, _ = motor(FRICTIONS[name], shape)
    velocity, normal, tangential = followed(name, shape)
    exact = burst(s, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-9, samples=6, method="exact")
    near = 1e-6 if shape == "sphere" else 1e-8
    assert exact.velocity_at_burst_end == pytest.approx(velocity, rel=near)
    assert exact.ledger.wave_tangential == pytest.approx(tangential, rel=near)
    assert exact.ledger.wave_normal == pytest.approx(normal, rel=1e-5)
    assert exact.ledger.relative_residual < 1e-9
    coulomb, *_ = motor(None, shape)
    plain = burst(coulomb, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-9, samples=6, method="exact")
    assert abs(plain.velocity_at_burst_end / velocity - 1.0) > 0.02  # the friction matters here
    stepped = burst(s, waves, duration=6 / 2.2e6, after=0.0, tolerance=1e-5, samples=6, method="stepped")
    reference = 2.2e6 * 2.0 * math.pi * 2.8e-9 / 10.0
    apart = abs(stepped.velocity_at_burst_end - velocity)
    assert apart < 2.0 * stepped.relative_error * reference + near * velocity
    assert stepped.relative_error < 1e-5


@pytest.mark.parametrize("shape", ["sphere", "punch"])
@pytest.mark.parametrize("friction", [SPEED, PRESSURE, BOTH], ids=["speed", "pressure", "both"])
def test_averaged_and_exact_steady_states_agree_and_the_energy_closes(friction, shape):
    s, waves, _ = motor(friction, shape)
    exact, mean = steady(s, waves, tolerance=1e-6), mean_motion(s, waves)
    assert exact.method == "exact"
    reference = max(abs(exact.velocity), 2.2e6 * 2.0 * math.pi * 2.8e-9 / 10.0)
    assert abs(mean.velocity - exact.velocity) < 2.0 * (mean.relative_error + exact.relative_error) * reference
    assert mean.relative_error < 1e-6
    assert exact.ledger.relative_residual < 1e-8
    assert exact.ledger.slip > 0.0
    if shape == "punch":  # its spring does not care for the approach: nothing leaks, whatever the friction
        assert abs(exact.ledger.leak) < 1e-12 * exact.ledger.wave


@pytest.mark.slow  # two more kernels; test_user_law.py has them for another law
def test_long_bursts_agree_within_their_errors():
    s, waves, _ = motor(BOTH)
    runs = [
        burst(s, waves, duration=2000 / 2.2e6, after=0.0, tolerance=1e-4, samples=4, method=method)
        for method in ("exact", "stepped", "averaged")
    ]
    reference = max(abs(runs[0].velocity_at_burst_end), 2.2e6 * 2.0 * math.pi * 2.8e-9 / 10.0)
    for run in runs[1:]:
        apart = abs(run.velocity_at_burst_end - runs[0].velocity_at_burst_end) / reference
        assert apart < 2.0 * (run.relative_error + runs[0].relative_error)
        assert run.relative_error < 1e-3


# Property: what sticks does not know how friction falls with speed
def test_the_threshold_is_that_of_the_static_coefficient():
    speed, plain = (slider(friction_coefficient=0.3, friction=each) for each in (SPEED, None))
    assert threshold_factor(speed, orbit(1e-9)) == pytest.approx(threshold_factor(plain, orbit(1e-9)), rel=1e-12)
    # and a pressure that changes nothing is no pressure
    same = slider(friction_coefficient=0.3, friction=FallingFriction(high_pressure=0.3, pressure=1e7))
    assert threshold_factor(same, orbit(1e-9)) == pytest.approx(threshold_factor(plain, orbit(1e-9)), rel=2e-5)


# Limit: at full slip, far above the speed, only the sliding coefficient is left, and the blocked thrust falls
def test_fast_slip_knows_the_sliding_coefficient_alone():
    fast = FallingFriction(sliding=0.15, speed=1e-9)
    s, wave = slider(friction_coefficient=0.15 + 1e-12, friction=fast), orbit(8e-9)
    assert steady(s, wave, tolerance=1e-6).velocity == pytest.approx(
        steady(slider(friction_coefficient=0.15), wave, tolerance=1e-6).velocity, rel=1e-8
    )
    falls, plain = (slider(friction_coefficient=0.3, friction=each) for each in (SPEED, None))
    assert 0.5 < blocked_thrust(falls, wave)[0] / blocked_thrust(plain, wave)[0] < 0.98


# Closed form: a slider that the load drags along a surface at rest, load = mu(v) P + R_t v
def test_a_dragged_slider_slides_where_friction_and_damper_carry_the_load():
    s = slider(friction_coefficient=0.3, friction=SPEED, load=4e-4, tangential_damping=1e-3)
    v = abs(steady(s, orbit(0.0), tolerance=1e-6).velocity)
    assert 0.1 < v < 0.4
    assert (0.15 + 0.15 * math.exp(-v / 0.05)) * s.preload + 1e-3 * v == pytest.approx(4e-4, rel=1e-12)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"friction": SPEED, "stick_band": 0.1}, "slider.stick_band must be 0 with a friction that depends"),
        ({"friction": SPEED, "reciprocal": True}, "slider.reciprocal must be false with a friction"),
        ({"friction": SPEED, "law": "hysteretic"}, 'slider.law must be "elastic" with a friction'),
        ({"friction": SPEED, "friction_coefficient": 0.0}, "slider.friction_coefficient must be positive"),
        ({"law": "no/such/file.py"}, "slider.law names no/such/file.py, which cannot be read"),
        ({"law": "lawful"}, "slider.law must be one of"),
    ],
)  # fmt: skip
def test_what_does_not_go_together_is_refused(given, sentence):
    with pytest.raises(InputError, match=sentence):
        slider(**given)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({}, "friction needs sliding with speed, or high_pressure with pressure"),
        ({"sliding": 0.1}, "friction.speed is required and missing: sliding is given"),
        ({"sliding": 0.1, "speed": 0.0}, "friction.speed must be positive and finite, got 0.0 m/s"),
    ],
)
def test_half_a_friction_is_refused(given, sentence):
    with pytest.raises(InputError, match=sentence):
        FallingFriction(**given)
