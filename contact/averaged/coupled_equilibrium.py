r"""Averaged equilibrium of a slider on rows of contacts, with the unknowns of its body and of the wave.

The unknowns are the mean approach H of the slider's plane, its tilts theta about y and psi about x, the velocity v, and
the wave's amplitudes at the rows of contacts. They satisfy

    sum <P> = F,  sum <P> x = F x_F,  sum <P> y = F y_F,  sum <Q> = load + R_t v,                               (1)

and the amplitudes are those that the contacts' first harmonics leave (`RowCycle.wave_step`). The cycle means,
including the weights, come from `RowCycle` or `OvertoneCycle`. The contacts may differ in position, height, radius
and stiffness. A load that acts at a height b above the surface tilts the slider: it shifts x_F by -b load/F.

How many of these are unknown at once follows from body and wave:

- A wave that the contacts do not change: H and tilts, or H of each row on a soft backing, follow from the normal forces
  alone (`ride`), and do not depend on v. `equilibrium.balanced_speed` then searches v, as for a body that is held.
- A wave that they change: the amplitudes at the rows depend on v, and H and tilts on the amplitudes. One iteration
  (`_Search`) changes all unknowns. Each step consists of Newton's step of the slider at constant amplitudes, and of the
  step of the amplitudes for a slider that does not move. Anderson's method (J. ACM 12 (1965) 547) estimates from the
  last steps what this neglects, the coupling of the two.
"""

import math
from dataclasses import dataclass, field

import numpy as np

from contact.averaged.cycle_mean import MeanForces
from contact.averaged.row_cycle import RowCycle
from contact.body import height_under
from contact.exceptions import ConvergenceError
from contact.law.normal import approach

CLOSE = 1e-12  # tolerance of the scaled residuals and of the change of the wave amplitudes
# For a wave of many periods or a sum of 10^5 forces, rounding keeps the change of the amplitudes above CLOSE. Residuals
# and changes below ROUNDING are accepted if they no longer fall.
ROUNDING = 1e-11
# Where contacts touch only at the crests, residuals are the forces' rounding times the amplitude over the depth of the
# contact (4e-11 under 1 uN). They are accepted below MAX_RESIDUAL if Newton's step is below CLOSE of the unknowns.
MAX_RESIDUAL = 1e-8
STEP = 1e-6  # of the finite differences, in scaled unknowns
# Largest change in one step: of a scaled unknown, and of an amplitude over the incident one
MAX_MOVE, MAX_WAVE = 1.0, 0.5
# MEMORY: number of steps that Anderson's method combines. SAMPLE: about as many of the amplitudes' parts enter its
# least squares; they change smoothly along the wave.
MEMORY, SAMPLE = 16, 4000
# Stagnation: in PATIENCE steps the residuals have not fallen below FALL times their value before. The search then
# returns to the point of the smallest residuals and computes the derivatives there. It ends after USELESS stagnations
# in a row without progress, or after MAX_EVALUATIONS.
PATIENCE, FALL, USELESS, MAX_EVALUATIONS = 4, 0.3, 6, 2500
# If a step increases the residuals, to more than FAR, it is replaced by one that is shorter by the factor SHORTER:
# once, or up to SHORTENINGS times in a careful search (one that has stagnated).
FAR, SHORTER, SHORTENINGS = 0.3, 0.4, 7
# At the start the amplitudes alone are moved until their change is below START of the incident amplitude; in a careful
# search also after each step, until it is below INNER of the residuals; in both cases for at most WAIT evaluations. If
# the change does not fall below SLOW times the last one, the derivatives of the forces in the amplitudes are computed.
START, INNER, WAIT, SLOW = 0.1, 0.1, 12, 0.5
# Largest number of Newton steps of H and tilts under the normal forces alone. SOFT times the mean stiffness is added to
# the diagonal of their matrix, which is singular if a single contact touches.
LEVELLINGS, SOFT = 60, 1e-9
HEIGHT, PITCH, ROLL, SPEED = range(4)


class Anderson:
    """Anderson's method, which improves the step f(x) of a fixed-point iteration by the last steps.

    With the changes dx and df of the last points x and steps f, it takes f - gamma (dx + df), where gamma minimises
    |f - gamma df| over a sample of the quantities.
    """

    def __init__(self, count: int, first: int):
        # the first ones, and the others at equal distances: an odd one, for real and imaginary parts take turns
        stride = max((count - first) // SAMPLE, 1) | 1
        self.sample = slice(None) if stride == 1 else np.r_[:first, first:count:stride]
        self.last = None  # point and step
        self.changes: list[np.ndarray] = []  # df in the sample
        self.moves: list[np.ndarray] = []  # dx + df

    def step(self, point, step):
        """Return a better step than `step` from a point."""
        last, self.last = self.last, (point, step)
        if last is None:
            return step
        change, kept = step - last[1], min(MEMORY, step.size) - 1
        self.changes = [*self.changes[-kept:], change[self.sample]] if kept else [change[self.sample]]
        move = change + point
        move -= last[0]
        self.moves = [*self.moves[-kept:], move] if kept else [move]
        gamma = np.linalg.lstsq(np.array(self.changes).T, step[self.sample], rcond=1e-10)[0]
        better = step.copy()
        for factor, each in zip(gamma, self.moves, strict=True):
            better -= factor * each
        return better


def _largest(values) -> float:
    return float(np.max(np.abs(values), initial=0.0))


def _solved(jacobian, right):
    """Return the shortest solution of a system of equations, which is singular if few contacts touch."""
    return np.linalg.lstsq(jacobian, right, rcond=1e-12)[0]


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged equilibrium of a slider on a passing wave."""

    height: float  # H, m; with a soft backing the mean over the rows
    tilt: tuple[float, float]  # about y and x, rad; positive if the approach increases towards +x and +y
    w: float  # velocity over omega, m
    traction: float  # sum <Q>, N
    forces: MeanForces = field(repr=False)
    error: float  # estimated error of w, m, from the residuals and the last change of the amplitudes


class Equilibrium:
    """Equations of one slider on one wave; each solution starts from the last one."""

    def __init__(self, cycle: RowCycle):
        slider, wave = cycle.slider, cycle.wave
        self.cycle = cycle
        # load on the slider, N, and the point (x_F, y_F) at which the resultant of load and preload acts, m
        self.load, self.preload_at = 0.0, slider.preload_at
        self.preload, self.friction = slider.preload, slider.friction_coefficient * slider.preload
        rest = float(approach(self.preload / float(np.sum(cycle.weight * cycle.k_n)), cycle.normal))
        self.amplitude = max(wave.amplitude, 1e-300)
        self.length = max(wave.amplitude, rest)
        self.speed = max(abs(wave.orbit) * wave.amplitude, 1e-3 * self.length)
        # Half the extent along x and y, the unit of length of the moments. If all contacts lie on one line, the tilt
        # along it has no effect, and the arm is arbitrary.
        self.arm = np.array([0.5 * float(np.ptp(each)) or 1.0 for each in (slider.x, slider.y)])
        tilts = {"held": (), "pitch": (PITCH,), "free": (PITCH, ROLL)}[slider.tilt]
        self.soft = slider.backing == "soft"
        self.plane = [] if self.soft else [HEIGHT, *tilts]
        self.scale = np.array([self.length, *(self.length / self.arm), self.speed])
        self.row_load = self.preload * cycle.sums(np.ones_like(cycle.x)) / slider.number
        self.unknowns = np.zeros(4)
        self.rows = np.full(cycle.turn.size, -np.inf)  # H of each row with a soft backing
        self.rest = rest - float(cycle.height.min())
        self.unlevel = 0.0  # largest residual of the normal forces and moments that `level` has left
        self.begin()
        sign = abs(wave.forward) ** 2 - abs(wave.backward) ** 2
        self.unknowns[SPEED] = -0.6 * wave.orbit.imag * sign / self.amplitude
        # weight of the amplitudes in a step of all unknowns: their root mean square counts as one unknown
        self.weight = 1.0 / math.sqrt(max(cycle.waves.size, 1))

    def begin(self):
        """Start from the undisturbed wave and the height and tilts of a slider that it carries."""
        self.cycle.reset()
        self.unknowns[PITCH] = self.unknowns[ROLL] = 0.0
        self.carried_at = None
        self.ride()

    def ride(self):
        """Take H and tilts, or H of each row, at which the wave as it is carries the preload where it acts."""
        if self.carried_at == self.preload_at:
            return
        weight = self.cycle.weight
        if self.soft:
            self.rows = self._row_heights()
        elif self.carried_at is None:
            self.unknowns[HEIGHT] = self._carrying(self.preload, self.rest, lambda each: weight @ each)
        self.carried_at = self.preload_at
        if len(self.plane) > 1:
            self.level()

    def level(self):
        """Take H and tilts at which the normal forces balance at the current amplitudes, or come close to it.

        These forces are the derivatives of a convex potential of H and tilts. A Newton step is therefore halved until
        the residual along it is at most half of what it was, or negative, as it is before the minimum.
        """
        active, cycle = self.plane, self.cycle
        arms = np.stack([np.ones_like(cycle.x), cycle.x / self.arm[0], cycle.y / self.arm[1]])[active]
        wanted = np.array([1.0, *(np.array(self.preload_at) / self.arm)])[active]

        def residual_and_rates():
            force, rate = cycle.mean_loads(cycle.approaches(*self.unknowns[:SPEED]))
            rates = arms * (cycle.weight * rate) @ arms.T * (self.length / self.preload)
            return arms @ (cycle.weight * force) / self.preload - wanted, rates

        for _ in range(LEVELLINGS):
            residual, rates = residual_and_rates()
            self.unlevel = _largest(residual)
            if self.unlevel < CLOSE:
                return
            start = self.unknowns[active]
            step = np.linalg.solve(rates + SOFT * np.trace(rates) * np.eye(len(active)), -residual)
            step /= max(1.0, _largest(step) / MAX_MOVE)
            for _ in range(SHORTENINGS):
                self.unknowns[active] = start + step * self.scale[active]
                if residual_and_rates()[0] @ step <= -0.5 * (residual @ step):
                    break
                step = 0.5 * step

    def _carrying(self, load, heights, sums):
        """Return H at which the contacts carry a load in N without tilt, at the current wave amplitudes.

        `sums` adds forces over all contacts, or over each row if every row has its own load and H.
        """
        return height_under(lambda each: map(sums, self.cycle.mean_normal(each)), load, heights, 1e-13 * self.length)

    def _row_heights(self):
        """Return H of each row under its share of the preload."""
        cycle = self.cycle
        above = approach(self.row_load / cycle.sums(cycle.k_n), cycle.normal)
        above = above - np.minimum.reduceat(cycle.height, cycle.first)
        # the last heights are better initial values if they are still too large
        force = cycle.sums(next(cycle.mean_normal(self.rows)))
        return self._carrying(self.row_load, np.where(force >= self.row_load, self.rows, above), cycle.sums)

    def _evaluate(self, side: float):
        """Return the residuals of (1) over F, F arm, F arm and mu F, at the current wave amplitudes."""
        cycle, y = self.cycle, self.unknowns
        if self.soft and cycle.waves.size:
            self.rows = self._row_heights()
        w = y[SPEED]
        side = side if w == 0.0 else np.sign(w)
        self.approaches = cycle.approaches(self.rows if self.soft else y[HEIGHT], y[PITCH], y[ROLL])
        self.moving, self.forces = (w, side), cycle.forces(self.approaches, w, side)
        sums = self._generalised(self.forces.normal, self.forces.tangential)
        self.traction = float(sums[SPEED]) * self.friction
        opposed = self.load + cycle.slider.tangential_damping * w * cycle.wave.omega
        return sums - np.array([1.0, *(np.array(self.preload_at) / self.arm), opposed / self.friction])

    def _generalised(self, normal, tangential):
        """Return sum P, sum P x, sum P y and sum Q of forces per class, over F, F arm, F arm and mu F."""
        cycle = self.cycle
        P, Q = cycle.weight * normal, float(np.sum(cycle.weight * tangential))
        moments = np.array([np.sum(P * cycle.x), np.sum(P * cycle.y)]) / (self.preload * self.arm)
        return np.array([np.sum(P) / self.preload, *moments, Q / self.friction])

    def residuals(self, active, side, slope):
        """Return the residuals and the step of the amplitudes, over the incident one."""
        residual = self._evaluate(side)[active]
        return residual, self.cycle.wave_step(self.forces, slope) / self.amplitude

    def newton_step(self):
        """Return the derivatives of the forces in the amplitudes, and Newton's step of the amplitudes."""
        slope = self.cycle.tangent(self.approaches, *self.moving, self.forces)
        return slope, self.cycle.wave_step(self.forces, slope) / self.amplitude

    def limited(self, moves, wave_step, method=None, point=None):
        """Return a step of unknowns and amplitudes as a vector of `at`, improved by a method and limited in length."""
        step = np.append(moves, self.weight * wave_step.view(float))
        if method is not None:
            step = method.step(point, step)
        most = np.where(np.arange(step.size) < moves.size, MAX_MOVE, MAX_WAVE * self.weight)
        return step / max(1.0, _largest(step / most))

    def at(self, active):
        """Return the active unknowns and the wave's amplitudes as one scaled vector."""
        waves = self.weight * self.cycle.waves / self.amplitude
        return np.append(self.unknowns[active] / self.scale[active], waves.view(float))

    def go_to(self, point, active):
        """Take unknowns and amplitudes from a vector of `at`."""
        n = len(active)
        self.unknowns[active] = point[:n] * self.scale[active]
        self.cycle.waves = point[n:].view(complex) * (self.amplitude / self.weight)

    def jacobian(self, active):
        """Return the derivatives of the residuals at constant wave amplitudes, by differences of the contacts' forces.

        H and tilts change the approach alone, so that one difference serves them.
        """
        cycle, here, (w, side), columns = self.cycle, self.forces, self.moving, np.zeros((4, 4))
        if self.plane:
            there = cycle.forces(self.approaches + STEP * self.length, w, side)
            rise = [(new - old) / STEP for new, old in zip(there[:2], here[:2], strict=True)]
            for k, arm in enumerate((1.0, cycle.x / self.arm[0], cycle.y / self.arm[1])):
                columns[k] = self._generalised(*(arm * each for each in rise))
        if SPEED in active:  # away from v = 0, where the residual has a kink
            step = STEP * self.speed * (np.sign(w) or side or 1.0)
            there, scale = cycle.forces(self.approaches, w + step, side), self.speed / step
            columns[SPEED] = scale * (
                self._generalised(there.normal, there.tangential) - self._generalised(here.normal, here.tangential)
            )
            columns[SPEED, SPEED] -= cycle.slider.tangential_damping * cycle.wave.omega * self.speed / self.friction
        return columns.T[np.ix_(active, active)]

    def solve(self, load: float, w: float | None = None, side: float = 0.0, close: float = CLOSE) -> Balance:
        """Return the equilibrium under a load, or at the fixed velocity over omega `w`; only that on a given wave.

        `side`: sign of the motion before a velocity of zero; `close`: tolerance of the search on a wave that is loaded.
        """
        self.load, self.preload_at = load, self.cycle.slider.preload_point(load)
        active = list(self.plane)
        if w is None:
            active.append(SPEED)
        else:
            self.unknowns[SPEED] = w
        if not self.cycle.waves.size:
            self.ride()
            if self.unlevel > MAX_RESIDUAL:
                raise ConvergenceError(
                    "not converged", f"height and tilts leave a residual of {self.unlevel:.1e} of the preload"
                )
            self._evaluate(side)
            return self._balance(0.0)
        try:
            speed_error = _Search(self, active, side, close).run()
        except ConvergenceError:
            if w is None:
                raise
            self.begin()
            speed_error = _Search(self, active, side, close, careful=True).run()
        return self._balance(speed_error * self.speed)

    def _balance(self, error):
        height, pitch, roll, w = self.unknowns.tolist()
        return Balance(
            height=float(np.mean(self.rows)) if self.soft else height, tilt=(pitch, roll), w=w,
            traction=self.traction, forces=self.forces, error=error,
        )  # fmt: skip


class _Search:
    """One solution of the equations of a slider, from its current unknowns and amplitudes.

    A step of all unknowns leads from the point `before` to `before` + `step`. The evaluation there decides on one move:

    1. The step has made the residuals worse: a shorter one is taken (`_shorten`).
    2. The amplitudes do not follow the slider yet: they move alone (`_move_waves`).
    3. Otherwise the next step is Newton's, improved by Anderson's method (`_advance`). If the residuals stagnate, it
       starts at the best point so far, with new derivatives.

    After such a stagnation the search is careful: it shortens more, and lets the amplitudes follow after every step.
    """

    def __init__(self, equations: Equilibrium, active: list[int], side: float, close: float, careful: bool = False):
        self.equations, self.active, self.side, self.close = equations, active, side, close
        self.method, self.jacobian, self.slope = None, None, None
        self.before = self.step = self.best = None
        self.sizes: list[float] = []  # residuals and changes since the last derivatives
        self.last = self.last_change = self.least = self.reached = np.inf
        self.waits = self.shortenings = 0  # evaluations in which the amplitudes moved alone; shorter steps
        self.stagnations = int(careful)  # in a row without progress

    def run(self) -> float:
        """Change the active unknowns and the amplitudes until residuals and steps vanish; return the last step."""
        cycle = self.equations.cycle
        most = cycle.evaluations + MAX_EVALUATIONS
        while self.stagnations <= USELESS and cycle.evaluations < most:
            self._evaluate()
            if self.waits == WAIT and self.before is None:
                self.equations.begin()
                self.slope = None
            elif self._is_worse():
                self._shorten()
            elif self.waits:
                self._move_waves()
            else:
                self.sizes.append(max(self.size, self.change))
                if self._is_solved():
                    return self.change + self._last_step()
                self._advance()
        remaining = max(self.size, self.change)
        raise ConvergenceError(
            "not converged", f"height, tilts, velocity and the wave leave a residual of {remaining:.1e} of the preload"
        )

    @property
    def careful(self) -> bool:
        return self.stagnations > 0

    @property
    def _stale(self) -> bool:
        """True if the residuals have not fallen by FALL in PATIENCE steps."""
        return len(self.sizes) > PATIENCE and self.sizes[-1] > FALL * self.sizes[-PATIENCE - 1]

    def _evaluate(self):
        """Compute the residuals and the step of the amplitudes at the current point."""
        self._set_residual()
        follows = INNER * self.size if self.careful else (START if self.jacobian is None else np.inf)
        self.waits = self.waits + 1 if self.change > max(ROUNDING, follows) else 0
        if self.jacobian is None and len(self.equations.plane) > 1 and not self.waits and self.careful:
            self.equations.level()
            self._set_residual()

    def _set_residual(self):
        self.residual, self.wave_step = self.equations.residuals(self.active, self.side, self.slope)
        self.size, self.change = _largest(self.residual), _largest(self.wave_step)

    def _is_worse(self) -> bool:
        """True if the last step is to be shortened."""
        lost = not self.equations.forces.normal.any()  # without contact the residuals do not depend on H
        if self.step is None or self.shortenings >= (SHORTENINGS if self.careful or lost else 1):
            return False
        if self.waits:
            return self.careful and self.waits > WAIT
        return lost or self.size > max(self.last, 1e-9 if self.careful else max(FAR, self.change))

    def _shorten(self):
        self.step, self.shortenings, self.waits = SHORTER * self.step, self.shortenings + 1, 0
        self.equations.go_to(self.before + self.step, self.active)

    def _move_waves(self):
        """Move the amplitudes alone, by Newton's step if their change falls too slowly."""
        if self.change > SLOW * self.last_change:
            self.slope, self.wave_step = self.equations.newton_step()
        self.last_change = self.change
        step = self.equations.limited(0.0 * self.residual, self.wave_step)
        self.equations.go_to(self.equations.at(self.active) + step, self.active)

    def _last_step(self) -> float:
        """Return Newton's step of the unknowns from here, scaled."""
        step = self.residual if self.jacobian is None else np.linalg.pinv(self.jacobian) @ self.residual
        return _largest(step)

    def _is_solved(self) -> bool:
        if self.sizes[-1] < self.close:
            return True
        if not (self.careful and self._stale):
            return False
        rounded = self.size < MAX_RESIDUAL and self.change < ROUNDING and self._last_step() < CLOSE
        return self.sizes[-1] < ROUNDING or rounded

    def _advance(self):
        """Take the next step of all unknowns."""
        equations, stale = self.equations, self._stale
        if self.sizes[-1] < self.least:
            self.least, self.best = self.sizes[-1], equations.at(self.active)
        elif stale:
            equations.go_to(self.best, self.active)
            self.residual, _ = equations.residuals(self.active, self.side, None)
        if stale:
            progress = self.least < 0.9 * self.reached
            self.stagnations, self.reached = (0, self.least) if progress else (self.stagnations + 1, self.reached)
            self.slope, self.wave_step = equations.newton_step()
        if stale or self.jacobian is None:
            self.method = Anderson(equations.at(self.active).size, len(self.active))
            self.sizes, self.jacobian = [self.least], equations.jacobian(self.active)
        self.last, self.last_change = _largest(self.residual), self.change
        self.before, self.shortenings = equations.at(self.active), 0
        newton = _solved(self.jacobian, -self.residual)
        self.step = equations.limited(newton, self.wave_step, self.method, self.before)
        equations.go_to(self.before + self.step, self.active)
