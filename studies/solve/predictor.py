"""Answers of one motor for other values of some keys of its scene; a solved stator is reused wherever it still holds.

Sweeps, fits, tolerances, measured curves, sensitivities and design searches take their answers from here. A point where
the velocity misses its tolerance is solved again on a more accurate stator, as in a run (`studies.solve.refinement`).
Which stator that is depends on the point alone, so that its answer does not depend on its neighbours.
"""

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import replace

import fem
from studies.model.changed_scenes import ChangedScenes
from studies.model.model import Model
from studies.model.resolve import build, following
from studies.model.wave_to_contact import Contact
from studies.record import Record
from studies.record.point import Point
from studies.record.status import Status
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.solve.contact_at_level import point_answer
from studies.solve.free_wave import free_wave_record
from studies.solve.point_answer import PointAnswer, SliderAnswer
from studies.solve.refinement import ROUNDS, refined
from studies.solve.requested_quantities import FREE, amplitudes, requested_quantities
from studies.solve.stators import UNSHARED, Shared, Stators
from studies.solve.steady_states import averaged_answers


class Predictor:
    """Answers of one scene with some of its keys changed.

    Parameters
    ----------
    table : dict
        The scene's TOML document.
    tolerance : float
        Of the velocity, over its reference speed.
    rounds : int
        Largest number of solutions of a stator, each more accurate than the one before.
    shared : Shared
        What one solution of the stator is computed for.
    coarse : bool
        True takes the stator's coarsest discretisation.
    numbers : dict, optional
        As for `ChangedScenes`.
    """

    def __init__(
        self, table: dict, *, tolerance: float, rounds: int = ROUNDS, shared: Shared = UNSHARED, coarse: bool = False,
        numbers: dict | None = None,
    ) -> None:  # fmt: skip
        self.tolerance, self.rounds = tolerance, 1 if coarse else rounds
        self.scenes = ChangedScenes(table, numbers)
        slider = "slider" in table if shared.slider is None else shared.slider
        self.stators = Stators(tolerance=tolerance, slider=slider, shared=shared, coarse=coarse)
        self.free = "wave" not in table and not table.get("transducer")

    @classmethod
    def of_record(cls, record: Record, written: Scene | None = None) -> "Predictor":
        """Return the predictor of a run's scene, its stator known, without the scene's burst and [uncertain] block.

        ``written``: the scene before its automatic values became numbers; with it, the preload and the moduli follow
        the changed keys (`studies.model.resolve.following`).
        """
        scene = replace(record.scene, uncertain=None)
        if scene.burst is not None:
            scene = scene.with_source(burst=None)
        table = following(scene, written or scene).to_table()
        predictor = cls(table, tolerance=record.tolerance, rounds=1, numbers=scene.to_table())
        model = predictor.scenes.model({})
        if scene.stator is not None:
            predictor.stators.know(model.alone, model.scene.positions, record.surface_motion)
        return predictor

    def scene(self, changes: dict) -> Scene:
        """Return the scene with some of its keys changed; SceneError if it breaks a rule of the text."""
        return self.scenes.scene(changes)

    def contact(self, changes: dict, goal: float | None = None) -> Contact:
        """Return the contact with some keys changed; its stator is solved unless a solution is known.

        ``goal``: of its section, by default that of the first round.

        Raises
        ------
        SceneError
            If the text or the physics refuses a value.
        RunError
            If the stator has no solution, or the model does not resolve the motion under a contact.
        """
        return self._contact(self.scenes.model(changes), goal)

    def _contact(self, model: Model, goal: float | None) -> Contact:
        driven = self.stators.contact(model, goal)
        if driven.refusal and driven.scene.slider is not None:
            raise RunError(driven.refusal)
        return driven

    def answers(
        self, many: Sequence[dict], also: Sequence[str] = (), *, tolerance: float | None = None, quick: bool = False,
        averaged: bool = False,
    ) -> list[PointAnswer]:  # fmt: skip
        """Return the motor's answer for each of several sets of changed keys.

        Parameters
        ----------
        many : sequence of dict
            Each maps keys of the scene to values and leaves one voltage, power or amplitude.
        also : sequence of str
            Quantities other than the velocity, of `studies.solve.requested_quantities.ALSO`.
        tolerance : float, optional
            Of the velocity and the other quantities; by default the predictor's own, which is always that of the
            stator.
        quick : bool
            True takes averaged steady states, microseconds each, where their error is a quarter of the tolerance or
            less; False solves each steady state as a run does, with the same answer to the last bit.
        averaged : bool
            True accepts averaged steady states of any error: they are smooth functions of the numbers, as derivatives
            require.

        Returns
        -------
        list of PointAnswer
            The ``status`` of a point is the text of a `studies.record.status.Status`.
        """
        tolerance = tolerance or self.tolerance
        accepted = math.inf if averaged else tolerance if quick else None
        self.stators.nearby = self.stators.nearby or "ripple" in also

        def solve(some: list[dict], goals: list[float | None]) -> list[SliderAnswer]:
            with fem.blas_on_one_thread():  # as a run: the number of threads changes the last digits
                return self._solved(some, goals, tolerance, accepted)

        found = refined(solve, many, tolerance, self.rounds)
        return [_with_quantities(each, also, tolerance, averaged) for each in found]

    def _solved(
        self, many: list[dict], goals: list[float | None], tolerance: float, accepted: float | None
    ) -> list[SliderAnswer]:
        """Return the answers on stators solved to some goals; ``accepted``: tolerance of averaged states, or None."""
        models = self._solved_together(many, goals)
        results: list[SliderAnswer | None] = [None] * len(many)
        contacts: dict[int, Contact] = {}
        for k, (changes, goal) in enumerate(zip(many, goals, strict=True)):
            try:
                if self.free:
                    results[k] = SliderAnswer(answers=(_free_answer(self.scene(changes), self.tolerance),))
                else:
                    contacts[k] = self._contact_at_one_level(models.get(k) or self.scenes.model(changes), goal)
            except Exception as error:
                results[k] = _failed(error)
        steady = [k for k, each in contacts.items() if accepted is not None and _is_steady(each)]
        states = [(contacts[k], contacts[k].level) for k in steady]
        side_by_side = dict(zip(steady, averaged_answers(states, accepted or 0.0), strict=True))
        for k, driven in contacts.items():
            try:
                answer = side_by_side.get(k) or self._alone(driven, tolerance)
                results[k] = SliderAnswer(answers=(answer,), driven=driven)
            except Exception as error:
                results[k] = _failed(error)
        return [each for each in results if each is not None]

    def _solved_together(self, many: list[dict], goals: list[float | None]) -> dict[int, Model]:
        """Solve the frequencies of one geometry side by side, where they make a band; return the models by number."""
        models: dict[int, Model] = {}
        for k, changes in enumerate(many) if self.stators.limits else ():
            with suppress(SceneError):  # raised again when the point is answered
                models[k] = self.scenes.model(changes)
        self.stators.solve_together([(model, goals[k]) for k, model in models.items()])
        return models

    def _contact_at_one_level(self, model: Model, goal: float | None) -> Contact:
        """Return `contact` of a resolved scene; SceneError if it has several levels."""
        driven = self._contact(model, goal)
        if (count := len(driven.scene.levels)) != 1:
            raise SceneError(driven.scene.level_key, f"must be one value at a point, got {count}")
        # with the ring-up of a burst, whose error no finer stator reduces (`finer`)
        return driven if driven.scene.slider is None else self.stators.bursting(driven)

    def _alone(self, driven: Contact, tolerance: float) -> PointAnswer:
        """Return the answer of one contact, or of a stator without a slider, as in a run."""
        if driven.scene.slider is None:
            error, status = driven.stator_error, Status.OK.value
            if error > tolerance:
                status = Status.ABOVE_TOLERANCE.because(f"the stator's error is {error:.1e}")
            error = error if driven.level else 0.0
            return PointAnswer(point=Point(relative_error=error, status=status), from_stator=error)
        return point_answer(driven, driven.level, tolerance, balance=False)


def _is_steady(driven: Contact) -> bool:
    return driven.scene.slider is not None and driven.scene.burst is None


def _with_quantities(solved: SliderAnswer, also: Sequence[str], tolerance: float, averaged: bool) -> PointAnswer:
    """Return an answer with the amplitudes of the surface and the requested quantities."""
    (answer,), driven = solved.answers, solved.driven
    if driven is None:
        return answer
    try:
        point = amplitudes(driven) | answer.point
        if also and answer.point.velocity_m_per_s is not None:
            point |= requested_quantities(also, tolerance, driven, answer, averaged=averaged)
        return replace(answer, point=point)
    except Exception as error:
        return _failed(error).answers[0]


def _failed(error: Exception) -> SliderAnswer:
    """Return the answer of a point that has none."""
    answer = PointAnswer(point=Point(status=reason(error)), refused=isinstance(error, SceneError))
    return SliderAnswer(answers=(answer,))


def reason(error: Exception) -> str:
    """Return the status of a point that has no answer."""
    text = " ".join(str(error).split())
    if isinstance(error, MemoryError):
        text = "it needs more memory than the worker has"
    elif not isinstance(error, SceneError | RunError):
        text = f"a defect of sawmotor: {type(error).__name__}: {text}"
    return (Status.REFUSED if isinstance(error, SceneError) else Status.NO_ANSWER).because(text)


def _free_answer(scene: Scene, tolerance: float) -> PointAnswer:
    """Return the answer of a scene without transducers: its free wave."""
    record = free_wave_record(build(scene), tolerance)
    values = {name: record.wave[name] for name in FREE}
    point = Point(**values, relative_error=record.error.relative, status=Status.OK.value)
    return PointAnswer(point=point, from_stator=record.error.relative)
