r"""The normal force of one contact: a sphere or a rigid flat punch on a half-space.

With approach z (closing distance, compression positive), radius R and effective modulus E,
1/E = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2, the force is P = K p(z) for z > 0, else 0:

    sphere   p = z^(3/2),  K = (4/3) E sqrt(R)   a = sqrt(R z)   Hertz; Johnson, *Contact Mechanics* (1985), section 4.2
    punch    p = z,        K = 2 E R             a = R           Boussinesq; Johnson, eq. 3.36

with a the contact radius. In both dP/dz = 2 a E. P of a sphere is once continuously differentiable at z = 0, that of a
punch has a kink: whoever integrates it must stop there.

Kernels and Python take the law as a `NormalLaw`, whose functions they call through those of this module; z is a number
or an array, measured from first touch. `SPHERE` and `PUNCH` share their functions, so that one kernel serves both.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from contact.codes import Shape
from contact.jit.compiled import formula
from contact.law.holding import rescaled

SHAPES = ("sphere", "punch")
STEP = 1e-4  # of the difference that gives p'', relative


class NormalLaw(NamedTuple):
    """The normal force of each contact over its stiffness, p(z); see the module's text."""

    shape: int  # one of `codes.Shape`: p begins as that of this shape does, as onset z^m
    smooth: int  # 1: p is the power of z throughout
    onset: float
    pull: float  # attraction of a closed contact over its stiffness; friction does not feel it
    force: Callable  # k p(z) of z >= 0
    slope: Callable
    energy: Callable
    approach: Callable
    scaled: Callable
    unit_load: Callable
    table: tuple | None = None  # `law.table.Table`
    hold: tuple | None = (
        None  # `law.holding.Hold` of adhesion that holds on beyond the touch: p is then that of its depth
    )


@formula
def load(z, normal):
    """Return p(z) = P/K, zero when separated."""
    return normal.force(1.0, 0.5 * (z + abs(z)), normal)


@formula
def slope(z, normal):
    """Return dp/dz, zero when separated."""
    return normal.slope(z, normal)


@formula
def energy(z, normal):
    """Return the integral of p from 0 to z."""
    return normal.energy(z, normal)


@formula
def approach(p, normal):
    """Return z >= 0 with p(z) = p."""
    return normal.approach(p, normal)


@formula
def scaled(normal, length):
    """Return the law p(length z)/p(length) of lengths in this unit."""
    return normal.scaled(normal, length)


@formula
def force(stiffness, z, normal):
    """Return P of z >= 0."""
    return normal.force(stiffness, z, normal)


@formula
def unit_load(normal, length):
    """Return p in SI units of the unit of length of a scaled law."""
    return normal.unit_load(normal, length)


@formula
def exponent(normal):
    """Return m of p ~ z^m at first touch, 3/2 for a sphere and 1 for a punch."""
    return 1.5 if normal.shape == Shape.SPHERE else 1.0


@formula
def hertz(z):
    """Return p of a sphere."""
    up = 0.5 * (z + abs(z))
    return up * np.sqrt(up)


@formula
def smooth_force(stiffness, z, normal):
    """Return P of z >= 0 of a sphere or punch."""
    return stiffness * z * np.sqrt(z) if normal.shape == Shape.SPHERE else stiffness * z


@formula
def smooth_slope(z, normal):
    """Return dp/dz of a sphere or punch."""
    return 1.5 * np.sqrt(0.5 * (z + abs(z))) if normal.shape == Shape.SPHERE else 1.0 * (z > 0.0)


@formula
def smooth_energy(z, normal):
    """Return the integral of p of a sphere or punch."""
    up = 0.5 * (z + abs(z))
    return 0.4 * up * up * np.sqrt(up) if normal.shape == Shape.SPHERE else 0.5 * up * up


@formula
def smooth_approach(p, normal):
    """Return z of a sphere or punch that carries p."""
    return p ** (2.0 / 3.0) if normal.shape == Shape.SPHERE else p


@formula
def smooth_scaled(normal, length):
    """Return the law of lengths in this unit: p of a sphere or punch is a power of z, the same in every unit."""
    return with_pull(normal, normal.pull / smooth_force(1.0, length, normal), rescaled(normal.hold, length))


@formula
def with_pull(normal, pull, hold):
    """Return the law with another attraction."""
    return NormalLaw(
        normal.shape, normal.smooth, normal.onset, pull, normal.force, normal.slope, normal.energy, normal.approach,
        normal.scaled, normal.unit_load, normal.table, hold,
    )  # fmt: skip


@formula
def plain(normal):
    """Return whether the force is that of a sphere or punch alone: convex, and one power of z."""
    return normal.smooth == 1 and normal.pull == 0.0 and normal.hold is None


@formula
def smooth_unit_load(normal, length):
    """Return p of a length in m of a sphere or punch."""
    return smooth_force(1.0, length, normal)


@formula
def edge_load(z, normal):
    """Return p of a small approach: the power of first touch."""
    return normal.onset * smooth_force(1.0, 0.5 * (z + abs(z)), normal)


@formula
def curvature(z, normal):
    """Return z^2 p''/2p."""
    m = exponent(normal)
    if normal.smooth:
        return 0.5 * m * (m - 1.0)
    step = STEP * z
    return z * z * (slope(z + step, normal) - slope(z - step, normal)) / (4.0 * step * load(z, normal))


_SMOOTH = smooth_force, smooth_slope, smooth_energy, smooth_approach, smooth_scaled, smooth_unit_load
SPHERE, PUNCH = LAWS = tuple(NormalLaw(int(shape), 1, 1.0, 0.0, *_SMOOTH) for shape in Shape)


@formula
def mean_pressure(z, normal):
    """Return P/(pi a^2) of a sphere or punch over its value at z = 1, a length of any unit."""
    up = 0.5 * (z + abs(z))
    return np.sqrt(up) if normal.shape == Shape.SPHERE else up


def stiffness(radius, effective_modulus, shape):
    """Return K in N/m^1.5 (sphere) or N/m (punch)."""
    return (
        4.0 / 3.0 * effective_modulus * np.sqrt(radius) if shape == Shape.SPHERE else 2.0 * effective_modulus * radius
    )


def contact_radius(z, radius, shape):
    """Return the radius a of the contact circle in m, zero when separated."""
    return np.sqrt(radius * np.maximum(z, 0.0)) if shape == Shape.SPHERE else radius * (np.asarray(z) > 0.0)
