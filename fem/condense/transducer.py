"""`FingerColumns` of a transducer: from the columns of a finger's cell to all of its fingers.

A cell is half a gap, a finger and half a gap.  It is condensed in two halves, one the mirror image of the other where
x -> -x is a symmetry.  Equal runs of cells are joined once.  The functions below call `Condensation` for every single
step; a subclass in `fem.condense.problem_size` counts these steps without computing anything.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np

from fem.condense.cascade_piece import ELECTRODES
from fem.condense.column_skeleton import Skeleton, column_skeleton
from fem.condense.electrode_conditions import open_circuit
from fem.condense.finger_columns import FingerColumns, Restated, condensed
from fem.condense.joined_fingers import Reflection, exchanged, joined, mirrored, repeated, with_fingers, with_ports
from fem.condense.reaction_moments import finger_dipole
from fem.discretize.element_sizes import Resolution, edge_layers, graded
from fem.discretize.section import LineSpace
from fem.geometry import Stator, Transducer, outer_gaps
from fem.parameters import InputError

ROUNDED = 9  # digits of a finger's width and of its gaps over the narrowest width


@dataclass(eq=False)
class Condensation:
    """Elementary steps of the condensation on a section at a frequency in Hz; a new finger is on electrode 0.

    A column is condensed on the lines of the full section; pieces on reduced lines are only joined.
    """

    section: LineSpace
    frequency: float
    skeletons: dict[float, Skeleton] = field(default_factory=dict, repr=False)  # by width, of fingers and of gaps

    def column(self, width: float, electrode: int | None) -> FingerColumns:
        """Condense one column of elements."""
        key = round(width, 12)
        if key not in self.skeletons:
            self.skeletons[key] = column_skeleton(self.section.full, self.frequency, width)
        skeleton = self.skeletons[key]
        return condensed(self.section.full, self.frequency, width=width, electrode=electrode, skeleton=skeleton)

    def joined(self, left: FingerColumns, right: FingerColumns, electrode: int | None = None) -> FingerColumns:
        """Join two neighbours; ``electrode`` if a finger lies on the line they share."""
        phi = None if electrode is None else self.section.full.finger_potential
        return joined(left, right, phi=phi, electrode=electrode, odd=self.section.odd)

    def mirrored(self, superelement: FingerColumns) -> FingerColumns:
        """Reflect in x -> -x."""
        solid, odd = self.section.solid, self.section.odd
        if odd is None or solid.parity is None:
            raise ValueError(f"x -> -x is no symmetry of {solid}")
        return mirrored(superelement, Reflection(odd, bool(solid.parity[solid.fields.index("phi")])))

    exchanged = staticmethod(exchanged)

    def open_circuited(self, superelement: FingerColumns) -> FingerColumns:
        """Disconnect the finger from electrode 0: it carries no net charge."""
        matrix, sides = open_circuit(superelement.matrix, superelement.at.ports.start)
        return replace(superelement, matrix=matrix, inside=Restated(piece=superelement, sides=sides))


@dataclass(frozen=True, kw_only=True)
class FingerShape:
    """A finger and the halves of its two neighbouring gaps, length units."""

    half_finger: float
    half_gaps: tuple[float, float]

    @classmethod
    def of(cls, transducer: Transducer, unit: float) -> "FingerShape":
        """Of a transducer's inner fingers; ``unit``: the length unit in m."""
        return cls(half_finger=transducer.finger_width / 2 / unit, half_gaps=(transducer.half_gap / unit,) * 2)

    @classmethod
    def each(cls, transducer: Transducer, outer: tuple[float, float], unit: float) -> list["FingerShape"]:
        """Of all fingers; ``outer``: bare surface at both ends, ``unit``: the length unit, m.

        Lengths are rounded, so that equal fingers of different periods have equal shapes.
        """
        if transducer.even:
            inner = cls.of(transducer, unit)
            half_gap, last = inner.half_gaps[0], len(transducer.signs) - 1
            ends = [half_gap if abs(gap / unit - half_gap) < 1e-9 * half_gap else gap / unit for gap in outer]
            return [
                replace(inner, half_gaps=(ends[0] if k == 0 else half_gap, ends[1] if k == last else half_gap))
                for k in range(last + 1)
            ]
        gaps = np.concatenate([[2 * outer[0]], transducer.gaps, [2 * outer[1]]])  # half of each belongs to a finger
        widths = np.ptp(transducer.fingers, axis=1)
        digits = ROUNDED - int(np.floor(np.log10(widths.min() / unit)))
        half_fingers, half_gaps = ((lengths / 2 / unit).round(digits).tolist() for lengths in (widths, gaps))
        return [
            cls(half_finger=half, half_gaps=both) for half, both in zip(half_fingers, pairwise(half_gaps), strict=True)
        ]

    @property
    def width(self) -> float:
        """Width of the cell."""
        return self.half_gaps[0] + 2 * self.half_finger + self.half_gaps[1]

    @property
    def even(self) -> bool:
        """True if both gaps are equal."""
        return abs(self.half_gaps[0] - self.half_gaps[1]) < 1e-9 * self.half_gaps[0]


def half_cells(make: Condensation, shape: FingerShape, resolution: Resolution) -> tuple[FingerColumns, FingerColumns]:
    """Condense the two halves of a finger's cell: gap to mid-finger, and mid-finger to gap, electrode 0."""
    done: dict[tuple, FingerColumns] = {}

    def piece(width: float, electrode: int | None) -> FingerColumns:
        key = (round(width, 12), electrode)
        if key not in done:
            done[key] = make.column(width, electrode)
        return done[key]

    def adjacent(widths: np.ndarray, electrode: int | None) -> FingerColumns:
        whole = piece(widths[0], electrode)
        for width in widths[1:]:
            whole = make.joined(whole, piece(width, electrode), electrode)
        return whole

    smallest = min(shape.half_finger, *shape.half_gaps)
    metal, left, right = (
        graded(length, edge_layers(resolution, length, smallest), largest=resolution.element_size)
        for length in (shape.half_finger, *shape.half_gaps)
    )
    rising = make.joined(adjacent(left, None), adjacent(metal[::-1], 0), 0)
    if make.section.odd is not None and shape.even:
        return rising, make.mirrored(rising)
    return rising, make.joined(adjacent(metal, 0), adjacent(right[::-1], None), 0)


def finger_cell(make: Condensation, shape: FingerShape, resolution: Resolution) -> FingerColumns:
    """Condense half a gap, a finger of electrode 0 and half a gap."""
    return make.joined(*half_cells(make, shape, resolution), 0)


def joined_fingers(
    make: Condensation,
    signs: str,
    shapes: Sequence[FingerShape],
    cell: Callable[[FingerShape], FingerColumns],
    bare: Callable[[FingerShape], FingerColumns],
) -> FingerColumns:
    """Join the cells of fingers, of signs "+", "-", "0" (omitted) or "o" (open); equal runs are joined once.

    ``shapes``: of each finger.  ``cell`` and ``bare`` return the superelement of a finger of a shape on electrode 0, or
    of bare surface of the same width.
    """
    singles: dict[tuple, FingerColumns] = {}

    def single(sign: str, shape: FingerShape) -> FingerColumns:
        if (sign, shape) not in singles:
            kinds = {
                "+": cell,
                "-": lambda shape: make.exchanged(cell(shape)),
                "0": bare,
                "o": lambda shape: make.open_circuited(cell(shape)),
            }
            singles[sign, shape] = kinds[sign](shape)
        return singles[sign, shape]

    return _joined_run(make, single, {}, list(zip(signs, shapes, strict=True)))


def _joined_run(make: Condensation, single: Callable, runs: dict, fingers: list) -> FingerColumns:
    """Join fingers, each its sign and shape; ``runs``: what is joined already.

    A function within `joined_fingers` that called itself would keep all superelements until the next search for cyclic
    garbage.
    """
    key = tuple(fingers)
    if key not in runs:
        if len(fingers) == 1:
            runs[key] = single(*fingers[0])
        else:
            half = _left_half(len(fingers))
            left, right = (_joined_run(make, single, runs, each) for each in (fingers[:half], fingers[half:]))
            runs[key] = make.joined(left, right)
    return runs[key]


def _left_half(count: int) -> int:
    """Fingers in the left part of the superelement of a transducer."""
    return 2 ** ((count - 1).bit_length() - 1)


def finger_ports(transducer: FingerColumns, signs: str) -> tuple[FingerColumns, np.ndarray]:
    """FingerColumns of a transducer with one potential for each finger "+" or "-", from left to right.

    Also the first moments of these fingers' reactions about their middles as functions of its sides, length units,
    shape (fingers, 2 n + fingers).
    """
    return _ports_of_run(transducer, signs, {})


def on_electrodes(by_finger: FingerColumns, signs: str) -> FingerColumns:
    """Superelement with two electrodes from that with one potential for each finger "+" or "-" (`finger_ports`).

    ``signs``: of the fingers; which are "+" and which "-" is free.  The fingers of an apodised transducer belong to the
    other electrode beyond their tips.
    """
    lines = by_finger.at.ports.start
    place = np.zeros((len(by_finger.matrix), lines + 2))
    place[:lines, :lines] = np.eye(lines)
    electrodes = ["+-".index(sign) for sign in signs if sign in "+-"]
    place[lines + np.arange(len(electrodes)), lines + np.array(electrodes, dtype=int)] = 1.0

    def sides(own: np.ndarray) -> np.ndarray:
        return np.tensordot(place, own, axes=1)

    matrix = place.T @ by_finger.matrix @ place
    return replace(by_finger, matrix=matrix, ports=ELECTRODES, inside=Restated(piece=by_finger, sides=sides))


def _ports_of_run(piece: FingerColumns, signs: str, done: dict) -> tuple[FingerColumns, np.ndarray]:
    """`finger_ports` of a part of the fingers; ``done``: results by piece and number of fingers."""
    key = id(piece), len(signs)
    if key not in done:
        if len(signs) == 1:
            done[key] = _single(piece, signs)
        else:
            half = _left_half(len(signs))
            left, below = _ports_of_run(piece.pair.left, signs[:half], done)
            right, above = _ports_of_run(piece.pair.right, signs[half:], done)
            whole = with_fingers(piece, left, right)
            done[key] = whole, np.concatenate([whole.pair.from_left(below), whole.pair.from_right(above)])
    return done[key]


def _single(piece: FingerColumns, sign: str) -> tuple[FingerColumns, np.ndarray]:
    if sign not in "+-":
        return with_ports(piece, []), np.zeros((0, piece.at.ports.start))
    return with_ports(piece, ["+-".index(sign)]), finger_dipole(piece)[None]


def transducer_superelements(
    make: Condensation, stator: Stator, transducers: tuple[Transducer, ...], resolution: Resolution
) -> list[FingerColumns]:
    """Pieces of transducers from left to right, between their outer gaps; equal ones are the same object."""
    made: dict[tuple, FingerColumns] = {}
    pieces = []
    for each in transducers:
        if not each.uniform_along_y:
            rule = "must be uniform along y in one section: the answer of an apodised or slanted one is a sum of strips"
            raise InputError("transducer", rule, owner=each.name)
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        own = (transducer.cell, transducer.mirrored, transducer.chirp)
        key = (transducer.signs, transducer.pitch, transducer.metallisation, *own, gaps)
        if key not in made:
            made[key] = _transducer_superelement(make, transducer, gaps, resolution)
        pieces.append(made[key])
    return pieces


def _transducer_superelement(make: Condensation, transducer: Transducer, gaps, resolution: Resolution) -> FingerColumns:
    """Piece of one transducer between its outer gaps, m."""
    made: dict[FingerShape, FingerColumns] = {}

    def cell(shape: FingerShape) -> FingerColumns:
        if shape not in made:
            made[shape] = finger_cell(make, shape, resolution)
        return made[shape]

    def bare(shape: FingerShape) -> FingerColumns:
        widths = graded(shape.width, 0, largest=resolution.element_size)
        return repeated(make.column(widths[0], None), len(widths), make.joined)

    return joined_fingers(
        make, transducer.signs, FingerShape.each(transducer, gaps, make.section.length_unit), cell, bare
    )
