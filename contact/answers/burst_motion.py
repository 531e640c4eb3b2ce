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
from contact.answers.burst_methods import METHODS, Burst, rest_problem, ring_down, run, silence
from contact.answers.ledger import Ledger, ledger, together
from contact.answers.quasi_static import quasi_static
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
    begun = clock.perf_counter()
    after, fading = after if isinstance(after, tuple) else (after, None)
    parameter_check.positive("duration", duration, "s")
    parameter_check.non_negative("after", after, "s")
    parameter_check.positive("tolerance", tolerance, "")
    parameter_check.count("samples", samples, 2)
    parameter_check.choice("method", method, (*METHODS, QUASI_STATIC))
    given = slider
    if method == QUASI_STATIC or (coupling(slider, orbits) and method in ("auto", "averaged")):
        return _quasi_static(slider, orbits, duration, after, tolerance, samples, envelope, track, fading, begun)
    slider, listed = prescribed(slider, orbits, in_time=True)
    frequency = listed[0].frequency
    cycles = max(1, round(duration * frequency))
    share = cycles / frequency / (cycles / frequency + after)
    stride = max(1, round(cycles / max(1.0, samples * share)))
    side, driven = towards_plus(listed)
    problem = rest_problem(slider, driven)
    request = Burst(slider, driven, problem, cycles, stride, tolerance, envelope)
    if track is not None:
        turn = np.exp(1j * driven[0].upward_zero) / problem.length
        request = request._replace(track=Scaled(track, side, turn, problem.length))
    result, method, reasons = run(method, request)
    (motion, record, *way), statistics, asked = result.run, result.statistics, cycles
    if way:
        cycles = way[0].cycles
        request = request._replace(cycles=cycles)
        reasons = (*reasons, *((f"the track ends after {cycles} of {asked} cycles",) if cycles < asked else ()))
    end, parts = side * float(motion.state[At.VELOCITY]) * problem.speed, _during(request, motion, record)
    ledgers = [ledger(slider, motion)] if motion.begun is not None else []
    slid, rang, still = [], 0.0, None
    if cycles == asked:
        slid, rang, still = _follow_on(slider, motion, after, fading, samples * (1.0 - share), request.track, way)
    parts += [(cycles / frequency + part[0], *part[1:]) for part in slid]
    after_ledger = None
    if still is not None:
        after_ledger = ledger(slider, still)
        statistics |= {f"after_{name}": number for name, number in still.events().items()}
        ledgers += [after_ledger] if ledgers else []
    time, velocity, position = (np.concatenate(series) for series in zip(*parts, strict=True))
    answer = Answer(
        value=end, error=result.error * problem.speed, reasons=(f"{cycles} cycles from rest", *reasons)
    ).judged(tolerance, reference_speed(end, listed), _advice(method, envelope))
    motion_after = Trajectory(
        slider=given, orbits=orbits if isinstance(orbits, PassingWave) else listed, time=time,
        velocity=side * velocity * problem.speed,
        position=position * problem.length,
        duration=cycles / frequency, cycles=cycles, rang=rang, answer=answer, method=method,
        ledger=together(*ledgers) if ledgers and not rang else None, after_ledger=after_ledger, statistics=statistics,
        seconds=clock.perf_counter() - begun,
    )  # fmt: skip
    return motion_after if track is None else _on_track(motion_after, track, way, side * problem.length, asked)


def _quasi_static(slider, wave, duration, after, tolerance, samples, envelope, track, fading, begun):
    """Return the trajectory by the quasi-static method."""
    why = ("the orbits are prescribed, give a PassingWave",) if not isinstance(wave, PassingWave) else ()
    why += ("it takes no track",) if track is not None else ()
    why += ("it takes no ring-down",) if fading is not None else ()
    if why:
        raise refused("a burst", {QUASI_STATIC: why}, "leave them out")
    refuse_infinite_mass(slider)
    time = np.unique(np.append(np.linspace(0.0, duration + after, samples), duration))
    answer, velocity, height = quasi_static(slider, wave, time, duration, envelope)
    return Trajectory(
        slider=slider, orbits=wave, time=time, velocity=velocity, position=np.full(time.size, -height),
        duration=duration, cycles=max(1, round(duration * wave.frequency)), rang=0.0, method=QUASI_STATIC,
        answer=answer.judged(tolerance, reference_speed(answer.value, wave)), ledger=None, after_ledger=None,
        statistics={}, seconds=clock.perf_counter() - begun,
    )  # fmt: skip


def _on_track(trajectory, track, way, unit, asked):
    """Return a trajectory with its displacement, stopped at the end of the track; ``unit``: m, with the side."""
    x = unit * np.concatenate([[0.0], way[0].displacement])
    if x.size < trajectory.time.size and trajectory.time[x.size] <= trajectory.duration * (1.0 + 1e-12):
        x = np.append(x, unit * way[0].place)
    if len(way) > 1:
        x = np.concatenate([x, unit * way[1].displacement])
    rest = slice(x.size - 1, None)
    time, velocity = trajectory.time[rest], trajectory.velocity[rest]
    steps = 0.5 * (velocity[1:] + velocity[:-1]) * np.diff(time)
    x = np.concatenate([x, x[-1] + np.cumsum(steps)])
    outside = np.flatnonzero((x < track.limits[0]) | (x > track.limits[1]))
    inside = outside[0] if outside.size else x.size
    return replace(
        trajectory, time=trajectory.time[:inside], velocity=trajectory.velocity[:inside],
        position=trajectory.position[:inside], displacement=x[:inside],
        ended=trajectory.cycles < asked or inside < x.size or (len(way) > 1 and way[1].ended),
    )  # fmt: skip


def _during(burst, motion, record):
    """Return the parts of a burst: start, record and, if the last sample is not its end, the end; see `_follow_on`."""
    frequency, start = burst.orbits.frequency, -burst.slider.rest_approach(len(burst.orbits)) / burst.problem.length
    ends = burst.stride * np.arange(1, len(record) + 1)
    parts = [
        (np.zeros(1), np.zeros(1), np.full(1, start)),
        (ends / frequency, record[:, Recorded.VELOCITY], record[:, Recorded.POSITION]),
    ]
    if burst.cycles % burst.stride:
        parts.append((np.full(1, burst.cycles / frequency), motion.state[[At.VELOCITY]], motion.state[[At.POSITION]]))
    return parts


def _advice(method, envelope):
    """Return what to do about a burst's error that exceeds the tolerance."""
    if envelope is not None:
        return (
            "even the shortest fixed steps do not follow this motion closely enough; an envelope excludes method exact"
        )
    return "" if method == "exact" else "ask for method exact"


def _follow_on(slider, motion, after, envelope, samples, track, way):
    """Follow the slider after the burst, during the ring-down of the surface and then on the surface at rest.

    Returns (parts, duration of the ring-down, motion at the end). A part is (times in s from the end of the burst, v,
    z_s). The motion is None if the surface does not come to rest within the time `after`, or the slider comes to an end
    of the `track` before. `way`: the motion along it up to now, `Followed`; that during the ring-down is appended.
    """
    parts, rang, problem = [], 0.0, motion.problem
    if envelope is not None:
        count = max(2, round(samples / 2.0))
        start = way[0].place if way else 0.0
        times, record, *along = ring_down(
            slider, motion, envelope, longest=after, samples=count, track=track, start=start
        )
        way += along
        if times.size:
            rang = float(times[-1])
            parts.append((times, record[:, Recorded.VELOCITY], record[:, Recorded.POSITION]))
    if after <= rang or any(each.ended for each in way):
        return parts, rang, None
    still, span, count = silence(motion), after - rang, max(2, round(samples))
    at = np.arange(1, count + 1) * (span / count)
    z, *_, velocity = still.move(0.0, problem.omega * span * (1.0 + 1e-12), at * problem.omega)[:, 0].T
    # the surface is at rest at zero, so that the approach of the first contact is its height less z_s
    parts.append((rang + at, velocity, problem.paths.height[0] - z))
    return parts, rang, still
