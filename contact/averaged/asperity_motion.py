r"""Velocity of a heavy slider on rough balls, samples of asperities or mean fields, of first order.

Each ball carries an equal part of the preload F, as statics demands of three balls about the centre of mass: its mean
approach h follows from <P> = F/n, and v from <Q> = load + R_t v of all balls, P and Q the forces of all asperities of
a ball. The tangential law of the slider says how they slip:

    hysteretic  the memory of Mindlin and Deresiewicz in the whole force P(z) of each ball (`memory_cycle`). It is that
                of asperities that displace each other tangentially as they do normally, and slip each on its own
                (`tests/oracles/contact_asperities.py` solves them: 2e-4 of the velocity). For fine asperities it
                becomes the hysteretic law of the smooth ball.
    elastic     a stop for each asperity of a sample (`asperity_cycle`), Q_j = mu (P_j(z) - P_j(z - |x_j|/c)), and one
                of the whole force for a mean field, which for fine asperities becomes the elastic law of the smooth
                ball. Against the memory the stops of samples give 10, 6 and 4 % more with an rms of 0.3 nm at waves of
                2, 3 and 5 nm, since they do not draw each other along, and 8, 4 and 2 % less with 3 nm, where each
                asperity for itself remembers. One stop of a rough mean field must come back from where its first
                asperities touch, and is far too slow: with an rms of 3 nm at a wave of 3 nm 8 % of the smooth ball's
                velocity, where the memory gives 86 % (`tests/contact/test_memory_motion.py`).

The error is estimated by half as many panels of a cycle or cells of depth, and half as many rows of the tables of P.
"""

import math
from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

from contact import parameter_check
from contact.averaged.asperity_stops import Balanced, Powers, Stops, TangentialModel
from contact.averaged.memory_motion import Memory
from contact.choice import Answer
from contact.error_estimate import speed_scale
from contact.exceptions import RUNAWAY, ConvergenceError, InputError
from contact.law.asperities import Asperities
from contact.law.rough import MeanField
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

DRIVEN_BACK = "it moves in the direction of the load, which opposes the unloaded motion"
DOUBLINGS = 4  # at most, of rows and of steps or cells
DEEPER = 1.25  # growth of a range of approaches in which the preload is not reached
MODELS: dict[str, Callable[[Slider, Any, float, float], TangentialModel]] = {"hysteretic": Memory, "elastic": Stops}


class RoughMotion(NamedTuple):
    """Steady motion of a slider on rough balls."""

    answer: Answer  # the velocity, m/s
    heights: tuple[float, ...]  # mean approach of each ball, m
    regime: str  # stick, slip, or intermittent: all asperities leave the surface in every cycle
    solved: Balanced  # motion by the last tables, whose velocity differs from the answer by its error
    doubling: int  # of the last tables


class RoughBalls:
    """Balls with samples of asperities under one slider; their tables serve every amplitude up to the largest.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, tangential damping, load and law are used: "hysteretic", which is
        that of coupled asperities, or "elastic" (see the module's text). The load opposes the motion of the unloaded
        slider, and drives it back where friction does not hold it.
    samples : sequence of Asperities or MeanField
        One for each ball.
    amplitude : float
        Largest normal amplitude in m of the waves that are asked for, where it is known: the tables are made for it.

    Examples
    --------
    >>> from contact import Orbit, Roughness, Slider
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="hysteretic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> rough = RoughBalls(ball, [Roughness(rms=3e-9).drawn(1, 5e-6)])
    >>> wave = Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.35e-9j)
    >>> print(f"{rough.velocity(wave, tolerance=1e-3).value:.4f} m/s; smooth, it is 0.0299 m/s")
    0.0275 m/s; smooth, it is 0.0299 m/s
    """

    def __init__(self, slider: Slider, samples: Sequence[Asperities | MeanField], amplitude: float = 0.0):
        self.slider, self.samples = slider, tuple(samples)
        if slider.law not in MODELS:
            raise InputError("slider.law", f'must be "hysteretic" or "elastic" on rough balls, got "{slider.law}"')
        for each in self.samples:
            if isinstance(each, Asperities) and not len(each):
                raise InputError("sample", "must bring at least one asperity of each ball near the surface")
        self._lowest = min(each.lowest(slider.radius) for each in self.samples)
        self._balls: TangentialModel | None = None
        self._carries = math.inf  # approach at which every ball is known to carry its share
        if amplitude > 0.0:
            self._reach(amplitude)

    @property
    def lowest(self) -> float:
        """Approach from which on the asperities of the first ball to touch are counted to carry, m."""
        return self._lowest

    def reaching(self, deepest: float) -> TangentialModel:
        """Return the balls for approaches up to one in m."""
        return self._reach(max(0.5 * (deepest - self._lowest), 0.0))

    def on(self, orbits: Sequence[Orbit]) -> TangentialModel:
        """Return the balls for waves, those of `motion`."""
        return self._reach(max(abs(each.normal) for each in orbits))

    def velocity(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> Answer:
        """Return the steady velocity in m/s; see `motion`."""
        return self.motion(orbits, tolerance=tolerance).answer

    def motion(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> RoughMotion:
        """Return the steady motion on a wave, given as the orbit of each ball or one of all.

        Averaging of first order is not part of its error.

        Raises
        ------
        ConvergenceError
            With status "runaway" if friction cannot balance the load and there is no tangential damping.
        """
        parameter_check.positive("tolerance", tolerance, "")
        waves, slider = self._of_each(orbits), self.slider
        if slider.tangential_damping == 0.0 and slider.load > 0.0 and self._overloaded:
            raise ConvergenceError("runaway", RUNAWAY)
        balls = self.on(waves)
        reference = speed_scale(0.0, max(each.omega * abs(each.tangential) for each in waves))
        doubling, (before, solved) = 1, balls.solve_two(waves, 1, None)
        velocity, error = balls.refined(before, solved.velocity)
        while error > tolerance * max(abs(velocity), reference) and doubling < DOUBLINGS:
            doubling += 1
            before, solved = balls.solve_two(waves, doubling, solved)
            velocity, error = balls.refined(before, solved.velocity)
        said = (balls.said, DRIVEN_BACK) if solved.load < 0.0 else (balls.said,)
        answer = Answer(value=velocity, error=error, reasons=said)
        each_ball = zip(solved.heights, waves, self._parting, strict=True)
        hops = all(height - abs(wave.normal) <= part for height, wave, part in each_ball)
        regime = "stick" if answer.value == 0.0 else "intermittent" if hops else "slip"
        return RoughMotion(
            answer.judged(tolerance, max(abs(velocity), reference) or 1.0), solved.heights, regime, solved, doubling
        )

    def powers(self, orbits: Orbit | Sequence[Orbit], motion: RoughMotion) -> Powers:
        """Return the mean powers in W of a `motion` on the same orbits; zeros where the slider rests.

        They are those of the tables with which the motion was found, at the velocity at which these balance.
        """
        waves = self._of_each(orbits)
        if motion.answer.value == 0.0:
            return Powers(0.0, 0.0, 0.0)
        return self.on(waves).powers(waves, motion.doubling, motion.solved)

    def coarse_velocity(self, orbits: Sequence[Orbit]) -> float:
        """Return the velocity in m/s of the first tables, for its differences between similar waves."""
        waves = tuple(orbits)
        return self.on(waves).solve(waves, 0).velocity

    def threshold(self, orbits: Orbit | Sequence[Orbit], speed: float, *, tolerance: float) -> float:
        """Return the factor on the orbits at which the velocity passes a small `speed` in m/s; inf above a thousand.

        It is zero if friction cannot hold the load.
        """
        waves = self._of_each(orbits)
        if self._overloaded:
            return 0.0

        def left(factor):
            scaled = tuple(each.scaled(factor) for each in waves)
            return abs(self.velocity(scaled, tolerance=tolerance).value) - speed

        return _passing(left)

    def release(self, orbits: Orbit | Sequence[Orbit]) -> float:
        """Return the factor on the orbits at which the first ball leaves the surface in every cycle; inf above 1000.

        A sample leaves with its highest asperity; of a mean field half of all balls have left; see `MeanField.parting`.
        """
        waves = self._of_each(orbits)

        def left(factor):
            scaled = tuple(each.scaled(factor) for each in waves)
            heights = self._reach(max(abs(each.normal) for each in scaled)).solve(scaled, 1).heights
            troughs = (h - abs(each.normal) for h, each in zip(heights, scaled, strict=True))
            return max(part - trough for part, trough in zip(self._parting, troughs, strict=True))

        return _passing(left)

    @property
    def _overloaded(self) -> bool:
        """Whether friction cannot hold the load."""
        return self.slider.static_friction(len(self.samples)) <= self.slider.load

    @cached_property
    def _parting(self) -> tuple[float, ...]:
        """Approach at which each ball leaves the surface, m."""
        return tuple(each.parting(self.slider.radius) for each in self.samples)

    def _of_each(self, orbits: Orbit | Sequence[Orbit]) -> tuple[Orbit, ...]:
        """Return the orbit of each ball."""
        waves = (orbits,) * len(self.samples) if isinstance(orbits, Orbit) else tuple(orbits)
        if len(waves) != len(self.samples):
            raise InputError("orbits", f"must be one for each ball, {len(self.samples)}, got {len(waves)}")
        return waves

    def _reach(self, amplitude: float) -> TangentialModel:
        """Return the balls for approaches up to the deepest crest of an amplitude; waves come in any order."""
        slider, before = self.slider, self._balls.deepest if self._balls else self._lowest
        deepest = max(before, self._lowest + 2.0 * amplitude + slider.rest_approach(len(self.samples)))
        while True:
            if self._balls is None or deepest > self._balls.deepest:
                of = (slider.radius, slider.effective_modulus, deepest)
                made = {id(each): each.ball(*of) for each in self.samples}
                balls = [made[id(each)] for each in self.samples]
                self._balls = MODELS[slider.law](slider, balls, self._lowest, deepest)
            trough = deepest - 2.0 * amplitude
            if trough >= self._carries:
                return self._balls
            share = slider.preload / len(self.samples)
            if all(each.carries(share, trough) for each in set(self._balls.balls)):
                self._carries = trough
                return self._balls
            deepest = self._lowest + DEEPER * (deepest - self._lowest)


def _passing(left) -> float:
    """Return the factor at which a function that rises passes zero, to 1e-3 of it; infinite above a thousand."""
    low, high = 1.0, 1.0
    while left(high) < 0.0:
        low, high = high, 1.3 * high
        if high > 1e3:
            return math.inf
    while left(low) > 0.0:
        low, high = low / 1.3, low
    return bracketed(left, low, high, tolerance=1e-3 * high)


def asperity_motion(slider: Slider, sample: Asperities, orbit: Orbit, *, tolerance: float = 1e-3) -> Answer:
    """Return the steady velocity of a heavy slider on one rough ball, in m/s with its error; see `RoughBalls`."""
    return RoughBalls(slider, (sample,)).velocity(orbit, tolerance=tolerance)
