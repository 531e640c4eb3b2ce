"""Answers of one motor for other values of some keys of its scene; a solved stator is reused wherever it still holds.

Sweeps, fits, tolerances, measured curves, sensitivities and design searches take their answers from here; a run takes
its contact from `studies.solve.changed_contacts` as they do.  Near the threshold the contact amplifies the stator's
error: such a point is solved again on a stator ten times as accurate, with at most ``STEPS`` accuracies.  The last step
of a point depends on that point alone, so that its answer does not depend on its neighbours.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

from studies.model import resolve
from studies.model.contact import Contact
from studies.record import Record
from studies.record.status import Status
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.solve.changed_contacts import ChangedContacts
from studies.solve.contact_at_level import point_answer
from studies.solve.free_wave import free_wave_record
from studies.solve.requested_quantities import FREE, amplitudes, with_outcomes
from studies.solve.solved_stator import SolvedStator
from studies.solve.steady_states import averaged_answers, rated, steady_answer

STEPS = 3  # accuracies of the stator, the first included


class Predictor(ChangedContacts):
    """Answers of one scene with some of its keys changed.

    Parameters
    ----------
    table : dict
        The scene's TOML document.
    tolerance : float
        Of the velocity, over its reference speed.
    steps : int
        Number of accuracies that the stator may be solved with, each ten times the one before; 1: no finer stator.
    **options
        As of `ChangedContacts`.
    """

    def __init__(self, table: dict, *, tolerance: float, steps: int = STEPS, **options: Any) -> None:
        super().__init__(table, tolerance=tolerance, **options)
        self.steps = 1 if self.coarse else steps
        self.free = "wave" not in table and not table.get("transducer")

    @classmethod
    def of_record(cls, record: Record, written: Scene | None = None) -> "Predictor":
        """Return the predictor of a run's scene, its stator known, without the scene's burst and [uncertain] block.

        ``written``: the scene before its automatic values became numbers; with it, the preload and the moduli follow
        the changed keys (`resolve.following`).
        """
        scene = replace(record.scene, uncertain=None)
        if scene.burst is not None:
            scene = scene.with_source(burst=None)
        table = resolve.following(scene, written or scene).to_table()
        predictor = cls(table, tolerance=record.tolerance, steps=1, numbers=scene.to_table())
        resolved, stator = predictor.resolved({})
        if stator is not None:
            positions = resolved.positions
            motion = record.surface_motion
            predictor._solved[stator, positions, 0, False] = SolvedStator.of(motion, positions)
            predictor._latest = (stator, positions, predictor._goal(stator, positions, 0)), motion
        return predictor

    def answers(
        self, many: Sequence[dict], also: Sequence[str] = (), *, tolerance: float | None = None, averaged: bool = False
    ) -> list[dict]:
        """Return the motor's answer for each of several sets of changed keys.

        Parameters
        ----------
        many : sequence of dict
            Each maps keys of the scene to values and leaves one voltage, power or amplitude.
        also : sequence of str
            Outcomes other than the velocity, of `studies.solve.requested_quantities.ALSO`.
        tolerance : float, optional
            Of the velocity and the other outcomes; by default the predictor's own, which is always that of the stator.
        averaged : bool
            True accepts averaged steady states of any error: they are smooth functions of the numbers, as derivatives
            require.

        Returns
        -------
        list of dict
            Columns by name; ``status`` is the text of a `studies.record.status.Status`.  Without an answer
            ``relative_error`` is absent; ``refused`` is true where the scene was refused.
        """
        self.nearby = self.nearby or "ripple" in also
        answers: list[dict] = [{} for _ in many]
        todo = list(range(len(many)))
        for step in range(self.steps):
            self.solve_together((many[at] for at in todo), step)
            some = [many[at] for at in todo]
            results = self._answers_of(some, also, step, tolerance or self.tolerance, averaged)
            for at, answer in zip(todo, results, strict=True):
                # if the more accurate stator has no answer, the previous answer is returned
                if "relative_error" in answer or not answers[at]:
                    answers[at] = answer
            todo = [at for at, answer in zip(todo, results, strict=True) if answer.get("finer")]
        return answers

    def _answers_of(self, many: list[dict], also: Any, step: int, tolerance: float, averaged: bool) -> list[dict]:
        """Return the answers on the stator of a step; ``finer`` is true where a more accurate one would help."""
        answers: list[dict] = [{} for _ in many]
        ready: dict[int, Contact] = {}
        for at, changes in enumerate(many):
            try:
                if self.free:
                    answers[at] = _free_answer(self.scene(changes), self.tolerance)
                    continue
                driven = self.contact(changes, step)
                if (count := len(driven.scene.levels)) != 1:
                    raise SceneError(driven.scene.level_key, f"must be one value at a point, got {count}")
                ready[at] = driven
            except Exception as error:
                answers[at] = {"status": reason(error), "refused": isinstance(error, SceneError)}
        steady = [at for at, each in ready.items() if each.scene.slider is not None and each.scene.burst is None]
        states = [(ready[at], ready[at].level) for at in steady]
        side_by_side = dict(zip(steady, averaged_answers(states, math.inf if averaged else tolerance), strict=True))
        for at, driven in ready.items():
            try:
                if at in side_by_side:
                    answer = side_by_side[at] or steady_answer(driven, driven.level, tolerance)
                else:
                    answer = self._alone(driven, step, tolerance)
                answers[at] = amplitudes(driven) | with_outcomes(also, tolerance, driven, answer, averaged=averaged)
            except Exception as error:
                answers[at] = {"status": reason(error), "refused": isinstance(error, SceneError)}
        return answers

    def _alone(self, driven: Contact, step: int, tolerance: float) -> dict:
        """Return the answer of a burst, or of a stator without a slider, as in a run."""
        error, status = driven.stator_error, Status.OK.value
        if driven.scene.slider is None:
            if error > tolerance:
                status = Status.ABOVE_TOLERANCE.because(f"the stator's error is {error:.1e}")
            return {"relative_error": error if driven.level else 0.0, "status": status}
        point = point_answer(self.bursting(driven, self.motion_of(driven, step)), driven.level, tolerance)
        return rated(point.values, point.parts, tolerance)


def reason(error: Exception) -> str:
    """Return the status of a point that has no answer."""
    text = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        text = "it needs more memory than the worker has"
    elif not isinstance(error, SceneError | RunError):
        text = f"a defect of sawmotor: {type(error).__name__}: {text}"
    return (Status.REFUSED if isinstance(error, SceneError) else Status.NO_ANSWER).because(text)


def _free_answer(scene: Scene, tolerance: float) -> dict:
    """Return the answer of a scene without transducers: its free wave."""
    record = free_wave_record(resolve.resolved(scene), tolerance)
    answer = {name: record.wave[name] for name in FREE}
    return answer | {"relative_error": record.error["relative"], "status": Status.OK.value}
