#!/usr/bin/env bash
# pdoc 16.0.0 (and 15.0.4): a package whose `__getattr__` imports its public names on first use (PEP 562).
# Guess:     a name of `__all__` that `getattr` gives is documented.
# Behaviour: pdoc looks into the module's namespace alone: the page has the name as an empty heading, and pdoc exits with 0.
#            A warning calls the name a module that cannot be imported. With the name in the namespace it is documented.
# Output seen: 16.0.0: exit code 0, documented False, documented once it has been imported True (15.0.4: the same)
# Source:    pdoc, doc.py, Module._member_objects ("this may be an unimported submodule"); PEP 562, "Rationale".
# Here:      `python -m studies.website.api_reference` imports all public names before pdoc looks.
set -euo pipefail
folder=$(mktemp -d); trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/v"
mkdir "$folder/waves"
cat > "$folder/waves/velocity.py" <<'PYTHON'
def rayleigh(shear):
    """Estimate the velocity of a surface wave from that of the shear wave."""
    return 0.92 * shear
PYTHON
cat > "$folder/waves/__init__.py" <<'PYTHON'
"""Waves."""

from importlib import import_module

__all__ = ["rayleigh"]


def __getattr__(name):
    if name not in __all__:
        raise AttributeError(name)
    return getattr(import_module("waves.velocity"), name)
PYTHON
cd "$folder"
for version in 15.0.4 16.0.0; do
    v/bin/pip install --quiet pdoc==$version
    PYTHONPATH=. v/bin/python -W ignore - <<'PYTHON'
import subprocess
import sys
from importlib.metadata import version

import pdoc

done = subprocess.run([sys.executable, "-W", "ignore", "-m", "pdoc", "-o", "out", "waves"], capture_output=True)
alone = "Estimate the velocity" in open("out/waves.html").read()
import waves

assert waves.rayleigh(1.0) == 0.92  # the name is there
waves.rayleigh = waves.rayleigh
page = pdoc.pdoc("waves")
print(
    f"{version('pdoc')}: exit code {done.returncode}, documented {alone}, "
    f"documented once it has been imported {'Estimate the velocity' in page}"
)
assert done.returncode == 0
assert not alone
assert 'id="rayleigh"' in open("out/waves.html").read()
PYTHON
done
