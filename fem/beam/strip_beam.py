"""Apodised and slanted transducers as strips along y, each a section of its own, electrically in parallel.

Between two lines y at which a finger begins or ends, every finger has one sign and one place: a strip
(`fem.geometry.strips_of`).  Its plane section has the admittance Y_s, in proportion to its width.  The electrodes join
the strips, so that

    Y = sum_s Y_s,    u(x, y) = sum_s u_s(x, y),                                                                  (1)

with u_s the motion of the strip's section at the voltages of the common circuit.  In the plane section u_s is zero
beside the strip; with beams it is the field of the section's charges on fingers as long as the strip is wide.  What one
transducer sends to another passes along the strip, without spreading.

In a solid isotropic about z the change of the charges by the finite aperture and by the tips of the fingers, and the
spreading between transducers, are then added in the mean over y and -y, where all fingers are straight:

    Y = sum_s Y_s + sum_e w_e (Y_own - Y_plane)_e,    u = sum_s u_s + sum_e w_e (u_own - u_plane)_e,              (2)

with "own" the answer of fingers whose charge is a sum of sheets (own_aperture.py), and "plane" that of the same fingers
with the charges and waves of the section, which is the even part of (1) exactly.  Of a slanted transducer the fingers
are those at both ends of the aperture, each with half the weight w_e, because there the charge changes.

The fingers and their dummies are the same metal in all strips of an apodised transducer, which differ in the electrode
that each finger is on: their sections follow from one solution with a potential for each finger (`_section_of`).

The classical model of apodised transducers by strips of equal overlap (Tancrell and Holland, Proc. IEEE 59, 1971, 393;
Hartmann, Bell and Rosenfeld, IEEE Trans. Microwave Theory Tech. 21, 1973, 162), with the reflections inside each strip.
Left out: in the plane section and in other cuts the charge at the ends and tips of fingers; at the tips gaps of other
widths than between fingers.
"""

from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np

from fem.beam.beam_of_section import aperture_beam, beam_refusal
from fem.beam.crossed_beam import Solve
from fem.beam.reception import with_apertures
from fem.beam.surface_beam import BeamError, SurfaceBeam
from fem.circuit import Circuit, Drive, as_drive, solve_circuit
from fem.condense.electrode_conditions import is_port
from fem.condense.finger_columns import FingerColumns
from fem.exceptions import InputError
from fem.geometry import LateralStrip, Stator, Transducer, strips_of
from fem.materials import isotropic_about_normal
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.stator_solution import driven_solution
from fem.waveguide.port_fields import PortFields, by_finger, with_other_signs


class Straightened(NamedTuple):
    """Beams of the straight fingers of equation (2)."""

    weight: float
    own: SurfaceBeam
    plane: SurfaceBeam


# Share of what equation (2) adds that remains as an error.  Apodised: 0.01 to 0.1 at the largest (boundary elements,
# tests/validation/test_finite_fingers.py).  Slanted: assumed, because no truth is known.
STRAIGHT, SLANTED = 0.15, 0.5


@dataclass(frozen=True, kw_only=True)
class StripBeam:
    """Surface motion of transducers that are not uniform along y.

    Attributes
    ----------
    strips : tuple of LateralStrip
        Those with a voltage, from -y to +y.
    waves : tuple of SurfaceWave
        Solution of the section of each, at the voltages of the circuit.
    beams : tuple of SurfaceBeam
        Field in three dimensions of each; empty in the plane section.
    straightened : tuple of Straightened
        What is added by equation (2).
    circuit : Circuit
        Voltages and currents of all ports.
    length : float
        Of the surface, m.
    """

    strips: tuple[LateralStrip, ...]
    waves: tuple[SurfaceWave, ...] = field(repr=False)
    beams: tuple[SurfaceBeam, ...] = field(repr=False)
    circuit: Circuit
    length: float
    straightened: tuple[Straightened, ...] = field(default=(), repr=False)

    @property
    def wave(self) -> SurfaceWave:
        """Solution of the section of the strip next to y = 0."""
        return self.waves[int(np.argmin([abs(each.low + each.high) for each in self.strips]))]

    @property
    def spreads(self) -> bool:
        """True if the strips' waves spread as beams."""
        return bool(self.beams)

    def in_section(self, x: float, y: float) -> float:
        """Coordinate x in m, in the section `wave`, of a point (x, y) in m."""
        return x

    @property
    def surface_mode(self) -> "StripBeam":
        """The same strips with the field of the surface wave alone; with beams only."""
        straightened = tuple(
            each._replace(own=each.own.surface_mode, plane=each.plane.surface_mode) for each in self.straightened
        )
        return replace(self, beams=tuple(each.surface_mode for each in self.beams), straightened=straightened)

    @property
    def pictured(self) -> "StripBeam":
        """The same strips for a picture, as `SurfaceBeam.pictured`."""
        return replace(self, beams=tuple(each.pictured for each in self.beams))

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V at points (x, y) in m, shape (3, *shape of x and y); equation (1)."""
        return self.motion_and_error(x, y)[0]

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Sum of the strips' errors over max(|u_x|, |u_z|) at each point."""
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion` and `relative_error` at once."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        total, error = np.zeros((3, *x.shape), dtype=complex), np.zeros(x.shape)
        for number, strip in enumerate(self.strips):
            if self.beams:
                motion, relative = self.beams[number].motion_and_error(x, y)
            else:
                tangential, normal = self.waves[number].motion(x)
                inside = (y >= strip.low) & (y < strip.high)
                motion = np.array([tangential, np.zeros_like(normal), normal]) * inside
                relative = self.waves[number].relative_error
            total = total + motion
            error = error + relative * abs(motion[[0, 2]]).max(axis=0)
        total = total + self._added(x, y)
        size = abs(total[[0, 2]]).max(axis=0)
        return total, np.divide(error, size, out=np.zeros_like(error), where=size > 0.0)

    def _added(self, x, y):
        """Motion by the finite aperture and the tips of the fingers, m per V; 0 where it is not computed."""
        return sum(each.weight * (each.own.motion(x, y) - each.plane.motion(x, y)) for each in self.straightened)

    def charge_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray | None:
        """Relative error of |u_z| by the approximate charge at the ends and tips of the fingers; None if left out."""
        if not self.straightened:
            return None
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        share = STRAIGHT if len(self.straightened) == 1 else SLANTED
        return share * abs(self._added(x, y)[2]) / abs(self.motion(x, y)[2])

    def first_images(self, x: float | np.ndarray, y: float | np.ndarray, width: float) -> np.ndarray:
        """Sum of |u_z| in m per V of the first images in two side faces ``width`` (m) apart, at points (x, y) in m."""
        return np.sum([abs(self.motion(x, side * width - np.asarray(y))[2]) for side in (1.0, -1.0)], axis=0)

    @cached_property
    def power(self) -> PowerBalance:
        """Power balance summed over the strips' sections; the loads take what the circuit's other ports take."""
        parts, circuit = [each.power for each in self.waves], self.circuit
        powers = 0.5 * np.real(circuit.voltages * np.conj(circuit.currents))
        loads = -sum(
            float(each) for name, each in zip(circuit.names, powers, strict=True) if name not in circuit.driven
        )
        solid, left, right = (sum(getattr(each, key) for each in parts) for key in ("solid", "left", "right"))
        missing = abs(sum(each.input for each in parts) - solid - left - right)
        return PowerBalance(
            input=circuit.power, solid=solid, loads=loads, left=left, right=right,
            imbalance=max(missing, *(each.imbalance for each in parts)),
            apparent=circuit.apparent_power,  # that of a strip with little voltage is rounding
        )  # fmt: skip


def strip_beam(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    drive: str | Drive,
    solve: Solve,
    places: tuple[float, ...] = (),
    spreads: bool = True,
) -> StripBeam:
    """Field of transducers of which some are apodised or slanted.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Along x, about the middle line.
    frequency : float
        Hz.
    drive : str or Drive
    solve : callable
        Solver of one section, as for `fem.crossed_beam`.
    places : tuple of float
        x in m at which the error matters; mid-stator if empty.
    spreads : bool
        False for the plane sections of the strips.

    Raises
    ------
    BeamError
        If the field in three dimensions is not computed, `fem.beam_refusal`.
    InputError
        If a transducer is turned or beside the middle line, or has fingers of one electrode only in all strips.
    """
    if spreads and (refusal := beam_refusal(stator)):
        raise BeamError(refusal)
    if spreads and stator.ends != "absorbing":
        raise BeamError(f"the beams of strips need stator.ends = 'absorbing', got {stator.ends!r}")
    names = tuple(each.name for each in sorted(transducers, key=lambda each: each.center) if is_port(each))
    solved, admittances = [], np.zeros((len(names), len(names)), dtype=complex)
    of_fingers: dict[tuple[Transducer, ...], _OfFingers] = {}
    for strip in strips_of(transducers):
        if not any(map(is_port, strip.transducers)):
            continue
        wave = _section_of(stator, strip, solve, places, of_fingers)
        fields = wave.solution.fields
        at = [names.index(name) for name in fields.names]
        admittances[np.ix_(at, at)] += fields.admittances
        solved.append((strip, wave))
    straight = _straight(stator, transducers, names, solve, places) if spreads else []
    admittances += sum(each.weight * (each.own.admittances - each.plane.admittances) for each in straight)
    drive = as_drive(drive)
    circuit = solve_circuit(admittances, names, transducers, drive, frequency)
    volts = dict(zip(circuit.names, circuit.voltages, strict=True))
    kept, waves = [], []
    for strip, wave in solved:
        fields = wave.solution.fields
        sources = {name: complex(volts[name]) for name in fields.names}
        if not any(sources.values()):
            continue
        solution = driven_solution(fields, Drive(sources=sources))
        kept.append(strip)
        waves.append(
            surface_wave(
                solution, relative_error=wave.relative_error, admittance_error=wave.admittance_error,
                balance=partial(power_balance, solution),
            )
        )  # fmt: skip
    if not kept:
        raise InputError("drive", "must drive a transducer with fingers of both electrodes")
    beams = tuple(aperture_beam(wave, wave.solution) for wave in waves) if spreads else ()
    together = Drive(sources={name: complex(volts[name]) for name in names})
    straightened = tuple(
        Straightened(
            each.weight, *(aperture_beam(each.wave, driven_solution(own, together)) for own in (each.own, each.plane))
        )
        for each in straight
    )
    return StripBeam(
        strips=tuple(kept), waves=tuple(waves), beams=beams, circuit=circuit, length=stator.length,
        straightened=straightened,
    )  # fmt: skip


class _OfFingers(NamedTuple):
    """Solution of plain fingers, and their superelements with one potential for each finger."""

    wave: SurfaceWave
    pieces: list[FingerColumns]


def _section_of(
    stator: Stator,
    strip: LateralStrip,
    solve: Solve,
    places: tuple[float, ...],
    solved: dict[tuple[Transducer, ...], _OfFingers],
) -> SurfaceWave:
    """Solution of a strip's section for 1 V at each port; ``solved``: those of plain fingers at the same places.

    Strips of an apodised transducer differ only in which electrode each finger is on.
    """
    drive = Drive(sources={each.name: 1.0 for each in strip.transducers if is_port(each)})
    plain = tuple(replace(each, pattern=None, center_y=0.0, aperture=1.0) for each in strip.transducers)
    left_out = any(set(each.signs) - {"+", "-"} for each in strip.transducers)
    if left_out or not all(map(is_port, plain)):
        return solve(stator, strip.transducers, drive, places)
    if plain not in solved:
        wave = solve(stator, plain, Drive(sources={each.name: 1.0 for each in plain}), places)
        solved[plain] = _OfFingers(wave, by_finger(wave.solution.fields))
    wave, pieces = solved[plain]
    solution = driven_solution(with_other_signs(wave.solution.fields, pieces, strip.transducers), drive)
    return surface_wave(
        solution, relative_error=wave.relative_error, admittance_error=wave.admittance_error,
        balance=partial(power_balance, solution),
    )  # fmt: skip


class _Straight(NamedTuple):
    """Solutions of straight fingers for 1 V at each port."""

    weight: float
    wave: SurfaceWave
    own: PortFields
    plane: PortFields


def _straight(
    stator: Stator, transducers: tuple[Transducer, ...], names: tuple[str, ...], solve: Solve, places: tuple[float, ...]
) -> list[_Straight]:
    """Return the straight fingers of equation (2); none in a solid that is not isotropic about z."""
    if not isotropic_about_normal(stator.solid):
        return []
    slanted = any(each.slant for each in transducers)
    reaches = {each.name: each.overlaps for each in transducers if each.overlaps is not None}
    found = []
    for end in (-1.0, 1.0) if slanted else (0.0,):
        row = tuple(
            replace(each, overlaps=None, slant=0.0, period=each.period * (1.0 + each.slant * end / 2))
            for each in transducers
        )
        wave = solve(stator, row, Drive(sources=dict.fromkeys(names, 1.0)), places)
        own, plane = (with_apertures(wave.solution.fields, reaches=reaches, plane=plane) for plane in (False, True))
        found.append(_Straight(0.5 if slanted else 1.0, wave, own, plane))
    return found
