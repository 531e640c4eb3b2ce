#!/usr/bin/env bash
# pint 0.25.3: the speed of a rotary motor, in revolutions per minute.
# Guess:     60 rpm are 1 Hz.
# Behaviour: a revolution is 2 pi rad and a radian is the number 1, while Hz is 1/s: 60 rpm are 6.283 Hz, and 1 Hz is
#            1 rad/s. Both conversions pass the check of dimensions.
# Output seen: 60 rpm = 6.283185307179586 Hz; 1 Hz = 1.0 rad/s
# Source:    pint's registry, default_en.txt: revolution = 2 pi radian, rpm, hertz = 1 / second.
# Here:      frequencies and rates of turning are different kinds of keys; a unit of the other kind is refused.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet pint==0.25.3
cd "$folder" && v/bin/python - <<'PYTHON'
import math

import pint

unit = pint.UnitRegistry()
turns, rate = unit("60 rpm").to("Hz").magnitude, unit("1 Hz").to("rad/s").magnitude
print(turns, rate)
assert math.isclose(turns, 2 * math.pi)
assert rate == 1.0
PYTHON
