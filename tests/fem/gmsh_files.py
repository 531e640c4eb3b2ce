"""Files as gmsh writes them, formats 2.2 and 4.1 as text, from entities that may be in several groups or in none."""

from pathlib import Path
from typing import NamedTuple

import numpy as np

CODES = {"line": 1, "triangle": 2, "quad": 3, "line3": 8, "triangle6": 9}


class Entity(NamedTuple):
    """A curve or a surface of gmsh with its elements."""

    groups: tuple[str, ...]  # names of its physical groups
    kind: str  # of its elements
    nodes: list  # of its elements, numbers from 0


def write(path: Path, version: str, points, entities: list[Entity], *, save_all: bool = False) -> Path:
    """Write a file; ``points`` (n, 2); ``save_all``: as Mesh.SaveAll = 1 does, also elements in no group."""
    names = dict.fromkeys((_dim(each), name) for each in entities for name in each.groups)
    number = {key: k for k, key in enumerate(names, start=1)}
    text = ["$MeshFormat", f"{version} 0 8", "$EndMeshFormat", "$PhysicalNames", str(len(number))]
    text += [f'{dim} {k} "{name}"' for (dim, name), k in number.items()] + ["$EndPhysicalNames"]
    kept = [each for each in entities if each.groups or save_all]
    body = _body_22(points, kept, number, save_all) if version == "2.2" else _body_41(points, entities, kept, number)
    path.write_text("\n".join([*text, *body, ""]))
    return path


def _dim(entity: Entity) -> int:
    return 1 if entity.kind.startswith("line") else 2


def _body_22(points, entities, number, save_all):
    """Nodes and elements of format 2.2: an element of two groups stands twice, with SaveAll all have the group 0."""
    rows = []
    for tag, each in enumerate(entities, start=1):
        for group in [0] if save_all else [number[_dim(each), name] for name in each.groups]:
            rows += [f"{CODES[each.kind]} 2 {group} {tag} {' '.join(str(k + 1) for k in row)}" for row in each.nodes]
    nodes = [f"{k} {x!r} {z!r} 0" for k, (x, z) in enumerate(np.asarray(points, float).tolist(), start=1)]
    elements = [f"{k} {row}" for k, row in enumerate(rows, start=1)]
    return [
        *("$Nodes", str(len(nodes)), *nodes, "$EndNodes"),
        *("$Elements", str(len(elements)), *elements, "$EndElements"),
    ]


def _body_41(points, entities, kept, number):
    """Entities, nodes and elements of format 4.1, where an entity lists its groups."""
    counts = [sum(_dim(each) == dim for each in entities) for dim in (1, 2)]
    text = ["$Entities", f"0 {counts[0]} {counts[1]} 0"]
    for tag, each in sorted(enumerate(entities, start=1), key=lambda pair: _dim(pair[1])):
        groups = [number[_dim(each), name] for name in each.groups]
        text.append(f"{tag} 0 -9 0 9 0 0 {len(groups)} {' '.join(map(str, groups))} 0")
    count = len(points)
    text += ["$EndEntities", "$Nodes", f"1 {count} 1 {count}", f"2 1 0 {count}"]
    text += [str(k + 1) for k in range(count)] + [f"{x!r} {z!r} 0" for x, z in np.asarray(points, float).tolist()]
    total = sum(len(each.nodes) for each in kept)
    text += ["$EndNodes", "$Elements", f"{len(kept)} {total} 1 {total}"]
    element = 0
    for tag, each in enumerate(entities, start=1):
        if each not in kept:
            continue
        text.append(f"{_dim(each)} {tag} {CODES[each.kind]} {len(each.nodes)}")
        for row in each.nodes:
            element += 1
            text.append(f"{element} {' '.join(str(k + 1) for k in row)}")
    return [*text, "$EndElements"]
