r"""Motion of a heavy slider on balls with adhesion that hold on beyond z = 0, of first order.

A ball of Johnson, Kendall and Roberts (`law.adhesion`) closes at z = 0 and opens where dz/da = 0, at a negative
approach; one of Maugis (`law.maugis`) closes where the attraction begins and opens there or as a point. A heavy slider
prescribes z = h + u_z. Closed, the contact has the radius a(z) and with it the elastic, repulsive part
K delta^(3/2) of its force, delta = a^2/R, from which its slip limit c delta and its friction follow:

    Q = mu K (delta^(3/2) - (delta - |x|/c)^(3/2)) sign x,      |x| <= c delta                                  (1)

(`law.elastic`, with delta in the place of z). It closes without deformation; what its spring holds when it opens is
lost, and so is the work of the normal force around both branches, `AdhesiveSphere.loss`, in every hop.

All balls have one mean approach h, which follows from <sum P> = F; of several the largest, which a slider from rest
keeps. v follows from <sum Q> = load + R_t v. The slider rests where the deformations that do not slip hold the load.
Phases between closing and opening are phi = phi_1 + (phi_2 - phi_1)(1 - cos theta)/2 with Gauss's points in theta,
which takes out the square root with which a(z) ends; the error is that against half as many steps.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, lru_cache

import numpy as np

from contact import parameter_check
from contact.choice import Answer
from contact.error_estimate import reference_speed
from contact.exceptions import RUNAWAY, ConvergenceError, InputError
from contact.jit.compiled import native
from contact.law.adhesion import AdhesiveSphere
from contact.law.maugis import MaugisSphere
from contact.law.sphere_limits import DISTANCE
from contact.orbit import Orbit, as_orbits, drive_direction
from contact.problem import load_direction
from contact.roots import bracketed
from contact.slider import Slider

STEPS = 256  # of a cycle, of the first answer
DOUBLINGS = 9  # at most
PANEL = 16  # Gauss's points of each part of a contact
# Error over the largest change: of 92 drawn balls 87 held twice the change itself, 91 four times that; of 80 others 79
# held their stated error and all twice that (`tests/benchmarks/adhesive_error.py`).
SAFETY = 4.0
CLOSE = 1e-12  # of heights and velocities over their range
REPEATS = 1e-12  # change of a deformation from one cycle to the next over the largest, at which it repeats
STARTS = 1e-9  # drive over the friction, from which on a slider moves
SCAN = 32  # factors up to a crossing at which an earlier one is looked for; one ball has it at most once
FAR = 1e3  # factor on the orbits above which a limit counts as infinite


@dataclass(frozen=True)
class AdhesiveMotion:
    """Steady motion of a heavy slider on adhesive balls.

    Attributes
    ----------
    velocity : Answer
        m/s, with the error of the steps.
    height : float
        Mean approach h, m.
    hops : bool
        Whether a ball leaves the surface in every cycle.
    lost_power : float
        Power lost by closing and opening, W: of the normal forces around both branches; 0 without hops.
    normal_power, tangential_power : float
        Work of the surface's normal and tangential motion on the balls, W, by cycle means. The first is what closing
        and opening lose; the second is what the slider takes, and friction and the springs of opened contacts lose.
    """

    velocity: Answer
    height: float
    hops: bool
    lost_power: float
    normal_power: float
    tangential_power: float

    @property
    def regime(self) -> str:
        """Stick, slip, or intermittent: a ball leaves the surface in every cycle."""
        return "stick" if self.velocity.value == 0.0 else "intermittent" if self.hops else "slip"


@dataclass(frozen=True)
class _Cycle:
    """One cycle of a contact while it is closed, counted from the crest of its u_z."""

    phases: np.ndarray  # of the nodes
    before: float  # phase at which it closed, or that of the last node a cycle earlier
    weights: np.ndarray  # of a mean over the cycle
    radii: np.ndarray  # m
    forces: np.ndarray  # N
    hops: bool


@cache
def _gauss(steps: int) -> tuple[np.ndarray, np.ndarray]:
    """Return nodes and weights in theta from 0 to pi, rising."""
    nodes, weights = np.polynomial.legendre.leggauss(PANEL)
    width = math.pi * PANEL / steps
    starts = width * np.arange(steps // PANEL)
    return (starts[:, None] + 0.5 * width * (1.0 + nodes)).ravel(), np.tile(0.5 * width * weights, steps // PANEL)


def _cycle(ball, h: float, size: float, steps: int) -> _Cycle | None:
    """Return the cycle at a mean approach, of z = h + size cos(phase); None where the contact never closes."""
    lowest, makes = ball.break_approach, ball.make_approach
    hops = h - size < lowest
    if hops:
        if h + size <= makes:
            return None
        start, stop = -math.acos(max((makes - h) / size, -1.0)), math.acos((lowest - h) / size)
        theta, gauss = _gauss(steps)
        half = 0.5 * (stop - start)
        phases, weights, before = (
            start + half * (1.0 - np.cos(theta)),
            half * np.sin(theta) * gauss / (2 * math.pi),
            start,
        )
    else:
        phases, weights = 2.0 * math.pi * np.arange(steps) / steps, np.full(steps, 1.0 / steps)
        before = phases[-1] - 2.0 * math.pi
    radii, forces = ball.closed(np.maximum(h + size * np.cos(phases), lowest))
    return _Cycle(phases, before, weights, radii, forces, hops)


@native(
    "f1 f1 f1 f1 f1 f f f f1 f1 f2",
    {"delta": "k", "weights": "k", "along": "n", "phases": "n", "rate": "k", "slips": "m", "starts": "m", "out": "m 2"},
)
def mean_stops(delta, weights, along, phases, rate, hops, slope, repeats, slips, starts, out):
    """Write the means of q = Q/(mu K) and of q times a rate over a cycle of a stop at several velocities; equation (1).

    Its limit is `slope` times `delta`. ``along`` and ``phases``: u_x of the surface at the nodes, and before at the one
    before the first. ``slips``: the velocities over omega; ``starts``: the deformations before the first node. One that
    does not hop is followed until its deformation repeats to ``repeats``, 400 cycles at most.
    """
    for j in range(slips.size):
        x = starts[j]
        for _ in range(0 if hops > 0.0 else 400):
            begin = x
            for k in range(delta.size):
                limit = slope * delta[k]
                x += along[k + 1] - along[k] - slips[j] * (phases[k + 1] - phases[k])
                x = min(max(x, -limit), limit)
            if abs(x - begin) <= repeats:
                break
        total, work = 0.0, 0.0
        for k in range(delta.size):
            limit = slope * delta[k]
            x += along[k + 1] - along[k] - slips[j] * (phases[k + 1] - phases[k])
            x = min(max(x, -limit), limit)
            left = max(delta[k] - abs(x) / slope, 0.0)
            force = delta[k] * np.sqrt(delta[k]) - left * np.sqrt(left)
            signed = weights[k] * (force if x > 0.0 else -force)
            total += signed
            work += rate[k] * signed
        out[j, 0], out[j, 1] = total, work
    return 0


class AdhesiveBalls:
    """A heavy slider on equal balls with adhesion.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, load and tangential damping are used. The load opposes the motion
        of the unloaded slider.
    work : float
        Work of adhesion w, J/m^2, positive.
    model : str
        "JKR", "Maugis" or "DMT".
    separation : float
        Equilibrium separation of the surfaces, m, positive; of "Maugis" alone.

    Examples
    --------
    >>> from contact import Orbit, Slider
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> balls = AdhesiveBalls(ball, work=0.05, model="JKR")
    >>> wave = Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.67e-9j)
    >>> print(f"starts at {balls.threshold(wave):.4f} nm, leaves the surface at {balls.release(wave):.4f} nm")
    starts at 1.4277 nm, leaves the surface at 5.6960 nm
    """

    def __init__(self, slider: Slider, *, work: float, model: str, separation: float = DISTANCE):
        where = ", on balls with adhesion"
        slider.refuse_other_laws(where)
        if slider.shape != "sphere" or slider.radius is None or slider.normal_law is not None or not slider.even:
            raise InputError("slider", f"must stand on equal smooth balls with a radius{where}")
        if not slider.level:
            raise InputError("slider.heights", f"must all be 0{where}, and the curvature too")
        parameter_check.positive("slider.preload", slider.preload, "N")
        parameter_check.positive("slider.friction_coefficient", slider.friction_coefficient, "")
        radius, modulus = float(np.max(slider.radius)), slider.effective_modulus
        self.ball: MaugisSphere | AdhesiveSphere
        if model == "Maugis":
            self.ball = MaugisSphere(radius=radius, modulus=modulus, work=work, separation=separation)
        else:
            self.ball = AdhesiveSphere(radius=radius, modulus=modulus, work=work, model=model)
        self.slider, self.model = slider, model

    def motion(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> AdhesiveMotion:
        """Return the steady motion on the orbits of the balls.

        ``tolerance``: of the velocity, relative to it or to omega |u_x|/10 where that is larger.
        """
        parameter_check.positive("tolerance", tolerance, "")
        waves = _listed(orbits)
        reference = reference_speed(0.0, waves)
        values: list[float] = []
        error, changed = math.inf, 0.0
        for doubling in range(DOUBLINGS + 1):
            height, cycles = self._riding(waves, STEPS * 2**doubling)
            values.append(self._velocity(waves, cycles))
            if doubling:
                # of second order; where slip begins between two nodes decides, so that the change of one doubling may
                # be small by accident: a quarter of that before counts as well, and so on
                changed = max(abs(values[-1] - values[-2]), changed / 4.0)
            if doubling > 1:
                error = SAFETY * changed
                if error <= tolerance * max(abs(values[-1]), reference):
                    break
        answer = Answer(value=values[-1], error=error, reasons=(f"cycle means of first order, model {self.model}",))
        hopping = sum(each is not None and each.hops for each in cycles)
        judged = answer.judged(tolerance, max(abs(values[-1]), reference) or 1.0)
        return AdhesiveMotion(
            velocity=judged, height=height, hops=hopping > 0,
            lost_power=hopping * self.ball.loss * waves[0].frequency, normal_power=self._normal_power(waves, cycles),
            tangential_power=self._pull(waves, cycles, values[-1])[1],
        )  # fmt: skip

    def threshold(self, orbits: Orbit | Sequence[Orbit]) -> float:
        """Return the first factor on the orbits at which the slider starts to move, in either direction.

        It is zero if friction cannot hold the load, and infinite above a thousand.
        """
        listed, friction = _listed(orbits), self._friction
        if self.slider.load >= friction:
            return 0.0

        @cache
        def drives(factor):
            waves = tuple(each.scaled(factor) for each in listed)
            return [net - STARTS * friction for _, net in self._drives(waves, self._riding(waves, STEPS * 16)[1])]

        def margin(way):
            return lambda factor: drives(factor)[way]

        forward, back = map(margin, range(2))
        end = min(_rising(forward), _rising(back))
        if self.slider.load == 0.0 or math.isinf(end):
            return end
        # Friction holds least near the factor at which an unloaded slider starts, where the load moves it back. From
        # some larger factor on the wave may hold it again, or move it forward.
        factors = np.append(np.linspace(0.0, end, SCAN + 1), _rising(lambda factor: forward(factor) + self.slider.load))
        before = 0.0
        for factor in np.sort(factors[factors < end])[1:]:
            for way in (forward, back):
                if way(factor) > 0.0:
                    return bracketed(way, before, factor, tolerance=1e-12 * end)
            before = factor
        return end

    def release(self, orbits: Orbit | Sequence[Orbit]) -> float:
        """Return the factor on the orbits at which the first ball leaves the surface; infinite above a thousand."""

        def left(factor):
            waves = tuple(each.scaled(factor) for each in _listed(orbits))
            return self._mean(waves, self._closed(waves), STEPS) - self.slider.preload

        return _rising(left)

    def height(self, orbits: Orbit | Sequence[Orbit]) -> float:
        """Return the mean approach h of the balls on their orbits, m."""
        return self._riding(_listed(orbits), STEPS * 4)[0]

    def load_sign(self, orbits: Orbit | Sequence[Orbit]) -> float:
        """Return +1 if the load opposes motion in the direction in which the crests drive, -1 if in the other."""
        waves = _listed(orbits)
        return drive_direction(as_orbits(waves)) * self._drives(waves, self._riding(waves, STEPS * 16)[1])[0][0]

    def held_loads(self, orbits: Orbit | Sequence[Orbit]) -> tuple[float, float]:
        """Return the smallest and the largest load in N along -x under which the slider stays at rest."""
        waves = _listed(orbits)
        return self._held(waves, self._riding(waves, STEPS * 16)[1])

    def traction(self, orbits: Orbit | Sequence[Orbit], velocity: float) -> float:
        """Return the mean force in N along +x of the surface on a slider of a velocity in m/s."""
        waves = _listed(orbits)
        return self._pull(waves, self._riding(waves, STEPS * 16)[1], velocity)[0]

    def harmonics(self, orbits: Orbit | Sequence[Orbit], velocity: float) -> np.ndarray:
        """Return P_0, Q_0, P_1 and Q_1 of each ball in N at a velocity in m/s, complex, shape (4, n).

        The forces are P_0 + Re P_1 exp(i omega t), with the phase of the orbits' amplitudes. A ball that always sticks
        has the least deformation possible.
        """
        waves, found = _listed(orbits), []
        for wave, cycle in zip(waves, self._riding(waves, STEPS * 16)[1], strict=True):
            if cycle is None:
                found.append(np.zeros(4, complex))
                continue
            turn = wave.normal / abs(wave.normal) if wave.normal else 1.0
            first = 2.0 * turn * cycle.weights * np.exp(-1j * cycle.phases)
            (mean, cosine), (_, sine) = (
                self._means(wave, cycle, np.array([velocity]), np.zeros(1), factor)[0]
                for factor in (np.cos(cycle.phases), np.sin(cycle.phases))
            )
            along = 2.0 * turn * (cosine - 1j * sine)
            found.append(np.array([cycle.weights @ cycle.forces, mean, first @ cycle.forces, along]))
        return np.transpose(found)

    def repulsion(self, cycle: _Cycle) -> np.ndarray:
        """Return the elastic part of the forces of a cycle, which friction feels, N."""
        return self._stiffness * (cycle.radii**2 / self.ball.radius) ** 1.5

    def dragged(self, waves, cycles, velocities: np.ndarray) -> np.ndarray:
        """Return the mean forces in N of the surface at velocities in m/s; at 0.0 and -0.0 the limits of both sides."""
        return self._pulls(waves, cycles, velocities, -np.copysign(self._far(cycles), velocities))[:, 0]

    def _far(self, cycles) -> float:
        """Return a deformation in m beyond every limit of slip."""
        return self.slider.limit_slope * max(
            (float(each.radii.max()) for each in cycles if each is not None), default=0.0
        )

    @property
    def _stiffness(self) -> float:
        """K of a ball, N/m^1.5."""
        return 4.0 / 3.0 * self.ball.modulus * math.sqrt(self.ball.radius)

    @property
    def _friction(self) -> float:
        return self.slider.friction_coefficient * self.slider.preload

    def cycles(self, waves, h: float, steps: int) -> list:
        """Return the cycle of each ball at a mean approach in m; None where it never closes."""
        return [_cycle(self.ball, h, abs(each.normal), steps) for each in waves]

    def _mean(self, waves, h: float, steps: int) -> float:
        """Return the mean normal force of all balls in N."""
        cycles = self.cycles(waves, h, steps)
        return sum(float(each.weights @ each.forces) for each in cycles if each is not None)

    def _closed(self, waves) -> float:
        """Return the smallest mean approach at which no ball opens."""
        return max(self.ball.break_approach + abs(each.normal) * (1.0 + 1e-12) for each in waves)

    def _riding(self, waves, steps: int) -> tuple[float, list]:
        """Return the largest mean approach at which the mean force is the preload, and the cycles there.

        The mean force grows with the approach, but for a fall where a ball ceases to hop.
        """
        ball, preload = self.ball, self.slider.preload

        def left(h):
            return self._mean(waves, h, steps) - preload

        sizes = sorted({abs(each.normal) for each in waves}, reverse=True)
        edges = [ball.break_approach + each for each in sizes]
        high = edges[0] + sizes[0] + ball.approach_under(preload) - ball.break_approach
        for edge, size in zip(edges, sizes, strict=True):
            above, below = edge + size * 1e-12, edge - size * 1e-12
            if left(above) <= 0.0:
                height = bracketed(left, above, high, tolerance=CLOSE * (abs(high) + sizes[0]))
                return height, self.cycles(waves, height, steps)
            high = below
        low = ball.make_approach - sizes[0]
        height = bracketed(left, low, high, tolerance=CLOSE * (abs(high) + sizes[0]))
        return height, self.cycles(waves, height, steps)

    def _pull(self, waves, cycles, v: float) -> tuple[float, float]:
        """Return the mean friction of all balls in N at a velocity, and the work of the surface's motion in W."""
        ((pull, work),) = self._pulls(waves, cycles, np.array([v]), np.zeros(1)).tolist()
        return pull, work

    def _pulls(self, waves, cycles, velocities: np.ndarray, starts: np.ndarray) -> np.ndarray:
        """Return friction and work as `_pull` at velocities, from deformations `starts` in m; shape (m, 2)."""
        total = np.zeros((velocities.size, 2))
        for wave, cycle in zip(waves, cycles, strict=True):
            if cycle is not None:
                total += self._means(wave, cycle, velocities, starts)
        return total

    def _means(self, wave, cycle, velocities: np.ndarray, starts: np.ndarray, factor=None) -> np.ndarray:
        """Return the means of the friction of one ball, N, and of its product with a factor at the nodes, shape (m, 2).

        The factor is the surface's velocity in m/s where none is given.
        """
        c, answer, size = self.slider.limit_slope, np.zeros((velocities.size, 2)), abs(wave.normal)
        turned = wave.tangential * (size / wave.normal if size > 0.0 else 1.0)  # counted from the crest of u_z
        phases = np.concatenate([[cycle.before], cycle.phases])
        along = turned * np.exp(1j * phases)
        rate = (1j * wave.omega * along[1:]).real if factor is None else factor
        delta = cycle.radii**2 / self.ball.radius
        begins = np.zeros_like(starts) if cycle.hops else starts
        mean_stops(
            delta, cycle.weights, np.ascontiguousarray(along.real), phases, np.ascontiguousarray(rate),
            float(cycle.hops), c, REPEATS * c * float(delta.max()), velocities / wave.omega, begins, answer,
        )  # fmt: skip
        return self.slider.friction_coefficient * self._stiffness * answer

    def _normal_power(self, waves, cycles) -> float:
        """Return the mean of sum P du_z/dt, W."""
        return sum(
            -wave.omega * abs(wave.normal) * float(each.weights @ (each.forces * np.sin(each.phases)))
            for wave, each in zip(waves, cycles, strict=True)
            if each is not None
        )

    def _held(self, waves, cycles) -> tuple[float, float]:
        """Return the smallest and largest mean friction in N on a slider at rest."""
        far = self._far(cycles)
        lowest, highest = self._pulls(waves, cycles, np.zeros(2), np.array([-far, far]))[:, 0].tolist()
        return lowest, highest

    def _velocity(self, waves, cycles) -> float:
        """Return the velocity at which no mean force is left."""
        slider, c, omega = self.slider, self.slider.limit_slope, waves[0].omega
        drives = self._drives(waves, cycles)
        way, drive = max(drives, key=lambda each: each[1])
        if drive <= STARTS * self._friction:
            return 0.0
        load = drives[0][0] * slider.load
        deepest = max(float(each.radii.max()) for each in cycles if each is not None) ** 2 / self.ball.radius
        top = omega * (
            max(abs(each.tangential) for each in waves) + c * (max(abs(each.normal) for each in waves) + deepest)
        )

        def left(v):
            return way * drive if v == 0.0 else self._pull(waves, cycles, v)[0] - load - slider.tangential_damping * v

        if way * left(way * top) > 0.0:  # the load pulls harder than friction that slips everywhere
            if slider.tangential_damping == 0.0:
                raise ConvergenceError("runaway", RUNAWAY)
            top += abs(load) / slider.tangential_damping
        return bracketed(left, 0.0, way * top, tolerance=CLOSE * top)

    def _drives(self, waves, cycles) -> list[tuple[float, float]]:
        """Return for both directions the direction and the least net force in N in it on a slider at rest.

        The first direction is that of the slider without its load, which the load opposes (`load_direction`).
        """
        lowest, highest = self._held(waves, cycles)
        least = {1.0: lowest, -1.0: -highest}
        crest = drive_direction(as_orbits(waves))
        against = crest * load_direction(-least[-crest])
        return [(sign * against, least[sign * against] - sign * self.slider.load) for sign in (1.0, -1.0)]


def adhesive_motion(
    slider: Slider, orbits: Orbit | Sequence[Orbit], *, work: float, model: str = "JKR",
    separation: float = DISTANCE, tolerance: float = 1e-5,
) -> AdhesiveMotion:  # fmt: skip
    """Return the steady motion of a heavy slider on equal balls with adhesion; see `AdhesiveBalls`.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, load and tangential damping are used.
    orbits : Orbit or sequence of Orbit
        Of the surface under the balls.
    work : float
        Work of adhesion w, J/m^2, positive.
    model : str
        "JKR", "Maugis" or "DMT".
    separation : float
        Equilibrium separation of the surfaces, m, positive; of "Maugis" alone.
    tolerance : float
        Of the velocity, relative to it or to omega |u_x|/10 where that is larger.

    Examples
    --------
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> motion = adhesive_motion(ball, Orbit(frequency=2.2e6, normal=10e-9, tangential=-6.7e-9j), work=0.05)
    >>> print(f"{motion.hops}, {1e6 * motion.lost_power:.2f} uW lost in hops")
    True, 0.66 uW lost in hops
    """
    balls = AdhesiveBalls(slider, work=work, model=model, separation=separation)
    return balls.motion(orbits, tolerance=tolerance)


@lru_cache(64)  # of a search's points many have the same
def holding_balls(slider: Slider) -> AdhesiveBalls:
    """Return the balls of a slider whose own adhesion holds on beyond the touch."""
    own = slider.adhesion
    if own is None or own.work is None:
        raise InputError("slider.adhesion", "is required: of balls that hold on beyond the touch")
    distance = own.separation or DISTANCE
    return AdhesiveBalls(replace(slider, adhesion=None), work=own.work, model=own.model, separation=distance)


def _listed(orbits: Orbit | Sequence[Orbit]) -> tuple[Orbit, ...]:
    """Return the orbits of the balls."""
    return (orbits,) if isinstance(orbits, Orbit) else tuple(orbits)


def _rising(left) -> float:
    """Return the factor at which a function that rises passes zero; infinite above `FAR`."""
    low, high = 1.0, 1.0
    while left(high) < 0.0:
        low, high = high, 2.0 * high
        if high > FAR:
            return math.inf
    while left(low) >= 0.0:
        low, high = 0.5 * low, low
    return bracketed(left, low, high, tolerance=1e-12 * high)
