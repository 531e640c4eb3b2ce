r"""Motion of the slider from rest during a burst of the wave and after it.

The slider starts from rest at a time at which u_z of the first contact crosses zero upwards. The burst lasts a whole
number of cycles, and the surface is at rest after it. The contact forces depend on the tangential velocity of the
surface, so that its tangential displacement may have any initial value. At the start, the surface under the other
contacts is displaced at once according to the phase of the wave there.

Three methods compute the motion during the burst: event-driven ("exact"), fixed time steps ("stepped") and cycle means
("averaged"). Method "auto" takes the cheapest one whose estimated error is within the tolerance. The motion after the
burst is always event-driven, with segments as long as the contact resonance allows.

An envelope describes the wave's amplitude and phase during the burst. At the end of the burst the wave stops, or it
decays according to a second envelope (ring-down), which is followed with fixed time steps.

On a `Track` the orbits are those of the place to which the slider has come, with the turn of their phase from place to
place, by which a moving slider meets another frequency (Doppler). The motion stops where the track ends.
"""

import time as clock
from dataclasses import dataclass, replace

import numpy as np

from contact import parameter_check
from contact.answers.after_burst import Afterwards, Series, follow_after
from contact.answers.burst_methods import METHODS, run
from contact.answers.burst_question import Burst
from contact.answers.ledger import Ledger, ledger, together
from contact.answers.quasi_static import quasi_static
from contact.answers.rest_motion import rest_problem
from contact.choice import Answer, Answered, refused
from contact.codes import At, Recorded
from contact.envelope import Envelope
from contact.error_estimate import reference_speed
from contact.orbit import Orbits, towards_plus
from contact.passing_wave import PassingWave, Surface, coupling, prescribed, refuse_infinite_mass
from contact.slider import Slider
from contact.stepping.along_track import Scaled
from contact.track import Track

QUASI_STATIC = "quasi-static"


@dataclass(frozen=True, kw_only=True)
class Trajectory(Answered):
    """Motion of the slider over a burst and after it.

    Attributes
    ----------
    slider, orbits
        The arguments of `burst`.
    time : (k,) array
        Time from the start of the burst, s; the first entry is 0. Times during the burst are ends of whole cycles.
    velocity : (k,) array
        Slider velocity, m/s.
    position : (k,) array
        Normal position z_s of the slider, m. It starts at minus the rest approach; the averaged method gives cycle
        means.
    duration : float
        Length of the burst in whole cycles, s.
    cycles : int
        Length of the burst in cycles.
    rang : float
        Duration of the ring-down of the surface after the burst, s; 0 without a ring-down.
    answer : Answer
        Velocity at the end of the burst, m/s, with its error, status and reasons.
    method : str
        "exact", "stepped", "averaged" or "quasi-static".
    ledger : Ledger or None
        Energies of the burst and of the motion after it; None if the method was not "exact" or the surface rang down.
    after_ledger : Ledger or None
        Energies of the motion on the surface at rest after the burst; None if there is no such motion.
    statistics : dict
        Number of events of each kind after the burst and, by the exact method, during it; smallest time between two
        events in s (inf for fewer than two); chatter. The stepped method adds steps per cycle and omega_n dt, the
        averaged one its order.
    seconds : float
        Computing time.
    displacement : (k,) array or None
        On a track, displacement of the slider along +x, m; None without one.
    ended : bool
        True if the slider came to an end of the track, where the trajectory stops. If this was during the burst,
        `duration`, `cycles` and `answer` are those of that instant.
    """

    slider: Slider
    orbits: Orbits | PassingWave
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
    displacement: np.ndarray | None = None
    ended: bool = False

    @property
    def velocity_at_burst_end(self) -> float:
        """Slider velocity at the end of the burst, m/s."""
        return self.answer.value


def burst(
    slider: Slider,
    orbits: Surface,
    *,
    duration: float,
    after: float | tuple[float, Envelope],
    tolerance: float,
    samples: int,
    method: str = "auto",
    envelope: Envelope | None = None,
    track: Track | None = None,
) -> Trajectory:
    """Return the motion from rest during a burst and for some time after it.

    Parameters
    ----------
    slider, orbits
        As for `steady`; the orbits are those during the burst.
    duration : float
        Length of the burst in s, rounded to whole cycles of the wave, at least one.
    after : float or (float, Envelope)
        Time in s to follow the slider after the burst. The envelope is the factor on the orbits during the ring-down of
        the surface, with the time from the end of the burst. Without it the surface is at rest after the burst.
    tolerance : float
        Allowed error of the velocity at the end of the burst, relative to max(|v|, omega |u_x|/10).
    samples : int
        Approximate number of times in the result, distributed over the burst and the time after it by their lengths.
    method : str
        "exact", "stepped", "averaged", "quasi-static" or "auto". The last but one, for a `PassingWave`, has height,
        tilts and wave in equilibrium at all times; it is the only one for a slider that loads the wave, tilts or has a
        soft backing.
    envelope : Envelope, optional
        Factor on the orbits during the burst; the stepped and the quasi-static method accept one.
    track : Track, optional
        Orbits along the slider's way; at the displacement 0 they must be `orbits`. Only methods stepped and exact
        accept one.

    Returns
    -------
    Trajectory

    Raises
    ------
    ConvergenceError
        Status "not applicable" if the method does not apply, or the status of the solver that failed.
    """
    start_time = clock.perf_counter()
    after, fading = after if isinstance(after, tuple) else (after, None)
    parameter_check.positive("duration", duration, "s")
    parameter_check.non_negative("after", after, "s")
    parameter_check.positive("tolerance", tolerance, "")
    parameter_check.count("samples", samples, 2)
    parameter_check.choice("method", method, (*METHODS, QUASI_STATIC))
    if method == QUASI_STATIC or (coupling(slider, orbits) and method in ("auto", "averaged")):
        _refuse_quasi_static(orbits, track, fading)
        trajectory = _quasi_static(slider, orbits, duration, after, tolerance, samples, envelope)
        return replace(trajectory, seconds=clock.perf_counter() - start_time)
    body, listed = prescribed(slider, orbits, in_time=True)
    asked, side = _question(body, listed, duration, after, tolerance, samples, envelope, track)
    result, method, reasons = run(method, asked)
    motion, record, *ways = result.run
    driven = ways[0] if ways else None  # the motion along the track
    done = asked if driven is None else asked._replace(cycles=driven.cycles)
    if done.cycles < asked.cycles:
        reasons = (*reasons, f"the track ends after {done.cycles} of {asked.cycles} cycles")
    span = done.cycles / listed[0].frequency
    # what follows the burst goes on with its motion, so that velocity, record and energies are taken before
    end = side * float(motion.state[At.VELOCITY]) * asked.problem.speed
    parts = _series_of_burst(done, motion, record)
    own_ledger = ledger(body, motion) if motion.begun is not None else None
    later, after_ledger, statistics = Afterwards(), None, dict(result.statistics)
    if done.cycles == asked.cycles:
        share = _share_of_burst(span, after)
        later = follow_after(body, motion, after, fading, samples * (1.0 - share), asked.track, driven)
        parts += [part._replace(time=span + part.time) for part in later.parts]
    if later.at_rest is not None:
        after_ledger = ledger(body, later.at_rest)
        statistics |= {f"after_{name}": number for name, number in later.at_rest.events().items()}
    answer = Answer(
        value=end, error=result.error * asked.problem.speed, reasons=(f"{done.cycles} cycles from rest", *reasons)
    ).judged(tolerance, reference_speed(end, listed), _advice(method, envelope))
    time, velocity, position = (np.concatenate(series) for series in zip(*parts, strict=True))
    trajectory = Trajectory(
        slider=slider, orbits=orbits if isinstance(orbits, PassingWave) else listed, time=time,
        velocity=side * velocity * asked.problem.speed,
        position=position * asked.problem.length,
        duration=span, cycles=done.cycles, rang=later.rang, answer=answer, method=method,
        ledger=_whole_ledger(own_ledger, after_ledger, later.rang), after_ledger=after_ledger, statistics=statistics,
        seconds=clock.perf_counter() - start_time,
    )  # fmt: skip
    if driven is None:
        return trajectory
    return _on_track(trajectory, track, driven, later.along, side * asked.problem.length, asked.cycles)


def _share_of_burst(duration, after):
    """Return the part of a trajectory's time that the burst takes, and of its samples."""
    return duration / (duration + after)


def _question(slider, orbits, duration, after, tolerance, samples, envelope, track):
    """Return the scaled burst, and the side, +1 or -1, to which its waves run."""
    frequency = orbits[0].frequency
    cycles = max(1, round(duration * frequency))
    share = _share_of_burst(cycles / frequency, after)
    stride = max(1, round(cycles / max(1.0, samples * share)))
    side, driving = towards_plus(orbits)
    problem = rest_problem(slider, driving)
    question = Burst(slider, driving, problem, cycles, stride, tolerance, envelope)
    if track is not None:
        turn = np.exp(1j * driving[0].upward_zero) / problem.length
        question = question._replace(track=Scaled(track, side, turn, problem.length))
    return question, side


def _series_of_burst(burst, motion, record):
    """Return the start of a burst, its record and, if the last sample is not its end, the end: a list of `Series`."""
    frequency, cycles = burst.orbits.frequency, burst.cycles
    start = -burst.slider.rest_approach(len(burst.orbits)) / burst.problem.length
    sampled = burst.stride * np.arange(1, len(record) + 1) / frequency
    parts = [
        Series(np.zeros(1), np.zeros(1), np.full(1, start)),
        Series(sampled, record[:, Recorded.VELOCITY], record[:, Recorded.POSITION]),
    ]
    if cycles % burst.stride:
        end = np.full(1, cycles / frequency)
        parts.append(Series(end, motion.state[[At.VELOCITY]], motion.state[[At.POSITION]]))
    return parts


def _whole_ledger(own, after, rang):
    """Return the energies of burst and motion after it; None if those of the burst or of a ring-down are not known."""
    if own is None or rang:
        return None
    return own if after is None else together(own, after)


def _refuse_quasi_static(wave, track, fading):
    """Refuse what the quasi-static method does not take."""
    why = ("the orbits are prescribed, give a PassingWave",) if not isinstance(wave, PassingWave) else ()
    why += ("it takes no track",) if track is not None else ()
    why += ("it takes no ring-down",) if fading is not None else ()
    if why:
        raise refused("a burst", {QUASI_STATIC: why}, "leave them out")


def _quasi_static(slider, wave, duration, after, tolerance, samples, envelope):
    """Return the trajectory by the quasi-static method; its computing time is not known yet."""
    refuse_infinite_mass(slider)
    time = np.unique(np.append(np.linspace(0.0, duration + after, samples), duration))
    answer, velocity, height = quasi_static(slider, wave, time, duration, envelope)
    return Trajectory(
        slider=slider, orbits=wave, time=time, velocity=velocity, position=np.full(time.size, -height),
        duration=duration, cycles=max(1, round(duration * wave.frequency)), rang=0.0, method=QUASI_STATIC,
        answer=answer.judged(tolerance, reference_speed(answer.value, wave)), ledger=None, after_ledger=None,
        statistics={}, seconds=0.0,
    )  # fmt: skip


def _on_track(trajectory, track, driven, ringing, unit, asked):
    """Return a trajectory with its displacement, stopped where the track ends.

    `driven` and `ringing` are the motions along the track during the burst and the ring-down, `Followed` or None;
    ``unit``: the unit of length in m, with the side; `asked`: cycles of the burst that was asked for.
    """
    x = unit * np.concatenate([[0.0], driven.displacement])
    if x.size < trajectory.time.size and trajectory.time[x.size] <= trajectory.duration * (1.0 + 1e-12):
        x = np.append(x, unit * driven.place)  # the end of the burst is a sample of its own
    if ringing is not None:
        x = np.concatenate([x, unit * ringing.displacement])
    # on the surface at rest the displacement is the integral of the velocity
    at_rest = slice(x.size - 1, None)
    time, velocity = trajectory.time[at_rest], trajectory.velocity[at_rest]
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)
    x = np.concatenate([x, x[-1] + np.cumsum(steps)])
    outside = np.flatnonzero((x < track.limits[0]) | (x > track.limits[1]))
    inside = outside[0] if outside.size else x.size
    ended = trajectory.cycles < asked or inside < x.size or (ringing is not None and ringing.ended)
    return replace(
        trajectory, time=trajectory.time[:inside], velocity=trajectory.velocity[:inside],
        position=trajectory.position[:inside], displacement=x[:inside], ended=ended,
    )  # fmt: skip


def _advice(method, envelope):
    """Return what to do about a burst's error that exceeds the tolerance."""
    if envelope is not None:
        return (
            "even the shortest fixed steps do not follow this motion closely enough; an envelope excludes method exact"
        )
    return "" if method == "exact" else "ask for method exact"
