"""Method "exact" of a burst: event by event, from one event to the next.

A burst of some length is computed once and checked over parts of it. Others are computed at two levels of resolution,
whose difference is the error. On a track the orbits are constant for one cycle.
"""

import math

import numpy as np

from contact.answers.burst_question import Burst, compared_velocities
from contact.answers.refined_run import difference_along, refined
from contact.answers.rest_motion import rest
from contact.body import Paths
from contact.choice import Result
from contact.codes import At, Recorded
from contact.error_estimate import event_driven_error, held_orbits_error
from contact.events.collocation import collocation
from contact.exceptions import ConvergenceError
from contact.problem import largest_resonance, with_longer_segments
from contact.stepping.along_track import Followed

# Choice of the method. EXACT_CYCLES: method "auto" uses the event-driven method up to this number of cycles, whatever
# the tolerance. MAX_EXACT_CYCLES: if another method misses the tolerance, the exact method takes over up to this number
# (about 10 s).
EXACT_CYCLES = 3000
MAX_EXACT_CYCLES = 100_000

# Exact method. It refuses bursts of more segments than this (some minutes, at 2 to 4 us for one to three contacts).
MAX_SEGMENTS = 1e8
# Nodes per segment, truncation error of a segment, maximum segment length over that of the problem, and the smallest
# tolerance for which this level is fine enough. Neighbouring levels differ in all three, so that their difference shows
# the error: the truncation has no effect if events limit the segments, and the number of nodes has none if the forces
# are polynomials (a punch).
ORDERS = ((8, 1e-5, 0.8, math.inf), (10, 1e-7, 1.0, 1e-8), (12, 1e-9, 0.8, 1e-10), (16, 1e-12, 1.0, 0.0))

# A burst of at least SPOT_CYCLES cycles is computed once at the level ANSWER and again at the level CHECK, which
# differs in all three, over PARTS of it (start and end over its length), the later ones from states of the answer.
# Tolerances below SPOT_TOLERANCE take two whole runs. The wave's limit of a segment is then LONG times the usual one.
# SPOT_FACTOR: stated error over that of the parts, which see neither all cycles nor how a motion of little damping
# enlarges an error. In 314 draws the true error was up to 1.7 times that without the factor
# (`tests/benchmarks/spot_checks.py`). A coarser level, (8, 1e-4, 1.0), would take 0.8 of the time, but its energy
# balance has a residual of up to 7e-6 (seed's slider, mu of 0.3, 0.75 nm, which sticks); this one has 1e-8.
ANSWER, CHECK = (10, 1e-6, 1.0), (12, 1e-7, 0.8)
LONG = 2.0
SPOT_CYCLES, SPOT_TOLERANCE, SPOT_FACTOR = 64, 1e-8, 3.0
PARTS = (0.0, 1 / 10), (1 / 2, 21 / 40), (39 / 40, 1.0)
# Change of the motion in a segment that the answer may leave out, over the tolerance, and its largest value, with which
# the energy balance keeps 1e-10 (with 1e-11 it misses by up to 5e-10, and bursts at 1e-3 take 0 to 8 % less time); the
# parts are computed to rounding and see it. With a tenth of this share a cycle at 1e-8 takes 4 to 9 % longer, with ten
# times as much none shorter (the ball of the seed at 1 to 20 nm).
LEFT_OUT, MOST_LEFT_OUT, ROUNDING = 1e-5, 1e-13, 1e-15


def exact_burst(burst):
    """Run the event-driven method at two levels of `ORDERS`, and at finer ones until the tolerance is met."""
    if burst.track is not None:
        return _exact_along(burst)
    spotted = spot_checked(burst)
    if spotted is not None:
        return spotted

    def follow(level):
        return every_event(burst, *ORDERS[level][:3])

    def error(level, run, difference, reference):
        return event_driven_error(
            difference, truncation=ORDERS[level][1], reference=reference, cycles=burst.cycles,
            segments=burst.problem.segments, moves=np.any(run[0]),
        )  # fmt: skip

    for least in range(1, len(ORDERS)):
        try:
            _, (_, motion, record), result = refined(burst, follow, error, ORDERS, least)
            break
        except ConvergenceError:  # with few nodes the solver may report events without end: try the next level
            if least == len(ORDERS) - 1:
                raise
    every = burst.compared_per_returned_sample
    return result._replace(run=(motion, record[every - 1 :: every]), statistics=motion.events())


def exact_refusals(burst):
    """Return the reasons why the method does not apply; empty if it does."""
    reasons = ("it takes no envelope",) if burst.envelope is not None else ()
    if burst.cycles * burst.problem.segments > MAX_SEGMENTS:
        reasons += (
            f"{burst.cycles} cycles of at least {burst.problem.segments:.3g} segments of the motion are too many "
            "(shorten the burst, raise the mass or lower the dampers)",
        )
    return reasons


def spot_checked(burst: Burst) -> Result | None:
    """Return the result of one event-driven run that is checked over a part of its cycles (`PARTS`).

    None if it misses the tolerance, or if the burst is not one for it.
    """
    remembers = burst.slider.law == "hysteretic"  # its memory is laid out for the nodes of one level
    if burst.cycles < SPOT_CYCLES or burst.tolerance < SPOT_TOLERANCE or remembers:
        return None
    long = burst._replace(problem=with_longer_segments(burst.problem, LONG))
    try:
        result = _checked_in_parts(long)
    except ConvergenceError:
        return None
    if result is not None:
        result.run[0].problem = burst.problem
    return result


def _checked_in_parts(burst):
    """Return the result of a run at `ANSWER`, checked at `CHECK` over `PARTS`; None if it misses the tolerance.

    The errors of single cycles are added. The run ends with the first part that shows that it will miss.
    """
    motion, record, errors, done = _at_rest(burst, ANSWER), [], [], 0
    motion.close = min(LEFT_OUT * burst.tolerance, MOST_LEFT_OUT)
    parts = [[round(share * burst.cycles) for share in part] for part in PARTS]
    growth = SPOT_FACTOR * burst.cycles / sum(stop - start for start, stop in parts)
    fastest = burst.orbits.peak_speed / burst.problem.speed

    def turned(stop):
        if stop > done:  # one sample a cycle, so that samples do not change the motion
            record.append(motion.turn(stop - done, stride=1, warm=done > 0))
        return stop

    for start, stop in parts:
        done = turned(start)
        other = _continued(burst, motion, CHECK) if start > 0 else _at_rest(burst, CHECK)
        other.close = ROUNDING
        done = turned(stop)
        if stop > start:
            errors.append(_apart(burst, other, motion, stop - start))
        if growth * sum(errors) > burst.allowed(max(fastest, abs(float(motion.state[At.VELOCITY])))):
            return None
    every, velocity = np.concatenate(record), float(motion.state[At.VELOCITY])
    error = event_driven_error(
        growth * sum(errors), truncation=ANSWER[1], reference=burst.reference(velocity), cycles=burst.cycles,
        segments=burst.problem.segments, moves=bool(np.any(every[:, Recorded.VELOCITY])),
    )  # fmt: skip
    if error > burst.allowed(velocity):
        return None
    return Result((motion, every[burst.stride - 1 :: burst.stride]), error, burst.allowed(velocity), motion.events())


def _apart(burst, motion, other, cycles):
    """Return the distance of a motion after some cycles from another, in velocity, scaled.

    Errors of height and deformations become some of the velocity within a period of the contact's resonance.
    """
    motion.turn(cycles)
    rate, change = largest_resonance(burst.problem), np.abs(motion.state - other.state)
    normal = change[At.NORMAL_VELOCITY] + rate * change[At.POSITION]
    along = change[At.VELOCITY] + rate * np.max(change[At.DEFORMATIONS :])
    return float(along + burst.problem.friction * normal)


def _at_rest(burst, level):
    """Return the motion at phase 0 of a slider at rest, for a run at a level such as those of `ORDERS`."""
    nodes, truncation, longest = level
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    motion = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    motion.begin()
    return motion


def _continued(burst, motion, level):
    """Return a motion that continues from a state at another level."""
    nodes, truncation, longest = level
    other = motion.copy()
    other.grid, other.truncation = collocation(nodes), truncation
    other.problem = burst.problem._replace(longest=longest * burst.problem.longest)
    return other


def every_event(burst, *level):
    """Return (velocities to compare, motion, record) of one event-driven run."""
    motion = _at_rest(burst, level)
    record = motion.turn(burst.cycles, stride=burst.cycles_per_compared_sample)
    motion.problem = burst.problem
    return compared_velocities(record, motion.state), motion, record


def _exact_along(burst):
    """Run the event-driven method on a track, the orbits constant for one cycle, and for two in a coarser run."""
    coarse, fine = (_events_along(burst, ORDERS[level], hold) for level, hold in ((1, 2), (2, 1)))
    velocity = float(fine[0][-1])
    error = event_driven_error(
        difference_along(coarse[0], fine[0]), truncation=ORDERS[2][1], reference=burst.reference(velocity),
        cycles=burst.cycles, segments=burst.problem.segments, moves=np.any(fine[0]),
    )  # fmt: skip
    _, motion, record, followed, turned = fine
    error += held_orbits_error(turned, burst.reference(velocity))
    every = burst.compared_per_returned_sample
    followed = followed._replace(displacement=followed.displacement[every - 1 :: every])
    return Result((motion, record[every - 1 :: every], followed), error, burst.allowed(velocity), {})


def _events_along(burst, order, hold):
    """Return (velocities to compare, motion, record, `Followed`, change) of one event-driven run along a track.

    The orbits are those of the middle of each `hold` cycles. Where they change, a closed contact goes with its surface.
    `change`: largest of an amplitude from one to the next, over the largest amplitude.
    """
    nodes, truncation, longest, _ = order
    problem = burst.problem._replace(longest=longest * burst.problem.longest)
    motion = rest(burst.slider, burst.orbits, problem, nodes=nodes, truncation=truncation)
    stride, (low, high) = burst.cycles_per_compared_sample, burst.track.limits
    record, passed, place, advance, cycle, turned = [], [], 0.0, 0.0, 0, 0.0
    while cycle < burst.cycles:
        many = min(hold, burst.cycles - cycle)
        if not low < place + many * advance < high:
            break
        u_x, u_z = burst.track.at(place + 0.5 * many * advance)
        paths = Paths(problem.paths.height, u_z.real.copy(), -u_z.imag, u_x.real.copy(), -u_x.imag)
        old = motion.problem.paths
        gone = paths.tangential_cos - old.tangential_cos
        changes = [np.abs(new - before) for new, before in zip(paths[1:], old[1:], strict=True)]
        turned = max(turned, float(np.max(changes)) / max(np.max(np.abs(u_x)), np.max(np.abs(u_z)), 1e-300))
        state = motion.state.copy()
        motion.set_state(
            *state[: At.DEFORMATIONS], state[At.DEFORMATIONS :] + gone, problem=problem._replace(paths=paths)
        )
        for row in motion.turn(many, stride=1):
            cycle, advance = cycle + 1, 2.0 * math.pi * row[Recorded.MEAN_VELOCITY]
            place += advance
            if cycle % stride == 0:
                record.append(row)
                passed.append(place)
    record = np.array(record).reshape(-1, len(Recorded))
    followed = Followed(record, np.array(passed), cycle, place, cycle < burst.cycles)
    motion.problem = burst.problem
    return np.append(record[:, Recorded.VELOCITY], motion.state[At.VELOCITY]), motion, record, followed, turned
