"""Load lines of a slider in the plane: the stall force in each direction, and the speed against load or torque.

In the plane a stall is a curve: the slider, free to move across it, keeps its place along a direction under the force F
of that direction.  A rotor has one torque at which it stands.
"""

import logging
import math
from dataclasses import replace

import numpy as np

from contact import plane
from studies.model.wave_to_contact import Contact
from studies.progress import counted
from studies.record.plots import curve, finished
from studies.record.prefixes import key_axis, si
from studies.record.quantities import quantity
from studies.scene.plane_keys import AXLE
from studies.solve.plane_motor import PER_MINUTE, PlaneMotor, friction_torque
from studies.study_list import Answered, Panel, judged

LOGGER = logging.getLogger(__name__)

DIRECTIONS = 24  # of the stall curve: half a turn, since a force holds the slider along one line only
OF_TORQUE = "rotation"  # panel of a rotor


def plane_load_lines(driven: Contact, points: int, tolerance: float) -> Answered:
    """Return stall curve and load line at the largest level, or of a rotor its speed against torque."""
    level = max(driven.scene.levels)
    motor = PlaneMotor.of(driven, level, tolerance)
    motor = replace(motor, slider=replace(motor.slider, load=(0.0, 0.0), torque=0.0))
    title = f"{driven.scene.title}: {driven.scene.named(level)}"
    if motor.slider.freedom == AXLE:
        return _of_rotor(motor, points, title)
    return _of_slider(motor, points, title)


def _of_rotor(motor: PlaneMotor, points: int, title: str) -> Answered:
    stall, friction = plane.stall_torque(motor.slider, motor.waves), friction_torque(motor.slider)
    torque = np.linspace(0.0, 1.0, points)[:-1] * stall.value
    shown = counted(LOGGER, "speed against torque", torque)
    turning = [motor.state(slider=replace(motor.slider, torque=float(each))).yaw_rate for each in shown]
    rates, torque = np.append(turning, 0.0), np.append(torque, stall.value)
    best = int(np.argmax(np.abs(torque * rates)))
    findings = (
        judged("The rotor's speed falls with the torque.", "stall torque over that of the friction limit",
               abs(stall.value) / friction, low=0.0, high=1.0 + 1e-9,
               holds=bool(np.all(np.diff(np.abs(rates)) < 0.0)), expected="above 0, up to 1"),
    )  # fmt: skip
    answer = [
        ("without torque", f"{PER_MINUTE * rates[0]:.4g} turns per minute"),
        ("stall torque", f"{si(stall.value, 'N m', 4)} +- {si(stall.error, 'N m', 1)}"),
        ("power", f"at most {si(abs(torque[best] * rates[best]), 'W', 3)}, at {si(abs(torque[best]), 'N m', 3)}"),
    ]
    data = {"torque_N_m": np.abs(torque), "rotation_rpm": PER_MINUTE * np.abs(rates)}
    return [Panel(name=OF_TORQUE, title=title, data=data)], findings, answer


def _of_slider(motor: PlaneMotor, points: int, title: str) -> Answered:
    slider, share, waves = motor.slider, motor.scene.slider.share, motor.waves
    angles = np.linspace(0.0, math.pi, DIRECTIONS, endpoint=False)
    directions = counted(LOGGER, "stall in each direction", angles)
    stalls = [plane.stall(slider, waves, (math.cos(each), math.sin(each))) for each in directions]
    free = motor.state()
    along = free.velocity / max(float(np.hypot(*free.velocity)), math.ulp(0.0))
    blocked = plane.stall(slider, waves, tuple(along))
    loads = np.linspace(0.0, 1.0, points)[:-1] * blocked.value
    states = [motor.state(slider=replace(slider, load=tuple(float(each) * along)))
              for each in counted(LOGGER, "load line", loads)]  # fmt: skip
    speeds = np.append([float(state.velocity @ along) for state in states], 0.0)
    loads, limit = np.append(loads, blocked.value), slider.friction_coefficient * slider.preload
    force = np.array([each.value for each in stalls])
    findings = [
        judged("The speed falls with a load against it.", "stall force against the motion over mu times preload",
               blocked.value / limit, low=0.0, high=1.0 + 1e-9, holds=bool(np.all(np.diff(speeds) < 0.0)),
               expected="above 0, up to 1"),
    ]  # fmt: skip
    towards = math.degrees(math.atan2(along[1], along[0]))
    answer = [
        ("stall", f"{si(share * blocked.value, 'N', 4)} against the motion, {towards:.4g} deg from x"),
        ("in any direction", f"{si(share * force.min(), 'N', 4)} to {si(share * force.max(), 'N', 4)}"),
    ]  # fmt: skip
    if motor.scene.slider.turns:
        torque = plane.stall_torque(slider, waves)
        answer.append(("stall torque", f"{si(torque.value, 'N m', 4)} keep it from turning"))
    panels = [
        Panel(name="stall", title=title, data={"angle_rad": angles, "load_N": share * force,
                                               "error_N": share * np.array([each.error for each in stalls])}),
        Panel(name="load_line", title=title, data={"load_N": share * loads, quantity.velocity_m_per_s.column: speeds}),
    ]  # fmt: skip
    return panels, findings, answer


def draw(record: Panel, ax):
    """Draw the stall curve, the load line, or the speed of a rotor against torque."""
    data = record.data
    if record.name == OF_TORQUE:
        turns, torque = quantity.rotation_rpm, quantity.torque_N_m
        curve(ax, np.asarray(data["torque_N_m"]) * torque.scale, np.asarray(data["rotation_rpm"]), ".-", "slip")
        return finished(ax, torque.axis, turns.axis, record.title, columns=0)
    if record.name == "load_line":
        factor, label = key_axis("slider.load", float(max(data["load_N"])))
        up = quantity.velocity_m_per_s
        curve(ax, np.asarray(data["load_N"]) * factor, np.asarray(data[up.column]) * up.scale, ".-", "slip")
        return finished(ax, label, up.axis, record.title, columns=0)
    up = quantity.thrust_N
    angle, force = np.append(data["angle_rad"], data["angle_rad"][0]), np.append(data["load_N"], data["load_N"][0])
    x, y = force * up.scale * np.cos(angle), force * up.scale * np.sin(angle)
    curve(ax, x, y, ".-", "slip")
    ax.plot([0.0], [0.0], "+", color="black")
    ax.set_aspect("equal", adjustable="datalim")
    return finished(ax, f"F_x against +x ({up.shown})", f"F_y against +y ({up.shown})", record.title, columns=0)
