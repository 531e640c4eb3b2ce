"""Motion of a slider in the plane during a burst of the waves and after it, from rest."""

import math
import time
from dataclasses import replace

import numpy as np
from scipy.integrate import solve_ivp

from contact import parameter_check
from contact.choice import Answer
from contact.error_estimate import speed_scale
from contact.exceptions import ConvergenceError
from contact.passing_wave import refuse_infinite_mass
from contact.plane.averaged import ANSWER, CHECK, Averaged
from contact.plane.fixed_steps import FixedSteps
from contact.plane.full_motion import FullMotion, motion_at_rest, with_heights
from contact.plane.plane_equations import Body
from contact.plane.plane_waves import Surface, SurfaceWaves, surface_under
from contact.plane.scaling import FREE, averaging_error, refuse_slow_beat, resonance_ratios, scaled
from contact.plane.steady_state import refuse
from contact.plane.trajectory import PlaneTrajectory
from contact.slider import Slider

METHODS = ("auto", "exact", "stepped", "averaged")
# Nodes and tolerance of the exact motion and of the one that it is compared with, which differs in both, by the
# tolerance of the answer down to which they serve
EXACT = {
    1e-3: ((4, 3e-3), (3, 1e-2)),
    1e-5: ((5, 1e-3), (4, 1e-3)),
    1e-6: ((5, 1e-4), (4, 1e-4)),
    0.0: ((6, 1e-6), (5, 1e-5)),
}
STEPS = {1e-2: (192, 128), 1e-3: (768, 512), 0.0: (3072, 2048)}  # per cycle of the fastest wave
# Error over the correction by Richardson's extrapolation, 0.006 to 1.3 in tests/contact/test_plane_motion.py, where
# contacts stick at the touch; a component is not known better than half of the other one
LEFT = 1.0
MOVED = 5e-6  # m: way of a contact after which the waves under it are taken anew
MAX_EXACT = 20_000  # cycles of the fastest wave up to which `auto` follows the events: 0.2 ms each for a contact


def burst(
    slider: Slider, surface: Surface, *, duration: float, after: float, tolerance: float, samples: int,
    method: str = "auto", rise_time: float = 0.0,
) -> PlaneTrajectory:  # fmt: skip
    """Return the motion from rest during a burst and after it.

    Parameters
    ----------
    slider, surface
        As for `steady`. On a field the waves are followed: those under a contact are taken anew when it has moved by
        5 um or turned that far. A motion given at the contacts alone stays the same.
    duration, after : float
        Length of the burst, and time followed after it, s.
    tolerance : float
        Allowed error of the speed at the end of the burst, relative to max(|V|, omega |u_t|/10).
    samples : int
        Number of instants recorded, evenly spaced.
    method : str
        "exact" (event by event), "stepped" (fixed steps), "averaged", or "auto".
    rise_time : float
        Time constant of the waves' rise, 1 - exp(-t/rise_time), and of their fall after the burst, s.

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
    for name, value in (("after", after), ("rise_time", rise_time)):
        parameter_check.non_negative(name, value, "s")
    parameter_check.count("samples", samples, 1)
    parameter_check.choice("method", method, METHODS)
    refuse(slider)
    refuse_infinite_mass(slider)
    waves = surface_under(slider, surface)
    at = np.linspace(0.0, duration + after, samples + 1)[1:]
    if 0.0 < after:
        at = np.union1d(at, [duration])
    question = _Question(slider, surface, waves, at, duration, rise_time, tolerance)
    if method == "auto":
        cycles = (duration + after) * waves.omega / (2.0 * math.pi)
        method = "exact" if cycles * waves.count <= MAX_EXACT else "averaged"
    found = {"exact": _exact, "stepped": _stepped, "averaged": _averaged}[method](question)
    return _answered(question, method, found, begun)


class _Question:
    """What every method takes."""

    def __init__(self, slider, surface, waves, at, duration, rise_time, tolerance):
        self.slider, self.surface, self.waves, self.at = slider, surface, waves, at
        self.duration, self.rise_time, self.tolerance = duration, rise_time, tolerance
        arms = np.hypot(np.subtract(slider.x, slider.axis[0]), np.subtract(slider.y, slider.axis[1]))
        self.arm = float(np.max(arms)) if slider.freedom == "axle" else float(np.max(np.hypot(slider.x, slider.y)))

    @property
    def follows(self):
        """True if the waves under the contacts change with their place."""
        return not isinstance(self.surface, SurfaceWaves)

    def level(self, t):
        """Return the envelope at a time."""
        if self.rise_time == 0.0:
            return 1.0 if t <= self.duration else 0.0
        up = 1.0 - math.exp(-min(t, self.duration) / self.rise_time)
        return up * math.exp(-max(t - self.duration, 0.0) / self.rise_time)

    def speed(self, rates):
        """Return |V|, or the speed of the farthest contact of an axle."""
        return abs(rates[2]) * self.arm if self.slider.freedom == "axle" else float(np.hypot(*rates[:2]))


def _answered(question, method, found, begun):
    time_at, pose, rates, height, error, ledger, reason, statistics = found
    end = int(np.searchsorted(question.at, question.duration * (1.0 - 1e-12)))
    speed = question.speed(rates[min(end, len(rates) - 1)])
    reference = speed_scale(speed, question.waves.peak_speed)
    size = error[2] * question.arm if question.slider.freedom == "axle" else float(np.hypot(*error[:2]))
    answer = Answer(value=speed, error=size, reasons=(reason,)).judged(question.tolerance, reference)
    return PlaneTrajectory(
        answer=answer, time=time_at, pose=pose, rates=rates, height=height, error=error, ledger=ledger, method=method,
        statistics=statistics, seconds=time.perf_counter() - begun,
    )  # fmt: skip


def _levels(table, tolerance):
    return next(pair for level, pair in table.items() if tolerance >= level)


def _exact(question):
    """Two motions that differ in the order of collocation and in its tolerance; finer ones where one does not converge.

    The coarsest fail in one of a thousand drawn motions.
    """
    pairs = [pair for level, pair in EXACT.items() if question.tolerance >= level]
    for k, (fine, coarse) in enumerate(pairs):
        try:
            (pose, rates, height, motion), (_, rough, _, _) = (_exact_run(question, how) for how in (fine, coarse))
            break
        except ConvergenceError:
            if k == len(pairs) - 1:
                raise
    error = np.abs(rates - rough).max(axis=0) + 1e-12 * np.abs(rates).max(axis=0)
    names = {"segments": int(motion.state.total[2]), "trials": int(motion.state.total[3])}
    return question.at, pose, rates, height, error, motion.ledger(), "event by event in the plane", names


def _exact_run(question, how):
    begun = motion_at_rest(
        question.slider, question.waves, how, rise=question.rise_time, stop=question.duration
    )  # fmt: skip
    return _followed(question, begun)


def _stepped(question):
    """Fixed steps of two sizes."""
    fine, coarse = _levels(STEPS, question.tolerance)
    units = scaled(
        question.slider, question.waves, heavy=False, rise=question.rise_time,
        stop=question.duration if question.rise_time > 0.0 else math.inf, commensurable=False,
    )  # fmt: skip
    units = with_heights(question.slider, question.waves, units)
    (pose, rates, height, _), (rough_pose, rough, _, _) = (
        _followed(question, FixedSteps.at_rest(units, steps)) for steps in (fine, coarse)
    )
    # first order: Richardson's extrapolation, of whose correction a share is left
    correction = (rates - rough) / (fine / coarse - 1.0)
    pose, rates = pose + (pose - rough_pose) / (fine / coarse - 1.0), rates + correction
    error = LEFT * np.abs(correction).max(axis=0) + 1e-12 * np.abs(rates).max(axis=0)
    error[:2] = np.maximum(error[:2], 0.5 * error[:2].max())
    reason = f"{coarse} and {fine} fixed steps per cycle, extrapolated"
    return question.at, pose, rates, height, error, None, reason, {"steps": fine}


def _followed(question, motion: FullMotion):
    """Return (pose, rates, height, motion) of a motion at the instants asked for."""
    units, k = motion.units, len(question.at)
    pose, rates, height = np.zeros((k, 3)), np.zeros((k, 3)), np.zeros(k)
    place, cycle = np.zeros(3), 2.0 * math.pi
    stop, silent = question.duration * units.omega, question.rise_time > 0.0
    for j, t in enumerate(question.at):
        until = t * units.omega
        while motion.state.total[0] < until - 1e-12:
            here = motion.state.total[0]
            to = min(until, stop) if here < stop - 1e-12 else until
            if question.follows:
                # so that the waves change in small steps
                speed = max(np.abs(motion.state.p[1:3]).max(), abs(motion.state.p[3]) * question.arm / units.length)
                to = min(to, here + max(cycle, MOVED / units.length / max(speed, 1e-300)))
            motion.follow(to)
            if not silent and motion.state.total[0] >= stop - 1e-12:
                motion, silent = motion.silenced(), True
            if question.follows and not (silent and question.rise_time == 0.0):
                now = _pose(motion)
                if np.abs(now - place)[:2].max() > MOVED or abs(now[2] - place[2]) * question.arm > MOVED:
                    motion, place = _on_waves_at(question, motion, now), now
        pose[j], rates[j] = _pose(motion), motion.state.p[1:] * [units.speed, units.speed, units.omega]
        height[j] = motion.state.q[Body.HEIGHT] * units.length
    return pose, rates, height, motion


def _pose(motion):
    return motion.state.q[1:] * [motion.units.length, motion.units.length, 1.0]


def _on_waves_at(question, motion, pose):
    """Return the motion on the waves at another pose."""
    waves = surface_under(question.slider, question.surface, pose)
    length = motion.units.length
    problem = motion.units.problem._replace(
        cos=np.ascontiguousarray(waves.amplitudes.real / length),
        sin=np.ascontiguousarray(-waves.amplitudes.imag / length),
    )
    return replace(motion, units=motion.units._replace(problem=problem))


def _averaged(question):
    """The averaged equations of velocity and yaw rate, twice with means that differ."""
    slider = question.slider
    refuse_slow_beat(slider, question.waves)
    (pose, rates, height, calls), (_, rough, _, _) = (
        _averaged_run(question, how, max(0.1 * question.tolerance * factor, 1e-9))
        for how, factor in ((ANSWER, 1.0), (CHECK, 10.0))
    )
    ratio, _ = resonance_ratios(slider, question.waves)
    by_averaging = averaging_error(slider, question.waves)
    error = np.abs(rates - rough).max(axis=0) + by_averaging * np.abs(rates).max(axis=0)
    # the height comes to its mean within a bounce, through which the force differs by up to its size
    start = np.abs(np.diff(rates, axis=0, prepend=0.0) / np.diff(question.at, prepend=0.0)[:, None]).max(axis=0)
    error += start / (ratio * question.waves.omega)
    statistics = {"evaluations": calls}
    return question.at, pose, rates, height, error, None, "averaged motion in the plane", statistics


def _averaged_run(question, how, relative):
    slider = question.slider
    units = scaled(slider, question.waves, heavy=False)
    inverse = units.problem.inverse[1:]
    free, calls, kept = np.array(FREE[slider.freedom]), [0], {}

    def averaged_at(t, pose):
        level = question.level(t)
        place = tuple(np.round(pose / [MOVED, MOVED, MOVED / max(question.arm, 1e-12)])) if question.follows else ()
        if (level, place) not in kept:
            kept.clear()
            waves = surface_under(slider, question.surface, pose).scaled(level)
            made = Averaged.of(slider, waves)
            made.deformation = kept.get("deformation", made.deformation)
            kept[level, place] = made
        return kept[level, place]

    def acceleration(t, y):
        pose, rates = y[:3], y[3:]
        averaged = averaged_at(t, pose)
        own = averaged.scaled
        unknown = rates / [own.speed, own.speed, own.omega / averaged.arm]
        means = averaged.at(unknown, how)
        calls[0] += 1
        if not means.repeats:
            raise ConvergenceError("not applicable", 'a contact keeps its deformation: method = "exact"')
        left = means.force - averaged.load - averaged.damping * unknown
        change = np.zeros(3)
        change[free] = left[free]
        forces = change * own.force * np.array([1.0, 1.0, averaged.arm * own.length])
        return np.concatenate([rates, forces / masses])

    mass = slider.unit_mass
    masses = np.array([mass, mass, slider.inertia or math.inf])
    masses[inverse == 0.0] = math.inf
    scale = question.waves.peak_speed
    smallest = relative * np.array(
        [scale * question.at[-1]] * 2 + [1.0] + [scale] * 2 + [scale / max(question.arm, 1e-12)]
    )
    y, t, rows = np.zeros(6), 0.0, []
    height = []
    slow = np.maximum(smallest[3:], 1e-6 * scale * np.array([1.0, 1.0, 1.0 / max(question.arm, 1e-12)]))

    def stops(t, y):
        return float(np.abs(y[3:] / slow).max()) - 1.0

    stops.terminal, stops.direction = True, -1
    for end in question.at:
        coasts = t >= question.duration * (1.0 - 1e-12) and question.level(end) == 0.0
        if coasts and stops(t, y) <= 0.0:
            y, found = np.append(y[:3], np.zeros(3)), None
        else:
            found = solve_ivp(
                acceleration, (t, end), y, method="RK45", rtol=max(relative, 1e-9), atol=smallest,
                events=stops if coasts else None,
            )  # fmt: skip
        if found is None:
            t = end
            rows.append(y)
            height.append(height[-1])
            continue
        if not found.success or not np.isfinite(found.y).all():
            raise ConvergenceError("not converged", "the averaged motion in the plane was not followed; method exact")
        y, t = found.y[:, -1], end
        rows.append(y)
        averaged = averaged_at(t, y[:3])
        height.append(float(averaged.height.mean()) * averaged.scaled.length)
    table = np.array(rows)
    return table[:, :3], table[:, 3:], np.array(height), calls[0]
