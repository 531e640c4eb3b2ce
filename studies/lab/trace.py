"""An encoder's trace: the filters of the instrument, and the alignment of a trace in time."""

import numpy as np


def travelled_distance(time: np.ndarray, velocity: np.ndarray) -> np.ndarray:
    """Return the distance in m travelled by each instant (trapezoidal rule)."""
    return np.concatenate([[0.0], np.cumsum(np.diff(time) * 0.5 * (velocity[1:] + velocity[:-1]))])


def low_pass(time: np.ndarray, values: np.ndarray, bandwidth: float) -> np.ndarray:
    """Return a curve as a filter of first order with a bandwidth in Hz (-3 dB) shows it, at rest before it begins.

    The curve is linear between its instants; the filter's answer to that is exact.
    """
    rate = 2.0 * np.pi * bandwidth
    out = np.empty(len(values))
    out[0] = values[0]
    for k in range(1, len(values)):
        step = time[k] - time[k - 1]
        decay = np.exp(-rate * step)
        slope = (values[k] - values[k - 1]) / step
        late = slope / rate
        out[k] = values[k] - late + (out[k - 1] - values[k - 1] + late) * decay
    return out


def averaged(time: np.ndarray, values: np.ndarray, span: float, at: np.ndarray) -> np.ndarray:
    """Return the means of a curve, which rests before and stays after, over the ``span`` in s before each instant."""
    sums = travelled_distance(time, values)

    def until(instant):
        inside = np.clip(instant, time[0], time[-1])
        k = np.clip(np.searchsorted(time, inside, side="right") - 1, 0, len(time) - 2)
        ahead = inside - time[k]
        slope = (values[k + 1] - values[k]) / (time[k + 1] - time[k])
        own = sums[k] + ahead * (values[k] + 0.5 * slope * ahead)
        return own + np.where(instant < time[0], values[0], values[-1]) * (instant - inside)

    return (until(at) - until(at - span)) / span


def aligned(time: np.ndarray, measured: np.ndarray, at: np.ndarray, predicted: np.ndarray) -> float:
    """Return the offset in s of a trace's time for which it lies closest to a prediction (least squares).

    ``time``, ``measured``: of the trace; ``at``, ``predicted``: of the prediction, which rests before and stays after.
    """
    from scipy.optimize import minimize_scalar

    span = 0.5 * (at[-1] - at[0])

    def squares(offset):
        return float(np.sum((measured - np.interp(time - offset, at, predicted)) ** 2))

    grid = np.linspace(-span, span, 401)
    best = grid[np.argmin([squares(offset) for offset in grid])]
    width = grid[1] - grid[0]
    return float(
        minimize_scalar(
            squares, bounds=(best - width, best + width), method="bounded", options={"xatol": 1e-9 * span}
        ).x
    )
