"""The residuals of a fit as a function, for a solver of one's own: `scipy.optimize`, lmfit, a sampler."""

from pathlib import Path
from typing import Any

import numpy as np

from studies.inverse.fitting import prepared
from studies.inverse.free_parameters import key_of
from studies.lab.measurement import Measurement
from studies.refusal import needed
from studies.scene import Scene


class Residual:
    """Residuals of measured curves as a function of free numbers of a scene.

    Called with the values in SI units - an array in the order of ``parameters``, a dict by key, or lmfit.Parameters -
    it returns (measured - predicted) over the standard deviation of every measured value, shape (n,).

    Parameters
    ----------
    scene, measurements, parameters
        As for `studies.fit`.
    tolerance : float
        Of the velocity.

    Attributes
    ----------
    parameters : tuple of Parameter
        The free ones.
    start : ndarray, shape (p,)
        The start of a search.
    bounds : tuple of ndarray
        Lower and upper ends of the ranges.

    Examples
    --------
    >>> from scipy.optimize import least_squares
    >>> from studies import Measurement
    >>> curve = Measurement(name="lab", quantity="velocity", level_key="normal_amplitude_m", levels=(5e-9, 1e-8, 2e-8),
    ...                     values=(0.0280, 0.0693, 0.1520), deviations=(1e-3,) * 3)
    >>> residual = Residual("twente-contact", curve, {"wave.tangential_ratio": (0.3, 1.5)})
    >>> solution = least_squares(residual, residual.start, jac=residual.jacobian, bounds=residual.bounds)
    >>> bool(0.69 < solution.x[0] < 0.71)
    True
    """

    def __init__(
        self,
        scene: Scene | str | Path,
        measurements: Measurement | str | Path | list,
        parameters: list | dict,
        *,
        tolerance: float = 1e-3,
    ):
        self._problem, self.fixed, _ = prepared(scene, measurements, parameters, tolerance=tolerance)
        self.parameters = self._problem.parameters
        starts = zip(self.parameters, self._problem.starts()[0], strict=False)
        self.start = np.array([each.outer(value) for each, value in starts])
        self.bounds = tuple(np.array([[each.low, each.high] for each in self.parameters]).T)

    def __repr__(self) -> str:
        """Return the measurements and the free parameters with their ranges on one line."""
        curves = ", ".join(f"{each.name} ({len(each.values)} values)" for each in self._problem.measurements)
        free = ", ".join(f"{p.key} = {p.text(p.low)} to {p.text(p.high)}" for p in self.parameters)
        return f"Residual({curves}; {free})"

    def __call__(self, values: Any) -> np.ndarray:
        """Return the residuals."""
        return self._problem.residuals([self._inner(values)])[0]

    def jacobian(self, values: Any) -> np.ndarray:
        """Return the derivatives of the residuals by the values in SI units, shape (n, p)."""
        x = self._inner(values)
        scale = [each.outer(part) if each.logarithmic else 1.0 for each, part in zip(self.parameters, x, strict=False)]
        return self._problem.jacobian(x)[:, : len(scale)] / np.array(scale)

    def lmfit_parameters(self) -> Any:
        """Return lmfit.Parameters with the free numbers at the start; a dot of a key is ``__`` in their names.

        Those that the residual was made of keep their expressions.

        Predictions are computed to some 1e-9: give `lmfit.minimize` ``epsfcn=1e-8``, for steps of 1e-4.
        """
        if self._problem.ties.expressions:
            return self._problem.ties.parameters(dict(zip([p.key for p in self.parameters], self.start, strict=True)))
        parameters = needed("lmfit", "lmfit_parameters").Parameters()
        for each, value in zip(self.parameters, self.start, strict=True):
            parameters.add(each.key.replace(".", "__"), value=float(value), min=each.low, max=each.high)
        return parameters

    def _inner(self, values: Any) -> np.ndarray:
        if hasattr(values, "valuesdict"):
            values = {key_of(key): value for key, value in values.valuesdict().items()}
        if isinstance(values, dict):
            values = [values[each.key] for each in self.parameters]
        own = [each.inner(float(value)) for each, value in zip(self.parameters, values, strict=True)]
        return np.array([*own, *(0.0 for _ in self._problem.systematic)])
