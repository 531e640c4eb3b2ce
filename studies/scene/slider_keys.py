"""The block of a scene's slider, with its damping."""

import math
from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

from studies.scene import plane_keys
from studies.scene.adhesion_keys import Adhesion, NormalLawText
from studies.scene.block import Block, Within, keys_of
from studies.scene.friction import Friction, LawFile, LawText
from studies.scene.numbers import FixedList, Listed, Quantity, as_pair, surface_position
from studies.scene.pillar_keys import Pillars
from studies.scene.roughness_keys import Roughness
from studies.scene.rule import FLAG, TEXT, Count, choice

OFFSET = FixedList((Quantity("m", negative=True),) * 2, "[x, y] in m")
# what rough balls do not know, and why
STOP_OF_EACH = "each asperity slips by Coulomb's law"
WITHOUT_ROUGHNESS = {
    "law": STOP_OF_EACH, "friction_coefficient": STOP_OF_EACH,
    "method": "its steady velocities are averaged ones",
    "freedom": "rough balls move along x alone",
    "reciprocal": "the force of an asperity on its neighbours is not a reciprocal one",
    "stick_band": STOP_OF_EACH,
    "heights": "each rough ball carries an equal part of the preload, whatever its height",
    "normal_law": "it is a normal law itself",
    "adhesion": "the attraction between rough surfaces is not computed (the budget says how much of it is left)",
}  # fmt: skip
ALONE = ("radius", "contacts", "heights", "normal_law", "adhesion")  # keys that pillars replace


@dataclass(frozen=True, kw_only=True)
class Damping(Block):
    """Losses of the slider's motion; the viscous ones are totals of the slider."""

    block: ClassVar[str] = "slider.damping"
    contact: Annotated[
        float,
        Quantity("s/m", zero=True),
        "Hunt-Crossley coefficient chi: the force chi P dz/dt during contact (R_n1 of Feenstra and Breedveld).",
    ] = 0.0
    normal: Annotated[
        float,
        Quantity("N s/m", zero=True),
        "Viscous damping of the slider's velocity along z (R_n2 of Feenstra and Breedveld).",
    ] = 0.0
    tangential: Annotated[
        float,
        Quantity("N s/m", zero=True),
        "Viscous damping of the slider's velocity along x (R_t of Feenstra and Breedveld).",
    ] = 0.0


@dataclass(frozen=True, kw_only=True)
class Slider(Block):
    """A rigid slider on balls or flat punches; mass, forces and viscous dampers are totals.

    Keys that depend on the kind of contact, such as ``radius`` and ``pillars``, are None where they are absent; their
    types are written Any, as those of the blocks of a scene.
    """

    block: ClassVar[str] = "slider"
    parameters_of = "contact.SliderRules"
    keys: ClassVar[dict[str, str]] = {"friction": "friction_coefficient"}
    position: Annotated[
        float | tuple[float, float] | Any,
        surface_position(),
        "Position of the slider's centre: x from the left end of the stator, or [x, y] with y from the middle line."
        " Required with a stator; absent with [wave].",
    ] = None
    shape: Annotated[
        str,
        choice("sphere", "punch"),
        "Shape of each contact. sphere: a ball; punch: a rigid flat cylinder, P = 2 a E* z, which slips as a whole.",
    ] = "sphere"
    radius: Annotated[float | Any, Quantity("m"), "Radius of each ball or punch; required without pillars."] = None
    mass: Annotated[float, Quantity("kg"), "Mass of the whole slider."]
    contacts: Annotated[
        int | tuple[float | tuple[float, float], ...] | None,
        Count(10_000) | Listed(surface_position(negative=True), distinct=True),
        "Positions of the balls relative to the slider's centre: a list of x or [x, y]; or the number of balls, all"
        " at the centre. Required without pillars.",
    ] = None
    heights: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("m", negative=True)),
        "Distance by which each contact projects towards the stator, one value for each position in contacts. "
        "Absent: all equal.",
    ] = None
    preload: Annotated[
        float | str,
        Quantity("N", zero=True) | choice("weight"),
        "Total normal force, including the weight of the slider. weight: mass times gravity.",
    ]
    gravity: Annotated[
        float, Quantity("m/s^2", zero=True), 'Acceleration of gravity; used only if preload is "weight".'
    ] = 9.81
    load: Annotated[
        float | tuple[float, float],
        Quantity("N", zero=True) | plane_keys.VECTOR,
        "Constant force opposite to the direction in which the unloaded slider moves or, where it rests, would start; "
        "in the plane also [F_x, F_y], against +x and +y.",
    ] = 0.0
    freedom: Annotated[
        str,
        choice(*plane_keys.FREEDOMS),
        "Motion along the surface. x: along x alone; xy: in the plane, without turning; xy yaw: it also turns about z; "
        "axle: it turns about slider.axis, which sets it.",
    ] = "x"
    axis: Annotated[
        tuple[float, float] | None,
        OFFSET,
        "An axle about which the slider turns, [x, y] from its centre. Absent: the motion of freedom.",
    ] = None
    inertia: Annotated[
        float | None,
        Quantity("kg m^2"),
        "Moment of inertia about the slider's centre, or about its axle. Absent: that of its mass at the contacts.",
    ] = None
    torque: Annotated[
        float,
        Quantity("N m", negative=True),
        "Constant torque against a slider that turns, positive against turning from x to y.",
    ] = 0.0
    incline: Annotated[
        tuple[float, float] | None,
        plane_keys.SLOPES,
        "Slope of the surface along x and y, positive where it rises and the weight pulls back. Absent: level.",
    ] = None
    friction_coefficient: Annotated[
        float | Friction,
        Quantity(zero=True) | Within(Friction),
        "Coulomb's coefficient mu of ball and stator, or a table of its dependence on slip speed and pressure, such"
        ' as { static = 0.3, sliding = 0.15, speed = "0.05 m/s" }.',
    ]
    effective_modulus: Annotated[
        float | Any, Quantity("Pa"), "E* of the two bodies, 1/E* = sum of (1 - nu^2)/E; required unless ball is given."
    ] = None
    tangential_modulus: Annotated[
        float | Any, Quantity("Pa"), "G* of the two bodies, 1/G* = sum of (2 - nu)/G; required unless ball is given."
    ] = None
    ball: Annotated[
        str | None, TEXT, 'Material of the balls, such as "steel", from which both moduli follow; not with [wave].'
    ] = None
    law: Annotated[
        str | LawText | Any,
        choice("elastic", "hysteretic") | LawFile() | Within(LawText),
        "Tangential contact law. elastic: eq. 2 of Feenstra and Breedveld; hysteretic: Mindlin and Deresiewicz, "
        "with memory; or a Python file with a user's law (contact/README.md). Absent: elastic; with roughness "
        "hysteretic, that of asperities that draw each other along.",
    ] = None
    normal_law: Annotated[
        NormalLawText | None,
        LawFile(NormalLawText) | Within(NormalLawText),
        "A Python file with the normal force of a contact over its approach from first touch, force(approach, contact) "
        "(contact/README.md). Absent: that of a smooth ball or punch.",
    ] = None
    adhesion: Annotated[
        Adhesion | None,
        Within(Adhesion),
        'Attraction of balls in contact, such as { work = "0.05 J/m^2", model = "DMT" } or { surface_tension = '
        '"0.072 N/m", model = "meniscus" }. Absent: none.',
    ] = None
    reciprocal: Annotated[
        bool, FLAG, "true: the tangential spring also acts on the normal motion, so that energy is conserved."
    ] = False
    stick_band: Annotated[
        float,
        Quantity("m/s", zero=True),
        "Slip speed below which the contact is taken to stick (DV of Feenstra and Breedveld).",
    ] = 0.0
    method: Annotated[
        str,
        choice("auto", "exact", "stepped", "averaged"),
        "Integration of the slider's motion. exact: from event to event; stepped: fixed time steps; averaged: over "
        "cycles of the wave; auto: selected by error and cost.",
    ] = "auto"
    travel: Annotated[
        bool | None,
        FLAG,
        "true: in a burst the slider is followed on the wave at its own place, up to fingers, a piece or the stator's "
        "end; false: the wave stays that at slider.position. Absent: true if the slider travels more than a tenth of a "
        "wavelength.",
    ] = None
    damping: Annotated[Damping, Within(Damping), "Damping of the slider's motion."] = Damping()
    pillars: Annotated[
        Pillars | Any, Within(Pillars), "Flat pillars, up to a million, instead of radius, contacts and heights."
    ] = None
    roughness: Annotated[
        Roughness | Any, Within(Roughness), 'Roughness of the balls, such as { rms = "3 nm" }. Absent: smooth balls.'
    ] = None
    tilt: Annotated[
        str,
        choice("held", "pitch", "free"),
        "Rotations of a slider on pillars, or in the plane. held: none; pitch: about y; free: about x and y.",
    ] = "held"
    preload_at: Annotated[
        tuple[float, float], OFFSET, "Point of action of the preload on a slider on pillars, [x, y] from its centre."
    ] = (0.0, 0.0)
    load_height: Annotated[
        float, Quantity("m", zero=True), "Height above the surface at which the load acts on a slider on pillars."
    ] = 0.0
    backing: Annotated[
        str,
        choice("rigid", "soft"),
        "Support of the pillars. rigid: their bases stay in one plane; soft: each row along the wave carries the "
        "same pressure.",
    ] = "rigid"
    loading: Annotated[
        bool | str | None,
        FLAG | choice("harmonics"),
        "true: pillars change the wave; false: they do not; harmonics: they change it and generate its overtones. "
        "Absent: true if the loading number exceeds 0.05.",
    ] = None

    def __post_init__(self) -> None:
        if self.axis is not None and self.freedom == "x":
            object.__setattr__(self, "freedom", plane_keys.AXLE)
        super().__post_init__()

    def check_contacts(self) -> Any:
        if self.pillars is None:
            for key in ALONE[:2]:
                if getattr(self, key) is None:
                    yield key, f"is required and missing: give {keys_of(Slider)[key].rule.expected}"
            for key in ("loading", "tilt", "preload_at", "load_height", "backing"):
                if getattr(self, key) != keys_of(Slider)[key].default and not (key == "tilt" and self.planar):
                    yield key, "must be absent without [slider.pillars]"
            return
        for key in ALONE:
            if getattr(self, key) is not None:
                yield key, "must be absent with [slider.pillars], which define the contacts"
        if self.tangential_law != "elastic":
            yield "law", 'must be "elastic" with [slider.pillars]: a flat pillar slips as a whole'
        if isinstance(self.friction_coefficient, Friction):
            yield "friction_coefficient", "must be a number with [slider.pillars]"
        if self.stick_band > 0:
            yield "stick_band", f"must be absent with [slider.pillars], got {self.stick_band:g} m/s"
        if self.method not in ("auto", "averaged"):
            yield "method", f'must be "auto" or "averaged" with [slider.pillars], got "{self.method}"'
        if self.travel:
            yield "travel", "must be false or absent with [slider.pillars]"
        if self.backing == "soft" and self.loading == "harmonics":
            yield "loading", 'must be true or false where slider.backing is "soft"'

    def check_plane(self) -> Any:
        yield from plane_keys.check_slider(self)

    def check_roughness(self) -> Any:
        if self.roughness is None:
            return
        if self.pillars is not None or self.shape != "sphere":
            yield "roughness", "is that of balls, which this slider has not"
        other = {
            "law": isinstance(self.law, LawText),
            "friction_coefficient": isinstance(self.friction_coefficient, Friction),
            "method": self.method not in ("auto", "averaged"),
            "freedom": self.freedom != "x",
        } | {key: bool(getattr(self, key)) for key in ("reciprocal", "stick_band", "heights", "normal_law", "adhesion")}
        for key in (key for key, wrong in other.items() if wrong):
            yield key, f"does not go with slider.roughness: {WITHOUT_ROUGHNESS[key]}"

    def check_holding(self) -> Any:
        if self.adhesion is None or not self.adhesion.holds:
            return
        other = {
            "law": isinstance(self.law, LawText),
            "friction_coefficient": isinstance(self.friction_coefficient, Friction),
        } | {key: bool(getattr(self, key)) for key in ("stick_band", "normal_law")}
        for key in (key for key, wrong in other.items() if wrong):
            model = f'slider.adhesion.model = "{self.adhesion.model}"'
            yield key, f"does not go with {model}, which knows smooth balls with Coulomb's friction alone"

    def check_friction(self) -> Any:
        if isinstance(self.friction_coefficient, Friction) and isinstance(self.law, LawText):
            yield "friction_coefficient", "must be a number with a law of one's own"

    @property
    def special_friction(self) -> str:
        """What the friction depends on beside the normal force, in words; empty for Coulomb's law."""
        if isinstance(self.friction_coefficient, Friction):
            return "a table of friction_coefficient"
        return "a law of one's own" if isinstance(self.law, LawText) else ""

    def check_heights(self) -> Any:
        if self.heights is None:
            return
        if self.adhesion is not None:
            yield "heights", "must be absent with slider.adhesion: at rest all balls count as closed, and some may hang"
        number = 0 if self.contacts is None or isinstance(self.contacts, int) else len(self.contacts)
        if number == 0:
            yield "heights", "needs slider.contacts as a list of positions, one per height"
        elif number != len(self.heights):
            yield "heights", f"must hold one height for each of the {number} contacts, got {len(self.heights)}"

    def check_moduli(self) -> Any:
        for key in ("effective_modulus", "tangential_modulus"):
            if self.ball is not None and getattr(self, key) is not None:
                yield "ball", f"must not be given together with slider.{key}: they follow from the ball"
            if self.ball is None and getattr(self, key) is None:
                yield key, 'is required and missing: give both moduli in Pa, or ball = "steel" instead'

    @property
    def planar(self) -> bool:
        """Whether it moves in the plane or turns, and not along x alone."""
        return self.freedom != "x"

    @property
    def turns(self) -> bool:
        """Whether it turns about z."""
        return self.freedom in ("xy yaw", plane_keys.AXLE)

    @property
    def scalar_load(self) -> float:
        """The load as a number in N: of a vector its size."""
        return math.hypot(*self.load) if isinstance(self.load, tuple) else self.load

    @property
    def along_x(self) -> "Slider":
        """The slider kept to x and without a load, for estimates; itself where it moves along x alone."""
        if not self.planar:
            return self
        return replace(self, freedom="x", axis=None, inertia=None, torque=0.0, incline=None, load=0.0, tilt="held")

    @property
    def opposes(self) -> bool:
        """Whether its load is a number, which acts against its motion, and not zero."""
        return not isinstance(self.load, tuple) and self.load != 0.0

    @property
    def static_coefficient(self) -> float:
        """The friction coefficient at rest."""
        friction = self.friction_coefficient
        return friction.static if isinstance(friction, Friction) else friction

    @property
    def tangential_law(self) -> "str | LawText":
        """The tangential law: the given one, or what its absence says."""
        return self.law or ("elastic" if self.roughness is None else "hysteretic")

    @property
    def remembers(self) -> bool:
        """Whether the law has a memory."""
        return self.tangential_law == "hysteretic"

    @property
    def preload_force(self) -> float:
        """Total normal force in N, the weight included."""
        return self.mass * self.gravity if isinstance(self.preload, str) else self.preload

    @property
    def offsets(self) -> tuple[tuple[float, float], ...]:
        """Positions (x, y) of the contacts from the slider's centre, m; a mere number of contacts is at the centre."""
        if self.contacts is None:  # pillars: the wave is computed at the centre and propagated from there
            return ((0.0, 0.0),)
        if isinstance(self.contacts, int):
            return ((0.0, 0.0),) * self.contacts
        return tuple(map(as_pair, self.contacts))

    @property
    def share(self) -> int:
        """Number of contacts that each computed contact represents: all, if only their number is specified."""
        return self.contacts if isinstance(self.contacts, int) else 1

    @property
    def computed_contacts(self) -> int:
        """Number of contacts that are computed."""
        return len(self.offsets) // self.share

    @property
    def center(self) -> tuple[float, float]:
        """Position (x, y) of the slider's centre on the stator, m."""
        return as_pair(self.position)

    @property
    def stands_on(self) -> str:
        """Kind of the contacts, "balls" (which may be flat) or "pillars"."""
        return "balls" if self.pillars is None else "pillars"

    @property
    def contact_positions(self) -> tuple[tuple[float, float], ...]:
        """Different positions (x, y) of the contacts on the stator, m."""
        x, y = self.center
        return tuple((x + along, y + across) for along, across in dict.fromkeys(self.offsets))
