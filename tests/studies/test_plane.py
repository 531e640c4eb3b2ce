"""Runs of sliders in the plane on prescribed waves.

Oracle: cases of two independent integrators (event-driven with Radau's collocation, and return mapping with Richardson
extrapolation), which agree to 3e-8 of the velocity; closed forms; rotations of a whole scene.
"""

import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import contact
from studies import Scene, SceneError, run, sweep
from studies.inverse import Measurement, fit
from studies.inverse.prediction import MeasurementPredictor
from studies.model.resolve import build
from studies.motor import load_line, trajectory
from studies.record import Record
from studies.record.point import Point
from studies.record.text import points_table
from studies.scene.stator_keys import Cooling
from studies.solve import heat
from studies.solve.electrical import electrical_block
from studies.solve.plane_surface import further_motions
from studies.solve.surface_blocks import surface_columns, wave_block
from studies.solve.surface_motion import solved_motion
from studies.study_list import driven_contact

BALL = {
    "radius": "1 mm", "mass": "0.089 g", "contacts": 1, "preload": "0.87309 mN", "friction_coefficient": 0.08,
    "effective_modulus": "64 GPa", "tangential_modulus": "12 GPa", "freedom": "xy",
}  # fmt: skip
THREE = [["6 mm", 0], ["-3 mm", "5.19615 mm"], ["-3 mm", "-5.19615 mm"]]
LIMIT = 0.08 * 0.87309e-3  # N: friction coefficient times preload
EXACT = 2e-7  # m/s: the cases' own error


def scene(*sources, level="10 nm", wavelength=None, burst=None, **slider):
    wave = {"frequency": "2.2 MHz", "normal_amplitude": level, "tangential_ratio": 0.67, "sources": list(sources)}
    wave |= {} if wavelength is None else {"wavelength": wavelength}
    wave |= {} if burst is None else {"burst": burst}
    return Scene.from_table("", {"wave": wave, "slider": BALL | slider})


def velocity(record):
    (point,) = record.points
    return np.array([point.velocity_m_per_s, point.lateral_velocity_m_per_s])


@pytest.mark.parametrize(
    ("sources", "expected"),
    [
        ([{}], (0.0683658806, 0.0)),
        ([{}, {"direction": 90}], (0.0743296047, 0.0743296047)),
        ([{}, {"direction": 90, "phase": 90}], (0.0202250455, 0.0816736288)),
        ([{}, {"direction": 90, "phase": -90}], (0.0816736288, 0.0202250455)),
        ([{}, {"direction": 90, "frequency": "2.3 MHz"}], (0.06470998, 0.06670011)),
    ],
    ids=["one", "in phase", "ahead", "behind", "two frequencies"],
)
def test_waves_from_two_sides(sources, expected):
    # that of averaging: the full motion of an undamped ball on a beat is unstable
    record = run(scene(*sources), tolerance=1e-2)
    assert velocity(record) == pytest.approx(expected, abs=EXACT if len(sources) < 3 else 1e-6)
    assert record.points[0].status == "ok"


def test_a_force_across_the_wave_is_answered_by_a_drift():
    pushed = run(scene({}, load=[0.0, 0.2 * LIMIT]), tolerance=1e-3)
    assert velocity(pushed) == pytest.approx((0.0681188558, -1.7441887e-3), abs=EXACT)
    # the drift per degree is the slope of that velocity in the force, which the weight on a slope makes
    drift = run(scene({}), tolerance=1e-3).points[0].drift_m_per_s_per_deg[1]
    force = 0.089e-3 * 9.81 * np.pi / 180
    assert drift == pytest.approx(8.2248723e-5 / (0.01 * LIMIT) * force, rel=1e-3)


def test_the_threshold_of_a_run_is_that_along_the_wave():
    table = scene({}).to_table()
    table["slider"].pop("freedom")
    table["wave"].pop("sources")
    line, own = run(Scene.from_table("", table)), run(scene({}))
    assert own.summary.threshold_amplitude_m == pytest.approx(line.summary.threshold_amplitude_m, rel=6e-4)


def test_a_slope_is_a_force():
    force = 0.089e-3 * 9.81 * np.sin(np.radians(0.5))
    inclined, pushed = (run(scene({}, **keys)) for keys in ({"incline": [0.5, 0.0]}, {"load": [force, 0.0]}))
    assert velocity(inclined) == pytest.approx(velocity(pushed), rel=1e-12)


def test_a_number_as_load_acts_against_the_motion():
    free, loaded = (run(scene({}, {"direction": 90, "phase": 90}, **keys)) for keys in ({}, {"load": "5 uN"}))
    towards = velocity(free) / np.hypot(*velocity(free))
    pushed = run(scene({}, {"direction": 90, "phase": 90}, load=[float(each) * 5e-6 for each in towards]))
    assert velocity(loaded) == pytest.approx(velocity(pushed), rel=1e-9)
    assert velocity(loaded) @ towards < velocity(free) @ towards


@pytest.mark.parametrize(("share", "amplitudes"), [(0.3, ["0.5 nm", "1 nm", "3 nm"]), (0.9, ["0.5 nm"])])
def test_a_number_as_load_below_and_above_the_stall_is_that_along_x(share, amplitudes):
    """The kernels along x: threshold under the load, slider pushed back, and held where the free one rests too."""
    table = scene({}, level=amplitudes, load=share * LIMIT).to_table()
    table["wave"].pop("sources")
    own = run(Scene.from_table("", table), tolerance=1e-3)
    table["slider"].pop("freedom")
    line = run(Scene.from_table("", table), tolerance=1e-3)
    assert own.summary.threshold_amplitude_m == pytest.approx(line.summary.threshold_amplitude_m, rel=6e-4)
    for here, there in zip(own.points, line.points, strict=True):
        assert here.velocity_m_per_s == pytest.approx(there.velocity_m_per_s, abs=1e-4 * LIMIT / 1e-3)
        assert here.regime == there.regime
    assert min(each.velocity_m_per_s for each in own.points) < -1e-3


def test_a_load_a_slope_and_a_torque_beyond_the_friction_are_warned_about():
    damped = {"damping": {"normal": 0.5, "tangential": 1e-3}}
    dragged = run(scene({}, level=["0.5 nm"], load=1.2 * LIMIT, **damped))
    line = scene({}, level=["0.5 nm"], load=1.2 * LIMIT, **damped).to_table()
    line["wave"].pop("sources")
    line["slider"].pop("freedom")
    line = run(Scene.from_table("", line))
    assert set(line.warnings) & set(dragged.warnings) >= {each for each in line.warnings if "drags" in each} != set()
    assert dragged.points[0].velocity_m_per_s == pytest.approx(line.points[0].velocity_m_per_s, rel=1e-6)
    assert dragged.points[0].velocity_m_per_s == pytest.approx(-0.2 * LIMIT / 1e-3, rel=1e-2)
    assert dragged.summary.threshold_amplitude_m == line.summary.threshold_amplitude_m == 0.0
    pulled = run(scene({}, level=["0.5 nm"], load=[0.0, 1.2 * LIMIT], **damped))
    assert any("slider.load, 8.382e-05 N, exceeds the friction" in each for each in pulled.warnings)
    sloping = run(scene({}, level=["0.5 nm"], incline=[0.0, 30.0], **damped))
    assert any(each.startswith("slider.incline, 0.0004365 N, exceeds the friction") for each in sloping.warnings)
    turned = {"contacts": THREE, "freedom": "xy yaw", "mass": "0.267 g", "preload": "2.61927 mN", "torque": "2 uN m"}
    (turning,) = [each for each in run(scene({}, wavelength="1 mm", **turned)).warnings if "slider.torque" in each]
    friction = 3 * LIMIT * 6e-3
    assert f"2e-06 N m, exceeds the torque of the friction that holds the slider, {friction:.4g} N m" in turning


@pytest.mark.parametrize("angle", [30.0, -117.0])
def test_a_turned_scene_has_the_turned_answer(angle):
    plain = run(scene({}, {"direction": 70, "phase": 50}, load=["2 uN", "-1 uN"]))
    cos, sin = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[cos, -sin], [sin, cos]])
    load = [float(each) for each in turn @ [2e-6, -1e-6]]
    other = run(scene({"direction": angle}, {"direction": 70 + angle, "phase": 50}, load=load))
    assert velocity(other) == pytest.approx(turn @ velocity(plain), abs=1e-10)


def test_three_balls_on_a_wave_move_as_one_and_do_not_turn():
    slider = {"contacts": THREE, "freedom": "xy yaw", "mass": "0.267 g", "preload": "2.61927 mN"}
    (point,) = run(scene({}, wavelength="1 mm", **slider)).points
    assert point.velocity_m_per_s == pytest.approx(0.0683658806, abs=EXACT)
    assert point.lateral_velocity_m_per_s == pytest.approx(0.0, abs=1e-9)
    assert point.rotation_rpm == pytest.approx(0.0, abs=1e-6)
    assert point.contact_regimes.split() == ["intermittent"] * 3


def test_the_place_in_the_pattern_of_two_waves_decides_the_direction():
    """The mean over places of two waves of equal size lies on the diagonal, by the symmetry x <-> y."""
    (point,) = run(scene({}, {"direction": 90, "phase": 90}, wavelength="1 mm")).points
    along, across = point.mean_velocity_m_per_s, point.mean_lateral_velocity_m_per_s
    assert along == pytest.approx(across, rel=5 * point.mean_velocity_relative_error)
    assert point.lowest_velocity_m_per_s < 0.0 < point.highest_velocity_m_per_s
    assert point.lowest_lateral_velocity_m_per_s < 0.0 < point.highest_lateral_velocity_m_per_s


def test_a_level_without_an_answer_has_the_status_of_one_along_x(monkeypatch):
    def unstable(_motor):
        raise contact.ConvergenceError("unstable", "no steady motion")

    monkeypatch.setattr("studies.solve.plane_motor.PlaneMotor.state", unstable)
    record = run(scene({}), tolerance=1e-2)
    assert list(record.status) == ["no answer: unstable: no steady motion"]
    assert record.shortfall == "1 of 1 points have no answer: unstable: no steady motion"


def test_the_error_of_the_phase_between_crossing_waves_is_in_that_of_the_velocity():
    """Against the change of the velocity of P3 by a phase of the wave along y, with its sources known apart."""
    from contact import plane
    from studies.model.plane import StatorSurface, prescribed_surface
    from studies.solve.plane_answer import plane_point_answer

    level, error = 10e-9, 1e-3
    crossing = scene({}, {"direction": 90, "phase": 90})
    apart = [prescribed_surface(scene(*each).wave) for each in (({},), ({"direction": 90},))]

    class Beams:  # the motion of a stator whose beams cross
        def __init__(self, together):
            self.together = together

        def beams_at(self, places):
            rows = [surface.at(*np.transpose(places)).amplitudes[0].T for surface in apart]
            rows[1] = 1j * rows[1]  # ahead by 90 degrees
            return rows if not self.together else [sum(rows)]

        def at(self, places):
            return sum(self.beams_at(places))

    def stated(together):
        surface = StatorSurface(center=(0.0, 0.0), frequencies=(2.2e6,), motions=(lambda: Beams(together),))
        driven = replace(driven_contact(crossing, planar=True), surface=surface, stator_error=error)
        return plane_point_answer(driven, level, 1e-6).from_stator

    slider = driven_contact(crossing, planar=True).slider
    velocities = []
    for phase in (0.0, 1e-3):
        x, y = (each.at(np.zeros(1), np.zeros(1)).amplitudes * level for each in apart)
        waves = plane.SurfaceWaves(frequencies=(2.2e6,), amplitudes=x + 1j * np.exp(1j * phase) * y)
        velocities.append(plane.steady(slider, waves, tolerance=1e-7, method="averaged").velocity)
    turned = np.linalg.norm(velocities[1] - velocities[0]) / np.linalg.norm(velocities[0])
    assert stated(together=False) - stated(together=True) == pytest.approx(turned, rel=1e-3)
    assert turned > 0.4 * error  # the phase decides the direction


def test_levels_scale_all_waves():
    """A level is the amplitude of the first source; the others keep their ratio to it."""
    waves = {"normal_amplitude": "2 nm"}, {"normal_amplitude": "1 nm", "direction": 90}
    large = run(scene(*waves, level="10 nm"))
    same = run(scene({"normal_amplitude": "10 nm"}, {"normal_amplitude": "5 nm", "direction": 90}, level="10 nm"))
    assert velocity(large) == pytest.approx(velocity(same), rel=1e-12)


def test_path_and_coast():
    """Friction alone stops the slider within v^2/(2 mu g)."""
    record = trajectory.run(scene({}, {"direction": 90, "frequency": "2.3 MHz"}), duration=0.004, tolerance=3e-2)
    assert [each.confirmed for each in record.findings] == [True] * 3
    path = record.panel("path").data
    assert list(path["x_m"]) == ["wave 1", "wave 2", "wave 1 and wave 2", "coast"]
    assert path["y_m"]["wave 1"] == pytest.approx(0.0, abs=1e-12)
    coast, speed = (np.array(path[key]["coast"]) for key in ("time_s", "velocity_m_per_s"))
    assert coast.size > 50  # a curve, not the line between its ends
    assert (np.diff(coast) > 0.0).all()
    assert (np.diff(abs(speed)) < 0.0).all()  # friction slows it at each instant
    assert record.findings[1].found == pytest.approx(1.0, abs=0.02)


def thrust_along_x():
    """Return the blocked thrust of the one-dimensional motor, N."""
    wave = {key: value for key, value in scene({}).to_table()["wave"].items() if key != "sources"}
    driven = driven_contact(Scene.from_table("", {"wave": wave, "slider": BALL | {"freedom": "x"}}))
    return contact.blocked_thrust(driven.slider, driven.at(10e-9))[0]


PARTS = ({}, {"direction": 90, "frequency": "2.75 MHz"})
TRUE = {"slider.friction_coefficient": 0.11, "slider.preload": 1.2e-3}


def measured(predictor, levels, numbers, deviation=2e-4):
    """Return both components of the velocity at levels with a scatter, as two measurements."""
    curves = [
        Measurement(name=name, quantity=name, level_key="normal_amplitude_m", levels=levels)
        for name in ("velocity", "lateral velocity")
    ]
    random, found = np.random.default_rng(5), predictor.predict([(each, numbers) for each in curves])
    return [
        replace(each, values=tuple(v + deviation * random.normal(size=len(v))), deviations=(deviation,) * len(v))
        for each, v in zip(curves, found, strict=True)
    ]


def test_the_path_of_a_rotor_is_its_yaw():
    """The finding about its velocity, 0/0, ended the study; friction stops a rotor within omega^2 J/(2 M)."""
    keys = {"contacts": [["6 mm", 0], ["5 mm", "2 mm"]], "freedom": "axle", "axis": [0, 0], "inertia": "2 g mm^2"}
    sources = {"direction": 90}, {"direction": 120, "frequency": "2.3 MHz"}
    record = trajectory.run(scene(*sources, wavelength="1.1 mm", **keys), duration=0.004, tolerance=3e-2)
    assert [panel.name for panel in record.panels] == ["yaw"]
    stop, error = record.findings
    assert stop.confirmed
    assert error.confirmed
    assert stop.found == pytest.approx(1.0, abs=0.05)


def test_both_components_of_a_velocity_are_predicted_from_one_motion(monkeypatch):
    """They are those of a run, solved once, from a motion near it in fewer evaluations."""
    from studies.solve import plane_motor

    evaluations, steady = [], plane_motor.plane.steady

    def counted(*arguments, **options):
        state = steady(*arguments, **options)
        evaluations.append(state.statistics["evaluations"])
        return state

    moving = scene(*PARTS)
    expected = velocity(run(moving, tolerance=1e-2))
    monkeypatch.setattr(plane_motor.plane, "steady", counted)
    predictor = MeasurementPredictor(moving)
    x, y = measured(predictor, (1e-8,), {}, 0.0)
    assert np.array([*x.values, *y.values]) == pytest.approx(expected, rel=1e-6)
    assert len(evaluations) == 1
    measured(predictor, (1e-8,), {"slider.preload": 0.874e-3})
    assert evaluations[1] <= evaluations[0] - 2
    moved = velocity(run(moving.replace(slider={"preload": 0.874e-3}), tolerance=1e-2))
    x, y = measured(predictor, (1e-8,), {"slider.preload": 0.874e-3}, 0.0)
    assert np.array([*x.values, *y.values]) == pytest.approx(moved, rel=1e-6)


def test_an_axle_has_a_yaw_rate_alone():
    turning = scene({}, contacts=THREE, freedom="axle", axis=[0, 0], inertia="5 g mm^2", wavelength="1.5 mm")
    curve = Measurement(name="lab", quantity="velocity", level_key="normal_amplitude_m", levels=(1e-8,))
    with pytest.raises(SceneError, match="a slider on an axle has a yaw rate alone"):
        MeasurementPredictor(turning).predict([(curve, {})])


@pytest.mark.slow
def test_friction_and_preload_follow_from_velocities_in_the_plane():
    """Both numbers of two curves with a scatter of 0.2 mm/s; about 15 s, of which no derivative repeats a motion."""
    moving = scene(*PARTS)
    curves = measured(MeasurementPredictor(moving), (3e-9, 4e-9, 6e-9, 9e-9, 13e-9, 20e-9), TRUE)
    free = ["slider.friction_coefficient=0.03:0.3", "slider.preload=0.3 mN:5 mN"]
    found = fit(moving, curves, free)
    for key, value in TRUE.items():
        low, high = found.intervals[key]
        # 3.5 standard deviations: with this scatter the sum of squares is 5.4 less than with the true numbers
        assert abs(value - 0.5 * (low + high)) < 0.9 * (high - low) < 0.2 * value
    # the sum of squares, minimised over the preload on a grid of the other number, is 3.84 more than the least there
    assert found.intervals["slider.friction_coefficient"] == pytest.approx((0.0868, 0.1074), rel=5e-3)
    assert 2.0 < found.chi2 < 22.0


def test_stall_curve_of_one_wave():
    """Along the wave the stall is that of the one-dimensional motor; across it there is none."""
    record = load_line.run(scene({}), points=4, tolerance=1e-3)
    stall, thrust = record.panel("stall").data, thrust_along_x()
    assert stall["load_N"][0] == pytest.approx(thrust, rel=1e-4)
    across = np.argmin(np.abs(np.asarray(stall["angle_rad"]) - np.pi / 2))
    assert abs(stall["load_N"][across]) < 0.1 * thrust


@pytest.mark.slow
def test_a_scene_in_x_imports_nothing_of_the_plane():
    script = (
        "import sys, studies; studies.run('twente-contact'); "
        "found = [each for each in sys.modules if 'plane' in each and each not in ('studies.scene.plane_keys',"
        " 'studies.remarks.plane_effects')]; print(found); sys.exit(bool(found))"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.parametrize("amplitude", [3e-9, 15e-9])
@pytest.mark.parametrize("ratio", [0.034, 0.1])
def test_the_budget_of_motion_across_the_wave_holds_to_a_factor_of_two(amplitude, ratio):
    """Two of three balls on a beam that spreads: u_y in step with u_x, of opposite signs."""
    from contact import plane
    from studies.remarks.plane_effects import ACROSS

    y = [0.0, 5.2e-3, -5.2e-3]
    slider = contact.Slider(
        radius=1e-3, x=[6e-3, -3e-3, -3e-3], y=y, mass=np.inf, preload=2.61927e-3, load=(0.0, 0.0),
        friction_coefficient=0.08, effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
        stick_band=0.0, contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    )  # fmt: skip
    speeds = []
    for across in (0.0, ratio):
        u_x = -0.67j * amplitude
        rows = [[u_x, side * across * u_x, amplitude] for side in (0.0, 1.0, -1.0)]
        waves = plane.SurfaceWaves(frequencies=[2.2e6], amplitudes=[rows])
        speeds.append(plane.steady(slider, waves, tolerance=1e-5).velocity[0])
    loss = 1.0 - speeds[1] / speeds[0]
    assert 0.5 < loss / (ACROSS * ratio**2) < 2.0


def test_maps_of_a_travelling_slider_are_the_surface():
    """Splines between ten lines per wavelength, on two crossing plane waves, across the edge of a map."""
    from studies.model.plane import prescribed_surface
    from studies.solve.mapped_surface import Mapped

    exact = prescribed_surface(scene({}, {"direction": 90, "phase": 40}, wavelength="1 mm").wave)
    mapped = Mapped(surface=exact, wavelength=1e-3)
    x, y = np.linspace(-2.5e-3, 2.5e-3, 37), np.linspace(1.9e-3, 2.1e-3, 37)
    expected = exact.at(x, y).amplitudes
    assert np.abs(mapped.at(x, y).amplitudes - expected).max() < 1e-4 * np.abs(expected).max()


def test_sources_at_their_own_frequencies():
    drive = Scene.load("twente-planar").drive
    assert drive.frequencies == (2.2e6, 2.3e6)
    assert drive.at_frequency(2.3e6).driven == {"left": 0.0, "front": 1}
    assert drive.at_frequency(2.2e6).frequency == 2.2e6
    assert Scene.load("rotor").drive.frequencies == (2.2e6,)
    assert drive.at_other_frequencies == ("front",)
    assert Scene.load("rotor").drive.at_other_frequencies == ()


def test_powers_and_heat_of_sources_at_their_own_frequencies_add():
    """Against the sources of runs with each of them alone, its own frequency as drive.frequency."""

    def motions_and_model(**drive):
        model = build(Scene.load("twente-planar").replace(drive=drive) if drive else Scene.load("twente-planar"))
        at = model.scene.positions
        return solved_motion(model.alone, at, tolerance=5e-2, slider=True, missed=True), model

    motion, model = motions_and_model()
    further = further_motions(model, 5e-2)
    electrical = electrical_block(model.scene.drive, motion, further)
    given = {"source_frequencies": None, "voltage": [60.0]}
    alone = [
        motions_and_model(**given, frequency=2.2e6, sources={"left": 1.0, "front": 0.0}),
        motions_and_model(**given, frequency=2.3e6, sources={"left": 0.0, "front": 1.0}),
    ]  # fmt: skip
    blocks = [electrical_block(each.scene.drive, one) for one, each in alone]
    for key in ("power_W_per_V2", "power_radiated_W_per_V2", "power_solid_W_per_V2"):
        assert electrical[key] == pytest.approx(sum(each[key] for each in blocks), rel=1e-9)
    assert electrical.power_residual < 1e-9  # an undriven turned transducer has rounding over rounding
    powers = [each["power_W_per_V2"] for each in electrical.sources.values()]
    assert powers == pytest.approx([each.power_W_per_V2 for each in blocks], rel=1e-9)
    record = Record(
        scene=model.scene, tolerance=1e-3, points=(), electrical=electrical, wave=wave_block(model.scene, motion, None),
        surface=surface_columns(model.scene, motion),
    )  # fmt: skip
    heated, front = heat.sources(record), model.scene.transducer[1]
    assert heat.powers(record).power_W == pytest.approx(3600.0 * sum(each.power_W_per_V2 for each in blocks), rel=1e-9)
    across = [each for each in heated if each.start == pytest.approx(front.center_xy[0] - 0.5 * front.aperture)]
    assert len(across) == 2  # dielectric loss, and what its beam loses
    assert all(each.stop - each.start == pytest.approx(front.aperture) for each in across)
    ends = 3600.0 * electrical.power_radiated_W_per_V2 * (model.scene.stator.cooling or Cooling()).ends_heat_stator
    assert sum(each.power for each in heated) == pytest.approx(
        3600.0 * electrical.power_solid_W_per_V2 + ends, rel=1e-9
    )


def test_arrows_of_a_rotor_are_its_velocities():
    from studies.record.point import Point
    from studies.report.plane_drawing import contact_velocities

    rotor = Scene.load("rotor")
    velocities = contact_velocities(rotor, Point(yaw_rate_rad_per_s=-2.0))
    first = rotor.slider.offsets[0]
    assert velocities[0] == pytest.approx((2.0 * first[1], -2.0 * first[0]))
    assert np.hypot(*velocities.T) == pytest.approx(np.full(8, 2.0 * 6e-3), rel=1e-4)


def test_datasheet_of_one_wave():
    """Its stall, direction and start: momentum over the stall force bounds the time of the start from below."""
    from studies.report.motor_datasheet import datasheet

    sheet = datasheet(scene({}, load="1 uN"), tolerance=1e-3)
    rows = {row.name: row.value for row in sheet.rows}
    (stop,) = (row for row in sheet.rows if row.name == "stop distance")
    braked = 0.0683658806**2 / (2 * LIMIT / 0.089e-3)
    assert abs(stop.value - braked) < 2.0 * stop.error * stop.value < 0.05 * braked
    assert rows["speed"] == pytest.approx(0.0683658806, abs=EXACT)
    assert rows["direction"] == pytest.approx(0.0, abs=1e-6)
    assert rows["stall force"] == pytest.approx(thrust_along_x(), rel=1e-4)
    assert rows["start time"] > 0.95 * 0.089e-3 * rows["speed"] / rows["stall force"]
    assert "stall torque" not in rows
    assert "drift along y" in str(sheet)


def test_the_start_of_a_datasheet_is_on_the_waves_of_the_position():
    """It went through the pattern of crossing waves, or off the plate, and took the speed there for the steady one.

    Oracle: two integrators that share no code with it.
    """
    from studies.model.wave_to_contact import Contact
    from studies.report.plane_datasheet import SETTLED, start_and_stop, start_of
    from studies.solve.plane_motor import PlaneMotor

    driven = Contact.prescribed(build(scene({}, {"direction": 90, "phase": 90}, wavelength="1 mm")))
    speed = Point(velocity_m_per_s=0.0202250455, lateral_velocity_m_per_s=0.0816736288)
    found = start_of(PlaneMotor.of(driven, 10e-9, 1e-3), driven, 10e-9, speed)
    end = found.motion.rates[found.motion.burst_end, :2]
    assert np.abs(end - (0.0202250455, 0.0816736288)).max() < 2.0 * np.hypot(*found.motion.error[:2]) < 2e-3
    assert found.motion.pose[-1, 0] > 1e-3  # beyond the wavelength, over which the drive changes its direction
    assert 0 < found.reached < found.motion.burst_end
    time, way, *_ = start_and_stop(found, driven)
    # a start that ends later ends farther
    assert way.error * way.value > time.error * time.value * SETTLED * np.hypot(0.0202250455, 0.0816736288)


def test_the_start_of_a_rotor_is_up_to_its_mean_rotation():
    """It was up to the speed at the position, which a rotor that runs slower over a turn reaches late or never."""
    from studies.model.wave_to_contact import Contact
    from studies.report.plane_datasheet import SETTLED, start_of
    from studies.solve.plane_motor import PER_MINUTE, PlaneMotor

    keys = {"contacts": [["6 mm", 0], ["5 mm", "2 mm"]], "freedom": "axle", "axis": [0, 0], "inertia": "2 g mm^2"}
    driven = Contact.prescribed(build(scene({"direction": 90}, wavelength="1.1 mm", **keys)))
    motor = PlaneMotor.of(driven, 10e-9, 1e-3)
    here = PER_MINUTE * motor.state().yaw_rate
    found = start_of(motor, driven, 10e-9, Point(rotation_rpm=here, mean_rotation_rpm=0.5 * here))
    before, after = PER_MINUTE * found.legs[0].rates[found.reached - 1 : found.reached + 1, 2]
    assert before + found.share * (after - before) == pytest.approx(0.5 * SETTLED * here)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ({"load": [0.0, "1 uN"]}, r"The slider runs at 68\.3\d+ mm/s along x and -1\d\d\.\d+ µm/s along y at 10 nm\."),
        ({"contacts": [["6 mm", 0], ["5 mm", "2 mm"]], "freedom": "axle", "axis": [0, 0], "inertia": "5 g mm^2",
          "wavelength": "1.5 mm"}, r"The slider turns at -?[\d.]+ 1/min at 10 nm\."),
    ],
    ids=["plane", "axle"],
)  # fmt: skip
def test_the_report_states_the_motion_in_the_plane(keys, said):
    """A rotor's report said that its slider sticks at every point."""
    from studies.report.page import report

    text = " ".join(report(run(scene({}, **keys), tolerance=1e-2)).split())
    assert re.search(said, text)
    assert "their centres move with the slider" in text
    assert "along x and z only" not in text
    assert "sticks at every point" not in text


def test_sweep_of_the_plane_takes_its_own_quantities():
    from studies.solve.predictor import Predictor

    predictor = Predictor(scene({}).to_table(), tolerance=1e-3)
    (answer,) = predictor.answers([{"wave.normal_amplitude": 10e-9}], ["thrust", "pressure"])
    assert answer.point.thrust_N == pytest.approx(thrust_along_x(), rel=1e-4)
    with pytest.raises(SceneError, match="must be of ripple, thrust, torque, pressure"):
        sweep(scene({}), over={"wave.normal_amplitude": [10e-9]}, also=["limits"])


def test_sweep_of_an_axle_states_its_rotation():
    three = {"contacts": THREE, "freedom": "x", "axis": ["1 mm", 0.0], "mass": "0.267 g", "preload": "2.61927 mN"}
    rotor = scene({}, wavelength="1 mm", **three)
    found = sweep(rotor, over={"slider.torque": [0.0, 1e-8]})
    columns = found.columns()
    assert "velocity_m_per_s" not in columns
    assert columns["rotation_rpm"][0] == pytest.approx(run(rotor).points[0].rotation_rpm, rel=1e-6)
    assert columns["rotation_rpm"][0] != columns["rotation_rpm"][1]
    assert "rotation" in str(found)


def test_an_answer_of_motion_along_x_alone_is_refused_in_the_plane():
    from studies.inverse import sensitivity

    with pytest.raises(SceneError, match=r"slider\.freedom"):
        sensitivity.run(scene({}))


def test_the_table_of_an_axle_has_no_velocity_of_its_centre():
    """Three balls about their centre on one wave: the torques cancel by symmetry."""
    three = {"contacts": THREE, "freedom": "x", "axis": [0.0, 0.0], "mass": "0.267 g", "preload": "2.61927 mN"}
    record = run(scene({}, wavelength="1 mm", **three))
    assert record.points[0].rotation_rpm == pytest.approx(0.0, abs=1e-6)
    head = str(record).splitlines()[2]
    assert "rotation (1/min)" in head
    assert "velocity" not in head


def test_velocities_that_are_rounding_are_printed_as_0():
    """At 10 nm and 2.2 MHz the surface moves at 0.14 m/s: 1.4e-13 m/s, and 2.3e-11 rad/s of arms of 6 mm, are 0."""
    keys = {"contacts": THREE, "freedom": "xy yaw", "mass": "0.267 g", "preload": "2.61927 mN", "inertia": "5 g mm^2"}
    points = [
        Point(normal_amplitude_m=10e-9, velocity_m_per_s=0.05, lateral_velocity_m_per_s=v, yaw_rate_rad_per_s=rate,
              rotation_rpm=rate * 30.0 / np.pi)
        for v, rate in ((-1.3e-13, 2.2e-11), (-1.5e-13, -2.4e-11))
    ]  # fmt: skip
    record = Record(scene=scene({}, wavelength="1 mm", **keys), tolerance=1e-2, points=tuple(points))
    _, (rounding, motion) = points_table(record)
    assert rounding == ["10", "50", "0", "0", "0"]
    assert motion[2:] == ["-1.5e-10", "-2.4e-11", "-2.2918e-10"]
    assert record.points[0].lateral_velocity_m_per_s == -1.3e-13


@pytest.mark.parametrize("spread", [1e-4, 1e-2], ids=["alike", "apart"])
def test_the_mean_over_places_is_that_of_full_motions_of_which_few_are_solved(monkeypatch, spread):
    """Averaged motions that miss by nearly the same everywhere are corrected, others are not taken.

    Truth: the mean of the full motions that stand in for those of the solver.
    """
    from types import SimpleNamespace

    from studies.model.wave_to_contact import Contact
    from studies.solve.plane_motor import PlaneMotor
    from studies.solve.plane_ripple import ripple_of
    from studies.solve.point_answer import PointAnswer

    full = {}

    def state(self, waves=None, slider=None, method=None):
        """An averaged speed of 1 m/s that differs by 0.1 m/s from place to place, and a full one that is more."""
        there = np.angle((self.waves if waves is None else waves).amplitudes[:, 0, 2])
        velocity = np.array([1.0 + 0.1 * np.cos(there[0]), 0.5 + 0.1 * np.sin(there[1])])
        if method != "averaged":
            velocity = velocity * 1.003 + spread * np.sin(there)
            full[tuple(there)] = velocity
        status = "not accurate" if method == "averaged" else "ok"
        return SimpleNamespace(velocity=velocity, yaw_rate=0.0, status=status)

    monkeypatch.setattr(PlaneMotor, "state", state)
    driven = Contact.prescribed(build(scene({}, {"direction": 90, "frequency": "2.3 MHz"}, wavelength="1 mm")))
    here = PlaneMotor.of(driven, 10e-9, 1e-3).state().velocity
    own = Point(velocity_m_per_s=here[0], lateral_velocity_m_per_s=here[1], relative_error=0.0)
    found = ripple_of(driven, 10e-9, 1e-2, PointAnswer(point=own))
    assert len(full) == (3 if spread < 1e-3 else 23)
    truth = np.array([1.0, 0.5]) * 1.003  # sines and cosines have no mean over the lattices
    mean = np.array([found.mean_velocity_m_per_s, found.mean_lateral_velocity_m_per_s])
    assert np.linalg.norm(mean - truth) <= found.mean_velocity_relative_error * np.linalg.norm(truth) + 1e-12
    assert found.mean_velocity_relative_error < 1e-3
