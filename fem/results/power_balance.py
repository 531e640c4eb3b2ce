"""Where the power of a driven stator goes.

The flux through the lines of each transducer is taken from what arrives and leaves there, the loss between them from
the imaginary moduli, element by element (recovery.py), and the power in from circuit and charge: three numbers of
different origin that must balance.

With finite apertures (fem.beam.reception) the lines carry the mean waves over each transducer's aperture.  What one
sends and the next does not receive is then counted as lost: in the solid, or past its aperture.  What a transducer's
charges send more or less than in the section, for their own finite aperture, counts to both of its sides alike.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fem.results.evaluation import end_line, recovered
from fem.results.solution import Solution
from fem.waveguide.ends import Wall
from fem.waveguide.modes import power


@dataclass(frozen=True, kw_only=True)
class PowerBalance:
    """Power of a solution in W per V^2 of the drive (peak).

    Over the aperture of the (first) driven transducer or, where beams are received, of each transducer's own.
    """

    input: float  # from the sources' circuit into the driven transducers
    # lost in the solid and an absorbing bottom, under the fingers, between the transducers and before
    # reflecting ends; with finite apertures also what passes beside the next transducer
    solid: float
    loads: float  # taken by the other transducers' terminations
    # left, right: radiated through the absorbing ends
    left: float
    right: float
    # worst over the transducers of |power in - flux out - power lost between the lines|, over the sources'
    # apparent power |V I| / 2
    residual: float

    @property
    def radiated(self) -> float:
        """Through both ends."""
        return self.left + self.right

    @property
    def dissipated(self) -> float:
        """What is not radiated: lost in the solid, an absorbing bottom and the other transducers' loads."""
        return self.input - self.radiated


def power_balance(solution: Solution) -> PowerBalance:
    """Return the power in, lost and radiated, and how well they balance round each transducer."""
    fields, circuit = solution.fields, solution.circuit
    modes, n = fields.modes, fields.section.size
    frequency = modes.frequency
    unit = fields.section.solid.stress_unit
    apertures = [
        unit * (fields.transducers[owner].aperture if fields.own_apertures else circuit.aperture)
        for owner in fields.owners
    ]
    worst, lost_under, into_loads, through = 0.0, 0.0, 0.0, []
    for index, (scatterer, aperture) in enumerate(zip(fields.network.scatterers, apertures, strict=True)):
        sides, arriving = solution.sides(index), solution.incoming(index)
        leaving = sides[: 2 * n] - arriving
        left = modes.right_impedance @ arriving[:n] - modes.left_impedance @ leaving[:n]
        right = modes.right_impedance @ leaving[n:] - modes.left_impedance @ arriving[n:]
        fluxes = (
            aperture * power(sides[:n], left, frequency),
            aperture * power(sides[n : 2 * n], right, frequency),
        )
        reaction = scatterer.piece.matrix[2 * n :] @ sides
        taken = aperture * np.pi * frequency * np.imag(np.sum(reaction * np.conj(sides[2 * n :])))
        lost = aperture * recovered(solution, index).loss()
        worst = max(worst, abs(taken - (fluxes[1] - fluxes[0]) - lost))
        owner = fields.owners[index]
        names = [fields.transducers[owner].name] if owner is not None else []
        if owner is None:
            names = [port.name[:-1] for port in scatterer.piece.ports]
        beyond = 0.0
        name = names[0] if names else ""
        if fields.own_apertures:
            at_port = 0.0
            if name in circuit.names:
                port = circuit.names.index(name)
                at_port = 0.5 * np.real(circuit.voltages[port] * np.conj(circuit.currents[port]))
            beyond, taken = at_port - taken, at_port
        lost_under += lost
        into_loads -= 0.0 if not name or name in circuit.driven else taken
        through.append((fluxes[0] - beyond / 2, fluxes[1] + beyond / 2))
    leaving = [-through[0][0], through[-1][1]]
    between = sum(one[1] - other[0] for one, other in pairwise(through))
    for side, end in enumerate(fields.network.ends):
        if end == "absorbing":
            continue
        # what leaves towards an end is lost on the way there and back, or behind a step of thickness
        behind = 0.0
        if isinstance(end, Wall) and end.beyond is not None:
            behind = unit * circuit.aperture * _behind(solution, side)
        between, leaving[side] = between + leaving[side] - behind, behind
    left, right = leaving
    return PowerBalance(
        input=circuit.power,
        solid=float(lost_under + between),
        loads=float(into_loads),
        left=float(left),
        right=float(right),
        residual=worst / circuit.apparent_power,
    )


def _behind(solution: Solution, side: int) -> float:
    """Power that leaves behind a step of thickness, away from the stator, scaled."""
    outside = solution.fields.network.ends[side].beyond
    line = outside.far_line @ end_line(solution, side)
    impedance = outside.modes.right_impedance if side else -outside.modes.left_impedance
    flow = float(power(line, impedance @ line, outside.modes.frequency))
    return flow if side else -flow
