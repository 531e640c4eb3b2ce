"""Resolution of a scene: numbers for its automatic values, and the checks of a scene that need physics.

``period = "auto"`` and ``"half-space"``, ``frequency = "center"``, ``match = "auto"``, ``load = "matched"``,
``preload = "weight"`` and ``ball = "steel"`` are replaced by numbers, and an absent ``slider.law`` by its name, so that
the scene that is stored with a result can be run again with the same numbers.  Where numbers are changed afterwards
(tolerances, fits, sensitivities), weight, ball and law keep following them (`following`), and a scene stored with
[uncertain] keeps "weight".
``slider.method = "auto"`` is not replaced: the contact chooses its method (contact/choice.py).  Rules that need physics
(an unknown material, an impossible layout) are checked here.
"""

import itertools
import logging
import math
from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import fem
from fem.parameters import refuses
from studies.model.contact_moduli import pair_moduli
from studies.model.contacts_of import contacts_of
from studies.model.fem_objects import layers, stator, unturned
from studies.model.model import Model
from studies.model.scene_errors import stator_keys
from studies.model.solid_of_material import crystal, crystal_at, reference_temperature, thermal_table
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.drive import Element
from studies.scene.keys import tolerances
from studies.scene.slider_keys import Slider
from studies.scene.stator_keys import Stator, Transducer

LOGGER = logging.getLogger(__name__)

MAX_BURST_SECONDS = 3600.0  # largest time to compute one burst, on one processor
# Time in s to compute one cycle of the wave, by method, measured on a 2-core x86_64 machine. In the plane the averaged
# motion of one ball takes as long, 0.5 s of 1 s at 2.2 MHz; fewer cycles are followed by their events.
CYCLE_SECONDS = {"hysteretic": 6e-4, "exact": 1.4e-4, "stepped": 4.5e-6, "averaged": 5e-7}
MODULI = ("effective_modulus", "tangential_modulus")  # of the slider; they follow from a named ball
# m/s: surface waves of solids are faster than the first, those of stators are about as fast as the second
SLOW_WAVE, USUAL_WAVE = 500.0, 3000.0
PREFIXES = (("kHz", 1e3), ("MHz", 1e6), ("GHz", 1e9))
ATOM = 1e-10  # m; a film of 1e-9 wavelengths errs by 2e-6 of the velocity, of 1e-6 by 1e-8, by rounding in its element
MAX_LAYER = 3.0  # wavelengths; a thicker layer holds the whole wave
MATCH_TOLERANCE = 1e-3  # of the admittance; an error e of it reflects e^2 / 4 of the power


def build(scene: Scene) -> Model:
    """Return the model of a scene, `with_numbers`."""
    return with_numbers(Model(scene))


def with_numbers(model: Model, *, spread: bool | None = None) -> Model:
    """Return a model with numbers for the automatic values of its scene, which it keeps as ``written``.

    ``spread``: True if the admittances for an automatic match are those of finite apertures; by default the scene
    decides. Automatic values are those of the constants without ``stator.temperature``: a motor is built once.

    Raises
    ------
    SceneError
        If material, moduli or layout are impossible.
    """
    _check_temperature(model)
    model = replace(model, written=model.scene)
    return _built(model.cold, spread).at_temperature_of(model)


def resolved(scene: Scene) -> Scene:
    """Return the scene of its model: with numbers for its automatic values."""
    return build(scene).scene


@refuses(SceneError)
def _check_temperature(model: Model) -> Iterator[Any]:
    """Refuse a temperature whose effect is not known, or a steady one of a stator that has none."""
    scene, block = model.scene, model.scene.stator
    if block is None or block.temperature is None:
        return
    if not block.is_steady:
        model.solid  # noqa: B018  a cached property, which refuses it
        layers(block)
        return
    material = thermal_table(block.material)
    missing = {
        "needs a drive, whose heat it follows": not scene.transducer,
        "needs a plate: a half-space never becomes steady": block.thickness == "half-space",
        f"needs a conductivity, and {crystal(block.material).name} has none": material.get("conductivity") is None,
    }
    if scene.transducer:
        lone = scene.drive.burst is not None and scene.drive.duty is None
        missing["needs drive.duty beside drive.burst: a lone burst has no steady temperature"] = lone
    for rule, wrong in missing.items():
        if wrong:
            yield "stator.temperature", f'of "steady" {rule}'
    for layer in (None, *range(len(block.layer))):
        crystal_at(block, reference_temperature(block), layer)


def _built(model: Model, spread: bool | None) -> Model:
    if model.scene.stator is not None:
        model = _with_thicknesses(model)
        if model.scene.transducer:
            _refuse_long_waves(model.scene)
            model = _with_source_numbers(model)
        _check_layout(model)
        if model.scene.crossed:
            model = model.with_blocks(stator=replace(model.scene.stator, diffraction=True))
    if model.scene.slider is not None:
        model = model.with_blocks(slider=resolved_slider(model.scene.slider, model.scene.stator))
        check_slider(model)
    if model.scene.transducer:
        model = _with_circuit(model, spread)
    if model.scene.slider is not None:
        tolerances(model.scene)
    source = model.scene.source
    if source is not None and source.waveform is not None:
        from studies.record.waveform import modulation  # imports contact's envelopes and the reader of files

        modulation(model.scene)  # refuses a file that cannot be read before anything is solved
    return model


def resolved_slider(slider: Slider, block: Stator | Any) -> Slider:
    """Return a slider with its preload and its moduli as numbers, those of a named ball on this stator."""
    slider = contacts_of(slider).resolved(replace(slider, preload=slider.preload_force, law=slider.tangential_law))
    if slider.ball is None:
        return slider
    normal, tangential = pair_moduli(slider.ball, stator(block).solids[-1])
    return replace(slider, ball=None, effective_modulus=normal, tangential_modulus=tangential)


def following(scene: Scene, written: Scene) -> Scene:
    """Return a resolved scene whose preload and moduli follow from other numbers again, where they do as ``written``.

    A preload of "weight" follows the mass and gravity, the moduli of a named ball follow the stator's solid.  A period,
    a frequency, a match or a load that the program has chosen stays as it is, like that of a motor that has been built.
    """
    if scene.slider is None:
        return scene
    keys = ("preload", "ball", "law", *MODULI)
    return replace(scene, slider=replace(scene.slider, **{key: getattr(written.slider, key) for key in keys}))


def _with_circuit(model: Model, spread: bool | None) -> Model:
    """Return the model with voltages for its powers, the load of a receiver, and the elements of an automatic match."""
    old_drive = model.scene.drive
    if old_drive.power is not None:
        model = model.with_blocks(drive=replace(old_drive, voltage=old_drive.levels, power=None))
    recovery, frequency = old_drive.recovery, model.scene.frequency
    matched = recovery is not None and recovery.rectifier is None and recovery.load == "matched"
    if not matched and old_drive.match != "auto":
        return _with_load(model)
    with stator_keys("drive.match"):
        ports = model.port_admittance(frequency, MATCH_TOLERANCE, spread=spread)
    matrix, names, auto = ports.matrix, ports.names, old_drive.match == "auto"
    load = None
    if recovery is not None and matched:
        with stator_keys("drive.recovery.load"):
            load = fem.matched_load(
                matrix, names, model.transducers, model.drive, recovery.receiver, frequency, source_matched=auto
            )
    model = _with_load(model, load)
    if auto:
        seen = fem.solve_circuit(matrix, names, model.transducers, old_drive.transducer, frequency).admittance
        with stator_keys("drive.match"):
            ladder = fem.best_match(complex(old_drive.source_impedance), seen, frequency)
        elements = tuple(Element(**{f"{each.place}_{each.kind}": each.value}) for each in ladder) or "none"
        model = model.with_blocks(drive=replace(model.scene.drive, match=elements))
    return model


def _with_load(model: Model, load: complex | None = None) -> Model:
    """Return the model with the load of ``drive.recovery`` as the receiver's termination, ``load`` for "matched"."""
    drive = model.scene.drive
    recovery = drive.recovery
    if recovery is None:
        return model
    recovery = replace(recovery, load=load or recovery.rectifier_load or recovery.load)
    loaded = tuple(
        replace(each, termination=recovery.load) if each.name == recovery.receiver else each
        for each in model.scene.transducer
    )
    return model.with_blocks(transducer=loaded, drive=replace(drive, recovery=recovery))


@refuses(SceneError)
def _refuse_long_waves(scene: Scene) -> Iterator[Any]:
    """Refuse a frequency whose wave is too long for fingers of an automatic period, and ask for the probable unit."""
    length, frequency = scene.stator.length, scene.drive.frequency
    pairs = max((each.finger_pairs for each in scene.transducer if isinstance(each.period, str)), default=0)
    if isinstance(frequency, str) or pairs * SLOW_WAVE / frequency <= length:
        return
    units = [name for name, factor in PREFIXES if 4 * pairs * USUAL_WAVE / (frequency * factor) <= length]
    meant = f': did you mean "{frequency:g} {units[0]}"? A' if units else "; a"
    yield (
        "drive.frequency",
        f"is {frequency:g} Hz, at which {pairs} periods of a surface wave are longer than the stator of "
        f"{length * 1e3:g} mm{meant} number without a unit is in Hz",
    )


def _with_thicknesses(model: Model) -> Model:
    """Return the model with the thicknesses of its layers in m, where they are numbers of wavelengths.

    A SceneError says that a layer is too thick, or that the wave of the layers leaks.
    """
    block, frequency = model.scene.stator, model.scene.drive.frequency
    if not block.layer or isinstance(frequency, str):
        return model
    stack, surface = layers(block), "open" if block.above == "none" else "vacuum"
    try:
        wave = fem.principal_wave(fem.layered_waves(model.solid, stack, surface=surface, frequency=frequency))
    except fem.ConvergenceError as error:
        rule = f"must leave a wave bound to the surface: at {frequency:g} Hz {error}"
        raise SceneError("stator.layer", rule) from None
    wavelength, made = wave.velocity / frequency, []
    for index, (each, depth) in enumerate(zip(block.layer, wave.stack.depth[:, 0], strict=True)):
        thickness = float(depth) / (2.0 * math.pi) * wavelength
        if thickness > MAX_LAYER * wavelength:
            rule = f"is {thickness * 1e3:.4g} mm, {thickness / wavelength:.3g} wavelengths: it is the substrate"
            raise SceneError(f"stator.layer.{index}.thickness", f"{rule}; make it the material of the stator")
        if thickness < ATOM:
            rule = f"must be at least {ATOM:g} m, the size of an atom, got {thickness:.3g} m"
            raise SceneError(f"stator.layer.{index}.thickness", rule)
        made.append(replace(each, thickness=thickness) if isinstance(each.thickness, str) else each)
    return model.with_blocks(stator=replace(block, layer=tuple(made)))


def _with_source_numbers(model: Model) -> Model:
    """Return the model with the periods, or the frequency, of the strongest wave (fem/solve/best_frequency.py)."""
    block, scene = replace(model.stator, pieces=()), model.scene
    if "phi" not in block.fields:
        name = " on ".join(each.name for each in block.solids[::-1])
        raise SceneError("transducer", f"must be absent on {name}: it is not piezoelectric in this orientation")
    with stator_keys("drive.frequency"):
        if scene.drive.frequency == "center":
            driven = scene.driven_transducer
            LOGGER.info("search for the frequency of the strongest wave")
            frequency = fem.best_frequency(block, unturned(driven, driven.wavelength))
            return model.with_blocks(drive=replace(scene.drive, frequency=frequency))

    own = dict(scene.drive.source_frequencies or ())

    def with_period(each: Transducer) -> Transducer:
        if not isinstance(each.period, str):
            return each
        frequency = own.get(each.name, scene.frequency)
        if each.period == "auto" and each.has_two_electrodes:
            LOGGER.info("search for the period of the strongest wave")
            period = fem.best_period(block, unturned(each, 1.0), frequency)
        else:
            period = _half_space_period(replace(block, thickness=math.inf), frequency, each.metallisation)
        return replace(each, period=float(period))

    with stator_keys("transducer.period"):
        return model.with_blocks(transducer=tuple(with_period(each) for each in scene.transducer))


@lru_cache(256)  # points of a sweep or a search share most of them
def _half_space_period(block: fem.Stator, frequency: float, metallisation: float) -> float:
    return fem.bound_period(block, frequency, metallisation)


def _check_layout(model: Model) -> None:
    block, placed, scene = model.stator, model.transducers, model.scene
    with stator_keys("transducer", [each.name for each in placed], [each.label for each in scene.piece]):
        if not scene.crossed:
            fem.check_layout(block, placed)
            return
        fem.check_plan(block, scene.stator.width, placed)
        fem.check_turned(block)


def check_slider(model: Model) -> None:
    """Refuse a resolved slider that stands where it cannot, or whose burst takes too long to compute."""
    contacts_of(model.scene.slider).check(model.scene)
    _refuse_gaps(model)
    _refuse_covered(model)
    _refuse_endless_burst(model.scene)


@refuses(SceneError)
def _refuse_gaps(model: Model) -> Iterator[Any]:
    """Raise a SceneError if a contact lies on a meshed piece where this has no plain surface."""
    slider = model.scene.slider
    for each in model.pieces:
        for (low, high), (left, right) in itertools.product(each.gaps, contacts_of(slider).intervals(slider)):
            if left < high and right > low:
                rule = f"must keep the contacts off {each.name!r} from {low * 1e3:g} to {high * 1e3:g} mm, where it has"
                got = f"{left * 1e3:g}" + (f" to {right * 1e3:g}" if right > left else "")
                yield "slider.position", f"{rule} no plain surface at z = 0, got some at {got} mm"


@refuses(SceneError)
def _refuse_covered(model: Model) -> Iterator[Any]:
    """Raise a SceneError if a contact lies on a rotated transducer."""
    scene = model.scene
    if not scene.crossed:
        return
    for each, block in zip(model.transducers, scene.transducer, strict=True):
        for x, y in scene.slider.contact_positions if block.turned else ():
            if fem.covers(each, (x, y)):
                rule = f"must keep the contacts off {each.name!r}, got one at ({x * 1e3:g}, {y * 1e3:g}) mm"
                yield "slider.position", rule


@refuses(SceneError)
def _refuse_endless_burst(scene: Scene) -> Iterator[Any]:
    """Raise a SceneError if a burst takes longer than an hour to compute; the message names the longest duration."""
    if scene.burst is None:
        return
    slider, frequency = scene.slider, scene.frequency
    every_event = slider.remembers or slider.reciprocal or slider.stick_band > 0
    by_means = scene.wave is not None or scene.planar
    method = slider.method if slider.method in CYCLE_SECONDS else "averaged" if by_means else "stepped"
    if every_event and method != "stepped":
        method = "hysteretic" if slider.remembers else "exact"
    longest = MAX_BURST_SECONDS / CYCLE_SECONDS[method] / frequency
    if scene.burst > longest:
        cycles = scene.burst * frequency
        hours = cycles * CYCLE_SECONDS[method] / 3600
        rule = f"must be at most {longest:.3g} s: {cycles:.3g} cycles would take {hours:.3g} hours"
        yield (f"{scene.source.block}.burst", f"{rule}, got {scene.burst:g} s; the steady state needs no burst")
