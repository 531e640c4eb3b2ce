"""Evaluation of a solution: sums of modes in the segments, recovered fields in the pieces.

Nothing is solved here.  The cascade keeps, for each of its excitations e (volts, newtons per metre), the amplitudes A_e
of the modes that go right at the start x_0 of every segment, B_e of those that go left at its stop x_1, and the sides
s_e (both lines and the potentials) of every piece (`fem.waveguide.port_fields.PortFields`).  With the weights w_e of a
solution (`fem.results.stator_solution.Solution`) the field of a segment is

    u(x, z) = sum_i a_i v_i(z) exp(-i k_i (x - x_0)) + sum_j b_j w_j(z) exp(-i k_j (x - x_1)),
    a = sum_e A_e w_e,      b = sum_e B_e w_e,                                                       (1)

v_i and w_j the shapes of the modes going right and left, and that of a piece follows from its sides,

    s = sum_e s_e w_e,      u = piece.recover(s).                                                     (2)

An end that is a piece has one line, where (1) gives its unknowns: u_end = u(x_0) on the left, u(x_1) on the right.

Example: one mode, k = 2 pi, a segment of length 0.25 (a quarter of its wave) with a = 1 and b = 0: u goes from v to
-i v, and a piece behind it has u_left = -i v plus what it sends back.
"""

from collections.abc import Callable

import numpy as np

from fem.condense.element_column import ColumnField
from fem.results.stator_solution import Solution
from fem.results.surface import CondensedPiece, Surface, UniformSegment
from fem.waveguide.end_conditions import Beyond, Wall
from fem.waveguide.guided_modes import GuidedModes
from fem.waveguide.scattering_network import SegmentWaves

ENDS = (-1, -2)  # "scatterer" numbers of the left and the right end where they are condensed pieces


def surface_of(solution: Solution, solve: Callable[[], Solution] | None = None) -> Surface:
    """Motion of the surface; ``solve`` computes the solution again for the columns, so that it need not be stored."""
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
    fields = solution.fields
    network, length, unit = fields.network, fields.stator.length, fields.section.length_unit
    segments = [[_segment(solution, part) for part in parts] for parts in fields.segments]

    def condensed(start: float, stop: float, index: int, **rest) -> CondensedPiece:
        origin = start if np.isfinite(start) else stop

        def motion_in_metres(inside) -> Callable[[np.ndarray], np.ndarray]:
            return lambda x: inside.motion((x - origin) / unit)

        return CondensedPiece(
            start=start, stop=stop, recover=lambda: motion_in_metres(recovered(solve(), index)), index=index, **rest
        )

    pieces: list = [*segments[0]]
    for index, scatterer in enumerate(network.scatterers):
        start, transducer = network.positions[index], fields.owners[index] is not None
        stop = start + scatterer.piece.width
        pieces += [condensed(start * unit, stop * unit, index, transducer=transducer), *segments[index + 1]]
    for side, wall in enumerate(network.ends):
        if not isinstance(wall, Wall):
            continue
        beside = segments[-side][-side]
        meshed = fields.stator.placement.ends[side] if fields.stator.pieces else None
        span = (0.0, beside.start) if side == 0 else (beside.stop, length)
        if meshed is not None:
            low, high = meshed.extent
            span = (low, beside.start) if side == 0 else (beside.stop, high)
        piece = condensed(*span, ENDS[side], beside=None if meshed else beside, transducer=False)
        outside = [] if wall.beyond is None else [_beyond(solution, side, length, wall.beyond)]
        pieces = [*outside, piece, *pieces] if side == 0 else [*pieces, piece, *outside]
    return tuple(pieces)


def _beyond(solution: Solution, side: int, length: float, outside: Beyond) -> UniformSegment:
    """Surface of the stator of another thickness behind a step, with the waves that leave there."""
    unit, modes, line = solution.fields.section.length_unit, outside.modes, outside.far_line @ end_line(solution, side)
    right, left = (np.zeros(len(line), dtype=complex) for _ in range(2))
    if side:
        right = modes.right_amplitudes(line)
    else:
        left = modes.left_amplitudes(line)
    position = outside.position
    start, stop = (position, max(length / unit, position)) if side else (min(0.0, position), position)
    return _uniform(modes, unit, start, stop, right, left, beyond=True)


def _segment(solution: Solution, part: SegmentWaves) -> UniformSegment:
    amplitudes = part.right @ solution.weights, part.left @ solution.weights
    return _uniform(solution.fields.modes, solution.fields.section.length_unit, part.start, part.stop, *amplitudes)


def _uniform(
    modes: GuidedModes,
    unit: float,
    start: float,
    stop: float,
    right: np.ndarray,
    left: np.ndarray,
    beyond: bool = False,
) -> UniformSegment:
    """Equation (1) in metres; ``unit``: the length unit of ``start``, ``stop`` and the modes, m."""
    return UniformSegment(
        start=start * unit,
        stop=stop * unit,
        right=right,
        left=left,
        wavenumbers=modes.wavenumbers / unit,
        backwards=modes.backwards / unit,
        right_shapes=modes.section.surface_rows @ modes.right,
        left_shapes=modes.section.surface_rows @ modes.left,
        rayleigh=modes.rayleigh,
        beyond=beyond,
    )


def end_line(solution: Solution, side: int) -> np.ndarray:
    """Unknowns of the line where the uniform stator meets an end that is a condensed piece."""
    modes = solution.fields.modes
    part = solution.fields.segments[-side][-side]
    position = part.stop if side else part.start
    right, left = (each(modes, position) @ solution.weights for each in (part.right_at, part.left_at))
    # the mode k = 0 is the constant potential: without the part that leaves the end it refers to the transducer
    (left if side else right)[modes.wavenumbers == 0] = 0.0
    return modes.right @ right + modes.left @ left


def wall_of(solution: Solution, side: int) -> Wall:
    """The left (0) or right (1) end, which is a condensed piece; a TypeError for another."""
    wall = solution.fields.network.ends[side]
    if not isinstance(wall, Wall):
        raise TypeError("the end is no condensed piece")
    return wall


def recovered(solution: Solution, index: int):
    """Field inside a scatterer or an end (`ENDS`): `fem.condense.cascade_piece.RecoveredField`."""
    network = solution.fields.network
    if index in ENDS:
        side = ENDS.index(index)
        return wall_of(solution, side).recover(end_line(solution, side))
    return network.scatterers[index].piece.recover(solution.sides(index))


def left_edge(solution: Solution, index: int) -> float:
    """Left edge of a scatterer, or of an end that is a condensed piece, m."""
    network, unit = solution.fields.network, solution.fields.section.length_unit
    if index not in ENDS:
        return network.positions[index] * unit
    side = ENDS.index(index)
    ends = solution.fields.stator.placement.ends
    if side == 0:
        return 0.0 if ends[0] is None else ends[0].extent[0]
    return network.stop * unit


def columns_in_order(
    solution: Solution, index: int, of: Callable[[ColumnField, np.ndarray], np.ndarray]
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Columns of a transducer or an end from left to right: left edges and widths (m), fields (columns, ...).

    ``of``: recovery and sides of some columns -> their fields, shape (..., columns).
    """
    unit = solution.fields.section.length_unit
    starts, widths, values = recovered(solution, index).in_order(of)
    return left_edge(solution, index) + starts * unit, widths * unit, values
