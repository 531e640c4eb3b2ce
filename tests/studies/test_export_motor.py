"""The exported averaged motor: against contact's own solvers, as Python, as C and as an FMU that fmpy runs.

Truth: `contact.burst` (averaged and stepped), `contact.mean_traction` integrated by scipy, Cattaneo's closed form.
"""

import ctypes
import importlib.metadata
import math
import subprocess
import zipfile
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import contact
import studies
from studies.__main__ import main
from studies.export import reduced_motor
from studies.export.averaged_motor import averaged_motor
from studies.export.c_source import header, source
from studies.export.c_translation import UntranslatableError, c_source
from studies.export.fmu import STEP, compiler, fmu
from studies.export.force_grid import mean_forces
from studies.export.motor_model import Drive
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from tests.seed_motor import MASS

AMPLITUDE = 8e-9


@cache
def motor():
    return averaged_motor("twente-contact")


@cache
def light_motor():
    return averaged_motor(Scene.load("twente-contact").replace(slider={"mass": "1 mg", "preload": "0.873 mN"}))


@cache
def built(version):
    """The FMU of this version of the standard, with its machine code, and what is remarked on it."""
    return fmu(motor(), version)


def steady(level):
    return abs(float(contact.mean_motion(motor().slider, orbits(level)).velocity))


def orbits(level, drive=0):
    return tuple(each.scaled(level) for each in motor().drives[drive].orbits)


def run(schedule, state=None):
    """Return the velocities at the ends of (duration, level, force) steps."""
    state = state or motor().start()
    out = []
    for duration, level, force in schedule:
        state.advance(duration, level, force=force)
        out.append(state.velocity)
    return np.array(out), state


@pytest.mark.parametrize("amplitude", [3e-9, 20e-9])
def test_a_burst_and_its_stop_are_those_of_contact(amplitude):
    truth = contact.burst(
        motor().slider, orbits(amplitude), duration=0.1, after=0.02, tolerance=1e-5, samples=600, method="averaged"
    )
    during = truth.time <= truth.duration * (1 + 1e-12)
    steps = zip(np.diff(truth.time), np.where(during[1:], amplitude, 0.0), np.zeros(len(truth.time) - 1), strict=True)
    velocity, _ = run(steps)
    assert np.abs(velocity - truth.velocity[1:]).max() < 5e-5 * steady(amplitude)


@pytest.mark.parametrize("step", [2e-6, 1e-5, 1e-4])
def test_a_drive_that_rises_slowly_starts_the_slider_as_a_sudden_one_does(step):
    """It stayed at rest while the bounce of each small change was dead: up to the full drive, and for ever after."""
    light = light_motor()
    rise, top = 1e-3, 10e-9
    envelope = contact.Envelope(time=np.array([0.0, rise]), amplitude=np.array([0.0, 1.0]), phase=np.zeros(2))
    truth = contact.burst(
        light.slider, light.orbits_at(top), duration=1.5 * rise, after=0.0, tolerance=1e-4, samples=300,
        method="stepped", envelope=envelope,
    )  # fmt: skip
    state = light.start()
    for time in np.arange(round(1.5 * rise / step)) * step:
        state.advance(step, top * min(1.0, (time + 0.5 * step) / rise))
        exact = np.interp(time + step, truth.time, truth.velocity)
        assert state.velocity == pytest.approx(exact, abs=2e-2 * abs(truth.velocity[-1])), time


def test_a_load_that_is_taken_off_is_followed_as_by_contact():
    # the averaged velocity obeys an autonomous equation: after the load is gone the motion is that from rest, later
    loaded = replace(motor().slider, load=0.3 * motor().slider.preload * motor().slider.friction_coefficient)
    state = motor().start(force=-loaded.load)
    state.advance(0.05, AMPLITUDE, force=-loaded.load)
    first = contact.burst(loaded, orbits(AMPLITUDE), duration=0.05, after=0.0, tolerance=1e-5, samples=50)
    assert state.velocity == pytest.approx(first.velocity_at_burst_end, abs=5e-5 * steady(AMPLITUDE))
    free = contact.burst(
        motor().slider, orbits(AMPLITUDE), duration=0.2, after=0.0, tolerance=1e-5, samples=4000, method="averaged"
    )
    at = np.interp(state.velocity, free.velocity, free.time)
    for later in (0.01, 0.05, 0.1):
        moved = state.copy()
        moved.advance(later, AMPLITUDE)
        assert moved.velocity == pytest.approx(
            np.interp(at + later, free.time, free.velocity), abs=5e-5 * steady(AMPLITUDE)
        )


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_load_of_the_scene_opposes_a_motor_of_either_direction(side):
    """A force along +x on the real slider of three balls, against the velocity that contact finds."""
    drive = motor().drives[0]
    orbits = drive.orbits if side > 0.0 else tuple(each.mirrored() for each in drive.orbits)
    loaded = replace(motor().slider, load=1e-5)
    whole = replace(motor(), slider=loaded, share=3, drives=(replace(drive, orbits=orbits),))
    free = float(contact.mean_motion(motor().slider, whole.orbits_at(AMPLITUDE)).velocity)
    assert np.sign(free) == side
    assert whole.load == pytest.approx(-side * 3e-5, rel=1e-12)


def test_a_level_is_explained_in_its_unit():
    """A prescribed wave's level is its amplitude: "a level of 1 m makes 1 m" said nothing."""
    assert "the level is the amplitude of u_z under the contacts, in m" in header(motor())
    drives = tuple(replace(each, orbits=tuple(one.scaled(2.5e-10) for one in each.orbits)) for each in motor().drives)
    scene = Scene.load("twente-left")
    text = header(replace(motor(), scene=scene, drives=drives))
    assert "1 V (peak) of the source makes an amplitude of u_z of 2.5e-10 m, 2.5e-10 m under the contacts" in text


def test_a_load_step_brakes_as_the_exact_mean_traction_says():
    slider, load = motor().slider, 2.5e-5
    _, state = run([(0.1, AMPLITUDE, 0.0)])
    begin = state.velocity
    heavy = replace(slider, load=0.0)

    def rate(_, v):
        return (contact.mean_traction(heavy, orbits(AMPLITUDE), v) - slider.tangential_damping * v - load) / slider.mass

    truth = solve_ivp(rate, (0.0, 0.2), [begin], rtol=1e-8, atol=1e-12, max_step=5e-3, t_eval=[0.01, 0.05, 0.2])
    for time, velocity in zip(truth.t, truth.y[0], strict=True):
        moved = state.copy()
        moved.advance(time, AMPLITUDE, force=-load)
        assert moved.velocity == pytest.approx(velocity, abs=2e-5 * steady(AMPLITUDE))


def test_the_wave_that_grows_and_fades_is_followed_as_by_fixed_steps():
    # a response of 40 us to full size, with an overshoot; the same envelope in contact's stepped method
    time = np.linspace(0.0, 4e-5, 161)
    factor = 1.2 * np.sin(0.5 * np.pi * time / 3e-5) * np.exp(0.4j * (1.0 - time / 4e-5))
    factor[-1] = 1.0
    own = replace(motor().drives[0], response=factor, response_step=float(time[1]))
    shaped = with_response(own)
    envelope = contact.Envelope(time=time, amplitude=abs(factor), phase=np.angle(factor))
    truth = contact.burst(
        motor().slider, orbits(AMPLITUDE), duration=2e-3, after=0.0, tolerance=1e-4, samples=400, method="stepped",
        envelope=envelope,
    )  # fmt: skip
    state = shaped.start()
    error = []
    for step, velocity in zip(np.diff(truth.time), truth.velocity[1:], strict=True):
        state.advance(step, AMPLITUDE)
        error.append(abs(state.velocity - velocity))
    assert max(error) < 5e-5 * steady(AMPLITUDE)


def with_response(drive):
    """The motor with a ring-up put into its first drive; its tables follow after those that are there."""
    whole = motor()
    parameters = whole.parameters.copy()
    own = reduced_motor.index.FIRST_DRIVE
    parameters[own + reduced_motor.index.RESPONSE_NODES] = len(drive.response)
    parameters[own + reduced_motor.index.RESPONSE_STEP] = drive.response_step
    parameters[own + reduced_motor.index.RESPONSE] = len(whole.tables)
    tables = np.concatenate([whole.tables, np.ascontiguousarray(drive.response).view(float)])
    return replace(whole, parameters=parameters, tables=tables)


def test_the_second_drive_runs_the_other_way_and_brings_the_slider_back():
    _, state = run([(0.05, AMPLITUDE, 0.0)])
    there = state.velocity
    assert there > 0.0
    _, mirrored = run([(0.05, -AMPLITUDE, 0.0)])
    assert mirrored.velocity == pytest.approx(-there, rel=1e-9)
    state.advance(0.5, -AMPLITUDE)
    assert state.velocity == pytest.approx(-steady(AMPLITUDE), rel=1e-3)


def test_a_slider_that_is_held_gives_way_as_cattaneo_says_and_comes_back():
    whole, slider = motor(), motor().slider
    limit = slider.friction_coefficient * slider.preload
    state = whole.start()
    for _ in range(2000):  # slowly, or it would ring
        state.advance(1e-4, 0.0, force=min(state.time / 0.1, 1.0) * 0.6 * limit)
    z = slider.rest_approach(1)
    moved = slider.limit_slope * z * (1.0 - (1.0 - 0.6) ** (2.0 / 3.0))
    assert state.sticks
    assert state.position == pytest.approx(moved, rel=1e-2)
    for _ in range(3000):
        state.advance(1e-4, 0.0, force=max(0.0, 1.0 - (state.time - 0.2) / 0.1) * 0.6 * limit)
    assert abs(state.position) < 0.02 * moved


def test_tables_are_exact_in_amplitude_and_preload():
    # the scaling that makes two ratios of three numbers: another amplitude and preload, the same tau and nu
    slider, drive = motor().slider, motor().drives[0]
    small = Drive(name="", orbits=tuple(each.scaled(2e-9) for each in drive.orbits))
    sizes = np.array([0.1, 0.5, 0.9])
    one, other = mean_forces(slider, drive, 0.55, sizes), mean_forces(slider, small, 0.55, sizes)
    assert one[0] == pytest.approx(other[0], rel=1e-9)
    np.testing.assert_allclose(one[1], other[1], rtol=1e-6)
    worst, usual = motor().interpolation_error
    assert 1e-5 < worst < 5e-3
    assert usual < 2e-4


def test_stated_errors_of_the_steady_velocity_hold():
    whole = motor()
    assert 2e-6 < whole.averaging_error < 1e-3
    assert whole.velocity_error < 1e-3
    for level in (3e-9, 10e-9):
        first = float(contact.mean_motion(whole.slider, orbits(level)).first_order)
        state = whole.start()
        for _ in range(20):
            state.advance(0.1, level)
        assert abs(state.velocity / first - 1.0) < 1.5 * whole.velocity_error + 1e-9


@pytest.fixture(scope="module")
def library(tmp_path_factory):
    folder = tmp_path_factory.mktemp("c")
    (folder / "motor.c").write_text(source(motor()))
    (folder / "motor.h").write_text(header(motor()))
    target = folder / "motor.so"
    flags = ["-std=c99", "-Wall", "-Werror", "-Wno-unused-function", "-O1", "-ffp-contract=off", "-shared", "-fPIC"]
    subprocess.run([*compiler(), *flags, "-o", target, "motor.c", "-lm"], cwd=folder, check=True)
    return ctypes.CDLL(str(target))


def test_c_and_python_take_the_same_steps(library):
    number, state = ctypes.c_double, (ctypes.c_double * reduced_motor.index.STATE_SIZE)()
    for name in ("position", "velocity", "deformation"):
        getattr(library, f"sawmotor_{name}").restype = number
    library.sawmotor_start(state, number(motor().preload), number(0.0))
    python = motor().start()
    for duration, level, force in (
        (1e-3, AMPLITUDE, 0.0),
        (2e-2, AMPLITUDE, -2e-5),
        (5e-4, -AMPLITUDE, 0.0),
        (0.03, 0, 0),
    ):
        python.advance(duration, level, force=force)
        done = library.sawmotor_advance(state, number(level), number(force), number(motor().preload), number(duration))
        assert done == 0
    for name in ("position", "velocity", "deformation"):
        assert getattr(library, f"sawmotor_{name}")(state) == pytest.approx(getattr(python, name), rel=1e-9, abs=1e-16)
    assert library.sawmotor_advance(state, number(1e-9), number(0), number(-1.0), number(1e-3)) == 1


WARMTH, THERMAL_TIME = 3e17, 0.05  # K per m^2 of the prescribed wave, s


def warmed_motor():
    """The motor of a stator that warms, faster than any real one."""
    index, numbers = reduced_motor.index, motor().parameters.copy()
    numbers[index.THERMAL_TIME] = THERMAL_TIME
    for drive in range(2):
        numbers[index.FIRST_DRIVE + drive * index.DRIVE_SIZE + index.WARMTH] = (1 + drive) * WARMTH
    return replace(motor(), parameters=numbers)


def test_the_stator_warms_as_one_body(tmp_path):
    """T' = (w s^2 - T)/tau in closed form, in Python and in C, while the motion is that of a cold one."""
    (tmp_path / "motor.c").write_text(source(warmed_motor()))
    (tmp_path / "motor.h").write_text(header(warmed_motor()))
    target = tmp_path / "motor.so"
    subprocess.run([*compiler(), "-std=c99", "-O1", "-shared", "-fPIC", "-o", target, tmp_path / "motor.c", "-lm"],
                   cwd=tmp_path, check=True)  # fmt: skip
    library, number = ctypes.CDLL(str(target)), ctypes.c_double
    library.sawmotor_temperature_rise.restype = number
    state = (number * reduced_motor.index.STATE_SIZE)()
    library.sawmotor_start(state, number(motor().preload), number(0.0))
    python, cold, rise = warmed_motor().start(), motor().start(), 0.0
    for duration, level in ((0.02, AMPLITUDE), (0.03, -AMPLITUDE), (0.04, 0.0)):
        python.advance(duration, level)
        cold.advance(duration, level)
        assert library.sawmotor_advance(state, number(level), number(0), number(motor().preload), number(duration)) == 0
        steady = (1 + (level < 0)) * WARMTH * level**2
        rise = steady + (rise - steady) * np.exp(-duration / THERMAL_TIME)
        assert python.temperature_rise == pytest.approx(rise, rel=1e-12)
        assert library.sawmotor_temperature_rise(state) == pytest.approx(rise, rel=1e-12)
    assert rise > 1.0
    assert python.position == cold.position
    assert cold.temperature_rise == 0.0


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fmpy's own imports
def test_the_fmu_carries_the_stator_s_temperature(tmp_path):
    fmpy = pytest.importorskip("fmpy")
    path = tmp_path / "motor.fmu"
    path.write_bytes(fmu(warmed_motor(), "3")[0])
    result = fmpy.simulate_fmu(
        str(path), stop_time=0.1, step_size=1e-3, output_interval=1e-2, start_values={"drive": AMPLITUDE},
        output=["temperature_rise"],
    )  # fmt: skip
    expected = WARMTH * AMPLITUDE**2 * -np.expm1(-result["time"] / THERMAL_TIME)
    assert result["temperature_rise"] == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_the_warmth_is_the_run_s():
    """A stator of PZT-8: its mean rise over the squared voltage, and its time constant."""
    table = {
        "stator": {"material": "PZT-8", "length": "20 mm", "thickness": "2 mm", "width": "12 mm", "ends": "absorbing",
                   "diffraction": False},
        "transducer": [{"name": "t", "center": "5 mm", "finger_pairs": 4, "period": "1 mm", "metallisation": 0.5,
                        "aperture": "8 mm"}],
        "drive": {"frequency": "2.2 MHz", "transducer": "t", "voltage": [40.0, 60.0], "duty": 0.5},
        "slider": {"position": "14 mm", "contacts": 1, "radius": "1 mm", "mass": "0.089 g", "preload": "2 mN",
                   "ball": "steel", "friction_coefficient": 0.2, "damping": {"normal": "0.5 N s/m"}},
    }  # fmt: skip
    found = averaged_motor(Scene.from_table("", table), tolerance=1e-2)
    heat = studies.run(found.scene, tolerance=1e-2).heat
    state = found.start()
    state.advance(heat.time_constant_s, 60.0)
    assert state.temperature_rise == pytest.approx(2.0 * heat.mean_rise_K * -np.expm1(-1.0), rel=1e-9)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fmpy's own imports
@pytest.mark.parametrize("version", ["3", "2"])
def test_fmpy_runs_the_fmu(version, tmp_path):
    fmpy = pytest.importorskip("fmpy")
    from fmpy.validation import validate_fmu

    content, remark = built(version)
    assert remark == ""
    path = tmp_path / "motor.fmu"
    path.write_bytes(content)
    assert validate_fmu(str(path)) == []
    times = np.array([0.0, 0.1, 0.1, 0.2])
    inputs = np.zeros(4, dtype=[("time", float), ("load_force", float), ("drive", float)])
    inputs["time"], inputs["load_force"] = times, [0.0, 0.0, -2e-5, -2e-5]
    inputs["drive"] = AMPLITUDE
    result = fmpy.simulate_fmu(
        str(path), stop_time=0.2, step_size=1e-3, output_interval=1e-3, input=inputs,
        start_values={"drive": AMPLITUDE, "position_start": 1.0},
    )  # fmt: skip
    _, state = run([(0.1, AMPLITUDE, 0.0)])
    assert result["velocity"][100] == pytest.approx(state.velocity, rel=1e-4)
    state.advance(0.1, AMPLITUDE, force=-2e-5)
    assert result["velocity"][-1] == pytest.approx(state.velocity, rel=1e-3)  # the importer's step of the input
    assert result["position"][-1] - 1.0 == pytest.approx(state.position, rel=1e-3)
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
    assert {"modelDescription.xml", "sources/motor.c", "sources/motor.h", f"sources/fmi{version}.c"} <= set(names)
    assert not any(name.endswith(".py") for name in names)


@pytest.mark.filterwarnings("ignore::DeprecationWarning")  # of fmpy's own imports
@pytest.mark.parametrize("version", ["3", "2"])
def test_an_importer_may_step_by_more_than_is_suggested(version, tmp_path):
    """FMPy doubles the suggested step of a co-simulation until 1000 outputs are left (simulate_fmu, 0.3.32).

    0.3 s at 10 us are stepped by 320 us. The motor has its own steps within one of the importer: with constant inputs
    its answers are the same; a change of an input waits for the next step.
    """
    fmpy = pytest.importorskip("fmpy")
    path = tmp_path / "motor.fmu"
    path.write_bytes(built(version)[0])
    suggested = float(fmpy.read_model_description(str(path)).defaultExperiment.stepSize)
    assert suggested == STEP
    long = fmpy.simulate_fmu(str(path), start_values={"drive": AMPLITUDE})
    taken = float(long["time"][1])
    if fmpy.__version__ == "0.3.32":
        assert taken == pytest.approx(32 * suggested, rel=1e-9)
    assert taken >= suggested
    alone = motor().start()
    for row in long[[1, 10, 300, -1]]:
        for _ in range(10):
            alone.advance((float(row["time"]) - alone.time) / 2, AMPLITUDE)
        alone.advance(float(row["time"]) - alone.time, AMPLITUDE)
        assert row["velocity"] == pytest.approx(alone.velocity, rel=1e-5, abs=1e-6 * steady(AMPLITUDE))
        assert row["position"] == pytest.approx(alone.position, rel=1e-5)


def schedule_of_a_burst():
    """Times in s, levels in m and forces in N: ring-up, load step, stop."""
    return ((0.05, AMPLITUDE, 0.0), (0.05, AMPLITUDE, -2e-5), (0.002, 0.0, -2e-5))


@cache
def truth_of_a_burst(step):
    """Velocity and position at the end of each part, moved on in an importer's steps."""
    state, out = motor().start(), []
    for duration, level, force in schedule_of_a_burst():
        for _ in range(round(duration / step)):
            state.advance(step, level, force=force)
        out.append((state.velocity, state.position))
    return np.array(out)


def test_libcosim_runs_the_fmu_of_version_2(tmp_path):
    # the Open Simulation Platform's libcosim, with FMI Library as importer: no code of fmpy
    pytest.importorskip("libcosimpy")
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    path = tmp_path / "motor.fmu"
    path.write_bytes(built("2")[0])
    execution = CosimExecution.from_step_size(step_size=10_000)  # ns
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(path), instance_name="motor"))
    setter, watcher = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(setter)
    execution.add_observer(watcher)
    number = {each.name.decode(): each.reference for each in execution.slave_variables(slave)}
    out = []
    for duration, level, force in schedule_of_a_burst():
        setter.slave_real_values(slave, [number["drive"], number["load_force"]], [level, force])
        assert execution.step(round(duration / 1e-5))
        out.append(watcher.last_real_values(slave, [number["velocity"], number["position"]]))
    np.testing.assert_allclose(out, truth_of_a_burst(1e-5), rtol=1e-6, atol=1e-4 * steady(AMPLITUDE))


def test_ecos_runs_the_fmu_of_version_3(tmp_path):
    # the co-simulation engine Ecos (C++), with fmi4c as importer
    for known in importlib.metadata.distributions(name="tbb"):  # a library that ecospy does not find by itself
        for file in known.files:
            if file.name == "libtbb.so.12":
                ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
    ecospy = pytest.importorskip("ecospy", exc_type=(ImportError, OSError))
    path = tmp_path / "motor.fmu"
    path.write_bytes(built("3")[0])
    out = []
    with ecospy.EcosSimulationStructure() as structure:
        structure.add_model("motor", str(path))
        structure.add_parameter_set("start", {"motor::drive": AMPLITUDE, "motor::position_start": 1.0})
        with ecospy.EcosSimulation(structure=structure, step_size=1e-5) as simulation:
            simulation.init(parameter_set="start")
            for duration, level, force in schedule_of_a_burst():
                simulation.set_real("motor::drive", level)
                simulation.set_real("motor::load_force", force)
                simulation.step(round(duration / 1e-5))
                out.append([simulation.get_real(f"motor::{name}") for name in ("velocity", "position")])
    truth = truth_of_a_burst(1e-5) + np.array([0.0, 1.0])
    np.testing.assert_allclose(out, truth, rtol=1e-9, atol=1e-12)


def test_a_ring_on_a_surface_at_rest_keeps_amplitude_and_phase():
    # 80 rings about the load's deformation, against the slider's equation solved by scipy
    slider = motor().slider
    limit = slider.friction_coefficient * slider.preload
    reach = slider.limit_slope * slider.rest_approach(1)
    state = motor().start(force=-0.6 * limit)

    def rate(_, y):
        x, v = y
        spring = limit * np.sign(x) * (1.0 - max(1.0 - abs(x) / reach, 0.0) ** 1.5)
        return [-v, (spring - slider.tangential_damping * v - 0.1 * limit) / slider.mass]

    truth = solve_ivp(rate, (0.0, 0.01), [state.deformation, 0.0], rtol=1e-9, atol=1e-18, max_step=1e-5)
    state.advance(0.01, 0.0, force=-0.1 * limit)
    largest = np.abs(truth.y[1]).max()
    assert state.sticks
    assert state.velocity == pytest.approx(truth.y[1, -1], abs=2e-3 * largest)


def test_without_a_compiler_the_fmu_has_its_sources_and_says_so(monkeypatch):
    monkeypatch.setenv("CC", "no-such-compiler")
    content, remark = fmu(motor())
    assert "no C compiler was found" in remark
    assert b"sources/motor.c" in content
    assert b"binaries" not in content


def test_a_compiler_that_fails_is_one_sentence(monkeypatch, tmp_path):
    broken = tmp_path / "broken-cc"
    broken.write_text("#!/bin/sh\necho 'no such machine' >&2\nexit 1\n")
    broken.chmod(0o755)
    monkeypatch.setenv("CC", str(broken))
    with pytest.raises(RunError, match=r"refuses the sources of the FMU: no such machine"):
        fmu(motor())


def test_inputs_that_cannot_be_are_refused():
    state = motor().start()
    with pytest.raises(SceneError, match="preload must be positive"):
        state.advance(1e-3, AMPLITUDE, preload=0.0)
    alone = replace(motor(), drives=motor().drives[:1])
    with pytest.raises(SceneError, match="nothing drives the other way"):
        alone.start().advance(1e-3, -AMPLITUDE)


def test_a_law_that_averaging_does_not_know_is_refused_before_any_table(monkeypatch):
    monkeypatch.setattr("studies.export.averaged_motor.force_tables", lambda *_: pytest.fail("minutes of tables"))
    hysteretic = Scene.load("twente-contact").replace(slider={"law": "hysteretic"})
    with pytest.raises(RunError, match="the averaged method does not apply"):
        averaged_motor(hysteretic)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["twente-contact"], "--format is missing"),
        (["twente-contact", "--format", "fmx"], "--format 'fmx' is not one of fmu, c, gds, dxf, uff, csv, "),
        (["twente-contact", "--format", "c", "--fmi", "2"], "--fmi is not taken by the format c"),
        (["twente-contact", "--format", "fmu", "--fmi", "4"], "--fmi must be one of 3, 2, got '4'"),
    ],
)
def test_wrong_calls_write_nothing(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", *words]) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_the_command_writes_c_and_does_not_replace_what_is_not_its_own(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "twente-contact", "--format", "c"]) == 0
    assert {each.name for each in (tmp_path / "results/twente-contact-export-c").iterdir()} >= {"motor.c", "motor.h"}
    assert "interpolation of the mean force" in capsys.readouterr().out
    (tmp_path / "mine.fmu").write_text("mine")
    assert main(["export", "twente-contact", "--format", "fmu", "--out", "mine.fmu"]) == 2
    assert (tmp_path / "mine.fmu").read_text() == "mine"


def test_what_has_no_translation_is_refused_with_its_line():
    with pytest.raises(UntranslatableError, match="line 2"):
        c_source("def f(x: float) -> float:\n    return [x]")


def test_the_surface_amplitude_is_in_the_unit_of_the_drive():
    _, state = run([(1e-3, AMPLITUDE, 0.0)])
    assert state.surface_amplitude == pytest.approx(AMPLITUDE, rel=1e-12)
    assert math.isclose(motor().preload, MASS * 9.80665, rel_tol=1e-3)
