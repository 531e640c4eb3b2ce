r"""Mean approach h of a heavy slider that rides on a wave: the cycle mean of the normal forces equals the preload.

A heavy slider does not move within a cycle. Contact i of height h_i then has the approach z_i = h + h_i + Re(U_i
exp(i omega t)), with the same h for all contacts. The cycle mean of a contact's load, <p(z)>, depends only on its mean
approach and on |u_z|. It is integrated over half of the phases in contact, 0 < phi < beta. With the substitution
phi = beta (1 - cos theta)/2 the square root at the end of the arc becomes smooth, so that Gauss-Legendre quadrature in
theta converges spectrally. For a flat punch the mean has a closed form.
"""

from functools import cache
from typing import NamedTuple

import numpy as np

from contact.averaged.adhesive_motion import holding_balls
from contact.body import Coordinates, approach, circle, normal_amplitude
from contact.codes import Shape, Tangential
from contact.jit.compiled import compiled, formula, native, summed
from contact.law.elastic import coulomb
from contact.law.normal import NormalLaw, load, plain, slope
from contact.law.normal import approach as approach_under
from contact.passing_wave import Surface, prescribed
from contact.problem import Problem, scaled
from contact.slider import Slider

NODES = 48  # of the answer for one slider


class Rule(NamedTuple):
    """A quadrature: nodes in [0, 1] and weights, arrays (n,)."""

    node: np.ndarray
    weight: np.ndarray


@cache
def quadrature(nodes: int) -> Rule:
    """Return Gauss and Legendre's rule in theta."""
    point, weight = np.polynomial.legendre.leggauss(nodes)
    theta = 0.5 * np.pi * (point + 1.0)
    return Rule(0.5 * (1.0 - np.cos(theta)), 0.25 * np.pi * weight * np.sin(theta))


@formula
def arc(z, a):
    """Return half of the arc of a cycle in which z + a cos phi is positive; z > -a."""
    return np.arccos(-np.minimum(z / np.maximum(a, 1e-300), 1.0))


@compiled
def punch_means(z, a):
    """Return (<z>, z_1, half of the arc in contact) of z + a cos phi where it is positive; z > -a, z_1 of cos phi."""
    if z >= a:
        return z, a, np.pi
    p = 2.0 * np.arcsin(np.sqrt(0.5 * (z + a) / a))
    if p < 0.1:  # series: the closed form loses digits as p^-3 does
        q = p * p
        mean = p * q * (1.0 / 3.0 - q * (1.0 / 30.0 - q * (1.0 / 840.0 - q / 45360.0)))
        first = p * q * (2.0 / 3.0 - q * (2.0 / 15.0 - q * (4.0 / 315.0 - q / 1417.5)))
    else:
        mean, first = np.sin(p) - p * np.cos(p), p - np.sin(p) * np.cos(p)
    return a * mean / np.pi, a * first / np.pi, p


@summed
def _sums_over_arc(z, a, half, rule, normal):
    """Return the sums of p and dp/dz of z + a cos phi over the half of a cycle that is in contact."""
    force = rate = 0.0
    for j in range(rule.weight.size):
        co, _ = circle(half * rule.node[j])
        force += rule.weight[j] * load(z + a * co, normal)
        rate += rule.weight[j] * slope(z + a * co, normal)
    return force, rate


@compiled
def load_means(z, a, rule, normal):
    """Return the cycle means of p(z + a cos phi), less the attraction, and of its derivative in z."""
    if z <= -a:
        return 0.0, 0.0
    if normal.shape == Shape.PUNCH and plain(normal):
        mean, _, half = punch_means(z, a)
        return mean, half / np.pi
    half = arc(z, a)
    force, rate = _sums_over_arc(z, a, half, rule, normal)
    bend = normal.pull / np.sqrt(a * a - z * z) if normal.pull > 0.0 and z < a else 0.0
    return (force - normal.pull) * half / np.pi, (rate * half - bend) / np.pi


@native("f1 f1 t t f2", {"z": "n", "a": "n", "out": "2 n"})
def _mean_loads(z, a, rule, normal, out):
    for i in range(z.size):
        out[0, i], out[1, i] = load_means(z[i], a[i], rule, normal)
    return 0


def mean_loads(z, a, normal):
    """Return the cycle means of p(z + a cos phi) and of its derivative in z; arrays (n,)."""
    z, a = np.broadcast_arrays(np.atleast_1d(z), np.atleast_1d(a))
    out = np.empty((2, z.size))
    _mean_loads(np.ascontiguousarray(z, float), np.ascontiguousarray(a, float), quadrature(NODES), normal, out)
    return out


def mean_load(z: float, a: float, normal: NormalLaw) -> float:
    """Return the cycle mean of p(z + a cos phi)."""
    return float(mean_loads(z, a, normal)[0][0])


@compiled
def mean_normal_force(problem, h, rule):
    """Return the cycle mean of sum P at constant approach and its derivative in h."""
    paths, factors = problem.paths, problem.factors
    total = steepness = force = rate = 0.0
    last_a, last_z = -1.0, 0.0
    for i in range(paths.height.size):
        a, z = normal_amplitude(paths, i), approach(paths, i, 0.0, Coordinates(-h, 0.0))
        if a != last_a or z != last_z:
            last_a, last_z = a, z
            force, rate = load_means(z, a, rule, problem.normal)
        kappa = problem.stiffness * factors.stiffness[i]
        total += kappa * force
        steepness += kappa * rate
    return total, steepness


@compiled
def riding(problem, rule):
    """Return the mean approach at which the cycle mean of sum P is the preload.

    The mean load of smooth contacts is convex in h, so that Newton's method falls from any h that is too large, until
    rounding stops it; the others are searched by `_riding_between`.
    """
    paths, target, n = problem.paths, problem.preload, problem.paths.height.size
    least, reach, number = np.inf, 0.0, 0.0
    for i in range(n):
        number += problem.factors.stiffness[i]
        least, reach = min(least, paths.height[i]), max(reach, normal_amplitude(paths, i))
    if not plain(problem.normal):
        return _riding_between(problem, rule, least, reach)
    # too large: the mean load is at least that of the mean approach, and no contact is lower than the lowest
    h = approach_under(target / (problem.stiffness * number), problem.normal) - least
    for _ in range(80):
        force, steepness = mean_normal_force(problem, h, rule)
        step = (force - target) / steepness if steepness > 0.0 else 0.0
        h -= step
        if step < 1e-15 * (reach + abs(h)):
            break
    return h


@compiled
def _riding_between(problem, rule, least, reach):
    """Return what `riding` returns, by a search between bounds, of contacts that attract or whose force is not convex.

    With attraction there may be two heights: one with all contacts closed throughout, where a slider from rest stays
    as long as it exists, and one of a slider that hops.
    """
    paths, law = problem.paths, problem.normal
    number = closed = top = 0.0
    for i in range(paths.height.size):
        number += problem.factors.stiffness[i]
        closed = max(closed, normal_amplitude(paths, i) - paths.height[i])
        top = max(top, paths.height[i])
    high = approach_under(problem.preload / (problem.stiffness * number) + law.pull, law) - least + reach
    low = -reach - top
    if law.pull > 0.0 and closed < high:
        if mean_normal_force(problem, closed, rule)[0] <= problem.preload:
            low = closed
        else:
            high = closed
    h = 0.5 * (low + high)
    for _ in range(200):
        force, steepness = mean_normal_force(problem, h, rule)
        if force > problem.preload:
            high = h
        else:
            low = h
        new = h - (force - problem.preload) / steepness if steepness > 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - h) < 1e-15 * (reach + abs(h)) or high - low < 1e-15 * (reach + abs(h)):
            return new
        h = new
    return h


@compiled
def mean_pull(problem, h):
    """Return the cycle mean of the attraction of all contacts at constant approach."""
    total = 0.0
    for i in range(problem.paths.height.size):
        a, z = normal_amplitude(problem.paths, i), approach(problem.paths, i, 0.0, Coordinates(-h, 0.0))
        if z > -a:
            total += problem.stiffness * problem.factors.stiffness[i] * problem.normal.pull * arc(z, a) / np.pi
    return total


@native("t t f1")
def _riding(problem, rule, answer):
    answer[0] = riding(problem, rule)
    return 0


def riding_approach(problem: Problem, nodes: int = NODES) -> float:
    """Return h of a scaled problem, by quadrature with so many nodes; see `riding_height`."""
    answer = np.zeros(1)
    # the tangential law does not enter: one kernel serves all
    _riding(problem._replace(law=coulomb(Tangential.ELASTIC)), quadrature(nodes), answer)
    return float(answer[0])


def riding_height(slider: Slider, orbits: Surface) -> float:
    """Return h in m, the mean approach of a contact of height 0 at which <sum P_i> is the preload (preload > 0).

    Negative when the slider hops: it rides above the undisturbed surface.
    """
    slider, listed = prescribed(slider, orbits)
    if slider.profile.hold is not None:
        return holding_balls(slider).height(tuple(listed))
    problem = scaled(slider, listed, direction=1.0, start=0.0)
    return riding_approach(problem) * problem.length
