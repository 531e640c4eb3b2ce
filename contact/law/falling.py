r"""Friction that falls (or rises) with the speed of slip and with the contact pressure.

The coefficient is a product of what the pressure p makes of it at rest and what the speed w of slip leaves:

    mu(p, w) = mu_p(p) (r + (1 - r) exp(-w/w_s)),         r = sliding/static,
    mu_p(p)  = mu_h + (static - mu_h)/(1 + p/p_h),        p = P/(pi a^2), the mean pressure.

The first factor's decay is Stribeck's curve without its viscous branch (Armstrong-Helouvry, Dupont and Canudas de Wit,
Automatica 30 (1994) 1083, eq. 7 with exponent 1). The second tends to mu_h + const/p, a constant shear strength on top
of a constant coefficient (Bowden and Tabor; Briscoe and Evans, Proc. R. Soc. A 380 (1982) 389), and stays finite at
p = 0. For a sphere p = K sqrt(z)/(pi R), for a punch K z/(pi R^2).

At rest, and while it sticks, a contact has the coefficient mu_p(p): spring and slip limit are those of `law.elastic`
with it, X = c mu_p z/static. The speed is that of slip at this limit, w = s (u_x' - v) - X'(z) z'. When slip begins
the force falls to mu(p, w) P at once; what the spring so gives back is lost in slip and does not count in w, for a
contact without mass whose friction fell with its own recoil would have no motion (a jump at any speed).
"""

from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.codes import Tangential
from contact.input_error import InputError
from contact.jit.compiled import formula
from contact.law.elastic import back_load, coulomb, deformation, friction_energy
from contact.law.normal import load, mean_pressure, slope
from contact.law.protocol import Law


@dataclass(frozen=True, kw_only=True)
class FallingFriction:
    """How friction departs from its static coefficient, `Slider.friction_coefficient`.

    Attributes
    ----------
    sliding : float, optional
        Coefficient at speeds of slip far above `speed`, zero or positive; with `speed`.
    speed : float, optional
        w_s, m/s, positive: the excess over `sliding` falls by a factor e over it.
    high_pressure : float, optional
        Coefficient of a contact at rest at pressures far above `pressure`, positive; with `pressure`.
    pressure : float, optional
        p_h, Pa, positive: half of the difference is left there.
    """

    sliding: float | None = None
    speed: float | None = None
    high_pressure: float | None = None
    pressure: float | None = None

    def __post_init__(self):
        for name, rule, unit in (
            ("sliding", bounds.non_negative, ""), ("speed", bounds.positive, "m/s"),
            ("high_pressure", bounds.positive, ""), ("pressure", bounds.positive, "Pa"),
        ):  # fmt: skip
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, rule(f"friction.{name}", value, unit))
        for one, other in (("sliding", "speed"), ("high_pressure", "pressure")):
            if (getattr(self, one) is None) != (getattr(self, other) is None):
                raise InputError(f"friction.{one}", f"must be given together with friction.{other}")
        if self.sliding is None and self.high_pressure is None:
            raise InputError("friction", "must hold sliding with speed, or high_pressure with pressure")

    def law(self, static: float, ratio: float, pressure: float) -> Law:
        """Return the law of a static coefficient; `ratio` is E/4G, `pressure` p in Pa at an approach of 1 m."""
        fading, speed, pressed, strength = 1.0, 1.0, 1.0, 0.0
        if self.sliding is not None and self.speed is not None:
            fading, speed = self.sliding / static, self.speed
        if self.high_pressure is not None and self.pressure is not None:
            pressed, strength = self.high_pressure / static, pressure / self.pressure
        numbers = np.array([static * ratio, fading, speed, pressed, strength])
        return coulomb(Tangential.ELASTIC)._replace(
            rated=int(self.sliding is not None), bent=int(self.high_pressure is not None), numbers=numbers,
            coefficient=coefficient, limit_ratio=limit_ratio, limit_rate=limit_rate, sliding=sliding,
            deformation=deformation, back=back,
        )  # fmt: skip


# Numbers of the law: c at the static coefficient, r, w_s, mu_h/static, p/p_h of an approach of 1 m
SLOPE, RATIO, SPEED, PRESSED, STRENGTH = range(5)


@formula
def share(problem, z):
    """Return mu_p over the static coefficient, and z times its derivative."""
    n, exponent = problem.law.numbers, 2.0 - slope(1.0, problem.shape)
    pressure = n[STRENGTH] * mean_pressure(z * problem.length, problem.shape)
    part = 1.0 / (1.0 + pressure)
    return n[PRESSED] + (1.0 - n[PRESSED]) * part, -(1.0 - n[PRESSED]) * exponent * pressure * part * part


@formula
def coefficient(problem, z):
    """Return mu_p."""
    return problem.friction * share(problem, z)[0]


@formula
def limit_ratio(problem, z):
    """Return X/z."""
    return problem.law.numbers[SLOPE] * share(problem, z)[0]


@formula
def limit_rate(problem, z):
    """Return dX/dz."""
    part, change = share(problem, z)
    return problem.law.numbers[SLOPE] * (part + change)


@formula
def sliding(problem, z, w):
    """Return Q in slip."""
    n = problem.law.numbers
    fading = n[RATIO] + (1.0 - n[RATIO]) * np.exp(-w * problem.length * problem.omega / n[SPEED])
    return coefficient(problem, z) * fading * load(z, problem.shape)


@formula
def back(problem, z, x):
    """Return the derivative of the energy in z: that of the elastic law, and by the coefficient's own change."""
    (part, change), shape = share(problem, z), problem.shape
    c = problem.law.numbers[SLOPE] * part
    stick, bend = z - x / c, change / (part * (z + 1e-300))
    own = back_load(z, stick, shape) + 2.0 * bend * friction_energy(z, stick, shape)
    own -= (z - stick) * bend * (load(z, shape) - load(stick, shape))
    return problem.friction * part * c * own
