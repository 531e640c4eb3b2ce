r"""A contact whose adhesion holds on beyond the touch, for the solvers in time: two branches of one approach.

Open, a contact closes where its approach z rises through `Hold.make`. Closed, its circle has the radius a, and with it
the *depth* d = a^2/R, the approach at which a smooth contact without adhesion has the same circle. The elastic force
K p(d), the slip limit c d and the friction are those of that contact (`law.elastic` with d in the place of z); the
attraction is K times a function of d that friction does not feel. The contact opens where z falls through `Hold.leave`,
the smallest approach of the branch, at which dz/dd = 0. In between both an open and a closed contact are possible, and
its history decides.

For Johnson, Kendall and Roberts (`law.adhesion`) with S = sqrt(2 pi w/E) R^(1/4)

    z = d - S d^(1/4),     P/K = d^(3/2) - (3/2) S d^(3/4).                                                       (1)

With y = d^(1/4), y_0 that of the end (4 y_0^3 = S) and e = y - y_0, z - z_0 = e^2 (6 y_0^2 + 4 y_0 e + e^2). The root
of this is a smooth function of e without a double root at the end, which Newton's method inverts to rounding.

Functions take ``hold``, the field of a `law.normal.NormalLaw`. Of a contact without such adhesion it is None, and numba
then compiles nothing of what is here.
"""

from typing import NamedTuple

import numpy as np

from contact.jit.compiled import formula

ROUNDING = 4e-15  # scaled approach beyond the end that is taken for the end: a root would make 6e-8 of this rounding
STEEPEST = 1e8  # largest dd/dz, which is infinite at the end
NEWTON = 12  # steps at most; from the smaller of both limits of small and large e, 6 reach rounding


class Hold(NamedTuple):
    """Numbers of equation (1), in the unit of length of the law."""

    root: float  # S
    end: float  # y_0
    leave: float  # approach at which a closed contact opens
    make: float  # approach at which an open contact closes


@formula
def jkr(root):
    """Return the numbers of a contact of Johnson, Kendall and Roberts."""
    end = (0.25 * root) ** (1.0 / 3.0)
    return Hold(root, end, -3.0 * end**4, 0.0)


@formula
def rescaled(hold, length):
    """Return the numbers of lengths in this unit."""
    if hold is None:
        return None
    else:
        return jkr(hold.root / length**0.75)


@formula
def depth(z, hold):
    """Return d of a closed contact at an approach z; that of the end below it. Without adhesion d is z."""
    if hold is None:
        return z
    else:
        beyond = z - hold.leave
        if beyond < ROUNDING:
            return hold.end**4
        goal, y = np.sqrt(beyond), hold.end
        e = min(goal / (np.sqrt(6.0) * y), np.sqrt(goal))
        for _ in range(NEWTON):
            square = 6.0 * y * y + e * (4.0 * y + e)
            root = np.sqrt(square)
            step = (e * root - goal) * root / (square + e * (2.0 * y + e))
            e -= step
            if abs(step) <= 1e-16 * (y + e):
                break
        return (y + e) ** 4


@formula
def power(d):
    """Return d^(3/4)."""
    root = np.sqrt(d)
    return root * np.sqrt(root)


@formula
def depth_rate(d, hold):
    """Return dd/dz, at most `STEEPEST`."""
    if hold is None:
        return 1.0
    else:
        rise = 1.0 - 0.25 * hold.root / power(d)
        return 1.0 / max(rise, 1.0 / STEEPEST)


@formula
def depth_second(d, z_rate, z_second, hold):
    """Return d'' of the rates z' and z'' of the approach."""
    if hold is None:
        return z_second
    else:
        rate = depth_rate(d, hold)
        return z_second * rate - z_rate * z_rate * 0.1875 * hold.root / (d * power(d)) * rate**3


@formula
def attraction(d, pull, hold):
    """Return the attraction of a closed contact over its stiffness; `pull` without this adhesion."""
    if hold is None:
        return pull
    else:
        return 1.5 * hold.root * power(d)


@formula
def approach_at(d, hold):
    """Return z of a closed contact of this depth."""
    return d - hold.root * np.sqrt(np.sqrt(d))


@formula
def depth_under(p, hold):
    """Return d of a contact that carries p = P/K, at least -(9/16) S^2: a quadratic equation in d^(3/4)."""
    half = 0.75 * hold.root
    q = half + np.sqrt(half * half + p)
    return q ** (4.0 / 3.0)


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
    return (1.5 * np.sqrt(d) - 1.125 * hold.root / np.sqrt(np.sqrt(d))) * depth_rate(d, hold)


@formula
def work(d, hold):
    """Return the integral of P/K over z, up to a constant, on the closed branch."""
    S = hold.root
    return d * (0.4 * d * np.sqrt(d) - S * power(d) + 0.375 * S * S)


@formula
def made_depth(hold):
    """Return d of a contact that has just closed."""
    return hold.root ** (4.0 / 3.0)


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
def is_open(z, was_open, hold):
    """Return whether a contact at an approach is open, where its history has to tell; False without such adhesion."""
    if hold is None:
        return False
    else:
        return z <= hold.leave or (z < hold.make and was_open)
