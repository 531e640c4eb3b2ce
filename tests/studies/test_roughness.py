"""Rough balls in a scene: refusals, samples against the contact's own solver, budget lines, and files of patches."""

import numpy as np
import pytest

import contact
from studies import Scene, SceneError, run, sweep
from studies.evidence import rough_balls
from studies.model.resolve import build
from studies.model.roughness_of_balls import STRIDE
from studies.model.wave_to_contact import Contact
from studies.motor import load_line
from studies.remarks.ball_surface import ratio
from studies.report.energies import balances

AMPLITUDES = ["3 nm", "8 nm"]


def scene(**roughness):
    slider = {"roughness": roughness, "damping": {"normal": 0.5, "tangential": 0.0}}
    return Scene.load("twente-contact").replace(wave={"normal_amplitude": AMPLITUDES}, slider=slider)


def effects(record):
    return {each["effect"]: each for each in record.model_error}


@pytest.fixture(scope="module")
def sampled():
    return run(scene(rms="3 nm", seed=5), tolerance=1e-3)


def test_a_sample_is_that_of_the_contact(sampled):
    """The same ball by `RoughBalls`, with a reach of its own."""
    ball = rough_balls.ball("hysteretic")
    balls = [contact.RoughBalls(ball, [contact.Roughness(rms=3e-9).drawn(5 + STRIDE * k, 9e-6)]) for k in range(8)]
    for point, amplitude in zip(sampled.points, (3e-9, 8e-9), strict=True):
        orbit = contact.Orbit(
            frequency=2.2e6, normal=amplitude, tangential=-1j * sampled.scene.wave.tangential_ratio * amplitude
        )
        speeds = [each.velocity(orbit, tolerance=1e-3).value for each in balls]
        assert point.velocity_m_per_s == pytest.approx(speeds[0], rel=2e-3)
        assert point.sample_lowest_m_per_s == pytest.approx(min(speeds), rel=5e-3)
        assert point.sample_median_m_per_s == pytest.approx(np.median(speeds), rel=5e-3)
        assert point.sample_highest_m_per_s == pytest.approx(max(speeds), rel=5e-3)
        assert point.relative_error < 1e-3


def test_the_budget_of_a_sample_has_the_scatter_instead_of_an_assumed_roughness(sampled):
    found = effects(sampled)
    point = sampled.points[-1]
    half = 0.5 * (point.sample_highest_m_per_s - point.sample_lowest_m_per_s) / abs(point.velocity_m_per_s)
    assert found["another ball of the same roughness"]["size"] == pytest.approx(half, rel=1e-9)
    assert not {
        "roughness of the balls",
        "memory of the tangential contact",
        "roughness of the balls: where they start",
    } & set(found)
    assert "a roughness of 3 nm removes" in found["adhesion of clean smooth balls"]["source"]


@pytest.mark.parametrize("roughness", [{"seed": 5}, {}])
@pytest.mark.parametrize("law", ["hysteretic", "elastic"])
def test_the_energies_of_a_run_balance(roughness, law):
    """Twice the mass, preload and load on two balls is twice the power of one, of a mean field."""
    load = {"load": "5 uN", "law": law}
    record = run(scene(rms="3 nm", **roughness).replace(slider=load), tolerance=1e-3)
    moving = [point for point in record.points if point.velocity_m_per_s]
    assert moving
    assert all(point.ledger_relative_residual < 1e-10 for point in moving)
    found = [dict(each.entries) for each in balances(record)]
    for powers, point, balance in zip(found, moving, balances(record), strict=True):
        assert balance.residual < 1e-10
        # the load drives the stop of a mean field back
        assert powers["work against the load"] == pytest.approx(5e-6 * point.velocity_m_per_s, rel=1e-2)
        spent = powers["lost in slip"] + powers["work against the load"] + powers["not conserved by the elastic law"]
        assert spent == pytest.approx(powers["wave, friction force"], rel=1e-9)
    if not roughness:
        double = {"contacts": 2, "preload": 2 * 0.87309e-3, "load": 1e-5, "law": law}
        twice = run(scene(rms="3 nm").replace(slider=double), tolerance=1e-3)
        (one, *_), (two, *_) = found, [dict(each.entries) for each in balances(twice)]
        assert two["lost in slip"] == pytest.approx(2.0 * one["lost in slip"], rel=1e-3)


def test_an_answer_does_not_depend_on_the_other_levels(sampled):
    alone = run(scene(rms="3 nm", seed=5).replace(wave={"normal_amplitude": "3 nm"}), tolerance=1e-3)
    assert alone.points[0].velocity_m_per_s == pytest.approx(sampled.points[0].velocity_m_per_s, rel=1e-3)


def test_three_balls_run_between_the_velocities_of_each():
    """Samples of the seeds 5, 6 and 7, each with a third of the preload."""
    wave = {"normal_amplitude": "3 nm"}
    three = scene(rms="3 nm", seed=5).replace(wave=wave, slider={"contacts": 3, "preload": 3 * 0.87309e-3})
    alone = [
        run(scene(rms="3 nm", seed=seed).replace(wave=wave), tolerance=1e-2).points[0].velocity_m_per_s
        for seed in (5, 6, 7)
    ]
    found = run(three, tolerance=1e-2).points[0].velocity_m_per_s
    assert min(alone) < found < max(alone)
    assert found == pytest.approx(np.mean(alone), rel=0.02)


def patch_file(folder):
    """The egg box: peaks of one height and radius."""
    n, step, amplitude = 64, 25e-9, 2e-9
    k = 2 * np.pi * 2 / (n * step)
    x = np.arange(n) * step
    np.save(folder / "patch.npy", amplitude * np.cos(k * x)[:, None] * np.cos(k * x))
    return folder / "patch.npy", n * step / 2, 1 / (amplitude * k**2)


def test_a_patch_gives_the_asperities(tmp_path):
    file, period, radius = patch_file(tmp_path)
    record = run(scene(file=str(file), step="25 nm"), tolerance=1e-2)
    # by hand: a centred square lattice about the middle of the patch, all of one height
    i, j = (each.ravel() for each in np.meshgrid(np.arange(-40, 41), np.arange(-40, 41)))
    whole = (i + j) % 2 == 0
    x, y = i[whole] * period / 2, j[whole] * period / 2
    near = np.hypot(x, y) < 8e-6
    sample = contact.Asperities(x=x[near], y=y[near], heights=np.full(near.sum(), 2e-9), radius=radius)
    orbit = contact.Orbit(frequency=2.2e6, normal=8e-9, tangential=-1j * record.scene.wave.tangential_ratio * 8e-9)
    expected = contact.asperity_motion(rough_balls.ball("hysteretic"), sample, orbit, tolerance=1e-3).value
    assert record.points[1].velocity_m_per_s == pytest.approx(expected, rel=0.01)
    assert record.points[1].sample_highest_m_per_s > record.points[1].sample_lowest_m_per_s


def test_missing_pixels_are_counted_aloud(tmp_path):
    file, *_ = patch_file(tmp_path)
    heights = np.load(file)
    heights[3, 4:9] = np.nan
    np.save(file, heights)
    record = run(scene(file=str(file), step="25 nm").replace(wave={"normal_amplitude": "8 nm"}), tolerance=1e-2)
    assert any("5 of 4096 pixels have no value" in each for each in record.warnings)
    assert any("patch.npy has an rms of 1" in each for each in record.warnings)


@pytest.mark.parametrize(
    ("roughness", "slider", "sentence"),
    [
        ({}, {}, r'slider\.roughness\.rms is required and missing: give a length such as "3 nm"'),
        ({"rms": "3 nm", "file": "a.npy"}, {}, r"slider\.roughness\.rms must be absent with slider\.roughness\.file"),
        ({"rms": "3 nm", "step": "1 nm"}, {}, r"slider\.roughness\.step belongs to slider\.roughness\.file"),
        ({"file": "none.npy", "step": "1 nm"}, {}, r"slider\.roughness\.file cannot be read: No such file"),
        ({"rms": "3 nm", "seed": 1}, {"law": {"name": "a.py", "source": "b"}}, r"slider\.law does not go with"),
        ({"rms": "3 nm", "seed": 1}, {"stick_band": "1 mm/s"}, "stick_band does not go with slider.roughness"),
        ({"rms": "3 nm", "seed": 1}, {"method": "exact"}, "method does not go with slider.roughness"),
        (
            {"rms": "3 nm"},
            {"contacts": [["-1 mm", "0 mm"], ["1 mm", "0 mm"]], "heights": ["0 nm", "1 nm"]},
            "heights does not go with slider.roughness: each rough ball carries an equal part of the preload",
        ),
        ({"rms": "3 nm"}, {"shape": "punch"}, r"slider\.roughness is that of balls, which this slider has not"),
        ({"rms": -1.0}, {}, r"slider\.roughness\.rms must be positive"),
    ],
)  # fmt: skip
def test_refusals(roughness, slider, sentence):
    with pytest.raises(SceneError, match=sentence):
        run(scene(**roughness).replace(slider=slider))


def test_stops_of_single_asperities_answer_steady_velocities_alone():
    rule = r'slider\.law must be "hysteretic" or absent here: of samples with a stop for each asperity'
    stops = scene(rms="3 nm", seed=5).replace(slider={"law": "elastic"})
    with pytest.raises(SceneError, match=rule):
        _ = Contact.prescribed(build(stops)).slider
    with pytest.raises(SceneError, match=rule.replace("here", "with a burst")):
        run(stops.replace(wave={"burst": "1 ms"}))


@pytest.mark.parametrize("roughness", [{}, {"seed": 5}])
def test_balls_with_memory_are_a_normal_law_of_every_method(roughness):
    """The event-driven chain of slipped annuli on the tabulated force against the walls of depths."""
    rough = scene(rms="3 nm", **roughness)
    driven = Contact.prescribed(build(rough))
    assert driven.slider.law == "hysteretic"
    for point, amplitude in zip(run(rough, tolerance=1e-4).points, (3e-9, 8e-9), strict=True):
        full = contact.steady(driven.slider, driven.at(amplitude), tolerance=1e-4)
        assert float(full.velocity) == pytest.approx(point.velocity_m_per_s, rel=3e-4)
        assert full.ledger.relative_residual < 1e-8


@pytest.mark.parametrize("roughness", [{}, {"seed": 5}])
def test_balls_with_memory_take_bursts_and_loads(roughness):
    rough = scene(rms="3 nm", **roughness).replace(wave={"normal_amplitude": "8 nm"})
    steady = run(rough, tolerance=1e-3).points[0]
    burst = run(rough.replace(wave={"burst": "4 ms"}), tolerance=1e-2).points[0]
    assert burst.velocity_m_per_s == pytest.approx(steady.velocity_m_per_s, rel=5e-4)
    assert 0.0 < abs(burst.velocity_at_burst_end_m_per_s) < abs(steady.velocity_m_per_s)
    line = load_line.run(rough, points=3).panels[0].data
    assert line["value"]["8 nm"][0] == pytest.approx(abs(steady.velocity_m_per_s), rel=5e-4)
    stall = line["blocked_thrust_N"]["8 nm"]
    assert 0.0 < stall < 0.08 * 0.87309e-3
    # the heavy slider on the walls of depths moves just below that load, and back just above it, for it hops
    for share, way in ((0.99, 1.0), (1.01, -1.0)):
        loaded = rough.replace(slider={"load": share * stall})
        found, driven = run(loaded, tolerance=1e-3).points[0].velocity_m_per_s, Contact.prescribed(build(loaded))
        assert way * found > 0.0
        assert found == pytest.approx(
            float(contact.steady(driven.slider, driven.at(8e-9), tolerance=1e-4).velocity), rel=2e-3
        )


def test_a_mean_field_is_near_the_middle_of_samples(sampled):
    """Ranges of an independent program at 3 nm: 0.79 to 1.02 of the smooth ball, threshold 1.05 to 1.43."""
    record = run(scene(rms="3 nm"), tolerance=1e-3)
    for point, other in zip(record.points, sampled.points, strict=True):
        assert 0.9 < point.velocity_m_per_s / other.sample_median_m_per_s < 1.0  # the field is softer than samples
        assert point.sample_median_m_per_s is None
    smooth = contact.mean_motion(rough_balls.ball(), rough_balls.orbit(3e-9)).velocity
    assert 0.79 < abs(record.points[0].velocity_m_per_s) / smooth < 1.02
    found = effects(record)
    assert 0.02 < found["another ball of the same roughness"]["size"] < 0.2
    assert "roughness of the balls" not in found
    assert 0.86e-9 * 1.05 < record.summary.threshold_amplitude_m < 0.87e-9 * 1.43


def test_three_equal_balls_of_a_mean_field_are_one_with_a_third():
    wave = {"normal_amplitude": "5 nm"}
    one, three = (
        run(scene(rms="3 nm").replace(wave=wave, slider={"contacts": n, "preload": n * 0.87309e-3}), tolerance=1e-3)
        for n in (1, 3)
    )
    assert three.points[0].velocity_m_per_s == pytest.approx(one.points[0].velocity_m_per_s, rel=1e-6)


def test_a_sweep_gives_the_points_of_runs():
    """Sweeps take averaged states where they can: not of rough balls, whose velocity would be that of smooth ones."""
    motor = scene(rms="3 nm").replace(wave={"normal_amplitude": "5 nm"})
    found = sweep(motor, {"slider.preload": [0.8e-3, 1e-3]}, tolerance=1e-3).columns()["velocity_m_per_s"]
    for velocity, preload in zip(found, (0.8e-3, 1e-3), strict=True):
        alone = run(motor.replace(slider={"preload": preload}), tolerance=1e-3).points[0].velocity_m_per_s
        assert velocity == pytest.approx(alone, rel=1e-6)


def test_a_run_states_the_release_of_its_own_ball(sampled):
    """Also where its levels end below: the ball's asperities then reach as far as the release needs."""
    ball = contact.RoughBalls(rough_balls.ball(), [contact.Roughness(rms=3e-9).drawn(5, 9e-6)])
    orbit = contact.Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j)
    assert sampled.summary.release_amplitude_m == pytest.approx(1e-9 * ball.release(orbit), rel=3e-3)
    low = run(scene(rms="3 nm", seed=5).replace(wave={"normal_amplitude": "0.5 nm"}), tolerance=1e-2)
    assert low.summary.release_amplitude_m == pytest.approx(sampled.summary.release_amplitude_m, rel=3e-3)
    assert low.summary.threshold_amplitude_m == pytest.approx(sampled.summary.threshold_amplitude_m, rel=3e-3)


def test_a_mean_field_that_slips_as_a_whole_is_a_normal_law_of_every_method():
    """The kernels' averaged motion, and the full motion, on the tabulated force against the field's own cycle means."""
    rough = scene(rms="3 nm").replace(slider={"law": "elastic"})
    driven = Contact.prescribed(build(rough))
    known = [point.velocity_m_per_s for point in run(rough, tolerance=1e-4).points]
    for velocity, amplitude in zip(known, (3e-9, 8e-9), strict=True):
        averaged = float(contact.mean_motion(driven.slider, driven.at(amplitude)).velocity)
        full = float(contact.steady(driven.slider, driven.at(amplitude), tolerance=1e-4, method="exact").velocity)
        assert averaged == pytest.approx(velocity, rel=2e-4)
        assert full == pytest.approx(velocity, rel=5e-4)
    # the tabulated force carries the preload at the field's own approach
    field = contact.MeanField(1e-3, 64e9, contact.Roughness(rms=3e-9))
    rest = driven.slider.rest_approach(1) + field.lowest(1e-3)
    assert rest == pytest.approx(4.2130e-9, rel=2e-4)


def test_a_mean_field_that_slips_as_a_whole_takes_bursts_and_loads():
    rough = scene(rms="3 nm").replace(slider={"law": "elastic"}, wave={"normal_amplitude": "8 nm"})
    steady = run(rough, tolerance=1e-3).points[0]
    burst = run(rough.replace(wave={"burst": "20 ms"}), tolerance=1e-2).points[0]
    assert abs(burst.velocity_at_burst_end_m_per_s) < abs(steady.velocity_m_per_s)
    assert 0.0 < abs(burst.displacement_m) < 20e-3 * abs(steady.velocity_m_per_s)
    line = load_line.run(rough, points=3).panels[0].data
    assert line["value"]["8 nm"][0] == pytest.approx(abs(steady.velocity_m_per_s), rel=2e-3)
    assert 0.0 < line["blocked_thrust_N"]["8 nm"] < 0.08 * 0.87309e-3


def test_few_asperities_are_refused():
    """An independent program counts 3 with 20 nm and 10 um."""
    rule = "slider.roughness.rms of 20 nm: 3 asperities carry a ball: the mean field does not apply; give a seed, the"
    with pytest.raises(SceneError, match=rule):
        run(scene(rms="20 nm"))


@pytest.mark.parametrize(
    ("roughness", "slider", "sentence"),
    [
        ({"rms": "3 nm"}, {"preload": 0.0}, r"slider\.preload must be positive with slider\.roughness"),
        ({"rms": "3 nm"}, {"friction_coefficient": 0.0}, r"slider\.friction_coefficient must be positive with"),
        ({"rms": "3 nm", "density": 1.0}, {}, r"slider\.roughness\.density of 1 1/m\^2: one asperity or none carries"),
        ({"rms": "3 nm", "asperity_radius": "1 m"}, {}, r"asperity_radius must be at most the ball's radius of"),
        ({"rms": "2 mm"}, {}, r"slider\.roughness\.rms must have heights with an rms of at most the ball's radius"),
        ({"rms": "3 nm", "seed": 1}, {"radius": "1 km"}, r"seed must draw at most 20000 asperities .* about 2\.5e\+08"),
        ({"rms": "3 nm", "seed": 1}, {"radius": "1 um"}, r"slider\.roughness must bring at least one asperity"),
    ],
)  # fmt: skip
def test_roughness_beyond_sense_is_refused(roughness, slider, sentence):
    with pytest.raises(SceneError, match=sentence):
        run(scene(**roughness).replace(slider=slider))


def test_a_patch_in_other_units_is_refused(tmp_path):
    file, *_ = patch_file(tmp_path)
    np.save(file, 1e9 * np.load(file))
    with pytest.raises(SceneError, match=r"file must have heights with an rms of at most .* got 1 m in patch\.npy"):
        run(scene(file=str(file), step="25 nm"))


def test_a_vanishing_roughness_is_the_smooth_ball_with_memory():
    """0.01 nm was not solved once; the velocity is that of the hysteretic law on the smooth ball."""
    smooth = run(scene(rms="3 nm").replace(slider={"roughness": None, "law": "hysteretic"}), tolerance=1e-3)
    rough = run(scene(rms="0.01 nm"), tolerance=1e-3)
    for point, other in zip(rough.points, smooth.points, strict=True):
        assert point.velocity_m_per_s == pytest.approx(other.velocity_m_per_s, rel=5e-3)


def test_asperities_that_overlap_are_refused():
    rule = r"slider\.roughness\.density must be at most 1/\(asperity_radius rms\) = 3\.333e\+13 1/m\^2"
    with pytest.raises(SceneError, match=rule):
        run(scene(rms="3 nm", density=1e30))


def test_the_budget_of_a_mean_field_has_what_single_asperities_would_change():
    found = effects(run(scene(rms="3 nm").replace(wave={"normal_amplitude": "3 nm"}), tolerance=1e-3))
    median, _, _, field = ratio(3e-9 / 4.71296e-9, 3 / 4.71296)
    assert found["single asperities instead of their mean field"]["size"] == pytest.approx(median / field - 1, rel=1e-4)
    assert 0.03 < median / field - 1 < 0.12


def test_the_elastic_law_of_rough_balls_states_what_memory_would_change():
    """A stop for each asperity of a sample; the memory by the run with the law that a scene has without the key."""
    rough = scene(rms="3 nm", seed=5).replace(wave={"normal_amplitude": "3 nm"})
    record = run(rough.replace(slider={"law": "elastic"}), tolerance=1e-3)
    expected = contact.asperity_motion(
        rough_balls.ball(), contact.Roughness(rms=3e-9).drawn(5, 9e-6),
        contact.Orbit(frequency=2.2e6, normal=3e-9, tangential=-2.1e-9j),
    ).value  # fmt: skip
    assert record.points[0].velocity_m_per_s == pytest.approx(expected, rel=3e-3)
    memory = run(rough, tolerance=1e-3).points[0].velocity_m_per_s / record.points[0].velocity_m_per_s - 1
    assert memory > 0.02
    assert effects(record)["memory of the tangential contact"]["size"] == pytest.approx(memory, abs=3e-3)


def test_the_printed_threshold_is_that_of_a_speed():
    record = run(scene(rms="3 nm").replace(wave={"normal_amplitude": "3 nm"}), tolerance=1e-3)
    assert "asperities that draw each other along" not in effects(record)
    assert "nm: the slider runs at 0.2 mm/s" in str(record)
    assert "starts to move" not in str(record)
