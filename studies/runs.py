"""From a scene to its record: surface motion per volt, orbits at each voltage, contact, velocity, remarks.

Only the parts that the scene needs are imported and computed.  The tolerance bounds the error of the last quantity;
`studies.solve.refinement` says how accurately the stator is solved for it.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import fem
from studies.model.contact import Contact
from studies.model.model import Model
from studies.model.resolve import with_numbers
from studies.progress import reported_to
from studies.record import Record
from studies.record.blocks import ErrorBlock, WaveBlock
from studies.refusal import RunError
from studies.remarks.left_out import left_out
from studies.remarks.model_error import with_model_error
from studies.remarks.run_warnings import warnings_of
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.solve.contact_at_level import slider_answer
from studies.solve.electrical import electrical_block, with_powers
from studies.solve.free_wave import free_wave_record
from studies.solve.heat import heat_block
from studies.solve.point_answer import SliderAnswer
from studies.solve.refinement import ROUNDS, finer
from studies.solve.ring_up import RingUp
from studies.solve.ripple import with_ripple
from studies.solve.solved_stator import SolvedStator
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


def _run(scene: Scene, tolerance: float) -> Record:
    model = Model(scene)
    model, heated = at_own_temperature(with_numbers(model), tolerance)
    if model.scene.slider is not None:
        record = _with_slider(model, tolerance)
    elif model.scene.transducer:
        record = _surface_alone(model, tolerance)
    else:
        record = replace(free_wave_record(model, tolerance), left_out=left_out(model))
    if model.scene.uncertain is not None:
        from studies.solve.uncertainty import with_bands  # imports scipy.stats, 0.3 s

        record = with_bands(record, model.written)
    record = with_model_error(replace(record, heat=record.heat | heated))
    return replace(record, warnings=warnings_of(record))


def _with_slider(model: Model, tolerance: float) -> Record:
    """Return the record of a slider on a driven stator or a prescribed wave."""
    start_time, stators = time.perf_counter(), Stators(tolerance=tolerance, slider=True)
    driven, answer, seconds = _refined(model, stators)
    motion, refusal = None, ""
    if driven.solved is not None:
        motion = stators.motion_under(driven)
        # of a passing wave, the centre is one place of many
        vanished = "" if driven.passing else node(motion, model.scene.positions)
        refusal = vanished or driven.refusal
        if not refusal and not driven.rough:
            contact_start = time.perf_counter()
            answer = _rippled(answer, driven, motion, tolerance)
            seconds += time.perf_counter() - contact_start
    elif model.scene.planar:
        answer = _in_plane(answer, driven, tolerance)
    record = Record(
        scene=model.scene, tolerance=tolerance, points=answer.points, summary=answer.summary,
        trajectories=answer.trajectories, pillars=answer.pillars, slider_wave=answer.slider_wave, error=answer.error,
        shortfall=f"no answer: {refusal}" if refusal else answer.shortfall(tolerance), refused=bool(refusal),
        seconds={"contact": seconds},
    )  # fmt: skip
    if motion is None:
        given = model.scene.wave
        wave = WaveBlock(frequency_Hz=given.frequency, surface_ratio=given.tangential_ratio)
        return replace(record, wave=wave, left_out=left_out(model))
    return _on_stator(record, model, motion, start_time, driven.ringing)


def _refined(model: Model, stators: Stators) -> tuple[Contact, SliderAnswer, float]:
    """Return the contact, its answers at all levels, and the time in s that they took.

    The stator is solved until it is as accurate as the velocities need.
    """
    driven, before = stators.bursting(stators.contact(model)), None
    answer, seconds = _timed_answer(driven, stators.tolerance)
    for _ in range(ROUNDS - 1):
        goal = finer(answer.answers, driven, stators.tolerance, before)
        if goal is None:
            break
        before = driven
        try:
            driven = stators.bursting(stators.contact(model, goal))
        except RunError:
            break  # the answer of the round before is recorded, with its error
        answer, more = _timed_answer(driven, stators.tolerance)
        seconds += more
    return driven, answer, seconds


def _timed_answer(driven: Contact, tolerance: float) -> tuple[SliderAnswer, float]:
    start_time = time.perf_counter()
    answer = slider_answer(driven, tolerance=tolerance)
    return answer, time.perf_counter() - start_time


def _surface_alone(model: Model, tolerance: float) -> Record:
    """Return the record of a driven stator without a slider, whose result is the amplitude of its surface."""
    start_time, stators = time.perf_counter(), Stators(tolerance=tolerance, slider=False)
    motion = stators.motion(model.alone, model.scene.positions)
    error = motion.relative_error(model.scene.positions[:1])
    short = f"the surface amplitude's error is {error:.1e}, {tolerance:.1e} was asked for: give a larger tolerance"
    record = Record(
        scene=model.scene, tolerance=tolerance, points=amplitude_points(model, motion),
        error=ErrorBlock(relative=error, parts={"stator": error}), shortfall=short if error > tolerance else "",
    )  # fmt: skip
    return _on_stator(record, model, motion, start_time)


def _on_stator(
    record: Record, model: Model, motion: SurfaceMotion, start_time: float, ringing: RingUp | None = None
) -> Record:
    """Return a record with what the motion of its stator's surface adds."""
    if motion.beam is not None:
        model = model.with_blocks(stator=replace(model.scene.stator, diffraction=True))
    electrical = electrical_block(model, motion)
    neglected = left_out(
        model, beam=motion.beam is not None, reason=motion.reason, ringing=ringing, trajectories=record.trajectories
    )
    record = replace(
        record, scene=model.scene, wave=wave_block(model, motion, ringing), electrical=electrical,
        points=with_powers(record.points, electrical), left_out=neglected, surface=surface_columns(model, motion),
        surface_motion=motion, meshed_pieces=motion.wave.meshed_pieces,
    )  # fmt: skip
    record = replace(record, heat=heat_block(record))
    seconds = time.perf_counter() - start_time - sum(record.seconds.values())
    return replace(record, seconds={"stator": seconds} | record.seconds)


def _rippled(answer: SliderAnswer, driven: Contact, motion: SurfaceMotion, tolerance: float) -> SliderAnswer:
    """Return the answer with mean and range of the velocity over half a wavelength."""
    LOGGER.debug("velocities about the position")
    if driven.scene.planar:
        return _in_plane(answer, driven, tolerance)
    solved = SolvedStator.of(motion, driven.scene.positions, nearby=not driven.passing)
    driven = Contact.of_stator(driven.model, solved, lambda: motion)
    return (with_wave_ripple if driven.passing else with_ripple)(answer, driven, tolerance)


def _in_plane(answer: SliderAnswer, driven: Contact, tolerance: float) -> SliderAnswer:
    """Return the answer of a slider in the plane with mean and range of the velocity over nearby places."""
    from studies.solve.plane_ripple import with_plane_ripple

    return with_plane_ripple(answer, driven, tolerance)
