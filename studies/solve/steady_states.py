"""Steady states of many contacts at once, each with its error.

Averaged states are computed together in a compiled loop and cost microseconds each.  An averaged state is accepted if
its error is below a fraction of the tolerance; otherwise the motion itself is solved, as in a run.
"""

import os

import contact
from studies.model.contact import Contact
from studies.record.status import Status
from studies.solve.contact_at_level import RUNAWAY, SHARE, point_answer
from studies.solve.velocity_error import judged

AVERAGED_METHODS = ("auto", "averaged")  # methods of a scene that allow the compiled loop of averaged states


def steady_answers(states: list[tuple[Contact, float]], tolerance: float) -> list[dict]:
    """Return the steady state of each contact at a level.

    Parameters
    ----------
    states : list of (Contact, float)
        Contact and level.  The level is a factor on the contact's orbits: the source voltage in V, or the amplitude in
        m of a prescribed wave.
    tolerance : float
        Tolerance of the velocity over its reference speed.

    Returns
    -------
    list of dict
        ``velocity_m_per_s``, ``regime``, ``relative_error`` and ``status``; only ``status`` if there is no answer.
    """
    answers = averaged_answers(states, tolerance)
    return [
        steady_answer(driven, level, tolerance) if answer is None else answer
        for answer, (driven, level) in zip(answers, states, strict=True)
    ]


def steady_answer(driven: Contact, level: float, tolerance: float) -> dict:
    """Return the steady state of one contact at a level, solved as in a run.

    ``numerical_error`` is the contact's part of the relative error. It remains in a difference of two such answers,
    whereas the error of averaging is nearly equal in both and cancels.
    """
    point, parts, *_ = point_answer(driven, level, tolerance, bursting=False)
    return rated(point, parts, tolerance) | {"numerical_error": parts[1]}


def rated(point: dict, parts: tuple[float, float], tolerance: float) -> dict:
    """Return a point with the key ``finer``, True if a more accurate stator is needed; without an answer its status."""
    if "relative_error" not in point:
        return {"status": Status.NO_ANSWER.because(point["status"])}
    return point | {"finer": point["relative_error"] > tolerance and parts[0] > SHARE * tolerance}


def averaged_answers(states: list[tuple[Contact, float]], tolerance: float) -> list[dict | None]:
    """Return the averaged steady state of each contact as in `steady_answers`, or None if its error is too large."""
    answers: list[dict | None] = [None] * len(states)
    sliders = [driven.scene.slider for driven, _ in states]
    allowed = [k for k, each in enumerate(sliders) if each.method in AVERAGED_METHODS and each.pillars is None]
    some = (states[k] for k in allowed)
    contacts = [(driven.slider, driven.orbits, driven.stator_error, level) for driven, level in some]
    for k, (velocity, regime, of_contact, of_stator, thrust) in zip(allowed, averaged(contacts), strict=True):
        if regime != "unknown" and of_contact <= SHARE * tolerance and abs(velocity) < RUNAWAY:
            state = {"velocity_m_per_s": velocity, "regime": regime, "thrust_N": thrust}
            state |= judged(tolerance, of_stator, of_contact)
            answers[k] = rated(state, (of_stator, of_contact), tolerance)
    return answers


def averaged(contacts: list[tuple]) -> list[tuple]:
    """Return averaged steady states, each of (slider, orbits, wave error, factor on the orbits).

    An answer is a tuple of velocity, regime, error, error by the wave, and blocked thrust.  Contacts with the same
    number of orbits are computed in one compiled loop (`contact.steady_sweep`).  The regime is "unknown" where
    averaging does not apply.  The loop takes the threads that SAWMOTOR_THREADS allows, by default all processors.
    """
    setting = os.environ.get("SAWMOTOR_THREADS", "")
    threads = int(setting) if setting.isdecimal() and int(setting) else None
    answers: list[tuple] = [()] * len(contacts)
    for count in {len(orbits) for _, orbits, _, _ in contacts}:
        members = [at for at, each in enumerate(contacts) if len(each[1]) == count]
        sliders: dict = {}  # each different one with its number
        waves: dict = {}
        which, factors = [], []
        for slider, orbits, error, factor in (contacts[at] for at in members):
            wave = waves.setdefault((orbits, error), len(waves))
            which.append((sliders.setdefault(slider, len(sliders)), wave))
            factors.append(factor)
        orbits, errors = zip(*waves, strict=True)
        options = {"which": which, "factors": factors, "wave_errors": errors, "threads": threads}
        states = contact.steady_sweep(list(sliders), orbits, **options)
        names = ("velocity", "regime", "relative_error", "error_from_wave", "blocked_thrust")
        columns = (getattr(states, name).tolist() for name in names)
        for at, *values in zip(members, *columns, strict=True):
            answers[at] = tuple(values)
    return answers
