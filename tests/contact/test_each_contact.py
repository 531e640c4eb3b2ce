"""Forces of each contact in the averaged steady state: means and first harmonics, in closed form and by brute force."""

from dataclasses import replace

import numpy as np
import pytest

from contact import mean_forces, mean_motion, riding_height
from tests.contact.motors import orbit, slider

PUNCH = slider(shape="punch", radius=2e-5)


def waves(*sizes):
    return tuple(orbit(3e-9).scaled(size * np.exp(1.3j * k)) for k, size in enumerate(sizes))


def brute(body, wave, h, velocity):
    """Return P_0, P_1, Q_0 and Q_1 of one contact by 2e4 steps of the stop operator through three cycles."""
    phases = 2.0 * np.pi * np.arange(3 * 20_000) / 20_000
    turn = np.exp(1j * phases)
    z = h + (wave.normal * turn).real
    way = (wave.tangential * turn).real - velocity / wave.omega * phases
    limit, x, xs = body.limit_slope * np.maximum(z, 0.0), 0.0, np.empty(phases.size)
    for k, (most, move) in enumerate(zip(limit, np.diff(way, prepend=way[0]), strict=True)):
        x = min(max(x + move, -most), most)
        xs[k] = x
    last = slice(2 * 20_000, None)
    power = 1.5 if body.shape == "sphere" else 1.0
    up = np.maximum(z, 0.0)
    push = body.normal_stiffness * up**power
    left = np.maximum(up - np.abs(xs) / body.limit_slope, 0.0)
    pull = np.sign(xs) * body.friction_coefficient * body.normal_stiffness * (up**power - left**power)
    first = 2.0 * turn[last].conj() / 20_000
    return push[last].mean(), push[last] @ first, pull[last].mean(), pull[last] @ first


def test_the_first_harmonic_of_a_punch_is_in_closed_form():
    wave = waves(1.0, 0.6)
    forces = mean_forces(PUNCH, wave, mean_motion(PUNCH, wave))
    h = riding_height(PUNCH, wave)
    for each, first, mean in zip(wave, forces.first_normal, forces.normal, strict=True):
        A = abs(each.normal)
        p = np.arccos(np.clip(-h / A, -1.0, 1.0))
        touched = h > A
        closed = PUNCH.normal_stiffness * A * (1.0 if touched else (p - np.sin(p) * np.cos(p)) / np.pi)
        assert first == pytest.approx(closed * each.normal / A, rel=1e-11)
        closed = h if touched else A * (np.sin(p) - p * np.cos(p)) / np.pi
        assert mean == pytest.approx(PUNCH.normal_stiffness * closed, rel=1e-11)


@pytest.mark.parametrize("body", [slider(), PUNCH])
def test_the_first_harmonics_are_those_of_a_brute_cycle(body):
    wave = waves(1.0)
    motion = mean_motion(body, wave)
    forces = mean_forces(body, wave, motion)
    found = forces.normal[0], forces.first_normal[0], forces.tangential[0], forces.first_tangential[0]
    unit = np.array([1.0, 1.0, body.friction_coefficient, body.friction_coefficient]) * body.preload
    right = np.array(brute(body, wave[0], riding_height(body, wave), float(motion.first_order)))
    assert np.max(np.abs(np.array(found) - right) / unit) < 3e-4  # the steps'


def test_the_forces_of_all_contacts_balance_the_slider():
    body = replace(slider(), load=2e-5)
    wave = waves(1.0, 0.9, 1.1)
    motion = mean_motion(body, wave)
    forces = mean_forces(body, wave, motion)
    assert forces.normal.sum() == pytest.approx(body.preload, rel=1e-12)
    drag = body.tangential_damping * motion.first_order + np.sign(motion.first_order) * body.load
    assert forces.tangential.sum() == pytest.approx(drag, rel=1e-8)
