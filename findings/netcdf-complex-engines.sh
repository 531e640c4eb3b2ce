#!/usr/bin/env bash
# xarray 2026.9.0 with netCDF4 1.7.5.1.post1 and h5netcdf 1.8.2: complex amplitudes of a wave field in a netCDF file.
# Guess:     what `to_netcdf(engine="netcdf4", auto_complex=True)` writes opens as complex again with the same engine.
# Behaviour: the reader needs `auto_complex=True` too. Without it the variable comes back without an error as a structured
#            array of pairs (r, i) with the shape of the complex one. The engine h5netcdf opens the same file as complex.
# Output seen: netcdf4 [('r', '<f8'), ('i', '<f8')]; netcdf4 with auto_complex complex128; h5netcdf complex128
# Source:    netCDF4-python, Dataset(auto_complex=...); xarray, "Reading and writing files", complex numbers.
# Here:      complex columns are kept as two real ones, so that each engine opens them alike.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet xarray==2026.9.0 netCDF4==1.7.5.1.post1 h5netcdf==1.8.2 h5py==3.16.0
cd "$folder" && v/bin/python -W ignore - <<'PYTHON'
import numpy as np
import xarray

field = xarray.Dataset({"u": ("x", np.array([1 + 2j, 3 - 1j]))})
field.to_netcdf("field.nc", engine="netcdf4", auto_complex=True)
seen = {}
for name, engine, options in (
    ("netcdf4", "netcdf4", {}),
    ("netcdf4, auto_complex", "netcdf4", {"auto_complex": True}),
    ("h5netcdf", "h5netcdf", {}),
):
    with xarray.open_dataset("field.nc", engine=engine, **options) as file:
        seen[name] = file.u.load().dtype
print(seen)
assert seen["netcdf4"].names == ("r", "i")
assert seen["netcdf4, auto_complex"] == seen["h5netcdf"] == np.complex128
PYTHON
