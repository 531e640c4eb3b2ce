"""The mask of a scene as a file, and as a picture."""

from functools import partial
from io import StringIO
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from studies.export.exported import Exported
from studies.export.mask import LAYERS, Mask, Polygon, Sizes, mask
from studies.record.plots import finished
from studies.record.quantities import quantity
from studies.refusal import needed, refuse_if
from studies.scene import Scene

PARTS = ("fingers", "busbars", "pads", "openings")  # that the answer counts
COMBS = {"+": "plus", "-": "minus", "o": "open"}  # in the name of a layer
MAX_COORDINATE = 2**31 - 1  # largest coordinate of a GDSII file, in units of its precision
GDS_PRECISION = 1e-9  # m


def gds_files(scene: Scene, name: str, *, size: list[str] | None = None, tolerance: float) -> Exported:
    """Return NAME.gds and a table of its layers."""
    drawn = mask(scene, Sizes.read(size or []))
    files = {f"{name}.gds": gds(drawn), "layers.csv": layer_table(drawn)}
    return _exported(drawn, files)


def dxf_files(scene: Scene, name: str, *, size: list[str] | None = None, tolerance: float) -> Exported:
    """Return NAME.dxf."""
    drawn = mask(scene, Sizes.read(size or []))
    return _exported(drawn, {f"{name}.dxf": dxf(drawn)})


def gds(mask: Mask) -> bytes:
    """Return the mask as GDSII, unit 1 um: layers of ``LAYERS``, datatypes of `datatype`."""
    gdstk = needed("gdstk", "a mask")
    precision = min(GDS_PRECISION, mask.grid)
    refuse_if(
        max(mask.length, mask.width) / precision > MAX_COORDINATE,
        "size.grid",
        f"must be at least {max(mask.length, mask.width) / MAX_COORDINATE:.2g} m here",
    )
    library = gdstk.Library("sawmotor", unit=1e-6, precision=precision)
    cell = library.new_cell("CHIP")
    for each in mask.polygons:
        cell.add(gdstk.Polygon(each.corners * 1e6, layer=LAYERS[each.layer], datatype=datatype(mask, each)))
    for name in mask.transducers:
        corners = np.vstack([each.corners for each in mask.polygons if each.transducer == name])
        cell.add(gdstk.Label(name, tuple(corners.mean(axis=0) * 1e6), layer=LAYERS["outline"]))
    with TemporaryDirectory() as folder:
        path = Path(folder) / "mask.gds"
        library.write_gds(str(path))
        return path.read_bytes()


def datatype(mask: Mask, polygon: Polygon) -> int:
    """Return the GDSII datatype: 10 n + 1, 2 or 3 for the comb +, - or o of the n-th transducer; 0 for other parts."""
    if not polygon.transducer:
        return 0
    return 10 * (mask.transducers.index(polygon.transducer) + 1) + list(COMBS).index(polygon.comb) + 1


def dxf(mask: Mask) -> bytes:
    """Return the mask as DXF (R2010), unit 1 um: closed polylines on layers such as FINGERS_left_plus."""
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
    names = {(LAYERS[each.layer], datatype(mask, each)): layer_name(each) for each in mask.polygons}
    return "layer,datatype,name\n" + "".join(
        f"{layer},{kind},{name}\n" for (layer, kind), name in sorted(names.items())
    )


def _exported(drawn: Mask, files) -> Exported:
    counts = {layer: sum(each.layer == layer for each in drawn.polygons) for layer in PARTS}
    counts = {layer: number for layer, number in counts.items() if number or layer != "openings"}
    shift, widening = (round(each * 1e9, 3) for each in (drawn.shift, drawn.width_error))  # nm
    answer = (
        ("mask", f"{drawn.title}: chip {drawn.length * 1e3:g} mm x {drawn.width * 1e3:g} mm, unit 1 um"),
        ("", ", ".join(f"{number} {layer}" for layer, number in counts.items())),
        ("grid", f"{drawn.grid * 1e9:g} nm: corners moved by at most {shift:g} nm, widths of fingers by "
                 f"{widening:g} nm; narrowest gap {drawn.gap * 1e6:.4g} um"),
    )  # fmt: skip
    return Exported(
        files=files, answer=answer, pictures={"mask.png": partial(draw, drawn)},
        remarks=(drawn.left_out,) * bool(drawn.left_out),
    )  # fmt: skip


def draw(mask: Mask, ax) -> None:
    """Draw a mask into an Axes in mm."""
    from matplotlib.collections import PolyCollection

    colours = {"+": "tab:red", "-": "tab:blue", "o": "tab:grey", "": "black"}
    for comb, colour in colours.items():
        corners = [each.corners * 1e3 for each in mask.polygons if each.comb == comb]
        if corners:
            face = "none" if comb == "" else colour
            label = {"": None, "o": "open strips"}.get(comb, f"comb {comb}")
            ax.add_collection(PolyCollection(corners, facecolors=face, edgecolors=colour, linewidths=0.4, label=label))
    openings = [each.corners * 1e3 for each in mask.polygons if each.layer == "openings"]
    if openings:
        label = "openings of the layers above"
        ax.add_collection(PolyCollection(openings, facecolors="white", edgecolors="black", linewidths=0.4, label=label))
    ax.set_xlim(-0.02e3 * mask.length, 1.02e3 * mask.length)
    ax.set_ylim(-0.52e3 * mask.width, 0.52e3 * mask.width)
    ax.set_aspect("equal")
    finished(ax, quantity.x_m.axis, quantity.y_m.axis, f"{mask.title}\nmask", columns=3, grid=False)
