"""The points of a run: the steady velocity, its regime and its error at each level of the drive."""

import logging
import math
from dataclasses import replace

import contact
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import Contact
from studies.progress import counted
from studies.record.blocks import SummaryBlock
from studies.record.point import Point
from studies.record.status import Status
from studies.record.values import Columns
from studies.solve.crest_pressure import contact_load
from studies.solve.event_counts import burst_events, burst_values, steady_events
from studies.solve.face_motion import face_point
from studies.solve.heavy_limits import heavy_limits
from studies.solve.loaded_wave import wave_point, wave_tables
from studies.solve.point_answer import PointAnswer, SliderAnswer
from studies.solve.refinement import SHARE
from studies.solve.slider_burst import STEADY_METHODS, followed_burst, method_of
from studies.solve.velocity_error import judged, velocity_sensitivities

LOGGER = logging.getLogger(__name__)

# Velocity of a slider from which on it has no answer, m/s: that of surface waves on soft polymers, the slowest
# (`scene_warnings.USUAL_VELOCITIES`).  The contact's forces are those of bodies at rest.
RUNAWAY = 200.0
TOGETHER = 1e-3  # relative difference of the releases of two contacts that leave the surface together


def slider_answer(driven: Contact, *, tolerance: float) -> SliderAnswer:
    """Return the answers at all levels of the scene; the contact solvers get ``SHARE`` of the tolerance."""
    LOGGER.info("contact")
    summary, threshold = _summary(driven)
    answers, last = [], None
    for number, level in enumerate(driven.scene.levels, start=1):
        LOGGER.debug(f"point {number} of {len(driven.scene.levels)}")
        answer = point_answer(driven, level, tolerance)
        volts = None if driven.scene.wave is not None else level
        point = Point(voltage_V=volts) | driven.amplitudes_at(level) | answer.point
        if not (driven.passing or driven.heavy):
            point |= contact_load(driven.slider_along_x, driven.at(level), threshold / level if level else math.inf)
        if answer.motion is not None:
            point |= face_point(driven, answer.motion, level)
        answers.append(replace(answer, point=point))
        last = answer.motion if answer.motion is not None and level > 0.0 else last
    tables = {name: Columns(table) for name, table in wave_tables(last).items()}
    return SliderAnswer(answers=tuple(answers), driven=driven, summary=summary, **tables)


def velocity_answer(driven: Contact, *, tolerance: float) -> SliderAnswer:
    """Return the answers of `slider_answer` without threshold, release and loads of the contacts."""
    shown = counted(LOGGER, "velocity at each level", driven.scene.levels)
    return SliderAnswer(answers=tuple(point_answer(driven, level, tolerance) for level in shown), driven=driven)


def point_answer(
    driven: Contact, level: float, tolerance: float, *, bursting: bool = True, balance: bool = True
) -> PointAnswer:
    """Return the answer at one level; if a solver does not converge, the status of the point says so.

    If ``bursting`` is False, only the steady state is computed, even if the scene has a burst; ``balance`` is that of
    `rough_answer`.
    """
    try:
        if driven.scene.planar:
            from studies.solve.plane_answer import plane_point_answer

            answer = plane_point_answer(driven, level, tolerance, bursting=bursting)
            point = answer.point
            _refuse_runaway(math.hypot(point.velocity_m_per_s or 0.0, point.lateral_velocity_m_per_s or 0.0))
            return answer
        if driven.rough and not (driven.as_law and driven.scene.burst is not None):
            from studies.solve.rough_answer import rough_answer

            answer = rough_answer(driven, level, tolerance, balance=balance)
        else:
            answer = _answer(driven, level, tolerance, bursting)
            if driven.rough:
                from studies.solve.rough_answer import sample_scatter

                velocity = answer.point.velocity_m_per_s or 0.0
                answer = replace(answer, point=answer.point | sample_scatter(driven, level, velocity))
        _refuse_runaway(answer.point.velocity_m_per_s)
        return answer
    except contact.ConvergenceError as error:
        return PointAnswer(point=Point(status=Status.NO_ANSWER.because(" ".join(str(error).split()))))


def _refuse_runaway(velocity: float) -> None:
    """Raise if a slider in its steady state runs at `RUNAWAY` m/s or faster."""
    if abs(velocity) >= RUNAWAY:
        raise contact.ConvergenceError(
            "runaway",
            f"the slider would run at {velocity:.4g} m/s, and from {RUNAWAY:g} m/s on, the velocity of the slowest "
            "surface waves, the contact is not quasi-static: lower slider.load or the wave's amplitude",
        )


def _answer(driven: Contact, level: float, tolerance: float, bursting: bool) -> PointAnswer:
    orbits, goal = driven.at(level), SHARE * tolerance
    method = method_of(driven.scene, "the steady state", STEADY_METHODS)

    def steady(some, near=None):
        return contact.steady(driven.slider, some, tolerance=goal, method=method, near=near)

    with slider_keys():
        state = steady(orbits)
    nearby = _nearby(driven.slider, state, steady)
    by_amplitude, by_orbit = velocity_sensitivities(state.velocity, orbits, driven.stator_error, nearby)
    from_stator = driven.stator_error * by_orbit
    from_contact, answer, trajectory = state.relative_error, state.answer, None
    known = driven.stator_error > 0 or (driven.passing and level > 0.0)
    sensitivity = by_amplitude if known else None
    point = Point(velocity_m_per_s=state.velocity, regime=state.regime, amplitude_sensitivity=sensitivity)
    events = steady_events(state) | wave_point(driven, state, level)
    if driven.holding:
        power = state.ledger.adhesion * driven.scene.frequency * driven.scene.slider.share
        point |= Point(adhesion_power_W=power)
    if bursting and driven.scene.burst is not None:
        trajectory, moved = followed_burst(driven, level, state.velocity, goal)
        point |= moved | burst_values(trajectory)
        events |= burst_events(trajectory)
        from_stator += 0.0 if driven.ringing is None else driven.ringing.error
        if trajectory.relative_error > from_contact or answer.status == Status.OK:
            from_contact, answer = max(from_contact, trajectory.relative_error), trajectory.answer
    # the contact may exceed its fraction of the tolerance: the sum of both errors decides
    point |= judged(tolerance, from_stator, from_contact, "" if answer.status == Status.OK else answer.why) | events
    return PointAnswer(
        point=point, from_stator=from_stator, from_contact=from_contact, trajectory=trajectory, motion=state
    )


def _nearby(slider, state, steady):
    """Return a function that gives the velocity for orbits close to those of a steady state.

    It uses the averaged motion, shifted so that it agrees with the state, because averaging is much faster. Where
    averaging does not converge, it uses ``steady``.
    """
    if state.loaded is not None:
        return lambda orbits: steady(orbits, state).velocity
    try:
        shift = state.velocity - contact.mean_motion(slider, state.orbits).velocity
    except contact.ConvergenceError:
        return lambda orbits: steady(orbits).velocity

    def velocity(orbits):
        try:
            return contact.mean_motion(slider, orbits).velocity + shift
        except contact.ConvergenceError:
            return steady(orbits).velocity

    return velocity


def _summary(driven: Contact) -> tuple[SummaryBlock, float]:
    """Return the values of threshold and release that exist, and the factor on the orbits at the threshold.

    Neither is computed on a loaded wave, where a threshold takes about as long as 30 levels; in the plane no release.
    """
    if driven.heavy:
        return _limits(driven, *heavy_limits(driven)), math.inf
    with slider_keys():
        driven.slider  # noqa: B018  a cached property: parameters that the contact refuses are reported here
    if driven.scene.planar:
        from studies.solve.plane_answer import plane_threshold

        threshold = plane_threshold(driven)
        return _limit(driven, "threshold", threshold), threshold
    if driven.passing:
        return SummaryBlock(), math.inf
    threshold, release = (
        factor_of(driven.slider, driven.orbits) for factor_of in (contact.threshold_factor, contact.release_factor)
    )
    return _limits(driven, threshold, release) | _each_release(driven), threshold


def _limits(driven: Contact, threshold: float, release: float) -> SummaryBlock:
    """Return threshold and release, given as factors on the orbits, where they are finite."""
    return _limit(driven, "threshold", threshold) | _limit(driven, "release", release)


def _limit(driven: Contact, name: str, factor: float) -> SummaryBlock:
    """Return a limit as an amplitude in m and, on a stator, as a voltage in V; empty where it is infinite."""
    if not math.isfinite(factor):
        return SummaryBlock()
    volts = None if driven.scene.wave is not None else factor
    return SummaryBlock(**{f"{name}_amplitude_m": factor * driven.amplitude, f"{name}_voltage_V": volts})


def _each_release(driven: Contact) -> SummaryBlock:
    """Return which contacts leave the surface first and last, and the level of the last; empty if all leave at once."""
    if len(driven.orbits) == 1:
        return SummaryBlock()
    answers = enumerate(contact.releases(driven.slider, driven.orbits), start=1)
    factors = {number: float(answer.value) for number, answer in answers if answer is not None}
    leaving = {number: factor for number, factor in factors.items() if math.isfinite(factor)}
    if not leaving:
        return SummaryBlock()
    first, last = min(leaving, key=leaving.__getitem__), max(leaving, key=leaving.__getitem__)
    if leaving[last] <= leaving[first] * (1 + TOGETHER) and len(leaving) == len(driven.orbits):
        return SummaryBlock()
    summary = SummaryBlock(first_released_contact=first, touching_contacts=len(factors))
    if len(leaving) < len(factors):  # some never leave
        return summary
    return summary | SummaryBlock(last_released_contact=last) | _limit(driven, "last_release", leaving[last])
