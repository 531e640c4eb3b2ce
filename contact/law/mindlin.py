r"""The tangential spring of the contact, as the seed paper relaxes Cattaneo and Mindlin: elastic, Q = Q(P, x).

With tangential deformation x, normal force P and 1/G = (2 - nu_1)/G_1 + (2 - nu_2)/G_2 (Feenstra and Breedveld,
eq. 2; Johnson, section 7.2):

    Q = mu P (1 - (1 - |x|/x_max)^(3/2)) sign x,   x_max = 3 mu P/(16 a G) = (mu E/4G) z.

The second form of x_max is exact with Hertz's P and a: the slip limit is proportional to the approach. Stick and
slip together are the *stop operator*: x follows the difference of surface and slider velocity, and is kept within
[-x_max, x_max]. Q is smooth between x = 0 (curvature jumps there: the law has |x| x in it), |x| = x_max and z = 0.
"""

import numpy as np


def limit_slope(friction_coefficient, effective_modulus, tangential_modulus):
    """Return c = mu E/4G, dimensionless: the slip limit x_max over the approach z."""
    return friction_coefficient * effective_modulus / (4.0 * tangential_modulus)


def slip_limit(approach, limit_slope):
    """Return x_max = c z in m, zero when separated."""
    return limit_slope * np.maximum(approach, 0.0)


def tangential_force(deformation, slip_limit, friction_limit):
    """Return the tangential force Q in N (eq. 2); beyond the slip limit it is the friction limit.

    Parameters
    ----------
    deformation : float or (...) array
        x, m.
    slip_limit : float or (...) array
        x_max, m; where it is zero Q is zero.
    friction_limit : float or (...) array
        mu P, N.
    """
    x, x_max = np.asarray(deformation, float), np.asarray(slip_limit, float)
    ratio = np.minimum(np.abs(x) / np.where(x_max > 0.0, x_max, 1.0), 1.0)
    return np.where(x_max > 0.0, np.sign(x) * friction_limit * (1.0 - (1.0 - ratio) ** 1.5), 0.0)


def reciprocal_force(deformation, slip_limit, friction_limit, limit_slope):
    """Return the normal force dW/dz in N with which the spring of `stored_energy` W(z, x) acts back on the approach.

    With r = abs(x)/x_max, w(r) = r - 0.4 (1 - (1 - r)^2.5), W = mu P c z w(r) and P proportional to z^1.5:
    dW/dz at constant x is c mu P (2.5 w - r w'), never negative, c mu P/2 at the slip limit. Arguments as for
    `tangential_force` with abs(x) <= x_max, and c of `limit_slope`.
    """
    x_max = np.asarray(slip_limit, float)
    ratio = np.minimum(np.abs(deformation) / np.where(x_max > 0.0, x_max, 1.0), 1.0)
    w, slope = ratio - 0.4 * (1.0 - (1.0 - ratio) ** 2.5), 1.0 - (1.0 - ratio) ** 1.5
    return limit_slope * friction_limit * (2.5 * w - ratio * slope)


def initial_stiffness(approach, radius, tangential_modulus):
    """Return dQ/dx at x = 0, 8 a G, in N/m (Mindlin 1949; Johnson, eq. 7.43)."""
    return 8.0 * np.sqrt(radius * np.maximum(approach, 0.0)) * tangential_modulus


def stored_energy(deformation, slip_limit, friction_limit):
    """Return the energy of the spring at constant P, the integral of Q dx from 0 to x, in J.

    Arguments as for `tangential_force`, with abs(x) <= x_max.
    """
    x_max = np.asarray(slip_limit, float)
    ratio = np.minimum(np.abs(deformation) / np.where(x_max > 0.0, x_max, 1.0), 1.0)
    return friction_limit * x_max * (ratio - 0.4 * (1.0 - (1.0 - ratio) ** 2.5))
