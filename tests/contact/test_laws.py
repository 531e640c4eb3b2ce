"""Force laws: closed forms on generic numbers, and the forms that the paper prints."""

from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from contact.body import Point
from contact.codes import Regime, Shape
from contact.law import elastic, normal
from studies.papers.seed_contact import ring_at_slip_limit
from tests.contact.motors import slider
from tests.seed_motor import MASS, PRELOAD

RADIUS, E, G, MU = 1.7e-3, 71e9, 13.3e9, 0.23
C = elastic.limit_slope(MU, E, G)
SHAPES = pytest.mark.parametrize("shape", [Shape.SPHERE, Shape.PUNCH])


def force(z, shape):
    return normal.stiffness(RADIUS, E, shape) * normal.load(z, normal.LAWS[shape])


def traction(x, z, shape):
    return elastic.tangential_force(x, z, MU * normal.stiffness(RADIUS, E, shape), C, normal.LAWS[shape])


def test_normal_force_is_hertz_and_zero_when_separated():
    # Oracle: Johnson eq. 4.23, delta = (9 P^2 / 16 R E^2)^(1/3)
    P = force(np.array([-2e-9, 0.0, 3.1e-9]), Shape.SPHERE)
    assert P[0] == P[1] == 0.0
    assert (9.0 * P[2] ** 2 / (16.0 * RADIUS * E**2)) ** (1 / 3) == pytest.approx(3.1e-9, rel=1e-13)


def test_normal_force_of_a_punch_is_boussinesq():
    # Oracle: Johnson eq. 3.36, P = 2 a E delta
    P = force(np.array([-2e-9, 0.0, 3.1e-9]), Shape.PUNCH)
    assert P[0] == P[1] == 0.0
    assert P[2] / (2.0 * RADIUS * E) == pytest.approx(3.1e-9, rel=1e-13)


@SHAPES
def test_the_normal_stiffness_is_that_of_the_contact_circle(shape):
    # dP/dz = 2 a E whatever the profile (Johnson, section 5.5; Barber 1998)
    z = np.array([0.3e-9, 4.7e-9, 60e-9])
    slope = normal.stiffness(RADIUS, E, shape) * normal.slope(z, normal.LAWS[shape])
    assert slope == pytest.approx(2.0 * normal.contact_radius(z, RADIUS, shape) * E, rel=1e-13)
    assert normal.slope(-1e-9, normal.LAWS[shape]) == normal.contact_radius(-1e-9, RADIUS, shape) == 0.0
    step = 1e-4 * z
    work = normal.energy(z + step, normal.LAWS[shape]) - normal.energy(z - step, normal.LAWS[shape])
    assert work / (2.0 * step) == pytest.approx(normal.load(z, normal.LAWS[shape]), rel=1e-7)


@SHAPES
@given(P=st.floats(1e-12, 1e3))
def test_approach_and_load_are_inverse(shape, P):
    law = normal.LAWS[shape]
    assert normal.load(normal.approach(P, law), law) == pytest.approx(P, rel=1e-13)


def test_slip_limit_is_the_papers_with_its_cube_root():
    z = np.array([0.3e-9, 4.7e-9, 60e-9])
    P = force(z, Shape.SPHERE)
    a = np.cbrt(3.0 * P * RADIUS / (4.0 * E))
    assert normal.contact_radius(z, RADIUS, Shape.SPHERE) == pytest.approx(a, rel=1e-13)
    assert C * z == pytest.approx(3.0 * MU * P / (16.0 * a * G), rel=1e-13)


def test_tangential_force_is_cattaneo_mindlin_up_to_the_friction_limit():
    z = 4.7e-9
    P, a = force(z, Shape.SPHERE), normal.contact_radius(z, RADIUS, Shape.SPHERE)
    x = np.linspace(-1.0, 1.0, 11) * C * z
    paper = MU * P * (1.0 - np.maximum(1.0 - 16.0 * np.abs(x) * a * G / (3.0 * MU * P), 0.0) ** 1.5) * np.sign(x)
    assert traction(x, z, Shape.SPHERE) == pytest.approx(paper, rel=1e-7)
    assert np.all(elastic.tangential_force(x, z, 0.0, 0.0, normal.SPHERE) == 0.0)


def test_tangential_force_of_a_punch_is_a_spring_that_slips_as_a_whole():
    # Oracle: Q = 8 a G x (Johnson, eq. 7.43 with a fixed contact circle) up to mu P
    z, x = 4.7e-9, np.array([-2e-9, -3e-10, 0.0, 1e-10, 5e-10, 1.6e-9])
    Q = np.clip(8.0 * RADIUS * G * x, -MU * force(z, Shape.PUNCH), MU * force(z, Shape.PUNCH))
    assert traction(x, z, Shape.PUNCH) == pytest.approx(Q, rel=1e-13)
    assert np.count_nonzero(np.abs(Q) == MU * force(z, Shape.PUNCH)) == 2  # the others stick


@SHAPES
def test_past_the_slip_limit_the_tangential_force_is_the_friction_limit(shape):
    z = 4.7e-9
    assert traction(3.0 * C * z, z, shape) == pytest.approx(MU * force(z, shape), rel=1e-15)
    for regime in (Regime.STICK, Regime.SLIP):
        problem = SimpleNamespace(
            friction=MU, stiffness=1.0, limit_slope=C, normal=normal.LAWS[shape], law=elastic.coulomb(0)
        )
        Q = elastic.spring(problem, regime, -1.0, Point(z, -C * z, 0.0, 0.0))[0]
        assert Q == pytest.approx(-MU * normal.load(z, normal.LAWS[shape]), rel=1e-14)


@SHAPES
def test_initial_stiffness_is_the_slope_at_zero(shape):
    z, step = 4.7e-9, 1e-15
    stiffness = 8.0 * normal.contact_radius(z, RADIUS, shape) * G
    assert traction(step, z, shape) / step == pytest.approx(stiffness, rel=2e-6)  # one-sided difference


@SHAPES
def test_stored_energy_is_the_integral_of_the_force(shape):
    z = 4.7e-9
    node, weight = np.polynomial.legendre.leggauss(40)
    s = 0.5 * (node + 1.0)
    x = C * z * (1.0 - s**2)  # the square root at x_max becomes smooth
    work = np.sum(weight * C * z * s * traction(x, z, shape))
    friction = MU * normal.stiffness(RADIUS, E, shape)
    assert friction * C * elastic.friction_energy(z, 0.0, normal.LAWS[shape]) == pytest.approx(work, rel=1e-13)


def test_a_punch_at_rest():
    # Oracle: two springs, 2 a E and 8 a G, that are linear up to the slip limit
    s = slider(shape="punch", radius=20e-6)
    k = 2.0 * 20e-6 * s.effective_modulus
    assert s.rest_approach(3) == pytest.approx(s.preload / (3.0 * k), rel=1e-14)
    assert s.normal_resonance(3) == pytest.approx(np.sqrt(3.0 * k / s.mass) / (2.0 * np.pi), rel=1e-14)
    ring = np.sqrt(3.0 * 8.0 * 20e-6 * s.tangential_modulus / s.mass) / (2.0 * np.pi)
    assert s.tangential_resonance(3) == pytest.approx(ring, rel=1e-14)


def test_a_hysteretic_punch_is_refused():
    with pytest.raises(ValueError, match=r'slider\.law must be "elastic" with shape = "punch"'):
        slider(shape="punch", law="hysteretic")
    with pytest.raises(ValueError, match=r"slider\.shape"):
        slider(shape="cone")


def test_the_seeds_motor_at_rest():
    # Oracle: figures of the design notes, worked out by hand from the closed forms
    s = slider()
    assert s.rest_approach(1) == pytest.approx(4.712958e-9, rel=1e-6)
    assert s.limit_slope * s.rest_approach(1) == pytest.approx(0.502715e-9, rel=2e-6)
    assert s.normal_resonance(1) == pytest.approx(8893.1, rel=1e-5)
    assert s.tangential_resonance(1) == pytest.approx(7701.7, rel=1e-5)
    assert ring_at_slip_limit(s) == pytest.approx(6581.0, rel=1e-5)


def test_three_balls_stand_as_one_with_a_third_of_everything():
    three, one = slider(), slider(mass=MASS / 3, preload=PRELOAD / 3)
    assert three.rest_approach(3) == pytest.approx(one.rest_approach(1), rel=1e-14)
    assert three.normal_resonance(3) == pytest.approx(one.normal_resonance(1), rel=1e-14)
