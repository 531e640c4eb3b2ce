#!/usr/bin/env bash
# KLayout (Python package klayout 0.30.12) reads a mask from DXF (written by ezdxf 1.4.5).
# Guess:     the drawing's unit, header variable $INSUNITS (13 = um, 4 = mm, 6 = m), scales the shapes.
# Behaviour: the header is not looked at. A finger of 1 mm by 20 mm becomes one of 1 um by 20 um; the reader's own option
#            `LoadLayoutOptions.dxf_unit` (1 um where it is not set) is the only scale.
# Output seen: $INSUNITS 13, 4, 6 -> (0,0;1,20) each; with dxf_unit = 1000 -> (0,0;1000,20000)
# Source:    KLayout, class LoadLayoutOptions, dxf_unit: "unit in which the DXF file is drawn, default 1 micrometre".
# Here:      DXF masks of `sawmotor export` are drawn in um, so that both readings agree.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet klayout==0.30.12 ezdxf==1.4.5
cd "$folder" && v/bin/python - <<'PYTHON'
import ezdxf
import klayout.db as db


def read(path, unit=None):
    options = db.LoadLayoutOptions()
    if unit:
        options.dxf_unit = unit
    layout = db.Layout()
    layout.read(path, options)
    return str(layout.top_cell().dbbox())


seen = []
for code in (13, 4, 6):
    drawing = ezdxf.new("R2010")
    drawing.header["$INSUNITS"] = code
    drawing.modelspace().add_lwpolyline([(0, 0), (1, 0), (1, 20), (0, 20)], close=True)
    drawing.saveas("finger.dxf")
    seen.append(read("finger.dxf"))
scaled = read("finger.dxf", 1000.0)
print(seen, scaled)
assert seen == ["(0,0;1,20)"] * 3
assert scaled == "(0,0;1000,20000)"
PYTHON
