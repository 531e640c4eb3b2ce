r"""The elastic law: the tangential force as a function of approach and deformation; stick, slip and separation.

Ciavarella, J. Appl. Mech. 65 (1998) 998, and Jaeger, Arch. Appl. Mech. 68 (1998) 245: the tangential force is mu times
the difference between the normal force and that at a smaller approach, the approach of the part that sticks,

    Q = mu (P(z) - P(z_s)) sign x,   z_s = z - |x|/c,   c = mu E/(4 G),   1/G = (2 - nu_1)/G_1 + (2 - nu_2)/G_2.

For a sphere this is Cattaneo's and Mindlin's Q = mu P (1 - (1 - |x|/x_max)^(3/2)) (Johnson, *Contact Mechanics*,
section 7.2; Feenstra and Breedveld, eq. 2) with x_max = 3 mu P/(16 a G) = c z exactly. For a punch it is Q = 8 R G x
up to mu P at the same x_max = c z: nothing slips before. The initial stiffness is 8 a G for both.

Stick and slip together are the *stop
operator*: x follows the difference of surface and slider velocity, and is kept within [-c z, c z]. Q is smooth between
x = 0 (for a sphere the curvature jumps there), |x| = x_max and z = 0.

Guards are positive inside a regime; their first root ends it. With s the sign of deformation or slip,
v_f = s (v_t - v_s) - c z' the slip speed (Feenstra and Breedveld, eq. 3, with the sign that the paper leaves out):

    separated   -z > 0                                 -> contact
    stick       z > 0, c z - s x > 0, s x > 0          -> release, slip (or creep), reversal
    slip        z > 0, v_f - DV > 0                    -> release, stick (creep when DV > 0)
    creep       z > 0, DV - v_f > 0, s x - c z > 0     -> release, slip, stick

Creep exists only with the seed's band DV > 0: the deformation has passed the slip limit but the slip speed is below
DV, so the contact still counts as stuck and carries mu P. With DV = 0 stick and slip form the stop operator.
Every transition lands on its far side: the state is set to the new regime's side of the guard, so that none chatters.
"""

import numpy as np

from contact.codes import Event, Regime
from contact.jit.compiled import formula
from contact.kinematics import slip_speed
from contact.law.normal import energy, load, slope

# how far past its root a guard is accepted, in units of the scaled problem: above rounding, below everything else
FAR_SIDE = 1e-15


def limit_slope(friction_coefficient, effective_modulus, tangential_modulus):
    """Return c = mu E/4G, dimensionless: the slip limit x_max over the approach z."""
    return friction_coefficient * effective_modulus / (4.0 * tangential_modulus)


@formula
def friction_load(z, stick, shape):
    """Return |Q|/(mu K) with z_s = `stick` = z - |x|/c, below 0 in full slip; past x = 0 the branch is continued."""
    return load(z, shape) - load(stick, shape)


@formula
def friction_energy(z, stick, shape):
    """Return W/(mu K c), W the integral of Q dx from 0 to |x| = c (z - z_s) at constant z."""
    return (z - stick) * load(z, shape) - energy(z, shape) + energy(stick, shape)


@formula
def back_load(z, stick, shape):
    """Return dW/dz/(mu K c) at constant x, the reciprocal normal force; zero for a punch."""
    return (z - stick) * slope(z, shape) - load(z, shape) + load(stick, shape)


@formula
def tangential_force(x, z, friction, c, shape):
    """Return Q for any x, held at the friction limit beyond c z; `friction` is mu K. Numbers or arrays."""
    if c == 0.0:
        return 0.0 * x
    return np.sign(x) * friction * friction_load(z, z - abs(x) / c, shape)


@formula
def guard(problem, regime, which, sign, point):
    """Return guard number `which` (0, 1, 2) of a regime; 1.0 where the regime has no such guard."""
    z, x, z_rate, x_rate = point
    c, band = problem.limit_slope, problem.stick_band
    if which == 0:
        return FAR_SIDE - z if regime == Regime.SEPARATED else FAR_SIDE + z
    if regime == Regime.STICK:
        return FAR_SIDE + c * z - sign * x if which == 1 else FAR_SIDE + sign * x
    if regime == Regime.SLIP and which == 1:
        return FAR_SIDE + slip_speed(sign, z_rate, x_rate, c) - band
    if regime == Regime.CREEP:
        return FAR_SIDE + (band - slip_speed(sign, z_rate, x_rate, c) if which == 1 else sign * x - c * z)
    return 1.0


@formula
def follow(problem, regime, which, sign, point):
    """Return (regime, sign, x, kind of event) on the far side of guard `which`."""
    z, _, z_rate, x_rate = point
    c, band = problem.limit_slope, problem.stick_band
    speed = slip_speed(sign, z_rate, x_rate, c)
    if which == 0:
        if regime != Regime.SEPARATED:
            return Regime.SEPARATED, sign, 0.0, Event.RELEASE
        sign = -1.0 if x_rate < 0.0 else 1.0
        speed = slip_speed(sign, z_rate, x_rate, c)
        if speed > band:
            return Regime.SLIP, sign, 0.0, Event.CONTACT
        return (Regime.CREEP if speed > 0.0 else Regime.STICK), sign, 0.0, Event.CONTACT
    if regime == Regime.STICK:
        if which == 2:
            return Regime.STICK, -sign, 0.0, Event.REVERSAL
        if speed > band:
            return Regime.SLIP, sign, sign * c * z, Event.STICK_TO_SLIP
        return (Regime.CREEP if band > 0.0 else Regime.STICK), sign, sign * c * z, Event.STICK_TO_SLIP
    if regime == Regime.SLIP:
        return (Regime.CREEP if band > 0.0 else Regime.STICK), sign, sign * c * z, Event.SLIP_TO_STICK
    if which == 1:
        return Regime.SLIP, sign, sign * c * z, Event.STICK_TO_SLIP
    return Regime.STICK, sign, sign * c * z, Event.SLIP_TO_STICK


@formula
def opening(problem, point):
    """Return (regime, sign, x) of a contact that is found with approach z and deformation x."""
    z, x, z_rate, x_rate = point
    c, band = problem.limit_slope, problem.stick_band
    if z < 0.0 or (z == 0.0 and z_rate <= 0.0):
        return Regime.SEPARATED, 1.0, 0.0
    sign = 1.0
    if x < 0.0 or (x == 0.0 and x_rate < 0.0):
        sign = -1.0
    if sign * x >= c * z * (1.0 - 1e-13):
        x = sign * c * z
        speed = slip_speed(sign, z_rate, x_rate, c)
        if speed > band:
            return Regime.SLIP, sign, x
        if speed > 0.0 and band > 0.0:
            return Regime.CREEP, sign, x
    return Regime.STICK, sign, x


@formula
def spring(problem, regime, sign, point):
    """Return Q, the reciprocal force dW/dz at constant x, and the energy W of a contact's tangential spring.

    In stick the smooth branch of sign s is continued past x = 0, and held at mu P past the limit. All three are those
    of one friction coefficient: one that depends on the point is written here, and energies and ledger follow.
    """
    z, x, _, _ = point
    friction, c, shape = problem.friction * problem.stiffness, problem.limit_slope, problem.shape
    if regime == Regime.SEPARATED or z <= 0.0 or c <= 0.0:
        return 0.0, 0.0, 0.0
    stick = max(z - sign * x / c, 0.0) if regime == Regime.STICK else 0.0
    force = sign * friction * friction_load(z, stick, shape)
    return force, friction * c * back_load(z, stick, shape), friction * c * friction_energy(z, stick, shape)
