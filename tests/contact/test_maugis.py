"""A sphere of Maugis and Dugdale: limits, the equations of both papers, and an integration of its own tractions."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contact import AdhesiveSphere, InputError
from contact.law.maugis import MaugisSphere

R, E, W, PRELOAD = 1e-3, 64e9, 0.05, 0.87309e-3


def sphere(separation=0.3e-9, **given):
    return MaugisSphere(**({"radius": R, "modulus": E, "work": W, "separation": separation} | given))


def test_a_short_range_is_jkr():
    """The range enters as 1/lambda: 1e-4 at a separation of 0.1 pm."""
    ball, limit = sphere(1e-13), AdhesiveSphere(radius=R, modulus=E, work=W, model="JKR")
    assert ball.break_approach == pytest.approx(limit.break_approach, rel=1e-8)
    assert ball.pull_off == pytest.approx(1.5 * math.pi * W * R, rel=1e-7)
    assert ball.loss == pytest.approx(limit.loss, rel=1e-4)
    assert ball.radius_under(PRELOAD) == pytest.approx(limit.radius_under(PRELOAD), rel=1e-7)
    assert ball.release_amplitude(PRELOAD) == pytest.approx(limit.release_amplitude(PRELOAD), rel=1e-7)


def test_a_long_range_is_dmt():
    """The approach differs by the root of lambda, 1e-2; apart the surfaces attract over their range."""
    ball = sphere(1e-5)
    assert ball.tabor_number < 1e-4
    assert ball.pull_off == pytest.approx(2.0 * math.pi * W * R, rel=1e-3)
    limit = AdhesiveSphere(radius=R, modulus=E, work=W, model="DMT")
    assert ball.radius_under(PRELOAD) == pytest.approx(limit.radius_under(PRELOAD), rel=1e-3)
    assert ball.approach_under(PRELOAD) == pytest.approx(limit.approach_under(PRELOAD), rel=1e-2)
    assert ball.loss < 1e-6 * math.pi * W * R * 1e-9
    # a rigid sphere on the way out: the force falls linearly over the range
    z = np.array([0.5 * ball.make_approach])
    assert float(ball.closed(z)[1][0]) == pytest.approx(-math.pi * W * R, rel=1e-3)


@pytest.mark.parametrize("separation", [1e-10, 3e-10, 1e-9, 3e-9])
def test_contacts_satisfy_the_equations_of_the_papers(separation):
    """Johnson and Greenwood (1997), equations 4 to 6, with m = c/a as they write them."""
    ball = sphere(separation)
    K = 4.0 / 3.0 * E
    lam = 2.0 * ball.traction * (R / (math.pi * W * K**2)) ** (1 / 3)
    assert lam == pytest.approx(1.157 * ball.tabor_number, rel=2e-4)
    t = np.linspace(0.1, 1.5, 8)
    a, force, z = ball.at_angle(t)
    m, bar = 1.0 / np.cos(t), a * (K / (math.pi * W * R**2)) ** (1 / 3)
    root, arc = np.sqrt(m**2 - 1.0), np.arccos(1.0 / m)
    one = 0.5 * lam * bar**2 * ((m**2 - 2.0) * arc + root) + 4.0 / 3.0 * lam**2 * bar * (root * arc - m + 1.0)
    np.testing.assert_allclose(one, 1.0, rtol=1e-12)
    np.testing.assert_allclose(force, math.pi * W * R * (bar**3 - lam * bar**2 * (root + m**2 * arc)), rtol=1e-11)
    unit = (math.pi**2 * W**2 * R / K**2) ** (1 / 3)
    np.testing.assert_allclose(z, unit * (bar**2 - 4.0 / 3.0 * lam * bar * root), rtol=1e-11, atol=1e-24)


@pytest.mark.parametrize("separation", [1e-10, 3e-10, 1e-9, 3e-9, 1e-8])
def test_force_approach_and_loss_belong_together(separation):
    ball = sphere(separation)
    z = ball.break_approach + np.geomspace(1e-15, 2e-8, 9)
    a, force = ball.closed(z)
    assert np.all(np.diff(a) >= 0.0)
    for each, own in zip(z, force, strict=True):  # contacts under a positive load are found by it
        if own > 0.0:
            assert ball.approach_under(float(own)) == pytest.approx(each, rel=1e-9)
    kink = float(ball.at_angle(np.array(0.5 * math.pi))[2])
    # z = end + s^2 nm; the force has a kink where the contact is a point
    ends = (
        math.sqrt(1e9 * (ball.make_approach - ball.break_approach)),
        math.sqrt(max(1e9 * (kink - ball.break_approach), 0)),
    )
    work, _ = quad(
        lambda s: 2.0 * s * 1e-9 * 1e3 * float(ball.closed(ball.break_approach + 1e-9 * s**2)[1]), 0.0, ends[0],
        limit=400, epsabs=1e-20, points=[ends[1]] if 0.0 < ends[1] < ends[0] else None,
    )  # fmt: skip
    assert ball.loss == pytest.approx(-1e-3 * work, rel=1e-6)
    assert ball.loss > 0.0
    # the two regimes meet where the contact is a point
    below, above = (float(ball.closed(kink + step)[1]) for step in (-1e-16, 1e-16))
    if ball.break_approach < kink - 1e-15:
        assert below == pytest.approx(above, rel=1e-5)


def test_the_pressure_gives_the_displacements():
    """Maugis's tractions on the half-space: at the rim of the attraction the gap is h_0, in the contact 0."""
    ball = sphere(1e-9)
    t = 0.8
    a, force, z = (float(each) for each in ball.at_angle(np.array(t)))
    c, sigma = a / math.cos(t), ball.traction

    def pressure(r):
        if r >= c:
            return 0.0
        if r >= a:
            return -sigma
        inner = math.sqrt(a**2 - r**2)
        dugdale = (2.0 * sigma / math.pi) * math.atan(math.sqrt((c**2 - a**2) / (a**2 - r**2)))
        return 2.0 * E / (math.pi * R) * inner - dugdale

    total = quad(lambda r: 2.0 * math.pi * r * pressure(r), 0.0, a, limit=400)[0] - sigma * math.pi * (c**2 - a**2)
    assert total == pytest.approx(force, rel=1e-8)

    # Abel: the stress function g(x) of an axisymmetric pressure gives u(r) = (2/(pi E)) int_0^r g(x)/sqrt(r^2 - x^2)
    def g(x):
        def along(y):  # r = sqrt(x^2 + y^2)
            return pressure(math.hypot(x, y))

        edges = [math.sqrt(each**2 - x**2) for each in (a, c) if each > x]
        return sum(quad(along, low, high, limit=200)[0] for low, high in zip([0.0, *edges[:-1]], edges, strict=True))

    def displacement(r):
        return 4.0 / (math.pi * E) * quad(lambda s: g(r * math.sin(s)), 0.0, 0.5 * math.pi, limit=200, points=[0.6])[0]

    gap = c**2 / (2.0 * R) - z + displacement(c)
    assert gap == pytest.approx(-ball.make_approach, rel=2e-3)
    middle = (0.5 * a) ** 2 / (2.0 * R) - z + displacement(0.5 * a)
    assert abs(middle) < 2e-3 * abs(ball.make_approach)


@pytest.mark.parametrize("name", ["radius", "modulus", "work", "separation"])
def test_refusals(name):
    with pytest.raises(InputError, match=rf"adhesion\.{name} must be positive"):
        sphere(**{name: -1.0})


def test_a_separation_far_below_that_of_atoms_is_the_limit_jkr():
    with pytest.raises(
        InputError, match=r"adhesion\.separation must give a number of Tabor of at most 1e\+06, got 8\.\d+e"
    ):
        MaugisSphere(radius=1e-3, modulus=64e9, work=0.05, separation=1e-17)
