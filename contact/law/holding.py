r"""A contact whose adhesion holds on beyond the touch, for the solvers in time: two branches of one approach.

Open, a contact closes where its approach z rises through `Hold.make`. Closed, its circle has the radius a, and with it
the *depth* d = a^2/R, the approach at which a smooth contact without adhesion has the same circle. The elastic force
K p(d), the slip limit c d and the friction are those of that contact (`law.elastic` with d in the place of z); the
attraction is K times a function of d that friction does not feel. The contact opens where z falls through `Hold.leave`,
the smallest approach of the branch, at which dz/dd = 0 (a *fold*), or where it becomes a point, d = 0. In between both
an open and a closed contact are possible, and its history decides.

For Johnson, Kendall and Roberts (`law.adhesion`) with S = sqrt(2 pi w/E) R^(1/4)

    z = d - S d^(1/4),     P/K = d^(3/2) - (3/2) S d^(3/4).                                                       (1)

With y = d^(1/4), y_0 that of the end (4 y_0^3 = S) and e = y - y_0, z - z_0 = e^2 (6 y_0^2 + 4 y_0 e + e^2). The root
of this is a smooth function of e without a double root at the end, which Newton's method inverts to rounding.

For Maugis and Dugdale, z, d and P/K are those of equations (1) to (3) of `law.maugis` times U, U and U^(3/2), with the
unit of approach U. With q^2 = c^2 - a^2, (1) there is an equation in q at any a, convex, and k = cot t = a/q runs
from `Hold.end` to infinity along the branch. From the derivatives of (1) there,

    dz/dd = 1 - (2 lambda/3) r,     r = (N/G)/q,     N = lambda c (t - sin t cos t) + nu (1 - cos t),
    G = lambda c (t + sin t cos t) + nu (t/sin t - 1 + cos t),     nu = 4 lambda^2/3.                             (2)

Functions take ``hold``, the field of a `law.normal.NormalLaw`. Of a contact without such adhesion it is None, and numba
then compiles nothing of what is here. The numbers of both models have one type, so that one set of kernels serves both.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from contact.jit.compiled import formula
from contact.roots import bracketed

ROUNDING = 4e-15  # scaled approach beyond the end that is taken for the end: a root would make 6e-8 of this rounding
STEEPEST = 1e8  # largest dd/dz, which is infinite at the end
NEWTON = 12  # steps at most; from the smaller of both limits of small and large e, 6 reach rounding
SMALL = 0.1  # angle below which differences of sines are series: 1e-16 of their rounding
NEAR = 0.05  # of k beyond its end, relative: closer, z is integrated from the end on, and not a difference
# Legendre's rule of 6 points on [0, 1], 1e-16 of the integral over `NEAR`
POINTS, WEIGHTS = (0.5 * each for each in np.polynomial.legendre.leggauss(6))
POINTS = POINTS + 0.5
THIN = 1e-3  # k at a fold below which it is taken for one at the point
SERIES = 8  # degree of the polynomial in the root of the approach from which the terms at the end are taken


class Terms(NamedTuple):
    """Coefficients of 1, s, s^2 and s^3 in a series at the end of the branch, s^2 the approach from there on."""

    one: float
    root: float
    linear: float
    mixed: float


class Hold(NamedTuple):
    """Numbers of a contact that holds on, lengths in the unit of the law."""

    number: float  # lambda of Maugis; 0 of Johnson, Kendall and Roberts
    unit: float  # U; the depth at which a contact closes of Johnson, Kendall and Roberts
    root: float  # S; 0 of Maugis
    end: float  # y_0, or k at the end of the branch
    bend: float  # of Maugis: ds/dk at the end, s^2 the approach from there on over U
    lowest: float  # of Maugis: approach at the end over U
    point: float  # of Maugis: q of a contact that is a point
    leave: float  # approach at which a closed contact opens
    make: float  # approach at which an open contact closes
    end_depth: float  # d where a closed contact opens, 0 where it becomes a point
    made_depth: float  # d of a contact that has just closed
    # at the end: terms of d^(3/2) and of the attraction
    elastic: Terms
    attraction: Terms


@formula
def jkr(root):
    """Return the numbers of a contact of Johnson, Kendall and Roberts."""
    y = (0.25 * root) ** (1.0 / 3.0)
    made = root ** (4.0 / 3.0)
    # s^2 = 6 y^2 e^2 + 4 y e^3 + e^4: the series e = a1 s + a2 s^2 + a3 s^3
    a1 = 1.0 / (np.sqrt(6.0) * y)
    a2 = -a1 * a1 / (3.0 * y)
    a3 = -(6.0 * y**2 * a2 * a2 + 12.0 * y * a1 * a1 * a2 + a1**4) / (12.0 * y**2 * a1)
    # (y + e)^6, and 3/2 S (y + e)^3
    elastic = Terms(
        y**6, 6.0 * y**5 * a1, 6.0 * y**5 * a2 + 15.0 * y**4 * a1 * a1,
        6.0 * y**5 * a3 + 30.0 * y**4 * a1 * a2 + 20.0 * y**3 * a1**3,
    )  # fmt: skip
    half = 1.5 * root
    attraction = Terms(
        half * y**3, half * 3.0 * y**2 * a1, half * (3.0 * y**2 * a2 + 3.0 * y * a1 * a1),
        half * (3.0 * y**2 * a3 + 6.0 * y * a1 * a2 + a1**3),
    )  # fmt: skip
    return Hold(0.0, made, root, y, 0.0, 0.0, 0.0, -3.0 * y**4, 0.0, y**4, made, elastic, attraction)


@formula
def _scaled_terms(terms, length):
    """Return the terms of a force over its stiffness in another unit of length."""
    root = np.sqrt(length)
    return Terms(terms.one / (length * root), terms.root / length, terms.linear / root, terms.mixed)


@formula
def rescaled(hold, length):
    """Return the numbers of lengths in this unit."""
    if hold is None:
        return None
    else:
        if hold.number == 0.0:
            return jkr(hold.root / length**0.75)
        return Hold(
            hold.number, hold.unit / length, 0.0, hold.end, hold.bend, hold.lowest, hold.point, hold.leave / length,
            hold.make / length, hold.end_depth / length, hold.made_depth / length,
            _scaled_terms(hold.elastic, length), _scaled_terms(hold.attraction, length),
        )  # fmt: skip


def maugis(number, unit, first):
    """Return the numbers of a contact of Maugis and Dugdale.

    Parameters
    ----------
    number : float
        lambda, positive.
    unit : float
        U, the unit of the approach.
    first : float
        Approach at which the surfaces begin to attract, negative. An open contact closes there, or where it is a point
        if that comes later.
    """
    end, bend, lowest, point, elastic, attraction = _end_of(number)
    depth_at_end = float(unit * (end * rim_at_angle(end, number).q) ** 2)
    hold = Hold(
        number, unit, 0.0, end, bend, lowest, point, unit * lowest, max(first, unit * lowest), depth_at_end, 0.0,
        _scaled_terms(elastic, 1.0 / unit), _scaled_terms(attraction, 1.0 / unit),
    )  # fmt: skip
    return hold._replace(made_depth=float(depth(hold.make, hold)) if hold.make > hold.leave else depth_at_end)


@lru_cache(256)
def _end_of(number):
    """Return k, ds/dk, z, q of a point, and the terms of both forces at the end of the branch of a lambda, unit U."""
    point = float(rim_at_angle(0.0, number).q)

    def rise(k):
        return _rise(rim_at_angle(k, number), number)

    end = 0.0
    if rise(0.0) < 0.0:
        high = 1.0
        while rise(high) < 0.0:
            high *= 2.0
        end = float(bracketed(rise, 0.5 * high if high > 1.0 else 0.0, high))
    rim = rim_at_angle(end, number)
    lowest = float(rim_approach(rim, number))
    # near the end s is a smooth function of k, and so are the forces
    x = np.cos(np.pi * (np.arange(SERIES + 1) + 0.5) / (SERIES + 1))
    if end < THIN and rise(0.0) < NEAR:  # the fold is so near the point that s is smooth on one side only
        x = 0.5 * NEAR * (1.0 + x)
    else:
        x = (NEAR * end if end > 0.0 else NEAR) * x
    rims = [rim_at_angle(end + each, number) for each in x]
    s = np.sign(x) * np.sqrt([_beyond(each, end, lowest, number) for each in rims])
    elastic, attraction = _terms(s, [each.a**3 for each in rims]), _terms(s, [rim_pull(each, number) for each in rims])
    if end == 0.0:  # z = dz/dd q^2 k^2 there
        return end, float(point * np.sqrt(rise(0.0))), lowest, point, elastic, attraction
    return end, _terms(x, s).root, lowest, point, elastic, attraction


def _terms(s, values):
    """Return the first coefficients of the polynomial in s through the values."""
    coefficients = np.polynomial.Polynomial.fit(s, values, SERIES).convert().coef[:4]
    return Terms(*map(float, coefficients))


class Rim(NamedTuple):
    """A contact of Maugis and Dugdale in the units of `law.maugis`, on its branch."""

    k: float
    a: float
    c: float
    q: float
    t: float
    sine: float
    cosine: float
    steep: float  # r


@formula
def _sine_gap(x, sine):
    """Return x - sin x."""
    square = x * x
    if x < SMALL:
        return x * square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0 * (1.0 - square / 72.0)))
    return x - sine


@formula
def _twist(x, sine, cosine):
    """Return sin x - x cos x."""
    square = x * x
    if x < SMALL:
        return x * square / 3.0 * (1.0 - square / 10.0 * (1.0 - square / 28.0 * (1.0 - square / 54.0)))
    return sine - x * cosine


@formula
def _twist_twice(t, sine, cosine):
    """Return sin x - x cos x of x = 2 t."""
    return _twist(2.0 * t, 2.0 * sine * cosine, 2.0 * cosine * cosine - 1.0)


@formula
def rim_at_angle(k, number):
    """Return the contact at k = cot t: equation (1) of `law.maugis` is a quadratic equation in c."""
    sine = 1.0 / np.sqrt(1.0 + k * k)
    t = np.arctan2(1.0, k)
    versine = sine * sine / (1.0 + k * sine)
    slope = 4.0 / 3.0 * number * number * (t * sine - versine)
    c = 2.0 / (slope + np.sqrt(slope * slope + number * _twist_twice(t, sine, k * sine)))
    return _with_steepness(k, k * sine * c, c, sine * c, t, sine, k * sine, number)


@formula
def _with_steepness(k, a, c, q, t, sine, cosine, number):
    """Return the contact with r of equation (2)."""
    nu, versine = 4.0 / 3.0 * number * number, sine * sine / (1.0 + cosine)
    gap = 0.5 * _sine_gap(2.0 * t, 2.0 * sine * cosine)
    above = number * c * gap + nu * versine
    below = number * c * (t + sine * cosine) + nu * (t / sine - versine)
    return Rim(k, a, c, q, t, sine, cosine, above / (below * q))


@formula
def _rim_of(a, hold):
    """Return the contact of a radius: Newton's method in q for equation (1) of `law.maugis`, from the right."""
    number = hold.number
    nu = 4.0 / 3.0 * number * number
    q = hold.point + min(np.sqrt(2.0 * a / nu), (1.5 * a / number) ** (1.0 / 3.0))
    for _ in range(NEWTON):
        c, t = np.hypot(a, q), np.arctan2(q, a)
        sine, cosine = q / c, a / c
        versine = sine * sine / (1.0 + cosine)
        value = 0.25 * number * c * c * _twist_twice(t, sine, cosine) + nu * c * (t * sine - versine) - 1.0
        rate = number * c * sine * (t + sine * cosine) + nu * (t - sine * versine)
        step = value / rate
        q -= step
        if abs(step) <= 1e-9 * q:  # the next one would be its square
            break
    c, t = np.hypot(a, q), np.arctan2(q, a)
    return _with_steepness(a / q, a, c, q, t, q / c, a / c, number)


@formula
def rim_approach(rim, number):
    """Return z over U."""
    return rim.a * rim.a - 4.0 / 3.0 * number * rim.q


@formula
def _rise(rim, number):
    """Return dz/dd."""
    return 1.0 - 2.0 / 3.0 * number * rim.steep


@formula
def rim_pull(rim, number):
    """Return the attraction over U^(3/2)."""
    return number * (rim.c * rim.c * rim.t + rim.a * rim.q)


@formula
def rim_pull_rate(rim, number):
    """Return its derivative in d."""
    return number * (rim.t * (1.0 + rim.steep * rim.q) + rim.a * rim.steep)


@formula
def _rise_rate(rim, number):
    """Return d2z/dd2, infinite at a point, of at most a tiny radius there."""
    a, c, q, t, sine, cosine, r = rim.a, rim.c, rim.q, rim.t, rim.sine, rim.cosine, rim.steep
    nu, versine = 4.0 / 3.0 * number * number, sine * sine / (1.0 + cosine)
    c_rate, t_rate, gap = (
        a * (1.0 + r * q) / c,
        (a * a * r - q) / (c * c),
        0.5 * _sine_gap(2.0 * t, 2.0 * sine * cosine),
    )
    above = number * c * gap + nu * versine
    below = number * c * (t + sine * cosine) + nu * (t / sine - versine)
    above_rate = number * (c_rate * gap + 2.0 * c * sine * sine * t_rate) + nu * sine * t_rate
    below_rate = number * (c_rate * (t + sine * cosine) + 2.0 * c * cosine * cosine * t_rate)
    below_rate += nu * (_twist(t, sine, cosine) / (sine * sine) - sine) * t_rate
    rate = r * (above_rate / above - a * r / q - below_rate / below)
    return -number * rate / (3.0 * max(a, 1e-8))


@formula
def _climb(rim, number):
    """Return dz/dk over U."""
    return 2.0 * rim.a * _rise(rim, number) * rim.q / (1.0 - rim.k * rim.a * rim.steep)


@formula
def _beyond(rim, end, lowest, number):
    """Return z over U from the end of the branch on; beside a fold, where a difference is rounding, by an integral."""
    e, total = rim.k - end, 0.0
    if abs(e) > NEAR * end:
        return rim_approach(rim, number) - lowest
    for i in range(POINTS.size):
        total += WEIGHTS[i] * _climb(rim_at_angle(end + POINTS[i] * e, number), number)
    return e * total


@formula
def _at_approach(beyond, hold):
    """Return the contact of Maugis and Dugdale at an approach over U from the end on, by Newton's method in k."""
    number, end, goal = hold.number, hold.end, np.sqrt(beyond)
    if beyond < ROUNDING:
        return rim_at_angle(end, number)
    # near the end and far from it: within a half of the root for all lambda
    near, far = goal / hold.bend, np.sqrt(goal / 1.5) * number + (goal * goal * number / 1.5) ** (1.0 / 3.0)
    k = end + near * far / np.hypot(near, far)
    rim = rim_at_angle(k, number)
    for _ in range(2 * NEWTON):
        root = np.sqrt(max(_beyond(rim, end, hold.lowest, number), 1e-30))
        step = 2.0 * root * (root - goal) / _climb(rim, number)
        k = max(k - step, end)
        rim = rim_at_angle(k, number)
        if abs(step) <= 1e-8 * (0.1 + k):  # the next one would be its square
            break
    return rim


@formula
def circle(z, pull, hold):
    """Return d of a closed contact at an approach z, that of the end below it, and its attraction over the stiffness.

    Without such adhesion they are z and ``pull``.
    """
    if hold is None:
        return z, pull
    else:
        beyond = z - hold.leave
        if hold.number > 0.0:
            rim = _at_approach(max(beyond, 0.0) / hold.unit, hold)
            d, root = hold.unit * rim.a * rim.a, np.sqrt(hold.unit)
            return d, hold.unit * root * rim_pull(rim, hold.number)
        if beyond < ROUNDING:
            return hold.end_depth, 1.5 * hold.root * power(hold.end_depth)
        goal, y = np.sqrt(beyond), hold.end
        e = min(goal / (np.sqrt(6.0) * y), np.sqrt(goal))
        for _ in range(NEWTON):
            square = 6.0 * y * y + e * (4.0 * y + e)
            root = np.sqrt(square)
            step = (e * root - goal) * root / (square + e * (2.0 * y + e))
            e -= step
            if abs(step) <= 1e-16 * (y + e):
                break
        d = (y + e) ** 4
        return d, 1.5 * hold.root * power(d)


@formula
def depth(z, hold):
    """Return d of a closed contact at an approach z; that of the end below it. Without adhesion d is z."""
    return circle(z, 0.0, hold)[0]


@formula
def rim_at_depth(d, hold):
    """Return the contact of Maugis and Dugdale of a depth."""
    return _rim_of(np.sqrt(d / hold.unit), hold)


@formula
def power(d):
    """Return d^(3/4)."""
    root = np.sqrt(d)
    return root * np.sqrt(root)


@formula
def rise(d, hold):
    """Return dz/dd."""
    if hold.number > 0.0:
        return _rise(rim_at_depth(d, hold), hold.number)
    return 1.0 - 0.25 * hold.root / power(d)


@formula
def depth_rate(d, hold):
    """Return dd/dz, at most `STEEPEST`."""
    if hold is None:
        return 1.0
    else:
        return 1.0 / max(rise(d, hold), 1.0 / STEEPEST)


@formula
def _bend(d, hold):
    """Return d2z/dd2."""
    if hold.number > 0.0:
        return _rise_rate(rim_at_depth(d, hold), hold.number) / hold.unit
    return 0.1875 * hold.root / (d * power(d))


@formula
def depth_second(d, z_rate, z_second, hold):
    """Return d'' of the rates z' and z'' of the approach."""
    if hold is None:
        return z_second
    else:
        rate = depth_rate(d, hold)
        return z_second * rate - z_rate * z_rate * _bend(d, hold) * rate**3


@formula
def attraction(d, pull, hold):
    """Return the attraction of a closed contact over its stiffness; `pull` without this adhesion."""
    if hold is None:
        return pull
    else:
        if hold.number > 0.0:
            return hold.unit * np.sqrt(hold.unit) * rim_pull(rim_at_depth(d, hold), hold.number)
        return 1.5 * hold.root * power(d)


@formula
def attraction_rate(d, hold):
    """Return the derivative of the attraction in d."""
    if hold.number > 0.0:
        return np.sqrt(hold.unit) * rim_pull_rate(rim_at_depth(d, hold), hold.number)
    return 1.125 * hold.root / np.sqrt(np.sqrt(d))


@formula
def suction(d, hold):
    """Return how much less the pressure in the middle is than that of the elastic part, over E/(pi R^(1/2))."""
    if hold.number > 0.0:
        return 4.0 / 3.0 * hold.number * np.sqrt(hold.unit) * rim_at_depth(d, hold).t
    return hold.root / np.sqrt(np.sqrt(d))


@formula
def approach_at(d, hold):
    """Return z of a closed contact of this depth."""
    if hold.number > 0.0:
        return hold.unit * rim_approach(rim_at_depth(d, hold), hold.number)
    return d - hold.root * np.sqrt(np.sqrt(d))


@formula
def depth_under(p, hold):
    """Return d of a contact that carries p = P/K, at least minus the pull-off.

    Of Johnson, Kendall and Roberts a quadratic equation in d^(3/4); it is less of Maugis and Dugdale, whose force is
    convex in d, so that Newton's method falls from there.
    """
    root = hold.root if hold.number == 0.0 else np.sqrt(8.0 / 3.0) * power(hold.unit)
    half = 0.75 * root
    q = half + np.sqrt(max(half * half + p, 0.0))
    d = q ** (4.0 / 3.0)
    if hold.number > 0.0:
        for _ in range(5 * NEWTON):
            rate = 1.5 * np.sqrt(d) - attraction_rate(d, hold)
            step = (d * np.sqrt(d) - attraction(d, 0.0, hold) - p) / rate
            if not (step > 1e-15 * d and rate > 0.0):
                break
            d -= step
    return d


@formula
def attraction_under(p, pull, hold):
    """Return the attraction of closed contacts that carry p = P/K, over their stiffness."""
    if hold is None:
        return pull
    else:
        return attraction(depth_under(p, hold), pull, hold)


@formula
def stiffness(d, hold):
    """Return d(P/K)/dz of a closed contact."""
    return (1.5 * np.sqrt(d) - attraction_rate(d, hold)) * depth_rate(d, hold)


@formula
def work(d, hold):
    """Return the integral of P/K over z, up to a constant, on the closed branch.

    Of Maugis and Dugdale it is the elastic energy and that of the surfaces, z P - U_e - M/2R - w pi c^2, with the
    second moment M of the pressure. With the line load g(s) of the contact (the Abel transform of the pressure), which
    is E (z - s^2/R) up to a and -2 sigma_0 sqrt(c^2 - s^2) up to c, U_e = (1/E) int_0^c g^2 ds and
    M = 4 int_0^c s^2 g ds. (Of the surfaces between a and c the energy is -w + sigma_0 h at a gap h, and
    int p u dA = 2 U_e gives the integral of h.)
    """
    if hold.number > 0.0:
        number, rim = hold.number, rim_at_depth(d, hold)
        a, c, z, t = rim.a, rim.c, rim_approach(rim, hold.number), rim.t
        rim_width = c * rim.sine * rim.sine / (1.0 + rim.cosine)
        elastic = 0.75 * a * (z * z + a * a * (0.2 * a * a - 2.0 / 3.0 * z))
        elastic += 4.0 / 9.0 * number * number * rim_width * rim_width * (2.0 * c + a)
        moment = 1.5 * a**3 * (z / 3.0 - 0.2 * a * a) - number * c**4 * _sine_gap(4.0 * t, np.sin(4.0 * t)) / 16.0
        total = z * (a**3 - rim_pull(rim, number)) - moment - elastic - c * c
        return hold.unit**2 * np.sqrt(hold.unit) * total
    S = hold.root
    return d * (0.4 * d * np.sqrt(d) - S * power(d) + 0.375 * S * S)


@formula
def made_depth(hold):
    """Return d of a contact that has just closed."""
    return hold.made_depth


@formula
def stored(d, hold):
    """Return the work on a closed contact over its stiffness since it closed: what is lost where it opens."""
    return work(d, hold) - work(made_depth(hold), hold)


@formula
def closes_at(hold):
    """Return the approach at which an open contact closes."""
    if hold is None:
        return 0.0
    else:
        return hold.make


@formula
def opens_at(hold):
    """Return the approach at which a closed contact opens."""
    if hold is None:
        return 0.0
    else:
        return hold.leave


@formula
def opens_as_point(hold):
    """Return whether a contact opens where it is a point, as one without adhesion, and not at a fold."""
    if hold is None:
        return True
    else:
        return hold.end_depth == 0.0


@formula
def closes_as_point(hold):
    """Return whether a contact closes as a point, as one without adhesion."""
    if hold is None:
        return True
    else:
        return hold.made_depth == 0.0


@formula
def is_open(z, was_open, hold):
    """Return whether a contact at an approach is open, where its history has to tell; False without such adhesion."""
    if hold is None:
        return False
    else:
        return z <= hold.leave or (z < hold.make and was_open)
