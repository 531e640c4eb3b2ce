"""Adhesive spheres against the values of an independent program, exact relations and refusals."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from contact import (
    Adhesion,
    InputError,
    burst,
    mean_motion,
    release_amplitude,
    riding_height,
    stall,
    steady,
    threshold_amplitude,
)
from contact.law.adhesion import AdhesiveSphere, meniscus_force
from contact.law.sphere_limits import tabor_number
from tests.contact.motors import orbit, slider
from tests.oracles.contact_heavy_ball import HeavyBall

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


# u_z nm; mean velocity m/s without, with w = 0.05 and 0.1 J/m^2, and with a meniscus of water, by another program,
# which errs by up to 2e-7 (`HeavyBall`)
SPEEDS = [
    (2.0, 0.005205413, 0.003786650, 0.002790847, 0.002136737),
    (3.0, 0.012188264, 0.009986348, 0.008282401, 0.007078834),
    (10.0, 0.068365875, 0.066550407, 0.064717926, 0.063085817),
]
KINDS = (
    None, Adhesion(model="DMT", work=0.05), Adhesion(model="DMT", work=0.1),
    Adhesion(model="meniscus", surface_tension=0.072),
)  # fmt: skip


@pytest.mark.parametrize(("u", "speeds"), [(row[0], row[1:]) for row in SPEEDS])
def test_the_speeds_of_attracted_balls(u, speeds):
    ball = slider(preload=PRELOAD, mass=math.inf, normal_damping=0.0, tangential_damping=0.0)
    for adhesion, speed in zip(KINDS, speeds, strict=True):
        found = mean_motion(replace(ball, adhesion=adhesion), orbit(1e-9 * u, 0.67))
        assert float(found.velocity) == pytest.approx(speed, rel=3e-7)


@pytest.mark.parametrize("u", [2.0, 3.0])
def test_the_speeds_of_attracted_balls_to_more_digits(u):
    body = slider(preload=PRELOAD, mass=math.inf, normal_damping=0.0, tangential_damping=0.0)
    for adhesion in KINDS:
        pressed = PRELOAD + (adhesion.attraction(R) if adhesion else 0.0)
        known = HeavyBall(
            stiffness=4 / 3 * 64e9 * math.sqrt(R), slope=0.08 * 64 / 48, preload=pressed, ratio=0.67,
            omega=2 * math.pi * 2.2e6,
        ).velocity(1e-9 * u)  # fmt: skip
        found = mean_motion(replace(body, adhesion=adhesion), orbit(1e-9 * u, 0.67))
        assert float(found.velocity) == pytest.approx(known, rel=1e-8)


@pytest.mark.parametrize("adhesion", KINDS[1:], ids=lambda each: f"{each.model} {each.work}")
def test_without_hops_an_attraction_is_a_preload(adhesion):
    ball = slider(preload=PRELOAD, load=1e-6, contact_damping=1e-2)
    pulled, pressed = replace(ball, adhesion=adhesion), replace(ball, preload=PRELOAD + adhesion.attraction(R))
    unit = orbit(1e-9)
    assert threshold_amplitude(pulled, unit) == pytest.approx(threshold_amplitude(pressed, unit), rel=1e-9)
    assert release_amplitude(pulled, unit) == pytest.approx(release_amplitude(pressed, unit), rel=1e-9)
    stalls = [stall(each, orbit(3e-9), tolerance=1e-3).value for each in (pulled, pressed)]
    assert stalls[0] == pytest.approx(stalls[1], rel=1e-8)
    one, other = (steady(each, orbit(3e-9), tolerance=1e-6) for each in (pulled, pressed))
    assert one.velocity == pytest.approx(other.velocity, rel=1e-10)
    for method, close in (("exact", 1e-10), ("stepped", 1e-8), ("averaged", 1e-7)):
        options = {"duration": 2e-5, "after": 5e-6, "tolerance": 1e-3, "samples": 5, "method": method}
        one, other = (burst(each, orbit(2e-9), **options) for each in (pulled, pressed))
        assert one.velocity_at_burst_end == pytest.approx(other.velocity_at_burst_end, rel=close)


@pytest.mark.parametrize("adhesion", KINDS[1:], ids=lambda each: f"{each.model} {each.work}")
def test_an_attraction_alone_is_a_preload(adhesion):
    ball, unit = slider(preload=0.0), orbit(1e-9)
    pulled, pressed = replace(ball, adhesion=adhesion), replace(ball, preload=adhesion.attraction(R))
    assert threshold_amplitude(pulled, unit) == pytest.approx(threshold_amplitude(pressed, unit), rel=1e-9)
    assert release_amplitude(pulled, unit) == pytest.approx(release_amplitude(pressed, unit), rel=1e-9)


def test_a_hopping_ball_is_pulled_as_long_as_it_touches():
    ball, wave = slider(preload=PRELOAD, adhesion=KINDS[3]), orbit(10e-9)
    h, pull = riding_height(ball, wave), KINDS[3].attraction(R)
    half = math.acos(-h / 10e-9)
    elastic = quad(lambda phi: (h + 10e-9 * math.cos(phi)) ** 1.5, 0.0, half, epsabs=0.0, epsrel=1e-11)[0] / math.pi
    assert 4.0 / 3.0 * E * math.sqrt(R) * elastic - pull * half / math.pi == pytest.approx(PRELOAD, rel=1e-9)
    found = steady(ball, wave, tolerance=1e-6)
    assert found.regime == "intermittent"
    assert found.velocity == pytest.approx(float(mean_motion(ball, wave).velocity), rel=1e-7)
    books = found.ledger
    spent = books.slip + books.leak + books.normal_damper + books.tangential_damper
    assert books.wave == pytest.approx(spent, rel=1e-9)
    options = {"duration": 2e-5, "after": 0.0, "tolerance": 1e-3, "samples": 5}
    exact = burst(ball, wave, method="exact", **options).velocity_at_burst_end
    unit = wave.omega * abs(wave.tangential) / 10.0
    for method in ("stepped", "averaged"):
        other = burst(ball, wave, method=method, **options)
        assert abs(other.velocity_at_burst_end - exact) < 1.01 * other.relative_error * unit


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"law": "hysteretic"}, r'slider\.adhesion has no hysteretic law: choose "elastic"'),
        ({"shape": "punch", "radius": 1e-6}, r'slider\.shape cannot be "punch" where balls attract'),
        ({"reciprocal": True}, r"slider\.reciprocal cannot be true"),
        ({"heights": (0.0, 1e-9)}, r"slider\.heights must all be 0"),
        ({"radius": [1e-3, 2e-3]}, r"slider\.radius must be equal"),
    ],
)
def test_sliders_that_attraction_does_not_take(changed, sentence):
    with pytest.raises(InputError, match=sentence):
        slider(adhesion=KINDS[1], **changed)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ({"model": "jkr", "work": 0.05}, r"adhesion\.model"),
        ({"model": "JKR", "work": 0.05, "separation": 3e-10}, r"adhesion\.separation must be left out"),
        ({"model": "DMT"}, r"adhesion\.work is required"),
        ({"model": "DMT", "work": -0.05}, r"adhesion\.work must be"),
        ({"model": "meniscus", "work": 0.05}, r"adhesion\.surface_tension is required"),
        ({"model": "meniscus", "surface_tension": 0.07, "work": 0.05}, r"adhesion\.work must be left out"),
        ({"model": "meniscus", "surface_tension": 0.07, "contact_angle": 1.6}, r"adhesion\.contact_angle"),
        ({"model": "DMT", "work": 0.05, "contact_angle": 0.1}, r"adhesion\.contact_angle must be left out"),
    ],
)
def test_adhesions_are_refused(given, sentence):
    with pytest.raises(InputError, match=sentence):
        Adhesion(**given)
