"""The slider: a rigid body on one or several equal balls or flat punches.

Mass, preload, load and viscous dampers are totals of the slider; radius and moduli belong to each ball's contact.
Normal: m z'' = sum P_i (1 + chi z_i') - R_n2 z' - preload. Tangential: m v' = sum Q_i - R_t v - load.
"""

import math
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.input_error import InputError
from contact.law import elastic, normal

LAWS = ("elastic", "hysteretic")
POSITIVE = {"radius": "m", "mass": "kg", "effective_modulus": "Pa", "tangential_modulus": "Pa"}
NON_NEGATIVE = {
    "preload": "N", "load": "N", "friction_coefficient": "", "stick_band": "m/s", "contact_damping": "s/m",
    "normal_damping": "N s/m", "tangential_damping": "N s/m",
}  # fmt: skip


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
    heights : tuple of float
        How much further each contact stands out towards the surface than a contact of height 0, m; empty: all 0.
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
    heights: tuple[float, ...] = ()

    def __post_init__(self):
        for rule, units in (bounds.positive, POSITIVE), (bounds.non_negative, NON_NEGATIVE):
            for name, unit in units.items():
                object.__setattr__(self, name, rule(f"slider.{name}", getattr(self, name), unit))
        bounds.choice("slider.law", self.law, LAWS)
        bounds.choice("slider.shape", self.shape, normal.SHAPES)
        if np.ndim(self.heights) != 1:
            raise InputError("slider.heights", "must be a list of heights in m", self.heights)
        heights = tuple(bounds.finite("slider.heights", height, "m") for height in self.heights)
        object.__setattr__(self, "heights", heights if any(heights) else ())
        if self.shape == "punch" and self.law == "hysteretic":
            raise InputError(
                "slider.law", 'must be "elastic" for a punch, which slips as a whole, got "hysteretic"'
            )
        if self.stick_band > 0.0 and self.law == "hysteretic":
            raise InputError(
                "slider.stick_band", "must be 0 m/s with the hysteretic law", self.stick_band, "m/s"
            )
        if not isinstance(self.reciprocal, bool):
            raise InputError("slider.reciprocal", "must be true or false", self.reciprocal)

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

    def contact_radius(self, approach: float) -> float:
        """Return the radius in m of the contact circle at an approach in m."""
        return float(normal.contact_radius(approach, self.radius, self.contact_shape))

    def pressure(self, approach: float) -> float:
        """Return the largest pressure of a sphere, 2 E a/(pi R), or the mean one of a punch, 2 E z/(pi R), in Pa."""
        z = max(approach, 0.0)
        length = z if self.shape == "punch" else self.contact_radius(z)
        return 2.0 * self.effective_modulus * length / (math.pi * self.radius)

    def tangential_force(self, deformation, approach: float):
        """Return Q in N of the elastic law at deformations and an approach in m, at most the friction limit."""
        friction = self.friction_coefficient * self.normal_stiffness
        return elastic.tangential_force(deformation, approach, friction, self.limit_slope, self.contact_shape)

    def offsets(self, contacts: int) -> np.ndarray:
        """Return the heights of so many contacts as an array, m."""
        if self.heights and len(self.heights) != contacts:
            raise InputError(
                "slider.heights", f"must hold one height per contact, {contacts}", len(self.heights)
            )
        return np.array(self.heights) if self.heights else np.zeros(contacts)

    def approach_under(self, force: float, contacts: int) -> float:
        """Return the approach in m of a contact of height 0 at which the contacts carry a normal force in N."""
        shape, target = self.contact_shape, force / self.normal_stiffness
        if not self.heights:
            return float(normal.approach(target / contacts, shape))
        heights = self.offsets(contacts)
        # Newton's method from above on a convex sum: the lowest contact alone, or all as low as it, would carry more
        h = float(min(normal.approach(target / contacts, shape) - min(heights),
                      normal.approach(target, shape) - max(heights)))  # fmt: skip
        for _ in range(100):
            excess = float(np.sum(normal.load(h + heights, shape))) - target
            slope = float(np.sum(normal.slope(h + heights, shape)))
            if not excess > 1e-16 * target or slope == 0.0:
                break
            h -= excess / slope
        return h

    def rest_approach(self, contacts: int) -> float:
        """Return the approach in m of a contact of height 0 under the preload, no wave: minus the slider's position."""
        return self.approach_under(self.preload, contacts)

    def rest_approaches(self, contacts: int) -> np.ndarray:
        """Return the approach of every contact under the preload, no wave, m; zero where it does not touch."""
        return np.maximum(self.rest_approach(contacts) + self.offsets(contacts), 0.0)

    def rest_deformations(self, contacts: int) -> np.ndarray:
        """Return the deformations in m with which the contacts carry the load at rest, all slipping if they cannot.

        Contacts that are sheared together carry Q = mu (P - P'), P' the normal force at an approach x/c smaller
        (Ciavarella 1998; see `law.elastic`), so that P' is the preload less load/mu.
        """
        z, c = self.rest_approaches(contacts), self.limit_slope
        if c == 0.0:
            return 0.0 * z
        left = max(self.preload - self.load / self.friction_coefficient, 0.0)
        return c * np.minimum(z, self.rest_approach(contacts) - self.approach_under(left, contacts))

    def normal_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of the bounce at rest, sqrt(sum dP/dz / m)/2 pi."""
        slope = float(
            np.sum(normal.slope(self.rest_approach(contacts) + self.offsets(contacts), self.contact_shape))
        )
        return math.sqrt(self.normal_stiffness * slope / self.mass) / (2.0 * math.pi)

    def tangential_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of a small tangential ring at rest, sqrt(sum 8 a G/m)/2 pi; dP/dz = 2 a E."""
        ratio = 4.0 * self.tangential_modulus / self.effective_modulus
        return math.sqrt(ratio) * self.normal_resonance(contacts)
