"""The small-step witness of the contact is itself tested: rest, conservation, order."""

import math

import numpy as np
import pytest

from tests.oracles.contact_steps import parameters, rest_height, run, steady_velocity, velocity_from_rest


def test_without_a_wave_a_slider_at_rest_stays():
    p = parameters()
    (z, w, v, x), regime, _, mean = run(0.0, p, (-rest_height(p), 0.0, 0.0, 0.0), 1, 1.0, 0.0, 4000, 400)
    assert z == pytest.approx(-rest_height(p), rel=1e-14)
    assert abs(w) < 1e-17
    assert (v, x, regime, mean) == (0.0, 0.0, 1, 0.0)


def test_a_sliding_slider_is_slowed_by_mu_g():
    p = parameters(tangential_damping=0.0)
    y, regime, _, _ = run(0.0, p, (-rest_height(p), 0.0, 0.01, 0.0), 2, -1.0, 0.0, 40000, 400)
    assert regime == 2
    assert (0.01 - y[2]) / (100 / 2.2e6) == pytest.approx(0.08 * 9.81, rel=1e-10)  # rounding of v


def test_an_undamped_bounce_keeps_its_energy():
    p = parameters(normal_damping=0.0)
    K, m, F = 4.0 / 3.0 * 64e9 * math.sqrt(1e-3), p[1], p[2]

    def energy(y):
        return 0.4 * K * max(-y[0], 0.0) ** 2.5 + 0.5 * m * y[1] ** 2 + F * y[0]

    begin = (-3.0 * rest_height(p), 0.0, 0.0, 0.0)
    end = run(0.0, p, begin, 1, 1.0, 0.0, 40000, 100)[0]
    assert energy(end) == pytest.approx(energy(begin), rel=1e-9)


@pytest.mark.parametrize("A", [3e-9, 10e-9])
def test_it_converges_as_its_events_allow(A):
    # Order 2.5 with a phase that depends on where the events fall in the step: averaged over eight-fold refinements
    v = [velocity_from_rest(A, 20, n) for n in (50, 400, 3200)]
    assert np.log(abs(v[0] - v[2]) / abs(v[1] - v[2])) / np.log(8.0) > 1.8
    assert v[1] == pytest.approx(v[2], rel=3e-6)


def test_steady_velocity_is_where_a_long_run_ends():
    # Light slider and strong damper, so that rest is forgotten within 1500 cycles
    light = {"mass": 2e-6, "preload": 2e-4, "normal_damping": 0.2, "tangential_damping": 3e-3}
    p = parameters(**light)
    y, *_, mean = run(3e-9, p, (-rest_height(p), 0.0, 0.0, 0.0), 1, 1.0, 0.0, 14000 * 100, 100)
    y, *_, mean = run(3e-9, p, (*y[:3], 0.0), 0, 1.0, 0.0, 5 * 100, 100)
    assert steady_velocity(3e-9, 100, **light) == pytest.approx(mean, rel=1e-4)  # 100 steps per cycle
