"""The blocks of a scene that the wave runs on: stator, materials, transducers and meshed pieces.

Everything is in SI units once read.  x runs along the surface from the
stator's left end, z out of the surface.  The sentence beside each key is its entry in ``studies/scenes/README.md``.
"""

import math
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import PurePath
from typing import Annotated, Any, ClassVar

import fem
from studies.refusal import SceneError, one_of, shown
from studies.scene.block import Block, Blocks, Within, keys_of
from studies.scene.numbers import NUMBER, FixedList, Listed, Quantity, as_pair, impedance, matrix, surface_position
from studies.scene.quantity import si_value
from studies.scene.rule import FIELD, FLAG, TEXT, Count, Field, Named, Plain, Rule, choice

CUTS = choice("Z", "X", "YZ", "128YX", "ST-X")
ORIENTATION = (
    CUTS
    | Plain(
        'another cut such as "64YX", "X112Y" or "ZX"',
        lambda value: isinstance(value, str) and fem.named_cut(value) is not None,
        {
            "type": "string",
            "pattern": r"^(\d{1,3}(\.\d+)?\s*°?[\s-]*Y-?X|X[\s-]*\d{1,3}(\.\d+)?\s*°?[\s-]*Y|Z[XY]|YX|X[YZ])$",
        },
    )
    | FixedList((NUMBER,) * 3, "three angles [phi, theta, psi] in degrees")
)
CONDUCTIVITY = Annotated[
    float | None, Quantity("W/(m K)"), "Thermal conductivity. Absent: powers are stated, and no temperature."
]
HEAT_CAPACITY = Annotated[
    float | None, Quantity("J/(kg K)"), "Heat capacity. Absent: the steady temperature is stated, and not its time."
]
VELOCITY_COEFFICIENT = Annotated[
    float | None,
    Quantity("1/K", negative=True),
    "Temperature coefficient of the resonance frequency, TCF: of the velocity less the expansion along x. Absent: the "
    "temperature's effect on the wave is not stated.",
]
TEMPERATURE = Quantity("degC", negative=True)
ABSOLUTE_ZERO, HOTTEST_AMBIENT = -273.15, 250.0  # degC; a number of 250 and more is a room's temperature in K


def _no_kelvins(key: str, degrees: float) -> Iterator[tuple[str, str]]:
    if not ABSOLUTE_ZERO < degrees < HOTTEST_AMBIENT:
        rule = f"must be above {ABSOLUTE_ZERO:g} and below {HOTTEST_AMBIENT:g} degC"
        yield key, f"{rule}, got {degrees:g}; 293 K are 20 degC"


DENSITY = Annotated[float, Field("fem.Solid.density"), "Mass density."]
QUALITY = Annotated[
    float | None,
    Field("fem.Solid.mechanical_quality"),
    "Mechanical quality factor Q: the stiffness is c (1 + i/Q). Absent: no mechanical loss.",
]


COEFFICIENTS = Named("a table of coefficients by constant such as { c11 = -1.74e-4 }", NUMBER)
AXIAL = FixedList((NUMBER,) * 3, "three numbers, along the crystal's axes 1, 2, 3")


@dataclass(frozen=True, kw_only=True)
class TemperatureCoefficients(Block):
    """How the constants of a solid change with the temperature."""

    block: ClassVar[str] = "stator.material.temperature"
    reference: Annotated[float, TEMPERATURE, "Temperature at which the constants hold."] = 25.0
    source: Annotated[str | None, TEXT, "Where the coefficients come from."] = None
    confirmed: Annotated[str | None, TEXT, "Published values that they give; absent: none was found."] = None
    first: Annotated[tuple | None, COEFFICIENTS, "Relative change of the constants by name, 1/K."] = None
    second: Annotated[tuple | None, COEFFICIENTS, "Of second order, 1/K^2."] = None
    third: Annotated[tuple | None, COEFFICIENTS, "Of third order, 1/K^3."] = None
    expansion: Annotated[tuple | None, AXIAL, "Relative expansion along the crystal's axes, 1/K."] = None
    expansion_second: Annotated[tuple | None, AXIAL, "Of second order, 1/K^2."] = None
    expansion_third: Annotated[tuple | None, AXIAL, "Of third order, 1/K^3."] = None

    def check_reference(self) -> Any:
        yield from _no_kelvins("reference", self.reference)

    def unknown(self, known: tuple[str, ...]) -> Any:
        """Yield key and rule of each coefficient whose constant is not among the known ones."""
        for order in fem.COEFFICIENT_ORDERS:
            for name, _ in getattr(self, order) or ():
                if name not in known:
                    yield f"temperature.{order}.{name}", one_of(known)


TEMPERATURE_COEFFICIENTS = Annotated[
    TemperatureCoefficients | None,
    Within(TemperatureCoefficients),
    "Temperature coefficients of the constants. Absent: they are not known.",
]


@dataclass(frozen=True, kw_only=True)
class PiezoelectricSolid(Block):
    """A table of constants in the crystal frame; engineering shear strain."""

    block: ClassVar[str] = "stator.material"
    parameters_of = "fem.Conditions"
    name: Annotated[str, TEXT, "Name of the material in results."] = "user's table"
    source: Annotated[str | None, TEXT, "Where the constants come from."] = None
    axes: Annotated[str | None, TEXT, "The crystal's axes 1, 2, 3 in words."] = None
    aliases: Annotated[tuple | None, Listed(TEXT, distinct=True), "Other names, in the catalogue's files."] = None
    confirmed: Annotated[str | None, TEXT, "Published values that the constants give; absent: none was found."] = None
    remark: Annotated[str | None, TEXT, "What else is to be known of the constants."] = None
    form: Annotated[
        str,
        FIELD,
        "stress-charge: stiffness c^E, coupling e in C/m^2, permittivity eps^S; strain-charge: compliance s^E, "
        "coupling d in C/N, permittivity eps^T.",
    ] = "stress-charge"
    stiffness: Annotated[
        tuple | None, matrix(6, 6), "Stiffness at constant electric field, c^E, in Pa. Absent: that of compliance."
    ] = None
    compliance: Annotated[
        tuple | None, matrix(6, 6), "Compliance at constant electric field, s^E, in 1/Pa; with form = strain-charge."
    ] = None
    coupling: Annotated[tuple | None, matrix(3, 6), "Piezoelectric constants: e in C/m^2, or d in C/N (form)."] = None
    permittivity: Annotated[
        tuple | None,
        matrix(3, 3),
        "Permittivity relative to that of vacuum: eps^S at constant strain, or eps^T at constant stress (form).",
    ] = None
    crystal_class: Annotated[
        str | None, Field("fem.CLASSES"), "Crystal class whose tables constants fill, in the axes of IEEE 176."
    ] = None
    constants: Annotated[
        tuple | None,
        Named("a table of constants by name such as { c11 = 139e9, e31 = -5.2, eps11 = 730 }", NUMBER),
        "Independent constants of crystal_class in place of the tables: c11, e15, eps11 ..., or s11, d15 ... (form).",
    ] = None
    order: Annotated[
        str,
        Field("fem.ORDERS"),
        "Order of the components of stress and strain in the tables. 11 22 33 12 23 13 is that of Ansys, "
        "11 22 33 12 13 23 that of Abaqus.",
    ] = "11 22 33 23 13 12"
    units: Annotated[
        tuple | None,
        Named('a table of units by key such as { stiffness = "GPa", permittivity = "F/m" }', TEXT),
        "Units of the numbers in stiffness, compliance, coupling and permittivity where they are others.",
    ] = None
    stiffness_at: Annotated[str, FIELD, "Condition of the stiffness. constant D: c^E = c^D - e^T (eps^S)^-1 e."] = (
        "constant E"
    )
    permittivity_at: Annotated[
        str | None,
        FIELD,
        "Condition of the permittivity. constant stress: eps^S = eps^T - e (c^E)^-1 e^T. Absent: that of the form.",
    ] = None
    density: DENSITY
    mechanical_quality: QUALITY = None
    dielectric_loss: Annotated[
        float | None,
        Field("fem.Solid.dielectric_loss"),
        "Loss tangent tan delta: the permittivity is eps (1 - i tan delta). Absent: no dielectric loss.",
    ] = None
    conductivity: CONDUCTIVITY = None
    heat_capacity: HEAT_CAPACITY = None
    curie_temperature: Annotated[
        float | None, NUMBER, "Temperature in degC at which the poling is lost. Absent: it is not judged."
    ] = None
    velocity_coefficient: VELOCITY_COEFFICIENT = None
    temperature: TEMPERATURE_COEFFICIENTS = None

    def check_temperature(self) -> Any:
        if self.temperature is None:
            return
        if self.velocity_coefficient is not None:
            yield "velocity_coefficient", "must be absent beside temperature, whose coefficients give it"
        if self.constants is None:
            yield "temperature", "needs constants by name (constants, with a crystal_class), not tables"
            return
        names = tuple(name for name, _ in self.constants)
        tied = self.form == "stress-charge" and self.crystal_class in fem.TIED_C66
        yield from self.temperature.unknown((*names, "c66") if tied else names)

    def check_form(self) -> Any:
        elastic = "compliance" if self.form == "strain-charge" else "stiffness"
        tables = [name for name in ("stiffness", "compliance") if getattr(self, name) is not None]
        if self.constants is not None:
            tables += [name for name in ("coupling", "permittivity") if getattr(self, name) is not None]
            yield from ((name, "must be absent beside constants") for name in tables)
            if self.crystal_class is None:
                yield "crystal_class", f"is required and missing beside constants: give one of {', '.join(fem.CLASSES)}"
            elif self.order != fem.ORDERS[0]:
                yield "order", "must be absent beside constants, whose names have two indices"
            return
        if len(tables) == 2:
            yield "compliance", "must be absent beside stiffness"
        elif tables == ["compliance"] and self.form != "strain-charge":
            yield "form", 'must be "strain-charge" with compliance, got "stress-charge": the coupling is then d'
        for name in ("coupling", "permittivity") if tables else (elastic, "coupling", "permittivity"):
            if getattr(self, name) is None:
                rule = keys_of(type(self))[name].rule.expected
                yield name, f"is required and missing: give {rule}, or the constants of a crystal_class"

    def check_constants(self) -> Any:
        if self.constants is None or self.crystal_class is None:
            return
        try:
            fem.class_tables(self.crystal_class, dict(self.constants), compliant=self.form == "strain-charge")
        except fem.InputError as error:
            yield error.key, error.rule

    def check_units(self) -> Any:
        for key, unit in self.units or ():
            if key not in self.table_units:
                yield f"units.{key}", one_of(self.table_units)
                continue
            if key == "permittivity" and unit == "relative":
                continue
            try:
                si_value("", f"1 {unit}", self.table_units[key])
            except SceneError as error:
                yield f"units.{key}", error.rule

    @property
    def table_units(self) -> dict[str, str]:
        """SI unit of the numbers of each table."""
        coupling = "C/N" if self.form == "strain-charge" else "C/m^2"
        return {"stiffness": "Pa", "compliance": "1/Pa", "coupling": coupling, "permittivity": "F/m"}


@dataclass(frozen=True, kw_only=True)
class IsotropicSolid(Block):
    """An isotropic solid; no electric field is solved for."""

    block: ClassVar[str] = "stator.material"
    name: Annotated[str, TEXT, "Name of the material in results."] = "user's isotropic solid"
    source: Annotated[str | None, TEXT, "Where the constants come from."] = None
    aliases: Annotated[tuple | None, Listed(TEXT, distinct=True), "Other names, in the catalogue's files."] = None
    confirmed: Annotated[str | None, TEXT, "Published values that the constants give; absent: none was found."] = None
    remark: Annotated[str | None, TEXT, "What else is to be known of the constants."] = None
    parameters_of = "fem.IsotropicConstants"
    youngs_modulus: Annotated[float, FIELD, "Young's modulus."]
    poisson_ratio: Annotated[float, FIELD, "Poisson's ratio."]
    density: DENSITY
    mechanical_quality: QUALITY = None
    conducting: Annotated[
        bool, FLAG, "true: a metal. A layer of it has one potential and no net charge; fingers do not touch it."
    ] = False
    conductivity: CONDUCTIVITY = None
    heat_capacity: HEAT_CAPACITY = None
    velocity_coefficient: VELOCITY_COEFFICIENT = None
    temperature: TEMPERATURE_COEFFICIENTS = None

    @property
    def curie_temperature(self) -> None:
        """None: it has no poling."""
        return None

    def check_temperature(self) -> Any:
        if self.temperature is not None:
            yield from self.temperature.unknown(("youngs_modulus", "poisson_ratio"))


SOLID = Within(PiezoelectricSolid, IsotropicSolid)


class MaterialFile(Rule):
    """A file with a table of constants, as in the scene; a scene that is written back holds the table."""

    expected = 'a file such as "my-ceramic.toml", from the scene\'s folder'

    def takes(self, value: Any) -> Any:
        return isinstance(value, str) and value.endswith(".toml")

    def read(self, path: Any, value: Any) -> Any:
        file = PurePath(value)
        try:
            with open(file, "rb") as opened:
                table = tomllib.load(opened)
        except OSError as error:
            raise SceneError(path, f"names the file {shown(value)}, which cannot be read: {error.strerror}") from None
        except (tomllib.TOMLDecodeError, UnicodeDecodeError, RecursionError) as error:
            raise SceneError(path, f"names the file {shown(value)}, which is no TOML: {str(error)[:120]}") from None
        try:
            return SOLID.read(path, {"name": file.stem} | table)
        except SceneError as error:
            found = [SceneError(each.path, each.rule, each.location or file.name) for each in error.problems]
            raise SceneError.together(found) from None

    def schema(self) -> Any:
        return {"type": "string", "pattern": r"\.toml$"}


MATERIAL = MaterialFile() | TEXT | SOLID
SOLIDS = Named('a table of solids by surface group such as { strip = "aluminium" }', MATERIAL)
CONNECTIONS = Named('a table by electrode such as { strip = "floating", a = "left+" }', TEXT)


@dataclass(frozen=True, kw_only=True)
class Cooling(Block):
    """What takes the heat of the stator; still air without the block."""

    block: ClassVar[str] = "stator.cooling"
    air: Annotated[
        float,
        Quantity("W/(m^2 K)", zero=True),
        "Heat taken by air and radiation per area and kelvin. Still air: 5 to 10 W/(m^2 K), stated to +-40 %.",
    ] = 10.0
    bottom: Annotated[
        float | str,
        Quantity("W/(m^2 K)") | choice("air", "held"),
        "Below the stator. air: as its other faces; held: at the ambient temperature, as glued to metal; or a "
        "conductance per area.",
    ] = "air"
    ends_heat_stator: Annotated[
        float,
        Quantity(least=0.0, most=1.0),
        "Share of the absorbing ends' heat that the stator takes over its last 5 mm. 0: they are cooled.",
    ] = 0.0
    ambient: Annotated[float, TEMPERATURE, "Temperature of the surroundings."] = 20.0

    def check_cooled(self) -> Any:
        if self.air == 0.0 and self.bottom == "air":
            yield "air", "must be positive where the bottom is in air: nothing would cool the stator"
        yield from _no_kelvins("ambient", self.ambient)


class Wavelengths(Rule):
    """A text of a number of wavelengths, kept as it is."""

    expected = 'a number of wavelengths such as "0.05 lambda"'

    def takes(self, value: Any) -> Any:
        return isinstance(value, str) and value.rstrip().endswith(LAMBDAS)

    def read(self, path: Any, value: Any) -> Any:
        self.require(self.takes(value) and wavelengths_of(value) is not None, path, value)
        return value

    def schema(self) -> Any:
        return {"type": "string", "pattern": r"^\s*\d*\.?\d+([eE][+-]?\d+)?\s*(lambda|\u03bb)\s*$"}


LAMBDAS = ("lambda", "\u03bb")


def wavelengths_of(text: str) -> float | None:
    """Return the number in a text such as "0.05 lambda"; None if it is not positive, or none.

    Examples
    --------
    >>> wavelengths_of("0.05 lambda"), wavelengths_of("-1 lambda")
    (0.05, None)
    """
    try:
        number = float(text.strip().removesuffix(LAMBDAS[0]).removesuffix(LAMBDAS[1]))
    except ValueError:
        return None
    return number if 0.0 < number < math.inf else None


@dataclass(frozen=True, kw_only=True)
class Bond(Block):
    """An elastic bond between a layer and what lies below it; without the block they move as one."""

    block: ClassVar[str] = "stator.layer.bond"
    parameters_of = "fem.Bond"
    normal: Annotated[float, FIELD, "Normal traction over the jump of u_z: modulus over thickness of a glue."]
    tangential: Annotated[float, FIELD, "Shear traction over the jump of u_x and u_y."]


@dataclass(frozen=True, kw_only=True)
class Layer(Block):
    """A layer on the stator's material, from the material up; the last one is the surface."""

    block: ClassVar[str] = "stator.layer"
    material: Annotated[
        str | PiezoelectricSolid | IsotropicSolid, MATERIAL, "As stator.material; its losses are those of the material."
    ]
    orientation: Annotated[str | tuple, ORIENTATION, "As stator.orientation, of this layer's crystal."] = "Z"
    euler_convention: Annotated[str, Field("fem.CONVENTIONS"), "As stator.euler_convention."] = "SAW"
    thickness: Annotated[
        float | str,
        Wavelengths() | Quantity("m"),
        "Thickness, or its ratio to the wavelength of the surface wave of the layers at drive.frequency.",
    ]
    bond: Annotated[Bond | None, Within(Bond), "Bond to what lies below. Absent: a perfect joint."] = None

    @property
    def cut(self) -> str | tuple[float, ...]:
        """Its orientation as `fem` takes it: a name, or Euler angles in the convention SAW."""
        return _cut(self)


def _cut(block: Any) -> str | tuple[float, ...]:
    if isinstance(block.orientation, str):
        return block.orientation
    return fem.euler_angles(block.orientation, block.euler_convention)


@dataclass(frozen=True, kw_only=True)
class Stator(Block):
    """The block of material that carries the wave; a vertical section of it is modelled."""

    block: ClassVar[str] = "stator"
    parameters_of = "fem.Stator"
    material: Annotated[
        str | PiezoelectricSolid | IsotropicSolid,
        MATERIAL,
        "Name of a material of the catalogue below, a file with a table of constants, or the table itself.",
    ]
    orientation: Annotated[
        str | tuple,
        ORIENTATION,
        "Z: poled along the surface normal; X: poled along x; YZ, ST-X, 128YX, 64YX or another angle, X112Y, ZX: cuts "
        "by the crystal axes of normal and propagation; or three Euler angles in degrees.",
    ] = "Z"
    euler_convention: Annotated[
        str,
        Field("fem.CONVENTIONS"),
        "Convention of three Euler angles. SAW: z-x-z, passive, from the crystal to the cut (128YX is [0, 38, 0]); "
        "COMSOL (in three dimensions, z normal), sawsim: from the cut to the crystal (128YX is [0, -38, 0]).",
    ] = "SAW"
    length: Annotated[float, FIELD, "Length along x, the direction of propagation."]
    thickness: Annotated[
        float | str,
        FIELD | choice("half-space"),
        "Thickness along z, of the material below the layers. half-space: unbounded below, with an exactly absorbing "
        "boundary.",
    ]
    width: Annotated[
        float, Quantity("m"), "Width along y: limit for apertures and contacts, and distance between the side faces."
    ]
    bottom: Annotated[
        str,
        FIELD,
        "Boundary condition of the bottom. free: no traction, D_n = 0; grounded: no traction, phi = 0; clamped: u ="
        " 0, D_n = 0; absorbing: no reflection.",
    ] = "free"
    ends: Annotated[
        str,
        FIELD,
        "Boundary condition of both ends in x. absorbing: no reflection; free: no traction, D_n = 0; clamped: u = "
        "0, D_n = 0.",
    ]
    above: Annotated[
        str, FIELD, "Electric field above the surface. none: neglected, D_n = 0 on the bare surface; vacuum: included."
    ] = "none"
    diffraction: Annotated[
        bool | None,
        FLAG,
        "true: the beam of the finite aperture spreads; false: plane waves. Absent: true if the scene has a slider,"
        " the beam can be computed, and either the ends absorb or a contact lies beside the axis.",
    ] = None
    sides: Annotated[
        str,
        choice("absorbing", "mirror"),
        "Side faces y = +-width/2 in the beam model. absorbing: no reflection; mirror: total reflection.",
    ] = "absorbing"
    mechanical_quality: Annotated[
        float | None,
        Field("fem.Solid.mechanical_quality"),
        "Mechanical quality factor Q. Absent: that of the material.",
    ] = None
    dielectric_loss: Annotated[
        float | None, Field("fem.Solid.dielectric_loss"), "Loss tangent. Absent: that of the material. 0: lossless."
    ] = None
    layer: Annotated[
        tuple[Layer, ...], Blocks(Layer), "Layers on the material, from the material up; the last is the surface."
    ] = ()
    temperature: Annotated[
        float | str | None,
        TEMPERATURE | choice("steady"),
        "Temperature of the stator, for its constants and lengths. steady: the one that its own heat gives it at the "
        "largest level and a fixed frequency. Absent: the constants as they are. Automatic periods and frequencies "
        "are those without it.",
    ] = None
    temperature_coefficient: Annotated[
        float | None,
        Quantity("1/K", negative=True),
        "Temperature coefficient of the resonance frequency, TCF, about the ambient temperature. Absent: that of the "
        "material.",
    ] = None
    cooling: Annotated[
        Cooling | None, Within(Cooling), "What takes the stator's heat. Absent: still air on all faces, cooled ends."
    ] = None

    @property
    def mirror_width(self) -> float | None:
        """Distance of the side faces in m where they reflect."""
        return self.width if self.sides == "mirror" else None

    @property
    def cut(self) -> str | tuple[float, ...]:
        """Its orientation as `fem` takes it: a name, or Euler angles in the convention SAW."""
        return _cut(self)

    def check_temperature(self) -> Any:
        if isinstance(self.temperature, float) and not self.temperature > ABSOLUTE_ZERO:
            yield "temperature", f"must be above {ABSOLUTE_ZERO:g} degC, got {self.temperature:g}"

    def check_sides(self) -> Any:
        if self.sides == "mirror" and self.diffraction is False:
            yield "sides", "must be absorbing where stator.diffraction is false, got 'mirror'"

    @property
    def ambient(self) -> float:
        """Temperature of its surroundings, degC."""
        return (self.cooling or Cooling()).ambient

    @property
    def is_steady(self) -> bool:
        """Whether it is to be solved at the temperature that its own heat gives it."""
        return self.temperature == "steady"

    @property
    def cold(self) -> "Stator":
        """The stator with the constants of its solid as they are, without ``temperature``."""
        return self if self.temperature is None else replace(self, temperature=None)

    def check_layers(self) -> Any:
        if self.layer and self.diffraction:
            yield "diffraction", "must not be true with layers: the field in three dimensions is that of one solid"

    def check_loss(self) -> Any:
        if isinstance(self.material, IsotropicSolid) and self.dielectric_loss is not None:
            yield "dielectric_loss", "must be absent with an isotropic solid: no electric field is solved for"


# How far the fingers of an apodised transducer reach, from its left end, 0, to its right end, 1
WINDOWS = {"cosine": lambda u: math.sin(math.pi * u), "hamming": lambda u: 0.54 - 0.46 * math.cos(2 * math.pi * u)}


@dataclass(frozen=True, kw_only=True)
class Transducer(Block):
    """Two interleaved combs of fingers on the surface; one block for each transducer."""

    block: ClassVar[str] = "transducer"
    parameters_of = "fem.Transducer"
    name: Annotated[str, TEXT, "Name of the transducer, to which [drive] refers."]
    center: Annotated[
        float | tuple[float, float],
        surface_position(),
        "Position of the middle of the fingers: x from the left end of the stator, or [x, y] with y from its middle"
        " line.",
    ]
    finger_pairs: Annotated[int, FIELD, "Number of periods; 10 are 20 fingers, 40 if split, or 30 in cells of three."]
    period: Annotated[
        float | str,
        FIELD | choice("auto", "half-space"),
        "Length of one period, two fingers and two gaps (four of each if split), which is one wavelength. auto:"
        " computed for the strongest surface wave per volt at drive.frequency, for this transducer alone; half-space:"
        " from the velocity under a partly metallised surface, without reflections.",
    ] = "auto"
    metallisation: Annotated[float, FIELD, "Width of a finger over the pitch (finger and gap)."]
    aperture: Annotated[
        float, FIELD, "Overlap of the fingers along y, at most stator.width. The admittance is proportional to it."
    ]
    termination: Annotated[
        str | float | complex,
        impedance("open", "short"),
        "Electrical load of a transducer that is not driven. open: no net charge on either electrode; short: both "
        "electrodes connected; or an impedance.",
    ] = "open"
    pattern: Annotated[
        str | None,
        FIELD,
        "One sign for each finger, from left to right: + and - for the two electrodes, 0 for a finger left out, o "
        "for an open strip. Absent: + - + - ...",
    ] = None
    plane: Annotated[
        str | int,
        choice("surface") | Count(100),
        "Where the fingers are: on the surface, or below so many layers of the stator, at an interface.",
    ] = "surface"
    split: Annotated[bool, FLAG, "true: four fingers in each period, + + - -, instead of two."] = False
    cell: Annotated[
        str,
        FIELD,
        "plain: two fingers in each period, or four if split. DART, EWC: three, - + -, the last one wider, of a "
        "single-phase unidirectional transducer. The electrodes' masses, which decide its directivity, are left out.",
    ] = "plain"
    mirrored: Annotated[bool, FLAG, "true: each cell DART or EWC is reflected in x, for the other direction."] = False
    chirp: Annotated[
        float,
        FIELD,
        "Change of the local period from the left end of the transducer to the right one, over period, its mean; "
        "0.1: from 0.95 to 1.05 of it.",
    ] = 0.0
    apodisation: Annotated[
        str | tuple[float, ...] | None,
        choice(*WINDOWS) | Listed(Quantity(least=0.0, most=1.0)),
        "How far each finger reaches over the aperture, from 0 to 1: one number for each or for all, or cosine or "
        "hamming over the length of the transducer. Fingers + end at y = -a aperture/2, fingers - at a aperture/2, in "
        "the middle of a gap beyond which a dummy finger of the other electrode goes on; where half the gap does not "
        "fit before the end of the aperture, at that end. Absent: 1.",
    ] = None
    slant: Annotated[
        float,
        FIELD,
        "Change of the period from one side of the aperture to the other (-y to y) over period, that of the middle.",
    ] = 0.0
    slant_strips: Annotated[
        int, FIELD, "Number of strips along y, of one period each, that stand for a slanted transducer."
    ] = 8
    angle: Annotated[
        float,
        Quantity("deg", negative=True),
        "Rotation about the surface normal, from x towards y. A rotated transducer, or one beside the middle line, "
        "requires a solid isotropic about z, absorbing ends and sides, and diffraction.",
    ] = 0.0

    def check_apodisation(self) -> Any:
        numbers = self.apodisation
        if isinstance(numbers, tuple) and len(numbers) not in (1, self.fingers):
            yield "apodisation", f"must be one number for each of the {self.fingers} fingers, got {len(numbers)}"
        if isinstance(numbers, tuple) and not any(numbers):
            yield "apodisation", "must let one finger at least reach over the middle line, got zeros"

    @property
    def overlaps(self) -> tuple[float, ...] | None:
        """How far each finger reaches over the aperture, 0 to 1; None if all reach over it whole."""
        reach = self.apodisation
        if reach is None:
            return None
        if not isinstance(reach, str):
            return reach * self.fingers if len(reach) == 1 else reach
        places = [(number + 0.5) / self.fingers for number in range(self.fingers)]
        return tuple(round(WINDOWS[reach](u), 9) for u in places)

    @property
    def uniform_along_y(self) -> bool:
        """Whether all fingers are straight along y and reach over the whole aperture."""
        return self.slant == 0.0 and min(self.overlaps or (1.0,)) == 1.0

    @property
    def center_xy(self) -> tuple[float, float]:
        """Position (x, y) of its middle on the stator, m."""
        return as_pair(self.center)

    @property
    def wavelength(self) -> float:
        """Its period in m; an automatic one must have been resolved."""
        if isinstance(self.period, str):
            self.refuse("period", f"must be a number in m here, got {self.period!r}")
        return self.period

    @property
    def half_length(self) -> float:
        """Half its length along its direction of propagation, m."""
        return self.finger_pairs * self.wavelength / 2

    @property
    def turned(self) -> bool:
        """Whether it is rotated or lies beside the middle line of the stator."""
        return self.angle % 360 != 0 or self.center_xy[1] != 0

    @property
    def fingers(self) -> int:
        """Number of fingers, those left out included."""
        return self.finger_pairs * len(fem.cell_signs(self.cell, self.split, self.mirrored))

    @property
    def signs(self) -> str:
        """The sign of each finger, from left to right."""
        return self.pattern or fem.cell_signs(self.cell, self.split, self.mirrored) * self.finger_pairs

    @property
    def even(self) -> bool:
        """Whether all fingers are equal and equally spaced."""
        return self.cell == "plain" and self.chirp == 0.0

    @property
    def finger_edges(self) -> Any:
        """Left and right edges of all fingers from the middle of the transducer, m, shape (fingers, 2)."""
        own = {"name": self.name, "center": 0.0, "period": self.wavelength}
        return fem.Transducer(**self.arguments(fem.Transducer) | own | {"angle": 0.0, "center_y": 0.0}).fingers

    @property
    def gap(self) -> float | None:
        """Smallest free surface between fingers of both electrodes, without open strips, m; None if it has only one."""
        gap, last, last_at, metal = None, "", 0.0, 0.0
        for (left, right), sign in zip(self.finger_edges.tolist(), self.signs, strict=True):
            if sign == "o":
                metal += right - left
            elif sign in "+-":
                if last not in ("", sign):
                    free = left - last_at - metal
                    gap = free if gap is None else min(gap, free)
                last, last_at, metal = sign, right, 0.0
        return gap

    @property
    def has_two_electrodes(self) -> bool:
        """Whether it has fingers of both electrodes, so that it can have a voltage."""
        return self.pattern is None or {"+", "-"} <= set(self.pattern)


@dataclass(frozen=True, kw_only=True)
class Piece(Block):
    """A meshed part of the section: a groove, a strip, an end, or all of it; one block for each file."""

    block: ClassVar[str] = "piece"
    name: Annotated[str | None, TEXT, "Name of the piece in messages. Absent: the name of the file."] = None
    file: Annotated[
        str,
        TEXT,
        "Mesh of gmsh, format 2.2 or 4.1, in the plane (x, z) with the surface at z = 0. The path is relative to "
        "the folder of the scene. Triangles and quadrilaterals of order 1 or 2; curved edges are kept. A mesh "
        "without the line groups left and right is the whole stator, and its electrodes are the fingers of the "
        "transducers.",
    ]
    length_unit: Annotated[
        str, Field("fem.LENGTH_UNITS"), "Unit of the coordinates in the file, which does not state it."
    ]
    position: Annotated[
        tuple[float, ...],
        Listed(Quantity("m", negative=True), ranged=True),
        "Position of the file's x = 0, from the left end of the stator; several positions are a list or a range.",
    ]
    materials: Annotated[
        tuple | None,
        SOLIDS,
        'Material of each surface group other than "stator": a name of the catalogue or a table, in the orientation'
        " of the stator.",
    ] = None
    electrodes: Annotated[
        tuple | None,
        CONNECTIONS,
        "Connection of each line group electrode:NAME: floating (also those not named here), grounded, or an "
        'electrode of a transducer such as "left+".',
    ] = None

    @property
    def label(self) -> str:
        """Its name, or that of its file."""
        return self.name or PurePath(self.file).stem
