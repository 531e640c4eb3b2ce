"""How accurately the stator is solved, and when it is solved again: one rule for runs, sweeps, fits and designs.

The stator is first solved to a quarter of the velocity's tolerance.  The contact amplifies the error of the stator,
near the threshold by a factor of 20.  If the velocity then misses its tolerance, the stator is solved again to the
accuracy that the velocity needs (`finer`), in `ROUNDS` rounds at most.
"""

import math
from collections.abc import Callable, Sequence
from typing import TypeVar

from studies.model.wave_to_contact import Contact
from studies.solve.point_answer import PointAnswer, SliderAnswer

Motor = TypeVar("Motor")

SHARE = 0.25  # fraction of the tolerance for the contact and, in the first round, for the stator
# The same for a stator that is solved in a band of frequencies: a band that is one level finer costs half as much
# again, a second band costs twice as much
BAND_SHARE = 0.1
ROUNDS = 3  # largest number of solutions of the stator; each round determines the goal of the next
# If the error of the motion is more than this fraction of that in the round before, no further round is tried, because
# the remaining error is that of the beam, which a finer section does not reduce.
STALLED = 0.7
# Goals after the first are fractions SHARE / STEP**k of the tolerance, so that points of a sweep share finer stators
STEP = 2.0


def refined(
    solve: Callable[[list[Motor], list[float | None]], list[SliderAnswer]], motors: Sequence[Motor], tolerance: float,
    rounds: int = ROUNDS,
) -> list[SliderAnswer]:  # fmt: skip
    """Return the answers of some motors, each solved again on a finer stator as long as `finer` gives a goal.

    Parameters
    ----------
    solve : callable
        Returns the answers of some motors for the goals of their sections, None for those of the first round.
    motors : sequence
        As ``solve`` takes them.
    tolerance : float
        Of the velocities, over their reference speed.
    rounds : int
        Largest number of solutions of a stator.
    """
    found: dict[int, SliderAnswer] = {}
    goals: dict[int, float | None] = dict.fromkeys(range(len(motors)))
    for _ in range(rounds):
        again, answers = {}, solve([motors[k] for k in goals], list(goals.values()))
        for k, latest in zip(goals, answers, strict=True):
            before = found.get(k)
            if before is None or latest.answered:  # without an answer on the finer stator, the previous one is kept
                found[k] = latest
            if latest.driven is not None:
                again[k] = finer(latest.answers, latest.driven, tolerance, before.driven if before else None)
        goals = {k: goal for k, goal in again.items() if goal is not None}
        if not goals:
            break
    return [found[k] for k in range(len(motors))]


def finer(
    answers: Sequence[PointAnswer], driven: Contact, tolerance: float, before: Contact | None = None
) -> float | None:
    """Return the goal of the section that the velocities need; None if the section suffices or a finer one cannot help.

    Parameters
    ----------
    answers : sequence of PointAnswer
        On the contact, at one or more levels.
    driven : Contact
        With its stator's solution and the ring-up of its burst.
    tolerance : float
        Of the velocity, over its reference speed.
    before : Contact, optional
        On the stator of the round before.

    Notes
    -----
    Let s be the largest stator part of the points that miss the tolerance t, r the ring-up's contribution and b that of
    the beam, a share of s - r.  The section contributes s - r - b, in proportion to its error.  It may contribute
    (t - b) / 2 - r, because half of t - b is reserved for the contact.
    """
    missed = [each.from_stator for each in answers if each.from_stator + each.from_contact > tolerance]
    ringing = 0.0 if driven.ringing is None else driven.ringing.error
    if driven.solved is None or not missed or max(missed) <= ringing:
        return None
    section, whole = driven.solved.section_error, driven.stator_error
    if not math.isfinite(section):  # of the coarsest discretisation, which has no estimate
        return None
    if before is not None and (section >= before.solved.section_error or whole > STALLED * before.stator_error):
        return None
    beam_share = 1.0 - section / whole
    beam = beam_share * (max(missed) - ringing)
    allowed = 0.5 * (tolerance - beam) - ringing
    if allowed <= 0.0:  # the beam alone, or the ring-up, takes the tolerance
        return None
    needed = section * allowed / (max(missed) - ringing - beam)
    if needed >= section:
        return None
    first = SHARE * tolerance
    return first / STEP ** math.ceil(math.log(first / needed, STEP))
