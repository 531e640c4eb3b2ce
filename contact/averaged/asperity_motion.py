r"""Velocity of a heavy slider on rough balls: each asperity of a sample slips on its own, of first order.

The force of asperity j is a function P_j(z) of its ball's approach, in which all of them take part (`law.asperities`).
One stop for the ball as a whole (`law.elastic` with the sum of the forces) forgets which asperities have slipped; here
each has its own (`asperity_cycle`). Each ball carries an equal part of the preload F, as statics demands of three balls
about the centre of mass: its mean approach h follows from <sum P_j> = F/n, and v from <sum Q_j> = load + R_t v of all
balls. The error is estimated by half as many steps of phase and half as many rows of the table of approaches.

The asperities push each other down, but do not draw each other along: P_j(z) - P_j(z - |x_j|/c) is exact where all have
moved alike (Jaeger). For asperities so fine that they merge the truth is the hysteretic law of the smooth ball; the
stops give 11 % more than that on the seed's ball at a wave of 3 nm and 19 % at 2 nm (rings of Hertz's pressure with a
stop each), of which samples of 0.3 nm show 4 and 7 %.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.averaged.asperity_cycle import Table, mean_normal, mean_pull
from contact.choice import Answer
from contact.error_estimate import reference_speed
from contact.exceptions import InputError
from contact.law.asperities import Asperities, RoughBall
from contact.law.rough import FieldBall, MeanField
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

ROWS = 24  # approaches of a ball at which the forces are solved, of the first answer
STEPS = 128  # of phase, of the first answer
DOUBLINGS = 4  # at most, of both
REPEATS = 1e-9  # change of a deformation from one cycle to the next over the largest, at which it repeats
CLOSE = 1e-6  # of the velocity over its range
DEEPER = 1.25  # growth of a range of approaches in which the preload is not reached


class RoughMotion(NamedTuple):
    """Steady motion of a slider on rough balls."""

    answer: Answer  # the velocity, m/s
    heights: tuple[float, ...]  # mean approach of each ball, m
    regime: str  # stick, slip, or intermittent: all asperities leave the surface in every cycle


class RoughBalls:
    """Balls with samples of asperities under one slider; their tables serve every amplitude up to the largest.

    The asperities do not draw each other along. On the ball below, 0.03 nm of roughness gives 15, 9 and 5 % more than
    the hysteretic law of a smooth one at waves of 2, 3 and 5 nm.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, tangential damping and load are used. The load opposes the motion
        of the unloaded slider.
    samples : sequence of Asperities or MeanField
        One for each ball.
    amplitude : float
        Largest normal amplitude in m of the waves that are asked for, where it is known: the tables are made for it.

    Examples
    --------
    >>> from contact import Orbit, Roughness, Slider
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> rough = RoughBalls(ball, [Roughness(rms=3e-9).drawn(1, 5e-6)])
    >>> wave = Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.35e-9j)
    >>> print(f"{rough.velocity(wave, tolerance=1e-3).value:.4f} m/s; smooth, it is 0.0279 m/s")
    0.0270 m/s; smooth, it is 0.0279 m/s
    """

    def __init__(self, slider: Slider, samples: Sequence[Asperities | MeanField], amplitude: float = 0.0):
        self.slider, self.samples = slider, tuple(samples)
        for each in self.samples:
            if isinstance(each, Asperities) and not len(each):
                raise InputError("sample", "must bring at least one asperity of each ball near the surface")
        self._balls: list[RoughBall | FieldBall] = []
        self._tables: dict[int, list[Table]] = {}
        self._lowest = min(each.lowest(slider.radius) for each in self.samples)
        self._deepest = self._lowest
        if amplitude > 0.0:
            self._reach(amplitude)

    def velocity(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> Answer:
        """Return the steady velocity in m/s; see `motion`."""
        return self.motion(orbits, tolerance=tolerance).answer

    def motion(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> RoughMotion:
        """Return the steady motion on a wave, given as the orbit of each ball or one of all.

        Averaging of first order is not part of its error.
        """
        parameter_check.positive("tolerance", tolerance, "")
        waves = self._of_each(orbits)
        self._reach(max(abs(each.normal) for each in waves))
        reference = max(reference_speed(0.0, (each,)) for each in waves)
        values: list[float] = []
        error = math.inf
        for doubling in range(DOUBLINGS + 1):
            heights = self._riding(waves, doubling)
            values.append(self._velocity(waves, doubling, heights))
            if doubling:
                # about the square of the step: of a smooth mean a third of the change would be the error
                error = 0.5 * abs(values[-1] - values[-2])
                if error <= tolerance * max(abs(values[-1]), reference):
                    break
        number = sum(table.touch.size for table in self._tables[0])
        reasons = (f"cycle means of {number} asperities, a stop each",)
        answer = Answer(value=values[-1], error=error, reasons=reasons)
        each_ball = zip(heights, waves, self._parting, strict=True)
        hops = all(height - abs(wave.normal) <= part for height, wave, part in each_ball)
        regime = "stick" if answer.value == 0.0 else "intermittent" if hops else "slip"
        return RoughMotion(answer.judged(tolerance, max(abs(values[-1]), reference) or 1.0), heights, regime)

    def coarse_velocity(self, orbits: Sequence[Orbit]) -> float:
        """Return the velocity in m/s of the first tables, for its differences between similar waves."""
        waves = tuple(orbits)
        self._reach(max(abs(each.normal) for each in waves))
        return self._velocity(waves, 0, self._riding(waves, 0))

    def threshold(self, orbits: Orbit | Sequence[Orbit], speed: float, *, tolerance: float) -> float:
        """Return the factor on the orbits at which the velocity passes a small `speed` in m/s; inf above a thousand."""
        waves = self._of_each(orbits)

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
            self._reach(max(abs(each.normal) for each in scaled))
            troughs = (h - abs(each.normal) for h, each in zip(self._riding(scaled, 1), scaled, strict=True))
            return max(part - trough for part, trough in zip(self._parting, troughs, strict=True))

        return _passing(left)

    @property
    def _parting(self) -> tuple[float, ...]:
        """Approach at which each ball leaves the surface, m."""
        return tuple(each.parting(self.slider.radius) for each in self.samples)

    def _of_each(self, orbits: Orbit | Sequence[Orbit]) -> tuple[Orbit, ...]:
        """Return the orbit of each ball."""
        waves = (orbits,) * len(self.samples) if isinstance(orbits, Orbit) else tuple(orbits)
        if len(waves) != len(self.samples):
            raise InputError("orbits", f"must be one for each ball, {len(self.samples)}, got {len(waves)}")
        return waves

    def _reach(self, amplitude: float) -> None:
        """Solve the balls for approaches up to the deepest crest of an amplitude; waves come in any order."""
        slider, rest = self.slider, self.slider.rest_approach(len(self.samples))
        deepest = max(self._deepest, self._lowest + 2.0 * amplitude + rest)
        while True:
            if deepest > self._deepest:
                balls = (each.ball(slider.radius, slider.effective_modulus, deepest) for each in self.samples)
                self._balls = list(balls)
                self._deepest, self._tables = deepest, {}
            trough = deepest - 2.0 * amplitude
            share = slider.preload / len(self._balls)
            if all(float(each.forces(each.at(trough).approaches).sum()) >= share for each in self._balls):
                return
            deepest = self._lowest + DEEPER * (deepest - self._lowest)

    def _at(self, doubling: int) -> list[Table]:
        """Return the tables with so many doublings of their rows."""
        if doubling not in self._tables:
            self._tables[doubling] = [self._table(each, ROWS * 2**doubling) for each in self._balls]
        return self._tables[doubling]

    def _table(self, ball: RoughBall | FieldBall, rows: int) -> Table:
        z = np.linspace(self._lowest, self._deepest, rows + 1)
        spacing, states, near = z[1] - z[0], [], None
        for each in z:
            states.append(ball.at(float(each), near))
            near = states[-1].approaches + spacing * states[-1].rates
        approaches, rates = (np.array(each) for each in zip(*states, strict=True))
        # the approach at which an asperity touches first: below, u_j is smooth between two rows
        touching = np.maximum((approaches > 0.0).argmax(axis=0), 1)
        column = np.arange(approaches.shape[1])
        low, high = approaches[touching - 1, column], approaches[touching, column]
        share = np.clip(-low / np.where(high > low, high - low, 1.0), 0.0, 1.0)
        touch = np.where((approaches > 0.0).any(axis=0), z[touching - 1] + share * spacing, np.inf)
        used = np.isfinite(touch)
        return Table(
            np.ascontiguousarray(approaches[:, used]), np.ascontiguousarray(spacing * rates[:, used]), touch[used],
            ball.stiffness[used], ball.merged[used], float(z[0]), float(spacing),
        )  # fmt: skip

    def _riding(self, waves: tuple[Orbit, ...], doubling: int) -> tuple[float, ...]:
        """Return the mean approaches at which the mean normal force of each ball is its part of the preload."""
        turn, answer, share = _turn(doubling), np.zeros(1), self.slider.preload / len(waves)

        def height(table, wave):
            u_z, size = (wave.normal * turn).real, abs(wave.normal)

            def left(h):
                mean_normal(table, h + u_z, answer)
                return float(answer[0]) - share

            span = self._deepest - self._lowest
            return bracketed(left, self._lowest - size, self._deepest - size, tolerance=1e-9 * span)

        return tuple(height(*each) for each in zip(self._at(doubling), waves, strict=True))

    def _velocity(self, waves: tuple[Orbit, ...], doubling: int, heights: tuple[float, ...]) -> float:
        """Return the velocity at which no mean force is left, with so many doublings of steps and rows."""
        slider, turn, answer = self.slider, _turn(doubling), np.zeros(1)
        u_x = [(each.tangential * turn).real for each in waves]
        size, steps = max(abs(each.normal) for each in waves), turn.size
        z = [height + (each.normal * turn).real for height, each in zip(heights, waves, strict=True)]
        c, friction = slider.limit_slope, slider.friction_coefficient
        tangential, omega = max(abs(each.tangential) for each in waves), waves[0].omega
        top = omega * (tangential + c * size)
        repeats = REPEATS * (tangential + c * size)

        def left(v, load=0.0):
            """Return the force that is left at a velocity under a load with its sign."""
            travel = v * 2.0 * np.pi / (steps * omega)
            pull = 0.0
            for table, place, along in zip(self._at(doubling), z, u_x, strict=True):
                mean_pull(table, place, along - np.roll(along, 1) - travel, c, repeats, answer)
                pull += float(answer[0])
            return friction * pull - load - slider.tangential_damping * v

        drive = left(0.0)
        way, load = math.copysign(1.0, drive), math.copysign(slider.load, drive)
        if abs(drive) - slider.load <= 1e-9 * friction * slider.preload:
            return 0.0
        # at this speed every asperity slips backwards all the time
        return bracketed(lambda v: left(v, load), 0.0, way * top, tolerance=CLOSE * top)


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


def _turn(doubling: int) -> np.ndarray:
    steps = STEPS * 2**doubling
    return np.exp(2j * np.pi * np.arange(steps) / steps)


def asperity_motion(slider: Slider, sample: Asperities, orbit: Orbit, *, tolerance: float = 1e-3) -> Answer:
    """Return the steady velocity of a heavy slider on one rough ball, in m/s with its error; see `RoughBalls`."""
    return RoughBalls(slider, (sample,)).velocity(orbit, tolerance=tolerance)
