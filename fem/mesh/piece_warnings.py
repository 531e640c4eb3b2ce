"""Warnings about errors of a drawing that no finer discretisation of the same file can show or reduce."""

import numpy as np

from fem.mesh.mesh_piece import MeshPiece
from fem.mesh.quad_mesh import STRAIGHT, conditions_of, singular_vertices
from fem.mesh.section_mesh import SectionMesh

NEAR_INTERFACE = 1 / 8  # wavelengths: at 0.12 the admittance errs by 1e-5, at a third by 6e-7
# An arc is drawn by at least ARC_VERTICES neighbouring vertices at which the boundary turns to the same side, by less
# than MAX_TURN each.  A chamfer or a trapezoidal groove has two such vertices.
ARC_VERTICES, MAX_TURN = 3, np.deg2rad(50)
# Relative change of the motion over k^2 A, with k the wavenumber of the slowest bulk wave and A the area between an arc
# and its edges: 0.09 to 0.43 behind three grooves on PZT-4 whose bottom is an arc, drawn by 4, 8 and 16 edges
# (tests/fem/test_pieces.py has one of them); 0.04 to 0.16 behind grooves 0.8 mm wide and 0.05 or 0.2 mm deep on PZT-5H
# along X and on lithium niobate, 128YX and YZ.
ARC_CHANGE = 0.5
LEAST_ARC_CHANGE = 1e-6  # a smaller one is below the error of the finest discretisation


def corner_warnings(piece: MeshPiece, bottom: str, wavelength: float) -> list[str]:
    """Warn of singular corners near an interface, whose field the section's line cannot resolve.

    ``wavelength``: of the slowest bulk wave, m.
    """
    result = []
    corners = piece.mesh.points[sorted(singular_vertices(piece.mesh, conditions_of(piece, bottom)))]
    for side in ("left", "right"):
        line = piece.mesh.interface(side)
        if line is None or not len(corners):
            continue
        distance = float(abs(corners[:, 0] - line[0]).min())
        if distance < NEAR_INTERFACE * wavelength:
            result.append(
                f'piece "{piece.name}": a corner stands {distance * 1e3:.3g} mm from the interface {side}, nearer '
                f"than an eighth of a wavelength ({NEAR_INTERFACE * wavelength * 1e3:.3g} mm): its field is cut off "
                "there, which costs 1e-5 of the answer or more; draw the piece wider"
            )
    return result


def arc_warnings(piece: MeshPiece, wavelength: float) -> list[str]:
    """Warn of arcs that the file draws by straight edges: their sagitta, and the change of u_z that it makes.

    ``wavelength``: of the slowest bulk wave, m.
    """
    sagittas, lengths = _arc_edges(piece.mesh)
    area = float(np.sum(2 / 3 * sagittas * lengths))
    change = ARC_CHANGE * (2 * np.pi / wavelength) ** 2 * area
    if change < LEAST_ARC_CHANGE:
        return []
    worst = float(sagittas.max())
    return [
        f'piece "{piece.name}": straight edges of up to {lengths[sagittas.argmax()] * 1e3:.3g} mm draw an arc, with a '
        f"sagitta of {worst * 1e6:.2g} um ({worst / wavelength:.1g} wavelengths): u_z changes by about {change:.1e} of "
        "itself, which no stated error contains; draw elements of second order (gmsh -order 2) or shorter edges"
    ]


def _arc_edges(mesh: SectionMesh) -> tuple[np.ndarray, np.ndarray]:
    """Sagittas and lengths in m of the straight edges on the boundary that stand for arcs.

    An edge of length L between vertices at which the boundary turns by t is the chord of an arc of radius L / t, whose
    sagitta is L t / 8.
    """
    if any(cells.kind not in ("triangle", "quad") for cells in mesh.cells):
        return np.zeros(1), np.zeros(1)
    following = dict(mesh.boundary)
    vectors = {start: mesh.points[stop] - mesh.points[start] for start, stop in mesh.boundary}
    turns: dict[int, float] = {}
    for before, here in mesh.boundary:
        one, other = vectors[before], vectors[here]
        turn = float(np.arctan2(one[0] * other[1] - one[1] * other[0], one @ other))
        if STRAIGHT < abs(turn) < MAX_TURN:
            turns[here] = turn
    arc_edges: list[tuple[float, float]] = []
    firsts = [here for before, here in mesh.boundary if here in turns and turns.get(before, 0.0) * turns[here] <= 0]
    for here in firsts:
        arc = [here]
        while turns.get(following[arc[-1]], 0.0) * turns[here] > 0:
            arc.append(following[arc[-1]])
        if len(arc) >= ARC_VERTICES:
            inner = [float(np.linalg.norm(vectors[vertex])) for vertex in arc[:-1]]
            mean_turn = float(np.mean([abs(turns[vertex]) for vertex in arc]))
            # the first and the last edge, which end at a corner or where the arc does, are as long as the others
            arc_edges += [(length * mean_turn / 8, length) for length in (inner[0], *inner, inner[-1])]
    return tuple(np.array(arc_edges or [(0.0, 0.0)]).T)
