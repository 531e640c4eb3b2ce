"""The integrator of a ball that holds on: the loss of a hop in closed form, and the energy of its own motion."""

import math

import numpy as np
import pytest

from tests.oracles.contact_hold import NORMAL_LOSS, SLIP_LOSS, TRAVEL, DugdaleBall, HoldingBall, Integration

BALL = {
    "radius": 1e-3, "modulus": 64e9, "tangential_modulus": 12e9, "work": 0.05, "mu": 0.08, "preload": 0.87309e-3,
    "frequency": 2.2e6, "normal": 10e-9, "tangential": -6.7e-9j,
}  # fmt: skip


def test_the_work_of_a_heavy_ball_s_hop_is_that_of_both_branches():
    """3.008e-13 J at 0.05 J/m^2 (`rough.md`), the integral of P dz between both ends in closed form."""
    run = Integration(HoldingBall(mass=1e3, **BALL), (-1e-9, 0.0, 0.02, 0.0), closed=True)
    run.until(4.0 * math.pi)
    start = run.energies[0]
    run.until(6.0 * math.pi)
    assert run.hops == 3
    ball = run.ball
    first, last = ((each * ball.root * ball.radius) ** (1.0 / 3.0) for each in (1.0, 0.25))
    y = np.linspace(last, first, 20_001)
    force = ball.normal_force(y) * ball.approach_slope(y)
    assert run.energies[0] - start == pytest.approx(-np.trapezoid(force, y), rel=1e-7)
    assert run.energies[0] - start == pytest.approx(3.008e-13, rel=3e-4)


@pytest.mark.parametrize("work", [0.02, 0.1])
def test_the_energies_of_a_cycle_balance(work):
    """Work of the surface less all losses, of a slider that rides closed: what is stored, kinetic energy and leak."""
    own = BALL | {"work": work, "normal": 2e-9, "tangential": 0.0}
    ball = HoldingBall(mass=89e-6, normal_damping=0.5, **own)
    run = Integration(ball, (-5.9e-9, 0.0, 0.0, 0.0), closed=True)

    def stored():
        height, rate, velocity, _ = run.state
        y = ball.place_at(run.surface(run.y[0])[0] - height)
        unit = np.linspace(y * 0.2, y, 200_001)
        potential = np.trapezoid(ball.normal_force(unit) * ball.approach_slope(unit), unit)
        return potential + ball.preload * height + 0.5 * ball.mass * (rate**2 + velocity**2)

    before = stored()
    low = 0.2 * ball.place_at(run.surface(0.0)[0] - run.state[0])
    run.until(2.0 * math.pi)
    after = stored()
    # the lower ends of both integrals differ
    high = 0.2 * ball.place_at(run.surface(run.y[0])[0] - run.state[0])
    y = np.linspace(low, high, 2001)
    after += np.trapezoid(ball.normal_force(y) * ball.approach_slope(y), y)
    wave_normal, wave_tangential, slip, damper = run.energies
    assert wave_tangential == slip == 0.0
    assert wave_normal == pytest.approx(after - before + damper, abs=1e-7 * abs(after - before) + 1e-22)
    assert run.y[TRAVEL] == 0.0
    assert NORMAL_LOSS == SLIP_LOSS + 1


@pytest.mark.parametrize("separation", [3e-10, 1.3e-9, 3e-9])
def test_a_heavy_ball_of_finite_range_loses_the_work_of_both_branches(separation):
    """2.431e-13 J at 0.3 nm, 0 where it closes and opens as a point; by the trapezoidal rule over y."""
    run = Integration(DugdaleBall(mass=1e3, separation=separation, **BALL), (-1e-9, 0.0, 0.02, 0.0), closed=True)
    run.until(4.0 * math.pi)
    start = run.energies[0]
    run.until(6.0 * math.pi)
    assert run.hops == 3
    ball = run.ball
    y = np.linspace(ball.last, ball.first, 4001)
    force = np.array([ball.normal_force(each) * ball.approach_slope(each) for each in y])
    assert run.energies[0] - start == pytest.approx(-np.trapezoid(force, y), rel=1e-6, abs=1e-20)
    if separation == 3e-10:
        assert run.energies[0] - start == pytest.approx(2.431e-13, rel=3e-4)
