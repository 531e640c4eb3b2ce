"""A cut made visible: its rotated tensors as tables, its crystal axes in the x-z section as a picture.

x runs along the propagation, z out of the surface, and the section is looked at along +y: what points to +y goes into
the page.  A crystal axis X, Y or Z (1, 2, 3 of the material's tables) is drawn as long as its part in the section.
"""

from pathlib import Path

from fem import VACUUM_PERMITTIVITY, rotation_matrix
from studies.refusal import RunError, SceneError
from studies.report.answer import table
from studies.report.figures import COLOURS, arrow, saved

__all__ = ["axes", "axes_figure", "crystal_tables", "save_axes", "tables_text"]

FORMATS = (".png", ".jpg", ".jpeg", ".pdf", ".svg", ".tif", ".tiff")
VOIGT = ("11", "22", "33", "23", "13", "12")
NOISE = 1e-9  # of a tensor's largest entry: printed as 0
SEEN = 0.05  # part of an axis along y that is worth a mark


def crystal_tables(solid, orientation) -> dict:
    """Return a rotated solid's tensors and the cut's axes in terms of JSON.

    Parameters
    ----------
    solid : fem.Solid
        In the frame of the cut.
    orientation : str or sequence of 3 floats
        The cut.

    Returns
    -------
    dict
        ``stiffness_Pa``, ``coupling_C_per_m2``, ``permittivity_relative``, ``density_kg_per_m3``, and
        ``axes_in_crystal``: unit vectors of x, y and z along the crystal's axes.
    """
    rows = rotation_matrix(orientation)
    return {
        "stiffness_Pa": solid.stiffness,
        "coupling_C_per_m2": solid.coupling,
        "permittivity_relative": solid.permittivity / VACUUM_PERMITTIVITY,
        "density_kg_per_m3": solid.density,
        "axes_in_crystal": {name: row for name, row in zip("xyz", rows, strict=True)},
    }


def tables_text(crystal: dict) -> list[str]:
    """Return the tensors and axes as lines of text, Voigt order 11 22 33 23 13 12."""
    lines = []
    for head, key, rows, columns, unit in (
        ("stiffness c (GPa), rotated", "stiffness_Pa", VOIGT, VOIGT, 1e-9),
        ("coupling e (C/m^2), rotated", "coupling_C_per_m2", "xyz", VOIGT, 1.0),
        ("permittivity (relative to vacuum, clamped), rotated", "permittivity_relative", "xyz", "xyz", 1.0),
    ):
        lines += [head, *_table(crystal[key], rows, columns, unit), ""]
    cut, names = crystal["axes_in_crystal"], {"x": "x, propagation", "y": "y", "z": "z, outward normal"}
    rows = [[name, *(f"{part + 0.0:.5f}" for part in _clean(cut[axis]))] for axis, name in names.items()]
    return [*lines, "axes of the cut along the crystal's", *table([["", "X", "Y", "Z"], *rows])]


def axes(crystal: dict) -> dict:
    """Return the crystal's axes X, Y, Z as (x, y, z) of the cut."""
    rows = [_clean(crystal["axes_in_crystal"][name]) for name in "xyz"]
    return {name: tuple(row[k] for row in rows) for k, name in enumerate("XYZ")}


def axes_figure(answer: dict, ax):
    """Draw the crystal axes in the section's corner of the material that `half_space_wave` answered for."""
    colours = {"X": COLOURS["slip"], "Y": COLOURS["second"], "Z": COLOURS["intermittent"]}
    ax.axhspan(-1.5, 0, color=COLOURS["stick"], alpha=0.25, linewidth=0)
    ax.axhline(0, color=COLOURS["line"], linewidth=1.2)
    for name, (x, y, z) in axes(answer["crystal"]).items():
        if x * x + z * z > SEEN**2:
            arrow(ax, (0, 0), (x, z), colours[name], width=2.0)
        mark = "" if abs(y) < SEEN else f" ({abs(y):.2f} {'into' if y > 0 else 'out of'} the page)"
        size = max((x * x + z * z) ** 0.5, SEEN)
        at = (1.15 * x, 1.15 * z + (0.09 if abs(z) < 0.1 else 0.0)) if size > SEEN else (0.12, -0.12)
        ax.text(*at, name + mark, color=colours[name], ha="center", va="center", fontsize="small")
    ax.plot([0], [0], "o", color=COLOURS["line"], markersize=4)
    ax.text(-1.4, 0.05, "surface", fontsize="small")
    material = answer["material"]
    speed = f"{answer['velocity_m_per_s']:.5g} m/s"
    ax.set_title(f"{material['name']}, {material['orientation']}: {speed}", fontsize="medium")
    ax.set_xlim(-1.5, 1.5)
    ax.set_ylim(-1.5, 1.5)
    ax.set_aspect("equal")
    ax.set_xlabel("x, along the propagation (length of the axis, 1)")
    ax.set_ylabel("z, out of the surface (length of the axis, 1)")
    return ax


def save_axes(answer: dict, file: str | Path) -> None:
    """Draw the crystal axes into a file.

    Raises
    ------
    SceneError
        If the file's format is unknown.
    RunError
        If it cannot be written.
    """
    if Path(file).suffix.lower() not in FORMATS:
        raise SceneError("--plot", f"must end in one of {', '.join(FORMATS)}, got {str(file)!r}")
    try:
        saved(Path(file), lambda ax: axes_figure(answer, ax), size=(5.0, 5.0))
    except OSError as error:
        raise RunError(f"the picture {str(file)!r} cannot be written: {error.strerror or error}") from None


def _table(rows, heads, columns, unit: float) -> list[str]:
    largest = max(abs(value) for row in rows for value in row)
    cells = [["", *columns]]
    for head, row in zip(heads, rows, strict=True):
        entries = [value if abs(value) > NOISE * largest else 0.0 for value in row]
        cells.append([head, *(f"{value * unit:.5g}" for value in entries)])
    return table(cells)


def _clean(row) -> list[float]:
    """Return a unit vector's parts without rounding noise and negative zeros."""
    return [0.0 if abs(part) < 1e-12 else float(part) for part in row]
