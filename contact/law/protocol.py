r"""The interface between a tangential law and the solvers: compiled functions and the numbers that they need.

In gross slip every law here is a *stop operator*. While a contact sticks, its deformation x follows the surface, and
the force is that of a spring; x stays within the slip limit X(z). At the limit it slips, at the speed

    w = s (u_x' - v) - dX/dz z' >= 0,   s the sign of the deformation,

and the force is the sliding force. All of it is in the units of `contact.problem`; forces and energies are over the
stiffness kappa, as `normal.load` is. `problem` are the parameters of one contact (`contact.problem.ContactParameters`):

    coefficient(problem, z)         mu of a contact at rest
    limit_ratio(problem, z)         X/z; `slip_limit` returns X
    limit_rate(problem, z)          dX/dz
    stuck(problem, z, x)            Q of a contact that sticks with 0 <= x <= X, and of its spring
    sliding(problem, z, w)          Q of a contact that slips at the speed w; w = 0 as at the limit, else Q jumps there
    deformation(problem, z, Q)      x at which the spring carries Q; X where Q is more than it can carry
    energy(problem, z, x)           integral of Q dx from 0, the spring's energy
    back(problem, z, x)             its derivative in z at constant x

Between events a contact i is in a regime (`codes.Regime`) with a sign s. What the event-driven solver asks of it, at a
`body.Point` (z, x, z', x'); those of the stop operator are in `law.elastic`:

    force(problem, memory, i, regime, s, point, level, front)     (Q, front): Q scaled, not over the stiffness
    guard(problem, memory, i, regime, which, s, point, front)     positive inside the regime; its first root ends it
    guard_rate(problem, memory, i, regime, which, s, point, second)    its rate; `second` is (z'', x'')
    follow(problem, memory, i, regime, which, s, point)           (regime, s, x, kind of event) beyond that guard

A law may have a *memory*: what a contact remembers beyond its deformation (`law.hysteretic` keeps a chain of slipped
and stuck annuli). `level` is the moment M of the memory, integrated with the motion, and `front` the inner edge of
slip. Laws without memory take None and ignore both.

The functions are fields of a named tuple, so that a solver is compiled for each law: a law that needs no slip speed
does not pay for it. What a user has written is called by address instead (`callbacks`), so that one compiled solver
serves all users' laws.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.body import slip_speed
from contact.jit.compiled import formula


class Law(NamedTuple):
    """A tangential law; see the module's text for the functions."""

    kind: int  # One of `codes.Tangential`
    rated: int  # 1: the sliding force depends on the speed of slip
    bent: int  # 1: the slip limit is not proportional to the approach
    numbers: np.ndarray  # Of the law's functions, SI units
    coefficient: Callable
    limit_ratio: Callable
    limit_rate: Callable
    stuck: Callable
    sliding: Callable
    deformation: Callable
    energy: Callable
    back: Callable
    force: Callable
    guard: Callable
    guard_rate: Callable
    follow: Callable
    callbacks: tuple | None = None  # A user's functions, called by address (`law.user.Callbacks`)


@formula
def slip_limit(problem, z):
    """Return X, the deformation at which slip begins; `z` a number or, where X/z is one number, an array."""
    return problem.law.limit_ratio(problem, z) * z


@formula
def slip_rate(problem, sign, point):
    """Return the speed w of slip of a sign at a `body.Point`; negative where the contact sticks."""
    rate = problem.law.limit_rate(problem, point.approach)
    return slip_speed(sign, point.approach_rate, point.deformation_rate, rate)


@formula
def limit_bend(problem, z):
    """Return d2X/dz2, by a difference: it serves the rates of guards, where Newton's method needs no more."""
    step = 1e-4 * abs(z)
    if step == 0.0:
        return 0.0
    law = problem.law
    return (law.limit_rate(problem, z + step) - law.limit_rate(problem, z - step)) / (2.0 * step)
