"""Solving the stator for a sweep: once for each frequency and geometry.

What does not depend on the slider or the voltage is computed here, once, and kept in the sweep's store.  Many
frequencies of one geometry are solved as a band.  Where a point near the threshold turns out to need a better
stator, the next answer is ten times better: which of the ``STEPS`` a point uses depends on that point alone.
"""

import json
import math
import os
import time
from dataclasses import asdict
from functools import lru_cache

import fem
from studies.chain.surface_motion import SurfaceMotion, solved_motion, surface_motion, wanted_diffraction
from studies.refusal import RunError, SceneError
from studies.scene import Scene, resolved
from studies.scene.blocks import Stator
from studies.sweep.design import Question, contact_places
from studies.sweep.source import Source, reason
from studies.sweep.variation import Variation

SHARE, GAIN = 0.25, 0.1  # of the tolerance at first, and of the step before
BAND_SHARE = 0.1  # a band a level finer costs half as much again, two bands twice as much
STEPS = 3
COARSE_ERROR = (
    0.05  # taken of the coarsest discretisation, which does not estimate its own (1.7 to 4.5 % seen)
)


@lru_cache(4)
def _variation(text: str) -> Variation:
    return Variation(Question(**{key: _tuples(key, value) for key, value in json.loads(text).items()}))


def _tuples(key, value):
    """Return a value of a question or a point with its lists, also those in lists, as tuples."""
    nested = isinstance(value, list) and key != "table"
    return tuple(_tuples(key, each) for each in value) if nested else value


def variation(question: Question) -> Variation:
    """Return the scenes of a question, the same for all tasks that a process is given."""
    return _variation(json.dumps(asdict(question)))


def solved_sources(
    question: Question, names: tuple[str, ...], step: int, threads: int | None
) -> tuple[list[Source], float]:
    """Return the stator's answers of these names, and the seconds that they took."""
    from fem import one_blas_thread

    keep_to(threads)
    begun = time.perf_counter()
    if serves_band(question):
        one_blas_thread(_in_bands)(question, names, step)
    answers = [one_blas_thread(_answer)(question, name, step) for name in names]
    return answers, time.perf_counter() - begun


def keep_to(threads: int | None) -> None:
    """Keep this process, a worker, to so many threads; None leaves it as it is."""
    if threads is not None:
        from fem import set_workers

        set_workers(threads)
        os.environ["SAWMOTOR_THREADS"] = str(threads)


def _in_bands(question: Question, names, step: int) -> None:
    """Solve the frequencies of these answers side by side, for `_answer` to read."""
    _WAVES.clear()
    groups = {}
    for name in names:
        try:
            scene = variation(question).source(_values(name))
            along = _along(_places(question, scene, _values(name)))
            groups.setdefault((_Fixed(scene), along), []).append(scene.frequency)
        except SceneError:
            continue  # said when it is its turn
    for (fixed, places), frequencies in groups.items():
        try:
            band = _band(fixed, question.frequencies, places, goal(question, step))
            waves = band.waves(frequencies, resolved.drive(fixed.scene))
        except (RunError, ValueError, ArithmeticError, fem.ConvergenceError):
            continue  # one of them: each is tried by itself, and says why
        _WAVES.update({(fixed, frequency, places, step): wave
                       for frequency, wave in zip(frequencies, waves, strict=True)})  # fmt: skip


_WAVES = {}  # the frequencies of the task in hand


def goal(question: Question, step: int) -> float:
    """Return the relative error allowed at a step."""
    if question.coarse:
        return math.inf
    if not question.has_slider:
        return question.tolerance
    return question.tolerance * (BAND_SHARE if serves_band(question) else SHARE) * GAIN**step


def serves_band(question: Question) -> bool:
    """Return whether the transducers stay what they are while the frequency moves, over enough frequencies."""
    kept = not any(isinstance(each.get("period", "auto"), str) for each in question.table["transducer"])
    moved = any(key.endswith(".period") for key in question.keys)
    return bool(question.frequencies) and kept and not moved and not _spreads(question)


def _spreads(question: Question) -> bool:
    """Return whether the finite aperture may be computed, which no band does."""
    given = question.table["stator"].get("diffraction")
    if wanted_diffraction(given, question.has_slider) is False and "stator.diffraction" not in question.keys:
        return False
    if given or any(key.startswith("stator.") for key in question.keys):
        return True
    try:
        block = resolved.stator(Stator.from_table("stator", question.table["stator"]))
    except SceneError:
        return False  # said at every point
    return not resolved.default_refusal(block)


def _answer(question: Question, name: str, step: int) -> Source:
    values = _values(name)
    try:
        scene = variation(question).source(values)
        places = _places(question, scene, values)
        return _solved(question, name, step, scene, places)
    except Exception as error:
        if isinstance(error, fem.ConvergenceError):
            error = RunError(str(error))
        return Source(name=name, step=step, reason=reason(error))


def _values(name: str) -> dict:
    values = json.loads(name)
    return {key: _tuples(key, value) for key, value in values.items()}


def _places(question, scene, values) -> tuple[tuple[float, float], ...]:
    if not question.has_slider:
        return ((scene.stator.length / 2, 0.0),)
    places = question.places
    if not places:
        slider = question.table.get("slider", {})
        own = {key.split(".")[1]: value for key, value in values.items() if key.startswith("slider.")}
        places = contact_places(slider | own)
    places = tuple(place for place in places if 0 <= place[0] <= scene.stator.length)
    if not places:
        raise SceneError(
            "slider.position", f"must keep the contacts on the stator, 0 to {scene.stator.length:g} m"
        )
    return places


def _solved(question, name, step, scene, places) -> Source:
    try:
        answers = [(_motion(question, scene, places, step), places)]
    except RunError:
        if len(places) == 1:
            raise
        answers = []
        for place in places:  # one that cannot be had, in a node of the wave, must not cost the others
            try:
                answers.append((_motion(question, scene, (place,), step), (place,)))
            except RunError:
                answers.append((None, (place,)))
        if all(motion is None for motion, _ in answers):
            raise
    known = next(motion for motion, _ in answers if motion is not None)
    tangential, normal, errors, covered = [], [], [], []
    for motion, some in answers:
        tangential_of, _, normal_of = [[0j] * len(some)] * 3 if motion is None else motion.at(some)
        tangential += map(complex, tangential_of)
        normal += map(complex, normal_of)
        if motion is None:
            errors += [None] * len(some)
        else:
            errors += [COARSE_ERROR] * len(some) if question.coarse else map(float, motion.errors(some))
        covered += [bool(known.covered(place)) for place in some]
    return Source(
        name=name, step=step, frequency=float(known.wave.frequency), places=places, tangential=tuple(tangential),
        normal=tuple(normal), errors=tuple(errors), covered=tuple(covered), admittance=known.circuit.admittance,
        comb_voltage=known.circuit.voltage,
    )  # fmt: skip


def _motion(question: Question, scene: Scene, places, step: int) -> SurfaceMotion:
    """Return the motion of the finite aperture or of the section, as a run takes it; from a band where there is one."""
    if scene.crossed or not serves_band(question):
        return solved_motion(scene, places, tolerance=goal(question, step), slider=question.has_slider)
    along, fixed = _along(places), _Fixed(scene)
    wave = _WAVES.pop((fixed, scene.frequency, along, step), None)
    if wave is None:
        band = _band(fixed, question.frequencies, along, goal(question, step))
        wave = band.wave(scene.frequency, resolved.drive(scene))
    return surface_motion(wave, scene.stator, places, slider=question.has_slider)


def _along(places) -> tuple[float, ...]:
    """Return the different x of places (x, y): a plane section knows no y."""
    return tuple(dict.fromkeys(x for x, _ in places))


class _Fixed:
    """A scene but for its frequency: what a band is prepared for."""

    def __init__(self, scene: Scene):
        self.scene = scene
        drive = scene.drive
        self._own = (
            scene.stator,
            scene.transducer,
            drive.transducer,
            drive.sources,
            drive.source_impedance,
            drive.match,
        )

    def __eq__(self, other):
        return self._own == other._own

    def __hash__(self):
        return hash(self._own)


@lru_cache(4)
def _band(fixed: _Fixed, limits, places, allowed):
    from studies.chain.spectrum import response

    return response(fixed.scene, *limits, places=places, tolerance=allowed, progress=_silent)


def _silent(text: str) -> None:
    """Say nothing: a worker's stator is one of many."""
