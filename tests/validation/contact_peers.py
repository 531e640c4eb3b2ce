r"""The seed's contact as others would integrate it: event solvers off the shelf, and fixed steps as an engineer writes.

In the scaled units of ``contact.problem``; one contact, elastic law.  State z_s, z_s', v, x.  An event solver gets the
right-hand side of the regime it is in, compiled, and three guards that are positive inside; at an event the regime is
changed on the far side and the solver starts anew.  SUNDIALS is reached through scikit-sundae, if that is installed.

The naive way follows the paper's text: explicit steps, x_max' by differences, the slip speed without the sign of the
deformation, stick as soon as it is within DV.
"""

import time

import numba
import numpy as np

__all__ = ["cvode", "first_wave", "naive", "numbers", "scipy_solver", "with_events"]

SEPARATED, STICK, SLIP = 0, 1, 2


@numba.njit
def _surface(t, wave):
    c, s = np.cos(t), np.sin(t)
    return (
        wave[0] * c + wave[1] * s, wave[1] * c - wave[0] * s, wave[2] * c + wave[3] * s, wave[3] * c - wave[2] * s,
    )  # fmt: skip


@numba.njit
def rates(t, y, regime, sign, par, wave, out):
    """Fill the time derivatives of (z_s, z_s', v, x)."""
    u, w, _, w_x = _surface(t, wave)
    z = u - y[0]
    push, pull = 0.0, 0.0
    if regime != SEPARATED and z > 0.0:
        push = par[0] * z * np.sqrt(z)
        if regime == SLIP:
            pull = sign * par[6] * push
        else:
            left = max(1.0 - abs(y[3]) / (par[7] * z), 0.0)
            pull = np.sign(y[3]) * par[6] * push * (1.0 - left * np.sqrt(left))
    out[0] = y[1]
    out[1] = push - par[2] * y[1] - par[3]
    out[2] = pull - par[4] * y[2] - par[5]
    out[3] = 0.0
    if regime == STICK:
        out[3] = w_x - y[2]
    elif regime == SLIP:
        out[3] = sign * par[7] * (w - y[1])


@numba.njit
def guards(t, y, regime, sign, par, wave, out):
    """Fill three guards, positive inside the regime."""
    u, w, _, w_x = _surface(t, wave)
    z = u - y[0]
    out[0] = -z if regime == SEPARATED else z
    out[1] = out[2] = 1.0
    if regime == STICK:
        out[1], out[2] = par[7] * z - y[3], par[7] * z + y[3]
    elif regime == SLIP:
        out[1] = sign * (w_x - y[2]) - par[7] * (w - y[1])


def _next(t, y, regime, sign, which, par, wave):
    """Return (regime, sign) on the far side of a guard; y is changed."""
    u, w, _, w_x = _surface(t, wave)
    z = u - y[0]
    if which == 0 and regime != SEPARATED:
        y[3] = 0.0
        return SEPARATED, sign
    if which == 0:
        sign, y[3] = (1.0 if w_x >= y[2] else -1.0), 0.0
    elif regime == STICK:
        sign = 1.0 if which == 1 else -1.0
        y[3] = sign * par[7] * z * (1.0 - 1e-14)
    else:
        y[3] = sign * par[7] * z * (1.0 - 1e-14)
        return STICK, sign
    return (SLIP if sign * (w_x - y[2]) - par[7] * (w - y[1]) > 0.0 else STICK), sign


def numbers(problem):
    """Return (8,): kappa, chi (not used here), d_n, p_0, d_t, q, mu and c of a problem, the parameters of the rates."""
    return np.array(problem[:8], float)


def first_wave(problem):
    """Return (4,): a, b of u_z = a cos phi + b sin phi under the first contact, then of u_x."""
    return np.array([each[0] for each in problem.paths[1:]])


def with_events(problem, state, cycles, segment, *, limit):
    """Return (v, events, complaint) after a number of cycles, one segment per regime; complaint is "" if none.

    Parameters
    ----------
    problem : contact.problem.Problem
        One contact.
    state : (4,) array
        At phase 0, in stick.
    cycles : int
        To follow.
    segment : callable
        (t, y, stop, regime, sign, parameters, wave) -> (t, y, guard or -1), raising RuntimeError with a complaint.
    limit : float
        s of run time.
    """
    par, wave = numbers(problem), first_wave(problem)
    t, stop, y = 0.0, 2.0 * np.pi * cycles, state.copy()
    regime, sign, events, begun = STICK, 1.0, 0, time.process_time()
    while t < stop * (1.0 - 1e-15):
        if time.process_time() - begun > limit:
            return float(y[2]), events, f"stopped after {limit:g} s at {100 * t / stop:.0f} %"
        try:
            t, y, which = segment(t, y, stop, regime, sign, par, wave)
        except (RuntimeError, ValueError) as error:  # a ValueError: the solver's own root finder gave up
            return float(y[2]), events, str(error)
        if which >= 0:
            regime, sign = _next(t, y, regime, sign, which, par, wave)
            events += 1
    return float(y[2]), events, ""


def scipy_solver(method, *, rtol, max_step):
    """Return the segment function of a method of ``scipy.integrate.solve_ivp``."""
    from scipy.integrate import solve_ivp

    out, values = np.empty(4), np.empty(3)

    def right_hand_side(t, y, regime, sign, par, wave):
        rates(t, y, regime, sign, par, wave, out)
        return out.copy()

    def event(number):
        def g(t, y, regime, sign, par, wave):
            guards(t, y, regime, sign, par, wave, values)
            return values[number]

        g.terminal, g.direction = True, -1.0
        return g

    three = [event(number) for number in range(3)]

    def segment(t, y, stop, regime, sign, par, wave):
        found = solve_ivp(
            right_hand_side, (t, stop), y, method=method, rtol=rtol, atol=1e-3 * rtol, max_step=max_step, events=three,
            args=(regime, sign, par, wave), dense_output=False,
        )  # fmt: skip
        if not found.success:
            raise RuntimeError(found.message)
        hit = [k for k in range(3) if found.t_events[k].size]
        return float(found.t[-1]), found.y[:, -1].copy(), hit[0] if found.status == 1 else -1

    return segment


def cvode(method, *, rtol, max_step):
    """Return the segment function of CVODE with root functions, or None if scikit-sundae is not installed."""
    try:
        from sksundae.cvode import CVODE
    except ImportError:
        return None

    def segment(t, y, stop, regime, sign, par, wave):
        def right_hand_side(s, y, yp):
            rates(s, y, regime, sign, par, wave, yp)

        def event(s, y, g):
            guards(s, y, regime, sign, par, wave, g)

        event.terminal, event.direction = [True] * 3, [-1] * 3
        solver = CVODE(
            right_hand_side, method=method, rtol=rtol, atol=1e-3 * rtol, max_step=max_step, eventsfn=event,
            num_events=3, max_num_steps=10_000_000,
        )  # fmt: skip
        found = solver.solve(np.array([t, stop]), y)
        if found.status < 0:
            raise RuntimeError(str(found.message))
        if found.i_events is None or len(found.i_events) == 0:
            return float(found.t[-1]), np.array(found.y[-1]), -1
        which = int(np.flatnonzero(found.i_events[-1])[0])
        return float(found.t_events[-1]), np.array(found.y_events[-1]), which

    return segment


@numba.njit
def naive(par, wave, state, cycles, per_cycle, band):
    """Return v after explicit steps of the paper's algorithm, stick within the band DV."""
    h = 2.0 * np.pi / per_cycle
    height, climb, v, x = state
    stuck, before = True, par[7] * max(wave[0] - height, 0.0)
    for k in range(cycles * per_cycle):
        u, _, _, w_x = _surface(k * h, wave)
        z = u - height
        push, pull = 0.0, 0.0
        limit = par[7] * max(z, 0.0)
        if z > 0.0:
            push = par[0] * z * np.sqrt(z)
            slip_speed = w_x - (limit - before) / h - v
            if stuck:
                x += h * (w_x - v)
                stuck = abs(x) < limit
            else:
                stuck = abs(slip_speed) < band
            if not stuck:
                x = np.sign(x) * limit if x != 0.0 else limit
            left = max(1.0 - abs(x) / limit, 0.0)
            pull = np.sign(x) * par[6] * push * (1.0 - left * np.sqrt(left))
        else:
            x, stuck = 0.0, True
        before = limit
        climb += h * (push - par[2] * climb - par[3])
        v += h * (pull - par[4] * v - par[5])
        height += h * climb
    return v
