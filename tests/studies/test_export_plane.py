"""The exported averaged motor in the plane: against contact.plane's own solvers, as Python, as C and as an FMU.

Truth: `contact.plane.burst` and `steady`; cases of two independent integrators, which agree to 3e-8.
"""

import ctypes
import math
import subprocess
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

import contact
from contact import plane
from studies.__main__ import main
from studies.export import planar_export, simulators
from studies.export.fmu import compiler, fmu_of
from studies.export.planar_body import Body
from studies.export.planar_export import planar_motor
from studies.export.planar_motor import PlanarMotor
from studies.export.planar_source import planar_header, planar_model, planar_source
from studies.export.planar_tables import Forces, Grid, packed, speeds, tables_of
from studies.export.reduced_plane import plane_index as index
from studies.export.reduced_plane.plane_cycle import force_on_waves
from studies.export.reduced_plane.plane_force_tables import angle_position, speed_position
from studies.export.simulators import drive_input
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.study_list import driven_contact

BODY = {
    "radius": "1 mm", "mass": "0.267 g", "preload": "2.61927 mN", "friction_coefficient": 0.08,
    "contacts": [["6 mm", 0], ["-3 mm", "5.19615 mm"], ["-3 mm", "-5.19615 mm"]], "tilt": "free",
    "effective_modulus": "64 GPa", "tangential_modulus": "12 GPa",
    "damping": {"normal": "2 N s/m"},
}  # fmt: skip
ALONE = {"contacts": 1, "mass": "0.089 g", "preload": "0.87309 mN", "tilt": "held"}
LIMIT = 0.08 * 2.61927e-3  # N: friction coefficient times preload
LEVEL = 1e-8


def scene(*sources, levels=("10 nm",), **slider):
    wave = {"frequency": "2.2 MHz", "normal_amplitude": list(levels), "tangential_ratio": 0.67, "wavelength": "1.5 mm",
            "sources": list(sources)}  # fmt: skip
    return Scene.from_table("", {"wave": wave, "slider": BODY | slider})


@cache
def one_wave():
    """Three balls on one wave, free to move and to turn."""
    return planar_motor(scene({}, freedom="xy yaw", inertia="5 g mm^2"), tolerance=1e-2)


def driven(motor):
    return driven_contact(motor.scene, tolerance=1e-2, planar=True)


def followed(motor, trajectory, duration, *levels, load=(0.0, 0.0, 0.0)):
    """Return rates and poses of the motor at the instants of a burst, and its state at the end."""
    state, rates, poses, now = motor.start(), [], [], 0.0
    for each in trajectory.time:
        if now < duration:
            state.advance(min(each, duration) - now, *levels, load=load)
        if each > duration:
            state.advance(each - max(now, duration), *[0.0] * len(levels), load=load)
        now = each
        rates.append(state.rates)
        poses.append(state.pose)
    return np.array(rates), np.array(poses), state


@pytest.mark.parametrize(
    ("share", "expected"),
    [(0.0, (0.0683658806, 0.0)), (0.2, (0.0681188558, -1.7441887e-3)), (0.5, (0.0666775340, -5.5188554e-3))],
)
def test_a_force_across_the_wave_makes_the_drift_of_two_integrators(share, expected):
    motor = one_wave()
    rates = replace(motor, load=(0.0, -share * LIMIT, 0.0)).steady(LEVEL)
    assert motor.velocity_error < 5e-3
    assert np.hypot(*(rates[:2] - expected)) < 2.0 * motor.velocity_error * expected[0]
    assert rates[1] == pytest.approx(expected[1], rel=1e-2, abs=1e-9)
    assert abs(rates[2]) < 1e-9


def test_a_burst_and_its_stop_are_those_of_the_averaged_equations():
    motor, duration = one_wave(), 0.05
    contact_of = driven(motor)
    truth = plane.burst(
        contact_of.slider, contact_of.surface_at(LEVEL), duration=duration, after=math.inf, tolerance=1e-4, samples=10,
        method="averaged", start=(np.zeros(3), np.zeros(3)),
    )  # fmt: skip
    rates, poses, state = followed(motor, truth, duration, LEVEL)
    allowed = 2e-4 * 0.0683658806  # twice the tolerance of the burst
    assert np.abs(rates[:, :2] - truth.velocity)[:-1].max() < allowed
    assert np.abs(poses[:, :2] - truth.pose[:, :2]).max() < allowed * truth.time[-1]
    state.advance(1e-3, 0.0)
    assert state.rests


def test_the_burst_of_the_program_differs_by_the_start_that_is_stated():
    motor, duration = one_wave(), 0.02
    contact_of = driven(motor)
    truth = plane.burst(
        contact_of.slider, contact_of.surface_at(LEVEL), duration=duration, after=0.0, tolerance=1e-3, samples=5,
        method="averaged",
    )  # fmt: skip
    rates, _, _ = followed(motor, truth, duration, LEVEL)
    (line,) = (each for each in motor.left_out if "bounce of a sudden start" in each)
    start = float(line.split(" by ")[1].split(" m/s")[0])
    assert 1e-6 < start < 1e-3
    at_end = abs(rates[-1, 0] - truth.velocity[-1, 0])
    assert at_end < 2.0 * start + motor.velocity_error * truth.reference


def test_a_slider_that_friction_holds_creeps_as_stated_and_one_that_it_does_not_slides():
    motor, creep = one_wave(), one_wave().parameters[index.CREEP]
    state = motor.start()
    state.advance(0.1, 0.0, load=(0.0, 0.5 * LIMIT, 0.0))
    assert state.rests
    assert state.rates[1] == pytest.approx(0.5 * creep, rel=1e-6)
    state = motor.start()
    state.advance(0.1, 0.0, load=(1.5 * LIMIT, 0.0, 0.0))
    assert state.rates[0] == pytest.approx(0.5 * LIMIT / 0.267e-3 * 0.1, rel=1e-4)


def test_other_preloads_are_followed():
    """All forces grow as a power of the lengths: with 4 P a wave 4^(2/3) as large, speeds too."""
    motor, factor = one_wave(), 4.0 ** (2.0 / 3.0)
    small, large = motor.start(), motor.start()
    small.advance(0.02, LEVEL / factor)
    large.advance(0.02 * factor / 4.0, LEVEL, preload=4.0 * motor.preload)
    assert large.rates[0] == pytest.approx(factor * small.rates[0], rel=1e-5)
    assert large.rates[0] > 0.02


def test_the_nodes_lie_where_the_tables_are_read():
    for count in (9, 25, 33):
        places = [speed_position(float(q)) * (count - 1) for q in speeds(count)[:-1]]
        np.testing.assert_allclose(places, np.arange(count - 1), atol=1e-6)
    grid = Grid.of(dense_ring()[0], 0.7)
    places = [angle_position(each - grid.axis, grid.axes) * grid.angle.size for each in grid.angle]
    np.testing.assert_allclose(np.array(places) % grid.angle.size, np.arange(grid.angle.size), atol=1e-6)


@cache
def two_waves():
    """One ball on waves along x and y of two frequencies."""
    sources = {}, {"direction": 90, "frequency": "2.75 MHz"}
    return planar_motor(scene(*sources, freedom="xy", **ALONE), tolerance=1e-2)


def test_two_drives_move_along_both_axes():
    motor = two_waves()
    assert motor.drives == ("wave 1", "wave 2")
    assert motor.velocity_error < 1e-2
    first, both = motor.steady(LEVEL, 0.0), motor.steady(LEVEL, LEVEL)
    assert first[:2] == pytest.approx([0.0683658806, 0.0], abs=2.0 * motor.velocity_error * 0.0684)
    contact_of = driven(motor)
    exact = plane.mean_motion(contact_of.slider, contact_of.surface_at(LEVEL)).velocity
    assert min(exact) > 0.05
    reference = contact.speed_scale(float(np.hypot(*exact)), 0.1)
    assert np.hypot(*(both[:2] - exact)) < 2.0 * motor.velocity_error * reference
    second = motor.steady(0.0, LEVEL)
    assert abs(second[0]) < 2.0 * motor.velocity_error * 0.0684 < second[1]


def test_two_frequencies_make_the_motion_of_two_integrators():
    sources = {}, {"direction": 90, "frequency": "2.3 MHz"}
    motor, expected = planar_motor(scene(*sources, freedom="xy", **ALONE), tolerance=1e-2), (0.06470998, 0.06670011)
    off = np.hypot(*(motor.steady(LEVEL, LEVEL)[:2] - expected)) / np.hypot(*expected)
    assert off < 2.0 * motor.velocity_error
    assert motor.velocity_error < 1e-2


@pytest.mark.parametrize("draw", range(8))
def test_the_stated_error_holds_at_other_levels_and_forces(draw):
    """Unequal levels, one of them next to the threshold of its own wave, under forces of up to 0.8 of friction."""
    motor, random = two_waves(), np.random.default_rng(draw)
    levels = LEVEL * random.uniform(0.06, 1.2, 2)
    force, angle = 0.8 * random.uniform() * LIMIT / 3.0, random.uniform(0.0, 2.0 * math.pi)
    slider = replace(motor.body.slider, load=(force * math.cos(angle), force * math.sin(angle)))
    waves = motor.body.waves_at(levels)
    exact = plane.steady(slider, waves, tolerance=1e-4, method="averaged").velocity
    found = replace(motor, load=(-slider.load[0], -slider.load[1], 0.0)).steady(*levels)[:2]
    reference = contact.speed_scale(float(np.hypot(*exact)), waves.peak_speed)
    assert np.hypot(*(found - exact)) < 2.0 * motor.velocity_error * reference


@pytest.mark.parametrize("velocity", [(0.03, 0.02), (-0.001, 0.06), (4e-7, -3e-7)])
def test_derivatives_of_a_mean_force_are_those_of_its_differences(velocity):
    """Also below the creep of 2e-6 m/s."""
    motor, h = two_waves(), 1e-4 * math.hypot(*velocity)
    state = np.zeros(motor.state_size)

    def force(v_x, v_y):
        force_on_waves(motor.parameters, motor.tables, state, 0, 8e-9, 5e-9, v_x, v_y, motor.preload)
        return state[index.FOUND : index.FOUND + 2].copy()

    x, y = velocity
    differences = [force(x + h, y) - force(x - h, y), force(x, y + h) - force(x, y - h)]
    force(x, y)
    slopes = state[index.SLOPE : index.SLOPE + 4].reshape(2, 2)
    assert slopes.T == pytest.approx(np.array(differences) / (2.0 * h), rel=1e-3, abs=1e-2 * np.abs(slopes).max())


class HalfPlanes:
    """A wave that drives to -x for y > 0 and one that drives to +x for y < 0."""

    def at(self, x, y):
        side = np.where(np.asarray(y) > 0.0, 1.0, -1.0)
        amplitudes = np.stack([0.67j * side, 0.0 * side, 1.0 + 0.0 * side], axis=-1)
        return plane.SurfaceWaves(frequencies=[2.2e6], amplitudes=amplitudes[None])


@cache
def dense_ring():
    """A rotor on eight balls over two half-planes, its exact mean forces, the arm and the number of balls."""
    turn, arm, count = 2.0 * np.pi * (np.arange(8) + 0.5) / 8, 6e-3, 8
    slider = contact.Slider(
        radius=1e-3, x=arm * np.cos(turn), y=arm * np.sin(turn), mass=1e-3, preload=count * 0.87309e-3, load=(0.0, 0.0),
        friction_coefficient=0.08, effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
        stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0, freedom="axle", inertia=1e-8,
        axis=(0.0, 0.0), tilt="held",
    )  # fmt: skip
    return Forces(Body(slider=slider, share=1, surfaces=(HalfPlanes(),))), arm, count


def test_a_rotor_is_that_of_a_dense_ring():
    """Speed and half of the stall torque of balls dense on a ring, from an integral over the ring."""
    forces, arm, count = dense_ring()
    body = forces.body
    grid = Grid.of(forces, forces.tau(1.2e-8), (11, 1, 17, 2))
    p, flat = packed(body, forces, grid, tables_of(forces, grid), creep=1e-6, steps=(1e-4, 1e-5), rise=0.0)
    motor = PlanarMotor(scene=one_wave().scene, body=body, drives=("beams",), parameters=p, tables=flat,
                        load=(0.0, 0.0, 0.0), limits=(1.2e-8,))  # fmt: skip
    assert arm * motor.steady(LEVEL)[2] == pytest.approx(0.046385, rel=1e-2)
    stall = count * arm * 2.0 / math.pi * 6.91668571e-5
    half = replace(motor, load=(0.0, 0.0, -0.5 * stall)).steady(LEVEL)
    assert arm * half[2] == pytest.approx(0.024705, rel=1e-2)
    held = replace(motor, load=(0.0, 0.0, -1.001 * stall)).steady(LEVEL)
    assert held[2] < 0.0
    assert not half[:2].any()
    with pytest.raises(RunError, match=r"the tables reach up to 1\.2e-08 m"):
        motor.start().advance(1e-3, 10.0 * LEVEL)


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder, motor = tmp_path_factory.mktemp("c"), one_wave()
    (folder / "motor.c").write_text(planar_source(motor))
    (folder / "motor.h").write_text(planar_header(motor))
    target = folder / "motor.so"
    flags = ["-std=c99", "-Wall", "-Werror", "-Wno-unused-function", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run([*compiler(), *flags, "-o", target, "motor.c", "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(target))


def test_c_and_python_take_the_same_steps(library):
    motor = one_wave()
    state = (ctypes.c_double * motor.state_size)()
    inputs = (ctypes.c_double * 6)()
    for name in ("pose", "rates"):
        getattr(library, f"sawmotor_{name}").restype = ctypes.POINTER(ctypes.c_double)
    library.sawmotor_start(state)
    python = motor.start()
    for duration, level, load in (
        (0.01, LEVEL, (0.0, 0.0, 0.0)), (0.02, LEVEL, (0.0, -3e-5, 2e-7)), (0.005, 0.0, (0.0, 0.0, 0.0)),
    ):  # fmt: skip
        python.advance(duration, level, load=load)
        inputs[:] = [level, 0.0, *load, motor.preload]
        assert library.sawmotor_advance(state, inputs, ctypes.c_double(duration)) == 0
    for name in ("pose", "rates"):
        found = getattr(library, f"sawmotor_{name}")(state)[:3]
        assert found == pytest.approx(getattr(python, name).tolist(), rel=1e-8, abs=1e-15)
    assert abs(python.rates[2]) > 1e-4
    inputs[0] = -1.0
    assert library.sawmotor_advance(state, inputs, ctypes.c_double(1e-3)) == 1


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fmpy's own imports
@pytest.mark.parametrize("version", ["3", "2"])
def test_fmpy_runs_the_fmu(version, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    content, remark = fmu_of(planar_model(one_wave()), version)
    assert remark == ""
    path = tmp_path / "motor.fmu"
    path.write_bytes(content)
    assert validate_fmu(str(path)) == []
    result = fmpy.simulate_fmu(
        str(path), stop_time=0.05, step_size=1e-3, output_interval=1e-2,
        start_values={"drive": LEVEL, "force_y": -0.2 * LIMIT, "torque": 1e-7},
    )  # fmt: skip
    assert {"x", "y", "yaw", "velocity_x", "velocity_y", "yaw_rate", "surface_amplitude"} <= set(result.dtype.names)
    state = one_wave().start()
    for k, now in enumerate(result["time"][1:], start=1):
        for _ in range(10):
            state.advance(1e-3, LEVEL, load=(0.0, -0.2 * LIMIT, 1e-7))
        found = [result[name][k] for name in ("velocity_x", "velocity_y", "yaw_rate", "x", "y", "yaw")]
        assert state.time == pytest.approx(now)
        assert found == pytest.approx([*state.rates, *state.pose], rel=1e-7, abs=1e-12)
    assert result["velocity_y"][-1] < -1e-3
    assert "this error changes it by up to" in fmpy.read_model_description(str(path)).description


@pytest.mark.parametrize(
    ("sources", "keys", "key", "words"),
    [
        ([{}, {"direction": 90, "phase": 90}], {}, "wave.sources", "depends less on the place"),
        ([{}, {"direction": 90, "frequency": "2.75 MHz"}, {"direction": 45, "frequency": "3.3 MHz"}], {},
         "wave.sources", "at most two frequencies"),
        ([{}], {"heights": [0.0, "1 nm", 0.0], "contacts": BODY["contacts"]}, "slider.heights", "of one height"),
    ],
    ids=["pattern", "three frequencies", "heights"],
)  # fmt: skip
def test_what_tables_do_not_hold_is_refused(sources, keys, key, words):
    with pytest.raises(SceneError, match=words) as raised:
        planar_motor(scene(*sources, freedom="xy", **(ALONE | {"tilt": "held"} | keys)), tolerance=1e-2)
    assert key in str(raised.value)


def test_a_slider_without_friction_is_refused_with_its_key():
    frictionless = scene({}, freedom="xy yaw", inertia="5 g mm^2", friction_coefficient=0.0)
    with pytest.raises(SceneError, match="must be positive") as raised:
        planar_motor(frictionless, tolerance=1e-2)
    assert raised.value.path == "slider.friction_coefficient"


def test_inputs_that_cannot_be_are_refused():
    state = one_wave().start()
    with pytest.raises(SceneError, match="level must be zero or positive"):
        state.advance(1e-3, -LEVEL)
    with pytest.raises(SceneError, match="preload must be positive"):
        state.advance(1e-3, LEVEL, preload=0.0)


@pytest.mark.slow
def test_the_rotor_is_exported_by_the_command(tmp_path, monkeypatch, capsys):
    """Torque in, angle and rotation out, at the mean rotation that its datasheet states."""
    fmpy = pytest.importorskip("fmpy")
    monkeypatch.chdir(tmp_path)
    assert main(["export", "rotor", "--format", "fmu", "--voltage", "60", "--out", "rotor.fmu"]) == 0
    assert "the torque is the mean over a turn" in capsys.readouterr().out
    result = fmpy.simulate_fmu(
        "rotor.fmu", stop_time=2.0, step_size=1e-3, output_interval=0.1, start_values={"drive": 60}
    )
    assert {"yaw", "rotation"} <= set(result.dtype.names)
    assert not {"x", "velocity_x", "force_x"} & set(result.dtype.names)
    assert result["rotation"][-1] == pytest.approx(-200.4 * math.pi / 30, rel=3e-2)


def test_a_waveform_stands_beside_the_model_as_a_table_of_all_drives():
    given = scene({}, {"direction": 90}, levels=("5 nm", "10 nm"), freedom="xy").to_table()
    given["wave"] |= {"burst": "4 ms", "waveform": {"shape": "ramp", "rise": "1 ms", "fall": "2 ms"}}
    text = drive_input(Scene.from_table("", given), "stage", ["drive_a", "drive_b"])["stage.drive.csv"]
    head, *rows = text.splitlines()
    assert head == "time,drive_a,drive_b"
    table = np.array([[float(each) for each in row.split(",")] for row in rows])
    assert table == pytest.approx(
        np.array([[0, 0, 0], [1e-3, 1e-8, 1e-8], [2e-3, 1e-8, 1e-8], [4e-3, 0, 0], [4e-3, 0, 0]]), abs=1e-20
    )


@pytest.mark.parametrize("files", [simulators.fmu_files, simulators.c_files])
def test_a_waveform_that_turns_is_refused_before_anything_is_computed(monkeypatch, files):
    monkeypatch.setattr(planar_export, "planar_motor", lambda *_, **__: pytest.fail("the motor was computed"))
    given = scene({}, {"direction": 90}, freedom="xy").to_table()
    given["wave"] |= {"burst": "4 ms", "waveform": {"shape": "chirp", "sweep": [0.0, "1 kHz"]}}
    with pytest.raises(SceneError, match="must keep phase and frequency here"):
        files(Scene.from_table("", given), "stage", tolerance=1e-2)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fmpy's own imports
def test_the_fmu_of_a_shipped_scene_follows_its_path(tmp_path):
    """Bursts of each transducer, of both, and the coast, by fmpy; truth: `contact.plane.burst` on the waves there."""
    fmpy = pytest.importorskip("fmpy")
    motor = planar_motor(Scene.load("twente-planar").at_level(60.0), tolerance=1e-2)
    path = tmp_path / "motor.fmu"
    path.write_bytes(fmu_of(planar_model(motor))[0])
    duration, slider, start = 0.01, motor.body.slider, (np.zeros(3), np.zeros(3))
    drives = ((60.0, 0.0), (0.0, 60.0), (60.0, 60.0))
    rows = [(k * duration + at, *levels) for k, levels in enumerate(drives) for at in (0.0, duration)]
    rows += [(3 * duration, 0.0, 0.0), (1.0, 0.0, 0.0)]
    inputs = np.array(rows, dtype=[("time", float), ("drive_left", float), ("drive_front", float)])
    result = fmpy.simulate_fmu(str(path), stop_time=0.06, step_size=1e-4, output_interval=1e-4, input=inputs)
    arms, passed, allowed = np.array([1.0, 1.0, motor.body.arm]), 0.0, 0.0
    for k, levels in enumerate(drives):
        after = math.inf if k == 2 else 0.0
        leg = plane.burst(
            slider, motor.body.waves_at(levels), duration=duration, after=after, tolerance=1e-3, samples=5,
            method="averaged", start=start, in_place=True,
        )  # fmt: skip
        fastest = float(np.abs(leg.rates * arms).max())
        for now, pose, rates in zip(leg.time, leg.pose, leg.rates, strict=True):
            at = int(np.argmin(np.abs(result["time"] - passed - now)))
            found = np.array([result[name][at] for name in ("x", "y", "yaw")])
            moved = np.array([result[name][at] for name in ("velocity_x", "velocity_y", "yaw_rate")])
            stated = (motor.velocity_error + leg.relative_error) * fastest
            assert np.abs((moved - rates) * arms).max() < stated + 1e-4 * fastest
            assert np.abs((found - pose) * arms).max() < allowed + stated * now + 1e-4 * fastest * duration
        allowed += stated * leg.time[-1]
        passed, start = passed + duration, (leg.pose[leg.burst_end], leg.rates[leg.burst_end])
    assert abs(result["yaw"][-1]) * motor.body.arm > 1e-6
