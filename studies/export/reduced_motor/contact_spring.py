"""Tangential spring and approach of the contacts on a surface at rest (Hertz; Cattaneo and Mindlin)."""

from math import sqrt

from contact.jit.compiled import compiled
from studies.export.reduced_motor import index
from studies.export.reduced_motor.index import Array


@compiled
def power(z: float, exponent: float) -> float:
    """Return z^(3/2) or z, for z >= 0."""
    if exponent > 1.25:
        return z * sqrt(z)
    return z


@compiled
def spring_share(u: float, exponent: float) -> float:
    """Return Q over its limit of contacts that stick, deformed by u times the deformation at which they slip."""
    share = 1.0 - power(max(1.0 - abs(u), 0.0), exponent)
    return share if u > 0.0 else -share


@compiled
def rest_approach(p: Array, load: float) -> float:
    """Return the approach in m that carries a load in N on a surface at rest."""
    z = max(load, 0.0) / p[index.STIFFNESS]
    return z ** (2.0 / 3.0) if p[index.EXPONENT] > 1.25 else z


@compiled
def spring_force(p: Array, load: float, x: float) -> float:
    """Return Q in N of contacts that stick, deformed by x in m, under a normal force in N."""
    if load <= 0.0:
        return 0.0
    return (
        p[index.FRICTION] * load * spring_share(x / (p[index.LIMIT_SLOPE] * rest_approach(p, load)), p[index.EXPONENT])
    )


@compiled
def spring_deformation(p: Array, load: float, force: float) -> float:
    """Return x in m at which contacts that stick carry a force in N: the inverse of `spring_force`."""
    if load <= 0.0:
        return 0.0
    left = max(1.0 - abs(force) / (p[index.FRICTION] * load), 0.0)
    if p[index.EXPONENT] > 1.25:
        left = left ** (2.0 / 3.0)
    x = p[index.LIMIT_SLOPE] * rest_approach(p, load) * (1.0 - left)
    return x if force > 0.0 else -x
