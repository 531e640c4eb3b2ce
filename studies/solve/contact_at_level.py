"""The points of a run: the steady velocity, its regime and its error at each level of the drive."""

import logging
import math
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import contact
from studies.model.contact import Contact
from studies.model.scene_errors import slider_keys
from studies.record.point import Point
from studies.record.status import Status
from studies.solve.bursts import STEADY_METHODS, followed_burst, method_of
from studies.solve.event_counts import burst_tally, burst_values, steady_tally
from studies.solve.velocity_error import judged, velocity_sensitivities

LOGGER = logging.getLogger(__name__)

# Velocity of a slider from which on it has no answer, m/s: that of surface waves on soft polymers, the slowest
# (`scene_warnings.USUAL_VELOCITIES`).  The contact's forces are those of bodies at rest.
RUNAWAY = 200.0
TOGETHER = 1e-3  # relative difference of the releases of two contacts that leave the surface together
SHARE = 0.25  # fraction of the tolerance for the contact and, in the first attempt, for the stator


@dataclass(frozen=True, kw_only=True)
class SliderAnswer:
    """The answers of the slider at all levels of a run."""

    points: tuple[Point, ...]
    # Errors of each point due to stator and contact, relative to the reference speed
    parts: tuple[tuple[float, float], ...]
    summary: dict  # threshold and release
    trajectories: tuple  # with a burst
    pillars: dict = field(default_factory=dict)  # columns of pillars.csv
    slider_wave: dict = field(default_factory=dict)  # columns of slider_wave.csv

    def blocks(self, tolerance: float) -> dict:
        """Return the blocks of the record, with the largest error of all points."""
        failed = [point for point in self.points if "relative_error" not in point]
        parts = [part for part, point in zip(self.parts, self.points, strict=True) if "relative_error" in point]
        names = ("points", "summary", "trajectories", "pillars", "slider_wave")
        blocks = {name: getattr(self, name) for name in names}
        if parts:
            stator, contact = max(parts, key=sum)
            error = stator + contact
            blocks["error"] = {"relative": error, "parts": {"stator": stator, "contact": contact}}
            if error > tolerance:
                blocks["shortfall"] = (
                    f"the velocity's error is {error:.1e} (stator {stator:.1e}, contact {contact:.1e}), "
                    f"{tolerance:.1e} was asked for: see error.parts, or give a larger tolerance"
                )
        if failed:
            count = f"{len(failed)} of {len(self.points)}"
            blocks["shortfall"] = f"{count} points have no answer: {failed[0]['status']}"
        return blocks


def slider_answer(driven: Contact, *, tolerance: float) -> SliderAnswer:
    """Return the answers at all levels of the scene; the contact solvers get ``SHARE`` of the tolerance."""
    scene, on_pillars = driven.scene, driven.scene.on_pillars
    LOGGER.info("contact")
    summary: dict = {}
    threshold = math.inf
    if not on_pillars:
        with slider_keys():
            driven.slider  # noqa: B018  a cached property: parameters that the contact refuses are reported here
        if not contact.kernels.ready():
            LOGGER.debug(f"compiling its kernels, {contact.kernels.how_often()}")
        summary, threshold = _summary(driven)
    points, parts, trajectories, last = [], [], [], None
    for number, level in enumerate(scene.levels, start=1):
        LOGGER.debug(f"point {number} of {len(scene.levels)}")
        point = {} if scene.wave is not None else {"voltage_V": level}
        answer = point_answer(driven, level, tolerance)
        point |= driven.amplitudes_at(level) | answer.values
        if not on_pillars:
            factor = threshold / level if level else math.inf
            point |= contact_load(driven.slider, driven.at(level), factor)
        points.append(Point.read(point))
        parts.append(answer.parts)
        trajectories += [] if answer.trajectory is None else [(level, answer.trajectory)]
        last = answer.motion or last
    tables: dict = {}
    if last is not None:
        from studies.solve.pillar_points import pillar_tables

        tables = pillar_tables(last)
    return SliderAnswer(
        points=tuple(points), parts=tuple(parts), summary=summary, trajectories=tuple(trajectories), **tables
    )


class PointAnswer(NamedTuple):
    """The slider's answer at one level."""

    values: dict  # as in run.json; only the status if there is no answer
    parts: tuple[float, float] = (0.0, 0.0)  # errors due to stator and contact
    trajectory: Any = None  # only with a burst
    motion: Any = None  # contact.PillarMotion of a slider on pillars


def point_answer(driven: Contact, level: float, tolerance: float, *, bursting: bool = True) -> PointAnswer:
    """Return the answer at one level; if a solver does not converge, the status of the point says so.

    If ``bursting`` is False, only the steady state is computed, even if the scene has a burst.
    """
    try:
        if driven.scene.slider.pillars is None:
            answer = _point_on_balls(driven, level, tolerance, bursting)
        else:
            from studies.solve.pillar_points import pillar_point

            answer = PointAnswer(*pillar_point(driven, level, tolerance, bursting=bursting))
        _refuse_runaway(answer.values["velocity_m_per_s"])
        return answer
    except contact.ConvergenceError as error:
        return PointAnswer({"status": " ".join(str(error).split())})


def _refuse_runaway(velocity: float) -> None:
    """Raise if a slider in its steady state runs at `RUNAWAY` m/s or faster."""
    if abs(velocity) >= RUNAWAY:
        raise contact.ConvergenceError(
            "runaway",
            f"the slider would run at {velocity:.4g} m/s, and from {RUNAWAY:g} m/s on, the velocity of the slowest "
            "surface waves, the contact is not quasi-static: lower slider.load or the wave's amplitude",
        )


def _point_on_balls(driven: Contact, level: float, tolerance: float, bursting: bool) -> PointAnswer:
    orbits, goal = driven.at(level), SHARE * tolerance
    method = method_of(driven.scene, "the steady state", STEADY_METHODS)

    def steady(some: tuple):
        return contact.steady(driven.slider, some, tolerance=goal, method=method)

    with slider_keys():
        state = steady(orbits)
    nearby = _nearby(driven.slider, state, steady)
    sensitivities = velocity_sensitivities(state.velocity, orbits, driven.stator_error, nearby)
    from_stator = driven.stator_error * math.hypot(*sensitivities)
    from_contact, answer = state.relative_error, state.answer
    values, trajectory = {"velocity_m_per_s": state.velocity, "regime": state.regime}, None
    if driven.stator_error > 0:
        values["amplitude_sensitivity"] = sensitivities[0]
    tally = steady_tally(state)
    if bursting and driven.scene.burst is not None:
        trajectory, moved = followed_burst(driven, level, state.velocity, goal)
        values |= moved | burst_values(trajectory)
        tally |= burst_tally(trajectory)
        from_stator += 0.0 if driven.ringing is None else driven.ringing.error
        if trajectory.relative_error > from_contact or answer.status == Status.OK:
            from_contact, answer = max(from_contact, trajectory.relative_error), trajectory.answer
    # the contact may exceed its fraction of the tolerance: the sum of both errors decides
    values |= judged(tolerance, from_stator, from_contact, "" if answer.status == Status.OK else answer.why)
    return PointAnswer(values | tally, (from_stator, from_contact), trajectory)


def _nearby(slider, state, steady):
    """Return a function that gives the velocity for orbits close to those of a steady state.

    It uses the averaged motion, shifted so that it agrees with the state, because averaging is much faster. Where
    averaging does not converge, it uses ``steady``.
    """
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


def contact_load(slider, orbits: tuple, threshold: float) -> dict:
    """Return the contact pressure on the highest crest, and the margin of the amplitude below the threshold.

    ``threshold`` is the factor on the orbits at which the slider starts to move; it is infinite if the slider never
    moves.
    """
    load = {"stick_margin": threshold - 1.0} if math.isfinite(threshold) else {}
    if slider.preload > 0.0:
        crests = slider.offsets(len(orbits)) + [abs(orbit.normal) for orbit in orbits]
        deepest = contact.riding_height(slider, orbits) + max(crests)
        load["contact_pressure_Pa"] = float(slider.pressure(deepest))
    return load


def _summary(driven: Contact) -> tuple[dict, float]:
    """Return the values of threshold and release that exist, and the factor on the orbits at the threshold."""
    limits, factors = {}, {}
    for name, factor_of in (("threshold", contact.threshold_factor), ("release", contact.release_factor)):
        factor = factors[name] = factor_of(driven.slider, driven.orbits)
        if math.isfinite(factor):
            limits[f"{name}_amplitude_m"] = factor * driven.amplitude
            if driven.scene.wave is None:
                limits[f"{name}_voltage_V"] = factor
    return limits | _each_release(driven), factors["threshold"]


def _each_release(driven: Contact) -> dict:
    """Return which contacts leave the surface first and last, and the level of the last; empty if all leave at once."""
    if len(driven.orbits) == 1:
        return {}
    answers = enumerate(contact.releases(driven.slider, driven.orbits), start=1)
    factors = {number: float(answer.value) for number, answer in answers if answer is not None}
    leaving = {number: factor for number, factor in factors.items() if math.isfinite(factor)}
    if not leaving:
        return {}
    first, last = min(leaving, key=leaving.__getitem__), max(leaving, key=leaving.__getitem__)
    if leaving[last] <= leaving[first] * (1 + TOGETHER) and len(leaving) == len(driven.orbits):
        return {}
    summary: dict[str, float] = {"first_released_contact": first, "touching_contacts": len(factors)}
    if len(leaving) < len(factors):  # some never leave
        return summary
    summary |= {"last_released_contact": last, "last_release_amplitude_m": leaving[last] * driven.amplitude}
    return summary | ({} if driven.scene.wave is not None else {"last_release_voltage_V": leaving[last]})
