"""Sums across edges: against mpmath-free definitions and integrals in closed form; the stepped way that uses them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import brentq
from scipy.special import zeta

from contact import burst
from contact.law.normal import PUNCH, SPHERE
from contact.stepping.end_corrections import (
    cubic,
    edge_excess,
    last_part,
    passage_excess,
    rising_root,
    zeta_five_halves,
    zeta_three_halves,
)
from tests.contact.motors import orbit, slider


@pytest.mark.parametrize(("function", "power"), [(zeta_three_halves, 1.5), (zeta_five_halves, 2.5)])
def test_hurwitz_zeta(function, power):
    # Closed form: Riemann's functional equation at 1, zeta(-a) = -2^-a pi^(-a-1) sin(pi a/2) Gamma(1+a) zeta(1+a)
    from math import gamma, pi, sin

    riemann = -(2.0**-power) * pi ** (-power - 1.0) * sin(0.5 * pi * power) * gamma(1.0 + power) * zeta(1.0 + power)
    assert function(1.0) == pytest.approx(riemann, rel=2e-6)  # the fit keeps 1e-8 of the largest value
    assert function(0.0) == pytest.approx(riemann, rel=2e-6)
    # Property: the mean over theta vanishes
    node, weight = np.polynomial.legendre.leggauss(400)
    values = [function(0.5 * (t + 1.0)) for t in node]
    assert 0.5 * np.dot(weight, values) == pytest.approx(0.0, abs=2e-8)


@pytest.mark.parametrize(("shape", "a"), [(SPHERE, 1.5), (PUNCH, 1.0)])
@pytest.mark.parametrize("theta", [0.07, 0.5, 0.93])
def test_the_sum_less_its_excess_is_the_integral(theta, shape, a):
    # (2 t^a - 3 t^(a+1)) (1 - t)^8 on [0, 1], smooth at the far end; Euler's beta function
    from scipy.special import beta

    exact = 2.0 * beta(a + 1.0, 9.0) - 3.0 * beta(a + 2.0, 9.0)
    errors = []
    for number in (40, 80, 160):
        h = 1.0 / number
        t = (np.arange(number) + theta) * h
        total = h * np.sum((2.0 * t**a - 3.0 * t ** (a + 1.0)) * (1.0 - t) ** 8)
        errors.append(abs(total - edge_excess(theta, h, 2.0, -3.0 - 16.0, shape) - exact))
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    assert orders == pytest.approx(a + 3.0, abs=0.2)


@pytest.mark.parametrize("s", [0.1, 0.45, 0.8])
def test_a_passage_through_zero(s):
    h = 1.0 / 60.0
    t = (np.arange(-60, 60) + 1.0 - s) * h
    window = (1.0 - t**2) ** 6  # even, so the integral of t |t| times it is zero
    total = h * np.sum(-t * np.abs(t) * window)
    assert passage_excess(s, h, 1.0) == pytest.approx(total, rel=1e-2)


def test_root_of_a_rising_cubic():
    y0, y1, r0, r1 = -0.4, 0.7, 0.5, 2.0
    assert cubic(rising_root(y0, y1, r0, r1), y0, y1, r0, r1) == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize(("A", "allowed"), [(3e-9, 1.5e-5), (4.3e-9, 2e-5), (10e-9, 1.5e-5), (20e-9, 1e-6)])
def test_48_steps_per_cycle_keep_five_digits(A, allowed):
    # Oracle: the event-exact way
    from contact.answers.rest_motion import rest, rest_problem
    from contact.stepping.time_stepping import steps

    problem = rest_problem(slider(), (orbit(A),))
    motion = rest(slider(), (orbit(A),), problem, nodes=14, truncation=1e-11)
    state = motion.state.copy()
    motion.turn(1500)
    steps(problem, state, 1500, 48)
    reference = max(abs(motion.state[2]), 0.07 * A / problem.length)
    assert abs(state[2] - motion.state[2]) / reference < allowed
    # the height too, against the rest approach
    assert abs(state[0] - motion.state[0]) * problem.length / slider().rest_approach(1) < 3.0 * allowed


@given(st.floats(0.01, 2.0), st.floats(-2.0, -0.01), st.floats(-0.3, 0.3))
@settings(max_examples=50, deadline=None, derandomize=True)
def test_the_last_part_of_a_parabola(v0, v1, bulge):
    # Oracle: Brent's method and numpy's polynomials, for ends v0 and v1 and a bulge
    bulge *= min(v0, -v1)
    f = np.polynomial.Polynomial([v0, v1 - v0 + bulge, -bulge])
    found, part = last_part(v0, v1, f.integ()(1.0))
    root = brentq(f, 0.0, 1.0, xtol=1e-15)
    assert found == pytest.approx(root, abs=2e-4)
    assert part == pytest.approx(f.integ()(1.0) - f.integ()(root), abs=1e-6)


def test_slip_and_stick_are_followed_to_high_order():
    # Oracle: the event-exact way at 3 nm, cycle by cycle, each with two slips; 7e-6 of the friction's impulse with
    # edges of first order
    from contact.answers.rest_motion import rest, rest_problem
    from contact.stepping.time_stepping import steps

    problem = rest_problem(slider(), (orbit(3e-9),))
    motion = rest(slider(), (orbit(3e-9),), problem, nodes=14, truncation=1e-11)
    motion.turn(800)
    gained = []
    for _ in range(40):
        state = motion.state.copy()
        steps(problem, state, 1, 48)
        motion.turn(1)
        gained.append(state[2] - motion.state[2])
    impulse = 2.0 * np.pi * problem.friction * problem.preload
    assert np.sqrt(np.mean(np.square(gained))) < 2.5e-6 * impulse


@pytest.mark.parametrize("A", [2e-9, 10e-9])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-6])
def test_the_stepped_estimate_is_honest(A, tolerance):
    exact = burst(slider(), orbit(A), duration=5e-4, after=0.0, tolerance=1e-8, samples=2, method="exact")
    found = burst(slider(), orbit(A), duration=5e-4, after=0.0, tolerance=tolerance, samples=2, method="stepped")
    v = exact.velocity_at_burst_end
    error = abs(found.velocity_at_burst_end - v) / max(abs(v), 2.0 * np.pi * 2.2e6 * 0.07 * A)
    assert found.relative_error <= tolerance
    assert error < 2.0 * found.relative_error
    assert 0.0 < found.statistics["omega_n_dt"] < 0.01
