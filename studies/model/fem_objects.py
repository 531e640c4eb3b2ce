"""The blocks of a scene as objects of ``fem``: stator, meshed pieces, transducers, drive.

It also decides whether a stator is computed as a plane section or with finite apertures (`section_reason`). The blocks
are resolved: their automatic values are numbers. `studies.model.model.Model` has these objects for a whole scene.
"""

import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import fem
from studies.model.scene_errors import stator_keys
from studies.model.solid_of_material import LOSSES, crystal, crystal_at, frequency_coefficient, reference_temperature
from studies.refusal import SceneError
from studies.scene.drive import Drive
from studies.scene.stator_keys import Piece, Stator, Transducer, wavelengths_of

ROUNDED = 1e-6  # relative change of a length by the roundings of a mesh file


def solid(block: Stator):
    """Return the stator's ``fem.Solid``, rotated to its orientation; at a temperature, in the lengths before it."""
    if block.is_steady:
        rule = 'must be a number here: "steady" is found by sawmotor run, which prints the temperature'
        raise SceneError("stator.temperature", rule)
    warm = None if block.temperature is None else crystal_at(block, block.temperature)
    with stator_keys("stator.material"):
        whole, stretch = warm or (crystal(block.material), 0.0)
        own = {name: value for name in LOSSES if (value := getattr(block, name)) is not None}
        cut = fem.rotated(replace(whole, **own) if own else whole, block.cut)
    return fem.in_cold_lengths(cut, stretch) if stretch else cut


@lru_cache(256)
def relative_frequency(block: Stator, temperature: float, frequency: float) -> float:
    """Return the frequency of a stator's surface wave at a temperature in degC, fingers fixed to it, over the cold one.

    Cold: of the constants as they are. In the lengths before the expansion velocity and frequency change alike, at the
    wavelength of the cold wave at ``frequency`` (Hz), which matters to layers alone.
    """
    coefficient = frequency_coefficient(block)
    if coefficient is not None:
        return 1.0 + coefficient * (temperature - reference_temperature(block))
    warm, cold = (stator(each) for each in (replace(block, temperature=temperature), block.cold))
    if not block.layer:
        return fem.rayleigh(warm.solid, "vacuum").velocity / fem.rayleigh(cold.solid, "vacuum").velocity
    velocity = fem.bound_wave(cold, frequency, "vacuum").velocity
    stack = [
        fem.Layer(solid=each.solid, bond=each.bond, wavelengths=each.thickness * frequency / velocity)
        for each in warm.layers
    ]
    waves = fem.layered_waves(warm.solid, stack, surface="vacuum", frequency=frequency)
    return fem.principal_wave(waves).velocity / velocity


def layers(block: Stator) -> tuple:
    """Return the ``fem.Layer`` objects of a stator block, from its material up."""
    made = []
    for index, each in enumerate(block.layer):
        warm = None if block.temperature is None else crystal_at(block, block.temperature, index)
        with stator_keys(f"stator.layer.{index}.material"):
            whole, stretch = warm or (crystal(each.material), 0.0)
            rotated = fem.rotated(whole, each.cut)
            rotated = fem.in_cold_lengths(rotated, stretch) if stretch else rotated
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


def pieces(blocks: tuple[Piece, ...], cut: Any, length: float) -> tuple:
    """Return the ``fem.MeshPiece`` objects of some blocks, one for each position.

    ``cut``: of the stator's material; ``length``: of the stator, m.
    """
    meshed = []
    for index, block in enumerate(blocks):
        path = f"piece.{index}"
        solids: tuple = ()
        for name, material in block.materials or ():
            with stator_keys(f"{path}.materials.{name}"):
                solids += ((name, fem.rotated(crystal(material), cut)),)
        try:
            mesh = _mesh(block.file, fem.LENGTH_UNITS[block.length_unit])
        except fem.MeshError as error:
            raise SceneError(f"{path}.file", f"names {error}") from None
        low, high = mesh.extent
        count = len(block.position)
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


def transducers(blocks: tuple[Transducer, ...]) -> tuple:
    """Return the ``fem.Transducer`` objects of blocks whose periods are numbers."""
    with stator_keys("transducer"):
        return tuple(_transducer(block, block.wavelength) for block in blocks)


def free_span(extents, x: float, length: float, clear: float = 0.0) -> tuple[float, float]:
    """Return the ends in m of the free surface about x.

    On either side this is the end of the stator, or a distance ``clear`` (m) before the nearest fingers.
    ``extents``: left and right end of the fingers of each transducer, m.
    """
    left = max((right + clear for _, right in extents if right <= x), default=0.0)
    return left, min((left - clear for left, _ in extents if left >= x), default=length)


def _transducer(block: Transducer, period: float):
    x, y = block.center_xy
    own: dict[str, Any] = {"center": x, "center_y": y, "angle": math.radians(block.angle % 360), "period": period}
    own["overlaps"] = block.overlaps
    return fem.Transducer(**block.arguments(fem.Transducer) | own)


def unturned(block: Transducer, period: float):
    """Return the ``fem.Transducer`` of a block in the axes of its waves."""
    return _transducer(replace(block, center=block.center_xy[0], angle=0.0), period)


def drive(block: Drive):
    """Return the ``fem.Drive`` of a block."""
    ladder = []
    for each in () if isinstance(block.match, str) else block.match:
        place, kind = each.name.split("_")  # such as series_L
        value, quality = getattr(each, each.name), math.inf if each.Q is None else each.Q
        ladder.append(fem.Element(place=place, kind=kind, value=value, quality=quality))
    return fem.Drive(sources=block.driven, impedance=block.source_impedance, match=tuple(ladder))


def section_reason(block: Stator, whole, positions, transducers: tuple = ()) -> str:
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
    transducers : tuple
        Blocks or ``fem.Transducer`` objects, some of which may be apodised or slanted.
    """
    if block.diffraction is not None:
        return "" if block.diffraction else "stator.diffraction is false"
    if positions is None:
        return "stator.diffraction is absent, and the scene has no slider"
    refusal = fem.beam_refusal(whole)
    if not refusal and whole.ends != "absorbing" and not all(each.uniform_along_y for each in transducers):
        return "between reflecting ends the beams of strips are not computed"
    if refusal or whole.ends == "absorbing" or any(y for _, y in positions):
        return refusal
    return (
        "stator.diffraction is absent, and between reflecting ends the beam takes 2 to 4 times as long as the section; "
        "true computes it"
    )
