"""From a scene to its record: surface motion per volt, orbits at each voltage, contact, velocity, remarks.

Only the parts that the scene needs are imported and computed.  The tolerance bounds the error of the last quantity;
`studies.solve.refinement` says how accurately the stator is solved for it.

Which function makes which block of the record:

- points, summary, error, trajectories, pillars, slider_wave: `slider_answer`, or `amplitude_points` without a slider;
- velocities over the places near the slider's, in points and summary: `_with_ripple`;
- wave: `wave_block`, or `free_wave_record` without transducers;
- electrical, powers in the points: `electrical_block`, `with_powers`;
- heat: `heat_block`; its steady temperature: `at_own_temperature`;
- surface: `surface_columns`; left_out: `left_out`;
- uncertainty, bands in the points: `with_bands`;
- model_error, its share in points and error, refusals by it: `with_model_error`;
- shortfall: `SliderAnswer.shortfall`; warnings: `warnings_of`; seconds: `run`.

The block measured is the command's (`studies.solve.measured_run`).
"""

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path

import fem
from studies.model.model import Model
from studies.model.resolve import build
from studies.model.wave_to_contact import Contact
from studies.progress import reported_to
from studies.record import Record
from studies.record.blocks import ErrorBlock, WaveBlock
from studies.refusal import RunError
from studies.remarks.model_error import with_model_error
from studies.remarks.neglected_effects import left_out
from studies.remarks.run_warnings import warnings_of
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.solve.contact_at_level import slider_answer, velocity_answer
from studies.solve.electrical import electrical_block, with_powers
from studies.solve.free_wave import free_wave_record
from studies.solve.heat import heat_block
from studies.solve.point_answer import SliderAnswer
from studies.solve.refinement import refined
from studies.solve.ring_up import RingUp
from studies.solve.ripple import with_ripple
from studies.solve.solved_stator import SolvedStator, contact_of_run
from studies.solve.stators import Stators
from studies.solve.steady_temperature import at_own_temperature
from studies.solve.surface_blocks import amplitude_points, node, surface_columns, wave_block
from studies.solve.surface_motion import SurfaceMotion
from studies.solve.wave_ripple import with_wave_ripple

LOGGER = logging.getLogger(__name__)


def run(
    scene: Scene | str | Path = "twente", *, tolerance: float = 1e-3, progress: Callable[[str], None] | None = None
) -> Record:
    """Run the chain that a scene needs.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its file, or the name of a shipped scene.
    tolerance : float
        Bound of the error of the last quantity: of the slider's velocity over max(|v|, omega |u_x| / 10); without a
        slider, the relative error of the surface amplitude; for a free wave, that of its velocity.
    progress : callable, optional
        Called with a few words about each step, as it is logged.

    Returns
    -------
    Record
        If the tolerance is not met, its ``shortfall`` says why.

    Raises
    ------
    SceneError
        If the scene cannot be read, or is physically impossible.
    RunError
        If there is no result to record.

    Examples
    --------
    >>> run("rayleigh").wave["phase_velocity_m_per_s"]  # doctest: +ELLIPSIS
    2181...
    """
    tolerance = Quantity(below=1.0).read("tolerance", tolerance)
    start_time = time.perf_counter()
    with fem.blas_on_one_thread(), reported_to(progress):
        record = _run(Scene.load(scene), tolerance)
    total = time.perf_counter() - start_time
    parts = record.seconds | {"other": total - sum(record.seconds.values())}
    return replace(record, seconds={"total": total, **parts})


def solved_contact(scene: Scene, *, tolerance: float = 1e-3) -> Contact:
    """Return the contact of a scene with a slider, its stator solved as accurately as in a run.

    The blocks of a run that neither the contact nor its stator needs are not computed: threshold and release,
    velocities nearby, bands, model errors and warnings.
    """
    tolerance = Quantity(below=1.0).read("tolerance", tolerance)
    with fem.blas_on_one_thread():
        model, heated = at_own_temperature(build(scene), tolerance)
        record = _with_slider(model, Stators(tolerance=tolerance, slider=True), velocity_answer)
        return contact_of_run(replace(record, heat=record.heat | heated))


def _run(scene: Scene, tolerance: float) -> Record:
    model, heated = at_own_temperature(build(scene), tolerance)
    record = _solved(model, tolerance)
    if model.scene.uncertain is not None:
        from studies.solve.uncertainty import with_bands  # imports scipy.stats, 0.3 s

        record = with_bands(record, model.written)
    record = with_model_error(replace(record, heat=record.heat | heated))
    return replace(record, warnings=warnings_of(record))


def _solved(model: Model, tolerance: float) -> Record:
    """Return the record of a resolved scene without its bands, model errors and warnings."""
    if model.scene.slider is not None:
        return _with_slider(model, Stators(tolerance=tolerance, slider=True))
    if model.scene.transducer:
        return _surface_alone(model, Stators(tolerance=tolerance, slider=False))
    return replace(free_wave_record(model, tolerance), left_out=left_out(model))


def _with_slider(model: Model, stators: Stators, answer_of: Callable[..., SliderAnswer] = slider_answer) -> Record:
    """Return the record of a slider on a driven stator or a prescribed wave.

    ``answer_of``: `slider_answer`, or `velocity_answer`, which leaves out the velocities nearby too.
    """
    start_time, tolerance = time.perf_counter(), stators.tolerance
    (answer,) = refined(partial(_answers, stators, answer_of), [model], tolerance)
    driven, motion, refusal = answer.driven, None, ""
    if driven.solved is not None:
        motion = stators.motion_under(driven)
        # of a passing wave, the centre is one place of many
        refusal = ("" if driven.passing else node(motion, driven.scene.positions)) or driven.refusal
    if not refusal and answer_of is slider_answer:
        answer = _with_ripple(answer, motion, tolerance)
    record = Record(
        scene=model.scene, tolerance=tolerance, points=answer.points, summary=answer.summary,
        trajectories=answer.trajectories, pillars=answer.pillars, slider_wave=answer.slider_wave, error=answer.error,
        shortfall=f"no answer: {refusal}" if refusal else answer.shortfall(tolerance), refused=bool(refusal),
        seconds={"stator": stators.seconds, "contact": time.perf_counter() - start_time - stators.seconds},
    )  # fmt: skip
    if motion is not None:
        further = tuple(each() for each in driven.surface.motions[1:]) if model.scene.planar else ()
        return _on_stator(record, model, motion, driven.ringing, further)
    given = model.scene.wave
    wave = WaveBlock(frequency_Hz=given.frequency, surface_ratio=given.tangential_ratio)
    return replace(record, wave=wave, left_out=left_out(model))


def _answers(
    stators: Stators, answer_of: Callable[..., SliderAnswer], models: list[Model], goals: list[float | None]
) -> list[SliderAnswer]:
    """Return the answers of models at all their levels, on stators solved to some goals."""
    answers = []
    for model, goal in zip(models, goals, strict=True):
        try:
            driven = stators.bursting(stators.contact(model, goal))
        except RunError:
            if goal is None:
                raise
            answers.append(SliderAnswer(answers=()))  # that of the round before is recorded, with its error
        else:
            answers.append(answer_of(driven, tolerance=stators.tolerance))
    return answers


def _with_ripple(answer: SliderAnswer, motion: SurfaceMotion | None, tolerance: float) -> SliderAnswer:
    """Return the answer with mean and range of the velocity over the places near the slider's."""
    driven = answer.driven
    if driven.scene.planar:
        from studies.solve.plane_ripple import with_plane_ripple

        return with_plane_ripple(answer, tolerance)
    if motion is None or driven.heavy:
        return answer
    LOGGER.debug("velocities about the position")
    if driven.passing:
        return with_wave_ripple(answer, tolerance)
    solved = SolvedStator.of(motion, driven.scene.positions, nearby=True)
    return with_ripple(replace(answer, driven=replace(driven, solved=solved)), tolerance)


def _surface_alone(model: Model, stators: Stators) -> Record:
    """Return the record of a driven stator without a slider, whose result is the amplitude of its surface."""
    positions, tolerance = model.scene.positions, stators.tolerance
    motion = stators.motion(model.alone, positions)
    error = motion.relative_error(positions[:1])
    short = f"the surface amplitude's error is {error:.1e}, {tolerance:.1e} was asked for: give a larger tolerance"
    record = Record(
        scene=model.scene, tolerance=tolerance, points=amplitude_points(model.scene, motion),
        error=ErrorBlock(relative=error, parts={"stator": error}), shortfall=short if error > tolerance else "",
        seconds={"stator": stators.seconds},
    )  # fmt: skip
    return _on_stator(record, model, motion)


def _on_stator(
    record: Record, model: Model, motion: SurfaceMotion, ringing: RingUp | None = None,
    further: tuple[SurfaceMotion, ...] = (),
) -> Record:  # fmt: skip
    """Return a record with what the motion of its stator's surface adds; ``further``: at its other frequencies."""
    scene, beam = model.scene, motion.spreads
    neglected = left_out(model, beam=beam, reason=motion.reason, ringing=ringing, trajectories=record.trajectories)
    if beam:
        scene = replace(scene, stator=replace(scene.stator, diffraction=True))
    electrical = electrical_block(scene.drive, motion, further)
    record = replace(
        record, scene=scene, wave=wave_block(scene, motion, ringing), electrical=electrical,
        points=with_powers(record.points, electrical), left_out=neglected, surface=surface_columns(scene, motion),
        surface_motion=motion, further_motions=further, meshed_pieces=motion.wave.meshed_pieces,
    )  # fmt: skip
    return replace(record, heat=heat_block(record))
