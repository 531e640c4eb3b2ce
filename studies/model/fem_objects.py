"""The blocks of a scene as objects of ``fem``: stator, meshed pieces, transducers, drive.

It also decides whether a scene is computed as a plane section or with finite apertures (`section_reason`). The scene is
resolved: its automatic values are numbers.
"""

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import fem
from studies.model.materials import LOSSES, crystal, crystal_at, frequency_coefficient, reference_temperature
from studies.model.scene_errors import stator_keys
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.blocks import Stator, Transducer, wavelengths_of

ROUNDED = 1e-6  # relative change of a length by the roundings of a mesh file


def solid(block: Stator):
    """Return the stator's ``fem.Solid``, rotated to its orientation; at a temperature, in the lengths before it."""
    if block.temperature == "steady":
        rule = 'must be a number here: "steady" is found by sawmotor run, which prints the temperature'
        raise SceneError("stator.temperature", rule)
    warm = None if block.temperature is None else crystal_at(block, block.temperature)
    with stator_keys("stator.material"):
        whole, stretch = warm or (crystal(block.material), 0.0)
        own = {name: value for name in LOSSES if (value := getattr(block, name)) is not None}
        cut = fem.rotated(replace(whole, **own) if own else whole, block.cut)
    return fem.in_cold_lengths(cut, stretch) if stretch else cut


def before_its_heat(scene: Scene) -> Scene:
    """Return a scene with a cold stator where it is to be solved at its own steady temperature."""
    if scene.stator is None or scene.stator.temperature != "steady":
        return scene
    return replace(scene, stator=replace(scene.stator, temperature=None))


def surface_solid(block: Stator):
    """Return the ``fem.Solid`` at the surface: that of the last layer, or of the stator."""
    return stator(block).solids[-1]


def surface_velocity(block: Stator, frequency: float) -> float:
    """Return the velocity of the wave under a bare surface without charge (D_n = 0) at a frequency in Hz, m/s."""
    return fem.bound_wave(stator(block), frequency, "open").velocity


@lru_cache(256)
def relative_frequency(block: Stator, temperature: float) -> float:
    """Return the frequency of a stator's surface wave at a temperature in degC, fingers fixed to it, over the cold one.

    Cold: of the constants as they are. In the lengths before the expansion velocity and frequency change alike.
    """
    coefficient = frequency_coefficient(block)
    if coefficient is not None:
        return 1.0 + coefficient * (temperature - reference_temperature(block))
    warm, cold = (solid(replace(block, temperature=each)) for each in (temperature, None))
    return fem.rayleigh(warm, "vacuum").velocity / fem.rayleigh(cold, "vacuum").velocity


def wavelength(scene: Scene) -> float:
    """Return the length in m of that wave at the frequency of a resolved scene."""
    return surface_velocity(scene.stator, scene.frequency) / scene.frequency


def layers(block: Stator) -> tuple:
    """Return the ``fem.Layer`` objects of a stator block, from its material up."""
    made = []
    for index, each in enumerate(block.layer):
        with stator_keys(f"stator.layer.{index}.material"):
            rotated = fem.rotated(crystal(each.material), each.cut)
        bond = None if each.bond is None else fem.Bond(normal=each.bond.normal, tangential=each.bond.tangential)
        share = wavelengths_of(each.thickness) if isinstance(each.thickness, str) else None
        thickness = {"thickness": each.thickness} if share is None else {"wavelengths": share}
        made.append(fem.Layer(solid=rotated, bond=bond, **thickness))
    return tuple(made)


def stator(block: Stator, plane: int = 0):
    """Return the ``fem.Stator`` of a stator block; ``plane``: number of layers above the fingers."""
    own = {"solid": solid(block), "thickness": math.inf if block.thickness == "half-space" else block.thickness}
    with stator_keys("stator"):
        return fem.Stator(**block.arguments(fem.Stator) | own, layers=layers(block), plane=plane)


def whole_stator(scene: Scene):
    """Return the ``fem.Stator`` of a scene with its meshed pieces and the plane of its fingers."""
    plane = next((int(each.plane) for each in scene.transducer if each.plane != "surface"), 0)
    plain = stator(scene.stator, plane)
    return replace(plain, pieces=pieces(scene)) if scene.piece else plain


def pieces(scene: Scene) -> tuple:
    """Return the ``fem.MeshPiece`` objects of a scene, one for each position."""
    meshed = []
    for index, block in enumerate(scene.piece):
        path = f"piece.{index}"
        solids: tuple = ()
        for name, material in block.materials or ():
            with stator_keys(f"{path}.materials.{name}"):
                solids += ((name, fem.rotated(crystal(material), scene.stator.cut)),)
        try:
            mesh = _mesh(block.file, fem.LENGTH_UNITS[block.length_unit])
        except fem.MeshError as error:
            raise SceneError(f"{path}.file", f"names {error}") from None
        low, high = mesh.extent
        count, length = len(block.position), scene.stator.length
        if count > 1 and count * (high - low) > (1 + ROUNDED) * length:
            rule = f"must name at most as many positions as fit on the stator, {length * 1e3:g} mm long"
            raise SceneError(f"{path}.position", f"{rule}, got {count} of a mesh {(high - low) * 1e3:.6g} mm wide")
        meshed += [
            fem.MeshPiece(
                name=block.label, mesh=mesh, position=position, solids=solids, electrodes=block.electrodes or ()
            )
            for position in block.position
        ]
    return tuple(meshed)


def _mesh(file: str, unit: float):
    """Return the ``fem.SectionMesh`` of a file as it is now."""
    path = Path(file)
    return _read_mesh(file, unit, path.stat().st_mtime_ns if path.is_file() else 0)


@lru_cache(32)
def _read_mesh(file: str, unit: float, stamp: int):
    return fem.read_mesh(file, unit)


def transducers(scene: Scene) -> tuple:
    """Return the ``fem.Transducer`` objects of a scene whose periods are numbers."""
    with stator_keys("transducer"):
        return tuple(_transducer(block, block.wavelength) for block in scene.transducer)


def free_span(extents, x: float, length: float, clear: float = 0.0) -> tuple[float, float]:
    """Return the ends in m of the free surface about x.

    On either side this is the end of the stator, or a distance ``clear`` (m) before the nearest fingers.
    ``extents``: left and right end of the fingers of each transducer, m.
    """
    left = max((right + clear for _, right in extents if right <= x), default=0.0)
    return left, min((left - clear for left, _ in extents if left >= x), default=length)


def section_transducers(scene: Scene) -> tuple:
    """Return `transducers` for models with a single section along x; a SceneError if some lie on other lines."""
    if scene.crossed:
        rule = "must all have the angle 0 and y = 0 here: this answer is that of one section along x"
        raise SceneError("transducer", f"{rule}; sawmotor run, sweep and view accept rotated ones")
    return transducers(scene)


def transducer_groups(scene: Scene) -> tuple:
    """Return the groups of parallel transducers (`fem.rows_of`) of a scene with rotated transducers."""
    return fem.rows_of(stator(scene.stator), scene.stator.width, transducers(scene), drive(scene))


def first_section(scene: Scene, point: tuple[float, float]) -> tuple[Scene, float]:
    """Return the scene of the section that the answers of a rotated scene refer to, and x of a point in it, m.

    ``point``: (x, y) in m on the stator.
    """
    if not scene.crossed:
        return scene, point[0]
    group = transducer_groups(scene)[0]
    blocks, drive = {each.name: each for each in scene.transducer}, scene.drive
    alone = tuple(
        replace(blocks[each.name], center=each.center, angle=0.0, pattern=each.pattern) for each in group.transducers
    )
    if drive.sources is not None:
        names = [each.name for each in alone]
        drive = replace(drive, sources=tuple((name, size) for name, size in drive.driven.items() if name in names))
    section = replace(scene.stator, length=group.stator.length)
    return replace(scene, stator=section, transducer=alone, drive=drive), float(group.local(*point)[0])


def driven(scene: Scene):
    """Return the ``fem.Transducer`` that is driven; the first one if there are several."""
    return next(each for each in transducers(scene) if each.name == scene.drive.transducer)


def _transducer(block: Transducer, period: float):
    x, y = block.center_xy
    own = {"center": x, "center_y": y, "angle": math.radians(block.angle % 360), "period": period}
    return fem.Transducer(**block.arguments(fem.Transducer) | own)


def unturned(block: Transducer, period: float):
    """Return the ``fem.Transducer`` of a block in the axes of its waves."""
    return _transducer(replace(block, center=block.center_xy[0], angle=0.0), period)


def drive(scene: Scene):
    """Return the ``fem.Drive`` of a scene with transducers."""
    block, ladder = scene.drive, []
    for each in () if isinstance(block.match, str) else block.match:
        place, kind = each.name.split("_")  # such as series_L
        value, quality = getattr(each, each.name), math.inf if each.Q is None else each.Q
        ladder.append(fem.Element(place=place, kind=kind, value=value, quality=quality))
    return fem.Drive(sources=block.driven, impedance=block.source_impedance, match=tuple(ladder))


def diffracts(scene: Scene) -> bool:
    """Return True if finite apertures are computed for a scene, see `section_reason`."""
    return not scene.piece and spreads(scene.stator, None if scene.slider is None else scene.slider.contact_positions)


@lru_cache(64)
def spreads(block: Stator, positions: tuple | None) -> bool:
    """Return True if finite apertures are computed for contacts at ``positions`` (x, y), m; None without slider."""
    return not section_reason(block, stator(block), positions)


def section_reason(block: Stator, whole, positions) -> str:
    """Return why the plane section is used instead of the finite aperture; empty where the beam is to be computed.

    Between reflecting ends the beam takes several times as long as the section.  It is then computed by default only
    for contacts beside the axis (y != 0), because the section does not describe how the amplitude varies along y.

    Parameters
    ----------
    block : Stator
    whole : fem.Stator
        Of this block, with its meshed pieces.
    positions : sequence of (float, float) or None
        Of the contacts, m; None without a slider.
    """
    if block.diffraction is not None:
        return "" if block.diffraction else "stator.diffraction is false"
    if positions is None:
        return "stator.diffraction is absent, and the scene has no slider"
    refusal = fem.beam_refusal(whole)
    if refusal or whole.ends == "absorbing" or any(y for _, y in positions):
        return refusal
    return (
        "stator.diffraction is absent, and between reflecting ends the beam takes 2 to 4 times as long as the section; "
        "true computes it"
    )


def port_admittance(scene: Scene, frequency, tolerance: float, *, spread: bool | None = None):
    """Return the `fem.PortAdmittance` of a scene at one or several frequencies in Hz.

    ``spread``: True for finite apertures; None as `diffracts` says.
    """
    return fem.port_admittance(
        whole_stator(scene), section_transducers(scene), frequency=frequency, tolerance=tolerance,
        finite_apertures=diffracts(scene) if spread is None else spread, mirror_width=scene.stator.mirror_width,
    )  # fmt: skip
