"""Reference solutions for the extreme cases of the driven stator: independent values of admittance and motion.

A reference is an admittance in S, and u_x and u_z at ``motor.position`` in m per volt. Most are stored beside this
file: the whole section as one sparse matrix of scikit-fem's elements, written by `tests/stability_cases.py`, whose test
solves them again. The others are the next level of discretisation.
"""

import csv
import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from fem import LEVELS, ConvergenceError, solve_driven, surface_of
from studies.evidence.stability.verdict import Comparison, NoReference

STORED = Path(__file__).with_name("stator_references.csv")


def compared_with_reference(motor, stored, tolerance: float, balance: float) -> Comparison:
    """Solve a motor and compare it with a reference; return (error, estimate, True), or a text where it flags itself.

    Of motion and admittance the one with the larger error over its estimate is returned; an estimate below a hundredth
    of the tolerance counts as that.  If the power balance does not close, a text in place of True says so.

    Parameters
    ----------
    motor : studies.evidence.stability.stator.Motor
    stored : tuple of complex and array, or None
        The reference; with None it is the next level of discretisation.
    tolerance : float
        Relative tolerance of the motion.
    balance : float
        Bound on the residual of the power balance over the apparent power.
    """
    wave = motor.wave(tolerance)
    try:
        admittance, motion = stored or _finer(motor, wave)
    except ConvergenceError as reason:
        raise NoReference(str(reason)) from None
    if not wave.power_residual < balance:
        return wave.power_residual, 0.0, "the power balance does not close"
    pairs = [
        (_difference(wave.motion(motor.position), motion), wave.relative_error),
        (abs(wave.admittance / admittance - 1), wave.admittance_error),
    ]
    if not all(math.isfinite(error) for error, _ in pairs):
        return math.nan, wave.relative_error, True
    error, estimate = max(pairs, key=lambda pair: pair[0] / max(pair[1], tolerance / 100))
    return float(error), float(estimate), True


@cache
def stored_references() -> dict[tuple[str, float], tuple[complex, np.ndarray]]:
    """Return the stored references by quantity and value."""
    with STORED.open(encoding="utf-8", newline="") as file:
        return {
            (row["varied"], float(row["value"])): (
                complex(row["admittance_S"]), np.array([complex(row[name]) for name in ("u_x_m_per_V", "u_z_m_per_V")]),
            )
            for row in csv.DictReader(file)
        }  # fmt: skip


def _difference(motion: np.ndarray, reference: np.ndarray) -> float:
    """Return the difference of two orbits over the larger component, without a common phase, which has no effect."""
    reference = np.asarray(reference)
    phase_factor = np.exp(1j * np.angle(np.sum(np.conj(reference) * motion)))
    return float(abs(motion - phase_factor * reference).max() / abs(reference).max())


def _finer(motor, answer) -> tuple[complex, np.ndarray]:
    """Solve on the next level of discretisation or, after the last level, with a higher order."""
    finer = (*LEVELS, replace(LEVELS[-1], order=12))
    resolution = finer[LEVELS.index(answer.solution.fields.resolution) + 1]
    solution = solve_driven(
        motor.stator, motor.transducers, frequency=motor.frequency, drive=motor.drive, resolution=resolution
    )
    return solution.circuit.admittance, surface_of(solution).motion(motor.position)
