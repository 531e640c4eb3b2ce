r"""Many cycles in fixed steps: the stop operator inside a Verlet step.

Positions by Verlet, forces at the step's ends, and the stop operator as a projection: the deformation follows the
surface and is cut to [-c z, c z]. The slider is heavy, so its own step errs little; what plain projection loses, it
loses at the events. These are located on cubics through values and rates, the deformation is laid out from there, and
the trapezoidal sums of the forces get the terms that belong to a fractional power at an edge (`end_corrections`):
contact, release, end of stick, x = 0. The surface motion of one cycle is tabulated.

An envelope scales the wave: e(t), complex, linear within each cycle, u = Re(e U exp(i phi)).

Not for a stick band (creep), nor where the contact resonance is not well resolved by the step.
"""

import numpy as np

from contact.jit.compiled import compiled, native
from contact.kinematics import Paths, at_phase, of_run
from contact.law.normal import load
from contact.problem import from_row
from contact.solve.end_corrections import (
    closing_share,
    contact_edge,
    cubic,
    curvature,
    edge_excess,
    last_part,
    passage_excess,
    rising_root,
    slip_edge,
)

# rows of the cells, one column per run: slider, contact forces alone, distance within the cycle, what a step is made of
HEIGHT, CLIMB, SPEED, PUSH, PULL, TRAVELLED, STEP, DAMP_N, DAMP_T, INVERSE, CELL = range(11)


@compiled
def _tabulate(paths, per_cycle, before, after, table):
    """Fill surface displacement and velocity of one cycle under an envelope that goes from `before` to `after`."""
    u_z, u_x, w_z, w_x = table[0], table[1], table[2], table[3]
    h = 2.0 * np.pi / per_cycle
    turn = (after - before) / (2.0 * np.pi)
    for k in range(per_cycle + 1):
        co, si = np.cos(h * (k % per_cycle)), np.sin(h * (k % per_cycle))
        e = before + (after - before) * (k / per_cycle)
        for i in range(paths.height.size):
            u, w, along, drift = at_phase(paths, i, co, si)
            u_z[k, i] = paths.height[i] + e.real * u + e.imag * w
            w_z[k, i] = e.real * w - e.imag * u + turn.real * u + turn.imag * w
            u, w = along, drift
            u_x[k, i] = e.real * u + e.imag * w
            w_x[k, i] = e.real * w - e.imag * u + turn.real * u + turn.imag * w


@compiled
def _step(problem, k, table, own, cells, m):
    """Move one run from step k of the cycle to the next; column m of `cells` is the slider, `own` its contacts."""
    kappa, chi, d_n, p = problem.stiffness, problem.contact_damping, problem.normal_damping, problem.preload
    d_t, q, mu, c = problem.tangential_damping, problem.load, problem.friction, problem.limit_slope
    u_z, u_x, w_z, w_x = table[0], table[1], table[2], table[3]
    z, x, slip, shape = own[0], own[1], own[2], problem.shape
    height, climb, speed, push, pull = (
        cells[HEIGHT, m],
        cells[CLIMB, m],
        cells[SPEED, m],
        cells[PUSH, m],
        cells[PULL, m],
    )
    h = cells[STEP, m]
    climb_half = climb + 0.5 * h * (push - p - d_n * climb)
    speed_half = speed + 0.5 * h * (pull - q - d_t * speed)
    height += h * climb_half
    travel = h * speed_half
    cells[TRAVELLED, m] += travel
    climb_next = 2.0 * climb_half - climb  # enough for rates at the step's end
    speed_next = 2.0 * speed_half - speed
    push, pull, push_excess, pull_excess = 0.0, 0.0, 0.0, 0.0
    for i in range(z.size):
        z_old, z_new = z[i], u_z[k + 1, i] - height
        z[i] = z_new
        if z_new <= 0.0:
            if z_old > 0.0:
                r0, r1 = h * (w_z[k, i] - climb), h * (w_z[k + 1, i] - climb_next)
                s = rising_root(-z_old, -z_new, -r0, -r1)
                rate = max(-(r0 + s * (r1 - r0)) / h, 1e-6)
                first, second = contact_edge(problem, rate, problem.paths.height[i] - height, h)
                sign = 1.0 if x[i] > 0.0 else -1.0
                if slip[i] == 0.0:  # it must have slipped before
                    along = x[i] + u_x[k + 1, i] - u_x[k, i] - travel
                    sign = 1.0 if along > 0.0 else -1.0
                    v_old = sign * (w_x[k, i] - speed) - c * (w_z[k, i] - climb)
                    v_new = sign * (w_x[k + 1, i] - speed_next) - c * (w_z[k + 1, i] - climb_next)
                    pull_excess -= sign * slip_edge(
                        problem,
                        sign * x[i] - c * z_old,
                        sign * along - c * z_new,
                        v_old,
                        v_new,
                        h,
                    )
                push_excess += edge_excess(s, h, first * (1.0 - chi * rate), second, shape)
                pull_excess += sign * mu * edge_excess(s, h, first, second, shape)
                x[i], slip[i] = 0.0, 0.0
            continue
        z_rate, x_rate = w_z[k + 1, i] - climb_next, w_x[k + 1, i] - speed_next
        limit = c * z_new
        along = u_x[k + 1, i] - u_x[k, i] - travel
        elastic = kappa * load(z_new, problem.shape)
        if z_old > 0.0 and slip[i] == 0.0:
            old = x[i]
            deformation = old + along
            if abs(deformation) < limit:  # stick all along
                x[i] = deformation
                push += elastic * (1.0 + chi * z_rate)
                # mu P (1 - (1 - |x|/c z)^1.5) without its division
                stick = z_new - abs(deformation) * cells[INVERSE, m]
                force = mu * (elastic - kappa * load(stick, problem.shape))
                pull += force if deformation > 0.0 else -force
                if old * deformation < 0.0:
                    bend = curvature(shape) * mu * elastic * x_rate * abs(x_rate) / (limit * limit)
                    pull_excess += passage_excess(old / (old - deformation), h, bend)
                continue
            sign = 1.0 if deformation > 0.0 else -1.0
            v_old = sign * (w_x[k, i] - speed) - c * (w_z[k, i] - climb)
            v_new = sign * x_rate - c * z_rate
            pull_excess -= sign * slip_edge(
                problem, sign * old - c * z_old, sign * deformation - limit, v_old, v_new, h
            )
            if v_new >= 0.0:
                x[i], slip[i] = sign * limit, sign
            else:  # slips and sticks again within the step
                x[i] = sign * limit
        else:
            if z_old <= 0.0:
                r0, r1 = h * (w_z[k, i] - climb), h * z_rate
                s = rising_root(z_old, z_new, r0, r1)
                y0, y1 = h * (w_x[k, i] - speed), h * x_rate
                rate, drift = max((r0 + s * (r1 - r0)) / h, 1e-6), (y0 + s * (y1 - y0)) / h
                sign = 1.0 if drift > 0.0 else -1.0
                x[i] = along - cubic(s, 0.0, along, y0, y1)
                first, second = contact_edge(problem, rate, problem.paths.height[i] - height, h)
                push_excess += edge_excess(1.0 - s, h, first * (1.0 + chi * rate), second, shape)
                ratio = min(sign * drift / (c * rate), 1.0)
                share, steep = closing_share(ratio, shape)
                turn = 0.0
                if ratio < 1.0:
                    bend = sign * (w_x[k + 1, i] - w_x[k, i]) / (h * c) + ratio * (
                        height - problem.paths.height[i]
                    )
                    turn = steep * bend / rate
                    turn = min(max(turn, -1.0 / h), 1.0 / h)
                pull_excess += (
                    sign * mu * edge_excess(1.0 - s, h, first * share, second * share + first * turn, shape)
                )
                slip[i] = sign if ratio == 1.0 else 0.0
                v_old = sign * drift - c * rate
            else:
                s, sign = 0.0, slip[i]
                v_old = sign * (w_x[k, i] - speed) - c * (w_z[k, i] - climb)
            if slip[i] != 0.0:
                v_new = sign * x_rate - c * z_rate
                if v_new >= 0.0:
                    x[i] = sign * limit
                elif z_old <= 0.0:
                    # slip ends within the step: what follows is stick from the limit there
                    rest = (1.0 - s) * h * v_new / (v_new - v_old)
                    x[i] = sign * (limit + 0.5 * rest * v_new)
                    slip[i] = 0.0
                else:
                    _, lag = last_part(v_old, v_new, (sign * along - c * (z_new - z_old)) / h)
                    x[i] = sign * (limit + h * lag)
                    slip[i] = 0.0
            elif abs(x[i]) >= limit:
                slip[i] = 1.0 if x[i] > 0.0 else -1.0
                x[i] = slip[i] * limit
        push += elastic * (1.0 + chi * z_rate)
        if slip[i] != 0.0:
            pull += slip[i] * mu * elastic
        else:
            stick = z_new - abs(x[i]) * cells[INVERSE, m]
            force = mu * (elastic - kappa * load(stick, problem.shape))
            pull += force if x[i] > 0.0 else -force
    climb = (climb_half + 0.5 * h * (push - p) - push_excess) * cells[DAMP_N, m]
    speed = (speed_half + 0.5 * h * (pull - q) - pull_excess) * cells[DAMP_T, m]
    cells[HEIGHT, m], cells[CLIMB, m], cells[SPEED, m], cells[PUSH, m], cells[PULL, m] = (
        height,
        climb,
        speed,
        push,
        pull,
    )


@native(
    "f2 t f2 i i1 i f3 c1 f4 f3 f2",
    {
        "numbers": "r 14", "paths.height": "r n", "paths.normal_cos": "r n", "states": "r 3+n",
        "per_cycle": "r", "rows": "r m 3", "tables": "r 4 s n", "own": "r 3 n", "cells": "10 r",
    },
)  # fmt: skip
def _abreast(numbers, paths, states, number, per_cycle, stride, rows, envelope, tables, own, cells):
    """Do the work of `abreast`; return whether all is finite."""
    runs, n = paths.height.shape
    shaped = envelope.size > 0
    e = envelope[0] if shaped else 1.0 + 0.0j
    most = 0
    for m in range(runs):
        _tabulate(of_run(paths, m), per_cycle[m], e, e, tables[m])
        _begin(from_row(numbers[m], of_run(paths, m)), states[m], per_cycle[m], tables[m], own[m], cells, m)
        most = max(most, per_cycle[m])
    for cycle in range(number):
        for m in range(runs):
            cells[TRAVELLED, m] = 0.0
            if shaped:
                _tabulate(of_run(paths, m), per_cycle[m], envelope[cycle], envelope[cycle + 1], tables[m])
        # runs do not wait for each other: the processor works at several at once
        for k in range(most):
            for m in range(runs):
                if k < per_cycle[m]:
                    _step(from_row(numbers[m], of_run(paths, m)), k, tables[m], own[m], cells, m)
        for m in range(runs):
            if not np.isfinite(cells[HEIGHT, m] + cells[CLIMB, m] + cells[SPEED, m]):
                return False
            if stride > 0 and (cycle + 1) % stride == 0:
                row = (cycle + 1) // stride - 1
                rows[m, row, 0], rows[m, row, 1] = cells[SPEED, m], cells[HEIGHT, m]
                rows[m, row, 2] = cells[TRAVELLED, m] / (2.0 * np.pi)
    for m in range(runs):
        states[m, 0], states[m, 1], states[m, 2] = cells[HEIGHT, m], cells[CLIMB, m], cells[SPEED, m]
        for i in range(n):
            states[m, 3 + i] = own[m, 1, i]
    return True


@compiled
def _begin(problem, state, per_cycle, table, own, cells, m):
    """Set the forces of the first instant and what stays the same."""
    h = 2.0 * np.pi / per_cycle
    cells[STEP, m], cells[INVERSE, m] = h, 1.0 / problem.limit_slope
    cells[DAMP_N, m], cells[DAMP_T, m] = (
        1.0 / (1.0 + 0.5 * h * problem.normal_damping),
        1.0 / (1.0 + 0.5 * h * problem.tangential_damping),
    )
    kappa, chi, mu, c = problem.stiffness, problem.contact_damping, problem.friction, problem.limit_slope
    cells[HEIGHT, m], cells[CLIMB, m], cells[SPEED, m] = state[0], state[1], state[2]
    push, pull = 0.0, 0.0
    for i in range(own.shape[1]):
        x, z, slip = state[3 + i], table[0, 0, i] - state[0], 0.0
        if z > 0.0:
            elastic = kappa * load(z, problem.shape)
            push += elastic * (1.0 + chi * (table[2, 0, i] - state[1]))
            stick = z - abs(x) / c
            pull += np.sign(x) * mu * (elastic - kappa * load(stick, problem.shape))
            slip = np.sign(x) if stick < 1e-13 * z else 0.0
        own[0, i], own[1, i], own[2, i] = z, x, slip
    cells[PUSH, m], cells[PULL, m] = push, pull


def abreast(problems, states, number, per_cycle, stride, rows, envelope) -> bool:
    """Move several runs through whole cycles, side by side; return whether all have stayed finite.

    Parameters
    ----------
    problems : list of Problem
        One per run, all of n contacts.
    states : (k, 3 + n) array
        z_s, z_s', v, x_1..x_n; changed in place.
    number : int
        Cycles.
    per_cycle : (k,) int array
        Steps in each cycle.
    stride, rows : int, (k, number // stride, 3) array
        Every `stride` cycles a row (v, z_s, mean v of the last cycle) is filled; stride 0 records nothing.
    envelope : (0,) or (number + 1,) complex array
        Factor on the waves at the ends of the cycles; empty: the waves as they are.
    """
    numbers = np.array([each.row for each in problems])
    paths = Paths(*(np.array(rows) for rows in zip(*(each.paths for each in problems), strict=True)))
    runs, n = paths.height.shape
    room = np.empty((runs, 4, int(np.max(per_cycle)) + 1, n)), np.empty((runs, 3, n)), np.zeros((CELL, runs))
    return bool(_abreast(numbers, paths, states, number, per_cycle, stride, rows, envelope, *room))


def steps(problem, state, number, per_cycle, stride, rows, envelope) -> bool:
    """Move one run through whole cycles of equal steps: `abreast` of one."""
    return abreast([problem], state[None], number, np.array([per_cycle]), stride, rows[None], envelope)
