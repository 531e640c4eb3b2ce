"""Witnesses of the driven stator's extreme cases: another way to the same admittance and motion.

Each gives an admittance (S) and u_x, u_z at the place (m per volt), or None for what it does not know.
"""

import math
from dataclasses import replace

import numpy as np

from fem import (
    LEVELS,
    ConvergenceError,
    Resolution,
    direct_solution,
    slowest_wavelength,
    solve_circuit,
    solve_driven,
    surface_of,
)
from studies.evidence.stability.verdict import NoWitness


def compared(motor, witness: str, tolerance: float, balance: float) -> tuple[float, float, bool | str]:
    """Solve a motor and ask a witness.

    Parameters
    ----------
    motor : studies.evidence.stability.stator.Motor
    witness : str
        "direct", "size", "circuit" or "finer".
    tolerance : float
        Relative, of the motion.
    balance : float
        Bound of the power balance's residual over the apparent power.

    Returns
    -------
    error, estimate, kept
        Of motion or admittance, whichever is further from its estimate; see `verdict.judged`.
    """
    wave = motor.wave(tolerance)
    try:
        admittance, motion = WITNESSES[witness](motor, wave)
    except ConvergenceError as lacking:
        raise NoWitness(str(lacking)) from None
    if not wave.power_residual < balance:
        return wave.power_residual, 0.0, "the power balance does not close"
    pairs = [(_difference(wave.motion(motor.place), motion), wave.relative_error)]
    if admittance is not None:
        pairs.append((abs(wave.admittance / admittance - 1), wave.admittance_error))
    if not all(math.isfinite(error) for error, _ in pairs):
        return math.nan, wave.relative_error, True
    error, estimate = max(pairs, key=lambda pair: pair[0] / max(pair[1], tolerance / 100))
    return float(error), float(estimate), True


def _difference(motion: np.ndarray, known: np.ndarray) -> float:
    """Of two orbits, a common phase aside (it moves nothing), over the larger component."""
    known = np.asarray(known)
    turn = np.exp(1j * np.angle(np.sum(np.conj(known) * motion)))
    return float(abs(motion - turn * known).max() / abs(known).max())


def _direct(motor, _) -> tuple[complex, np.ndarray]:
    """The whole section as one sparse matrix, one level finer than the answer."""
    solution = direct_solution(
        motor.stator,
        motor.transducers,
        frequency=motor.frequency,
        resolution=Resolution(order=6, edge_layers=2),
        wavelength=slowest_wavelength(motor.stator.solid, motor.frequency),
        segment_size=0.25,
        segment_layers=3,
    )
    wired = solve_circuit(
        solution.admittances, solution.names, motor.transducers, motor.drive, motor.frequency
    )
    return wired.admittance, solution.surface(np.array([motor.place]))[:, 0] @ wired.voltages


def _finer(motor, answer) -> tuple[complex, np.ndarray]:
    """The next level of the discretisation; beyond the last, one of higher order."""
    level = LEVELS.index(answer.solution.fields.resolution)
    finest = replace(LEVELS[-1], order=12)
    resolution = LEVELS[level + 1] if level + 1 < len(LEVELS) else finest
    solution = solve_driven(
        motor.stator, motor.transducers, frequency=motor.frequency, drive=motor.drive, resolution=resolution
    )
    return solution.circuit.admittance, surface_of(solution).motion(motor.place)


def _size(motor, _) -> tuple[complex, np.ndarray]:
    """The same motor at 2.2 MHz as one sparse matrix: charge per aperture and strain stay the same."""
    factor = 2.2e6 / motor.frequency
    (transducer,) = motor.transducers

    def scaled(part, *names: str):
        return replace(part, **{name: getattr(part, name) / factor for name in names})

    comb = scaled(transducer, "center", "period", "aperture")
    ordinary = replace(
        scaled(motor, "place"), stator=scaled(motor.stator, "length", "thickness"), transducers=(comb,)
    )
    return _direct(replace(ordinary, frequency=2.2e6), _)


def _circuit(motor, _) -> tuple[complex, np.ndarray]:
    """The same motor without source impedance, as one sparse matrix, and a voltage divider."""
    admittance, motion = _direct(replace(motor, source_impedance=0.0), _)
    return admittance, motion / (1 + motor.source_impedance * admittance)


WITNESSES = {"direct": _direct, "finer": _finer, "size": _size, "circuit": _circuit}
