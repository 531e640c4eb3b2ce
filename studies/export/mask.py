"""The mask of a scene's transducers: polygons on named layers, snapped to the grid of the lithography.

Each transducer has two combs. The busbar of the comb "+" lies on the upper side of the transducer (the +y side at an
angle of 0), the busbar of the comb "-" on the lower side. The fingers of both combs overlap along the aperture, and
each finger ends one gap before the busbar of the other comb. A pad touches the outer edge of each busbar. Open strips
("o") have no busbar. Crosses mark the corners of the chip. The outline of the chip has a separate layer. As in the
scene, x is measured from the left end of the chip and y from its centre line.
"""

from collections.abc import Iterator
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from math import cos, radians, sin

import numpy as np

import fem
from studies.chain import fem_model, resolve
from studies.record.quantities import quantity
from studies.refusal import SceneError, nearest, needed
from studies.scene import Scene
from studies.scene.blocks import Transducer
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value

LAYERS = {"fingers": 1, "busbars": 2, "pads": 3, "marks": 10, "outline": 20}
COMBS = {"+": "plus", "-": "minus", "o": "open"}
# in periods: largest default side of a pad; distance of a pad from the edge of the chip
PAD_PERIODS, CLEAR_PERIODS = 4.0, 0.5
SHOWN_SPANS = 3  # of what meshed pieces draw, in the warning
MAX_COORDINATE = 2**31 - 1  # largest coordinate of a GDSII file, in units of its precision
GDS_PRECISION = 1e-9  # m


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Dimensions of a mask in m that a scene does not contain. None selects the default for each transducer.

    Attributes
    ----------
    busbar : float or None
        Width of a busbar; by default one period.
    end_gap : float or None
        Distance from the end of a finger to the busbar of the other comb; by default the gap between two fingers.
    pad : float or None
        Side of a square pad, 0 for none; by default four periods, or less if the chip is too small.
    mark : float
        Length of an alignment cross, 0 for none.
    margin : float
        Distance from the centre of a cross to the edges of the chip.
    grid : float
        Grid of the lithography; the coordinates of all corners are multiples of it.
    """

    busbar: float | None = None
    end_gap: float | None = None
    pad: float | None = None
    mark: float = 2e-4
    margin: float = 3e-4
    grid: float = 5e-9

    @classmethod
    def read(cls, settings: list[str]) -> "Sizes":
        """Return the sizes from settings ``key=value``, such as ``busbar="0.5 mm"``."""
        known, values = [each.name for each in fields(cls)], {}
        for setting in settings:
            key, equals, text = (part.strip() for part in setting.partition("="))
            if not equals or key not in known:
                raise SceneError("--size", f"must be KEY=VALUE, got {setting!r}{nearest(key, known)}")
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
    left_out: str = ""  # a sentence on what meshed pieces draw and the mask does not


def mask(scene: Scene, sizes: Sizes | None = None) -> Mask:
    """Return the mask of a scene with transducers.

    Raises
    ------
    SceneError
        If there is no transducer, a part lies outside the chip, or combs touch, also because of a coarse grid; if a
        mesh of the whole stator draws other fingers than the transducers' blocks, which the mask follows.
    """
    sizes = Sizes() if sizes is None else sizes
    if not scene.transducer:
        scene.refuse("transducer", "is missing: a mask draws transducers")
    resolved = resolve.resolved(scene)
    stator = fem_model.whole_stator(resolved)
    for said in stator.other_fingers(fem_model.transducers(resolved)):
        raise SceneError("transducer", f"must have the fingers of the mesh, as a mask follows the block: {said}")
    length, width = resolved.stator.length, resolved.stator.width
    exact = [each for block in resolved.transducer for each in _transducer(block, sizes, length, width)]
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
        left_out=_left_out(stator), **_finger_errors(resolved.transducer, polygons),
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
    pitch = block.wavelength / (4 if block.split else 2)
    half_aperture, finger = block.aperture / 2, block.metallisation * pitch
    gap = pitch - finger if sizes.end_gap is None else sizes.end_gap
    busbar = block.wavelength if sizes.busbar is None else sizes.busbar
    signs = block.pattern or ("++--" if block.split else "+-") * block.finger_pairs
    first = -len(signs) * pitch / 2 + (pitch - finger) / 2
    last = first + (len(signs) - 1) * pitch + finger

    def polygon(layer: str, comb: str, left: float, right: float, low: float, high: float) -> Polygon:
        angle = radians(block.angle % 360)
        # exact for multiples of 90 deg
        c, s = (each if abs(each) > 1e-12 else 0.0 for each in (cos(angle), sin(angle)))
        box = np.array([[left, low], [right, low], [right, high], [left, high]])
        corners = np.array(block.place) + box @ np.array([[c, s], [-s, c]])
        return Polygon(layer=layer, transducer=block.name, comb=comb, corners=corners)

    for k, sign in enumerate(signs):
        left = first + k * pitch
        # overlap with the busbar, so that rounding cannot separate finger and busbar
        extension = gap + busbar / 2
        low, high = half_aperture + extension * (sign == "-"), half_aperture + extension * (sign == "+")
        if sign != "0":
            yield polygon("fingers", sign, left, left + finger, -low, high)
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


def _pad_room(block: Transducer, side_sign: float, outer: float, length: float, width: float) -> float:
    """Return the largest side of a pad in m that keeps the clearance from the edge of the chip."""
    angle = radians(block.angle % 360)
    direction = side_sign * np.array([-sin(angle), cos(angle)])
    edges = np.array([[0.0, length], [-width / 2, width / 2]])
    distances = [
        (edges[axis, int(direction[axis] > 0)] - block.place[axis]) / direction[axis]
        for axis in (0, 1)
        if abs(direction[axis]) > 1e-12
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


def _snapped(corners: np.ndarray, grid: float) -> np.ndarray:
    return np.round(corners / grid) * grid


def _refuse_outside(polygons, length: float, width: float, sizes: Sizes) -> None:
    for each in polygons:
        (left, low), (right, high) = each.corners.min(axis=0), each.corners.max(axis=0)
        if left < 0.0 or right > length or low < -width / 2 or high > width / 2:
            rule = (
                f"must leave its parts on the chip, 0 to {length * 1e3:g} mm by +-{width * 500:g} mm: the {each.layer} "
                f"of {each.transducer!r} reach from x = {left * 1e3:.6g} to {right * 1e3:.6g} mm and y = "
                f"{low * 1e3:.6g} to {high * 1e3:.6g} mm; smaller "
                "size.busbar, size.pad or size.end_gap help"
            )
            raise SceneError("transducer", rule)


def _refuse_contact(polygons) -> None:
    """Raise an error if polygons of different combs touch."""
    boxes = np.array([np.concatenate([each.corners.min(axis=0), each.corners.max(axis=0)]) for each in polygons])
    owner = [(each.transducer, each.comb, k if each.comb == "o" else -1) for k, each in enumerate(polygons)]
    order = np.argsort(boxes[:, 0])
    for position, k in enumerate(order):
        later = order[position + 1 :]
        later = later[: np.searchsorted(boxes[later, 0], boxes[k, 2], side="right")]
        candidates = later[(boxes[later, 1] <= boxes[k, 3]) & (boxes[later, 3] >= boxes[k, 1])]
        for other in candidates:
            one, two = polygons[k], polygons[other]
            if owner[k] != owner[other] and not apart(one.corners, two.corners):
                names = " and ".join(f"{each.layer} {each.comb} of {each.transducer!r}" for each in (one, two))
                rule = f"{names} touch: smaller size.pad, size.busbar or size.grid help"
                raise SceneError("transducer", rule)


def _refuse_covered_marks(polygons) -> None:
    marks = [each for each in polygons if each.layer == "marks"]
    for mark in marks:
        box = np.array([mark.corners.min(axis=0), mark.corners.max(axis=0)])
        corners = np.array([box[0], [box[1, 0], box[0, 1]], box[1], [box[0, 0], box[1, 1]]])
        for each in polygons:
            if each.layer not in ("marks", "outline") and not apart(corners, each.corners):
                rule = f"must leave the marks free of the {each.layer} of {each.transducer!r}; 0 draws none"
                raise SceneError("size.mark", rule)


def apart(one: np.ndarray, other: np.ndarray) -> bool:
    """Return whether two convex polygons, shapes (k, 2), are disjoint, by the separating axis theorem."""
    for corners in (one, other):
        sides = np.roll(corners, -1, axis=0) - corners
        for normal in np.stack([sides[:, 1], -sides[:, 0]], axis=1):
            a, b = one @ normal, other @ normal
            if a.max() < b.min() or b.max() < a.min():
                return True
    return False


def _finger_errors(blocks, polygons) -> dict[str, float]:
    """Return the largest error of a finger width and the smallest gap after snapping, m."""
    worst, smallest = 0.0, np.inf
    for block in blocks:
        pitch = block.wavelength / (4 if block.split else 2)
        angle = radians(block.angle % 360)
        along = np.array([cos(angle), sin(angle)])
        edges = sorted(
            (float((each.corners @ along).min()), float((each.corners @ along).max()))
            for each in polygons
            if each.transducer == block.name and each.layer == "fingers"
        )
        worst = max(worst, max(abs(right - left - block.metallisation * pitch) for left, right in edges))
        gaps = [after[0] - before[1] for before, after in pairwise(edges)]
        smallest = min([smallest, *gaps])
    return {"width_error": worst, "gap": float(smallest)}


def draw(mask: Mask, ax, *, beam: bool) -> None:
    """Draw a mask into an Axes in mm; ``beam`` says that the Axes already show a computed beam."""
    from matplotlib.collections import PolyCollection

    colours = {"+": "tab:red", "-": "tab:blue", "o": "tab:grey", "": "black"}
    for comb, colour in colours.items():
        corners = [each.corners * 1e3 for each in mask.polygons if each.comb == comb]
        if corners:
            face = "none" if comb == "" else colour
            label = {"": None, "o": "open strips"}.get(comb, f"comb {comb}")
            ax.add_collection(PolyCollection(corners, facecolors=face, edgecolors=colour, linewidths=0.4, label=label))
    ax.set_xlim(-0.02e3 * mask.length, 1.02e3 * mask.length)
    ax.set_ylim(-0.52e3 * mask.width, 0.52e3 * mask.width)
    ax.set_aspect("equal")
    ax.set_xlabel(quantity("x_m").axis)
    ax.set_ylabel(quantity("y_m").axis)
    ax.legend(loc="lower right", ncols=3, fontsize="small", framealpha=0.85)
    ax.set_title(f"{mask.title}\nmask{' on the computed beam' if beam else ''}", fontsize="medium")


def gds(mask: Mask) -> bytes:
    """Return the mask as GDSII, unit 1 um: layers of ``LAYERS``, datatypes of `datatype`."""
    from tempfile import TemporaryDirectory

    gdstk = needed("gdstk", "a mask")
    precision = min(GDS_PRECISION, mask.grid)
    if max(mask.length, mask.width) / precision > MAX_COORDINATE:
        raise SceneError("size.grid", f"must be at least {max(mask.length, mask.width) / MAX_COORDINATE:.2g} m here")
    library = gdstk.Library("sawmotor", unit=1e-6, precision=precision)
    cell = library.new_cell("CHIP")
    for each in mask.polygons:
        cell.add(gdstk.Polygon(each.corners * 1e6, layer=LAYERS[each.layer], datatype=datatype(mask, each)))
    for name in mask.transducers:
        corners = np.vstack([each.corners for each in mask.polygons if each.transducer == name])
        cell.add(gdstk.Label(name, tuple(corners.mean(axis=0) * 1e6), layer=LAYERS["outline"]))
    with TemporaryDirectory() as folder:
        path = f"{folder}/mask.gds"
        library.write_gds(path)
        with open(path, "rb") as file:
            return file.read()


def datatype(mask: Mask, polygon: Polygon) -> int:
    """Return the GDSII datatype: 10 n + 1, 2 or 3 for the comb +, - or o of the n-th transducer; 0 for other parts."""
    if not polygon.transducer:
        return 0
    return 10 * (mask.transducers.index(polygon.transducer) + 1) + list(COMBS).index(polygon.comb) + 1


def dxf(mask: Mask) -> bytes:
    """Return the mask as DXF (R2010), unit 1 um: closed polylines on layers such as FINGERS_left_plus."""
    from io import StringIO

    ezdxf = needed("ezdxf", "a mask")
    document = ezdxf.new("R2010")
    document.units = 13  # micrometres
    space = document.modelspace()
    for each in mask.polygons:
        name = layer_name(each)
        if name not in document.layers:
            document.layers.add(name)
        space.add_lwpolyline(each.corners * 1e6, close=True, dxfattribs={"layer": name})
    text = StringIO()
    document.write(text)
    return text.getvalue().encode("utf-8")


def layer_name(polygon: Polygon) -> str:
    """Return the name of a polygon's layer in a DXF file."""
    parts = [polygon.layer.upper(), polygon.transducer, COMBS.get(polygon.comb, "")]
    return "_".join(part for part in parts if part)


def layer_table(mask: Mask) -> str:
    """Return the layers of the GDSII file as CSV."""
    rows = {(LAYERS[each.layer], datatype(mask, each)): layer_name(each) for each in mask.polygons}
    return "layer,datatype,name\n" + "".join(f"{layer},{kind},{name}\n" for (layer, kind), name in sorted(rows.items()))
