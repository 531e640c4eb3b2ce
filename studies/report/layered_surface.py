"""``sawmotor wave --layer``: the bound waves of layers on a lossless half-space."""

import math
from contextlib import suppress

import fem
from studies.model.scene_errors import as_run_errors
from studies.model.solid_of_material import named_solid
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.record.text import labelled, table
from studies.record.values import Columns
from studies.refusal import SceneError, refuse_if
from studies.report.free_surface import DEPTHS
from studies.results.content import plain
from studies.scene.quantity import si_value
from studies.scene.stator_keys import ORIENTATION

MAX_WAVELENGTHS = 3.0  # a layer that is thicker holds the whole wave
FORM = 'must be "MATERIAL [ORIENTATION], THICKNESS" such as "SiO2, 0.05 lambda", "LiNbO3 (Kovacs) 128YX, 2 um"'


def read_layer(text: str) -> fem.Layer:
    """Return the layer that a text such as "LiNbO3 (Kovacs) 128YX, 0.3 lambda" or "AlN.toml, 2 um" describes."""
    what, comma, thickness = text.rpartition(",")
    thickness = thickness.strip()
    counted = thickness.endswith(("lambda", "\u03bb"))
    number = thickness.removesuffix("lambda").removesuffix("\u03bb").strip()
    sizes, why = {}, "" if comma else f"{FORM}, got {text!r}"
    try:
        sizes = {"wavelengths": float(number)} if counted else {}
    except ValueError:
        why = why or f"{FORM}, got {text!r}: {number!r} is no number of wavelengths"
    if why:
        raise SceneError("--layer", why)
    solid = _solid(what.strip())
    try:
        return fem.Layer(solid=solid, **(sizes or {"thickness": si_value("--layer", thickness, "m")}))
    except fem.InputError as error:
        raise SceneError("--layer", f"{error} in {text!r}") from None


def _solid(text: str) -> fem.Solid:
    """Return the rotated solid that a name describes, with an orientation behind it where the name alone is unknown."""
    name, space, cut = text.rpartition(" ")
    try:
        return fem.rotated(named_solid(text)[1], "Z")
    except (SceneError, fem.InputError) as refusal:
        unknown = refusal
    with suppress(SceneError, fem.InputError):
        if space:
            return fem.rotated(named_solid(name)[1], ORIENTATION.read("--layer", cut))
    raise SceneError("--layer", str(unknown))


def layered_surface_wave(
    material: str, layers: list[str], *, orientation="Z", surface: str = "vacuum", frequency: float | None = None
) -> Columns:
    """Return the bound waves of layers on a half-space as JSON-compatible data.

    Parameters
    ----------
    material : str
        The half-space: a catalogue name or a file of constants.
    layers : list of str
        From the half-space upwards; see `read_layer`.
    orientation : str or sequence of 3 floats
        Of the half-space.
    surface : str
        "vacuum" (or "free"), "open" or "metallised".
    frequency : float, optional
        Hz; needed for thicknesses in m.

    Returns
    -------
    dict
        The keys of ``free_surface.half_space_wave``, of the first wave with sagittal motion, without ``crystal``;
        ``layers``: name, orientation and thickness of each; ``waves``: all bound waves; ``shorted_velocity_m_per_s``:
        the velocity with an electrode at "surface" or below so many layers, and ``coupling_K2`` that of each plane.
        Where no wave is bound, the leaky waves without these and without ``depth_profile``: ``waves`` have the key
        ``attenuation_dB_per_wavelength``.
    """
    orientation = ORIENTATION.read("--orientation", orientation)
    stack = [read_layer(text) for text in layers]
    try:
        solid = fem.rotated(named_solid(material)[1], orientation)
        with as_run_errors():
            try:
                waves = fem.layered_waves(solid, stack, surface=surface, frequency=frequency)
                wave = fem.principal_wave(waves)
            except fem.ConvergenceError as refusal:
                return _leaky(solid, stack, surface, frequency, refusal)
    except fem.InputError as error:
        key = "--frequency" if error.key == "frequency" else error.key
        raise SceneError(key, error.rule) from None
    thicknesses = wave.stack.depth[:, 0] / (2.0 * math.pi)
    for text, each in zip(layers, thicknesses, strict=True):
        rule = f"{text!r} is {each:.3g} wavelengths thick: it is the substrate; make it MATERIAL"
        refuse_if(each > MAX_WAVELENGTHS, "--layer", rule)
    planes = {"surface": 0} | {str(above): above for above in range(1, len(stack) + 1)}
    shorted, coupling = {}, {}
    if surface in ("vacuum", "free") and wave.impedance.electric:
        with as_run_errors():
            velocities = fem.shorted_velocities(wave, tuple(planes.values()))
        shorted = dict(zip(planes, velocities.tolist(), strict=True))
        coupling = {name: 2.0 * (wave.velocity - each) / wave.velocity for name, each in shorted.items()}
    displacement, potential = wave.profile(DEPTHS)
    profile = {"depth_wavelengths": DEPTHS}
    profile |= {f"u_{axis}": displacement[:, k] for k, axis in enumerate("xyz")}
    if wave.impedance.electric:
        profile["potential_V_per_m"] = potential
    answer = dict(
        material={"name": solid.name, "orientation": solid.frame, "source": solid.source},
        layers=_layers(stack, wave.velocity, frequency),
        surface=wave.surface,
        velocity_m_per_s=wave.velocity,
        limiting_velocity_m_per_s=wave.limiting_velocity,
        surface_ratio=wave.surface_ratio,
        retrograde=wave.displacement[0].imag > 0,
        shorted_velocity_m_per_s=shorted,
        coupling_K2=coupling,
        waves=[
            dict(name=each.name, velocity_m_per_s=each.velocity, surface_ratio=each.surface_ratio)
            for each in waves
        ],
        depth_profile=profile,
    )  # fmt: skip
    return Columns((key, plain(key, value)) for key, value in answer.items())


def _layers(stack: list[fem.Layer], velocity: float, frequency: float | None) -> list[dict]:
    """Return name, orientation and thickness of layers, in wavelengths of a wave in m/s and in m."""
    rows = []
    for each in stack:
        thickness, share = each.thickness, each.wavelengths
        if share is None and frequency is not None and thickness is not None:
            share = thickness * frequency / velocity
        elif thickness is None and frequency is not None and share is not None:
            thickness = share * velocity / frequency
        rows.append({"name": each.solid.name, "orientation": each.solid.frame, "thickness_wavelengths": share,
                     "thickness_m": thickness})  # fmt: skip
    return rows


def _leaky(solid, stack: list[fem.Layer], surface: str, frequency: float | None, refusal: Exception) -> Columns:
    """Return the leaky waves where none is bound; with none of these either, raise the refusal of the bound ones."""
    try:
        waves = fem.leaky_waves(solid, stack, surface=surface, frequency=frequency)
    except fem.ConvergenceError as error:
        raise fem.ConvergenceError(f"{refusal}. There is {error}") from None
    wave = next((each for each in waves if not each.transverse), waves[0])
    answer = dict(
        material={"name": solid.name, "orientation": solid.frame, "source": solid.source},
        layers=_layers(stack, wave.velocity, frequency),
        surface=fem.surface_named(surface),
        velocity_m_per_s=wave.velocity,
        attenuation_dB_per_wavelength=wave.decibels,
        limiting_velocity_m_per_s=wave.limiting_velocity,
        surface_ratio=wave.surface_ratio,
        retrograde=bool(wave.displacement[0].imag * wave.displacement[2].real > 0),
        waves=[
            dict(name="leaky, transverse" if each.transverse else "leaky", velocity_m_per_s=each.velocity,
                 surface_ratio=each.surface_ratio, attenuation_dB_per_wavelength=each.decibels)
            for each in waves
        ],
    )  # fmt: skip
    return Columns((key, plain(key, value)) for key, value in answer.items())


def layered_answer(answer: Columns) -> str:
    """Return the waves of `layered_surface_wave` as text."""
    material, sense = answer["material"], "retrograde" if answer["retrograde"] else "prograde"
    title = f"layers on {material['name']}, {material['orientation']}, surface {answer['surface']}"
    rows = [["layer", "orientation", "thickness"]]
    for each in reversed(answer["layers"]):  # as they lie, the surface first
        size = f"{each['thickness_wavelengths']:.4g} wavelengths"
        absolute = each["thickness_m"]
        rows.append([each["name"], each["orientation"], size if absolute is None else f"{si(absolute, 'm')}, {size}"])
    lines = [
        ("velocity", f"{answer.velocity_m_per_s:.8g} m/s"),
        ("surface ratio", f"{answer.surface_ratio:.6g} (|u_x/u_z|, {sense})"),
        ("limit", f"{answer['limiting_velocity_m_per_s']:.6g} m/s: the half-space's slowest bulk wave"),
    ]
    leaks = "attenuation_dB_per_wavelength" in answer
    if leaks:
        attenuation = f"{answer.attenuation_dB_per_wavelength:.4g} dB in a wavelength"
        lines.append(("attenuation", f"{attenuation}: it is faster than that bulk wave, and leaks into it"))
    for plane, velocity in answer.get("shorted_velocity_m_per_s", {}).items():
        where = "at the surface" if plane == "surface" else f"below {plane} layer{'s' * (plane != '1')}"
        coupling = 100.0 * answer["coupling_K2"][plane]
        lines.append(("electrode", f"{where}: {velocity:.8g} m/s, K2 {coupling:.4g} %"))
    for each in map(Columns, answer["waves"]):
        loss = f", {each.attenuation_dB_per_wavelength:.4g} dB in a wavelength" if leaks else ""
        lines.append((each["name"], f"{each.velocity_m_per_s:.8g} m/s, |u_x/u_z| {each.surface_ratio:.4g}{loss}"))
    if leaks:
        return "\n".join([title, *table(rows), "", *labelled(lines, 18)])
    profile = answer["depth_profile"]
    depths = [[quantity.depth_wavelengths.axis, "|u_x|", "|u_y|", "|u_z|"]]
    for row in range(0, len(profile["depth_wavelengths"]), 5):
        sizes = [f"{abs(complex(*profile[f'u_{axis}'][row])):.5f}" for axis in "xyz"]
        depths.append([f"{profile['depth_wavelengths'][row]:g}", *sizes])
    return "\n".join([title, *table(rows), "", *labelled(lines, 15), "", *table(depths)])
