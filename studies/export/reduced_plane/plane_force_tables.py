"""Mean force of an element from its tables, by cubic interpolation.

Arguments: p, the flat array of parameters, and state, that of the state (`plane_index`); tables; element, its number;
vx and vy, its velocity, m/s; s, the normal amplitude of the waves, m.  Results stand in the state.
"""

from math import atan2, exp, log, sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_index import Array

SIXTH = 0.16666666666666666
TURN = 6.283185307179586
CLOSER = 0.2  # distance of angles at an axis over the mean one, as those below for speeds
KNEE = 0.8  # of the speed v_1 s, see `speed_position`
MIDDLE = 0.7071067811865476  # of q = KNEE
BELOW = 0.625  # part of the speeds below it: a multiple of 1/8
CLOSER_BELOW = 0.2
CLOSER_ABOVE = 0.2897056274847714  # as close on both sides: CLOSER_BELOW MIDDLE/(1 - MIDDLE) (1 - BELOW)/BELOW


@compiled
def weight(t: float, k: int) -> float:
    """Return the weight at t of the value at k - 1 in the cubic through four values at -1, 0, 1, 2."""
    if k == 0:
        return -SIXTH * t * (t - 1.0) * (t - 2.0)
    if k == 1:
        return 0.5 * (t + 1.0) * (t - 1.0) * (t - 2.0)
    if k == 2:
        return -0.5 * (t + 1.0) * t * (t - 2.0)
    return SIXTH * (t + 1.0) * t * (t - 1.0)


@compiled
def first_node(position: float, nodes: int) -> int:
    """Return the first of the four nodes about a position, which counts from 0; 0 of a single node."""
    k: int = int(position) - 1
    if k > nodes - 4:
        k = nodes - 4
    if k < 0:
        k = 0
    return k


@compiled
def spread(x: float, closer: float) -> float:
    """Return t of -1 to 1 with closer t + (1 - closer) t^3 = x: nodes equidistant in t lie closer together at 0."""
    a = closer / (3.0 * (1.0 - closer))
    y = 0.5 * abs(x) / ((1.0 - closer) * a * sqrt(a))
    third = exp(log(y + sqrt(y * y + 1.0)) / 3.0)  # Cardano's root of t^3 + 3 a t = x/(1 - closer)
    t = sqrt(a) * (third - 1.0 / third)
    return t if x > 0.0 else -t


@compiled
def angle_position(angle: float, axes: float) -> float:
    """Return the place of an angle (rad, from the waves' axis) among the nodes as a part of a turn, 0 to 1.

    The nodes lie closer together at the axes: across a wave the force changes within a few degrees.
    """
    turn = angle / TURN
    k: int = int(turn)
    if turn < k:
        k = k - 1
    turn = turn - k
    sector: int = int(turn * axes + 0.5)
    found = (sector + 0.5 * spread(2.0 * (turn * axes - sector), CLOSER)) / axes
    if found < 0.0:
        found = found + 1.0
    if found >= 1.0:
        found = found - 1.0
    return found


@compiled
def speed_position(q: float) -> float:
    """Return the place of a speed q = |v|/(v_1 s) among the nodes, 0 to 1.

    The nodes are equidistant in sqrt(q/(q + KNEE)) at rest, and closer together about q = KNEE, where the slider
    comes near the largest speed of the surface and the force changes its sign.
    """
    u = sqrt(q / (q + KNEE))
    if u < MIDDLE:
        return BELOW * (1.0 + spread(u / MIDDLE - 1.0, CLOSER_BELOW))
    return BELOW + (1.0 - BELOW) * spread((u - MIDDLE) / (1.0 - MIDDLE), CLOSER_ABOVE)


@compiled
def rest_approach(p: Array, preload: float) -> float:
    """Return the approach in m that carries the preload on a surface at rest."""
    z = preload / p[index.STIFFNESS]
    return z ** (2.0 / 3.0) if p[index.EXPONENT] > 1.25 else z


@compiled
def set_wave(p: Array, state: Array, first: float, second: float, preload: float) -> float:
    """Store tau and phi of waves of two normal amplitudes in m; return their sum s."""
    s = first + second
    tau = sqrt(s) / (sqrt(s) + sqrt(rest_approach(p, preload)))
    state[index.TAU] = tau
    state[index.PHI] = second / s if s > 0.0 else 0.0
    if tau > p[index.MAX_TAU] * (1.0 + 1e-9):
        state[index.OUTSIDE] = 1.0
    return s


@compiled
def rest_row(p: Array, tables: Array, state: Array, element: int) -> float:
    """Fill g at rest, the middle of its values over the angles, and the share of the preload; return the share."""
    taus: int = int(p[index.TAU_NODES])
    phis: int = int(p[index.PHI_NODES])
    down = min(state[index.TAU] / p[index.MAX_TAU], 1.0) * (taus - 1)
    along = state[index.PHI] * (phis - 1)
    i0: int = first_node(down, taus)
    j0: int = first_node(along, phis)
    start: int = int(p[index.FIRST_ELEMENT + element * index.ELEMENT_SIZE + index.REST_TABLE])
    x = 0.0
    y = 0.0
    share = 0.0
    i: int = 0
    while i < 4:
        j: int = 0
        while j < min(phis, 4):
            w = weight(down - i0 - 1.0, i)
            if phis > 1:
                w = w * weight(along - j0 - 1.0, j)
            at: int = start + 3 * ((i0 + i) * phis + j0 + j)
            share = share + w * tables[at]
            x = x + w * tables[at + 1]
            y = y + w * tables[at + 2]
            j = j + 1
        i = i + 1
    state[index.FOUND] = x
    state[index.FOUND + 1] = y
    state[index.FOUND + 2] = share
    return share


@compiled
def element_force(p: Array, tables: Array, state: Array, element: int, vx: float, vy: float, s: float) -> float:
    """Fill g of an element at a velocity; return its speed, m/s."""
    speed = sqrt(vx * vx + vy * vy)
    share = rest_row(p, tables, state, element)
    rest_x = state[index.FOUND]
    rest_y = state[index.FOUND + 1]
    if speed <= 1e-6 * p[index.CREEP]:  # n is not known: the middle of the values at rest
        return speed
    n_x = vx / speed
    n_y = vy / speed
    x = 0.0
    y = 0.0
    if s > 0.0:
        taus: int = int(p[index.TAU_NODES])
        phis: int = int(p[index.PHI_NODES])
        nus: int = int(p[index.NU_NODES])
        angles: int = int(p[index.ANGLES])
        down = min(state[index.TAU] / p[index.MAX_TAU], 1.0) * (taus - 1)
        along = state[index.PHI] * (phis - 1)
        q = max(speed, p[index.CREEP]) / (p[index.SPEED] * s)
        out = speed_position(q) * (nus - 1)
        around = angle_position(atan2(n_y, n_x) - p[index.AXIS], p[index.AXES]) * angles
        i0: int = first_node(down, taus)
        j0: int = first_node(along, phis)
        k0: int = first_node(out, nus)
        l0: int = min(int(around), angles - 1)
        t = around - l0
        # the angle before the first of the four is the last one of the turn: the table begins there
        start: int = int(p[index.FIRST_ELEMENT + element * index.ELEMENT_SIZE + index.FORCE_TABLE])
        i: int = 0
        while i < 4:
            j: int = 0
            while j < min(phis, 4):
                w = weight(down - i0 - 1.0, i)
                if phis > 1:
                    w = w * weight(along - j0 - 1.0, j)
                k: int = 0
                while k < 4:
                    at: int = start + 2 * ((((i0 + i) * phis + j0 + j) * nus + k0 + k) * (angles + 3) + l0)
                    w3 = w * weight(out - k0 - 1.0, k)
                    sum_x = 0.0
                    sum_y = 0.0
                    m: int = 0
                    while m < 4:
                        w4 = weight(t, m)
                        sum_x = sum_x + w4 * tables[at + 2 * m]
                        sum_y = sum_y + w4 * tables[at + 2 * m + 1]
                        m = m + 1
                    x = x + w3 * sum_x
                    y = y + w3 * sum_y
                    k = k + 1
                j = j + 1
            i = i + 1
    x = x - share * n_x
    y = y - share * n_y
    if speed < p[index.CREEP]:
        x = rest_x + (x - rest_x) * speed / p[index.CREEP]
        y = rest_y + (y - rest_y) * speed / p[index.CREEP]
    state[index.FOUND] = x
    state[index.FOUND + 1] = y
    return speed
