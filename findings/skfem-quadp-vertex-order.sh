#!/usr/bin/env bash
# scikit-fem 12.0.2: ElementQuadP(p) on quadrilaterals whose lists of vertices begin at different corners.
# Guess:     a mesh of the same quadrilaterals gives the same space, as with ElementQuad2: a cubic is projected exactly.
# Behaviour: from order 3 on the odd functions of an edge change sign with the direction in which an element runs along it,
#            and neighbours are not made to agree. The space is discontinuous; nothing is said.
# Output seen: L2 error of a projected cubic, order 3, 4, 5: 7.5e-16, 1.5e-15, 2.7e-15 where all elements begin at the same
#            corner, 7.9e-4, 5.6e-4, 4.6e-4 where they begin at different ones.
# Source:    scikit-fem, ElementQuadP.
# Here:      every element of a meshed piece is split so that all edges run vertex, middle, centre.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet scikit-fem==12.0.2
cd "$folder" && v/bin/python - <<'PYTHON'
import numpy as np
from skfem import Basis, BilinearForm, ElementQuadP, Functional, LinearForm, MeshQuad, solve


def cubic(x):
    return x[0] ** 3 - 2 * x[0] * x[1] ** 2


def error(mesh, order):
    basis = Basis(mesh, ElementQuadP(order), intorder=2 * order + 4)
    mass = BilinearForm(lambda u, v, w: u * v).assemble(basis)
    load = LinearForm(lambda v, w: cubic(w.x) * v).assemble(basis)
    square = Functional(lambda w: (w["u"] - cubic(w.x)) ** 2)
    return np.sqrt(square.assemble(basis, u=basis.interpolate(solve(mass, load))))


mesh = MeshQuad.init_tensor(np.linspace(0, 1, 3), np.linspace(0, 1, 3))
rolled = mesh.t.copy()
for k in range(rolled.shape[1]):
    rolled[:, k] = np.roll(rolled[:, k], k)
turned = MeshQuad(mesh.p, rolled)
for order in (3, 4, 5):
    same, different = error(mesh, order), error(turned, order)
    print(order, same, different)
    assert same < 1e-12
    assert different > 1e-4
PYTHON
