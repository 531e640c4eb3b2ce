"""Transducers turned about the surface normal, or beside one another: several beams on one surface.

Parallel transducers that a section can hold one behind the other form a row.  In a solid isotropic about z every row is
the section problem of the same stator in its own axes, s along its waves and t across; its beam is `SurfaceBeam` in
those axes, and the beams add up.  Rows are coupled through their charges.  With the charges q per volt at port i of one
row and at port j of another, each alone on the bare surface, reciprocity gives

    Y_ij = -i omega int q_j phi_i dA = -i omega int dk_t / 2 pi  sum_p A_p (k_p / kappa_p) q_i^(k) q_j^(-k),

phi_i the potential of the beam that port i sends, k = kappa_p n + k_t t with n any direction along which the two
transducers are apart, q^ the transform of the charges over the plane and A_p the potential of mode p per line charge.

Left out between rows: what the metal of one scatters of another's beam at given voltages (its fingers are then bare
surface to that beam), and their electrostatic coupling.  Within a row reception.py has the former.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from fem.beam.charges import ElectrodeCharges, electrode_charges
from fem.beam.lateral import evanescent, lateral_rule
from fem.beam.line_source import KEPT, LOCAL, isotropic_about_normal, line_source
from fem.beam.reception import with_apertures
from fem.beam.surface_beam import BeamError, SurfaceBeam, aperture_beam
from fem.circuit import Circuit, Drive, as_drive, solve_circuit
from fem.geometry import Stator, Transducer, check_plan, separation, turn
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.solution import Solution
from fem.results.surface_wave import SurfaceWave, surface_wave
from fem.waveguide.modes import GuidedModes

PARALLEL = 1e-9  # rad
LARGEST_DECAY = 300.0  # exponent between two middles beyond which a mode is left out of their coupling
# Places in a row at an oblique angle, where each has an s of its own, beyond which a grid in s and t is interpolated by
# splines of order 5: its lines per wavelength, which leave 2e-5 beside the fingers, and lines beyond the places
FEW, PER_WAVELENGTH, MARGIN = 500, 8, 8
ROOM = 4.0  # periods, more than the lines beyond the places take

Solve = Callable[[Stator, tuple[Transducer, ...], Drive, tuple[float, ...]], SurfaceWave]


@dataclass(frozen=True, kw_only=True)
class Row:
    """Parallel transducers in the axes of their waves.

    Attributes
    ----------
    angle : float
        Of s from x, rad, above -pi/2 and up to pi/2.
    stator : Stator
        Along s.
    transducers : tuple of Transducer
        Their places are s and t; one turned by pi has its fingers in the reverse order.
    middle : tuple of float
        x and s of the stator's middle, m.
    """

    angle: float
    stator: Stator
    transducers: tuple[Transducer, ...]
    middle: tuple[float, float]

    def local(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """Places s and t in m of places x and y."""
        if self.angle == 0:
            return np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        (xs, ys), (xt, yt) = turn(self.angle)
        from_middle = np.asarray(x, dtype=float) - self.middle[0]
        return self.middle[1] + from_middle * xs + y * ys, from_middle * xt + y * yt

    @property
    def along_an_axis(self) -> bool:
        """Whether a grid of x and y is one of s and t."""
        return bool(np.any(turn(self.angle)[0] == 0))


def rows_of(
    stator: Stator, width: float, transducers: tuple[Transducer, ...], drive: str | Drive
) -> tuple[Row, ...]:
    """Rows of a stator's transducers; the first is the driven one whose waves run nearest to x."""
    rows: list[Row] = []
    for each in transducers:
        angle = each.angle - np.pi * np.ceil(each.angle / np.pi - 0.5 - PARALLEL)
        if abs(angle) < PARALLEL:
            angle = 0.0
        reversed_order = np.cos(each.angle - angle) < 0
        length = stator.length  # of a turned row: its diagonal and room for the lines of `_interpolated`
        if angle:
            length = float(np.hypot(length, width)) + ROOM * max(other.period for other in transducers)
        row = Row(
            angle=angle,
            stator=replace(stator, length=length),
            transducers=(),
            middle=(stator.length / 2, length / 2),
        )
        s, t = row.local(each.center, each.center_y)
        own = replace(
            each,
            center=float(s),
            center_y=float(t),
            angle=0.0,
            pattern=each.signs[::-1] if reversed_order else each.pattern,
        )
        for number, other in enumerate(rows):
            if abs(other.angle - angle) < PARALLEL and _clear(own, other.transducers):
                rows[number] = replace(other, transducers=(*other.transducers, own))
                break
        else:
            rows.append(replace(row, transducers=(own,)))
    drive = as_drive(drive)
    return tuple(sorted(rows, key=lambda row: (not _driven(row, drive), round(-np.cos(row.angle), 9))))


def _clear(one: Transducer, others: tuple[Transducer, ...]) -> bool:
    (left, right), spans = one.extent, [each.extent for each in others]
    return all(right < start or stop < left for start, stop in spans)


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

        Of rows at an oblique angle many places are interpolated: under their own fingers to some per cent only.
        """
        total = 0.0
        for row, beam in self._moving:
            total = total + _in_plan(row, self._of_row(row, beam.motion, x, y))
        return total

    def relative_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0) -> np.ndarray:
        """Sum of the beams' errors over max(|u_x|, |u_z|) at each place."""
        return self.motion_and_error(x, y)[1]

    def motion_and_error(self, x: float | np.ndarray, y: float | np.ndarray = 0.0):
        """`motion` and `relative_error` at once."""
        total, error = 0.0, 0.0
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
        total = 0.0
        for row, beam in self._moving:
            for image in images:
                s, t = row.local(x, image)
                total = total + abs(beam.motion(np.clip(s, 0.0, row.stator.length), t)[2])
        return total

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
            step = wave.phase_velocity / wave.frequency / PER_WAVELENGTH
            return _interpolated(evaluate, s, t, step).reshape(-1, *x.shape)
        return evaluate(s, t).reshape(-1, *x.shape)


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
        if not _driven(row, drive):
            wave = surface_wave(
                Solution(fields=wave.solution.fields, circuit=mine),
                relative_error=wave.relative_error,
                admittance_error=wave.admittance_error,
            )
        beams.append(aperture_beam(wave, Solution(fields=own, circuit=mine)))
    return CrossedBeam(rows=rows, beams=tuple(beams), circuit=circuit, length=stator.length, width=width)


def _driven(row: Row, drive: Drive) -> list[str]:
    return [each.name for each in row.transducers if drive.sources.get(each.name)]


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
    from scipy.linalg import block_diag

    out = block_diag(*(each.admittances for each in fields)).astype(complex)
    plan = {each.name: each for each in transducers}
    charges = [_unit_charges(wave, own) for wave, own in zip(waves, fields, strict=True)]
    first = np.cumsum([0, *(len(each.names) for each in fields)])
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


def mutual_admittance(
    modes: GuidedModes,
    plan: tuple[Transducer, Transducer],
    origins: tuple[float, float],
    angles: tuple[float, float],
    charges: tuple[ElectrodeCharges, ElectrodeCharges],
    *,
    along: float | None = None,
) -> complex:
    """Short-circuit current at one transducer per volt at another, in S, from the charges of each alone.

    Parameters
    ----------
    modes : GuidedModes
        Of the bare section.
    plan : tuple of Transducer
        Both on the surface.
    origins : tuple of float
        Places of their middles on the lines of ``charges``, m.
    angles : tuple of float
        Of those lines, rad.
    charges : tuple of ElectrodeCharges
        Per volt.
    along : float, optional
        Direction in rad along which they are apart; by default that of the widest gap.

    Returns
    -------
    complex
        The same for both orders.
    """
    one, other = plan
    gap, widest = separation(one, other)
    forward, across = turn(widest if along is None else along)
    between = np.array([other.center - one.center, other.center_y - one.center_y])
    distance, offset = float(between @ forward), float(between @ across)
    source = line_source(modes)
    k = source.wavenumbers
    wavelength = 2 * np.pi / float(np.mean(k[source.surface].real))
    kept = -k.imag * max(wavelength / LOCAL, distance / LARGEST_DECAY, gap / -np.log(KEPT)) < 1
    reach = abs(offset) + sum(
        float(abs((each.corners - each.corners.mean(axis=0)) @ across).max()) for each in plan
    )
    rule = lateral_rule(
        float(np.sqrt((k**2).real.max())),
        reach,
        evanescent(float(np.sqrt((k**2).real.max())), max(gap, wavelength)),
    )
    total = 0.0
    for number in np.flatnonzero(kept):
        backward = k[number].real < 0
        contour = rule.conjugate if backward else rule
        kappa = (-1 if backward else 1) * np.sqrt(k[number] ** 2 - contour.nodes**2)
        kappa[kappa.imag > 0] *= -1
        for side in (1, -1):
            lateral = side * contour.nodes
            vector = np.outer(forward, kappa) + np.outer(across, lateral)
            sent = [
                _transform(sign * (turn(angle) @ vector), each.aperture, origin, own)
                for sign, angle, each, origin, own in zip(
                    (1, -1), angles, plan, origins, charges, strict=True
                )
            ]
            phase = np.exp(-1j * (kappa * distance + lateral * offset))
            total += source.potential[number] * np.sum(
                contour.weights / 2 * (k[number] / kappa) * sent[0] * sent[1] * phase
            )
    return complex(-2j * np.pi * modes.frequency * total)


def _transform(vector: np.ndarray, aperture: float, origin: float, charges: ElectrodeCharges) -> np.ndarray:
    """Charges over the plane at wave vectors (k_s, k_t), about their middle, in C per V."""
    return charges.transform(vector[0], origin) * aperture * np.sinc(vector[1] * aperture / (2 * np.pi))
