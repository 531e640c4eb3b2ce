#!/usr/bin/env bash
# pyuff 2.5.8 writes spectra as binary Universal Files (58b), as vibrometer programs exchange them.
# Guess:     the head's number of bytes (field 7 of "58b") is that of the data that follow: 16 for a complex double.
# Behaviour: it is 8 times the number of points, whatever the kind of number. A reader that trusts it takes half of a
#            complex spectrum; pyuff itself reads up to the closing line.
# Output seen: 4 points, head of real and of complex doubles: 32 bytes each; the complex file is 32 bytes longer.
# Source:    pyuff/datasets/dataset_58.py; Universal File dataset 58b, "number of bytes following ASCII header".
# Here:      spectra are read to the closing line, and exported with the right number.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet pyuff==2.5.8
cd "$folder" && v/bin/python -W ignore - <<'PYTHON'
from pathlib import Path

import numpy as np
import pyuff

sizes, heads = {}, {}
for name, kind, data in (("real", 4, np.arange(4.0)), ("complex", 6, np.arange(4) * (1 + 1j))):
    spectrum = pyuff.prepare_58(
        binary=1, func_type=4, rsp_node=1, rsp_dir=3, ref_node=1, ref_dir=3, data=data, x=np.arange(4.0), id1="spectrum",
        rsp_ent_name="slider", ref_ent_name="slider", abscissa_spec_data_type=18, ordinate_spec_data_type=12,
        orddenom_spec_data_type=13,
    )
    spectrum["ord_data_type"] = kind
    pyuff.UFF(f"{name}.uff").write_sets(spectrum, "add")
    raw = Path(f"{name}.uff").read_bytes()
    sizes[name], heads[name] = len(raw), int(raw.split(b"\n")[1].split()[4])
print(heads, sizes["complex"] - sizes["real"])
assert heads == {"real": 32, "complex": 32}
assert sizes["complex"] - sizes["real"] == 32
PYTHON
