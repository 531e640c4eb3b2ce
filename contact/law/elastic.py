r"""The elastic law: the tangential force as a function of approach and deformation; stick, slip and separation.

Ciavarella, J. Appl. Mech. 65 (1998) 998, and Jaeger, Arch. Appl. Mech. 68 (1998) 245: the tangential force is mu times
the difference between the normal force and that at a smaller approach, the approach of the part that sticks,

    Q = mu (P(z) - P(z_s)) sign x,   z_s = z - |x|/c,   c = mu E/(4 G),   1/G = (2 - nu_1)/G_1 + (2 - nu_2)/G_2.

For a sphere this is Cattaneo's and Mindlin's Q = mu P (1 - (1 - |x|/x_max)^(3/2)) (Johnson, *Contact Mechanics*,
section 7.2; Feenstra and Breedveld, eq. 2) with x_max = 3 mu P/(16 a G) = c z exactly. For a punch it is Q = 8 R G x
up to mu P at the same x_max = c z: nothing slips before. The initial stiffness is 8 a G for both.

Stick and slip together are the *stop operator*: the rate of x is surface velocity less slider velocity, x' = v_t - v,
and x is kept within [-c z, c z]. Between x = 0, |x| = x_max and z = 0 the force Q is smooth; at x = 0 the curvature of
a sphere's Q jumps.

A *guard* is a function that is positive inside a regime; its first root ends the regime. With s the sign of deformation
or slip and v_f = s (v_t - v) - c z' the slip speed (Feenstra and Breedveld, eq. 3, with the sign that the paper leaves
out), the guards, in their order, and the regimes that follow are

    separated   -z > 0                                 -> contact
    stick       z > 0, c z - s x > 0, s x > 0          -> release, slip (or creep), reversal
    slip        z > 0, v_f - DV > 0                    -> release, stick (creep when DV > 0)
    creep       z > 0, DV - v_f > 0, s x - c z > 0     -> release, slip, stick

Creep exists only with `Slider.stick_band` DV > 0: the deformation has passed the slip limit but the slip speed is below
DV, so the contact still counts as stuck and carries mu P. At a transition the state is set to the new regime's side of
the guard, so that rounding does not repeat the event at once.
"""

import numpy as np

from contact.body import slip_speed
from contact.codes import Event, Guard, Regime
from contact.jit.compiled import formula
from contact.law.holding import closes_as_point
from contact.law.normal import approach, energy, load, slope
from contact.law.protocol import Law, limit_bend, slip_limit, slip_rate

# Added to every guard, scaled: a guard counts as passed when it is below minus this, so that one which starts at zero
# up to rounding (eps 2e-16) does not end its regime at once
FAR_SIDE = 1e-15


def limit_slope(friction_coefficient, effective_modulus, tangential_modulus):
    """Return c = mu E/4G, dimensionless: the slip limit x_max over the approach z."""
    return friction_coefficient * effective_modulus / (4.0 * tangential_modulus)


@formula
def spring_force(z, x, friction, c, normal):
    """Return Q of 0 <= x <= c z; `friction` is mu K, with c that of this approach."""
    return friction * (load(z, normal) - load(z - x / c, normal))


@formula
def spring_deformation(z, force, friction, c, normal):
    """Return x at which the spring carries a force, at most c z: the inverse of `spring_force`."""
    return c * (z - approach(max(load(z, normal) - force / friction, 0.0), normal))


@formula
def spring_work(z, x, friction, c, normal):
    """Return the integral of `spring_force` from 0 to x."""
    return friction * c * friction_energy(z, z - x / c, normal)


@formula
def friction_energy(z, stick, normal):
    """Return W/(mu K c), W the integral of Q dx from 0 to x at constant z; `stick` is z_s = z - x/c."""
    return (z - stick) * load(z, normal) - energy(z, normal) + energy(stick, normal)


@formula
def back_load(z, stick, normal):
    """Return dW/dz/(mu K c) at constant x, the reciprocal normal force; zero for a punch."""
    return (z - stick) * slope(z, normal) - load(z, normal) + load(stick, normal)


@formula
def tangential_force(x, z, friction, c, normal):
    """Return Q for any x, held at the friction limit beyond c z; `friction` is mu K. Numbers or arrays."""
    if c == 0.0:
        return 0.0 * x
    return np.sign(x) * spring_force(z, abs(x), friction, c, normal)


@formula
def coulomb_limit(c, z):
    """Return X = c z, the slip limit with one coefficient of friction."""
    return c * z


@formula
def coefficient(problem, z):
    """Return the coefficient of friction at rest."""
    return problem.friction


@formula
def limit_ratio(problem, z):
    """Return X/z = c."""
    return problem.limit_slope


@formula
def stuck(problem, z, x):
    """Return Q in stick."""
    law = problem.law
    return spring_force(z, x, law.coefficient(problem, z), law.limit_ratio(problem, z), problem.normal)


@formula
def sliding(problem, z, w):
    """Return Q in slip."""
    return problem.friction * load(z, problem.normal)


@formula
def deformation(problem, z, force):
    """Return x of a spring that carries a force, at most X."""
    law = problem.law
    return spring_deformation(z, force, law.coefficient(problem, z), law.limit_ratio(problem, z), problem.normal)


@formula
def energy_stored(problem, z, x):
    """Return the spring's energy."""
    law = problem.law
    return spring_work(z, x, law.coefficient(problem, z), law.limit_ratio(problem, z), problem.normal)


@formula
def reciprocal_force(problem, z, x):
    """Return the derivative of the spring's energy in z at constant x, where mu and c do not depend on z."""
    c = problem.limit_slope
    return problem.friction * c * back_load(z, z - x / c, problem.normal)


@formula
def _deformation_at_limit(problem, z, force):
    """Return X: a contact that slips carries the friction limit, whatever its speed."""
    return slip_limit(problem, z)


@formula
def guard(problem, memory, i, regime, which, sign, point, front):
    """Return guard number `which` (`codes.Guard`) of a regime; 1.0 where the regime has no such guard."""
    z, x, _, _ = point
    band = problem.stick_band
    if which == Guard.GAP:
        return FAR_SIDE - z if regime == Regime.SEPARATED else FAR_SIDE + z
    if regime == Regime.STICK:
        deformation = sign * x
        return FAR_SIDE + slip_limit(problem, z) - deformation if which == Guard.STICK_LIMIT else FAR_SIDE + deformation
    if regime == Regime.SLIP and which == Guard.SLIP_SPEED:
        return FAR_SIDE + slip_rate(problem, sign, point) - band
    if regime == Regime.CREEP:
        speed = slip_rate(problem, sign, point)
        return FAR_SIDE + (band - speed if which == Guard.CREEP_SPEED else sign * x - slip_limit(problem, z))
    return 1.0


@formula
def guard_rate(problem, memory, i, regime, which, sign, point, second):
    """Return the rate of a guard; `second` is (z'', x'') of the contact."""
    z, _, z_rate, x_rate = point
    if which == Guard.GAP:
        return -z_rate if regime == Regime.SEPARATED else z_rate
    if regime == Regime.STICK and which == Guard.STICK_REVERSAL:
        return sign * x_rate
    slope = problem.law.limit_rate(problem, z)
    if regime == Regime.STICK:
        return slope * z_rate - sign * x_rate
    if regime == Regime.CREEP and which == Guard.CREEP_LIMIT:
        return sign * x_rate - slope * z_rate
    rate = slip_speed(sign, second[0], second[1], slope) - limit_bend(problem, z) * z_rate * z_rate
    return rate if regime == Regime.SLIP else -rate


@formula
def follow(problem, memory, i, regime, which, sign, point):
    """Return (regime, sign, x, kind of event) on the far side of guard `which`."""
    band, limit = problem.stick_band, slip_limit(problem, point.approach)
    speed = slip_rate(problem, sign, point)
    if which == Guard.GAP:
        if regime != Regime.SEPARATED:
            return Regime.SEPARATED, sign, 0.0, Event.RELEASE
        sign = -1.0 if point.deformation_rate < 0.0 else 1.0
        speed = slip_rate(problem, sign, point)
        if not closes_as_point(problem.normal.hold):  # it closes with a circle, within whose slip limit it sticks
            return Regime.STICK, sign, 0.0, Event.CONTACT
        if speed > band:
            return Regime.SLIP, sign, 0.0, Event.CONTACT
        return (Regime.CREEP if speed > 0.0 else Regime.STICK), sign, 0.0, Event.CONTACT
    if regime == Regime.STICK:
        if which == Guard.STICK_REVERSAL:
            return Regime.STICK, -sign, 0.0, Event.REVERSAL
        if speed > band:
            return Regime.SLIP, sign, sign * limit, Event.STICK_TO_SLIP
        return (Regime.CREEP if band > 0.0 else Regime.STICK), sign, sign * limit, Event.STICK_TO_SLIP
    if regime == Regime.SLIP:
        return (Regime.CREEP if band > 0.0 else Regime.STICK), sign, sign * limit, Event.SLIP_TO_STICK
    if which == Guard.CREEP_SPEED:
        return Regime.SLIP, sign, sign * limit, Event.STICK_TO_SLIP
    return Regime.STICK, sign, sign * limit, Event.SLIP_TO_STICK


@formula
def regime_at(problem, point):
    """Return (regime, sign, x) of a contact with approach z and deformation x, where no history tells its regime."""
    z, x, z_rate, x_rate = point
    band = problem.stick_band
    if z < 0.0 or (z == 0.0 and z_rate <= 0.0):
        return Regime.SEPARATED, 1.0, 0.0
    sign, limit = 1.0, slip_limit(problem, z)
    if x < 0.0 or (x == 0.0 and x_rate < 0.0):
        sign = -1.0
    if sign * x >= limit * (1.0 - 1e-13):
        x = sign * limit
        speed = slip_rate(problem, sign, point)
        if speed > band:
            return Regime.SLIP, sign, x
        if speed > 0.0 and band > 0.0:
            return Regime.CREEP, sign, x
    return Regime.STICK, sign, x


@formula
def tangential(problem, regime, sign, point):
    """Return Q of a contact and the deformation that its spring has with it, of the sign of the force.

    In stick the smooth branch of sign s is continued past x = 0, and held at the limit past it. A contact that slips
    has the deformation of its force, or that of the slip limit where the force exceeds what the spring can carry.
    """
    z, x, _, _ = point
    law, limit = problem.law, slip_limit(problem, z)
    if regime == Regime.SEPARATED or z <= 0.0 or limit <= 0.0:
        return 0.0, 0.0
    if regime == Regime.STICK:
        x = min(sign * x, limit)
        return sign * problem.stiffness * law.stuck(problem, z, x), x
    force = law.sliding(problem, z, max(slip_rate(problem, sign, point), 0.0))
    return sign * problem.stiffness * force, law.deformation(problem, z, force)


@formula
def force(problem, memory, i, regime, sign, point, level, front):
    """Return Q of a contact, and 0.0: without memory slip has no front."""
    return tangential(problem, regime, sign, point)[0], 0.0


@formula
def spring(problem, regime, sign, point):
    """Return Q, the reciprocal force dW/dz at constant x, and the energy W of a contact's tangential spring."""
    z, law = point[0], problem.law
    force, x = tangential(problem, regime, sign, point)
    if x == 0.0:
        return force, 0.0, 0.0
    return force, problem.stiffness * law.back(problem, z, x), problem.stiffness * law.energy(problem, z, x)


def coulomb(kind: int) -> Law:
    """Return the elastic law with one coefficient of friction.

    The hysteretic law shares its gross slip. A law whose coefficient depends on approach or speed replaces some fields.
    """
    rated = bent = 0
    return Law(
        kind, rated, bent, np.zeros(0), coefficient, limit_ratio, limit_rate=limit_ratio, stuck=stuck, sliding=sliding,
        deformation=_deformation_at_limit, energy=energy_stored, back=reciprocal_force, force=force, guard=guard,
        guard_rate=guard_rate, follow=follow,
    )  # fmt: skip
