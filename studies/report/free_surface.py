"""``sawmotor wave``: the Rayleigh wave of a material's half-space, without a mesh and without loss."""

import fem
from fem import surface_named
from studies.refusal import RunError, SceneError
from studies.report.answer import labelled, table
from studies.report.crystal import crystal_tables, tables_text
from studies.results.content import plain
from studies.scene.blocks import ORIENTATION

__all__ = ["half_space_answer", "half_space_wave"]

DEPTHS = tuple(k / 20 for k in range(61))  # wavelengths


def half_space_wave(material: str, *, orientation="Z", surface: str = "vacuum") -> dict:
    """Return the wave in terms of JSON.

    Parameters
    ----------
    material : str
        A catalogue name.
    orientation : str or sequence of 3 floats
        A named cut, or angles in degrees.
    surface : str
        "vacuum" (or "free"), "open" or "metallised".

    Returns
    -------
    dict
        ``velocity_m_per_s``, ``coupling_K2`` (of a piezoelectric solid), ``surface_ratio``,
        ``depth_profile`` with displacements over u_z at the surface and the potential in V per m of it,
        ``material``, ``crystal`` with the rotated tensors and the cut's axes.
    """
    orientation = ORIENTATION.read("--orientation", orientation)
    try:
        solid = fem.rotated(fem.material(material), orientation)
        surface = surface_named(surface)
    except ValueError as error:
        raise SceneError("", str(error)) from None
    try:
        wave = fem.rayleigh(solid, surface)
        coupled = "phi" in wave.fields
        coupling = {"coupling_K2": fem.coupling(solid)} if coupled else {}
    except fem.ConvergenceError as error:
        raise RunError(str(error)) from None
    displacement, potential = wave.profile(DEPTHS)
    profile = {"depth_wavelengths": DEPTHS}
    profile |= {f"u_{axis}": displacement[:, k] for k, axis in enumerate("xyz")}
    if coupled:
        profile["potential_V_per_m"] = potential
    answer = {
        "material": {"name": solid.name, "orientation": solid.frame, "source": solid.source},
        "surface": surface,
        "velocity_m_per_s": wave.velocity,
        **coupling,
        "surface_ratio": wave.surface_ratio,
        "retrograde": wave.displacement[0].imag > 0,
        "depth_profile": profile,
        "crystal": crystal_tables(solid, orientation),
    }
    return {key: plain(key, value) for key, value in answer.items()}


def half_space_answer(answer: dict) -> str:
    """Return the wave as text for a reader."""
    material, sense = answer["material"], "retrograde" if answer["retrograde"] else "prograde"
    title = (
        f"{material['name']}, {material['orientation']}, surface {answer['surface']} ({material['source']})"
    )
    lines = [("velocity", f"{answer['velocity_m_per_s']:.8g} m/s")]
    if "coupling_K2" in answer:
        lines.append(("coupling K2", f"{100 * answer['coupling_K2']:.4g} %"))
    lines.append(("surface ratio", f"{answer['surface_ratio']:.6g} (|u_x/u_z|, {sense})"))
    profile = answer["depth_profile"]
    rows = [["depth (wavelengths)", "|u_x|", "|u_y|", "|u_z|"]]
    for row in range(0, len(profile["depth_wavelengths"]), 5):
        sizes = [f"{abs(complex(*profile[f'u_{axis}'][row])):.5f}" for axis in "xyz"]
        rows.append([f"{profile['depth_wavelengths'][row]:g}", *sizes])
    return "\n".join([title, *labelled(lines, 15), "", *table(rows), "", *tables_text(answer["crystal"])])
