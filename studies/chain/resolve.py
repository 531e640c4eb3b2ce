"""Resolution of a scene: numbers for its automatic values, and its blocks as objects of ``fem``.

``period = "auto"``, ``frequency = "center"``, ``preload = "weight"`` and ``ball = "steel"`` are replaced by numbers, so
that the scene that is stored with a result can be run again with the same numbers.  Rules that need physics (an unknown
material, an impossible layout) are checked here.
"""

import itertools
import math
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import fem
from studies.chain.solver_errors import stator_keys
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.blocks import LENGTHS, Element, IsotropicSolid, PiezoelectricSolid, Stator, Transducer
from studies.scene.keys import tolerances
from studies.scene.slider import Slider

MAX_BURST_SECONDS = 3600.0  # largest time to compute one burst, on one processor
# Time in s to compute one cycle of the wave, by method, measured on a 2-core x86_64 machine.
CYCLE_SECONDS = {"hysteretic": 6e-4, "exact": 1.4e-4, "stepped": 4.5e-6, "averaged": 5e-7}
ROUNDED = 1e-6  # relative change of a length by the roundings of a mesh file
MATCH_TOLERANCE = 1e-3  # of the admittance; an error e of it reflects e^2 / 4 of the power


def resolved(scene: Scene, *, spread: bool | None = None) -> Scene:
    """Return the scene with numbers for its automatic values; SceneError if material, moduli or layout are impossible.

    ``spread``: True if the admittances for an automatic match are those of finite apertures; by default the scene
    decides.
    """
    if scene.stator is not None:
        if scene.transducer:
            scene = _with_source_numbers(scene)
        _check_layout(scene)
        refuse_gaps(scene)
        if scene.crossed:
            scene = replace(scene, stator=replace(scene.stator, diffraction=True))
        if scene.transducer:
            scene = _with_circuit(scene, spread)
    if scene.slider is None:
        return scene
    if scene.burst is not None:
        refuse_endless_burst(scene, scene.frequency)
    scene = replace(scene, slider=resolved_slider(scene.slider, scene.stator))
    if scene.slider.pillars is not None:
        from studies.chain.pillars import check_pillars

        check_pillars(scene)
    tolerances(scene)
    return scene


def resolved_slider(slider: Slider, stator: Stator | Any) -> Slider:
    """Return a slider with its preload and its moduli as numbers, those of a named ball on this stator."""
    slider = replace(slider, preload=slider.preload_force)
    if slider.pillars is not None:
        from studies.chain.pillars import resolved_pillars

        slider = replace(resolved_pillars(slider), shape="punch")
    if slider.ball is None:
        return slider
    from studies.chain.moduli import pair_moduli

    normal, tangential = pair_moduli(slider.ball, solid(stator))
    return replace(slider, ball=None, effective_modulus=normal, tangential_modulus=tangential)


def solid(block: Stator):
    """Return the stator's ``fem.Solid``, rotated to its orientation."""
    with stator_keys("stator.material"):
        crystal = _crystal(block.material)
        own = _given(block, "mechanical_quality", "dielectric_loss")
        return fem.rotated(replace(crystal, **own) if own else crystal, block.orientation)


def surface_velocity(block: Stator) -> float:
    """Return the velocity of the Rayleigh wave under a bare surface without charge (D_n = 0), m/s."""
    return fem.rayleigh(solid(block), "open").velocity


def _crystal(material: str | PiezoelectricSolid | IsotropicSolid):
    """Return the ``fem.Solid`` of a name of the catalogue or of a table, in the crystal's frame."""
    if isinstance(material, PiezoelectricSolid):
        return fem.anisotropic(**_given(material, *keys_of(PiezoelectricSolid)))
    if isinstance(material, IsotropicSolid):
        return fem.isotropic(**_given(material, *keys_of(IsotropicSolid)))
    return fem.material(material)


def stator(block: Stator):
    """Return the ``fem.Stator`` of a stator block."""
    rotated, own = solid(block), _given(block, "length", "bottom", "ends", "above")
    thickness = math.inf if block.thickness == "half-space" else block.thickness
    with stator_keys("stator"):
        return fem.Stator(solid=rotated, thickness=thickness, **own)


def whole_stator(scene: Scene):
    """Return the ``fem.Stator`` of a scene with its meshed pieces."""
    return replace(stator(scene.stator), pieces=pieces(scene)) if scene.piece else stator(scene.stator)


def pieces(scene: Scene) -> tuple:
    """Return the ``fem.MeshPiece`` objects of a scene, one for each place."""
    meshed = []
    for index, block in enumerate(scene.piece):
        path = f"piece.{index}"
        solids = tuple(
            (name, _piece_solid(material, scene.stator, f"{path}.materials.{name}"))
            for name, material in block.materials or ()
        )
        try:
            mesh = _mesh(block.file, LENGTHS[block.length_unit])
        except fem.MeshError as error:
            raise SceneError(f"{path}.file", f"names {error}") from None
        low, high = mesh.extent
        count, length = len(block.position), scene.stator.length
        if count > 1 and count * (high - low) > (1 + ROUNDED) * length:
            rule = f"must name at most as many places as fit on the stator, {length * 1e3:g} mm long"
            raise SceneError(f"{path}.position", f"{rule}, got {count} of a mesh {(high - low) * 1e3:.6g} mm wide")
        meshed += [
            fem.MeshPiece(name=block.label, mesh=mesh, position=place, solids=solids, electrodes=block.electrodes or ())
            for place in block.position
        ]
    return tuple(meshed)


def _mesh(file: str, unit: float):
    """Return the ``fem.SectionMesh`` of a file as it is now."""
    path = Path(file)
    stamp = path.stat().st_mtime_ns if path.is_file() else 0
    return _read_mesh(file, unit, stamp)


@lru_cache(32)
def _read_mesh(file: str, unit: float, stamp: int):
    return fem.read_mesh(file, unit)


def _piece_solid(material, block: Stator, path: str):
    """Return the ``fem.Solid`` of a surface group of a mesh, in the orientation of the stator."""
    with stator_keys(path):
        return fem.rotated(_crystal(material), block.orientation)


def transducers(scene: Scene) -> tuple:
    """Return the ``fem.Transducer`` objects of a scene whose periods are numbers."""
    with stator_keys("transducer"):
        return tuple(_transducer(block, block.wavelength) for block in scene.transducer)


def free_span(rows, x: float, length: float, clear: float = 0.0) -> tuple[float, float]:
    """Return the ends in m of the free surface about x: those of the stator, or ``clear`` from the fingers before them.

    ``rows``: left and right end of each row of fingers.
    """
    left = max((right + clear for _, right in rows if right <= x), default=0.0)
    return left, min((left - clear for left, _ in rows if left >= x), default=length)


def section_row(scene: Scene) -> tuple:
    """Return `transducers` for models with a single section along x; a SceneError if some lie on other lines."""
    if scene.crossed:
        rule = "must all have the angle 0 and y = 0 here: this answer is that of one section along x"
        raise SceneError("transducer", f"{rule}; sawmotor run, sweep and view accept rotated ones")
    return transducers(scene)


def rows(scene: Scene) -> tuple:
    """Return the `fem.rows_of` a scene with turned transducers."""
    return fem.rows_of(stator(scene.stator), scene.stator.width, transducers(scene), drive(scene))


def first_row(scene: Scene, place: tuple[float, float]) -> tuple[Scene, float]:
    """Return the scene of the section that the answers of a rotated scene refer to, and the position of a point in it.

    ``place``: (x, y) in m; its position along the section is in m.
    """
    if not scene.crossed:
        return scene, place[0]
    row = rows(scene)[0]
    blocks, drive = {each.name: each for each in scene.transducer}, scene.drive
    alone = tuple(
        replace(blocks[each.name], center=each.center, angle=0.0, pattern=each.pattern) for each in row.transducers
    )
    sources = tuple((name, size) for name, size in drive.driven.items() if name in [each.name for each in alone])
    return replace(
        scene,
        stator=replace(scene.stator, length=row.stator.length),
        transducer=alone,
        drive=replace(drive, sources=sources) if drive.sources is not None else drive,
    ), float(row.local(*place)[0])


def driven(scene: Scene):
    """Return the ``fem.Transducer`` that is driven; the first one if there are several."""
    return next(each for each in transducers(scene) if each.name == scene.drive.transducer)


def _transducer(block: Transducer, period: float):
    (x, y), alike = block.place, "name finger_pairs metallisation aperture termination pattern split".split()
    own = {name: getattr(block, name) for name in alike}
    return fem.Transducer(center=x, center_y=y, angle=math.radians(block.angle % 360), period=period, **own)


def _alone(block: Transducer, period: float):
    """Return the ``fem.Transducer`` of a block in the axes of its waves."""
    return _transducer(replace(block, center=block.place[0], angle=0.0), period)


def drive(scene: Scene):
    """Return the ``fem.Drive`` of a scene with transducers."""
    return fem.Drive(
        sources=scene.drive.driven, impedance=scene.drive.source_impedance, match=_ladder(scene.drive.match)
    )


def _ladder(match: str | tuple) -> tuple:
    """Return the ``fem.Element`` objects of a ladder as read."""
    elements = []
    for each in () if isinstance(match, str) else match:
        place, kind = each.name.split("_")
        value, quality = getattr(each, each.name), math.inf if each.Q is None else each.Q
        elements.append(fem.Element(place=place, kind=kind, value=value, quality=quality))
    return tuple(elements)


def diffracts(scene: Scene) -> bool:
    """Return True if finite apertures are computed: as the scene requests, or by default if it has a slider."""
    return not scene.piece and spreads(scene.stator, None if scene.slider is None else scene.slider.places)


@lru_cache(64)
def spreads(block: Stator, places: tuple | None) -> bool:
    """Return True if finite apertures are computed for contacts at places (x, y); ``places`` is None without slider."""
    return not section_reason(block, stator(block), places)


def section_reason(block: Stator, whole, places) -> str:
    """Return why the plane section stands for the finite aperture; empty where the beam is to be computed.

    Contacts beside the axis, y != 0 in ``places`` (x, y), lie where the beam's amplitude varies along y, which the
    section does not describe.  Between reflecting ends the beam takes several times as long as the section, and it is
    computed by default only for such contacts.

    Parameters
    ----------
    block : Stator
    whole : fem.Stator
        Of this block, with its meshed pieces.
    places : sequence of (float, float) or None
        Of the contacts, m; None without a slider.
    """
    if block.diffraction is not None:
        return "" if block.diffraction else "stator.diffraction is false"
    if places is None:
        return "stator.diffraction is absent, and the scene has no slider"
    refusal = fem.beam_refusal(whole)
    if refusal or whole.ends == "absorbing" or any(y for _, y in places):
        return refusal
    return (
        "stator.diffraction is absent, and between reflecting ends the beam takes 2 to 4 times as long as the section; "
        "true computes it"
    )


def port_admittance(scene: Scene, frequency, tolerance: float, *, spread: bool | None = None):
    """Return the `fem.PortAdmittance` of a scene at one or several frequencies in Hz, one for all its answers."""
    return fem.port_admittance(
        whole_stator(scene),
        section_row(scene),
        frequency=frequency,
        tolerance=tolerance,
        finite_apertures=diffracts(scene) if spread is None else spread,
        mirror_width=scene.stator.mirror_width,
    )


def _with_circuit(scene: Scene, spread: bool | None) -> Scene:
    """Return the scene with voltages for its powers, the load of a receiver, and the elements of an automatic match."""
    old_drive = scene.drive
    if old_drive.power is not None:
        scene = replace(scene, drive=replace(old_drive, voltage=old_drive.levels, power=None))
    recovery = old_drive.recovery
    matched = recovery is not None and recovery.rectifier is None and recovery.load == "matched"
    if not matched and old_drive.match != "auto":
        return _with_load(scene)
    with stator_keys("drive.match"):
        ports = port_admittance(scene, scene.frequency, MATCH_TOLERANCE, spread=spread)
    about = (ports.matrix, ports.names)
    if recovery is not None:
        load = None
        if matched:
            auto = old_drive.match == "auto"
            with stator_keys("drive.recovery.load"):
                load = fem.matched_load(
                    *about, transducers(scene), drive(scene), recovery.receiver, scene.frequency, source_matched=auto
                )
        scene = _with_load(scene, load)
    if old_drive.match == "auto":
        seen = fem.solve_circuit(*about, transducers(scene), old_drive.transducer, scene.frequency).admittance
        with stator_keys("drive.match"):
            ladder = fem.best_match(complex(old_drive.source_impedance), seen, scene.frequency)
        elements = tuple(Element(**{f"{each.place}_{each.kind}": each.value}) for each in ladder) or "none"
        scene = replace(scene, drive=replace(scene.drive, match=elements))
    return scene


def _with_load(scene: Scene, load: complex | None = None) -> Scene:
    """Return the scene with the load of ``drive.recovery`` as the receiver's termination; ``load``: of "matched"."""
    recovery = scene.drive.recovery
    if recovery is None:
        return scene
    recovery = replace(recovery, load=load or recovery.rectifier_load or recovery.load)
    row = tuple(
        replace(each, termination=recovery.load) if each.name == recovery.receiver else each
        for each in scene.transducer
    )
    return replace(scene, transducer=row, drive=replace(scene.drive, recovery=recovery))


def _with_source_numbers(scene: Scene) -> Scene:
    """Return the scene with the periods, or the frequency, that give the strongest wave (fem/solve/passband.py)."""
    block = stator(scene.stator)
    if "phi" not in fem.fields(block.solid):
        rule = f"must be absent on {block.solid.name}: it is not piezoelectric in this orientation"
        raise SceneError("transducer", rule)
    with stator_keys("drive.frequency"):
        if scene.drive.frequency == "center":
            driven = scene.driven_transducer
            frequency = fem.best_frequency(block, _alone(driven, driven.wavelength))
            return replace(scene, drive=replace(scene.drive, frequency=frequency))

    def with_period(each: Transducer) -> Transducer:
        if not isinstance(each.period, str):
            return each
        if each.period == "auto" and each.has_two_combs:
            period = fem.best_period(block, _alone(each, 1.0), scene.frequency)
        else:
            bulk = replace(scene.stator, thickness="half-space")
            period = _half_space_period(bulk, scene.frequency, each.metallisation)
        return replace(each, period=float(period))

    with stator_keys("transducer.period"):
        return replace(scene, transducer=tuple(with_period(each) for each in scene.transducer))


@lru_cache(256)  # points of a sweep or a search share most of them
def _half_space_period(block: Stator, frequency: float, metallisation: float) -> float:
    return fem.automatic_period(solid(block), frequency, metallisation)


def _check_layout(scene: Scene) -> None:
    block, row = whole_stator(scene), transducers(scene)
    with stator_keys("transducer", [each.name for each in row], [each.label for each in scene.piece]):
        if not scene.crossed:
            fem.check_layout(block, row)
            return
        fem.check_plan(block, scene.stator.width, row)
    if not fem.isotropic_about_normal(block.solid):
        rule = "may be rotated, or stand beside the middle line, only in solids isotropic about z, unlike this cut of"
        raise SceneError("transducer", f"{rule} {block.solid.name}")
    refuse_covered(scene)


def refuse_gaps(scene: Scene) -> None:
    """Raise a SceneError if a contact lies on a meshed piece where this has no plain surface."""
    if scene.slider is None or not scene.piece:
        return
    reached = [(x, x) for x, _ in scene.slider.places]
    if scene.slider.pillars is not None:
        from studies.chain.pillars import extent

        reached = [extent(scene.slider)]
    for each in pieces(scene):
        for (low, high), (left, right) in itertools.product(each.gaps, reached):
            if left < high and right > low:
                rule = f"must keep the contacts off {each.name!r} from {low * 1e3:g} to {high * 1e3:g} mm, where it has"
                got = f"{left * 1e3:g}" + (f" to {right * 1e3:g}" if right > left else "")
                raise SceneError("slider.position", f"{rule} no plain surface at z = 0, got some at {got} mm")


def refuse_covered(scene: Scene) -> None:
    """Raise a SceneError if a contact lies on a rotated transducer."""
    row = transducers(scene)
    for place in () if scene.slider is None else scene.slider.places:
        for each, block in zip(row, scene.transducer, strict=True):
            if block.turned and fem.covers(each, place):
                where = f"({place[0] * 1e3:g}, {place[1] * 1e3:g}) mm"
                raise SceneError("slider.position", f"must keep the contacts off {each.name!r}, got one at {where}")


def refuse_endless_burst(scene: Scene, frequency: float) -> None:
    """Raise a SceneError if a burst takes longer than an hour to compute; the message names the longest duration."""
    slider = scene.slider
    every_event = slider.remembers or slider.reciprocal or slider.stick_band > 0
    method = slider.method if slider.method in CYCLE_SECONDS else "averaged" if scene.wave is not None else "stepped"
    if every_event and method != "stepped":
        method = "hysteretic" if slider.remembers else "exact"
    longest = MAX_BURST_SECONDS / CYCLE_SECONDS[method] / frequency
    if scene.burst > longest:
        cycles = scene.burst * frequency
        hours = cycles * CYCLE_SECONDS[method] / 3600
        rule = f"must be at most {longest:.3g} s: {cycles:.3g} cycles would take {hours:.3g} hours"
        raise SceneError(f"{scene.source_key}.burst", f"{rule}, got {scene.burst:g} s; the steady state needs no burst")


def _given(block, *names: str) -> dict:
    """Return the keys of a block that are present, with their values."""
    return {name: getattr(block, name) for name in names if getattr(block, name) is not None}
