"""Superelements of fingers from smaller ones: joining, mirroring, repetition by doubling, and their ports.

Two neighbours A and B share a line m between their outer lines l and r, and, where their electrodes are the same, the
potentials v (substructuring).  On that line the outward fluxes of both vanish together,

    (A_mm + B_mm) u_m + A_ml u_l + B_mr u_r + (A_mp + B_mp) v = 0,                                 (1)

so that u_m = T [u_l, u_r, v] with

    T = -(A_mm + B_mm)^-1 C,      C = [A_ml, B_mr, A_mp + B_mp],                                   (2)

and what remains of the two matrices is

    | A_ll   0      A_lp        |
    | 0      B_rr   B_rp        |  +  C^T T.                                                       (3)
    | A_pl   B_pr   A_pp + B_pp |

Where a finger lies on the shared line, u_m has no potential of its own at the surface: its row and column are added to
those of the finger's electrode before (1) (`fem.condense.electrode_conditions.equipotential`).

N equal pieces take about log2(N) joins instead of N (cyclic reduction, Buzbee, Golub and Nielson 1970).  The unknowns
between are recovered from the sides by (2), level by level (`fem.condense.finger_columns.distinct_columns`).

Example: two springs of stiffness s, A = B = [[s, -s], [-s, s]], joined: T = [1/2, 1/2], and (3) is the spring s/2,
s/2 [[1, -1], [-1, 1]].
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from fem.condense.cascade_piece import Blocks
from fem.condense.electrode_conditions import equipotential
from fem.condense.element_column import Column
from fem.condense.elimination import sides_to_inside, symmetric_product
from fem.condense.finger_columns import FingerColumns, LiftedHalf, Pair, Restated, SurfaceReactions


def joined(
    left: FingerColumns,
    right: FingerColumns,
    *,
    phi: int | None = None,
    electrode: int | None = None,
    odd: np.ndarray | None = None,
) -> FingerColumns:
    """Join two neighbours into one piece by equations (2) and (3).

    Both have the same potentials.  If the surface node of the shared line lies on a finger, ``phi`` is the index of
    this node's potential among the unknowns of the line, and ``electrode`` the number of the finger's electrode.  The
    node then has the potential of the finger, and its row in the system of the shared line becomes the identity.

    ``odd``: unknowns of a line that change sign under x -> -x, shape (n,), where that is a symmetry of the solid.
    Parts that are each other's mirror image then take a third of the time.

    Examples
    --------
    >>> import numpy as np
    >>> spring = FingerColumns(size=1, matrix=np.array([[2.0, -2.0], [-2.0, 2.0]]), width=1.0, ports=())
    >>> both = joined(spring, spring)
    >>> both.matrix.tolist(), both.pair.middle.tolist()
    ([[1.0, -1.0], [-1.0, 1.0]], [[0.5, 0.5]])
    """
    at, first, second = left.at, left.matrix, right.matrix
    if electrode is not None:
        port = at.ports.start + electrode
        first = equipotential(first, np.array([at.right.start + phi]), port)
        second = equipotential(second, np.array([at.left.start + phi]), port)
    middle = first[at.right, at.right] + second[at.left, at.left]
    shared = first[at.right, at.ports] + second[at.left, at.ports]
    if electrode is not None:
        middle[phi, phi] = 1.0
    if odd is not None and mirror_images(first, second, at, odd):
        transfer, matrix = _eliminated_mirror_line(middle, first[at.right, at.left], shared, odd)
    else:
        coupling = np.hstack([first[at.right, at.left], second[at.left, at.right], shared])
        transfer = sides_to_inside(middle, coupling)  # T of equation (2)
        matrix = symmetric_product(coupling, transfer)  # and equation (3)
    for own, line in ((first, at.left), (second, at.right)):
        matrix[line, line] += own[line, line]
        matrix[line, at.ports] += own[line, at.ports]
        matrix[at.ports, line] += own[at.ports, line]
    matrix[at.ports, at.ports] += first[at.ports, at.ports] + second[at.ports, at.ports]
    if electrode is not None:
        transfer[phi, at.ports.start + electrode] = 1.0
    return FingerColumns(
        size=at.size,
        matrix=matrix,
        width=left.width + right.width,
        ports=left.ports,
        inside=Pair(left=left, right=right, middle=transfer),
    )


def mirror_images(first: np.ndarray, second: np.ndarray, at: Blocks, odd: np.ndarray) -> bool:
    """True if the lines of one matrix are exactly the mirror image of the other's, whatever their ports.

    Equal runs of fingers are, because each begins as half a cell and its mirror image.
    """
    line = np.where(odd, -1.0, 1.0)
    signs = np.outer(line, line)
    images = (
        (first[at.right, at.right], second[at.left, at.left]),
        (first[at.right, at.left], second[at.left, at.right]),
        (first[at.left, at.left], second[at.right, at.right]),
    )
    own, other = images[0]
    if not np.array_equal(np.diag(own), np.diag(other)):  # most pairs; the diagonal does not change its sign
        return False
    return all(np.array_equal(own * signs, other) for own, other in images)


def _eliminated_mirror_line(
    middle: np.ndarray, from_left: np.ndarray, shared: np.ndarray, odd: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """T of equation (2) and C^T T of equation (3) where the right part's lines are the mirror image of the left's.

    With S = diag(+1, -1), -1 for the odd unknowns, B_mr = S A_ml S, and ``middle`` = A_mm + S A_mm S couples no odd
    unknown with an even one.  Each parity is eliminated alone.  With t and c the columns of T and C of the left line,
    those of the right line are S t S and S c S, so that the products of even and of odd rows, E + O = c^T t, also give
    c^T S t S = (E - O) S.

    Parameters
    ----------
    middle : ndarray, shape (n, n)
    from_left : ndarray, shape (n, n)
        A_ml.
    shared : ndarray, shape (n, ports)
        A_mp + B_mp.
    odd : ndarray of bool, shape (n,)
    """
    size, line = len(odd), np.where(odd, -1.0, 1.0)
    coupling = np.hstack([from_left, shared])
    solved = np.empty(coupling.shape, dtype=np.result_type(middle, coupling))
    products = []
    for parity in (np.flatnonzero(~odd), np.flatnonzero(odd)):
        own = coupling[parity]
        solved[parity] = sides_to_inside(middle[np.ix_(parity, parity)], own)
        products.append(symmetric_product(own, solved[parity]))
    even, uneven = products
    both, difference = even + uneven, even - uneven
    at = Blocks(size)
    matrix = np.empty((2 * size + shared.shape[1],) * 2, dtype=solved.dtype)
    own, ports = both[:size, :size], both[:size, size:]
    matrix[at.left, at.left] = own
    matrix[at.right, at.right] = line[:, None] * own * line
    matrix[at.left, at.right] = difference[:size, :size] * line
    matrix[at.right, at.left] = matrix[at.left, at.right].T
    matrix[at.left, at.ports] = ports
    matrix[at.right, at.ports] = line[:, None] * difference[:size, size:]
    matrix[at.ports, at.lines] = matrix[at.lines, at.ports].T
    matrix[at.ports, at.ports] = both[size:, size:]
    left = solved[:, :size]
    return np.hstack([left, line[:, None] * left * line, solved[:, size:]]), matrix


def repeated(
    piece: FingerColumns, count: int, join: Callable[[FingerColumns, FingerColumns], FingerColumns] = joined
) -> FingerColumns:
    """Join ``count`` equal neighbours into one piece by doubling."""
    result, power = None, piece
    while count > 1:
        if count & 1:
            result = power if result is None else join(result, power)
        count >>= 1
        power = join(power, power)
    return power if result is None else join(result, power)


def with_ports(piece: FingerColumns, ports: list[int]) -> FingerColumns:
    """Return the piece with the potentials of the numbers ``ports`` alone; the other potentials are zero."""
    numbers = np.array(ports, dtype=int)
    remaining = np.append(np.arange(piece.at.ports.start), piece.at.ports.start + numbers)

    def own(sides: np.ndarray) -> np.ndarray:
        out = np.zeros((len(piece.matrix), *sides.shape[1:]), dtype=sides.dtype)
        out[remaining] = sides
        return out

    return FingerColumns(
        size=piece.size,
        matrix=piece.matrix[np.ix_(remaining, remaining)],
        width=piece.width,
        ports=tuple(piece.ports[number] for number in ports),
        inside=Restated(piece=piece, sides=own),
    )


def with_fingers(whole: FingerColumns, left: FingerColumns, right: FingerColumns) -> FingerColumns:
    """Return a joined pair with the electrodes of ``left`` and then those of ``right`` as separate ports.

    ``whole`` is the joined pair with common potentials; the parts have their own, v_A and v_B.  Equations (1) to (3)
    hold with C_p = [A_mp, B_mp], [A_lp, 0] and [0, B_rp] in the columns of [v_A, v_B]; the columns of the lines are
    those of ``whole``.
    """
    at, first, second = whole.at, left.matrix, right.matrix
    count, total = len(left.ports), len(left.ports) + len(right.ports)
    v_a, v_b = slice(0, count), slice(count, total)
    dtype = np.result_type(first, second)
    c_left, c_middle, c_right = np.zeros((3, at.size, total), dtype=dtype)  # [A_lp, 0], C_p and [0, B_rp]
    c_left[:, v_a], c_right[:, v_b] = first[at.left, at.ports], second[at.right, at.ports]
    c_middle[:, v_a], c_middle[:, v_b] = first[at.right, at.ports], second[at.left, at.ports]
    t_lines = whole.pair.middle[:, at.lines]  # columns of T: of the lines, and of [v_A, v_B]
    t_ports = sides_to_inside(first[at.right, at.right] + second[at.left, at.left], c_middle)
    matrix = np.zeros((at.ports.start + total,) * 2, dtype=t_ports.dtype)
    matrix[at.lines, at.lines] = whole.matrix[at.lines, at.lines]
    matrix[at.lines, at.ports] = np.concatenate([c_left, c_right]) + t_lines.T @ c_middle
    matrix[at.ports, at.lines] = matrix[at.lines, at.ports].T
    between_ports = c_middle.T @ t_ports
    between_ports[v_a, v_a] += first[at.ports, at.ports]
    between_ports[v_b, v_b] += second[at.ports, at.ports]
    matrix[at.ports, at.ports] = 0.5 * (between_ports + between_ports.T)
    middle = np.concatenate([t_lines, t_ports], axis=1)
    return FingerColumns(
        size=at.size,
        matrix=matrix,
        width=whole.width,
        ports=left.ports + right.ports,
        inside=Pair(left=left, right=right, middle=middle, own_ports=True),
    )


def exchanged(piece: FingerColumns) -> FingerColumns:
    """Return the piece with its electrodes exchanged; the superelements inside are shared and not changed."""
    lines = np.arange(piece.at.ports.start)
    order = np.append(lines, [len(lines) + 1, len(lines)])
    return replace(
        piece, matrix=piece.matrix[np.ix_(order, order)], inside=Restated(piece=piece, sides=lambda sides: sides[order])
    )


@dataclass(frozen=True, eq=False)
class Reflection:
    """Mirror image x -> -x of pieces, a symmetry of the solid.

    ``odd``: unknowns of a line that change sign, shape (n,); ``phi_odd``: True if all potentials do.
    """

    odd: np.ndarray
    phi_odd: bool

    def sides(self, ports: int) -> tuple[np.ndarray, np.ndarray]:
        """Order and signs of the sides of a piece with so many ports."""
        n, line = len(self.odd), np.where(self.odd, -1.0, 1.0)
        order = np.concatenate([np.arange(n, 2 * n), np.arange(n), np.arange(2 * n, 2 * n + ports)])
        return order, np.concatenate([line, line, np.full(ports, -1.0 if self.phi_odd else 1.0)])


class ReflectedPair(Pair):
    """Mirror image of a pair; its parts and the matrix to its shared line are formed on first use."""

    original: Pair
    reflection: Reflection

    def __init__(self, pair: Pair, reflection: Reflection):
        vars(self).update(original=pair, reflection=reflection, own_ports=pair.own_ports)

    @cached_property
    def left(self) -> FingerColumns:
        """Mirror image of the right part."""
        return mirrored(self.original.right, self.reflection)

    @cached_property
    def right(self) -> FingerColumns:
        """Mirror image of the left part."""
        return mirrored(self.original.left, self.reflection)

    @cached_property
    def middle(self) -> np.ndarray:
        """T of equation (2)."""
        middle = self.original.middle
        order, signs = self.reflection.sides(middle.shape[1] - 2 * len(middle))
        return signs[: len(middle), None] * middle[:, order] * signs


def mirrored(piece: FingerColumns, reflection: Reflection) -> FingerColumns:
    """Return the mirror image of a piece; a single column is its own mirror image."""
    inside = piece.inside
    if isinstance(inside, Column):
        return piece
    order, signs = reflection.sides(len(piece.ports))
    if isinstance(inside, Pair):
        inside = ReflectedPair(inside, reflection)
    elif isinstance(inside, LiftedHalf):
        phi_sign = -signs[-1]  # a moment changes its sign once more, because it contains x
        reactions = inside.reactions and partial(_mirrored_reactions, inside.reactions, piece.width, order, signs)
        moment = phi_sign * inside.moment[order] * signs
        inside = replace(inside, side=1 - inside.side, moment=moment, reactions=reactions)
    elif inside is not None:
        raise TypeError("a piece with other potentials than it was joined with has no mirror image here")
    matrix = signs[:, None] * piece.matrix[np.ix_(order, order)] * signs
    return replace(piece, matrix=matrix, inside=inside)


def _mirrored_reactions(
    of: Callable[[], SurfaceReactions], width: float, order: np.ndarray, signs: np.ndarray
) -> SurfaceReactions:
    """Reactions of the mirror image of a piece, from those of the piece: ``of``; ``order``, ``signs``: of its sides."""
    position, on_metal, rows = (each[::-1] for each in of())
    return SurfaceReactions(width - position, on_metal, signs[-1] * rows[:, order] * signs)
