"""Shape functions of the elements that a file may hold, on the reference triangle and the reference square.

Triangle: corners (0, 0), (1, 0), (0, 1).  Square: corners (0, 0), (1, 0), (1, 1), (0, 1).  Nodes in the order of gmsh
and meshio: corners, then the middles of the edges in turn, then the centre.
"""

import numpy as np

CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}
TRIANGLE = np.array([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]])
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])


def reference_corners(kind: str) -> np.ndarray:
    """Corners of the reference element of a kind, shape (corners, 2)."""
    return TRIANGLE if CORNERS[kind] == 3 else SQUARE


def shape_functions(kind: str, at: np.ndarray) -> np.ndarray:
    """Values of the nodal functions of a kind of element at reference positions (m, 2), shape (m, nodes)."""
    x, y = np.asarray(at, dtype=float).T
    if kind == "triangle":
        return np.stack([1 - x - y, x, y], axis=1)
    if kind == "triangle6":
        w = 1 - x - y
        corners = [w * (2 * w - 1), x * (2 * x - 1), y * (2 * y - 1)]
        return np.stack([*corners, 4 * w * x, 4 * x * y, 4 * y * w], axis=1)
    if kind == "quad":
        return np.stack([(1 - x) * (1 - y), x * (1 - y), x * y, (1 - x) * y], axis=1)
    across, along = (np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)], axis=1) for t in (x, y))
    numbers = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1), (1, 1)]
    nine = np.stack([across[:, i] * along[:, j] for i, j in numbers], axis=1)
    if kind == "quad9":
        return nine
    # without the centre: its value is half the sum of the middles less a quarter of that of the corners
    return nine[:, :8] + nine[:, 8:] * np.array([-0.25] * 4 + [0.5] * 4)
