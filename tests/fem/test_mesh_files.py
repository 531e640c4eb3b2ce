"""Meshes of gmsh: groups, files that are cut off, and what other readers lose of them."""

import io
from contextlib import redirect_stdout

import meshio
import numpy as np
import pytest

from fem.mesh.section_mesh import MeshError, read_mesh
from tests.fem.gmsh_files import Entity, write

VERSIONS = ("2.2", "4.1")
SECTIONS = ("MeshFormat", "PhysicalNames", "Entities", "Nodes", "Elements")
CORNERS = [(0, -2), (1, -2), (2, -2), (2, 0), (1, 0), (0, 0)]
LEFT, RIGHT = Entity(("left",), "line", [(5, 0)]), Entity(("right",), "line", [(2, 3)])
TOP = Entity((), "line", [(3, 4), (4, 5)])
FIRST, SECOND = [(0, 1, 5), (1, 4, 5)], [(1, 2, 4), (2, 3, 4)]


def block(*, first=("stator",), second=("stator",), top=()):
    """Two squares side by side of two triangles each, between x = 0 and 2, z = -2 and 0."""
    surfaces = [Entity(first, "triangle", FIRST), Entity(second, "triangle", SECOND)]
    return [LEFT, RIGHT, TOP._replace(groups=top), *surfaces]


def refused(path) -> str:
    with pytest.raises(MeshError) as error:
        read_mesh(path, 1e-3)
    return str(error.value)


def second_order(triangles, lines):
    """Points and nodes of a mesh of second order with straight edges: the middles follow the corners."""
    points, middles = list(CORNERS), {}

    def middle(one, other):
        key = min(one, other), max(one, other)
        if key not in middles:
            middles[key] = len(points)
            points.append(tuple(np.mean([CORNERS[one], CORNERS[other]], axis=0)))
        return middles[key]

    finer = [(a, b, c, middle(a, b), middle(b, c), middle(c, a)) for a, b, c in triangles]
    return points, finer, [(a, b, middle(a, b)) for a, b in lines]


@pytest.mark.parametrize("version", VERSIONS)
def test_a_file_of_all_elements(version, tmp_path):
    """Mesh.SaveAll writes elements in no group: said so, where meshio 5.3.5 refuses the file in format 4.1."""
    path = write(tmp_path / "all.msh", version, CORNERS, block(), save_all=True)
    said = refused(path)
    assert "the file has elements in no physical group: put every surface into a group, and save without " in said
    if version == "4.1":
        with pytest.raises(ValueError, match="Incompatible cell data 'gmsh:physical'"):
            meshio.read(path)
    read_mesh(write(path, version, CORNERS, block()), 1e-3)


@pytest.mark.parametrize("version", VERSIONS)
def test_elements_in_two_groups(version, tmp_path):
    """One sentence in both formats, for surfaces and for lines; 2.2 holds such an element twice, 4.1 once."""
    path = write(tmp_path / "two.msh", version, CORNERS, block(second=("strip", "stator")))
    assert refused(path) == '"two.msh": the surface at (1.50, -1.00) mm is in two groups, stator and strip'
    path = write(tmp_path / "two.msh", version, CORNERS, block(top=("surface", "grounded")))
    assert refused(path) == '"two.msh": the line at (1.00, 0.00) mm is in two groups, surface and grounded'


@pytest.mark.parametrize("version", VERSIONS)
def test_files_that_are_cut_off(version, tmp_path):
    """A file that ends anywhere before its last number is refused with the section where it ends."""
    whole = write(tmp_path / "whole.msh", version, CORNERS, block()).read_text()
    path, seen = tmp_path / "cut.msh", []
    for end in range(len("$MeshFormat"), whole.index("$EndElements"), 7):
        path.write_text(whole[:end])
        said = refused(path)
        assert "cut off" in said
        seen.append(next(name for name in SECTIONS if f", ${name}" in said or f"is ${name}" in said))
        assert f"\n${seen[-1]}" in f"\n{whole[:end]}"
    assert seen == sorted(seen, key=whole.index)
    assert seen[-1] == "Elements"


@pytest.mark.parametrize("version", VERSIONS)
def test_named_lines_of_second_order(version, tmp_path):
    """Kept here; scikit-fem 12.0.2 (skfem.Mesh.load) drops all of them: "Failure to parse tags from meshio"."""
    import skfem

    points, triangles, (left, right) = second_order([*FIRST, *SECOND], [(5, 0), (2, 3)])
    entities = [
        Entity(("left",), "line3", [left]), Entity(("right",), "line3", [right]),
        Entity(("stator",), "triangle6", triangles),
    ]  # fmt: skip
    path = write(tmp_path / "second.msh", version, points, entities)
    mesh = read_mesh(path, 1.0)
    assert {name: mesh.points[nodes].tolist() for name, nodes in mesh.lines.items()} == {
        "left": [[[0.0, 0.0], [0.0, -2.0]]],
        "right": [[[2.0, -2.0], [2.0, 0.0]]],
    }
    other = skfem.Mesh.load(path)
    assert other.nelements == 4
    assert not other.boundaries


@pytest.mark.parametrize("version", VERSIONS)
def test_triangles_and_quadrilaterals(version, tmp_path):
    """Both kept here; scikit-fem 12.0.2 (skfem.Mesh.load) reads one of the two kinds and says nothing."""
    import skfem

    entities = [LEFT, RIGHT, Entity(("stator",), "triangle", FIRST), Entity(("stator",), "quad", [(1, 2, 3, 4)])]
    path = write(tmp_path / "mixed.msh", version, CORNERS, entities)
    mesh = read_mesh(path, 1.0)
    assert {each.kind: len(each.nodes) for each in mesh.cells} == {"triangle": 2, "quad": 1}
    assert set(mesh.lines) == {"left", "right"}
    assert skfem.Mesh.load(path).nelements < 3


def test_groups_on_the_way_to_vtu(tmp_path):
    """The names are lost in meshio 5.3.5: only .msh is read here."""
    entities = [LEFT, Entity(("stator",), "triangle", FIRST), Entity(("strip",), "triangle", SECOND)]
    path = write(tmp_path / "groups.msh", "2.2", CORNERS, entities)
    assert read_mesh(path, 1.0).solids == ("stator", "strip")
    vtu = tmp_path / "groups.vtu"
    with redirect_stdout(io.StringIO()):
        meshio.read(path).write(vtu)
    written = meshio.read(vtu)
    assert (written.field_data, written.cell_sets) == ({}, {})
    assert "the file is no mesh of gmsh, format 2.2 or 4.1" in refused(vtu)
