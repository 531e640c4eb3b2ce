"""Integration of the slider in the plane under constant inputs.

Arguments as in `plane_force_tables`; preload, N; fx, fy and torque act on the slider along +x, +y and positive yaw.
"""

from math import cos, exp, sin, sqrt

from contact.jit.compiled import compiled, native
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_cycle import contact_force, set_levels
from studies.export.reduced_plane.plane_force_tables import element_force, rest_approach, set_wave
from studies.export.reduced_plane.plane_index import Array
from studies.export.reduced_plane.plane_matrix import solve_matrix

GAMMA = 0.2928932188134524  # 1 - 1/sqrt(2)
SETTLED = 1e-6  # of the waves and the approach at rest: an amplitude that is that near to its drive has settled
CLOSE = 1e-10  # of the speed plus the creep: a residual at which Newton's method ends
ROUND = 1e-7  # of friction's part in a step: the same where the forces are computed, which repeat to 1e-8


@native("f1 f1")
def begin(p: Array, state: Array) -> int:
    """Put the slider at rest at time 0, at its first place; return 0."""
    i: int = 0
    while i < index.STATE_SIZE + index.ELEMENT_STATE * p[index.ELEMENTS]:
        state[i] = 0.0
        i = i + 1
    state[index.RESTS] = 1.0
    return 0


@compiled
def inverse_mass(p: Array, k: int) -> float:
    """Return 1/m, or 1/J of the yaw; 0 of what is held."""
    if k < 2:
        return p[index.MOVES] / p[index.MASS]
    return p[index.TURNS] / p[index.INERTIA]


@compiled
def response(
    p: Array, tables: Array, state: Array, element: int, vx: float, vy: float, s: float, preload: float,
    differentiate: int,
) -> float:  # fmt: skip
    """Fill g of an element and, with ``differentiate`` 1, its derivatives at a velocity; return its speed, m/s."""
    if p[index.STEPS] > 0.5:
        return contact_force(p, tables, state, element, vx, vy, preload)
    speed = element_force(p, tables, state, element, vx, vy, s)
    if differentiate == 1:
        x = state[index.FOUND]
        y = state[index.FOUND + 1]
        h = 1e-6 * (speed + p[index.CREEP])
        element_force(p, tables, state, element, vx + h, vy, s)
        state[index.SLOPE] = (state[index.FOUND] - x) / h
        state[index.SLOPE + 2] = (state[index.FOUND + 1] - y) / h
        element_force(p, tables, state, element, vx, vy + h, s)
        state[index.SLOPE + 1] = (state[index.FOUND] - x) / h
        state[index.SLOPE + 3] = (state[index.FOUND + 1] - y) / h
        state[index.FOUND] = x
        state[index.FOUND + 1] = y
    return speed


@compiled
def set_waves(
    p: Array, tables: Array, state: Array, first: float, second: float, preload: float
) -> float:  # fmt: skip
    """Store what depends on waves of two normal amplitudes in m and on the preload; return the sum of both."""
    if p[index.STEPS] < 0.5:
        return set_wave(p, state, first, second, preload)
    level = second / p[index.AMPLITUDE + 1] if p[index.DRIVES] > 1.5 else 0.0
    set_levels(p, tables, state, first / p[index.AMPLITUDE], level, preload)
    return first + second


@compiled
def evaluate(
    p: Array, tables: Array, state: Array, yaw: float, s: float, preload: float, fx: float, fy: float, torque: float,
    step: float, differentiate: int,
) -> float:  # fmt: skip
    """Fill forces and the residual u - BASE - step f(u)/m at the rates TRIAL; return the largest speed of an element.

    With ``differentiate`` 1 also the derivative of the residual.
    """
    u_x = state[index.TRIAL]
    u_y = state[index.TRIAL + 1]
    rate = state[index.TRIAL + 2]
    limit = p[index.FRICTION] * preload
    c = 1.0
    d = 0.0
    if p[index.ARMS_TURN] > 0.5:
        c = cos(yaw)
        d = sin(yaw)
    total_x = fx - p[index.DAMPING] * u_x
    total_y = fy - p[index.DAMPING] * u_y
    moment = torque - p[index.YAW_DAMPING] * rate
    state[index.FORCE] = 0.0
    state[index.FORCE + 1] = 0.0
    state[index.FORCE + 2] = 0.0
    k: int = 0
    if differentiate == 1:
        while k < 12:
            state[index.MATRIX + k] = 0.0
            k = k + 1
        state[index.MATRIX] = 1.0 + step * p[index.DAMPING] * inverse_mass(p, 0)
        state[index.MATRIX + 5] = 1.0 + step * p[index.DAMPING] * inverse_mass(p, 1)
        state[index.MATRIX + 10] = 1.0 + step * p[index.YAW_DAMPING] * inverse_mass(p, 2)
    fastest = 0.0
    e: int = 0
    while e < p[index.ELEMENTS]:
        own: int = index.FIRST_ELEMENT + e * index.ELEMENT_SIZE
        x = c * p[own + index.ELEMENT_X] - d * p[own + index.ELEMENT_Y]
        y = d * p[own + index.ELEMENT_X] + c * p[own + index.ELEMENT_Y]
        vx = u_x - rate * y
        vy = u_y + rate * x
        fastest = max(fastest, response(p, tables, state, e, vx, vy, s, preload, differentiate))
        q_x = limit * state[index.FOUND]
        q_y = limit * state[index.FOUND + 1]
        state[index.FORCE] = state[index.FORCE] + q_x
        state[index.FORCE + 1] = state[index.FORCE + 1] + q_y
        state[index.FORCE + 2] = state[index.FORCE + 2] + x * q_y - y * q_x
        if differentiate == 1:
            xx = limit * state[index.SLOPE]
            xy = limit * state[index.SLOPE + 1]
            yx = limit * state[index.SLOPE + 2]
            yy = limit * state[index.SLOPE + 3]
            # by the yaw rate
            xr = x * xy - y * xx
            yr = x * yy - y * yx
            a = step * inverse_mass(p, 0)
            b = step * inverse_mass(p, 2)
            state[index.MATRIX] = state[index.MATRIX] - a * xx
            state[index.MATRIX + 1] = state[index.MATRIX + 1] - a * xy
            state[index.MATRIX + 2] = state[index.MATRIX + 2] - a * xr
            state[index.MATRIX + 4] = state[index.MATRIX + 4] - a * yx
            state[index.MATRIX + 5] = state[index.MATRIX + 5] - a * yy
            state[index.MATRIX + 6] = state[index.MATRIX + 6] - a * yr
            state[index.MATRIX + 8] = state[index.MATRIX + 8] - b * (x * yx - y * xx)
            state[index.MATRIX + 9] = state[index.MATRIX + 9] - b * (x * yy - y * xy)
            state[index.MATRIX + 10] = state[index.MATRIX + 10] - b * (x * yr - y * xr)
        e = e + 1
    total_x = total_x + state[index.FORCE]
    total_y = total_y + state[index.FORCE + 1]
    moment = moment + state[index.FORCE + 2]
    state[index.STEP_FORCE] = total_x * inverse_mass(p, 0)
    state[index.STEP_FORCE + 1] = total_y * inverse_mass(p, 1)
    state[index.STEP_FORCE + 2] = moment * inverse_mass(p, 2)
    k = 0
    while k < 3:
        state[index.NEW_RESIDUAL + k] = (
            state[index.TRIAL + k] - state[index.BASE + k] - step * state[index.STEP_FORCE + k]
        )
        k = k + 1
    return fastest


@compiled
def size_of(p: Array, state: Array, start: int) -> float:
    """Return the length of a vector of rates with the weights of the kinetic energy, over the mass."""
    x = state[start]
    y = state[start + 1]
    w = state[start + 2]
    inertia = p[index.TURNS] * p[index.INERTIA] / p[index.MASS]
    return sqrt(x * x + y * y + inertia * w * w)


@compiled
def implicit_stage(
    p: Array, tables: Array, state: Array, yaw: float, s: float, preload: float, fx: float, fy: float, torque: float,
    step: float,
) -> float:  # fmt: skip
    """Solve u = BASE + step f(u)/m from START by damped Newton steps; u stands in TRIAL. Return the largest speed.

    A full step that does not lessen the residual may have jumped over rest, where the forces bend within the creep:
    then the search begins there.
    """
    k: int = 0
    restarted: int = 0
    turns: int = 0
    while k < 3:
        state[index.TRIAL + k] = state[index.START + k]
        k = k + 1
    fastest = evaluate(p, tables, state, yaw, s, preload, fx, fy, torque, step, 1)
    while turns < 60:
        k = 0
        while k < 3:
            state[index.RESIDUAL + k] = state[index.NEW_RESIDUAL + k]
            state[index.START + k] = state[index.TRIAL + k]
            k = k + 1
        old = size_of(p, state, index.RESIDUAL)
        enough = CLOSE * (size_of(p, state, index.START) + p[index.CREEP])
        if p[index.STEPS] > 0.5:
            enough = enough + ROUND * step * p[index.FRICTION] * preload / p[index.MASS]
        solve_matrix(state)
        step_x = state[index.MATRIX + 3]
        step_y = state[index.MATRIX + 7]
        step_w = state[index.MATRIX + 11]
        factor = 1.0
        new = old
        tries: int = 0
        while tries < 12:
            state[index.TRIAL] = state[index.START] + factor * step_x
            state[index.TRIAL + 1] = state[index.START + 1] + factor * step_y
            state[index.TRIAL + 2] = state[index.START + 2] + factor * step_w
            fastest = evaluate(p, tables, state, yaw, s, preload, fx, fy, torque, step, 1)
            new = size_of(p, state, index.NEW_RESIDUAL)
            tries = tries + 1
            if new < 0.9 * old or new <= enough:
                tries = 12
            elif restarted == 0:
                restarted = 1
                tries = 12
                k = 0
                while k < 3:
                    state[index.TRIAL + k] = 0.0
                    k = k + 1
                fastest = evaluate(p, tables, state, yaw, s, preload, fx, fy, torque, step, 1)
                new = size_of(p, state, index.NEW_RESIDUAL)
            else:
                factor = 0.4 * factor
        turns = turns + 1
        if new <= enough:
            turns = 60
    return fastest


@compiled
def wave_at(p: Array, state: Array, drive: int, level: float, time: float) -> float:
    """Return the normal amplitude in m of a drive at a time from now on at which its level has been constant."""
    now = state[index.LEVEL + drive]
    if p[index.RISE] > 0.0:
        now = level + (now - level) * exp(-time / p[index.RISE])
    else:
        now = level
    return now * p[index.AMPLITUDE + drive]


@compiled
def settle(p: Array, state: Array, drive: int, level: float, preload: float) -> float:
    """Set a wave that is near to its drive to it; return 1 where the wave still changes."""
    if p[index.RISE] <= 0.0 or drive >= p[index.DRIVES]:
        return 0.0
    now = state[index.LEVEL + drive]
    size = p[index.AMPLITUDE + drive]
    if abs(now - level) * size > SETTLED * (max(now, level) * size + rest_approach(p, preload)):
        return 1.0
    state[index.LEVEL + drive] = level
    return 0.0


@compiled
def one_step(
    p: Array, tables: Array, state: Array, first: float, second: float, preload: float, fx: float, fy: float,
    torque: float, step: float,
) -> float:  # fmt: skip
    """Advance by one step of Alexander's method; return the largest speed of an element at its end, m/s."""
    yaw = state[index.POSE + 2]
    part = GAMMA * step
    k: int = 0
    while k < 3:
        state[index.BASE + k] = state[index.RATES + k]
        state[index.START + k] = state[index.RATES + k]
        k = k + 1
    s = set_waves(p, tables, state, wave_at(p, state, 0, first, part), wave_at(p, state, 1, second, part), preload)
    implicit_stage(p, tables, state, yaw + part * state[index.RATES + 2], s, preload, fx, fy, torque, part)
    k = 0
    while k < 3:
        state[index.FIRST_RATE + k] = state[index.TRIAL + k]
        state[index.START + k] = state[index.TRIAL + k]
        state[index.BASE + k] = state[index.RATES + k] + (1.0 - GAMMA) / GAMMA * (
            state[index.TRIAL + k] - state[index.RATES + k]
        )
        k = k + 1
    s = set_waves(p, tables, state, wave_at(p, state, 0, first, step), wave_at(p, state, 1, second, step), preload)
    fastest = implicit_stage(
        p, tables, state, yaw + step * state[index.FIRST_RATE + 2], s, preload, fx, fy, torque, part
    )
    k = 0
    while k < 3:
        state[index.POSE + k] = state[index.POSE + k] + step * (
            (1.0 - GAMMA) * state[index.FIRST_RATE + k] + GAMMA * state[index.TRIAL + k]
        )
        state[index.RATES + k] = state[index.TRIAL + k]
        k = k + 1
    state[index.LEVEL] = wave_at(p, state, 0, first, step) / p[index.AMPLITUDE]
    if p[index.DRIVES] > 1.5:
        state[index.LEVEL + 1] = wave_at(p, state, 1, second, step) / p[index.AMPLITUDE + 1]
    return fastest


@native("f1 f1 f1 f f f f f f f")
def advance(
    p: Array, tables: Array, state: Array, first: float, second: float, fx: float, fy: float, torque: float,
    preload: float, duration: float,
) -> int:  # fmt: skip
    """Advance by a duration in s under constant inputs.

    Return 0, 1 if a number is not finite, 2 where the table does not reach as far as the waves.
    """
    start = state[index.TIME]
    done = 0.0
    fastest = 0.0
    state[index.OUTSIDE] = 0.0
    set_waves(p, tables, state, first * p[index.AMPLITUDE], second * p[index.AMPLITUDE + 1], preload)
    if state[index.OUTSIDE] > 0.5 or rest_approach(p, preload) <= 0.0:
        return 2
    while done < duration * (1.0 - 1e-12):
        step = p[index.MAX_STEP]
        if settle(p, state, 0, first, preload) + settle(p, state, 1, second, preload) > 0.5:
            step = p[index.FAST_STEP]
        step = min(step, duration - done)
        fastest = one_step(p, tables, state, first, second, preload, fx, fy, torque, step)
        done = done + step
        state[index.TIME] = start + done
    state[index.RESTS] = 1.0 if fastest <= p[index.CREEP] else 0.0
    total = state[index.POSE] + state[index.POSE + 1] + state[index.POSE + 2]
    total = total + state[index.RATES] + state[index.RATES + 1] + state[index.RATES + 2]
    if total - total != 0.0:
        return 1
    return 2 if state[index.OUTSIDE] > 0.5 else 0
