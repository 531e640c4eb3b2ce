"""Reference solutions for the extreme cases of the driven stator: independent values of admittance and motion.

Each function returns an admittance in S, or None if it has none, and u_x and u_z at ``motor.position`` in m per volt.
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
from studies.evidence.stability.verdict import Comparison, NoReference


def compared_with_reference(motor, kind: str, tolerance: float, balance: float) -> Comparison:
    """Solve a motor and compare it with a reference; return (error, estimate, True), or a text where it flags itself.

    Of motion and admittance the one with the larger error over its estimate is returned; an estimate below a hundredth
    of the tolerance counts as that.  If the power balance does not close, a text in place of True says so.

    Parameters
    ----------
    motor : studies.evidence.stability.stator.Motor
    kind : str
        "direct", "size", "circuit" or "finer".
    tolerance : float
        Relative tolerance of the motion.
    balance : float
        Bound on the residual of the power balance over the apparent power.
    """
    wave = motor.wave(tolerance)
    try:
        admittance, motion = REFERENCES[kind](motor, wave)
    except ConvergenceError as reason:
        raise NoReference(str(reason)) from None
    if not wave.power_residual < balance:
        return wave.power_residual, 0.0, "the power balance does not close"
    pairs = [(_difference(wave.motion(motor.position), motion), wave.relative_error)]
    if admittance is not None:
        pairs.append((abs(wave.admittance / admittance - 1), wave.admittance_error))
    if not all(math.isfinite(error) for error, _ in pairs):
        return math.nan, wave.relative_error, True
    error, estimate = max(pairs, key=lambda pair: pair[0] / max(pair[1], tolerance / 100))
    return float(error), float(estimate), True


def _difference(motion: np.ndarray, reference: np.ndarray) -> float:
    """Return the difference of two orbits over the larger component, without a common phase, which has no effect."""
    reference = np.asarray(reference)
    phase_factor = np.exp(1j * np.angle(np.sum(np.conj(reference) * motion)))
    return float(abs(motion - phase_factor * reference).max() / abs(reference).max())


def _direct(motor, _) -> tuple[complex, np.ndarray]:
    """Solve the whole section as one sparse matrix, at a fixed resolution with short elements."""
    solution = direct_solution(
        motor.stator,
        motor.transducers,
        frequency=motor.frequency,
        resolution=Resolution(order=6, edge_layers=2),
        wavelength=slowest_wavelength(motor.stator.solid, motor.frequency),
        segment_size=0.25,
        segment_layers=3,
    )
    circuit = solve_circuit(solution.admittances, solution.names, motor.transducers, motor.drive, motor.frequency)
    return circuit.admittance, solution.surface(np.array([motor.position]))[:, 0] @ circuit.voltages


def _finer(motor, answer) -> tuple[complex, np.ndarray]:
    """Solve on the next level of discretisation or, after the last level, with a higher order."""
    finer = (*LEVELS, replace(LEVELS[-1], order=12))
    resolution = finer[LEVELS.index(answer.solution.fields.resolution) + 1]
    solution = solve_driven(
        motor.stator, motor.transducers, frequency=motor.frequency, drive=motor.drive, resolution=resolution
    )
    return solution.circuit.admittance, surface_of(solution).motion(motor.position)


def _size(motor, _) -> tuple[complex, np.ndarray]:
    """Solve the motor scaled to 2.2 MHz as one sparse matrix; motion per volt and admittance do not change.

    At the same voltage the charge per aperture is the same, and so is the frequency times the aperture.
    """
    factor = 2.2e6 / motor.frequency
    (transducer,) = motor.transducers

    def scaled(part, *names: str):
        return replace(part, **{name: getattr(part, name) / factor for name in names})

    transducer = scaled(transducer, "center", "period", "aperture")
    stator = scaled(motor.stator, "length", "thickness")
    whole = replace(scaled(motor, "position"), stator=stator, transducers=(transducer,), frequency=2.2e6)
    return _direct(whole, _)


def _circuit(motor, _) -> tuple[complex, np.ndarray]:
    """Solve the motor without source impedance as one sparse matrix, and apply a voltage divider."""
    admittance, motion = _direct(replace(motor, source_impedance=0.0), _)
    return admittance, motion / (1 + motor.source_impedance * admittance)


REFERENCES = {"direct": _direct, "finer": _finer, "size": _size, "circuit": _circuit}
