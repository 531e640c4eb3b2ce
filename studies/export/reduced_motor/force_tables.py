"""Cycle means of the contact forces, read from the tables R and g by cubic interpolation."""

from math import atan2, sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.contact_spring import SIXTH, contact_force, cubic, node, place, power
from studies.export.reduced_motor.index import Array

EDGE = 0.41421356237309503  # tau from which on contacts open in each cycle, sqrt(2) - 1: h - s = START
PI = 3.141592653589793


@compiled
def bounded(x: float, low: float, high: float) -> float:
    """Return x limited to its bounds; NaN stays NaN."""
    if x < low:
        return low
    if x > high:
        return high
    return x


@compiled
def ratio(h: float, s: float) -> float:
    """Return tau of a mean approach and a normal amplitude; h + s is positive, both over START."""
    return sqrt(s) / (sqrt(s) + sqrt(h + s))


@compiled
def row_place(p: Array, tau: float) -> float:
    """Return the position of tau among the rows of a table with depths, which are closer on both sides of `EDGE`."""
    split = p[index.SPLIT]
    if tau <= EDGE:
        return (1.0 - sqrt(max(1.0 - tau / EDGE, 0.0))) * (split - 1.0)
    return split + sqrt((tau - EDGE) / (1.0 - EDGE)) * (p[index.TAU_NODES] - split - 1.0)


@compiled
def row_node(p: Array, at: float) -> int:
    """Return the second of four rows about a position of `row_place`, all on one side of `EDGE`."""
    split: int = int(p[index.SPLIT])
    rows: int = int(p[index.TAU_NODES])
    k: int = 0
    if at < split - 0.5:
        k = node(at, split)
    else:
        k = split + node(at - split, rows - split)
    return k


@compiled
def depth_blend(tables: Array, i: int, plane: int, columns: int, down: float, deep: float) -> float:
    """Return the cubic across four depths and four rows, the first at `i`; places among them from the second on."""
    j: int = i + 2 * plane
    a = row_blend(tables, i, columns, down)
    b = row_blend(tables, i + plane, columns, down)
    c = row_blend(tables, j, columns, down)
    d = row_blend(tables, j + plane, columns, down)
    return cubic(deep, a, b, c, d)


@compiled
def share_at(p: Array, tables: Array, start: int, z: float, tau: float) -> float:
    """Return the entry of a table over the crest's approach over START, z in m, and tau, which begins at `start`."""
    rows: int = int(p[index.TAU_NODES])
    deep = place(p, z, int(p[index.DEPTHS]))
    down = row_place(p, tau)
    m: int = node(deep, int(p[index.DEPTHS]))
    j: int = row_node(p, down)
    return depth_blend(tables, start + (m - 1) * rows + j - 1, rows, 1, down - j, deep - m)


@compiled
def open_throughout(p: Array, h: float, s: float) -> int:
    """Return 1 where no contact touches in the cycle, or where those that open in it do not close again."""
    z = h + s - p[index.START]
    if z <= 0.0:
        return 1
    return 1 if h - s < p[index.START] and h + s < p[index.MAKES] else 0


@compiled
def mean_load(p: Array, tables: Array, drive: int, h: float, s: float) -> float:
    """Return the mean repulsion in N, the sum over the contacts; without adhesion that is <P>."""
    if open_throughout(p, h, s) == 1:
        return 0.0
    nodes: int = int(p[index.TAU_NODES])
    start: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.LOADS])
    if p[index.DEPTHS] > 0.5:
        z = h + s - p[index.START]
        return contact_force(p, tables, z) * max(share_at(p, tables, start, z, ratio(z - s, s)), 0.0)
    at = ratio(h, s) * (nodes - 1)
    k: int = node(at, nodes)
    i: int = start + k
    share = cubic(at - k, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return p[index.STIFFNESS] * power(h + s, p[index.EXPONENT]) * max(share, 0.0)


@compiled
def mean_pull(p: Array, tables: Array, drive: int, h: float, s: float) -> float:
    """Return the mean attraction in N, the sum over the contacts."""
    own: int = index.FIRST_DRIVE + drive * index.DRIVE_SIZE
    if open_throughout(p, h, s) == 1:
        return 0.0
    if p[own + index.PULLS] >= 0.0:
        z = h + s - p[index.START]
        return contact_force(p, tables, z) * share_at(p, tables, int(p[own + index.PULLS]), z, ratio(z - s, s))
    total = 0.0
    if p[index.PULL] > 0.0:  # closed while h + s cos(phase) > 0
        i: int = int(p[own + index.SIZES])
        last: int = i + int(p[index.CONTACTS])
        while i < last:
            size = s * tables[i]
            if h >= size:
                total = total + p[index.PULL]
            elif h > -size:
                total = total + p[index.PULL] * atan2(sqrt(size * size - h * h), -h) / PI
            i = i + 1
    return total


@compiled
def attracts(p: Array) -> int:
    """Return 1 where contacts attract, of constant attraction or of a table."""
    return 1 if p[index.PULL] > 0.0 or p[index.FIRST_DRIVE + index.PULLS] >= 0.0 else 0


@compiled
def normal_force(p: Array, tables: Array, drive: int, h: float, s: float) -> float:
    """Return <P> in N: the mean repulsion less the mean attraction."""
    if attracts(p) == 0:
        return mean_load(p, tables, drive, h, s)
    return mean_load(p, tables, drive, h, s) - mean_pull(p, tables, drive, h, s)


@compiled
def steady_load(p: Array, tables: Array, drive: int, h: float, s: float, preload: float) -> float:
    """Return the mean repulsion in N at the approach h at which <P> is the preload."""
    return preload if attracts(p) == 0 else mean_load(p, tables, drive, h, s)


@compiled
def share_of_depths(p: Array, tables: Array, drive: int, z: float, tau: float, side: int, size: float) -> float:
    """Return g of a table with depths at the crest's approach over START, z in m; see `traction_share`.

    Beyond the last column it tends to -1 or 1 as 1/nu.
    """
    rows: int = int(p[index.TAU_NODES])
    columns: int = int(p[index.NU_NODES])
    depths: int = int(p[index.DEPTHS])
    facing = p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FACING]
    i: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FORCES])
    if (side == 1) == (facing > 0.0):
        i = i + depths * rows * columns
    deep = place(p, z, depths)
    down = row_place(p, tau)
    along = min(size / p[index.FASTEST], 1.0) * (columns - 1)
    m: int = node(deep, depths)
    j: int = row_node(p, down)
    k: int = node(along, columns)
    plane: int = rows * columns
    i = i + (m - 1) * plane + (j - 1) * columns + k - 1
    a = depth_blend(tables, i, plane, columns, down - j, deep - m)
    b = depth_blend(tables, i + 1, plane, columns, down - j, deep - m)
    c = depth_blend(tables, i + 2, plane, columns, down - j, deep - m)
    d = depth_blend(tables, i + 3, plane, columns, down - j, deep - m)
    g = facing * cubic(along - k, a, b, c, d)
    if size > p[index.FASTEST]:
        end = -1.0 if side == 1 else 1.0
        g = end + (g - end) * (p[index.FASTEST] / size) ** 2.0
    return bounded(g, -1.0, 1.0)


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
    """Return Q in N at the velocity v towards +x (side 1) or -x (side 0); `load` is the mean repulsion."""
    if load <= 0.0:
        return 0.0
    limit = p[index.FRICTION] * load
    if s <= 0.0:
        return -limit if side == 1 else limit
    nu = v / (p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.SATURATION] * s)
    if p[index.DEPTHS] > 0.5:
        z = h + s - p[index.START]
        return limit * share_of_depths(p, tables, drive, z, ratio(z - s, s), side, sqrt(abs(nu)))
    return limit * traction_share(p, tables, drive, ratio(h, s), side, sqrt(abs(nu)))


@compiled
def slip_force(p: Array, tables: Array, drive: int, h: float, s: float, load: float, v: float) -> float:
    """Return Q in N of a slipping slider; `load` is the mean repulsion."""
    side: int = 1 if v > 0.0 else 0
    return friction_force(p, tables, drive, h, s, load, side, v)


@compiled
def stick_limit(p: Array, tables: Array, drive: int, h: float, s: float, load: float, side: int) -> float:
    """Return the force in N at which slip begins towards +x (side 1) or -x (side 0) of the slider."""
    return friction_force(p, tables, drive, h, s, load, side, 0.0)


@compiled
def cached_share(p: Array, tables: Array, state: Array, drive: int, sign: float, nu: float) -> float:
    """Return g at |nu| = `nu` on a steady wave; the cubic over the cell of the table is cached in the state."""
    h = state[index.APPROACH] - p[index.START]
    s = state[index.SURFACE]
    if p[index.DEPTHS] > 0.5:
        if nu >= p[index.FASTEST] ** 2.0:
            return share_of_depths(p, tables, drive, h + s, ratio(h, s), 1 if sign > 0.0 else 0, sqrt(nu))
    elif nu >= 1.0:
        return -sign
    rows: int = int(p[index.TAU_NODES])
    columns: int = int(p[index.NU_NODES])
    along = sqrt(nu) * (columns - 1)
    if p[index.DEPTHS] > 0.5:
        along = along / p[index.FASTEST]
    k: int = node(along, columns)
    t = along - k
    cell = sign * k
    if state[index.CELL] != cell:
        state[index.CELL] = cell
        facing = p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FACING]
        i: int = int(p[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.FORCES]) + k - 1
        if sign * facing > 0.0:
            i = i + int(max(p[index.DEPTHS], 1.0)) * rows * columns
        before = facing * column_at(p, tables, i, h, s)
        here = facing * column_at(p, tables, i + 1, h, s)
        after = facing * column_at(p, tables, i + 2, h, s)
        beyond = facing * column_at(p, tables, i + 3, h, s)
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


@compiled
def column_at(p: Array, tables: Array, i: int, h: float, s: float) -> float:
    """Return a column of g, whose first entry is at `i`, at a mean approach over START and a normal amplitude."""
    rows: int = int(p[index.TAU_NODES])
    columns: int = int(p[index.NU_NODES])
    if p[index.DEPTHS] > 0.5:
        down = row_place(p, ratio(h, s))
        deep = place(p, h + s, int(p[index.DEPTHS]))
        j: int = row_node(p, down)
        m: int = node(deep, int(p[index.DEPTHS]))
        first: int = i + (m - 1) * rows * columns + (j - 1) * columns
        return depth_blend(tables, first, rows * columns, columns, down - j, deep - m)
    at = ratio(h, s) * (rows - 1)
    k: int = node(at, rows)
    return row_blend(tables, i + (k - 1) * columns, columns, at - k)
