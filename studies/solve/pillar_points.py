"""The points of a run with a slider on pillars: velocity, wave, powers and contact ratios at each level of drive."""

import math
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

import contact
from studies.model import pillars
from studies.model.contact import Contact
from studies.model.scene_errors import slider_keys
from studies.record.point import Point
from studies.record.status import Status
from studies.solve.event_counts import burst_values
from studies.solve.point_answer import PointAnswer
from studies.solve.velocity_error import judged

SENSITIVITY_STEP = 1e-3  # relative step of the amplitude
HOPS = 0.999  # mean fraction of the cycle in contact below which the motion counts as intermittent
SHOWN_OVERTONES = 7  # largest number of overtones in slider_wave.csv
SAMPLES = 200  # instants of a stored burst
RATE_TOLERANCE = 3e-5  # relative tolerance of the averaged velocity in a burst


@dataclass(frozen=True, kw_only=True)
class PillarContact:
    """A slider on pillars and the incident waves below it, per unit of the drive level."""

    driven: Contact = field(repr=False)
    pillars: object  # contact.Pillars
    wave: Any  # contact.PassingWave at a level of 1
    misfit: float  # rms misfit of two plane waves to the surface motion, relative to the larger wave

    @classmethod
    def of(cls, driven: Contact) -> "PillarContact":
        """Return the pillars and the wave of a `Contact`, which caches the wave of a stator."""
        scene, slider = driven.scene, driven.scene.slider
        wave, misfit = (pillars.prescribed_wave(scene), 0.0) if scene.wave is not None else driven.passing
        return cls(driven=driven, pillars=pillars.pillars_of(slider), wave=wave, misfit=misfit)

    def at(self, level: float):
        """Return the `contact.PassingWave` at a level."""
        return replace(self.wave, forward=self.wave.forward * level, backward=self.wave.backward * level)

    def motion(self, level: float, load: float | None = None, near=None):
        """Return the `contact.PillarMotion` at a level.

        ``load`` in N replaces the load of the scene; ``near`` is a similar motion, used as a warm start.
        """
        slider, wave = self.driven.scene.slider, self.at(level)
        load = slider.load if load is None else load
        with slider_keys():
            return contact.pillar_motion(self.pillars, wave, load=load, loading=slider.loading, near=near)

    def load_line(self, level: float, points: int):
        """Return the `contact.PillarLoadLine` at a level."""
        loading = self.driven.scene.slider.loading
        with slider_keys():
            return contact.pillar_load_line(self.pillars, self.at(level), points=points, loading=loading)

    def sensitivity(self, level: float, motion) -> float:
        """Return the relative change of the velocity divided by the relative change of the wave amplitude."""
        velocity = motion.velocity
        if velocity == 0.0:
            return 0.0
        other = self.motion(level * (1.0 + SENSITIVITY_STEP), near=motion).velocity
        return abs(other - velocity) / (SENSITIVITY_STEP * abs(velocity))


def pillar_velocity(driven: Contact, level: float) -> float:
    """Return the velocity at a level in m/s without its error; NaN if the solver does not converge."""
    try:
        return PillarContact.of(driven).motion(level).velocity
    except contact.ConvergenceError:
        return math.nan


def moves(driven: Contact, level: float) -> bool:
    """Return whether the slider moves at a level."""
    return abs(pillar_velocity(driven, level)) > 0.0


def point_of(motion) -> Point:
    """Return the values of a point of run.json from a `contact.PillarMotion`."""
    slips = "slip" if motion.share_in_contact == 1.0 and motion.duty > HOPS else "intermittent"
    point = Point(
        velocity_m_per_s=motion.velocity, regime="stick" if motion.held else slips, approach_m=motion.approach,
        tilt_rad=list(motion.tilt), share_in_contact=motion.share_in_contact, duty=motion.duty,
        friction_power_W=motion.friction_power, thrust_power_W=motion.thrust_power,
        exit_over_entry=motion.exit_over_entry, reflected_over_entry=motion.reflected_over_entry,
    )  # fmt: skip
    if motion.wave.compliance > 0.0:
        point |= Point(
            wave_power_in_W=motion.wave_power_in, wave_power_out_W=motion.wave_power_out,
            loading_number=motion.loading_number, overtone_ratio=motion.overtone, harmonics=motion.harmonics,
        )  # fmt: skip
    return point | Point(ledger_relative_residual=abs(motion.ledger_residual))


def at_the_transducers(body: PillarContact, motion, level: float) -> Point:
    """Return the effects of the loaded wave on the transducers, as values of a point.

    The first effect is the change of admittance of the driven transducer. By reciprocity, a force F on the stator
    causes the current i omega F u/V in a transducer that moves the point of the force by u at a voltage V
    (tests/fem/solve/test_forced.py). Here F are the forces of the loaded wave and u is the motion of the wave without
    the slider. The second effect is that receivers behind the slider get the wave multiplied by `exit_over_entry`.
    The wave that the transducers send back after a reflection at the slider is neglected; it is of second order.
    """
    wave, scene = motion.wave, body.driven.scene
    if scene.stator is None or not motion.loading:
        return Point()
    backward_change, forward_change = motion.backward[0] - wave.backward, motion.forward[-1] - wave.forward
    # sum (P_1 u_z + Q_1 u_x) i Gamma/w
    reaction = wave.forward * backward_change + wave.backward * forward_change
    change = -wave.omega * wave.strip_width / wave.compliance * reaction / level**2
    direction = 1.0 if abs(wave.forward) >= abs(wave.backward) else -1.0
    centre, driven = scene.slider.center[0], scene.drive.driven
    behind = (each for each in scene.transducer if (each.center_xy[0] - centre) * direction > 0.0)
    received = motion.exit_over_entry if any(not driven.get(each.name) for each in behind) else None
    return Point(admittance_change_S=change, received_over_free=received)


def pillar_tables(motion) -> dict[str, dict]:
    """Return the columns of pillars.csv and of slider_wave.csv, by the name of the table."""
    body = motion.pillars
    of_pillars = {
        "x_m": np.array(body.x), "y_m": np.array(body.y), "height_m": np.array(body.heights),
        "normal_force_N": motion.normal_force, "friction_power_W": motion.friction,
    }  # fmt: skip
    of_wave = {"x_m": motion.row_x, "forward_m": motion.forward, "backward_m": motion.backward}
    of_wave |= {f"overtone_{n}_m": each for n, each in enumerate(motion.overtones.T[:SHOWN_OVERTONES], start=2)}
    return {"pillars": of_pillars, "slider_wave": of_wave}


def pillar_point(driven: Contact, level: float, tolerance: float, *, bursting: bool) -> PointAnswer:
    """Return the answer at a level."""
    if level == 0.0:
        rest = Point(velocity_m_per_s=0.0, regime="stick", relative_error=0.0, status=Status.OK.value)
        return PointAnswer(point=rest)
    body = PillarContact.of(driven)
    motion = body.motion(level)
    point, trajectory = point_of(motion) | at_the_transducers(body, motion, level), None
    # of the velocity over its reference speed
    sensitivity = body.sensitivity(level, motion) * (abs(motion.velocity) / motion.speed_scale)
    from_stator, from_contact = driven.stator_error * sensitivity, motion.relative_error
    if bursting and driven.scene.burst is not None:
        trajectory = burst(body, level, motion, driven.scene.burst)
        point |= burst_values(trajectory) | Point(burst_method=trajectory.method)
        from_contact = max(from_contact, trajectory.relative_error)
    point |= Point(amplitude_sensitivity=sensitivity) | judged(tolerance, from_stator, from_contact)
    return PointAnswer(
        point=point, from_stator=from_stator, from_contact=from_contact, trajectory=trajectory, motion=motion
    )


@dataclass(frozen=True, kw_only=True)
class PillarBurst:
    """Averaged motion of a slider on pillars over a burst; time in s, velocity in m/s, normal position in m."""

    time: np.ndarray
    velocity: np.ndarray
    position: np.ndarray
    duration: float
    velocity_at_burst_end: float
    relative_error: float
    method: str = "averaged"
    rang: float = 0.0
    displacement: np.ndarray | None = None  # only along a track (contact.Trajectory), which pillars have none of


def burst(body: PillarContact, level: float, steady, duration: float) -> PillarBurst:
    """Integrate m v' = sum <Q>(v, U(t)) - R_t v - load through a burst and until the slider stops after it.

    The wave grows with the ring-up of the stator. Height and tilts are quasi-static, so that there is no bounce.
    """
    from scipy.integrate import solve_ivp

    slider, ringing, load = body.driven.scene.slider, body.driven.ringing, steady.load
    envelope = None if ringing is None else ringing.envelope
    traction = contact.pillar_traction(body.pillars, body.at(level), load=load, near=steady)

    def rate(time, velocity):
        size = 1.0 if envelope is None else float(np.interp(time, envelope.time, np.abs(envelope.amplitude)))
        if size < 1e-3:
            return [0.0]
        force = traction(velocity[0], size) - slider.damping.tangential * velocity[0] - load
        held = velocity[0] == 0.0 and force * math.copysign(1.0, steady.velocity) <= 0.0
        return [0.0 if held else force / slider.mass]

    time = np.linspace(0.0, duration, SAMPLES + 1)
    solution = solve_ivp(
        rate, (0.0, duration), [0.0], method="RK45", t_eval=time, rtol=RATE_TOLERANCE,
        atol=RATE_TOLERANCE * max(abs(steady.velocity), 1e-6), max_step=duration / 8,
    )  # fmt: skip
    if not solution.success:
        raise contact.ConvergenceError("not converged", f"the averaged velocity in the burst: {solution.message}")
    velocity = solution.y[0]
    end = float(velocity[-1])
    # without the wave, friction stops the slider; the load assists or opposes friction
    friction, sign = slider.static_coefficient * slider.preload_force, math.copysign(1.0, end)
    slowing = (friction + load * sign) / slider.mass
    if end != 0.0 and slowing > 0.0:
        after = np.linspace(0.0, 1.2 * abs(end) / slowing, SAMPLES // 4)[1:]
        slide = end - sign * slowing * after
        velocity = np.concatenate([velocity, np.where(slide * end > 0, slide, 0.0)])
        time = np.concatenate([time, duration + after])
    return PillarBurst(
        time=time, velocity=velocity, position=np.full(time.size, -steady.approach), duration=duration,
        velocity_at_burst_end=end, relative_error=10 * RATE_TOLERANCE,
    )  # fmt: skip


@lru_cache(64)
def bounce_ratio(slider, frequency: float) -> float:
    """Return the ratio of the contact resonance to the frequency of the wave."""
    stiffness = float(np.sum(pillars.pillars_of(slider).normal_stiffness))
    return math.sqrt(stiffness / slider.mass) / (2 * math.pi * frequency)
