"""Motion of a slider in the plane during a burst of the waves and after it."""

import copy
import math
import time
from contextlib import suppress
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.answers.ledger import Ledger
from contact.choice import Answer
from contact.error_estimate import speed_scale
from contact.exceptions import ConvergenceError, InputError
from contact.passing_wave import refuse_infinite_mass
from contact.plane.averaged import Averaged, accuracies
from contact.plane.averaged_path import AveragedPath
from contact.plane.burst_path import PlaneTrajectory
from contact.plane.fixed_steps import FixedSteps
from contact.plane.full_motion import SATURATED, FullMotion, begun_later, followed_from_rest, units_at_rest
from contact.plane.plane_equations import Body
from contact.plane.plane_waves import Surface, SurfaceWaves, surface_under
from contact.plane.scaling import FREE, averaging_error, beats_slowly, refuse_slow_beat, resonance_ratios
from contact.plane.steady_state import refuse
from contact.plane.wave_shape import Shape, WaveShape
from contact.slider import Slider

METHODS = ("auto", "exact", "stepped", "averaged")
# Nodes and tolerance of the exact motion and of the one that it is compared with, whose error is far larger, so that no
# two agree by chance, and the least error that is stated, over the speed: by the tolerance of the answer down to which
# they serve. `tests/benchmarks/plane_exact_error.py` measured the true error over the stated one
EXACT = {
    1e-3: ((4, 1e-2), (3, 1e-1), 1e-6),
    1e-5: ((5, 3e-3), (4, 1e-2), 3e-7),
    1e-6: ((6, 3e-4), (4, 3e-3), 5e-8),
    0.0: ((6, 1e-6), (5, 1e-4), 1e-9),
}
STEPS = {1e-2: (192, 128), 1e-3: (768, 512), 0.0: (3072, 2048)}  # per cycle of the fastest wave
# Error over the correction by Richardson's extrapolation, 0.006 to 1.3 in tests/contact/test_plane_motion.py, where
# contacts stick at the touch; a component is not known better than half of the other one
LEFT = 1.0
RESTART = 300  # cycles after which phases and places are counted anew
# Change of the rate of a wave's factor at a knot, over omega and the tolerance, from which on no segment goes across:
# energies miss 1e-5 at the tolerance 1e-6 where segments cross knots whose rates change by 1e-3
CORNER = 1.0
CLOSE = 1e-9  # of a phase: instants that are one
MOVED = 1e-6  # m: way of a contact after which the waves under it are taken anew; 6e-3 of the phase of a wave of 1 mm
# Cycles of the fastest wave times contacts up to which `auto` follows the events: 0.02 ms each at a tolerance of 1e-3,
# 0.04 ms at 1e-6, in both computations (`tests/benchmarks/plane_cost.py`)
MAX_EXACT = 20_000
MAX_SHAPED = 200_000  # the same where the waves' shape is too fast for their means
LAG = 0.5  # error of a velocity over the lag of the height that a shape of the waves makes, relative to the load
DECAYS = 3.0  # time constants of the bounce that are followed event by event; 5 % of its size are left then
# Time for which the mean force differs after a change of the wave, over the period of the bounce over 2 pi: 4.4 on
# `twente-planar` from rest, where the height changes most
BOUNCES = 5.0
HELD_RINGS = 2.0  # largest rate in the ring of a held slider over that at the instants of its start
CREEPS = 0.3  # damping rate over the resonance above which the height follows the waves without a bounce to speak of
FADED = 0.1  # size of waves that have faded after a burst, over that at its end
ROUNDING = 1e-9  # of the largest speed: rates below it are none
INSTANTS = 12  # of a motion, at which two computations of it are compared
MAX_LAGS, LEVELS = 100_000, 17  # instants and levels of the waves at which a lag of the height is known
PLACE = 1e-4  # m: a tenth of a wavelength, to which the tolerance of a place refers
MAX_COAST = 10.0  # s after the burst within which a slider has to stop


def burst(
    slider: Slider, surface: Surface, *, duration: float, after: float, tolerance: float, samples: int,
    method: str = "auto", rise_time: float = 0.0, start: tuple | None = None, envelope: Shape | None = None,
    ring_down: Shape | None = None, in_place: bool = False,
) -> PlaneTrajectory:  # fmt: skip
    """Return the motion from rest during a burst and after it.

    Parameters
    ----------
    slider, surface
        As for `steady`. On a field the waves are followed: those under a contact are taken anew when it has moved by
        1 um or turned that far. A motion given at the contacts alone stays the same. The burst begins at the time zero
        of the amplitudes; `from_upward_zero` gives the one at which `contact.burst` begins along x.
    duration, after : float
        Length of the burst, and time followed after it, s; with `after` inf until the slider has stopped, by the
        averaged motion.
    tolerance : float
        Allowed error of the speed at the end of the burst, relative to max(|V|, omega |u_t|/10).
    samples : int
        Number of instants recorded, evenly spaced; with `after` inf of the burst and as many of the coast.
    method : str
        "exact" (event by event), "stepped" (fixed steps), "averaged" (after a start event by event), or "auto". The
        last two take fixed steps where the events are not solved.
    rise_time : float
        Time constant of the waves' rise, 1 - exp(-t/rise_time), and of their fall after the burst, s.
    start : (pose, rates), optional
        (x, y, yaw) in m and rad and their rates at the beginning, by the averaged motion. Absent: at rest.
    envelope : Envelope or mapping of float to Envelope, optional
        Factor on the waves during the burst, of all or by frequency in Hz, without a rise time.
    ring_down : Envelope or mapping of float to Envelope, optional
        The same after the burst, with the time from its end. Absent: the surface is at rest then.
    in_place : bool
        True if the mean forces of the averaged motion stay those at the first pose, on the waves there: the motion
        that tends to that of `steady`.

    Examples
    --------
    >>> slider = Slider(
    ...     radius=1e-3, mass=1e-7, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.05, tangential_damping=0.0, freedom="xy",
    ... )
    >>> waves = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-1.34e-9j, 1.34e-9, 2e-9 + 2e-9j]]])
    >>> run = burst(
    ...     slider, waves, duration=60 / 2.2e6, after=0.0, tolerance=1e-6, samples=7, rise_time=5 / 2.2e6
    ... )
    >>> print(f"{1e3 * run.velocity[-1, 1]:.4f} mm/s, {run.method}")
    7.0341 mm/s, exact
    """
    begun = time.perf_counter()
    for name, value in (("duration", duration), ("tolerance", tolerance)):
        parameter_check.positive(name, value, "s" if name == "duration" else "")
    ends = after == math.inf
    for name, value in (("after", 0.0 if ends else after), ("rise_time", rise_time)):
        parameter_check.non_negative(name, value, "s")
    parameter_check.count("samples", samples, 1)
    parameter_check.choice("method", method, METHODS)
    refuse(slider)
    refuse_infinite_mass(slider)
    if (ends or start is not None) and method in ("exact", "stepped"):
        rule = 'must be "averaged" or "auto" until the slider has stopped, and from a start in motion'
        raise InputError("method", rule, method)
    if in_place and method != "averaged":
        raise InputError("method", 'must be "averaged" for mean forces that stay those of one place', method)
    waves = surface_under(slider, surface)
    shape = WaveShape.of(waves, duration, envelope, ring_down)
    if shape is not None and rise_time > 0.0:
        raise InputError("rise_time", "must be 0 with an envelope", rise_time, "s")
    at = np.linspace(0.0, duration if ends else duration + after, samples + 1)[1:]
    if 0.0 < after:
        at = np.union1d(at, [duration])
    begins = None if start is None else np.concatenate([np.asarray(each, float) for each in start])
    question = _Question(
        slider, surface, waves, at, duration, rise_time, tolerance, begins, ends, samples, shape, in_place
    )
    if method == "auto":
        cycles = (duration + after) * waves.omega / (2.0 * math.pi)
        by_events = cycles * waves.count <= MAX_EXACT or beats_slowly(slider, waves)
        method = "exact" if by_events and start is None and not ends else "averaged"
        if method == "exact":
            try:
                return _answered(question, method, _exact(question), begun)
            except ConvergenceError:
                method = "stepped"
        elif shape is not None and not ends and start is None and cycles * waves.count <= MAX_SHAPED:
            method, found = _averaged_or_exact(question)
            return _answered(question, method, found, begun)
    found = {"exact": _exact, "stepped": _stepped, "averaged": _averaged}[method](question)
    return _answered(question, method, found, begun)


class _Question:
    """What every method takes."""

    def __init__(
        self, slider, surface, waves, at, duration, rise_time, tolerance, start, ends, samples, shape, in_place
    ):
        self.slider, self.surface, self.waves, self.at = slider, surface, waves, at
        self.duration, self.rise_time, self.tolerance = duration, rise_time, tolerance
        self.start, self.ends, self.samples, self.shape, self.in_place = start, ends, samples, shape, in_place
        arms = np.hypot(np.subtract(slider.x, slider.axis[0]), np.subtract(slider.y, slider.axis[1]))
        self.arm = float(np.max(arms)) if slider.freedom == "axle" else float(np.max(np.hypot(slider.x, slider.y)))

    def up_to(self, at):
        """Return the question of the same burst at other instants."""
        other = copy.copy(self)
        other.at = at
        return other

    def with_more_instants(self):
        """Return the question with instants in which two computations are compared: they may agree at one by chance."""
        return self.up_to(np.union1d(self.at, np.linspace(0.0, self.at[-1], INSTANTS + 1)[1:]))

    @property
    def follows(self):
        """True if the waves under the contacts change with their place."""
        return not isinstance(self.surface, SurfaceWaves)

    @property
    def at_rest_from(self):
        """The time at which the surface falls to rest at once, s; inf where it fades with the rise time."""
        if self.shape is not None:
            return self.shape.end
        return self.duration if self.rise_time == 0.0 else math.inf

    def level(self, t, after):
        """Return the factor on waves without a shape at a time; `after`: True after the burst."""
        if self.rise_time == 0.0:
            return 0.0 if after else 1.0
        up = 1.0 - math.exp(-min(t, self.duration) / self.rise_time)
        return up * math.exp(-max(t - self.duration, 0.0) / self.rise_time)

    def size_of(self, rates):
        """Return |V|, or the speed of the farthest contact of an axle; of errors too."""
        return abs(rates[2]) * self.arm if self.slider.freedom == "axle" else float(np.hypot(*rates[:2]))

    def reference(self, rates):
        """Return the speed to which a relative error at these rates refers."""
        return speed_scale(self.size_of(rates), self.waves.peak_speed)


class _Found(NamedTuple):
    """What every method returns."""

    time: np.ndarray  # (k,) s
    pose: np.ndarray  # (k, 3)
    rates: np.ndarray
    height: np.ndarray
    error: np.ndarray  # (3,) of the rates
    pose_error: np.ndarray
    ledger: Ledger | None
    reason: str
    statistics: dict
    stopped: float = math.inf  # s


def _answered(question, method, found: _Found, begun):
    end = _at_end(question, found)
    speed, reference = question.size_of(found.rates[end]), question.reference(found.rates[end])
    answer = Answer(value=speed, error=question.size_of(found.error), reasons=(found.reason,))
    answer = answer.judged(question.tolerance, reference)
    return PlaneTrajectory(
        answer=answer, time=found.time, pose=found.pose, rates=found.rates, height=found.height, error=found.error,
        pose_error=found.pose_error, duration=question.duration, stopped=found.stopped, reference=reference,
        ledger=found.ledger, method=method, statistics=found.statistics, seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _averaged_or_exact(question):
    """Return method and motion of a burst whose waves may change too fast for their means."""
    if _relative_error(question, _bounces_until(question)) <= question.tolerance:
        with suppress(ConvergenceError):
            found = _averaged(question)
            end = found.rates[_at_end(question, found)]
            if question.size_of(found.error) <= question.tolerance * question.reference(end):
                return "averaged", found
    try:
        return "exact", _exact(question)
    except ConvergenceError:
        return "stepped", _stepped(question)


def _at_end(question, found):
    """Return the index of the instant at which the burst ends."""
    return min(int(np.searchsorted(found.time, question.duration * (1.0 - 1e-12))), len(found.time) - 1)


def _levels(table, tolerance):
    return next(pair for level, pair in table.items() if tolerance >= level)


def _exact(question):
    """Two motions that differ in nodes and tolerance of their segments.

    Finer ones where one does not converge, and where they differ by more than the tolerance.
    """
    found = None
    for fine, coarse, least in [each for level, each in EXACT.items() if question.tolerance >= level]:
        try:
            found = _compared(question, fine, coarse, least)
        except ConvergenceError:
            continue
        if question.size_of(found.error) <= question.tolerance * question.reference(found.rates[-1]):
            return found
    if found is None:
        raise ConvergenceError("not converged", "a segment of the motion in the plane was not solved")
    return found


def _compared(question, how, other, least):
    asked, question = question.at, question.with_more_instants()
    (pose, rates, height, motion), (place, rough, _, _) = (_exact_run(question, each) for each in (how, other))
    error, pose_error = np.abs(rates - rough).max(axis=0), np.abs(pose - place).max(axis=0)
    moves = np.isin(range(3), FREE[question.slider.freedom]) / np.array([1.0, 1.0, question.arm or 1.0])
    speed = max(question.reference(each) for each in rates)
    error += least * speed * moves
    pose_error += least * speed * float(question.at[-1]) * moves
    names = {"segments": int(motion.state.total[2]), "trials": int(motion.state.total[3])}
    reason, at = "event by event in the plane", np.searchsorted(question.at, asked)
    return _Found(asked, pose[at], rates[at], height[at], error, pose_error, motion.ledger(), reason, names)


def _exact_run(question, how):
    """Return the motion of one accuracy."""
    return followed_from_rest(
        lambda begun: _followed(question, begun), question.slider, question.waves, how, rise=question.rise_time,
        stop=question.duration, shape=question.shape,
    )  # fmt: skip


def _stepped(question):
    """Fixed steps of two sizes."""
    asked, question = question.at, question.with_more_instants()
    fine, coarse = _levels(STEPS, question.tolerance)
    units = units_at_rest(
        question.slider, question.waves, rise=question.rise_time, stop=question.duration, shape=question.shape
    )
    (pose, rates, height, _), (rough_pose, rough, _, _) = (
        _followed(question, FixedSteps.at_rest(units, steps)) for steps in (fine, coarse)
    )
    # first order: Richardson's extrapolation, of whose correction a share is left
    correction = (rates - rough) / (fine / coarse - 1.0)
    moved = (pose - rough_pose) / (fine / coarse - 1.0)
    pose, rates = pose + moved, rates + correction
    error = LEFT * np.abs(correction).max(axis=0) + 1e-12 * np.abs(rates).max(axis=0)
    pose_error = LEFT * np.abs(moved).max(axis=0) + 1e-12 * np.abs(pose).max(axis=0)
    for each in (error, pose_error):
        each[:2] = np.maximum(each[:2], 0.5 * each[:2].max())
    reason = f"{coarse} and {fine} fixed steps per cycle, extrapolated"
    at = np.searchsorted(question.at, asked)
    return _Found(asked, pose[at], rates[at], height[at], error, pose_error, None, reason, {"steps": fine})


def _followed(question, motion: FullMotion):
    """Return (pose, rates, height, motion) of a motion at the instants asked for."""
    units, k = motion.units, len(question.at)
    pose, rates, height = np.zeros((k, 3)), np.zeros((k, 3)), np.zeros(k)
    scale = np.array([units.length, units.length, 1.0])
    place, cycle = np.zeros(3), 2.0 * math.pi
    stop, rests = question.duration * units.omega, question.at_rest_from * units.omega
    silent = rests == math.inf
    corners = (
        np.zeros(0) if question.shape is None else question.shape.corners(CORNER * question.tolerance) * units.omega
    )
    for j, t in enumerate(question.at):
        until = t * units.omega
        while motion.phase < until - CLOSE:
            here = motion.phase
            to = min(until, stop) if here < stop - CLOSE else until
            to = min(to, rests) if here < rests - CLOSE else to
            to = min(to, here + RESTART * cycle)
            ahead = int(np.searchsorted(corners, here + 2.0 * CLOSE))
            if ahead < len(corners):
                to = min(to, corners[ahead] - CLOSE)
            if question.follows:
                # so that the waves change in small steps
                speed = max(np.abs(motion.state.p[1:3]).max(), abs(motion.state.p[3]) * question.arm / units.length)
                to = min(to, here + max(cycle, MOVED / units.length / max(speed, 1e-300)))
            motion.follow(to - here + motion.state.total[0])
            if motion.state.total[0] > RESTART * cycle:
                motion = motion.restarted()
            if not silent and motion.phase >= rests - CLOSE:
                motion, silent = motion.silenced(), True
            if question.follows and not (silent and rests < math.inf):
                now = motion.place * scale
                if np.abs(now - place)[:2].max() > MOVED or abs(now[2] - place[2]) * question.arm > MOVED:
                    motion, place = _on_waves_at(question, motion, now), now
        pose[j], rates[j] = motion.place * scale, motion.state.p[1:] * [units.speed, units.speed, units.omega]
        height[j] = motion.state.q[Body.HEIGHT] * units.length
    return pose, rates, height, motion


def _on_waves_at(question, motion, pose):
    """Return the motion on the waves at another pose."""
    waves = surface_under(question.slider, question.surface, pose)
    length, problem = motion.units.length, motion.units.problem
    whole = problem._replace(cos=waves.amplitudes.real / length, sin=-waves.amplitudes.imag / length)
    cos, sin = begun_later(whole, motion.phase - motion.state.total[0])
    return motion.on(problem._replace(cos=cos, sin=sin))


def _averaged(question):
    """The averaged equations of velocity and yaw rate, twice with means that differ, after a start with its events."""
    slider = question.slider
    refuse_slow_beat(slider, question.waves)
    begun = _start(question)
    answer, check = accuracies(question.tolerance)
    path = _path(question, answer, 0.1)
    fine = _averaged_run(question, path, begun, question.at)
    rough = _averaged_run(question, _path(question, check, 1.0), begun, fine.time)
    height = np.append(begun.rows[2], _heights(question, path, fine, len(begun.at)))
    missed = np.abs(fine.state - rough.state).max(axis=0)
    # a relative error of the forces moves each contact, and so turns a slider that hardly turns
    arms = np.array([1.0, 1.0, question.arm or 1.0])
    speed = float(np.abs(fine.state[:, 3:] * arms).max())
    systematic = begun.error + _relative_error(question, begun.time) * speed / arms
    if begun.moves:  # the height comes to its mean within some bounces, through which the force differs
        ratio, _ = resonance_ratios(slider, question.waves)
        way, time_of = np.abs(np.diff(fine.state[:, 3:], axis=0)), np.diff(fine.time)[:, None]
        if len(way):
            systematic += BOUNCES * (way / time_of).max(axis=0) / (ratio * question.waves.omega)
    systematic += _of_bounces(question, begun, fine, height)
    ring, swing = _of_springs(question, fine)
    error = missed[3:] + systematic + ring
    pose_error = missed[:3] + systematic * float(fine.time[-1]) + swing
    names = {"evaluations": path.evaluations}
    reason = f"averaged motion in the plane{begun.reason}"
    pose, rates = fine.state[:, :3], fine.state[:, 3:]
    return _Found(fine.time, pose, rates, height, error, pose_error, None, reason, names, fine.stopped)


def _of_bounces(question, begun, run, height):
    """Return the errors of the rates (3,) by bounces that averaging leaves out: of a held slider, and after the waves.

    After the waves the impulse of friction is the friction coefficient times that of the normal forces, which differs
    from the preload's by the change of the slider's vertical momentum: at most twice that of a bounce as high as the
    way of the height, or as one whose force is the preload.
    """
    slider, coasts, error = question.slider, run.time > question.duration, np.zeros(3)
    held = run.state[(run.time > begun.time) & ~coasts, 3:]
    if len(held) and len(begun.rows[1]):  # a slider that is held rings as at its start
        error += HELD_RINGS * np.abs(begun.rows[1]).max(axis=0) * (held == 0.0).any(axis=0)
    if not coasts.any() or slider.mass == math.inf:
        return error
    bounce = 2.0 * math.pi * slider.normal_resonance(slider.count)
    friction = slider.static_friction(slider.count)
    friction *= min(slider.mass * bounce**2 * float(np.ptp(height)) / slider.preload, 1.0)
    turned = friction * question.arm / slider.inertia if slider.inertia else 0.0
    slowed = np.array([friction / slider.mass, friction / slider.mass, turned])
    slowed *= run.state[coasts, 3:].any(axis=0) & _moving(question, run)
    return error + 2.0 * slowed / (bounce * (1.0 + bounce * question.rise_time))


def _of_springs(question, run):
    """Return the errors of the rates and of the pose (3,) where the slider rests after the waves, in its springs."""
    slider, coasts = question.slider, run.time > question.duration
    stops = spring_back(slider) if run.stopped < math.inf else np.zeros(3)
    if not coasts.any() or slider.mass == math.inf:
        return np.zeros(3), stops
    ring = _ring_after_the_waves(question, run.state[~coasts][-1, 3:])
    ring *= (np.abs(run.state[coasts, 3:]).min(axis=0) <= ring) & _moving(question, run)
    swing = ring / (math.pi * slider.tangential_resonance(slider.count))
    return ring, stops if run.stopped < math.inf else swing


def _moving(question, run):
    """Return which of the rates of a run are more than rounding, (3,)."""
    rates = np.abs(run.state[:, 3:]).max(axis=0) * [1.0, 1.0, question.arm or 1.0]
    return rates > ROUNDING * rates.max()


def _ring_after_the_waves(question, rates):
    """Return the largest rates (3,) of a slider that rests after the waves and swings in its springs.

    ``rates``: those at the end of the waves (3,). Springs that the load and the waves have deformed give it the rest,
    up to that of the slip limit.
    """
    slider, waves = question.slider, question.waves
    pulse = 2.0 * math.pi * slider.tangential_resonance(slider.count)
    most = 0.5 * pulse * spring_back(slider)
    arm = most[0] / most[2] if most[2] > 0.0 else 0.0
    torque = abs(slider.torque) / arm if arm > 0.0 else 0.0
    load = (float(np.hypot(*np.atleast_1d(slider.load))) + torque) / (slider.mass * pulse)
    speed = float(np.hypot(*rates[:2])) + arm * abs(float(rates[2])) + pulse * waves.peak_speed / waves.omega + load
    return most * min(speed / most[0], 1.0) if most[0] > 0.0 else np.zeros(3)


def spring_back(slider):
    """Return how far a slider that friction has stopped moves while its contacts spring back, shape (3,), m and rad.

    The averaged motion ends before: from their slip limit c z the contacts swing to -c z at most.
    """
    swing = 2.0 * float(np.max(slider.limit_slope * slider.rest_approaches(slider.count)))
    squares = np.subtract(slider.x, slider.axis[0]) ** 2 + np.subtract(slider.y, slider.axis[1]) ** 2
    arm = math.sqrt(float(np.mean(squares)))
    return np.array([swing, swing, swing / arm if arm > 0.0 else 0.0])


def _relative_error(question, begin):
    """Return the relative error of a velocity by averaging from a time, s, to the end."""
    error = averaging_error(question.slider, question.waves)
    if question.shape is not None:
        error += question.shape.spread(question.waves) + LAG * _height_lag(question, begin)
    return error


def _height_lag(question, begin):
    """Return the largest relative change of the load, after a time, by which the height lags behind the waves.

    The end of waves that fade within a period of the bounce is left out: `_of_bounces` has the bounce that it makes.
    Dampers by which the height creeps to its mean keep it: what they carry on a ramp is not estimated otherwise.
    """
    slider, shape, waves = question.slider, question.shape, question.waves
    time = shape.time if shape.time.size < MAX_LAGS else np.linspace(0.0, shape.end, MAX_LAGS)
    levels = np.sqrt(np.mean([np.interp(time, shape.time, each) ** 2 for each in shape.amplitude], axis=0))
    if np.ptp(levels) == 0.0:
        return 0.0
    grid = np.linspace(levels.min(), levels.max(), LEVELS)
    means = [Averaged.of(slider, waves.scaled(each)) for each in grid]
    at_rest = np.interp(levels, grid, [float(each.height.mean()) * each.scaled.length for each in means])
    resonance = 2.0 * math.pi * slider.normal_resonance(slider.count)
    damping = (slider.normal_damping + slider.contact_damping * slider.preload) / (2.0 * slider.unit_mass)
    pole = complex(-damping, math.sqrt(max(resonance**2 - damping**2, 0.0)))
    width = np.diff(time)
    faded = (time > question.duration) & (levels < FADED * np.interp(question.duration, time, levels))
    fades = float(time[faded][0]) - question.duration if faded.any() else 0.0
    bounces = fades < 2.0 * math.pi / resonance and damping < CREEPS * resonance
    last = question.duration * (1.0 - ROUNDING) if bounces else math.inf
    # its speed at a knot changes by that of the height at which it would rest
    jumps, turns = np.diff(np.diff(at_rest) / width), np.exp(pole * width[1:])
    state, largest = 0j, 0.0
    for t, jump, turn in zip(time[1:-1], jumps, turns, strict=True):
        if t >= last:
            break
        state -= jump
        if t + 1.0 / resonance >= begin:
            largest = max(largest, abs(state))
        state *= turn
    return slider.unit_mass * resonance * largest / slider.preload


class _Start(NamedTuple):
    """Where the averaged motion begins."""

    time: float  # s
    state: np.ndarray  # (6,)
    at: np.ndarray  # instants before, (k,) s, with pose, rates and height there
    rows: tuple
    error: np.ndarray  # (3,) of the rates, which the start leaves
    moves: bool  # True if the slider begins in motion
    reason: str


def _start(question):
    """Return the motion up to where the bounce of the start has decayed, event by event, or in fixed steps.

    A wave that begins finds the slider at its height of rest. It bounces about the mean height of the wave for 2 m/R_n,
    with another mean force: on `twente-planar` the velocity after 1 ms is 9 % less than by the averaged equations.
    """
    slider, begun = question.slider, question.start
    none = np.zeros(0), (np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))
    if begun is not None:
        return _Start(0.0, begun, *none, np.zeros(3), True, "")
    decay, until = _decay(slider), _bounces_until(question)
    at = np.union1d(question.at[question.at < until], [until])
    try:
        found, how = _exact(question.up_to(at)), "event by event"
    except ConvergenceError:
        found, how = _stepped(question.up_to(at)), "in fixed steps"
    error, fall = found.error, math.exp(-until / decay)
    left = min(fall / max(1.0 - fall, 1e-12), question.duration / until - 1.0)
    if left > 0.0:
        # without the rise, in which contacts may keep their deformation
        path = replace(_path(question, accuracies(question.tolerance)[1], 1.0), level=lambda *_: 1.0, rise_time=0.0)
        mean = path.follow(np.zeros(6), (0.0, until), np.array([until])).end
        error = error + left * np.abs(found.rates[-1] - mean[3:])
    rows = found.pose[:-1], found.rates[:-1], found.height[:-1]
    last = np.concatenate([found.pose[-1], found.rates[-1]])
    reason = f", {how} for the first {until * 1e3:.2g} ms"
    return _Start(until, last, at[:-1], rows, error, False, reason)


def _decay(slider):
    """Return the time constant of a slider's bounce, s."""
    damping = slider.normal_damping + slider.contact_damping * slider.preload
    return 2.0 * slider.unit_mass / damping if damping > 0.0 else math.inf


def _bounces_until(question):
    """Return the time up to which a start from rest is followed event by event, s."""
    most = MAX_EXACT * 2.0 * math.pi / (question.waves.omega * question.waves.count)
    return min(DECAYS * _decay(question.slider), most, question.duration)


class _Run(NamedTuple):
    time: np.ndarray
    state: np.ndarray  # (k, 6)
    stopped: float  # s; inf where the slider still moves


def _path(question, how, share) -> AveragedPath:
    """Return the averaged motion with means of an accuracy, integrated to a share of the tolerance."""
    slider, relative = question.slider, max(share * question.tolerance, 1e-9)
    reach, speed = question.arm or 1.0, max(0.1 * question.waves.peak_speed, 1e-9)
    if question.start is not None:
        speed = max(speed, float(np.hypot(*question.start[3:5])), reach * abs(float(question.start[5])))
    scale = np.array([PLACE, PLACE, PLACE / reach, speed, speed, speed / reach])
    return AveragedPath(
        slider, question.surface, question.level, how, relative, question.rise_time, scale, question.shape,
        question.in_place,
    )  # fmt: skip


def _averaged_run(question, path: AveragedPath, begun: _Start, instants) -> _Run:
    duration, state, stopped = question.duration, begun.state, math.inf
    at, states = [begun.at], [np.concatenate(begun.rows[:2], axis=1)]
    during, later = instants[instants <= duration], instants[instants > duration]
    if begun.time < duration:
        run = path.follow(state, (begun.time, duration), during[during >= begun.time])
        at, states, state = [*at, run.time], [*states, run.state], run.end
    elif begun.time in during:
        at, states = [*at, np.array([begun.time])], [*states, state[None]]
    if question.ends:
        end, later = duration + MAX_COAST, later if len(later) else question.samples
    else:
        end = float(instants[-1])
    fades = SATURATED * question.rise_time if question.shape is None else question.shape.end - duration
    faded = min(duration + fades, end)
    if faded > duration:
        fading = np.linspace(duration, faded, 5)[1:] if isinstance(later, int) else later[later <= faded]
        later = later if isinstance(later, int) else later[later > faded]
        run = path.follow(state, (duration, faded), fading, after=True)
        at, states, state = [*at, run.time], [*states, run.state], run.end
    if end > faded:
        run = path.follow(state, (faded, end), later, after=True, coasts=True)
        at, states, stopped = [*at, run.time], [*states, run.state], run.stopped
        if question.ends and stopped == math.inf:
            raise ConvergenceError("not converged", f"the slider does not stop within {MAX_COAST:g} s after the burst")
    return _Run(np.concatenate(at), np.concatenate(states), stopped)


def _heights(question, path: AveragedPath, run: _Run, first: int):
    """Return the mean heights at the instants of a run from the first that the averaged motion has followed."""
    later = zip(run.time[first:], run.state[first:, :3], strict=True)
    return [path.height(t, pose, t > question.duration) for t, pose in later]
