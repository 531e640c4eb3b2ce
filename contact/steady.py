r"""The steady velocity: the periodic motion itself, found without waiting for it.

Two steps. *Averaged*: a slider that is heavy on the wave's time scale keeps height h and velocity v through a cycle;
h follows from <sum P_i> = preload and v from <sum Q_i>(v) = R_t v + load, with the cycle mean between exact events.
*Exact*: the map of one whole cycle of the full equations, (z_s, z_s', v, x_i) -> the same a cycle later, is brought to
its fixed point by Newton's method from the averaged state. The first differs from the second by O((f_n/f)^2).

Held: if one contact can stick for good, the deformations that the wave drives them to (from above and from below)
leave a whole interval of mean tractions. If load lies in it the slider stays, and its velocity is exactly zero.
"""

import math
import time
from dataclasses import dataclass

import numpy as np

from contact import bounds
from contact.convergence import ConvergenceError
from contact.limits import riding_height
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

METHODS = ("auto", "exact", "averaged")


@dataclass(frozen=True, kw_only=True)
class SteadyState:
    """The periodic motion of a slider on a continuous wave.

    Attributes
    ----------
    slider, orbits
        What was asked.
    velocity : float
        Mean over a cycle, m/s; exactly 0 when held.
    regime : str
        "stick", "slip" or "intermittent".
    relative_error : float
        Estimated error of velocity over max(|v|, omega |u_x|/10), from two computed answers.
    height : float
        Mean approach h of the contacts, m; the slider's mean position is -h.
    status, message : str
        "ok", or what is to be known about the answer, and a sentence.
    method : str
        What was used: "exact" or "averaged".
    statistics : dict
        Events by kind in one cycle; stretches, sweeps and cycles computed; multipliers of the cycle map.
    seconds : float
        Time taken.
    """

    slider: Slider
    orbits: tuple[Orbit, ...]
    velocity: float
    regime: str
    relative_error: float
    height: float
    status: str
    message: str
    method: str
    statistics: dict
    seconds: float


def steady(
    slider: Slider, orbits: Orbit | tuple[Orbit, ...], *, tolerance: float, method: str = "auto"
) -> SteadyState:
    """Return the steady state.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact.
    tolerance : float
        Error allowed in the velocity, relative to max(|v|, omega |u_x|/10).
    method : str
        "exact", "averaged", or "auto".

    Returns
    -------
    SteadyState
        With the error estimated; its status says when the estimate exceeds the tolerance.

    Raises
    ------
    ValueError
        For a law that is not available.
    ConvergenceError
        Status "runaway" (nothing balances the load), "unstable" (no stable motion repeats with the wave's period),
        or what the motion ran into.
    """
    begun = time.perf_counter()
    listed = as_orbits(orbits)
    bounds.positive("tolerance", tolerance, "")
    bounds.choice("method", method, METHODS)
    _available(slider)
    trivial = _without_traction(slider, listed)
    if trivial is None:
        trivial = _Search(slider, listed, tolerance).answer(method)
    return SteadyState(slider=slider, orbits=listed, seconds=time.perf_counter() - begun, **trivial)


def reference_speed(velocity: float, orbits: tuple[Orbit, ...]) -> float:
    """Return max(|v|, omega |u_x|/10) in m/s, the measure of velocity errors."""
    return max(abs(velocity), max(o.omega * abs(o.tangential) for o in orbits) / 10.0)


def drive_direction(orbits: tuple[Orbit, ...]) -> float:
    """Return +1 or -1, the direction in which the crests drive an unloaded slider (+1 if neither)."""
    return -1.0 if sum(orbit.crest_velocity for orbit in orbits) < 0.0 else 1.0


def _available(slider):
    if slider.law != "elastic":
        raise ValueError(f'slider.law "{slider.law}" is not available yet, only "elastic" is')
    if slider.reciprocal:
        raise ValueError("slider.reciprocal = true is not available yet, only false is")


def _without_traction(slider, orbits):
    """Return the answer where no wave or no friction force drives the slider, else None."""
    direction = drive_direction(orbits)
    friction = slider.friction_coefficient * slider.preload
    still = all(orbit.normal == 0 and orbit.tangential == 0 for orbit in orbits)
    if not still and friction > 0.0:
        return None
    height = slider.rest_approach(len(orbits)) if still else riding_height(slider, orbits)
    parted = any(abs(orbit.normal) > height for orbit in orbits)
    regime = "stick" if still and slider.load <= friction else "intermittent" if parted else "slip"
    velocity = 0.0
    if slider.load > friction:
        if slider.tangential_damping == 0.0:
            raise ConvergenceError(
                "runaway",
                f"a load of {slider.load:.6g} N exceeds the friction limit {friction:.6g} N and no tangential damping "
                "bounds the speed; lower slider.load or give slider.damping.tangential",
            )
        velocity = -direction * (slider.load - friction) / slider.tangential_damping
    why = "no wave" if still else "no friction force" if slider.friction_coefficient == 0.0 else "no preload"
    return {
        "velocity": velocity, "regime": regime, "relative_error": 0.0, "height": height, "status": "ok",
        "message": f"{why}: closed form", "method": "exact", "statistics": {},
    }  # fmt: skip


class _Search:
    """The search for one steady state: holds the scaled problem and counts the work."""

    def __init__(self, slider, orbits, tolerance):
        from contact import scaling
        from contact.motion import Motion

        self.slider, self.orbits, self.tolerance = slider, orbits, tolerance
        self.Motion, self.scaling = Motion, scaling
        # phase 0 at the trough of the first contact: there it is parted or slips, and old deformation is forgotten
        self.start = math.pi - float(np.angle(orbits[0].normal)) if orbits[0].normal != 0 else 0.0
        self.direction = drive_direction(orbits)
        self.work = np.zeros(10, np.int64)
        self.problem = self._scaled(self.direction)
        self.h = riding_height(slider, orbits) / self.problem.length

    def _scaled(self, direction):
        return self.scaling.scaled(self.slider, self.orbits, direction=direction, start=self.start)

    def _frozen(self, speed, deformations, nodes=16):
        """Return (<sum Q>, motion after a repeating cycle) at constant height and velocity."""
        motion = self.Motion(self.problem, nodes=nodes, tolerance=1e-12)
        motion.place(-self.h, 0.0, speed, deformations)
        for _ in range(6):
            before = motion.state[3:].copy()
            motion.tally[:], motion.sums[:] = 0, 0.0
            motion.turn(1, mobile=False)
            self.work += motion.tally
            motion.tally[9] = 1
            if np.max(np.abs(motion.state[3:] - before)) < 1e-13:
                break
            motion.place(-self.h, 0.0, speed, motion.state[3:])
        return motion.sums[0] / (2.0 * math.pi), motion

    def answer(self, method):
        slider, problem = self.slider, self.problem
        reach = 10.0 * (1.0 + abs(self.h)) * (1.0 + problem.parameters[7])
        low, low_motion = self._frozen(0.0, -reach)
        high, high_motion = self._frozen(0.0, reach)
        scale = problem.parameters[6] * problem.parameters[3]
        load = problem.parameters[5]
        if low > load + 1e-13 * scale:
            way = 1.0
        elif high < load - 1e-13 * scale:
            way = -1.0
        else:
            return self._held(scale, 0.5 * (low_motion.state[3:] + high_motion.state[3:]))
        # the load opposes the unloaded motion: turn it round if the crests point the other way
        if slider.load > 0.0 and (low + high) * self.direction < 0.0:
            self.direction = -self.direction
            self.problem = problem = self._scaled(self.direction)
            load = problem.parameters[5]
            way = 1.0 if low > load else -1.0 if high < load else 0.0
            if way == 0.0:
                return self._held(scale, 0.5 * (low_motion.state[3:] + high_motion.state[3:]))
        speed, slope, motion = self._balance(way, low if way > 0 else high, load)
        averaged = speed * problem.speed
        fine, multipliers, fine_motion = self._periodic(motion, speed, slope, nodes=16, tolerance=1e-12)
        coarse, _, _ = self._periodic(
            fine_motion.copy(), None, slope, nodes=11, tolerance=1e-9, jacobian=self.jacobian
        )
        velocity = fine * problem.speed
        reference = reference_speed(velocity, self.orbits)
        statistics = self._statistics(fine_motion, multipliers)
        statistics["averaged_velocity"] = float(averaged)
        error = abs(fine - coarse) * problem.speed / reference
        used, note = "exact", "periodic motion of the full equations"
        if method == "averaged":
            error = abs(averaged - velocity) / reference
            used, note, velocity = "averaged", "cycle mean at constant height and velocity", averaged
        status = "ok"
        if np.max(np.abs(multipliers)) > 1.0 + 1e-6:
            raise ConvergenceError(
                "unstable",
                f"the motion that repeats with the wave's period is unstable (multiplier {np.max(np.abs(multipliers)):.6g}): "
                "the slider hops; add slider.damping.normal or follow a burst with method exact",
            )
        if error > self.tolerance:
            status, note = (
                "above tolerance",
                f"{note}; estimated error {error:.2g} exceeds {self.tolerance:.2g}",
            )
        if slider.normal_damping == 0.0 and slider.contact_damping == 0.0:
            note += "; without normal damping the bounce of a real start would not die out"
        regime = "intermittent" if statistics["release"] else "slip"
        return {
            "velocity": float(velocity), "regime": regime, "relative_error": float(error), "height": -float(fine_motion.height) * problem.length,
            "status": status, "message": note, "method": used, "statistics": statistics,
        }  # fmt: skip

    def _statistics(self, motion, multipliers):
        statistics = motion.events()
        for name, number in zip(("stretches", "halvings", "sweeps"), self.work[6:9], strict=True):
            statistics[name] = int(number)
        statistics["cycles"] = int(self.work[9])
        statistics["multipliers"] = tuple(complex(m) for m in multipliers)
        return statistics

    def _held(self, scale, deformations):
        """Return the answer of a slider that a sticking contact holds; its error is the averaging's near the edge."""
        _, motion = self._frozen(0.0, deformations)
        frequency_ratio = self.slider.normal_resonance(len(self.orbits)) / self.orbits[0].frequency
        tally = motion.events()
        note = "held by friction"
        regime = "intermittent" if tally["release"] else "slip" if tally["stick_to_slip"] else "stick"
        # just above the threshold: what the velocity would be if averaging had misjudged the amplitude
        grown = tuple(orbit.scaled(1.0 + min(12.0 * frequency_ratio**2, 0.5)) for orbit in self.orbits)
        probe = _Search(self.slider, grown, self.tolerance)
        lowest, _ = probe._frozen(0.0, -10.0 * (1.0 + abs(probe.h)))
        highest, _ = probe._frozen(0.0, 10.0 * (1.0 + abs(probe.h)))
        edge = probe.problem.parameters[5]
        mean = 0.0
        if lowest > edge + 1e-13 * scale or highest < edge - 1e-13 * scale:
            way = 1.0 if lowest > edge else -1.0
            speed, _, _ = probe._balance(way, lowest if way > 0 else highest, edge)
            mean = abs(speed) * probe.problem.speed
        statistics = self._statistics(motion, ())
        return {
            "velocity": 0.0, "regime": regime, "relative_error": float(mean) / reference_speed(0.0, self.orbits),
            "height": self.h * self.problem.length, "status": "ok", "message": note, "method": "averaged",
            "statistics": statistics,
        }  # fmt: skip

    def _balance(self, way, traction, load):
        """Return (v, d<sum Q>/dv, motion) at <sum Q>(v) = d_t v + load; v has the sign `way`."""
        d_t = self.problem.parameters[4]
        top = 1.05 * max(float(np.hypot(*wave[2:])) for wave in self.problem.waves)
        a, fa = 0.0, traction - load
        b = way * top
        fb, motion = self._frozen(b, 0.0)
        fb -= d_t * b + load
        for _ in range(60):
            if fb * way < 0.0:
                break
            b *= 2.0  # a load that drags the slider backwards is only bounded by the damper
            fb, motion = self._frozen(b, 0.0)
            fb -= d_t * b + load
            if abs(b) > 1e6 * top and d_t == 0.0:
                break
        if fb * way >= 0.0:
            raise ConvergenceError(
                "runaway",
                "friction cannot balance the load at any speed; lower slider.load or give a tangential damper",
            )
        for count in range(80):
            v = b - fb * (b - a) / (fb - fa)
            if count % 4 == 3 or not min(a, b) < v < max(a, b):
                v = 0.5 * (a + b)
            f, motion = self._frozen(v, motion.state[3:])
            f -= d_t * v + load
            if (f > 0.0) == (fb > 0.0):
                slope = (f - fb) / (v - b) if v != b else 0.0
                b, fb, fa = v, f, 0.5 * fa
            else:
                slope = (f - fa) / (v - a) if v != a else 0.0
                a, fa, fb = v, f, 0.5 * fb
            if f == 0.0 or abs(b - a) < 1e-12 * top or abs(f) < 1e-13 * abs(traction):
                break
        return v, slope, motion

    def _periodic(self, motion, speed, slope, *, nodes, tolerance, jacobian=None):
        """Return (mean v, multipliers of the cycle map, motion after its last cycle)."""
        moving = self.Motion(self.problem, nodes=nodes, tolerance=tolerance)
        if speed is None:
            y, x = motion.fixed.copy(), motion.state[3:].copy()
        else:
            y, x = np.array([-self.h, 0.0, speed]), motion.state[3:].copy()

        def cycle(at, x):
            moving.tally[:], moving.sums[:] = 0, 0.0
            moving.place(*at, x)
            moving.turn(1)
            self.work[:] += moving.tally
            return moving.state[:3].copy(), moving.state[3:].copy()

        if jacobian is None:
            _, x = cycle(y, x)
            base, _ = cycle(y, x)
            jacobian = np.empty((3, 3))
            steps = (1e-7, 1e-7 * max(1e-2, self.problem.parameters[9]), 1e-7)
            for k, step in enumerate(steps):
                near = y.copy()
                near[k] += step
                _, x_near = cycle(near, x)
                jacobian[:, k] = (cycle(near, x_near)[0] - base) / step
            self.jacobian = jacobian
        matrix = jacobian - np.eye(3)
        least = math.inf
        for count in range(40):
            after, x_after = cycle(y, x)
            residual = after - y
            step = -np.linalg.solve(matrix, residual)
            size = float(np.max(np.abs(step))) + float(np.max(np.abs(x_after - x)))
            mean = moving.sums[2] / (2.0 * math.pi)
            if size < 2e-13 or (count > 3 and size >= least and least < 1e-10):
                break
            least = min(least, size)
            y, x = y + step, x_after
        else:
            raise ConvergenceError(
                "not converged",
                f"the cycle map's fixed point was not reached (last step {size:.2g}); follow a burst instead",
            )
        moving.fixed, moving.height = y, y[0]
        moving.state[3:] = x
        return mean, np.linalg.eigvals(jacobian), moving
