"""Cycle means of the contact forces, read from the tables R and g by cubic interpolation."""

from math import sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.contact_spring import power
from studies.export.reduced_motor.index import Array

SIXTH = 0.16666666666666666


@compiled
def cubic(t: float, a: float, b: float, c: float, d: float) -> float:
    """Return the cubic through a, b, c, d at -1, 0, 1, 2."""
    e = t * (t - 1.0)
    f = (t + 1.0) * (t - 2.0)
    return SIXTH * e * ((t + 1.0) * d - (t - 2.0) * a) + 0.5 * f * ((t - 1.0) * b - t * c)


@compiled
def bounded(x: float, low: float, high: float) -> float:
    """Return x limited to its bounds; NaN stays NaN."""
    if x < low:
        return low
    if x > high:
        return high
    return x


@compiled
def node(position: float, nodes: int) -> int:
    """Return the second of the four nodes about a position, which counts from 0 and is not negative."""
    k: int = int(position)
    if k < 1:
        k = 1
    if k > nodes - 3:
        k = nodes - 3
    return k


@compiled
def ratio(h: float, s: float) -> float:
    """Return tau of a mean approach and a normal amplitude; h + s is positive."""
    return sqrt(s) / (sqrt(s) + sqrt(h + s))


@compiled
def mean_load(p: Array, tables: Array, drive: int, h: float, s: float) -> float:
    """Return <P> in N, the sum over the contacts."""
    if h + s <= 0.0:
        return 0.0
    nodes: int = int(p[index.TAU_NODES])
    start: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.LOADS])
    at = ratio(h, s) * (nodes - 1)
    k: int = node(at, nodes)
    i: int = start + k
    share = cubic(at - k, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return p[index.STIFFNESS] * power(h + s, p[index.EXPONENT]) * max(share, 0.0)


@compiled
def traction_share(p: Array, tables: Array, drive: int, tau: float, side: int, size: float) -> float:
    """Return g in -1..1 for V > 0 (side 1) or V < 0 (side 0); `size` is sqrt(|nu|)."""
    if size >= 1.0:
        return -1.0 if side == 1 else 1.0
    rows: int = int(p[index.TAU_NODES])
    columns: int = int(p[index.NU_NODES])
    facing = p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FACING]
    start: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FORCES])
    if (side == 1) == (facing > 0.0):  # the second half of the table is that of V > 0
        start = start + rows * columns
    down = tau * (rows - 1)
    along = size * (columns - 1)
    j: int = node(down, rows)
    k: int = node(along, columns)
    t = along - k
    i: int = start + (j - 1) * columns + k
    a = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    b = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    c = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    i = i + columns
    d = cubic(t, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return facing * bounded(cubic(down - j, a, b, c, d), -1.0, 1.0)


@compiled
def friction_force(p: Array, tables: Array, drive: int, h: float, s: float, load: float, side: int, v: float) -> float:
    """Return Q in N at the velocity v towards +x (side 1) or -x (side 0); `load` is <P>."""
    if load <= 0.0:
        return 0.0
    limit = p[index.FRICTION] * load
    if s <= 0.0:
        return -limit if side == 1 else limit
    nu = v / (p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.SATURATION] * s)
    return limit * traction_share(p, tables, drive, ratio(h, s), side, sqrt(abs(nu)))


@compiled
def slip_force(p: Array, tables: Array, drive: int, h: float, s: float, load: float, v: float) -> float:
    """Return Q in N of a slipping slider; `load` is <P>."""
    side: int = 1 if v > 0.0 else 0
    return friction_force(p, tables, drive, h, s, load, side, v)


@compiled
def stick_limit(p: Array, tables: Array, drive: int, h: float, s: float, load: float, side: int) -> float:
    """Return the force in N at which slip begins towards +x (side 1) or -x (side 0) of the slider."""
    return friction_force(p, tables, drive, h, s, load, side, 0.0)


@compiled
def cached_share(p: Array, tables: Array, state: Array, drive: int, sign: float, nu: float) -> float:
    """Return g at |nu| = `nu` on a steady wave; the cubic over the cell of the table is cached in the state."""
    if nu >= 1.0:
        return -sign
    rows: int = int(p[index.TAU_NODES])
    columns: int = int(p[index.NU_NODES])
    along = sqrt(nu) * (columns - 1)
    k: int = node(along, columns)
    t = along - k
    cell = sign * k
    if state[index.CELL] != cell:
        state[index.CELL] = cell
        down = ratio(state[index.APPROACH], state[index.SURFACE]) * (rows - 1)
        j: int = node(down, rows)
        facing = p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FACING]
        i: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FORCES]) + (j - 1) * columns + k - 1
        if sign * facing > 0.0:
            i = i + rows * columns
        before = facing * row_blend(tables, i, columns, down - j)
        here = facing * row_blend(tables, i + 1, columns, down - j)
        after = facing * row_blend(tables, i + 2, columns, down - j)
        beyond = facing * row_blend(tables, i + 3, columns, down - j)
        # Newton's form of the cubic through the values at -1, 0, 1, 2
        state[index.CUBIC] = before
        state[index.CUBIC + 1] = here - before
        state[index.CUBIC + 2] = 0.5 * (after - 2.0 * here + before)
        state[index.CUBIC + 3] = SIXTH * (beyond - 3.0 * after + 3.0 * here - before)
    g = state[index.CUBIC + 2] + (t - 1.0) * state[index.CUBIC + 3]
    g = state[index.CUBIC] + (t + 1.0) * (state[index.CUBIC + 1] + t * g)
    return bounded(g, -1.0, 1.0)


@compiled
def row_blend(tables: Array, i: int, columns: int, t: float) -> float:
    """Return the cubic across four rows of a table, the first at `i`."""
    j: int = i + 2 * columns
    return cubic(t, tables[i], tables[i + columns], tables[j], tables[j + columns])
