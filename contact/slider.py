"""Slider: a rigid body on one or several equal balls or flat punches.

Mass, preload, load and viscous dampers are those of the whole slider. Radius and moduli are those of each contact.
Normal: m z'' = sum P_i (1 + chi z_i') - R_n2 z' - preload. Tangential: m v' = sum Q_i - R_t v - load.
"""

import math
from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from contact import parameter_check
from contact.body import height_under
from contact.codes import Shape, Tangential
from contact.exceptions import InputError
from contact.law import elastic, hysteretic, normal
from contact.law.falling import FallingFriction
from contact.law.protocol import Law, slip_limit
from contact.law.user import Contact, UserLaw, tried, user_law
from contact.roots import bracketed

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
        Mass of the slider, kg, positive.
    preload : float
        Normal force that presses the slider onto the surface, including its weight, N, zero or positive.
    load : float
        Constant force against the direction of the unloaded motion, N, zero or positive. The direction is that of the
        cycle means, also for a slider that hops. Such a slider may move the other way, and then the load drives it.
    friction_coefficient : float
        Coefficient of friction mu, zero or positive.
    effective_modulus, tangential_modulus : float
        Effective moduli E and G of the pair of materials, Pa, positive.
    law : str
        "elastic" (Feenstra and Breedveld, eq. 2) or "hysteretic" (Mindlin-Deresiewicz). A `UserLaw`, a module
        or the path of a file becomes `friction`, with the elastic law's stick and slip.
    reciprocal : bool
        True if the tangential spring contributes to the normal force (reciprocal force).
    stick_band : float
        Slip velocity below which a contact counts as sticking, DV in Feenstra and Breedveld, m/s; 0 for none.
    contact_damping : float
        R_n1, the coefficient chi of the Hunt-Crossley force chi P dz/dt, s/m. The friction limit uses the elastic P.
    normal_damping, tangential_damping : float
        Viscous dampers R_n2 and R_t on the slider's normal and tangential velocity, N s/m.
    shape : str
        "sphere" (default), or "punch": a rigid flat cylindrical projection on a half-space.
    heights : tuple of float
        Height of each contact, positive towards the surface, m; an empty tuple means that all heights are 0.
    friction : FallingFriction or UserLaw, optional
        Friction law that depends on more than the normal force; None means Coulomb's law.
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
    friction: FallingFriction | UserLaw | None = None

    def __post_init__(self):
        if not isinstance(self.law, str) or (self.law not in LAWS and self.law.endswith(".py")):
            object.__setattr__(self, "friction", UserLaw.of(self.law))
            object.__setattr__(self, "law", "elastic")
        for rule, units in (parameter_check.positive, POSITIVE), (parameter_check.non_negative, NON_NEGATIVE):
            for name, unit in units.items():
                object.__setattr__(self, name, rule(f"slider.{name}", getattr(self, name), unit))
        parameter_check.choice("slider.law", self.law, LAWS)
        parameter_check.choice("slider.shape", self.shape, normal.SHAPES)
        if np.ndim(self.heights) != 1:
            raise InputError("slider.heights", "must be a list of heights in m", self.heights)
        heights = tuple(parameter_check.finite("slider.heights", height, "m") for height in self.heights)
        object.__setattr__(self, "heights", heights if any(heights) else ())
        if self.shape == "punch" and self.law == "hysteretic":
            raise InputError("slider.law", 'must be "elastic" for a punch, which slips as a whole, got "hysteretic"')
        if self.stick_band > 0.0 and self.law == "hysteretic":
            raise InputError("slider.stick_band", "must be 0 m/s with the hysteretic law", self.stick_band, "m/s")
        if not isinstance(self.reciprocal, bool):
            raise InputError("slider.reciprocal", "must be true or false", self.reciprocal)
        if self.friction is not None:
            self._check_friction()

    def _check_friction(self):
        """Raise if other parameters are not compatible with friction that depends on speed or pressure."""
        if not isinstance(self.friction, FallingFriction | UserLaw):
            raise InputError("slider.friction", "must be a FallingFriction or a UserLaw", self.friction)
        only = "with a friction that depends on more than the normal force"
        for name, wanted in (("law", "elastic"), ("reciprocal", False), ("stick_band", 0.0)):
            if getattr(self, name) != wanted:
                raise InputError(f"slider.{name}", f"must be {wanted!r} {only}", getattr(self, name))
        if isinstance(self.friction, FallingFriction):
            parameter_check.positive("slider.friction_coefficient", self.friction_coefficient, "")
        else:
            _ = self._tried  # refuses a law that cannot be evaluated

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
        """C = mu E/4G, the slip limit over the approach; its maximum if mu depends on the pressure."""
        if isinstance(self.friction, UserLaw):
            return self._tried[1]
        c = elastic.limit_slope(self.friction_coefficient, self.effective_modulus, self.tangential_modulus)
        if self.friction is None or self.friction.high_pressure is None:
            return c
        return c * max(1.0, self.friction.high_pressure / self.friction_coefficient)

    @property
    def static_coefficient(self) -> float:
        """Friction coefficient at rest; for a user's law its value at an approach of 1 nm."""
        return self._tried[0] if isinstance(self.friction, UserLaw) else self.friction_coefficient

    @property
    def tangential_law(self) -> Law:
        """The tangential law in the form that the solvers use."""
        if isinstance(self.friction, UserLaw):
            return user_law(self.friction, self._contact, self.normal_stiffness)
        if self.friction is not None:
            area = math.pi * self.radius * (1.0 if self.contact_shape == Shape.SPHERE else self.radius)
            ratio, pressure = (self.effective_modulus / (4.0 * self.tangential_modulus), self.normal_stiffness / area)
            return self.friction.law(self.friction_coefficient, ratio, pressure)
        if self.law == "hysteretic" and self.limit_slope > 0.0:
            return hysteretic.mindlin_deresiewicz()
        kind = Tangential.RECIPROCAL if self.reciprocal else Tangential.ELASTIC
        return elastic.coulomb(Tangential.HYSTERETIC if self.law == "hysteretic" else kind)

    @property
    def _contact(self):
        return Contact(
            self.friction_coefficient, self.radius, self.effective_modulus, self.tangential_modulus,
            float(self.contact_shape == Shape.PUNCH),
        )  # fmt: skip

    @property
    def _tried(self):
        return tried(self.friction, self._contact, self.normal_stiffness)

    @property
    def _in_si(self):
        """Problem for the law's functions with lengths in m, times in s and forces divided by K."""
        return SimpleNamespace(
            length=1.0, omega=1.0, friction=self.static_coefficient, limit_slope=self.limit_slope,
            shape=self.contact_shape, law=self.tangential_law,
        )  # fmt: skip

    def static_friction(self, contacts: int) -> float:
        """Return the largest tangential force in N that the contacts hold under the preload without a wave."""
        if self.friction is None or not self.tangential_law.bent:
            return self.static_coefficient * self.preload
        return self.sliding_friction(contacts, 0.0)

    def sliding_friction(self, contacts: int, speed: float) -> float:
        """Return the friction force in N of contacts that slip at a speed in m/s under the preload without a wave."""
        law, si, z = self.tangential_law, self._in_si, self.rest_approaches(contacts)
        return self.normal_stiffness * sum(float(law.sliding(si, each, speed)) for each in z if each > 0.0)

    def contact_radius(self, approach: float) -> float:
        """Return the radius in m of the contact circle at an approach in m."""
        return float(normal.contact_radius(approach, self.radius, self.contact_shape))

    def pressure(self, approach: float) -> float:
        """Return the maximum pressure of a sphere, 2 E a/(pi R), or the mean pressure of a punch, 2 E z/(pi R), Pa."""
        z = max(approach, 0.0)
        length = z if self.shape == "punch" else self.contact_radius(z)
        return 2.0 * self.effective_modulus * length / (math.pi * self.radius)

    def tangential_force(self, deformation, approach: float):
        """Return Q in N of the elastic law at deformations and an approach in m, limited by friction."""
        friction = self.friction_coefficient * self.normal_stiffness
        return elastic.tangential_force(deformation, approach, friction, self.limit_slope, self.contact_shape)

    def offsets(self, contacts: int) -> np.ndarray:
        """Return the heights of the contacts as an array of that length, m."""
        if self.heights and len(self.heights) != contacts:
            raise InputError("slider.heights", f"must hold one height per contact, {contacts}", len(self.heights))
        return np.array(self.heights) if self.heights else np.zeros(contacts)

    def approach_under(self, force: float, contacts: int) -> float:
        """Return the approach in m of a contact of height 0 at which the contacts carry a normal force in N."""
        shape, target = self.contact_shape, force / self.normal_stiffness
        if not self.heights:
            return float(normal.approach(target / contacts, shape))
        heights = self.offsets(contacts)
        # both initial guesses are upper bounds: one takes all heights equal to the smallest, the other only the contact
        # with the largest height
        h = float(min(normal.approach(target / contacts, shape) - min(heights),
                      normal.approach(target, shape) - max(heights)))  # fmt: skip
        if target == 0.0:
            return h

        def sums(height):
            return tuple(float(np.sum(each(height + heights, shape))) for each in (normal.load, normal.slope))

        return float(height_under(sums, target, h, 1e-15 * (abs(h) + float(np.max(np.abs(heights))))))

    def least_friction(self, contacts: int) -> float:
        """Return the least friction force in N of slipping contacts under the preload at speeds up to 10 m/s."""
        if self.friction is None:
            return self.static_friction(contacts)
        return min(self.sliding_friction(contacts, float(speed)) for speed in (0.0, *np.logspace(-4, 1, 21)))

    def rest_approach(self, contacts: int) -> float:
        """Return minus the slider's position under the preload without a wave, the approach of a height of 0, m."""
        return self.approach_under(self.preload, contacts)

    def rest_approaches(self, contacts: int) -> np.ndarray:
        """Return the approach of each contact under the preload without a wave, m; zero if it does not touch."""
        return np.maximum(self.rest_approach(contacts) + self.offsets(contacts), 0.0)

    def rest_deformations(self, contacts: int) -> np.ndarray:
        """Return the deformations in m with which the contacts carry the load at rest, or slip if they cannot.

        Contacts that are sheared together by x carry Q = mu (P - P'), where P' is the normal force at an approach that
        is smaller by x/c (Ciavarella 1998; see `law.elastic`). Hence P' equals the preload less load/mu.
        """
        z, c = self.rest_approaches(contacts), self.limit_slope
        if c == 0.0:
            return 0.0 * z
        if self.friction is not None:
            limits = np.array([float(slip_limit(self._in_si, each)) if each > 0.0 else 0.0 for each in z])
            if self.static_friction(contacts) <= self.load:
                return limits
            return np.minimum(-self.distance_to_rest(0.0 * z, self.load), limits)
        reduced = max(self.preload - self.load / self.friction_coefficient, 0.0)
        return c * np.minimum(z, self.rest_approach(contacts) - self.approach_under(reduced, contacts))

    def distance_to_rest(self, deformations: np.ndarray, load: float) -> float:
        """Return how far along +x a slider with these deformations in m comes to rest under a load along -x in N.

        Its contacts stick on the way, or slip at their limits. At rest the sum of Q(x_i - distance) is the load.
        """
        si, z = self._in_si, self.rest_approaches(len(deformations))
        touching = np.flatnonzero(z)
        x, limits = deformations[touching], np.array([float(slip_limit(si, z[i])) for i in touching])

        def left(distance):
            at_rest = np.clip(x - distance, -limits, limits)
            forces = (
                np.sign(b) * float(si.law.stuck(si, z[i], abs(b))) for i, b in zip(touching, at_rest, strict=True)
            )
            return self.normal_stiffness * sum(forces) - load

        return bracketed(left, float(np.min(x - limits)), float(np.max(x + limits)))

    def normal_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of the bounce at rest, sqrt(sum dP/dz / m)/2 pi."""
        slope = float(np.sum(normal.slope(self.rest_approach(contacts) + self.offsets(contacts), self.contact_shape)))
        return math.sqrt(self.normal_stiffness * slope / self.mass) / (2.0 * math.pi)

    def tangential_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of a small tangential ring at rest, sqrt(sum 8 a G/m)/2 pi; dP/dz = 2 a E."""
        ratio = 4.0 * self.tangential_modulus / self.effective_modulus
        return math.sqrt(ratio) * self.normal_resonance(contacts)
