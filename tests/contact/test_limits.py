"""Threshold and release: closed forms against other closed forms, quadrature and the simulated regime."""

import math

import numpy as np
import pytest
from scipy.integrate import quad

from contact import (
    Orbit,
    contact_history,
    damper_pull,
    release_amplitude,
    release_factor,
    riding_height,
    steady,
    threshold_amplitude,
)
from contact import threshold_factor as threshold
from contact.averaged.riding import mean_normal_force, quadrature
from contact.codes import Shape
from contact.law.normal import LAWS, SHAPES, load
from contact.problem import scaled
from tests.contact.motors import FREQUENCY, HEAVY, orbit, slider


def mean_load(h, A, shape=Shape.SPHERE):
    """Return the cycle mean of p(h + A cos phi) from the kernel."""
    problem = scaled(slider(shape=SHAPES[shape]), (orbit(A),), direction=1.0, start=0.0)
    force, _ = mean_normal_force(problem, h / problem.length, quadrature(48))
    return force / problem.stiffness * load(problem.length, LAWS[shape])


@pytest.mark.parametrize("shape", [Shape.SPHERE, Shape.PUNCH])
@pytest.mark.parametrize("height", [-0.93, -0.2, 0.0, 0.4, 0.999, 1.0, 1.001, 1.7])
def test_mean_load_against_adaptive_quadrature(height, shape):
    amplitude, power = 1.3e-9, (1.5, 1.0)[shape]
    h = height * amplitude
    edge = math.pi if height >= 1.0 else math.acos(-height)
    expected = quad(lambda q: max(h + amplitude * math.cos(q), 0.0) ** power, 0.0, edge, epsabs=0.0, epsrel=1e-12)[0]
    assert mean_load(h, amplitude, shape) == pytest.approx(expected / math.pi, rel=3e-11)


def test_release_amplitude_is_the_closed_form():
    mean = 16.0 * math.sqrt(2.0) / (6.0 * math.pi)
    assert mean == pytest.approx(1.2004217549, rel=1e-10)
    closed_form = slider().rest_approach(1) / mean ** (2.0 / 3.0)
    assert closed_form == pytest.approx(4.17258e-9, rel=1e-6)
    assert release_amplitude(slider(mass=HEAVY), orbit(1e-9)) == pytest.approx(closed_form, rel=1e-8)
    # the seed's slider moves within a cycle by (f_n/f)^2 = 2e-5 of the wave
    assert 1e-5 < 1 - release_amplitude(slider(), orbit(1e-9)) / closed_form < 2e-5


def test_release_does_not_depend_on_the_tangential_motion_or_on_the_scale():
    s = slider()
    one = release_amplitude(s, orbit(1e-9))
    other = release_amplitude(s, Orbit(frequency=2.2e6, normal=3e-8j, tangential=2e-9))
    assert one == pytest.approx(other, rel=1e-14)
    assert release_factor(s, Orbit(frequency=2.2e6, normal=0, tangential=2e-9)) == math.inf


def test_riding_height_carries_the_preload():
    s = slider()
    for A in (0.0, 1e-9, 4.17e-9, 9e-9, 80e-9):
        h = riding_height(s, orbit(A))
        assert s.normal_stiffness * mean_load(h, A) == pytest.approx(s.preload, rel=1e-12)


@pytest.mark.parametrize("ratio", [0.1, 0.7, 2.0])
def test_threshold_in_quadrature_is_the_closed_form(ratio):
    # A sqrt(r^2 + c^2) = c h(A)
    s = slider(mass=HEAVY)
    A = threshold_amplitude(s, orbit(1e-9, ratio))
    c = s.limit_slope
    assert A * math.hypot(ratio, c) == pytest.approx(c * riding_height(s, orbit(A)), rel=1e-7)


def test_threshold_at_a_general_phase_by_searching_the_offset():
    # x0 + u_x within c (h + u_z) at all times, <Q> = 0 at that x0: by brute force over time
    s = slider()
    shape = Orbit(frequency=2.2e6, normal=1e-9, tangential=0.7e-9 * np.exp(-1.1j))
    A = threshold_amplitude(s, shape)
    phase = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 4001))

    def room(amplitude):
        scaled = shape.scaled(amplitude / 1e-9)
        bound = s.limit_slope * (riding_height(s, scaled) + (scaled.normal * phase).real)
        u_x = (scaled.tangential * phase).real
        return np.min(bound - u_x) + np.min(bound + u_x)

    assert room(0.5 * A) > 0.0
    # the offsets leave room, but the mean traction of the highest may already be positive
    assert room(A) >= -1e-6 * s.limit_slope * s.rest_approach(1)


def test_threshold_is_zero_without_friction_and_infinite_without_motion():
    assert threshold_amplitude(slider(friction_coefficient=0.0), orbit(1e-9)) == 0.0
    assert threshold(slider(), Orbit(frequency=1e6, normal=0, tangential=0)) == math.inf
    assert threshold(slider(load=1.0), orbit(1e-9)) == 0.0


def test_load_lowers_the_threshold():
    s = slider()
    loaded = slider(load=0.5 * s.friction_coefficient * s.preload)
    assert threshold_amplitude(loaded, orbit(1e-9)) < 0.9 * threshold_amplitude(s, orbit(1e-9))


def _edge(low, high, inside, width):
    while high - low > width * low:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if inside(middle) else (low, middle)
    return 0.5 * (low + high)


def test_simulated_threshold_is_the_closed_form():
    # The slider is heavy but not infinitely so: (f_n/f)^2 = 1.6e-5, times 12 at the threshold
    s = slider()
    edge = _edge(0.6e-9, 0.9e-9, lambda A: steady(s, orbit(A), tolerance=1e-6).regime == "stick", 1e-4)
    assert edge == pytest.approx(threshold_amplitude(s, orbit(1e-9)), rel=1e-3)


def test_simulated_release_is_the_closed_form():
    s = slider()
    edge = _edge(4.0e-9, 4.4e-9, lambda A: steady(s, orbit(A), tolerance=1e-6).regime == "slip", 1e-6)
    assert edge == pytest.approx(release_amplitude(s, orbit(1e-9)), rel=3e-5)  # (f_n/f)^2 = 1.6e-5


@pytest.mark.parametrize("chi", [0.0, 5.0, 7.0, 20.0, 100.0])
def test_a_damper_pulls_as_the_full_motion_does(chi):
    """P (1 + chi z') along the steady motion itself; the slider moves by 1e-5 of the wave within a cycle."""
    body, wave = slider(contact_damping=chi), orbit(10e-9)
    motion = contact_history(body, wave, stage="steady", skip=0.0, cycles=1.0, points_per_cycle=8000.0)
    rate = np.gradient(motion.approach[:, 0], motion.time)
    force = motion.normal_force[:, 0] * (1.0 + chi * rate)
    least, share = damper_pull(body, wave)
    assert least == pytest.approx(min(float(force.min()), 0.0), rel=1e-3, abs=1e-9)
    assert share == pytest.approx(float(np.mean(force < -1e-12)), abs=2e-3)
    remarked = "pulls the slider down" in steady(body, wave, tolerance=1e-3).message
    assert remarked == (chi in (20.0, 100.0)) == (least < 0.0)


def test_of_several_contacts_the_one_that_pulls_most_counts_in_any_order_and_mirrored():
    body, waves = (
        slider(contact_damping=20.0),
        (orbit(3e-9), orbit(10e-9), Orbit(frequency=FREQUENCY, normal=6e-9j, tangential=2e-9)),
    )
    alone = damper_pull(body, waves)
    assert alone[0] < 0.0 < alone[1]
    assert damper_pull(body, waves[::-1]) == pytest.approx(alone, rel=1e-12)
    assert damper_pull(body, tuple(each.mirrored() for each in waves)) == pytest.approx(alone, rel=1e-12)
