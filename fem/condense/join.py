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


def with_ports(piece: Superelement, ports: np.ndarray, places: np.ndarray, count: int) -> Superelement:
    """The same piece with ``count`` potentials, those of the numbers ``ports`` at ``places`` and the others idle."""
    first = 2 * piece.size
    here, there = (np.r_[0:first, first + np.asarray(each, dtype=int)] for each in (ports, places))
    matrix = np.zeros((first + count,) * 2, dtype=piece.matrix.dtype)
    matrix[np.ix_(there, there)] = piece.matrix[np.ix_(here, here)]

    def expand(sides: np.ndarray) -> tuple[Superelement, np.ndarray]:
        own = np.zeros((len(piece.matrix), *sides.shape[1:]), dtype=sides.dtype)
        own[here] = sides[there]
        return piece, own

    return Superelement(size=piece.size, matrix=matrix, width=piece.width, expand=expand)


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
) -> Iterator[tuple[float, Superelement, np.ndarray]]:
    """Walk the columns of a superelement from left to right: yields start, column, sides of each.

    ``sides``: left line, right line and electrode potentials, shape (2 n + 2, ...); in those that are yielded the
    potentials are in the column's own order, a finger is always on electrode 0.  ``start``: where the left line lies,
    length units. Pieces of the width ``finest`` or less are not entered.
    """
    first = 2 * piece.size
    if piece.exchanged:
        sides = np.concatenate([sides[:first], sides[first:][::-1]])
    if piece.floating is not None:
        sides = np.concatenate([sides[:first], piece.floating[None] @ sides, sides[first + 1 :]])
    if piece.expand is not None:
        yield from lines(*piece.expand(sides), start, finest=finest)
        return
    if not piece.parts or piece.width <= finest:
        yield start, piece, sides
        return
    n = piece.size
    left, right, back = piece.parts
    middle = back @ sides
    yield from lines(left, np.concatenate([sides[:n], middle, sides[2 * n :]]), start, finest=finest)
    yield from lines(right, np.concatenate([middle, sides[n:]]), start + left.width, finest=finest)


def widths(piece: Superelement) -> Iterator[float]:
    """Widths of a superelement's columns from left to right, length units."""
    if piece.parts:
        yield from widths(piece.parts[0])
        yield from widths(piece.parts[1])
    else:
        yield piece.width
