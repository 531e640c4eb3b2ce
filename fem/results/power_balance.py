"""Power balance of a driven stator: input, loss in the solid, loads, radiation through the ends.

Three quantities of different origin must balance at each piece: the flux through its two interface lines, from the
incident and outgoing waves; the loss between them, from the imaginary moduli, element by element (`Piece.recover`); and
the input, from the circuit's voltages and currents.  The input of a line force is the power that the waves carry away
on both of its sides.

In the plane section each transducer sends waves over its own aperture, and what one receives from another is that of
the narrower of the two (`fem.waveguide.port_fields`).  The stator therefore consists of strips along y, each as wide as
the difference of two apertures, on which those transducers are driven or loaded that reach over it, and the others are
shorted.  On each strip the section balances; the sum over the strips is the circuit's power.

With finite apertures (fem.beam.reception) the lines carry the mean wave over each transducer's aperture.  Power that
one transducer radiates and the next does not receive then counts as lost, in the solid or past the aperture.  A
transducer's finite aperture changes the radiated power against that of the section; this excess is divided equally
between its two sides.
"""

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from fem.results.field_evaluation import end_line, recovered
from fem.results.stator_solution import Solution
from fem.waveguide.end_conditions import Beyond, Wall
from fem.waveguide.guided_modes import power
from fem.waveguide.port_fields import PortFields
from fem.waveguide.scattering_network import SegmentWaves


@dataclass(frozen=True, kw_only=True)
class PowerBalance:
    """Power in W per V^2 of the drive (peak), over each transducer's own aperture; of forces over the widest."""

    input: float  # from the sources' circuit into the driven transducers, and from forces
    # lost in the solid and an absorbing bottom, under the fingers, between the transducers and before
    # reflecting ends; with finite apertures also what passes beside the next transducer
    solid: float
    loads: float  # taken by the other transducers' terminations
    # left, right: radiated through the absorbing ends
    left: float
    right: float
    # |input - solid - loads - left - right| or, if that is larger, the worst over pieces and forces of |power in - flux
    # out - power lost between the lines|
    imbalance: float
    apparent: float  # apparent power |V I| / 2 of the sources and omega |F u| / 2 of the forces

    @property
    def residual(self) -> float:
        """Imbalance over the apparent power; 0 without an imbalance, as where nothing is driven."""
        return self.imbalance / self.apparent if self.imbalance else 0.0

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


@dataclass(frozen=True, kw_only=True)
class _SectionPowers:
    """Powers of a section of some width along y, in W."""

    from_forces: float
    solid: float
    left: float
    right: float
    imbalance: float  # worst of a piece or a force
    apparent: float  # omega |F u| / 2 of the forces


def power_balance(solution: Solution) -> PowerBalance:
    """Input, lost and radiated power, and the worst imbalance of the whole, of a piece or of a force."""
    circuit = solution.circuit
    parts = [_section_powers(strip, width) for width, strip in _strips(solution)]
    powers = 0.5 * np.real(circuit.voltages * np.conj(circuit.currents))
    loads = -sum(float(each) for name, each in zip(circuit.names, powers, strict=True) if name not in circuit.driven)
    solid, left, right, from_forces, imbalance, apparent = (
        float(sum(getattr(each, name) for each in parts))
        for name in ("solid", "left", "right", "from_forces", "imbalance", "apparent")
    )
    taken, apparent = circuit.power + from_forces, circuit.apparent_power + apparent
    return PowerBalance(
        input=taken,
        solid=solid,
        loads=loads,
        left=left,
        right=right,
        imbalance=max(imbalance, abs(taken - solid - loads - left - right)),
        apparent=apparent,
    )


def _strips(solution: Solution) -> list[tuple[float, Solution]]:
    """Widths in m of the strips along y, and the solution on each: a voltage is zero beside its transducer's aperture.

    A single one without transducers, and where the fields are those of each transducer's own aperture.
    """
    circuit, fields = solution.circuit, solution.fields
    if fields.own_apertures or not circuit.names:
        return [(circuit.aperture, solution)]
    by_name = {each.name: each.aperture for each in fields.transducers}
    apertures = np.array([by_name[name] for name in circuit.names])
    edges = np.unique(apertures)
    strips = []
    for width, outer in zip(np.diff(edges, prepend=0.0), edges, strict=True):
        voltages = np.where(apertures >= outer, circuit.voltages, 0.0)
        strips.append((float(width), replace(solution, circuit=replace(circuit, voltages=voltages))))
    return strips


def _section_powers(solution: Solution, width: float) -> _SectionPowers:
    """Powers of a solution over a width in m; with finite apertures those of each transducer's own."""
    fields = solution.fields
    crossings, force_power = [], 0.0
    for index, parts in enumerate(fields.segments):
        for number, (before, after) in zip(fields.network.forces_on(index), pairwise(parts), strict=True):
            crossings.append(_at_force(solution, width, number, before, after))
            force_power += crossings[-1].taken
        if index < len(fields.network.scatterers):
            crossings.append(_at_piece(solution, width, index))
    to_watts = fields.section.solid.stress_unit * width  # scaled power per metre to W
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
    apparent = 0.0
    if solution.forces is not None:
        displacements = fields.displacements @ solution.weights
        apparent = np.pi * fields.frequency * width * float(abs(displacements * solution.forces).sum())
    return _SectionPowers(
        from_forces=float(force_power),
        solid=float(sum(each.lost for each in crossings) + lost_between),
        left=float(radiated[0]),
        right=float(radiated[1]),
        imbalance=max(each.imbalance for each in crossings),
        apparent=apparent,
    )


def _transducer_of(fields: PortFields, index: int) -> str:
    """Name of the transducer whose electrodes stand on a piece of the cascade; empty if none do."""
    owner = fields.owners[index]
    if owner is not None:
        return fields.transducers[owner].name
    return next((port.name[:-1] for port in fields.network.scatterers[index].piece.ports), "")


def _at_piece(solution: Solution, width: float, index: int) -> _Crossing:
    """Powers at a piece of the cascade over a width, m; with finite apertures over the transducer's own aperture."""
    fields, circuit, scatterer = solution.fields, solution.circuit, solution.fields.network.scatterers[index]
    modes, at, frequency = fields.modes, scatterer.at, fields.frequency
    owner = fields.owners[index]
    own = None if owner is None or not fields.own_apertures else fields.transducers[owner]
    to_watts = fields.section.solid.stress_unit * (width if own is None else own.aperture)
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


def _at_force(solution: Solution, width: float, number: int, before: SegmentWaves, after: SegmentWaves) -> _Crossing:
    """Powers over a width (m) at a force, a port of the network, between the parts of its segment on either side."""
    fields, modes = solution.fields, solution.fields.modes
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
    to_watts = fields.section.solid.stress_unit * width
    return _Crossing(
        left=to_watts * fluxes[0],
        right=to_watts * fluxes[1],
        taken=float(width * np.pi * fields.frequency * np.imag(force * np.conj(displacement))),
    )


def _power_behind_step(solution: Solution, side: int, outside: Beyond) -> float:
    """Power radiated behind a step of thickness, away from the stator, scaled."""
    line = outside.far_line @ end_line(solution, side)
    impedance = outside.modes.right_impedance if side else -outside.modes.left_impedance
    flow = float(power(line, impedance @ line, outside.modes.frequency))
    return flow if side else -flow
