"""Where the power of a driven stator goes, as an audit of its solution.

The flux through the lines of each transducer is taken from what arrives and leaves there, the loss between them from
the imaginary moduli, element by element (interior.py), and the power in from circuit and charge: three numbers of
different origin that must balance.
"""

from dataclasses import dataclass

import numpy as np

from fem.results.evaluation import column_fields
from fem.solution import Solution
from fem.waveguide.modes import power


@dataclass(frozen=True, kw_only=True)
class Audit:
    """Power of a solution in W per V^2 of the source (peak), over the driven aperture."""

    input: float
    dissipated: float
    radiated: float
    residual: float


def audit(solution: Solution) -> Audit:
    """Power in, lost and sent out, and how well they balance round each transducer.

    Returns
    -------
    Audit
        ``residual``: worst over the transducers of |power in - flux out - power lost between the lines|, over the
        apparent power |V I| / 2 of the source.
    """
    modes, n = solution.modes, solution.section.size
    frequency = modes.frequency
    stress = solution.section.solid.stress_unit
    counts = [len(own.kinds) for own in solution.wiring]
    owners = np.repeat(np.arange(len(counts)), counts)
    driven = solution.transducers[owners[solution.circuit.driven]].aperture
    worst, outward = 0.0, np.zeros(2)
    for index, scatterer in enumerate(solution.network.scatterers):
        sides, arriving = solution.sides(index), solution.incoming(index)
        leaving = sides[: 2 * n] - arriving
        left = modes.right_end @ arriving[:n] - modes.left_end @ leaving[:n]
        right = modes.right_end @ leaving[n:] - modes.left_end @ arriving[n:]
        fluxes = power(sides[:n], left, frequency), power(sides[n : 2 * n], right, frequency)
        reaction = scatterer.charge(sides[: 2 * n, None], sides[2 * n :, None])[:, 0]
        voltages = solution.weights[owners == index]
        taken = np.pi * frequency * np.imag(np.sum(reaction * np.conj(voltages)))
        lost = sum(recovery.loss(places) for recovery, _, places in column_fields(solution, index))
        worst = max(worst, abs(taken - (fluxes[1] - fluxes[0]) - lost) * stress * driven)
        if index == 0:
            outward[0] = -fluxes[0]
        outward[1] = fluxes[1]
    radiated = float(outward.sum() * stress * driven) if solution.network.ends == "absorbing" else 0.0
    given = solution.circuit.power
    own = solution.circuit
    apparent = 0.5 * abs(own.voltages[own.driven] * np.conj(own.currents[own.driven]))
    return Audit(
        input=given,
        dissipated=given - radiated,
        radiated=radiated,
        residual=worst / apparent,
    )
