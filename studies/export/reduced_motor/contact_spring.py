"""Force, tangential spring and approach of the contacts on a surface at rest.

The repulsion of all contacts is a power of the approach (Hertz, flat punch), or a table: its power 1/e at nodes that
are closer where it begins. Friction feels the repulsion alone. The tangential spring is that of Cattaneo and Mindlin,
or of Jaeger and Ciavarella for the force of the table.
"""

from math import sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.index import Array

SIXTH = 0.16666666666666666


@compiled
def cubic(t: float, a: float, b: float, c: float, d: float) -> float:
    """Return the cubic through a, b, c, d at -1, 0, 1, 2."""
    e = t * (t - 1.0)
    f = (t + 1.0) * (t - 2.0)
    return SIXTH * e * ((t + 1.0) * d - (t - 2.0) * a) + 0.5 * f * ((t - 1.0) * b - t * c)


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
def power(z: float, exponent: float) -> float:
    """Return z^(3/2) or z, for z >= 0."""
    if exponent > 1.25:
        return z * sqrt(z)
    return z


@compiled
def place(p: Array, z: float, nodes: int) -> float:
    """Return the position of an approach over START in m among nodes, 0 to nodes - 1."""
    scale = p[index.FORCE_SCALE]
    inner = min(max(z, 0.0), p[index.DEEPEST])
    u = (sqrt(1.0 + inner / scale) - 1.0) / (sqrt(1.0 + p[index.DEEPEST] / scale) - 1.0)
    return u * (nodes - 1)


@compiled
def contact_force(p: Array, tables: Array, z: float) -> float:
    """Return the repulsion in N of all contacts at an approach over START in m, positive, on a surface at rest."""
    nodes: int = int(p[index.FORCE_NODES])
    if nodes < 1:
        return p[index.STIFFNESS] * power(z, p[index.EXPONENT])
    at = place(p, z, nodes)
    k: int = node(at, nodes)
    i: int = int(p[index.FORCE_TABLE]) + k
    root = cubic(at - k, tables[i - 1], tables[i], tables[i + 1], tables[i + 2])
    return power(max(root * max(1.0, z / p[index.DEEPEST]), 0.0), p[index.EXPONENT])


@compiled
def table_approach(p: Array, tables: Array, load: float) -> float:
    """Return the approach over START in m at which the table's repulsion is a load in N (Illinois variant)."""
    exponent = 1.0 / p[index.EXPONENT]
    goal = load**exponent
    low = 0.0
    high = p[index.DEEPEST]
    above = contact_force(p, tables, high) ** exponent - goal
    if above <= 0.0:
        return high * goal / (goal + above)
    below = contact_force(p, tables, low) ** exponent - goal
    if below >= 0.0:
        return low
    last_side: int = 0
    z = high
    i: int = 0
    while i < 60 and high - low > 1e-13 * p[index.DEEPEST]:
        z = (low * above - high * below) / (above - below)
        f = contact_force(p, tables, z) ** exponent - goal
        if abs(f) < 1e-14 * goal:
            i = 60
        if f > 0.0:
            high = z
            above = f
            if last_side == 1:
                below = 0.5 * below
            last_side = 1
        else:
            low = z
            below = f
            if last_side == -1:
                above = 0.5 * above
            last_side = -1
        i = i + 1
    return z


@compiled
def rest_approach(p: Array, tables: Array, load: float) -> float:
    """Return the depth of the spring in m under a repulsion in N: the approach over START that carries it.

    It is that of a power for contacts whose spring is so (`index.SPRING`).
    """
    if p[index.SPRING] > 0.5:
        return table_approach(p, tables, max(load, 0.0))
    z = max(load, 0.0) / p[index.STIFFNESS]
    return z ** (2.0 / 3.0) if p[index.EXPONENT] > 1.25 else z


@compiled
def carrying_approach(p: Array, tables: Array, load: float) -> float:
    """Return the approach over START in m at which the repulsion on a surface at rest is a load in N."""
    return table_approach(p, tables, load) if p[index.FORCE_NODES] > 0.5 else rest_approach(p, tables, load)


@compiled
def power_share(u: float, exponent: float) -> float:
    """Return what `spring_share` does of a force that is a power."""
    share = 1.0 - power(max(1.0 - abs(u), 0.0), exponent)
    return share if u > 0.0 else -share


@compiled
def spring_share(p: Array, tables: Array, u: float, depth: float) -> float:
    """Return Q over its limit of contacts that stick, deformed by u times the deformation at which they slip."""
    if p[index.SPRING] > 0.5:
        left = contact_force(p, tables, depth * max(1.0 - abs(u), 0.0)) / contact_force(p, tables, depth)
        return 1.0 - left if u > 0.0 else left - 1.0
    return power_share(u, p[index.EXPONENT])


@compiled
def spring_force(p: Array, tables: Array, load: float, x: float) -> float:
    """Return Q in N of contacts that stick, deformed by x in m, under a repulsion in N."""
    if load <= 0.0:
        return 0.0
    depth = rest_approach(p, tables, load)
    return p[index.FRICTION] * load * spring_share(p, tables, x / (p[index.LIMIT_SLOPE] * depth), depth)


@compiled
def spring_deformation(p: Array, tables: Array, load: float, force: float) -> float:
    """Return x in m at which contacts that stick carry a force in N: the inverse of `spring_force`."""
    if load <= 0.0:
        return 0.0
    left = max(1.0 - abs(force) / (p[index.FRICTION] * load), 0.0)
    depth = rest_approach(p, tables, load)
    if p[index.SPRING] > 0.5:
        left = table_approach(p, tables, load * left) / depth
    elif p[index.EXPONENT] > 1.25:
        left = left ** (2.0 / 3.0)
    x = p[index.LIMIT_SLOPE] * depth * (1.0 - left)
    return x if force > 0.0 else -x
