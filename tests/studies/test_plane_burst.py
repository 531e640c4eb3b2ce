"""Bursts of runs in the plane, against the scalar solver, the contacts' own burst, and closed forms."""

import math
from types import SimpleNamespace

import matplotlib.pyplot as plt
import numpy as np
import pytest

import contact
from contact import Envelope, plane
from studies import Scene, SceneError, run
from studies.inverse.prediction import MeasurementPredictor
from studies.lab.measurement_csv import read_measured
from studies.model.plane import StatorSurface
from studies.model.resolve import build
from studies.motor import plane_positioning, positioning
from studies.record import Record
from studies.record.run_pictures import pictures
from studies.record.text import comparison, points_table
from studies.record.velocity_comparison import compared, refuse_incomparable
from studies.solve import plane_burst
from studies.solve.contact_at_level import point_answer
from studies.solve.plane_burst import Rise
from studies.solve.ring_up import RingUp
from studies.study_list import driven_contact
from tests.oracles.contact_plane import in_steps
from tests.studies.test_plane import LIMIT, THREE, scene

DAMPED = {"damping": {"normal": "0.5 N s/m"}}


def burst_scene(*sources, burst="0.2 ms", **keys):
    return scene(*(sources or ({},)), burst=burst, **(DAMPED | keys))


@pytest.mark.parametrize(("burst", "phase"), [("0.2 ms", 0), ("0.2001 ms", 70), ("18.2 us", -140)])
def test_along_one_wave_it_is_the_burst_of_a_slider_that_moves_along_x(burst, phase):
    """Events in the plane against the scalar kernels, whatever the phase: both begin at an upward zero of u_z."""
    plane_run = run(burst_scene({"phase": phase}, burst=burst), tolerance=1e-5)
    table = burst_scene(burst=burst).to_table()
    table["slider"].pop("freedom")
    table["wave"].pop("sources")
    line_run = run(Scene.from_table("", table), tolerance=1e-5)
    (own,), (other,) = plane_run.points, line_run.points
    ((_, motion),), ((_, line),) = plane_run.trajectories, line_run.trajectories
    scale = motion.reference
    assert own.velocity_at_burst_end_m_per_s == pytest.approx(other.velocity_at_burst_end_m_per_s, abs=1e-6 * scale)
    assert motion.duration == pytest.approx(line.duration, rel=1e-12)
    during = line.time <= line.duration * (1.0 + 1e-12)
    along = np.trapezoid(np.append(0.0, line.velocity[during]), np.append(0.0, line.time[during]))
    assert motion.pose[motion.burst_end, 0] == pytest.approx(along, abs=1e-4 * scale * motion.duration)
    assert own.lateral_displacement_m == pytest.approx(0.0, abs=1e-15)
    assert own.burst_method == "exact"
    assert own.status == "ok"


@pytest.mark.parametrize(
    "waveform",
    [
        {"shape": "ramp", "rise": "50 us", "fall": "30 us"},
        {"shape": "modulated", "depth": 0.6, "frequency": "9 kHz"},
        {"shape": "chirp", "sweep": ["-20 kHz", "30 kHz"]},
        "time_us,amplitude,phase_deg\n0,0.5,0\n80,1,0\n90,1,90\n200,0.8,90\n",
    ],
    ids=["ramp", "modulated", "chirp", "file"],
)
def test_a_waveform_along_one_wave_is_that_of_a_slider_that_moves_along_x(waveform, tmp_path):
    """Events in the plane against fixed steps of the scalar kernels."""
    if isinstance(waveform, str):
        (tmp_path / "shape.csv").write_text(waveform, encoding="utf-8")
        waveform = {"file": str(tmp_path / "shape.csv")}
    table = burst_scene({"phase": 30}, burst="0.2 ms").to_table()
    table["wave"]["waveform"] = waveform
    plane_run = run(Scene.from_table("", table), tolerance=1e-4)
    table["slider"].pop("freedom")
    table["wave"].pop("sources")
    line_run = run(Scene.from_table("", table), tolerance=1e-4)
    (own,), (other,), ((_, motion),) = plane_run.points, line_run.points, plane_run.trajectories
    miss = abs(own.velocity_at_burst_end_m_per_s - other.velocity_at_burst_end_m_per_s)
    assert miss < 1e-5 * motion.reference
    assert (own.burst_method, own.status) == ("exact", "ok")
    rectangular = run(burst_scene({"phase": 30}, burst="0.2 ms"), tolerance=1e-4).points[0]
    changed = abs(own.velocity_at_burst_end_m_per_s - rectangular.velocity_at_burst_end_m_per_s)
    assert changed > 20 * miss or "sweep" in waveform  # as many cycles of another frequency push as much


@pytest.mark.slow
def test_the_burst_that_is_advised_on_a_slow_beat_has_an_answer():
    """Over a whole beat of 5 kHz, against fixed steps of an integrator that shares nothing."""
    waves = {}, {"direction": 90, "frequency": "2.205 MHz"}
    refused = run(scene(*waves, level="3 nm", **DAMPED), tolerance=1e-2)
    assert "slower than twice the contact resonance" in refused.shortfall
    assert 'method "exact" (slider.method of a scene), or the same method through a burst' in refused.points[0].status
    record = run(burst_scene(*waves, level="3 nm", burst="0.2 ms"), tolerance=1e-3)
    (point,), ((_, motion),) = record.points, record.trajectories
    assert point.status == "ok"
    assert (point.burst_method, point.velocity_m_per_s) == ("exact", None)
    assert not record.shortfall
    size, ratio, frequencies = 3e-9, 0.67, np.array([2.2e6, 2.205e6])
    turn = np.exp(2j * np.pi * frequencies * 0.75 / frequencies[1])  # u_z of the faster wave crosses zero upwards
    amplitudes = np.array([[[-1j * ratio * size, 0.0, size]], [[0.0, -1j * ratio * size, size]]]) * turn[:, None, None]
    stiffness = 4.0 / 3.0 * 64e9 * math.sqrt(1e-3)  # P = stiffness z^(3/2)
    slope = 0.08 * 64e9 / (4.0 * 12e9)  # c = mu E/4G
    body = 0.089e-3, 0.0, 0.87309e-3, 0.0, 0.0, 0.0, 0.5, 0.0, 0.0
    start = np.zeros(8)
    start[0] = -((0.87309e-3 / stiffness) ** (2.0 / 3.0))
    balls = np.array([[0.0, 0.0, 0.0, stiffness, slope, 0.08]])
    state, error = in_steps(440, frequencies, amplitudes, 0.0, body, balls, False, start)
    end = motion.rates[motion.burst_end]
    assert np.hypot(*(end - state[5:])[:2]) <= 2.0 * np.hypot(*motion.error[:2]) + np.hypot(*error[5:7])
    assert np.hypot(*error[5:7]) < 1e-5 * np.hypot(*end[:2])


def test_a_burst_of_a_slider_on_an_axle_states_its_turn_alone(tmp_path):
    ring = [["5 mm", 0], [0, "5 mm"]]
    slider = {"contacts": ring, "axis": [0, "-9 mm"], "freedom": "axle", "mass": "0.267 g", "preload": "3.5 mN"}
    record = run(burst_scene({}, wavelength="1 mm", burst="0.1 ms", **slider), tolerance=1e-1)
    (point,) = record.points
    for name in ("velocity_at_burst_end", "displacement", "lateral_displacement", "lateral_velocity_at_burst_end"):
        assert not [each for each in point if each.startswith(name)]
    assert point.turn_rad != 0.0
    turned = np.abs(np.diff(np.append(0.0, record.trajectories[0][1].yaw))).sum()
    assert point.path_length_m == pytest.approx(14e-3 * turned, rel=1e-12)  # of the ball that is farthest from the axle
    head = [each for each in points_table(record)[0] if "(m" in each or "(um" in each]
    assert head == ["path (um)"]
    record.save(tmp_path / "run")
    columns = (tmp_path / "run" / "trajectory.csv").read_text().splitlines()[0]
    assert columns == "normal_amplitude_m,time_s,yaw_rate_rad_per_s,yaw_rad,normal_position_m"
    (_, read), (_, own) = Record.load(tmp_path / "run").trajectories[0], record.trajectories[0]
    np.testing.assert_array_equal(read.rates, own.rates)
    figure, ax = plt.subplots()
    pictures(record)["trajectory"](ax)
    assert ax.get_ylabel() == "yaw rate (rad/s)"
    np.testing.assert_allclose(ax.lines[0].get_ydata(), own.rates[:, 2])
    plt.close(figure)


@pytest.mark.parametrize("method", ["auto", "averaged", "exact"])
def test_a_burst_that_takes_hours_is_refused_as_along_x(method):
    with pytest.raises(SceneError, match=r"wave.burst must be at most .* s: 2.2e\+10 cycles would take .* hours"):
        build(burst_scene(burst="1e4 s", method=method))
    build(burst_scene(burst="3000 s", method="averaged"))


def test_a_long_burst_ends_where_friction_stops_it():
    record = run(burst_scene({}, {"direction": 90}, burst="20 ms"), tolerance=1e-2)
    (point,), ((level, motion),) = record.points, record.trajectories
    end = np.array([point.velocity_at_burst_end_m_per_s, point.lateral_velocity_at_burst_end_m_per_s])
    assert end[0] == pytest.approx(end[1], rel=1e-6)  # equal waves in phase: the diagonal
    at_end, braking = motion.pose[motion.burst_end, :2], LIMIT / 0.089e-3
    slide = np.array([point.displacement_m, point.lateral_displacement_m]) - at_end
    assert slide == pytest.approx(end * np.hypot(*end) / (2.0 * braking), rel=2e-3)
    assert point.path_length_m == pytest.approx(np.hypot(point.displacement_m, point.lateral_displacement_m), rel=1e-6)
    assert level == 10e-9


@pytest.mark.slow
def test_the_pose_of_an_averaged_burst_is_within_its_error_of_that_by_events():
    keys = {"contacts": THREE, "freedom": "xy yaw", "mass": "0.267 g", "preload": "2.61927 mN", "wavelength": "1 mm"}
    waves = {"direction": 10}, {"direction": 90, "normal_amplitude": "6 nm", "frequency": "2.3 MHz"}
    waves = (waves[0] | {"normal_amplitude": "10 nm"}, waves[1])
    driven = driven_contact(burst_scene(*waves, burst="4 ms", **keys), planar=True)
    answer = point_answer(driven, driven.level, 1e-2)
    own, motion, surface = answer.point, answer.trajectory, driven.surface_at(driven.level)
    exact = plane.burst(
        driven.slider, surface, duration=4e-3, after=0.0, tolerance=1e-3, samples=1, method="exact"
    )  # fmt: skip
    assert own.burst_method == "averaged"
    assert np.all(np.abs(motion.pose[motion.burst_end] - exact.pose[-1]) <= 2.0 * motion.pose_error)
    assert own.turn_rad != 0.0
    swing = 2.0 * 0.08 * 64.0 / (4.0 * 12.0) * (0.87309e-3 / (4.0 / 3.0 * 64e9 * math.sqrt(1e-3))) ** (2.0 / 3.0)
    assert own.turn_error_rad == motion.pose_error[2] > swing / 6e-3  # arms of 6 mm


def rung_out(method):
    """Return point and motion of a short burst, and the place along x over the last part of its trajectory."""
    record = run(with_method(burst_scene(burst="20 us", damping={"normal": "2 N s/m"}), method), tolerance=1e-2)
    (point,), ((_, motion),) = record.points, record.trajectories
    assert (point.burst_method, point.status) == (method, "ok")
    return point, motion, motion.pose[-60:, 0]


def test_an_averaged_place_is_within_its_error_of_a_motion_that_rings_after_the_stop():
    (averaged, motion, _), (_, _, ringing) = rung_out("averaged"), rung_out("stepped")
    missed = np.abs(ringing - averaged.displacement_m).max()
    assert missed <= motion.pose_error[0] <= averaged.displacement_error_m < 5.0 * missed


def test_the_place_where_the_ring_would_die_out_is_within_the_error_of_its_last_instant():
    point, motion, ringing = rung_out("exact")
    sway = 0.5 * np.ptp(ringing)
    assert 10.0 * motion.pose_error[0] < 0.9 * sway < point.displacement_error_m < 1.2 * sway
    assert abs(point.displacement_m - 0.5 * (ringing.min() + ringing.max())) <= point.displacement_error_m


def with_method(given, method):
    table = given.to_table()
    table["slider"]["method"] = method
    return Scene.from_table("", table)


def test_the_motion_is_written_and_read_back(tmp_path):
    record = run(burst_scene({}, {"direction": 90, "phase": 90}, burst="0.1 ms"), tolerance=1e-2)
    record.save(tmp_path / "run")
    again = Record.load(tmp_path / "run")
    (level, motion), (same, read) = record.trajectories[0], again.trajectories[0]
    assert level == same
    for name in ("time", "pose", "rates", "height"):
        np.testing.assert_array_equal(getattr(read, name), getattr(motion, name))
    figure, axes = plt.subplots(2)
    for name, ax in zip(("trajectory", "path"), axes, strict=True):
        pictures(again)[name](ax)
        assert ax.get_xlabel()
        assert ax.lines
    figure, ax = plt.subplots()
    pictures(record)["path"](ax)
    marks = {each.get_text(): line.get_marker() for each, line in
             zip(ax.get_legend().get_texts(), ax.get_legend().get_lines(), strict=True)}  # fmt: skip
    assert marks["end of the burst"] == "s"
    assert marks["end of the motion"] == "o"
    plt.close(figure)


def test_a_contact_that_comes_to_fingers_ends_the_way():
    model = build(Scene.load("twente-planar"))
    slider = SimpleNamespace(x=np.array([5.3e-3, -2.65e-3]), y=np.zeros(2), axis=(0.0, 0.0), freedom="xy", count=2)
    driven = SimpleNamespace(
        model=model, scene=model.scene, surface=StatorSurface(center=(45e-3, 0.0), frequencies=(), motions=())
    )
    (left, _) = model.transducers
    edge = float(left.corners[:, 0].max())
    way = np.linspace(0.0, -30e-3, 31)
    motion = _motion(np.column_stack([way, 0 * way, 0 * way]))
    shorter, end = plane_burst.on_free_surface(driven, slider, motion)
    reached = np.flatnonzero(45e-3 + way - 2.65e-3 <= edge)[0]
    assert end == motion.time[reached - 1]
    assert len(shorter.pose) == reached
    across = np.linspace(0.0, 45e-3, 31)
    over, end = plane_burst.on_free_surface(driven, slider, _motion(np.column_stack([0 * way, across, 0 * way])))
    assert len(over.pose) == np.flatnonzero(across > 40e-3)[0]
    assert plane_burst.on_free_surface(driven, slider, _motion(np.zeros((4, 3))))[1] is None


def _motion(pose):
    count = len(pose)
    return plane.PlaneTrajectory(
        answer=None, time=1e-3 * np.arange(1, count + 1), pose=pose, rates=np.zeros((count, 3)), height=np.zeros(count),
        error=np.zeros(3), pose_error=np.zeros(3), duration=1.0, stopped=math.inf, reference=1.0, ledger=None,
        method="averaged", statistics={}, seconds=0.0,
    )  # fmt: skip


def test_the_rise_costs_the_time_of_the_ring_up():
    """A ramp of 20 us costs 10 us; two ring-ups that differ cost their mean."""
    time = np.linspace(0.0, 1e-4, 2001)
    ramps = [
        RingUp(error=e, envelope=Envelope(time=time, amplitude=np.minimum(time / t, 1.0), phase=0 * time))
        for t, e in ((20e-6, 1e-4), (40e-6, 3e-4))
    ]
    rise = Rise(rings=tuple(ramps), duration=1e-3)
    assert rise.time == pytest.approx(15e-6, rel=1e-3)
    assert rise.error == pytest.approx(3e-4 + 0.015, rel=1e-2)
    too_long = Rise(rings=(ramps[0], RingUp(error=0.4)), duration=1e-3)
    assert (too_long.time, too_long.error) == (0.0, 0.4)


def test_the_ring_ups_of_a_waveform_are_followed_as_they_are():
    """On a stator the waveform of each frequency is what reaches the slider, without an error of its shape."""
    time = np.linspace(0.0, 1e-4, 11)
    shapes = [Envelope(time=time, amplitude=np.minimum(time / t, 1.0), phase=t * time) for t in (2e-5, 4e-5, 6e-5)]
    rings = tuple(
        RingUp(error=e, envelope=one, ring_down=shapes[2]) for e, one in zip((1e-3, 2e-3), shapes, strict=False)
    )
    rise = Rise(rings=rings, duration=1e-4, shaped=(2.2e6, 2.3e6))
    assert (rise.time, rise.error) == (0.0, 2e-3)
    assert rise.envelopes["envelope"] == {2.2e6: shapes[0], 2.3e6: shapes[1]}
    assert rise.envelopes["ring_down"] == {2.2e6: shapes[2], 2.3e6: shapes[2]}


def test_an_unknown_way_of_solution_is_refused():
    with pytest.raises(SceneError, match="method"):
        run(with_method(burst_scene(), "quasi-static"))
    with pytest.raises(SceneError, match="must be absent in the plane: a burst follows the slider there"):
        burst_scene(travel=True)


def test_steps_in_two_axes(monkeypatch):
    """Waves along x and y: each step is that of the scalar kernels along its own axis, and nothing goes across."""
    monkeypatch.setattr(plane_positioning, "DURATIONS", (2e-4, 4e-4))
    both = scene({}, {"direction": 90}, **DAMPED)
    record = positioning.run(both, target="30 nm")
    steps = record.panel("steps_in_plane").data
    along, across = (np.asarray(steps["pose"][f"wave {number}"]) for number in (1, 2))
    line = contact.Slider(
        radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
        tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=0.5, tangential_damping=0.0,
    )  # fmt: skip
    orbit = contact.Orbit(frequency=2.2e6, normal=10e-9, tangential=-6.7e-9j)
    step = contact.step(line, orbit, cycles=880)  # 0.4 ms
    assert along[1, 0] == pytest.approx(step.displacement, rel=3e-2)
    assert across[:, 1] == pytest.approx(along[:, 0], rel=1e-6)
    assert np.abs(along[:, 1]).max() < 1e-15
    own = record.panel("move_in_plane").data
    ends = [np.array([own[key]["wave 2"][-1] for key in ("x_m", "y_m")])]
    assert ends[0] == pytest.approx([30e-9, 30e-9], rel=2e-2)
    together = np.asarray(steps["pose"]["wave 1 and wave 2"])
    assert together[:, 0] == pytest.approx(together[:, 1], rel=1e-6)
    assert together[1, 0] < 0.9 * along[1, 0]  # one friction for both
    for panel in record.panels:
        figure, ax = plt.subplots()
        positioning.figure(panel, ax)
        assert ax.get_xlabel()
        plt.close(figure)


def test_what_steps_in_the_plane_do_not_take_is_refused():
    with pytest.raises(SceneError, match="--loop must be absent with a slider in the plane"):
        positioning.run(scene({}, {"direction": 90}), loop=["noise=0"])
    with pytest.raises(SceneError, match="--target"):
        positioning.run(scene({}, {"direction": 90}), target="-3 um")


def data_file(folder, text):
    path = folder / "data.csv"
    path.write_text(text, encoding="utf-8")
    return read_measured(path)


def test_measured_motions_in_the_plane_are_predicted(tmp_path):
    """The predictions of `fit` are the points of a run; an amplitude factor is a larger level."""
    keys = {"contacts": THREE, "freedom": "xy yaw", "mass": "0.267 g", "preload": "2.61927 mN", "inertia": "5 g mm^2"}
    pushed = scene({}, load=["5 uN", "2 uN"], torque="10 nN m", wavelength="1 mm", **keys)
    lateral = data_file(tmp_path, "normal_amplitude_nm,lateral_velocity_mm_per_s\n10,-0.1\n")
    yaw = data_file(
        tmp_path, "normal_amplitude_nm,yaw_rate_rad_per_s,yaw_rate_standard_deviation_rad_per_s\n10,1,0.1\n"
    )
    assert (lateral.quantity, lateral.values, yaw.deviations) == ("lateral velocity", (-1e-4,), (0.1,))
    predictor = MeasurementPredictor(pushed, tolerance=1e-3)
    across, turning = predictor.predict([(lateral, {}), (yaw, {})])
    driven = driven_contact(pushed, planar=True)
    point = point_answer(driven, 10e-9, 1e-3).point
    assert across == pytest.approx([point.lateral_velocity_m_per_s], rel=1e-6)
    assert turning == pytest.approx([point.yaw_rate_rad_per_s], rel=1e-6)
    assert abs(across[0]) > 1e-5
    larger = point_answer(driven, 12e-9, 1e-3).point
    one_volt = MeasurementPredictor(pushed, tolerance=1e-3).contact({"amplitude_factor": 1.2})
    at_ten = point_answer(one_volt, 10e-9, 1e-3).point
    assert at_ten.velocity_m_per_s == pytest.approx(larger.velocity_m_per_s, rel=1e-6)


def test_columns_of_further_velocities_are_named(tmp_path):
    """A measurement has one quantity; run and fit print which columns are left out."""
    both = data_file(tmp_path, "normal_amplitude_nm,velocity_mm_per_s,lateral_velocity_mm_per_s\n10,2,-0.1\n")
    remark = "lateral_velocity_mm_per_s left out: the velocity is read; give each other quantity a file of its own"
    assert (both.quantity, both.values, both.remarks) == ("velocity", (2e-3,), (remark,))
    assert ("", remark) in list(comparison(compared(both, [1.9e-3])))
    all_three = data_file(tmp_path, "voltage_V,yaw_rate_rad_per_s,lateral_velocity_m_per_s\n10,1,-0.1\n")
    assert [each.partition(" left")[0] for each in all_three.remarks] == ["yaw_rate_rad_per_s"]
    assert data_file(tmp_path, "voltage_V,lateral_velocity_m_per_s\n10,-0.1\n").remarks == ()


def test_rotations_of_a_rotor_are_read_in_turns_per_minute(tmp_path):
    """The column of a run's own velocity.csv was refused."""
    data = data_file(tmp_path, "voltage_V,rotation_rpm,rotation_standard_deviation_rpm\n20,-60,3\n40,30,6\n")
    assert (data.quantity, data.values) == ("yaw rate", pytest.approx((-2.0 * np.pi, np.pi)))
    assert data.deviations == pytest.approx((0.1 * np.pi, 0.2 * np.pi))
    assert data.remarks == ()
    with pytest.raises(SceneError, match="got a yaw rate: sawmotor fit compares it"):
        refuse_incomparable(Scene.load("rotor"), data)


def test_measurements_that_a_slider_does_not_make_are_refused(tmp_path):
    yaw = data_file(tmp_path, "normal_amplitude_nm,yaw_rate_rad_per_s\n10,1\n")
    with pytest.raises(SceneError, match="holds a yaw rate"):
        MeasurementPredictor(scene({}), tolerance=1e-3).predict([(yaw, {})])
    trace = data_file(tmp_path, "time_ms,velocity_mm_per_s\n0,0\n1,1\n")
    with pytest.raises(SceneError, match="holds a burst, which is predicted of a slider along x"):
        MeasurementPredictor(burst_scene(), tolerance=1e-3).predict([(trace, {})])
    with pytest.raises(SceneError, match="compared with a slider along x alone"):
        refuse_incomparable(burst_scene(), trace)
