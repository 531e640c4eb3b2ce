r"""Fixed steps: the Verlet method, and the projection of each deformation onto the disc of radius c z.

In a step e moves with the surface, e* = e + u_t(new) - u_t(old) - (the slider's way), and is cut back to c z e*/|e*|
where it is longer (Moreau's catching-up algorithm). In the step in which a contact touches only the fraction after
z = 0 counts, else the order drops. First order in the step.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from contact.exceptions import ConvergenceError
from contact.jit.compiled import native
from contact.law.elastic import spring_force
from contact.law.normal import load
from contact.plane.full_motion import clipped, rest_deformations, rest_position, without_waves
from contact.plane.plane_equations import Body, PlaneProblem, Surface, fill_surface, turned_by
from contact.plane.scaling import Scaled


class StepState(NamedTuple):
    """State and work arrays."""

    q: np.ndarray  # (4,)
    p: np.ndarray  # (4,)
    force: np.ndarray  # (4,): of the contacts
    e: np.ndarray  # (n, 2)
    before: np.ndarray  # (n, 6): surface
    after: np.ndarray  # (n, 6)
    z: np.ndarray  # (n,)
    total: np.ndarray  # (1,): phase


@native("t f i t")
def take_steps(problem, length, steps, state):
    """Take so many steps of a length in phase; return 1 where the motion stays finite."""
    q, p, force, e, n = state.q, state.p, state.force, state.e, problem.x.size
    for _ in range(steps):
        phase = state.total[0] + length
        fill_surface(problem, 0, n, phase, state.after)
        for k in range(4):
            push = problem.inverse[k] * (force[k] + problem.force[k] - problem.damping[k] * p[k])
            p[k] += 0.5 * length * push
        way_x, way_y, yaw = length * p[Body.X], length * p[Body.Y], q[Body.YAW]
        for k in range(4):
            q[k] += length * p[k]
            force[k] = 0.0
        c, s = np.cos(q[Body.YAW]), np.sin(q[Body.YAW])
        for i in range(n):
            new = state.after[i]
            x, y = c * problem.x[i] - s * problem.y[i], s * problem.x[i] + c * problem.y[i]
            turn_x, turn_y = turned_by(problem, i, yaw, q[Body.YAW])
            d_x = new[Surface.X] - state.before[i, Surface.X] - way_x - turn_x
            d_y = new[Surface.Y] - state.before[i, Surface.Y] - way_y - turn_y
            z_old, z = state.z[i], problem.height[i] + new[Surface.Z] - q[Body.HEIGHT]
            state.z[i] = z
            for k in range(6):
                state.before[i, k] = new[k]
            if z <= 0.0:
                e[i, 0] = e[i, 1] = 0.0
                continue
            share = z / (z - z_old) if z_old < 0.0 else 1.0
            e[i, 0] += share * d_x
            e[i, 1] += share * d_y
            size, limit = np.hypot(e[i, 0], e[i, 1]), problem.limit_slope[i] * z
            if size > limit:
                e[i, 0] *= limit / size
                e[i, 1] *= limit / size
                size = limit
            elastic = problem.stiffness[i] * load(z, problem.normal)
            rate = new[Surface.Z_RATE] - p[Body.HEIGHT]
            force[Body.HEIGHT] += elastic * (1.0 + problem.contact_damping * rate)
            if size > 0.0:
                friction = problem.friction * problem.stiffness[i]
                q_size = spring_force(z, size, friction, problem.limit_slope[i], problem.normal) / size
                force[Body.X] += q_size * e[i, 0]
                force[Body.Y] += q_size * e[i, 1]
                force[Body.YAW] += q_size * (x * e[i, 1] - y * e[i, 0])
        for k in range(4):
            push = problem.inverse[k] * (force[k] + problem.force[k])
            half = 0.5 * length * problem.inverse[k] * problem.damping[k]
            p[k] = (p[k] + 0.5 * length * push) / (1.0 + half)
        state.total[0] = phase
    return 1 if np.isfinite(p[0] + p[1] + p[2] + p[3]) else 0


@dataclass
class FixedSteps:
    """A motion in fixed steps."""

    units: Scaled
    state: StepState
    per_cycle: int

    @classmethod
    def at_rest(cls, units: Scaled, per_cycle: int) -> "FixedSteps":
        """Return the motion of a slider that stands on the surface when the waves begin."""
        problem, n = units.problem, units.problem.x.size
        state = StepState(
            np.zeros(4), np.zeros(4), np.zeros(4), np.zeros((n, 2)), np.zeros((n, 6)), np.zeros((n, 6)),
            np.zeros(n), np.zeros(1),
        )  # fmt: skip
        state.q[Body.HEIGHT] = rest_position(problem)
        fill_surface(problem, 0, n, 0.0, state.before)
        state.z[:] = problem.height + state.before[:, Surface.Z] - state.q[Body.HEIGHT]
        deformations = rest_deformations(problem, state.q[Body.HEIGHT])
        state.e[:] = clipped(deformations, problem.limit_slope * np.maximum(state.z, 0.0))
        state.force[1:3] = -problem.force[1:3] if deformations.any() else 0.0
        state.force[0] = float((problem.stiffness * load(state.z, problem.normal)).sum())
        return cls(units, state, per_cycle)

    @property
    def phase(self) -> float:
        """Phase since the start."""
        return float(self.state.total[0])

    @property
    def place(self) -> np.ndarray:
        """(x, y, yaw) since the start, scaled."""
        return self.state.q[Body.X :]

    def restarted(self) -> "FixedSteps":
        """Return the motion itself: it locates no events."""
        return self

    def silenced(self) -> "FixedSteps":
        """Return the motion on a surface that is at rest at once; contacts that touch keep their deformation."""
        return self.on(without_waves(self.units.problem))

    def on(self, problem: PlaneProblem) -> "FixedSteps":
        """Return the motion on other waves from this instant."""
        state = self.state
        fill_surface(problem, 0, problem.x.size, state.total[0], state.before)
        state.z[:] = problem.height + state.before[:, Surface.Z] - state.q[Body.HEIGHT]
        return replace(self, units=self.units._replace(problem=problem))

    def follow(self, phase: float) -> None:
        """Move up to a phase, in steps as long as `per_cycle` allows."""
        left = phase - self.state.total[0]
        steps = max(1, int(np.ceil(left * self.per_cycle / (2.0 * np.pi) * (1.0 - 1e-12))))
        if not take_steps(self.units.problem, left / steps, steps, self.state):
            raise ConvergenceError("not converged", "the motion in fixed steps is not finite: take method exact")
        self.state.total[0] = phase
