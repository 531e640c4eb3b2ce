"""Impacts against Hertz's closed forms, in the manner of the first tests of Chung and Ooi (2011); friction that holds.

A slider without wave and almost without preload is a ball thrown at a wall; two equal balls head on are one ball of
half the mass and radius. Values: glass and aluminium alloy.
"""

import math

import numpy as np
import pytest
from scipy.special import gamma

from contact import steady, threshold_amplitude
from contact.averaged.event_equilibrium import balanced
from contact.codes import Event, WorkCount
from contact.events import energy
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.problem import scaled, without_wave
from tests.contact.motors import orbit, slider

PAIR = {
    "two spheres head on": (5e-3, 2800.0, 48e9, 0.2, 10e-3, 20.0),
    "sphere on a wall": (0.1, 2699.0, 70e9, 0.33, 0.1, 0.2),
}


def thrown(case, speed_t=0.0, **changed):
    """Return (slider, motion just above the wall, speed, largest approach by closed form)."""
    radius, density, young, poisson, ball, speed = PAIR[case]
    mass = 4.0 / 3.0 * math.pi * ball**3 * density * (0.5 if radius < ball else 1.0)
    modulus = young / (1.0 - poisson**2) / 2.0
    s = slider(
        radius=radius, mass=mass, preload=1e-12, effective_modulus=modulus, tangential_modulus=0.2 * modulus,
        normal_damping=0.0, tangential_damping=0.0, friction_coefficient=0.1, **changed,
    )  # fmt: skip
    deepest = (1.25 * mass * speed**2 / s.normal_stiffness) ** 0.4
    wave = orbit(deepest, frequency=speed / deepest / (2.0 * math.pi))  # sets the units, then is silent
    problem = without_wave(scaled(s, (wave,), direction=1.0, start=0.0))
    motion = Motion(problem, grid=collocation(16), truncation=1e-10)
    motion.set_state(1e-9, -speed / problem.speed, speed_t)
    return s, motion, speed, deepest


@pytest.mark.parametrize("law", ["elastic", "hysteretic"])
@pytest.mark.parametrize("case", PAIR)
def test_depth_duration_and_rebound_of_an_impact(case, law):
    _, motion, speed, deepest = thrown(case, law=law)
    at = np.linspace(0.0, 4.0, 40_001)[1:]
    samples = motion.move(0.0, 4.0, at)[:, 0]
    z, P = samples[:, 0] * motion.problem.length, samples[:, 2]
    assert np.max(z) == pytest.approx(deepest, rel=1e-6)  # nearest sample
    assert motion.state[1] * motion.problem.speed == pytest.approx(speed, rel=1e-9)
    # Closed form: 4 sqrt(pi) Gamma(0.4)/(5 Gamma(0.9)) deepest/speed = 2.943...
    duration = 4.0 * math.sqrt(math.pi) * gamma(0.4) / (5.0 * gamma(0.9))
    assert np.sum(P > 0.0) * 1e-4 == pytest.approx(duration, abs=2e-4)
    assert (motion.tally[Event.CONTACT], motion.tally[Event.RELEASE]) == (1, 1)


def test_the_gap_between_contact_and_release_is_the_duration():
    _, motion, *_ = thrown("sphere on a wall")
    motion.move(0.0, 4.0, np.empty(0))
    duration = 4.0 * math.sqrt(math.pi) * gamma(0.4) / (5.0 * gamma(0.9))
    assert 1.0 / motion.sums[energy.EnergySum.CROWDING] == pytest.approx(duration, rel=1e-8)


@pytest.mark.parametrize("law", ["elastic", "hysteretic"])
def test_gross_sliding_takes_mu_times_the_normal_momentum(law):
    # Closed form: slip throughout, so that the tangential momentum falls by mu 2 m v
    s, motion, speed, _ = thrown("sphere on a wall", speed_t=3.0, law=law)
    motion.move(0.0, 4.0, np.empty(0))
    lost = 3.0 - motion.state[2]
    assert lost == pytest.approx(2.0 * s.friction_coefficient * speed / motion.problem.speed, rel=1e-9)
    assert motion.tally[Event.SLIP_TO_STICK] == 0


@pytest.mark.parametrize("damping", [0.01, 0.3, 2.0, 30.0])
def test_restitution_of_a_ball_with_the_contact_damper(damping):
    # Closed form: m z' dz'/(1 + chi z') = -P dz, so that g(y) = y - ln(1 + y) of y = chi z' is the same on the way in
    # and out, whatever the spring (Hunt and Crossley 1975)
    from scipy.optimize import brentq

    _, _, speed, _ = thrown("sphere on a wall")
    _, motion, *_ = thrown("sphere on a wall", contact_damping=damping / speed)
    motion.move(0.0, 40.0, np.empty(0))
    left = damping - math.log1p(damping)
    out = brentq(lambda y: -y - math.log1p(-y) - left, 1e-12, 1.0 - 1e-15, xtol=1e-15)
    assert motion.state[1] * motion.problem.speed == pytest.approx(speed * out / damping, rel=1e-8)
    assert (motion.tally[Event.CONTACT], motion.tally[Event.RELEASE]) == (1, 1)


@pytest.mark.parametrize("over", [1e-9, 1e-3, 0.5, 40.0])
def test_the_stick_slip_valve_opens_and_closes_twice_a_cycle(over):
    # Published trap: slip that ends where its speed passes zero, and sticks or slips on by a hair. A surface that goes
    # to and fro by A = (1 + over) x_max under a body that does not move: the spring is stretched by 2 x_max, then slips
    # 2 (A - x_max) to the turning point. Closed form: loss 4 mu P (A - x_max) per cycle
    from contact import Orbit

    s = slider()
    x_max = s.limit_slope * s.rest_approach(1)
    wave = (Orbit(frequency=2.2e6, normal=0.0, tangential=(1.0 + over) * x_max),)
    problem = scaled(s, wave, direction=1.0, start=0.0)
    motion = Motion(problem, grid=collocation(16), truncation=1e-12)
    motion.set_state(-s.rest_approach(1) / problem.length, 0.0, 0.0, x_max / problem.length)
    motion.turn(1, mobile=False)
    motion.tally[:], motion.sums[:] = 0, 0.0
    cycles = 300
    motion.turn(cycles, mobile=False)
    kinds = (Event.STICK_TO_SLIP, Event.SLIP_TO_STICK, Event.REVERSAL, Event.CONTACT, WorkCount.CHATTER)
    assert [motion.tally[kind] for kind in kinds] == [2 * cycles, 2 * cycles, 2 * cycles, 0, 0]
    unit = s.mass * problem.speed**2
    lost = 4.0 * s.friction_coefficient * s.preload * over * x_max * cycles
    assert motion.sums[energy.EnergySum.SLIP_LOSS] * unit == pytest.approx(lost, rel=1e-9 + 1e-14 / over)


def test_the_stick_slip_valve_stays_shut_below_the_slip_limit():
    from contact import Orbit

    s = slider()
    x_max = s.limit_slope * s.rest_approach(1)
    wave = (Orbit(frequency=2.2e6, normal=0.0, tangential=(1.0 - 1e-9) * x_max),)
    problem = scaled(s, wave, direction=1.0, start=0.0)
    motion = Motion(problem, grid=collocation(16), truncation=1e-12)
    motion.set_state(-s.rest_approach(1) / problem.length, 0.0, 0.0, wave[0].tangential.real / problem.length)
    motion.turn(300, mobile=False)
    assert motion.tally[Event.STICK_TO_SLIP] == 0
    assert motion.sums[energy.EnergySum.SLIP_LOSS] == 0.0


def held(cycles):
    s = slider()
    wave = orbit(0.99 * threshold_amplitude(s, orbit(1e-9)))
    assert steady(s, wave, tolerance=1.0).regime == "stick"
    balance = balanced(s, (wave,))
    motion = Motion(balance.problem, grid=collocation(12), truncation=1e-10)
    motion.set_state(-balance.height, 0.0, 0.0, balance.motion.state[3:])
    motion.turn(cycles)
    return motion


@pytest.mark.parametrize("cycles", [5_000, pytest.param(1_000_000, marks=pytest.mark.slow)])
def test_held_just_below_the_threshold_nothing_ever_slips(cycles):
    motion = held(cycles)
    assert motion.tally[Event.STICK_TO_SLIP] == 0
    assert motion.sums[energy.EnergySum.SLIP_LOSS] == 0.0
    # slip displacement: what x does not account for; in stick x is the relative displacement itself
    assert motion.tally[WorkCount.CYCLES] == cycles
