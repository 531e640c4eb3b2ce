r"""Slider: a rigid body on contacts, which are balls, flat punches or pillars.

Mass, preload, load, viscous dampers and the way in which the body is held are those of the whole slider. Position,
height, radius or stiffness, and weight belong to the contacts, one value for all of them or one for each.
Normal: m z'' = sum P_i (1 + chi z_i') - R_n2 z' - preload. Tangential: m v' = sum Q_i - R_t v - load.
"""

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from types import SimpleNamespace
from typing import Any, NamedTuple

import numpy as np

from contact import parameter_check
from contact.body import height_under
from contact.codes import Shape, Tangential
from contact.exceptions import InputError
from contact.law import elastic, holding, hysteretic, normal
from contact.law.adhesion import Adhesion
from contact.law.falling import FallingFriction
from contact.law.holding import attraction
from contact.law.protocol import Law, slip_limit
from contact.law.table import TabulatedForce
from contact.law.user import Contact, UserForce, UserLaw, tried, user_law
from contact.parameter_check import refuse_if
from contact.roots import bracketed
from contact.rules import SliderRules

LAWS = ("elastic", "hysteretic")
FREEDOMS = ("x", "xy", "xy yaw", "axle")
TILTS, BACKINGS = ("held", "pitch", "free"), ("rigid", "soft")
NON_NEGATIVE = {
    "preload": "N", "load": "N", "friction_coefficient": "", "stick_band": "m/s", "contact_damping": "s/m",
    "normal_damping": "N s/m", "tangential_damping": "N s/m",
}  # fmt: skip
# What each contact may have of its own: noun and unit. Radii, stiffnesses and weights are positive.
OWN = {
    "x": ("position", "m"), "y": ("position", "m"), "heights": ("height", "m"), "radius": ("radius", "m"),
    "normal_stiffness": ("stiffness", "N/m"), "tangential_stiffness": ("stiffness", "N/m"), "weights": ("weight", ""),
}  # fmt: skip
ANY_SIGN = ("x", "y", "heights")
USER_START, USER_END = 1e-2, 1e3  # of the table of a user's normal law, over the approach of a smooth contact at rest
# Unit of the depth of adhesion (`law.holding`) over the approach of a smooth ball at rest, below which there is none
NEGLIGIBLE = 1e-12
SAME_ROW = 1e-9  # positions closer than this times the slider's length are equal up to rounding in the input


class Derived(float):
    """A number that follows from other fields, so that `dataclasses.replace` computes it anew."""


class DerivedArray(np.ndarray):
    """Numbers that follow from other fields, so that `dataclasses.replace` computes them anew."""


class DerivedName(str):
    """A choice that follows from other fields, so that `dataclasses.replace` makes it anew."""

    __slots__ = ()


class Contacts(NamedTuple):
    """The n contacts of a slider, SI units; arrays (n,)."""

    x: np.ndarray
    y: np.ndarray
    height: np.ndarray
    normal_stiffness: np.ndarray  # k_n of P = k_n p(z)
    tangential_stiffness: np.ndarray
    limit_slope: np.ndarray  # c
    weight: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class Slider(SliderRules):
    """A slider and its contacts.

    Attributes
    ----------
    radius : float or array_like, shape (n,), optional
        Radius of each ball or punch, m, positive.
    effective_modulus, tangential_modulus : float, optional
        Effective moduli E and G of the pair of materials, Pa, positive. With the radius they give the stiffnesses.
    normal_stiffness, tangential_stiffness : float or array_like, shape (n,), optional
        k_n of P = k_n z^1.5 (sphere, N/m^1.5) or P = k_n z (punch, N/m) and k_t of each contact, positive. Contacts
        without a radius, such as pillars that are compliant themselves, are given by these. The slip limit is
        c = mu k_n/k_t times the approach; of radius and moduli k_t = 4 (G/E) k_n.
    x, y : float or array_like, shape (n,)
        Positions along and across the wave, from the slider's centre, m.
    heights : float or array_like, shape (n,)
        Height of each contact, positive towards the surface, m; an empty tuple means that all heights are 0.
    weights : float or array_like, shape (n,)
        Number of equal contacts that each contact represents, positive.
    mass : float
        Mass of the slider, kg, positive. inf stands for a slider that moves neither up nor along within a cycle of the
        wave: first-order averaging is exact for it, and it has no motion in time.
    preload : float
        Normal force that presses the slider onto the surface, including its weight, N, zero or positive.
    load : float
        Constant force against the direction of the unloaded motion, N, zero or positive. The direction is that of the
        cycle means, also for a slider that hops. Such a slider may move the other way, and then the load drives it.
    friction_coefficient : float
        Coefficient of friction mu, zero or positive.
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
        "sphere" (default of contacts with a radius), or "punch": a flat cylindrical projection, such as a pillar.
    normal_law : TabulatedForce or UserForce, optional
        Normal force of each contact over its approach from first touch, of a rough surface or of one's own; None means
        that of the smooth `shape`. A module or the path of a file becomes a `UserForce`.
    adhesion : Adhesion, optional
        Attraction of balls in contact; friction does not feel it. The balls must be equal and at one height.
    friction : FallingFriction or UserLaw, optional
        Friction law that depends on more than the normal force; None means Coulomb's law.
    tilt : str
        "held" (default: no rotation), "pitch" (rotation about y) or "free" (rotation about x and y).
    preload_at : tuple of float
        Position (x, y) at which the preload acts, m. It has no effect if `tilt` is "held".
    load_height : float
        Height above the surface at which a load acts, m. It has no effect if `tilt` is "held".
    backing : str
        "rigid": all contacts are on one plane. "soft": every row along the wave carries the same force per contact.
    curvature : float
        Curvature of the slider's face, 1/m. If it is positive, the middle protrudes: a contact at (x, y) is set back by
        (x^2 + y^2)/2 times the curvature.
    freedom : str
        "x" (default: motion along x alone), or a motion in the plane, see `contact.plane`: "xy" (yaw held), "xy yaw",
        or "axle" (rotation about `axis` alone). In the plane `load` is the vector (F_x, F_y) in N of any sign; the
        force on the slider is its negative.
    axis : tuple of float
        Position (x, y) of the axle, m.
    inertia : float, optional
        Moment of inertia about the centre, or about the axle, kg m^2, positive; required where yaw is followed in time.
    torque : float
        Torque in N m against positive yaw, which turns from x to y.
    yaw_damping : float
        Viscous damper of the yaw, N m s.
    """

    mass: float
    preload: float
    load: Any
    friction_coefficient: float
    law: str
    reciprocal: bool
    stick_band: float
    contact_damping: float
    normal_damping: float
    tangential_damping: float
    radius: Any = None
    effective_modulus: Any = None
    tangential_modulus: Any = None
    normal_stiffness: Any = None
    tangential_stiffness: Any = None
    x: Any = 0.0
    y: Any = 0.0
    heights: Any = ()
    weights: Any = 1.0
    shape: Any = None
    normal_law: Any = None
    adhesion: Adhesion | None = None
    friction: FallingFriction | UserLaw | None = None
    tilt: str = "held"
    preload_at: tuple[float, float] = (0.0, 0.0)
    load_height: float = 0.0
    backing: str = "rigid"
    curvature: float = 0.0
    freedom: str = "x"
    axis: tuple[float, float] = (0.0, 0.0)
    inertia: float | None = None
    torque: float = 0.0
    yaw_damping: float = 0.0

    def __post_init__(self):
        if not isinstance(self.law, str) or (self.law not in LAWS and self.law.endswith(".py")):
            self._set("friction", UserLaw.of(self.law))
            self._set("law", "elastic")
        if self.shape is None or isinstance(self.shape, DerivedName):
            rule = 'is required with slider.normal_stiffness, in N/m^1.5 of a "sphere" and N/m of a "punch"'
            refuse_if(not isinstance(self.normal_stiffness, Derived | DerivedArray | None), "slider.shape", rule)
            self._set("shape", DerivedName("sphere"))
        if self.mass != math.inf:
            self._set("mass", parameter_check.positive("slider.mass", self.mass, "kg"))
        self._set_freedom()
        for name, unit in NON_NEGATIVE.items():
            if name != "load" or self.freedom == "x":
                self._set(name, parameter_check.non_negative(f"slider.{name}", getattr(self, name), unit))
        for name, allowed in {"law": LAWS, "shape": normal.SHAPES, "tilt": TILTS, "backing": BACKINGS}.items():
            parameter_check.choice(f"slider.{name}", getattr(self, name), allowed)
        refuse_if(not isinstance(self.reciprocal, bool), "slider.reciprocal", "must be true or false", self.reciprocal)
        self._refuse("slider")
        self._set_contacts()
        self._hold_body()
        if self.friction is not None:
            self._check_friction()
        if self.normal_law is not None:
            self._check_normal_law()
        if self.adhesion is not None:
            self._check_adhesion()

    def _set(self, name, value):
        object.__setattr__(self, name, value)

    def _set_freedom(self):
        """Check what belongs to a motion in the plane."""
        parameter_check.choice("slider.freedom", self.freedom, FREEDOMS)
        if self.inertia is not None:
            self._set("inertia", parameter_check.positive("slider.inertia", self.inertia, "kg m^2"))
        self._set("torque", parameter_check.finite("slider.torque", self.torque, "N m"))
        self._set("yaw_damping", parameter_check.non_negative("slider.yaw_damping", self.yaw_damping, "N m s"))
        for name, unit in ({"axis": "m"} | ({"load": "N"} if self.freedom != "x" else {})).items():
            value = getattr(self, name)
            pair = (0.0, 0.0) if np.ndim(value) == 0 and value == 0.0 else value
            refuse_if(np.shape(pair) != (2,), f"slider.{name}", f"must be a vector of two numbers in {unit}", value)
            self._set(name, tuple(parameter_check.finite(f"slider.{name}", each, unit) for each in pair))

    def _set_contacts(self):
        """Check the contacts' values and make them floats or arrays; derive the stiffnesses from radius and moduli."""
        placed = np.size(self.x) if np.ndim(self.x) else None
        refuse_if(
            np.ndim(self.heights) != 1 and placed is None,
            "slider.heights",
            "must be a list of heights in m",
            self.heights,
        )
        if isinstance(self.normal_stiffness, Derived | DerivedArray):
            self._set("normal_stiffness", None)
            self._set("tangential_stiffness", None)
        moduli = () if self.normal_stiffness is not None else ("effective_modulus", "tangential_modulus")
        required = ("normal_stiffness", "tangential_stiffness") if not moduli else ("radius",)
        if placed and np.ndim(self.heights) and not len(self.heights):
            self._set("heights", 0.0)
        for name, (_, unit) in OWN.items():
            if getattr(self, name) is not None or name in required:
                self._set(name, _own_values(name, getattr(self, name), unit, placed))
        if placed is None:
            self._set("heights", tuple(self.heights.tolist()) if self.heights.any() else ())
        for name in moduli:
            self._set(name, parameter_check.positive(f"slider.{name}", getattr(self, name), "Pa"))
        if moduli:
            k_n = normal.stiffness(self.radius, self.effective_modulus, self.contact_shape)
            k_t = 4.0 * self.tangential_modulus / self.effective_modulus * k_n
            for name, value in (("normal_stiffness", k_n), ("tangential_stiffness", k_t)):
                self._set(name, value.view(DerivedArray) if np.ndim(value) else Derived(value))

    @property
    def special_friction(self) -> str:
        """What the friction depends on beside the normal force, in words; empty for Coulomb's law."""
        return "" if self.friction is None else "a friction that depends on more than the normal force"

    def refuse_other_laws(self, where: str = "") -> None:
        """Raise an InputError unless the law is Coulomb's with the elastic spring alone."""
        rule = 'must be "elastic", not reciprocal, with Coulomb\'s friction and no stick band'
        refuse_if(
            self.law != "elastic" or self.reciprocal or self.stick_band > 0.0 or self.friction is not None,
            "slider.law",
            f"{rule}{where}",
        )
        refuse_if(self.adhesion is not None, "slider.adhesion", f"must be absent{where}")

    def _hold_body(self):
        """Raise unless the contacts can hold the body, its tilt and a preload beside their centre."""
        for name, unit in (("load_height", "m"), ("curvature", "1/m")):
            self._set(name, parameter_check.finite(f"slider.{name}", getattr(self, name), unit))
        at = tuple(parameter_check.finite("slider.preload_at", each, "m") for each in self.preload_at)
        self._set("preload_at", at)
        if self.freedom in ("xy yaw", "axle"):
            about = self.axis if self.freedom == "axle" else (np.mean(self.x), np.mean(self.y))
            arms = np.hypot(np.subtract(self.x, about[0]), np.subtract(self.y, about[1]))
            refuse_if(not np.any(arms > 0.0), "slider.axis", "needs two contacts apart: one ball has no yaw stiffness")
        if self.tilt == "held":
            return
        if self.tilt == "free" and self.freedom != "x" and _on_a_line(self.x, self.y):
            number = {1: "one ball does", 2: "two balls on a line do", 3: "three balls on a line do"}
            which = number.get(self.count, "balls on a line do")
            raise InputError("slider.tilt", f'must change: {which} not fix the tilt: hold it with slider.tilt = "held"')
        for name in ("x",) if self.tilt == "pitch" else ("x", "y"):
            refuse_if(
                np.ptp(getattr(self, name)) == 0.0,
                "slider.tilt",
                f'must be "held" where all contacts have the same {name}',
            )
        self.preload_point(0.0)

    def _check_friction(self):
        """Raise if other parameters are not compatible with friction that depends on speed or pressure."""
        if not isinstance(self.friction, FallingFriction | UserLaw):
            raise InputError("slider.friction", "must be a FallingFriction or a UserLaw", self.friction)
        only = f"with {self.special_friction}"
        refuse_if(not self.even, "slider.radius", f"must be equal for all contacts {only}, and the weights 1")
        if self.effective_modulus is None:
            raise InputError("slider.effective_modulus", f"is required {only}")
        if isinstance(self.friction, FallingFriction):
            parameter_check.positive("slider.friction_coefficient", self.friction_coefficient, "")
        else:
            _ = self._tried  # refuses a law that cannot be evaluated

    def _check_normal_law(self):
        """Raise unless the contacts are of the one kind that a table of their normal force holds for."""
        if not isinstance(self.normal_law, TabulatedForce):
            self._set("normal_law", UserForce.of(self.normal_law))
            if self.radius is None or self.effective_modulus is None:
                raise InputError("slider.radius", "and effective_modulus are required with a normal law of one's own")
            _ = self._table
        elif self.normal_law.shape != self.shape:
            raise InputError(
                "slider.normal_law", f'must begin as the shape does, "{self.shape}"', self.normal_law.shape
            )
        refuse_if(
            np.ptp(self.normal_stiffness) > 0.0,
            "slider.radius",
            "must be equal for all contacts with a normal law of one's own",
        )
        rule = "must be left out with a normal law of one's own: it takes the pressure of a smooth contact"
        refuse_if(
            isinstance(self.friction, FallingFriction) and self.friction.high_pressure is not None,
            "slider.friction.high_pressure",
            rule,
        )

    def _check_adhesion(self):
        """Raise unless all balls have one radius and one height."""
        if not isinstance(self.adhesion, Adhesion):
            raise InputError("slider.adhesion", "must be an Adhesion", self.adhesion)
        if self.radius is None:
            raise InputError("slider.radius", "is required with slider.adhesion")
        refuse_if(
            np.ptp(self.radius) > 0.0 or np.ptp(self.normal_stiffness) > 0.0,
            "slider.radius",
            "must be equal for all contacts with slider.adhesion",
        )
        rule = "must all be 0 with slider.adhesion, and the curvature too: at rest all balls count as closed"
        refuse_if(not self.level, "slider.heights", rule)
        if not self.adhesion.holds:
            return
        model = f'with slider.adhesion.model = "{self.adhesion.model}"'
        refuse_if(self.effective_modulus is None, "slider.effective_modulus", f"is required {model}")
        refuse_if(self.normal_law is not None, "slider.normal_law", f"must be left out {model}")
        refuse_if(
            self.friction is not None, "slider.friction", f"must be left out {model}, which knows Coulomb's alone"
        )
        refuse_if(self.stick_band > 0.0, "slider.stick_band", f"must be 0 {model}", self.stick_band)
        refuse_if(float(np.max(self.weights)) != 1.0, "slider.weights", f"must be 1 {model}")
        self.adhesion.hold(float(np.max(self.radius)), self.effective_modulus)  # refuses a separation far below atoms'

    @property
    def contact_shape(self) -> int:
        """SPHERE or PUNCH of `contact.law.normal`."""
        return normal.SHAPES.index(self.shape)

    @cached_property
    def profile(self) -> normal.NormalLaw:
        """The normal law over the stiffness, in SI units."""
        own, unit = self.normal_law, self.stiffness_unit
        law = normal.LAWS[self.contact_shape] if own is None else self._table.law(unit)
        if self.adhesion is None:
            return law
        radius = float(np.max(self.radius))
        hold = self.adhesion.hold(radius, self.effective_modulus) if self.adhesion.holds else None
        smooth = float(normal.approach(self.preload / unit, law))
        if hold is not None and hold.unit < NEGLIGIBLE * smooth:
            hold = None  # its branches differ by less than rounding
        return law._replace(pull=self.adhesion.attraction(radius) / unit, hold=hold)

    @property
    def _table(self) -> TabulatedForce:
        """The table of the normal law; of a user's from a hundredth of the smooth approach up to 1000 times it."""
        if not isinstance(self.normal_law, UserForce):
            return self.normal_law
        rest = self.preload / self.stiffness_unit or 1.0
        smooth = float(normal.approach(rest, normal.LAWS[self.contact_shape]))
        # a power of 2, so that preloads of a sweep share tables
        unit = min(2.0 ** round(math.log2(smooth)), 1e-3 * float(np.max(self.radius)))
        return self.normal_law.table(self._contact, USER_START * unit, USER_END * unit)

    @property
    def profile_key(self) -> tuple:
        """What the `profile` is made of: sliders of one key have one law."""
        own = self.normal_law is None and self.adhesion is None
        return self.shape, self.normal_law, None if own else (self.stiffness_unit, self.profile.pull, self.profile.hold)

    @cached_property
    def _key(self) -> tuple:
        values = (getattr(self, each.name) for each in fields(self))
        return tuple(each.tobytes() if isinstance(each, np.ndarray) else each for each in values)

    def __eq__(self, other):
        return isinstance(other, Slider) and self._key == other._key

    def __hash__(self):
        return hash(self._key)

    def __getstate__(self):
        # without what was derived and kept: laws hold compiled functions, which cannot be pickled
        return {each.name: getattr(self, each.name) for each in fields(self)}

    @cached_property
    def even(self) -> bool:
        """True if all contacts have the same stiffnesses and the weight 1."""
        own = self.normal_stiffness, self.tangential_stiffness, self.weights
        return bool(np.max(self.weights) == 1.0) and all(np.ndim(each) == 0 or np.ptp(each) == 0.0 for each in own)

    @property
    def unit_mass(self) -> float:
        """Mass in kg of the units in which the solvers work; any number, here 1, for a slider of infinite mass."""
        return 1.0 if self.mass == math.inf else self.mass

    @property
    def count(self) -> int:
        """How many contacts have values of their own; 1 where all values are single numbers."""
        return max(1, *(np.size(getattr(self, name)) for name in OWN if getattr(self, name) is not None))

    @property
    def number(self) -> float:
        """Number of contacts of `count`, that of their weights."""
        return float(np.sum(self._each("weights", self.count)))

    @cached_property
    def stiffness_unit(self) -> float:
        """k_n of the stiffest contact, N/m^1.5 or N/m."""
        return float(np.max(self.normal_stiffness))

    @cached_property
    def slope_unit(self) -> float:
        """The largest `limit_slope`."""
        return float(np.max(self.limit_slope))

    @property
    def limit_slope(self):
        """C = mu k_n/k_t = mu E/4G, the slip limit over the approach; its maximum if mu depends on the pressure."""
        if isinstance(self.friction, UserLaw):
            return self._tried[1]
        if not isinstance(self.normal_stiffness, Derived):
            return self.friction_coefficient * self.normal_stiffness / self.tangential_stiffness
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
            return user_law(self.friction, self._contact, float(self.stiffness_unit))
        if self.friction is not None:
            radius = float(np.max(self.radius))
            area = math.pi * radius * (1.0 if self.contact_shape == Shape.SPHERE else radius)
            ratio, pressure = (self.effective_modulus / (4.0 * self.tangential_modulus), self.stiffness_unit / area)
            return self.friction.law(self.friction_coefficient, ratio, pressure)
        if self.law == "hysteretic" and self.slope_unit > 0.0:
            return hysteretic.mindlin_deresiewicz()
        kind = Tangential.RECIPROCAL if self.reciprocal else Tangential.ELASTIC
        return elastic.coulomb(Tangential.HYSTERETIC if self.law == "hysteretic" else kind)

    @property
    def _contact(self):
        return Contact(
            self.friction_coefficient, float(np.max(self.radius)), self.effective_modulus, self.tangential_modulus,
            float(self.contact_shape == Shape.PUNCH),
        )  # fmt: skip

    @property
    def _tried(self):
        return tried(self.friction, self._contact, float(self.stiffness_unit))

    def _in_si(self, limit_slope=None):
        """Problem of a contact for the law's functions with lengths in m, times in s and forces divided by K."""
        return SimpleNamespace(
            length=1.0, omega=1.0, friction=self.static_coefficient, normal=self.profile, law=self.tangential_law,
            limit_slope=self.slope_unit if limit_slope is None else limit_slope,
        )  # fmt: skip

    def static_friction(self, contacts: int) -> float:
        """Return the largest tangential force in N that the contacts hold under the preload without a wave."""
        if self.friction is None or not self.tangential_law.bent:
            return self.static_coefficient * (self.preload + self.attraction(contacts))
        return self.sliding_friction(contacts, 0.0)

    def sliding_friction(self, contacts: int, speed: float) -> float:
        """Return the friction force in N of contacts that slip at a speed in m/s under the preload without a wave."""
        law, si, z = self.tangential_law, self._in_si(), self.rest_approaches(contacts)
        return self.stiffness_unit * sum(float(law.sliding(si, each, speed)) for each in z if each > 0.0)

    def contact_radius(self, approach):
        """Return the radius in m of the contact circle at an approach in m, or at one of each contact.

        Of a sphere with a normal law of one's own, that of a circle with the same stiffness dP/dz = 2 E a.
        """
        if self.normal_law is None or self.shape == "punch":
            return normal.contact_radius(self._depths(approach), self.radius, self.contact_shape)
        rate = normal.slope(np.asarray(approach), self.profile)
        return self.stiffness_unit * rate / (2.0 * self._pressed_modulus)

    def pressure(self, approach):
        """Return the pressure in Pa at an approach in m, or at one of each contact.

        It is the maximum pressure of a sphere, 2 E a/(pi R), or the mean pressure of a punch, k_n z/(pi R^2), which is
        2 E z/(pi R) on a half-space. With a normal law of one's own it is 3 P/(2 pi a^2) and P/(pi R^2).
        """
        if self.radius is None:
            raise InputError("slider.radius", "is required for the pressure of the contacts")
        z = np.maximum(approach, 0.0)
        if self.normal_law is not None:
            radius, share = (self.radius, 1.0) if self.shape == "punch" else (self.contact_radius(z), 1.5)
            force = self.stiffness_unit * normal.load(z, self.profile)
            return share * force / (math.pi * np.maximum(radius, 1e-300) ** 2)
        length = z if self.shape == "punch" else self.contact_radius(z)
        pressure = 2.0 * self._pressed_modulus * length / (math.pi * self.radius)
        if self.profile.hold is None:
            return pressure
        depths = np.asarray(length) ** 2 / self.radius
        share = np.vectorize(lambda d: float(holding.suction(d, self.profile.hold)))(depths)
        return pressure - self.effective_modulus / (math.pi * math.sqrt(self.radius)) * share

    def _depths(self, approach):
        """Return the depths of closed contacts at approaches, which they are without adhesion that holds on."""
        hold = self.profile.hold
        return approach if hold is None else np.vectorize(lambda z: float(holding.depth(z, hold)))(approach)

    @property
    def _pressed_modulus(self):
        """E in Pa of the pressure under a contact; of given stiffnesses that of a punch of the radius."""
        if isinstance(self.normal_stiffness, Derived | DerivedArray):
            return self.effective_modulus
        return self.normal_stiffness / (2.0 * self.radius)

    def tangential_force(self, deformation, approach: float):
        """Return Q in N of the elastic law at deformations and an approach in m, limited by friction."""
        friction = self.friction_coefficient * self.normal_stiffness
        return elastic.tangential_force(deformation, self._depths(approach), friction, self.limit_slope, self.profile)

    def _each(self, name: str, contacts: int) -> np.ndarray:
        """Return a value of `OWN` for each of so many contacts."""
        value = getattr(self, name)
        if np.ndim(value) and len(value) != contacts:
            raise _other_number(name, contacts, len(value))
        return np.broadcast_to(value, (contacts,))

    def contacts(self, number: int) -> Contacts:
        """Return the values of so many contacts."""
        x, y, k_n, k_t, weight = (
            self._each(name, number) for name in ("x", "y", "normal_stiffness", "tangential_stiffness", "weights")
        )
        return Contacts(x, y, self.offsets(number), k_n, k_t, np.broadcast_to(self.limit_slope, (number,)), weight)

    def classes(self, also: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the contacts that stand for all that are equal to them, rows one after the other from left to right.

        Contacts of a row are at one x; equal ones also have the same height, stiffnesses and columns of ``also``, an
        array (k, n).

        Returns
        -------
        member : (m,) array
            A contact of each class.
        classes : (n,) array
            Number of each contact's class.
        row : (m,) array
            Number of each class's row.
        """
        x, _, heights, k_n, k_t, _, _ = self.contacts(also.shape[1])
        step = SAME_ROW * max(float(np.ptp(x)), 1e-300)
        position = np.round((x - x.min()) / step) if np.ptp(x) > 0.0 else np.zeros_like(x)
        # one column per contact, sorted by position first; equal columns are one class
        table = np.vstack([position, also, heights, k_n, k_t])
        order = np.lexsort(table[::-1])
        is_first = np.ones(x.size, dtype=bool)
        is_first[1:] = np.any(np.diff(table[:, order], axis=1) != 0.0, axis=0)
        classes = np.empty(x.size, dtype=int)
        classes[order] = np.cumsum(is_first) - 1
        member = order[is_first]
        return member, classes, np.unique(position[member], return_inverse=True)[1]

    def merged(self, member: np.ndarray, classes: np.ndarray) -> "Slider":
        """Return the same slider with one contact, of their weights, for the equal ones of each of its `classes`."""
        names = [name for name in OWN if np.ndim(getattr(self, name)) and np.size(getattr(self, name))]
        own = {name: getattr(self, name)[member] for name in names if name != "heights"}
        if isinstance(self.normal_stiffness, Derived | DerivedArray):
            own["normal_stiffness"] = own["tangential_stiffness"] = None
        weights = np.bincount(classes, self._each("weights", classes.size))
        return replace(self, curvature=0.0, **own | {"heights": self.offsets(classes.size)[member], "weights": weights})

    def contact_factors(self, contacts: int) -> np.ndarray:
        """Return weight times k_n over `stiffness_unit`, and c over `slope_unit`, of each contact, (2, contacts)."""
        if self.even:
            return np.ones((2, contacts))
        own, slope = self.contacts(contacts), self.slope_unit or 1.0
        return np.array([own.weight * (own.normal_stiffness / self.stiffness_unit), own.limit_slope / slope])

    @cached_property
    def level(self) -> bool:
        """True if all contacts have the height 0."""
        return not self.curvature and not np.any(self.heights)

    def offsets(self, contacts: int) -> np.ndarray:
        """Return the heights of the contacts on the slider's curved face as an array of that length, m."""
        heights = np.array(self._each("heights", contacts)) if np.size(self.heights) else np.zeros(contacts)
        if self.curvature:
            heights -= 0.5 * self.curvature * (self._each("x", contacts) ** 2 + self._each("y", contacts) ** 2)
        return heights

    def preload_point(self, load: float) -> tuple[float, float]:
        """Return where the preload acts together with a load in N along -x, m; raise if it lifts a side that may tilt.

        A load at a height b above the surface shifts the point by -b load/preload.
        """
        x, y = self.preload_at
        x -= self.load_height * load / self.preload if load else 0.0
        lifts = "" if self.tilt == "held" else self.lifts(x, y)
        if not lifts:
            return x, y
        rest = f"within the contacts unless the tilt is held, got ({x:g}, {y:g}) m: no equilibrium, the {lifts} lifts"
        if self.lifts(*self.preload_at):
            raise InputError("slider.preload_at", f"must lie {rest}")
        raise InputError("slider.load_height", f"must keep preload and load of {abs(load):.4g} N {rest}")

    def lifts(self, x: float, y: float) -> str:
        """Return which side lifts off under a force at (x, y), or an empty string where the contacts carry it."""
        if not self.x.min() < x < self.x.max():
            return "side at smaller x" if x >= self.x.max() else "side at larger x"
        if self.tilt != "free":
            return ""
        if not self.y.min() < y < self.y.max():
            return "side at smaller y" if y >= self.y.max() else "side at larger y"
        # within the convex hull: no direction in which all contacts lie behind the point
        angle = np.sort(np.arctan2(self.y - y, self.x - x))
        gaps = np.diff(np.append(angle, angle[0] + 2.0 * math.pi))
        if gaps.max() >= math.pi:
            towards = math.degrees(angle[int(gaps.argmax())] + 0.5 * gaps.max()) + 180.0
            return f"side at {towards % 360.0:.0f} degrees from the wave's direction"
        return ""

    def attraction(self, contacts: int) -> float:
        """Return the attraction in N of so many closed contacts; of those that hold on, under the preload at rest."""
        law, pull = self.profile, self.profile.pull
        if law.hold is not None:
            pull = attraction(self.depth_under(self.preload, contacts), pull, law.hold)
        if pull == 0.0:
            return 0.0
        return self.stiffness_unit * pull * float(np.sum(self.contact_factors(contacts)[0]))

    def depth_under(self, force: float, contacts: int) -> float:
        """Return the depth in m (`law.holding`) of each of so many equal contacts that carry a force in N together."""
        return float(holding.depth_under(force / self.stiffness_unit / contacts, self.profile.hold))

    def approach_under(self, force: float, contacts: int) -> float:
        """Return the approach in m of a contact of height 0 at which the contacts carry a normal force in N."""
        if self.profile.hold is not None:
            return float(holding.approach_at(self.depth_under(force, contacts), self.profile.hold))
        law, target = self.profile, (force + self.attraction(contacts)) / self.stiffness_unit
        if self.even and self.level:
            return float(normal.approach(target / contacts, law))
        heights, (share, _) = self.offsets(contacts), self.contact_factors(contacts)
        # both initial guesses are upper bounds: one takes all heights equal to the smallest, the other only the contact
        # with the largest height
        top = int(np.argmax(heights))
        h = float(min(normal.approach(target / np.sum(share), law) - min(heights),
                      normal.approach(target / share[top], law) - heights[top]))  # fmt: skip
        if target == 0.0:
            return h

        def sums(height):
            return tuple(float(np.sum(share * each(height + heights, law))) for each in (normal.load, normal.slope))

        return float(height_under(sums, target, h, 1e-15 * (abs(h) + float(np.max(np.abs(heights))))))

    def least_friction(self, contacts: int) -> float:
        """Return the least friction force in N of slipping contacts under the preload at speeds up to 10 m/s."""
        if self.friction is None:
            return self.static_friction(contacts)
        return min(self.sliding_friction(contacts, float(speed)) for speed in (0.0, *np.logspace(-4, 1, 21)))

    def rest_approach(self, contacts: int) -> float:
        """Return minus the slider's position under the preload without a wave, the approach of a height of 0, m."""
        if contacts not in self._at_rest:
            self._at_rest[contacts] = self.approach_under(self.preload, contacts)
        return self._at_rest[contacts]

    @cached_property
    def _at_rest(self) -> dict[int, float]:
        """The values of `rest_approach` by the number of contacts: a sweep asks for them at every point."""
        return {}

    def rest_approaches(self, contacts: int) -> np.ndarray:
        """Return the approach of each contact under the preload without a wave, m; zero if it does not touch."""
        return np.maximum(self.rest_approach(contacts) + self.offsets(contacts), 0.0)

    def rest_deformations(self, contacts: int) -> np.ndarray:
        """Return the deformations in m with which the contacts carry the load at rest, or slip if they cannot.

        Contacts that are sheared together by x carry Q = mu (P - P'), where P' is the normal force at an approach that
        is smaller by x/c (Ciavarella 1998; see `law.elastic`). Hence P' equals the preload less load/mu.
        """
        z, c, hold = self.rest_approaches(contacts), self.slope_unit, self.profile.hold
        if c == 0.0:
            return 0.0 * z
        if hold is not None:  # of the elastic part of the force, over the depth
            rest = self.depth_under(self.preload, contacts)
            carried = normal.load(rest, self.profile) - self.load / self.friction_coefficient / (
                self.stiffness_unit * contacts
            )
            return c * np.full(contacts, rest - float(normal.approach(max(carried, 0.0), self.profile)))
        if self.friction is not None or (np.ndim(self.limit_slope) and np.ptp(self.limit_slope) > 0.0):
            limits = self._slip_limits(z)
            if self.static_friction(contacts) <= self.load:
                return limits
            return np.minimum(-self.distance_to_rest(0.0 * z, self.load), limits)
        reduced = max(self.preload - self.load / self.friction_coefficient, -self.attraction(contacts))
        return c * np.minimum(z, self.rest_approach(contacts) - self.approach_under(reduced, contacts))

    def distance_to_rest(self, deformations: np.ndarray, load: float) -> float:
        """Return how far along +x a slider with these deformations in m comes to rest under a load along -x in N.

        Its contacts stick on the way, or slip at their limits. At rest the sum of Q(x_i - distance) is the load.
        """
        z, (share, slopes) = self.rest_approaches(len(deformations)), self.contact_factors(len(deformations))
        touching = np.flatnonzero(z)
        x, limits = deformations[touching], self._slip_limits(z)[touching]
        contacts = [self._in_si(slopes[i] * self.slope_unit) for i in touching]

        def unbalanced(distance):
            at_rest = np.clip(x - distance, -limits, limits)
            forces = (
                share[i] * np.sign(b) * float(si.law.stuck(si, z[i], abs(b)))
                for i, si, b in zip(touching, contacts, at_rest, strict=True)
            )
            return self.stiffness_unit * sum(forces) - load

        return bracketed(unbalanced, float(np.min(x - limits)), float(np.max(x + limits)))

    def _slip_limits(self, z):
        """Return the slip limit in m of each contact at its approach; 0 if it does not touch."""
        contacts = (self._in_si(factor * self.slope_unit) for factor in self.contact_factors(len(z))[1])
        return np.array(
            [float(slip_limit(si, each)) if each > 0.0 else 0.0 for si, each in zip(contacts, z, strict=True)]
        )

    def normal_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of the bounce at rest, sqrt(sum dP/dz / m)/2 pi."""
        if contacts not in self._bounces:
            self._bounces[contacts] = math.sqrt(self._spring(contacts, None) / self.mass) / (2.0 * math.pi)
        return self._bounces[contacts]

    @cached_property
    def _bounces(self) -> dict[int, float]:
        """The values of `normal_resonance` by the number of contacts, as `_at_rest`."""
        return {}

    def tangential_resonance(self, contacts: int) -> float:
        """Return the frequency in Hz of a small tangential ring at rest, sqrt(sum k_t dp/dz/m)/2 pi; 8 a G for one."""
        ratio = self.tangential_stiffness / self.normal_stiffness
        return math.sqrt(self._spring(contacts, ratio) / self.mass) / (2.0 * math.pi)

    def _spring(self, contacts, ratio):
        """Return the sum of the contacts' normal springs at rest, each times a ratio (None for none), N/m.

        A ratio is that of a tangential spring; the normal one of contacts that hold on feels their attraction too.
        """
        hold = self.profile.hold
        if hold is not None:
            d = self.depth_under(self.preload, contacts)
            each = holding.stiffness(d, hold) if ratio is None else ratio * normal.slope(d, self.profile)
            return self.stiffness_unit * contacts * float(each)
        ratio = 1.0 if ratio is None else ratio
        each = normal.slope(self.rest_approach(contacts) + self.offsets(contacts), self.profile)
        return self.stiffness_unit * float(np.sum(self.contact_factors(contacts)[0] * ratio * each))


def _on_a_line(x, y):
    """Return True if all positions lie on one line, or at one place."""
    x, y = np.broadcast_arrays(np.atleast_1d(x), np.atleast_1d(y))
    widths = np.linalg.svd(np.array([x - x.mean(), y - y.mean()]), compute_uv=False)
    return bool(widths[-1] <= 1e-9 * widths[0]) or widths.size < 2


def _other_number(name, contacts, got) -> InputError:
    return InputError(f"slider.{name}", f"must hold one {OWN[name][0]} per contact, {contacts}", got)


def _own_values(name, value, unit, placed):
    """Return a value of `OWN` as a float, or as a read-only array with one number for each contact."""
    rule = parameter_check.finite if name in ANY_SIGN else parameter_check.positive
    if np.ndim(value) == 0:
        value = rule(f"slider.{name}", value, unit)
        return value if placed is None else np.broadcast_to(value, (placed,))
    array = np.array(value, dtype=float)
    if array.ndim > 1 or array.size != (placed or array.size) or (array.size == 0 and name != "heights"):
        raise _other_number(name, placed or "at least 1", array.size)
    right = np.isfinite(array) if name in ANY_SIGN else np.isfinite(array) & (array > 0.0)
    if not right.all():
        rule(f"slider.{name}", float(array[~right][0]), unit)
    array.flags.writeable = False
    return array
