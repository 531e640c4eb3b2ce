r"""The slider during a burst of the wave and after it: v(t) from rest.

The burst starts at rest, at the instant at which u_z of the first contact passes zero upwards; it lasts a whole number
of cycles; then the surface stands still. The surface's velocity is what drives the contact, so the tangential
displacement may start anywhere on its orbit. Other contacts on other phases of the wave are moved to their place at
once. During the burst the motion is followed event by event ("exact"), in fixed steps ("stepped") or by cycle means
("averaged"); "auto" takes the cheapest whose error estimate keeps the tolerance. After the burst it is always followed
event by event, with stretches as long as the contact's resonance allows.

With an envelope the wave swells and fades as it says; what is left of it at the end of the burst stops there, or
fades as a ring-down says, followed in fixed steps.
"""

import time as clock
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.answers.ledger import Ledger, ledger, together
from contact.answers.methods import METHODS, Burst, rest_problem, ring_down, run, silence
from contact.choice import Answer, Answered
from contact.drive import reference_speed, towards_plus
from contact.envelope import Envelope
from contact.events.segment import At, Column
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider


@dataclass(frozen=True, kw_only=True)
class Trajectory(Answered):
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
        Slider's normal position z_s, m: minus the rest approach at the start; cycle means when averaged.
    duration : float
        Length of the burst in whole cycles, s.
    cycles : int
        The same in cycles.
    rang : float
        How long the surface was followed as it rang down after the burst, s; 0 without a ring-down.
    answer : Answer
        The velocity at the burst's end, m/s, its error, status and reasons.
    method : str
        "exact", "stepped" or "averaged".
    ledger : Ledger or None
        Energies of burst and slide after it; None where the burst was not followed event by event, or rang down.
    after_ledger : Ledger or None
        Of the slide alone, on a surface at rest, which is always followed so; None without one.
    statistics : dict
        Events by kind (those after the burst, and those during it when exact), smallest gap between two in s (inf:
        fewer), chatter; steps per cycle and omega_n dt when stepped; order and steps when averaged.
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
    rang: float
    answer: Answer
    method: str
    ledger: Ledger | None
    after_ledger: Ledger | None
    statistics: dict
    seconds: float

    @property
    def velocity_at_burst_end(self) -> float:
        """Slider velocity at the end of the burst, m/s."""
        return self.answer.value


def burst(
    slider: Slider,
    orbits: Orbit | tuple[Orbit, ...],
    *,
    duration: float,
    after: float | tuple[float, Envelope],
    tolerance: float,
    samples: int,
    method: str = "auto",
    envelope: Envelope | None = None,
) -> Trajectory:
    """Return the motion over a burst from rest and for a while after it.

    Parameters
    ----------
    slider, orbits
        As for `steady`, the orbits while the burst lasts.
    duration : float
        s; rounded to whole cycles of the wave, at least one.
    after : float or (float, Envelope)
        s to follow after the burst, on a surface that stands still; or with the factor on the orbits while the surface
        rings down, time from the end of the burst.
    tolerance : float
        Error allowed in the velocity at the end of the burst, relative to max(|v|, omega |u_x|/10).
    samples : int
        About how many instants to report, over burst and after in proportion to their lengths.
    method : str
        "exact", "stepped", "averaged" or "auto".
    envelope : Envelope, optional
        Factor on the orbits during the burst; only the stepped way takes one.

    Returns
    -------
    Trajectory

    Raises
    ------
    ConvergenceError
        Status "not applicable" if a way asked for by name does not apply, or what the motion ran into.
    """
    begun = clock.perf_counter()
    listed = as_orbits(orbits)
    after, fading = after if isinstance(after, tuple) else (after, None)
    bounds.positive("duration", duration, "s")
    bounds.non_negative("after", after, "s")
    bounds.positive("tolerance", tolerance, "")
    bounds.count("samples", samples, 2)
    bounds.choice("method", method, METHODS)
    frequency = listed[0].frequency
    cycles = max(1, round(duration * frequency))
    share = cycles / frequency / (cycles / frequency + after)
    stride = max(1, round(cycles / max(1.0, samples * share)))
    side, driven = towards_plus(listed)
    problem = rest_problem(slider, driven)
    shape = envelope.at(np.arange(cycles + 1) / frequency) if envelope is not None else np.empty(0, complex)
    asked = Burst(slider, driven, problem, cycles, stride, tolerance, shape)
    result, method, reasons = run(method, asked)
    (motion, rows), statistics = result.run, result.statistics
    end = side * float(motion.state[At.VELOCITY]) * problem.speed
    ends = stride * np.arange(1, len(rows) + 1)
    start = np.full(1, -slider.rest_approach(len(listed)) / problem.length)
    parts = [
        (np.zeros(1), np.zeros(1), start),
        (ends / frequency, rows[:, Column.VELOCITY], rows[:, Column.POSITION]),
    ]
    if cycles % stride:
        parts.append(
            (np.full(1, cycles / frequency), motion.state[[At.VELOCITY]], motion.state[[At.POSITION]])
        )
    books = [ledger(slider, motion)] if motion.begun is not None else []
    slid, rang, still = _follow_on(slider, motion, after, fading, samples * (1.0 - share))
    parts += [(cycles / frequency + part[0], *part[1:]) for part in slid]
    after_book = None
    if still is not None:
        after_book = ledger(slider, still)
        statistics |= {f"after_{name}": number for name, number in still.events().items()}
        books += [after_book] if books else []
    time, velocity, position = (np.concatenate(series) for series in zip(*parts, strict=True))
    answer = Answer(
        value=end, error=result.error * problem.speed, reasons=(f"{cycles} cycles from rest", *reasons)
    ).judged(tolerance, reference_speed(end, listed), "" if method == "exact" else "ask for method exact")
    return Trajectory(
        slider=slider, orbits=listed, time=time, velocity=side * velocity * problem.speed,
        position=position * problem.length,
        duration=cycles / frequency, cycles=cycles, rang=rang, answer=answer, method=method,
        ledger=together(*books) if books and not rang else None, after_ledger=after_book, statistics=statistics,
        seconds=clock.perf_counter() - begun,
    )  # fmt: skip


def _follow_on(slider, motion, after, envelope, samples):
    """Follow the slider for some seconds after the burst, while the surface rings down and then on a surface at rest.

    Returns parts (times in s from the end of the burst, v, z_s), how long the surface rang, and the motion at the end,
    None if the surface was not at rest by then.
    """
    parts, rang, problem = [], 0.0, motion.problem
    if envelope is not None:
        count = max(2, round(samples / 2.0))
        times, rows = ring_down(slider, motion, envelope, longest=after, samples=count)
        if times.size:
            rang = float(times[-1])
            parts.append((times, rows[:, Column.VELOCITY], rows[:, Column.POSITION]))
    if after <= rang:
        return parts, rang, None
    still, span, count = silence(motion), after - rang, max(2, round(samples))
    at = np.arange(1, count + 1) * (span / count)
    z, *_, velocity = still.move(0.0, problem.omega * span * (1.0 + 1e-12), at * problem.omega)[:, 0].T
    # the surface stands still at zero: the first contact's approach is its height less the slider's position
    parts.append((rang + at, velocity, problem.paths.height[0] - z))
    return parts, rang, still
