"""netCDF files of runs and sweeps: read by scipy alone, and opened again by xarray."""

import csv
import sys

import numpy as np
import pytest
from scipy.io import netcdf_file

import studies
from studies.__main__ import main

xarray = pytest.importorskip("xarray")
CONTACT = "twente-contact"


def test_file_of_a_run_holds_its_tables(tmp_path):
    assert main(["run", CONTACT, "--no-plot", "--netcdf", "--out", str(tmp_path)]) == 0
    with (tmp_path / "velocity.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    with netcdf_file(tmp_path / "run.nc", mmap=False) as file:  # not the library that wrote it
        velocity, level = file.variables["velocity_m_per_s"], file.variables["normal_amplitude_m"]
        np.testing.assert_array_equal(velocity[:], [float(row["velocity_m_per_s"]) for row in rows])
        np.testing.assert_array_equal(level[:], [float(row["normal_amplitude_m"]) for row in rows])
        assert (velocity.units, level.units, velocity.dimensions) == (b"m/s", b"m", ("normal_amplitude_m",))
        scene = file.scene.decode()
    with xarray.open_dataset(tmp_path / "run.nc", engine="scipy") as data:
        assert data.regime.values.tolist() == [row["regime"] for row in rows]
    (tmp_path / "again.toml").write_text(scene)
    assert studies.Scene.load(tmp_path / "again.toml") == studies.Scene.load(tmp_path / "scene.toml")


def test_surface_of_a_free_wave_lies_over_its_place(tmp_path):
    record = studies.run("rayleigh")
    data = record.to_xarray()
    assert not data.sizes or "x_m" not in data.sizes  # its profile is over the depth
    driven = studies.Record(
        scene=record.scene, tolerance=1e-3, surface={"x_m": np.arange(3.0), "u_z_m_per_V": np.array([1j, 2, 3 - 1j])}
    ).to_xarray()
    np.testing.assert_array_equal(driven.u_z_m_per_V_im.sel(x_m=[0.0, 2.0]), [1.0, -1.0])
    assert driven.x_m.attrs["units"] == "m"


def test_file_of_a_sweep_has_an_axis_for_each_key(tmp_path):
    words = ["sweep", CONTACT, "--over", "slider.preload=1 mN:3 mN:2", "--netcdf", "--out", str(tmp_path / "sweep")]
    assert main(words) == 0
    with xarray.open_dataset(tmp_path / "sweep" / "points.nc") as data:
        assert data["velocity_m_per_s"].sizes["slider.preload"] == 2
        assert data["slider.preload"].attrs["units"] == "N"
        expected = studies.sweep(CONTACT, {"slider.preload": "1 mN:3 mN:2"}).to_xarray()
        xarray.testing.assert_equal(data.load(), expected)
    assert main(words) == 0  # the store goes on beside the file


def test_missing_package_is_named_before_anything_is_computed(monkeypatch, capsys, tmp_path):
    monkeypatch.setitem(sys.modules, "xarray", None)
    assert main(["run", CONTACT, "--netcdf", "--out", str(tmp_path / "run")]) == 3
    assert "--netcdf needs xarray, which is not installed: pip install xarray" in capsys.readouterr().err
    assert not (tmp_path / "run").exists()
    monkeypatch.undo()
    assert main(["run", CONTACT, "--netcdf", "--json"]) == 2
    assert "--netcdf needs a directory to go to: give --out, or leave --json out" in capsys.readouterr().err
