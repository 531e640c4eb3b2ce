"""Frequencies at which the linear algebra of the driven stator is singular although the physical problem is not.

There are two kinds. At the cut-off of a mode, k = 0, and the guided modes of both directions coincide. At the resonance
of a clamped piece of the stator, static condensation fails because the interior block is singular. Both frequencies are
computed to machine precision on the discretisation of an answer with a tolerance of 1e-3, so that a case meets the
singularity exactly.
"""

import numpy as np
from scipy.linalg import eig

from fem import LEVELS, discretise, slowest_wavelength
from fem.condense.electrode_conditions import equipotential
from fem.condense.transducer import Condensation, FingerShape, half_cells

LEVEL = 2  # of fem.discretize.mesh_refinement.LEVELS
BAND = (0.6, 1.6)  # relative to the frequency of the motor; brackets the first resonance of a piece
STEPS = 60


def cut_off(motor) -> float:
    """Return the first cut-off frequency in Hz of a lossless section above the frequency of the motor."""
    section = _section(motor)
    first, second = motor.frequency, 2 * motor.frequency
    low, high = (section.matrices(each)[2] for each in (first, second))  # K - omega^2 M at k = 0
    mass = (low - high) / (second**2 - first**2)
    squares = eig(low + first**2 * mass, mass, right=False)
    squares = squares[np.isfinite(squares)]
    squares = squares[(abs(squares.imag) < 1e-9 * abs(squares)) & (squares.real > 0)].real
    frequencies = np.sqrt(squares)
    return float(frequencies[frequencies > 1.1 * motor.frequency].min())


def piece_resonance(motor) -> float:
    """Return the first resonance in Hz of the clamped cell of a finger, by bisection on the Sturm count."""
    low, high = (motor.frequency * side for side in BAND)
    first = _negatives(motor, low)
    for _ in range(STEPS):
        middle = (low + high) / 2
        if _negatives(motor, middle) > first:
            high = middle
        else:
            low = middle
    return (low + high) / 2


def _section(motor):
    return discretise(
        motor.stator,
        LEVELS[LEVEL],
        wavelength=slowest_wavelength(motor.stator.solid, motor.frequency),
        surface_scale=motor.transducers[0].finger_width / 2,
    )


def _negatives(motor, frequency: float) -> int:
    """Return the number of negative eigenvalues of the cell condensed to the line in mid-finger.

    The outer lines of the cell are clamped, and its electrode is at zero potential.
    """
    section = _section(motor)
    unit, transducer = section.length_unit, motor.transducers[0]
    shape = FingerShape(half_finger=transducer.finger_width / 2 / unit, half_gaps=(transducer.half_gap / unit,) * 2)
    rising, falling = half_cells(Condensation(section, frequency), shape, LEVELS[LEVEL])
    phi, lines = section.surface_dofs["phi"], rising.at
    left_part, right_part = (
        equipotential(half.matrix, np.array([line.start + phi]), lines.ports.start)[line, line]
        for half, line in ((rising, lines.right), (falling, lines.left))
    )
    middle = left_part + right_part
    keep = np.arange(section.size) != phi
    return int(np.sum(np.linalg.eigvalsh(middle[np.ix_(keep, keep)]) < 0))
