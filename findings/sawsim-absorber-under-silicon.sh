#!/usr/bin/env bash
# sawsim 2.0.2, model "sp_double_layer": a piezoelectric film on 8.33 um of silicon, over an absorbing layer.
# Guess:     the absorbing layer continues the silicon that lies above it.
# Behaviour: it has the constants of the piezoelectric film, so that bulk waves meet a step of impedance where the matched
#            layer begins. The model's notes say so, in Chinese.
# Output seen: layers ['si_isotropic'], material of the absorbing layer: sp_baseline
# Source:    sawsim/models.py, build_sp_family; sawsim/sp_specs.py, notes of the model.
# Here:      resonances of layered stators are compared with sawsim only where the wave is bound.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v" && "$folder/v/bin/pip" install --quiet sawsim==2.0.2
cd "$folder" && v/bin/python - <<'PYTHON'
from sawsim.config import SimulationConfig
from sawsim.models import build_sp_family

config = SimulationConfig(model_id="sp_double_layer")
details = build_sp_family(config).details
layers = [layer.material_id for layer in config.layers]
print(layers, details["pml_material_id"])
assert layers == ["si_isotropic"]
assert details["pml_material_id"] == "sp_baseline"
PYTHON
