"""Terms omitted from a model, and the full model for comparison.

Each pair computes one quantity twice through the Python API: ``without`` the part, as a scene does, and with the part
``included``.  A field or a symmetry that is omitted because entries of the tensors are zero is included by an entry
just above the noise of the material tables, so that its effect stays below the rounding of the answer.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

import contact
import fem
from studies.evidence.stability.extreme_contacts import SLIDER
from studies.evidence.stability.stator import other_motor, small_motor

ROUNDING = 2e-11  # of joined pieces, on the machines seen: up to 4e-12
ENTRY = 2e-10  # relative: just above what fem.fields takes for rounding
TILT = 2e-12  # relative: what breaks the mirror symmetry of the section


@dataclass(frozen=True, kw_only=True)
class Answered:
    """An answer and the unknowns behind it."""

    values: np.ndarray
    unknowns: int


@dataclass(frozen=True, kw_only=True)
class Omission:
    """A part of a model, and the computation of a quantity without and with it."""

    part: str
    question: str  # the quantity
    without: Callable[[], Answered]
    included: Callable[[], Answered]
    allowed: float = ROUNDING  # largest relative difference: rounding, or the size of the part's effect
    why: str = "rounding"  # reason for ``allowed``


def _motor(**solid):
    """Return the small motor of the stability study, with other constants of its solid."""
    return small_motor().solid(**solid)


def _solved(motor, level: int = 2) -> Answered:
    """Return admittance and motion of one discretisation."""
    options = {"frequency": motor.frequency, "drive": motor.drive, "resolution": fem.LEVELS[level]}
    solution = fem.solve_driven(motor.stator, motor.transducers, **options)
    motion = fem.surface_of(solution).motion(motor.position) / 1e-10
    values = np.array([solution.circuit.admittance / 1e-3, *motion])
    return Answered(values=values, unknowns=solution.fields.unknowns)


def _with_stiffness(row: int, column: int, share: float):
    """Return the motor with one more entry in its stiffness, relative to the largest."""
    motor = _motor()
    table = np.array(motor.stator.solid.stiffness)
    table[row, column] = table[column, row] = share * table.max()
    return motor.solid(stiffness=table)


def _free(**changes) -> Answered:
    """Return the velocity of the free wave of a plate of three wavelengths."""
    plain = fem.isotropic(name="isotropic", youngs_modulus=70e9, poisson_ratio=0.33, density=2700.0)
    block = fem.Stator(solid=replace(plain, **changes), length=0.1, thickness=4e-3, ends="absorbing")
    wave = fem.free_wave(block, frequency=2.2e6, tolerance=1e-6)
    return Answered(values=np.array([wave.velocity]), unknowns=wave.unknowns)


def _with_potential() -> Answered:
    coupling = np.zeros((3, 6))
    coupling[2, 2] = ENTRY * math.sqrt(1e11 * 1e-9)
    return _free(permittivity=np.eye(3) * 1e-9, coupling=coupling)


def _bare() -> Answered:
    """Return the velocity of the surface mode without transducers."""
    motor = _motor()
    wave = fem.free_wave(motor.stator, frequency=motor.frequency, tolerance=1e-5)
    return Answered(values=np.array([wave.velocity]), unknowns=wave.unknowns)


def _driven_velocity() -> Answered:
    wave = _motor().wave(1e-4)
    return Answered(values=np.array([wave.phase_velocity]), unknowns=wave.unknowns)


def _pair(width: float):
    return other_motor(_motor(), metallisation=0.5 * (1 + width))


def _segments_of_elements():
    """Return the motor with bare surface on either side of its fingers meshed like the gaps between them."""
    motor = _motor()
    return motor.comb(finger_pairs=6, pattern="0000+-+-0000")


def _far_ends():
    """Return the motor of a lossy solid with free ends that are too far away for an echo, for absorbing ends."""
    motor = _motor(mechanical_quality=20.0)
    away = 300 * motor.transducers[0].period
    far = motor.section(length=motor.stator.length + 2 * away, ends="free")
    far = far.comb(center=motor.transducers[0].center + away)
    return replace(far, position=motor.position + away)


def _interior(with_field: bool) -> Answered:
    motor = _motor()
    wave = motor.wave(1e-3)
    values = np.array([wave.admittance / 1e-3, *(wave.motion(motor.position) / 1e-10)])
    field = fem.wave_field(wave) if with_field else None
    extra = 0 if field is None else int(np.size(field.displacement))
    return Answered(values=values, unknowns=wave.unknowns + extra)


SHARED = ("mass", "preload", "load", "normal_damping", "tangential_damping")


def _orbits(count: int = 1):
    return (contact.Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j),) * count


def _steady(orbits, *, method: str = "exact", tolerance: float = 1e-9, **changes) -> Answered:
    state = contact.steady(contact.Slider(**SLIDER | changes), orbits, tolerance=tolerance, method=method)
    return Answered(values=np.array([state.velocity]), unknowns=4 * len(orbits))


def _one_for_three() -> Answered:
    shared = {name: SLIDER[name] / 3 for name in SHARED}
    return _steady(_orbits(), **shared)


def _from_rest() -> Answered:
    """Return the velocity at the end of a burst that is long compared with the start."""
    slider = contact.Slider(**SLIDER | {"tangential_damping": 0.05})
    motion = contact.burst(slider, _orbits(), duration=0.05, after=0.0, tolerance=1e-3, method="averaged", samples=10)
    return Answered(values=np.array([motion.velocity_at_burst_end]), unknowns=4)


def _with_history() -> Answered:
    slider, orbits = contact.Slider(**SLIDER), _orbits()
    state = contact.steady(slider, orbits, tolerance=1e-9, method="exact")
    history = contact.contact_history(slider, orbits, stage="steady", skip=0.0, cycles=20.0, points_per_cycle=500.0)
    return Answered(values=np.array([state.velocity]), unknowns=4 + np.size(history.time))


DRIVEN_PZT = "admittance and motion of a driven plate of hard PZT"
STEADY = "steady velocity at 5 nm"
OMISSIONS = (
    Omission(part="out-of-plane displacement", question=DRIVEN_PZT,
             without=lambda: _solved(_motor(), 1), included=lambda: _solved(_with_stiffness(0, 3, ENTRY), 1)),
    Omission(part="electric potential", question="velocity of the free wave of an isotropic plate",
             without=_free, included=_with_potential),
    Omission(part="complex arithmetic in the pieces", question="admittance and motion of a driven plate without loss",
             without=lambda: _solved(_motor(mechanical_quality=math.inf, dielectric_loss=0.0), 1),
             included=lambda: _solved(_motor(mechanical_quality=1e16, dielectric_loss=0.0), 1),
             allowed=1e-10, why="rounding; the section without loss has poles near by, 1.5e-11 seen"),
    Omission(part="half of the guided-mode problem", question=DRIVEN_PZT,
             without=lambda: _solved(_motor(), 1), included=lambda: _solved(_with_stiffness(0, 4, TILT), 1),
             allowed=1e-11,
             why="the tilt that breaks the symmetry, 2e-12 of the stiffness, times the mechanical quality"),
    Omission(part="a second, equal transducer's pieces",
             question="admittance and motion of a driven plate with two transducers",
             without=lambda: _solved(_pair(0.0)), included=lambda: _solved(_pair(1e-14))),
    Omission(part="elements in the uniform segments", question=DRIVEN_PZT,
             without=lambda: _solved(_motor(), 3), included=lambda: _solved(_segments_of_elements(), 3),
             allowed=1e-6, why="the error of those elements, order 8"),
    Omission(part="absorbing layers at the ends", question="admittance and motion of a driven plate of Q = 20",
             without=lambda: _solved(_motor(mechanical_quality=20.0)), included=lambda: _solved(_far_ends())),
    Omission(part="electrodes", question="velocity of the surface mode of a plate of hard PZT",
             without=_bare, included=_driven_velocity,
             allowed=1e-5, why="the tolerance of both"),
    Omission(part="vacuum above", question=DRIVEN_PZT,
             without=lambda: _solved(_motor()), included=lambda: _solved(_motor().section(above="vacuum")),
             allowed=5e-3,
             why="its own size: permittivity of vacuum over that of the solid, times the plate's resonance"),
    Omission(part="interior field", question=DRIVEN_PZT,
             without=lambda: _interior(False), included=lambda: _interior(True)),
    Omission(part="two of three contacts in phase", question=STEADY,
             without=_one_for_three, included=lambda: _steady(_orbits(3)),
             allowed=1e-8, why="the tolerance of both"),
    Omission(part="history output", question=STEADY,
             without=lambda: _steady(_orbits()), included=_with_history),
    Omission(part="motion from rest", question="steady velocity at 5 nm, a strong damper",
             without=lambda: _steady(_orbits(), tangential_damping=0.05), included=_from_rest,
             allowed=2e-3, why="the tolerance of the burst"),
    Omission(part="normal and tangential dynamics within a cycle", question=STEADY,
             without=lambda: _steady(_orbits(), method="averaged", tolerance=1e-3), included=lambda: _steady(_orbits()),
             allowed=1e-4, why="its own size: the squared ratio of bounce to wave frequency"),
    Omission(part="hysteresis memory", question=STEADY,
             without=lambda: _steady(_orbits(), tolerance=1e-6),
             included=lambda: _steady(_orbits(), tolerance=1e-6, law="hysteretic"),
             allowed=0.1, why="its own size: another law"),
    Omission(part="the spring's reaction on the normal motion", question=STEADY,
             without=lambda: _steady(_orbits(), tolerance=1e-6),
             included=lambda: _steady(_orbits(), tolerance=1e-6, reciprocal=True),
             allowed=0.1, why="its own size: another law"),
)  # fmt: skip
