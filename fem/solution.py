"""A driven stator solved on one discretisation: condensed transducers, guided modes, ends and circuit together.

Every transducer is condensed once (equal ones share their block), the uniform stretches are sums of guided modes, and
the circuit makes one field of the ports' fields.
"""

from dataclasses import dataclass, field

import numpy as np

from fem.circuit import Circuit, Ports, circuit, port_admittances, ports_of
from fem.condense.superelement import Block
from fem.condense.transducer import transducer_block
from fem.convergence import ConvergenceError
from fem.discretize.section import Resolution, Section, discretise
from fem.geometry import Stator, Transducer, outer_gaps
from fem.materials.christoffel import slowest_wavelength
from fem.waveguide.ends import Walls
from fem.waveguide.modes import GuidedModes, guided_modes
from fem.waveguide.network import Network, PortSolution, Scatterer

CUT_OFF = 1e-3  # rad per slowest wavelength: a mode's wavenumber below which its square, all that is known, is rounding
MOST_COLUMNS = 150_000  # of a quarter of a finger's


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Discretised answer at one level: what the surface, the audit and the interior are read from."""

    stator: Stator
    transducers: tuple[Transducer, ...]
    section: Section
    modes: GuidedModes
    network: Network
    wiring: tuple[Ports, ...]
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
    fingers = sum(len(transducer.signs) for transducer in transducers)
    if fingers * (resolution.edge_layers + 1) > MOST_COLUMNS:
        raise ConvergenceError(
            f"{fingers} fingers with {resolution.edge_layers} edge layers have more columns of elements than can be "
            "walked through in minutes: take fewer finger_pairs, or ask for a looser tolerance"
        )
    unit = slowest_wavelength(stator.solid, frequency)
    scale = min(transducer.finger_width / 2 for transducer in transducers)
    section = discretise(stator, resolution, wavelength=unit, surface_scale=scale)
    made: dict[tuple, Block] = {}
    blocks = []
    for transducer, gaps in zip(transducers, outer_gaps(stator, transducers), strict=True):
        key = (transducer.signs, transducer.pitch, transducer.metallisation, gaps)
        if key not in made:
            made[key] = transducer_block(section, frequency, transducer, gaps, resolution)
        blocks.append(made[key])
    modes = guided_modes(section, frequency)
    if modes.nearest_cut_off < CUT_OFF:
        raise ConvergenceError(
            f"a mode of the section is at its cut-off at {frequency:.12g} Hz, where the last digits decide: "
            "change the frequency by a part in 100000, or give the solid a mechanical_quality"
        )
    return assembled(
        stator,
        transducers,
        blocks,
        modes=modes,
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
    wiring = [ports_of(transducer, section.floats) for transducer in transducers]
    scatterers = {
        id(block): Scatterer(block=block, modes=modes, potentials=own.potentials)
        for block, own in zip(blocks, wiring, strict=True)
    }
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
    charges = ports.charges * (medium.stress_unit / medium.potential_unit**2)
    admittances = port_admittances(charges, transducers, wiring, frequency)
    wired = circuit(admittances, transducers, wiring, driven=driven, source_impedance=source_impedance)
    weights = wired.voltages / medium.potential_unit
    owned = np.split(weights, np.cumsum([len(own.kinds) for own in wiring])[:-1])
    combs = tuple(own.potentials @ weight for own, weight in zip(wiring, owned, strict=True))
    return Solution(
        stator=stator,
        transducers=transducers,
        section=section,
        modes=modes,
        network=network,
        wiring=tuple(wiring),
        ports=ports,
        circuit=wired,
        resolution=resolution,
        combs=combs,
        weights=weights,
    )
