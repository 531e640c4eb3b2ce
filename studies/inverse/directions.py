"""Directions in which the free numbers change without changing the predicted measurements, described in words.

The Jacobian's columns are scaled by half the range of each number.  Where a singular value is below ``ENOUGH``, a move
from the middle of the ranges to their edge changes the sum of squares by less than the 95 % level: the data do not
determine that direction.  The undetermined directions are given by a basis in which most components are zero (reduced
echelon form), so that each can be described in one sentence.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import qr
from scipy.stats import chi2

from studies.inverse.free_parameters import Parameter

LEVEL = 0.95
ENOUGH = float(np.sqrt(chi2.ppf(LEVEL, 1)))
EXACT = 1e-3  # of the largest singular value; below it the first-order effect is zero but for rounding
SMALL = 0.1  # over the largest component; smaller ones are not named


@dataclass(frozen=True, kw_only=True)
class Direction:
    """A combination of numbers that the measurements do not determine."""

    # by key: change of the logarithm, or of the number itself where that may be zero; the largest component is 1
    components: dict[str, float]
    exact: bool  # True: to first order the predictions do not change at all along it

    @property
    def sentence(self) -> str:
        """The direction in words."""
        keys = list(self.components)
        how = "has no effect on these data" if self.exact else "is not determined by these data within its range"
        if len(keys) == 1:
            return f"{keys[0]} {how}"
        if len(keys) == 2:
            a, b = keys
            power = -self.components[b] / self.components[a]
            if abs(abs(power) - 1.0) < SMALL:
                what = "product" if power > 0 else "ratio"
                return f"{a} and {b} trade off: only their {what} is determined"
            return f"{a} and {b} trade off: only {a}^{power:.2g} * {b} is determined"
        up = [_powered(key, size) for key, size in self.components.items() if size > 0]
        down = [_powered(key, -size) for key, size in self.components.items() if size < 0]
        changes = " and ".join(f"{', '.join(each)} {way}" for each, way in ((up, "up"), (down, "down")) if each)
        how = "nothing in these data" if self.exact else "too little in these data"
        return f"{changes} by one factor changes {how}: only products and ratios that stay the same are determined"


def undetermined(jacobian: np.ndarray, parameters: tuple[Parameter, ...], half_width: np.ndarray) -> list[Direction]:
    """Return the directions of the free numbers that the measurements leave undetermined.

    ``jacobian``: of the residuals, with the columns of systematic errors at the end; ``half_width``: half the range of
    each x.
    """
    count = len(parameters)
    scaled = jacobian * half_width
    if scaled.shape[1] > count:  # what a systematic error may explain determines nothing
        shared = np.linalg.qr(scaled[:, count:])[0]
        scaled = scaled[:, :count] - shared @ (shared.T @ scaled[:, :count])
    _, sizes, right = np.linalg.svd(np.vstack([scaled, np.zeros((count, count))]))
    least = EXACT * max(sizes[0], ENOUGH)
    directions = []
    for exact in (True, False):
        small = (sizes < ENOUGH) & ((sizes <= least) == exact)
        changes = _echelon(right[small] * half_width[:count])
        directions += [direction(change, parameters, exact=exact) for change in changes]
    return directions


def direction(change: np.ndarray, parameters: tuple[Parameter, ...], *, exact: bool) -> Direction:
    """Return the direction of a change of x."""
    change = change / change[np.argmax(np.abs(change))]
    components = {p.key: float(size) for p, size in zip(parameters, change, strict=True) if abs(size) > SMALL}
    if next(iter(components.values())) < 0:
        components = {key: -size for key, size in components.items()}
    return Direction(components=components, exact=exact)


def _echelon(rows: np.ndarray) -> list[np.ndarray]:
    """Return the rows of a matrix in reduced echelon form, with the columns that QR chooses as pivots."""
    if not len(rows):
        return []
    _, triangle, order = qr(rows, pivoting=True)
    reduced = np.empty_like(triangle)
    reduced[:, order] = np.linalg.solve(triangle[:, : len(rows)], triangle)
    return list(reduced)


def _powered(key: str, size: float) -> str:
    return key if abs(size - 1.0) < SMALL else f"{key}^{size:.2g}"
