r"""Stick, slip and separation of one contact: what bounds each regime and what follows it.

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

from contact.jit.compiled import compiled

SEPARATED, STICK, SLIP, CREEP = 0, 1, 2, 3
# of the hysteretic law, instead of stick: slip of an outer annulus, and an edge that grows without slip (`memory`)
ANNULUS, GROW = 4, 5
# how far past its root a guard is accepted, in units of the scaled problem: above rounding, below everything else
FAR_SIDE = 1e-15
# kinds of event
CONTACT, RELEASE, STICK_TO_SLIP, SLIP_TO_STICK, REVERSAL, GRAZE = 0, 1, 2, 3, 4, 5
# and, in the tally behind the figures of the work, a piece of memory wiped out
WIPE_OUT = 11
NAMES = ("contact", "release", "stick_to_slip", "slip_to_stick", "reversal", "graze")


@compiled
def guard(regime, which, sign, z, x, z_rate, x_rate, c, band):
    """Return guard number `which` (0, 1, 2) of a regime; 1.0 where the regime has no such guard."""
    if which == 0:
        return FAR_SIDE - z if regime == SEPARATED else FAR_SIDE + z
    if regime == STICK:
        return FAR_SIDE + c * z - sign * x if which == 1 else FAR_SIDE + sign * x
    if regime == SLIP and which == 1:
        return FAR_SIDE + sign * x_rate - c * z_rate - band
    if regime == CREEP:
        return FAR_SIDE + (band - (sign * x_rate - c * z_rate) if which == 1 else sign * x - c * z)
    return 1.0


@compiled
def follow(regime, which, sign, z, x, z_rate, x_rate, c, band):
    """Return (regime, sign, x, kind of event) on the far side of guard `which`."""
    slip_speed = sign * x_rate - c * z_rate
    if which == 0:
        if regime != SEPARATED:
            return SEPARATED, sign, 0.0, RELEASE
        sign = -1.0 if x_rate < 0.0 else 1.0
        slip_speed = sign * x_rate - c * z_rate
        if slip_speed > band:
            return SLIP, sign, 0.0, CONTACT
        return (CREEP if slip_speed > 0.0 else STICK), sign, 0.0, CONTACT
    if regime == STICK:
        if which == 2:
            return STICK, -sign, 0.0, REVERSAL
        if slip_speed > band:
            return SLIP, sign, sign * c * z, STICK_TO_SLIP
        return (CREEP if band > 0.0 else STICK), sign, sign * c * z, STICK_TO_SLIP
    if regime == SLIP:
        return (CREEP if band > 0.0 else STICK), sign, sign * c * z, SLIP_TO_STICK
    if which == 1:
        return SLIP, sign, sign * c * z, STICK_TO_SLIP
    return STICK, sign, sign * c * z, SLIP_TO_STICK


@compiled
def opening(z, x, z_rate, x_rate, c, band):
    """Return (regime, sign, x) of a contact that is found with approach z and deformation x."""
    if z < 0.0 or (z == 0.0 and z_rate <= 0.0):
        return SEPARATED, 1.0, 0.0
    sign = 1.0
    if x < 0.0 or (x == 0.0 and x_rate < 0.0):
        sign = -1.0
    if sign * x >= c * z * (1.0 - 1e-13):
        x = sign * c * z
        slip_speed = sign * x_rate - c * z_rate
        if slip_speed > band:
            return SLIP, sign, x
        if slip_speed > 0.0 and band > 0.0:
            return CREEP, sign, x
    return STICK, sign, x


@compiled
def traction(regime, sign, z, x, normal_force, mu, c):
    """Return Q; in stick the smooth branch of sign s is continued past x = 0 and held at mu P past the limit."""
    if regime == SEPARATED or c * z <= 0.0:
        return 0.0
    if regime == STICK:
        left = 1.0 - sign * x / (c * z)
        if left <= 0.0:
            return sign * mu * normal_force
        return sign * mu * normal_force * (1.0 - left * left**0.5)
    return sign * mu * normal_force


@compiled
def back_force(regime, sign, z, x, normal_force, mu, c):
    """Return dW/dz at constant x, W the energy of the tangential spring: mu P c (2.5 w(r) - r w'(r)), r = s x/(c z).

    W = mu P c z w(r), w = r - 0.4 (1 - (1 - r)^2.5), P proportional to z^1.5; at the slip limit it is mu P c/2.
    """
    if regime == SEPARATED or z <= 0.0 or c == 0.0:
        return 0.0
    if regime != STICK:
        return 0.5 * mu * normal_force * c
    left = max(1.0 - sign * x / (c * z), 0.0)
    power = left * left**0.5
    return mu * normal_force * c * (2.5 * (0.6 - left + 0.4 * left * power) - (1.0 - left) * (1.0 - power))
