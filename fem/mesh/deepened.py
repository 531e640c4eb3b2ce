"""A mesh continued downwards by quadrilaterals, as a half-space goes on below what the user has drawn."""

from dataclasses import replace

import numpy as np

from fem.mesh.section_mesh import SAME, Cells, SectionMesh
from fem.mesh.shape_functions import SQUARE, shape_functions


def deepened(mesh: SectionMesh, depth: float, largest: float) -> SectionMesh:
    """Continue a mesh from its foot to a depth by quadrilaterals of the stator's material.

    The lines of the groups left and right go on; the group bottom ends.

    Parameters
    ----------
    mesh : SectionMesh
    depth : float
        m; at least that of the mesh.
    largest : float
        Largest height of a new quadrilateral, m.
    """
    foot, x = mesh.foot, mesh.points[mesh.foot, 0]
    top = float(mesh.points[foot, 1].mean())
    lines = {name: nodes for name, nodes in mesh.lines.items() if name != "bottom"}
    if depth + top <= SAME * depth:
        return replace(mesh, lines=lines)
    count = int(np.ceil((depth + top) / largest - 1e-9))
    levels = np.linspace(top, -depth, count + 1)[1:]
    vertices = np.append(foot[:, 0], foot[-1, 1])
    across = np.append(x[:, 0], x[-1, 1])
    made = len(mesh.points) + np.arange(count * len(vertices)).reshape(count, -1)
    grid = np.vstack([vertices, made])
    points = [mesh.points, np.stack(np.meshgrid(across, levels), axis=-1).reshape(-1, 2)]
    corners = np.stack([grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:], grid[:-1, :-1]], axis=-1).reshape(-1, 4)
    kind = "quad"
    if any(cells.kind not in ("triangle", "quad") for cells in mesh.cells):
        kind = "quad8"  # straight edges, with their middles
        at = np.concatenate(points)[corners]
        middles = np.einsum("mn,enk->emk", shape_functions("quad", (SQUARE + np.roll(SQUARE, -1, axis=0)) / 2), at)
        numbers = len(mesh.points) + made.size + np.arange(4 * len(corners)).reshape(-1, 4)
        points.append(middles.reshape(-1, 2))
        corners = np.hstack([corners, numbers])
    for side, column in (("left", grid[:, 0]), ("right", grid[:, -1])):
        if side in lines:
            lines[side] = np.concatenate([lines[side], np.stack([column[:-1], column[1:]], axis=1)])
    return replace(
        mesh,
        points=np.concatenate(points),
        cells=(*mesh.cells, Cells(kind=kind, solid="stator", nodes=corners)),
        lines=lines,
    )
