"""Load lines: stall, drag, efficiency, three balls."""

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, blocked_thrust, load_line, mean_motion, steady
from tests.contact.motors import orbit, slider


@pytest.mark.parametrize("A", [1e-9, 3e-9, 10e-9])
def test_the_motor_stalls_at_the_blocked_thrust(A):
    # Oracle: the full periodic motion a little below and above
    stall, held = blocked_thrust(slider(), orbit(A))
    assert 0.0 < stall <= held * (1.0 + 1e-12)
    assert steady(slider(load=stall * 0.999), orbit(A), tolerance=1e-4).velocity > 0.0
    assert steady(slider(load=held * 1.001), orbit(A), tolerance=1e-4).velocity < 0.0
    assert blocked_thrust(slider(), orbit(A).mirrored()) == pytest.approx((stall, held), rel=1e-9)


def test_crests_alone_give_full_friction():
    # Closed form: 20 nm touch at the crest, where the surface moves forward faster than the spring can follow
    stall, _ = blocked_thrust(slider(), orbit(40e-9, ratio=5.0))
    assert stall == pytest.approx(0.08 * slider().preload, rel=1e-9)


def test_line_power_and_efficiency():
    line = load_line(slider(), orbit(10e-9), points=5, tolerance=1e-4)
    assert line.load[-1] == line.blocked_thrust == blocked_thrust(slider(), orbit(10e-9))[0]
    assert np.all(np.diff(line.velocity) < 0.0)
    assert (line.velocity[-1], line.efficiency[0], line.efficiency[-1]) == (0.0, 0.0, 0.0)
    assert np.all(line.efficiency[1:-1] > 0.2)
    assert np.all(line.efficiency < 1.0)
    assert line.velocity[0] == pytest.approx(steady(slider(), orbit(10e-9), tolerance=1e-4).velocity, rel=1e-12)
    # Property: what the wave gives is friction, dampers, leak and useful work; the last is power
    state = steady(slider(load=float(line.load[2])), orbit(10e-9), tolerance=1e-4)
    assert line.power[2] == pytest.approx(state.ledger.load * 2.2e6, rel=1e-9)


def test_three_balls_in_phase_are_one():
    trio = (orbit(10e-9),) * 3
    n = 3
    one, three = slider(preload=1e-3 / n), slider(preload=1e-3)
    assert blocked_thrust(three, trio)[0] == pytest.approx(n * blocked_thrust(one, orbit(10e-9))[0], rel=1e-9)
    apart = tuple(orbit(10e-9).scaled(np.exp(-2j * np.pi * k / 7.0)) for k in range(3))
    # to a heavy slider the means of equal balls are the same wherever they stand on the wave
    assert blocked_thrust(three, apart)[0] == pytest.approx(blocked_thrust(three, trio)[0], rel=1e-9)


def test_no_line_below_the_threshold():
    with pytest.raises(ConvergenceError, match="threshold"):
        load_line(slider(), orbit(0.5e-9), points=3, tolerance=1e-3)


def test_a_wave_that_drives_against_its_crests():
    shape = Orbit(frequency=2.2e6, normal=6e-9, tangential=5e-9 * np.exp(0.2j))
    way = np.sign(mean_motion(slider(), shape).velocity)
    assert way != np.sign(shape.crest_velocity)
    stall, held = blocked_thrust(slider(), shape)
    assert 0.0 < stall <= held * (1.0 + 1e-12)
    for load, sign in ((0.0, 1.0), (0.4 * stall, 1.0), (0.999 * stall, 1.0), (1.001 * held, -1.0)):
        full = steady(slider(load=load), shape, tolerance=1e-4).velocity
        assert np.sign(full) == sign * way
        assert mean_motion(slider(load=load), shape).velocity == pytest.approx(full, rel=1e-6, abs=1e-9)
