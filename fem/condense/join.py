"""Joining condensed pieces: mirror, join, repeat by doubling, and the way back to every line.

Two neighbours share a line; eliminating it gives the block of both (substructuring).  N equal pieces take about
log2(N) joins instead of N (block cyclic reduction, Buzbee, Golub and Nielson 1970), and the unknowns between are
found again from the sides, level by level.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from fem.condense.superelement import PORTS, Block, folded, refuse_resonance


def joined(left: Block, right: Block, *, phi: int | None = None, comb: int | None = None) -> Block:
    """Block of two neighbours.

    Parameters
    ----------
    left, right : Block
    phi, comb : int, optional
        If the shared line's surface node lies on a finger: the number of phi there, and the finger's comb.

    Returns
    -------
    Block
        Its ``parts`` keep the way back to the shared line.
    """
    from scipy.linalg import lu_factor, lu_solve

    n = left.size
    first, second = left.matrix, right.matrix
    if comb is not None:
        first, second = folded(left, 1, phi, comb), folded(right, 0, phi, comb)
    middle = first[n : 2 * n, n : 2 * n] + second[:n, :n]
    coupling = np.zeros((n, 2 * n + PORTS), dtype=middle.dtype)
    coupling[:, :n] = first[n : 2 * n, :n]
    coupling[:, n : 2 * n] = second[:n, n : 2 * n]
    coupling[:, 2 * n :] = first[n : 2 * n, 2 * n :] + second[:n, 2 * n :]
    if comb is not None:
        middle[phi, phi] = 1.0
    back = -lu_solve(lu_factor(middle, check_finite=False), coupling, check_finite=False)
    refuse_resonance(back)
    matrix = coupling.T @ back
    matrix[:n, :n] += first[:n, :n]
    matrix[n : 2 * n, n : 2 * n] += second[n : 2 * n, n : 2 * n]
    matrix[:n, 2 * n :] += first[:n, 2 * n :]
    matrix[2 * n :, :n] += first[2 * n :, :n]
    matrix[n : 2 * n, 2 * n :] += second[n : 2 * n, 2 * n :]
    matrix[2 * n :, n : 2 * n] += second[2 * n :, n : 2 * n]
    matrix[2 * n :, 2 * n :] += first[2 * n :, 2 * n :] + second[2 * n :, 2 * n :]
    if comb is not None:
        back[phi, 2 * n + comb] = 1.0
    matrix = 0.5 * (matrix + matrix.T)
    return Block(size=n, matrix=matrix, width=left.width + right.width, parts=(left, right, back))


def repeated(block: Block, count: int, join: Callable[[Block, Block], Block] = joined) -> Block:
    """Block of ``count`` equal neighbours, by doubling."""
    result, power = None, block
    while True:
        if count & 1:
            result = power if result is None else join(result, power)
        count >>= 1
        if not count:
            return result
        power = join(power, power)


def swapped(block: Block) -> Block:
    """The same piece with its fingers on the other comb; inside, it keeps its own."""
    n = block.size
    order = np.r_[0 : 2 * n, 2 * n + 1, 2 * n]
    return replace(block, matrix=block.matrix[np.ix_(order, order)], turned=not block.turned)


def mirrored(block: Block, odd: np.ndarray, phi_odd: bool) -> Block:
    """The piece seen in a mirror x -> -x that is a symmetry of the solid.

    Parameters
    ----------
    block : Block
    odd : ndarray, shape (n,)
        Unknowns of a line that change sign.
    phi_odd : bool
        Whether the potential changes sign, those of the electrodes included.

    Returns
    -------
    Block
        A single column is its own mirror image.
    """
    if block.column is not None:
        return block
    n = block.size
    signs = np.where(odd, -1.0, 1.0)
    order = np.r_[n : 2 * n, 0:n, 2 * n : 2 * n + PORTS]
    all_signs = np.concatenate([signs, signs, np.full(PORTS, -1.0 if phi_odd else 1.0)])
    parts: tuple = ()
    if block.parts:
        left, right, back = block.parts
        turned = signs[:, None] * back[:, order] * all_signs
        parts = mirrored(right, odd, phi_odd), mirrored(left, odd, phi_odd), turned
    return Block(
        size=n,
        matrix=all_signs[:, None] * block.matrix[np.ix_(order, order)] * all_signs,
        width=block.width,
        parts=parts,
    )


def opened(block: Block) -> Block:
    """The same piece with its finger of comb 0 cut off from the comb: whatever potential leaves it no charge."""
    finger = 2 * block.size
    row = -block.matrix[finger] / block.matrix[finger, finger]
    row[finger] = 0.0
    matrix = block.matrix + np.outer(block.matrix[finger], row)
    matrix[finger], matrix[:, finger] = 0.0, 0.0
    return replace(block, matrix=0.5 * (matrix + matrix.T), floating=row)


def lines(
    block: Block, sides: np.ndarray, start: float = 0.0, *, finest: float = 0.0
) -> Iterator[tuple[float, Block, np.ndarray]]:
    """Walk the columns of a block from left to right.

    Parameters
    ----------
    block : Block
    sides : ndarray, shape (2 n + 2, ...)
        Its left line, right line and comb potentials.
    start : float
        Where its left line lies, length units.
    finest : float
        Pieces of this width or less are not entered.

    Yields
    ------
    start, column block, sides
        The combs' potentials are in the column's own order: a finger is always on comb 0.
    """
    first = 2 * block.size
    if block.turned:
        sides = np.concatenate([sides[:first], sides[first:][::-1]])
    if block.floating is not None:
        sides = np.concatenate([sides[:first], block.floating[None] @ sides, sides[first + 1 :]])
    if block.expand is not None:
        block, sides = block.expand(sides)
    if not block.parts or block.width <= finest:
        yield start, block, sides
        return
    n = block.size
    left, right, back = block.parts
    middle = back @ sides
    yield from lines(left, np.concatenate([sides[:n], middle, sides[2 * n :]]), start, finest=finest)
    yield from lines(right, np.concatenate([middle, sides[n:]]), start + left.width, finest=finest)


def widths(block: Block) -> Iterator[float]:
    """Widths of a block's columns from left to right, length units."""
    if block.parts:
        yield from widths(block.parts[0])
        yield from widths(block.parts[1])
    else:
        yield block.width
