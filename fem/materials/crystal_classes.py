"""The crystal class that a solid's tables fit, in axes along the symmetry elements.

A table of constants is unchanged by every operation of its point group (Nye, *Physical Properties of Crystals*, 1957).
The groups are made of two generators each; the axes of the monoclinic, orthorhombic, tetragonal and hexagonal classes
may lie along any of x, y and z, those of trigonal and hexagonal ones in the plane may be exchanged.
"""

from functools import cache

import numpy as np

from fem.materials.rotation import bond_matrix
from fem.materials.solids import Solid

TABLES = ("stiffness", "coupling", "permittivity")
FITS = 0.02  # of a table's largest entry: published constants are rounded, and c66 is not always (c11 - c12)/2

_TURN = {n: np.array([[np.cos(a), -np.sin(a), 0], [np.sin(a), np.cos(a), 0], [0, 0, 1]]) for n in (2, 3, 4, 6)
         for a in (2 * np.pi / n,)}  # fmt: skip
_FLIP = {axis: np.diag([-1.0 if k == axis else 1.0 for k in range(3)]) for axis in range(3)}  # mirrors
_HALF = {axis: -flip for axis, flip in _FLIP.items()}  # turns by 180 degrees
_DIAGONAL = np.array([[0, 0, 1.0], [1, 0, 0], [0, 1, 0]])  # turn by 120 degrees about [111]
_INVERSION = -np.eye(3)
# Classes of different tables of c, e and eps: number of operations and generators; others have the tables of these
_CLASSES: dict[str, tuple[int, tuple[np.ndarray, ...]]] = {
    "m3m": (48, (_TURN[4], _DIAGONAL, _INVERSION)),
    "-43m": (24, (-_TURN[4], _DIAGONAL)),
    "6/mmm": (24, (_TURN[6], _FLIP[0], _INVERSION)),
    "4/mmm": (16, (_TURN[4], _FLIP[0], _INVERSION)),
    "6mm": (12, (_TURN[6], _FLIP[0])),
    "622": (12, (_TURN[6], _HALF[0])),
    "-6m2": (12, (-_TURN[6], _FLIP[0])),
    "-3m": (12, (_TURN[3], _FLIP[0], _INVERSION)),
    "4mm": (8, (_TURN[4], _FLIP[0])),
    "422": (8, (_TURN[4], _HALF[0])),
    "-42m": (8, (-_TURN[4], _HALF[0])),
    "mmm": (8, (_FLIP[0], _FLIP[1], _FLIP[2])),
    "6": (6, (_TURN[6],)),
    "3m": (6, (_TURN[3], _FLIP[0])),
    "32": (6, (_TURN[3], _HALF[0])),
    "4": (4, (_TURN[4],)),
    "-4": (4, (-_TURN[4],)),
    "mm2": (4, (_FLIP[0], _FLIP[1])),
    "222": (4, (_HALF[0], _HALF[1])),
    "2/m": (4, (_HALF[2], _FLIP[2])),
    "3": (3, (_TURN[3],)),
    "2": (2, (_HALF[2],)),
    "m": (2, (_FLIP[2],)),
}
LEAST = 3  # operations of a group that says more of a table than one mirror or axis of two


@cache
def _settings() -> list[tuple[str, int, list[np.ndarray]]]:
    """Classes with their numbers of operations and their generators in all settings, the largest first."""
    axes = [np.linalg.matrix_power(_DIAGONAL, k) for k in range(3)]
    axes += [each @ _TURN[4].T for each in axes]
    return [(name, size, [q @ g @ q.T for g in own]) for name, (size, own) in _CLASSES.items() for q in axes]


def _group(generators: list[np.ndarray]) -> list[np.ndarray]:
    """Return all operations that products of the generators give."""
    group, known = [np.eye(3)], set()
    for one in group:
        for other in generators:
            product = one @ other
            key = tuple((np.round(product, 3) + 0.0).ravel())
            if key not in known:
                known.add(key)
                group.append(product)
    return group[1:]  # the identity is among them


def tables_of(solid: Solid) -> tuple[np.ndarray, ...]:
    """Stiffness, coupling and permittivity over their largest entries."""
    tables = (solid.stiffness, solid.coupling, solid.permittivity)
    return tuple(each / (abs(each).max() or 1.0) for each in tables)


def crystal_class(tables: tuple[np.ndarray, ...]) -> tuple[str, int]:
    """Return the class of most operations that tables fit, and the number of these; "1" and 1 where there is none."""
    for name, size, generators in _settings():
        if all(_misfit(tables, operation) <= FITS for operation in generators):
            return name, size
    return "1", 1


def nearest_class(tables: tuple[np.ndarray, ...]) -> tuple[str, str, tuple[int, int], float]:
    """Return the class that tables fit best, and their entry that is farthest from it.

    Returns
    -------
    tuple
        Name; "stiffness", "coupling" or "permittivity"; indices from 1; the difference over the table's largest entry.
    """
    found = []
    for name, operations, generators in _settings():
        if operations < LEAST:
            continue
        turned = [_turned(tables, operation) for operation in _group(generators)]
        means = [np.mean([each[k] for each in turned], axis=0) for k in range(3)]
        apart = [abs(table - mean) for table, mean in zip(tables, means, strict=True)]
        which = int(np.argmax([each.max() for each in apart]))
        i, j = np.unravel_index(np.argmax(apart[which]), apart[which].shape)
        found.append((float(apart[which].max()), name, TABLES[which], (int(i) + 1, int(j) + 1)))
    size, name, table, entry = min(found, key=lambda each: round(each[0], 9))
    return name, table, entry, size


def _turned(tables: tuple[np.ndarray, ...], operation: np.ndarray) -> tuple[np.ndarray, ...]:
    stiffness, coupling, permittivity = tables
    bond = bond_matrix(operation)
    return bond @ stiffness @ bond.T, operation @ coupling @ bond.T, operation @ permittivity @ operation.T


def _misfit(tables: tuple[np.ndarray, ...], operation: np.ndarray) -> float:
    return max(
        float(abs(turned - table).max()) for turned, table in zip(_turned(tables, operation), tables, strict=True)
    )
