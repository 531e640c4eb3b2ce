"""Joining condensed pieces: mirror, join, repeat by doubling, and the way back to every line.

Two neighbours share a line; eliminating it gives the superelement of both (substructuring).  N equal pieces take about
log2(N) joins instead of N (superelement cyclic reduction, Buzbee, Golub and Nielson 1970), and the unknowns between are
found again from the sides, level by level.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from fem.condense.superelement import PORTS, Superelement, eliminated, folded


def joined(
    left: Superelement, right: Superelement, *, phi: int | None = None, electrode: int | None = None
) -> Superelement:
    """Superelement of two neighbours; its ``parts`` keep the way back to the line they share.

    Both have the same potentials.  If that line's surface node lies on a finger: ``phi``, the number of the potential
    there, and the finger's electrode.
    """
    n = left.size
    first, second = left.matrix, right.matrix
    if electrode is not None:
        first, second = folded(left, 1, phi, electrode), folded(right, 0, phi, electrode)
    middle = first[n : 2 * n, n : 2 * n] + second[:n, :n]
    coupling = np.zeros((n, len(first)), dtype=middle.dtype)
    coupling[:, :n] = first[n : 2 * n, :n]
    coupling[:, n : 2 * n] = second[:n, n : 2 * n]
    coupling[:, 2 * n :] = first[n : 2 * n, 2 * n :] + second[:n, 2 * n :]
    if electrode is not None:
        middle[phi, phi] = 1.0
    back = eliminated(middle, coupling)
    matrix = coupling.T @ back
    matrix[:n, :n] += first[:n, :n]
    matrix[n : 2 * n, n : 2 * n] += second[n : 2 * n, n : 2 * n]
    matrix[:n, 2 * n :] += first[:n, 2 * n :]
    matrix[2 * n :, :n] += first[2 * n :, :n]
    matrix[n : 2 * n, 2 * n :] += second[n : 2 * n, 2 * n :]
    matrix[2 * n :, n : 2 * n] += second[2 * n :, n : 2 * n]
    matrix[2 * n :, 2 * n :] += first[2 * n :, 2 * n :] + second[2 * n :, 2 * n :]
    if electrode is not None:
        back[phi, 2 * n + electrode] = 1.0
    matrix = 0.5 * (matrix + matrix.T)
    return Superelement(size=n, matrix=matrix, width=left.width + right.width, parts=(left, right, back))


def repeated(
    piece: Superelement, count: int, join: Callable[[Superelement, Superelement], Superelement] = joined
) -> Superelement:
    """Superelement of ``count`` equal neighbours, by doubling."""
    result, power = None, piece
    while True:
        if count & 1:
            result = power if result is None else join(result, power)
        count >>= 1
        if not count:
            return result
        power = join(power, power)


def with_ports(piece: Superelement, ports: list[int]) -> Superelement:
    """The same piece with some of its potentials, those of the numbers ``ports``, the others zero."""
    kept = np.r_[0 : 2 * piece.size, 2 * piece.size + np.array(ports, dtype=int)]

    def expand(sides: np.ndarray) -> tuple[Superelement, np.ndarray]:
        own = np.zeros((len(piece.matrix), *sides.shape[1:]), dtype=sides.dtype)
        own[kept] = sides
        return piece, own

    return Superelement(
        size=piece.size, matrix=piece.matrix[np.ix_(kept, kept)], width=piece.width, expand=expand
    )


def with_fingers(pair: Superelement, left: Superelement, right: Superelement) -> Superelement:
    """A joined pair with its parts' own potentials, from left to right, in the place of their common ones.

    ``left``, ``right``: the pair's parts with potentials of their own.
    """
    n, first, second = pair.size, left.matrix, right.matrix
    count = len(first) - 2 * n
    total = count + len(second) - 2 * n
    loads = np.zeros((3, n, total), dtype=np.result_type(first, second))  # of the left, middle and right line
    loads[:2, :, :count] = first[: 2 * n, 2 * n :].reshape(2, n, count)
    loads[1:, :, count:] += second[: 2 * n, 2 * n :].reshape(2, n, total - count)
    by_sides = pair.parts[2][:, : 2 * n]
    by_ports = eliminated(first[n : 2 * n, n : 2 * n] + second[:n, :n], loads[1])
    matrix = np.zeros((2 * n + total,) * 2, dtype=by_ports.dtype)
    matrix[: 2 * n, : 2 * n] = pair.matrix[: 2 * n, : 2 * n]
    matrix[: 2 * n, 2 * n :] = np.concatenate([loads[0], loads[2]]) + by_sides.T @ loads[1]
    matrix[2 * n :, : 2 * n] = matrix[: 2 * n, 2 * n :].T
    own = loads[1].T @ by_ports
    own[:count, :count] += first[2 * n :, 2 * n :]
    own[count:, count:] += second[2 * n :, 2 * n :]
    matrix[2 * n :, 2 * n :] = 0.5 * (own + own.T)
    parts = tuple(
        replace(part, expand=lambda sides, part=part, some=some: (part, _some_ports(sides, n, some)))
        for part, some in ((left, slice(0, count)), (right, slice(count, total)))
    )
    back = np.concatenate([by_sides, by_ports], axis=1)
    return Superelement(size=n, matrix=matrix, width=pair.width, parts=(*parts, back))


def _some_ports(sides: np.ndarray, n: int, some: slice) -> np.ndarray:
    return np.concatenate([sides[: 2 * n], sides[2 * n :][some]])


def exchanged(piece: Superelement) -> Superelement:
    """The same piece with its fingers on the other electrode; inside, it keeps its own."""
    n = piece.size
    order = np.r_[0 : 2 * n, 2 * n + 1, 2 * n]
    return replace(piece, matrix=piece.matrix[np.ix_(order, order)], exchanged=not piece.exchanged)


def mirrored(piece: Superelement, odd: np.ndarray, phi_odd: bool) -> Superelement:
    """The piece seen in a mirror x -> -x that is a symmetry of the solid; a single column is its own mirror image.

    ``odd``: unknowns of a line that change sign, shape (n,); ``phi_odd``: whether all potentials do.
    """
    if piece.column is not None:
        return piece
    n = piece.size
    signs = np.where(odd, -1.0, 1.0)
    order = np.r_[n : 2 * n, 0:n, 2 * n : 2 * n + PORTS]
    all_signs = np.concatenate([signs, signs, np.full(PORTS, -1.0 if phi_odd else 1.0)])
    parts: tuple = ()
    if piece.parts:
        left, right, back = piece.parts
        reflected = signs[:, None] * back[:, order] * all_signs
        parts = mirrored(right, odd, phi_odd), mirrored(left, odd, phi_odd), reflected
    phi_sign = -all_signs[-1]  # of a moment, for x changes its sign
    return Superelement(
        size=n,
        matrix=all_signs[:, None] * piece.matrix[np.ix_(order, order)] * all_signs,
        width=piece.width,
        parts=parts,
        moment=None if piece.moment is None else phi_sign * piece.moment[order] * all_signs,
    )


def open_circuited(piece: Superelement) -> Superelement:
    """The same piece with its finger cut off from electrode 0: at whatever potential leaves it no charge."""
    finger = 2 * piece.size
    row = -piece.matrix[finger] / piece.matrix[finger, finger]
    row[finger] = 0.0
    matrix = piece.matrix + np.outer(piece.matrix[finger], row)
    matrix[finger], matrix[:, finger] = 0.0, 0.0
    return replace(piece, matrix=0.5 * (matrix + matrix.T), floating=row)


def lines(
    piece: Superelement, sides: np.ndarray, start: float = 0.0, *, finest: float = 0.0
) -> list[tuple[float, Superelement, np.ndarray]]:
    """Columns of a superelement from left to right, each with left edge and sides: `alike_columns` in their order."""
    found = [
        (begin, column, own[..., place])
        for column, starts, own in alike_columns(piece, sides, start, finest=finest)
        for place, begin in enumerate(starts)
    ]
    return sorted(found, key=lambda each: each[0])


def alike_columns(
    piece: Superelement, sides: np.ndarray, start: float = 0.0, *, finest: float = 0.0
) -> list[tuple[Superelement, np.ndarray, np.ndarray]]:
    """Columns of a superelement by kind: column, left edges (places,), sides (2 n + 2, ..., places).

    ``sides``: left line, right line and electrode potentials, shape (2 n + 2, ...); in those that are returned the
    potentials are in the column's own order, a finger is always on electrode 0.  ``start``: where the left line lies,
    length units. Pieces of the width ``finest`` or less are not entered.
    """
    level, found = _Places(), _Places()
    level.add(piece, np.array([start]), sides[..., None])
    while level.known:
        above, level = level, _Places()
        for each, starts, own in above.gathered():
            part, own = _in_its_order(each, own)
            if not part.parts or part.width <= finest:
                found.add(part, starts, own)
                continue
            n = part.size
            left, right, back = part.parts
            middle = np.tensordot(back, own, axes=1)
            level.add(left, starts, np.concatenate([own[:n], middle, own[2 * n :]]))
            level.add(right, starts + left.width, np.concatenate([middle, own[n:]]))
    return found.gathered()


class _Places:
    """Superelements with the places where they stand."""

    def __init__(self):
        self.known: dict[int, tuple[Superelement, list, list]] = {}

    def add(self, piece: Superelement, starts: np.ndarray, sides: np.ndarray) -> None:
        _, all_starts, all_sides = self.known.setdefault(id(piece), (piece, [], []))
        all_starts.append(starts)
        all_sides.append(sides)

    def gathered(self) -> list[tuple[Superelement, np.ndarray, np.ndarray]]:
        return [
            (piece, np.concatenate(starts), np.concatenate(sides, axis=-1))
            for piece, starts, sides in self.known.values()
        ]


def _in_its_order(piece: Superelement, sides: np.ndarray) -> tuple[Superelement, np.ndarray]:
    """The piece on its own lines and with its own potentials."""
    first = 2 * piece.size
    if piece.exchanged:
        sides = np.concatenate([sides[:first], sides[first:][::-1]])
    if piece.floating is not None:
        potential = np.tensordot(piece.floating[None], sides, axes=1)
        sides = np.concatenate([sides[:first], potential, sides[first + 1 :]])
    return (piece, sides) if piece.expand is None else _in_its_order(*piece.expand(sides))


def widths(piece: Superelement) -> Iterator[float]:
    """Widths of a superelement's columns from left to right, length units."""
    if piece.parts:
        yield from widths(piece.parts[0])
        yield from widths(piece.parts[1])
    else:
        yield piece.width
