"""Contacts with their own radius, weight and place in one averaged equilibrium, and the wave that balls load."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from contact import InputError, PassingWave, balls_of, mean_motion, pillar_motion, steady
from tests.contact.motors import FREQUENCY, orbit, slider
from tests.contact.test_each_contact import brute

WAVE = PassingWave(frequency=FREQUENCY, wavelength=1e-3, ratio=0.7, forward=3e-9, compliance=4.9e-12, strip_width=10e-3)


@pytest.mark.parametrize("changed", [{}, {"shape": "punch", "radius": 2e-5}])
def test_contacts_of_one_radius_in_phase_are_the_slider_of_equal_contacts(changed):
    # Twin: the compiled equilibrium of `mean_motion`
    body = slider(load=1e-5, **changed)
    old = mean_motion(body, (orbit(3e-9).mirrored(),) * 3)
    found = pillar_motion(balls_of(body, [0.0], weights=3.0), WAVE, load=body.load, loading=False)
    assert found.velocity == pytest.approx(float(old.first_order), rel=1e-9)
    assert found.velocity < 0.0
    apart = pillar_motion(balls_of(body, [-1e-3, 0.0, 2e-3]), WAVE, load=body.load, loading=False)
    assert apart.velocity == pytest.approx(found.velocity, rel=1e-12)


def test_one_ball_away_from_the_centre_moves_as_at_the_centre():
    centre, away = (pillar_motion(balls_of(slider(), [x], y=[x]), WAVE, loading=False) for x in (0.0, 3e-4))
    assert away.velocity == pytest.approx(centre.velocity, rel=1e-12)


def test_two_unequal_balls_balance_in_a_sum_written_by_hand():
    # Oracle: Hertz's force by adaptive quadrature, the tangential one by small steps of the stop operator
    radius, weights, heights, x = (0.5e-3, 4e-3), (3.0, 1.0), (0.6e-9, 0.0), np.array([0.0, 0.31e-3])
    body = slider(heights=heights)
    found = pillar_motion(balls_of(body, x, radius=radius, weights=weights), WAVE, loading=False)
    push = pull = 0.0
    for R, weight, height, place in zip(radius, weights, heights, x, strict=True):
        under = orbit(3e-9).mirrored().scaled(np.exp(-2j * np.pi * place / 1e-3))
        ball, h = slider(radius=R), found.approach + height
        K = 4.0 / 3.0 * ball.effective_modulus * np.sqrt(R)
        edge = np.arccos(np.clip(-h / 3e-9, -1.0, 1.0))
        whole, _ = quad(lambda phi, h=h: max(h + 3e-9 * np.cos(phi), 0.0) ** 1.5 * 1e13, 0.0, edge, epsrel=1e-10)
        push += weight * K * whole / 1e13 / np.pi
        pull += weight * brute(ball, under, h, found.velocity)[2]
    assert push == pytest.approx(body.preload, rel=1e-9)
    assert pull == pytest.approx(body.tangential_damping * found.velocity, abs=3e-4 * 0.08 * body.preload)
    # the answer is not that of equal balls
    equal = pillar_motion(balls_of(body, x, weights=weights), WAVE, loading=False)
    assert equal.approach < 0.9 * found.approach
    assert found.normal_force @ np.array(weights) == pytest.approx(body.preload, rel=1e-11)


def test_balls_that_load_the_wave_balance_its_power():
    body = slider(preload=0.02, mass=0.002)
    balls = balls_of(body, np.linspace(-2e-3, 2e-3, 5), radius=np.linspace(0.5e-3, 2e-3, 5))
    narrow = replace(WAVE, strip_width=2e-4)
    free, found = (pillar_motion(balls, narrow, loading=loading) for loading in (False, True))
    assert abs(found.ledger_residual) < 1e-11
    assert abs(found.exit_over_entry - 1.0) > 1e-2
    assert found.velocity != pytest.approx(free.velocity, rel=1e-3)
    held = pillar_motion(balls_of(slider(preload=0.5, mass=0.05), balls.x), narrow, loading=True)
    assert held.held
    assert abs(held.ledger_residual) < 1e-11
    # first order: what the unloaded forces radiate
    first = balls.weights * (free.first_normal - 0.7j * free.first_tangential)
    small = pillar_motion(balls, replace(WAVE, compliance=4.9e-17), loading=True)
    expected = 1j * 4.9e-17 / 10e-3 * np.sum(first * np.exp(2j * np.pi * balls.x / 1e-3)) / 3e-9
    assert small.exit_over_entry - 1.0 == pytest.approx(expected, rel=1e-4)


def test_balls_of_a_law_that_the_equilibrium_does_not_know_are_refused():
    with pytest.raises(InputError, match="must be"):
        balls_of(slider(law="hysteretic"), [0.0])
    with pytest.raises(InputError, match="radius"):
        balls_of(slider(), [0.0], radius=-1.0)
    with pytest.raises(InputError, match="must be one of 'sphere', 'punch'"):
        replace(balls_of(slider(), [0.0]), shape="cone")
    with pytest.raises(InputError, match="harmonics"):
        pillar_motion(balls_of(slider(), [0.0]), WAVE, loading="harmonics")


def losses(ball, under, h, velocity):
    """Return the mean powers in W of slip and of the surface on a ball, by 2e5 steps of the stop operator.

    It begins at its limit, as after a motion towards -x.
    """
    steps, turns = 100_000, 2
    phases = 2.0 * np.pi * np.arange(turns * steps + 1) / steps
    z = np.maximum(h + (under.normal * np.exp(1j * phases)).real, 0.0)
    u_x = (under.tangential * np.exp(1j * phases)).real
    way, xs, slid = u_x - velocity / under.omega * phases, np.empty(phases.size), np.empty(phases.size)
    x = ball.limit_slope * z[0]
    for k, (most, move) in enumerate(zip(ball.limit_slope * z, np.diff(way, prepend=way[0]), strict=True)):
        free, x = x + move, min(max(x + move, -most), most)
        xs[k], slid[k] = x, free - x
    inside = np.maximum(z - np.abs(xs) / ball.limit_slope, 0.0)
    pull = np.sign(xs) * ball.friction_coefficient * ball.normal_stiffness * (z**1.5 - inside**1.5)
    last = slice((turns - 1) * steps, None)
    push = ball.normal_stiffness * z**1.5
    u_z = (under.normal * np.exp(1j * phases)).real
    surface = sum(0.5 * (f[last][1:] + f[last][:-1]) @ np.diff(u[last]) for f, u in ((pull, u_x), (push, u_z)))
    return under.frequency * float(pull[last][1:] @ slid[last][1:]), under.frequency * float(surface)


@pytest.mark.parametrize("held", [True, False])
def test_the_friction_power_of_a_ball_is_what_it_loses_in_slip(held):
    """Oracle: small steps. The elastic law's spring is not conservative: its gain is no friction."""
    ball, turned = (
        slider(),
        replace(WAVE, ratio=0.7 * np.exp(0.0j if held else 0.2j), forward=0.55e-9 if held else 3e-9),
    )
    found = steady(replace(balls_of(ball, [0.0]), tangential_damping=0.0), turned, tolerance=1.0)
    assert (found.regime == "stick") == held
    rows, (under,) = found.loaded, turned.orbits_at(0.0)
    slip, surface = losses(ball, under, found.height, found.velocity)
    assert surface == pytest.approx(sum(rows.work), rel=2e-3, abs=1e-5 * rows.apparent_power)
    assert rows.friction_power == pytest.approx(slip, rel=2e-3, abs=1e-6 * rows.apparent_power)
    assert rows.leak_power == pytest.approx(surface - slip, rel=2e-3, abs=1e-5 * rows.apparent_power)
    assert abs(rows.ledger_residual) < 1e-12
    assert rows.friction_power >= 0.0
    if held:
        assert rows.leak_power < 0.0
