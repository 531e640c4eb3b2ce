r"""Velocity of a heavy slider on rough balls: each asperity of a sample slips on its own, of first order.

The force of asperity j is a function P_j(z) of its ball's approach, in which all of them take part (`law.asperities`).
One stop for the ball as a whole (`law.elastic` with the sum of the forces) forgets which asperities have slipped; here
each has its own (`asperity_cycle`). The mean approach h follows from <sum P_j> = F, and v from
<sum Q_j> = load + R_t v. The error is estimated by half as many steps of phase and half as many rows of the table of
approaches.

The asperities push each other down, but do not draw each other along: P_j(z) - P_j(z - |x_j|/c) is exact where all have
moved alike (Jaeger). For asperities so fine that they merge the truth is the hysteretic law of the smooth ball; the
stops give 11 % more than that on the seed's ball at a wave of 3 nm and 19 % at 2 nm (rings of Hertz's pressure with a
stop each), of which samples of 0.3 nm show 4 and 7 %.
"""

import math
from collections.abc import Sequence

import numpy as np

from contact import parameter_check
from contact.averaged.asperity_cycle import Table, mean_normal, mean_pull
from contact.choice import Answer
from contact.error_estimate import reference_speed
from contact.exceptions import InputError
from contact.law.asperities import Asperities, RoughBall
from contact.orbit import Orbit
from contact.roots import bracketed
from contact.slider import Slider

ROWS = 24  # approaches of a ball at which the forces are solved, of the first answer
STEPS = 128  # of phase, of the first answer
DOUBLINGS = 4  # at most, of both
MAX_NEAR = 2500  # asperities of a ball; a table of them takes about a minute
REPEATS = 1e-9  # change of a deformation from one cycle to the next over the largest, at which it repeats
CLOSE = 1e-7  # of the velocity over its range
DEEPER = 1.25  # growth of a range of approaches in which the preload is not reached


class RoughBalls:
    """Balls with samples of asperities under one slider; their tables serve every amplitude up to the largest.

    Parameters
    ----------
    slider : Slider
        Radius, moduli, friction coefficient, preload, tangential damping and load are used. The load opposes the motion
        of the unloaded slider.
    samples : sequence of Asperities
        One for each ball; the balls have one mean height.

    Examples
    --------
    >>> from contact import Orbit, Roughness, Slider
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> rough = RoughBalls(ball, [Roughness(rms=3e-9).drawn(1, 5e-6)])
    >>> wave = Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.35e-9j)
    >>> print(f"{rough.velocity(wave, tolerance=1e-3).value:.4f} m/s; smooth, it is 0.0279 m/s")
    0.0267 m/s; smooth, it is 0.0279 m/s
    """

    def __init__(self, slider: Slider, samples: Sequence[Asperities]):
        self.slider, self.samples = slider, tuple(samples)
        for each in self.samples:
            if not len(each):
                raise InputError("sample", "must hold at least one asperity")
        self._balls: list[RoughBall] = []
        self._tables: dict[int, list[Table]] = {}
        self._lowest = min(-float(np.max(self._free(each))) for each in self.samples)
        self._deepest = self._lowest

    def _free(self, sample: Asperities) -> np.ndarray:
        return sample.heights - (sample.x**2 + sample.y**2) / (2.0 * self.slider.radius)

    def velocity(self, orbits: Orbit | Sequence[Orbit], *, tolerance: float) -> Answer:
        """Return the steady velocity in m/s on a wave, the orbit of each ball or one of all.

        Averaging of first order is not part of its error.
        """
        parameter_check.positive("tolerance", tolerance, "")
        waves = (orbits,) * len(self.samples) if isinstance(orbits, Orbit) else tuple(orbits)
        if len(waves) != len(self.samples):
            raise InputError("orbits", f"must be one for each ball, {len(self.samples)}, got {len(waves)}")
        self._reach(max(abs(each.normal) for each in waves))
        reference = max(reference_speed(0.0, (each,)) for each in waves)
        values: list[float] = []
        error = math.inf
        for doubling in range(DOUBLINGS + 1):
            values.append(self._velocity(waves, doubling))
            if doubling:
                # the means err by the square of the step; a third of the change would be Richardson's
                error = abs(values[-1] - values[-2])
                if error <= tolerance * max(abs(values[-1]), reference):
                    break
        number = sum(table.touch.size for table in self._tables[0])
        reasons = (f"cycle means of {number} asperities, a stop each",)
        answer = Answer(value=values[-1], error=error, reasons=reasons)
        return answer.judged(tolerance, max(abs(values[-1]), reference) or 1.0)

    def threshold(self, orbits: Orbit | Sequence[Orbit], speed: float, *, tolerance: float) -> float:
        """Return the factor on the orbits at which the velocity passes a small `speed` in m/s; inf above a thousand."""
        waves = (orbits,) * len(self.samples) if isinstance(orbits, Orbit) else tuple(orbits)

        def left(factor):
            found = self.velocity(tuple(each.scaled(factor) for each in waves), tolerance=tolerance)
            return abs(found.value) - speed

        low, high = 1.0, 1.0
        while left(high) < 0.0:
            low, high = high, 1.3 * high
            if high > 1e3:
                return math.inf
        while left(low) > 0.0:
            low, high = low / 1.3, low
        return bracketed(left, low, high, tolerance=1e-3 * high)

    def _reach(self, amplitude: float) -> None:
        """Solve the balls for approaches up to the deepest crest of an amplitude; waves come in any order."""
        slider, rest = self.slider, self.slider.rest_approach(len(self.samples))
        deepest = max(self._deepest, self._lowest + 2.0 * amplitude + rest)
        while True:
            if deepest > self._deepest:
                radius, modulus = slider.radius, slider.effective_modulus
                self._balls = [RoughBall(each, radius, modulus, deepest) for each in self.samples]
                for each in self._balls:
                    if len(each.near) > MAX_NEAR:
                        rule = f"must not bring more than {MAX_NEAR} asperities of a ball near the surface"
                        raise InputError("sample", f"{rule}, got {len(each.near)}: the mean field serves these")
                self._deepest, self._tables = deepest, {}
            trough = deepest - 2.0 * amplitude
            if sum(float(each.forces(each.at(trough).approaches).sum()) for each in self._balls) >= slider.preload:
                return
            deepest = self._lowest + DEEPER * (deepest - self._lowest)

    def _at(self, doubling: int) -> list[Table]:
        """Return the tables with so many doublings of their rows."""
        if doubling not in self._tables:
            self._tables[doubling] = [self._table(each, ROWS * 2**doubling) for each in self._balls]
        return self._tables[doubling]

    def _table(self, ball: RoughBall, rows: int) -> Table:
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

    def _velocity(self, waves: tuple[Orbit, ...], doubling: int) -> float:
        """Return the velocity at which no mean force is left, with so many doublings of steps and rows."""
        slider, tables, steps = self.slider, self._at(doubling), STEPS * 2**doubling
        turn = np.exp(2j * np.pi * np.arange(steps) / steps)
        u_z = [(each.normal * turn).real for each in waves]
        u_x = [(each.tangential * turn).real for each in waves]
        size, answer = max(abs(each.normal) for each in waves), np.zeros(1)

        def total(kernel, *arguments):
            sums = 0.0
            for own in zip(tables, *arguments, strict=True):
                kernel(*own, answer)
                sums += float(answer[0])
            return sums

        def carried(height):
            return total(mean_normal, [height + each for each in u_z]) - slider.preload

        height = bracketed(
            carried, self._lowest - size, self._deepest - size, tolerance=1e-9 * (self._deepest - self._lowest)
        )
        z, c, friction = [height + each for each in u_z], slider.limit_slope, slider.friction_coefficient
        tangential, omega = max(abs(each.tangential) for each in waves), waves[0].omega
        top = omega * (tangential + c * size)
        repeats = [REPEATS * (tangential + c * size)] * len(waves)

        def left(v):
            """Return the force that is left at a velocity."""
            travel = v * 2.0 * np.pi / (steps * omega)
            moved = [each - np.roll(each, 1) - travel for each in u_x]
            pull = total(mean_pull, z, moved, [c] * len(waves), repeats)
            return friction * pull - load - slider.tangential_damping * v

        load = 0.0
        drive = left(0.0)
        way, load = math.copysign(1.0, drive), math.copysign(slider.load, drive)
        if abs(drive) - slider.load <= 1e-9 * friction * slider.preload:
            return 0.0
        # at this speed every asperity slips backwards all the time
        return bracketed(left, 0.0, way * top, tolerance=CLOSE * top)


def asperity_motion(slider: Slider, sample: Asperities, orbit: Orbit, *, tolerance: float = 1e-3) -> Answer:
    """Return the steady velocity of a heavy slider on one rough ball, in m/s with its error; see `RoughBalls`."""
    return RoughBalls(slider, (sample,)).velocity(orbit, tolerance=tolerance)
