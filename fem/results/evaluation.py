"""The surface read off a solution: amplitudes of the modes in the stretches, nodal values under the fingers."""

from functools import partial

import numpy as np

from fem.condense.join import lines, widths
from fem.condense.recovery import ColumnField
from fem.discretize.section import Section
from fem.geometry import Stator
from fem.results.surface import Covered, Stretch, SurfaceWave
from fem.solution import Solution


def surface_wave(solution: Solution) -> SurfaceWave:
    """Surface motion of a solution; its errors and powers are yet to be found (infinite and NaN)."""
    modes, section, wired = solution.modes, solution.section, solution.circuit
    surface = modes.rayleigh
    shape = section.surface_rows @ modes.right[:, surface]
    frequency = modes.frequency
    speed = 2 * np.pi * frequency * section.length_unit / np.mean(modes.wavenumbers[surface].real)
    resolution = solution.resolution
    columns = sum(1 for each in solution.network.scatterers for _ in widths(each.block))
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
        left_out=left_out(solution.stator, section, frequency),
        solution=solution,
    )


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
            right = _returned(network, 0, left * np.exp(1j * modes.backwards * (stop - start)))
        if network.ends != "absorbing" and index == last:
            left = _returned(network, 1, right * np.exp(-1j * modes.wavenumbers * (stop - start)))
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


def _returned(network, side, at_end):
    arriving, sent = network.reflections[side]
    return sent @ at_end[arriving]


def column_fields(solution: Solution, index: int):
    """Columns of a transducer by kind: (recovery, left edges in m, sides (2 n + 2, places))."""
    unit = solution.section.length_unit
    kinds: dict[tuple, tuple] = {}
    for start, part, sides in _columns(solution, index):
        column, starts, found = kinds.setdefault((part.width, part.column.comb), (part.column, [], []))
        starts.append(start * unit)
        found.append(sides)
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


def left_out(stator: Stator, section: Section, frequency: float) -> tuple[str, ...]:
    """What a driven stator is solved without at a frequency in Hz, and why."""
    reasons = []
    if "uy" not in section.solid.fields:
        reasons.append("out-of-plane displacement: uncoupled in this orientation")
    if section.odd is not None:
        reasons.append("half of the guided-mode problem: x -> -x is a symmetry of this orientation")
    if stator.above == "none":
        reasons.append("field in the vacuum above: D_n = 0 on the bare surface")
    speed = section.surface_speed
    if speed is not None and stator.thickness < speed / frequency:
        reasons.append(
            "a Rayleigh wave: the plate is thinner than a wavelength, what is named so is a plate mode"
        )
    reasons.append("elements in the uniform stretches: sums of guided modes instead")
    reasons.append("interior field: only the surface was asked for")
    return tuple(reasons)
