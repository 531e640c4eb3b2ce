"""Evaluation of a solution: amplitudes of the modes in the segments, nodal values in the columns of elements."""

from collections.abc import Callable

import numpy as np

from fem.condense.join import alike_columns
from fem.condense.recovery import ColumnField
from fem.condense.superelement import Superelement
from fem.results.solution import Solution
from fem.results.surface import MeshedPiece, Surface, UniformSegment
from fem.waveguide.ends import Walls

ENDS = (-1, -2)  # "transducer" numbers of the left and the right end where they are columns of elements


def surface_of(solution: Solution, solve: Callable[[], Solution] | None = None) -> Surface:
    """Motion of the surface; ``solve`` returns the solution again, for the columns, if it is not to be kept."""
    fields = solution.fields
    modes, section = fields.modes, fields.section
    surface = modes.rayleigh
    shape = section.surface_rows @ modes.right[:, surface]
    speed = 2 * np.pi * modes.frequency * section.length_unit / np.mean(modes.wavenumbers[surface].real)
    return Surface(
        frequency=modes.frequency,
        length=fields.stator.length,
        pieces=_pieces(solution, solve or (lambda: solution)),
        phase_velocity=float(speed),
        surface_ratio=float(abs(np.mean(shape[0] / shape[1]))),
    )


def _pieces(solution: Solution, solve: Callable[[], Solution]) -> tuple:
    """Pieces of the surface from left to right, in m and m per volt."""
    network = solution.fields.network
    unit = solution.fields.section.length_unit
    segments = [_segment(solution, index) for index in range(len(network.scatterers) + 1)]

    def meshed(start: float, stop: float, index: int, beside: UniformSegment | None = None) -> MeshedPiece:
        return MeshedPiece(
            start=start, stop=stop, beside=beside, recover=lambda: _surface_columns(solve(), index)
        )

    pieces: list = []
    for index, segment in enumerate(segments):
        if index:
            pieces.append(meshed(segments[index - 1].stop, segment.start, index - 1))
        pieces.append(segment)
    if isinstance(network.ends, Walls):
        width = network.ends.width * unit
        pieces.insert(0, meshed(0.0, width, ENDS[0], segments[0]))
        length = solution.fields.stator.length
        pieces.append(meshed(length - width, length, ENDS[1], segments[-1]))
    return tuple(pieces)


def _segment(solution: Solution, index: int) -> UniformSegment:
    fields = solution.fields
    modes, section, unit = fields.modes, fields.section, fields.section.length_unit
    start, stop = fields.network.segments[index]
    right, left = _amplitudes(solution, index)
    return UniformSegment(
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


def _amplitudes(solution: Solution, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes of a segment's modes: going right at its start, going left at its stop."""
    modes, network, n = solution.fields.modes, solution.fields.network, solution.fields.section.size
    length = np.diff(network.segments[index])[0]
    last = len(network.scatterers)
    right = left = np.zeros(n, dtype=complex)
    if index > 0:
        out = solution.sides(index - 1)[n : 2 * n] - solution.incoming(index - 1)[n:]
        right = modes.right_amplitudes(out)
    if index < last:
        out = solution.sides(index)[:n] - solution.incoming(index)[:n]
        left = modes.left_amplitudes(out)
    if network.ends != "absorbing" and index == 0:
        right = _reflected(network, 0, left * np.exp(1j * modes.backwards * length))
    if network.ends != "absorbing" and index == last:
        left = _reflected(network, 1, right * np.exp(-1j * modes.wavenumbers * length))
    return right, left


def _reflected(network, side, at_end):
    arriving, sent = network.reflections[side]
    return sent @ at_end[arriving]


def _superelement(solution: Solution, index: int) -> tuple[Superelement, np.ndarray, float]:
    """Superelement of a transducer or of an end (`ENDS`), its sides, and where it begins in length units."""
    modes, network = solution.fields.modes, solution.fields.network
    if index not in ENDS:
        return network.scatterers[index].superelement, solution.sides(index), network.places[index]
    side = ENDS.index(index)
    right, left = _amplitudes(solution, len(network.scatterers) if side else 0)
    here, stop = network.segments[-side]
    if side:
        right, left = right * np.exp(-1j * modes.wavenumbers * (stop - here)), left.copy()
    else:
        right, left = right.copy(), left * np.exp(1j * modes.backwards * (stop - here))
    (left if side else right)[modes.wavenumbers == 0] = (
        0.0  # a matter of gauge: the potential refers to the transducer
    )
    line = modes.right @ right + modes.left @ left
    superelement, sides = network.ends.recover(side, line)
    return superelement, sides, stop if side else 0.0


def column_fields(solution: Solution, index: int):
    """Columns of a transducer or of an end by kind: (recovery, left edges in m, sides (2 n + 2, places))."""
    unit = solution.fields.section.length_unit
    superelement, sides, begin = _superelement(solution, index)
    kinds: dict[tuple, tuple] = {}
    for part, starts, own in alike_columns(superelement, sides, begin):
        column, places, found = kinds.setdefault((part.width, part.column.electrode), (part.column, [], []))
        places.append(starts * unit)
        found.append(own)
    for column, places, found in kinds.values():
        yield ColumnField(column), np.concatenate(places), np.concatenate(found, axis=-1)


def columns_in_row(
    solution: Solution, index: int, of: Callable[[ColumnField, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a transducer or an end from left to right: left edges and widths (m), fields (columns, ...).

    ``of``: recovery and sides of some columns -> their fields, shape (..., columns).
    """
    starts, widths, values = [], [], []
    for recovery, left, sides in column_fields(solution, index):
        starts.append(left)
        widths.append(np.full(len(left), recovery.column.width * solution.fields.section.length_unit))
        values.append(np.moveaxis(of(recovery, sides), -1, 0))
    in_row = np.argsort(np.concatenate(starts))
    return tuple(np.concatenate(each)[in_row] for each in (starts, widths, values))


def _surface_columns(solution: Solution, index: int) -> tuple[np.ndarray, np.ndarray]:
    """Edges of the columns of a transducer or an end (m), and u_x and u_z at their surface nodes, left to right."""
    start, width, motion = columns_in_row(solution, index, ColumnField.surface_motion)
    return np.append(start, start[-1] + width[-1]), motion
