"""Where the power of a driven stator goes.

The flux through the lines of each transducer is taken from what arrives and leaves there, the loss between them from
the imaginary moduli, element by element (recovery.py), and the power in from circuit and charge: three numbers of
different origin that must balance.
"""

from dataclasses import dataclass

import numpy as np

from fem.results.evaluation import column_fields
from fem.results.solution import Solution
from fem.waveguide.modes import power


@dataclass(frozen=True, kw_only=True)
class PowerBalance:
    """Power of a solution in W per V^2 of the drive (peak), over the aperture of the (first) driven transducer.

    Attributes
    ----------
    input, dissipated, radiated : float
        Given by the sources; lost in the solid, an absorbing bottom and the other transducers' loads; radiated through
        the ends.
    residual : float
        Worst over the transducers of |power in - flux out - power lost between the lines|, over the sources' apparent
        power |V I| / 2.
    """

    input: float
    dissipated: float
    radiated: float
    residual: float


def power_balance(solution: Solution) -> PowerBalance:
    """Return the power in, lost and radiated, and how well they balance round each transducer."""
    fields, circuit = solution.fields, solution.circuit
    modes, n = fields.modes, fields.section.size
    frequency = modes.frequency
    over_aperture = fields.section.solid.stress_unit * circuit.aperture
    worst, outward = 0.0, np.zeros(2)
    for index, scatterer in enumerate(fields.network.scatterers):
        sides, arriving = solution.sides(index), solution.incoming(index)
        leaving = sides[: 2 * n] - arriving
        left = modes.right_impedance @ arriving[:n] - modes.left_impedance @ leaving[:n]
        right = modes.right_impedance @ leaving[n:] - modes.left_impedance @ arriving[n:]
        fluxes = power(sides[:n], left, frequency), power(sides[n : 2 * n], right, frequency)
        reaction = scatterer.superelement.matrix[2 * n :] @ sides
        taken = np.pi * frequency * np.imag(np.sum(reaction * np.conj(sides[2 * n :])))
        lost = sum(recovery.loss(places) for recovery, _, places in column_fields(solution, index))
        worst = max(worst, abs(taken - (fluxes[1] - fluxes[0]) - lost) * over_aperture)
        if index == 0:
            outward[0] = -fluxes[0]
        outward[1] = fluxes[1]
    radiated = float(outward.sum() * over_aperture) if fields.network.ends == "absorbing" else 0.0
    return PowerBalance(
        input=circuit.power,
        dissipated=circuit.power - radiated,
        radiated=radiated,
        residual=worst / circuit.apparent_power,
    )
