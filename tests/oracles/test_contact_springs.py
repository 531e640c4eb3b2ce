"""The row of springs is itself tested: Hertz, Cattaneo and Mindlin, and the published loss of a loop."""

import math

import numpy as np
import pytest

from tests.oracles.contact_springs import force_on_path, velocity_from_rest
from tests.seed_motor import BODY, DAMPERS

BALL = {"radius": 1e-3, "E": 64e9, "G": 12e9, "mu": 0.08}


def test_pressed_and_pushed_it_is_hertz_and_cattaneo_mindlin():
    z = 5e-9
    x_max = BALL["mu"] * BALL["E"] / (4.0 * BALL["G"]) * z
    x = np.linspace(0.0, 1.2 * x_max, 25)
    force = force_on_path(np.full(25, z), x, springs=4000, **BALL)
    hertz = 4.0 / 3.0 * BALL["E"] * math.sqrt(BALL["radius"]) * z**1.5
    mindlin = BALL["mu"] * hertz * (1.0 - np.maximum(1.0 - x / x_max, 0.0) ** 1.5)
    assert force[:, 0] == pytest.approx(hertz, rel=1e-6)
    assert force[:, 1] == pytest.approx(mindlin, abs=1e-5 * BALL["mu"] * hertz)


def test_a_loop_loses_what_mindlin_and_deresiewicz_say():
    z, q = 5e-9, 0.7
    hertz = 4.0 / 3.0 * BALL["E"] * math.sqrt(BALL["radius"]) * z**1.5
    end = BALL["mu"] * BALL["E"] / (4.0 * BALL["G"]) * z * (1.0 - (1.0 - q) ** (2.0 / 3.0))
    x = np.concatenate([np.linspace(0, end, 500), np.linspace(end, -end, 1001)[1:], np.linspace(-end, end, 1001)[1:]])
    Q = force_on_path(np.full(x.size, z), x, springs=2000, **BALL)[:, 1]
    loop = slice(499, None)
    work = np.trapezoid(Q[loop], x[loop])
    contact_radius = math.sqrt(BALL["radius"] * z)
    published = 0.9 * (BALL["mu"] * hertz) ** 2 / (contact_radius * BALL["G"])
    published *= 1.0 - (1.0 - q) ** (5 / 3) - 5.0 * q / 6.0 * (1.0 + (1.0 - q) ** (2 / 3))
    assert work == pytest.approx(published, rel=1e-4)


def test_finer_springs_and_steps_converge():
    slider = BALL | BODY | DAMPERS | {"load": 0.0, "chi": 0.0}
    v = [
        velocity_from_rest([-5e-9j], [-3.5e-9], 2.2e6, cycles=10, per_cycle=n, springs=n, slider=slider)
        for n in (100, 200, 1600)
    ]
    assert abs(v[1] - v[2]) < 0.6 * abs(v[0] - v[2])
    assert v[1] == pytest.approx(v[2], rel=2e-3)
