"""The Python interface: scenes changed, runs and sweeps as arrays, saved and loaded; one BLAS thread during a run."""

import json
import math
import os
import re
import sys
import threading

import numpy as np
import pytest
import threadpoolctl

from studies import Record, RunError, Scene, SceneError, datasheet, network, run, sweep
from studies.record.quantities import quantity
from studies.results import MANIFEST

LEVELS = (0.5e-9, 3e-9, 10e-9)


@pytest.fixture(scope="module")
def contact():
    return Scene.load("twente-contact").replace(wave={"normal_amplitude": list(LEVELS)})


@pytest.fixture(scope="module")
def record(contact):
    return run(contact)


@pytest.fixture(scope="module")
def driven(small_run):
    return small_run


def test_a_scene_is_changed_by_its_keys():
    motor = Scene.load("twente").replace(
        title="mine",
        slider={"preload": "5 mN", "damping": {"normal": "0.2 N s/m"}},
        drive={"voltage": "5:60:12"},
        transducer={"left": {"finger_pairs": 5}},
    )
    old = Scene.load("twente")
    assert motor.slider.preload == 5e-3
    assert (motor.slider.damping.normal, motor.slider.damping.tangential) == (0.2, old.slider.damping.tangential)
    assert motor.drive.voltage == tuple(5.0 + 5 * k for k in range(12))
    assert [each.finger_pairs for each in motor.transducer] == [5, 10]
    assert motor.replace(title=old.title, slider=None).slider is None
    assert old == Scene.load("twente")
    with pytest.raises(SceneError, match=r"^transducer has none of the name 'lefft'; did you mean left\?$"):
        motor.replace(transducer={"lefft": {"finger_pairs": 5}})


@pytest.mark.parametrize("voltage", [np.linspace(5, 60, 3), np.array([5, 6]), range(5, 60, 10), np.float64(7.0)])
def test_voltages_come_from_an_array_or_a_range(voltage):
    changed = Scene.load("twente").replace(drive={"voltage": voltage})
    assert changed.drive.voltage == tuple(np.atleast_1d(voltage).astype(float))


def test_a_run_takes_a_name_a_path_or_a_scene(contact, record, tmp_path):
    from studies.scene.toml import document

    (tmp_path / "motor.toml").write_text(document(contact.to_table()))
    assert run(tmp_path / "motor.toml").points == run(str(tmp_path / "motor.toml")).points == record.points
    assert record.tolerance == 1e-3
    with pytest.raises(SceneError, match="tolerance must be positive and finite and below 1, got 0"):
        run(contact, tolerance=0.0)


def test_a_record_gives_its_points_as_arrays(record):
    np.testing.assert_array_equal(record.normal_amplitude, LEVELS)
    np.testing.assert_array_equal(record.velocity, [point["velocity_m_per_s"] for point in record.points])
    np.testing.assert_array_equal(record.relative_error, [point["relative_error"] for point in record.points])
    assert list(record.regime) == ["stick", "slip", "intermittent"]
    assert list(record.status) == ["ok"] * 3
    assert np.isnan(record.voltage).all()
    with pytest.raises(SceneError, match="velocity_m_per_s"):
        record.column("velocity")


def test_a_point_without_an_answer_is_nan_with_its_reason(contact):
    failed = run(contact.replace(slider={"load": 1.0, "damping": {"tangential": 0.0}}))
    assert np.isnan(failed.velocity[1:]).all()
    assert all("runaway" in status for status in failed.status[1:])
    assert failed.shortfall in repr(failed)


def test_a_data_frame_has_the_points_as_rows(record):
    table = record.to_dataframe()
    assert len(table) == 3
    for key in ("normal_amplitude_m", "velocity_m_per_s", "relative_error", "regime"):
        assert table[key].tolist() == [point[key] for point in record.points]


@pytest.mark.parametrize(("name", "package"), [("to_dataframe", "pandas"), ("to_xarray", "xarray")])
def test_an_optional_package_that_is_missing_is_named(record, contact, monkeypatch, name, package):
    monkeypatch.setitem(sys.modules, package, None)
    source = record if package == "pandas" else sweep(contact, {})
    with pytest.raises(RunError, match=f"{name} needs {package}, which is not installed: pip install {package}"):
        getattr(source, name)()


def test_a_package_is_named_as_pip_knows_it(monkeypatch):
    monkeypatch.setitem(sys.modules, "skrf", None)
    with pytest.raises(RunError, match="needs scikit-rf, which is not installed: pip install scikit-rf"):
        network("twente")


def test_a_saved_record_is_the_loaded_one(driven, tmp_path):
    driven.save(tmp_path / "mine")
    loaded = Record.load(tmp_path / "mine")
    assert json.dumps(loaded.to_dict()) == json.dumps(driven.to_dict())
    assert loaded.scene == driven.scene
    assert loaded.wave == driven.wave
    assert loaded.electrical == driven.electrical
    assert loaded.surface.keys() == driven.surface.keys()
    for key, values in driven.surface.items():
        np.testing.assert_array_equal(loaded.surface[key], values)
    assert len(loaded.trajectories) == len(driven.trajectories) == 3
    for (level, motion), (other, saved) in zip(driven.trajectories, loaded.trajectories, strict=True):
        assert level == other
        for name in ("time", "velocity", "position"):
            np.testing.assert_array_equal(getattr(saved, name), getattr(motion, name))
    before = {path.name: path.read_bytes() for path in (tmp_path / "mine").iterdir() if path.name != MANIFEST}
    (tmp_path / "mine" / "notes.md").write_text("mine")
    said = loaded.save(tmp_path / "mine")
    assert {path: (tmp_path / "mine" / path).read_bytes() for path in before} == before
    assert "notes.md" in " ".join(said)


def test_a_directory_without_a_run_is_said(tmp_path):
    with pytest.raises(RunError, match=r"holds no run\.json"):
        Record.load(tmp_path)


def test_a_record_shows_itself(record, driven):
    from matplotlib.figure import Figure

    assert "3 points, 0.5 to 10 nm, velocity 0 to" in repr(record)
    assert "20 to 120 V" in repr(driven)
    page = driven._repr_html_()
    assert page.count("<tr>") == 4
    assert "velocity (mm/s)" in page
    ax = record.plot(Figure().add_subplot())
    assert "mm/s" in ax.get_ylabel()
    sheet = datasheet("twente-contact")
    assert re.match(r"Datasheet\('.*', 20 nm, .*speed.* 1[0-9.]+ mm/s\)", repr(sheet))
    assert "blocked thrust" in str(sheet)
    free = run("rayleigh")
    assert "free wave, 218" in repr(free)
    assert "depth" in free.plot(Figure().add_subplot()).get_xlabel()


def test_a_sweep_as_a_data_set_has_the_runs_own_numbers(contact):
    over = {"slider.preload": [1e-3, 2e-3], "wave.normal_amplitude": [3e-9, 6e-9, 9e-9]}
    grid = sweep(contact, over).to_xarray()
    assert dict(grid.sizes) == {"slider.preload": 2, "wave.normal_amplitude": 3}
    single = run(contact.replace(slider={"preload": 2e-3}, wave={"normal_amplitude": 6e-9}))
    value = grid["velocity_m_per_s"].sel({"slider.preload": 2e-3, "wave.normal_amplitude": 6e-9})
    assert float(value) == pytest.approx(float(single.velocity[0]), rel=1e-3)
    assert str(grid["regime"][1, 1].item()) == single.regime[0]
    for data in (grid, run(contact).to_xarray()):
        assert all("units" in each.attrs for each in data.variables.values() if each.dtype.kind == "f")
    refused = sweep(contact, {"slider.preload": [-1e-3, 1e-3]}).to_xarray()
    assert refused["regime"].to_numpy().tolist()[0] == [""] * refused["regime"].shape[1]
    table = sweep(contact, over).columns()
    assert table["velocity_m_per_s"] == grid["velocity_m_per_s"].to_numpy().ravel().tolist()


def test_sweep_is_the_function_whatever_was_imported_before():
    import studies.sweep
    from studies.sweep import Sweep, sweep

    import studies

    assert (studies.sweep, studies.Sweep) == (sweep, Sweep)
    assert sweep.__module__ == "studies.sweeps"


def test_the_parts_of_the_time_add_up(driven, record):
    for each in (driven, record):
        parts = {key: value for key, value in each.seconds.items() if key != "total"}
        assert min(parts.values()) >= 0
        assert math.fsum(parts.values()) == pytest.approx(each.seconds["total"], rel=1e-9)


def blas_threads():
    return {each["num_threads"] for each in threadpoolctl.threadpool_info() if each["user_api"] == "blas"}


def test_the_tests_have_one_blas_thread():
    """More of them wait for each other: 200 s instead of 10 for `test_cut_source.py` on a busy machine."""
    import scipy.linalg  # noqa: F401

    assert blas_threads() == {int(os.environ["OPENBLAS_NUM_THREADS"])}


def test_a_run_has_one_blas_thread_and_restores_what_was(contact):
    import scipy.linalg  # noqa: F401

    seen = []
    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        before = blas_threads()
        run(contact, progress=lambda text: seen.append(blas_threads()))
        assert blas_threads() == before == {2}
    assert seen
    assert all(each == {1} for each in seen)


def test_two_runs_in_two_threads_leave_the_number_of_threads_as_it_was():
    import scipy.linalg  # noqa: F401

    from fem import blas_on_one_thread

    inside, seen = [threading.Event(), threading.Event()], []

    def second():
        with blas_on_one_thread():
            inside[1].set()
            inside[0].wait(10)  # the first has left
            seen.append(blas_threads())

    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        other = threading.Thread(target=second)
        with blas_on_one_thread():
            other.start()
            inside[1].wait(10)
        seen.append(blas_threads())
        inside[0].set()
        other.join()
        assert seen == [{1}, {1}]
        assert blas_threads() == {2}


def test_a_thread_that_ran_and_lives_on_leaves_the_number_of_threads_to_the_user():
    import scipy.linalg  # noqa: F401

    from fem import blas_on_one_thread

    ran, end = threading.Event(), threading.Event()

    def run_once():
        with blas_on_one_thread():
            pass
        ran.set()
        end.wait(10)

    thread = threading.Thread(target=run_once)
    thread.start()
    ran.wait(10)
    with threadpoolctl.threadpool_limits(limits=2, user_api="blas"):
        assert blas_threads() == {2}
    end.set()
    thread.join()


def test_a_record_as_a_dataset_has_units_on_variables_and_coordinate(driven, record):
    for each, level, unit in ((driven, "voltage_V", "V"), (record, "normal_amplitude_m", "m")):
        data = each.to_xarray()
        surface = {"x_m": each.surface["x_m"].size} if each.surface else {}
        assert dict(data.sizes) == {level: len(each.points)} | surface
        assert data[level].attrs == {"units": unit, "long_name": quantity(level).label}
        assert data["velocity_m_per_s"].attrs["units"] == "m/s"
        assert data["relative_error"].attrs["units"] == "1"
        assert data["contact_per_cycle"].attrs == {"units": "1"}
        assert "units" not in data["status"].attrs
        assert np.array_equal(data["velocity_m_per_s"], each.velocity)
        assert data.attrs["tolerance"] == each.tolerance


def test_every_public_name_is_imported_from_studies_and_no_module_hides_it():
    import studies

    assert sorted(studies.__all__) == studies.__all__
    for name in studies.__all__:
        assert callable(getattr(studies, name)), name
    for name in ("run", "sweep", "fit", "design", "datasheet", "network"):
        assert type(getattr(studies, name)).__name__ == "function", name


def test_a_network_of_a_scene_is_scikit_rf_s(small):
    skrf = pytest.importorskip("skrf")
    found = network(small, [2.15e6, 2.2e6, 2.25e6], z0=75.0, tolerance=0.1)
    assert isinstance(found, skrf.Network)
    names = [each.name for each in small.transducer]
    assert found.port_names == names
    assert found.f.tolist() == [2.15e6, 2.2e6, 2.25e6]
    assert found.z0[0].tolist() == [75.0] * len(names)
    assert found.is_passive()
    record = run(small.replace(drive={"voltage": 1.0}), tolerance=0.02)
    assert found.y[1, 0, 0] == pytest.approx(complex(record.electrical["admittance_S"]), rel=0.1)


def test_a_sweep_shows_itself(contact):
    over = {"slider.preload": [1e-3, 2e-3], "wave.normal_amplitude": [3e-9, 6e-9, 9e-9]}
    grid = sweep(contact, over)
    low, high = grid.summary["ranges"]["velocity_m_per_s"]
    assert repr(grid) == (
        f"Sweep(slider.preload (2) x wave.normal_amplitude (3); 6 ok; "
        f"velocity {1e3 * low:.5g} to {1e3 * high:.5g} mm/s)"
    )
