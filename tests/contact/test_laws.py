"""Hertz and Mindlin: closed forms on generic numbers, and the forms that the paper prints."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contact.law import hertz, mindlin
from tests.contact.motors import slider

RADIUS, E, G, MU = 1.7e-3, 71e9, 13.3e9, 0.23


def test_normal_force_is_hertz_and_zero_when_separated():
    # Oracle: Johnson eq. 4.23, delta = (9 P^2 / 16 R E^2)^(1/3)
    P = hertz.normal_force(np.array([-2e-9, 0.0, 3.1e-9]), hertz.stiffness(RADIUS, E))
    assert P[0] == P[1] == 0.0
    assert (9.0 * P[2] ** 2 / (16.0 * RADIUS * E**2)) ** (1 / 3) == pytest.approx(3.1e-9, rel=1e-13)


@given(st.floats(1e-12, 1e3))
def test_approach_and_normal_force_are_inverse(P):
    K = hertz.stiffness(RADIUS, E)
    assert hertz.normal_force(hertz.approach(P, K), K) == pytest.approx(P, rel=1e-13)


def test_slip_limit_is_the_papers_with_its_cube_root():
    z = np.array([0.3e-9, 4.7e-9, 60e-9])
    P = hertz.normal_force(z, hertz.stiffness(RADIUS, E))
    a = np.cbrt(3.0 * P * RADIUS / (4.0 * E))
    assert hertz.contact_radius(z, RADIUS) == pytest.approx(a, rel=1e-13)
    assert mindlin.slip_limit(z, mindlin.limit_slope(MU, E, G)) == pytest.approx(
        3.0 * MU * P / (16.0 * a * G), rel=1e-13
    )


def test_tangential_force_is_cattaneo_mindlin_up_to_the_friction_limit():
    z = 4.7e-9
    P = hertz.normal_force(z, hertz.stiffness(RADIUS, E))
    a, x_max = hertz.contact_radius(z, RADIUS), mindlin.slip_limit(z, mindlin.limit_slope(MU, E, G))
    x = np.linspace(-1.0, 1.0, 11) * x_max
    paper = (
        MU * P * (1.0 - np.maximum(1.0 - 16.0 * np.abs(x) * a * G / (3.0 * MU * P), 0.0) ** 1.5) * np.sign(x)
    )
    assert mindlin.tangential_force(x, x_max, MU * P) == pytest.approx(paper, rel=1e-7)
    assert mindlin.tangential_force(3.0 * x_max, x_max, MU * P) == MU * P
    assert mindlin.tangential_force(x, 0.0, 0.0) == pytest.approx(0.0, abs=0.0)


def test_initial_stiffness_is_the_slope_at_zero():
    z = 4.7e-9
    P = hertz.normal_force(z, hertz.stiffness(RADIUS, E))
    x_max = mindlin.slip_limit(z, mindlin.limit_slope(MU, E, G))
    step = 1e-6 * x_max
    slope = mindlin.tangential_force(step, x_max, MU * P) / step
    assert slope == pytest.approx(mindlin.initial_stiffness(z, RADIUS, G), rel=1e-6)  # one-sided difference


def test_stored_energy_is_the_integral_of_the_force():
    x_max, limit = 3.1e-10, 2.3e-3
    node, weight = np.polynomial.legendre.leggauss(40)
    s = 0.5 * (node + 1.0)
    x = x_max * (1.0 - s**2)  # the square root at x_max becomes smooth
    work = np.sum(weight * x_max * s * mindlin.tangential_force(x, x_max, limit))
    assert mindlin.stored_energy(x_max, x_max, limit) == pytest.approx(work, rel=1e-13)


def test_the_seeds_motor_at_rest():
    # Oracle: figures of the design notes, worked out by hand from the closed forms
    s = slider()
    assert s.rest_approach(1) == pytest.approx(4.712958e-9, rel=1e-6)
    assert s.limit_slope * s.rest_approach(1) == pytest.approx(0.502715e-9, rel=2e-6)
    assert s.normal_resonance(1) == pytest.approx(8893.1, rel=1e-5)
    assert s.tangential_resonance(1) == pytest.approx(7701.7, rel=1e-5)
    assert s.ring_at_slip_limit(1) == pytest.approx(6581.0, rel=1e-5)


def test_three_balls_stand_as_one_with_a_third_of_everything():
    three, one = slider(), slider(mass=0.089e-3 / 3, preload=0.089e-3 * 9.81 / 3)
    assert three.rest_approach(3) == pytest.approx(one.rest_approach(1), rel=1e-14)
    assert three.normal_resonance(3) == pytest.approx(one.normal_resonance(1), rel=1e-14)
    assert three.ring_at_slip_limit(3) == pytest.approx(one.ring_at_slip_limit(1), rel=1e-13)
