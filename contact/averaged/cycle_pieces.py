r"""Integrals of a contact's forces over a smooth piece of the cycle, between two of its events.

In the units of `contact.problem` a contact has at the phase phi the approach z = h + sum z_k and, relative to the
slider, the travel y = -v phi + sum y_k of the surface, with the harmonics z_k and y_k of `Path`. While it sticks its
deformation is x = offset + y; while it slips towards s, with |x| at the slip limit X(z), it has the force of the law at
the speed of slip g_s = s y' - X'(z) z'. P = kappa z^n is the elastic normal force, chi the contact's damping. Two
ways:

*By quadrature*, for any law and profile and any number of harmonics. The integrals are taken in theta,
phi = phi_1 + (phi_2 - phi_1)(1 - cos theta)/2, which makes the square roots at contact, release and the end of stick
smooth: Gauss-Legendre quadrature converges exponentially.

*Closed*, for a flat contact with Coulomb's friction on one harmonic (`CLOSED`, a rule without nodes). P = kappa z, and
Q is proportional to x; both are linear in (1, cos phi, sin phi, phi). The work lost to friction is that of the limit
force on the slip, X g_s, also a sum of closed integrals. It is not obtained from the energy balance, which therefore
checks it. Normal part with the amplitude A of z, in contact over 2 p of the cycle, cos p = -h/A
(`riding.punch_means`): <z> = A (sin p - p cos p)/pi and the first harmonic z_1 = A (p - sin p cos p)/pi.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.averaged.riding import Rule, punch_means
from contact.body import circle, slip_speed
from contact.jit.compiled import compiled, formula, summed
from contact.law.normal import load

TURN = 2.0 * np.pi
# Side of the slider: the direction of its mean motion or, at a mean velocity of 0, of the motion before. It decides to
# which of its limits a contact that never slips is deformed.
FORWARD, BACKWARD = 1.0, -1.0
CLOSED = Rule(np.empty(0), np.empty(0))


class Mean(IntEnum):
    """Indices of the means: sum of P, of Q and, with closed integrals, of the power lost to friction."""

    NORMAL = 0
    TANGENTIAL = 1
    FRICTION = 2


class Counted(IntEnum):
    """Indices of the counts: contacts made, slips begun, contacts that stick throughout, deformed by earlier cycles."""

    MADE = 0
    SLIPS = 1
    STUCK = 2


class Harmonics(NamedTuple):
    """Amplitudes of a normal and a tangential quantity in the first K harmonics of the wave; arrays (K,)."""

    normal_cos: np.ndarray
    normal_sin: np.ndarray
    tangential_cos: np.ndarray
    tangential_sin: np.ndarray


class Nodes(NamedTuple):
    """Work arrays at the n nodes of a piece: cos and sin of the harmonics (K, n); z, x and then the forces, (n,)."""

    cos: np.ndarray
    sin: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray


class Cycle(NamedTuple):
    """Arrays of a cycle: its input `fast`, its results `force`, `means` and `counts`, and work arrays."""

    fast: Harmonics  # of the slider's own fast motion: z_s, and its travel
    path: Harmonics  # of a contact relative to the slider
    force: Harmonics  # of P (1 + chi z') and of Q; empty if only the means are wanted
    nodes: Nodes  # one per node of the quadrature; empty likewise
    means: np.ndarray  # (len(Mean),) array: See `Mean`
    counts: np.ndarray  # (len(Counted),) int array: See `Counted`


class Path(NamedTuple):
    """Motion of one contact: mean approach, mean velocity of the slider, and harmonics of z and y."""

    h: float
    v: float
    side: float  # FORWARD or BACKWARD
    wave: Harmonics
    # amplitude of z in the first harmonic, and the phase of its crest
    reach: float
    crest: float


class Anchor(NamedTuple):
    """Where stick began: deformation x and travel y there."""

    x: float
    y: float


class Passage(NamedTuple):
    """The part of the cycle that a contact is followed through, and how it begins: slip of a sign, or stick (0)."""

    start: float
    stop: float
    slip: float
    x: float  # deformation at the start


def cycle_arrays(harmonics: int, nodes: int = 0) -> Cycle:
    """Return the arrays of a cycle of so many harmonics, the slider without fast motion.

    `nodes` of the quadrature where the harmonics of the forces are wanted, else 0; with closed integrals 1, because any
    number above 0 makes room for the harmonics.
    """
    fast, path, force = (Harmonics(*np.zeros((4, n))) for n in (harmonics, harmonics, harmonics * (nodes > 0)))
    at_nodes = Nodes(*np.zeros((2, harmonics, nodes)), *np.zeros((2, nodes)))
    return Cycle(fast, path, force, at_nodes, np.zeros(len(Mean)), np.zeros(len(Counted), np.int64))


@formula
def first_harmonic(path):
    """Return the amplitudes a, b of z and d, e of y in the first harmonic, z = ... + a cos phi + b sin phi."""
    wave = path.wave
    return wave.normal_cos[0], wave.normal_sin[0], wave.tangential_cos[0], wave.tangential_sin[0]


@compiled
def motion_at(path, phi):
    """Return z, z', y, y' of a path at a phase, eq. (1) of `cycle_mean`."""
    if path.wave.normal_cos.size > 1:
        return _motion_of_harmonics(path, phi)
    a, b, d, e = first_harmonic(path)
    co, si = np.cos(phi), np.sin(phi)
    z, y = path.h + (a * co + b * si), -path.v * phi + (d * co + e * si)
    return z, b * co - a * si, y, -path.v + (e * co - d * si)


@compiled
def _motion_of_harmonics(path, phi):
    """Do the work of `motion_at` for several harmonics."""
    a, b, d, e = path.wave
    co, si = np.cos(phi), np.sin(phi)
    c, s = co, si
    z, z_rate, y, y_rate = path.h, 0.0, -path.v * phi, -path.v
    for k in range(a.size):
        z += a[k] * c + b[k] * s
        y += d[k] * c + e[k] * s
        z_rate += (k + 1) * (b[k] * c - a[k] * s)
        y_rate += (k + 1) * (e[k] * c - d[k] * s)
        c, s = c * co - s * si, s * co + c * si
    return z, z_rate, y, y_rate


@compiled
def add_integrals(problem, path, rule, work, start, stop, slip, offset):
    """Add the integrals of the forces from one event to the next; `slip` is its sign, 0 in stick: x = offset + y.

    The quadrature is cut at the trough of a contact that stays closed: where z almost comes to zero, its 3/2 power has
    branch points just off the real axis.
    """
    if rule.weight.size == 0:
        _add_closed(problem, path, work, start, stop, slip, offset)
        return
    if path.h >= path.reach:
        trough = path.crest + np.pi
        trough += TURN * np.ceil((start - trough) / TURN)
        while trough < stop:
            _add_piece(problem, path, rule, work, start, trough - start, slip, offset)
            start, trough = trough, trough + TURN
    _add_piece(problem, path, rule, work, start, stop - start, slip, offset)


@compiled
def _add_closed(problem, path, work, start, stop, slip, offset):
    """Add the closed integrals of Q, of its first harmonic and of the friction power over a piece.

    With x = base + co cos phi + si sin phi + drift (phi - start), Q = stiffness x. In slip x = s c z, and the friction
    power is stiffness c z g_s with g_s = alpha + beta cos phi + gamma sin phi, eq. (3) of `cycle_mean`.
    """
    h, v, force, law = path.h, path.v, work.force, problem.law
    a, b, d, e = first_harmonic(path)
    c = law.limit_ratio(problem, h)  # one number: X = c z makes all integrals closed
    stiffness = problem.stiffness * law.coefficient(problem, h) / c
    c1, s1, c2, s2 = np.cos(start), np.sin(start), np.cos(stop), np.sin(stop)
    # integrals of 1, cos, sin and their products
    width = stop - start
    cos, sin = s2 - s1, c1 - c2
    cos_cos = 0.5 * (width + s2 * c2 - s1 * c1)
    cos_sin, sin_sin = 0.5 * (s2 * s2 - s1 * s1), width - cos_cos
    if slip != 0.0:
        base, co, si, drift = slip * c * h, slip * c * a, slip * c * b, 0.0
        alpha, beta, gamma = -slip * v, slip * e - c * b, c * a - slip * d
        work.means[Mean.FRICTION] += stiffness * c * (
            h * alpha * width + (h * beta + a * alpha) * cos + (h * gamma + b * alpha) * sin
            + a * beta * cos_cos + (a * gamma + b * beta) * cos_sin + b * gamma * sin_sin
        )  # fmt: skip
    else:
        base, co, si, drift = offset - v * start, d, e, -v
    # integrals of (phi - start) times 1, cos, sin
    t, t_cos, t_sin = 0.5 * width * width, width * s2 - sin, cos - width * c2
    work.means[Mean.TANGENTIAL] += stiffness * (base * width + co * cos + si * sin + drift * t)
    force.tangential_cos[0] += stiffness * (base * cos + co * cos_cos + si * cos_sin + drift * t_cos)
    force.tangential_sin[0] += stiffness * (base * sin + co * cos_sin + si * sin_sin + drift * t_sin)


@compiled
def add_closed_normal(problem, path, work):
    """Add the closed integrals of P and of its first harmonic over a cycle; return half of the arc in contact."""
    mean, first, half = punch_means(path.h, path.reach)
    work.means[Mean.NORMAL] += TURN * problem.stiffness * mean
    if path.reach > 0.0:
        a, b, _, _ = first_harmonic(path)
        first *= np.pi * problem.stiffness / path.reach
        work.force.normal_cos[0] += first * a
        work.force.normal_sin[0] += first * b
    return half


@compiled
def _add_piece(problem, path, rule, work, start, width, slip, offset):
    """Add the integrals of the forces over one smooth piece."""
    kappa = problem.stiffness
    if path.wave.normal_cos.size == 1 and work.force.normal_cos.size == 0:
        normal_sum, tangential_sum = _first_harmonic_sums(problem, path, rule, start, width, slip, offset)
    else:
        _motion_at_nodes(path, rule, work.nodes, start, width, offset)
        normal_sum, tangential_sum = _forces_at_nodes(problem, path, rule, work.nodes, slip)
        if slip != 0.0 and path.wave.normal_cos.size == 1:
            work.means[Mean.FRICTION] += kappa * width * _loss_at_nodes(problem, path, rule, work.nodes, slip)
        _add_harmonics(problem, path, rule, work, kappa * width)
    work.means[Mean.NORMAL] += kappa * width * (normal_sum - problem.normal.pull)
    work.means[Mean.TANGENTIAL] += kappa * width * tangential_sum


@summed
def _motion_at_nodes(path, rule, nodes, start, width, offset):
    """Fill the harmonics' cosines and sines, the approach and the deformation at the nodes of a piece."""
    h, v, wave, n = path.h, path.v, path.wave, rule.node.size
    cos, sin, z, x = nodes.cos, nodes.sin, nodes.normal, nodes.tangential
    for j in range(n):
        phi = start + width * rule.node[j]
        cos[0, j], sin[0, j] = circle(phi)
        z[j] = h
        x[j] = offset - v * phi
    for k in range(wave.normal_cos.size):
        a, b, d, e = wave.normal_cos[k], wave.normal_sin[k], wave.tangential_cos[k], wave.tangential_sin[k]
        if k > 0:
            for j in range(n):
                cos[k, j] = cos[k - 1, j] * cos[0, j] - sin[k - 1, j] * sin[0, j]
            for j in range(n):
                sin[k, j] = sin[k - 1, j] * cos[0, j] + cos[k - 1, j] * sin[0, j]
        for j in range(n):
            z[j] += a * cos[k, j] + b * sin[k, j]
        for j in range(n):
            x[j] += d * cos[k, j] + e * sin[k, j]


@summed
def _forces_at_nodes(problem, path, rule, nodes, slip):
    """Replace approach and deformation at the nodes by the weighted forces P/kappa and Q/kappa; return their sums."""
    law, normal, wave = problem.law, problem.normal, path.wave
    z, x = nodes.normal, nodes.tangential
    normal_sum = tangential_sum = 0.0
    if slip != 0.0:  # in slip x holds the speed of slip, which the force may depend on
        for j in range(rule.weight.size):
            x[j] = -slip * path.v
            if law.rated:
                slope = law.limit_rate(problem, z[j])
                for k in range(wave.normal_cos.size):
                    co, si = (k + 1) * nodes.cos[k, j], (k + 1) * nodes.sin[k, j]
                    x[j] += slip * (wave.tangential_sin[k] * co - wave.tangential_cos[k] * si)
                    x[j] -= slope * (wave.normal_sin[k] * co - wave.normal_cos[k] * si)
    for j in range(rule.weight.size):
        if slip == 0.0:
            force = law.stuck(problem, z[j], abs(x[j]))
            force = -force if x[j] < 0.0 else force
        else:
            force = slip * law.sliding(problem, z[j], max(x[j], 0.0))
        z[j] = rule.weight[j] * load(z[j], normal)
        x[j] = rule.weight[j] * force
        normal_sum += z[j]
        tangential_sum += x[j]
    return normal_sum, tangential_sum


@summed
def _loss_at_nodes(problem, path, rule, nodes, slip):
    """Return the integral of the friction power over kappa of a slip, from the weighted forces at the nodes."""
    a, b, d, e = first_harmonic(path)
    cos, sin, loss = nodes.cos, nodes.sin, 0.0
    for j in range(rule.weight.size):
        co, si = cos[0, j], sin[0, j]
        slope = problem.law.limit_rate(problem, path.h + a * co + b * si)
        loss += slip * nodes.tangential[j] * slip_speed(slip, b * co - a * si, e * co - d * si - path.v, slope)
    return loss


@summed
def _add_harmonics(problem, path, rule, work, scale):
    """Add the harmonics of the forces at the nodes, the damper's with them."""
    wave, force, nodes = path.wave, work.force, work.nodes
    cos, sin, normal, tangential = nodes.cos, nodes.sin, nodes.normal, nodes.tangential
    # P z' is a total derivative, so that the damper's mean over a cycle is zero
    if problem.contact_damping > 0.0:
        for j in range(rule.weight.size):
            rate = 0.0
            for k in range(wave.normal_cos.size):
                rate += (k + 1) * (wave.normal_sin[k] * cos[k, j] - wave.normal_cos[k] * sin[k, j])
            normal[j] *= 1.0 + problem.contact_damping * rate
    if problem.normal.pull > 0.0:
        for j in range(rule.weight.size):
            normal[j] -= rule.weight[j] * problem.normal.pull
    for k in range(force.normal_cos.size):
        a = b = d = e = 0.0
        for j in range(rule.weight.size):
            a += normal[j] * cos[k, j]
            b += normal[j] * sin[k, j]
            d += tangential[j] * cos[k, j]
            e += tangential[j] * sin[k, j]
        force.normal_cos[k] += scale * a
        force.normal_sin[k] += scale * b
        force.tangential_cos[k] += scale * d
        force.tangential_sin[k] += scale * e


@summed
def _first_harmonic_sums(problem, path, rule, start, width, slip, offset):
    """Return the integrals of normal and tangential force over a smooth piece of a path of one harmonic."""
    law, normal = problem.law, problem.normal
    h, v = path.h, path.v
    a, b, d, e = first_harmonic(path)
    normal_sum, tangential_sum = 0.0, 0.0
    for j in range(rule.weight.size):
        phi = start + width * rule.node[j]
        co, si = circle(phi)
        z = h + a * co + b * si
        normal_sum += rule.weight[j] * load(z, normal)
        if slip == 0.0:
            x = offset + d * co + e * si - v * phi
            force = law.stuck(problem, z, abs(x))
            tangential_sum += rule.weight[j] * (-force if x < 0.0 else force)
        else:
            speed = slip * (e * co - d * si - v) - law.limit_rate(problem, z) * (b * co - a * si)
            tangential_sum += rule.weight[j] * slip * law.sliding(problem, z, max(speed, 0.0))
    return normal_sum, tangential_sum
