"""Measured data in the instruments' formats: round trips, comparisons where the data lie, fits of a known truth."""

import math
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

import contact
import fem
from studies.__main__ import main
from studies.export.averaged_motor import averaged_motor
from studies.export.instruments import Recording, csv_files, touchstone_files, virtual_scan
from studies.inverse import fit, read_measurement, read_parameter
from studies.inverse.prediction import MeasurementPredictor
from studies.lab.encoder import aligned, averaged, low_pass, travelled_distance
from studies.lab.measurement import Measurement
from studies.lab.measurement_csv import measured_scan, read_measured
from studies.lab.network_file import read_network
from studies.lab.s_parameters import NetworkData
from studies.lab.scan import Scan, scan_csv
from studies.model import fem_objects, resolve
from studies.model.model import Model
from studies.record import Record
from studies.record.run_pictures import draw_scan, pictures
from studies.record.scan_comparison import compared_scan
from studies.refusal import SceneError
from studies.runs import run
from studies.scene import Scene
from studies.solve.measured_run import measured_block
from studies.solve.scan_prediction import at_other_velocity, drawn_line, placed
from studies.solve.scattering import scattering_matrix
from studies.stator.network_deviation import deviations
from studies.study_list import driven_contact
from tests.studies.settings import without
from tests.studies.solved_once import solved_once

SMALL = Scene.load("twente-left").replace(
    stator={"length": "60 mm"}, slider={"position": "40 mm"}, drive={"voltage": "30 V"}
)


@cache
def clean():
    """What a vibrometer would see of a short stator, without noise."""
    return virtual_scan(SMALL, Recording(), 1e-2)[0]


def noisy(seed, share=0.01):
    random = np.random.default_rng(seed)
    size = share * float(np.max(np.abs(clean().values)))
    scatter = random.standard_normal((2, len(clean().x)))
    values = clean().values + size * (scatter[0] + 1j * scatter[1])
    return replace(clean(), values=values, deviation=np.full(len(values), size))


def some_scan(kind="xy"):
    random = np.random.default_rng(3)
    x, y = np.repeat([0.031, 0.0402, 0.055], 2), np.tile([-0.002, 0.003], 3)
    values = 1e-9 * (random.standard_normal(6) + 1j * random.standard_normal(6))
    if kind == "xy":
        return Scan(name="lab", x=x, y=y, values=values)
    frequency = np.array([2.1e6, 2.15e6, 2.2e6, 2.22e6, 2.3e6, 2.31e6])
    return Scan(name="lab", x=np.full(6, 0.04), y=np.zeros(6), frequency=frequency, values=values)


@pytest.mark.parametrize("kind", ["xy", "frequency"])
def test_csv_round_trip_is_exact(kind, tmp_path):
    scan = replace(some_scan(kind), deviation=np.full(6, 1.7e-11))
    path = tmp_path / "lab.csv"
    path.write_text(scan_csv(scan, ("remark",)))
    found = read_measured(path).scan
    for name in ("x", "y", "values", "deviation", "frequency"):
        np.testing.assert_array_equal(getattr(found, name), getattr(scan, name))
    assert (found.component, found.per_volt, found.kind) == ("u_z", True, {"xy": "x, y"}.get(kind, kind))


@cache
def network():
    made = touchstone_files(SMALL, "small", Recording(band="2.1:2.3:9"), tolerance=1e-2)
    return made.files["small.s1p"]


def test_touchstone_round_trip_is_exact_and_scikit_rf_reads_the_same(tmp_path):
    skrf = pytest.importorskip("skrf")
    path = tmp_path / "small.s1p"
    path.write_text(network())
    ours, theirs = read_network(path, "--measured"), skrf.Network(str(path))
    np.testing.assert_allclose(ours.frequency, theirs.f, rtol=1e-12)
    np.testing.assert_allclose(ours.scattering, theirs.s, rtol=1e-12)
    again = fem.touchstone(ours.frequency, ours.scattering, ours.reference, ())
    path.write_text(again)
    twice = read_network(path, "--measured")
    np.testing.assert_array_equal(twice.scattering, ours.scattering)
    np.testing.assert_array_equal(twice.frequency, ours.frequency)


def test_a_velocity_scan_is_the_same_displacement():
    scan, omega = some_scan(), 2 * np.pi * 2.2e6
    rates = replace(scan, values=1j * omega * scan.values * 30.0, motion="velocity", per_volt=False, voltage=30.0)
    # magnitudes too; and the deviation is that of the same quantity
    for one, same in ((rates, scan.values), (replace(rates, values=abs(rates.values)), abs(scan.values))):
        one = replace(one, deviation=0.02 * abs(one.values))
        moved = one.per_volt_of_source().as_displacement(2.2e6)
        np.testing.assert_allclose(moved.values, same, rtol=1e-12)
        np.testing.assert_allclose(moved.deviation, 0.02 * abs(scan.values), rtol=1e-12)
        assert (moved.per_volt, moved.motion) == (True, "displacement")
    unknown = replace(rates, voltage=None)
    with pytest.raises(SceneError, match="at an unknown voltage: add a column voltage_V"):
        unknown.per_volt_of_source()


def test_a_comparison_states_size_phase_velocity_ripple_and_place_of_the_beam():
    # a wave with 12 % coming back, seen 1.3 times larger, turned, and 0.5 % faster
    wavelength, source = 1e-3, 0.015
    x = np.arange(0.03, 0.06, wavelength / 12)
    k = 2 * np.pi / wavelength

    def field(speed):
        return np.exp(-1j * k / speed * (x - source)) + 0.12 * np.exp(1j * k / speed * (x - 0.06))

    scan = Scan(name="lab", x=x, y=0 * x, values=1.3 * np.exp(0.4j) * field(1.0))
    block = compared_scan(scan, field(1.0), wavelength=wavelength, source=source)
    assert block["measured_over_predicted"] == pytest.approx(1.3, rel=1e-12)
    assert block["phase_of_measured_rad"] == pytest.approx(0.4, abs=1e-12)
    assert block["rms_deviation_of_shape"] < 1e-12
    assert block["measured_standing_wave_ratio"] == pytest.approx(1.12 / 0.88, rel=0.03)
    faster = replace(scan, values=np.exp(-1j * k / 1.005 * (x - source)))
    block = compared_scan(faster, np.exp(-1j * k * (x - source)), wavelength=wavelength, source=source)
    assert block["measured_wave_velocity_over_predicted"] == pytest.approx(1.005, abs=1e-9)
    y = np.linspace(-0.01, 0.01, 41)
    beam = np.exp(-(((y - 0.001) / 0.004) ** 2))
    across = Scan(name="lab", x=0 * y + 0.04, y=y, values=beam)
    block = compared_scan(across, np.exp(-((y / 0.004) ** 2)) + 0j, wavelength=wavelength, source=source)
    assert block["beam_center_measured_m"] == pytest.approx(0.001, abs=2e-5)
    assert abs(block["beam_center_predicted_m"]) < 1e-9


def test_an_exported_scan_states_its_numerical_error():
    """Against a solution a hundred times as accurate: at most twice the stated error, relative to the rms motion."""
    _, remarks = virtual_scan(SMALL, Recording(), 1e-2)
    (stated,) = [float(each.split()[3]) / 100 for each in remarks if each.startswith("estimated numerical error")]
    exact, fine = virtual_scan(SMALL, Recording(), 1e-4)
    found = np.sqrt(np.mean(abs(clean().values - exact.values) ** 2) / np.mean(abs(exact.values) ** 2))
    assert found <= 2.0 * stated <= 2e-2
    assert found > 1e-5  # there is one to be stated
    assert any("for a tolerance of 0.01 %" in each for each in fine)


def test_another_wave_velocity_turns_the_phase_along_the_way():
    chosen = resolve.resolved(SMALL)
    scan = Scan(name="", x=np.array([0.03, 0.05]), y=np.zeros(2), values=np.ones(2, complex))
    turned = at_other_velocity(Model(chosen), scan, np.ones(2, complex), 1.001)
    velocity = fem.rayleigh(fem_objects.solid(chosen.stator), "open").velocity
    expected = 2 * np.pi * 2.2e6 / velocity * (1 - 1 / 1.001) * 0.02
    assert np.angle(turned[1] / turned[0]) == pytest.approx(expected, rel=1e-9)


def both_fitted(seed):
    found = fit(
        SMALL, [measured_scan(noisy(seed))],
        [read_parameter("amplitude_factor=0.5:2"), read_parameter("wave_velocity_factor=0.99:1.01")],
        tolerance=1e-2,
    )  # fmt: skip
    return found, [low <= 1.0 <= high for low, high in found.intervals.values()]


@pytest.mark.parametrize("kind", ["xy", "frequency"])
@pytest.mark.parametrize("is_complex", [True, False])
def test_a_scan_read_back_is_drawn_as_it_was(kind, is_complex, tmp_path):
    scan = some_scan(kind)
    block = compared_scan(
        scan if is_complex else replace(scan, values=np.abs(scan.values)), 1.2 * scan.values,
        wavelength=1.8e-3, source=8e-3,
    )  # fmt: skip
    record = Record(scene=Scene.load("twente-contact"), tolerance=1e-2, measured=block)
    record.save(tmp_path / "run")
    found = Record.load(tmp_path / "run")
    for name, values in block["scan"].items():
        np.testing.assert_array_equal(found.measured["scan"][name], values)
    drawn = [pictures(each)["measured"](Figure().add_subplot()).get_lines() for each in (record, found)]
    for before, after in zip(*drawn, strict=True):
        np.testing.assert_array_equal(before.get_xydata(), after.get_xydata())


def test_a_virtual_scan_gives_back_the_truth():
    found, inside = both_fitted(5)
    assert all(inside)
    sizes = [high - low for low, high in found.intervals.values()]
    # 1.96 standard deviations either side: of the mean of 2 N numbers, and of a slope over the scan's length
    scan = noisy(5)
    size, weights = scan.deviation[0], np.abs(scan.values) ** 2
    assert sizes[0] == pytest.approx(2 * 1.96 * size / np.sqrt(np.sum(weights)), rel=0.05)
    spread = np.sqrt(np.sum(weights * (scan.x - np.average(scan.x, weights=weights)) ** 2))
    assert sizes[1] == pytest.approx(2 * 1.96 * size / (spread * 2 * np.pi * 2.2e6 / 2181.9), rel=0.05)
    assert found.candidates == ()  # the scan knows both numbers so well that no other measurement narrows them


@pytest.mark.slow
def test_the_truth_lies_in_its_interval_in_18_of_20_draws():
    inside = np.array([both_fitted(seed)[1] for seed in range(20)])
    assert inside.sum(axis=0).min() >= 18


def test_a_scaled_and_slower_truth_is_found():
    scan = noisy(9)
    chosen = resolve.resolved(SMALL)
    values = 1.2 * np.exp(1j) * at_other_velocity(Model(chosen), placed(chosen, scan), scan.values, 0.9990)
    found = fit(
        SMALL, [measured_scan(replace(scan, values=values))],
        [read_parameter("amplitude_factor=0.5:2"), read_parameter("wave_velocity_factor=0.99:1.01")],
        tolerance=1e-2,
    )  # fmt: skip
    low, high = found.intervals["wave_velocity_factor"]
    assert low < 0.9990 < high
    assert high - low < 1e-4
    low, high = found.intervals["amplitude_factor"]
    assert low < 1.2 < high
    assert high - low < 5e-3


@pytest.mark.slow
def test_a_mixture_says_which_file_informs_which_number(tmp_path):
    curve = tmp_path / "curve.csv"
    # the velocities of a friction coefficient of 0.08 at half of the computed amplitude
    rows = ["voltage_V,velocity_m_per_s,error_m_per_s"]
    truth = fit_predictor().predict([(read_curve(tmp_path, (20.0, 30.0, 50.0)), {"amplitude_factor": 0.5})])[0]
    rows += [f"{volts},{value},2e-4" for volts, value in zip((20, 30, 50), truth, strict=True)]
    curve.write_text("\n".join(rows))
    scan = replace(noisy(2), values=0.5 * noisy(2).values)
    found = fit(
        SMALL, [measured_scan(scan), read_measurement(curve)],
        [read_parameter(each) for each in ("amplitude_factor=0.2:2", "slider.damping.tangential=1e-5:1e-3")],
        tolerance=1e-2,
    )  # fmt: skip
    (_, by_scan), (_, by_curve) = found.informs
    assert by_scan["amplitude_factor"] > 20.0
    assert by_scan["slider.damping.tangential"] == pytest.approx(1.0)
    assert by_curve["slider.damping.tangential"] > 2.0
    low, high = found.intervals["slider.damping.tangential"]
    assert low < 1e-4 < high


def fit_predictor():
    return MeasurementPredictor(SMALL, tolerance=1e-2)


def read_curve(folder, volts):
    path = folder / "levels.csv"
    path.write_text("voltage_V,velocity_m_per_s\n" + "".join(f"{each},0\n" for each in volts))
    return read_measurement(path)


def test_network_deviations_are_those_put_in():
    at = np.linspace(2.0e6, 2.4e6, 81)
    omega = 2 * np.pi * at

    def data(shift, size):
        branch = 120.0 / size + 1j * omega * 9e-5 / size + 1 / (1j * omega * 5.9e-11 * size * shift)
        y = 1j * omega * 1e-9 * size + 1 / branch
        return NetworkData(
            name="lab.s1p", frequency=at, scattering=((1 - 50 * y) / (1 + 50 * y))[:, None, None], reference=50.0
        )

    rows = deviations(data(0.98, 1.1), data(1.0, 1.0).scattering, ["left"])
    said = " ".join(text for _, text in rows)
    numbers = {
        text.split()[0]: float(text.split("predicted, ")[1].rstrip(" %"))
        for _, text in rows[1:]
        if "predicted, " in text
    }
    assert numbers["C0"] == pytest.approx(10.0, abs=0.05)
    assert numbers["G"] == pytest.approx(10.0, abs=1.0)
    assert numbers["resonance"] == pytest.approx(100 * (1 / math.sqrt(0.98) - 1), abs=0.2)
    assert "K2 over the predicted 0.98" in said


def test_a_network_analysers_file_is_predicted_as_its_study_computes_it():
    at, scene = np.array([2.19e6, 2.2e6]), resolve.resolved(SMALL)
    count = sum(each.has_two_electrodes for each in scene.transducer)
    file = NetworkData(name="lab.snp", frequency=at, scattering=np.zeros((2, count, count)), reference=50.0)
    measurement = Measurement(name="lab.snp", quantity="network", values=tuple(file.flat()), network=file)
    (predicted,) = fit_predictor().predict([(measurement, {})])
    expected = scattering_matrix(Model(scene), at, 50.0, 1e-2)[2]
    np.testing.assert_array_equal(predicted, [*expected.real.ravel(), *expected.imag.ravel()])
    assert np.ptp(predicted) > 0.1


def test_a_fit_takes_one_port_of_a_network_analyser_s_file(tmp_path):
    file = tmp_path / "lab.s2p"
    file.write_text("# MHz S RI R 50\n2.2 .1 .2 .01 0 .01 0 .3 .4\n")
    measured = read_measurement(file, ("port=2", "systematic=0.02"))
    assert measured.values == (0.3, 0.4)
    assert (measured.systematic, measured.settings) == (0.02, {})
    for path, port, said in ((file, "3", "one of the 2 ports"), (file, "x", "port=x must be the number of a port")):
        with pytest.raises(SceneError, match=said):
            read_measurement(path, (f"port={port}",))


def test_the_remarks_on_a_file_are_in_the_answer_of_its_fit(tmp_path):
    # 1.2 times the prediction, as spectra at two places with lines beside the drive
    chosen = replace(clean(), x=clean().x[::40], y=clean().y[::40], values=1.2 * clean().values[::40])
    rows = ["x_m,frequency_kHz,u_z_real_m_per_V,u_z_imag_m_per_V"]
    for x, value in zip(chosen.x.tolist(), chosen.values.tolist(), strict=True):
        rows += [f"{x!r},{f},{value.real * part!r},{value.imag * part!r}" for f, part in ((2190, 0.5), (2200, 1.0))]
    file = tmp_path / "lab.csv"
    file.write_text("\n".join(rows))
    found = fit(SMALL, [read_measurement(file)], {"amplitude_factor": (0.5, 2.0)}, tolerance=1e-2)
    assert found.values["amplitude_factor"] == pytest.approx(1.2, rel=1e-6)
    assert "lab.csv: of 2 spectral lines that at 2200000 Hz is taken" in str(found)


def test_an_encoder_is_a_low_pass_filter_and_a_trace_is_moved_to_where_it_fits():
    time = np.linspace(0.0, 1.0, 2001)
    ramp = low_pass(time, time, 5.0)
    late = 1 / (2 * np.pi * 5.0)
    np.testing.assert_allclose(ramp, time - late * (1 - np.exp(-time / late)), atol=1e-12)
    assert travelled_distance(time, 2 * time)[-1] == pytest.approx(1.0, abs=1e-9)
    curve = np.tanh(5 * time)
    assert aligned(time, np.interp(time - 0.07, time, curve), time, curve) == pytest.approx(0.07, abs=1e-6)


def test_a_run_is_laid_beside_a_trace_of_its_burst(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    levels = ["--set", 'wave.normal_amplitude="10 nm"', "--set", 'wave.burst="40 ms"']
    assert main(["export", "twente-contact", *levels, "--format", "csv", "--no-plot", "--out", "made"]) == 0
    names = {each.name for each in Path("made").iterdir()}
    assert {"burst.csv", "mean_force_wave.csv", "mean_load_wave.csv"} <= names
    head = Path("made/mean_load_wave.csv").read_text()
    assert "tau,R" in head
    # by mirror symmetry: g of one wave at V is minus that of the other at -V
    one, other = (
        np.loadtxt(f"made/mean_force_wave{name}.csv", delimiter=",", skiprows=sum(
            line.startswith(("#", "tau")) for line in Path(f"made/mean_force_wave{name}.csv").read_text().splitlines()
        ))
        for name in ("", "_from_the_other_side")
    )  # fmt: skip
    np.testing.assert_allclose(one[:, 3:], -other[:, :2:-1], rtol=1e-8)
    assert np.all(one[100:400, 3] > 0.5)  # braked wave-backwards, it is pushed towards +x
    assert main(["run", "twente-contact", *levels, "--measured", "made/burst.csv", "--out", "ran"]) == 0
    said = capsys.readouterr().out
    assert "burst over time" in said
    assert "measured / predicted 1, begins at" in said
    assert (tmp_path / "ran/measured.png").stat().st_size > 5000


def trace_of_a_burst(folder, seed, sampling):
    """A burst of 30 ms as an encoder says it: filtered by scipy, averaged, late, with noise of 0.2 mm/s."""
    from scipy.signal import lsim

    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": "10 nm", "burst": "30 ms"})
    driven = driven_contact(scene)
    path = contact.burst(driven.slider, driven.at(10e-9), duration=30e-3, after=10e-3, tolerance=1e-5, samples=4000)
    fine = np.arange(0.0, 39e-3, 2e-6)
    delay = [1.0 / (2 * np.pi * 60.0), 1.0]  # of a bandwidth of 60 Hz
    seen = lsim(([1.0], delay), np.interp(fine, path.time, path.velocity), fine)[1]
    time = np.linspace(-3e-3, 38e-3, 165)  # of which the first lie before the trigger
    parts = time[:, None] - 2e-3 - (sampling or 1e-9) * np.linspace(0.0, 1.0, 51)
    velocity = np.trapezoid(np.interp(parts, fine, seen, left=0.0), axis=1) / 50
    noisy = velocity + 2e-4 * np.random.default_rng(seed).standard_normal(len(time))
    rows = [f"{t * 1e3!r},{v * 1e3!r},0.2" for t, v in zip(time.tolist(), noisy.tolist(), strict=True)]
    file = folder / "trace.csv"
    file.write_text("\n".join(["time_ms,velocity_mm_per_s,error_mm_per_s", *rows]))
    settings = () if sampling is None else (f'sampling="{sampling} s"',)
    return scene, read_measurement(file, settings), velocity


@pytest.mark.parametrize("sampling", [None, 2e-3])
def test_a_trace_is_predicted_as_the_instrument_says_it(sampling, tmp_path):
    scene, trace, velocity = trace_of_a_burst(tmp_path, 4, sampling)
    numbers = {"bandwidth": 60.0, "time_offset": 2e-3} | trace.settings
    (predicted,) = MeasurementPredictor(scene, tolerance=1e-4).predict([(trace, numbers)])
    np.testing.assert_allclose(predicted, velocity, atol=3e-4 * np.abs(velocity).max())


@pytest.mark.slow
@pytest.mark.parametrize("sampling", [None, 2e-3])
def test_a_trace_gives_back_friction_bandwidth_and_its_origin_of_time(sampling, tmp_path):
    scene, trace, _ = trace_of_a_burst(tmp_path, 4, sampling)
    truth = {"slider.friction_coefficient": 0.08, "bandwidth": 60.0, "time_offset": 2e-3}
    free = [read_parameter(f"{key}={0.5 * value}:{2.0 * value}") for key, value in truth.items()]
    found = fit(scene, [trace], free, tolerance=1e-4)
    for key, (low, high) in found.intervals.items():
        assert low < truth[key] < high
        assert high - low < 0.5 * truth[key]


def test_an_exported_trace_is_filtered_and_averaged_as_the_encoder_does(monkeypatch):
    # a velocity that rises and falls in tens of ms, behind 30 Hz and means of 5 ms: scipy's filter of the plain export
    from scipy.signal import lsim

    monkeypatch.setattr("studies.export.averaged_motor.averaged_motor", solved_once(averaged_motor))

    def recorded(**encoder):
        scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": "10 nm", "burst": "30 ms"})
        made = csv_files(scene, "trace", Recording(**encoder), tolerance=1e-3)
        lines = [line for line in made.files["burst.csv"].splitlines() if line[0].isdigit()]
        return np.array([[float(each) for each in line.split(",")] for line in lines])

    plain, seen = recorded(), recorded(bandwidth="30 Hz", sampling='"5 ms"')
    step = 1e-5
    fine = np.arange(0.0, plain[-1, 1], step)
    for column in (2, 3):
        curve = np.interp(fine, plain[:, 1], plain[:, column], left=0.0)
        late = lsim(([1.0], [1.0 / (2 * np.pi * 30.0), 1.0]), curve, fine)[1]
        sums = np.concatenate([[0.0], np.cumsum(0.5 * step * (late[1:] + late[:-1]))])
        means = (np.interp(seen[:, 1], fine, sums) - np.interp(seen[:, 1] - 5e-3, fine, sums)) / 5e-3
        np.testing.assert_allclose(seen[:, column], means, atol=2e-3 * np.abs(curve).max())


def test_touchstone_of_version_2_is_read_with_references_of_its_ports(tmp_path):
    path = tmp_path / "two.s2p"
    path.write_text(
        "[Version] 2.0\n# MHz S RI R 50\n[Number of Ports] 2\n[Two-Port Data Order] 21_12\n[Number of Frequencies] 1\n"
        "[Reference] 50 75\n[Network Data]\n2.2 0.1 0.2 0.3 0.4 0.3 0.4 0.5 -0.1\n[End]\n"
    )
    found = read_network(path, "--measured")
    s, z = np.array([[0.1 + 0.2j, 0.3 + 0.4j], [0.3 + 0.4j, 0.5 - 0.1j]]), np.diag([50.0, 75.0])
    # power waves: Y = z^(-1/2) (1 + S)^(-1) (1 - S) z^(-1/2)
    root = np.diag(np.diag(z) ** -0.5)
    np.testing.assert_allclose(
        found.admittance[0], root @ np.linalg.solve(np.eye(2) + s, np.eye(2) - s) @ root, rtol=1e-9
    )
    assert found.frequency[0] == pytest.approx(2.2e6)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("# MHz S MA R 50\none 2 3\n", "line 2: must hold numbers, got 'one'"),
        ("", "must have an option line"),
        ("# MHz S RI R 50\n", "must hold S-parameters of 1 ports, got none"),
        ("# MHz S RI R 50\n1 2 3 4\n", "line 2: must hold a frequency and 2 numbers of 1 ports, got 1 more"),
        ("# MHz S RI R 50\n1 .2 .3\n2 .2\n", "ends with 2 of 3 numbers after 1 frequencies: it is cut off"),
        ("# MHz S RI R 50\n2 .1 .2\n1 .1 .2\n", "must have rising frequencies"),
        ("# MHz S RI R 50\n1 nan .2\n", "must hold finite numbers only"),
    ],
)
def test_a_broken_touchstone_file_is_one_sentence(text, said, tmp_path):
    path = tmp_path / "a.s1p"
    path.write_text(text)
    with pytest.raises(SceneError, match=said) as caught:
        read_network(path, "--measured")
    assert "\n" not in str(caught.value)


def test_readings_that_are_averaged_are_the_mean_of_the_curve():
    time = np.array([0.0, 1.0, 3.0])
    values = np.array([0.0, 2.0, -2.0])
    at = np.array([-1.0, 0.5, 2.0, 5.0])
    means = [0.0, 0.25, 1.0, -2.0]  # of triangles over the second before
    np.testing.assert_allclose(averaged(time, values, 1.0, at), means, atol=1e-12)


X_HEAD, ROW = "x_mm,u_z_real_nm_per_V,u_z_imag_nm_per_V", "40,0.1,0.2"


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        (
            "a.csv",
            f"x_inch,u_z_real_nm,u_z_imag_nm\n{ROW}\n",
            "must have one column x_UNIT with a unit of m, cm, mm, um",
        ),
        ("a.csv", f"x_mm,u_z_real_nm_per_V,u_z_imag_V\n{ROW}\n", "must have one column u_z_imag_UNIT with a unit of m"),
        ("a.csv", "x_mm,u_z_real_nm_per_V\n40,0.1\n", "must have a column u_z_imag_UNIT beside the other part"),
        ("a.csv", "u_z_magnitude_nm_per_V\n0.1\n", "must have a column x_UNIT, y_UNIT or frequency_UNIT"),
        ("a.csv", "x_mm,u_z_magnitude_nm_per_V\n40,0.1+0.2j\n", "a complex number goes into two columns"),
        ("a.csv", "x_mm,u_z_magnitude_nm_per_V\n40,nan\n", "must be a finite number, got 'nan'\n"),
        (
            "a.csv",
            "x_mm,u_z_magnitude_nm_per_V\n40,-0.1\n",
            "line 2, u_z_magnitude_nm_per_V must be zero or positive, got -0.1 nm/V",
        ),
        ("a.csv", "x_mm,u_z_magnitude_nm\n40,0.1\n", "holds motions at an unknown voltage"),
        ("a.csv", f"{X_HEAD}\n400,0.1,0.2\n", "x must lie on the stator, 0 mm to 60 mm, got 400 mm to 400 mm"),
        ("a.csv", f"frequency_MHz,{X_HEAD}\n2.3,{ROW}\n", "was taken at 2300000 Hz, and the scene drives 2200000 Hz"),
        ("a.uff", "nothing", "is no Universal File: line 1 must hold -1, got 'nothing'"),
        ("a.csv", "x_mm,v_z_real_m_per_s,v_z_imag_m_per_s\n40,0.1,0.2\n", "holds motions at an unknown voltage"),
        ("a.s1p", "# MHz S RI R 50\n2.2 0.1 0.2\n", "is a network analyser's: sawmotor study network draws it"),
    ],
)
def test_files_that_do_not_fit_are_one_sentence_and_nothing_is_written(name, text, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    Path(name).write_text(text)
    scene = tmp_path / "small.toml"
    from studies.scene.toml import document

    scene.write_text(document(SMALL.to_table()))
    before = set(tmp_path.iterdir())
    assert main(["fit" if name == "b" else "run", str(scene), "--measured", name]) == 2
    error = [line for line in capsys.readouterr().err.splitlines() if line.startswith("sawmotor:")]
    assert len(error) == 1
    assert said in error[0] + "\n"
    assert set(tmp_path.iterdir()) == before


def test_a_touchstone_file_of_another_range_or_ports_is_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    # it is said before anything is solved
    monkeypatch.setattr("studies.stator.network.converged_scattering", None)
    monkeypatch.setattr("studies.solve.scan_prediction.scattering_matrix", None)
    Path("a.s1p").write_text("# MHz S RI R 50\n200 0.1 0.2\n201 0.1 0.2\n")
    assert main(["study", "network", "twente-left", "--measured", "a.s1p"]) == 2
    assert "must meet the passband" in capsys.readouterr().err
    assert main(["study", "network", "twente", "--measured", "a.s1p"]) == 2
    assert "must be a file of 2 ports" in capsys.readouterr().err
    assert main(["fit", "twente-left", "--data", "a.s1p", "--free", "transducer.0.aperture=10 mm:30 mm"]) == 2
    assert "must meet the passband" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [tmp_path / "a.s1p"]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--format", "csv", "--noise", "1%"], "--noise needs --seed N"),
        (["--format", "csv", "--seed", "1"], "--seed needs --noise"),
        (["--format", "uff", "--scan", "z"], "--scan must be one of x, y, xy, frequency, got 'z'"),
        (["--format", "uff", "--scan", "x", "--band", "2:2.1:3"], "--band is for --scan frequency"),
        (["--format", "csv", "--bandwidth", "60 Hz"], "--bandwidth is of an encoder"),
        (["--format", "csv", "--sampling", "1 kg"], "--sampling must be a time"),
        (["--format", "uff", "--sampling", "1 ms"], "--sampling is not taken by the format uff"),
        (["--format", "touchstone", "--z0", "-50"], "--z0 must be positive and finite"),
        (["--format", "csv", "--noise", "3", "--seed", "1"], "--noise must be at least 0 and below 1"),
        (["--format", "csv", "--out", "a.csv"], "--out must be a directory, as there are several files"),
        (["--format", "c", "--out", "motor.c"], "--out must be a directory, as there are several files"),
        (["--format", "uff", "--out", "a.csv"], "--out names a file of the format csv, not of uff"),
        (["--format", "touchstone", "--out", "net.s1p"], "--out must end in .s2p, as the scene has 2 ports"),
    ],
)
def test_wrong_exports_of_instruments_write_nothing(words, said, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["export", "twente", *words]) == 2
    assert said in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


def test_a_network_is_written_into_the_file_that_is_named(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    words = ["export", "twente", "--format", "touchstone", "--band", "2.15:2.25:3", "--tolerance", "1e-2"]
    assert main([*words, "--out", "net.S2P"]) == 0
    assert [each.name for each in tmp_path.iterdir()] == ["net.S2P"]
    assert read_network(Path("net.S2P"), "--measured").scattering.shape == (3, 2, 2)


@pytest.mark.parametrize("is_complex", [True, False])
@pytest.mark.parametrize("side", [1.0, -1.0])
@pytest.mark.parametrize("per_wavelength", [7.3, 12.0, 31.0])
def test_the_standing_wave_ratio_of_a_scan_is_that_between_its_points(per_wavelength, side, is_complex):
    wavelength, back = 1e-3, 0.45 * np.exp(0.6j)
    x = np.arange(0.03, 0.04, wavelength / per_wavelength)
    k = side * 2 * np.pi / wavelength
    values = np.exp(-1j * k * x) + back * np.exp(1j * k * x)
    scan = Scan(name="lab", x=x, y=0 * x, values=values if is_complex else np.abs(values))
    block = compared_scan(scan, values, wavelength=wavelength, source=0.015, place=0.034)
    assert block["standing_wave_ratio_at_m"] == 0.034
    for name in ("measured", "predicted"):
        assert block[f"{name}_standing_wave_ratio"] == pytest.approx(1.45 / 0.55, rel=2e-3)
    # the prediction's ratio from the whole field is the one that is printed, and data without error have the same
    known = compared_scan(scan, values, wavelength=wavelength, source=0.015, place=0.034, ratio=2.7)
    assert known["predicted_standing_wave_ratio"] == 2.7
    assert known["measured_standing_wave_ratio"] == pytest.approx(2.7, rel=1e-12)
    beyond = compared_scan(scan, values, wavelength=wavelength, source=0.015, place=0.01, ratio=2.7)
    assert beyond["standing_wave_ratio_at_m"] == pytest.approx(0.031, abs=1e-9)
    assert beyond["predicted_standing_wave_ratio"] == pytest.approx(1.45 / 0.55, rel=2e-3)


def scan_at(x, y, **options):
    return Scan(name="lab", x=np.array(x), y=np.array(y), values=np.ones(len(x), complex), **options)


def test_the_prediction_is_drawn_between_the_measured_places(small):
    x = np.arange(6.0e-3, 12e-3, 0.13e-3)
    record = run(Scene.from_table("", without(small.to_table(), "slider")), tolerance=0.05)
    motion = record.surface_motion
    scan = scan_at(x, 0 * x)
    block = measured_block(record, Measurement(name="lab", quantity="scan", scan=scan))
    assert block["predicted_standing_wave_ratio"] == record.wave["standing_wave_ratio"]
    line = block["line"]
    assert np.diff(line["x_m"]).max() < 0.05e-3
    assert (line["x_m"][0], line["x_m"][-1]) == pytest.approx((x[0], x[-1]))
    expected = motion.along(line["x_m"], 0.0)[2]
    np.testing.assert_allclose(line["predicted_m_per_V"], expected, rtol=0, atol=1e-12 * abs(expected).max())
    drawn = draw_scan(block, Figure().add_subplot()).get_lines()
    assert [len(each.get_xdata()) for each in drawn] == [len(line["x_m"]), len(x)]
    # of an area the row nearest to the middle
    across, along = (each.ravel() for each in np.meshgrid([-2e-3, 0.5e-3, 3e-3], x, indexing="ij"))
    area = drawn_line(scan_at(along, across), 1e-3)
    assert set(area.y) == {0.5e-3}
    assert drawn_line(scan_at(x, x - x[0]), 1e-3) is None
    assert drawn_line(scan_at(0 * x + 8e-3, x - 8e-3), 1e-3).kind == "y"
    few = drawn_line(scan_at([8e-3] * 3, [0.0] * 3, frequency=np.array([2.1e6, 2.2e6, 2.4e6])), 1e-3)
    assert list(few.frequency) == pytest.approx([2.1e6, 2.125e6, 2.15e6, 2.175e6, 2.2e6, 2.25e6, 2.3e6, 2.35e6, 2.4e6])
