"""A sphere of Maugis and Dugdale: limits, the equations of both papers, and an integration of its own tractions."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contact import AdhesiveSphere, InputError
from contact.law import holding
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
    """The approach differs by the root of lambda, 1e-2; it closes and opens as a point, and loses nothing."""
    ball = sphere(1e-5)
    assert ball.tabor_number < 1e-4
    assert ball.pull_off == pytest.approx(2.0 * math.pi * W * R, rel=1e-3)
    limit = AdhesiveSphere(radius=R, modulus=E, work=W, model="DMT")
    assert ball.radius_under(PRELOAD) == pytest.approx(limit.radius_under(PRELOAD), rel=1e-3)
    assert ball.approach_under(PRELOAD) == pytest.approx(limit.approach_under(PRELOAD), rel=1e-2)
    assert ball.release_amplitude(PRELOAD) == pytest.approx(limit.release_amplitude(PRELOAD), rel=1e-2)
    assert ball.loss == 0.0
    assert ball.make_approach == ball.break_approach


def test_the_pull_off_falls_from_dmt_to_jkr():
    """From 2 to 1.5 pi w R as lambda grows (Johnson and Greenwood (1997), figure 4), steadily."""
    pulls = np.array([sphere(each).pull_off for each in np.geomspace(1e-6, 1e-13, 60)]) / (math.pi * W * R)
    assert np.all(np.diff(pulls) < 0.0)
    assert pulls[0] == pytest.approx(2.0, abs=1e-2)
    assert pulls[-1] == pytest.approx(1.5, abs=1e-6)
    # the largest tension of all contacts
    _, force, _ = sphere().at_angle(np.linspace(0.2, 0.5 * math.pi, 2001))
    assert sphere().pull_off == pytest.approx(-float(force.min()), rel=1e-6)


@pytest.mark.parametrize("work", [1e-6, 1e-9, 1e-12])
def test_without_work_it_is_hertz(work):
    """Where the contact is a point it ends, so that its release tends to that of Hertz as the work does."""
    release = sphere(work=work).release_amplitude(PRELOAD)
    hertz = AdhesiveSphere(radius=R, modulus=E, work=1e-24, model="DMT").release_amplitude(PRELOAD)
    assert release == pytest.approx(hertz, rel=20.0 * work / W)
    assert release == pytest.approx(hertz, abs=1e-9 * 20.0 * work / W + 1e-20)
    assert sphere(work=work).loss == 0.0


@pytest.mark.parametrize("number", [1e-3, 0.1, 0.3, 0.6, 0.7, 1.0, 3.0, 10.0, 1e3])
def test_depths_are_those_of_the_branch(number):
    """Forwards by the angle, and back from the end of the contact on; derivatives by differences."""
    hold = holding.maugis(number, 1.0, -0.5)
    assert (hold.end_depth == 0.0) == (number < 0.8)
    for d in hold.end_depth + np.geomspace(1e-3, 1e4, 9):
        z, step = float(holding.approach_at(d, hold)), 1e-4 * (d - hold.end_depth)
        rate = float(holding.depth_rate(d, hold))
        assert float(holding.depth(z, hold)) == pytest.approx(d, abs=1e-13 * d + 4e-15 * rate * (abs(z) + d))
        around = [
            [float(of(d + each, hold)) for each in (-step, step)]
            for of in (
                holding.approach_at,
                holding.work,
                lambda d, hold: holding.attraction(d, 0.0, hold),
                holding.rise,
            )
        ]
        (z0, z1), (w0, w1), (p0, p1), (r0, r1) = around
        assert (z1 - z0) / (2.0 * step) == pytest.approx(1.0 / rate, rel=1e-6)
        assert (w1 - w0) / (z1 - z0) == pytest.approx(d**1.5 - holding.attraction(d, 0.0, hold), rel=1e-6, abs=1e-6)
        assert (p1 - p0) / (2.0 * step) == pytest.approx(holding.attraction_rate(d, hold), rel=1e-6)
        second = -holding.depth_second(d, 1.0, 0.0, hold) / rate**3
        assert (r1 - r0) / (2.0 * step) == pytest.approx(second, rel=1e-5, abs=1e-9)


# where a fold meets the point at which a contact ends, and around it; for the last two the bracket must not start at 0
POINT = 0.9379474572106667


@pytest.mark.parametrize(
    "number", [*(POINT * (1.0 + each) for each in (-1e-2, -1e-9, 0.0, 1e-13, 1e-4)), 56184.72651444387, 6e5]
)
def test_branches_of_all_numbers_end_at_a_fold_or_a_point(number):
    hold = holding.maugis(number, 1.0, -0.5)
    assert np.all(np.isfinite([*hold[:-2], *hold.elastic, *hold.attraction]))
    assert (hold.end_depth == 0.0) == (number <= POINT)
    if number > 1e4:  # the limit JKR: S^4 = 8/3 in the unit of Maugis, and the approach -3 (S/4)^(4/3)
        root = (8.0 / 3.0) ** 0.5
        assert hold.leave == pytest.approx(-3.0 * (0.25 * root) ** (4.0 / 3.0), rel=1e-6)
    else:
        z = hold.leave + np.geomspace(1e-6, 1.0, 7)
        d = [float(holding.depth(each, hold)) for each in z]
        assert [float(holding.approach_at(each, hold)) for each in d] == pytest.approx(z, abs=1e-12)


@pytest.mark.parametrize("number", [1.0, 3.0, 50.0])
def test_series_at_the_end_are_those_of_the_forces(number):
    hold = holding.maugis(number, 1.0, -0.1)
    for share in (1e-3, 1e-2):
        s = share * hold.bend * hold.end
        d = float(holding.depth(hold.leave + s**2, hold))
        for terms, known in ((hold.elastic, d**1.5), (hold.attraction, float(holding.attraction(d, 0.0, hold)))):
            series = sum(factor * s**k for k, factor in enumerate(terms))
            assert series == pytest.approx(known, rel=10.0 * share**4 + 1e-9)


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


@pytest.mark.parametrize("separation", [1e-10, 3e-10, 1e-9, 1.3e-9, 3e-9])
def test_force_approach_and_loss_belong_together(separation):
    ball = sphere(separation)
    z = ball.break_approach + np.geomspace(1e-15, 2e-8, 9)
    a, force = ball.closed(z)
    assert np.all(np.diff(a) >= 0.0)
    for each, own in zip(z, force, strict=True):  # contacts under a positive load are found by it
        if own > 0.0:
            assert ball.approach_under(float(own)) == pytest.approx(each, rel=1e-9)
    # z = end + s^2 nm takes out the root with which the force ends
    end = math.sqrt(1e9 * (ball.make_approach - ball.break_approach))
    work, _ = quad(
        lambda s: 2.0 * s * 1e-9 * 1e3 * float(ball.closed(ball.break_approach + 1e-9 * s**2)[1]), 0.0, end,
        limit=400, epsabs=1e-20,
    )  # fmt: skip
    assert ball.loss == pytest.approx(-1e-3 * work, rel=1e-9, abs=1e-25)
    assert (ball.loss > 0.0) == (separation < 2e-9)


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
    assert gap == pytest.approx(ball.reach, rel=2e-3)
    middle = (0.5 * a) ** 2 / (2.0 * R) - z + displacement(0.5 * a)
    assert abs(middle) < 2e-3 * ball.reach


@pytest.mark.parametrize("name", ["radius", "modulus", "work", "separation"])
def test_refusals(name):
    with pytest.raises(InputError, match=rf"adhesion\.{name} must be positive"):
        sphere(**{name: -1.0})


def test_a_separation_far_below_that_of_atoms_is_the_limit_jkr():
    with pytest.raises(
        InputError, match=r"adhesion\.separation must give a number of Tabor of at most 1e\+06, got 8\.\d+e"
    ):
        MaugisSphere(radius=1e-3, modulus=64e9, work=0.05, separation=1e-17)
