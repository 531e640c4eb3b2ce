"""Adhesive spheres against the values of an independent program, exact relations and refusals."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contact import InputError
from contact.law.adhesion import AdhesiveSphere, meniscus_force, tabor_number

R, E, PRELOAD = 1e-3, 64e9, 0.87309e-3
# work J/m^2; radius um and stiffness over Hertz's at the preload, approach at the end nm, release amplitude nm, loss J
JKR = [
    (0.02, 2.6924, 1.0266, -0.7408, 4.9285, 6.532e-14),
    (0.05, 3.0269, 1.0665, -1.3646, 5.6963, 3.008e-13),
    (0.1, 3.4180, 1.1289, -2.1662, 6.7838, 9.550e-13),
    (0.144, 3.6886, 1.1792, -2.7624, 7.6443, 1.754e-12),
]


def sphere(work, model="JKR"):
    return AdhesiveSphere(radius=R, modulus=E, work=work, model=model)


@pytest.mark.parametrize(("work", "radius", "stiffness", "ends", "release", "loss"), JKR)
def test_jkr(work, radius, stiffness, ends, release, loss):
    ball = sphere(work)
    a = ball.radius_under(PRELOAD)
    assert ball.force(a) == pytest.approx(PRELOAD, rel=1e-12)
    assert a * 1e6 == pytest.approx(radius, rel=1e-4)
    assert ball.stiffness(a) / 2.7788e5 == pytest.approx(stiffness, rel=1e-4)
    assert ball.break_approach * 1e9 == pytest.approx(ends, rel=1e-4)
    assert ball.release_amplitude(PRELOAD) * 1e9 == pytest.approx(release, rel=1e-4)
    assert ball.loss == pytest.approx(loss, rel=3e-4)


def test_jkr_relations():
    ball = sphere(0.05)
    # the largest tension is 1.5 pi w R, at (9 pi w R^2/8E)^(1/3); the end at prescribed approach lies beyond it
    a = (9 * math.pi * 0.05 * R**2 / (8 * E)) ** (1 / 3)
    assert ball.force(a) == pytest.approx(-ball.pull_off, rel=1e-12)
    assert ball.force(1.001 * a) > -ball.pull_off < ball.force(0.999 * a)
    assert ball.break_radius < a
    assert ball.break_approach < ball.approach(a)
    assert ball.approach(ball.make_radius) == pytest.approx(0.0, abs=1e-22)
    assert ball.radius_at(ball.approach(3e-6)) == pytest.approx(3e-6, rel=1e-12)
    # the loss is the work of the force around both branches, by a quadrature in z
    work, _ = quad(lambda z: ball.force(ball.radius_at(z)), ball.break_approach, 0.0, limit=200)
    assert ball.loss == pytest.approx(-work, rel=1e-5)


def test_without_adhesion_all_is_hertz():
    for model in ("JKR", "DMT"):
        ball = sphere(1e-13, model)
        a = ball.radius_under(PRELOAD)
        assert a**2 / R == pytest.approx(4.71296e-9, rel=1e-5)
        assert ball.stiffness(a) == pytest.approx(2 * a * E, rel=1e-5)
        assert ball.release_amplitude(PRELOAD) == pytest.approx(4.17258e-9, rel=1e-4)
        assert ball.loss < 1e-24


def test_dmt_is_a_larger_preload():
    for work, ratio in ((0.02, 1.0938), (0.05, 1.2274), (0.1, 1.4354)):
        ball = sphere(work, "DMT")
        grown = (1 + 2 * math.pi * work * R / PRELOAD) ** (2 / 3)
        assert ball.radius_under(PRELOAD) ** 2 / R / 4.71296e-9 == pytest.approx(grown, rel=1e-5)
        assert grown == pytest.approx(ratio, rel=1e-4)
        assert ball.break_approach == 0.0 == ball.loss


def test_numbers():
    assert tabor_number(R, E, 0.05) == pytest.approx(2.83, rel=1e-3)
    assert meniscus_force(R, 0.072) / PRELOAD == pytest.approx(1.036, rel=1e-3)
    assert meniscus_force(R, 0.072, math.radians(60)) == pytest.approx(0.5 * meniscus_force(R, 0.072), rel=1e-12)
    assert np.allclose(sphere(0.05).force(np.array([2e-6, 3e-6])), [sphere(0.05).force(2e-6), sphere(0.05).force(3e-6)])


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: sphere(-0.05), r"adhesion\.work must be positive"),
        (lambda: sphere(0.05, "jkr"), r"adhesion\.model must be"),
        (lambda: meniscus_force(R, 0.072, 2.0), r"adhesion\.contact_angle must be from 0 to below pi/2"),
        (lambda: sphere(0.05).radius_under(-1.0), "force must be at least minus the pull-off force"),
        (lambda: sphere(0.05).radius_at(-1e-6), "approach must be at least that at which the contact ends"),
    ],
)
def test_refusals(call, sentence):
    with pytest.raises(InputError, match=sentence):
        call()
