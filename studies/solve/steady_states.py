"""Steady states of many contacts at once, each with its error: averaged where that is accurate enough.

Averaged states are computed together in a compiled loop and cost microseconds each.  An averaged state is accepted if
its error is below a fraction of the tolerance; otherwise the motion itself is solved, as in a run.
"""

from studies.model.wave_to_contact import Contact
from studies.record.point import Point
from studies.solve.averaged_states import averaged_states
from studies.solve.contact_at_level import RUNAWAY, point_answer
from studies.solve.point_answer import PointAnswer
from studies.solve.refinement import SHARE
from studies.solve.velocity_error import judged

AVERAGED_METHODS = ("auto", "averaged")  # methods of a scene that allow the compiled loop of averaged states


def steady_answers(states: list[tuple[Contact, float]], tolerance: float) -> list[PointAnswer]:
    """Return the steady state of each contact at a level.

    Parameters
    ----------
    states : list of (Contact, float)
        Contact and level.  The level is a factor on the contact's orbits: the source voltage in V, or the amplitude in
        m of a prescribed wave.
    tolerance : float
        Tolerance of the velocity over its reference speed.
    """
    answers = averaged_answers(states, tolerance)
    return [
        point_answer(driven, level, tolerance, bursting=False) if answer is None else answer
        for answer, (driven, level) in zip(answers, states, strict=True)
    ]


def averaged_answers(states: list[tuple[Contact, float]], tolerance: float) -> list[PointAnswer | None]:
    """Return the averaged steady state of each contact as in `steady_answers`, or None if its error is too large."""
    answers: list[PointAnswer | None] = [None] * len(states)
    allowed = [
        k for k, (driven, _) in enumerate(states)
        if driven.scene.slider.method in AVERAGED_METHODS
        and not (driven.passing or driven.scene.planar or driven.heavy)
    ]  # fmt: skip
    some = (states[k] for k in allowed)
    contacts = [(driven.slider, driven.orbits, driven.stator_error, level) for driven, level in some]
    for k, state in zip(allowed, averaged_states(contacts), strict=True):
        accurate = state.regime != "unknown" and state.from_contact <= SHARE * tolerance
        if accurate and abs(state.velocity) < RUNAWAY:
            point = Point(velocity_m_per_s=state.velocity, regime=state.regime)
            answers[k] = PointAnswer(
                point=point | judged(tolerance, state.from_stator, state.from_contact),
                from_stator=state.from_stator, from_contact=state.from_contact, averaged=True, thrust=state.thrust,
            )  # fmt: skip
    return answers
