"""Remarks about a user's table of constants: a class that it does not fit, a known solid from which it differs.

`limits` refuses what no solid has. What is remarked here is possible, and probably a mistake.
"""

import re
from collections.abc import Iterator

import numpy as np

from fem.materials.crystal_classes import LEAST, TABLES, crystal_class, nearest_class, tables_of
from fem.materials.forms import ORDERS, in_order
from fem.materials.solids import Solid
from fem.materials.tables import catalogue

FAR = 0.2  # relative difference of a table from that of a solid of the same name
SAME = 0.05  # relative difference below which two tables are those of one material
NEARER = 0.4  # how much nearer a mistaken table must be than the right one


def plausibility(solid: Solid) -> Iterator[str]:
    """Yield remarks about a table of constants in the crystal's axes."""
    yield from list(_class_remarks(solid)) or list(_mistaken(solid)) or _namesake_remarks(solid)


def _class_remarks(solid: Solid) -> Iterator[str]:
    tables = tables_of(solid)
    name, size = crystal_class(tables)
    if size >= LEAST:
        return
    for order in ORDERS[1:]:
        other, operations = crystal_class((in_order(tables[0], order), in_order(tables[1], order), tables[2]))
        if operations >= LEAST:
            yield (
                f"the constants of {solid.name} fit class {other} in the order {order}, and none of that kind in "
                f'{ORDERS[0]}, as they are read: order = "{order}" reads them so'
            )
            return
    nearest, table, (i, j), apart = nearest_class(tables)
    fit = "no crystal class" if size == 1 else f"no crystal class but {name}"
    yield (
        f"the constants of {solid.name} fit {fit} with axes along x, y and z; nearest is {nearest}, from which {table} "
        f"({i}, {j}) differs by {100 * apart:.2g} % of the largest entry: a digit or a sign is wrong, or the table is "
        "already rotated to a cut, which orientation would rotate again"
    )


def _mistaken(solid: Solid) -> Iterator[str]:
    """Yield a remark for tables of a known solid of which some are those of other conditions, or one is another's."""
    found: list[tuple[float, str]] = []
    for known in catalogue().values():
        if not known.is_piezoelectric or not _near(solid.density, known.density, SAME):
            continue
        right = {key: _apart(getattr(solid, key), getattr(known, key)) for key in TABLES}
        for tables, words in _variants(known):
            wrong = {key: _apart(getattr(solid, key), table) for key, table in tables.items()}
            others = max(each for key, each in right.items() if key not in tables)
            if others < 2 * SAME and all(each < min(SAME, NEARER * right[key]) for key, each in wrong.items()):
                size = max(wrong.values())
                share = "" if size < 1e-3 else f", to {100 * size:.2g} %,"
                found.append((size, f"the {' and '.join(tables)} of {solid.name}: as of {known.name}{share} {words}"))
        far = [key for key, each in right.items() if each > FAR]
        near = max(each for key, each in right.items() if key not in far[:1])
        if len(far) == 1 and near < SAME:
            sentence = f"the {far[0]} of {solid.name} differs by {100 * right[far[0]]:.3g} % from that of {known.name}"
            # ranked behind the explanations above
            found.append((1 + near, f"{sentence}, whose other constants are the same: is a unit wrong?"))
    if found:
        yield min(found)[1]


def _variants(known: Solid) -> Iterator[tuple[dict[str, np.ndarray], str]]:
    """Yield wrong tables and words for the confusions of constants at other conditions."""
    e, eps = known.coupling, known.permittivity
    stiff = {"stiffness": known.stiffness + e.T @ np.linalg.solve(eps, e)}
    free = {"permittivity": eps + e @ np.linalg.solve(known.stiffness, e.T)}
    yield stiff, 'at constant D: stiffness_at = "constant D" converts it'
    yield free, 'at constant stress: permittivity_at = "constant stress" converts it'
    yield stiff | free, "at constant D and at constant stress: c^E and eps^S are wanted"


def _namesake_remarks(solid: Solid) -> Iterator[str]:
    """Yield a remark for a table that is far from every solid of the catalogue of its name."""
    namesakes = [each for each in catalogue().values() if _plain(each.name) == _plain(solid.name)]
    far = []
    for known in namesakes:
        apart = {key: _apart(getattr(solid, key), getattr(known, key)) for key in TABLES if getattr(known, key).any()}
        apart["density"] = abs(solid.density / known.density - 1)
        key = max(apart, key=lambda name: apart[name])
        if apart[key] <= FAR:
            return
        far.append((apart[key], key, known.name))
    if far:
        size, key, name = min(far)
        yield (
            f"the {key} of {solid.name} differs by {100 * size:.2g} % from that of {name} in the catalogue: is a unit, "
            "a form or an order of indices meant otherwise, or is the name another material's?"
        )


def _plain(name: str) -> str:
    """Return a material's name without its author, case, blanks and hyphens."""
    return re.sub(r"[\s\-_]+", "", re.sub(r"\(.*", "", name)).casefold()


def _apart(one: np.ndarray, other: np.ndarray) -> float:
    """Return the relative difference of two tables, over the norm of the other."""
    return float(np.linalg.norm(one - other) / (np.linalg.norm(other) or 1.0))


def _near(one: float, other: float, share: float) -> bool:
    return abs(one - other) <= share * other
