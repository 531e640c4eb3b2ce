"""Transducers turned about the surface normal, or beside one another: several beams on one surface.

Parallel transducers that a section can hold one behind the other form a row.  In a solid isotropic about z every row is
the section problem of the same stator in its own axes, s along its waves and t across; its beam is `SurfaceBeam` in
those axes, and the beams add up.  Rows are coupled through their charges (mutual_admittance.py).

Left out between rows: what the metal of one scatters of another's beam at given voltages (its fingers are then bare
surface to that beam), and their electrostatic coupling.  Within a row reception.py has the former.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fem.beam.charges import ElectrodeCharges, electrode_charges
from fem.beam.mutual_admittance import mutual_admittance
from fem.beam.reception import with_apertures
from fem.beam.rows import Row, driven_names, rows_of
from fem.beam.surface_beam import BeamError, SurfaceBeam, aperture_beam
from fem.circuit import Circuit, Drive, as_drive, solve_circuit
from fem.geometry import Stator, Transducer, check_plan, turn
from fem.materials import isotropic_about_normal
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.solution import Solution

# Places in a row at an oblique angle, where each has an s of its own, beyond which a grid in s and t is interpolated by
# splines of order 5: its lines per wavelength, lines beyond the places, and wavelengths from the fingers' charges
# within which no place is interpolated, for the field has kinks there.  They leave 3e-5 of the largest amplitude
# (test_passive_transducers.py).
FEW, PER_WAVELENGTH, MARGIN, CLEAR = 500, 9, 12, 2.0

Solve = Callable[[Stator, tuple[Transducer, ...], Drive, tuple[float, ...]], SurfaceWave]


@dataclass(frozen=True, kw_only=True)
class CrossedBeam:
    """Surface motion of several rows of transducers.

    Attributes
    ----------
    rows : tuple of Row
        The first is the driven one whose waves run nearest to x.
    beams : tuple of SurfaceBeam
        Of each row, in its axes.
    circuit : Circuit
        Voltages and currents of all ports.
    length, width : float
        Of the surface, m.
    """

    rows: tuple[Row, ...]
    beams: tuple[SurfaceBeam, ...] = field(repr=False)
    circuit: Circuit
    length: float
    width: float

    @property
    def wave(self) -> SurfaceWave:
        """Of the first row's section."""
        return self.beams[0].wave

    def in_section(self, x: float, y: float) -> float:
        """Where a place in m lies on the line of the section `wave`, m."""
        return float(self.rows[0].local(x, y)[0])

    @property
    def surface_mode(self) -> "CrossedBeam":
        """The part of the field that the surface wave alone carries."""
        return replace(self, beams=tuple(each.surface_mode for each in self.beams))

    @property
    def _moving(self) -> list[tuple[Row, SurfaceBeam]]:
        """Rows that have a voltage at any port, and their beams."""
        pairs = zip(self.rows, self.beams, strict=True)
        return [(row, beam) for row, beam in pairs if np.any(beam.circuit.voltages)]

    def motion(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """u_x, u_y and u_z in m per V at places (x, y) in m, as `SurfaceBeam.motion`.

        Of rows at an oblique angle many places are interpolated, but for those near their own fingers.
        """
        total: np.ndarray = np.zeros(())
        for row, beam in self._moving:
            total = total + _in_plan(row, self._of_row(row, beam.motion, x, y))
        return total

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Sum of the beams' errors over max(|u_x|, |u_z|) at each place."""
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion` and `relative_error` at once."""
        total: np.ndarray = np.zeros(())
        error: np.ndarray = np.zeros(())
        for row, beam in self._moving:
            both = self._of_row(row, lambda s, t, of=beam: np.vstack(_stacked(of, s, t)), x, y)
            total = total + _in_plan(row, both[:3])
            error = error + both[3].real
        return total, error / abs(total[[0, 2]]).max(axis=0)

    @cached_property
    def power(self) -> PowerBalance:
        """Where the power goes: sum over the rows, what one sends to another counted with the circuit's input."""
        parts = [power_balance(each.solution) for _, each in self._moving]
        return PowerBalance(
            input=self.circuit.power,
            solid=sum(each.solid for each in parts),
            loads=sum(each.loads for each in parts),
            left=sum(each.left for each in parts),
            right=sum(each.right for each in parts),
            residual=max(each.residual for each in parts),
        )

    def first_images(self, x: float | np.ndarray, y: float | np.ndarray) -> np.ndarray:
        """Sum of the sizes of u_z, m per V, that the first images of all beams in both side faces have at places."""
        images = [side * self.width - np.asarray(y) for side in (1, -1)]
        total: np.ndarray = np.zeros(())
        for row, beam in self._moving:
            for image in images:
                s, t = row.local(x, image)
                total = total + abs(beam.motion(np.clip(s, 0.0, row.stator.length), t)[2])
        return total

    def charge_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray | None:
        """As of `SurfaceBeam`, of all beams together."""
        total, x, y = 0.0, np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        for row, beam in self._moving:
            s, t = row.local(x, y)
            own = beam.charge_error(s, t)
            if own is None:
                return None
            total = total + own * abs(beam.motion(s, t)[2])
        return total / abs(self.motion(x, y)[2])

    def shadowed(self, slowing: float) -> float:
        """Sum of u_z at the transducers of other rows, m per V, times the phase that their metal gives the beams.

        ``slowing``: by metal, relative to the velocity on the bare surface.
        """
        total = 0.0
        for row, beam in self._moving:
            wavenumber = 2 * np.pi * beam.wave.frequency / beam.wave.phase_velocity
            for other in self.rows:
                for each in other.transducers if other is not row else ():
                    across = np.sin(row.angle - other.angle), np.cos(row.angle - other.angle)
                    way = abs(np.array(across)) @ [each.aperture, np.ptp(each.extent)]
                    size = abs(self._of_row(row, beam.motion, *self._plan(other, each))[2, 0])
                    total += size * min(wavenumber * way * each.metallisation * slowing, 2.0)
        return float(total)

    def _plan(self, row: Row, each: Transducer) -> tuple[np.ndarray, np.ndarray]:
        """Middle of a row's transducer on the surface."""
        (xs, ys), (xt, yt) = turn(row.angle)
        s = each.center - row.middle[1]
        return (
            np.array([row.middle[0] + s * xs + each.center_y * xt]),
            np.array([s * ys + each.center_y * yt]),
        )

    def _of_row(self, row: Row, evaluate, x, y) -> np.ndarray:
        """Values of a row's beam at places, shape (n, *shape of x and y)."""
        x, y = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(y, dtype=float))
        if not np.all((x >= 0) & (x <= self.length) & (abs(y) <= self.width / 2)):
            raise BeamError(
                f"places must lie on the stator, x from 0 to {self.length:g} m and y within +-{self.width / 2:g} m"
            )
        s, t = (each.ravel() for each in np.broadcast_arrays(*row.local(x, y)))
        if len(s) > FEW and not row.along_an_axis:
            wave = self.wave
            wavelength = wave.phase_velocity / wave.frequency
            values = None
            for some, near in _pieces(s, row.transducers, CLEAR * wavelength):
                if near or np.count_nonzero(some) <= FEW:
                    found = evaluate(s[some], t[some])
                else:
                    found = _interpolated(evaluate, s[some], t[some], wavelength / PER_WAVELENGTH)
                values = np.empty((len(found), len(s)), dtype=complex) if values is None else values
                values[:, some] = found
            return values.reshape(-1, *x.shape)
        return evaluate(s, t).reshape(-1, *x.shape)


def _pieces(
    s: np.ndarray, transducers: tuple[Transducer, ...], clear: float
) -> list[tuple[np.ndarray, bool]]:
    """Masks of the places on each side of and near each transducer of a row, and whether these are the near ones."""
    edges = np.array([each.extent + clear * np.array([-1, 1]) for each in transducers])
    edges = np.maximum.accumulate(edges[np.argsort(edges[:, 0])].ravel())
    piece = np.searchsorted(edges, s)
    return [(piece == number, bool(number % 2)) for number in set(piece.tolist())]


def _interpolated(evaluate, s: np.ndarray, t: np.ndarray, step: float) -> np.ndarray:
    """Values at many places from those on a grid of a step in m."""
    from scipy.ndimage import map_coordinates

    lines = [
        step * np.arange(np.floor(each.min() / step) - MARGIN, np.ceil(each.max() / step) + MARGIN + 1)
        for each in (s, t)
    ]
    grid = np.meshgrid(*lines, indexing="ij")
    known = evaluate(*(each.ravel() for each in grid)).reshape(-1, *grid[0].shape)
    at = [(each - line[0]) / step for each, line in zip((s, t), lines, strict=True)]
    return np.array([map_coordinates(each, at, order=5, mode="nearest") for each in known])


def _stacked(beam: SurfaceBeam, s, t):
    """Motion and, in its size, error of a beam."""
    motion, error = beam.motion_and_error(s, t)
    return motion, (error * abs(motion[[0, 2]]).max(axis=0))[None]


def _in_plan(row: Row, motion: np.ndarray) -> np.ndarray:
    """u_x, u_y and u_z of u_s, u_t and u_z."""
    if row.angle == 0:
        return motion
    (xs, ys), (xt, yt) = turn(row.angle)
    along, across, normal = motion
    return np.array([along * xs + across * xt, along * ys + across * yt, normal])


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
        Of the surface along y, m; its sides absorb.
    frequency : float
        Hz.
    drive : str or Drive
        Its first source drives a transducer of the first row.
    solve : callable
        Solves a section: from the stator and the transducers of a row, its drive and the places (m along the row) that
        matter returns a `SurfaceWave`.
    places : tuple of (float, float)
        x and y in m, where the field matters; the middle of the surface if empty.

    Raises
    ------
    BeamError
        For another solid or other ends, or a transducer without two electrodes.
    ValueError
        For a layout that is impossible.
    """
    check_plan(stator, width, transducers)
    if stator.ends != "absorbing" or not isotropic_about_normal(stator.solid):
        raise BeamError(
            "transducers at an angle or beside one another need a solid isotropic about z and absorbing ends"
        )
    for each in transducers:
        if not {"+", "-"} <= set(each.signs):
            raise BeamError(
                f"transducer {each.name!r} must have + and - fingers beside transducers at an angle"
            )
    drive = as_drive(drive)
    at = np.array(places or ((stator.length / 2, 0.0),)).T
    rows = rows_of(stator, width, transducers, drive)
    waves = [
        solve(
            row.stator, row.transducers, _own(drive, row), tuple(dict.fromkeys(map(float, row.local(*at)[0])))
        )
        for row in rows
    ]
    fields = [with_apertures(wave.solution.fields) for wave in waves]
    admittances, names = _admittances(transducers, rows, waves, fields, frequency)
    circuit = solve_circuit(admittances, names, transducers, drive, frequency)
    beams = []
    for row, wave, own in zip(rows, waves, fields, strict=True):
        mine = _part(circuit, own.names, row)
        if not driven_names(row, drive):
            wave = surface_wave(
                Solution(fields=wave.solution.fields, circuit=mine),
                relative_error=wave.relative_error,
                admittance_error=wave.admittance_error,
            )
        beams.append(aperture_beam(wave, Solution(fields=own, circuit=mine)))
    return CrossedBeam(rows=rows, beams=tuple(beams), circuit=circuit, length=stator.length, width=width)


def _own(drive: Drive, row: Row) -> Drive:
    """The drive of a row alone; one without sources is driven at its first transducer."""
    sources = {each.name: drive.sources[each.name] for each in row.transducers if each.name in drive.sources}
    return (
        replace(drive, sources=sources)
        if any(sources.values())
        else Drive(sources={row.transducers[0].name: 1.0})
    )


def _part(circuit: Circuit, names: tuple[str, ...], row: Row) -> Circuit:
    """The ports of a row; where none of them is driven all count as sources of its power balance."""
    index = [circuit.names.index(name) for name in names]
    sources = [index.index(at) for at in circuit.sources if at in index] or range(len(index))
    return replace(
        circuit,
        names=names,
        voltages=circuit.voltages[index],
        currents=circuit.currents[index],
        sources=tuple(sources),
        aperture=next(each.aperture for each in row.transducers if each.name == names[sources[0]]),
    )


def _admittances(transducers, rows, waves, fields, frequency) -> tuple[np.ndarray, tuple[str, ...]]:
    """Admittance matrix of all ports in S, and their names."""
    first = np.cumsum([0, *(len(each.names) for each in fields)])
    out = np.zeros((first[-1],) * 2, dtype=complex)
    for start, each in zip(first, fields, strict=False):
        own = slice(start, start + len(each.names))
        out[own, own] = each.admittances
    plan = {each.name: each for each in transducers}
    charges = [_unit_charges(wave, own) for wave, own in zip(waves, fields, strict=True)]
    for one in range(len(rows)):
        for other in range(one):
            for i, senders in enumerate(charges[one]):
                for j, receivers in enumerate(charges[other]):
                    mutual = sum(
                        mutual_admittance(
                            fields[one].modes,
                            (plan[a.name], plan[b.name]),
                            (a.center, b.center),
                            (rows[one].angle, rows[other].angle),
                            (q, p),
                        )
                        for a, q in zip(fields[one].transducers, senders, strict=True)
                        for b, p in zip(fields[other].transducers, receivers, strict=True)
                    )
                    pair = first[one] + i, first[other] + j
                    out[pair] = out[pair[::-1]] = mutual
    return out, tuple(name for each in fields for name in each.names)


def _unit_charges(wave: SurfaceWave, fields) -> list[list[ElectrodeCharges]]:
    """Charges of all transducers of a row for 1 V at each of its ports in turn, the other ports at zero."""
    ports, circuit = len(fields.names), wave.circuit
    return [
        [
            electrode_charges(Solution(fields=fields, circuit=replace(circuit, voltages=volts)), index)
            for index in range(len(fields.transducers))
        ]
        for volts in np.eye(ports)
    ]
