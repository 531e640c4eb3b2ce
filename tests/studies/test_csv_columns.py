"""Units of all heads of CSV files, and scans that are velocities or accelerations.  Oracle: the SI prefixes."""

import math
from dataclasses import replace

import numpy as np
import pytest

from studies.inverse import read_measurement
from studies.inverse.fitting import prepared
from studies.lab.csv_columns import CsvColumns
from studies.lab.measurement_csv import read_measured
from studies.model.resolve import resolved
from studies.refusal import SceneError
from studies.scene import Scene
from studies.solve.scan_prediction import placed

SCENE = Scene.load("twente-left")
OMEGA = 2.0 * math.pi * 2.2e6
SI = {"": 1.0, "c": 1e-2, "m": 1e-3, "u": 1e-6, "n": 1e-9, "p": 1e-12, "k": 1e3, "M": 1e6, "G": 1e9}
LENGTHS, RATES = ("m", "um", "nm", "pm"), ("m_per_s", "mm_per_s", "um_per_s", "nm_per_s")


def prefixed(unit: str) -> float:
    """The size of a unit by its SI prefix; of those without one by its definition."""
    own = {"deg": math.pi / 180.0, "rad": 1.0, "g": 9.80665}
    base = next((each for each in ("m_per_s2", "m_per_s", "Hz", "V", "s", "m") if unit.endswith(each)), "")
    return own[unit] if unit in own else SI[unit.removesuffix(base)]


TABLE = [
    # what is read, head but for its unit, units, other columns with their values
    *(("levels", "voltage", unit, {"velocity_m_per_s": 1.0}) for unit in ("V", "mV", "kV")),
    *(("levels", "normal_amplitude", unit, {"velocity_m_per_s": 1.0}) for unit in LENGTHS),
    *(("values", "velocity", unit, {"voltage_V": 1.0}) for unit in RATES),
    *(("deviations", "error", unit, {"voltage_V": 1.0, "velocity_m_per_s": 1.0}) for unit in RATES),
    *(("deviations", "velocity_standard_deviation", unit, {"voltage_V": 1.0, "velocity_m_per_s": 1.0})
      for unit in RATES),
    *(("time", "time", unit, {"velocity_m_per_s": 1.0}) for unit in ("s", "ms", "us", "ns")),
    *(("values", "position", unit, {"time_s": 1.0}) for unit in (*LENGTHS, "mm")),
    *(("deviations", "position_standard_deviation", unit, {"time_s": 1.0, "position_m": 1.0}) for unit in LENGTHS),
    *(("values", "normal_amplitude", unit, {"voltage_V": 1.0}) for unit in LENGTHS),
    *(("deviations", "normal_amplitude_standard_deviation", unit, {"voltage_V": 1.0, "normal_amplitude_m": 1.0})
      for unit in LENGTHS),
    *(("scan.x", "x", unit, {"u_z_magnitude_m_per_V": 1.0}) for unit in ("m", "cm", "mm", "um")),
    *(("scan.y", "y", unit, {"u_z_magnitude_m_per_V": 1.0}) for unit in ("m", "cm", "mm", "um")),
    *(("scan.frequency", "frequency", unit, {"u_z_magnitude_m_per_V": 1.0}) for unit in ("Hz", "kHz", "MHz", "GHz")),
    *(("scan.values", f"u_{axis}_magnitude", f"{unit}_per_V", {"x_m": 1.0}) for unit in LENGTHS for axis in "xyz"),
    *(("scan.values", "v_z_magnitude", f"{unit}_per_V", {"x_m": 1.0}) for unit in RATES),
    *(("scan.values", "a_z_magnitude", f"{unit}_per_V", {"x_m": 1.0})
      for unit in ("m_per_s2", "mm_per_s2", "km_per_s2", "g")),
    *(("scan.deviation", "u_z_standard_deviation", f"{unit}_per_V", {"x_m": 1.0, "u_z_magnitude_m_per_V": 1.0})
      for unit in LENGTHS),
]  # fmt: skip


@pytest.mark.parametrize(("read", "noun", "unit", "others"), TABLE)
def test_every_unit_of_every_head_is_its_prefix_in_si(read, noun, unit, others, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(f"{noun}_{unit},{','.join(others)}\n2.5,{','.join(map(str, others.values()))}\n")
    found = read_measured(file)
    for name in read.split("."):
        found = getattr(found, name)
    assert float(found[0]) == pytest.approx(2.5 * prefixed(unit.removesuffix("_per_V")), rel=1e-14)


@pytest.mark.parametrize(
    ("head", "line_of_units", "peak"),
    [
        ("Voltage (Vpp)", "", 0.5), ("voltage_mVpp", "", 0.5e-3), ("U_pp / V", "", 0.5), ("Vpp", "", 0.5),
        ("Vpp [V]", "", 0.5), ("Peak-to-peak voltage (kV)", "", 0.5e3), ("Drive voltage Vp-p", "", 0.5),
        ("Uss", "V,mm/s", 0.5), ("U", "Vpp,mm/s", 0.5), ("U_eff / V", "", math.sqrt(2.0)),
        ("Voltage RMS (mV)", "", 1e-3 * math.sqrt(2.0)), ("Voltage (Vrms)", "", math.sqrt(2.0)),
        ("Voltage (Vp)", "", 1.0), ("V_peak", "", 1.0), ("Voltage (V)", "", 1.0),
    ],
)  # fmt: skip
def test_voltages_are_read_as_peak_values_of_a_sine(head, line_of_units, peak, tmp_path):
    """The peak of a sine is half of its range, and sqrt(2) times its root mean square."""
    file = tmp_path / "lab.csv"
    velocity = "Velocity" if line_of_units else "Velocity (mm/s)"
    file.write_text("\n".join(filter(None, [f"{head},{velocity}", line_of_units, "10,3", "20,9"])))
    found = read_measured(file)
    assert found.levels == pytest.approx((10.0 * peak, 20.0 * peak), rel=1e-14)
    assert found.values == pytest.approx((3e-3, 9e-3), rel=1e-14)
    said = "".join(found.remarks)
    wanted = (
        "peak-to-peak voltages halved"
        if "5" in f"{peak:g}"
        else "rms voltages as sqrt(2)"
        if "4" in f"{peak:g}"
        else ""
    )
    assert wanted in said
    assert bool(wanted) == ("halved" in said or "sqrt" in said)


def test_a_line_of_units_may_lack_those_of_numbers_without_one(tmp_path):
    for units in (";ms", "-;ms", "[1];ms"):
        file = tmp_path / "lab.csv"
        file.write_text(f"Amplitude;Zeit\n{units}\n0;0\n0,5;1,5\n")
        table = CsvColumns.read(file, "--measured")
        assert table.names == ["amplitude", "time_ms"]
        assert table.rows == [["0", "0"], ["0.5", "1.5"]]


@pytest.mark.parametrize("unit", ["deg", "rad"])
def test_a_phase_in_degrees_or_radians(unit, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(f"x_m,u_z_magnitude_m_per_V,u_z_phase_{unit}\n0.04,2.0,{0.7 / prefixed(unit)!r}\n")
    assert read_measured(file).scan.values[0] == pytest.approx(2.0 * np.exp(0.7j), rel=1e-14)


POSITIONS = np.array([0.041, 0.042, 0.0433])
DISPLACEMENTS = 1e-9 * np.array([1.0 + 0.5j, -0.3 + 0.2j, 0.7 - 0.9j])  # m per V


def scan_file(folder, noun, unit, order, volts, per_volt=False, phase=True):
    """A scan over positions of these displacements, as derivatives of an order at a voltage."""
    scale = (1j * OMEGA) ** order * (1.0 if per_volt else volts) / prefixed(unit)
    unit += "_per_V" if per_volt else ""
    heads = f"{noun}_real_{unit},{noun}_imag_{unit}" if phase else f"{noun}_magnitude_{unit}"
    rows = [f"x_m,{heads},{noun}_standard_deviation_{unit}" + ("" if per_volt else ",voltage_V")]
    for x, value in zip(POSITIONS.tolist(), DISPLACEMENTS * scale, strict=True):
        parts = [value.real, value.imag] if phase else [abs(value)]
        numbers = [x, *parts, 1e-11 * abs(scale), *([] if per_volt else [volts])]
        rows.append(",".join(repr(float(each)) for each in numbers))
    file = folder / "lab.csv"
    file.write_text("\n".join(rows))
    return file


@pytest.mark.parametrize("phase", [True, False])
@pytest.mark.parametrize("per_volt", [True, False])
@pytest.mark.parametrize(
    ("noun", "unit", "order"), [("u_z", "nm", 0), ("v_z", "mm_per_s", 1), ("a_z", "km_per_s2", 2), ("a_z", "g", 2)]
)
def test_displacements_velocities_and_accelerations_are_one_motion(noun, unit, order, per_volt, phase, tmp_path):
    measured = read_measured(scan_file(tmp_path, noun, unit, order, 15.0, per_volt, phase))
    expected = DISPLACEMENTS if phase else abs(DISPLACEMENTS)
    found = placed(resolved(SCENE), measured.scan)
    np.testing.assert_allclose(found.values, expected, rtol=1e-12)
    np.testing.assert_allclose(found.deviation, 1e-11, rtol=1e-12)
    # what a fit compares with predictions in m per V
    problem, _, _ = prepared(SCENE, [measured], {"amplitude_factor": (0.5, 2.0)}, tolerance=1e-2)
    (fitted,) = problem.measurements
    parts = [*expected.real, *expected.imag] if phase else expected
    np.testing.assert_allclose(fitted.values, parts, rtol=1e-12)
    np.testing.assert_allclose(fitted.deviations, 1e-11, rtol=1e-12)


def test_a_scan_that_is_converted_for_a_fit_keeps_its_systematic_error_and_its_own_keys(tmp_path):
    file = scan_file(tmp_path, "v_z", "mm_per_s", 1, 15.0)
    measured = read_measurement(file, ("systematic=0.02", 'slider.position="42 mm"'))
    problem, _, _ = prepared(SCENE, [measured], {"amplitude_factor": (0.5, 2.0)}, tolerance=1e-2)
    (fitted,) = problem.measurements
    assert (fitted.systematic, fitted.settings) == (0.02, measured.settings)
    assert measured.settings


def test_a_scan_at_an_unknown_voltage_is_refused_whatever_the_motion(tmp_path):
    for noun, unit in (("u_z", "nm"), ("v_z", "mm_per_s"), ("a_z", "m_per_s2")):
        file = tmp_path / "lab.csv"
        file.write_text(f"x_mm,{noun}_magnitude_{unit}\n40,1\n")
        with pytest.raises(SceneError, match="holds motions at an unknown voltage: add a column voltage_V"):
            read_measured(file)


def test_a_scan_over_positions_and_frequencies_is_cut_at_the_drive(tmp_path):
    rows = [
        f"{x},{f},{k + 10 * n},{1 + k + 10 * n}"
        for k, x in enumerate((41, 42))
        for n, f in enumerate((2.19, 2.2, 2.21))
    ]
    file = tmp_path / "lab.csv"
    heads = "x_mm,frequency_MHz,u_z_magnitude_nm_per_V,u_z_standard_deviation_nm_per_V"
    file.write_text("\n".join([heads, *rows]))
    scan = read_measured(file).scan
    found = placed(resolved(SCENE), scan)
    np.testing.assert_allclose(found.x, [0.041, 0.042], rtol=1e-14)
    np.testing.assert_allclose(found.values, [10e-9, 11e-9], rtol=1e-14)
    np.testing.assert_allclose(found.deviation, [11e-9, 12e-9], rtol=1e-14)
    between = replace(scan, frequency=scan.frequency + 5e3)
    with pytest.raises(SceneError, match="no spectral line at the drive's 2200000 Hz; the nearest are at 2195000 and"):
        placed(resolved(SCENE), between)


def test_points_at_rest_are_left_out(tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text("frequency_kHz,v_z_magnitude_mm_per_s_per_V\n0,0\n2200,1\n")
    scan = read_measured(file).scan
    np.testing.assert_allclose(scan.values, [1e-3 / OMEGA], rtol=1e-14)
    assert scan.remarks == ("the points at 0 Hz are left out",)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (
            "# made up\n\nx_mm,u_z_magnitude_nm_per_V\n40,1\n# beside\n41,-3\n",
            "line 6, u_z_magnitude_nm_per_V must be zero or positive, got -3 nm/V",
        ),
        (
            "x_mm,u_z_magnitude_nm_per_V\n40,1\n\n41,x\n",
            "line 4, u_z_magnitude_nm_per_V must be a finite number, got 'x'",
        ),
        (
            "voltage_V,velocity_mm_per_s,error_mm_per_s\n10,3,-0.5\n",
            "line 2, error_mm_per_s must be positive, got -0.5 mm/s",
        ),
        (
            "time_ms,velocity_m_per_s\n\n0,0\n2,0\n1,0\n",
            "line 5, time must rise from line to line, got 0.001 s after 0.002 s",
        ),
        ("time_ms,velocity_m_per_s\n-2,0\n-1,0\n", "must hold times after 0, got -0.001 s"),
        ("time_s,velocity_m_per_s,voltage_V\n0,0,15\n1,0,30\n", "one level, got 15 and in line 3 30 V"),
        ("voltage_mV,velocity_mm_per_s\n-10,3\n", "line 2, voltage_mV must be zero or positive, got -10 mV"),
        ("x_mm,u_z_magnitude_nm,voltage_V\n40,1,0\n", "line 2, voltage_V must be positive, got 0 V"),
        ("x_mm,a_z_magnitude_m_per_s2,voltage_V\n40,-1,1\n", "got -1 m/s^2"),
        ("x_mm,a_z_real_m_per_s2,voltage_V\n40,-1,1\n", "must have a column a_z_imag_UNIT beside the other part"),
        ("x_mm,u_z_magnitude_nm,voltage_V\n40,1,15\n41,1,30\n", "must hold one voltage, got 15 to 30 V"),
    ],
)  # fmt: skip
def test_a_refusal_names_the_line_of_the_file_and_the_unit(text, said, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(text)
    with pytest.raises(SceneError) as caught:
        read_measured(file)
    assert said in str(caught.value)


@pytest.mark.parametrize(
    ("head", "read"),
    [
        ("standard_deviation_m_per_s", ""), ("std_m_per_s", ""), ("normal_amplitude_standard_deviation_nm", ""),
        ("velocity_standard_deviation_m_per_s", "it"), ("error_m_per_s", "it"), ("ripple_relative_error", "nothing"),
    ],
)  # fmt: skip
def test_standard_deviations_that_are_not_read_are_named(head, read, tmp_path):
    file = tmp_path / "v.csv"
    file.write_text(f"voltage_V,velocity_m_per_s,{head}\n10,0.1,0.01\n")
    measured = read_measured(file)
    own = "velocity_standard_deviation_m_per_s"
    expected = () if read else (f"{head} not read: standard deviations are those of the column {own}",)
    assert (measured.remarks, measured.deviations) == (expected, (0.01,) if read == "it" else None)


FIRST = {"levels": (10.0, 15.5), "values": (-0.0312, -0.069), "deviations": (0.002, 0.0025)}
INSTRUMENTS = {
    "heads of a person": "Voltage (V),Velocity (mm/s),Std. dev. (mm/s)\n10,-31.2,2\n15.5,-69,2.5\n",
    "instrument above": "Vibrometer 7; 64 averages\nDate;2024-05-17\n\nSpannung (V);Geschwindigkeit (mm/s);"
    "Standardabweichung (mm/s)\n10,0;-31,2;2,0\n15,5;-69,0;2,5\n",
    "padded by a spreadsheet": "Vibrometer 7;;\n64 averages;;\nU / V;v / mm/s;sigma / mm/s\n10;-31,2;2\n15,5;-69;2,5\n",
    "line of units": "Drive voltage\tVelocity\tUncertainty\n(V)\t(m/s)\t(m/s)\n"
    "10,0\t-0,0312\t0,002\n15,5\t-0,069\t2,5E-3\n",
    "quoted numbers": '"voltage_V","velocity_mm/s","error_mm/s"\n"10,0","-31,2","2,0"\n"15,5","-69,0","2,5"\n',
    "blanks": "# by hand\nvoltage_V  velocity_mm_per_s  error_mm_per_s\n10.0  -31.2  2.0\n15.5  -69.0   2.5\n",
}


@pytest.mark.parametrize("encoding", ["utf-8-sig", "utf-16", "latin-1"])
@pytest.mark.parametrize("layout", INSTRUMENTS)
def test_the_file_of_an_instrument_is_read_as_the_same_numbers(layout, encoding, tmp_path):
    file = tmp_path / "lab.csv"
    file.write_bytes(INSTRUMENTS[layout].replace("Vibrometer", "Prüf-Vibrometer").encode(encoding))
    found = read_measured(file)
    assert found.quantity == "velocity"
    for name, expected in FIRST.items():
        assert getattr(found, name) == pytest.approx(expected, rel=1e-14), name


def test_what_was_read_otherwise_than_the_file_has_it_is_remarked(tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text(INSTRUMENTS["instrument above"])
    (remark,) = read_measured(file).remarks
    assert remark == (
        "2 lines above the heads left out; columns read: 'Spannung (V)' as voltage_V, 'Geschwindigkeit (mm/s)' as "
        "velocity_mm_per_s, 'Standardabweichung (mm/s)' as velocity_standard_deviation_mm_per_s; decimal commas"
    )
    file.write_text("voltage_V,velocity_m_per_s\n10,0.1\n")
    assert not read_measured(file).remarks


def test_a_value_of_another_line_than_that_of_an_instrument_names_its_line(tmp_path):
    file = tmp_path / "lab.csv"
    file.write_text("Vibrometer 7\nVoltage [V];Velocity [mm/s]\n10,0;-31,2\n15,0;fast\n")
    with pytest.raises(SceneError, match="line 4, velocity_mm_per_s must be a finite number, got 'fast'"):
        read_measured(file)
