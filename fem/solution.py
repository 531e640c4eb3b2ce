"""A driven stator solved on one discretisation: condensed transducers, guided modes, ends and circuit together.

Every transducer is condensed once (equal ones share their block), the uniform stretches are sums of guided modes, and
the circuit makes one field of the ports' fields.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.cell import Block
from fem.chain import FingerShape, finger_cell, joined, repeated, swapped
from fem.electrodes import Circuit, circuit, port_admittances, port_potentials
from fem.geometry import Stator, Transducer, outer_gaps
from fem.guided import GuidedModes, guided_modes
from fem.network import Network, PortSolution, Scatterer, Walls
from fem.section import Resolution, Section, discretise
from fem.wavelength import slowest_wavelength


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Discretised answer at one level: what the surface, the audit and the interior are read from."""

    stator: Stator
    transducers: tuple[Transducer, ...]
    section: Section
    modes: GuidedModes
    network: Network
    ports: PortSolution
    circuit: Circuit
    resolution: Resolution
    combs: tuple[np.ndarray, ...] = field(repr=False)
    weights: np.ndarray = field(repr=False)

    def sides(self, index: int) -> np.ndarray:
        """Lines and comb potentials of a transducer, shape (2 n + 2,)."""
        return np.concatenate([self.ports.sides[index] @ self.weights, self.combs[index]])

    def incoming(self, index: int) -> np.ndarray:
        """Part of its lines that comes in, shape (2 n,)."""
        return self.ports.incoming[index] @ self.weights


def solved(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    driven: str,
    source_impedance: complex,
    resolution: Resolution,
) -> Solution:
    """Solve the driven stator on one discretisation.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        At least one; any order.
    frequency : float
        Hz.
    driven : str
        Name of the driven transducer.
    source_impedance : complex
        Ohm.
    resolution : Resolution

    Returns
    -------
    Solution
    """
    transducers = tuple(sorted(transducers, key=lambda transducer: transducer.center))
    unit = slowest_wavelength(stator.solid, frequency)
    scale = min(transducer.finger_width / 2 for transducer in transducers)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    made: dict[tuple, Block] = {}
    blocks = []
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        key = (transducer.finger_pairs, transducer.period, transducer.metallisation, gaps)
        if key not in made:
            made[key] = _transducer_block(section, frequency, transducer, gaps, resolution)
        blocks.append(made[key])
    return assembled(
        stator,
        transducers,
        blocks,
        modes=guided_modes(section, frequency),
        driven=driven,
        source_impedance=source_impedance,
        resolution=resolution,
    )


def assembled(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    blocks: list[Block],
    *,
    modes: GuidedModes,
    driven: str,
    source_impedance: complex,
    resolution: Resolution,
    walls: Walls | None = None,
    inset: float = 0.0,
) -> Solution:
    """Tie condensed transducers, stretches, ends and circuit together.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
        From left to right.
    blocks : list of Block
        One each, the same object for equal ones; from the outer gap's beginning to its end.
    modes : GuidedModes
        Of the uniform stretches; their section is the blocks'.
    driven, source_impedance, resolution
        As in `solved`.
    walls : Walls, optional
        The stator's ends as condensed pieces, ``inset`` length units wide.

    Returns
    -------
    Solution
    """
    section, frequency = modes.section, modes.frequency
    unit = section.length_unit
    potentials = port_potentials(section.floats)
    scatterers = {id(block): Scatterer(block=block, modes=modes, potentials=potentials) for block in blocks}
    gaps = outer_gaps(stator, transducers)
    network = Network(
        modes=modes,
        scatterers=tuple(scatterers[id(block)] for block in blocks),
        places=tuple((each.extent[0] - gap[0]) / unit for each, gap in zip(transducers, gaps, strict=True)),
        start=inset,
        stop=stator.length / unit - inset,
        ends=walls or stator.ends,
    )
    ports = network.solve()
    medium = section.solid
    each = potentials.shape[1]
    charges = ports.charges * (medium.stress_unit / medium.potential_unit**2)
    admittances = port_admittances(charges, transducers, each, frequency)
    wired = circuit(admittances, transducers, each, driven=driven, source_impedance=source_impedance)
    weights = wired.voltages / medium.potential_unit
    combs = tuple(
        potentials @ weights[index * each : (index + 1) * each] for index in range(len(transducers))
    )
    return Solution(
        stator=stator,
        transducers=transducers,
        section=section,
        modes=modes,
        network=network,
        ports=ports,
        circuit=wired,
        resolution=resolution,
        combs=combs,
        weights=weights,
    )


def transducer_row(cell: Block, finger_pairs: int) -> Block:
    """Block of a transducer of equal cells, combs alternating."""
    return repeated(joined(cell, swapped(cell)), finger_pairs)


def _transducer_block(section, frequency, transducer, gaps, resolution) -> Block:
    unit = section.length_unit
    half_gap = (transducer.period / 2 - transducer.finger_width) / 2 / unit
    outer = gaps[0] / unit, gaps[1] / unit

    def cell(left: float, right: float) -> Block:
        shape = FingerShape(half_finger=transducer.finger_width / 2 / unit, half_gaps=(left, right))
        return finger_cell(section, frequency, shape, resolution)

    positive = cell(half_gap, half_gap)
    pairs = transducer.finger_pairs
    if max(abs(outer[0] - half_gap), abs(outer[1] - half_gap)) < 1e-9 * half_gap:
        return transducer_row(positive, pairs)
    first, last = cell(outer[0], half_gap), swapped(cell(half_gap, outer[1]))
    if pairs == 1:
        return joined(first, last)
    return joined(joined(first, repeated(joined(swapped(positive), positive), pairs - 1)), last)
