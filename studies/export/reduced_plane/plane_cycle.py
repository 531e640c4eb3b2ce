"""Mean force of one contact over the common period of the waves, in fixed steps of the phase.

In a step the deformation e moves with the surface, e* = e + u_t(new) - u_t(old) - v dt, and is cut back to c z e*/|e*|
where it is longer (Moreau's catching-up algorithm, as in `contact.plane.fixed_steps`). In the step in which a contact
touches only the fraction after z = 0 counts. The method is of first order; from two lengths of the step the mean is
extrapolated. The derivatives of e and of the force in the velocity go with it.

A period begins at the least approach. A contact that is open there starts without a deformation; one that never opens
has been dragged to its limit against its motion, and repeats the period until its deformation does.

Arguments as in `plane_force_tables`; l_1 and l_2 are the levels of both waves.
"""

from math import cos, sin, sqrt

from contact.jit.compiled import compiled, native
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_index import Array
from studies.export.reduced_plane.plane_matrix import solve_matrix

FULL_TURN = 6.283185307179586
MAX_PASSES = 30  # of a period
MAX_CYCLES = 60.0  # of the fastest wave in these passes: one wave needs 3 to 24, most next to its threshold
MAX_TURNS = 60  # of Newton's method for the approaches
LEVELLED = 1e-12  # of the approach at rest
REPEATS = 1e-8  # change of the deformation over its limit in a period, below which a contact repeats


@compiled
def force_at(p: Array, z: float) -> float:
    """Return z to the exponent of the normal force; 0 of an open contact."""
    if z <= 0.0:
        return 0.0
    return z * sqrt(z) if p[index.EXPONENT] > 1.25 else z


@compiled
def slope_at(p: Array, z: float) -> float:
    """Return the derivative of `force_at`."""
    if z <= 0.0:
        return 0.0
    return 1.5 * sqrt(z) if p[index.EXPONENT] > 1.25 else 1.0


@compiled
def set_period(p: Array, state: Array) -> float:
    """Store the common period of the waves that are not 0 and the steps in a cycle; return its number of cycles."""
    state[index.CYCLES] = 1.0
    state[index.CYCLE_STEPS] = p[index.STEPS]
    state[index.RATIO] = 1.0
    state[index.RATIO + 1] = 1.0
    state[index.FASTEST] = p[index.OMEGA]
    if state[index.WAVE + 1] > 0.0:
        if state[index.WAVE] > 0.0:
            state[index.CYCLES] = p[index.COMMON_CYCLES]
            state[index.CYCLE_STEPS] = p[index.STEPS_OF_BOTH]
            state[index.FASTEST] = max(p[index.OMEGA], p[index.OMEGA + 1])
            state[index.RATIO] = p[index.OMEGA_RATIO]
            state[index.RATIO + 1] = p[index.OMEGA_RATIO + 1]
        else:
            state[index.FASTEST] = p[index.OMEGA + 1]
    return state[index.CYCLES]


@compiled
def normal_mean(p: Array, tables: Array, state: Array, element: int, height: float) -> float:
    """Fill NORMAL of an element at a mean approach; return its mean normal force over its stiffness."""
    at: int = int(p[index.FIRST_ELEMENT + element * index.ELEMENT_SIZE + index.REST_TABLE])
    steps: int = 2 * int(state[index.CYCLE_STEPS])
    step = FULL_TURN / steps
    count: int = int(steps * state[index.CYCLES])
    a = state[index.WAVE] * tables[at + index.ORBIT + 4]
    b = state[index.WAVE] * tables[at + index.ORBIT + 5]
    c = state[index.WAVE + 1] * tables[at + index.ORBIT + 10]
    d = state[index.WAVE + 1] * tables[at + index.ORBIT + 11]
    turn_x = cos(step * state[index.RATIO])
    turn_y = sin(step * state[index.RATIO])
    other_x = cos(step * state[index.RATIO + 1])
    other_y = sin(step * state[index.RATIO + 1])
    x = 1.0
    y = 0.0
    v = 1.0
    w = 0.0
    load = 0.0
    slope = 0.0
    least = height + a + c
    lowest: int = 0
    k: int = 0
    while k < count:
        z = height + a * x + b * y + c * v + d * w
        load = load + force_at(p, z)
        slope = slope + slope_at(p, z)
        if z < least:
            least = z
            lowest = k
        old = x
        x = x * turn_x - y * turn_y
        y = old * turn_y + y * turn_x
        old = v
        v = v * other_x - w * other_y
        w = old * other_y + w * other_x
        k = k + 1
    state[index.NORMAL] = load / count
    state[index.NORMAL + 1] = slope / count
    state[index.NORMAL + 2] = lowest * step
    return load / count


@compiled
def set_approaches(p: Array, tables: Array, state: Array, preload: float) -> float:
    """Store mean approaches at which the mean normal forces carry the preload; return the Newton steps made.

    One approach, or one and two tilts, as `contact.plane.heights`: from the approach at rest, which is too large,
    Newton's method falls monotonically.
    """
    limit = preload / p[index.STIFFNESS]
    rest = limit ** (2.0 / 3.0) if p[index.EXPONENT] > 1.25 else limit
    state[index.TRIAL] = rest
    state[index.TRIAL + 1] = 0.0
    state[index.TRIAL + 2] = 0.0
    turns: int = 0
    made: int = 0
    while turns < MAX_TURNS:
        state[index.RESIDUAL] = -limit
        state[index.RESIDUAL + 1] = -limit * p[index.LOAD_X] * p[index.TILTS]
        state[index.RESIDUAL + 2] = -limit * p[index.LOAD_X + 1] * p[index.TILTS]
        k: int = 0
        while k < 12:
            state[index.MATRIX + k] = 0.0
            k = k + 1
        if p[index.TILTS] < 0.5:
            state[index.MATRIX + 5] = 1.0
            state[index.MATRIX + 10] = 1.0
        e: int = 0
        while e < p[index.ELEMENTS]:
            at: int = int(p[index.FIRST_ELEMENT + e * index.ELEMENT_SIZE + index.REST_TABLE])
            own: int = index.STATE_SIZE + e * index.ELEMENT_STATE
            x = tables[at + index.ARM_X] * p[index.TILTS]
            y = tables[at + index.ARM_Y] * p[index.TILTS]
            z = state[index.TRIAL] + x * state[index.TRIAL + 1] + y * state[index.TRIAL + 2]
            part = tables[at + index.STIFFNESS_SHARE]
            load = part * normal_mean(p, tables, state, e, z)
            slope = part * state[index.NORMAL + 1]
            state[own + index.APPROACH] = z
            state[own + index.LOWEST] = state[index.NORMAL + 2]
            state[index.RESIDUAL] = state[index.RESIDUAL] + load
            state[index.RESIDUAL + 1] = state[index.RESIDUAL + 1] + load * x
            state[index.RESIDUAL + 2] = state[index.RESIDUAL + 2] + load * y
            state[index.MATRIX] = state[index.MATRIX] + slope
            state[index.MATRIX + 1] = state[index.MATRIX + 1] + slope * x
            state[index.MATRIX + 2] = state[index.MATRIX + 2] + slope * y
            state[index.MATRIX + 4] = state[index.MATRIX + 4] + slope * x
            state[index.MATRIX + 5] = state[index.MATRIX + 5] + slope * x * x
            state[index.MATRIX + 6] = state[index.MATRIX + 6] + slope * x * y
            state[index.MATRIX + 8] = state[index.MATRIX + 8] + slope * y
            state[index.MATRIX + 9] = state[index.MATRIX + 9] + slope * x * y
            state[index.MATRIX + 10] = state[index.MATRIX + 10] + slope * y * y
            e = e + 1
        solve_matrix(state)
        change = abs(state[index.MATRIX + 3]) + abs(state[index.MATRIX + 7]) + abs(state[index.MATRIX + 11])
        part = 1.0
        if p[index.TILTS] > 0.5 and change > 0.25 * rest:
            part = 0.25 * rest / change
        state[index.TRIAL] = state[index.TRIAL] + part * state[index.MATRIX + 3]
        state[index.TRIAL + 1] = state[index.TRIAL + 1] + part * state[index.MATRIX + 7]
        state[index.TRIAL + 2] = state[index.TRIAL + 2] + part * state[index.MATRIX + 11]
        turns = turns + 1
        made = made + 1
        if change < LEVELLED * rest:
            turns = MAX_TURNS
    return made


@compiled
def set_levels(p: Array, tables: Array, state: Array, first: float, second: float, preload: float) -> float:
    """Store the levels of both waves, and the approaches under them where they differ from the last ones; return 0."""
    if state[index.WAVE] == first and state[index.WAVE + 1] == second and state[index.RIDES] == preload:
        return 0.0
    state[index.WAVE] = first
    state[index.WAVE + 1] = second
    state[index.RIDES] = preload
    set_period(p, state)
    set_approaches(p, tables, state, preload)
    return 0.0


@compiled
def friction_means(
    p: Array, tables: Array, state: Array, element: int, vx: float, vy: float, steps: int, share: float
) -> float:  # fmt: skip
    """Add a share of the mean of Q/(mu K) and of its derivatives to FOUND and SLOPE; return the speed, not 0."""
    speed = sqrt(vx * vx + vy * vy)
    n_x = vx / speed
    n_y = vy / speed
    at: int = int(p[index.FIRST_ELEMENT + element * index.ELEMENT_SIZE + index.REST_TABLE])
    own: int = index.STATE_SIZE + element * index.ELEMENT_STATE
    height = state[own + index.APPROACH]
    begin = state[own + index.LOWEST]
    limit = tables[at + index.LIMIT_SLOPE]
    step = FULL_TURN / steps
    count: int = int(steps * state[index.CYCLES])
    time = step / state[index.FASTEST]
    l_1 = state[index.WAVE]
    l_2 = state[index.WAVE + 1]
    i: int = at + index.ORBIT
    ax = l_1 * tables[i]
    bx = l_1 * tables[i + 1]
    ay = l_1 * tables[i + 2]
    by = l_1 * tables[i + 3]
    az = l_1 * tables[i + 4]
    bz = l_1 * tables[i + 5]
    cx = l_2 * tables[i + 6]
    dx = l_2 * tables[i + 7]
    cy = l_2 * tables[i + 8]
    dy = l_2 * tables[i + 9]
    cz = l_2 * tables[i + 10]
    dz = l_2 * tables[i + 11]
    turn_x = cos(step * state[index.RATIO])
    turn_y = sin(step * state[index.RATIO])
    other_x = cos(step * state[index.RATIO + 1])
    other_y = sin(step * state[index.RATIO + 1])
    x = cos(begin * state[index.RATIO])
    y = sin(begin * state[index.RATIO])
    v = cos(begin * state[index.RATIO + 1])
    w = sin(begin * state[index.RATIO + 1])
    u_x = ax * x + bx * y + cx * v + dx * w
    u_y = ay * x + by * y + cy * v + dy * w
    z = height + az * x + bz * y + cz * v + dz * w
    closed: int = 1 if z > 0.0 else 0
    first = limit * max(z, 0.0)
    e_x = -first * n_x
    e_y = -first * n_y
    bend = first / speed
    d_xx = -bend * n_y * n_y
    d_xy = bend * n_x * n_y
    d_yx = d_xy
    d_yy = -bend * n_x * n_x
    q_x = 0.0
    q_y = 0.0
    s_xx = 0.0
    s_xy = 0.0
    s_yx = 0.0
    s_yy = 0.0
    passes: int = 0
    while passes < MAX_PASSES and passes * state[index.CYCLES] < MAX_CYCLES:
        from_x = e_x
        from_y = e_y
        q_x = 0.0
        q_y = 0.0
        s_xx = 0.0
        s_xy = 0.0
        s_yx = 0.0
        s_yy = 0.0
        k: int = 0
        while k < count:
            old = x
            x = x * turn_x - y * turn_y
            y = old * turn_y + y * turn_x
            old = v
            v = v * other_x - w * other_y
            w = old * other_y + w * other_x
            old_x = u_x
            old_y = u_y
            old_z = z
            u_x = ax * x + bx * y + cx * v + dx * w
            u_y = ay * x + by * y + cy * v + dy * w
            z = height + az * x + bz * y + cz * v + dz * w
            if z <= 0.0:
                e_x = 0.0
                e_y = 0.0
                d_xx = 0.0
                d_xy = 0.0
                d_yx = 0.0
                d_yy = 0.0
            else:
                part = 1.0
                if old_z < 0.0:
                    part = z / (z - old_z)
                e_x = e_x + part * (u_x - old_x - vx * time)
                e_y = e_y + part * (u_y - old_y - vy * time)
                d_xx = d_xx - part * time
                d_yy = d_yy - part * time
                size = sqrt(e_x * e_x + e_y * e_y)
                most = limit * z
                if size > most:
                    normal = force_at(p, z)
                    m_x = e_x / size
                    m_y = e_y / size
                    e_x = most * m_x
                    e_y = most * m_y
                    # of the direction alone
                    t_x = (d_yx * m_x - d_xx * m_y) * most / size
                    t_y = (d_yy * m_x - d_xy * m_y) * most / size
                    d_xx = -t_x * m_y
                    d_yx = t_x * m_x
                    d_xy = -t_y * m_y
                    d_yy = t_y * m_x
                    q_x = q_x + normal * m_x
                    q_y = q_y + normal * m_y
                    bend = normal / most
                    s_xx = s_xx + bend * d_xx
                    s_xy = s_xy + bend * d_xy
                    s_yx = s_yx + bend * d_yx
                    s_yy = s_yy + bend * d_yy
                elif size > 0.0:
                    m_x = e_x / size
                    m_y = e_y / size
                    normal = force_at(p, z) - force_at(p, z - size / limit)
                    q_x = q_x + normal * m_x
                    q_y = q_y + normal * m_y
                    bend = normal / size
                    along = slope_at(p, z - size / limit) / limit - bend
                    t_x = along * (m_x * d_xx + m_y * d_yx)
                    t_y = along * (m_x * d_xy + m_y * d_yy)
                    s_xx = s_xx + bend * d_xx + t_x * m_x
                    s_xy = s_xy + bend * d_xy + t_y * m_x
                    s_yx = s_yx + bend * d_yx + t_x * m_y
                    s_yy = s_yy + bend * d_yy + t_y * m_y
            k = k + 1
        passes = passes + 1
        if closed == 0 or abs(e_x - from_x) + abs(e_y - from_y) < REPEATS * first:
            passes = MAX_PASSES
    share = share / count
    state[index.FOUND] = state[index.FOUND] + share * q_x
    state[index.FOUND + 1] = state[index.FOUND + 1] + share * q_y
    state[index.SLOPE] = state[index.SLOPE] + share * s_xx
    state[index.SLOPE + 1] = state[index.SLOPE + 1] + share * s_xy
    state[index.SLOPE + 2] = state[index.SLOPE + 2] + share * s_yx
    state[index.SLOPE + 3] = state[index.SLOPE + 3] + share * s_yy
    return speed


@compiled
def sliding_force(
    p: Array, tables: Array, state: Array, element: int, vx: float, vy: float, preload: float
) -> float:  # fmt: skip
    """Fill g of an element and its derivatives at a velocity that is not 0; return its speed, m/s."""
    at: int = int(p[index.FIRST_ELEMENT + element * index.ELEMENT_SIZE + index.REST_TABLE])
    share = tables[at + index.STIFFNESS_SHARE] * p[index.STIFFNESS] / preload
    steps: int = int(state[index.CYCLE_STEPS])
    k: int = 0
    while k < 2:
        state[index.FOUND + k] = 0.0
        k = k + 1
    k = 0
    while k < 4:
        state[index.SLOPE + k] = 0.0
        k = k + 1
    # the error of first order in the step is removed
    friction_means(p, tables, state, element, vx, vy, steps, -share)
    return friction_means(p, tables, state, element, vx, vy, 2 * steps, 2.0 * share)


@compiled
def contact_force(
    p: Array, tables: Array, state: Array, element: int, vx: float, vy: float, preload: float
) -> float:  # fmt: skip
    """Fill g of an element and its derivatives at a velocity; return its speed, m/s.

    Below the creep g runs linearly through the middle of its values at rest.
    """
    speed = sqrt(vx * vx + vy * vy)
    creep = p[index.CREEP]
    if speed >= creep:
        return sliding_force(p, tables, state, element, vx, vy, preload)
    x = 0.0
    y = 0.0
    k: int = 0
    while k < 4:
        along = creep if k < 2 else -creep
        turned: int = 1 if k == 1 or k == 3 else 0
        sliding_force(p, tables, state, element, along * (1 - turned), along * turned, preload)
        x = x + 0.25 * state[index.FOUND]
        y = y + 0.25 * state[index.FOUND + 1]
        k = k + 1
    n_x = 1.0
    n_y = 0.0
    if speed > 1e-9 * creep:
        n_x = vx / speed
        n_y = vy / speed
    sliding_force(p, tables, state, element, creep * n_x, creep * n_y, preload)
    far_x = (state[index.FOUND] - x) / creep
    far_y = (state[index.FOUND + 1] - y) / creep
    state[index.FOUND] = x + far_x * speed
    state[index.FOUND + 1] = y + far_y * speed
    # along the motion, and across it that of the direction
    across_x = state[index.SLOPE + 1] * n_x - state[index.SLOPE] * n_y
    across_y = state[index.SLOPE + 3] * n_x - state[index.SLOPE + 2] * n_y
    state[index.SLOPE] = far_x * n_x - across_x * n_y
    state[index.SLOPE + 1] = far_x * n_y + across_x * n_x
    state[index.SLOPE + 2] = far_y * n_x - across_y * n_y
    state[index.SLOPE + 3] = far_y * n_y + across_y * n_x
    return speed


@native("f1 f1 f1 i f f f f f")
def force_on_waves(
    p: Array, tables: Array, state: Array, element: int, first: float, second: float, vx: float, vy: float,
    preload: float,
) -> int:  # fmt: skip
    """Fill g of an element and its derivatives on waves of two levels at a velocity; return 0."""
    set_levels(p, tables, state, first, second, preload)
    contact_force(p, tables, state, element, vx, vy, preload)
    return 0
