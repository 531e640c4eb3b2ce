r"""Mean approaches of the contacts of a heavy slider: one height, or three unknowns where statics gives the loads.

The cycle mean of each contact's normal force depends on its mean approach alone. Of a body that keeps its tilts the sum
of the means is the preload; of one that tilts freely also their moments about x and y are those of the preload at its
point, which a load above the surface shifts.
"""

import numpy as np

from contact.averaged.riding import NODES as QUADRATURE
from contact.averaged.riding import load_means, mean_loads, quadrature
from contact.exceptions import ConvergenceError
from contact.jit.compiled import native
from contact.law import normal
from contact.plane.disc_contacts import solve_linear
from contact.plane.scaling import Scaled
from contact.slider import Slider

SAMPLES = 128  # per cycle of the fastest wave, to find where contacts touch and open
MAX_NEWTON = 200
LONGEST = 0.25  # of the scale of lengths: a step of a body that tilts
CLOSE, NEAR, PATIENT = 2e-15, 1e-12, 40  # of that scale: the last step, and the last one after so many
UNFOUND = "no mean height of the contacts carries the preload"
NODES = 32  # of Gauss and Legendre's rule in half a cycle


class NormalMeans:
    """Means of p(z) and dp/dz over the period for mean approaches of n contacts."""

    def __init__(self, scaled: Scaled):
        problem = scaled.problem
        self.normal, self.period, self.ratio = problem.normal, scaled.period, problem.ratio
        self.cos, self.sin = problem.cos[..., 2], problem.sin[..., 2]  # (w, n)
        self.harmonic = self.ratio.size == 1
        if self.harmonic:
            return
        cycles = round(self.period / (2.0 * np.pi))
        self.grid = np.linspace(0.0, self.period, SAMPLES * cycles, endpoint=False)
        self.rule = np.polynomial.legendre.leggauss(NODES)
        self.samples = self.surface(self.grid[:, None], slice(None))[0]  # (samples, n)

    def surface(self, phase, i):
        """Return u_z of contacts and its rate at phases."""
        angle = self.ratio * phase[..., None]
        c, s, a, b = np.cos(angle), np.sin(angle), self.cos[:, i].T, self.sin[:, i].T
        return (a * c + b * s).sum(-1), (self.ratio * (b * c - a * s)).sum(-1)

    def lowest(self):
        """Return the phases of the least approach of each contact."""
        if self.harmonic:
            return np.arctan2(self.sin[0], self.cos[0]) - np.pi
        return self.grid[self.samples.argmin(axis=0)]

    def __call__(self, z):
        """Return the means for mean approaches (n,): arrays (2, n)."""
        if self.harmonic:
            return mean_loads(z, np.hypot(self.cos[0], self.sin[0]), self.normal)
        return np.array([self._several(i, each) for i, each in enumerate(z)]).T

    def _several(self, i, z):
        """Return the means of contact i by Gauss's rule between its touches and openings."""
        value = z + self.samples[:, i]
        up = np.flatnonzero((value <= 0.0) & (np.roll(value, -1) > 0.0))
        down = np.flatnonzero((value > 0.0) & (np.roll(value, -1) <= 0.0))
        if up.size == 0 and value[0] <= 0.0:
            return 0.0, 0.0
        if up.size == 0:
            lowest = self.grid[value.argmin()]
            touch, opens = np.array([lowest]), np.array([lowest + self.period])
        else:
            down = down if down[0] > up[0] else np.append(down[1:], down[0])
            step = self.grid[1]
            touch, opens = (self._root(i, z, each * step, each * step + step) for each in (up, down))
            opens = np.where(opens < touch, opens + self.period, opens)
        # pieces of at most half a cycle, the square roots at their ends removed
        counts = np.ceil((opens - touch) / np.pi).astype(int)
        pieces = [np.linspace(first, last, n + 1) for first, last, n in zip(touch, opens, counts, strict=True)]
        begin, end = (np.concatenate([each[cut] for each in pieces]) for cut in (slice(None, -1), slice(1, None)))
        half, theta = 0.5 * (end - begin), 0.5 * np.pi * (self.rule[0] + 1.0)
        phase = begin[:, None] + half[:, None] * (1.0 - np.cos(theta))
        weight = half[:, None] * np.sin(theta) * self.rule[1] * (0.5 * np.pi / self.period)
        approach = z + self.surface(phase, i)[0]
        return tuple(float((weight * each(approach, self.normal)).sum()) for each in (normal.load, normal.slope))

    def _root(self, i, z, low, high):
        phase = 0.5 * (low + high)
        for _ in range(30):
            value, rate = self.surface(phase, i)
            new = phase - (z + value) / rate
            if np.abs(new - phase).max() < 1e-14 * self.period:
                break
            phase = np.clip(new, low, high)
        return phase


def approaches(slider: Slider, scaled: Scaled, means: NormalMeans, force=(0.0, 0.0)) -> np.ndarray:
    """Return z_s for each contact, scaled: its mean approach is its height less z_s.

    `force`: tangential force (x, y) of the contacts on the slider in N, which acts below a load at `load_height`.
    """
    problem, rows, target = scaled.problem, np.ones((1, scaled.problem.height.size)), np.array([1.0])
    if slider.tilt != "held":
        places = np.array(_from_centre(slider, scaled))
        arms = np.abs(places).max(axis=1)
        at = np.array(slider.preload_at) - slider.load_height * np.array(force) / slider.preload
        rows, target = np.vstack([rows, places / arms[:, None]]), np.append(target, at / (scaled.length * arms))
    target *= -problem.force[0]
    reach = np.hypot(means.cos, means.sin).sum(axis=0)
    rest = normal.approach(-problem.force[0] / float(problem.stiffness.sum()), problem.normal)
    # from an approach that is too large Newton's method falls monotonically to the height of a held body
    unknown = np.zeros(len(rows))
    unknown[0] = rest - problem.height.min()
    scale = float(reach.max() + abs(unknown[0])) + 1e-300
    if means.harmonic:
        system = np.empty((len(rows), len(rows) + 1))
        if not _find_unknown(
            np.ascontiguousarray(problem.height, float), reach, np.ascontiguousarray(problem.stiffness, float), rows,
            target, quadrature(QUADRATURE), problem.normal, scale, int(slider.tilt != "held"), system, unknown,
        ):  # fmt: skip
            raise ConvergenceError("not converged", UNFOUND)
        return -(unknown @ rows)
    for count in range(MAX_NEWTON):
        z = problem.height + unknown @ rows
        load, slope = means(z)
        residual = rows @ (problem.stiffness * load) - target
        matrix = (rows * (problem.stiffness * slope)) @ rows.T
        try:
            step = np.linalg.solve(matrix, residual)
        except np.linalg.LinAlgError:
            step = np.full(len(rows), np.nan)
        if not np.isfinite(step).all():
            break
        largest = np.abs(step).max()
        if slider.tilt != "held" and largest > LONGEST * scale:
            step *= LONGEST * scale / largest
        unknown = unknown - step
        if largest < CLOSE * scale or (count > PATIENT and largest < NEAR * scale):
            return -(unknown @ rows)
    raise ConvergenceError("not converged", UNFOUND)


@native("f1 f1 f1 f2 f1 t t f i f2 f1", {"height": "n", "reach": "n", "stiffness": "n", "rows": "k n", "target": "k",
                                         "unknown": "k"})  # fmt: skip
def _find_unknown(height, reach, stiffness, rows, target, rule, normal, scale, tilts, system, unknown):
    """Move the unknown heights and tilts to those on one harmonic wave by Newton's method; return 1 where found.

    ``system`` (k, k + 1): work array.
    """
    size = target.size
    for count in range(MAX_NEWTON):
        for m in range(size):
            for j in range(size + 1):
                system[m, j] = -target[m] if j == size else 0.0
        for i in range(height.size):
            z = height[i]
            for m in range(size):
                z += unknown[m] * rows[m, i]
            load, slope = load_means(z, reach[i], rule, normal)
            for m in range(size):
                system[m, size] += rows[m, i] * (stiffness[i] * load)
                for j in range(size):
                    system[m, j] += rows[m, i] * rows[j, i] * (stiffness[i] * slope)
        if not solve_linear(system):
            return 0
        largest = 0.0
        for m in range(size):
            largest = max(largest, abs(system[m, size]))
        if not largest < np.inf:
            return 0
        factor = LONGEST * scale / largest if tilts == 1 and largest > LONGEST * scale else 1.0
        for m in range(size):
            unknown[m] -= factor * system[m, size]
        if largest < CLOSE * scale or (count > PATIENT and largest < NEAR * scale):
            return 1
    return 0


def _from_centre(slider, scaled):
    """Return the positions of the contacts from the slider's centre, scaled."""
    about = slider.axis if slider.freedom == "axle" else (0.0, 0.0)
    return scaled.problem.x + about[0] / scaled.length, scaled.problem.y + about[1] / scaled.length
