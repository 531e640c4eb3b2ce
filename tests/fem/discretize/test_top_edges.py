"""The upper boundary of a mesh: the higher of two boundary edges above each other, straight and curved."""

import numpy as np
import pytest

from fem.discretize.quad_elements import QuadSpace, TopEdges
from fem.mesh.quad_mesh import QuadMesh

CORNERS = [[0.0, -0.2], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0]]
# bottom arched, top hollow: 0.05 apart at x = 1/2
CURVED = [[0.0, -0.5], [1.0, -0.5], [1.0, 0.0], [0.0, 0.0], [0.5, -0.2], [1.0, -0.25], [0.5, -0.15], [0.0, -0.25]]


@pytest.mark.parametrize("points", [CORNERS, [*CURVED, [0.5, -0.175]]], ids=["wedge", "curved"])
@pytest.mark.parametrize("turned", [1, -1], ids=["edges forwards", "edges backwards"])
def test_the_upper_boundary_is_the_higher_edge(points, turned):
    """One element whose lower edge rises towards one end or its middle; the upper one runs from x = 1 to 0."""
    boundary = np.array([[0, 1], [1, 2], [2, 3], [3, 0]])[:, ::turned]
    mesh = QuadMesh(
        points=np.array(points), quads=np.arange(len(points))[None], solids=np.array(["s"]), lines={}, boundary=boundary
    )
    space, x = QuadSpace(mesh, 3, 1.0), np.linspace(0.05, 0.95, 10)
    numbers, values = TopEdges(space).at(x)
    top = space.edge_numbers(np.array([[2, 3][::turned]]))
    assert np.array_equal(numbers, np.repeat(top, len(x), axis=0))
    assert values == pytest.approx(space.edge_values(1 - x if turned == 1 else x), abs=1e-12)
