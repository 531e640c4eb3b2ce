"""Elimination of a mesh's unknowns by nested dissection (George, SIAM J. Numer. Anal. 10 (1973) 345).

The elements are bisected until few are left; from these leaves up, every part eliminates the unknowns that no element
outside it holds, and hands the rest on, a dense front (Duff and Reid, ACM Trans. Math. Softw. 9 (1983) 302).  What is
left at the root is the Schur complement onto the unknowns that are kept; on the way back every part gives the
unknowns that it eliminated.  A front is a few hundred unknowns wide, so that the work is done by matrix products.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.condense.column import eliminated

LEAF = 4  # elements of the smallest parts


@dataclass(frozen=True, kw_only=True, eq=False)
class Front:
    """A part of the mesh: what it eliminates, and where its own parts stand among its unknowns."""

    gone: np.ndarray = field(repr=False)  # numbers of the unknowns that it eliminates
    stay: np.ndarray = field(repr=False)
    children: tuple[int, ...]  # fronts, numbered before it
    elements: np.ndarray  # of a leaf
    # of every child or element: places of its unknowns in (gone, stay), -1 for those that are held at zero
    places: tuple[np.ndarray, ...] = field(repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class Dissection:
    """The order in which the unknowns of a mesh are eliminated.

    Attributes
    ----------
    unknowns : list of ndarray
        Of every element, -1 for those that are held at zero; two may be one unknown.
    centers : ndarray, shape (elements, 2)
    kept : int
        Number of the first unknown that is not eliminated; it and all behind it are kept.
    """

    unknowns: list[np.ndarray] = field(repr=False)
    centers: np.ndarray = field(repr=False)
    kept: int

    @cached_property
    def fronts(self) -> list[Front]:
        """Fronts from the leaves to the root."""
        own = [np.unique(each[each >= 0]) for each in self.unknowns]
        total = np.bincount(np.concatenate(own)) if own else np.zeros(0, dtype=int)
        fronts: list[Front] = []

        def part(elements: np.ndarray) -> tuple[int, np.ndarray, np.ndarray]:
            """Return the front of some elements, the unknowns that it hands on and how many elements hold them."""
            children: tuple[int, ...] = ()
            if len(elements) <= LEAF:
                parts = [(own[each], np.ones(len(own[each]), dtype=int)) for each in elements]
                asked = [self.unknowns[each] for each in elements]
            else:
                spread = np.ptp(self.centers[elements], axis=0)
                order = elements[
                    np.argsort(self.centers[elements, int(spread[1] > spread[0])], kind="stable")
                ]
                halves = [part(half) for half in np.array_split(order, 2)]
                children, parts = tuple(each[0] for each in halves), [each[1:] for each in halves]
                asked = [numbers for numbers, _ in parts]
            numbers, where = np.unique(np.concatenate([each for each, _ in parts]), return_inverse=True)
            count = np.bincount(where, weights=np.concatenate([each for _, each in parts])).astype(int)
            done = (count == total[numbers]) & (numbers < self.kept)
            rank = np.empty(len(numbers) + 1, dtype=int)
            rank[np.argsort(~done, kind="stable")] = np.arange(len(numbers))
            rank[-1] = -1
            places = tuple(rank[np.where(each >= 0, np.searchsorted(numbers, each), -1)] for each in asked)
            fronts.append(
                Front(
                    gone=numbers[done],
                    stay=numbers[~done],
                    children=children,
                    elements=elements if not children else elements[:0],
                    places=places,
                )
            )
            return len(fronts) - 1, numbers[~done], count[~done]

        if own:
            part(np.arange(len(own)))
        return fronts

    def factor(self, matrices: list[np.ndarray]) -> "Factor":
        """Eliminate, given the complex symmetric matrix of every element.

        A ConvergenceError where a part resonates between its fixed neighbours.
        """
        left: dict[int, np.ndarray] = {}
        back = []
        dtype = np.result_type(*matrices)
        for number, front in enumerate(self.fronts):
            size, first = len(front.gone) + len(front.stay), len(front.gone)
            full = np.zeros((size, size), dtype=dtype)
            given = [left.pop(each) for each in front.children] or [matrices[each] for each in front.elements]
            for own, places in zip(given, front.places, strict=True):
                there = np.flatnonzero(places >= 0)
                at = places[there]
                if len(there) < len(places):
                    own = own[np.ix_(there, there)]
                if front.children or len(np.unique(at)) == len(at):
                    full[at[:, None], at] += own
                else:
                    np.add.at(full, (at[:, None], at), own)
            back.append(eliminated(full[:first, :first], full[:first, first:]))
            outer = full[first:, first:] + full[first:, :first] @ back[-1]
            left[number] = 0.5 * (outer + outer.T)
        return Factor(fronts=self.fronts, first=self.kept, matrix=left[len(self.fronts) - 1], back=back)


@dataclass(frozen=True, kw_only=True, eq=False)
class Factor:
    """A mesh whose unknowns are eliminated but for those kept."""

    fronts: list[Front] = field(repr=False)
    first: int  # number of the first unknown that is kept
    matrix: np.ndarray = field(repr=False)  # over the unknowns kept
    back: list[np.ndarray] = field(repr=False)  # of every front: what it eliminates from what it hands on

    def unknowns(self, kept: np.ndarray) -> np.ndarray:
        """Return all unknowns for those kept, shape (unknowns, m)."""
        out = np.zeros((self.first + len(kept), kept.shape[1]), dtype=np.result_type(kept, *self.back[:1]))
        out[self.first :] = kept
        for front, back in zip(reversed(self.fronts), reversed(self.back), strict=True):
            out[front.gone] = back @ out[front.stay]
        return out
