"""Pieces in a waveguide: what each sends and scatters, and how segments and ends tie them together.

A piece - a transducer, or a mesh - sits between two uniform segments whose exact ends X_right and X_left are known
(modes.py).  With p the part of the field that goes right and q the part that goes left, its lines obey

    (A - diag(X_left, X_right)) u = [-(X_right + X_left) p_in, -(X_left + X_right) q_in] - A_ports V,

so one factorisation gives what it sends for each voltage and for each mode that arrives.  Along a segment of length
l a mode changes by exp(-i k l): only those that survive to double precision couple the pieces, which makes length
free of cost.  Free and clamped ends turn the modes that arrive into all modes of the section.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.piece import Piece, RecoveredField
from fem.condense.recovery import ColumnsField
from fem.condense.superelement import Superelement
from fem.waveguide.ends import End, end_reflection, with_gauge
from fem.waveguide.modes import GuidedModes

NEGLIGIBLE = 1e-18  # a mode's amplitude after a segment, relative: far below rounding


@dataclass(frozen=True, kw_only=True)
class Scatterer:
    """A condensed piece in the waveguide."""

    superelement: Piece
    modes: GuidedModes
    # shape (2, ports), or a row for each finger: electrode potentials of each port: half and minus half for the
    # voltage; one and one for the mean where the section is grounded (elsewhere the mean is a matter of gauge)
    potentials: np.ndarray

    def recover(self, sides: np.ndarray) -> RecoveredField:
        """Field inside for given lines and potentials of the electrodes."""
        if isinstance(self.superelement, Superelement):
            return ColumnsField(self.superelement, sides)
        return self.superelement.recover(sides)

    @cached_property
    def _between_ends(self):
        n = self.superelement.size
        system = self.superelement.matrix[: 2 * n, : 2 * n].astype(complex)
        system[:n, :n] -= self.modes.left_impedance
        system[n:, n:] -= self.modes.right_impedance
        if self.superelement.floating_potential:
            system = with_gauge(system, self.modes.section.constant_potential)
        return system

    def sides(self, incoming: np.ndarray, potentials: np.ndarray) -> np.ndarray:
        """Both lines' unknowns, shape (2 n, m).

        ``incoming``: field going right at the left line, then field going left at the right line, (2 n, m);
        ``potentials`` of the electrodes, scaled, (2, m).
        """
        n = self.superelement.size
        both = self.modes.impedance_sum
        load = -self.superelement.matrix[: 2 * n, 2 * n :] @ potentials
        load = load.astype(complex)
        load[:n] -= both @ incoming[:n]
        load[n:] -= both @ incoming[n:]
        return np.linalg.solve(self._between_ends, load)

    def charge(self, sides: np.ndarray, potentials: np.ndarray) -> np.ndarray:
        """Reactions q of the ports, scaled (minus the charge), shape (ports, m)."""
        n = self.superelement.size
        electrodes = self.superelement.matrix[2 * n :]
        return self.potentials.T @ (electrodes[:, : 2 * n] @ sides + electrodes[:, 2 * n :] @ potentials)


@dataclass(frozen=True, kw_only=True)
class Network:
    """Scatterers in a row between two ends."""

    modes: GuidedModes
    scatterers: tuple[Scatterer, ...]  # from left to right
    places: tuple[float, ...]  # where their left lines lie, length units
    # start, stop: where the uniform stator begins and ends, length units
    start: float
    stop: float
    ends: tuple[End, End]  # at start and at stop
    # of each scatterer: the network's ports that its potentials follow; one after the other if not given
    port_numbers: tuple[np.ndarray, ...] | None = None

    @property
    def ports(self) -> int:
        """Ports of the network."""
        return 1 + max((int(each.max()) for each in self.numbers if len(each)), default=-1)

    @property
    def numbers(self) -> tuple[np.ndarray, ...]:
        """Ports of the network that each scatterer's potentials follow."""
        if self.port_numbers is not None:
            return self.port_numbers
        counts = [each.potentials.shape[1] for each in self.scatterers]
        return tuple(np.split(np.arange(sum(counts)), np.cumsum(counts)[:-1]))

    @property
    def segments(self) -> np.ndarray:
        """Ends of the uniform segments before, between and after the scatterers, shape (scatterers + 1, 2)."""
        edges = [self.start]
        for place, scatterer in zip(self.places, self.scatterers, strict=True):
            edges += [place, place + scatterer.superelement.width]
        return np.array([*edges, self.stop]).reshape(-1, 2)

    def survivors(self, length: float) -> np.ndarray:
        """Modes that matter after a segment; the constant potential carries nothing and is left out."""
        alive = np.abs(np.exp(-1j * self.modes.wavenumbers * length)) > NEGLIGIBLE
        return np.flatnonzero(alive & (self.modes.wavenumbers != 0))

    def solve(self) -> "PortSolution":
        """Fields for one unit of potential at each port in turn, the other ports at zero.

        Returns
        -------
        PortSolution
        """
        modes, n = self.modes, self.modes.section.size
        lengths = np.diff(self.segments, axis=1)[:, 0]
        kept = [self.survivors(length) for length in lengths]
        closed = [end != "absorbing" for end in self.ends]
        # unknowns: in the middle of every segment, amplitudes going right and going left
        slots, total = [], 0
        for segment, keep in enumerate(kept):
            open_ends = [not closed[side] for side, end in ((0, 0), (1, len(kept) - 1)) if segment == end]
            count = 0 if any(open_ends) else len(keep)
            slots.append((slice(total, total + count), slice(total + count, total + 2 * count)))
            total += 2 * count
        system = np.eye(total, dtype=complex)
        load = np.zeros((total, self.ports), dtype=complex)
        answers = []
        for index, (scatterer, mine) in enumerate(zip(self.scatterers, self.numbers, strict=True)):
            before, after = kept[index], kept[index + 1]
            from_left, to_left = slots[index]
            to_right, from_right = slots[index + 1]
            arrive_left = before[: from_left.stop - from_left.start]
            arrive_right = after[: from_right.stop - from_right.start]
            count = len(mine)
            # columns: what arrives from the left, from the right, and the ports
            left = slice(0, len(arrive_left))
            right = slice(left.stop, left.stop + len(arrive_right))
            own = slice(right.stop, right.stop + count)
            way = self._half_way("right", arrive_left, lengths[index])
            back = self._half_way("left", arrive_right, lengths[index + 1])
            incoming = np.zeros((2 * n, own.stop), dtype=complex)
            incoming[:n, left] = modes.right[:, arrive_left] * way
            incoming[n:, right] = modes.left[:, arrive_right] * back
            potentials = np.zeros((len(scatterer.potentials), own.stop))
            potentials[:, own] = scatterer.potentials
            sides = scatterer.sides(incoming, potentials)
            out = sides - incoming
            for slot, rows in (
                (to_left, self._sent("left", arrive_left, lengths[index], out[:n])),
                (to_right, self._sent("right", arrive_right, lengths[index + 1], out[n:])),
            ):
                system[slot, from_left] -= rows[:, left]
                system[slot, from_right] -= rows[:, right]
                load[slot.start : slot.stop, mine] += rows[:, own]
            sources = [(left, from_left), (right, from_right)]
            answers.append((sides, potentials, incoming, sources, own, mine))
        self._reflect(system, slots, kept, lengths)
        amplitudes = np.linalg.solve(system, load) if total else load
        labels = [
            keep for keep, slot in zip(kept, slots, strict=True) for one in slot if one.stop > one.start
        ]
        waves = np.concatenate(labels) if labels else np.empty(0, dtype=int)
        return self._gathered(amplitudes, answers, np.eye(total) - system, waves)

    @cached_property
    def reflections(self) -> tuple[tuple[np.ndarray, np.ndarray] | None, ...]:
        """Of the left and the right end: the modes that arrive, and all modes sent back for each, (n, arriving).

        None for an absorbing end.
        """
        found = []
        for segment, side in ((0, 0), (-1, 1)):
            start, stop = self.segments[segment]
            arriving, end = self.survivors(stop - start), self.ends[side]
            sent = None if end == "absorbing" else end_reflection(self.modes, end, side, arriving)
            found.append(None if sent is None else (arriving, sent))
        return tuple(found)

    def _reflect(self, system, slots, kept, lengths):
        """Equations of the ends that reflect: amplitudes leaving an end from those that arrive there."""
        for segment, side in ((0, 0), (len(kept) - 1, 1)):
            if self.reflections[side] is None:
                continue
            going_right, going_left = slots[segment]
            keep, sent = self.reflections[side]
            length = lengths[segment]
            if side == 0:
                back = self._sent("right", keep, length, self.modes.right @ sent)
                system[going_right, going_left] -= back * self._half_way("left", keep, length)
            else:
                back = self._sent("left", keep, length, self.modes.left @ sent)
                system[going_left, going_right] -= back * self._half_way("right", keep, length)

    def _half_way(self, towards: str, chosen: np.ndarray, length: float) -> np.ndarray:
        """Factor of modes over half a segment."""
        k = self.modes.wavenumbers if towards == "right" else -self.modes.backwards
        return np.exp(-0.5j * k[chosen] * length)

    def _sent(self, towards: str, chosen: np.ndarray, length: float, field: np.ndarray) -> np.ndarray:
        """Amplitudes in mid-segment of chosen modes in a field that leaves a scatterer or an end.

        By the modes' biorthogonality, v_i^T (X_right + X_left) v_j = 0 for i going left, j going right, k_i != -k_j:
        the port matrix is then symmetric whatever the errors of the modes.
        """
        modes = self.modes
        shapes, opposite = (modes.right, modes.left) if towards == "right" else (modes.left, modes.right)
        tests = opposite[:, chosen].T @ modes.impedance_sum
        half_way = self._half_way(towards, chosen, length)[:, None]
        return np.linalg.solve(tests @ shapes[:, chosen], half_way * (tests @ field))

    def _gathered(self, amplitudes, answers, coupling, waves) -> "PortSolution":
        ports = self.ports
        sides, incoming, charges = [], [], np.zeros((ports, ports), dtype=complex)
        for scatterer, (lines, potentials, arriving, sources, own, mine) in zip(
            self.scatterers, answers, strict=True
        ):
            weights = np.zeros((lines.shape[1], ports), dtype=complex)
            for columns, slot in sources:
                weights[columns] = amplitudes[slot]
            weights[np.arange(own.start, own.stop), mine] = 1.0
            sides.append(np.concatenate([lines, potentials]) @ weights)
            incoming.append(arriving @ weights)
            charges[mine] += scatterer.charge(*np.split(sides[-1], [len(lines)]))
        return PortSolution(
            sides=tuple(sides), incoming=tuple(incoming), charges=charges, coupling=coupling, waves=waves
        )


@dataclass(frozen=True, kw_only=True)
class PortSolution:
    """Fields per unit of scaled potential at each port."""

    # shape (2 n + electrodes, ports): of each scatterer: its lines and the potentials of its electrodes
    sides: tuple[np.ndarray, ...] = field(repr=False)
    # shape (2 n, ports): the part of the lines that comes in
    incoming: tuple[np.ndarray, ...] = field(repr=False)
    charges: np.ndarray  # shape (ports, ports): reactions q, scaled; symmetric
    # shape (waves, waves): M of (1 - M) a = a_sent: amplitudes that leave scatterers and ends from those that
    # left the ones beside them. The stator resonates where an eigenvalue of M is near 1.
    coupling: np.ndarray = field(repr=False)
    waves: np.ndarray = field(repr=False)  # shape (waves,): number of the mode of each of these amplitudes
    # of each scatterer: what its charges are along the fingers (fem.beam.reception); empty for a section's
    sheets: tuple[tuple["Sheet", ...], ...] = field(default=(), repr=False)
    # each transducer's charge is that of its whole aperture, not of the shared beam
    own_apertures: bool = False


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """Charges of a transducer that are uniform over |y| < length / 2, per unit at each port."""

    length: float  # m
    sides: np.ndarray = field(
        repr=False
    )  # as of `PortSolution`, with the potentials that would make the charges
    # shape (fingers, ports): reactions on the charged fingers, and their first moments about the middles
    reactions: np.ndarray = field(repr=False)
    moments: np.ndarray = field(repr=False)
    dipoles: np.ndarray = field(repr=False)  # the part of the moments that the sides do not have
