"""Averaged steady states of many contacts at once, microseconds each."""

import os
from typing import NamedTuple

import contact


class AveragedState(NamedTuple):
    """Averaged steady state of one contact."""

    velocity: float  # m/s
    regime: str  # "unknown" where averaging does not apply
    from_contact: float  # error over the reference speed
    from_stator: float  # the same, by the error of the wave
    thrust: float  # blocked thrust, N


def averaged_states(contacts: list[tuple]) -> list[AveragedState]:
    """Return averaged steady states, each of (slider, orbits, wave error, factor on the orbits).

    Contacts with the same number of orbits are computed in one compiled loop (`contact.steady_sweep`).  The loop takes
    the threads that SAWMOTOR_THREADS allows, by default all processors.
    """
    setting = os.environ.get("SAWMOTOR_THREADS", "")
    threads = int(setting) if setting.isdecimal() and int(setting) else None
    answers: list = [None] * len(contacts)
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
            answers[at] = AveragedState(*values)
    return answers
