"""The chain from a scene to its record: surface motion per volt, orbits at each voltage, contact, velocity.

Only the parts that the scene needs are imported and computed.  The tolerance bounds the error of the last quantity.
The stator is first solved to a quarter of it.  The contact amplifies the error of the stator, near the threshold by a
factor of 20.  If the velocity then misses its tolerance, the stator is solved again to the accuracy that the velocity
needs.
"""

import logging
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import fem
from studies.model import resolve
from studies.model.contact import Contact
from studies.model.stator_alone import stator_alone
from studies.progress import reported_to
from studies.record import Record
from studies.record.blocks import WaveBlock
from studies.refusal import RunError
from studies.remarks.left_out import left_out
from studies.remarks.model_error import with_model_error
from studies.remarks.run_warnings import warnings_of
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.solve.changed_contacts import ChangedContacts
from studies.solve.contact_at_level import SHARE, SliderAnswer, slider_answer
from studies.solve.electrical import electrical_block, with_powers
from studies.solve.free_wave import free_wave_record
from studies.solve.heat import heat_block
from studies.solve.ring_up import RingUp
from studies.solve.ripple import with_ripple
from studies.solve.solved_stator import SolvedStator
from studies.solve.surface_blocks import amplitude_blocks, node, surface_columns, unresolved, wave_block
from studies.solve.surface_motion import SurfaceMotion

LOGGER = logging.getLogger(__name__)
# If the error of the motion is more than this fraction of that in the round before, no further round is tried, because
# the remaining error is that of the beam, which a finer section does not reduce.
STALLED = 0.7
# If the beam's own error at the best point is more than this multiple of the tolerance, no finer section is tried.
HOPELESS = 3
ROUNDS = 3  # largest number of solutions of the stator; each round determines the tolerance of the next


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
    written, scene = scene, resolve.resolved(scene)
    steady = None
    if scene.stator is not None and scene.stator.temperature == "steady":
        from studies.solve.steady_temperature import steady_temperature

        steady = steady_temperature(scene, tolerance)
        scene, written = (
            replace(each, stator=replace(each.stator, temperature=steady.temperature)) for each in (scene, written)
        )
    if scene.wave is not None:
        record = _prescribed(scene, tolerance)
    elif scene.transducer:
        contacts = ChangedContacts(scene.to_table(), tolerance=tolerance, as_run=True)
        record = _driven(scene, contacts)
    else:
        record = replace(free_wave_record(scene, tolerance), left_out=left_out(scene))
    if scene.uncertain is not None:
        from studies.solve.uncertainty import with_bands

        record = with_bands(record, written)
        if record.scene.slider is not None:  # so that the stored scene runs to the same intervals
            slider = replace(record.scene.slider, preload=written.slider.preload)
            record = replace(record, scene=replace(record.scene, slider=slider))
    if steady is not None:
        record = replace(record, heat=record.heat | steady.block())
    record = with_model_error(record)
    return replace(record, warnings=warnings_of(record))


def _prescribed(scene: Scene, tolerance: float) -> Record:
    """Return the record of a scene with a prescribed wave: its orbit, then the contact."""
    start_time = time.perf_counter()
    answer = slider_answer(Contact.prescribed(scene), tolerance=tolerance)
    wave = WaveBlock(frequency_Hz=scene.wave.frequency, surface_ratio=scene.wave.tangential_ratio)
    seconds = {"contact": time.perf_counter() - start_time}
    blocks = answer.blocks(tolerance)
    return Record(scene=scene, tolerance=tolerance, wave=wave, **blocks, seconds=seconds, left_out=left_out(scene))


def _driven(scene: Scene, contacts: ChangedContacts) -> Record:
    """Return the record of a driven stator: the motion of its surface, then the contact under a slider."""
    start_time, tolerance = time.perf_counter(), contacts.tolerance
    positions, ringing, seconds = scene.positions, None, {}
    if scene.slider is None:
        motion = contacts.motion(stator_alone(scene), positions, tolerance)
        blocks = amplitude_blocks(scene, motion, positions[0], tolerance)
    else:
        motion, answer, ringing, seconds["contact"] = _with_contact(scene, contacts)
        vanished = "" if scene.on_pillars else node(motion, positions)  # the centre is one position of many pillars
        refusal = vanished or unresolved(motion, positions)
        if not refusal:
            answer = _rippled(scene, motion, answer, tolerance, seconds)
        blocks = answer.blocks(tolerance)
        if refusal:
            blocks |= {"shortfall": f"no answer: {refusal}", "refused": True}
    if motion.beam is not None:
        scene = replace(scene, stator=replace(scene.stator, diffraction=True))
    electrical = electrical_block(scene, motion)
    blocks["points"] = with_powers(blocks["points"], electrical)
    neglected = left_out(
        scene, beam=motion.beam is not None, reason=motion.reason, ringing=ringing,
        trajectories=blocks.get("trajectories", ()),
    )  # fmt: skip
    record = Record(
        scene=scene, tolerance=tolerance, wave=wave_block(scene, motion, positions[0], ringing), electrical=electrical,
        left_out=neglected, surface=surface_columns(scene, motion), surface_motion=motion,
        meshed_pieces=motion.wave.meshed_pieces, **blocks,
    )  # fmt: skip
    record = replace(record, heat=heat_block(record))
    return replace(record, seconds={"stator": time.perf_counter() - start_time - sum(seconds.values())} | seconds)


def _rippled(
    scene: Scene, motion: SurfaceMotion, answer: SliderAnswer, tolerance: float, seconds: dict
) -> SliderAnswer:
    """Return the answer with mean and range over half a wavelength; their time is added to the contact's."""
    LOGGER.debug("velocities about the position")
    start_time = time.perf_counter()
    solved = SolvedStator.of(motion, scene.positions, nearby=not scene.on_pillars)
    driven = Contact.of_stator(scene, solved, motion)
    if scene.on_pillars:
        from studies.solve.pillar_ripple import with_pillar_ripple

        answer = with_pillar_ripple(answer, driven, tolerance)
    else:
        answer = with_ripple(answer, driven, tolerance)
    seconds["contact"] += time.perf_counter() - start_time
    return answer


def _with_contact(scene: Scene, contacts: ChangedContacts) -> tuple[SurfaceMotion, SliderAnswer, RingUp | None, float]:
    """Return surface motion, answer, ring-up, and the time in s of the contact.

    The stator is solved in up to ROUNDS rounds, until it is as accurate as the velocity needs.
    """
    stator, positions, seconds = stator_alone(scene), scene.positions, 0.0
    motion = contacts.motion(stator, positions, SHARE * contacts.tolerance)

    def solve_contact() -> tuple[SliderAnswer, RingUp | None]:
        nonlocal seconds
        driven = contacts.bursting(Contact.of_stator(scene, SolvedStator.of(motion, positions), motion), motion)
        contact_start = time.perf_counter()
        answer = slider_answer(driven, tolerance=contacts.tolerance)
        seconds += time.perf_counter() - contact_start
        return answer, driven.ringing

    answer, ringing = solve_contact()
    for _ in range(ROUNDS - 1):
        section, whole = motion.wave.relative_error, motion.relative_error(positions)
        rings = 0.0 if ringing is None else ringing.error
        goal = needed_section_tolerance(answer, section, contacts.tolerance, rings, beam_share=1 - section / whole)
        if goal is None:
            break
        try:
            motion = contacts.motion(stator, positions, goal)
        except RunError:
            break  # the answer of the round before is recorded, with its error
        answer, _ = solve_contact()
        if motion.wave.relative_error >= section or motion.relative_error(positions) > STALLED * whole:
            break
    return motion, answer, ringing, seconds


def needed_section_tolerance(
    answer: SliderAnswer, reached: float, tolerance: float, ringing: float, beam_share: float = 0.0
) -> float | None:
    """Return the tolerance of the section that the velocity needs; None if the section suffices or cannot help.

    Parameters
    ----------
    answer : SliderAnswer
    reached : float
        Present error of the section.
    tolerance : float
        Tolerance of the velocity.
    ringing : float
        Contribution of the ring-up to the stator's part of the velocity's error; a finer section does not reduce it.
    beam_share : float
        Fraction of the rest of this part that is the beam's own error; a finer section does not reduce it either.

    Notes
    -----
    Let s be the largest stator part of the points that miss the tolerance t, r the ring-up's contribution and
    b = beam_share (s - r) that of the beam.  The section contributes s - r - b, in proportion to its error.  It may
    contribute (t - b) / 2 - r, because half of t - b is reserved for the contact.
    """
    parts = [stator for stator, contact in answer.parts if stator + contact > tolerance]
    if not parts or max(parts) <= ringing:
        return None
    beam = beam_share * (max(parts) - ringing)
    allowed = 0.5 * (tolerance - beam) - ringing
    if allowed <= 0 or beam_share * min(parts) > HOPELESS * tolerance:
        return None
    goal = reached * allowed / (max(parts) - ringing - beam)
    return goal if goal < reached else None
