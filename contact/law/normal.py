r"""The normal force of one contact: a sphere or a rigid flat punch on a half-space.

With approach z (closing distance, compression positive), radius R and effective modulus E,
1/E = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2, the force is P = K p(z) for z > 0, else 0:

    sphere   p = z^(3/2),  K = (4/3) E sqrt(R)   a = sqrt(R z)   Hertz; Johnson, *Contact Mechanics* (1985), section 4.2
    punch    p = z,        K = 2 E R             a = R           Boussinesq; Johnson, eq. 3.36

with a the contact radius. In both dP/dz = 2 a E. P of a sphere is once continuously differentiable at z = 0, that of a
punch has a kink: whoever integrates it must stop there. The functions take numbers or arrays of z; `shape` is a number.
"""

import numpy as np

from contact.codes import Shape
from contact.jit.compiled import formula

SHAPES = ("sphere", "punch")


@formula
def load(z, shape):
    """Return p(z) = P/K, zero when separated."""
    return force(1.0, 0.5 * (z + abs(z)), shape)


@formula
def force(stiffness, z, shape):
    """Return P of z >= 0."""
    return stiffness * z * np.sqrt(z) if shape == Shape.SPHERE else stiffness * z


@formula
def slope(z, shape):
    """Return dp/dz, zero when separated."""
    return 1.5 * np.sqrt(0.5 * (z + abs(z))) if shape == Shape.SPHERE else 1.0 * (z > 0.0)


@formula
def energy(z, shape):
    """Return the integral of p from 0 to z."""
    up = 0.5 * (z + abs(z))
    return 0.4 * up * up * np.sqrt(up) if shape == Shape.SPHERE else 0.5 * up * up


@formula
def mean_pressure(z, shape):
    """Return P/(pi a^2) over its value at z = 1, a length of any unit."""
    up = 0.5 * (z + abs(z))
    return np.sqrt(up) if shape == Shape.SPHERE else up


@formula
def approach(p, shape):
    """Return z >= 0 with p(z) = p."""
    return p ** (2.0 / 3.0) if shape == Shape.SPHERE else p


def stiffness(radius, effective_modulus, shape):
    """Return K in N/m^1.5 (sphere) or N/m (punch)."""
    return (
        4.0 / 3.0 * effective_modulus * np.sqrt(radius) if shape == Shape.SPHERE else 2.0 * effective_modulus * radius
    )


def contact_radius(z, radius, shape):
    """Return the radius a of the contact circle in m, zero when separated."""
    return np.sqrt(radius * np.maximum(z, 0.0)) if shape == Shape.SPHERE else radius * (np.asarray(z) > 0.0)
