"""A batch of a sweep's points: a row for every one of them, the failed ones with their reason.

What a row holds depends on its own point alone, to the last bit: not on the other points of the batch, the
worker, or the number of threads.  Steady states of the elastic law are computed all at once in a compiled loop;
whatever that does not know or reach - other laws, bursts, stiff contacts - is solved as in a run, one by one.
"""

import math
import time
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache

from studies.chain import bridge
from studies.chain.points import averaged, slider_answer
from studies.chain.surface_motion import solved_motion
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.sweep.design import Question
from studies.sweep.outcomes import Driven, also_asked, electrical
from studies.sweep.source import Source, reason
from studies.sweep.source_solver import SHARE, STEPS, keep_to, variation

MAPPED = ("auto", "averaged")  # methods of the contact that the compiled loop may stand for


def solved_points(
    question: Question,
    points: list[int],
    values: list[tuple],
    sources: dict[str, Source],
    threads: int | None,
) -> tuple[list[tuple], list[int], float]:
    """Return the rows of a batch, each a point and its outcomes, the points that need a better stator, and seconds.

    ``sources``: the stator's best answers so far, by name, with every one that the points need; ``threads``: of the
    compiled loop, None for all processors.
    """
    begun = time.perf_counter()
    keep_to(threads)
    given = variation(question)
    found, ready, finer = {}, {}, []
    for point, own in zip(points, values, strict=True):
        try:
            source = sources.get(question.source(own)) if question.kind == "driven" else None
            made = _ready(question, given, own, source)
            if isinstance(made, dict):
                found[point] = made
            else:
                ready[point] = made
        except (SceneError, RunError) as error:
            found[point] = {"status": reason(error)}
    mapped = _mapped(question, ready, threads) if question.has_slider else {}
    for point, driven in ready.items():
        try:
            answer = mapped.get(point) or _one(question, driven)
            if answer.pop("finer", False) and not driven.final:
                finer.append(point)
                continue
            found[point] = electrical(driven) | also_asked(question, driven, answer)
        except Exception as error:
            found[point] = {"status": reason(error)}
    names = question.outcomes
    rows = [(point, *(_kept(answer.get(name)) for name in names)) for point, answer in found.items()]
    return rows, finer, time.perf_counter() - begun


def _ready(question, given, own, source) -> Driven | dict:
    """Return a point made ready for the contact, or its whole answer where no contact is asked for."""
    if question.kind == "free":
        return _free_wave(given.scene(own), question.tolerance)
    if source is not None and source.reason:
        given.scene(own)  # the point's own fault, if it has one, is the better reason
        return {"status": source.reason}
    scene = given.resolved(own)
    level = scene.levels[0]
    if question.kind == "given":
        return Driven(
            scene=scene, level=level, orbits=bridge.given_orbits(scene.wave),
            amplitudes=(1.0, scene.wave.tangential_ratio), error=0.0, source=None, final=True,
        )  # fmt: skip
    places = [(scene.stator.length / 2, 0.0)] if scene.slider is None else _places(scene.slider)
    at = [source.index(place) for place in places]
    if any(source.errors[k] is None for k in at):
        raise RunError("the stator's surface motion at this place is not known to the tolerance")
    amplitudes = (float(abs(source.normal[at[0]])), float(abs(source.tangential[at[0]])))
    error = max(source.errors[k] for k in at)
    if scene.frequency != source.frequency:
        scene = replace(scene, drive=replace(scene.drive, frequency=source.frequency))
    orbits = ()
    if scene.slider is not None:
        orbits = source.orbits(scene.slider.places)
    driven = Driven(
        scene=scene, level=level, orbits=orbits, amplitudes=amplitudes, error=error, source=source,
        final=question.coarse or source.step == STEPS - 1,
    )  # fmt: skip
    if scene.slider is not None:
        return driven
    status = "ok" if error <= question.tolerance else f"above tolerance: the stator's error is {error:.1e}"
    return electrical(driven) | {"relative_error": error if level else 0.0, "status": status}


def _places(slider) -> tuple[tuple[float, float], ...]:
    return tuple(dict.fromkeys((slider.center, *slider.places)))


def _mapped(question, ready: dict[int, Driven], threads) -> dict[int, dict]:
    """Return the answers of those points that the compiled loop reaches within the tolerance."""
    asked, answers = {}, {}
    for point, driven in ready.items():
        block = driven.scene.slider
        if driven.scene.burst is None and block.method in MAPPED:
            with suppress(ValueError):  # refused by name when it is solved by itself
                asked[point] = (_contact_slider(block), driven.orbits, driven.error, driven.level)
    for point, row in zip(asked, averaged(list(asked.values()), threads), strict=True):
        velocity, regime, of_contact, of_stator, thrust = row
        if regime != "unknown" and of_contact <= SHARE * question.tolerance:
            found = {"velocity_m_per_s": velocity, "regime": regime, "thrust_N": thrust}
            answers[point] = found | _judged(question, of_stator, of_contact, "ok")
    return answers


_contact_slider = lru_cache(10_000)(bridge.contact_slider)


def _one(question, driven: Driven) -> dict:
    """Return the answer of a point solved by itself, as in a run."""
    contact = bridge.DrivenContact(
        scene=driven.scene,
        orbits=driven.orbits,
        amplitudes=driven.amplitudes,
        stator_error=driven.error,
        ringing=_ringing(driven),
        along=_along(question, driven),
    )
    answer = slider_answer(contact, tolerance=question.tolerance, progress=lambda text: None)
    point, (of_stator, of_contact) = dict(answer.points[0]), answer.parts[0]
    if "relative_error" not in point:
        return {"status": f"no answer: {point['status']}"}
    return point | _judged(question, of_stator, of_contact, point["status"])


def _judged(question, of_stator, of_contact, status) -> dict:
    error = of_stator + of_contact
    above = error > question.tolerance
    if above and status == "ok":
        parts = f"stator {of_stator:.1e}, contact {of_contact:.1e}"
        status = f"above tolerance: the velocity's error is {error:.1e} ({parts})"
    return {
        "relative_error": error,
        "status": status,
        "finer": above and of_stator > SHARE * question.tolerance,
    }


def _ringing(driven: Driven):
    scene = driven.scene
    if scene.burst is None or driven.source is None:
        return None
    source = driven.source
    if source.covered[source.index(scene.slider.center)]:
        return None
    plain = replace(scene, slider=None, title="", drive=replace(scene.drive, voltage=(1.0,)))
    return _ring_up(plain, scene.slider.center)


def _along(question, driven: Driven):
    """Return the orbits along the field for a burst, as in a run; None where the slider stays at its place."""
    scene = driven.scene
    if scene.burst is None or driven.source is None or scene.slider.travel is False:
        return None
    plain = replace(scene, slider=None, title="", drive=replace(scene.drive, voltage=(1.0,), burst=None))
    return bridge.wave_along(_motion(plain, scene.slider.center, question.tolerance), scene.slider)


@lru_cache(4)  # the same for every slider and voltage
def _motion(scene: Scene, place: tuple[float, float], tolerance: float):
    return solved_motion(scene, (place,), tolerance=tolerance, slider=True)


@lru_cache(8)  # the same for every slider and voltage
def _ring_up(scene: Scene, place: tuple[float, float]):
    from studies.chain.ring_up import ring_up

    return ring_up(scene, place, progress=lambda text: None)


def _free_wave(scene: Scene, tolerance: float) -> dict:
    """Return the answer of a scene without transducers: one run of the chain."""
    from studies.chain import run

    record = run(scene, tolerance=tolerance)
    found = {
        name: record.wave[name] for name in ("phase_velocity_m_per_s", "surface_ratio", "attenuation_per_m")
    }
    status = f"above tolerance: {record.shortfall}" if record.shortfall else "ok"
    return found | {"relative_error": record.error["relative"], "status": status}


def _kept(value):
    """Return a value as the store holds it: what is not finite is none."""
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
