"""The blocks of a scene: stator, transducers, drive, given wave and slider, in the words of the scene file.

Everything is in SI units once read.  Amplitudes and voltages are peak values, x runs along the surface from
the stator's left end, z out of the surface.
"""

from dataclasses import dataclass
from typing import Annotated, ClassVar

from studies.refusal import SceneError, nearest, shown
from studies.scene.block import Block, OneOf, Within
from studies.scene.rule import Choice, Count, Flag, Impedance, Listed, Matrix, Quantity, Rule, Signs, Text

__all__ = [
    "Damping",
    "Drive",
    "IsotropicSolid",
    "PiezoelectricSolid",
    "Slider",
    "Stator",
    "Transducer",
    "Wave",
]

NARROWEST = 1e-3  # finger or gap, of the pitch; narrower ones take ever finer elements
ORIENTATIONS = ("Z", "X", "YZ", "128YX", "ST-X")


@dataclass(frozen=True, kw_only=True)
class PiezoelectricSolid(Block):
    """A user's table of constants, in the crystal frame, Voigt 11 22 33 23 13 12, engineering shear."""

    block: ClassVar[str] = "stator.material"
    name: Annotated[str, Text()] = "user's table"
    stiffness: Annotated[tuple, Matrix(6, 6)]
    coupling: Annotated[tuple, Matrix(3, 6)]
    permittivity: Annotated[tuple, Matrix(3, 3)]
    density: Annotated[float, Quantity("kg/m^3")]
    mechanical_quality: Annotated[float | None, Quantity()] = None
    dielectric_loss: Annotated[float | None, Quantity(zero=True)] = None


@dataclass(frozen=True, kw_only=True)
class IsotropicSolid(Block):
    """A user's isotropic solid: no electric field is solved for."""

    block: ClassVar[str] = "stator.material"
    name: Annotated[str, Text()] = "user's isotropic solid"
    youngs_modulus: Annotated[float, Quantity("Pa")]
    poisson_ratio: Annotated[float, Quantity(negative=True, below=0.5)]
    density: Annotated[float, Quantity("kg/m^3")]
    mechanical_quality: Annotated[float | None, Quantity()] = None

    def check(self):
        """Keep the solid stable."""
        if self.poisson_ratio <= -1:
            self.refuse("poisson_ratio", f"must be above -1 and below 0.5, got {self.poisson_ratio!r}")


@dataclass(frozen=True)
class Orientation(Rule):
    """A named cut, or three angles in degrees: z-x-z, passive."""

    def read(self, path, value):
        """Return the word or a tuple of three angles."""
        if isinstance(value, (list, tuple)):
            if len(value) != 3:
                self._refuse(path, value)
            return tuple(Quantity(negative=True).read(f"{path}.{i}", angle) for i, angle in enumerate(value))
        if value not in ORIENTATIONS:
            self._refuse(path, value)
        return value

    def written(self, value):
        """Return a list of angles."""
        return list(value) if isinstance(value, tuple) else value

    @staticmethod
    def _refuse(path, value):
        hint = nearest(value, ORIENTATIONS) if isinstance(value, str) else ""
        rule = f"must be {', '.join(ORIENTATIONS)} or three angles [phi, theta, psi] in degrees"
        raise SceneError(path, f"{rule}, got {shown(value)}{hint if 'mean' in hint else ''}")


@dataclass(frozen=True, kw_only=True)
class Stator(Block):
    """The block of material that carries the wave."""

    block: ClassVar[str] = "stator"
    material: Annotated[
        str | PiezoelectricSolid | IsotropicSolid, OneOf(Text(), (PiezoelectricSolid, IsotropicSolid))
    ]
    orientation: Annotated[str | tuple, Orientation()] = "Z"
    length: Annotated[float, Quantity("m")]
    thickness: Annotated[float | str, Quantity("m", words=("half-space",))]
    width: Annotated[float, Quantity("m")]
    bottom: Annotated[str, Choice(("free", "grounded", "clamped", "absorbing"))] = "free"
    ends: Annotated[str, Choice(("absorbing", "free", "clamped"))]
    above: Annotated[str, Choice(("none", "vacuum"))] = "none"


@dataclass(frozen=True, kw_only=True)
class Transducer(Block):
    """Two interleaved combs of fingers on the surface.

    ``split``: four fingers to a period, ``++--``, instead of two.  ``pattern``: one sign per finger from left to
    right, ``+`` and ``-`` the combs, ``0`` a finger left out, ``o`` an open strip.
    """

    block: ClassVar[str] = "transducer"
    name: Annotated[str, Text()]
    center: Annotated[float, Quantity("m")]
    finger_pairs: Annotated[int, Count(100_000)]
    period: Annotated[float | str, Quantity("m", words=("auto",))] = "auto"
    metallisation: Annotated[float, Quantity(below=1.0)]
    aperture: Annotated[float, Quantity("m")]
    termination: Annotated[str | float | complex, Impedance(("open", "short"))] = "open"
    pattern: Annotated[str | None, Signs("+-0o")] = None
    split: Annotated[bool, Flag()] = False

    def check(self):
        """Keep fingers and gaps of some width, one sign per finger, and at least one finger."""
        if not NARROWEST <= self.metallisation <= 1 - NARROWEST:
            rule = f"must be between {NARROWEST:g} and {1 - NARROWEST:g}, got {self.metallisation!r}"
            self.refuse("metallisation", rule)
        if self.pattern is None:
            return
        if len(self.pattern) != self.fingers:
            each = "four" if self.split else "two"
            rule = f"must have {self.fingers} signs, {each} for each of the {self.finger_pairs} finger_pairs"
            self.refuse("pattern", f"{rule}, got {len(self.pattern)}: {shown(self.pattern)}")
        if set(self.pattern) == {"0"}:
            self.refuse("pattern", f"must leave at least one finger, got {shown(self.pattern)}")

    @property
    def fingers(self) -> int:
        """Places of fingers, those left out included."""
        return self.finger_pairs * (4 if self.split else 2)

    @property
    def has_two_combs(self) -> bool:
        """Whether a voltage can stand between its combs."""
        return self.pattern is None or {"+", "-"} <= set(self.pattern)


@dataclass(frozen=True, kw_only=True)
class Drive(Block):
    """The source: its frequency and, with transducers, which one it drives at which peak voltages."""

    block: ClassVar[str] = "drive"
    frequency: Annotated[float | str, Quantity("Hz", words=("center",))]
    transducer: Annotated[str | None, Text()] = None
    voltage: Annotated[tuple[float, ...] | None, Listed(Quantity("V", zero=True))] = None
    burst: Annotated[float | None, Quantity("s")] = None
    source_impedance: Annotated[float | complex, Impedance()] = 0.0


@dataclass(frozen=True, kw_only=True)
class Wave(Block):
    """A given surface motion: u_z and, a quarter period from it, u_x, which at the crest moves towards +x."""

    block: ClassVar[str] = "wave"
    frequency: Annotated[float, Quantity("Hz")]
    normal_amplitude: Annotated[tuple[float, ...], Listed(Quantity("m", zero=True))]
    tangential_ratio: Annotated[float, Quantity()]
    burst: Annotated[float | None, Quantity("s")] = None


@dataclass(frozen=True, kw_only=True)
class Damping(Block):
    """Losses of the slider's motion; the viscous ones are totals of the slider."""

    block: ClassVar[str] = "slider.damping"
    contact: Annotated[float, Quantity("s/m", zero=True)] = 0.0
    normal: Annotated[float, Quantity("N s/m", zero=True)] = 0.0
    tangential: Annotated[float, Quantity("N s/m", zero=True)] = 0.0


UNDAMPED = Damping()


@dataclass(frozen=True, kw_only=True)
class Slider(Block):
    """A rigid slider on balls that share its load equally; mass, forces and dampers are totals."""

    block: ClassVar[str] = "slider"
    position: Annotated[float | None, Quantity("m")] = None
    radius: Annotated[float, Quantity("m")]
    mass: Annotated[float, Quantity("kg")]
    contacts: Annotated[
        int | tuple[float, ...], Listed(Quantity("m", negative=True), alone=Count(10_000), distinct=True)
    ]
    preload: Annotated[float | str, Quantity("N", zero=True, words=("weight",))]
    gravity: Annotated[float, Quantity("m/s^2", zero=True)] = 9.81
    load: Annotated[float, Quantity("N", zero=True)] = 0.0
    friction_coefficient: Annotated[float, Quantity(zero=True)]
    effective_modulus: Annotated[float | None, Quantity("Pa")] = None
    tangential_modulus: Annotated[float | None, Quantity("Pa")] = None
    ball: Annotated[str | None, Text()] = None
    law: Annotated[str, Choice(("elastic", "hysteretic"))] = "elastic"
    reciprocal: Annotated[bool, Flag()] = False
    stick_band: Annotated[float, Quantity("m/s", zero=True)] = 0.0
    method: Annotated[str, Choice(("auto", "exact", "stepped", "averaged"))] = "auto"
    damping: Annotated[Damping, Within(Damping)] = UNDAMPED

    def check(self):
        """Ask for the moduli once, by value or by the ball's material."""
        for key in ("effective_modulus", "tangential_modulus"):
            if self.ball is not None and getattr(self, key) is not None:
                self.refuse(
                    "ball", f"must not be given together with slider.{key}: they follow from the ball"
                )
            if self.ball is None and getattr(self, key) is None:
                self.refuse(key, 'is required and missing: give both moduli in Pa, or ball = "steel" instead')

    @property
    def preload_force(self) -> float:
        """Total normal force in N, the weight included."""
        return self.mass * self.gravity if self.preload == "weight" else self.preload

    @property
    def offsets(self) -> tuple[float, ...]:
        """Places of the contacts from the slider's centre in m; a mere number of them sits at the centre."""
        return (0.0,) * self.contacts if isinstance(self.contacts, int) else self.contacts
