#!/usr/bin/env bash
# pyvista 0.49.1 (vtk 9.7.2): a complex wave field as a point array.
# Guess:     an array that is complex after `save` and `read`, `copy` and `extract_cells` is so after every filter.
# Behaviour: filters that compute new values (sampling along a line, points to cells) return a real array of two columns,
#            without a warning: `abs` of it is no amplitude any more.
# Output seen: read complex128 (6,); extract_cells complex128; sample_over_line float64 (5, 2); point_data_to_cell_data
#            float64 (2, 2)
# Source:    pyvista, DataSetAttributes (complex arrays are kept by name beside VTK, which knows no complex numbers).
# Here:      field.vtu and the pictures hold real and imaginary parts, amplitude and phase as arrays of their own.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet pyvista==0.49.1 vtk==9.7.2
cd "$folder" && v/bin/python - <<'PYTHON'
import numpy as np
import pyvista

image = pyvista.ImageData(dimensions=(3, 2, 1))
image["u"] = np.arange(6) * (1 + 2j)
grid = image.cast_to_unstructured_grid()
grid.save("field.vtu")
seen = {
    "read": pyvista.read("field.vtu")["u"],
    "extract_cells": grid.extract_cells([0])["u"],
    "sample_over_line": image.sample_over_line((0, 0, 0), (2, 0, 0), resolution=4)["u"],
    "point_data_to_cell_data": grid.point_data_to_cell_data()["u"],
}
print({name: (str(array.dtype), array.shape) for name, array in seen.items()})
assert seen["read"].dtype == seen["extract_cells"].dtype == np.complex128
assert seen["sample_over_line"].dtype == seen["point_data_to_cell_data"].dtype == np.float64
assert seen["sample_over_line"].shape == (5, 2)
PYTHON
