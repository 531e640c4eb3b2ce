"""Scattering of guided modes by the pieces of a stator, and the network of pieces, uniform segments and ends.

A piece (a transducer or a mesh) lies between two uniform segments, whose radiation impedances X_right and X_left are
known (guided_modes.py).  With p the part of the field that travels to the right and q the part that travels to the
left, the unknowns u of its two lines obey

    (A - diag(X_left, X_right)) u = [-(X_right + X_left) p_in, -(X_left + X_right) q_in] - A_ports V,       (1)

so that one factorisation gives the waves that it sends for each voltage and for each incident mode.  Along a segment of
length l a mode changes by exp(-i k l).  Only modes that do not decay below double precision couple the pieces, so that
the cost does not depend on the length.  Free and clamped ends reflect an incident mode into all modes of the section.
A line force on the bare surface sends the modes of `fem.waveguide.line_force` both ways.
`fem.waveguide.cascade_system` solves for the amplitudes of all waves together.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise
from typing import NamedTuple

import numpy as np

from fem.condense.cascade_piece import Blocks, Piece, Port
from fem.condense.finger_columns import FingerColumns
from fem.exceptions import InputError
from fem.waveguide.cascade_system import Element, solve_cascade
from fem.waveguide.end_conditions import End, end_reflection, with_gauge
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.line_force import ForceResponse, force_response

NEGLIGIBLE = 1e-18  # a mode's amplitude after a segment, relative: far below rounding
NO_WAVES = np.empty(0, dtype=int)


@dataclass(frozen=True, kw_only=True, eq=False)
class Scatterer:
    """A condensed piece in the waveguide."""

    piece: Piece
    modes: GuidedModes
    # shape (ports of the piece, ports of the network that determine them): potentials of the piece's ports for a unit
    # at each port of the network, +1/2 and -1/2 for a voltage, 1 and 1 for a mean
    potentials: np.ndarray

    @cached_property
    def at(self) -> Blocks:
        """Slices of the lines and ports in the piece's matrix."""
        return Blocks(self.piece.size)

    @property
    def columns(self) -> FingerColumns:
        """The piece, if it consists of columns of fingers; a TypeError otherwise."""
        if not isinstance(self.piece, FingerColumns):
            raise TypeError("the piece is not made of columns of fingers")
        return self.piece

    @cached_property
    def matrix(self) -> np.ndarray:
        """The piece's matrix; where its potential and that of its electrodes float together, of exactly no charge then.

        The condensation leaves a charge by rounding, 1e-9 of the largest on the finest level, which would end the
        static field of a plate under vacuum as a leak to ground does.
        """
        section = self.modes.section
        if not (isinstance(self.piece, FingerColumns) and section.floating_potential):
            return self.piece.matrix
        matrix, constant = self.piece.matrix, section.constant_potential
        everywhere = np.concatenate([constant, constant, np.ones(len(matrix) - 2 * len(constant))])
        weights, charges = everywhere / (everywhere @ everywhere), matrix @ everywhere
        leak = np.outer(charges, weights)  # P^T A P with P = 1 - c w^T for the constant c and its weights w
        return matrix - leak - leak.T + np.outer(weights, weights) * (everywhere @ charges)

    @cached_property
    def _between_ends(self):
        at = self.at
        system = self.matrix[at.lines, at.lines].astype(complex)
        system[at.left, at.left] -= self.modes.left_impedance
        system[at.right, at.right] -= self.modes.right_impedance
        if self.piece.floating_potential:
            system = with_gauge(system, self.modes.section.constant_potential)
        return system

    def sides(self, incoming: np.ndarray, potentials: np.ndarray) -> np.ndarray:
        """Unknowns of both lines by equation (1), shape (2 n, m), for incident fields and potentials.

        ``incoming``, (2 n, m): field that travels right at the left line, then field that travels left at the right
        line; ``potentials``, (ports, m): of the piece's ports, scaled.
        """
        at, both = self.at, self.modes.impedance_sum
        load = -self.matrix[at.lines, at.ports] @ potentials
        load = load.astype(complex)
        load[at.left] -= both @ incoming[at.left]
        load[at.right] -= both @ incoming[at.right]
        return np.linalg.solve(self._between_ends, load)

    @cached_property
    def _known(self) -> dict[tuple[str, int], np.ndarray]:
        return {}

    def responses(self, modes: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Unknowns of both lines for each of some modes from the left, each from the right, and each unit of potential.

        Shape (2 n, modes) twice, and (2 n, ports of the network that determine the potentials).  The modes have unit
        amplitude at the line where they arrive; all potentials are zero then.  Each is solved once.
        """
        left, right = (("left", int(mode)) for mode in modes), (("right", int(mode)) for mode in modes)
        wanted = [*left, *right, *(("port", port) for port in range(self.potentials.shape[1]))]
        missing = [each for each in wanted if each not in self._known]
        if missing:
            at, shapes = self.at, {"left": self.modes.right, "right": self.modes.left}
            incoming = np.zeros((at.ports.start, len(missing)), dtype=complex)
            potentials = np.zeros((len(self.potentials), len(missing)))
            for column, (kind, number) in enumerate(missing):
                if kind == "port":
                    potentials[:, column] = self.potentials[:, number]
                else:
                    incoming[at.left if kind == "left" else at.right, column] = shapes[kind][:, number]
            self._known.update(zip(missing, self.sides(incoming, potentials).T, strict=True))
        both = np.array([self._known[each] for each in wanted]).T
        return both[:, : len(modes)], both[:, len(modes) : 2 * len(modes)], both[:, 2 * len(modes) :]

    def reactions(self, sides: np.ndarray) -> np.ndarray:
        """Scaled reactions at the network's ports (minus the charge of a voltage) for lines and potentials (., m)."""
        return self.potentials.T @ (self.matrix[self.at.ports] @ sides)


@dataclass(frozen=True, kw_only=True)
class SegmentWaves:
    """Amplitudes of all modes in a uniform segment, or in the part of one between two forces.

    Attributes
    ----------
    start, stop : float
        Both ends of the segment, length units.
    right, left : ndarray, shape (modes, excitations)
        Amplitudes of waves to the right, at ``start``, and of waves to the left, at ``stop``.
    """

    start: float
    stop: float
    right: np.ndarray = field(repr=False)
    left: np.ndarray = field(repr=False)

    def right_at(self, modes: GuidedModes, x: float) -> np.ndarray:
        """Amplitudes of the waves to the right at a position, (modes, excitations)."""
        return np.exp(-1j * modes.wavenumbers * (x - self.start))[:, None] * self.right

    def left_at(self, modes: GuidedModes, x: float) -> np.ndarray:
        """Amplitudes of the waves to the left at a position, (modes, excitations)."""
        return np.exp(1j * modes.backwards * (self.stop - x))[:, None] * self.left

    def weighted(self, weights: np.ndarray) -> "SegmentWaves":
        """Amplitudes for sums of the excitations, ``weights`` of shape (excitations, ...)."""
        return replace(self, right=self.right @ weights, left=self.left @ weights)


@dataclass(frozen=True, kw_only=True)
class _Segment:
    """A uniform segment, and the modes that couple its two ends.

    The unknown amplitudes are those in the middle of the segment, half a segment before the waves arrive, which
    balances the sizes of the equations.  In a segment with a force they are those at the point of arrival.
    """

    modes: GuidedModes
    start: float
    stop: float
    travel: float  # distance that the modes travel from end to end, length units; 0 if the segment is semi-infinite
    coupling_modes: np.ndarray  # indices of the modes that couple the ends
    first: int  # number in the cascade of their first wave: waves to the right, then waves to the left
    forces: tuple[int, ...]  # ports of the network that are forces on it, from left to right

    @property
    def right(self) -> np.ndarray:
        """Numbers in the cascade of the waves to the right."""
        return self.first + np.arange(len(self.coupling_modes))

    @property
    def left(self) -> np.ndarray:
        """Numbers in the cascade of the waves to the left."""
        return self.right + len(self.coupling_modes)

    def passed(self, towards: str, distance: float) -> np.ndarray:
        """Propagation factors of all modes over a distance in their direction."""
        k = self.modes.wavenumbers if towards == "right" else -self.modes.backwards
        return np.exp(-1j * k * distance)

    @property
    def half(self) -> float:
        """Distance from the position of the unknown amplitudes to the point of arrival, length units."""
        return 0.0 if self.forces else self.travel / 2

    def arriving(self, towards: str) -> np.ndarray:
        """Propagation factors of the coupling modes over the distance `half`."""
        return self.passed(towards, self.half)[self.coupling_modes]

    def sent(self, towards: str, lines: np.ndarray, *, by_end: bool = False) -> np.ndarray:
        """Amplitudes of the coupling modes in fields (n, m) that leave a piece or an end.

        They follow from biorthogonality, v_i^T (X_right + X_left) v_j = 0 for i to the left, j to the right and
        k_i != -k_j, because the port matrix is then symmetric whatever the errors of the modes.

        ``by_end``: True for the fields that an end reflects, one for each coupling mode that arrives.  Their products
        with the modes are a symmetric matrix by reciprocity.  The fluxes of fast decaying modes, with which plain ends
        are solved, err by up to 1e-9 on the finest level; the mean with the transpose keeps reciprocity to rounding.
        """
        modes, coupling_modes = self.modes, self.coupling_modes
        shapes, opposite = (modes.right, modes.left) if towards == "right" else (modes.left, modes.right)
        tests = opposite[:, coupling_modes].T @ modes.impedance_sum
        products = tests @ lines
        if by_end:
            products = 0.5 * (products + products.T)
        return np.linalg.solve(
            tests @ shapes[:, coupling_modes],
            self.passed(towards, self.travel - self.half)[coupling_modes, None] * products,
        )


class _Scattered(NamedTuple):
    """Response of a scatterer in the cascade.

    The columns are the m coupling modes that arrive from the left, those that arrive from the right, and the ports that
    determine its potentials.
    """

    element: Element
    sides: np.ndarray  # (2 n + ports of the piece, columns)
    incoming: np.ndarray  # (2 n, columns): the part of the lines that comes in


def _scattered(
    scatterer: Scatterer, ports: np.ndarray, before: _Segment, after: _Segment, *, coupled: np.ndarray, excitations: int
) -> _Scattered:
    """Response of a scatterer between two segments.

    ``ports``: those of the network that determine its potentials; ``coupled``: all modes that couple the ends of any
    segment, in rising order.
    """
    modes, at = scatterer.modes, Blocks(scatterer.modes.section.size)
    m, count = len(before.coupling_modes), len(before.coupling_modes) + len(after.coupling_modes)
    incoming = np.zeros((2 * at.size, count + len(ports)), dtype=complex)
    incoming[at.left, :m] = modes.right[:, before.coupling_modes] * before.arriving("right")
    incoming[at.right, m:count] = modes.left[:, after.coupling_modes] * after.arriving("left")
    potentials = np.zeros((len(scatterer.potentials), count + len(ports)))
    potentials[:, count:] = scatterer.potentials
    # of all modes that couple any segments, because equal transducers share the scatterer
    from_left, from_right, from_ports = scatterer.responses(coupled)
    lines = np.hstack(
        [
            from_left[:, np.searchsorted(coupled, before.coupling_modes)] * before.arriving("right"),
            from_right[:, np.searchsorted(coupled, after.coupling_modes)] * after.arriving("left"),
            from_ports,
        ]
    )
    # What the piece sends is the field of its lines less the incoming part.  The amplitudes of the coupling modes in it
    # are the scattering matrix, the first ``count`` columns, and the excitation by the ports.
    outgoing = lines - incoming
    sent = np.concatenate([before.sent("left", outgoing[at.left]), after.sent("right", outgoing[at.right])])
    excitation = np.zeros((count, excitations), dtype=complex)
    excitation[:, ports] = sent[:, count:]
    element = Element(
        scattering=sent[:, :count],
        excitation=excitation,
        leaves=np.append(before.left, after.right),
        arrives=np.append(before.right, after.left),
    )
    return _Scattered(element, np.concatenate([lines, potentials]), incoming)


@dataclass(frozen=True, kw_only=True)
class Network:
    """Scatterers in cascade between two ends."""

    modes: GuidedModes
    scatterers: tuple[Scatterer, ...]  # from left to right
    positions: tuple[float, ...]  # where their left lines lie, length units
    # start, stop: where the uniform stator begins and ends, length units
    start: float
    stop: float
    ends: tuple[End, End]  # at start and at stop
    ports: tuple[Port, ...]  # voltages and means of transducers, then forces
    numbers: tuple[np.ndarray, ...]  # for each scatterer: the ports that determine its potentials

    @cached_property
    def lines(self) -> list[tuple[float, float]]:
        """Positions of the left and of the right line of each scatterer, length units."""
        return [(left, left + each.piece.width) for left, each in zip(self.positions, self.scatterers, strict=True)]

    @cached_property
    def segments(self) -> np.ndarray:
        """Ends of the uniform segments before, between and after the scatterers, shape (scatterers + 1, 2)."""
        return np.array([self.start, *chain.from_iterable(self.lines), self.stop]).reshape(-1, 2)

    def survivors(self, length: float) -> np.ndarray:
        """Indices of the modes that are not negligible after a length; the constant potential carries no power."""
        alive = np.abs(np.exp(-1j * self.modes.wavenumbers * length)) > NEGLIGIBLE
        return np.flatnonzero(alive & (self.modes.wavenumbers != 0))

    @cached_property
    def forces(self) -> dict[int, ForceResponse]:
        """Response of an infinitely long segment to each port that is a force."""
        return {
            number: force_response(self.modes, port.component)
            for number, port in enumerate(self.ports)
            if port.kind == "force"
        }

    def forces_on(self, segment: int) -> tuple[int, ...]:
        """Numbers of the ports that are forces on a segment, from left to right."""
        start, stop = self.segments[segment]
        numbers = [number for number in self.forces if start <= self.ports[number].position <= stop]
        return tuple(sorted(numbers, key=lambda number: self.ports[number].position))

    def _refuse_covered_forces(self) -> None:
        """Raise an InputError for a force that lies on no uniform segment."""
        for port in (self.ports[number] for number in self.forces):
            if not any(start <= port.position <= stop for start, stop in self.segments):
                raise InputError(
                    "force.position",
                    "must lie on the bare surface, beside the pieces and the transducers with their outer gaps",
                    port.position * self.modes.section.length_unit,
                    "m",
                    owner=port.name,
                )

    def _coupled_segments(self, waves: np.ndarray) -> list[_Segment]:
        """Segments with their coupling modes; ``waves``: modes that arrive from outside at absorbing ends."""
        self._refuse_covered_forces()
        absorbs = [isinstance(end, str) and end == "absorbing" for end in self.ends]
        segments: list[_Segment] = []
        for index, (start, stop) in enumerate(self.segments):
            forces = self.forces_on(index)
            # A force excites modes anew: they reach the nearest edge after a distance shorter than the segment.
            to_edges = [abs(self.ports[each].position - edge) for each in forces for edge in (start, stop)]
            length = min([stop - start, *to_edges])
            coupling_modes, travel = self.survivors(length), stop - start
            semi_infinite = [absorbs[0] and index == 0, absorbs[1] and index == len(self.segments) - 1]
            # No wave returns from an absorbing end: a piece beside it receives only the waves from outside and those of
            # forces between the two.
            if any(semi_infinite):
                forced = forces and not all(semi_infinite)
                coupling_modes = np.append(waves, np.setdiff1d(coupling_modes, waves)) if forced else waves
                travel = 0.0
            before = segments[-1] if segments else None
            segments.append(
                _Segment(
                    modes=self.modes,
                    start=start,
                    stop=stop,
                    travel=travel,
                    coupling_modes=coupling_modes,
                    first=before.first + 2 * len(before.coupling_modes) if before else 0,
                    forces=forces,
                )
            )
        return segments

    def solve(self, waves: np.ndarray = NO_WAVES) -> "PortSolution":
        """Fields for a unit at each port, the other ports at zero, and for each wave that arrives from outside.

        Parameters
        ----------
        waves : ndarray of int
            Modes that arrive at the first line of the cascade, then at its last one; the ends are absorbing.
        """
        if any(scatterer.piece.size == 0 for scatterer in self.scatterers):
            return self._solve_whole(waves)
        ports = len(self.ports)
        segments, excitations = self._coupled_segments(waves), ports + 2 * len(waves)
        # segments[-side] is the first segment (segments[0]) at the left end, side 0, and the last one at the right end
        reflected = [self._reflection(side, segments[-side].coupling_modes) for side in (0, 1)]
        elements = [self._end(side, segments[-side], reflected[side], excitations) for side in (0, 1)]
        coupled = np.unique(np.concatenate([each.coupling_modes for each in segments]))
        responses = [
            _scattered(scatterer, own_ports, before, after, coupled=coupled, excitations=excitations)
            for scatterer, own_ports, before, after in zip(
                self.scatterers, self.numbers, segments, segments[1:], strict=False
            )
        ]
        elements += [each.element for each in responses]
        solved = solve_cascade(elements, outside=self._outside(segments, waves, excitations))

        # Superposition: the responses, weighted by the amplitudes that arrive and by one for the excited port.
        sides, arrived = [], []
        reactions = np.zeros((ports, excitations), dtype=complex)
        for scatterer, own_ports, response in zip(self.scatterers, self.numbers, responses, strict=True):
            arriving = solved.arriving[response.element.arrives]
            weights = np.concatenate([arriving, np.eye(ports, excitations)[own_ports]])
            sides.append(response.sides @ weights)
            arrived.append(response.incoming @ weights)
            reactions[own_ports] += scatterer.reactions(sides[-1])
        from_ends = [
            sent @ (segments[-side].arriving(towards)[:, None] * solved.arriving[elements[side].arrives])
            for side, (towards, sent) in enumerate(zip(("left", "right"), reflected, strict=True))
        ]
        amplitudes = self.segment_waves(sides, arrived, segments, from_ends)
        for number in self.forces:
            reactions[number] = self._displacement(number, amplitudes)
        return PortSolution(
            sides=tuple(sides),
            incoming=tuple(arrived),
            segments=amplitudes,
            reactions=reactions,
            coupling=solved.coupling,
            waves=np.concatenate([np.tile(each.coupling_modes, 2) for each in segments]),
        )

    def _solve_whole(self, waves: np.ndarray) -> "PortSolution":
        """Fields of a stator that is one piece from end to end, on which only the potentials of its ports act."""
        (scatterer,), (own_ports,), ports = self.scatterers, self.numbers, len(self.ports)
        if self.forces or len(waves):
            raise InputError("piece", "must leave some uniform stator for a line force or a wave from outside")
        potentials = scatterer.potentials @ np.eye(ports)[own_ports]
        reactions = np.zeros((ports, ports), dtype=complex)
        reactions[own_ports] = scatterer.reactions(potentials)
        return PortSolution(
            sides=(potentials,),
            incoming=(potentials[:0],),
            segments=((), ()),
            reactions=reactions,
            coupling=np.zeros((0, 0)),
            waves=NO_WAVES,
        )

    def _reflection(self, side: int, arriving: np.ndarray) -> np.ndarray:
        """Amplitudes of all modes that an end reflects, for a unit of each incident mode, (n, arriving)."""
        end = self.ends[side]
        if not len(arriving) or (isinstance(end, str) and end == "absorbing"):
            return np.zeros((self.modes.section.size, len(arriving)))
        return end_reflection(self.modes, end, side, arriving)

    def _end(self, side: int, segment: _Segment, reflected: np.ndarray, excitations: int) -> Element:
        """The left (0) or the right (1) end as an element of the cascade."""
        towards, away = ("left", "right") if side == 0 else ("right", "left")
        shapes = self.modes.right if side == 0 else self.modes.left
        scattering = np.zeros((len(segment.coupling_modes),) * 2, dtype=complex)
        if reflected.any():
            scattering = segment.sent(away, shapes @ reflected, by_end=True) * segment.arriving(towards)
        return Element(
            scattering=scattering,
            excitation=np.zeros((len(segment.coupling_modes), excitations)),
            leaves=segment.right if side == 0 else segment.left,
            arrives=segment.left if side == 0 else segment.right,
        )

    def _outside(self, segments: list[_Segment], waves: np.ndarray, excitations: int) -> np.ndarray | None:
        """Amplitudes that arrive at pieces and ends directly from forces and from outside, (waves, excitations).

        The columns are those of `solve`: all ports, then the waves from the left, then the waves from the right.
        """
        if not (self.forces or len(waves)):
            return None
        outside = np.zeros((segments[-1].first + 2 * len(segments[-1].coupling_modes), excitations), dtype=complex)
        for segment in segments:
            for number in segment.forces:
                force, position = self.forces[number], self.ports[number].position
                rightwards = segment.passed("right", segment.stop - position) * force.right
                leftwards = segment.passed("left", position - segment.start) * force.left
                outside[segment.right, number] = rightwards[segment.coupling_modes]
                outside[segment.left, number] = leftwards[segment.coupling_modes]
        # `coupling_modes` of a semi-infinite segment begins with ``waves``, so that entry `number` is wave `number`
        for number, column in enumerate(range(len(self.ports), len(self.ports) + len(waves))):
            outside[segments[0].right[number], column] = 1.0
            outside[segments[-1].left[number], column + len(waves)] = 1.0
        return outside

    def segment_waves(
        self,
        sides: list[np.ndarray],
        incoming: list[np.ndarray],
        segments: list[_Segment] | None = None,
        from_ends: list[np.ndarray] | None = None,
    ) -> tuple[tuple[SegmentWaves, ...], ...]:
        """Amplitudes of all modes in every segment, without the waves from outside.

        Parameters
        ----------
        sides, incoming
            As in `PortSolution`.
        segments : list, optional
            Segments with their forces; without, there are no waves from outside.
        from_ends : list of ndarray, shape (n, excitations), optional
            Amplitudes of all modes that leave both ends; zero if they absorb.
        """
        modes, at = self.modes, Blocks(self.modes.section.size)
        segments = segments or self._coupled_segments(NO_WAVES)
        excitations = sides[0].shape[1] if sides else len(self.ports)
        out = [own[at.lines] - arrived for own, arrived in zip(sides, incoming, strict=True)]
        leaving = np.array(out, dtype=complex).reshape(len(out), 2 * at.size, excitations)

        def by_piece(amplitudes: Callable[[np.ndarray], np.ndarray], lines: np.ndarray) -> list[np.ndarray]:
            """Amplitudes in the fields of all pieces (pieces, n, excitations), by one factorisation of the modes."""
            both = amplitudes(np.moveaxis(lines, 0, 1).reshape(at.size, -1))
            return list(np.moveaxis(both.reshape(at.size, len(lines), -1), 1, 0)) if len(lines) else []

        left_end, right_end = from_ends or (np.zeros((at.size, excitations), dtype=complex),) * 2
        right = [left_end, *by_piece(modes.right_amplitudes, leaving[:, at.right])]
        left = [*by_piece(modes.left_amplitudes, leaving[:, at.left]), right_end]
        return tuple(self._parts(*each) for each in zip(segments, right, left, strict=True))

    def _parts(self, segment: _Segment, right: np.ndarray, left: np.ndarray) -> tuple[SegmentWaves, ...]:
        """Parts of a segment between its forces, for amplitudes ``right`` at its start and ``left`` at its stop."""
        positions = [self.ports[number].position for number in segment.forces]
        edges = [segment.start, *positions, segment.stop]
        parts = []
        for index, (start, stop) in enumerate(pairwise(edges)):
            going_right, going_left = right, left
            if positions:
                going_right = segment.passed("right", start - segment.start)[:, None] * right
                going_left = segment.passed("left", segment.stop - stop)[:, None] * left
            for position, number in zip(positions[:index], segment.forces, strict=False):
                going_right[:, number] += segment.passed("right", start - position) * self.forces[number].right
            for position, number in zip(positions[index:], segment.forces[index:], strict=True):
                going_left[:, number] += segment.passed("left", position - stop) * self.forces[number].left
            parts.append(SegmentWaves(start=start, stop=stop, right=going_right, left=going_left))
        return tuple(parts)

    def _displacement(self, number: int, amplitudes: tuple[tuple[SegmentWaves, ...], ...]) -> np.ndarray:
        """Displacement at a force, in its direction, for each excitation."""
        modes, port = self.modes, self.ports[number]
        part = next(part for own in amplitudes for part in own if part.start <= port.position <= part.stop)
        lines = modes.right @ part.right_at(modes, port.position) + modes.left @ part.left_at(modes, port.position)
        return modes.section.surface_rows["xz".index(port.component)] @ lines


@dataclass(frozen=True, kw_only=True)
class PortSolution:
    """Fields per unit at each port: of scaled potential, or of force in N/m; then per wave from outside."""

    # shape (2 n + ports of the piece, excitations): of each scatterer: its lines and the potentials of its electrodes
    sides: tuple[np.ndarray, ...] = field(repr=False)
    # shape (2 n, excitations): the part of the lines that comes in
    incoming: tuple[np.ndarray, ...] = field(repr=False)
    segments: tuple[tuple[SegmentWaves, ...], ...] = field(repr=False)  # before, between and after the scatterers
    # shape (ports, excitations): reactions: minus the charge, scaled, symmetric among potentials; displacements in m
    reactions: np.ndarray
    # shape (waves, waves): `fem.waveguide.cascade_system.CascadeWaves.coupling`
    coupling: np.ndarray = field(repr=False)
    waves: np.ndarray = field(repr=False)  # shape (waves,): number of the mode of each of these amplitudes
    # of each scatterer: what its charges are along the fingers (fem.beam.reception); empty for a section's
    sheets: tuple[tuple["Sheet", ...], ...] = field(default=(), repr=False)
    # each transducer's charge is that of its whole aperture, not of the shared beam
    own_apertures: bool = False

    def weighted(self, weights: np.ndarray) -> "PortSolution":
        """Fields for sums of the excitations, ``weights`` of shape (excitations, sums)."""
        return replace(
            self,
            sides=tuple(each @ weights for each in self.sides),
            incoming=tuple(each @ weights for each in self.incoming),
            segments=tuple(tuple(part.weighted(weights) for part in parts) for parts in self.segments),
            reactions=self.reactions @ weights,
            sheets=tuple(tuple(sheet.weighted(weights) for sheet in own) for own in self.sheets),
        )


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """Charges of a transducer that are uniform over |y| < length / 2, per unit at each port."""

    length: float  # m
    # as of `PortSolution`, with the potentials that would make the charges
    sides: np.ndarray = field(repr=False)
    # first moments of the charged fingers about their middles that the sides do not have, (fingers, ports)
    dipoles: np.ndarray = field(repr=False)

    def weighted(self, weights: np.ndarray) -> "Sheet":
        """Charges for sums of the excitations, ``weights`` of shape (excitations, sums)."""
        return replace(self, sides=self.sides @ weights, dipoles=self.dipoles @ weights)
