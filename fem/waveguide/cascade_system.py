"""The one linear system of a cascade: waves that leave and arrive at its elements.

An element e of a cascade - a condensed piece, an end of the stator, a sheet of charges, a P-matrix - answers the waves
of amplitudes a_e that arrive at it, and its excitation v, by the waves b_e that leave it:

    b_e = S_e a_e + T_e v.                                                                        (1)

What leaves one element arrives at others, P b, beside waves a_0 from outside of the cascade:

    a = P b + a_0.                                                                                (2)

With S = diag(S_e) and all T_e in one column, (1) and (2) give

    (1 - S P) b = T v + S a_0.                                                                    (3)

The cascade resonates where an eigenvalue of the coupling M = S P is near 1.  For two elements (3) is the star product
of their scattering matrices (R. Redheffer, J. Math. Phys. 41, 1962, 1, eq. 4).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True, kw_only=True)
class Element:
    """An element of a cascade: its scattering and the numbers of its waves.

    Attributes
    ----------
    scattering : ndarray, shape (leaving, arriving)
        S_e.
    excitation : ndarray, shape (leaving, excitations)
        T_e.
    leaves, arrives : ndarray of int
        Numbers, among all waves of the cascade, of those that leave it and of those that arrive at it.
    """

    scattering: np.ndarray = field(repr=False)
    excitation: np.ndarray = field(repr=False)
    leaves: np.ndarray = field(repr=False)
    arrives: np.ndarray = field(repr=False)


class Travel(NamedTuple):
    """A part of P: groups of waves that travel from one element to another, none of them from group to group.

    Modes of a uniform segment are such groups, because they do not change into each other on the way.
    """

    arrives: np.ndarray  # (groups, r): numbers of the waves that arrive
    leaves: np.ndarray  # (groups, s): numbers of the waves that leave
    factors: np.ndarray  # (groups, r, s)

    def arriving(self, leaving: np.ndarray) -> np.ndarray:
        """Amplitudes that arrive, (groups, r, excitations), of the waves of a whole cascade, (waves, excitations)."""
        return self.factors @ leaving[self.leaves]


@dataclass(frozen=True, kw_only=True)
class CascadeWaves:
    """Amplitudes of a cascade for each of its excitations.

    Attributes
    ----------
    leaving, arriving : ndarray, shape (waves, excitations)
        b and a.
    coupling : ndarray, shape (waves, waves)
        M = S P: waves that leave the elements, per wave that left an element one scattering earlier.
    """

    leaving: np.ndarray = field(repr=False)
    arriving: np.ndarray = field(repr=False)
    coupling: np.ndarray = field(repr=False)


def solve_cascade(
    elements: Sequence[Element], travel: Sequence[Travel] | None = None, outside: np.ndarray | None = None
) -> CascadeWaves:
    """Solve equation (3).

    Parameters
    ----------
    elements : sequence of Element
        Each wave leaves exactly one of them.
    travel : sequence of Travel, optional
        P; without it a wave arrives with the number and the amplitude with which it leaves.  All waves of one
        part arrive at one element, and no other part takes any of them there.
    outside : ndarray, shape (waves, excitations), optional
        a_0.

    Examples
    --------
    Two mirrors of reflections 0.5 and 0.8 face each other, with a factor 0.9 on the way; the first sends a wave of
    amplitude 1.  The sum over all round trips is 1 / (1 - 0.5 0.8 0.9^2):

    >>> import numpy as np
    >>> one, other = (
    ...     Element(
    ...         scattering=np.array([[reflection]]),
    ...         excitation=np.array([[sent]]),
    ...         leaves=np.array([number]),
    ...         arrives=np.array([number]),
    ...     )
    ...     for number, reflection, sent in ((0, 0.5, 1.0), (1, 0.8, 0.0))
    ... )
    >>> way = np.array([[[0.9]]])
    >>> there, back = Travel(np.array([[1]]), np.array([[0]]), way), Travel(np.array([[0]]), np.array([[1]]), way)
    >>> waves = solve_cascade([one, other], [there, back])
    >>> bool(np.isclose(waves.leaving[0, 0], 1 / (1 - 0.5 * 0.8 * 0.9**2)))
    True
    """
    size = sum(len(each.leaves) for each in elements)
    # waves that arrive at an element; only they are unknowns of the system
    onward = np.full(size, travel is None)
    coupling = np.zeros((size, size), dtype=complex)
    load = np.zeros((size, elements[0].excitation.shape[1]), dtype=complex)
    element_of, place = np.zeros(size, dtype=int), np.zeros(size, dtype=int)  # of a wave that arrives
    for number, each in enumerate(elements):
        element_of[each.arrives], place[each.arrives] = number, np.arange(len(each.arrives))
        if travel is None:
            coupling[np.ix_(each.leaves, each.arrives)] = each.scattering
        load[each.leaves] = each.excitation
        if outside is not None:
            load[each.leaves] += each.scattering @ outside[each.arrives]
    parts = [part for part in travel or () if part.arrives.size]
    for part in parts:
        onward[part.leaves] = True
        receiver = elements[element_of[part.arrives.flat[0]]]
        # (groups, leaving, r) times (groups, r, s)
        scattered = np.moveaxis(receiver.scattering[:, place[part.arrives]], 1, 0) @ part.factors
        coupling[receiver.leaves[:, None, None], part.leaves] = np.moveaxis(scattered, 0, 1)
    by_onward = coupling[:, onward]
    leaving = load + by_onward @ np.linalg.solve(np.eye(by_onward.shape[1]) - by_onward[onward], load[onward])
    arriving = leaving if travel is None else np.zeros_like(leaving)
    for part in parts:
        arriving[part.arrives] += part.arriving(leaving)
    if outside is not None:
        arriving = arriving + outside
    return CascadeWaves(leaving=leaving, arriving=arriving, coupling=coupling)
