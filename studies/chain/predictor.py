"""Answers of one motor for other values of some keys of its scene; a solved stator is reused wherever it still holds.

A change of the stator, its transducers or the frequency requires a new solution of the section and its circuit; a
change of the slider requires a new contact alone; voltage, power and burst require neither.  Runs, sweeps, fits,
tolerances, measured curves, sensitivities and design searches take their answers from here.  Near the threshold the
contact multiplies the stator's error: such a point is solved again on a stator ten times as accurate, with ``STEPS``
accuracies at most.  The step that a point ends at depends on that point alone, so that its answer does not depend on
its neighbours.
"""

import logging
import math
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import fem
from studies.chain import fem_model, resolve
from studies.chain.bridge import DrivenContact
from studies.chain.changed_scenes import ChangedScenes
from studies.chain.free_wave import free_wave_record
from studies.chain.outcomes import FREE, also_asked, amplitudes
from studies.chain.points import SHARE, SliderAnswer, slider_answer
from studies.chain.ring_up import RingUp, ring_up
from studies.chain.solved_stator import SolvedStator, stator_alone
from studies.chain.spectrum import response
from studies.chain.steady import averaged_answers, rated, steady_answer
from studies.chain.surface_motion import SurfaceMotion, solved_motion, surface_motion
from studies.chain.travel import WaveAlong
from studies.record import Record
from studies.record.status import Status
from studies.refusal import RunError, SceneError
from studies.scene import Scene

LOGGER = logging.getLogger("studies.run")
MAX_PLACES = 1_000_000  # of all solved stators in memory, about 300 MB
GAIN = 0.1  # tolerance of the stator at a step, over that of the step before
# Of the velocity's tolerance, for a stator solved in a band: a band that is one level finer costs half as much again,
# a second band costs twice as much
BAND_SHARE = 0.1
STEPS = 3  # accuracies of the stator, the first included


@dataclass(frozen=True, kw_only=True)
class Shared:
    """What one solution of the stator, or of a band of them, serves."""

    # (x, y) in m that it is evaluated at, for all contacts that stand on some of them
    places: tuple[tuple[float, float], ...] = ()
    # lowest and highest frequency in Hz, if there are enough of them to interpolate over a band
    limits: tuple[float, ...] = ()
    slider: bool | None = None  # whether it drives sliders; None: if the scene has one before it is changed


class Predictor(ChangedScenes):
    """Answers of one scene with some of its keys changed.

    Parameters
    ----------
    table : dict
        The scene's TOML document.
    tolerance : float
        Of the velocity, over its reference speed.
    shared : Shared
        What the solutions of the stator are used for.
    coarse : bool
        True takes the stator's coarsest discretisation.
    steps : int
        Number of accuracies that the stator may be solved with, each ten times the one before; 1: no finer stator.
    as_run : bool
        True accepts a stator that misses its tolerance, with its error, and reports progress in detail.
    progress : callable, optional
        Told what is being computed.
    """

    def __init__(
        self, table: dict, *, tolerance: float, shared: Shared = Shared(), coarse: bool = False,
        steps: int = STEPS, as_run: bool = False, progress: Callable[[str], None] | None = None,
    ) -> None:  # fmt: skip
        super().__init__(table)
        self.tolerance, self.coarse = tolerance, coarse
        self.slider = "slider" in table if shared.slider is None else shared.slider
        self.steps, self.as_run = 1 if coarse else steps, as_run
        self.free = "wave" not in table and not table.get("transducer")
        self.places, self.limits, self.progress = shared.places, shared.limits, progress or LOGGER.info
        self.seconds = 0.0  # spent on stators
        self._count = 0
        self._answers: dict[tuple, SolvedStator | Exception] = {}
        self._latest: tuple[tuple | None, SurfaceMotion | Any] = (None, None)
        self._ring_up, self._band = lru_cache(64)(ring_up), lru_cache(4)(response)

    @classmethod
    def of_record(cls, record: Record, *, progress: Callable[[str], None] | None = None) -> "Predictor":
        """Return the predictor of a run's scene, its stator known, without the scene's burst and [uncertain] block."""
        scene = replace(record.scene, uncertain=None)
        if scene.burst is not None:
            scene = scene.with_source(burst=None)
        predictor = cls(scene.to_table(), tolerance=record.tolerance, steps=1, progress=progress)
        resolved, stator = predictor.resolved({})
        if stator is not None:
            places = predictor.own_and_shared_places(resolved)[0]
            predictor._answers[stator, places, 0] = SolvedStator.of(record.surface_motion, places)
        return predictor

    def answers(
        self, many: Sequence[dict], also: Sequence[str] = (), *, tolerance: float | None = None, averaged: bool = False
    ) -> list[dict]:
        """Return what the motor does with each of several sets of changed keys.

        Parameters
        ----------
        many : sequence of dict
            Each maps keys of the scene to values and leaves one voltage, power or amplitude.
        also : sequence of str
            Outcomes other than the velocity, of `studies.chain.outcomes.ALSO`.
        tolerance : float, optional
            Of the velocity and the other outcomes; by default the predictor's own, which the stator always keeps.
        averaged : bool
            True takes averaged steady states whatever their error: they are smooth functions of the numbers, as
            derivatives need.

        Returns
        -------
        list of dict
            Columns by name; ``status`` is the text of a `studies.record.status.Status`, and
            ``relative_error`` is absent where there is no answer, and ``refused`` true where the scene was refused.
        """
        answers: list[dict] = [{} for _ in many]
        todo = list(range(len(many)))
        for step in range(self.steps):
            self.solve_together((many[at] for at in todo), step)
            some = [many[at] for at in todo]
            results = self._answers_of(some, also, step, tolerance or self.tolerance, averaged)
            for at, answer in zip(todo, results, strict=True):
                # where a better stator has no answer, that of the one before stands
                if "relative_error" in answer or not answers[at]:
                    answers[at] = answer
            todo = [at for at, answer in zip(todo, results, strict=True) if answer.get("finer")]
        return answers

    def contact(self, changes: dict, step: int = 0) -> DrivenContact:
        """Return the contact with some keys changed; its stator is solved at a step, unless a solution is known.

        Raises
        ------
        SceneError
            If the text or the physics refuses a value.
        RunError
            If the stator misses its tolerance.
        """
        scene, stator = self.resolved(changes)
        if stator is None:
            return DrivenContact.given(scene)
        places, shared = self.own_and_shared_places(scene)
        try:
            solved = self._answer(stator, shared, step)
        except RunError:  # a place in a node of the wave must not cost the others
            if shared == places:
                raise
            solved = self._answer(stator, places, step)
        motion = self.motion(stator, places, self._goal(stator, places, step)) if scene.on_pillars else None
        return DrivenContact.of_stator(scene, solved, motion)

    def motion(self, stator: Scene, places: Any, goal: float) -> SurfaceMotion:
        """Return the surface motion of a `stator_alone` at places (x, y) in m; only the latest is kept.

        ``goal``: its relative error.  RunError where it is not reached; a run takes what was reached, with its error.
        """
        question = stator, places, goal
        latest, motion = self._latest  # once: a worker may have several threads
        if latest != question:
            self._count += 1
            if not self.as_run:
                self.progress(f"stator {self._count}")
            start_time, solve = time.perf_counter(), fem.one_blas_thread(solved_motion)
            options = {"progress": self.progress, "missed": True} if self.as_run else {}
            try:
                motion = solve(stator, places, tolerance=goal, slider=self.slider, **options)
            finally:
                self.seconds += time.perf_counter() - start_time
            self._latest = question, motion
        return motion

    def slider_answer(
        self, driven: DrivenContact, motion: SurfaceMotion | None = None, tolerance: float | None = None
    ) -> SliderAnswer:
        """Return what the slider does at every level of a contact's scene, each solved by itself.

        ``motion``: of the surface, for bursts in which the slider travels.  ``tolerance``: by default the predictor's.
        """
        progress = self.progress if self.as_run else _silent
        return slider_answer(self.bursting(driven, motion), tolerance=tolerance or self.tolerance, progress=progress)

    def bursting(self, driven: DrivenContact, motion: SurfaceMotion | None) -> DrivenContact:
        """Return a contact with the ring-up of its burst, and with the motion's field along the slider's travel."""
        slider, along = driven.scene.slider, None
        if motion is not None and driven.scene.burst is not None and slider.travel is not False:
            along = WaveAlong.under(slider, motion)
        return replace(driven, ringing=self.ring_up(driven), along=along)

    def motion_of(self, driven: DrivenContact, step: int = 0) -> SurfaceMotion | None:
        """Return the surface motion in which a slider may travel; None if it may not, or the wave is given."""
        if driven.solved is None or driven.scene.slider.travel is False:
            return None
        stator, places = stator_alone(driven.scene), tuple(driven.solved.at)
        return self.motion(stator, places, self._goal(stator, places, step))

    def ring_up(self, driven: DrivenContact) -> RingUp | None:
        """Return how the surface's motion grows and fades in a burst; None with a given wave and under a transducer."""
        center = driven.scene.slider.center
        if driven.scene.burst is None or driven.solved is None or driven.solved.at[center][-1]:
            return None
        alone = stator_alone(driven.scene)
        bursting = replace(alone, drive=replace(alone.drive, burst=driven.scene.burst))
        return self._ring_up(bursting, center, progress=self.progress)

    def solve_together(self, many: Iterable[dict], step: int) -> None:
        """Solve the frequencies of one geometry side by side, where they make a band."""
        if len(self._answers) * max(1, len(self.places)) > MAX_PLACES:
            self._answers.clear()
        groups: dict = {}
        for changes in many if self.limits else ():
            with suppress(SceneError):  # raised again when the point is answered
                scene, stator = self.resolved(changes)
                places = self.own_and_shared_places(scene)[1]
                if self._in_band(stator, places) and (stator, places, step) not in self._answers:
                    fixed = replace(stator, drive=replace(stator.drive, frequency=self.limits[0]))
                    groups.setdefault((fixed, places), {})[stator.frequency] = stator
        for (fixed, places), stators in groups.items():
            start_time = time.perf_counter()
            # a band that fails leaves each of its stators to be solved alone, which says why it fails
            with suppress(RunError, ValueError, ArithmeticError, fem.ConvergenceError):
                along, goal = tuple(dict.fromkeys(x for x, _ in places)), self._goal(fixed, places, step)
                band = self._band(fixed, *self.limits, places=along, tolerance=goal, progress=_silent)
                waves = band.waves(list(stators), fem_model.drive(fixed))
                for stator, wave in zip(stators.values(), waves, strict=True):
                    motion = surface_motion(wave, stator.stator, places, slider=self.slider)
                    self._answers[stator, places, step] = SolvedStator.of(motion, places)
            self.seconds += time.perf_counter() - start_time

    def _answers_of(self, many: list[dict], also: Any, step: int, tolerance: float, averaged: bool) -> list[dict]:
        """Return the answers on the stator of a step; ``finer`` is true where a more accurate one would help."""
        answers: list[dict] = [{} for _ in many]
        ready: dict[int, DrivenContact] = {}
        for at, changes in enumerate(many):
            try:
                if self.free:
                    answers[at] = _free_answer(self.scene(changes), self.tolerance)
                    continue
                driven = self.contact(changes, step)
                if len(driven.scene.levels) != 1:
                    count = len(driven.scene.levels)
                    raise SceneError(driven.scene.level_key, f"must be one value at a point, got {count}")
                ready[at] = driven
            except Exception as error:
                answers[at] = _without_answer(error)
        steady = [at for at, each in ready.items() if each.scene.slider is not None and each.scene.burst is None]
        rows = averaged_answers([(ready[at], ready[at].level) for at in steady], math.inf if averaged else tolerance)
        side_by_side = dict(zip(steady, rows, strict=True))
        for at, driven in ready.items():
            try:
                if at in side_by_side:
                    answer = side_by_side[at] or steady_answer(driven, driven.level, tolerance)
                else:
                    answer = self._alone(driven, step, tolerance)
                answers[at] = amplitudes(driven) | also_asked(also, tolerance, driven, answer, averaged=averaged)
            except Exception as error:
                answers[at] = _without_answer(error)
        return answers

    def _alone(self, driven: DrivenContact, step: int, tolerance: float) -> dict:
        """Return the answer of a burst, or of a stator without a slider, as in a run."""
        scene, error = driven.scene, driven.stator_error
        if scene.slider is None:
            missed = error > tolerance
            why = f"the stator's error is {error:.1e}"
            status = Status.ABOVE_TOLERANCE.because(why) if missed else Status.OK.value
            return {"relative_error": error if driven.level else 0.0, "status": status}
        answer = self.slider_answer(driven, self.motion_of(driven, step), tolerance)
        return rated(answer.points[0], answer.parts[0], tolerance)

    def own_and_shared_places(self, scene: Scene) -> tuple[tuple, tuple]:
        """Return the places of a scene, and those that one solution of the stator serves."""
        places = scene.places
        if scene.slider is None:
            return places, places
        # with all balls on the axis the section may stand for the wave, and knows no place off it
        off_axis, length = any(y for _, y in places), scene.stator.length
        shared = tuple((x, y) for x, y in self.places if 0.0 <= x <= length and (off_axis or not y))
        return places, shared if set(places) <= set(shared) else places

    def _answer(self, stator: Scene, places: Any, step: int) -> SolvedStator:
        """Return what is kept of a stator solved as `motion` does, or raise why there is none."""
        question = stator, places, step
        if question not in self._answers:
            try:
                motion = self.motion(stator, places, self._goal(*question))
                self._answers[question] = SolvedStator.of(motion, places, coarse=self.coarse)
            except Exception as error:
                self._answers[question] = error
        answer = self._answers[question]
        if isinstance(answer, Exception):
            raise answer.with_traceback(None)
        return answer

    def _in_band(self, stator: Scene, places: Any) -> bool:
        """Return whether a stator is solved as one of a band: a range was given, and no finite aperture."""
        return (
            bool(self.limits)
            and not (stator.crossed or stator.piece)
            and not fem_model.spreads(stator.stator, places if self.slider else None)
        )

    def _goal(self, stator: Scene, places: Any, step: int) -> float:
        """Return the relative error allowed of a stator at a step."""
        if self.coarse:
            return math.inf
        share = BAND_SHARE if self._in_band(stator, places) else SHARE
        return self.tolerance * (share * GAIN**step if self.slider else 1.0)


def _without_answer(error: Exception) -> dict:
    """Return the columns of a point that has no answer."""
    return {"status": reason(error), "refused": isinstance(error, SceneError)}


def reason(error: Exception) -> str:
    """Return why a point has no answer, as its status says it."""
    text = " ".join(str(error).split())
    if isinstance(error, SceneError):
        return Status.REFUSED.because(text)
    if isinstance(error, RunError):
        return Status.NO_ANSWER.because(text)
    if isinstance(error, MemoryError):
        return Status.NO_ANSWER.because("it needs more memory than the worker has")
    return Status.NO_ANSWER.because(f"a defect of sawmotor: {type(error).__name__}: {text}")


def _free_answer(scene: Scene, tolerance: float) -> dict:
    """Return the answer of a scene without transducers: its free wave."""
    record = free_wave_record(resolve.resolved(scene), tolerance)
    answer = {name: record.wave[name] for name in FREE}
    return answer | {"relative_error": record.error["relative"], "status": Status.OK.value}


def _silent(text: str) -> None:
    """Report no progress: what is solved here is one of many."""
