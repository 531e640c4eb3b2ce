"""The blocks of a scene: stator, transducers, drive, given wave and slider, in the words of the scene file.

Everything is in SI units once read.  Amplitudes and voltages are peak values, x runs along the surface from the
stator's left end, z out of the surface.  The sentence beside each key is its entry in ``studies/scenes/README.md``.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from studies.refusal import SceneError, nearest, shown
from studies.scene.block import Block, OneOf, Within
from studies.scene.match import Match
from studies.scene.rule import (
    Choice,
    Count,
    Flag,
    Impedance,
    Listed,
    Matrix,
    Place,
    Quantity,
    Rule,
    Signs,
    Text,
    as_pair,
)
from studies.scene.sources import Sources

MIN_WIDTH = 1e-3  # of a finger or a gap, relative to the pitch; narrower ones take ever finer elements
ORIENTATIONS = ("Z", "X", "YZ", "128YX", "ST-X")


@dataclass(frozen=True, kw_only=True)
class PiezoelectricSolid(Block):
    """A table of constants in the crystal frame; Voigt order 11 22 33 23 13 12, engineering shear strain."""

    block: ClassVar[str] = "stator.material"
    name: Annotated[str, Text(), "Name shown on results."] = "user's table"
    stiffness: Annotated[tuple, Matrix(6, 6), "Stiffness at constant electric field c^E, in Pa."]
    coupling: Annotated[tuple, Matrix(3, 6), "Piezoelectric stress constants e, in C/m^2."]
    permittivity: Annotated[
        tuple, Matrix(3, 3), "Permittivity at constant strain eps^S, relative to that of vacuum."
    ]
    density: Annotated[float, Quantity("kg/m^3"), "Density."]
    mechanical_quality: Annotated[
        float | None, Quantity(), "Mechanical quality factor Q: c (1 + i/Q). Absent: no mechanical loss."
    ] = None
    dielectric_loss: Annotated[
        float | None, Quantity(zero=True), "Loss tangent: eps (1 - i tan delta). Absent: no dielectric loss."
    ] = None


@dataclass(frozen=True, kw_only=True)
class IsotropicSolid(Block):
    """An isotropic solid; no electric field is solved for."""

    block: ClassVar[str] = "stator.material"
    name: Annotated[str, Text(), "Name shown on results."] = "user's isotropic solid"
    youngs_modulus: Annotated[float, Quantity("Pa"), "Young's modulus."]
    poisson_ratio: Annotated[float, Quantity(negative=True, below=0.5), "Poisson's ratio, above -1."]
    density: Annotated[float, Quantity("kg/m^3"), "Density."]
    mechanical_quality: Annotated[
        float | None, Quantity(), "Mechanical quality factor Q: c (1 + i/Q). Absent: no loss."
    ] = None

    def contradictions(self, unread):
        """Keep the solid stable."""
        if "poisson_ratio" not in unread and self.poisson_ratio <= -1:
            yield self.refusal("poisson_ratio", f"must be above -1 and below 0.5, got {self.poisson_ratio!r}")


@dataclass(frozen=True)
class Orientation(Rule):
    """A named cut, or three angles in degrees: z-x-z, passive."""

    def read(self, path, value):
        """Return the word or a tuple of three angles."""
        if isinstance(value, (list, tuple)):
            if len(value) != 3:
                self._refuse(path, value)
            return self.read_each(Quantity(negative=True), path, value)
        if value not in ORIENTATIONS:
            self._refuse(path, value)
        return value

    def written(self, value):
        return list(value) if isinstance(value, tuple) else value

    @property
    def expected(self):
        return f"{', '.join(ORIENTATIONS)} or three angles [phi, theta, psi] in degrees"

    def schema(self):
        angles = {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3}
        return {"anyOf": [{"enum": list(ORIENTATIONS)}, angles]}

    def _refuse(self, path, value):
        hint = nearest(value, ORIENTATIONS) if isinstance(value, str) else ""
        raise SceneError(path, f"must be {self.expected}, got {shown(value)}{hint if 'mean' in hint else ''}")


@dataclass(frozen=True, kw_only=True)
class Stator(Block):
    """The block of material that carries the wave; a vertical section of it is modelled."""

    block: ClassVar[str] = "stator"
    material: Annotated[
        str | PiezoelectricSolid | IsotropicSolid,
        OneOf(Text(), (PiezoelectricSolid, IsotropicSolid)),
        "A name of the catalogue below, or a table of constants.",
    ]
    orientation: Annotated[
        str | tuple,
        Orientation(),
        "Z: poled along the normal; X: poled along x; a crystal cut; or Euler angles in degrees (z-x-z, passive).",
    ] = "Z"
    length: Annotated[float, Quantity("m"), "Along x, the direction of propagation."]
    thickness: Annotated[
        float | str, Quantity("m", words=("half-space",)), "Along z; half-space: exactly absorbing below."
    ]
    width: Annotated[
        float,
        Quantity("m"),
        "Along y. Drawn, compared with the apertures, and the distance of the side faces.",
    ]
    bottom: Annotated[
        str,
        Choice(("free", "grounded", "clamped", "absorbing")),
        "free: no traction, D_n = 0; grounded: no traction, phi = 0; clamped: u = 0, D_n = 0; or no reflection.",
    ] = "free"
    ends: Annotated[
        str,
        Choice(("absorbing", "free", "clamped")),
        "absorbing: the section continues without end; free: no traction, D_n = 0; clamped: u = 0, D_n = 0.",
    ]
    above: Annotated[
        str,
        Choice(("none", "vacuum")),
        "none: D_n = 0 on the bare surface; vacuum: the field above is solved for.",
    ] = "none"
    diffraction: Annotated[
        bool | None,
        Flag(),
        "true: the finite aperture spreads the beam; false: plane section. "
        "Absent: true under a slider in solids isotropic about z with absorbing ends.",
    ] = None
    sides: Annotated[
        str,
        Choice(("absorbing", "mirror")),
        "Side faces y = +-width/2 under diffraction. absorbing: none; mirror: they reflect everything.",
    ] = "absorbing"
    mechanical_quality: Annotated[
        float | None, Quantity(), "Mechanical quality factor Q in place of the material's own."
    ] = None
    dielectric_loss: Annotated[
        float | None, Quantity(zero=True), "Loss tangent in place of the material's own; 0: lossless."
    ] = None

    @property
    def mirror_width(self) -> float | None:
        """Distance of the side faces in m where they reflect."""
        return self.width if self.sides == "mirror" else None

    def contradictions(self, unread):
        """Refuse a dielectric loss where there is no field, and side faces in a plane section."""
        if self.sides == "mirror" and self.diffraction is False:
            yield self.refusal("sides", "must be absorbing where stator.diffraction is false, got 'mirror'")
        if isinstance(self.material, IsotropicSolid) and self.dielectric_loss is not None:
            rule = "must be absent with an isotropic solid: no electric field is solved for"
            yield self.refusal("dielectric_loss", rule)


@dataclass(frozen=True, kw_only=True)
class Transducer(Block):
    """Two interleaved combs of fingers on the surface; the block is given once for each transducer."""

    block: ClassVar[str] = "transducer"
    name: Annotated[str, Text(), "Name by which the drive refers to it."]
    center: Annotated[
        float | tuple[float, float],
        Place(Quantity("m")),
        "Middle of its fingers, from the stator's left end, or [x, y], y from the stator's middle line.",
    ]
    finger_pairs: Annotated[int, Count(100_000), "Number of periods: 10 pairs are 20 fingers."]
    period: Annotated[
        float | str,
        Quantity("m", words=("auto", "half-space")),
        "Length of two fingers and two gaps, one wavelength; auto: that of the strongest surface wave per volt "
        "at drive.frequency, for these fingers alone; half-space: part metallised, without reflections.",
    ] = "auto"
    metallisation: Annotated[
        float, Quantity(below=1.0), "Width of a finger over the pitch (finger and gap), 0.001 to 0.999."
    ]
    aperture: Annotated[
        float,
        Quantity("m"),
        "Overlap of the fingers along y, at most the stator's width; scales the admittance.",
    ]
    termination: Annotated[
        str | float | complex,
        Impedance(("open", "short")),
        "When it is not the driven one. open: no net charge on either comb; short: both combs are one conductor.",
    ] = "open"
    pattern: Annotated[
        str | None,
        Signs("+-0o"),
        "One sign per finger, from left to right: + and - the combs, 0 left out, o an open strip. Absent: + - + - ...",
    ] = None
    split: Annotated[bool, Flag(), "true: four fingers per period, + + - -, instead of two."] = False
    angle: Annotated[
        float,
        Quantity("deg", negative=True),
        "By which it is turned about the surface normal, from x towards y. Turned transducers, and those beside the "
        "middle line, need a solid isotropic about z, absorbing ends and sides, and diffraction.",
    ] = 0.0

    def contradictions(self, unread):
        """Keep fingers and gaps of some width, one sign per finger, and at least one finger."""
        if "metallisation" not in unread and not MIN_WIDTH <= self.metallisation <= 1 - MIN_WIDTH:
            rule = f"must be between {MIN_WIDTH:g} and {1 - MIN_WIDTH:g}, got {self.metallisation!r}"
            yield self.refusal("metallisation", rule)
        if self.pattern is None or unread & {"pattern", "finger_pairs", "split"}:
            return
        if len(self.pattern) != self.fingers:
            each = "four" if self.split else "two"
            rule = f"must have {self.fingers} signs, {each} for each of the {self.finger_pairs} finger_pairs"
            yield self.refusal("pattern", f"{rule}, got {len(self.pattern)}: {shown(self.pattern)}")
        if set(self.pattern) == {"0"}:
            yield self.refusal("pattern", f"must leave at least one finger, got {shown(self.pattern)}")

    @property
    def place(self) -> tuple[float, float]:
        """Its middle (x, y) on the stator, m."""
        return as_pair(self.center)

    @property
    def turned(self) -> bool:
        """Whether its waves run along another line than the stator's middle."""
        return self.angle % 360 != 0 or self.place[1] != 0

    @property
    def fingers(self) -> int:
        """Places of fingers, those left out included."""
        return self.finger_pairs * (4 if self.split else 2)

    @property
    def has_two_combs(self) -> bool:
        """Whether a voltage can stand between its combs."""
        return self.pattern is None or {"+", "-"} <= set(self.pattern)


@dataclass(frozen=True, kw_only=True)
class Recovery(Block):
    """A receiving transducer whose load keeps the power, or feeds it back to the source in phase."""

    block: ClassVar[str] = "drive.recovery"
    receiver: Annotated[str, Text(), "Name of the transducer that receives; the load is its termination."]
    load: Annotated[
        str | float | complex,
        Impedance(("matched",)),
        "Across its electrodes; matched: the conjugate of the impedance that they show, at drive.frequency.",
    ] = "matched"
    rectifier: Annotated[
        float | None,
        Quantity("ohm"),
        "Instead of load: the resistance behind a full bridge with a capacitor, which is 8 / pi^2 of it.",
    ] = None
    efficiency: Annotated[
        float,
        Quantity(),
        "Power returned over power in the load, of rectifier and return path; above 1 with an amplifier in it.",
    ] = 1.0
    circulation: Annotated[
        bool,
        Flag(),
        "true: an ideal combiner adds the returned power to the source's, in phase; drive.voltage or power is that of "
        "both together, so that the motion is the same and the source gives less.",
    ] = False

    def contradictions(self, unread):
        """Ask for one load, with a resistance."""
        if unread & {"load", "rectifier"}:
            return
        if self.rectifier is not None and self.load not in ("matched", self.rectifier_load):
            yield self.refusal("load", "must be absent with drive.recovery.rectifier: it is the load")
        elif self.load != "matched" and not complex(self.load).real > 0:
            yield self.refusal(
                "load", f"must have a resistance, which takes the power, got {self.load!r} ohm"
            )

    @property
    def rectifier_load(self) -> float | None:
        """Resistance in ohm that stands for the rectifier, if there is one."""
        from fem import rectifier_resistance

        return None if self.rectifier is None else rectifier_resistance(self.rectifier)


@dataclass(frozen=True, kw_only=True)
class Drive(Block):
    """The source: its frequency and, with transducers, which one it drives at which peak voltages."""

    block: ClassVar[str] = "drive"
    frequency: Annotated[
        float | str,
        Quantity("Hz", words=("center",)),
        "Frequency of the source; center: that of the strongest surface wave per volt, for the driven fingers alone "
        "(needs a given period).",
    ]
    transducer: Annotated[
        str | None,
        Text(),
        "Name of the driven transducer; required when the scene has transducers, unless sources are given.",
    ] = None
    sources: Annotated[
        tuple[tuple[str, complex], ...] | None,
        Sources(),
        "Amplitude and phase of the source at each driven transducer, relative to the voltage; "
        "where given, it counts instead of transducer.",
    ] = None
    voltage: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("V", zero=True), ranged=True),
        "Peak voltage of the source, one value or a list; it or power is required when the scene has transducers.",
    ] = None
    power: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("W", zero=True), ranged=True),
        "Instead of voltage: what the sources can give to matched loads, V^2 / (8 R) each with source_impedance R.",
    ] = None
    burst: Annotated[
        float | None, Quantity("s"), "Length of the driven interval. Absent: the steady state only."
    ] = None
    source_impedance: Annotated[
        float | complex, Impedance(), "Impedance between each source and its transducer."
    ] = 0.0
    match: Annotated[
        str | tuple,
        Match(),
        "Network between each source and its transducer: the lossless L-section of least stored energy that delivers "
        "all available power at drive.frequency (auto), or elements from the source on, Q their quality there.",
    ] = "none"
    recovery: Annotated[
        Recovery | None, Within(Recovery), "What becomes of the power that another transducer receives."
    ] = None

    def contradictions(self, unread):
        """Ask for the level once; a power and a match need a source with a resistance."""
        resistance = 0.0 if "source_impedance" in unread else complex(self.source_impedance).real
        if "power" not in unread and self.power is not None:
            if "voltage" not in unread and self.voltage is not None:
                yield self.refusal("voltage", "must be absent with drive.power: it follows from the power")
            if resistance == 0 and "source_impedance" not in unread:
                rule = 'needs a drive.source_impedance with a resistance, such as "50 ohm", which limits the power'
                yield self.refusal("power", rule)
        if self.match == "auto" and "match" not in unread and "source_impedance" not in unread:
            if resistance == 0:
                rule = 'needs a drive.source_impedance with a resistance for "auto", such as "50 ohm"'
                yield self.refusal("match", rule)
            if "sources" not in unread and len(self.sources or ()) > 1:
                rule = 'must be "none" or a ladder with several sources: what each should see depends on the others'
                yield self.refusal("match", rule)

    def __post_init__(self):
        super().__post_init__()
        if self.sources is not None:  # they count; the first that is on is the one that reports are about
            first = next(name for name, amplitude in self.sources if amplitude)
            object.__setattr__(self, "transducer", first)

    @property
    def driven(self) -> dict[str, complex]:
        """Amplitude of the source at each driven transducer, relative to the voltage."""
        if self.sources is not None:
            return dict(self.sources)
        return {} if self.transducer is None else {self.transducer: 1.0}

    @property
    def levels(self) -> tuple[float, ...]:
        """Peak voltages of the source in V, those of the powers where these are given; empty without either."""
        if self.power is None:
            return self.voltage or ()
        squares = sum(abs(amplitude) ** 2 for amplitude in self.driven.values())
        per_watt = 8 * complex(self.source_impedance).real / squares
        return tuple((per_watt * power) ** 0.5 for power in self.power)


@dataclass(frozen=True, kw_only=True)
class Wave(Block):
    """A given surface motion: u_z and, a quarter period from it, u_x, which at the crest moves towards +x."""

    block: ClassVar[str] = "wave"
    frequency: Annotated[float, Quantity("Hz"), "Frequency of the motion."]
    normal_amplitude: Annotated[
        tuple[float, ...], Listed(Quantity("m", zero=True), ranged=True), "Peak of u_z, one value or a list."
    ]
    tangential_ratio: Annotated[float, Quantity(), "|u_x| / |u_z|."]
    burst: Annotated[
        float | None, Quantity("s"), "Length of the driven interval. Absent: the steady state only."
    ] = None


@dataclass(frozen=True, kw_only=True)
class Damping(Block):
    """Losses of the slider's motion; the viscous ones are totals of the slider."""

    block: ClassVar[str] = "slider.damping"
    contact: Annotated[
        float,
        Quantity("s/m", zero=True),
        "Hunt-Crossley coefficient chi: a force chi P dz/dt while in contact (R_n1 of Feenstra and Breedveld).",
    ] = 0.0
    normal: Annotated[
        float, Quantity("N s/m", zero=True), "Viscous, on the slider's normal velocity (R_n2 of the same)."
    ] = 0.0
    tangential: Annotated[
        float, Quantity("N s/m", zero=True), "Viscous, on the slider's velocity along x (R_t of the same)."
    ] = 0.0


UNDAMPED = Damping()


@dataclass(frozen=True, kw_only=True)
class Slider(Block):
    """A rigid slider on balls or flat punches; mass, forces and viscous dampers are totals."""

    block: ClassVar[str] = "slider"
    position: Annotated[
        float | tuple[float, float] | None,
        Place(Quantity("m")),
        "Of its centre, from the stator's left end, or [x, y], y from the middle of the apertures; "
        "required with a stator, absent with a given wave.",
    ] = None
    shape: Annotated[
        str,
        Choice(("sphere", "punch")),
        "Of each contact. punch: a rigid flat cylindrical projection, P = 2 a E* z, which slips as a whole.",
    ] = "sphere"
    radius: Annotated[float, Quantity("m"), "Radius of each ball or punch."]
    mass: Annotated[float, Quantity("kg"), "Mass of the whole slider."]
    contacts: Annotated[
        int | tuple[float | tuple[float, float], ...],
        Listed(Place(Quantity("m", negative=True)), alone=Count(10_000), distinct=True),
        "Places of the balls from the slider's centre, as a list of x or [x, y]; "
        "or a number of balls that all stand at its centre.",
    ]
    heights: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("m", negative=True)),
        "How much further each contact stands out towards the stator, one per place in contacts; absent: all alike.",
    ] = None
    preload: Annotated[
        float | str, Quantity("N", zero=True, words=("weight",)), "Total normal force, the weight included."
    ]
    gravity: Annotated[float, Quantity("m/s^2", zero=True), 'Used by preload = "weight".'] = 9.81
    load: Annotated[
        float,
        Quantity("N", zero=True),
        "Constant force against the direction in which the unloaded slider moves.",
    ] = 0.0
    friction_coefficient: Annotated[
        float, Quantity(zero=True), "Coulomb's coefficient mu of ball and stator."
    ]
    effective_modulus: Annotated[
        float | None,
        Quantity("Pa"),
        "E* of the pair, 1/E* = sum of (1 - nu^2)/E; required unless ball is given.",
    ] = None
    tangential_modulus: Annotated[
        float | None,
        Quantity("Pa"),
        "G* of the pair, 1/G* = sum of (2 - nu)/G; required unless ball is given.",
    ] = None
    ball: Annotated[
        str | None,
        Text(),
        'Instead of both moduli: the material of the balls, such as "steel"; not with a given wave.',
    ] = None
    law: Annotated[
        str,
        Choice(("elastic", "hysteretic")),
        "Tangential law. elastic: eq. 2 of Feenstra and Breedveld; hysteretic: Mindlin-Deresiewicz, with memory.",
    ] = "elastic"
    reciprocal: Annotated[
        bool,
        Flag(),
        "true: the tangential spring acts back on the normal motion, which closes the energy balance.",
    ] = False
    stick_band: Annotated[
        float,
        Quantity("m/s", zero=True),
        "Slip slower than this counts as sticking (DV of Feenstra and Breedveld).",
    ] = 0.0
    method: Annotated[
        str, Choice(("auto", "exact", "stepped", "averaged")), "How the slider's motion is integrated."
    ] = "auto"
    travel: Annotated[
        bool | None,
        Flag(),
        "Whether the orbits change with the slider's place during a burst. "
        "Absent: true where it travels more than a tenth of a wavelength.",
    ] = None
    damping: Annotated[Damping, Within(Damping), "Losses of the slider's motion."] = UNDAMPED

    def contradictions(self, unread):
        """Ask for the moduli once, by value or by the ball's material; refuse what no contact can be."""
        if not {"shape", "law"} & unread and self.shape == "punch" and self.law == "hysteretic":
            yield self.refusal("law", 'must be "elastic" with shape = "punch", which slips as a whole')
        if self.heights is not None and not {"heights", "contacts"} & unread:
            number = 0 if isinstance(self.contacts, int) else len(self.contacts)
            if number == 0:
                yield self.refusal("heights", "needs slider.contacts as a list of places, one per height")
            elif number != len(self.heights):
                rule = f"must hold one height for each of the {number} contacts, got {len(self.heights)}"
                yield self.refusal("heights", rule)
        for key in sorted({"effective_modulus", "tangential_modulus"} - unread):
            if self.ball is not None and getattr(self, key) is not None:
                yield self.refusal(
                    "ball", f"must not be given together with slider.{key}: they follow from the ball"
                )
            if self.ball is None and getattr(self, key) is None:
                yield self.refusal(
                    key, 'is required and missing: give both moduli in Pa, or ball = "steel" instead'
                )

    @property
    def preload_force(self) -> float:
        """Total normal force in N, the weight included."""
        return self.mass * self.gravity if self.preload == "weight" else self.preload

    @property
    def offsets(self) -> tuple[tuple[float, float], ...]:
        """Places (x, y) of the contacts from the slider's centre in m; a mere number of them sits at the centre."""
        if isinstance(self.contacts, int):
            return ((0.0, 0.0),) * self.contacts
        return tuple(map(as_pair, self.contacts))

    @property
    def center(self) -> tuple[float, float]:
        """Place (x, y) of the slider's centre on the stator, m."""
        return as_pair(self.position)

    @property
    def places(self) -> tuple[tuple[float, float], ...]:
        """Different places (x, y) of the contacts on the stator, m."""
        x, y = self.center
        return tuple((x + along, y + across) for along, across in dict.fromkeys(self.offsets))
