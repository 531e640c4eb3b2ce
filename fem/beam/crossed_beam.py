"""Surface motion of transducers that are rotated about the surface normal or lie beside one another.

Parallel transducers that lie one behind the other, so that one section can contain them, form a group.  In a solid
isotropic about z every group is a section problem of the same stator in its own axes, s along its waves and t across.
Each group sends a `SurfaceBeam` in its axes, and the beams add up.  The groups are coupled through their charges
(parallel_groups.py).

Two effects between groups are neglected: the scattering of one group's beam by the fingers of another group (to that
beam the surface is bare there), and the electrostatic coupling of the groups.  Scattering within a group is included
(reception.py).
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fem.beam.beam_of_section import aperture_beam
from fem.beam.parallel_groups import (
    ParallelGroup,
    admittances_of_groups,
    driven_names,
    group_circuit,
    group_drive,
    rows_of,
)
from fem.beam.reception import with_apertures
from fem.beam.surface_beam import BeamError, SurfaceBeam
from fem.circuit import Circuit, Drive, as_drive, solve_circuit
from fem.condense.electrode_conditions import is_port
from fem.geometry import Stator, Transducer, one_electrode
from fem.layout import TURNED, check_plan, check_turned
from fem.parameters import InputError
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.stator_solution import Solution

# In a group at an oblique angle every point has its own s, which makes direct evaluation expensive.  More than FEW
# points are therefore interpolated by splines of order 5 from a grid in s and t with PER_WAVELENGTH lines per
# wavelength, which extends MARGIN lines beyond the points.  Points within CLEAR wavelengths of the fingers are
# evaluated directly, because the field has kinks there.  The error is 3e-5 of the largest amplitude
# (test_passive_transducers.py).
FEW, PER_WAVELENGTH, MARGIN, CLEAR = 500, 9, 12, 2.0
# A face ends a beam if the angle between the beam and the face's normal has at least this cosine, that of 45 degrees:
# it stands more across the beam than along it.  Less by rounding, so that all four faces end a beam at 45 degrees.
END_COSINE = np.sqrt(0.5) - 1e-9

Solve = Callable[[Stator, tuple[Transducer, ...], Drive, tuple[float, ...]], SurfaceWave]


@dataclass(frozen=True, kw_only=True)
class CrossedBeam:
    """Surface motion of several groups of transducers.

    Attributes
    ----------
    rows : tuple of ParallelGroup
        Groups of parallel transducers; the first is the driven one whose waves run nearest to x.
    beams : tuple of SurfaceBeam
        One per group, in the axes of the group.
    circuit : Circuit
        Voltages and currents of all ports.
    length, width : float
        Size of the surface, m.
    """

    rows: tuple[ParallelGroup, ...]
    beams: tuple[SurfaceBeam, ...] = field(repr=False)
    circuit: Circuit
    length: float
    width: float

    @property
    def wave(self) -> SurfaceWave:
        """Solution of the first group's section."""
        return self.beams[0].wave

    def in_section(self, x: float, y: float) -> float:
        """Coordinate s in m, in the section `wave`, of a point (x, y) in m."""
        return float(self.rows[0].local(x, y)[0])

    @property
    def surface_mode(self) -> "CrossedBeam":
        """The same beam with the field of the surface wave alone."""
        return replace(self, beams=tuple(each.surface_mode for each in self.beams))

    @property
    def pictured(self) -> "CrossedBeam":
        """The same beam for a picture, as `SurfaceBeam.pictured`."""
        return replace(self, beams=tuple(each.pictured for each in self.beams))

    @property
    def _active(self) -> list[tuple[ParallelGroup, SurfaceBeam]]:
        """Groups with a voltage at one port at least, and their beams; the other groups send no wave."""
        pairs = zip(self.rows, self.beams, strict=True)
        return [(group, beam) for group, beam in pairs if np.any(beam.circuit.voltages)]

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V at points (x, y) in m, as `SurfaceBeam.motion`.

        The beam of a group at an oblique angle is interpolated if there are many points, except near its own fingers.
        """
        return sum(self.motions(x, y), np.zeros(()))

    def motions(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> list[np.ndarray]:
        """`motion` of the beam of each direction, those of groups without a voltage left out."""
        return [group.rotated(self._of_group(group, beam.motion, x, y)) for group, beam in self._active]

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Sum of the beams' errors over max(|u_x|, |u_z|) at each point."""
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion` and `relative_error` at once."""
        total: np.ndarray = np.zeros(())
        error: np.ndarray = np.zeros(())
        for group, beam in self._active:

            def motion_above_error(s, t, beam=beam):
                motion, relative = beam.motion_and_error(s, t)
                return np.vstack([motion, relative * abs(motion[[0, 2]]).max(axis=0)])

            values = self._of_group(group, motion_above_error, x, y)
            total = total + group.rotated(values[:3])
            error = error + values[3].real
        return total, error / abs(total[[0, 2]]).max(axis=0)

    @cached_property
    def power(self) -> PowerBalance:
        """Power balance summed over the groups; power sent from group to group is part of the circuit's input."""
        parts = [power_balance(each.solution) for _, each in self._active]
        return PowerBalance(
            input=self.circuit.power,
            solid=sum(each.solid for each in parts),
            loads=sum(each.loads for each in parts),
            left=sum(each.left for each in parts),
            right=sum(each.right for each in parts),
            imbalance=max(each.imbalance for each in parts),
            apparent=self.circuit.apparent_power,  # that of a group without a source is rounding, or zero
        )

    def incoherent_amplitude(self, x: float | np.ndarray, y: float | np.ndarray) -> np.ndarray:
        """Root of the sum of |u_z|^2 of all beams in m per V, which has no nodes, at points (x, y) in m."""
        return np.sqrt(sum(abs(each[2]) ** 2 for each in self.motions(x, y)))

    def first_images(self, x: float | np.ndarray, y: float | np.ndarray) -> np.ndarray:
        """Sum of |u_z| in m per V of the first images of all beams in their side faces, at points (x, y) in m.

        The side faces of a beam are those along which it runs.  Those at which it is aimed, `END_COSINE`, are its ends,
        which absorb.
        """
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        total: np.ndarray = np.zeros(x.shape)
        for group, beam in self._active:
            along = np.cos(group.angle), np.sin(group.angle)
            images: list = []
            if abs(along[0]) < END_COSINE:
                images += [(-x, y), (2.0 * self.length - x, y)]
            if abs(along[1]) < END_COSINE:
                images += [(x, self.width - y), (x, -self.width - y)]
            for image in images:
                s, t = group.local(*image)
                total = total + abs(beam.motion(np.clip(s, 0.0, group.stator.length), t)[2])
        return total

    def charge_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray | None:
        """`SurfaceBeam.charge_error` for the sum of all beams."""
        total, x, y = 0.0, np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        for group, beam in self._active:
            s, t = group.local(x, y)
            relative = beam.charge_error(s, t)
            if relative is None:
                return None
            total = total + relative * abs(beam.motion(s, t)[2])
        return total / abs(self.motion(x, y)[2])

    def shadowed(self, slowing: float) -> float:
        """Estimated change of u_z, in m per V, by the metal of other groups, which this model neglects.

        It is the sum over all transducers of other groups of |u_z| at their centre times min(phi, 2), which bounds
        |exp(i phi) - 1|; phi is the phase shift by their metal.  ``slowing``: relative reduction of the velocity there.
        """
        total = 0.0
        for group, beam in self._active:
            wavenumber = 2 * np.pi * beam.wave.frequency / beam.wave.phase_velocity
            for other in self.rows:
                for each in other.transducers if other is not group else ():
                    # distance that the wave travels below the transducer: its sides projected on the wave's direction
                    direction = np.sin(group.angle - other.angle), np.cos(group.angle - other.angle)
                    distance = abs(np.array(direction)) @ [each.aperture, np.ptp(each.extent)]
                    size = abs(self._of_group(group, beam.motion, *other.middle_of(each))[2])
                    total += size * min(wavenumber * distance * each.metallisation * slowing, 2.0)
        return float(total)

    def _of_group(self, group: ParallelGroup, evaluate, x, y) -> np.ndarray:
        """Values of ``evaluate(s, t)``, shape (n, points), of a group's beam at points (x, y) in m.

        The shape is (n, *shape of x and y).  Many points between the transducers of an oblique group are interpolated.
        """
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        if not np.all((x >= 0) & (x <= self.length) & (abs(y) <= self.width / 2)):
            raise BeamError(
                f"points must lie on the stator, x from 0 to {self.length:g} m and y within +-{self.width / 2:g} m"
            )
        s, t = (each.ravel() for each in np.broadcast_arrays(*group.local(x, y)))
        if len(s) > FEW and not group.along_an_axis:
            wavelength = self.wave.phase_velocity / self.wave.frequency
            parts = []
            for members, near in near_and_between(s, group.transducers, CLEAR * wavelength):
                if near or np.count_nonzero(members) <= FEW:
                    parts.append((members, evaluate(s[members], t[members])))
                else:
                    step = wavelength / PER_WAVELENGTH
                    parts.append((members, interpolated_on_grid(evaluate, s[members], t[members], step)))
            values = np.empty((len(parts[0][1]), len(s)), dtype=complex)
            for members, part in parts:
                values[:, members] = part
            return values.reshape(-1, *x.shape)
        return evaluate(s, t).reshape(-1, *x.shape)


def near_and_between(s: np.ndarray, transducers: tuple[Transducer, ...], clear: float) -> list[tuple[np.ndarray, bool]]:
    """Split points by their s (m) into those within ``clear`` (m) of a transducer's extent and those between.

    Returns pairs of a mask over the points and True for "near".
    """
    edges = np.array([each.extent + clear * np.array([-1, 1]) for each in transducers])
    edges = np.maximum.accumulate(edges[np.argsort(edges[:, 0])].ravel())
    piece = np.searchsorted(edges, s)
    return [(piece == number, bool(number % 2)) for number in set(piece.tolist())]


def interpolated_on_grid(evaluate, s: np.ndarray, t: np.ndarray, step: float) -> np.ndarray:
    """Interpolate ``evaluate(s, t)``, shape (components, points), from a grid whose lines are ``step`` apart.

    ``s``, ``t`` and ``step`` are in m; splines of order 5.
    """
    from scipy.ndimage import map_coordinates

    lines = [
        step * np.arange(np.floor(each.min() / step) - MARGIN, np.ceil(each.max() / step) + MARGIN + 1)
        for each in (s, t)
    ]
    grid = np.meshgrid(*lines, indexing="ij")
    known = evaluate(*(each.ravel() for each in grid)).reshape(-1, *grid[0].shape)
    at = [(each - line[0]) / step for each, line in zip((s, t), lines, strict=True)]
    return np.array([map_coordinates(each, at, order=5, mode="nearest") for each in known])


def crossed_beam(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    width: float,
    frequency: float,
    drive: str | Drive,
    solve: Solve,
    places: tuple[tuple[float, float], ...] = (),
) -> CrossedBeam:
    """Field of transducers at any angle, on a solid isotropic about z with absorbing ends.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        Each with two electrodes.
    width : float
        Width of the surface along y, m; its sides absorb.
    frequency : float
        Hz.
    drive : str or Drive
        Its first source drives a transducer of the first group.
    solve : callable
        Solver of one section: called with the stator and the transducers of a group, its drive and the points (m along
        the group) at which the error matters; returns a `SurfaceWave`.
    places : tuple of (float, float)
        Points x and y in m at which the error matters; the centre of the surface if empty.

    Raises
    ------
    BeamError
        If the solid is not isotropic about z, the ends do not absorb, or a transducer lacks one of its electrodes.
    ValueError
        If the layout is impossible.
    """
    _refuse(stator, width, transducers)
    drive = as_drive(drive)
    points = np.array(places or ((stator.length / 2, 0.0),)).T
    groups = rows_of(stator, width, transducers, drive)
    waves = [
        solve(
            group.stator,
            group.transducers,
            group_drive(drive, group),
            tuple(dict.fromkeys(map(float, group.local(*points)[0]))),
        )
        for group in groups
    ]
    fields = [with_apertures(wave.solution.fields) for wave in waves]
    admittances, names = admittances_of_groups(transducers, groups, [each.circuit for each in waves], fields)
    circuit = solve_circuit(admittances, names, transducers, drive, frequency)
    beams = []
    for group, wave, group_fields in zip(groups, waves, fields, strict=True):
        own_circuit = group_circuit(circuit, group_fields.names, group)
        if not driven_names(group, drive):
            wave = surface_wave(
                Solution(fields=wave.solution.fields, circuit=own_circuit),
                relative_error=wave.relative_error,
                admittance_error=wave.admittance_error,
            )
        beams.append(aperture_beam(wave, Solution(fields=group_fields, circuit=own_circuit)))
    return CrossedBeam(rows=groups, beams=tuple(beams), circuit=circuit, length=stator.length, width=width)


def _refuse(stator: Stator, width: float, transducers: tuple[Transducer, ...]) -> None:
    """Raise an error for an impossible layout, and a BeamError for one that is not covered."""
    check_plan(stator, width, transducers)
    check_turned(stator)
    for each in transducers:
        if not is_port(each):
            raise InputError("transducer.pattern", one_electrode(TURNED, each.signs), owner=each.name)
