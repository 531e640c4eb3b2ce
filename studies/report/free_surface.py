"""``sawmotor wave``: the Rayleigh wave of a lossless half-space and the orientation of its crystal axes.

x is the direction of propagation and z the outward normal. Figures show the section along +y, so that +y points into
the page. The length of a crystal axis X, Y or Z (1, 2, 3 of the material's tables) in a figure is that of its
projection on the section.
"""

from pathlib import Path

import fem
from fem import VACUUM_PERMITTIVITY, rotation_matrix, surface_named
from studies.model.scene_errors import as_run_errors, input_errors
from studies.model.solid_of_material import named_solid
from studies.record.plots import COLOURS, arrow, saved
from studies.record.quantities import Quantity, quantity
from studies.record.text import labelled, table
from studies.record.values import Columns
from studies.refusal import refuse_ending, writing
from studies.results.content import plain
from studies.scene.stator_keys import ORIENTATION

DEPTHS = tuple(k / 20 for k in range(61))  # in wavelengths
FORMATS = (".png", ".jpg", ".jpeg", ".pdf", ".svg", ".tif", ".tiff")
VOIGT = ("11", "22", "33", "23", "13", "12")
NOISE = 1e-9  # relative to the largest entry of a tensor; smaller entries are printed as 0
MIN_COMPONENT = 0.05  # smallest component of a unit vector that is drawn or written


def half_space_wave(material: str, *, orientation="Z", surface: str = "vacuum") -> Columns:
    """Return the Rayleigh wave of a half-space as JSON-compatible data.

    Parameters
    ----------
    material : str
        A catalogue name, or a file of constants.
    orientation : str or sequence of 3 floats
        A named cut, or angles in degrees.
    surface : str
        "vacuum" (or "free"), "open" or "metallised".

    Returns
    -------
    dict
        ``velocity_m_per_s``, ``coupling_K2`` (only for a piezoelectric solid), ``surface_ratio`` and ``material``;
        ``depth_profile``: displacements relative to u_z at the surface, and the potential in V per m of that u_z;
        ``crystal``: the tensors in the frame of the cut, and the components of its unit vectors x, y, z along the
        crystal axes.
    """
    orientation = ORIENTATION.read("--orientation", orientation)
    with input_errors():
        solid = fem.rotated(named_solid(material)[1], orientation)
        surface = surface_named(surface)
    with as_run_errors():
        try:
            wave = fem.rayleigh(solid, surface)
        except fem.ConvergenceError as refusal:
            raise fem.ConvergenceError(f"{refusal}{_leaky(solid, surface)}") from None
        coupled = "phi" in wave.fields
        coupling = {"coupling_K2": fem.coupling(solid)} if coupled else {}
    displacement, potential = wave.profile(DEPTHS)
    profile = {"depth_wavelengths": DEPTHS}
    profile |= {f"u_{axis}": displacement[:, k] for k, axis in enumerate("xyz")}
    if coupled:
        profile["potential_V_per_m"] = potential
    answer = dict(
        material={"name": solid.name, "orientation": solid.frame, "source": solid.source},
        surface=surface,
        velocity_m_per_s=wave.velocity,
        **coupling,
        surface_ratio=wave.surface_ratio,
        retrograde=wave.displacement[0].imag > 0,
        depth_profile=profile,
        crystal={
            "stiffness_Pa": solid.stiffness,
            "coupling_C_per_m2": solid.coupling,
            "permittivity_relative": solid.permittivity / VACUUM_PERMITTIVITY,
            "density_kg_per_m3": solid.density,
            "axes_in_crystal": dict(zip("xyz", rotation_matrix(orientation), strict=True)),
        },
    )
    return Columns((key, plain(key, value)) for key, value in answer.items())


def _leaky(solid: fem.Solid, surface: str) -> str:
    """Return a sentence on the least attenuated leaky wave of a half-space; empty without one."""
    try:
        wave = fem.leaky_waves(solid, surface=surface)[0]
    except fem.ConvergenceError:
        return ""
    kind = ", transverse" if wave.transverse else ""
    return f". Its leaky wave has {wave.velocity:.6g} m/s and loses {wave.decibels:.3g} dB in a wavelength{kind}"


def half_space_answer(answer: Columns) -> str:
    """Return the wave of `half_space_wave` as text."""
    material, sense = answer["material"], "retrograde" if answer["retrograde"] else "prograde"
    title = f"{material['name']}, {material['orientation']}, surface {answer['surface']} ({material['source']})"
    lines = [("velocity", f"{answer.velocity_m_per_s:.8g} m/s")]
    if "coupling_K2" in answer:
        lines.append(("coupling K2", f"{100 * answer['coupling_K2']:.4g} %"))
    lines.append(("surface ratio", f"{answer.surface_ratio:.6g} (|u_x/u_z|, {sense})"))
    profile = answer["depth_profile"]
    rows = [[quantity.depth_wavelengths.axis, "|u_x|", "|u_y|", "|u_z|"]]
    for row in range(0, len(profile["depth_wavelengths"]), 5):
        sizes = [f"{abs(complex(*profile[f'u_{axis}'][row])):.5f}" for axis in "xyz"]
        rows.append([f"{profile['depth_wavelengths'][row]:g}", *sizes])
    return "\n".join([title, *labelled(lines, 15), "", *table(rows), "", *tables_text(answer["crystal"])])


def tables_text(crystal: dict) -> list[str]:
    """Return the tensors and axes as lines of text, Voigt order 11 22 33 23 13 12."""
    lines = []
    for key, sides, columns in (
        ("stiffness_Pa", VOIGT, VOIGT),
        ("coupling_C_per_m2", "xyz", VOIGT),
        ("permittivity_relative", "xyz", "xyz"),
    ):
        tensor = quantity(f"crystal.{key}")
        lines += [f"{tensor.axis}, rotated", *_table(crystal[key], sides, columns, tensor), ""]
    cut, names = crystal["axes_in_crystal"], {"x": "x, propagation", "y": "y", "z": "z, outward normal"}
    rows = [[name, *(f"{part + 0.0:.5f}" for part in _clean(cut[axis]))] for axis, name in names.items()]
    return [*lines, "axes of the cut along the crystal's", *table([["", "X", "Y", "Z"], *rows])]


def axes(crystal: dict) -> dict:
    """Return the components (x, y, z) of the crystal axes X, Y and Z in the frame of the cut."""
    rows = [_clean(crystal["axes_in_crystal"][name]) for name in "xyz"]
    return {name: tuple(row[k] for row in rows) for k, name in enumerate("XYZ")}


def axes_figure(answer: Columns, ax):
    """Draw the crystal axes of a result of `half_space_wave` in the section."""
    colours = {"X": COLOURS["slip"], "Y": COLOURS["second"], "Z": COLOURS["intermittent"]}
    ax.axhspan(-1.5, 0, color=COLOURS["stick"], alpha=0.25, linewidth=0)
    ax.axhline(0, color=COLOURS["line"], linewidth=1.2)
    for name, (x, y, z) in axes(answer["crystal"]).items():
        if x * x + z * z > MIN_COMPONENT**2:
            arrow(ax, (0, 0), (x, z), colours[name], width=2.0)
        mark = "" if abs(y) < MIN_COMPONENT else f" ({abs(y):.2f} {'into' if y > 0 else 'out of'} the page)"
        projection = max((x * x + z * z) ** 0.5, MIN_COMPONENT)
        label_position = (
            (1.15 * x, 1.15 * z + (0.09 if abs(z) < 0.1 else 0.0)) if projection > MIN_COMPONENT else (0.12, -0.12)
        )
        ax.text(*label_position, name + mark, color=colours[name], ha="center", va="center", fontsize="small")
    ax.plot([0], [0], "o", color=COLOURS["line"], markersize=4)
    ax.text(-1.4, 0.05, "surface", fontsize="small")
    material = answer["material"]
    speed = f"{answer.velocity_m_per_s:.5g} m/s"
    ax.set_title(f"{material['name']}, {material['orientation']}: {speed}", fontsize="medium")
    ax.set_xlim(-1.5, 1.5)
    ax.set_ylim(-1.5, 1.5)
    ax.set_aspect("equal")
    ax.set_xlabel("x, along the propagation (length of the axis, 1)")
    ax.set_ylabel("z, out of the surface (length of the axis, 1)")
    return ax


def save_axes(answer: Columns, file: str | Path) -> None:
    """Draw the crystal axes into a file; raise an error for an unknown format or an unwritable file."""
    refuse_ending(file, FORMATS, "--plot")
    with writing(file, "--plot"):
        saved(Path(file), lambda ax: axes_figure(answer, ax), size=(5.0, 5.0))


def _table(rows, heads, columns, tensor: Quantity) -> list[str]:
    largest = max(abs(value) for row in rows for value in row)
    cells = [["", *columns]]
    for head, row in zip(heads, rows, strict=True):
        entries = [value if abs(value) > NOISE * largest else 0.0 for value in row]
        cells.append([head, *map(tensor.text, entries)])
    return table(cells)


def _clean(row) -> list[float]:
    """Return the components of a unit vector without rounding errors and negative zeros."""
    return [0.0 if abs(part) < 1e-12 else float(part) for part in row]
