r"""The trapezoidal rule across an edge where a force begins or ends as a fractional power of time.

For f = C t^a, t > 0 the time from an edge, sampled at t = (j + theta) h, j = 0, 1 ..., the rule's sum is

    h sum_j f = int f dt + C h^(a+1) zeta(-a, theta),                                                           (1)

zeta Hurwitz's function (Navot, J. Math. and Phys. 40 (1961) 271; Lyness and Ninham, Math. Comp. 21 (1967) 162). The
last term is the *excess*. For integers zeta(-n, theta) = -B_(n+1)(theta)/(n + 1) with Bernoulli's polynomials B_n.

Contact, release and the end of stick are edges of a force P = K p(z), p = z^m (`law.normal`), with the approach z, the
stiffness K, and m = 3/2 for a sphere and 1 for a punch. With z = z' t + z'' t^2/2,

    p(z) = p(z') [p(t) + m z''/(2 z') t p(t) + ...],     the terms a = m and a = m + 1.                         (2)

At x = 0 the tangential force of a sphere has a jump in curvature, a = 2 on both sides; for a punch it is smooth there.
Subtracting these terms leaves the rule its accuracy for smooth periodic functions.
"""

import numpy as np

from contact.codes import Shape
from contact.jit.compiled import compiled
from contact.law.normal import edge_load, exponent, load, smooth_force, smooth_slope
from contact.law.protocol import slip_limit


@compiled
def zeta_three_halves(theta):
    """Return zeta(-3/2, theta) on [0, 1] to 1e-8: theta^1.5 plus the smooth zeta(-3/2, 1 + theta)."""
    smooth = -0.02548521102488416 + theta * (-0.31182812373074353 + theta * (-0.5476597212373369 + theta * (
        -0.16304407482012848 + theta * (0.030445687423321655 + theta * (-0.010723098451273515 + theta * (
            0.003383023079009234 - theta * 0.0005736902764518283))))))  # fmt: skip
    return theta * theta**0.5 + smooth


@compiled
def zeta_five_halves(theta):
    """Return zeta(-5/2, theta) on [0, 1] to 1e-8."""
    smooth = 0.008516934787262741 + theta * (-0.0637137980807522 + theta * (-0.38976932454492436 + theta * (
        -0.4565074931076384 + theta * (-0.10142109125846284 + theta * (0.014208581815920938 + theta * (
            -0.0032821215636875054 + theta * 0.00048524563270975273))))))  # fmt: skip
    return theta * theta * theta**0.5 + smooth


@compiled
def zeta_one_half(theta):
    """Return zeta(-1/2, theta) on [0, 1] to 1e-8: four terms of the sum, Euler's and Maclaurin's rule for the rest."""
    total, q = 0.0, theta + 4.0
    for k in range(4):
        total += np.sqrt(theta + k)
    root = np.sqrt(q)
    rest = 1.0 / (1920.0 * root * q * q) - 1.0850694e-4 / (root * q**4)
    return total - root * q / 1.5 + 0.5 * root - 1.0 / (24.0 * root) + rest


@compiled
def whole_excess(theta, h, jump, slope):
    """Return the excess (1) for jump + slope t: zeta(0, theta) = 1/2 - theta, zeta(-1, theta) = -B_2/2."""
    return h * jump * (0.5 - theta) - 0.5 * h * h * slope * (theta * (theta - 1.0) + 1.0 / 6.0)


@compiled
def break_excess(theta, h, rate, bend, terms):
    """Return the excess (1) of the rule for a force of a contact that holds on, over its stiffness, where it opens.

    `terms` (`law.holding.Terms`) are its coefficients of 1, s, s^2 and s^3, s^2 the approach from the end on: in the
    time t before the end rate t + bend t^2/2. This gives the terms a = 0, 1/2, 1, 3/2.
    """
    speed = np.sqrt(rate)
    last = terms.mixed * speed**3 + 0.25 * terms.root * bend / speed
    fractional = terms.root * speed * zeta_one_half(theta) + h * last * zeta_three_halves(theta)
    return whole_excess(theta, h, terms.one, terms.linear * rate) + h * np.sqrt(h) * fractional


@compiled
def edge_excess(theta, h, first, second, normal):
    """Return the excess (1) for first p(t) + second t p(t); the sample next to the edge is at t = theta h."""
    if normal.shape == Shape.PUNCH:  # zeta(-1, theta) = -B_2/2 and zeta(-2, theta) = -B_3/3
        b2, b3 = theta * (theta - 1.0) + 1.0 / 6.0, theta * (theta - 0.5) * (theta - 1.0)
        return -h * h * (0.5 * first * b2 + h * second * b3 / 3.0)
    root = h**0.5
    return h * h * root * (first * zeta_three_halves(theta) + h * second * zeta_five_halves(theta))


@compiled
def contact_edge(contact, z_rate, z_bend, h):
    """Return the coefficients of p(t) and t p(t) in the elastic force at contact or release, eq. (2).

    `z_rate`, `z_bend`: z' and z''. The second term is limited to the first one at t = h.
    """
    law = contact.normal
    first, half = contact.stiffness * edge_load(z_rate, law), 0.5 * exponent(law)
    return first, first * min(max(half * z_bend / z_rate, -1.0 / h), 1.0 / h)


@compiled
def closing_share(ratio, normal):
    """Return the share Q/(mu P) of a contact that closes and p'(1 - ratio)/2, for |x'| = ratio c z', 0 <= ratio <= 1.

    The contact sticks, and its deformation grows in proportion to its approach, |x| = ratio c z. From
    Q/(mu K) = p(z) - p(z - |x|/c) and z - |x|/c = (1 - ratio) z the share is 1 - p(1 - ratio), constant in time. The
    second result takes the place of m/2 in eq. (2) if the rate of z - |x|/c changes in time.
    """
    return 1.0 - smooth_force(1.0, 1.0 - ratio, normal), 0.5 * smooth_slope(1.0 - ratio, normal)


@compiled
def slip_edge(contact, z_old, z_new, below, above, v_old, v_new, h):
    """Return the excess (1) of the rule for mu P - |Q| if stick ends within the step; 0 if it lasts to the end.

    `below` and `above` are |x| - X(z) at the ends of the step, with X = c z the slip limit, and `v_old` and `v_new` are
    their rates. Stick ends at the fraction s of the step, where |x| - X rises through zero with the rate v_edge. Until
    then

        mu P - |Q| = mu K p((X - |x|)/c),                                                                       (3)

    which falls to zero. In the time t counted backwards from the edge, the argument is z' t + z'' t^2/2 with

        z' = v_edge/c,    z'' = (v_old - v_new)/(c h),                                                          (4)

    so that (2) gives the two terms. Limits keep them finite where v_edge or z is near zero.
    """
    if above <= 0.0:
        return 0.0
    normal = contact.normal
    s = rising_root(below, above, h * v_old, h * v_new)
    v_edge = max(v_old + s * (v_new - v_old), 0.0)
    z = max((1.0 - s) * z_old + s * z_new, 1e-6 * max(z_old, z_new))
    # c and mu at this approach: a limit that is not proportional to z is replaced by X = c z near the edge
    limit = slip_limit(contact, z)
    c, friction = limit / z, contact.law.stuck(contact, z, limit) / load(z, normal)
    bend = 0.5 * exponent(normal) * (v_old - v_new) / max(v_edge, 1e-300)  # h m z''/(2 z'), with m = p'(1)
    first = friction * contact.stiffness * edge_load(v_edge / c, normal)
    excess = edge_excess(s, h, first, first * min(max(bend, -1.0), 1.0) / h, normal)
    if contact.law.rated and v_new >= 0.0:
        # The force drops at once to that of slip at this speed: a = 0 after the edge, zeta(0, 1 - s) = s - 1/2.
        fall = contact.stiffness * (friction * load(z, normal) - contact.law.sliding(contact, z, v_edge))
        excess += fall * h * (s - 0.5)
    return excess


@compiled
def passage_excess(s, h, bend):
    """Return the excess (1) of the rule for -bend t |t|, which passes zero at the fraction s of a step.

    Both sides have a = 2: h^3 bend [zeta(-2, s) - zeta(-2, 1 - s)] = -(2/3) bend h^3 B_3(s).
    """
    return -2.0 / 3.0 * bend * h**3 * s * (s - 0.5) * (s - 1.0)


@compiled
def last_part(v0, v1, whole):
    """Return (root s, integral from s to 1) of a parabola on [0, 1] with the ends v0 > 0 > v1 and the integral `whole`.

    The parabola is v0 + s (v1 - v0) + bulge s (1 - s); Newton's method finds its root from that of the chord.
    """
    bulge = 6.0 * (whole - 0.5 * (v0 + v1))
    s = v0 / (v0 - v1)
    for _ in range(3):
        slope = v1 - v0 + bulge * (1.0 - 2.0 * s)
        if slope >= 0.0:
            break
        s = min(max(s - (v0 + s * (v1 - v0) + bulge * s * (1.0 - s)) / slope, 0.0), 1.0)
    r = 1.0 - s
    return s, r * (v0 + 0.5 * (1.0 + s) * (v1 - v0) + bulge * r * (0.5 * s + r / 6.0))


@compiled
def cubic(s, y0, y1, r0, r1):
    """Return the cubic through y0, y1 with slopes r0, r1 (times the step) at s in [0, 1]."""
    return y0 + s * (r0 + s * (3.0 * (y1 - y0) - 2.0 * r0 - r1 + s * (2.0 * (y0 - y1) + r0 + r1)))


@compiled
def rising_root(y0, y1, r0, r1):
    """Return s at which the `cubic` rises through zero, y0 <= 0 < y1 (Newton's method from the secant)."""
    s = y0 / (y0 - y1)
    bend, twist = 3.0 * (y1 - y0) - 2.0 * r0 - r1, 2.0 * (y0 - y1) + r0 + r1
    for _ in range(5):
        slope = r0 + s * (2.0 * bend + 3.0 * s * twist)
        if slope <= 0.0:
            return s
        step = (y0 + s * (r0 + s * (bend + s * twist))) / slope
        s = min(max(s - step, 0.0), 1.0)
        if abs(step) < 1e-12:
            break
    return s
