r"""Averaged equilibrium of a slider on many contacts, coupled to the wave on which they act back.

The unknowns are the mean approach H of the slider's plane, its tilts theta about y and psi about x, and the velocity v.
They satisfy

    sum <P> = F,  sum <P> x = F x_F,  sum <P> y = F y_F,  sum <Q> = load + R_t v.

`pillar_cycle` computes the cycle means, including the weights. The contacts may differ in position, height, radius and
stiffness. A load that acts at a height b above the surface tilts the slider: it shifts x_F by -b load/F.

On a prescribed wave, `equilibrium` computes H first and then v. This is not possible here, because the wave amplitudes
at the rows depend on v, and H, theta and psi depend on these amplitudes. Newton's method with Broyden updates therefore
solves for all unknowns together. Each evaluation also iterates the amplitudes until their change is below `INNER` times
the residual. If Newton's method fails, `equilibrium.balanced_speed` searches v alone. This search also detects a held
slider: a contact that never slips at v = 0 depends on its history, so that sum <Q> has different limits for v -> 0 from
the two sides. The slider is held if the load lies between these limits.
"""

from dataclasses import dataclass, field

import numpy as np

from contact.averaged.cycle_mean import MeanForces
from contact.averaged.pillar_cycle import PillarCycle
from contact.convergence_error import ConvergenceError
from contact.law.normal import approach

CLOSE = 1e-12  # tolerance of the scaled residuals and of the change of the wave amplitudes
INNER = 1e-3  # the amplitudes are iterated until their change is below this times the residual
MAX_STEPS, MAX_SWEEPS = 80, 200
SLOW = 0.5  # ratio of successive changes above which the forces' derivatives are computed (anew)
# For a wave of many periods or a sum of 10^5 forces, rounding keeps the change of the amplitudes above CLOSE. A change
# below ROUNDING is accepted if it has not halved in STALE sweeps.
ROUNDING, STALE = 1e-10, 12
PATIENCE = 12  # the search stops if the residual does not fall to a third in this many steps, as at a kink (v = 0)
STEP = 1e-6  # of finite differences, of the scaled unknowns
MAX_MOVE = 1.0  # of a scaled unknown in one step
HEIGHT, PITCH, ROLL, SPEED = range(4)


@dataclass(frozen=True, kw_only=True)
class Balance:
    """Averaged equilibrium of a slider on pillars."""

    height: float | np.ndarray  # H, m; one value per row with a soft backing
    pitch: float  # rotation about y, rad; positive if the approach increases towards +x
    roll: float  # rotation about x, rad; positive if the approach increases towards +y
    w: float  # velocity over omega, m
    side: float  # sign of the velocity, or of the motion before it if the velocity is zero
    traction: float  # sum <Q>, N
    forces: MeanForces = field(repr=False)
    residual: float  # largest scaled residual
    change: float  # last relative change of the wave's amplitudes
    error: float  # estimated error of w, m, from the residuals and the last change


class Equilibrium:
    """Equations of one slider on one wave; each solution starts from the last one."""

    def __init__(self, cycle: PillarCycle):
        pillars, wave = cycle.pillars, cycle.wave
        self.cycle = cycle
        # load on the slider, N, and place (x, y) at which it and the preload act together, m
        self.load, self.preload_at = 0.0, pillars.preload_at
        self.preload, self.friction = pillars.preload, pillars.friction_coefficient * pillars.preload
        stiffness = float(np.sum(cycle.weight * cycle.k_n))
        rest = float(approach(self.preload / stiffness, cycle.shape))
        self.length = max(wave.amplitude, rest)
        self.speed = max(abs(wave.orbit) * wave.amplitude, 1e-3 * self.length)
        self.arm = np.array([max(float(np.ptp(each)), 1e-300) / 2.0 for each in (pillars.x, pillars.y)])
        tilts = {"held": (), "pitch": (PITCH,), "free": (PITCH, ROLL)}[pillars.tilt]
        self.soft = pillars.backing == "soft"
        self.plane = () if self.soft else (HEIGHT, *tilts)
        self.scale = np.array([self.length, *(self.length / self.arm), self.speed])
        share = cycle.sums(np.ones_like(cycle.x)) / pillars.number
        self.row_load = self.preload * share
        self.unknowns = np.zeros(4)
        self.rows = np.zeros(cycle.turn.size)
        if not self.soft:
            start = rest - float(cycle.height.min())
            self.unknowns[HEIGHT] = self._carrying(self.preload, start, lambda each: cycle.weight @ each)
        sign = abs(wave.forward) ** 2 - abs(wave.backward) ** 2
        self.unknowns[SPEED] = -0.6 * wave.orbit.imag * sign / max(wave.amplitude, 1e-300)
        self.residual = self.change = np.inf
        self.forces: MeanForces | None = None
        self.slope: np.ndarray | None = (
            None  # derivatives of the rows' forces, used if fixed-point sweeps converge too slowly
        )

    def _carrying(self, load, heights, sums):
        """Return H at which the contacts carry a load in N without tilt, at the current wave amplitudes.

        `sums` adds forces over all contacts, or over each row if every row has its own load and H. Newton's method
        converges from any H that is too large, because <P> is convex in H.
        """
        for _ in range(100):
            force, rate = (sums(each) for each in self.cycle.mean_normal(heights))
            step = (force - load) / rate
            heights = heights - step
            if np.max(np.abs(step)) < 1e-13 * self.length:
                break
        return heights

    def _row_heights(self):
        """Return H of each row under its share of the preload."""
        cycle = self.cycle
        rest = approach(self.row_load / cycle.sums(cycle.k_n), cycle.shape)
        heights = rest - np.minimum.reduceat(cycle.height, cycle.first)
        if self.forces is not None:  # the last heights are better initial values if they are still too large
            force = cycle.sums(next(cycle.mean_normal(self.rows)))
            heights = np.where(force >= self.row_load, self.rows, heights)
        return self._carrying(self.row_load, heights, cycle.sums)

    def _evaluate(self, unknowns, side: float):
        """Return the residuals of the four equations over F, F arm, F arm and mu F, at the current wave amplitudes."""
        cycle, pillars = self.cycle, self.cycle.pillars
        if self.soft:
            self.rows = self._row_heights()
        height = self.rows if self.soft else unknowns[HEIGHT]
        w = unknowns[SPEED]
        side = side if w == 0.0 else np.sign(w)
        self.place, self.moving = cycle.approaches(height, unknowns[PITCH], unknowns[ROLL]), (w, side)
        forces = cycle.forces(self.place, w, side)
        self.forces, P = forces, cycle.weight * forces.normal
        self.traction = float(np.sum(cycle.weight * forces.tangential))
        moments = [
            np.sum(P * place) - self.preload * at for place, at in zip((cycle.x, cycle.y), self.preload_at, strict=True)
        ]
        excess = self.traction - self.load - pillars.tangential_damping * w * cycle.wave.omega
        return np.array(
            [
                np.sum(P) / self.preload - 1.0, *(np.array(moments) / (self.preload * self.arm)),
                excess / self.friction,
            ]
        )  # fmt: skip

    def _settled(self, unknowns, side: float, active):
        """Iterate the wave amplitudes until their change is below `INNER` times the residuals; return these."""
        last, best, stale, self.at_rounding = np.inf, np.inf, 0, False
        for _ in range(MAX_SWEEPS):
            residual = self._evaluate(unknowns, side)[list(active)]
            self.residual = float(np.max(np.abs(residual), initial=0.0))
            self.change = self.cycle.advance(self.forces, self.slope)
            if self.change <= max(0.1 * CLOSE, INNER * self.residual):
                return residual
            # the force of a contact that touches briefly is very sensitive to the amplitude, so that sweeps oscillate
            if ROUNDING < self.change and self.change > SLOW * last:
                self._evaluate(unknowns, side)
                self.slope = self.cycle.tangent(self.place, *self.moving, self.forces)
            best, stale = (self.change, 0) if self.change < 0.5 * best else (best, stale + 1)
            self.at_rounding = self.change < ROUNDING and stale >= STALE
            if self.at_rounding:
                return residual
            last = self.change
        raise ConvergenceError(
            "not converged", f"the wave below the pillars still changes by {self.change:.1e} a sweep"
        )

    def _jacobian(self, unknowns, side, active, base):
        """Return the derivatives of the residuals by finite differences at constant wave amplitudes."""
        kept = self.cycle.forward.copy(), self.cycle.backward.copy()
        base = self._evaluate(unknowns, side)[list(active)]
        columns = []
        for k in active:
            step = STEP * self.scale[k]
            if k == SPEED and unknowns[k] != 0.0:  # away from v = 0, where the residual has a kink
                step *= np.sign(unknowns[k])
            moved = unknowns.copy()
            moved[k] += step
            columns.append((self._evaluate(moved, side)[list(active)] - base) / (step / self.scale[k]))
        self.cycle.forward, self.cycle.backward = kept
        return np.array(columns).T

    def solve(self, load: float, w: float | None = None, side: float = 0.0) -> Balance:
        """Return the equilibrium under a load, or at a fixed velocity over omega if `w` is given."""
        self.load, self.preload_at = load, self.cycle.pillars.preload_place(load)
        active = self.plane if w is not None else (*self.plane, SPEED)
        y = self.unknowns.copy()
        if w is not None:
            y[SPEED] = w
        y = self._newton(y, side, active)
        self.unknowns = y
        if w is None:
            side = np.sign(y[SPEED])
        return Balance(
            height=self.rows.copy() if self.soft else float(y[HEIGHT]), pitch=float(y[PITCH]), roll=float(y[ROLL]),
            w=float(y[SPEED]), side=float(side), traction=self.traction, forces=self.forces, residual=self.residual,
            change=self.change, error=self.error,
        )  # fmt: skip

    def _newton(self, y, side, active):
        """Return the unknowns at which the residuals vanish, by Newton's method with Broyden updates."""
        residual = self._settled(y, side, active)
        if not active:
            self.error = self.change * self.scale[SPEED]
            return y
        index, jacobian, poor, sizes = list(active), None, 0, []
        for _ in range(MAX_STEPS):
            size = float(np.max(np.abs(residual)))
            sizes.append(size)
            if len(sizes) > PATIENCE and size > 0.3 * sizes[-PATIENCE]:
                break
            if size < CLOSE and (self.change < CLOSE or self.at_rounding):
                self.error = self._left(jacobian, residual)
                return y
            if jacobian is None or poor > 2:
                jacobian, poor = self._jacobian(y, side, active, residual), 0
            try:
                step = -np.linalg.solve(jacobian, residual)
            except np.linalg.LinAlgError:
                raise ConvergenceError("not converged", "no pillar answers a change of the slider's height") from None
            step *= min(1.0, MAX_MOVE / float(np.max(np.abs(step))))
            kept = self.cycle.forward.copy(), self.cycle.backward.copy()
            for shorter in range(8):
                moved = y.copy()
                moved[index] += step * self.scale[index]
                after = self._settled(moved, side, active)
                touches = bool(self.forces.normal.any())  # without contact the residuals do not depend on H
                if touches and (float(np.max(np.abs(after))) < size or size < 1e-9):
                    break
                if shorter < 7:
                    step = 0.4 * step
                    self.cycle.forward, self.cycle.backward = kept[0].copy(), kept[1].copy()
            jacobian = jacobian + np.outer(after - residual - jacobian @ step, step) / (step @ step)
            poor = poor + 1 if float(np.max(np.abs(after))) > 0.3 * size else 0
            if shorter > 1:
                jacobian = None
            y, residual = moved, after
        if float(np.max(np.abs(residual))) < 1e-9 and self.change < 1e-9:
            self.error = self._left(jacobian, residual)
            return y
        raise ConvergenceError(
            "not converged", f"height, tilts and velocity leave a residual of {self.residual:.1e} of the preload"
        )

    def _left(self, jacobian, residual):
        """Return the estimated error of w in m, from the last residuals and the last change of the amplitudes."""
        if jacobian is None:
            return max(self.residual, self.change) * self.scale[SPEED]
        with np.errstate(all="ignore"):
            left = float(np.max(np.abs(np.linalg.pinv(jacobian) @ residual)))
        return (left + self.change) * self.scale[SPEED]
