"""The chain from a scene to its record: stator at its frequency, times the voltage, contact, velocity.

Only what the scene needs is imported and computed.  The tolerance bounds the last quantity.  The stator
begins with a quarter of it; where the contact turns out to multiply the stator's error (near the threshold
by 20), the stator is solved again, better.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import fem
from studies.chain import resolve
from studies.chain.blocks import amplitude_blocks, node, surface_columns, wave_block
from studies.chain.bridge import DrivenContact, wave_along
from studies.chain.electrical import electrical_block, with_available_power
from studies.chain.free_wave import free_wave_record
from studies.chain.left_out import left_out
from studies.chain.model_error import with_model_error
from studies.chain.points import SliderAnswer, slider_answer
from studies.chain.ring_up import ring_up
from studies.chain.surface_motion import SurfaceMotion, solved_motion
from studies.chain.warnings import warnings_of
from studies.record import Record
from studies.refusal import RunError, SceneError
from studies.scene import Scene

__all__ = ["SHARE", "run"]

LOGGER = logging.getLogger("studies.run")
SHARE = 0.25  # of the tolerance, for the stator at first and for the contact
# of the motion's error: what is left then is the beam's own, which no finer section makes smaller
STALLED = 0.7
HOPELESS = 3  # tolerances of the beam's own error at the best point, beyond which no finer section is tried
ROUNDS = 3  # of the stator, each with the tolerance that the one before found to be needed


def run(
    scene: Scene | str | Path = "twente",
    *,
    tolerance: float = 1e-3,
    progress: Callable[[str], None] | None = None,
) -> Record:
    """Run the chain that a scene needs.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, its file, or the name of one that ships.
    tolerance : float
        Bound of the error of the last quantity: slider velocity over max(|v|, omega |u_x| / 10); without a
        slider surface amplitude, relative; for the free wave its velocity, relative.
    progress : callable, optional
        Told in a few words what is being done.

    Returns
    -------
    Record
        Its ``shortfall`` says why it is no answer within the tolerance, if it is none.

    Raises
    ------
    SceneError
        If the scene cannot be read, or is refused by the physics.
    RunError
        If there is nothing to record.

    Examples
    --------
    >>> run("rayleigh").wave["phase_velocity_m_per_s"]  # doctest: +ELLIPSIS
    2181...
    """
    if isinstance(tolerance, str) or not 0 < tolerance < 1:
        raise SceneError("tolerance", f"must be a number above 0 and below 1, got {tolerance!r}")
    begun = time.perf_counter()
    with fem.blas_on_one_thread():
        record = _run(scene if isinstance(scene, Scene) else Scene.load(scene), tolerance, progress)
    total = time.perf_counter() - begun
    parts = record.seconds | {"other": total - sum(record.seconds.values())}
    return replace(record, seconds={"total": total, **parts})


def _run(scene: Scene, tolerance: float, progress: Callable[[str], None] | None) -> Record:
    say = progress or LOGGER.info
    scene = resolve.resolved(scene)
    if scene.wave is not None:
        record = _given(scene, tolerance, say)
    elif scene.transducer:
        record = _driven(scene, tolerance, say)
    else:
        record = free_wave_record(scene, tolerance)
    if scene.uncertain is not None:
        from studies.chain.uncertainty import with_bands

        record = with_bands(record, progress=say)
    record = with_model_error(record)
    return replace(record, warnings=warnings_of(record))


def _given(scene: Scene, tolerance: float, say: Any) -> Record:
    """Return the record of a given wave: its orbit, then the contact."""
    begun = time.perf_counter()
    answer = slider_answer(DrivenContact.given(scene), tolerance=tolerance, progress=say)
    return Record(
        scene=scene,
        tolerance=tolerance,
        wave={"frequency_Hz": scene.wave.frequency, "surface_ratio": scene.wave.tangential_ratio},
        **answer.blocks(tolerance),
        seconds={"contact": time.perf_counter() - begun},
        left_out=left_out(scene),
    )


def _driven(scene: Scene, tolerance: float, say: Any) -> Record:
    """Return the record of a driven stator: the motion of its surface, then the contact under a slider."""
    begun = time.perf_counter()
    slider, ringing, seconds = scene.slider, None, {}
    place = (scene.stator.length / 2, 0.0) if slider is None else slider.center
    places = (place,) if slider is None else tuple(dict.fromkeys((place, *slider.places)))

    def solved(goal: float) -> SurfaceMotion:
        # one that misses its goal is recorded with its error, which says whether it is good enough
        return solved_motion(scene, places, tolerance=goal, progress=say, missed=True)

    if slider is None:
        motion = solved(tolerance)
        blocks = amplitude_blocks(scene, motion, place, tolerance)
    else:
        motion = solved(SHARE * tolerance)
        if scene.burst is not None and not motion.covered(place):
            ringing = ring_up(scene, place, progress=say)
        motion, answer, seconds["contact"] = _with_contact(scene, motion, solved, tolerance, say, ringing)
        blocks = answer.blocks(tolerance)
    if slider is not None and (still := node(motion, places)):
        blocks["shortfall"] = still
    if motion.beam is not None:
        scene = replace(scene, stator=replace(scene.stator, diffraction=True))
    electrical = electrical_block(scene, motion)
    blocks["points"] = with_available_power(blocks["points"], electrical)
    record = Record(
        scene=scene,
        tolerance=tolerance,
        wave=wave_block(scene, motion, place, ringing),
        electrical=electrical,
        left_out=left_out(
            scene,
            beam=motion.beam is not None,
            reason=motion.reason,
            ringing=ringing,
            trajectories=blocks.get("trajectories", ()),
        ),
        surface=surface_columns(scene, motion),
        surface_motion=motion,
        **blocks,
    )
    return replace(record, seconds={"stator": time.perf_counter() - begun - sum(seconds.values())} | seconds)


def _with_contact(
    scene: Scene, motion: SurfaceMotion, solved: Callable, tolerance: float, say: Any, ringing: Any
) -> Any:
    """Return motion, answer and the contact's seconds; the motion is solved again where its error is too large."""
    slider, seconds = scene.slider, 0.0
    places = tuple(dict.fromkeys((slider.center, *slider.places)))

    def answered() -> SliderAnswer:
        nonlocal seconds
        started = time.perf_counter()
        along = None if scene.burst is None else wave_along(motion, slider)
        driven = DrivenContact.of_motion(scene, motion, ringing=ringing, along=along)
        answer = slider_answer(driven, tolerance=tolerance, progress=say)
        seconds += time.perf_counter() - started
        return answer

    answer = answered()
    for _ in range(ROUNDS - 1):
        section, whole = motion.wave.relative_error, motion.relative_error(places)
        rings = 0.0 if ringing is None else ringing.error
        goal = _needed(answer, section, tolerance, rings, beam_share=1 - section / whole)
        if goal is None:
            break
        try:
            motion = solved(goal)
        except RunError:
            break  # the answer that stands is recorded, with its error
        answer = answered()
        if motion.wave.relative_error >= section or motion.relative_error(places) > STALLED * whole:
            break
    return motion, answer, seconds


def _needed(
    answer: SliderAnswer, reached: float, tolerance: float, ringing: float, beam_share: float = 0.0
) -> float | None:
    """Return the section's tolerance that would do, or None where it is good enough or cannot help.

    ``ringing`` is what the ring-up adds to the stator's part, and ``beam_share`` the share of it that is the beam's
    own: no finer section makes these smaller.
    """
    parts = [stator for stator, contact in answer.parts if stator + contact > tolerance]
    if not parts or max(parts) <= ringing:
        return None
    beam = beam_share * (max(parts) - ringing)
    room = 0.5 * (tolerance - beam) - ringing
    if room <= 0 or beam_share * min(parts) > HOPELESS * tolerance:
        return None
    goal = reached * room / (max(parts) - ringing - beam)
    return goal if goal < reached else None
