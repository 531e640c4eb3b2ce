"""One steady state, asked for through every door: the same velocity, error and regime; wide brackets; honest edges."""

import math
from functools import cache

import numpy as np
import pytest

from contact import ConvergenceError, Orbit, mean_motion, steady, steady_sweep, threshold_factor
from contact.error_estimate import reference_speed
from tests.contact.motors import FREQUENCY, orbit, slider, steady_map
from tests.seed_motor import FRICTION as COEFFICIENT
from tests.seed_motor import MASS, PRELOAD

FRICTION = COEFFICIENT * PRELOAD


@cache
def edge():
    """Return the threshold amplitude in m; a function, so that collecting the tests compiles nothing."""
    return threshold_factor(slider(), orbit(1.0))


def doors(s, wave):
    """Return (velocity, relative error, regime, held) by each averaged entry point."""
    one = mean_motion(s, wave)
    many = steady_sweep([s], [(wave,)], which=[(0, 0)], factors=[1.0], wave_errors=[0.0], threads=1)
    grid = steady_map(s, wave, factors=[1.0], preloads=[s.preload])
    full = steady(s, wave, tolerance=1e-3, method="averaged")
    return [
        (one.velocity, one.relative_error, one.regime),
        (many.velocity[0], many.relative_error[0], many.regime[0]),
        (grid.velocity[0, 0], grid.relative_error[0, 0], grid.regime[0, 0]),
        (full.velocity, full.relative_error, full.regime),
    ]


@pytest.mark.parametrize(
    ("changed", "wave"),
    [
        ({}, orbit(5e-9)),
        ({}, orbit(5e-9).mirrored()),
        ({}, lambda: orbit((1.0 - 1e-6) * edge())),
        ({}, lambda: orbit((1.0 + 1e-6) * edge())),
        ({"load": 0.4 * FRICTION}, orbit(5e-9)),
        ({"load": 0.9 * FRICTION}, orbit(3e-9)),
        ({"load": 0.5 * FRICTION}, Orbit(frequency=FREQUENCY, normal=8e-9, tangential=0.0)),
        ({"load": 0.3 * FRICTION}, Orbit(frequency=FREQUENCY, normal=6e-9, tangential=2e-9 * np.exp(-0.2j))),
        ({}, orbit(0.0)),
    ],
)
def test_every_door_gives_the_same_steady_state(changed, wave):
    s, wave = slider(**changed), wave() if callable(wave) else wave
    found = doors(s, wave)
    velocity, error, regime = found[0]
    for each in found:  # one equilibrium; the last digit of an error depends on the order of its sum
        assert each[0] == velocity
        assert each[1] == pytest.approx(error, rel=1e-12, abs=0)
        assert each[2] == regime
    # Oracle: the periodic motion of the full equations, which shares neither bracket nor means with them
    full = steady(s, wave, tolerance=1e-6)
    scale = reference_speed(full.velocity, (wave,)) or 1.0
    assert abs(full.velocity - found[0][0]) <= (2.0 * (found[0][1] + full.relative_error) + 1e-9) * scale
    if full.method == "averaged" or wave.normal == 0.0:  # held, or a closed form
        assert (full.velocity, full.regime) == (velocity, regime)
        assert full.relative_error == pytest.approx(error, rel=1e-12, abs=0)


def test_a_bouncing_slider_without_tangential_motion_yields_to_a_load():
    # nothing is forgotten but at release: x = -v t in each contact, so a load always moves it (Property), and twice the
    # load more than twice as fast, for the spring softens
    wave = Orbit(frequency=FREQUENCY, normal=8e-9, tangential=0.0)
    speeds = [mean_motion(slider(load=k * FRICTION, tangential_damping=0.0), wave).velocity for k in (0.1, 0.2, 0.4)]
    assert speeds[0] < 0.0
    assert speeds[1] < 2.0 * speeds[0]
    assert speeds[2] < 2.0 * speeds[1]
    full = steady(slider(load=0.2 * FRICTION, tangential_damping=0.0), wave, tolerance=1e-6)
    assert full.velocity == pytest.approx(speeds[1], rel=1e-6)


def test_a_damper_that_vanishes_leaves_the_velocity():
    # Limit: slip is possible up to |u_x| + c |u_z|, far above u_x here
    wave = Orbit(frequency=FREQUENCY, normal=8e-9, tangential=-0.08e-9j)
    free, damped = (
        steady(slider(load=0.7 * FRICTION, tangential_damping=d), wave, tolerance=1e-6).velocity for d in (0.0, 1e-9)
    )
    assert free < -wave.omega * abs(wave.tangential)
    assert free == pytest.approx(damped, rel=1e-4)


@pytest.mark.parametrize("law", ["elastic", "hysteretic"])
def test_the_bracket_of_every_law_reaches_to_full_slip(law):
    wave = Orbit(frequency=FREQUENCY, normal=8e-9, tangential=-0.08e-9j)
    found = steady(slider(load=0.7 * FRICTION, tangential_damping=0.0, law=law), wave, tolerance=1e-3)
    top = wave.omega * (abs(wave.tangential) + slider().limit_slope * abs(wave.normal))
    assert -top < found.velocity < -0.1 * top


def test_beyond_full_slip_the_damper_alone_bounds_the_speed():
    s = slider(load=1.2 * FRICTION)
    found = mean_motion(s, orbit(1e-9))
    assert found.velocity == pytest.approx(-0.2 * FRICTION / s.tangential_damping, rel=1e-9)
    with pytest.raises(ConvergenceError, match="no tangential damping"):
        mean_motion(slider(load=1.2 * FRICTION, tangential_damping=0.0), orbit(1e-9))


def test_close_to_the_threshold_the_error_is_what_lies_beyond():
    below, far = (mean_motion(slider(), orbit((1.0 - 1e-6) * edge())), mean_motion(slider(), orbit(0.9 * edge())))
    assert (below.velocity, far.velocity, far.relative_error) == (0.0, 0.0, 0.0)
    # the amplitude larger by the averaging error of the threshold moves
    ratio = slider().normal_resonance(1) / FREQUENCY
    beyond = mean_motion(slider(), orbit((1.0 - 1e-6) * edge() * (1.0 + 12.0 * ratio**2)))
    assert below.relative_error > 1e-5
    error = below.relative_error * reference_speed(0.0, (orbit((1.0 - 1e-6) * edge()),))
    assert error == pytest.approx(beyond.first_order, rel=1e-6)


@pytest.mark.parametrize("ratio", [0.2, 0.28])
def test_a_stiff_contact_is_not_called_held_near_its_threshold(ratio):
    frequency = slider().normal_resonance(1) / ratio
    s = slider(normal_damping=0.05 * MASS * 2.0 * math.pi * slider().normal_resonance(1), tangential_damping=0.0)
    wave = Orbit(frequency=frequency, normal=0.999 * edge(), tangential=-0.7j * 0.999 * edge())
    with pytest.raises(ConvergenceError, match="near the threshold"):
        mean_motion(s, wave)
    full = steady(s, wave, tolerance=1e-6)
    assert full.method == "exact"
    assert abs(full.velocity) > 1e-3 * reference_speed(0.0, (wave,))
