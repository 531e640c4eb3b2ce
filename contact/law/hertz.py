r"""Hertz: the normal force of a sphere on a plane.

With approach z (closing distance, compression positive), radius R and effective modulus E,
1/E = (1 - nu_1^2)/E_1 + (1 - nu_2^2)/E_2 (Johnson, *Contact Mechanics*, 1985, section 4.2; Feenstra and
Breedveld, eq. 1):

    P = (4/3) E sqrt(R) z^(3/2)   for z > 0, else 0;   contact radius a = sqrt(R z).

P is once continuously differentiable at z = 0, no more: whoever integrates it must stop there.
"""

import numpy as np


def stiffness(radius, effective_modulus):
    """Return K = (4/3) E sqrt(R) of P = K z^1.5, in N/m^1.5.

    Parameters
    ----------
    radius : float
        Radius of the ball, m.
    effective_modulus : float
        E of the pair, Pa.
    """
    return 4.0 / 3.0 * effective_modulus * np.sqrt(radius)


def normal_force(approach, stiffness):
    """Return the normal force P = K z^1.5 in N, zero when separated (eq. 1).

    Parameters
    ----------
    approach : float or (...) array
        Closing distance z, m; negative when separated.
    stiffness : float
        K of `stiffness`, N/m^1.5.
    """
    z = np.maximum(approach, 0.0)
    return stiffness * z * np.sqrt(z)


def approach(normal_force, stiffness):
    """Return the approach z = (P/K)^(2/3) in m that carries the normal force P >= 0 in N."""
    return np.cbrt(normal_force / stiffness) ** 2


def contact_radius(approach, radius):
    """Return the radius of the contact circle a = sqrt(R z) in m, zero when separated."""
    return np.sqrt(radius * np.maximum(approach, 0.0))
