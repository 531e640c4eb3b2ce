"""What a file of gmsh holds, formats 2.2 and 4.1: its elements and the physical groups that they are in."""

import contextlib
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from fem.mesh.shape_functions import CORNERS
from fem.parameters import refuses

LINE_GROUPS = ("left", "right", "bottom", "grounded", "clamped", "surface")
ELECTRODE = "electrode:"
LINES = {"line": 2, "line3": 3}
SOLIDS = ("tetra", "hexahedron", "wedge", "pyramid")
SECTIONS = ("MeshFormat", "PhysicalNames", "Entities", "Nodes", "Elements", "Periodic")  # of a file of gmsh
NO_GROUP = (
    "the file has elements in no physical group: put every surface into a group, and save without Mesh.SaveAll "
    '("save all elements" in the window of gmsh)'
)


class MeshError(ValueError):
    """A file that is no mesh of a section, or one that does not fit; the sentence names the fault."""


@dataclass(frozen=True, kw_only=True)
class Cells:
    """Elements of one kind in one solid."""

    kind: str  # of meshio
    solid: str  # group of the surface
    nodes: np.ndarray = field(repr=False)  # shape (elements, nodes)


def parsed(path: Path, content: bytes):
    """The file as meshio reads it."""
    import meshio

    _check_complete(content)
    try:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            return meshio.read(path, file_format="gmsh")
    except (Exception, SystemExit) as error:
        why = " ".join(str(error).split())[:120]
        if "Incompatible cell data 'gmsh:physical'" in why:
            # meshio 5.3.5 lists the groups of the blocks that have one, fewer than there are blocks
            raise MeshError(NO_GROUP) from None
        reason = f" ({why})" if any(map(str.isalpha, why)) else ""  # an exit of meshio is a number
        raise MeshError(f"the file is no mesh of gmsh, format 2.2 or 4.1{reason}") from None


@refuses(MeshError)
def _check_complete(content: bytes) -> Iterator[Any]:
    """Refuse a file of gmsh that is cut off: every section ends with its own $End line, and one holds elements."""
    if not content.startswith(b"$MeshFormat"):
        return
    opened = re.findall(rb"^\$(%s)\s*$" % "|".join(SECTIONS).encode(), content, re.MULTILINE)
    section = opened[-1].decode() if opened else SECTIONS[0]
    ended = re.match(rb"\$End([A-Za-z]+)$", content.rstrip().rpartition(b"\n")[2].strip())
    if ended is None or (ended[1].decode() in SECTIONS and ended[1].decode() != section):
        yield f"the file is cut off: its last section, ${section}, has no line $End{section}"
    if b"Elements" not in opened:
        yield (f"the file has no section $Elements, its last is ${section}: it is cut off, or holds no mesh")


def grouped(file) -> tuple[list[Cells], dict[str, np.ndarray]]:
    """Elements by solid, and the corners of the lines by group, in the file's numbers of nodes."""
    names = {(int(dim), int(tag)): name for name, (tag, dim) in file.field_data.items()}
    tags = file.cell_data.get("gmsh:physical", [None] * len(file.cells))
    surfaces: list[Cells] = []
    lines: dict[str, list[np.ndarray]] = {}
    for index, block in enumerate(file.cells):
        kind = block.type
        if kind == "vertex":
            continue
        if kind.startswith(SOLIDS):
            raise MeshError(f"the file has {len(block.data)} {kind} elements in space: a section is a surface")
        if kind not in CORNERS and kind not in LINES:
            order = {"line4": 3, "triangle10": 3, "quad16": 3, "line5": 4, "triangle15": 4, "quad25": 4}.get(kind)
            what = f"elements of order {order}" if order else f"elements of kind {kind}"
            raise MeshError(f"{what} are not read: gmsh -order 2")
        dim = 1 if kind in LINES else 2
        for name, members in _members(file, index, tags[index], names, dim):
            nodes = np.asarray(block.data)[members].astype(int)
            if dim == 1:
                lines.setdefault(name, []).append(nodes[:, :2])
            else:
                surfaces.append(Cells(kind=kind, solid=name, nodes=nodes))
    for name in lines:
        if name not in LINE_GROUPS and not name.startswith(ELECTRODE):
            raise MeshError(f'unknown line group "{name}": {", ".join(LINE_GROUPS)} or electrode:NAME')
    if not any(each.solid == "stator" for each in surfaces):
        groups = ", ".join(dict.fromkeys(each.solid for each in surfaces)) or "none"
        raise MeshError(
            f"the file has no surface group stator, which is the stator's own material: its surface groups are {groups}"
        )
    return surfaces, {name: np.concatenate(parts) for name, parts in lines.items()}


def _members(file, index: int, tags, names: dict, dim: int):
    """Yield the groups of a block's elements and which they are; a surface in no group is refused."""
    if file.cell_sets and any(name in file.cell_sets for name in file.field_data):
        return _members_41(file, index, tags, dim)
    return _members_22(tags, names, dim)


def _members_41(file, index: int, tags, dim: int):
    """`_members` of a file in format 4.1, where the groups are sets of elements and a block lies in whole groups."""
    owners = [
        name
        for name, (_, own_dim) in file.field_data.items()
        if int(own_dim) == dim and name in file.cell_sets and len(_set(file.cell_sets[name][index]))
    ]
    for name in owners:
        yield name, slice(None)
    if not owners and tags is not None and len(tags):
        raise _nameless(dim, tags[0])


def _members_22(tags, names: dict, dim: int):
    """`_members` of a file in format 2.2, where every element has the number of its group; 0 is none.

    An element in two groups stands there twice.
    """
    tags = np.asarray([] if tags is None else tags)
    if dim == 2 and not tags.all():
        raise MeshError(NO_GROUP)
    for tag in np.unique(tags[tags != 0]):
        if (dim, int(tag)) not in names:
            raise _nameless(dim, tag)
        yield names[dim, int(tag)], tags == tag


def _nameless(dim: int, number) -> MeshError:
    return MeshError(f"a physical group of {'lines' if dim == 1 else 'surfaces'} has no name, number {number}")


def _set(members) -> np.ndarray:
    return np.empty(0) if members is None else np.asarray(members)


@refuses(MeshError)
def check_groups(
    what: str, groups: list[tuple[str, np.ndarray]], names: list[str], points: np.ndarray
) -> Iterator[Any]:
    """Refuse elements that are in two groups.

    ``groups``: names and corners (elements, corners); ``names``: of all groups, as the file orders them; ``points``: in
    m.
    """
    owners: dict[tuple[int, ...], set[str]] = {}
    for name, corners in groups:
        for element in np.sort(corners, axis=1).tolist():
            owners.setdefault(tuple(element), set()).add(name)
    several = {element: sorted(map(names.index, own)) for element, own in owners.items() if len(own) > 1}
    if several:
        first = min(several.values())
        nodes = np.unique(np.concatenate([element for element, own in several.items() if own == first]))
        named = " and ".join(names[k] for k in first)
        yield f"the {what} at {where(points[:, :2], nodes)} is in two groups, {named}"


def where(points: np.ndarray, nodes) -> str:
    """Mean position of some nodes (points in m), as text in mm."""
    x, z = points[np.atleast_1d(nodes)].mean(axis=0) * 1e3
    return f"({x:.2f}, {z:.2f}) mm"
