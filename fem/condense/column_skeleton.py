"""A column of elements condensed to its sides and the plane of the fingers.

The unknowns inside an element, then those on the faces between elements, are eliminated.  A homogeneous column is its
own mirror image, so that even and odd fields are eliminated apart where x -> -x is a symmetry of the solid
(`fem.condense.mirror_pairs`).
"""

from collections.abc import Callable
from functools import lru_cache, partial
from typing import NamedTuple

import numpy as np

from fem.condense.cascade_piece import ELECTRODES, Blocks
from fem.condense.elimination import schur
from fem.condense.mirror_pairs import MirrorPairs
from fem.discretize.element_matrices import combined, element_matrix, element_parts
from fem.discretize.section import FIELD_COLUMN, Section
from fem.materials.medium import Medium


class ElementSets:
    """Indices of an element's unknowns, ``fields`` at each node: on its four edges, all of these, inside."""

    def __init__(self, order: int, fields: int):
        grid = np.arange((order + 1) ** 2 * fields).reshape(order + 1, order + 1, fields)
        self.left, self.right = grid[0].reshape(-1), grid[-1].reshape(-1)
        self.bottom, self.top = grid[1:-1, 0].reshape(-1), grid[1:-1, -1].reshape(-1)
        self.inside = grid[1:-1, 1:-1].reshape(-1)
        self.rim = np.concatenate([self.left, self.right, self.bottom, self.top])


class Skeleton(NamedTuple):
    """A column condensed to its sides, two empty ports and its surface; the same with and without an electrode.

    ``faces`` are those of `fem.condense.element_column.Column`.  The matrices that functions return are needed only
    where the field inside is recovered.
    """

    matrix: np.ndarray
    faces: np.ndarray
    # to the faces below and above the surface from the unknowns of ``matrix``
    faces_from: Callable[[], np.ndarray]
    # by kind of element (height, medium): to its inside from its boundary
    inside_from: dict[tuple, Callable[[], np.ndarray]]


def column_skeleton(section: Section, frequency: float, width: float) -> Skeleton:
    """Condense a column, its width in length units, to its sides and the plane of the fingers."""
    sides = Blocks(section.size).ports.start + len(ELECTRODES)
    faces = _face_dofs(section, first=sides)
    count = int(max(faces.max(initial=-1), sides - 1)) + 1
    # the unknowns in the plane of the fingers come first of all faces
    outer = sides + np.count_nonzero(faces[section.plane // section.order] >= 0)
    angular, odd = 2 * np.pi * frequency * section.length_unit, section.odd
    if odd is None:
        return _condensed(section, angular, width, faces, count, outer)
    return _condensed_by_parity(section, angular, width, faces, outer, _column_pairs(section, faces, count, odd))


def _condensed(section: Section, angular: float, width: float, faces: np.ndarray, count: int, outer: int) -> Skeleton:
    """Skeleton of ``count`` unknowns, of which the first ``outer`` are kept; ``angular`` as in `element_matrix`."""
    matrix = np.zeros((count, count), dtype=_dtype(section))
    done: dict[tuple, np.ndarray] = {}
    inside_from: dict[tuple, Callable[[], np.ndarray]] = {}
    for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
        kind = element_kind(height, medium)
        if kind not in done:
            sets = ElementSets(section.order, len(medium.fields))
            full = element_matrix(medium, width, height, section.order, angular)
            done[kind], back = schur(full, sets.rim, sets.inside)
            inside_from[kind] = partial(np.asarray, back)
        dofs = element_dofs(section, element, faces)
        exists = np.flatnonzero(dofs >= 0)
        matrix[np.ix_(dofs[exists], dofs[exists])] += done[kind][np.ix_(exists, exists)]
    matrix, back = schur(matrix, np.arange(outer), np.arange(outer, count))
    return Skeleton(matrix, faces, partial(np.asarray, back), inside_from)


def _condensed_by_parity(
    section: Section, angular: float, width: float, faces: np.ndarray, outer: int, whole: MirrorPairs
) -> Skeleton:
    """`_condensed` of the unknowns ``whole`` where x -> -x is a symmetry of the solid."""
    odd_fields = _odd_fields(section.dofs, whole.signs < 0)
    kept, dropped = whole.part(slice(0, outer)), whole.part(slice(outer, None))
    matrices = [np.zeros((len(chosen), len(chosen)), dtype=_dtype(section)) for chosen in whole.chosen]
    places = whole.places
    done: dict[tuple, list[np.ndarray]] = {}
    inside_from: dict[tuple, Callable[[], np.ndarray]] = {}
    for element, (height, medium) in enumerate(zip(section.heights, section.media, strict=True)):
        kind = element_kind(height, medium)
        own = _element_parities(
            medium, section.order, tuple(odd_fields[[FIELD_COLUMN[name] for name in medium.fields]])
        )
        if kind not in done:
            both = [combined(parts, width, height, angular) for parts in own.parts]
            done[kind], back = _eliminated(both, own.pairs, len(own.rim.images))
            inside_from[kind] = partial(own.inside.joined, back, own.rim)
        dofs = element_dofs(section, element, faces)
        for matrix, place, chosen, each in zip(matrices, places, own.rim.chosen, done[kind], strict=True):
            exists = np.flatnonzero(dofs[chosen] >= 0)
            at = place[dofs[chosen[exists]]]
            matrix[at[:, None], at] += each[exists[:, None], exists]
    reduced, back = _eliminated(matrices, whole, outer)
    return Skeleton(kept.joined(reduced, kept), faces, partial(dropped.joined, back, kept), inside_from)


def _eliminated(parts, pairs: MirrorPairs, kept: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Schur complements of both parities onto the first unknowns, and the matrices from these to the others."""
    both = [
        schur(part, np.flatnonzero(chosen < kept), np.flatnonzero(chosen >= kept))
        for part, chosen in zip(parts, pairs.chosen, strict=True)
    ]
    return [reduced for reduced, _ in both], [back for _, back in both]


def _dtype(section: Section) -> np.dtype:
    return np.result_type(section.heights, *(medium.xx for medium in section.media))


def _odd_fields(dofs: np.ndarray, odd: np.ndarray) -> np.ndarray:
    """True for the fields u_x, u_y, u_z and phi that change sign; ``dofs``: of a line, ``odd``: of its unknowns."""
    return np.array([np.any(odd[column[column >= 0]]) for column in dofs.T])


def _column_pairs(section: Section, faces: np.ndarray, count: int, odd: np.ndarray) -> MirrorPairs:
    """Unknowns of a skeleton: those of the left line and of the right one, two empty ports, those of the faces.

    ``odd``: of the unknowns of a line.
    """
    at, images, odd_ones = Blocks(section.size), np.arange(count), np.zeros(count, dtype=bool)
    images[at.left], images[at.right] = images[at.right].copy(), images[at.left].copy()
    odd_ones[at.left] = odd_ones[at.right] = odd
    exists = faces >= 0
    images[faces[exists]] = faces[:, ::-1][exists]
    odd_ones[faces[exists]] = np.broadcast_to(_odd_fields(section.dofs, odd), faces.shape)[exists]
    return MirrorPairs(images, odd_ones)


class _Parities(NamedTuple):
    """Unknowns of an element, those on its edges first, and its matrices by parity."""

    pairs: MirrorPairs
    rim: MirrorPairs  # those on its edges
    inside: MirrorPairs
    parts: tuple[np.ndarray, ...]  # of even and of odd fields: `element_parts`, shape (4, n, n)


@lru_cache(maxsize=32)
def _element_parities(medium: Medium, order: int, odd_fields: tuple[bool, ...]) -> _Parities:
    """Parities of an element of any size; ``odd_fields``: of its medium's fields."""
    sets = ElementSets(order, len(odd_fields))
    at = np.concatenate([sets.rim, sets.inside])
    place = np.argsort(at)  # of each unknown in this order
    shape = (order + 1, order + 1, len(odd_fields))
    mirrored = np.arange(len(at)).reshape(shape)[::-1].reshape(-1)
    odd = np.broadcast_to(odd_fields, shape).reshape(-1)
    pairs, count = MirrorPairs(place[mirrored[at]], odd[at]), len(sets.rim)
    split = [pairs.split(each[np.ix_(at, at)]) for each in element_parts(medium, order)]
    parts = tuple(np.stack([0.5 * (part + part.T) for part in each]) for each in zip(*split, strict=True))
    return _Parities(pairs, pairs.part(slice(0, count)), pairs.part(slice(count, None)), parts)


def element_kind(height: complex, medium: Medium) -> tuple:
    """Key of an element: elements with equal keys have equal matrices."""
    return round(complex(height).real, 12), round(complex(height).imag, 12), id(medium)


def element_dofs(section: Section, element: int, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of an element in the order left, right, bottom, top; -1 where there is none."""
    n, order = section.size, section.order
    columns = [FIELD_COLUMN[name] for name in section.media[element].fields]
    line = section.dofs[element * order : (element + 1) * order + 1][:, columns].reshape(-1)
    other = np.where(line >= 0, line + n, -1)
    below, above = (faces[element + side][:, columns].reshape(-1) for side in (0, 1))
    return np.concatenate([line, other, below, above])


def _face_dofs(section: Section, *, first: int) -> np.ndarray:
    """Unknowns on the faces between elements: a node on a face has the fields of the line's node at that height.

    They are numbered from ``first`` on, those in the plane of the fingers before all others.
    """
    exists = section.dofs[:: section.order] >= 0
    exists = np.repeat(exists[:, None, :], section.order - 1, axis=1)
    plane_first = np.argsort(np.arange(len(exists)) != section.plane // section.order, kind="stable")
    numbers = np.cumsum(exists[plane_first]).reshape(exists.shape) + first - 1
    dofs = np.empty(exists.shape, dtype=int)
    dofs[plane_first] = np.where(exists[plane_first], numbers, -1)
    return dofs


def electrode_dofs(section: Section, faces: np.ndarray) -> np.ndarray:
    """Skeleton unknowns of phi in the plane of the fingers: left corner, right corner, nodes between."""
    corner = section.finger_potential
    if corner is None:
        raise ValueError("the plane of the fingers has no potential")
    between = faces[section.plane // section.order][:, FIELD_COLUMN["phi"]]
    return np.concatenate([[corner, corner + section.size], between])
