#!/usr/bin/env bash
# gmsh 4.15.2 with Mesh.SaveAll = 1: a mesh with a physical group, written in format 2.2 and in format 4.1.
# Guess:     elements that belong to a group keep its number, and the others get none.
# Behaviour: in format 2.2 every element is written with group 0, also those that have one; the names of the groups are in
#            the file all the same. Format 4.1 keeps the groups with the entities.
# Output seen: groups of the triangles in 2.2: [0] with SaveAll, [1] without
# Source:    gmsh reference manual, "MSH file format version 2 (Legacy)" and option Mesh.SaveAll.
# Here:      a mesh with elements in no group is refused, and the sentence names Mesh.SaveAll.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet gmsh==4.15.2
cd "$folder" && v/bin/python - <<'PYTHON'
from pathlib import Path

import gmsh

gmsh.initialize()
gmsh.option.setNumber("General.Verbosity", 0)
surface = gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
gmsh.model.occ.synchronize()
gmsh.model.addPhysicalGroup(2, [surface], 1, name="stator")
gmsh.model.mesh.generate(2)
gmsh.option.setNumber("Mesh.MshFileVersion", 2.2)
groups = {}
for everything in (0, 1):
    gmsh.option.setNumber("Mesh.SaveAll", everything)
    gmsh.write("plate.msh")
    text = Path("plate.msh").read_text()
    lines = text.split("$Elements\n")[1].splitlines()[1:]
    triangles = [line.split() for line in lines if len(line.split()) > 4 and line.split()[1] == "2"]
    groups[everything] = sorted({int(words[3]) for words in triangles})
    assert '"stator"' in text
gmsh.finalize()
print(groups)
assert groups == {0: [1], 1: [0]}
PYTHON
