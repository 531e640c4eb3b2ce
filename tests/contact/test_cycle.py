"""One cycle under a heavy slider: against the general event-exact motion, and its closed forms."""

import numpy as np
import pytest

from contact.averaged.cycle_mean import cycle, respond
from contact.averaged.cycle_pieces import FORWARD, Counted, Mean, cycle_arrays
from contact.averaged.event_equilibrium import balanced, mean_tangential_force
from contact.averaged.riding import mean_loads, mean_normal_force, punch_means, quadrature, riding_height
from contact.body import normal_amplitude, tangential_amplitude
from contact.law.normal import PUNCH, SPHERE
from tests.contact.motors import orbit, slider


def means(problem, h, v, nodes=20):
    work = cycle_arrays(1)
    cycle(problem, h, v, FORWARD, quadrature(nodes), work)
    return work.means[: Mean.FRICTION], work.counts


# Oracle: the same cycle by collocation between events that are searched on interpolants
@pytest.mark.parametrize("A", [1e-9, 3e-9, 4.1e-9, 4.3e-9, 10e-9, 20e-9])
@pytest.mark.parametrize("share", [-1.1, -0.3, 0.03, 0.2, 0.6, 0.95, 1.1])
def test_mean_forces_are_those_of_the_general_motion(A, share):
    problem = balanced(slider(), (orbit(A),)).problem
    h = riding_height(slider(), orbit(A)) / problem.length
    v = share * float(tangential_amplitude(problem.paths, 0))
    friction = problem.friction * problem.preload
    (push, pull), _ = means(problem, h, v)
    general, _ = mean_tangential_force(problem, h, v, 0.0)
    # where slip hardly begins both ways lose digits
    assert pull == pytest.approx(general, abs=2e-7 * friction)
    assert push == pytest.approx(problem.preload, rel=1e-9)


def test_three_contacts_of_general_phase():
    trio = tuple(orbit(5e-9).scaled((1 + 0.1 * k) * np.exp(0.4j - 2j * np.pi * k / 7.0)) for k in range(3))
    problem = balanced(slider(), trio).problem
    h = riding_height(slider(), trio) / problem.length
    (push, pull), counts = means(problem, h, 0.2)
    general, _ = mean_tangential_force(problem, h, 0.2, 0.0)
    assert pull == pytest.approx(general, rel=1e-8)
    assert push == pytest.approx(problem.preload, rel=1e-11)
    assert counts[Counted.MADE] == 3
    assert counts[Counted.SLIPS] >= 3
    assert counts[Counted.STUCK] == 0


def test_beyond_the_surface_velocity_friction_is_full():
    problem = balanced(slider(), (orbit(3e-9),)).problem
    h = riding_height(slider(), orbit(3e-9)) / problem.length
    (push, pull), _ = means(problem, h, 5.0)
    assert pull == pytest.approx(-problem.friction * push, rel=1e-13)


def test_a_sticking_cycle_says_so():
    problem = balanced(slider(), (orbit(0.3e-9),)).problem
    h = riding_height(slider(), orbit(0.3e-9)) / problem.length
    assert means(problem, h, 0.0)[1][Counted.STUCK] == 1


# Oracle: Gauss-Legendre quadrature on the arc in contact; z + cos phi = delta - 2 sin^2(phi/2) is free of cancellation
@pytest.mark.parametrize("delta", [2.0**-30, 2.0**-9, 0.125, 0.75, 1.5, 2.0, 2.5])
def test_the_means_of_a_punch_are_integrals_over_its_arc(delta):
    half = 2.0 * np.arcsin(np.sqrt(0.5 * delta)) if delta < 2.0 else np.pi
    node, weight = np.polynomial.legendre.leggauss(40)
    phi, weight = 0.5 * half * (node + 1.0), 0.5 * half * weight / np.pi
    z = delta - 2.0 * np.sin(0.5 * phi) ** 2
    mean, first, arc = punch_means(delta - 1.0, 1.0)
    assert mean == pytest.approx(weight @ z, rel=1e-13, abs=0.0)
    assert first == pytest.approx(2.0 * weight @ (z * np.cos(phi)), rel=1e-13, abs=0.0)
    assert arc == pytest.approx(half, rel=1e-14)
    assert mean_loads(delta - 1.0, 1.0, PUNCH)[:, 0] == pytest.approx([mean, half / np.pi], rel=1e-13, abs=0.0)
    assert mean_loads(delta - 1.0, 1.0, SPHERE)[0, 0] == pytest.approx(weight @ z**1.5, rel=1e-6)


def test_the_slope_of_the_mean_normal_force_is_its_derivative():
    problem = balanced(slider(), (orbit(10e-9),)).problem
    rule, a = quadrature(24), float(normal_amplitude(problem.paths, 0))
    for h in (-0.9 * a, -0.2 * a, 0.3 * a, 0.999 * a, 1.7 * a):
        step = 1e-5 * a
        rise = mean_normal_force(problem, h + step, rule)[0] - mean_normal_force(problem, h - step, rule)[0]
        # the difference quotient's own error
        assert mean_normal_force(problem, h, rule)[1] == pytest.approx(rise / (2.0 * step), rel=1e-6)


def test_the_fast_motion_obeys_its_equation():
    # Property: z'' + d z' = F harmonic by harmonic, and the same for the travel
    work = cycle_arrays(3, 1)
    for number, amplitudes in enumerate(work.force):
        amplitudes[:] = np.arange(1.0, 13.0)[number::4]
    problem = balanced(slider(), (orbit(3e-9),)).problem._replace(normal_damping=0.3, tangential_damping=0.07)
    respond(problem, work)
    phase = np.linspace(0.0, 2.0 * np.pi, 7)
    for side, damping in (("normal", 0.3), ("tangential", 0.07)):
        second = force = 0.0
        (cos, sin), (f_cos, f_sin) = (
            (getattr(part, f"{side}_cos"), getattr(part, f"{side}_sin")) for part in (work.fast, work.force)
        )
        for k in range(3):
            n = k + 1
            a, b = cos[k], sin[k]
            second += -n * n * (a * np.cos(n * phase) + b * np.sin(n * phase))
            second += damping * n * (b * np.cos(n * phase) - a * np.sin(n * phase))
            force += f_cos[k] * np.cos(n * phase) + f_sin[k] * np.sin(n * phase)
        assert second == pytest.approx(force, rel=1e-12)


# A part of a cycle is no cycle: with more events than are followed the means are not numbers
def test_a_cycle_with_more_events_than_are_followed_has_no_means(monkeypatch):
    from contact.averaged import cycle_mean

    problem = balanced(slider(), (orbit(3e-9),)).problem
    work, plain = cycle_arrays(1), getattr(cycle_mean.cycle, "function", cycle_mean.cycle)
    names = ("_add_contact", "_follow_contact")
    for name in names:
        monkeypatch.setattr(cycle_mean, name, getattr(getattr(cycle_mean, name), "function", getattr(cycle_mean, name)))
    plain(problem, 1.0, 0.05, FORWARD, quadrature(16), work)
    assert np.all(np.isfinite(work.means))
    monkeypatch.setattr(cycle_mean, "MAX_EVENTS", 1)
    plain(problem, 1.0, 0.05, FORWARD, quadrature(16), work)
    assert np.all(np.isnan(work.means[: Mean.FRICTION]))
