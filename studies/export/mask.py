"""The mask of a scene's transducers: polygons on named layers, snapped to the grid of the lithography.

Each transducer has two combs. The busbar of the comb "+" lies on the upper side of the transducer (the +y side at an
angle of 0), the busbar of the comb "-" on the lower side. The fingers of both combs overlap along the aperture, and
each finger ends one gap before the busbar of the other comb. A pad touches the outer edge of each busbar. Where layers
lie on the fingers, each pad has an opening through them, for a second mask. Open strips ("o") have no busbar. Crosses
mark the corners of the chip. The outline of the chip has a separate layer. As in the scene, x is measured from the left
end of the chip and y from its centre line.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from math import cos, radians, sin
from typing import Any

import numpy as np

import fem
from fem.parameters import refuses
from studies.model.resolve import build
from studies.refusal import SceneError, nearest
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value
from studies.scene.stator_keys import Transducer

LAYERS = {"fingers": 1, "busbars": 2, "pads": 3, "openings": 4, "marks": 10, "outline": 20}
# in periods: largest default side of a pad, and smallest distance of a pad from the edge of the chip
PAD_PERIODS, CLEAR_PERIODS = 4.0, 0.5
OPENING = 0.9  # side of an opening over that of its pad, which thus covers its edges if the two masks are displaced
MIN_GRID_STEPS = 10  # of the lithography's grid across the narrowest finger
SHOWN_SPANS = 3  # grooves and strips that the warning lists


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Dimensions of a mask in m that a scene does not contain. None selects the default for each transducer."""

    busbar: float | None = None  # width of a busbar; by default one period
    # from a finger's end to the other comb's busbar or dummy finger; by default the gap of two fingers
    end_gap: float | None = None
    pad: float | None = None  # side of a square pad, 0 for none; by default four periods, less if the chip is too small
    mark: float = 2e-4  # length of an alignment cross, 0 for none
    margin: float = 3e-4  # distance from the centre of a cross to the edges of the chip
    grid: float = 5e-9  # of the lithography; the coordinates of all corners are multiples of it

    @classmethod
    def read(cls, settings: list[str]) -> "Sizes":
        """Return the sizes from settings ``key=value``, such as ``busbar="0.5 mm"``."""
        keys, values = [each.name for each in fields(cls)], {}
        for setting in settings:
            key, equals, text = (part.strip() for part in setting.partition("="))
            if not equals or key not in keys:
                raise SceneError("--size", f"must be KEY=VALUE, got {setting!r}{nearest(key, keys)}")
            rule = Quantity("m", zero=key in ("pad", "mark"))
            values[key] = rule.read(f"size.{key}", toml_value(text))
        return cls(**values)


@dataclass(frozen=True, kw_only=True)
class Polygon:
    """One polygon of a mask."""

    layer: str  # a key of LAYERS
    transducer: str  # name of the transducer; empty for marks and outline
    comb: str  # "+", "-", "o" or empty
    corners: np.ndarray = field(repr=False)  # shape (k, 2), m; in cyclic order, snapped to the grid


@dataclass(frozen=True, kw_only=True)
class Mask:
    """All polygons of a scene, and the errors due to snapping."""

    title: str
    polygons: tuple[Polygon, ...] = field(repr=False)
    grid: float
    transducers: tuple[str, ...]
    length: float
    width: float
    shift: float  # largest displacement of a corner in x or y by snapping, m
    width_error: float  # largest change of a finger width by snapping, m
    gap: float  # smallest distance of neighbouring fingers after snapping, m
    left_out: str = ""  # a sentence on parts of meshed pieces that the mask does not contain


def mask(scene: Scene, sizes: Sizes | None = None) -> Mask:
    """Return the mask of a scene with transducers.

    Raises
    ------
    SceneError
        If there is no transducer, a part lies outside the chip, the grid is coarser than a tenth of a finger, combs
        touch, or a mesh of the whole stator has other fingers than the transducers' blocks, from which the mask is
        drawn.
    """
    sizes = Sizes() if sizes is None else sizes
    if not scene.transducer:
        scene.refuse("transducer", "is missing: a mask draws transducers")
    model = build(scene)
    resolved = model.scene
    for difference in model.stator.other_fingers(model.transducers):
        raise SceneError("transducer", f"must have the fingers of the mesh, as a mask follows the block: {difference}")
    length, width = resolved.stator.length, resolved.stator.width
    exact = [each for block in resolved.transducer for each in _transducer(block, sizes, length, width)]
    _refuse_coarse_grid(exact, sizes.grid)
    polygons = [replace(each, corners=_snapped(each.corners, sizes.grid)) for each in exact]
    _refuse_outside(polygons, length, width, sizes)
    _refuse_contact(polygons)
    polygons += [replace(each, corners=_snapped(each.corners, sizes.grid)) for each in _marks(length, width, sizes)]
    _refuse_covered_marks(polygons)
    box = np.array([[0.0, -width / 2], [length, -width / 2], [length, width / 2], [0.0, width / 2]])
    polygons.append(Polygon(layer="outline", transducer="", comb="", corners=_snapped(box, sizes.grid)))
    shifts = [float(np.abs(new.corners - old.corners).max()) for new, old in zip(polygons, exact, strict=False)]
    return Mask(
        title=resolved.title or "untitled", polygons=tuple(polygons), grid=sizes.grid,
        transducers=tuple(block.name for block in resolved.transducer), length=length, width=width, shift=max(shifts),
        left_out=_left_out(model.stator), **_finger_errors(resolved.transducer, exact, polygons),
    )  # fmt: skip


def _left_out(stator: fem.Stator) -> str:
    """Return a sentence on the grooves, strips and electrodes of meshed pieces, which have no extent along y."""
    combs = () if stator.placement.whole is None else ("+", "-", "o")  # of a whole stator's mesh they are drawn
    spans = [f"{low * 1e3:.5g} to {high * 1e3:.5g} mm" for each in stator.pieces for low, high in each.gaps]
    electrodes = [name for each in stator.pieces for name in each.mesh.electrodes
                  if not each.connection(name).endswith(combs)]  # fmt: skip
    if not (spans or electrodes):
        return ""
    shown = ", ".join(spans[:SHOWN_SPANS] + ["..."] * (len(spans) > SHOWN_SPANS))
    parts = [f"grooves and strips ({shown})"] * bool(spans) + [f"electrodes ({len(electrodes)})"] * bool(electrodes)
    return f"the mask leaves out {' and '.join(parts)} of meshed pieces: a scene states no extent along y of them"


def _transducer(block: Transducer, sizes: Sizes, length: float, width: float) -> Iterator[Polygon]:
    """Yield the polygons of a transducer before snapping."""
    edges, signs = block.finger_edges, block.signs
    half_aperture = block.aperture / 2
    narrowest = (edges[1:, 0] - edges[:-1, 1]).min()
    gap = float(narrowest) if sizes.end_gap is None else sizes.end_gap
    busbar = block.wavelength if sizes.busbar is None else sizes.busbar
    first, last = float(edges[0, 0]), float(edges[-1, 1])

    along, across = _axes(block)

    def polygon(layer: str, comb: str, left: float, right: float, low: float, high: float) -> Polygon:
        box = np.array([[left, low], [right, low], [right, high], [left, high]])
        if layer == "fingers":  # of a slanted transducer all places along the wave grow with y
            box[:, 0] *= 1.0 + block.slant * box[:, 1] / block.aperture
        corners = np.array(block.center_xy) + box @ np.array([along, across])
        return Polygon(layer=layer, transducer=block.name, comb=comb, corners=corners)

    overlaps = block.overlaps or (1.0,) * len(signs)
    for (left, right), sign, overlap in zip(edges.tolist(), signs, overlaps, strict=True):
        # overlap with the busbar, so that rounding cannot separate finger and busbar
        extension = gap + busbar / 2
        low, high = half_aperture + extension * (sign == "-"), half_aperture + extension * (sign == "+")
        # a gap about the tip, where the beam's model has it (`fem.beam.own_aperture.tips`), then a dummy finger of the
        # other comb; a finger beyond whose tip half a gap does not fit goes to the end
        tip = overlap * half_aperture
        ends_before = tip + gap / 2 < half_aperture
        end = tip - gap / 2 if ends_before else half_aperture
        if sign == "+":
            yield polygon("fingers", "+", left, right, -end, high)
        elif sign == "-":
            yield polygon("fingers", "-", left, right, -low, end)
        elif sign == "o":
            yield polygon("fingers", "o", left, right, -low, high)
        outer = half_aperture + extension
        if sign in "+-" and ends_before:
            ends = (tip + gap / 2, outer) if sign == "-" else (-outer, -tip - gap / 2)
            yield polygon("fingers", "+" if sign == "-" else "-", left, right, *ends)
    reach = 1.0 + abs(block.slant) * (half_aperture + gap + busbar) / block.aperture
    first, last = reach * first, reach * last
    for sign, side_sign in (("+", 1.0), ("-", -1.0)):
        if sign not in signs:
            continue
        inner, outer = half_aperture + gap, half_aperture + gap + busbar
        yield polygon("busbars", sign, first, last, *sorted((side_sign * inner, side_sign * outer)))
        side = sizes.pad
        if side is None:
            side = min(PAD_PERIODS * block.wavelength, last - first, _pad_room(block, side_sign, outer, length, width))
        if side > 0.0:
            yield polygon("pads", sign, -side / 2, side / 2, *sorted((side_sign * outer, side_sign * (outer + side))))
            if block.plane != "surface":
                half, middle = OPENING * side / 2, side_sign * (outer + side / 2)
                yield polygon("openings", sign, -half, half, middle - half, middle + half)


def _axes(block: Transducer) -> tuple[np.ndarray, np.ndarray]:
    """Return the unit vectors along a transducer's wave and along its fingers, exact for multiples of 90 deg."""
    angle = radians(block.angle % 360)
    c, s = (each if abs(each) > 1e-12 else 0.0 for each in (cos(angle), sin(angle)))
    return np.array([c, s]), np.array([-s, c])


def _pad_room(block: Transducer, side_sign: float, outer: float, length: float, width: float) -> float:
    """Return the largest side of a pad in m that keeps the clearance from the edge of the chip."""
    direction = side_sign * _axes(block)[1]
    edges = np.array([[0.0, length], [-width / 2, width / 2]])
    distances = [
        (edges[axis, int(direction[axis] > 0)] - block.center_xy[axis]) / direction[axis]
        for axis in (0, 1)
        if direction[axis] != 0.0
    ]
    return max(min(distances) - outer - CLEAR_PERIODS * block.wavelength, 0.0)


def _marks(length: float, width: float, sizes: Sizes) -> Iterator[Polygon]:
    if sizes.mark == 0.0:
        return
    a, b = sizes.mark / 2, sizes.mark / 20
    cross = [(-a, -b), (-b, -b), (-b, -a), (b, -a), (b, -b), (a, -b), (a, b), (b, b), (b, a), (-b, a), (-b, b), (-a, b)]
    for x in (sizes.margin, length - sizes.margin):
        for y in (sizes.margin - width / 2, width / 2 - sizes.margin):
            yield Polygon(layer="marks", transducer="", comb="", corners=np.array(cross) + np.array([x, y]))


@refuses(SceneError)
def _refuse_coarse_grid(polygons: list[Polygon], grid: float) -> Iterator[Any]:
    """Refuse a grid on which a finger's edges would move by a twentieth of its width or more."""
    edges = [np.diff(each.corners, axis=0, append=each.corners[:1]) for each in polygons if each.layer == "fingers"]
    narrowest = min(float(np.hypot(*each.T).min()) for each in edges)
    if grid > narrowest / MIN_GRID_STEPS:
        yield (
            "size.grid",
            f"must be at most a tenth of the narrowest finger, {narrowest / MIN_GRID_STEPS * 1e6:.4g} um, "
            f"got {grid * 1e6:.4g} um",
        )


def _snapped(corners: np.ndarray, grid: float) -> np.ndarray:
    return np.round(corners / grid) * grid


@refuses(SceneError)
def _refuse_outside(polygons, length: float, width: float, sizes: Sizes) -> Iterator[Any]:
    for each in polygons:
        (left, low), (right, high) = each.corners.min(axis=0), each.corners.max(axis=0)
        if left < 0.0 or right > length or low < -width / 2 or high > width / 2:
            rule = (
                f"must leave its parts on the chip, 0 to {length * 1e3:g} mm by +-{width * 500:g} mm: the {each.layer} "
                f"of {each.transducer!r} reach from x = {left * 1e3:.6g} to {right * 1e3:.6g} mm and y = "
                f"{low * 1e3:.6g} to {high * 1e3:.6g} mm; smaller "
                "size.busbar, size.pad or size.end_gap help"
            )
            yield "transducer", rule


@refuses(SceneError)
def _refuse_contact(polygons) -> Iterator[Any]:
    """Raise an error if polygons of different combs touch."""
    polygons = sorted(polygons, key=lambda each: each.corners[:, 0].min())
    low, high = (np.array([end(each.corners, axis=0) for each in polygons]) for end in (np.min, np.max))
    owner = [(each.transducer, each.comb, k if each.comb == "o" else -1) for k, each in enumerate(polygons)]
    boxes_touch = np.all((low[:, None] <= high) & (high[:, None] >= low), axis=2)
    for k, other in np.argwhere(np.triu(boxes_touch, 1)):
        one, two = polygons[k], polygons[other]
        if owner[k] != owner[other] and not apart(one.corners, two.corners):
            names = " and ".join(f"{each.layer} {each.comb} of {each.transducer!r}" for each in (one, two))
            yield "transducer", f"{names} touch: smaller size.pad, size.busbar or size.grid help"


@refuses(SceneError)
def _refuse_covered_marks(polygons) -> Iterator[Any]:
    marks = [each for each in polygons if each.layer == "marks"]
    for mark in marks:
        box = np.array([mark.corners.min(axis=0), mark.corners.max(axis=0)])
        corners = np.array([box[0], [box[1, 0], box[0, 1]], box[1], [box[0, 0], box[1, 1]]])
        for each in polygons:
            if each.layer not in ("marks", "outline") and not apart(corners, each.corners):
                rule = f"must leave the marks free of the {each.layer} of {each.transducer!r}; 0 draws none"
                yield "size.mark", rule


def apart(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two convex polygons, shapes (k, 2), are disjoint, by the separating axis theorem."""
    for corners in (one, other):
        sides = np.roll(corners, -1, axis=0) - corners
        for normal in np.stack([sides[:, 1], -sides[:, 0]], axis=1):
            a, b = one @ normal, other @ normal
            if a.max() < b.min() or b.max() < a.min():
                return True
    return False


def _finger_errors(blocks, exact, polygons) -> dict[str, float]:
    """Return the largest error of a finger width and the smallest gap after snapping, m.

    ``exact``: the polygons before snapping, in the same order.
    """
    worst, smallest = 0.0, np.inf
    for block in blocks:
        of_block = [
            pair for pair in zip(exact, polygons, strict=False)
            if pair[0].transducer == block.name and pair[0].layer == "fingers"
        ]  # fmt: skip
        for y in (-block.aperture / 2, block.aperture / 2):  # between which the sides are straight
            pairs = [tuple(_edges_at(each.corners, block, y) for each in pair) for pair in of_block]
            worst = max(worst, max(abs(np.ptp(snapped) - np.ptp(drawn)) for drawn, snapped in pairs))
            edges = sorted(snapped for _, snapped in pairs)
            # a finger and its dummy have the same edges
            gaps = [b[0] - a[1] for a, b in pairwise(edges) if b[0] - a[0] > 0.5 * (a[1] - a[0])]
            smallest = min([smallest, *gaps])
    return {"width_error": float(worst), "gap": float(smallest)}


def _edges_at(corners: np.ndarray, block: Transducer, y: float) -> tuple[float, float]:
    """Return where the sides of a finger are along the wave, m, at a distance y from the middle of its transducer."""
    along, across = _axes(block)
    u, v = corners @ along, (corners - np.array(block.center_xy)) @ across
    left, right = (u[a] + (u[b] - u[a]) * (y - v[a]) / (v[b] - v[a]) for a, b in ((0, 3), (1, 2)))
    return float(left), float(right)
