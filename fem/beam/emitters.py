"""Waves that sheets of charge or of force send along the surface, as spectra over the lateral wavenumber k_y.

An emitter is the bare stator's response to a line of charge or of force (line_source.py, cut_source.py) with the sheets
that act by it: those of all transducers together, or the one of a strip under a force.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import groupby
from typing import NamedTuple

import numpy as np

from fem.beam.cut_source import CutSource
from fem.beam.electrode_charges import MAX_PHASE, ChargeSheet, Fingers
from fem.beam.line_source import Branch, LineSource

SAME_STEP = 1e-15  # m: steps from node to node that differ by less share their phase factors


class Strip(NamedTuple):
    """A force on a strip of the surface: a sheet of one node with N/m for its charge, and the stator's response."""

    sheet: ChargeSheet
    source: LineSource | CutSource


@dataclass(frozen=True)
class Emitter:
    """Sheets from left to right that send waves by one source; a sheet of force has N/m for its charge."""

    source: LineSource | CutSource
    sheets: list[ChargeSheet]

    @cached_property
    def x(self) -> np.ndarray:
        """Positions of the nodes of all sheets, m."""
        return np.concatenate([each.x for each in self.sheets])

    @cached_property
    def charge(self) -> np.ndarray:
        """Charges of the nodes."""
        return np.concatenate([each.charge for each in self.sheets])

    def plane_waves(self, places: np.ndarray, distance: float) -> np.ndarray:
        """Motion u in the section, k_y = 0, at positions in m, by the modes that reach a distance in m; (places, 3)."""
        ones = np.ones((len(self.sheets), 1))
        return np.sum([self.spectra(branch, places, ones) for branch in self.source.plane(distance)], axis=0)[..., 0]

    def spectra(self, branch: Branch, places: np.ndarray, shapes: np.ndarray) -> np.ndarray:
        """Spectra of u at the positions ``places`` by all charges upstream of them in one branch, (places, 3, n).

        u^(x) = sum_m M_m sum_j q_j s_j exp(-i kappa_m |x - x_j|) with the modes m of the branch, their motion M_m, and
        the charges q_j at x_j upstream of x on sheets of spectrum s_j, the rows of ``shapes``, (sheets, n).  The inner
        sum is carried from charge to charge: it is multiplied by exp(-i kappa_m d) over each distance d, and q_j s_j is
        added at each charge.
        """
        side, along = branch.side, branch.along
        out = np.zeros((len(places), 3, shapes.shape[1]), dtype=complex)
        if not along.size:
            return out
        sources, waves = self._sources_beside(places, side * along, shapes)
        count = len(sources)
        at = side * np.append(sources, places)
        is_place = np.arange(len(at)) >= count
        arrived = np.zeros((len(along), shapes.shape[1]), dtype=complex)
        steps: dict[int, np.ndarray] = {}
        before, sends = 0.0, False  # position of the last stop; whether any charge lies upstream of it
        # Walk downstream from charge to charge.  The sort counts a charge at its own position in one direction only.
        for number in np.lexsort((side * is_place, at)):
            if sends and at[number] != before:
                key = round((at[number] - before) / SAME_STEP)
                if key not in steps:
                    steps[key] = np.exp(-1j * along * (at[number] - before))
                arrived *= steps[key]
            before = at[number]
            if not is_place[number]:
                arrived += waves[number]
                sends = True
            elif sends:
                out[number - count] = np.einsum("cmn,mn->cn", branch.motion, arrived)
        return out

    def _sources_beside(self, places, along, shapes) -> tuple[np.ndarray, list[np.ndarray]]:
        """Positions of the charges, and what they send, (modes, n) or, where that is the same for all modes, (n,).

        The charges of all sheets on the same fingers are added.  All charges of a finger without any requested position
        on it are combined to one source at its centre, by the Taylor series of the exponentials about the centre,
        equation (2) of `Fingers`.  ``along`` is signed by the direction of the branch.
        """
        positions, waves, first, ordered = [], [], 0, np.sort(places)
        for _, same_nodes in groupby(self.sheets, key=lambda sheet: id(sheet.x)):
            sheets = list(same_nodes)
            x, finger, own_shapes = sheets[0].x, sheets[0].finger, shapes[first : first + len(sheets)]
            first += len(sheets)
            charge = np.stack([each.charge for each in sheets])
            fingers = Fingers.of(x, charge, finger)
            # A finger is combined if no requested position lies on it, provided that the series is accurate for the
            # widest finger (MAX_PHASE).  `whole` marks the combined fingers, `single` the nodes of all others.
            whole = np.searchsorted(ordered, fingers.first) == np.searchsorted(ordered, fingers.last, side="right")
            whole &= fingers.phase(along).max() < MAX_PHASE
            single = ~whole[finger - finger[0]]
            moments = np.tensordot(own_shapes, fingers.moments[:, whole], axes=(0, 0))  # (n, fingers, TERMS)
            of_fingers = moments @ np.moveaxis(fingers.powers(along), 2, 0)  # (n, fingers, modes)
            positions += [fingers.middles[whole], x[single]]
            waves += [*of_fingers.transpose(1, 2, 0), *(charge[:, single].T @ own_shapes)]
        return np.concatenate(positions), waves
