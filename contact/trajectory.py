r"""The slider during a burst of the wave and after it: v(t) from rest.

The burst starts at rest, at the instant at which u_z of the first contact passes zero upwards; it lasts a whole number
of cycles; then the surface stands still. The surface's velocity is what drives the contact, so the tangential
displacement may start anywhere on its orbit. Other contacts on other phases of the wave are moved to their place at
once. During the burst the motion is followed event by event ("exact") or in fixed steps ("stepped"); after it always
event by event, with stretches as long as the contact's resonance allows.
"""

import math
import time as clock
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.convergence import ConvergenceError
from contact.drive import available, reference_speed, relative_to_reference, towards_plus
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

METHODS = ("auto", "exact", "stepped")
# up to here "auto" follows every event, whatever the tolerance
EXACT_CYCLES = 3000


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """Motion of the slider over a burst and after it.

    Attributes
    ----------
    slider, orbits
        What was asked.
    time : (k,) array
        s from the start of the burst; the first is 0. During the burst at ends of whole cycles.
    velocity : (k,) array
        Slider velocity, m/s.
    position : (k,) array
        Slider's normal position z_s, m: minus the rest approach at the start.
    duration : float
        Length of the burst in whole cycles, s.
    cycles : int
        The same in cycles.
    velocity_at_burst_end : float
        m/s.
    relative_error : float
        Estimated error of `velocity_at_burst_end` over max(|v|, omega |u_x|/10), from a second computation.
    status, message, method : str
        "ok" or what is to be known; a sentence; "exact" or "stepped".
    statistics : dict
        Events by kind (those after the burst, and those during it when exact), steps per cycle when stepped.
    seconds : float
        Time taken.
    """

    slider: Slider
    orbits: tuple[Orbit, ...]
    time: np.ndarray
    velocity: np.ndarray
    position: np.ndarray
    duration: float
    cycles: int
    velocity_at_burst_end: float
    relative_error: float
    status: str
    message: str
    method: str
    statistics: dict
    seconds: float


def burst(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    duration: float,
    after: float,
    tolerance: float,
    samples: int,
    method: str = "auto",
) -> Trajectory:
    """Return the motion over a burst from rest and for a while after it.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact while the burst lasts.
    duration, after : float
        s; the burst is rounded to whole cycles of the wave, at least one.
    tolerance : float
        Error allowed in the velocity at the end of the burst, relative to max(|v|, omega |u_x|/10).
    samples : int
        About how many instants to report, over burst and after in proportion to their lengths.
    method : str
        "exact", "stepped" or "auto".

    Returns
    -------
    Trajectory
    """
    begun = clock.perf_counter()
    listed = as_orbits(orbits)
    bounds.positive("duration", duration, "s")
    bounds.non_negative("after", after, "s")
    bounds.positive("tolerance", tolerance, "")
    bounds.count("samples", samples, 2)
    bounds.choice("method", method, METHODS)
    available(slider)
    frequency = listed[0].frequency
    cycles = max(1, round(duration * frequency))
    share = cycles / frequency / (cycles / frequency + after)
    stride = max(1, round(cycles / max(1.0, samples * share)))
    side, driven = towards_plus(listed)
    problem = rest_problem(slider, driven)
    if method == "auto":
        method = "exact" if cycles <= EXACT_CYCLES or _why_not_stepped(slider, problem, 64) else "stepped"
    run = _exact if method == "exact" else _stepped
    motion, rows, error, statistics = run(slider, driven, problem, cycles, stride, tolerance)
    speed_at_end = float(motion.state[2])
    length = problem.length
    time = [np.zeros(1), np.arange(1, len(rows) + 1) * stride / frequency, np.full(1, cycles / frequency)]
    velocity = [np.zeros(1), rows[:, 0], motion.state[2:3].copy()]
    position = [np.array([-slider.rest_approach(len(listed)) / length]), rows[:, 1], motion.state[:1].copy()]
    if cycles % stride == 0:
        for series in (time, velocity, position):
            series.pop()
    if after > 0.0:
        count = max(2, round(samples * (1.0 - share)))
        at = np.arange(1, count + 1) * (after / count)
        still = silence(motion)
        recorded = still.move(0.0, problem.omega * after * (1.0 + 1e-12), at * problem.omega)
        time.append(cycles / frequency + at)
        velocity.append(recorded[:, 0, 5])
        # the surface stands still at zero: the first contact's approach is minus the slider's position
        position.append(-recorded[:, 0, 0])
        for name, number in still.events().items():
            statistics[f"after_{name}"] = number
    end = side * speed_at_end * problem.speed
    relative = relative_to_reference(error * problem.speed, end, listed)
    status, message = "ok", f"{cycles} cycles from rest"
    if relative > tolerance:
        status = "above tolerance"
        message += f"; estimated error {relative:.2g} exceeds {tolerance:.2g}; ask for method exact"
    return Trajectory(
        slider=slider, orbits=listed, time=np.concatenate(time),
        velocity=side * np.concatenate(velocity) * problem.speed, position=np.concatenate(position) * length,
        duration=cycles / frequency, cycles=cycles, velocity_at_burst_end=end, relative_error=float(relative),
        status=status, message=message, method=method, statistics=statistics, seconds=clock.perf_counter() - begun,
    )  # fmt: skip


def rest_problem(slider, orbits):
    """Return the scaled problem whose phase 0 is where u_z of the first contact passes zero upwards."""
    from contact.scaling import scaled

    return scaled(slider, orbits, direction=1.0, start=-0.5 * math.pi - float(np.angle(orbits[0].normal)))


def rest(slider, orbits, problem, *, nodes, truncation):
    """Return the motion at phase 0 of a slider at rest, its contacts deformed by the load alone."""
    from contact.collocation import collocation
    from contact.motion import Motion

    contacts = len(orbits)
    motion = Motion(problem, table=collocation(nodes), truncation=truncation)
    depth = slider.rest_approach(contacts) / problem.length
    friction = slider.friction_coefficient * slider.preload
    used = min(slider.load / friction, 1.0) if friction > 0.0 else 0.0
    x = slider.limit_slope * depth * (1.0 - (1.0 - used) ** (2.0 / 3.0))
    motion.place(-depth, 0.0, 0.0, x)
    return motion


def silence(motion):
    """Return the motion that goes on where this one stands, at phase 0, when the wave stops."""
    from contact.scaling import quiet

    still = motion.copy()
    still.problem = quiet(motion.problem)
    still.tally[:], still.sums[:] = 0, 0.0
    still.place(*motion.state[:3], motion.state[3:])
    return still


def _exact(slider, orbits, problem, cycles, stride, tolerance):
    fine = rest(slider, orbits, problem, nodes=16, truncation=1e-12)
    rows = fine.turn(cycles, stride=stride)
    coarse = rest(slider, orbits, problem, nodes=10, truncation=max(1e-9, min(1e-6, 1e-3 * tolerance)))
    coarse.turn(cycles)
    return fine, rows, abs(float(fine.state[2] - coarse.state[2])), fine.events()


def _stepped(slider, orbits, problem, cycles, stride, tolerance):
    """Double the steps until two runs agree; the error of the finer is the fall of a method of order 2.5 or less."""
    from contact.stepped import steps

    refusal = _why_not_stepped(slider, problem, 64)
    if refusal:
        raise ConvergenceError(
            "not applicable", f"the stepped way does not apply: {refusal}; use method exact"
        )
    motion = rest(slider, orbits, problem, nodes=16, truncation=1e-12)
    begin, before, per_cycle = motion.state.copy(), None, 32
    while True:
        state, rows = begin.copy(), np.empty((cycles // stride, 3))
        if not steps(problem.parameters, problem.waves, state, cycles, per_cycle, stride, rows):
            raise ConvergenceError("not finite", "the stepped motion overflowed; use method exact")
        error = math.inf if before is None else 0.5 * abs(float(state[2] - before))
        reference = reference_speed(float(state[2]) * problem.speed, orbits) / problem.speed
        if error < tolerance * reference or (per_cycle >= 256 and before is not None) or reference == 0.0:
            break
        before, per_cycle = float(state[2]), per_cycle * 2
    motion.state[:] = state
    return motion, rows, error, {"steps_per_cycle": per_cycle, "cycles": cycles}


def _why_not_stepped(slider, problem, per_cycle):
    """Return why fixed steps cannot follow this motion, or an empty string."""
    if slider.stick_band > 0.0:
        return "slider.stick_band needs the events"
    if slider.limit_slope == 0.0:
        return "no friction"
    kappa, d_n, d_t = problem.parameters[0], problem.parameters[2], problem.parameters[4]
    step = 2.0 * math.pi / per_cycle
    if (
        step * math.sqrt(1.5 * kappa * len(problem.waves) * math.sqrt(2.0)) > 0.2
        or step * max(d_n, d_t) > 0.2
    ):
        return "contact resonance or dampers are too fast for 64 steps per cycle"
    return ""
