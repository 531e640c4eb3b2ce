"""Universal Files: round trips, files of scanning vibrometers, damage.  Oracles: pyuff, and records set by hand."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from studies.lab.measurement_csv import read_measured
from studies.lab.scan import Scan
from studies.lab.scan_uff import scan_of_uff, scan_uff
from studies.model.resolve import resolved
from studies.refusal import SceneError
from studies.scene import Scene
from studies.solve.scan_prediction import placed

pyuff = pytest.importorskip("pyuff")
# pyuff 2.5.8 leaves the files that it writes binary open
pytestmark = pytest.mark.filterwarnings("ignore::ResourceWarning", "ignore::pytest.PytestUnraisableExceptionWarning")
SCENE = Scene.load("twente-left")
DRIVE = 2.2e6
X = (0.0312345678, 0.0402, 0.0551)
LINES = np.array([2.19e6, DRIVE, 2.21e6])


def some_scan(kind):
    random = np.random.default_rng(3)
    x, y = np.repeat([0.031, 0.0402, 0.055], 2), np.tile([-0.002, 0.003], 3)
    values = 1e-9 * (random.standard_normal(6) + 1j * random.standard_normal(6))
    if kind == "xy":
        return Scan(name="lab", x=x, y=y, values=values)
    frequency = DRIVE + np.arange(6.0)  # 1 Hz apart: the same number in six digits
    return Scan(name="lab", x=np.full(6, 0.0401234567), y=np.zeros(6), frequency=frequency, values=values)


@pytest.mark.parametrize("kind", ["xy", "frequency"])
@pytest.mark.parametrize(
    "changes",
    [{}, {"motion": "velocity", "per_volt": False, "voltage": 12.5, "component": "u_x"}, {"motion": "acceleration"}],
)
@pytest.mark.parametrize("is_complex", [True, False])
def test_an_exported_scan_is_read_back_to_the_last_digit_and_by_pyuff(kind, changes, is_complex, tmp_path):
    scan = replace(some_scan(kind), **changes)
    scan = scan if is_complex else replace(scan, values=np.abs(scan.values))
    file = tmp_path / "lab.uff"
    file.write_bytes(scan_uff(scan, ("remark",)))
    found = scan_of_uff(file, "--measured")
    order = np.lexsort((scan.x, scan.y)) if kind == "xy" else np.arange(6)
    for name in ("values", "y", "x" if kind == "xy" else "frequency"):
        np.testing.assert_array_equal(getattr(found, name), getattr(scan, name)[order])
    for name in ("component", "motion", "per_volt", "voltage", "kind"):
        assert getattr(found, name) == getattr(scan, name)
    theirs = pyuff.UFF(str(file)).read_sets()
    theirs = theirs if isinstance(theirs, list) else [theirs]
    np.testing.assert_array_equal(np.concatenate([each["data"] for each in theirs]), scan.values[order])
    along = np.concatenate([each["x"] for each in theirs])
    np.testing.assert_array_equal(along, (scan.frequency if kind == "frequency" else scan.x)[order])
    assert theirs[0]["n_bytes"] == (24 if is_complex else 16) * len(theirs[0]["x"])


def function(values, x=LINES, **changes):
    """A dataset 58 as pyuff takes it: one velocity per volt over frequency."""
    values = np.asarray(values)
    return {
        "type": 58, "func_type": 4, "data": values, "x": np.asarray(x), "binary": 0, "id1": "Vib / Voltage",
        "id2": "FRF", "id3": "NONE", "id4": "NONE", "id5": "NONE", "rsp_node": 1, "rsp_dir": 3, "ref_node": 0,
        "ref_dir": 0, "abscissa_spacing": 1, "abscissa_spec_data_type": 18, "abscissa_axis_lab": "Frequency",
        "abscissa_axis_units_lab": "Hz", "ordinate_spec_data_type": 11, "ordinate_axis_lab": "Velocity",
        "ordinate_axis_units_lab": "m/s", "orddenom_spec_data_type": 0, "orddenom_axis_lab": "Voltage",
        "orddenom_axis_units_lab": "V",
    } | changes  # fmt: skip


def nodes(kind=15, x=X, scale=1.0, first=1):
    count = len(x)
    return {
        "type": kind, "node_nums": list(range(first, first + count)), "def_cs": [0] * count, "disp_cs": [0] * count,
        "color": [0] * count, "x": [each * scale for each in x], "y": [0.001 * scale] * count, "z": [0.0] * count,
    }  # fmt: skip


def units(code, factor):
    return {"type": 164, "units_code": code, "length": factor, "force": 1.0, "temp": 1.0, "temp_offset": 0.0}


def written(folder, *datasets, name="psv.uff"):
    """A file that pyuff has appended these datasets to."""
    file = folder / name
    for each in datasets:
        pyuff.UFF(str(file)).write_sets([each], "add")
    return file


MOTION = 1e-9 * np.array([1.0 + 0.5j, -0.3 + 0.2j, 0.7 - 0.9j])  # m per V at the nodes, at the drive


def spectrum(k, order=1):
    """The spectrum over LINES of node k: its motion at the drive times (i omega)^order, another one beside it."""
    return MOTION[k] * np.array([0.2, 1.0, -0.4j]) * (2j * np.pi * LINES) ** order


@pytest.mark.parametrize("kind", [15, 2411])
@pytest.mark.parametrize("binary", [0, 1])
@pytest.mark.parametrize("spacing", [0, 1])
def test_a_scanning_vibrometer_s_nodes_place_its_spectra_and_the_drive_chooses_the_line(
    kind, binary, spacing, tmp_path
):
    spectra = [function(spectrum(k), rsp_node=k + 1, binary=binary, abscissa_spacing=spacing) for k in (2, 0, 1)]
    scan = read_measured(written(tmp_path, nodes(kind), *spectra)).scan
    found = placed(resolved(SCENE), scan)
    assert (found.kind, found.component, found.motion) == ("x", "u_z", "displacement")
    np.testing.assert_allclose(found.x, [X[2], X[0], X[1]], rtol=1e-5 if kind == 15 else 1e-15)
    np.testing.assert_allclose(found.y, 0.001, rtol=1e-12)
    np.testing.assert_allclose(found.values, MOTION[[2, 0, 1]], rtol=1e-5)
    assert any("of 3 spectral lines that at 2200000 Hz is taken" in each for each in found.remarks)
    assert any("coordinates of nodes are taken as m" in each for each in found.remarks)


@pytest.mark.parametrize(
    ("order", "label", "data_type", "factor"),
    [
        (0, "nm", 8, 1e9), (1, "mm/s", 11, 1e3), (2, "m/s^2", 12, 1.0), (2, "g", 12, 1 / 9.80665),
        (0, "NONE", 8, 1e3), (1, "NONE", 11, 1e3), (2, "NONE", 12, 1e3), (1, "um/s", 0, 1e6),
    ],
)  # fmt: skip
def test_units_are_those_of_labels_or_of_dataset_164(order, label, data_type, factor, tmp_path):
    changes = {"ordinate_axis_units_lab": label, "ordinate_spec_data_type": data_type}
    spectra = [function(spectrum(k, order) * factor, rsp_node=k + 1, **changes) for k in range(3)]
    file = written(tmp_path, units(5, 1e3), nodes(scale=1e3), *spectra)  # a file in mm
    found = placed(resolved(SCENE), read_measured(file).scan)
    np.testing.assert_allclose(found.x, X, rtol=1e-5)
    np.testing.assert_allclose(found.values, MOTION, rtol=1e-5)
    assert not any("taken as m" in each for each in found.remarks)


def test_a_motion_against_the_axis_has_the_other_sign_and_a_millivolt_is_one(tmp_path):
    changes = {"rsp_dir": -3, "orddenom_axis_units_lab": "mV"}
    spectra = [function(-1e-3 * spectrum(k), rsp_node=k + 1, **changes) for k in range(3)]
    found = placed(resolved(SCENE), read_measured(written(tmp_path, nodes(), *spectra)).scan)
    np.testing.assert_allclose(found.values, MOTION, rtol=1e-5)


def test_coherences_beside_the_responses_are_left_out(tmp_path):
    spectra = [function(spectrum(k), rsp_node=k + 1) for k in range(3)]
    other = [function(np.ones(3), rsp_node=k + 1, func_type=6, ordinate_spec_data_type=0) for k in range(3)]
    scan = read_measured(written(tmp_path, nodes(), *spectra, *other)).scan
    np.testing.assert_allclose(placed(resolved(SCENE), scan).values, MOTION, rtol=1e-5)
    assert any("not a coherence" in each for each in scan.remarks)


@pytest.mark.parametrize(
    ("datasets", "said"),
    [
        ([function(spectrum(0)), function(spectrum(1), rsp_node=2)], "their positions are missing: dataset 15 or 2411"),
        ([nodes(first=2), function(spectrum(0))], "is of node 1, which no dataset 15 or 2411 of the file places"),
        ([function(spectrum(0), ordinate_axis_units_lab="NONE")], "states no unit of its velocity"),
        ([function(spectrum(0), ordinate_axis_units_lab="V")], "got data type 11 in V"),
        ([function(spectrum(0), ordinate_axis_units_lab="m")], "got data type 11 in m"),
        ([function(spectrum(0), orddenom_axis_units_lab="N")], "must hold motions per volt (V, mV), got N"),
        (
            [function(spectrum(0), orddenom_axis_units_lab="NONE", orddenom_spec_data_type=13)],
            "got data type 13 as denominator",
        ),
        ([function(spectrum(0), orddenom_axis_units_lab="NONE")], "holds motions at an unknown voltage"),
        ([function(abs(spectrum(0)) ** 2, func_type=2)], "got an auto spectrum"),
        ([function(spectrum(0), rsp_dir=-5)], "directions 1 to 3), got -5, a rotation"),
        ([function(-abs(spectrum(0)))], "holds real values below 0"),
        ([function(spectrum(0), abscissa_spec_data_type=17, abscissa_axis_units_lab="s")], "got type 17 in s"),
        ([units(1, 3.28083989501312334), function(spectrum(0))], "dataset 164 contradicts itself: units code 1"),
        (
            [nodes(), *(function(spectrum(k), rsp_node=k + 1, rsp_dir=1 + k) for k in range(3))],
            "must hold one motion in one unit, got several directions",
        ),
        (
            [{**nodes(), "z": [0.0, 0.1, 0.2]}, *(function(spectrum(k), rsp_node=k + 1) for k in range(3))],
            "must hold nodes in a plane of constant z",
        ),
        ([nodes()], "must hold a dataset 58, got 15"),
    ],
)
def test_what_a_file_does_not_say_is_refused(datasets, said, tmp_path):
    with pytest.raises(SceneError) as caught:
        read_measured(written(tmp_path, *datasets))
    assert said in str(caught.value)


def test_nodes_in_mm_without_a_unit_lie_beside_the_stator_and_that_is_said(tmp_path):
    spectra = [function(spectrum(k), rsp_node=k + 1) for k in range(3)]
    scan = read_measured(written(tmp_path, nodes(scale=1e3), *spectra)).scan
    with pytest.raises(SceneError, match=r"must lie on the stator, .*coordinates of nodes are taken as m"):
        placed(resolved(SCENE), scan)


def test_a_drive_between_the_spectral_lines_is_refused(tmp_path):
    spectra = [function(spectrum(k), LINES + 5e3, rsp_node=k + 1) for k in range(3)]
    scan = read_measured(written(tmp_path, nodes(), *spectra)).scan
    with pytest.raises(SceneError, match="no spectral line at the drive's 2200000 Hz; the nearest are at 2195000 and"):
        placed(resolved(SCENE), scan)


TEXT = """\
    -1
    58
scan
NONE
NONE
NONE
NONE
    0         0    0         0       NONE         1   3       NONE         0   0
         6         2         0  0.00000e+00  0.00000e+00  0.00000e+00
         8    0    0    0 x                    m
         8    0    0    0 u                    m
         0    0    0    0 Voltage              V
         0    0    0    0 NONE                 NONE
  1.74327E-02   3.23100805903E-10  -2.70082429041E-11
  1.75564E-02   2.06193860810E-10  -2.48060457985E-10
    -1
"""
IDENTITY = "    0         0    0         0       NONE         1   3       NONE         0   0"
FREE = TEXT.replace(IDENTITY, "0 0 0 0 NONE 1 3 NONE 0 0")
FREE = FREE.replace("         6         2         0  0.00000e+00", "6 2 0 0.0")


@pytest.mark.parametrize(
    "text",
    [
        TEXT, TEXT.replace("E-", "D-"), TEXT.replace(".", ","), FREE, FREE.replace("         8    0", "8 0"),
        TEXT.replace("\n", "\r\n"), TEXT.replace("    -1", "-1"),
        TEXT.replace("  1.74327E-02   3.23100805903E-10 ", "1.74327E-02 3.23100805903E-10\n"),
    ],
)  # fmt: skip
def test_text_is_read_from_any_columns_with_exponents_d_and_decimal_commas(text, tmp_path):
    file = tmp_path / "a.uff"
    file.write_bytes(text.encode())
    scan = scan_of_uff(file, "--measured")
    np.testing.assert_array_equal(scan.x, [1.74327e-2, 1.75564e-2])
    np.testing.assert_array_equal(
        scan.values, [3.23100805903e-10 - 2.70082429041e-11j, 2.0619386081e-10 - 2.48060457985e-10j]
    )
    assert (scan.component, scan.motion, scan.per_volt) == ("u_z", "displacement", True)


def without_line(number):
    lines = TEXT.splitlines(keepends=True)
    return "".join(lines[: number - 1] + lines[number:])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "must hold a dataset 58, got none"),
        ("lorem ipsum", "is no Universal File: line 1 must hold -1"),
        (without_line(5), "line 8: must hold function type, response node and direction"),
        (without_line(8), "line 8: must hold function type, response node and direction"),
        (without_line(9), "line 9: must hold data type, number of points and spacing"),
        (without_line(13), "line 13: must hold a data type, label and unit of an axis"),
        (TEXT[:300], "is cut off in its head"),
        (TEXT.replace("2.06193860810E-10", "2.06193860810E+910"), "line 15: must hold finite numbers"),
        (TEXT[:-60], "line 15: the dataset 58 that begins in line 1 is cut off: its closing -1 is missing"),
        (TEXT.replace("  -2.48060457985E-10", ""), "must hold 6 numbers, got 5: is it cut off?"),
        (TEXT.replace("2.06193860810E-10", "          *******"), "line 15: must hold numbers, got '*******'"),
        (TEXT.replace("1.75564E-02", "1.74327E-02"), "an abscissa of 2 points with 1 values: six digits do not tell"),
        (TEXT.replace("         6         2", "         7         2"), "line 9: must hold a data type of 2, 4, 5, 6"),
    ],
)
def test_a_damaged_text_is_one_true_sentence(text, said, tmp_path):
    file = tmp_path / "a.uff"
    file.write_text(text)
    with pytest.raises(SceneError) as caught:
        scan_of_uff(file, "--measured")
    assert said in str(caught.value)
    assert "\n" not in str(caught.value)


def binary(form, data, order=1):
    """A 58b of two complex points on an uneven abscissa, its head set by hand."""
    head = TEXT.split("  1.74327E-02")[0].replace("         6         2", f"{form:10d}         2")
    head = head.replace("    58\n", f"    58b{order:6d}{2:6d}{11:12d}{len(data):12d}{0:6d}{0:6d}{0:12d}{0:12d}\n")
    return head.encode() + data + b"    -1\n"


POINTS = (0.25, 1.5, -2.0, 0.5, 3.0, 4.0)  # exact in single precision


@pytest.mark.parametrize(
    ("form", "code", "order"), [(5, "<6f", 1), (5, ">6f", 2), (6, "<6d", 1), (6, ">6d", 2), (6, "<fddfdd", 1)]
)
def test_binary_values_of_single_and_double_precision_on_an_uneven_abscissa(form, code, order, tmp_path):
    file = tmp_path / "a.uff"
    file.write_bytes(binary(form, struct.pack(code if "fdd" not in code else "<fddfdd", *POINTS), order))
    scan = scan_of_uff(file, "--measured")
    np.testing.assert_array_equal(scan.x, [0.25, 0.5])
    np.testing.assert_array_equal(scan.values, [1.5 - 2j, 3 + 4j])
    file.write_bytes(
        binary(form, struct.pack(code, *POINTS), order).replace(b"     2          11", b"     1          11")
    )
    with pytest.raises(SceneError, match=r"must have byte order 1 or 2, IEEE numbers \(2\)"):
        scan_of_uff(file, "--measured")
    file.write_bytes(binary(form, struct.pack(code, *POINTS), order).removesuffix(b"    -1\n"))
    with pytest.raises(SceneError, match="the closing -1 of the dataset 58b that begins in line 1 is missing"):
        scan_of_uff(file, "--measured")
    # the byte of a line end within the numbers is no line
    file.write_bytes(binary(form, struct.pack(code, *POINTS)[:-1], order))
    with pytest.raises(SceneError, match=r"must hold \d+( or \d+)? bytes of values before its closing -1, got \d+"):
        scan_of_uff(file, "--measured")


def test_pyuff_2_5_8_writes_text_in_six_digits_and_loses_all_but_seven_bytes_of_a_binary_overwrite(tmp_path):
    """Surprises of pyuff 2.5.8, github.com/ladisk/pyuff, for which files are read and written here."""
    if pyuff.__version__ != "2.5.8":
        pytest.skip("of another version")
    fine = DRIVE + np.arange(3.0)
    file = written(tmp_path, function(spectrum(0), fine, abscissa_spacing=0))
    assert len(np.unique(pyuff.UFF(str(file)).read_sets()["x"])) == 1
    with pytest.raises(SceneError, match="six digits do not tell them apart"):
        read_measured(file)
    over = tmp_path / "over.uff"
    pyuff.UFF(str(over)).write_sets([function(spectrum(0), binary=1)], "overwrite")
    assert over.stat().st_size == 7
    with pytest.raises(SceneError, match="must hold a dataset 58"):
        read_measured(over)


def test_pyuff_2_5_8_cannot_read_its_own_complex_rotations_of_dataset_55(tmp_path):
    """Of this file the scan is read nevertheless: dataset 55 is passed over."""
    shape = {
        "type": 55, "analysis_type": 2, "data_ch": 3, "spec_data_type": 8, "data_type": 5, "load_case": 1,
        "mode_n": 1, "freq": 1.0, "modal_m": 1.0, "modal_damp_vis": 0.0, "modal_damp_his": 0.0, "n_data_per_node": 6,
        "node_nums": np.array([1.0, 2.0]), "id1": "NONE",
        **{f"r{k}": np.array([1.0 + 2j, 3.0 + 4j]) for k in range(1, 7)},
    }  # fmt: skip
    file = written(tmp_path, shape, nodes(), *(function(spectrum(k), rsp_node=k + 1) for k in range(3)))
    with pytest.raises(Exception, match="Error when reading data-set"):
        pyuff.UFF(str(file)).read_sets(0)
    found = placed(resolved(SCENE), read_measured(file).scan)
    np.testing.assert_allclose(found.values, MOTION, rtol=1e-5)
