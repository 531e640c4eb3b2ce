"""Exported motors on rough and adhesive balls: against the steady velocities of a run, as Python, as C and as an FMU.

Truth: `contact.RoughBalls`, `contact.AdhesiveBalls` and `contact.mean_motion`, which share no table with the exports.
"""

import ctypes
import math
import subprocess
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import contact
from studies.export import averaged_motor as exports
from studies.export import law_contact
from studies.export.averaged_motor import averaged_motor
from studies.export.c_source import description, header, source
from studies.export.fmu import compiler, fmu
from studies.export.law_grid import Nodes
from studies.export.reduced_motor import index
from studies.motor.followed_motor import HEIGHT, NORMAL_VELOCITY, STEPS, VELOCITY, FollowedMotor
from studies.scene import Scene

LEVELS = (2e-9, 4e-9, 12e-9)
OFF_THE_GRID = (2.7e-9, 5.45e-9, 9.1e-9)
MEAN_FIELD = {"roughness": {"rms": 3e-9}}
SAMPLE = {"roughness": {"rms": 3e-9, "seed": 1}, "contacts": 3}
STOPS = {"roughness": {"rms": 3e-9, "seed": 1}, "law": "elastic"}
JKR = {"adhesion": {"model": "JKR", "work": 0.05}}
DMT = {"adhesion": {"model": "DMT", "work": 0.05}}
MENISCUS = {"adhesion": {"model": "meniscus", "surface_tension": 0.072}}


def scene(slider):
    return Scene.load("twente-contact").replace(slider=slider, wave={"normal_amplitude": list(LEVELS)})


@cache
def coarse():
    """The motor on a mean field with few nodes, in seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(law_contact, "ROUGH", Nodes(depths=9, closed=17, open=9, columns=21))
        return averaged_motor(scene(MEAN_FIELD))


def run_velocity(motor, slider, level):
    driven = exports.first_drive(scene(slider))
    return law_contact.LawContact.of(driven).velocity(motor.orbits_at(level))


def settled(motor, level, preload=None):
    state = motor.start(preload=preload)
    for _ in range(8):
        state.advance(0.25, level, preload=preload)
    return state


def missed(motor, level, velocity):
    """Return the difference of the steady velocity from a given one over max(|v|, omega |u_x|/10)."""
    scale = contact.reference_speed(velocity, motor.orbits_at(level))
    return abs(settled(motor, level).velocity - velocity) / scale


def test_a_mean_field_reaches_the_velocities_of_a_run():
    motor = coarse()
    assert 1e-5 < motor.velocity_error < 1e-2
    for level in OFF_THE_GRID:
        assert missed(motor, level, run_velocity(motor, MEAN_FIELD, level)) < 2.0 * motor.velocity_error
    assert any(line.startswith("steady velocity: interpolation changes it by") for line in description(motor))


def test_a_mean_field_at_another_preload():
    motor, preload = coarse(), 1.4 * coarse().preload
    level, heavier = 6e-9, scene(MEAN_FIELD | {"preload": 1.4 * coarse().preload})
    truth = law_contact.LawContact.of(exports.first_drive(heavier)).velocity(motor.orbits_at(level))
    assert settled(motor, level, preload).velocity == pytest.approx(truth, rel=2.0 * motor.velocity_error)


def test_the_force_at_rest_and_the_spring_are_those_of_the_mean_field():
    motor = coarse()
    field = contact.MeanField(1e-3, 64e9, contact.Roughness(rms=3e-9))
    state = motor.start()
    assert state.numbers[index.APPROACH] == pytest.approx(field.approach(motor.preload), abs=2e-3 * 3e-9)
    # Jaeger and Ciavarella: Q = mu (P(h) - P(h - |x|/c)) of the field's own force
    limit = motor.slider.friction_coefficient * motor.preload
    held = motor.start(force=-0.6 * limit)
    left = field.approach(motor.preload) - field.approach(0.4 * motor.preload)
    assert held.deformation == pytest.approx(motor.slider.limit_slope * left, rel=3e-3)


def test_the_ring_of_a_rough_slider_has_the_stated_speed():
    motor = coarse()
    state = motor.start(force=-(1.0 - 1e-9) * motor.slider.friction_coefficient * motor.preload)
    speeds = []
    for _ in range(2000):
        state.advance(1e-7, 0.0)
        speeds.append(abs(state.velocity))
    assert max(speeds) == pytest.approx(motor.ring_speed, rel=2e-3)


def test_the_second_drive_of_a_rough_motor_is_the_mirror_image():
    motor = coarse()
    assert settled(motor, -6e-9).velocity == pytest.approx(-settled(motor, 6e-9).velocity, rel=1e-9)


def library_of(motor, folder):
    (folder / "motor.c").write_text(source(motor))
    (folder / "motor.h").write_text(header(motor))
    flags = ["-std=c99", "-Wall", "-Werror", "-Wno-unused-function", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run([*compiler(), *flags, "-o", folder / "motor.so", "motor.c", "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(folder / "motor.so"))


def same_in_c(motor, folder, level):
    library, number = library_of(motor, folder), ctypes.c_double
    state, python = (number * index.STATE_SIZE)(), motor.start()
    library.sawmotor_start(state, number(motor.preload), number(0.0))
    for duration, drive, force in ((2e-3, level, 0.0), (1e-2, level, -1e-5), (5e-4, -level, 0.0), (5e-3, 0.0, 0.0)):
        python.advance(duration, drive, force=force)
        arguments = (drive, force, motor.preload, duration)
        assert library.sawmotor_advance(state, *map(number, arguments)) == 0
    for name in ("position", "velocity", "deformation"):
        found = getattr(library, f"sawmotor_{name}")
        found.restype = number
        assert found(state) == pytest.approx(getattr(python, name), rel=1e-7, abs=1e-15)


def test_c_and_python_take_the_same_steps_on_a_mean_field(tmp_path):
    same_in_c(coarse(), tmp_path, 6e-9)


@pytest.mark.parametrize("version", ["2", "3"])
def test_fmpy_runs_the_fmu_of_a_mean_field(version, tmp_path):
    fmpy, validate_fmu = pytest.importorskip("fmpy"), pytest.importorskip("fmpy.validation").validate_fmu
    path = tmp_path / "motor.fmu"
    path.write_bytes(fmu(coarse(), version)[0])
    assert not validate_fmu(str(path))
    result = fmpy.simulate_fmu(
        str(path), stop_time=2.0, step_size=1e-2, output_interval=1e-2, start_values={"drive": 6e-9},
        output=["velocity"],
    )  # fmt: skip
    assert float(result["velocity"][-1]) == pytest.approx(settled(coarse(), 6e-9).velocity, rel=1e-6)


def adhesive_from(smooth, adhesion):
    """The motor on balls with a constant attraction; its tables are those of the smooth balls, `smooth`."""
    rows = int(smooth.parameters[index.TAU_NODES])
    loads = smooth.tables[:rows]
    forces = smooth.tables[rows:].reshape(2, rows, -1)
    with pytest.MonkeyPatch.context() as patch:
        for name, number in (("ROWS", 121), ("COLUMNS", 81)):
            patch.setattr(f"studies.export.force_grid.{name}", number)
        patch.setattr(exports, "force_tables", lambda *_: (loads, forces))
        return averaged_motor(scene(adhesion))


@cache
def smooth():
    """The motor on smooth balls with few nodes."""
    with pytest.MonkeyPatch.context() as patch:
        for name, number in (("ROWS", 121), ("COLUMNS", 81)):
            patch.setattr(f"studies.export.force_grid.{name}", number)
        return averaged_motor(scene({}))


@pytest.mark.parametrize("adhesion", [DMT, MENISCUS])
def test_constant_attraction_acts_as_in_a_run(adhesion):
    motor = adhesive_from(smooth(), adhesion)
    assert motor.velocity_error < 3e-3
    for level in OFF_THE_GRID:
        truth = contact.mean_motion(motor.slider, motor.orbits_at(level))
        assert missed(motor, level, float(truth.first_order)) < 2.0 * motor.velocity_error
        state = settled(motor, level)
        if not truth.held:
            assert state.numbers[index.APPROACH] == pytest.approx(float(truth.height), abs=2e-3 * level)
    # at rest the elastic force is preload and attraction
    at_rest = contact.Slider.rest_approach(motor.slider, 1)
    assert motor.start().numbers[index.APPROACH] == pytest.approx(at_rest, rel=1e-9)


def test_without_contacts_that_open_attraction_is_a_preload():
    """rough.md, section 4: DMT without hops is a preload of F + F_a."""
    motor = adhesive_from(smooth(), DMT)
    pressed = motor.preload + contact.Adhesion(model="DMT", work=0.05).attraction(1e-3)
    with_preload = replace(smooth(), slider=smooth().slider)
    truth = settled(with_preload, 3e-9, preload=pressed).velocity
    assert settled(motor, 3e-9).velocity == pytest.approx(truth, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("slider", [MEAN_FIELD, SAMPLE, STOPS, JKR])
def test_stated_errors_hold_and_fmpy_runs_the_fmu(slider, tmp_path):
    fmpy, validate_fmu = pytest.importorskip("fmpy"), pytest.importorskip("fmpy.validation").validate_fmu
    motor = averaged_motor(scene(slider))
    assert motor.velocity_error < 5e-3
    content, _ = fmu(motor)
    path = tmp_path / "motor.fmu"
    path.write_bytes(content)
    assert not validate_fmu(str(path))
    for level in OFF_THE_GRID:
        truth = run_velocity(motor, slider, level)
        result = fmpy.simulate_fmu(
            str(path), stop_time=2.0, step_size=1e-2, output_interval=0.1, start_values={"drive": level},
            output=["velocity"],
        )  # fmt: skip
        scale = contact.reference_speed(truth, motor.orbits_at(level))
        assert abs(float(result["velocity"][-1]) - truth) < 2.0 * motor.velocity_error * scale
    same_in_c(motor, tmp_path, 6e-9)


@cache
def holding():
    """The motor on balls of JKR with few nodes."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(law_contact, "HOLDING", Nodes(depths=7, closed=9, open=9, columns=11))
        return averaged_motor(scene(JKR))


def followed_mean(motor, level, height, velocity, steps=STEPS):
    """The mean forces in N of one cycle of a slider that is too heavy to change its motion within it: Q, and P - F."""
    parameters, frequency = motor.parameters.copy(), motor.drives[0].orbits[0].frequency
    parameters[index.MASS], parameters[index.NORMAL_DAMPING], parameters[index.TANGENTIAL_DAMPING] = 10.0, 0.0, 0.0
    state = FollowedMotor(replace(motor, parameters=parameters), steps=steps)
    state.state[HEIGHT], state.state[VELOCITY] = -height, velocity
    state.advance(6.0 / frequency, level)
    before = state.state.copy()
    state.advance(1.0 / frequency, level)
    changes = state.state - before
    return changes[VELOCITY] * 10.0 * frequency, changes[NORMAL_VELOCITY] * 10.0 * frequency


@pytest.mark.parametrize(
    ("make", "level", "height", "steps", "close"),
    [
        (coarse, 6e-9, 3e-9, STEPS, 3e-4),
        (coarse, 12e-9, 0.5e-9, STEPS // 4, 2e-4),  # 4e-4 if layers touch at the end of a step
        (holding, 4e-9, 4.8e-9, STEPS, 1e-3),
        (holding, 10e-9, 1.3e-9, STEPS, 1e-3),  # 6e-3 and 1e-2 if balls close and open at the end of a step
        (holding, 20e-9, -2e-9, STEPS, 1e-3),
    ],
)
def test_the_followed_motor_has_the_mean_force_of_a_run(make, level, height, steps, close):
    """Against `contact.HeldMeans`, which integrate a cycle in closed form or by Gauss's rule, without steps of time."""
    motor = make()
    limit = motor.slider.friction_coefficient * motor.slider.preload
    for velocity in (0.3, 0.7):
        v = velocity * motor.drives[0].saturation(motor.slider) * level
        (truth,) = motor.law.means.tractions(height, motor.orbits_at(level), [v])
        assert followed_mean(motor, level, height, v, steps)[0] == pytest.approx(truth, abs=close * limit)


def test_the_followed_motor_feels_an_attraction_as_long_as_a_ball_touches():
    """It begins and ends within steps, which count for their part: the means are those of the phase of contact."""
    motor, level = adhesive_from(smooth(), MENISCUS), 10e-9
    pull, stiffness = contact.meniscus_force(1e-3, 0.072), 4.0 / 3.0 * 64e9 * 1e-3**0.5
    for height in (1e-9, 4.1e-9, -3e-9):
        z = height + level * np.cos(2.0 * np.pi * (np.arange(20_000) + 0.5) / 20_000)
        truth = stiffness * np.mean(np.maximum(z, 0.0) ** 1.5) - pull * math.acos(-height / level) / math.pi
        found = followed_mean(motor, level, height, 0.0)[1] + motor.preload
        assert found == pytest.approx(truth, abs=2e-5 * pull)
