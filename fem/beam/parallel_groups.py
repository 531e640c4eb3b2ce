"""Groups of parallel transducers, each of which one section describes, and the admittances between groups.

A section has the axes s along the waves of its group and t across them.  Let q_i be the charges per volt at port i of
one transducer, alone on the bare surface, and q_j those at port j of a transducer of another group.  By reciprocity

    Y_ij = -i omega int q_j phi_i dA = -i omega int dk_t / 2 pi  sum_p A_p (k_p / kappa_p) q_i^(k) q_j^(-k),        (1)

with phi_i the potential of the beam that port i excites, A_p the potential of mode p per line charge, q^ the Fourier
transform of the charges in the plane, and k = kappa_p n + k_t m the wave vector.  The unit vector n points along any
gap between the two transducers, and m across it.  The solid is isotropic about z.
"""

from dataclasses import dataclass, replace

import numpy as np

from fem.beam.electrode_charges import ElectrodeCharges, all_charges
from fem.beam.lateral import amplitude_ratio, evanescent, highest_wavenumber, lateral_rule, wavenumber_along
from fem.beam.line_source import LOCAL, NEGLIGIBLE, line_source
from fem.circuit import Circuit, Drive, as_drive
from fem.geometry import Stator, Transducer, separation, turn
from fem.results.stator_solution import Solution
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.port_fields import PortFields

PARALLEL = 1e-9  # rad; transducers whose angles differ by less are parallel
# Periods added to the length of a rotated group's stator, so that the grid of `interpolated_on_grid` lies on it.
SPLINE_MARGIN = 4.0
# A mode is neglected if its decay from centre to centre has a larger exponent.
MAX_DECAY_EXPONENT = 300.0


@dataclass(frozen=True, kw_only=True)
class ParallelGroup:
    """Parallel transducers in the axes of their waves.

    Attributes
    ----------
    angle : float
        Angle from x to s in rad, -pi/2 < angle <= pi/2.
    stator : Stator
        The stator of the section, which extends along s.
    transducers : tuple of Transducer
        With s and t as their centres.  The fingers of a transducer rotated by pi are in reverse order.
    middle : tuple of float
        x and s of the stator's centre, m.
    """

    angle: float
    stator: Stator
    transducers: tuple[Transducer, ...]
    middle: tuple[float, float]

    def local(self, x, y) -> tuple[np.ndarray, np.ndarray]:
        """Coordinates s and t in m of points (x, y) in m."""
        if self.angle == 0:
            return np.asarray(x, dtype=float), np.asarray(y, dtype=float)
        (xs, ys), (xt, yt) = turn(self.angle)
        from_middle = np.asarray(x, dtype=float) - self.middle[0]
        return self.middle[1] + from_middle * xs + y * ys, from_middle * xt + y * yt

    def middle_of(self, transducer: Transducer) -> tuple[float, float]:
        """Centre (x, y) in m of one of its transducers on the surface: the inverse of `local`."""
        (xs, ys), (xt, yt) = turn(self.angle)
        s, t = transducer.center - self.middle[1], transducer.center_y
        return self.middle[0] + s * xs + t * xt, s * ys + t * yt

    def rotated(self, motion: np.ndarray) -> np.ndarray:
        """Rotate (u_s, u_t, u_z) to (u_x, u_y, u_z)."""
        if self.angle == 0:
            return motion
        (xs, ys), (xt, yt) = turn(self.angle)
        along, across, normal = motion
        return np.array([along * xs + across * xt, along * ys + across * yt, normal])

    @property
    def along_an_axis(self) -> bool:
        """True if s lies along x or y, so that a grid in x and y is also a grid in s and t."""
        return bool(np.any(turn(self.angle)[0] == 0))


def rows_of(
    stator: Stator, width: float, transducers: tuple[Transducer, ...], drive: str | Drive
) -> tuple[ParallelGroup, ...]:
    """Group a stator's transducers; the first group is the driven one whose waves run nearest to x.

    A group contains parallel transducers whose extents along s do not overlap.  ``width`` of the surface in m.
    """
    groups: list[ParallelGroup] = []
    for each in transducers:
        angle = each.angle - np.pi * np.ceil(each.angle / np.pi - 0.5 - PARALLEL)
        if abs(angle) < PARALLEL:
            angle = 0.0
        reversed_order = np.cos(each.angle - angle) < 0
        length = stator.length
        if angle:  # the diagonal of the surface contains every line along s
            length = float(np.hypot(length, width)) + SPLINE_MARGIN * max(other.period for other in transducers)
        group = ParallelGroup(
            angle=angle, stator=replace(stator, length=length), transducers=(), middle=(stator.length / 2, length / 2)
        )
        s, t = group.local(each.center, each.center_y)
        own = replace(each, center=float(s), center_y=float(t), angle=0.0)
        own = _reversed(own) if reversed_order else own
        for number, other in enumerate(groups):
            if abs(other.angle - angle) < PARALLEL and _clear(own, other.transducers):
                groups[number] = replace(other, transducers=(*other.transducers, own))
                break
        else:
            groups.append(replace(group, transducers=(own,)))
    drive = as_drive(drive)
    return tuple(sorted(groups, key=lambda group: (not driven_names(group, drive), round(-np.cos(group.angle), 9))))


def _reversed(transducer: Transducer) -> Transducer:
    """Transducer with its fingers in reverse order: rotated by pi about the surface's normal."""
    return replace(
        transducer,
        pattern=transducer.signs[::-1],
        mirrored=transducer.mirrored != (transducer.cell != "plain"),
        chirp=-transducer.chirp,
    )


def _clear(one: Transducer, others: tuple[Transducer, ...]) -> bool:
    """True if a transducer overlaps none of the others along s."""
    (left, right), spans = one.extent, [each.extent for each in others]
    return all(right < start or stop < left for start, stop in spans)


def driven_names(group: ParallelGroup, drive: Drive) -> list[str]:
    """Names of the transducers of a group that have a source."""
    return [each.name for each in group.transducers if drive.sources.get(each.name)]


def group_drive(drive: Drive, group: ParallelGroup) -> Drive:
    """Drive for solving one group alone; a group without sources is driven at its first transducer."""
    sources = {each.name: drive.sources[each.name] for each in group.transducers if each.name in drive.sources}
    return replace(drive, sources=sources) if any(sources.values()) else Drive(sources={group.transducers[0].name: 1.0})


def group_circuit(circuit: Circuit, names: tuple[str, ...], group: ParallelGroup) -> Circuit:
    """Part of the circuit at the ports of a group; if none is driven, the power balance takes all ports as sources."""
    index = [circuit.names.index(name) for name in names]
    sources = [index.index(at) for at in circuit.sources if at in index] or range(len(index))
    return replace(
        circuit,
        names=names,
        voltages=circuit.voltages[index],
        currents=circuit.currents[index],
        sources=tuple(sources),
        aperture=next(each.aperture for each in group.transducers if each.name == names[sources[0]]),
    )


def admittances_of_groups(
    transducers: tuple[Transducer, ...],
    groups: tuple[ParallelGroup, ...],
    circuits: list[Circuit],
    fields: list[PortFields],
) -> tuple[np.ndarray, tuple[str, ...]]:
    """Admittance matrix of all ports in S, and their names.

    ``transducers``: as they lie on the surface; ``circuits``, ``fields``: of each group alone.
    """
    first = np.cumsum([0, *(len(each.names) for each in fields)])
    out = np.zeros((first[-1],) * 2, dtype=complex)
    for start, each in zip(first, fields, strict=False):
        own = slice(start, start + len(each.names))
        out[own, own] = each.admittances
    plan = {each.name: each for each in transducers}
    charges = [_unit_charges(circuit, each) for circuit, each in zip(circuits, fields, strict=True)]

    def mutual(one: int, i: int, other: int, j: int) -> complex:
        """Admittance of port i of a group and port j of another: the sum over their transducers."""
        return sum(
            mutual_admittance(
                fields[one].modes,
                (plan[a.name], plan[b.name]),
                (a.center, b.center),
                (groups[one].angle, groups[other].angle),
                (q, p),
            )
            for a, q in zip(fields[one].transducers, charges[one][i], strict=True)
            for b, p in zip(fields[other].transducers, charges[other][j], strict=True)
        )

    for one in range(len(groups)):
        for other in range(one):
            for i, j in np.ndindex(len(charges[one]), len(charges[other])):
                pair = first[one] + i, first[other] + j
                out[pair] = out[pair[::-1]] = mutual(one, i, other, j)
    return out, tuple(name for each in fields for name in each.names)


def _unit_charges(circuit: Circuit, fields: PortFields) -> list[tuple[ElectrodeCharges, ...]]:
    """Charges of all transducers of a group for 1 V at each of its ports in turn, the other ports at zero."""
    volts = np.eye(len(fields.names))
    return [all_charges(Solution(fields=fields, circuit=replace(circuit, voltages=each))) for each in volts]


def mutual_admittance(
    modes: GuidedModes,
    plan: tuple[Transducer, Transducer],
    origins: tuple[float, float],
    angles: tuple[float, float],
    charges: tuple[ElectrodeCharges, ElectrodeCharges],
    *,
    along: float | None = None,
) -> complex:
    """Short-circuit current at one transducer per volt at another, in S, from the charges of each alone: equation (1).

    Parameters
    ----------
    modes : GuidedModes
        Modes of the bare section.
    plan : tuple of Transducer
        The two transducers, as they lie on the surface.
    origins : tuple of float
        Positions of their centres in the coordinates of ``charges``, m.
    angles : tuple of float
        Angles of the axes of these coordinates to x, rad.
    charges : tuple of ElectrodeCharges
        Charges of each transducer per volt.
    along : float, optional
        Direction n of equation (1), rad from x; by default that of the widest gap.

    Returns
    -------
    complex
        Mutual admittance, which does not depend on the order of the two.
    """
    one, other = plan
    gap, widest = separation(one, other)
    forward, across = turn(widest if along is None else along)
    between = np.array([other.center - one.center, other.center_y - one.center_y])
    distance, offset = float(between @ forward), float(between @ across)
    source = line_source(modes, "charge")
    k = source.wavenumbers
    wavelength = 2 * np.pi / float(np.mean(k[source.surface].real))
    # A mode is kept if its amplitude is more than exp(-LOCAL) after a wavelength, more than exp(-MAX_DECAY_EXPONENT)
    # from centre to centre, and more than NEGLIGIBLE after the gap.
    lasting = -k.imag * max(wavelength / LOCAL, distance / MAX_DECAY_EXPONENT, gap / -np.log(NEGLIGIBLE)) < 1
    reach = abs(offset) + sum(float(abs((each.corners - each.corners.mean(axis=0)) @ across).max()) for each in plan)
    highest = highest_wavenumber(k)
    rule = lateral_rule(highest, reach, evanescent(highest, max(gap, wavelength)))
    total = 0.0  # the integral of equation (1)
    pairs = [(number, contour) for some, contour in rule.contours(k) for number in np.flatnonzero(lasting & some)]
    for number, contour in pairs:
        kappa = wavenumber_along(k[number], contour.nodes)
        for side in (1, -1):  # both signs of k_t, half the weight each
            lateral = side * contour.nodes
            vector = np.outer(forward, kappa) + np.outer(across, lateral)
            transforms = [  # q_i^(k) and q_j^(-k)
                own.plane_transform(sign * (turn(angle) @ vector), each.aperture, origin)
                for sign, angle, each, origin, own in zip((1, -1), angles, plan, origins, charges, strict=True)
            ]
            phase = np.exp(-1j * (kappa * distance + lateral * offset))
            total += source.potential[number] * np.sum(
                contour.weights / 2 * amplitude_ratio(k[number], kappa) * transforms[0] * transforms[1] * phase
            )
    return complex(-2j * np.pi * modes.frequency * total)
