"""Charge of the electrodes of a solved section: what drives a stator whose fingers are massless and thin.

The reactions of the potential at the surface's nodes are summed over the columns that meet there, so that a field
outside follows from the sum over the nodes of charge times the response of the bare surface.  The transform

    T(k) = sum_j q_j exp(i k (x_j - x_0))

is evaluated finger by finger from the moments of the charge, exp(i k c) sum_n (i k)^n m_n, m_n = sum q (x - c)^n / n!.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from fem.discretize.spectral import gll_nodes
from fem.results.evaluation import column_fields
from fem.results.solution import Solution

SAME_NODE = 1e-9  # length units: nodes of neighbouring columns that are nearer are one
MOMENT_ERROR = 1e-14  # of a finger's transform from its moments
MAX_MOMENTS = 40  # a finger that is longer in radians is summed node by node


@dataclass(frozen=True, kw_only=True)
class ElectrodeCharges:
    """Charges on the fingers of one transducer.

    Attributes
    ----------
    x : ndarray, shape (nodes,)
        m from the stator's left end, increasing.
    charge : ndarray, shape (nodes,)
        C per metre of aperture, per volt of the source; complex.
    finger : ndarray of int, shape (nodes,)
        Number of the finger.
    """

    x: np.ndarray = field(repr=False)
    charge: np.ndarray = field(repr=False)
    finger: np.ndarray = field(repr=False)

    @cached_property
    def _fingers(self) -> list[tuple[float, np.ndarray, np.ndarray]]:
        """Middle, distances of the nodes from it, and charges of each finger."""
        found = []
        for number in np.unique(self.finger):
            here = self.finger == number
            middle = 0.5 * (self.x[here][0] + self.x[here][-1])
            found.append((middle, self.x[here] - middle, self.charge[here]))
        return found

    def transform(self, wavenumbers: np.ndarray, origin: float) -> np.ndarray:
        """T(k) in C/m per V.

        Parameters
        ----------
        wavenumbers : ndarray
            rad/m, complex, any shape.
        origin : float
            x_0 in m.

        Returns
        -------
        ndarray, shape as the wavenumbers
        """
        slope = 1j * np.asarray(wavenumbers, dtype=complex)
        total = np.zeros_like(slope)
        for middle, distances, charges in self._fingers:
            phase = np.exp(slope * (middle - origin))
            size = float(abs(slope).max(initial=0.0) * abs(distances).max())
            moments = _moments(distances, charges, size)
            if moments is None:
                total += phase * (np.exp(slope[..., None] * distances) @ charges)
                continue
            series = np.full_like(slope, moments[-1])
            for moment in moments[-2::-1]:
                series = series * slope + moment
            total += phase * series
        return total


def _moments(distances: np.ndarray, charges: np.ndarray, size: float) -> np.ndarray | None:
    """Moments of a finger over n!, as many as exponents up to ``size`` need; None if they are too many."""
    moments, power, bound = [], charges, 1.0
    for order in range(MAX_MOMENTS):
        moments.append(power.sum())
        power = power * distances / (order + 1)
        bound *= size / (order + 1)
        if bound < MOMENT_ERROR and order + 1 > 2 * size:
            return np.array(moments)
    return None


def electrode_charges(solution: Solution, index: int) -> ElectrodeCharges:
    """Charges on a transducer's fingers.

    Parameters
    ----------
    solution : Solution
    index : int
        Of the transducer, from left to right.

    Returns
    -------
    ElectrodeCharges
    """
    section = solution.fields.section
    places, reactions, metal = [], [], []
    for recovery, starts, sides in column_fields(solution, index):
        column = recovery.column
        reaction = recovery.surface_reactions(sides)
        places.append(
            np.add.outer(gll_nodes(section.order) * column.width * section.length_unit, starts).ravel()
        )
        reactions.append(reaction.ravel())
        metal.append(np.full(reaction.size, column.comb is not None))
    in_row = np.argsort(np.concatenate(places), kind="stable")
    place, reaction, on_metal = (np.concatenate(each)[in_row] for each in (places, reactions, metal))
    node = np.cumsum(np.diff(place, prepend=-np.inf) > SAME_NODE * section.length_unit) - 1
    first = np.searchsorted(node, np.arange(node[-1] + 1))
    charge = np.add.reduceat(reaction, first)
    covered = np.logical_or.reduceat(on_metal, first)
    finger = np.cumsum(np.diff(covered.astype(int), prepend=0) == 1)
    medium = section.solid
    return ElectrodeCharges(
        x=place[first][covered],
        charge=-charge[covered] * (medium.stress_unit / medium.potential_unit),
        finger=finger[covered],
    )
