#!/usr/bin/env bash
# AFMReader 0.0.7 reads a channel of a Gwyddion file (.gwy, written by gwyfile 0.3.0) as an image "in nm".
# Guess:     the unit of z that the file holds is used: heights in nm stay, and a channel in V or deg is refused.
# Behaviour: every channel is multiplied by 1e9, whatever its unit; a phase of 1 deg becomes 1e9, a height of 1 nm 1e9 "nm".
#            One pixel size is returned for both axes; where x and y differ it is that of x over the number of rows.
# Output seen: factors m 1e9, nm 1e9, V 1e9, deg 1e9; 8 by 8 pixels on 5 by 2.5 um: 625.0
# Source:    AFMReader/gwy.py, load_gwy; Gwyddion's file format, GwyDataField, si_unit_z.
# Here:      a rough surface is read with gwyfile; the unit of z must be a length, and both pixel sizes are kept.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet AFMReader==0.0.7 gwyfile==0.3.0
cd "$folder" && v/bin/python - <<'PYTHON' 2> /dev/null
import numpy as np
from AFMReader import gwy
from gwyfile.objects import GwyContainer, GwyDataField

z = np.random.default_rng(1).normal(size=(8, 8))


def load(unit, height=5e-6):
    file = GwyContainer()
    file["/0/data"] = GwyDataField(z.copy(), xreal=5e-6, yreal=height, si_unit_xy="m", si_unit_z=unit)
    file["/0/data/title"] = "Height"
    file.tofile("patch.gwy")
    return gwy.load_gwy("patch.gwy", "Height")


factors = {unit: round(float(np.std(load(unit)[0]) / np.std(z)), 3) for unit in ("m", "nm", "V", "deg")}
pixel = load("m", 2.5e-6)[1]
print(factors, pixel)
assert factors == {"m": 1e9, "nm": 1e9, "V": 1e9, "deg": 1e9}
assert abs(pixel - 625.0) < 1e-9
PYTHON
