"""What an encoder does to a motion: its filters, and the alignment of its trace in time."""

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.interpolate import make_interp_spline
from scipy.optimize import minimize_scalar


def travelled_distance(time: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the distance in m travelled by each instant (trapezoidal rule)."""
    return cumulative_trapezoid(velocity, time, initial=0.0)


def low_pass(time: np.ndarray, values: np.ndarray, bandwidth: float) -> np.ndarray:
    """Return a curve after a first-order low-pass filter of a bandwidth in Hz (-3 dB); it is constant before the start.

    The curve is linear between its samples, for which the response of the filter is exact.
    """
    rate = 2.0 * np.pi * bandwidth
    out = np.empty(len(values))
    out[0] = values[0]
    for k in range(1, len(values)):
        step = time[k] - time[k - 1]
        decay = np.exp(-rate * step)
        slope = (values[k] - values[k - 1]) / step
        lag = slope / rate
        out[k] = values[k] - lag + (out[k - 1] - values[k - 1] + lag) * decay
    return out


def averaged(time: np.ndarray, values: np.ndarray, span: float, at: np.ndarray) -> np.ndarray:
    """Return the means of a curve over the ``span`` in s before each instant ``at``; it is constant beyond its ends."""
    first, last = min(time[0], np.min(at) - span) - span, max(time[-1], np.max(at)) + span
    curve = make_interp_spline([first, *time, last], np.pad(values, 1, mode="edge"), k=1)
    integral = curve.antiderivative()
    return (integral(at) - integral(at - span)) / span


def recorded(
    time: np.ndarray,
    values: np.ndarray,
    at: np.ndarray,
    *,
    bandwidth: float | None = None,
    sampling: float | None = None,
) -> np.ndarray:
    """Return what an encoder records of a curve at some instants, after its filter and its averaging if it has them.

    ``bandwidth``: of `low_pass`, Hz; ``sampling``: the span of `averaged`, s.
    """
    if bandwidth is not None:
        values = low_pass(time, values, bandwidth)
    return np.interp(at, time, values) if sampling is None else averaged(time, values, sampling, at)


def aligned(time: np.ndarray, measured: np.ndarray, at: np.ndarray, predicted: np.ndarray) -> float:
    """Return the time offset in s that fits a trace best to a prediction (least squares).

    ``time`` and ``measured`` are the trace; ``at`` and ``predicted`` are the prediction, constant beyond its ends.
    """
    span = 0.5 * (at[-1] - at[0])

    def squares(offset):
        return float(np.sum((measured - np.interp(time - offset, at, predicted)) ** 2))

    grid = np.linspace(-span, span, 401)
    best = grid[np.argmin([squares(offset) for offset in grid])]
    width = grid[1] - grid[0]
    bounds = (best - width, best + width)
    return float(minimize_scalar(squares, bounds=bounds, method="bounded", options={"xatol": 1e-9 * span}).x)
