r"""A sample of the asperities of a rough sphere on a flat half-space: their forces and contacts.

Asperity j is a spherical cap of the radius beta_j. It stands at (x_j, y_j) with the height s_j - r_j^2/2R above the
plane of the sphere's lowest point. Its approach is

    u_j = z + s_j - r_j^2/2R - sum_{l != j} P_l/(pi E r_jl),        P_j = (4/3) E sqrt(beta_j) max(u_j, 0)^(3/2):  (1)

the sphere's own compliance is the sum over the other asperities. Equation (1) holds while the contacts are small
against their distances. Where a contact has grown to the radius

    b_j = (pi/4) d_j,    d_j the distance of the nearest other asperity,

it has met its neighbours, and carries on as a flat punch of that radius, dP_j/du_j = 2 E b_j. Then (1) has one
solution for every z: it makes the elastic energy smallest, and the energy is convex. For the compliance of a contact of
radius a, 1/(2 E a), is that of a charged sphere of the radius 2 a/pi for itself, and spheres of the radii
2 b_j/pi <= d_j/2 do not overlap, so that the matrix of all compliances is positive definite (Newton's shell theorem).
At pi/4 the caps already overlap by geometry; a smaller share would change contacts that (1) still describes.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.exceptions import ConvergenceError, InputError
from contact.law.force_table import ForceTable
from contact.law.normal import SPHERE, stiffness
from contact.law.table import TabulatedForce
from contact.roots import bracketed

CLOSE = 1e-12  # residual of (1) over the largest approach at which Newton's method ends
MAX_NEAR = 2500  # asperities of a ball; a table of them takes about a minute
MERGED = 0.25 * math.pi  # radius over the distance of the nearest asperity from which a contact is a punch


ROWS = 24  # approaches of a ball at which the forces are solved, of a first table
FINE = 1024  # rows of the table of a ball's whole force
LAW_ROWS, LAW_PIECES = 192, 1024  # approaches of a ball that is tabulated as a normal law, and pieces of the table


class State(NamedTuple):
    """Asperities at one approach of the sphere."""

    approaches: np.ndarray  # u_j, m; negative where one does not touch
    rates: np.ndarray  # du_j/dz


class Rows(NamedTuple):
    """Asperities at equally spaced approaches of the sphere."""

    z: np.ndarray  # approaches of the sphere, m, shape (rows,)
    approaches: np.ndarray  # u_j, m, shape (rows, n)
    rates: np.ndarray  # du_j/dz, shape (rows, n)


@dataclass(frozen=True, kw_only=True)
class Asperities:
    """A sample of asperities.

    Attributes
    ----------
    x, y, heights : ndarray, shape (n,)
        Positions from the sphere's lowest point and heights above its mean surface, m; no two at one place.
    radius : float or ndarray, shape (n,)
        Of the asperities, m, positive.

    Examples
    --------
    Two asperities 1 um apart at an approach of 5 nm; the lower one carries less than it would alone:

    >>> pair = Asperities(x=[0.0, 1e-6], y=[0.0, 0.0], heights=[0.0, 0.0], radius=10e-6)
    >>> print(pair.forces(1e-3, 64e9, 5e-9))  # N
    [8.55920413e-05 7.01775551e-05]
    """

    x: np.ndarray
    y: np.ndarray
    heights: np.ndarray
    radius: float | np.ndarray

    def __post_init__(self):
        size = np.shape(np.atleast_1d(self.x))
        for name in ("x", "y", "heights", "radius"):
            values = np.atleast_1d(np.asarray(getattr(self, name), dtype=float))
            if name == "radius" and values.shape == (1,):
                values = np.full(size, values[0])
            if values.ndim != 1 or values.shape != size:
                raise InputError(f"asperities.{name}", "must be a list with one value for each asperity")
            for each in values[~np.isfinite(values)][:1]:
                parameter_check.finite(f"asperities.{name}", each, "m")
            object.__setattr__(self, name, values)
        for each in self.radius[self.radius <= 0.0][:1]:
            parameter_check.positive("asperities.radius", float(each), "m")
        for j in np.flatnonzero(self.nearest == 0.0)[:1]:
            raise InputError("asperities.x", f"must not hold two asperities at one place, as that of number {j + 1}")

    def __len__(self) -> int:
        return self.x.size

    def lowest(self, sphere_radius: float) -> float:
        """Return the approach in m at which the first asperity touches."""
        return -float(np.max(self.heights - (self.x**2 + self.y**2) / (2.0 * sphere_radius)))

    parting = lowest  # the approach in m at which the ball leaves the surface

    def ball(self, sphere_radius: float, effective_modulus: float, deepest: float) -> "RoughBall":
        """Return the sample on a sphere, up to an approach in m; refused where too many asperities are near."""
        ball = RoughBall(self, sphere_radius, effective_modulus, deepest)
        if len(ball.near) > MAX_NEAR:
            rule = f"must not bring more than {MAX_NEAR} asperities of a ball near the surface"
            raise InputError("sample", f"{rule}, got {len(ball.near)}: the mean field serves these")
        return ball

    @cached_property
    def nearest(self) -> np.ndarray:
        """Distance of the nearest other asperity of each, m, shape (n,); infinite for one alone."""
        from scipy.spatial import KDTree  # of samples alone: scipy is not imported where there is none

        if len(self) < 2:
            return np.full(len(self), np.inf)
        return KDTree(np.column_stack([self.x, self.y])).query(np.column_stack([self.x, self.y]), k=2)[0][:, 1]

    def forces(self, sphere_radius: float, effective_modulus: float, z: float) -> np.ndarray:
        """Return P_j of each asperity in N at an approach z in m of the sphere.

        Raises
        ------
        ConvergenceError
            If Newton's method does not find the forces.
        """
        ball = RoughBall(self, sphere_radius, effective_modulus, z)
        forces = np.zeros(len(self))
        forces[ball.near] = ball.forces(ball.at(z).approaches)
        return forces


class RoughBall:
    """The equations (1) of one sphere, for those asperities that may touch up to a largest approach.

    Parameters
    ----------
    sample : Asperities
    sphere_radius, effective_modulus : float
        R in m, E in Pa.
    deepest : float
        Largest approach z, m.

    Attributes
    ----------
    near : ndarray
        Numbers of these asperities in the sample: those that an undeformed sphere brings to touch; shape (n,).
    free : ndarray, shape (n,)
        u_j - z where nothing is carried, m.
    stiffness, merged : ndarray, shape (n,)
        (4/3) E sqrt(beta_j), N/m^1.5, and the approach b_j^2/beta_j from which on a contact is a punch, m.
    """

    def __init__(self, sample: Asperities, sphere_radius: float, effective_modulus: float, deepest: float):
        self._known: dict[tuple[float, float], tuple[np.ndarray, np.ndarray]] = {}
        free = sample.heights - (sample.x**2 + sample.y**2) / (2.0 * sphere_radius)
        near = self.near = np.flatnonzero(free + deepest > 0.0)
        x, y, self.free, radius = sample.x[near], sample.y[near], free[near], np.asarray(sample.radius)[near]
        self.stiffness = np.asarray(stiffness(radius, effective_modulus, SPHERE.shape), dtype=float)
        self.merged = (MERGED * sample.nearest[near]) ** 2 / radius
        distance = np.hypot(x[:, None] - x, y[:, None] - y)
        np.fill_diagonal(distance, np.inf)
        self._compliance = 1.0 / (math.pi * effective_modulus * distance)

    def forces(self, u: np.ndarray) -> np.ndarray:
        """Return P_j of approaches u_j, N."""
        cap = np.minimum(np.maximum(u, 0.0), self.merged)
        return self.stiffness * np.sqrt(cap) * (cap + 1.5 * np.maximum(u - self.merged, 0.0))

    def carries(self, force: float, z: float) -> bool:
        """Return whether the force of all at an approach z in m is at least one in N."""
        return float(self.forces(self.at(z).approaches).sum()) >= force

    @property
    def lowest(self) -> float:
        """Approach in m at which the first asperity touches."""
        return -float(np.max(self.free))

    def rows(self, deepest: float, doubling: int) -> Rows:
        """Return the asperities at equally spaced approaches up to one in m, `ROWS` doubled so many times."""
        number = ROWS * 2**doubling
        return Rows(np.linspace(self.lowest, deepest, number + 1), *self._rows(deepest, number))

    def force_table(self, deepest: float, doubling: int) -> ForceTable:
        """Return the force of all up to an approach in m, from `ROWS` solutions doubled so many times.

        Between them each u_j is a cubic in z.
        """
        between = self.between(deepest, ROWS * 2**doubling)
        fine, step = np.linspace(0.0, ROWS * 2**doubling, FINE + 1, retstep=True)
        force, slope = between(fine)
        spacing = (deepest - self.lowest) / (ROWS * 2**doubling)
        return ForceTable(force[None], step * slope[None], np.array([self.lowest]), np.array([step * spacing]))

    def between(self, deepest: float, rows: int) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
        """Return a function that gives the force of all in N, and its derivative, at a number of rows behind `lowest`.

        Between the rows, at which the forces are solved, each u_j is a cubic in z.
        """
        spacing = (deepest - self.lowest) / rows
        approaches, rates = self._rows(deepest, rows)

        def forces(place):
            row = np.clip(place.astype(int), 0, rows - 1)
            t, low, high = (place - row)[:, None], approaches[row], approaches[row + 1]
            rise, fall = spacing * rates[row], spacing * rates[row + 1]
            cubic, square = 2.0 * (low - high) + rise + fall, 3.0 * (high - low) - 2.0 * rise - fall
            u = low + t * (rise + t * (square + t * cubic))
            slopes = 1.5 * self.stiffness * np.sqrt(np.minimum(np.maximum(u, 0.0), self.merged))
            slopes *= rise + t * (2.0 * square + 3.0 * t * cubic)
            return self.forces(u).sum(axis=1), slopes.sum(axis=1)

        return forces

    def _rows(self, deepest: float, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Return the approaches and rates at so many rows behind `lowest`; every second one may be known already."""
        if (deepest, rows) in self._known:
            return self._known[deepest, rows]
        z = np.linspace(self.lowest, deepest, rows + 1)
        known = self._known.get((deepest, rows / 2))
        if known is None:
            states, near = [], None
            for each in z:
                states.append(self.at(float(each), near))
                near = states[-1].approaches + (z[1] - z[0]) * states[-1].rates
            approaches, rates = (np.array(each) for each in zip(*states, strict=True))
            found = approaches, rates
        else:
            found = np.repeat(known[0], 2, axis=0)[:-1], np.repeat(known[1], 2, axis=0)[:-1]
            between = 0.5 * (known[0][1:] + known[0][:-1]) + 0.25 * (z[1] - z[0]) * (known[1][:-1] - known[1][1:])
            for row, near in enumerate(between):
                state = self.at(float(z[2 * row + 1]), near)
                found[0][2 * row + 1], found[1][2 * row + 1] = state
        self._known = {(deepest, rows): found}
        return found

    def at(self, z: float, near: np.ndarray | None = None) -> State:
        """Return the state at an approach z in m; `near` are approaches u_j from which the search starts.

        (1) has continuous derivatives and its matrix is never singular, so that Newton's step always shortens the
        residual; it is halved until it does.

        Raises
        ------
        ConvergenceError
            If a hundred steps do not suffice.
        """
        free = self.free + z
        u = free.copy() if near is None else near
        bound = CLOSE * max(float(np.max(free, initial=0.0)), 1e-300)
        residual = u - free + self._compliance @ self.forces(u)
        for _ in range(100):
            if np.max(np.abs(residual), initial=0.0) <= bound:
                return State(u, self._solved(u, np.ones(u.size)))
            step = self._solved(u, -residual)
            for _ in range(40):
                trial = u + step
                left = trial - free + self._compliance @ self.forces(trial)
                if left @ left < residual @ residual:
                    break
                step = 0.5 * step
            else:
                if np.max(np.abs(residual)) <= 1e3 * bound:  # rounding
                    return State(u, self._solved(u, np.ones(u.size)))
                break
            u, residual = trial, left
        raise ConvergenceError("not converged", f"forces of {u.size} asperities at an approach of {z:.4g} m")

    def _solved(self, u: np.ndarray, right: np.ndarray) -> np.ndarray:
        """Return s with s + C dP/du s = `right`: a system of the asperities that touch, and the others by it."""
        touching = np.flatnonzero(u > 0.0)
        rates = 1.5 * self.stiffness[touching] * np.sqrt(np.minimum(u[touching], self.merged[touching]))
        columns = self._compliance[:, touching]
        # symmetric and positive definite in the forces: (1/P' + C) P' s = right
        matrix = columns[touching]
        matrix[np.diag_indices(touching.size)] = 1.0 / rates
        forces = np.linalg.solve(matrix, right[touching])
        solution = right - columns @ forces
        solution[touching] = forces / rates
        return solution


def sample_force(
    samples: Sequence[Asperities], sphere_radius: float, effective_modulus: float, *, share: float, deepest: float
) -> TabulatedForce:
    """Return the mean normal force of balls with these samples as a normal law of one ball.

    Each ball stands at the approach at which it carries a `share` of the preload in N, as statics demands of three
    balls. Balls that then move alike are together as many of this one, also with the memory of Mindlin and Deresiewicz,
    in which all layers of one depth slip alike. Approaches go up to `deepest` in m.
    """
    balls = [each.ball(sphere_radius, effective_modulus, deepest) for each in samples]
    forces = [each.between(deepest, LAW_ROWS) for each in balls]

    def force(k, z):
        place = (z - balls[k].lowest) / (deepest - balls[k].lowest) * LAW_ROWS
        return np.where(place > 0.0, forces[k](place)[0], 0.0)

    every = range(len(balls))
    rest = [
        bracketed(lambda z, k=k: float(force(k, np.array([z]))[0]) - share, balls[k].lowest, deepest, tolerance=1e-15)
        for k in every
    ]
    begin = min(ball.lowest - at for ball, at in zip(balls, rest, strict=True))
    end = deepest - max(rest) - begin
    # every asperity that touches is a kink of the curvature: the error counts where a hundredth of the load is carried
    share_of_end = (2.0**0.5 - 1.0) * np.linspace(0.0, 1.0, 2 * LAW_PIECES + 1)
    z = end * share_of_end * (2.0 + share_of_end)
    mean = sum(force(k, z + begin + rest[k]) for k in every) / len(balls)
    mean[0] = 0.0
    table = TabulatedForce(end, end, mean[::2] ** (2.0 / 3.0), "sphere", 0.0)
    missed = np.abs(table.middles**1.5 - mean[1::2]) / np.maximum(mean[1::2], 0.01 * share)
    return replace(table, error=float(np.max(missed)))
