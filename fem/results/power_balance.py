"""Power balance of a driven stator: input, loss in the solid, loads, radiation through the ends.

Three quantities of different origin must balance at each piece: the flux through its two interface lines, from the
incident and outgoing waves; the loss between them, from the imaginary moduli, element by element (`Piece.recover`); and
the input, from the circuit's voltages and currents.  The input of a line force is the power that the waves carry away
on both of its sides.

With finite apertures (fem.beam.reception) the lines carry the mean wave over each transducer's aperture.  Power that
one transducer radiates and the next does not receive then counts as lost, in the solid or past the aperture.  A
transducer's finite aperture changes the radiated power against that of the section; this excess is divided equally
between its two sides.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fem.results.evaluation import end_line, recovered
from fem.results.solution import Solution
from fem.waveguide.ends import Beyond, Wall
from fem.waveguide.modes import power
from fem.waveguide.network import SegmentWaves
from fem.waveguide.port_fields import PortFields


@dataclass(frozen=True, kw_only=True)
class PowerBalance:
    """Power of a solution in W per V^2 of the drive (peak).

    Over the aperture of the (first) driven transducer; with finite apertures, over each transducer's own.
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
        """Power that is not radiated: lost in the solid, an absorbing bottom and the other transducers' loads."""
        return self.input - self.radiated


@dataclass(frozen=True, kw_only=True)
class _Crossing:
    """Powers at an element of the cascade, a piece or a force, in W."""

    left: float  # flux along +x through its left line
    right: float  # flux along +x through its right line
    taken: float  # from the circuit or the force
    lost: float = 0.0  # in the solid
    excess: float = 0.0  # radiated beyond that of the section, because of the finite aperture

    @property
    def imbalance(self) -> float:
        """Power that enters and does not leave."""
        return abs(self.taken - self.excess - (self.right - self.left) - self.lost)


def power_balance(solution: Solution) -> PowerBalance:
    """Input, lost and radiated power, and the worst imbalance at a piece or a force."""
    fields, circuit = solution.fields, solution.circuit
    crossings, load_power, force_power = [], 0.0, 0.0
    for index, parts in enumerate(fields.segments):
        for number, (before, after) in zip(fields.network.forces_on(index), pairwise(parts), strict=True):
            crossings.append(_at_force(solution, number, before, after))
            force_power += crossings[-1].taken
        if index < len(fields.network.scatterers):
            crossings.append(_at_piece(solution, index))
            load_power += _load_power(solution, index, crossings[-1].taken)
    to_watts = fields.section.solid.stress_unit * circuit.aperture  # scaled power per aperture to W
    radiated = [-(crossings[0].left - crossings[0].excess / 2), crossings[-1].right + crossings[-1].excess / 2]
    lost_between = sum(
        one.right + one.excess / 2 - (other.left - other.excess / 2) for one, other in pairwise(crossings)
    )
    for side, end in enumerate(fields.network.ends):
        if end == "absorbing":
            continue
        # Nothing is radiated at a reflecting end: the flux towards it counts as lost, except what passes a step of
        # thickness, which counts as radiated.
        passed = 0.0
        if isinstance(end, Wall) and end.beyond is not None:
            passed = to_watts * _power_behind_step(solution, side, end.beyond)
        lost_between, radiated[side] = lost_between + radiated[side] - passed, passed
    apparent_power = circuit.apparent_power
    if solution.forces is not None:
        displacements = fields.displacements @ solution.weights
        force_products = float(abs(displacements * solution.forces).sum())
        apparent_power += np.pi * fields.frequency * circuit.aperture * force_products
    return PowerBalance(
        input=circuit.power + force_power,
        solid=float(sum(each.lost for each in crossings) + lost_between),
        loads=float(load_power),
        left=float(radiated[0]),
        right=float(radiated[1]),
        residual=max(each.imbalance for each in crossings) / apparent_power,
    )


def _transducer_of(fields: PortFields, index: int) -> str:
    """Name of the transducer whose electrodes stand on a piece of the cascade; empty if none do."""
    owner = fields.owners[index]
    if owner is not None:
        return fields.transducers[owner].name
    return next((port.name[:-1] for port in fields.network.scatterers[index].piece.ports), "")


def _load_power(solution: Solution, index: int, taken: float) -> float:
    """Power from a piece of the cascade into terminations, W; ``taken``: power that enters the piece at its ports."""
    fields, circuit = solution.fields, solution.circuit
    if fields.network.scatterers[index].piece.size:  # a piece without lines is the whole stator, with all transducers
        name = _transducer_of(fields, index)
        return 0.0 if not name or name in circuit.driven else -taken
    powers = 0.5 * np.real(circuit.voltages * np.conj(circuit.currents))
    return -sum(float(each) for name, each in zip(circuit.names, powers, strict=True) if name not in circuit.driven)


def _at_piece(solution: Solution, index: int) -> _Crossing:
    """Powers at a piece of the cascade; with finite apertures those of the transducer's own aperture."""
    fields, circuit, scatterer = solution.fields, solution.circuit, solution.fields.network.scatterers[index]
    modes, at, frequency = fields.modes, scatterer.at, fields.frequency
    owner = fields.owners[index]
    own = None if owner is None or not fields.own_apertures else fields.transducers[owner]
    aperture = circuit.aperture if own is None else own.aperture
    to_watts = fields.section.solid.stress_unit * aperture
    sides, incident = solution.sides(index), solution.incoming(index)
    crossing = [0.0, 0.0]
    if at.size:
        outgoing = sides[at.lines] - incident
        left = modes.right_impedance @ incident[at.left] - modes.left_impedance @ outgoing[at.left]
        right = modes.right_impedance @ outgoing[at.right] - modes.left_impedance @ incident[at.right]
        crossing = [float(power(sides[line], flux, frequency)) for line, flux in ((at.left, left), (at.right, right))]
    reaction = scatterer.piece.matrix[at.ports] @ sides
    taken = to_watts * np.pi * frequency * float(np.imag(np.sum(reaction * np.conj(sides[at.ports]))))
    excess = 0.0
    if fields.own_apertures:
        name, port_power = _transducer_of(fields, index), 0.0
        if name in circuit.names:
            port = circuit.names.index(name)
            port_power = 0.5 * float(np.real(circuit.voltages[port] * np.conj(circuit.currents[port])))
        excess, taken = port_power - taken, port_power
    return _Crossing(
        left=to_watts * crossing[0],
        right=to_watts * crossing[1],
        taken=taken,
        lost=to_watts * recovered(solution, index).loss(),
        excess=excess,
    )


def _at_force(solution: Solution, number: int, before: SegmentWaves, after: SegmentWaves) -> _Crossing:
    """Powers at a force, number ``number`` of the network's ports, between the parts of its segment on either side."""
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
    index = number - (len(fields.network.ports) - len(fields.displacements))  # force ports come last
    displacement = fields.displacements[index] @ solution.weights
    force = 0.0 if solution.forces is None else solution.forces[index]
    to_watts = fields.section.solid.stress_unit * aperture
    return _Crossing(
        left=to_watts * fluxes[0],
        right=to_watts * fluxes[1],
        taken=float(aperture * np.pi * fields.frequency * np.imag(force * np.conj(displacement))),
    )


def _power_behind_step(solution: Solution, side: int, outside: Beyond) -> float:
    """Power radiated behind a step of thickness, away from the stator, scaled."""
    line = outside.far_line @ end_line(solution, side)
    impedance = outside.modes.right_impedance if side else -outside.modes.left_impedance
    flow = float(power(line, impedance @ line, outside.modes.frequency))
    return flow if side else -flow
