"""Extreme cases of the driven stator: one quantity of a small motor is varied to extreme values.

The motor is a lossy plate of hard PZT of 9 x 0.7 mm with absorbing ends and one transducer of two finger pairs at
2.2 MHz, except for the quantity that a case varies.  Each answer is compared with a reference that suits the case: one
sparse matrix of the whole section ("direct"), the next level of discretisation if that matrix would be too large
("finer"), the same problem in another unit of length, in which the answer must not change ("size"), or the motor
without source impedance behind a voltage divider ("circuit"). All but the finer ones are stored
(reference_solutions.py). The power balance must hold in every case.  `tests/validation` compares the same cases with
charges on strips of an infinite plate, solved by exact partial waves.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from itertools import product

import fem
from studies.evidence.stability.reference_solutions import compared_with_reference, stored_references
from studies.evidence.stability.resonance import cut_off, piece_resonance
from studies.evidence.stability.verdict import Case, Comparison

TOLERANCE = 1e-3
BALANCE = 1e-7  # allowed error of the power balance over the apparent power; the measured ones are up to 1e-9
ENDS = ("absorbing", "free", "clamped")
BOTTOMS = ("free", "grounded", "clamped", "absorbing")
SIDES = tuple(product(ENDS, BOTTOMS))
CUTS = (
    ("PZT-8", "X"),
    ("LiNbO3 (Warner)", "YZ"),
    ("LiNbO3 (Warner)", "128YX"),
    ("quartz (Bechmann)", "ST-X"),
    ("PZT-8", (10.0, 20.0, 30.0)),
    ("LiNbO3 (Warner)", (10.0, 20.0, 30.0)),
)
TERMINATIONS = ("open", "short", 0.0, 1e-9, 1e9, 50j, -50j)


@dataclass(frozen=True, kw_only=True)
class Motor:
    """A driven stator, and the position at which its motion is computed."""

    stator: fem.Stator
    transducers: tuple[fem.Transducer, ...]  # the first is driven
    frequency: float = 2.2e6  # Hz
    position: float = 6e-3  # x, m
    source_impedance: complex = 0.0  # ohm

    def solid(self, **changes) -> "Motor":
        """Return the motor with some constants of its solid replaced."""
        return replace(self, stator=replace(self.stator, solid=replace(self.stator.solid, **changes)))

    def section(self, **changes) -> "Motor":
        """Return the motor with some fields of its stator replaced."""
        return replace(self, stator=replace(self.stator, **changes))

    def comb(self, **changes) -> "Motor":
        """Return the motor with some fields of its driven transducer replaced."""
        return replace(self, transducers=(replace(self.transducers[0], **changes), *self.transducers[1:]))

    @property
    def drive(self):
        """Its ``fem.Drive``."""
        return fem.Drive(sources={self.transducers[0].name: 1.0}, impedance=self.source_impedance)

    def wave(self, tolerance: float):
        """Return its ``fem.SurfaceWave``."""
        options = {"frequency": self.frequency, "drive": self.drive, "tolerance": tolerance}
        return fem.driven_wave(self.stator, self.transducers, places=(self.position,), **options)


def small_motor(material: str = "PZT-8", orientation="Z", *, stretch: float = 1.0) -> Motor:
    """Return the motor of the cases; with another solid it has the same size in wavelengths, ``stretch`` scales it."""
    solid = fem.rotated(fem.material(material), orientation)
    frequency = 2.2e6 / stretch
    period = fem.automatic_period(solid, frequency, 0.5)
    transducer = fem.Transducer(
        name="left", center=3 * period, finger_pairs=2, period=period, metallisation=0.5, aperture=20 * period
    )
    stator = fem.Stator(solid=solid, length=9 * period, thickness=0.7 * period, ends="absorbing")
    return Motor(stator=stator, transducers=(transducer,), frequency=frequency, position=6.1 * period)


def other_motor(motor: Motor, **changes) -> Motor:
    """Return the motor with a second transducer at the mirror image of the first."""
    first = motor.transducers[0]
    second = replace(first, name="right", center=motor.stator.length - first.center, **changes)
    return replace(motor, transducers=(first, second), position=motor.stator.length / 2)


def _at(frequency: float) -> Motor:
    """Return the motor at a frequency relative to its centre frequency."""
    motor = small_motor()
    return replace(motor, frequency=motor.frequency * frequency)


def _pairs(count: float) -> Motor:
    """Return the motor with a number of finger pairs, on a stator of the corresponding length."""
    motor = small_motor()
    period = motor.transducers[0].period
    extent = (count + 1) * period
    motor = motor.comb(finger_pairs=int(count), center=extent / 2 + period).section(length=extent + 6 * period)
    return replace(motor, position=extent + 3 * period)


def _long(wavelengths: float) -> Motor:
    """Return the motor with a length of bare surface, near whose end the motion is computed."""
    motor = small_motor()
    period = motor.transducers[0].period
    motor = motor.comb(center=1.5 * period).section(length=(3 + wavelengths) * period)
    return replace(motor, position=(2.9 + wavelengths) * period)


def _thick(wavelengths: float) -> Motor:
    motor = small_motor()
    return motor.section(thickness=wavelengths * motor.transducers[0].period)


def _lossless(motor: Motor) -> Motor:
    return motor.solid(mechanical_quality=math.inf, dielectric_loss=0.0)


def _sides(number: float) -> Motor:
    ends, bottom = SIDES[int(number)]
    return small_motor().section(ends=ends, bottom=bottom)


def _cut(number: float) -> Motor:
    return small_motor(*CUTS[int(number)])


def _stiff(factor: float) -> Motor:
    """Return the motor with a stiffness multiplied by a factor, at the frequency that keeps its size in wavelengths."""
    motor = small_motor()
    motor = motor.solid(stiffness=motor.stator.solid.stiffness * factor)
    return replace(motor, frequency=motor.frequency * math.sqrt(factor))


def _times(key: str) -> Callable[[float], Motor]:
    def motor(factor: float) -> Motor:
        base = small_motor()
        return base.solid(**{key: getattr(base.stator.solid, key) * factor})

    return motor


def _one(key: str) -> Callable[[float], Motor]:
    return lambda value: small_motor().solid(**{key: value})


def _near(singular: Callable[[Motor], float]) -> Callable[[float], Motor]:
    """Return a lossless plate at a relative distance from a frequency that is singular in its discretisation."""

    def motor(distance: float) -> Motor:
        plate = _lossless(small_motor())
        return replace(plate, frequency=singular(plate) * (1 + distance))

    return motor


# quantity: unit, values, motor as a function of the value, kind of reference (`tests/stability_cases.py`)
VARIED: dict[str, tuple[str, tuple, Callable[[float], Motor], str]] = {
    "mechanical quality": ("", (5.0, 20.0, 1e4, 1e6), _one("mechanical_quality"), "direct"),
    "mechanical quality, lossless": ("", (math.inf,), lambda _: _lossless(small_motor()), "finer"),
    "dielectric loss": ("", (0.0, 0.1, 1.0), _one("dielectric_loss"), "direct"),
    "metallisation": ("", (0.02, 0.1, 0.9), lambda share: small_motor().comb(metallisation=share), "direct"),
    "metallisation, narrow gaps": ("", (0.98,), lambda share: small_motor().comb(metallisation=share), "finer"),
    "thickness, thin": ("wavelengths", (0.05, 0.1, 0.2), _thick, "direct"),
    "thickness": ("wavelengths", (0.35, 1.0, 2.0), _thick, "direct"),
    "thickness, thick": ("wavelengths", (10.0, 20.0, 100.0), _thick, "finer"),
    "length": ("wavelengths", (0.5, 1.0, 10.0), _long, "direct"),
    "length, long": ("wavelengths", (100.0, 1000.0), _long, "finer"),
    "finger pairs": ("", (1.0, 10.0), _pairs, "direct"),
    "finger pairs, many": ("", (50.0, 200.0, 2000.0), _pairs, "finer"),
    "permittivity": ("times", (1e-3, 1e-2, 1e2, 1e3), _times("permittivity"), "direct"),
    "coupling": ("times", (1e-6, 1e-3, 2.0, 5.0), _times("coupling"), "direct"),
    "stiffness": ("times", (1e-3, 1e-1, 1e1, 1e3), _stiff, "finer"),
    "frequency over centre": ("", (4.5e-4, 0.05, 0.5, 2.0, 5.0, 12.0), _at, "finer"),
    "size": ("times", (1e-6, 1e-3, 1e3, 1e6), lambda factor: small_motor(stretch=factor), "size"),
    "ends and bottom": ("", tuple(range(len(SIDES))), _sides, "finer"),
    "whole section as one matrix": ("", (0, 1, 2, 4, 5), _sides, "direct"),
    "cut": ("", tuple(range(len(CUTS))), _cut, "finer"),
    "cut, half-space": ("", (0, 1, 3), lambda number: _cut(number).section(thickness=math.inf), "finer"),
    "cut, no loss": ("", tuple(range(len(CUTS))), lambda number: _lossless(_cut(number)), "finer"),
    "distance from a cut-off": ("", (0.0, 1e-12, 1e-9, 1e-6, 1e-3), _near(cut_off), "finer"),
    "distance from a piece's resonance": ("", (0.0, 1e-14, 1e-12, 1e-9, 1e-6), _near(piece_resonance), "finer"),
    "source impedance": (
        "ohm", (1e-9, 1.0, 1e3, 1e6, 1e9), lambda impedance: replace(small_motor(), source_impedance=impedance),
        "circuit",
    ),
    "termination": (
        "", tuple(range(len(TERMINATIONS))),
        lambda number: other_motor(small_motor(), termination=TERMINATIONS[int(number)]), "finer",
    ),
    "vacuum above, permittivity": (
        "times", (1e-2, 1.0, 1e2), lambda factor: _times("permittivity")(factor).section(above="vacuum"), "finer",
    ),
}  # fmt: skip


def compared(case: Case, tolerance: float) -> Comparison:
    """Return error, estimate and status of a case."""
    _, _, motor, reference = VARIED[case.varied]
    stored = None if reference == "finer" else stored_references()[case.varied, case.value]
    return compared_with_reference(motor(case.value), stored, tolerance, BALANCE)
