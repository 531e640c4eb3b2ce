#!/usr/bin/env bash
# tamaas 2.9.0: contact of a sphere by PolonskyKeerRey under a prescribed load, with the non-periodic operator "dcfft".
# Guess:     `model.displacement` is the elastic displacement of the half-space, a^2/R under the centre (Hertz).
# Behaviour: the solver adds a constant, so that the least gap is 0: the displacement under the centre of the sphere is 0.
#            The approach is lost; it comes back by applying the operator to `model.traction`.
# Output seen: displacement at the centre 7e-12 of a^2/R; operator applied to the traction 0.99988; they differ by a constant
#            to 4e-15.
# Source:    Johnson, Contact Mechanics (1985), eq. 4.23; tamaas, class PolonskyKeerRey.
# Here:      approaches of rough contacts are compared by the operator, not by `model.displacement`.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet tamaas==2.9.0
cd "$folder" && v/bin/python - <<'PYTHON'
import numpy as np
import tamaas as tm

tm.set_log_level(tm.LogLevel.error)
n, length, radius, load = 256, 1.0, 8.0, 1e-4
x = (np.arange(n) - n // 2) * length / n
surface = -(x[:, None] ** 2 + x**2) / (2 * radius)
model = tm.Model(tm.model_type.basic_2d, [length, length], [n, n])
model.E, model.nu = 1.0, 0.0
tm.ModelFactory.registerNonPeriodic(model, "dcfft")
solver = tm.PolonskyKeerRey(model, surface, 1e-12)
solver.setIntegralOperator("dcfft")
solver.solve(load / length**2)
approach = (3 * load * radius / 4) ** (2 / 3) / radius
elastic = np.zeros((n, n))
model.operators["dcfft"](model.traction, elastic)
centre = n // 2, n // 2
print(model.displacement[centre] / approach, elastic[centre] / approach, np.ptp(elastic - model.displacement) / approach)
assert abs(model.displacement[centre]) < 1e-6 * approach
assert abs(elastic[centre] / approach - 1) < 1e-3
assert np.ptp(elastic - model.displacement) < 1e-10 * approach
PYTHON
