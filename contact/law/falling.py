r"""Friction that falls (or rises) with the speed of slip and with the contact pressure.

The coefficient is that at rest, which depends on the pressure p, times a factor that depends on the slip speed w:

    mu(p, w) = mu_p(p) (r + (1 - r) exp(-w/w_s)),         r = sliding/static,                                   (1)
    mu_p(p)  = mu_h + (static - mu_h)/(1 + p/p_h),        p = P/(pi a^2), the mean pressure.                    (2)

The speed factor is Stribeck's curve without its viscous branch (Armstrong-Helouvry, Dupont and Canudas de Wit,
Automatica 30 (1994) 1083, eq. 7 with exponent 1). mu_p tends to mu_h + const/p, a constant shear strength in addition
to a constant coefficient (Bowden and Tabor; Briscoe and Evans, Proc. R. Soc. A 380 (1982) 389), and is finite at p = 0.
For a sphere p = K sqrt(z)/(pi R), for a punch K z/(pi R^2).

A contact that sticks has the coefficient mu_p(p): its spring and its slip limit X are those of `law.elastic` with

    mu = static g(z),   X = c g(z) z,   g = mu_p/static.                                                        (3)

The slip speed is that at the limit, w = s (u_x' - v) - X'(z) z'. When slip begins, the force drops at once to
mu(p, w) P, and the spring relaxes. The energy that it releases is lost in slip. The relaxation does not enter w: a
contact has no mass, and with a friction that decreased by its own relaxation its motion would not be determined.
"""

from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.codes import Tangential
from contact.jit.compiled import formula
from contact.law.elastic import back_load, coulomb, deformation, friction_energy
from contact.law.normal import exponent, load, mean_pressure
from contact.law.protocol import Law
from contact.rules import FrictionRules


@dataclass(frozen=True, kw_only=True)
class FallingFriction(FrictionRules):
    """How friction departs from its static coefficient, `Slider.friction_coefficient`.

    Attributes
    ----------
    sliding : float, optional
        Coefficient at slip speeds far above `speed`, zero or positive; with `speed`.
    speed : float, optional
        w_s, m/s, positive: the excess over `sliding` falls by a factor e for each increase of the slip speed by w_s.
    high_pressure : float, optional
        mu_h: coefficient of a contact at rest at pressures far above `pressure`, positive; with `pressure`.
    pressure : float, optional
        p_h, Pa, positive: the pressure at which half of the excess over `high_pressure` is left.
    """

    sliding: float | None = None
    speed: float | None = None
    high_pressure: float | None = None
    pressure: float | None = None

    def __post_init__(self):
        for name, rule, unit in (
            ("sliding", parameter_check.non_negative, ""), ("speed", parameter_check.positive, "m/s"),
            ("high_pressure", parameter_check.positive, ""), ("pressure", parameter_check.positive, "Pa"),
        ):  # fmt: skip
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, rule(f"friction.{name}", value, unit))
        self._refuse("friction")

    def law(self, static: float, ratio: float, pressure: float) -> Law:
        """Return the law of a static coefficient; `ratio` is E/4G, `pressure` p in Pa at an approach of 1 m."""
        sliding_ratio, speed, high_pressure_ratio, pressure_ratio = 1.0, 1.0, 1.0, 0.0
        if self.sliding is not None and self.speed is not None:
            sliding_ratio, speed = self.sliding / static, self.speed
        if self.high_pressure is not None and self.pressure is not None:
            high_pressure_ratio, pressure_ratio = self.high_pressure / static, pressure / self.pressure
        numbers = np.array([static * ratio, sliding_ratio, speed, high_pressure_ratio, pressure_ratio])
        return coulomb(Tangential.ELASTIC)._replace(
            rated=int(self.sliding is not None), bent=int(self.high_pressure is not None), numbers=numbers,
            coefficient=coefficient, limit_ratio=limit_ratio, limit_rate=limit_rate, sliding=sliding,
            deformation=deformation, back=back,
        )  # fmt: skip


# Indices in `Law.numbers`: c at the static coefficient, r, w_s (m/s), mu_h/static, p/p_h at an approach of 1 m
SLOPE, SLIDING_RATIO, SPEED, HIGH_PRESSURE_RATIO, PRESSURE_RATIO = range(5)


@formula
def pressure_factor(problem, z):
    """Return (g, z dg/dz) of eq. (3).

    By eq. (2), g = h + (1 - h) f with h = mu_h/static and f = 1/(1 + p/p_h). As p is proportional to z^n,
    z dg/dz = -(1 - h) n (p/p_h) f^2.
    """
    numbers, n = problem.law.numbers, 2.0 - exponent(problem.normal)  # n: 1/2 for a sphere, 1 for a punch
    h = numbers[HIGH_PRESSURE_RATIO]
    pressure = numbers[PRESSURE_RATIO] * mean_pressure(z * problem.length, problem.normal)
    f = 1.0 / (1.0 + pressure)
    return h + (1.0 - h) * f, -(1.0 - h) * n * pressure * f * f


@formula
def coefficient(problem, z):
    """Return mu_p."""
    return problem.friction * pressure_factor(problem, z)[0]


@formula
def limit_ratio(problem, z):
    """Return X/z = c g."""
    return problem.law.numbers[SLOPE] * pressure_factor(problem, z)[0]


@formula
def limit_rate(problem, z):
    """Return dX/dz = c (g + z dg/dz)."""
    g, z_dg = pressure_factor(problem, z)
    return problem.law.numbers[SLOPE] * (g + z_dg)


@formula
def sliding(problem, z, w):
    """Return Q in slip at the speed w, eq. (1)."""
    numbers = problem.law.numbers
    r = numbers[SLIDING_RATIO]
    speed_factor = r + (1.0 - r) * np.exp(-w * problem.length * problem.omega / numbers[SPEED])
    return coefficient(problem, z) * speed_factor * load(z, problem.normal)


@formula
def back(problem, z, x):
    """Return dW/dz at constant x, W the energy of the spring.

    With C = c g, z_s = z - x/C and E(z, z_s) = `friction_energy`, the energy over the stiffness is W = mu g C E. As g
    and C have the same relative derivative b = (dg/dz)/g, and dz_s/dz = 1 + (z - z_s) b,

        dW/dz = mu g C [2 b E + dE/dz],   dE/dz = `back_load` - (z - z_s) b (p(z) - p(z_s)).
    """
    (g, z_dg), normal = pressure_factor(problem, z), problem.normal
    c_g = problem.law.numbers[SLOPE] * g
    z_s, b = z - x / c_g, z_dg / (g * (z + 1e-300))
    bracket = back_load(z, z_s, normal) + 2.0 * b * friction_energy(z, z_s, normal)
    bracket -= (z - z_s) * b * (load(z, normal) - load(z_s, normal))
    return problem.friction * g * c_g * bracket
