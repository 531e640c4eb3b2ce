r"""Jacobian of the map of one cycle by the averaged equations, for a heavy slider on many contacts.

A difference quotient of the event-driven map costs a cycle of every contact for each of 3 to 8 directions. Of a heavy
slider with the elastic law the derivatives follow from the cycle at constant height and velocity. With z_s = -h, w =
z_s', and sums over the contacts,

    d(delta z_s)/dphi = delta w
    d(delta w)/dphi   = -K(phi) delta z_s - D(phi) delta w        K = sum kappa_i p'(z_i) (1 + chi z_i')
    d(delta v)/dphi   = -Q_h delta z_s + (Q_v - d_t) delta v      D = d_n + sum kappa_i chi p(z_i)               (1)

with Q_h and Q_v the derivatives of the cycle mean of the tangential forces. K and D are taken at each phase, since the
cycle starts at one; the deformations follow at once. A contact that sticks at phase 0 still has the deformation x_i of
the cycle before, until it slips or opens at the phase T_i:

    d v(2 pi)/d x_i = int_0^T_i dQ_i/dx dphi,     dQ/dx = (mu/c) kappa p'(z - |x|/c).                             (2)

(1) has an error of O((f_n/f)^2) and (2) that of its sum over `PHASES` phases. Newton's method reaches the same fixed
point, in a step or two more. The multipliers of (1) are those of differences to 1e-7
(`tests/contact/test_many_contacts.py`). Without damping that of the bounce is 1: for f_n/f <= 0.1 no parametric
resonance of (1) is near, the first being at f_n/f = 1/2.
"""

import numpy as np

from contact.averaged.equilibrium import tangential_slopes
from contact.averaged.event_equilibrium import Balance
from contact.body import Coordinates, approach, approach_rate, at_phase
from contact.codes import At, Tangential
from contact.law.normal import load, slope
from contact.problem import largest_resonance

# Phases of the sums over a cycle; with 16 to 128 Newton's method took the same 4 or 5 steps for 30 to 400 balls, but
# with 32 the multipliers of the test were off by more than 1e-7
PHASES = 64
MAX_RATIO = 0.1  # largest f_n/f


def averaged_jacobian(balance: Balance, deformations: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
    """Return J of the map of one cycle as (L, R), J = L R^T, of shapes (3 + n, 3); None where (1) does not hold.

    `deformations` are those at phase 0. J has no rows of deformations: they are those of the map's last evaluation.
    """
    problem = balance.problem
    law = problem.law
    if law.kind != Tangential.ELASTIC or law.rated or law.bent or law.callbacks is not None:
        return None
    if problem.normal.hold is not None or problem.normal.pull > 0.0 or problem.stick_band > 0.0:
        return None
    if balance.held or balance.speed == 0.0 or problem.limit_slope == 0.0 or largest_resonance(problem) > MAX_RATIO:
        return None
    by_height, by_speed = tangential_slopes(problem, balance.height, balance.speed)
    if not (by_speed < 0.0 and np.isfinite(by_height)):
        return None
    every, q = np.arange(problem.contacts), Coordinates(-balance.height, 0.0)
    stiffness, c = problem.stiffness * problem.factors.stiffness, problem.limit_slope * problem.factors.limit_slope
    start = at_phase(problem.paths, every, 1.0, 0.0)
    step, map_, impulse = 2.0 * np.pi / PHASES, np.eye(3), np.zeros(every.size)
    sticks = approach(problem.paths, every, start[0], q) > 0.0
    half = np.array([[1.0, 0.5 * step, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    for k in range(PHASES):
        phase = step * (k + 0.5)
        u_z, u_z_rate, u_x, _ = at_phase(problem.paths, every, np.cos(phase), np.sin(phase))
        z = approach(problem.paths, every, u_z, q)
        depth = np.maximum(z, 0.0)
        damped = 1.0 + problem.contact_damping * approach_rate(u_z_rate, Coordinates(0.0, 0.0))
        spring = np.sum(stiffness * slope(depth, problem.normal) * damped)
        damper = problem.normal_damping + problem.contact_damping * np.sum(stiffness * load(depth, problem.normal))
        kick = np.eye(3)
        kick[At.NORMAL_VELOCITY, :2] = -spring * step, np.exp(-damper * step)
        kick[At.VELOCITY, At.POSITION], kick[At.VELOCITY, At.VELOCITY] = -by_height * step, np.exp(by_speed * step)
        map_ = half @ kick @ half @ map_
        x = deformations + (u_x - start[2]) - balance.speed * phase
        stuck = np.maximum(depth - np.abs(x) / c, 0.0)
        sticks &= stuck > 0.0
        impulse += np.where(sticks, step * problem.friction / c * stiffness * slope(stuck, problem.normal), 0.0)
    if np.any(sticks):  # a deformation that lasts a cycle has a row of its own
        return None
    left, right = np.zeros((2, 3 + every.size, 3))
    left[:3] = np.eye(3)
    right[:3], right[3:, At.VELOCITY] = map_.T, impulse
    return left, right
