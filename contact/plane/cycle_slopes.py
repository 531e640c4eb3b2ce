r"""Derivatives of the motion of one contact under a heavy slider, by the variational equation.

The deformation e and the angle alpha of slip are differentiated in the deformation at the start of the period and in
the velocity v of the slider at the contact; a column stands for each component, u for a variable's derivative. The
approach does not depend on either.

    stick           u_e' = -dv                              slip    c z u_alpha' = -(n.w) u_alpha - t.dv
    begins to slip  u_alpha = t.u_e/(c z)                   slips at the touch   u_alpha of n = w/|w|
    sticks          u_e = c z u_alpha t

The time at which slip begins changes too, which leaves the part of u_e across n alone; e is continuous in rate where
slip ends. The force is continuous at every event, so that its integral gains nothing there. In a slip segment u_alpha
solves the linear system of the last Newton iteration of the collocation: this is the derivative of the computed motion.
"""

from typing import NamedTuple

import numpy as np

from contact.codes import Regime
from contact.jit.compiled import compiled
from contact.law.normal import load, slope
from contact.plane.disc_contacts import RegimeEnd, Stage, Total, angle_equation, solve_linear

COLUMNS = 4  # e_x, e_y at the start, v_x, v_y
LEAST = 1e-9  # determinant of 1 - M below which a contact keeps its deformation


class Slopes(NamedTuple):
    """Derivatives of a contact's motion at a phase, and of its force since the start of the period."""

    deformation: np.ndarray  # (2, COLUMNS)
    angle: np.ndarray  # (COLUMNS,)
    force: np.ndarray  # (2, COLUMNS): of the integral of Q


def slopes_of() -> Slopes:
    """Return work arrays for the derivatives of one contact."""
    return Slopes(np.zeros((2, COLUMNS)), np.zeros(COLUMNS), np.zeros((2, COLUMNS)))


@compiled
def begin_slopes(opens, slopes):
    """Set the derivatives at the start of a period; `opens`: the contact is open there."""
    for k in range(COLUMNS):
        for axis in range(2):
            slopes.force[axis, k] = 0.0
            slopes.deformation[axis, k] = 1.0 if k == axis and not opens else 0.0
        slopes.angle[k] = 0.0


@compiled
def add_slopes(problem, i, state, work, slopes):
    """Add the derivatives of a solved segment's forces and move those of the contact to its end."""
    if state.regime[i] == Regime.STICK:
        _add_stick(problem, i, state, work, slopes)
    elif state.regime[i] == Regime.SLIP:
        _add_slip(problem, i, work, slopes)


@compiled
def _add_stick(problem, i, state, work, slopes):
    """Add the derivatives of a segment of stick."""
    begin, c = state.total[Total.PHASE], problem.limit_slope[i]
    since = 0.0
    for j in range(work.phase.size):
        row, since = work.stage[j, i], work.phase[j] - begin
        z, size = row[Stage.Z], np.hypot(row[Stage.E_X], row[Stage.E_Y])
        if z <= 0.0 or c == 0.0:
            continue
        friction, least = problem.friction * problem.stiffness[i], max(z - size / c, 0.0)
        radial = friction / c * slope(least, problem.normal)
        across, n_x, n_y = radial, 1.0, 0.0
        if size > 1e-9 * c * z:
            across = friction * (load(z, problem.normal) - load(least, problem.normal)) / size
            n_x, n_y = row[Stage.E_X] / size, row[Stage.E_Y] / size
        weight = work.nodes.weight[j] * work.rate[j]
        for k in range(COLUMNS):
            e_x = slopes.deformation[0, k] - (since if k == 2 else 0.0)
            e_y = slopes.deformation[1, k] - (since if k == 3 else 0.0)
            along = (radial - across) * (n_x * e_x + n_y * e_y)
            slopes.force[0, k] += weight * (across * e_x + along * n_x)
            slopes.force[1, k] += weight * (across * e_y + along * n_y)
    slopes.deformation[0, 2] -= since
    slopes.deformation[1, 3] -= since


@compiled
def _add_slip(problem, i, work, slopes):
    """Add the derivatives of a segment of slip: those of the turn at its nodes in the angle at its start and in v."""
    nodes, matrix, n = work.nodes, work.slope_matrix, work.phase.size
    for j in range(n):
        row = work.stage[j, i]
        along, _, inertia = angle_equation(problem, i, row, work.rate[j])
        moving = 0.0 if work.rate[j] == 0.0 and inertia > 0.0 else 1.0
        for k in range(n):
            matrix[j, k] = along * nodes.integral[j, k]
        matrix[j, j] += inertia
        matrix[j, n] = -along
        matrix[j, n + 1], matrix[j, n + 2] = moving * row[Stage.N_Y], -moving * row[Stage.N_X]
    solve_linear(matrix)
    end_0 = end_x = end_y = 0.0
    for j in range(n):
        row, turn_0, turn_x, turn_y = work.stage[j, i], 1.0, 0.0, 0.0
        for k in range(n):
            turn_0 += nodes.integral[j, k] * matrix[k, n]
            turn_x += nodes.integral[j, k] * matrix[k, n + 1]
            turn_y += nodes.integral[j, k] * matrix[k, n + 2]
        weight = nodes.weight[j] * work.rate[j]
        for k in range(COLUMNS):
            turn = weight * (turn_0 * slopes.angle[k] + (turn_x if k == 2 else turn_y if k == 3 else 0.0))
            slopes.force[0, k] -= turn * row[Stage.Q_Y]
            slopes.force[1, k] += turn * row[Stage.Q_X]
        end_0, end_x, end_y = turn_0, turn_x, turn_y  # the last node is the end
    for k in range(COLUMNS):
        slopes.angle[k] = end_0 * slopes.angle[k] + (end_x if k == 2 else end_y if k == 3 else 0.0)


@compiled
def pass_slopes(problem, i, which, begins, row, slopes):
    """Move the derivatives beyond an event of contact i; `begins`: it lies at the touch, `row`: the contact there."""
    if which == RegimeEnd.TOUCH or (which == RegimeEnd.SLIP and begins):
        square = row[Stage.W_X] ** 2 + row[Stage.W_Y] ** 2 + 1e-300
        for k in range(COLUMNS):
            slopes.deformation[0, k] = slopes.deformation[1, k] = slopes.angle[k] = 0.0
        slopes.angle[2], slopes.angle[3] = row[Stage.W_Y] / square, -row[Stage.W_X] / square
    elif which == RegimeEnd.SLIP:
        square = row[Stage.E_X] ** 2 + row[Stage.E_Y] ** 2 + 1e-300
        for k in range(COLUMNS):
            across = row[Stage.E_X] * slopes.deformation[1, k] - row[Stage.E_Y] * slopes.deformation[0, k]
            slopes.angle[k] = across / square
    elif which == RegimeEnd.STICK:
        fill_slip_deformation(problem, i, row, slopes)


@compiled
def fill_slip_deformation(problem, i, row, slopes):
    """Fill the derivatives of the deformation of contact i in slip from those of its angle."""
    limit = problem.limit_slope[i] * row[Stage.Z]
    for k in range(COLUMNS):
        slopes.deformation[0, k] = -limit * slopes.angle[k] * row[Stage.N_Y]
        slopes.deformation[1, k] = limit * slopes.angle[k] * row[Stage.N_X]


@compiled
def end_slopes(problem, i, regime, row, slopes):
    """Fill the derivatives of the deformation of contact i at the end of a period."""
    if regime == Regime.SLIP:
        fill_slip_deformation(problem, i, row, slopes)
    elif regime == Regime.SEPARATED:
        slopes.deformation[:] = 0.0


@compiled
def _solved(x, y, slopes):
    """Return (1 - M)^-1 (x, y), M the derivative of the deformation after a period in that before; else (0, 0)."""
    m = slopes.deformation
    a, b, c, d = 1.0 - m[0, 0], -m[0, 1], -m[1, 0], 1.0 - m[1, 1]
    determinant = a * d - b * c
    if abs(determinant) < LEAST:
        return 0.0, 0.0
    return (d * x - b * y) / determinant, (a * y - c * x) / determinant


@compiled
def to_fixed_point(before, way, reach, e, slopes):
    """Move a deformation e, that a period has moved by `way` from `before`, to the one that repeats to first order.

    Return the size of the step: at most `reach`, or that of the period.
    """
    d_x, d_y = _solved(way[0], way[1], slopes)
    size, own = np.hypot(d_x, d_y), np.hypot(way[0], way[1])
    if size == 0.0:
        if reach == np.inf:
            return own
        d_x, d_y, size = way[0], way[1], own
        d_x, d_y, size = d_x * reach / own, d_y * reach / own, reach
    if size > reach:
        d_x, d_y, size = d_x * reach / size, d_y * reach / size, reach
    if size > own:
        e[0], e[1] = before[0] + d_x, before[1] + d_y
    return max(size, own)


@compiled
def in_velocity(period, slopes, out):
    """Fill the derivatives (x by x, x by y, y by x, y by y) of the mean force of a motion that repeats in its velocity.

    The deformation at the start then changes by (1 - M)^-1 N, M and N the derivatives of that after the period.
    """
    for k in range(2):
        e_x, e_y = _solved(slopes.deformation[0, 2 + k], slopes.deformation[1, 2 + k], slopes)
        for axis in range(2):
            own = slopes.force[axis, 2 + k] + slopes.force[axis, 0] * e_x + slopes.force[axis, 1] * e_y
            out[2 * axis + k] = own / period
