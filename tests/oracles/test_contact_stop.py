"""The oracle without events is itself tested: rest, deceleration by friction, energy of a bounce, order, means."""

from dataclasses import replace

import numpy as np
import pytest

from tests.oracles.contact_steps import velocity_from_rest
from tests.oracles.contact_stop import MEAN_P, RATE, TRAVEL, Z_S, StopMotor, V, extrapolated
from tests.seed_motor import MASS, PRELOAD

BALL = StopMotor(
    mass=MASS, preload=PRELOAD, mu=0.08, frequency=2.2e6, normal=(4e-9,), tangential=(-2.8e-9j,), radii=(1e-3,),
    normal_damping=0.5, tangential_damping=1e-4,
)  # fmt: skip


def test_a_slider_at_rest_under_a_load_stays():
    loaded = replace(
        BALL, load=4e-5, radii=(1e-3, 3e-3), normal=(4e-9, 4e-9), tangential=(0.0, 0.0), heights=(0.0, 1e-9)
    )
    velocities, (_, y, _, _) = loaded.run(40, 200, silent=True)
    assert np.max(np.abs(velocities)) < 1e-13
    assert y[Z_S] == pytest.approx(-loaded.rest_height(), rel=1e-12)


def test_a_sliding_slider_is_slowed_by_mu_g():
    free = replace(BALL, tangential_damping=0.0)
    y = np.array([-free.rest_height(), 0.0, 0.01, *[0.0] * 4])
    velocities, (_, y, _, _) = free.run(100, 200, (0.0, y, np.array([-1.0]), np.zeros(1)), silent=True)
    assert (velocities[9] - velocities[99]) / (90 / 2.2e6) == pytest.approx(0.08 * 9.81, rel=1e-8)
    assert y[MEAN_P] == pytest.approx(PRELOAD, rel=1e-8)
    assert y[TRAVEL] == pytest.approx(100 / 2.2e6 * 0.5 * (0.01 + y[V]), rel=1e-6)


def test_an_undamped_bounce_keeps_its_energy():
    free = replace(BALL, normal_damping=0.0)
    begin = np.array([-3.0 * free.rest_height(), *[0.0] * 6])
    K, (_, y, _, _) = free.stiffness[0], free.run(400, 100, (0.0, begin, np.zeros(1), np.zeros(1)), silent=True)[1]
    energies = [0.4 * K * max(-z, 0.0) ** 2.5 + 0.5 * free.mass * w**2 + free.preload * z
                for z, w in ((begin[Z_S], 0.0), (y[Z_S], y[RATE]))]  # fmt: skip
    assert energies[1] == pytest.approx(energies[0], rel=1e-5)


def test_it_converges_to_the_velocity_of_the_oracle_with_events():
    truth = velocity_from_rest(4e-9, 60, 3200)
    for per_cycle, most in ((25, 1e-2), (100, 5e-4), (400, 3e-5)):
        assert 0.5 * most < abs(BALL.run(60, per_cycle)[1][1][V] - truth) / truth < most
    value, error = extrapolated(lambda n: BALL.run(60, n)[1][1][V], 500)
    assert abs(value - truth) < error + 1e-7 * truth < 1e-6 * truth


def test_mean_forces_of_a_frozen_slider_are_bounded_by_friction():
    height = BALL.height_under(lambda h: BALL.means(h, 0.0, 400)[0])
    slow, fast = (BALL.means(height, v, 400) for v in (0.01, 1.0))
    assert slow[0] == pytest.approx(PRELOAD, rel=1e-9)
    assert 0.0 < slow[1] < 0.08 * PRELOAD
    assert fast[1] == pytest.approx(-0.08 * PRELOAD, rel=1e-9)  # every contact slips backwards all the time
