"""Consistency of the blocks of a scene: each check yields the key and the rule of what it refuses."""

import math
from collections.abc import Iterator

import fem
from studies.refusal import nearest, shown
from studies.scene.plane_keys import check_scene as check_plane

MIN_COSINE = 0.7  # of the angle between x and the wave of at least one driven transducer
NOT_DRIVEN = "must be absent without a [[transducer]]: nothing is driven"
Refused = Iterator[tuple[str, str]]


def _mm(length: float) -> str:
    return f"{length * 1e3:g} mm"


def check_uncertain(scene) -> Refused:
    """Refuse tolerances without a slider, whose velocity has the bands."""
    if scene.uncertain is not None and scene.slider is None:
        yield "uncertain", "needs a [slider]: its bands are those of the velocity"


def check_prescribed_wave(scene) -> Refused:
    """Require a stator or a prescribed wave; with a wave, refuse what needs a stator."""
    if scene.wave is None:
        if scene.stator is None:
            yield "stator", "is missing: a scene needs a [stator] with a [drive], or a [wave] with a [slider]"
        return
    blocks = ("stator", "transducer", "piece", "drive")
    computed = [f"[{key}]" for key in blocks if getattr(scene, key) not in (None, ())]
    if computed:
        yield "wave", f"must not stand beside {', '.join(computed)}: the surface motion is prescribed or computed"
    slider = scene.slider
    if slider is None:
        yield "slider", "is missing: with a [wave] only the slider is computed"
        return
    if slider.position is not None:
        yield "slider.position", "must be absent with [wave]: the motion is prescribed at the slider"
    if slider.ball is not None:
        yield "slider.ball", "must be absent with [wave]: there is no stator; give both moduli in Pa"
    if slider.pillars is not None:
        yield from _pillars_on_prescribed_wave(scene.wave, slider)
    elif slider.planar and not isinstance(slider.contacts, int):
        if scene.wave.wavelength is None:
            yield "wave.wavelength", "is required and missing: the contacts stand at different positions"
    elif not isinstance(slider.contacts, int):
        yield "slider.contacts", "must be a number with [wave]: offsets need a wavelength, of a [stator]"


def _pillars_on_prescribed_wave(wave, slider) -> Refused:
    """Require the wavelength of pillars at different positions, and Gamma where they load the wave."""
    one_row = slider.pillars.file is None and slider.pillars.counts[0] == 1
    if wave.wavelength is None and (slider.loading or not one_row):
        yield "wave.wavelength", "is required and missing: [slider.pillars] stand at different positions along x"
    if slider.loading and wave.compliance is None:
        rule = "is required and missing where slider.loading is true: Gamma of the surface, such as 2.5e-12 1/Pa"
        yield "wave.compliance", rule


def check_drive(scene) -> Refused:
    """Require what drives the transducers, and nothing more."""
    drive, names = scene.drive, [each.name for each in scene.transducer]
    if scene.wave is not None or scene.stator is None:
        return
    if drive is None:
        yield "drive", "is missing: a [stator] needs the [drive] block with its frequency"
        return
    level = "voltage" if drive.power is None else "power"
    source = "transducer" if drive.sources is None else "sources"
    if not names:
        keys = {"match": drive.match != "none", source: drive.driven, level: getattr(drive, level) is not None}
        for key, present in keys.items():
            if present:
                yield f"drive.{key}", NOT_DRIVEN
        if drive.frequency == "center":
            yield "drive.frequency", 'must be a number in Hz without a transducer, got "center"'
        return
    for key, allowed in ((source, f"one of {', '.join(map(shown, names))}"), (level, "peak values in V")):
        if getattr(drive, key) is None:
            yield f"drive.{key}", f"is required and missing: the scene has transducers; give {allowed}"
    for name in drive.driven:
        if name not in names:
            rule = f"must name one of the transducers, got {shown(name)}"
            yield f"drive.{source}", rule + nearest(name, names)
    for index, each in enumerate(scene.transducer):
        if drive.frequency == "center" and isinstance(each.period, str):
            rule = f'must be a length in m where drive.frequency is "center", got {shown(each.period)}'
            yield f"transducer.{index}.period", rule


def check_recovery(scene) -> Refused:
    """Require a receiver that is not driven and has no load of its own."""
    if scene.drive is None or scene.drive.recovery is None or scene.stator is None:
        return
    recovery, names = scene.drive.recovery, [each.name for each in scene.transducer]
    others = [name for name in names if name not in scene.drive.driven]
    if recovery.receiver not in others:
        rule = f"must name a transducer that is not driven, got {shown(recovery.receiver)}"
        yield "drive.recovery.receiver", rule + nearest(recovery.receiver, others)
        return
    index = names.index(recovery.receiver)
    if scene.transducer[index].termination not in ("open", recovery.load):
        rule = "must be absent on the receiving transducer: drive.recovery has its load"
        yield f"transducer.{index}.termination", rule


def check_transducers(scene) -> Refused:
    """Require different names and positions on the stator; ``fem`` checks where the fingers end."""
    if scene.wave is not None or scene.stator is None:
        return
    stator, repeated = scene.stator, dict(fem.repeated_names(scene.transducer))
    for index, each in enumerate(scene.transducer):
        if index in repeated:
            yield f"transducer.{index}.name", repeated[index]
        at, x = f"transducer.{index}", each.center_xy[0]
        if each.aperture > stator.width:
            yield f"{at}.aperture", f"must be at most stator.width, {_mm(stator.width)}, got {_mm(each.aperture)}"
        if rule := fem.fingers_off_stator(x, x, stator.length):
            yield f"{at}.center", rule


def check_strips(scene) -> Refused:
    """Refuse what apodised and slanted transducers do not take."""
    if scene.stator is None:
        return
    for index, each in enumerate(scene.transducer):
        if each.uniform_along_y:
            continue
        key = f"transducer.{index}.{'apodisation' if each.apodisation is not None else 'slant'}"
        if scene.crossed:
            yield key, f"must be absent {fem.TURNED}: strips lie along x"
        if scene.piece:
            yield key, "must be absent with a [[piece]], which is as wide as the stator"
        if scene.stator.sides == "mirror":
            yield key, "must be absent with stator.sides = mirror: the beams of strips take no images"
        if scene.source.burst is not None:
            yield (
                key,
                f"must be absent with {scene.source.block}.burst: each strip rings up by itself and a common circuit "
                "couples them, so that the growth of the wave would take all strips at some hundred frequencies; drive "
                "steadily, or burst the plain transducer of the same period and fingers",
            )


def check_turned(scene) -> Refused:
    """Refuse rotated or off-axis transducers where their beams cannot be computed."""
    if scene.stator is None or not scene.crossed:
        return
    stator = scene.stator
    yield from fem.turned_rules(stator.ends, stator.sides)
    if stator.diffraction is False:
        yield "stator.diffraction", f"must be true or absent {fem.TURNED}: a plane section has no y"


def check_electrodes(scene) -> Refused:
    """Require fingers of both electrodes where a transducer has a voltage."""
    if scene.drive is None:
        return
    driven, recovery = scene.drive.driven, scene.drive.recovery
    for index, each in enumerate(scene.transducer):
        receives = recovery is not None and each.name == recovery.receiver
        if not each.has_two_electrodes and (each.name in driven or receives or scene.crossed):
            where = fem.TURNED
            if each.name in driven or receives:
                where = f"on the {'driven' if each.name in driven else 'receiving'} transducer"
            yield f"transducer.{index}.pattern", fem.one_electrode(where, each.pattern)


def check_direction(scene) -> Refused:
    """Refuse sources that would move the slider along y."""
    if scene.slider is None or scene.slider.planar or scene.drive is None or not scene.crossed:
        return
    driven = [each for each in scene.transducer if scene.drive.driven.get(each.name)]
    if driven and all(abs(math.cos(math.radians(each.angle))) < MIN_COSINE for each in driven):
        names = ", ".join(f"{each.name!r} at {each.angle:g} deg" for each in driven)
        rule = "must drive a transducer within 45 deg of x: the contact is one-dimensional, and the slider would"
        key = "transducer" if scene.drive.sources is None else "sources"
        yield f"drive.{key}", f'{rule} be moved across by {names}; or choose slider.freedom = "xy"'


def check_slider(scene) -> Refused:
    """Require contacts on a stator that is driven."""
    slider, stator = scene.slider, scene.stator
    if scene.wave is not None or slider is None or stator is None:
        return
    if scene.transducer == ():
        yield "slider", "must be absent without a [[transducer]] or a [wave]: nothing drives it"
    if slider.position is None:
        yield "slider.position", "is required and missing: where on the [stator] the slider stands, in m"
        return
    positions = [x for x, _ in slider.contact_positions]
    for x in sorted({min(positions), max(positions)}):
        if not 0 <= x <= stator.length:
            rule = f"must keep the contacts on the stator, 0 to {_mm(stator.length)}"
            yield "slider.position", f"{rule}, got {_mm(slider.center[0])}, a contact at {_mm(x)}"
    beside, half = max((y for _, y in slider.contact_positions), key=abs), stator.width / 2
    if abs(beside) > half:
        rule = f"must keep the contacts on the stator, y from {-half * 1e3:g} to {_mm(half)}"
        yield "slider.position", f"{rule}, got a contact at y = {_mm(beside)}"


def check_pieces(scene) -> Refused:
    """Refuse meshed pieces without a section along x."""
    if not scene.piece:
        return
    if scene.wave is not None or scene.stator is None:
        yield "piece", "must be absent without a [stator]: it is a part of its section"
        return
    if scene.crossed:
        yield "piece", f"must be absent {fem.TURNED}"
    if scene.stator.diffraction:
        rule = "must be false or absent with a [[piece]]: the field in three dimensions of a mesh is not computed"
        yield "stator.diffraction", rule
    for index, each in enumerate(scene.piece):
        if len(set(each.position)) < len(each.position):
            yield f"piece.{index}.position", f"must name different positions, got {shown(list(each.position))}"


def check_layers(scene) -> Refused:
    """Require fingers at one interface of the layers, and refuse what is computed in one solid alone."""
    if scene.stator is None:
        return
    layers, planes = len(scene.stator.layer), [each.plane for each in scene.transducer]
    for index, plane in enumerate(planes):
        key = f"transducer.{index}.plane"
        if rule := fem.plane_rule(0 if plane == "surface" else plane, layers):
            yield key, f"{rule}, got {plane}"
        elif plane != planes[0]:
            yield key, f"must be the same for all transducers, {shown(planes[0])}, got {shown(plane)}"
    if not layers:
        return
    if scene.piece:
        yield "piece", "must be absent with layers: the section beside a mesh is one solid"
    if scene.crossed:
        yield "stator.layer", f"must be absent {fem.TURNED}: beams are those of one solid"
    if scene.drive is not None and scene.drive.frequency == "center":
        for index, each in enumerate(scene.stator.layer):
            if isinstance(each.thickness, str):
                rule = 'must be a length in m where drive.frequency is "center": the wavelength is not known'
                yield f"stator.layer.{index}.thickness", f"{rule}, got {shown(each.thickness)}"


CHECKS = (
    check_uncertain,
    check_prescribed_wave,
    check_drive,
    check_recovery,
    check_transducers,
    check_electrodes,
    check_turned,
    check_strips,
    check_direction,
    check_slider,
    check_pieces,
    check_layers,
    check_plane,
)  # in the order in which their refusals are printed
