"""Meshes of pieces for tests: made without a mesh generator, and written as gmsh 2.2 text."""

from itertools import pairwise
from pathlib import Path

import numpy as np


def write_msh(path: Path, points, triangles: dict, lines: dict) -> Path:
    """Write a gmsh 2.2 file; ``triangles``: solid to nodes (m, 3), ``lines``: group to nodes (m, 2)."""
    groups = [(1, name) for name in lines] + [(2, name) for name in triangles]
    rows = [
        (1 if dim == 1 else 2, tag, nodes)
        for tag, (dim, name) in enumerate(groups, start=1)
        for nodes in np.asarray(lines[name] if dim == 1 else triangles[name])
    ]
    text = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(groups))]
    text += [f'{dim} {tag} "{name}"' for tag, (dim, name) in enumerate(groups, start=1)]
    text += ["$EndPhysicalNames", "$Nodes", str(len(points))]
    text += [f"{k} {x!r} {z!r} 0" for k, (x, z) in enumerate(np.asarray(points, dtype=float).tolist(), start=1)]
    text += ["$EndNodes", "$Elements", str(len(rows))]
    text += [
        f"{k} {kind} 2 {tag} {tag} " + " ".join(str(node + 1) for node in nodes)
        for k, (kind, tag, nodes) in enumerate(rows, start=1)
    ]
    path.write_text("\n".join([*text, "$EndElements", ""]))
    return path


def rectangle(
    path: Path,
    width: float,
    depth: float,
    *,
    size: float,
    groove: tuple[float, float, float] | list[tuple[float, float, float]] | None = None,
    strip: tuple[float, float, float] | None = None,
    groups=("left", "right", "bottom"),
) -> Path:
    """A plate section of irregular triangles; ``groove`` or ``strip``: left edge, width, depth or height.

    Several grooves have one depth; one that reaches the right edge is a step.
    """
    grooves = groove if isinstance(groove, list) else [groove] if groove else []
    rng = np.random.default_rng(7)
    across = np.linspace(0, width, 1 + round(width / size))
    for left, wide, _ in grooves or ([strip] if strip else []):
        across = np.unique(np.round(np.concatenate([across, [left, left + wide]]), 12))
    down = np.linspace(-depth, 0, 1 + round(depth / size))
    if grooves:
        down = np.unique(np.round(np.concatenate([down, [-grooves[0][2]]]), 12))
    up = np.append(down, strip[2]) if strip else down
    x, z = (each.ravel() for each in np.meshgrid(across, up, indexing="ij"))
    inside = (x > 0) & (x < width) & (z > -depth) & (z < (-grooves[0][2] if grooves else 0) - 1e-9)
    gap = min(np.diff(across).min(), np.diff(down).min())
    points = np.stack([x, z], axis=1) + inside[:, None] * rng.uniform(-0.2, 0.2, (len(x), 2)) * gap
    cells = []
    for i in range(len(across) - 1):
        for j in range(len(up) - 1):
            middle = (across[i] + across[i + 1]) / 2, (up[j] + up[j + 1]) / 2
            if any(a < middle[0] < a + wide and middle[1] > -deep for a, wide, deep in grooves):
                continue
            if strip and middle[1] > 0 and not strip[0] < middle[0] < strip[0] + strip[1]:
                continue
            a, b = i * len(up) + j, (i + 1) * len(up) + j
            halves = [(a, b, b + 1), (a, b + 1, a + 1)] if (i + j) % 2 else [(a, b, a + 1), (b, b + 1, a + 1)]
            cells += [("strip" if strip and middle[1] > 0 else "stator", half) for half in halves]
    solids: dict = {}
    for name, nodes in cells:
        solids.setdefault(name, []).append(nodes)
    used = np.unique([nodes for _, nodes in cells])
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    column = len(up)
    below = len(down)
    lines = {
        "left": [(j, j + 1) for j in range(below - 1)],
        "right": [
            (len(points) - column + j, len(points) - column + j + 1)
            for j in range(below - 1)
            if np.isin([len(points) - column + j, len(points) - column + j + 1], used).all()
        ],
        "bottom": [(i * column, (i + 1) * column) for i in range(len(across) - 1)],
        "electrode:strip": [
            (i * column + below - 1, (i + 1) * column + below - 1)
            for i in range(len(across) - 1)
            if strip and strip[0] < (across[i] + across[i + 1]) / 2 < strip[0] + strip[1]
        ],
    }
    return write_msh(
        path,
        points[used],
        {name: number[np.array(nodes)] for name, nodes in solids.items()},
        {name: number[np.array(lines[name])] for name in groups},
    )


def bevelled_end(path: Path, foot: float, top: float, depth: float, *, size: float, mirrored: bool = False) -> Path:
    """The right end of a plate from x = 0 on, a trapezoid: ``foot`` wide at the bottom, ``top`` at the surface.

    ``mirrored``: the left end, up to x = 0.
    """
    across, down = 1 + round(foot / size), 1 + round(depth / size)
    share, z = np.meshgrid(np.linspace(0, 1, across), np.linspace(-depth, 0, down), indexing="ij")
    x = share * (foot + (top - foot) * (1 + z / depth))
    node = np.arange(x.size).reshape(x.shape)
    a, b = node[:-1, :-1].ravel(), node[1:, :-1].ravel()
    c, d = node[1:, 1:].ravel(), node[:-1, 1:].ravel()
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    lines = {
        "right" if mirrored else "left": np.stack([node[0, :-1], node[0, 1:]], axis=1),
        "bottom": np.stack([node[:-1, 0], node[1:, 0]], axis=1),
    }
    points = np.stack([-x.ravel() if mirrored else x.ravel(), z.ravel()], axis=1)
    return write_msh(path, points, {"stator": triangles}, lines)


def profile(path: Path, top: np.ndarray, depth: float, rows: int = 3) -> Path:
    """A plate section of triangles below an upper side of straight edges through the points ``top`` (n, 2)."""
    share = np.linspace(0, 1, rows + 1)
    x, z = np.repeat(top[:, :1], rows + 1, axis=1), -depth + share * (top[:, 1:] + depth)
    node = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (each.ravel() for each in (node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]))
    triangles = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    ends = {"left": node[0], "right": node[-1], "bottom": node[:, 0]}
    lines = {name: np.stack([own[:-1], own[1:]], axis=1) for name, own in ends.items()}
    return write_msh(path, np.stack([x.ravel(), z.ravel()], axis=1), {"stator": triangles}, lines)


def chip(path: Path, length: float, depth: float, electrodes: dict, *, size: float, groups=("bottom",)) -> Path:
    """A whole plate section of triangles with strips on its surface; ``electrodes``: name to edges (n, 2)."""
    edges = np.unique(np.round(np.concatenate([[[0, length]], *electrodes.values()]), 12))
    parts = [np.linspace(a, b, 1 + max(1, round((b - a) / size)))[:-1] for a, b in pairwise(edges)]
    across, down = np.append(np.concatenate(parts), length), np.linspace(-depth, 0, 1 + round(depth / size))
    node = np.arange(len(across) * len(down)).reshape(len(across), -1)
    a, b, c, d = node[:-1, :-1], node[1:, :-1], node[1:, 1:], node[:-1, 1:]
    triangles = np.concatenate([np.stack([a, b, c], -1).reshape(-1, 3), np.stack([a, c, d], -1).reshape(-1, 3)])
    middle = (across[1:] + across[:-1]) / 2
    top, foot = (np.stack([row[:-1], row[1:]], axis=1) for row in (node[:, -1], node[:, 0]))
    lines = {
        f"electrode:{name}": top[np.any([(low < middle) & (middle < high) for low, high in strips], axis=0)]
        for name, strips in electrodes.items()
    }
    points = np.stack(np.meshgrid(across, down, indexing="ij"), axis=-1).reshape(-1, 2)
    return write_msh(path, points, {"stator": triangles}, {each: {"bottom": foot}[each] for each in groups} | lines)
