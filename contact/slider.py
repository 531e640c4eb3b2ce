"""The slider: a rigid body on one or several equal balls or flat punches.

Mass, preload, load and viscous dampers are totals of the slider; radius and moduli belong to each ball's contact.
Normal: m z'' = sum P_i (1 + chi z_i') - R_n2 z' - preload. Tangential: m v' = sum Q_i - R_t v - load.
"""

import math
from dataclasses import dataclass

from contact import bounds
from contact.law import elastic, normal

LAWS = ("elastic", "hysteretic")


@dataclass(frozen=True, kw_only=True)
class Slider:
    """A slider and its contacts.

    Attributes
    ----------
    radius : float
        Radius of each ball or punch, m, positive.
    mass : float
        kg, positive.
    preload : float
        Normal force that holds the slider down, weight included, N, zero or positive.
    load : float
        Constant force against the direction in which the unloaded slider is driven, N, zero or positive.
    friction_coefficient : float
        mu, zero or positive.
    effective_modulus, tangential_modulus : float
        E and G of the pair, Pa, positive.
    law : str
        "elastic" (the seed's eq. 2) or "hysteretic" (Mindlin-Deresiewicz).
    reciprocal : bool
        True: the tangential spring acts back on the normal motion.
    stick_band : float
        The seed's DV, m/s; 0 for none.
    contact_damping : float
        R_n1, Hunt-Crossley's chi, s/m: the force chi P dz/dt; the friction limit uses the elastic P.
    normal_damping, tangential_damping : float
        R_n2 and R_t, viscous, on the slider's normal and tangential velocity, N s/m.
    shape : str
        "sphere" (default), or "punch": a rigid flat cylindrical projection on a half-space.
    """

    radius: float
    mass: float
    preload: float
    load: float
    friction_coefficient: float
    effective_modulus: float
    tangential_modulus: float
    law: str
    reciprocal: bool
    stick_band: float
    contact_damping: float
    normal_damping: float
    tangential_damping: float
    shape: str = "sphere"

    def __post_init__(self):
        for name, unit in (
            ("radius", "m"),
            ("mass", "kg"),
            ("effective_modulus", "Pa"),
            ("tangential_modulus", "Pa"),
        ):
            object.__setattr__(self, name, bounds.positive(f"slider.{name}", getattr(self, name), unit))
        for name, unit in (
            ("preload", "N"),
            ("load", "N"),
            ("friction_coefficient", ""),
            ("stick_band", "m/s"),
            ("contact_damping", "s/m"),
            ("normal_damping", "N s/m"),
            ("tangential_damping", "N s/m"),
        ):
            object.__setattr__(self, name, bounds.non_negative(f"slider.{name}", getattr(self, name), unit))
        bounds.choice("slider.law", self.law, LAWS)
        bounds.choice("slider.shape", self.shape, normal.SHAPES)
        if self.shape == "punch" and self.law == "hysteretic":
            raise ValueError(
                'slider.law must be "elastic" for a punch, which slips as a whole, got "hysteretic"'
            )
        if not isinstance(self.reciprocal, bool):
            raise ValueError(f"slider.reciprocal must be true or false, got {self.reciprocal!r}")

    @property
    def contact_shape(self) -> int:
        """SPHERE or PUNCH of `contact.law.normal`."""
        return normal.SHAPES.index(self.shape)

    @property
    def normal_stiffness(self) -> float:
        """K of P = K z^1.5 (sphere, N/m^1.5) or P = K z (punch, N/m) of one contact."""
        return float(normal.stiffness(self.radius, self.effective_modulus, self.contact_shape))

    @property
    def limit_slope(self) -> float:
        """C = mu E/4G, the slip limit over the approach."""
        return elastic.limit_slope(self.friction_coefficient, self.effective_modulus, self.tangential_modulus)

    def rest_approach(self, contacts: int) -> float:
        """Return the approach z0 of each contact in m under the preload, no wave."""
        return float(normal.approach(self.preload / contacts / self.normal_stiffness, self.contact_shape))

    def normal_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of the bounce at rest, sqrt(sum dP/dz / m)/2 pi."""
        slope = normal.slope(self.rest_approach(contacts), self.contact_shape)
        return math.sqrt(contacts * self.normal_stiffness * slope / self.mass) / (2.0 * math.pi)

    def tangential_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of a small tangential ring at rest, sqrt(sum 8 a G/m)/2 pi; dP/dz = 2 a E."""
        ratio = 4.0 * self.tangential_modulus / self.effective_modulus
        return math.sqrt(ratio) * self.normal_resonance(contacts)

    def ring_at_slip_limit(self, contacts: int) -> float:
        """Return the frequency in Hz of the tangential ring whose amplitude is the slip limit.

        Quarter period by energy, (1/4) T = int_0^{x_max} dx/sqrt(2 (W(x_max) - W(x))/m), regularised at the turning
        point by x = x_max sin(psi); W the energy of the spring.
        """
        if self.friction_coefficient == 0.0 or self.preload == 0.0:
            return self.tangential_resonance(contacts)
        import numpy as np

        z, c, shape = self.rest_approach(contacts), self.limit_slope, self.contact_shape
        node, weight = np.polynomial.legendre.leggauss(64)
        psi, weight = 0.25 * math.pi * (node + 1.0), 0.25 * math.pi * weight
        stick = 2.0 * z * np.sin(0.25 * math.pi - 0.5 * psi) ** 2  # z - x/c without cancellation
        lost = stick * normal.load(z, shape) - normal.energy(stick, shape)
        lost *= contacts * self.friction_coefficient * self.normal_stiffness * c
        quarter = np.sum(weight * c * z * np.cos(psi) / np.sqrt(2.0 * lost / self.mass))
        return float(0.25 / quarter)
