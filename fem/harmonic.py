"""The driven stator at one frequency: from the scene's geometry to the surface motion per volt, with its error.

Every transducer is condensed once (equal ones share their block), the uniform stretches are sums of guided modes,
and the circuit makes one field of the ports' fields.  The same is done on two discretisations; their difference,
extrapolated with the rate at which edge layers converge (each divides the error of the charge by 6.7), is the error
reported.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from fem.cell import Block
from fem.chain import FingerShape, finger_cell, joined, lines, repeated, swapped, widths
from fem.convergence import ConvergenceError
from fem.electrodes import Circuit, circuit, port_admittances, port_potentials
from fem.geometry import Stator, Transducer, check_layout, outer_gaps
from fem.guided import GuidedModes, guided_modes, power
from fem.interior import ColumnField
from fem.materials import fields
from fem.network import Network, PortSolution, Scatterer, Walls, end_reflection
from fem.section import Resolution, Section, discretise
from fem.surface import Covered, Stretch, SurfaceWave
from fem.wavelength import slowest_wavelength

# From coarse to fine: measured on the seed's stator (admittance and surface motion move together).
LEVELS = (
    Resolution(order=5, edge_layers=0),
    Resolution(order=6, edge_layers=1),
    Resolution(order=7, edge_layers=2),
    Resolution(order=8, edge_layers=3),
    Resolution(order=9, edge_layers=4),
    Resolution(order=10, edge_layers=5),
)
EXPECTED = (np.inf, 5e-3, 1e-3, 1e-4, 1e-5, 1e-6)  # error of each level on an ordinary motor: where to begin
GAIN = 8.0  # a level divides the error by more than this: 6.7 per edge layer, and more by the order (11 to 25 seen)


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


def surface_pieces(solution: Solution) -> tuple:
    """Stretches and covered parts of the surface from left to right, in m and m per volt."""
    modes, section, network = solution.modes, solution.section, solution.network
    unit, n = section.length_unit, section.size
    pieces: list = []
    last = len(network.scatterers)
    stretches = network.stretches
    nothing = np.zeros(n, dtype=complex)
    for index, (start, stop) in enumerate(stretches):
        right = left = nothing
        if index > 0:
            out = solution.sides(index - 1)[n : 2 * n] - solution.incoming(index - 1)[n:]
            right = modes.right_amplitudes(out)
        if index < last:
            out = solution.sides(index)[:n] - solution.incoming(index)[:n]
            left = modes.left_amplitudes(out)
        if network.ends != "absorbing" and index == 0:
            right = _returned(modes, network.ends, 0, left * np.exp(1j * modes.backwards * (stop - start)))
        if network.ends != "absorbing" and index == last:
            left = _returned(modes, network.ends, 1, right * np.exp(-1j * modes.wavenumbers * (stop - start)))
        pieces.append(
            Stretch(
                start=start * unit,
                stop=stop * unit,
                right=right,
                left=left,
                wavenumbers=modes.wavenumbers / unit,
                backwards=modes.backwards / unit,
                right_shapes=section.surface_rows @ modes.right,
                left_shapes=section.surface_rows @ modes.left,
                rayleigh=modes.rayleigh,
            )
        )
        if index < last:
            pieces.append(
                Covered(edges=_column_edges(solution, index), recover=partial(_covered, solution, index))
            )
    return tuple(pieces)


def _returned(modes, ends, side, arriving):
    chosen = np.flatnonzero(abs(arriving) > 0)
    return end_reflection(modes, ends, side, chosen) @ arriving[chosen]


def column_fields(solution: Solution, index: int):
    """Columns of a transducer by kind: (recovery, left edges in m, sides (2 n + 2, places))."""
    unit, n = solution.section.length_unit, solution.section.size
    turned = np.r_[0 : 2 * n, 2 * n + 1, 2 * n]
    kinds: dict[tuple, tuple] = {}
    for start, part, sides in _columns(solution, index):
        column = part.column
        if column.comb == 1:
            sides = sides[turned]
        covered = column.comb is not None
        if (column.width, covered) not in kinds:
            if column.comb == 1:
                column = swapped(part).column
            kinds[column.width, covered] = (column, [], [])
        kind = kinds[column.width, covered]
        kind[1].append(start * unit)
        kind[2].append(sides)
    for column, starts, sides in kinds.values():
        yield ColumnField(column), np.array(starts), np.stack(sides, axis=-1)


def _columns(solution: Solution, index: int):
    block = solution.network.scatterers[index].block
    return lines(block, solution.sides(index), solution.network.places[index])


def _column_edges(solution: Solution, index: int) -> np.ndarray:
    block, unit = solution.network.scatterers[index].block, solution.section.length_unit
    return (solution.network.places[index] + np.append(0.0, np.cumsum(list(widths(block))))) * unit


def _covered(solution: Solution, index: int) -> np.ndarray:
    """Surface values under a transducer, shape (columns, order + 1, 2), from left to right."""
    section = solution.section
    starts, values = [], []
    for recovery, left, sides in column_fields(solution, index):
        starts.append(left)
        values.append(np.moveaxis(recovery.values(sides)[:, section.surface][:, [0, 2]], -1, 0))
    return np.concatenate(values)[np.argsort(np.concatenate(starts))]


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
        power of the source.
    """
    modes, n = solution.modes, solution.section.size
    frequency = modes.frequency
    stress = solution.section.solid.stress_unit
    each = solution.network.scatterers[0].potentials.shape[1]
    apertures = [transducer.aperture for transducer in solution.transducers]
    driven = apertures[solution.circuit.driven // each]
    worst, outward = 0.0, np.zeros(2)
    for index, scatterer in enumerate(solution.network.scatterers):
        sides, arriving = solution.sides(index), solution.incoming(index)
        leaving = sides[: 2 * n] - arriving
        left = modes.right_end @ arriving[:n] - modes.left_end @ leaving[:n]
        right = modes.right_end @ leaving[n:] - modes.left_end @ arriving[n:]
        fluxes = power(sides[:n], left, frequency), power(sides[n : 2 * n], right, frequency)
        reaction = scatterer.charge(sides[: 2 * n, None], sides[2 * n :, None])[:, 0]
        voltages = solution.weights[index * each : (index + 1) * each]
        taken = np.pi * frequency * np.imag(np.sum(reaction * np.conj(voltages)))
        lost = sum(recovery.loss(places) for recovery, _, places in column_fields(solution, index))
        worst = max(worst, abs(taken - (fluxes[1] - fluxes[0]) - lost) * stress * driven)
        if index == 0:
            outward[0] = -fluxes[0]
        outward[1] = fluxes[1]
    radiated = float(outward.sum() * stress * driven) if solution.network.ends == "absorbing" else 0.0
    given = solution.circuit.power
    return Audit(
        input=given,
        dissipated=given - radiated,
        radiated=radiated,
        residual=worst / given if given > 0 else np.inf,
    )


def driven_wave(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    frequency: float,
    driven: str,
    source_impedance: complex = 0.0,
    tolerance: float,
    places: tuple[float, ...] = (),
    progress: Callable[[str], None] | None = None,
) -> SurfaceWave:
    """Surface motion, admittance and power of the driven stator, per volt of the source.

    Parameters
    ----------
    stator : Stator
    transducers : tuple of Transducer
    frequency : float
        Hz.
    driven : str
        Name of the driven transducer.
    source_impedance : complex
        Ohm.
    tolerance : float
        Relative, of the surface motion at ``places``.
    places : tuple of float
        m from the left end; mid-stator if empty.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    SurfaceWave

    Raises
    ------
    ValueError
        For a geometry or a solid that cannot be driven.
    ConvergenceError
        If the finest discretisation does not reach the tolerance.
    """
    check_layout(stator, transducers)
    if "phi" not in fields(stator.solid):
        raise ValueError(f"a transducer needs a piezoelectric stator, and {stator.solid.name} is not one")
    if not (np.isfinite(frequency) and frequency > 0):
        raise ValueError(f"drive.frequency must be positive and finite, got {frequency!r} Hz")
    begun = time.perf_counter()
    at = np.array(places or (stator.length / 2,))
    say = progress or (lambda text: None)
    level = _first_level(tolerance)
    coarse = None
    while True:
        resolution = LEVELS[level]
        say(f"stator: order {resolution.order}, {resolution.edge_layers} edge layers")
        solution = solved(
            stator,
            transducers,
            frequency=frequency,
            driven=driven,
            source_impedance=source_impedance,
            resolution=resolution,
        )
        wave = surface_wave(solution)
        if coarse is not None:
            wave = replace(
                wave,
                relative_error=orbit_difference(wave, coarse, at) / (GAIN - 1),
                admittance_error=abs(wave.admittance / coarse.admittance - 1) / (GAIN - 1),
            )
            if wave.relative_error <= tolerance:
                break
        if level + 1 == len(LEVELS):
            raise ConvergenceError(
                f"the stator's surface motion is known to {wave.relative_error:.1e} only, "
                f"{tolerance:.1e} was asked for: ask for less, or make the fingers less extreme"
            )
        level, coarse = level + 1, wave
    say("stator: power balance")
    powers = audit(solution)
    return replace(
        wave,
        power_input=powers.input,
        power_dissipated=powers.dissipated,
        power_radiated=powers.radiated,
        power_residual=powers.residual,
        seconds=time.perf_counter() - begun,
    )


def _first_level(tolerance: float) -> int:
    """Coarser of the two levels to begin with."""
    enough = [level for level, error in enumerate(EXPECTED) if error <= tolerance]
    return (enough[0] if enough else len(EXPECTED) - 1) - 1


def orbit_difference(wave: SurfaceWave, other: SurfaceWave, at: np.ndarray) -> float:
    """Largest relative difference of the orbits at places; a common phase, which moves nothing, does not count."""
    orbits = []
    for each in (wave, other):
        tangential, normal = each.motion(at)
        orbits.append((abs(normal), tangential * np.exp(-1j * np.angle(normal))))
    size = np.maximum(abs(orbits[0][0]), abs(orbits[0][1]))
    change = np.maximum(abs(orbits[0][0] - orbits[1][0]), abs(orbits[0][1] - orbits[1][1]))
    return float(np.max(change / size))


def surface_wave(solution: Solution) -> SurfaceWave:
    """Surface motion of a solution; its errors and powers are yet to be found (infinite and NaN)."""
    modes, section, wired = solution.modes, solution.section, solution.circuit
    surface = modes.rayleigh
    shape = section.surface_rows @ modes.right[:, surface]
    frequency = modes.frequency
    speed = 2 * np.pi * frequency * section.length_unit / np.mean(modes.wavenumbers[surface].real)
    resolution = solution.resolution
    columns = sum(2 * t.finger_pairs * 4 * (resolution.edge_layers + 1) for t in solution.transducers)
    driven = solution.circuit.driven
    return SurfaceWave(
        frequency=frequency,
        length=solution.stator.length,
        pieces=surface_pieces(solution),
        phase_velocity=float(speed),
        surface_ratio=float(abs(np.mean(shape[0] / shape[1]))),
        admittance=wired.admittance,
        comb_voltage_per_volt=complex(wired.voltages[driven]),
        power_input=wired.power,
        power_dissipated=float("nan"),
        power_radiated=float("nan"),
        power_residual=float("nan"),
        relative_error=float("inf"),
        admittance_error=float("inf"),
        unknowns=columns * resolution.order * section.size,
        resolution=f"order {resolution.order}, {resolution.edge_layers} edge layers",
        seconds=0.0,
        left_out=_left_out(solution),
        solution=solution,
    )


def _left_out(solution: Solution) -> tuple[str, ...]:
    present = fields(solution.stator.solid)
    reasons = []
    if "uy" not in present:
        reasons.append("out-of-plane displacement: uncoupled in this orientation")
    if solution.section.odd is not None:
        reasons.append("half of the guided-mode problem: x -> -x is a symmetry of this orientation")
    if solution.stator.above == "none":
        reasons.append("field in the vacuum above: D_n = 0 on the bare surface")
    reasons.append("elements in the uniform stretches: sums of guided modes instead")
    reasons.append("interior field: only the surface was asked for")
    return tuple(reasons)
