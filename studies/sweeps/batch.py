"""A batch of a sweep's points: a row for every one of them, the failed ones with their reason.

What a row holds depends on its own point alone, to the last bit: not on the other points of the batch, the
worker, or the number of threads.  Steady states of the elastic law are computed all at once in a compiled loop;
whatever that does not know or reach - other laws, bursts, stiff contacts - is solved as in a run, one by one.
"""

import math
import os
import time
from dataclasses import replace
from functools import lru_cache

from studies.chain import bridge
from studies.chain.outcomes import also_asked, amplitudes
from studies.chain.points import averaged, slider_answer
from studies.chain.predictor import SHARE, STEPS, Driven, Predictor, stator_alone
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.sweeps.plan import Question

MAPPED = ("auto", "averaged")  # methods of the contact that the compiled loop may stand for


def solved_points(
    question: Question, points: list[int], values: list[tuple], threads: int | None
) -> tuple[list[tuple], float, float]:
    """Return the rows of a batch, each a point and its outcomes, the seconds it took, and those of its stators.

    ``threads``: of the compiled loop, None for all processors.
    """
    begun, predictor = time.perf_counter(), _predictor(question)
    before = predictor.seconds
    if threads is not None:
        from fem import set_workers

        set_workers(threads)
        os.environ["SAWMOTOR_THREADS"] = str(threads)
    found = {}
    todo = {
        point: dict(zip(question.keys, own, strict=True)) for point, own in zip(points, values, strict=True)
    }
    for step in range(1 if question.coarse else STEPS):
        predictor.solve_together(todo.values(), step)
        answers = _answers(question, predictor, todo, step, threads)
        # where a better stator has no answer, that of the one before stands
        found |= {
            point: row for point, row in answers.items() if "relative_error" in row or point not in found
        }
        todo = {point: todo[point] for point, row in answers.items() if row.get("finer")}
    rows = [(point, *(_kept(found[point].get(name)) for name in question.outcomes)) for point in found]
    return rows, time.perf_counter() - begun, predictor.seconds - before


@lru_cache(2)
def _predictor(question: Question) -> Predictor:
    """Return the predictor of a question, the same for all batches that a process is given."""
    return Predictor(
        question.table, tolerance=question.tolerance, places=question.places, limits=question.frequencies,
        coarse=question.coarse, slider=question.has_slider,
    )  # fmt: skip


def reason(error: Exception) -> str:
    """Return why a point has no answer, as a row's status says it."""
    text = " ".join(str(error).split())
    if isinstance(error, SceneError):
        return f"refused: {text}"
    if isinstance(error, RunError):
        return f"no answer: {text}"
    if isinstance(error, MemoryError):
        return "no answer: it needs more memory than the worker has"
    return f"no answer: a defect of sawmotor: {type(error).__name__}: {text}"


def _answers(question, predictor: Predictor, todo: dict[int, dict], step: int, threads) -> dict[int, dict]:
    """Return the outcomes of some points by name, with the stator of a step."""
    found, ready = {}, {}
    for point, changes in todo.items():
        try:
            if question.kind == "free":
                found[point] = _free_wave(predictor.scene(changes), question.tolerance)
            else:
                driven = predictor.contact(changes, step)
                if len(driven.scene.levels) != 1:
                    count = len(driven.scene.levels)
                    raise SceneError(driven.level_key, f"must be one value at a point, got {count}")
                ready[point] = driven
        except Exception as error:
            found[point] = {"status": reason(error)}
    mapped = _mapped(
        question, {k: each for k, each in ready.items() if each.scene.slider is not None}, threads
    )
    for point, driven in ready.items():
        try:
            answer = mapped.get(point) or _one(question, predictor, driven, step)
            found[point] = amplitudes(driven) | also_asked(question, driven, answer)
        except Exception as error:
            found[point] = {"status": reason(error)}
    return found


def _mapped(question, ready: dict[int, Driven], threads) -> dict[int, dict]:
    """Return the answers of those points that the compiled loop reaches within the tolerance."""
    asked, answers = {}, {}
    for point, driven in ready.items():
        if driven.scene.burst is None and driven.scene.slider.method in MAPPED:
            asked[point] = (driven.slider, driven.orbits, driven.stator_error, driven.level)
    for point, row in zip(asked, averaged(list(asked.values()), threads), strict=True):
        velocity, regime, of_contact, of_stator, thrust = row
        if regime != "unknown" and of_contact <= SHARE * question.tolerance:
            found = {"velocity_m_per_s": velocity, "regime": regime, "thrust_N": thrust}
            answers[point] = found | _judged(question, of_stator, of_contact, "ok")
    return answers


def _one(question, predictor: Predictor, driven: Driven, step: int) -> dict:
    """Return the answer of a point solved by itself, as in a run."""
    scene, error = driven.scene, driven.stator_error
    if scene.slider is None:
        status = (
            "ok" if error <= question.tolerance else f"above tolerance: the stator's error is {error:.1e}"
        )
        return {"relative_error": error if driven.level else 0.0, "status": status}
    along = None
    if scene.burst is not None and driven.solved is not None and scene.slider.travel is not False:
        motion = predictor.motion(stator_alone(scene), tuple(driven.solved.at), step)
        along = bridge.wave_along(motion, scene.slider)
    driven = replace(driven, ringing=predictor.ring_up(driven), along=along)
    answer = slider_answer(driven, tolerance=question.tolerance, progress=lambda text: None)
    point, (of_stator, of_contact) = dict(answer.points[0]), answer.parts[0]
    if "relative_error" not in point:
        return {"status": f"no answer: {point['status']}"}
    return point | _judged(question, of_stator, of_contact, point["status"])


def _judged(question, of_stator, of_contact, status) -> dict:
    """Return a point's error and status, and whether a better stator would help."""
    error = of_stator + of_contact
    above = error > question.tolerance
    if above and status == "ok":
        parts = f"stator {of_stator:.1e}, contact {of_contact:.1e}"
        status = f"above tolerance: the velocity's error is {error:.1e} ({parts})"
    finer = above and of_stator > SHARE * question.tolerance
    return {"relative_error": error, "status": status, "finer": finer}


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
    return None if isinstance(value, float) and not math.isfinite(value) else value
