"""Where the power of a driven stator goes.

The flux through the lines of each piece is taken from what arrives and leaves there, the loss between them from
the imaginary moduli, element by element (`Piece.recover`), and the power in from circuit and charge: three numbers of
different origin that must balance.  A line force gives what the waves carry away on both of its sides.

With finite apertures (fem.beam.reception) the lines carry the mean waves over each transducer's aperture.  What one
sends and the next does not receive is then counted as lost: in the solid, or past its aperture.  What a transducer's
charges send more or less than in the section, for their own finite aperture, counts to both of its sides alike.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fem.results.evaluation import end_line, recovered, wall_of
from fem.results.solution import Solution
from fem.waveguide.ends import Wall
from fem.waveguide.modes import power
from fem.waveguide.network import SegmentWaves
from fem.waveguide.port_fields import PortFields


@dataclass(frozen=True, kw_only=True)
class PowerBalance:
    """Power of a solution in W per V^2 of the drive (peak).

    Over the aperture of the (first) driven transducer or, where beams are received, of each transducer's own.
    """

    input: float  # from the sources' circuit into the driven transducers, and from forces
    # lost in the solid and an absorbing bottom, under the fingers, between the transducers and before
    # reflecting ends; with finite apertures also what passes beside the next transducer
    solid: float
    loads: float  # taken by the other transducers' terminations
    # left, right: radiated through the absorbing ends
    left: float
    right: float
    # worst over pieces and forces of |power in - flux out - power lost between the lines|, over the apparent power
    # |V I| / 2 of the sources and omega |F u| / 2 of the forces
    residual: float

    @property
    def radiated(self) -> float:
        """Through both ends."""
        return self.left + self.right

    @property
    def dissipated(self) -> float:
        """What is not radiated: lost in the solid, an absorbing bottom and the other transducers' loads."""
        return self.input - self.radiated


@dataclass(frozen=True, kw_only=True)
class _Crossing:
    """An element of the row, a piece or a force: power in W that crosses it along +x, enters it and is lost in it."""

    left: float
    right: float
    taken: float
    lost: float = 0.0
    beyond: float = 0.0  # sent more than in the section, by the charges' finite aperture

    @property
    def imbalance(self) -> float:
        """Power that enters and does not leave."""
        return abs(self.taken - self.beyond - (self.right - self.left) - self.lost)


def power_balance(solution: Solution) -> PowerBalance:
    """Return the power in, lost and radiated, and how well they balance round each piece and each force."""
    fields, circuit = solution.fields, solution.circuit
    crossings, into_loads, by_forces = [], 0.0, 0.0
    for index, parts in enumerate(fields.segments):
        for number, (before, after) in zip(fields.network.forces_on(index), pairwise(parts), strict=True):
            crossings.append(_at_force(solution, number, before, after))
            by_forces += crossings[-1].taken
        if index < len(fields.network.scatterers):
            crossings.append(_at_piece(solution, index))
            into_loads += _into_loads(solution, index, crossings[-1].taken)
    section_width = fields.section.solid.stress_unit * circuit.aperture
    leaving = [-(crossings[0].left - crossings[0].beyond / 2), crossings[-1].right + crossings[-1].beyond / 2]
    between = sum(
        one.right + one.beyond / 2 - (other.left - other.beyond / 2) for one, other in pairwise(crossings)
    )
    for side, end in enumerate(fields.network.ends):
        if end == "absorbing":
            continue
        # nothing is radiated at a reflecting end: what leaves towards it counts as lost, but for what passes a step of
        # thickness, which counts as radiated
        behind = 0.0
        if isinstance(end, Wall) and end.beyond is not None:
            behind = section_width * _behind(solution, side)
        between, leaving[side] = between + leaving[side] - behind, behind
    apparent = circuit.apparent_power
    if solution.forces is not None:
        moved = fields.displacements @ solution.weights
        apparent += np.pi * fields.frequency * circuit.aperture * float(abs(moved * solution.forces).sum())
    left, right = leaving
    return PowerBalance(
        input=circuit.power + by_forces,
        solid=float(sum(each.lost for each in crossings) + between),
        loads=float(into_loads),
        left=float(left),
        right=float(right),
        residual=max(each.imbalance for each in crossings) / apparent,
    )


def _transducer_of(fields: PortFields, index: int) -> str:
    """Transducer whose potentials a piece of the row has, empty if it has none."""
    owner = fields.owners[index]
    if owner is not None:
        return fields.transducers[owner].name
    return next((port.name[:-1] for port in fields.network.scatterers[index].piece.ports), "")


def _into_loads(solution: Solution, index: int, taken: float) -> float:
    """Power that a piece of the row gives to terminations, W; ``taken``: what its ports take in all."""
    fields, circuit = solution.fields, solution.circuit
    if fields.network.scatterers[index].piece.size:
        name = _transducer_of(fields, index)
        return 0.0 if not name or name in circuit.driven else -taken
    powers = 0.5 * np.real(circuit.voltages * np.conj(circuit.currents))
    return -sum(
        float(each) for name, each in zip(circuit.names, powers, strict=True) if name not in circuit.driven
    )


def _at_piece(solution: Solution, index: int) -> _Crossing:
    fields, circuit, scatterer = solution.fields, solution.circuit, solution.fields.network.scatterers[index]
    modes, at, frequency = fields.modes, scatterer.at, fields.frequency
    owner = fields.owners[index]
    aperture = fields.transducers[owner].aperture if fields.own_apertures else circuit.aperture
    width = fields.section.solid.stress_unit * aperture
    sides, arriving = solution.sides(index), solution.incoming(index)
    crossing = [0.0, 0.0]
    if at.size:
        leaving = sides[at.lines] - arriving
        left = modes.right_impedance @ arriving[at.left] - modes.left_impedance @ leaving[at.left]
        right = modes.right_impedance @ leaving[at.right] - modes.left_impedance @ arriving[at.right]
        crossing = [
            float(power(sides[line], flux, frequency)) for line, flux in ((at.left, left), (at.right, right))
        ]
    reaction = scatterer.piece.matrix[at.ports] @ sides
    taken = width * np.pi * frequency * float(np.imag(np.sum(reaction * np.conj(sides[at.ports]))))
    beyond = 0.0
    if fields.own_apertures:
        name, at_port = _transducer_of(fields, index), 0.0
        if name in circuit.names:
            port = circuit.names.index(name)
            at_port = 0.5 * float(np.real(circuit.voltages[port] * np.conj(circuit.currents[port])))
        beyond, taken = at_port - taken, at_port
    return _Crossing(
        left=width * crossing[0],
        right=width * crossing[1],
        taken=taken,
        lost=width * recovered(solution, index).loss(),
        beyond=beyond,
    )


def _at_force(solution: Solution, number: int, before: SegmentWaves, after: SegmentWaves) -> _Crossing:
    """``number``: port of the network; ``before``, ``after``: the segment's parts beside the force."""
    fields, modes = solution.fields, solution.fields.modes
    aperture = solution.circuit.aperture
    fluxes = []
    for part, x in ((before, before.stop), (after, after.start)):
        right, left = (
            modes.right @ (part.right_at(modes, x) @ solution.weights),
            modes.left @ (part.left_at(modes, x) @ solution.weights),
        )
        flux = modes.right_impedance @ right - modes.left_impedance @ left
        fluxes.append(float(power(right + left, flux, fields.frequency)))
    own = number - (len(fields.network.ports) - len(fields.displacements))
    moved = fields.displacements[own] @ solution.weights
    force = 0.0 if solution.forces is None else solution.forces[own]
    width = fields.section.solid.stress_unit * aperture
    return _Crossing(
        left=width * fluxes[0],
        right=width * fluxes[1],
        taken=float(aperture * np.pi * fields.frequency * np.imag(force * np.conj(moved))),
    )


def _behind(solution: Solution, side: int) -> float:
    """Power that leaves behind a step of thickness, away from the stator, scaled."""
    outside = wall_of(solution, side).beyond
    line = outside.far_line @ end_line(solution, side)
    impedance = outside.modes.right_impedance if side else -outside.modes.left_impedance
    flow = float(power(line, impedance @ line, outside.modes.frequency))
    return flow if side else -flow
