r"""The full motion of a slider in the plane, event by event: height, velocity, yaw and the deformation of each contact.

A slider whose tilt is free keeps the tilts at which the mean loads of the continuous wave have their moments; their
motion within a cycle is left out.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from contact.answers.ledger import Ledger
from contact.codes import Regime
from contact.exceptions import ConvergenceError
from contact.law import normal
from contact.law.elastic import spring_work
from contact.plane.averaged import Averaged
from contact.plane.disc_contacts import State, Sum, Total, Work, follow, state_of, work_of
from contact.plane.plane_equations import Body, Knots, PlaneProblem, Surface, fill_surface
from contact.plane.plane_waves import SurfaceWaves
from contact.plane.scaling import Scaled, scaled
from contact.plane.wave_shape import WaveShape
from contact.roots import bracketed
from contact.slider import Slider

SATURATED = 40.0  # time constants after which an envelope is 1 to rounding


def with_heights(slider: Slider, waves: SurfaceWaves, units: Scaled) -> Scaled:
    """Return the problem with the heights of contacts on a body that is tilted by the mean loads."""
    if slider.tilt == "held":
        return units
    averaged = Averaged.of(slider, waves)
    tilted = averaged.problem.height - averaged.height
    height = (tilted - tilted.mean()) * (averaged.scaled.length / units.length)
    return units._replace(problem=units.problem._replace(height=np.ascontiguousarray(height)))


def rest_position(problem, force: float | None = None) -> float:
    """Return z_s at which the contacts carry the preload, or another force, without a wave, scaled."""
    target = -problem.force[0] if force is None else force
    most = float(normal.approach(target / problem.stiffness.min(), problem.normal))

    def left(z_s):
        return float((problem.stiffness * normal.load(problem.height - z_s, problem.normal)).sum()) - target

    return float(bracketed(left, float(problem.height.min()) - most, float(problem.height.max())))


def rest_deformations(problem, z_s: float) -> np.ndarray:
    """Return the deformations (n, 2) with which contacts of a slider at rest carry its load, or their limits.

    Contacts that are sheared together carry Q = mu (P - P'), P' at an approach that is smaller by |e|/c (Ciavarella
    1998); those of different c are sheared in proportion. A torque is left to the first cycles.
    """
    load = -problem.force[1:3]
    size = float(np.hypot(*load))
    if size == 0.0:
        return np.zeros((problem.x.size, 2))
    reduced = max(-problem.force[0] - size / problem.friction, 0.0)
    shift = rest_position(problem, reduced) - z_s
    z = np.maximum(problem.height - z_s, 0.0)
    return (problem.limit_slope * np.minimum(z, shift))[:, None] * (load / size)


def clipped(deformations: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Return deformations (n, 2) within limits (n,)."""
    size = np.hypot(*deformations.T)
    return deformations * np.minimum(1.0, np.divide(limits, size, out=np.ones_like(size), where=size > 0.0))[:, None]


def without_waves(problem: PlaneProblem) -> PlaneProblem:
    """Return the problem on a surface at rest."""
    return problem._replace(cos=np.zeros_like(problem.cos), sin=np.zeros_like(problem.sin))


def begun_later(problem: PlaneProblem, shift: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the amplitudes `cos` and `sin` of the same waves whose phase is counted from a later one."""
    turn = np.exp(-1j * problem.ratio * shift)[:, None, None] * (problem.cos + 1j * problem.sin)
    return np.ascontiguousarray(turn.real), np.ascontiguousarray(turn.imag)


@dataclass
class FullMotion:
    """A motion in time: the scaled problem, the state, and work arrays of one accuracy."""

    units: Scaled
    state: State
    work: Work
    begun: float  # energy of contacts, preload and slider at the start, scaled
    from_place: np.ndarray  # q at the start
    phase_before: float = 0.0  # phase and place at which those of the state begin
    place_before: np.ndarray = field(default_factory=lambda: np.zeros(3))

    @classmethod
    def at_rest(cls, units: Scaled, how: tuple[int, float], *, warm: bool = False) -> "FullMotion":
        """Return the motion of a slider that stands on the surface when the waves begin.

        ``warm``: True where the events of one period of the waves tell those of the next (`last_period`).
        """
        problem = units.problem
        n = problem.x.size
        state, work = state_of(n), work_of(n, *how, units.period if warm else 0.0)
        state.q[Body.HEIGHT] = rest_position(problem)
        surface = np.zeros((n, 6))
        fill_surface(problem, 0, n, 0.0, surface)
        approach = problem.height + surface[:, Surface.Z] - state.q[Body.HEIGHT]
        state.regime[:] = np.where(approach > 0.0, Regime.STICK, Regime.SEPARATED)
        deformations = rest_deformations(problem, state.q[Body.HEIGHT])
        state.e[:] = clipped(deformations, problem.limit_slope * np.maximum(approach, 0.0))
        motion = cls(units, state, work, 0.0, state.q.copy())
        motion.begun = motion.energy()
        return motion

    def follow(self, phase: float) -> None:
        """Move up to a phase; raise a ConvergenceError where a segment does not converge."""
        if not follow(self.units.problem, 0, self.units.problem.x.size, phase, self.state, self.work):
            raise ConvergenceError("not converged", "a segment of the motion in the plane was not solved")

    @property
    def phase(self) -> float:
        """Phase since the start."""
        return self.phase_before + float(self.state.total[Total.PHASE])

    @property
    def place(self) -> np.ndarray:
        """(x, y, yaw) since the start, scaled."""
        return self.state.q[Body.X :] + self.place_before

    def restarted(self) -> "FullMotion":
        """Return the motion with phase and place counted from here; an envelope is kept until it no longer rises.

        Guards are known to 1e-12, to which 1e3 cycles and a way of 1e4 lengths are rounded.
        """
        problem, state = self.units.problem, self.state
        first = SATURATED * problem.rise
        shift = float(state.total[Total.PHASE]) - first
        if shift <= 0.0 or (problem.rise > 0.0 and state.total[Total.PHASE] > problem.stop):
            return self
        moved = np.array([*state.q[Body.X : Body.YAW], 0.0])
        state.total[Total.PHASE] = first
        state.q[Body.X :] -= moved
        self.from_place[Body.X :] -= moved
        cos, sin = begun_later(problem, shift)
        problem = problem._replace(cos=cos, sin=sin, stop=problem.stop - shift, knots=_later(problem.knots, shift))
        return replace(
            self, units=self.units._replace(problem=problem), phase_before=self.phase_before + shift,
            place_before=self.place_before + moved,
        )  # fmt: skip

    def silenced(self) -> "FullMotion":
        """Return the motion on a surface that is at rest at once."""
        return self.on(without_waves(self.units.problem))

    def on(self, problem: PlaneProblem) -> "FullMotion":
        """Return the motion on other waves from this instant; contacts that touch keep their deformation."""
        state, before = self.state, self.energy()
        surface = np.zeros((problem.x.size, 6))
        fill_surface(problem, 0, problem.x.size, state.total[Total.PHASE], surface)
        approach = problem.height + surface[:, Surface.Z] - state.q[Body.HEIGHT]
        state.regime[:] = np.where(approach > 0.0, Regime.STICK, Regime.SEPARATED)
        state.begins[:] = 0
        state.e[:] = clipped(state.e, problem.limit_slope * np.maximum(approach, 0.0))
        changed = replace(self, units=self.units._replace(problem=problem))
        changed.begun += changed.energy() - before  # what the jump of the surface gives
        return changed

    def energy(self) -> float:
        """Return the energy of springs, preload and slider, scaled, with the work of load and torque left out."""
        problem, state = self.units.problem, self.state
        surface = np.zeros((problem.x.size, 6))
        fill_surface(problem, 0, problem.x.size, state.total[Total.PHASE], surface)
        z = np.maximum(problem.height + surface[:, Surface.Z] - state.q[Body.HEIGHT], 0.0)
        touching = (state.regime != Regime.SEPARATED) & (z > 0.0)
        stored = problem.stiffness * normal.energy(z, problem.normal)
        size, c = np.hypot(*state.e.T), problem.limit_slope
        for i in np.flatnonzero(touching & (c > 0.0)):
            friction = problem.friction * problem.stiffness[i]
            stored[i] += spring_work(z[i], min(size[i], c[i] * z[i]), friction, c[i], problem.normal)
        moving = problem.inverse > 0.0
        kinetic = 0.5 * float((state.p[moving] ** 2 / problem.inverse[moving]).sum())
        return float(stored[touching].sum()) - problem.force[0] * state.q[Body.HEIGHT] + kinetic

    def ledger(self) -> Ledger:
        """Return the energies since the start, J; the increase of all stored energies is in `stored`."""
        problem, state = self.units.problem, self.state
        unit = self.units.force * self.units.length
        sums = state.sums.sum(axis=0)
        load = -float(problem.force[1:] @ (state.q - self.from_place)[1:])
        parts = dict.fromkeys(Ledger._fields, 0.0) | {
            "wave_normal": sums[Sum.WAVE_NORMAL], "wave_tangential": sums[Sum.WAVE_TANGENTIAL],
            "slip": sums[Sum.SLIP], "contact_damper": sums[Sum.DAMPER],
            "normal_damper": state.total[Total.LOST_NORMAL], "tangential_damper": state.total[Total.LOST_TANGENTIAL],
            "load": load, "leak": sums[Sum.LEAK], "stored": self.energy() - self.begun,
        }  # fmt: skip
        return Ledger(**{name: float(unit * value) for name, value in parts.items()})


def _later(knots: Knots, shift: float) -> Knots:
    """Return the knots with the phase counted from a later one, but for those that have passed."""
    past = max(int(np.searchsorted(knots.at, shift, side="right")) - 1, 0)
    return Knots(
        knots.at[past:] - shift, *(np.ascontiguousarray(each[:, past:]) for each in (knots.amplitude, knots.angle))
    )


def motion_at_rest(
    slider: Slider, waves: SurfaceWaves, how, *, rise: float, stop: float, warm: bool = False,
    shape: WaveShape | None = None,
) -> FullMotion:  # fmt: skip
    """Return the full motion of a slider at rest on waves that begin at time 0; rise time and stop in s.

    Without a rise time the waves go on: `FullMotion.silenced` ends them.
    """
    return FullMotion.at_rest(units_at_rest(slider, waves, rise=rise, stop=stop, shape=shape), how, warm=warm)


def followed_from_rest(
    follow: Callable[["FullMotion"], Any], slider: Slider, waves: SurfaceWaves, how, *, rise: float, stop: float,
    shape: WaveShape | None = None,
) -> Any:  # fmt: skip
    """Return what `follow` makes of `motion_at_rest`; a warm start saves 3/4 of the time, and fails rarely."""
    try:
        return follow(motion_at_rest(slider, waves, how, rise=rise, stop=stop, warm=True, shape=shape))
    except ConvergenceError:
        return follow(motion_at_rest(slider, waves, how, rise=rise, stop=stop, shape=shape))


def units_at_rest(
    slider: Slider, waves: SurfaceWaves, *, rise: float, stop: float, shape: WaveShape | None
) -> Scaled:  # fmt: skip
    """Return the problem of `motion_at_rest`; a free tilt is that of the mean square of shaped waves."""
    units = scaled(
        slider, waves, heavy=False, rise=rise, stop=stop if rise > 0.0 else math.inf, commensurable=False,
        knots=None if shape is None else shape.knots,
    )  # fmt: skip
    if shape is not None:
        waves = replace(waves, amplitudes=waves.amplitudes * shape.root_mean_square[:, None, None])
    return with_heights(slider, waves, units)
