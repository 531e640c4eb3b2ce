"""Witnesses of the driven stator's extreme cases: another way to the same admittance and motion.

Each gives an admittance (S) and u_x, u_z at the place (m per volt), or None for what it does not know.
"""

import math
from dataclasses import replace

import numpy as np

from fem import ConvergenceError
from studies.evidence.stability.verdict import NoWitness

__all__ = ["compared"]


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
        Of motion or admittance, whichever is further from its estimate; see stability_verdict.judged.
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
    found = [(float(error), float(estimate)) for error, estimate in pairs]
    if not all(math.isfinite(error) for error, _ in found):
        return math.nan, wave.relative_error, True
    error, estimate = max(found, key=lambda pair: pair[0] / max(pair[1], tolerance / 100))
    return error, estimate, True


def _difference(motion: np.ndarray, known: np.ndarray) -> float:
    """Of two orbits, a common phase aside (it moves nothing), over the larger component."""
    known = np.asarray(known)
    turn = np.exp(1j * np.angle(np.sum(np.conj(known) * motion)))
    return float(abs(motion - turn * known).max() / abs(known).max())


def _direct(motor, _) -> tuple[complex, np.ndarray]:
    """The whole section as one sparse matrix, one level finer than the answer."""
    from fem import Resolution, direct_solution, slowest_wavelength, solve_circuit

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
    from fem import LEVELS, solve_driven, surface_of

    level = LEVELS.index(answer.solution.fields.resolution)
    finest = replace(LEVELS[-1], order=12)
    solution = solve_driven(
        motor.stator,
        motor.transducers,
        frequency=motor.frequency,
        drive=motor.drive,
        resolution=LEVELS[level + 1] if level + 1 < len(LEVELS) else finest,
    )
    return solution.circuit.admittance, surface_of(solution).motion(motor.place)


def _size(motor, _) -> tuple[complex, np.ndarray]:
    """The same motor at 2.2 MHz as one sparse matrix: charge per aperture and strain stay the same."""
    factor = 2.2e6 / motor.frequency
    (transducer,) = motor.transducers
    ordinary = replace(
        motor,
        stator=replace(
            motor.stator, length=motor.stator.length / factor, thickness=motor.stator.thickness / factor
        ),
        transducers=(
            replace(
                transducer,
                center=transducer.center / factor,
                period=transducer.period / factor,
                aperture=transducer.aperture / factor,
            ),
        ),
        frequency=2.2e6,
        place=motor.place / factor,
    )
    return _direct(ordinary, _)


def _circuit(motor, _) -> tuple[complex, np.ndarray]:
    """The same motor without source impedance, as one sparse matrix, and a voltage divider."""
    admittance, motion = _direct(replace(motor, source_impedance=0.0), _)
    return admittance, motion / (1 + motor.source_impedance * admittance)


WITNESSES = {"direct": _direct, "finer": _finer, "size": _size, "circuit": _circuit}
