"""Elimination of a mesh's unknowns by nested dissection (George, SIAM J. Numer. Anal. 10 (1973) 345).

The elements are bisected until each part has at most LEAF of them.  From these leaves up, every part eliminates the
unknowns that occur in no element outside it and passes the rest on as a dense front (Duff and Reid, ACM Trans. Math.
Softw. 9 (1983) 302).  The root's front is the Schur complement onto the unknowns to keep.  Back substitution goes from
the root to the leaves.  A front has a few hundred unknowns, so that dense matrix products do the work.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.elimination import sides_to_inside

LEAF = 4  # elements of the smallest parts


@dataclass(frozen=True, kw_only=True, eq=False)
class Front:
    """A part of the mesh: the unknowns that it eliminates and those that it passes on."""

    eliminated: np.ndarray = field(repr=False)  # numbers of unknowns
    passed_on: np.ndarray = field(repr=False)
    children: tuple[int, ...]  # indices of fronts, smaller than its own
    elements: np.ndarray  # of a leaf; empty otherwise
    # for every child or element: positions of its unknowns in (eliminated, passed_on), -1 for those fixed at zero
    positions: tuple[np.ndarray, ...] = field(repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Dissection:
    """The order in which the unknowns of a mesh are eliminated.

    Attributes
    ----------
    unknowns : list of ndarray
        Global numbers of every element's unknowns, -1 for those fixed at zero; a number may occur twice.
    centers : ndarray, shape (elements, 2)
    first_kept : int
        This unknown and all with larger numbers are not eliminated.
    """

    unknowns: list[np.ndarray] = field(repr=False)
    centers: np.ndarray = field(repr=False)
    first_kept: int

    @cached_property
    def fronts(self) -> list[Front]:
        """Fronts from the leaves to the root."""
        own = [np.unique(each[each >= 0]) for each in self.unknowns]
        total = np.bincount(np.concatenate(own)) if own else np.zeros(0, dtype=int)
        fronts: list[Front] = []

        def part(elements: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
            """Index of the front of some elements, the unknowns passed on, and in how many elements each occurs."""
            children: tuple[int, ...] = ()
            if len(elements) <= LEAF:
                parts = [(own[each], np.ones(len(own[each]), dtype=int)) for each in elements]
                inputs = [self.unknowns[each] for each in elements]
            else:
                spread = np.ptp(self.centers[elements], axis=0)
                order = elements[np.argsort(self.centers[elements, int(spread[1] > spread[0])], kind="stable")]
                halves = [part(half) for half in np.array_split(order, 2)]
                children, parts = tuple(each[0] for each in halves), [each[1:] for each in halves]
                inputs = [numbers for numbers, _ in parts]
            numbers, where = np.unique(np.concatenate([each for each, _ in parts]), return_inverse=True)
            count = np.bincount(where, weights=np.concatenate([each for _, each in parts])).astype(int)
            complete = (count == total[numbers]) & (numbers < self.first_kept)
            # position of each unknown in (eliminated, passed_on); index -1, for those fixed at zero, has the entry -1
            rank = np.empty(len(numbers) + 1, dtype=int)
            rank[np.argsort(~complete, kind="stable")] = np.arange(len(numbers))
            rank[-1] = -1
            fronts.append(
                Front(
                    eliminated=numbers[complete],
                    passed_on=numbers[~complete],
                    children=children,
                    elements=elements if not children else elements[:0],
                    positions=tuple(rank[np.where(each >= 0, np.searchsorted(numbers, each), -1)] for each in inputs),
                )
            )
            return len(fronts) - 1, numbers[~complete], count[~complete]

        if own:
            part(np.arange(len(own)))
        return fronts

    def factor(self, matrices: list[np.ndarray]) -> "Factor":
        """Eliminate, from the complex symmetric matrix of every element.

        Raises a ConvergenceError if a part resonates between fixed neighbours.
        """
        complements: dict[int, np.ndarray] = {}
        back = []
        dtype = np.result_type(*matrices)
        for number, front in enumerate(self.fronts):
            first = len(front.eliminated)
            size = first + len(front.passed_on)
            full = np.zeros((size, size), dtype=dtype)
            inputs = [complements.pop(child) for child in front.children]
            inputs = inputs or [matrices[element] for element in front.elements]
            for own, positions in zip(inputs, front.positions, strict=True):
                free = np.flatnonzero(positions >= 0)
                at = positions[free]
                if len(free) < len(positions):
                    own = own[np.ix_(free, free)]
                if front.children or len(np.unique(at)) == len(at):
                    full[at[:, None], at] += own
                else:
                    np.add.at(full, (at[:, None], at), own)
            back.append(sides_to_inside(full[:first, :first], full[:first, first:]))
            complement = full[first:, first:] + full[first:, :first] @ back[-1]
            complements[number] = 0.5 * (complement + complement.T)
        root = complements[len(self.fronts) - 1]
        return Factor(fronts=self.fronts, first=self.first_kept, matrix=root, back=back)


@dataclass(frozen=True, kw_only=True, eq=False)
class Factor:
    """A mesh after elimination of all unknowns but those to keep."""

    fronts: list[Front] = field(repr=False)
    first: int  # number of the first kept unknown
    matrix: np.ndarray = field(repr=False)  # over the kept unknowns
    back: list[np.ndarray] = field(repr=False)  # for every front: eliminated unknowns from those passed on

    def unknowns(self, kept: np.ndarray) -> np.ndarray:
        """Return all unknowns from the kept ones, shape (unknowns, m)."""
        out = np.zeros((self.first + len(kept), kept.shape[1]), dtype=np.result_type(kept, *self.back[:1]))
        out[self.first :] = kept
        for front, back in zip(reversed(self.fronts), reversed(self.back), strict=True):
            out[front.eliminated] = back @ out[front.passed_on]
        return out
