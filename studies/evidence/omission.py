"""A part that a model does without, and the same model with the part put back: how both are computed and compared.

Every pair answers one question twice through the Python API: ``without`` as the scene would, ``put_back`` with the part
in.  A field or a symmetry that is left out by inspection of the tensors is put back by an entry just above the noise of
the tables, so that its own effect stays below the rounding of the answer.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import contact
import fem
from studies.evidence.stability.contact import SLIDER
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
    """A part, what it is left out of, and both ways.

    Attributes
    ----------
    part : str
    question : str
        What is asked with and without it.
    without, put_back : callable
        -> Answered.
    allowed : float
        Largest relative difference: rounding, or the part's own size.
    why : str
        What ``allowed`` is.
    """

    part: str
    question: str
    without: Callable[[], Answered]
    put_back: Callable[[], Answered]
    allowed: float = ROUNDING
    why: str = "rounding"


def _motor(**solid):
    """The small motor of the stability study, on a solid with other constants."""
    motor = small_motor()
    return motor.solid(**solid) if solid else motor


def _solved(motor, level: int = 2) -> Answered:
    """Admittance and motion of one discretisation."""
    options = {"frequency": motor.frequency, "drive": motor.drive, "resolution": fem.LEVELS[level]}
    solution = fem.solve_driven(motor.stator, motor.transducers, **options)
    motion = fem.surface_of(solution).motion(motor.place) / 1e-10
    values = np.array([solution.circuit.admittance / 1e-3, *motion])
    return Answered(values=values, unknowns=solution.fields.unknowns)


def _with_stiffness(row: int, column: int, share: float):
    """The motor's solid with one more entry in its stiffness, relative to the largest."""
    motor = _motor()
    table = np.array(motor.stator.solid.stiffness)
    table[row, column] = table[column, row] = share * table.max()
    return motor.solid(stiffness=table)


def _free(**changes) -> Answered:
    """Velocity of the free wave of a plate of three wavelengths."""
    plain = fem.isotropic(name="isotropic", youngs_modulus=70e9, poisson_ratio=0.33, density=2700.0)
    block = fem.Stator(
        solid=replace(plain, **changes) if changes else plain, length=0.1, thickness=4e-3, ends="absorbing"
    )
    wave = fem.free_wave(block, frequency=2.2e6, tolerance=1e-6)
    return Answered(values=np.array([wave.velocity]), unknowns=wave.unknowns)


def _with_potential() -> Answered:
    permittivity = np.eye(3) * 1e-9
    coupling = np.zeros((3, 6))
    coupling[2, 2] = ENTRY * math.sqrt(1e11 * 1e-9)
    return _free(permittivity=permittivity, coupling=coupling)


def _bare() -> Answered:
    """Velocity of the surface mode without transducers."""
    motor = _motor()
    wave = fem.free_wave(motor.stator, frequency=motor.frequency, tolerance=1e-5)
    return Answered(values=np.array([wave.velocity]), unknowns=wave.unknowns)


def _driven_velocity() -> Answered:
    wave = _motor().wave(1e-4)
    return Answered(values=np.array([wave.phase_velocity]), unknowns=wave.unknowns)


def _pair(width: float):
    return other_motor(_motor(), metallisation=0.5 * (1 + width))


def _stretches_of_elements():
    """The motor with bare surface on either side of its fingers meshed like the gaps between them."""
    motor = _motor()
    return motor.comb(finger_pairs=6, pattern="0000+-+-0000")


def _far_ends():
    """The motor of a solid that loses much, its free ends too far for an echo, and its absorbing ends beside it."""
    motor = _motor(mechanical_quality=20.0)
    away = 300 * motor.transducers[0].period
    far = motor.section(length=motor.stator.length + 2 * away, ends="free")
    far = far.comb(center=motor.transducers[0].center + away)
    return replace(far, place=motor.place + away)


def _interior(kept: bool) -> Answered:
    motor = _motor()
    wave = motor.wave(1e-3)
    values = np.array([wave.admittance / 1e-3, *(wave.motion(motor.place) / 1e-10)])
    field = fem.wave_field(wave) if kept else None
    extra = 0 if field is None else int(np.size(field.displacement))
    return Answered(values=values, unknowns=wave.unknowns + extra)


SHARED = ("mass", "preload", "load", "normal_damping", "tangential_damping")


def _orbits(count: int = 1):
    return (contact.Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j),) * count


def _steady(orbits, *, method: str = "exact", tolerance: float = 1e-9, **changes) -> Answered:
    state = contact.steady(contact.Slider(**SLIDER | changes), orbits, tolerance=tolerance, method=method)
    return Answered(values=np.array([state.velocity]), unknowns=4 * len(orbits))


def _one_for_three() -> Answered:
    shared: dict[str, Any] = {name: SLIDER[name] / 3 for name in SHARED}
    return _steady(_orbits(), **shared)


def _from_rest() -> Answered:
    """Velocity at the end of a burst so long that nothing of the start is left."""
    slider = contact.Slider(**SLIDER | {"tangential_damping": 0.05})
    motion = contact.burst(slider, _orbits(), duration=0.05, after=0.0, tolerance=1e-3, method="averaged", samples=10)
    return Answered(values=np.array([motion.velocity_at_burst_end]), unknowns=4)


def _with_history() -> Answered:
    slider, orbits = contact.Slider(**SLIDER), _orbits()
    state = contact.steady(slider, orbits, tolerance=1e-9, method="exact")
    history = contact.contact_history(slider, orbits, stage="steady", skip=0.0, cycles=20.0, points_per_cycle=500.0)
    return Answered(values=np.array([state.velocity]), unknowns=4 + np.size(history.time))


OMISSIONS = (
    Omission(
        part="out-of-plane displacement",
        question="admittance and motion of a driven plate of hard PZT",
        without=lambda: _solved(_motor(), 1),
        put_back=lambda: _solved(_with_stiffness(0, 3, ENTRY), 1),
    ),
    Omission(
        part="electric potential",
        question="velocity of the free wave of an isotropic plate",
        without=_free,
        put_back=_with_potential,
    ),
    Omission(
        part="complex arithmetic in the pieces",
        question="admittance and motion of a driven plate without loss",
        without=lambda: _solved(_motor(mechanical_quality=math.inf, dielectric_loss=0.0), 1),
        put_back=lambda: _solved(_motor(mechanical_quality=1e16, dielectric_loss=0.0), 1),
        allowed=1e-10,
        why="rounding; the section without loss has poles near by, 1.5e-11 seen",
    ),
    Omission(
        part="half of the guided-mode problem",
        question="admittance and motion of a driven plate of hard PZT",
        without=lambda: _solved(_motor(), 1),
        put_back=lambda: _solved(_with_stiffness(0, 4, TILT), 1),
        allowed=1e-11,
        why="the tilt that breaks the symmetry, 2e-12 of the stiffness, times the mechanical quality",
    ),
    Omission(
        part="a second, equal transducer's pieces",
        question="admittance and motion of a driven plate with two transducers",
        without=lambda: _solved(_pair(0.0)),
        put_back=lambda: _solved(_pair(1e-14)),
    ),
    Omission(
        part="elements in the uniform stretches",
        question="admittance and motion of a driven plate of hard PZT",
        without=lambda: _solved(_motor(), 3),
        put_back=lambda: _solved(_stretches_of_elements(), 3),
        allowed=1e-6,
        why="the error of those elements, order 8",
    ),
    Omission(
        part="absorbing layers at the ends",
        question="admittance and motion of a driven plate of Q = 20",
        without=lambda: _solved(_motor(mechanical_quality=20.0)),
        put_back=lambda: _solved(_far_ends()),
    ),
    Omission(
        part="electrodes",
        question="velocity of the surface mode of a plate of hard PZT",
        without=_bare,
        put_back=_driven_velocity,
        allowed=1e-5,
        why="the tolerance of both",
    ),
    Omission(
        part="vacuum above",
        question="admittance and motion of a driven plate of hard PZT",
        without=lambda: _solved(_motor()),
        put_back=lambda: _solved(_motor().section(above="vacuum")),
        allowed=5e-3,
        why="its own size: permittivity of vacuum over that of the solid, times the plate's resonance",
    ),
    Omission(
        part="interior field",
        question="admittance and motion of a driven plate of hard PZT",
        without=lambda: _interior(False),
        put_back=lambda: _interior(True),
    ),
    Omission(
        part="two of three contacts in phase",
        question="steady velocity at 5 nm",
        without=_one_for_three,
        put_back=lambda: _steady(_orbits(3)),
        allowed=1e-8,
        why="the tolerance of both",
    ),
    Omission(
        part="history output",
        question="steady velocity at 5 nm",
        without=lambda: _steady(_orbits()),
        put_back=_with_history,
    ),
    Omission(
        part="motion from rest",
        question="steady velocity at 5 nm, a strong damper",
        without=lambda: _steady(_orbits(), tangential_damping=0.05),
        put_back=_from_rest,
        allowed=2e-3,
        why="the tolerance of the burst",
    ),
    Omission(
        part="normal and tangential dynamics within a cycle",
        question="steady velocity at 5 nm",
        without=lambda: _steady(_orbits(), method="averaged", tolerance=1e-3),
        put_back=lambda: _steady(_orbits()),
        allowed=1e-4,
        why="its own size: the squared ratio of bounce to wave frequency",
    ),
    Omission(
        part="hysteresis memory",
        question="steady velocity at 5 nm",
        without=lambda: _steady(_orbits(), tolerance=1e-6),
        put_back=lambda: _steady(_orbits(), tolerance=1e-6, law="hysteretic"),
        allowed=0.1,
        why="its own size: another law",
    ),
    Omission(
        part="the spring's reaction on the normal motion",
        question="steady velocity at 5 nm",
        without=lambda: _steady(_orbits(), tolerance=1e-6),
        put_back=lambda: _steady(_orbits(), tolerance=1e-6, reciprocal=True),
        allowed=0.1,
        why="its own size: another law",
    ),
)
