"""A new field of a transducer, with its rule, unit and key, is a change of two files of the product.

The patch beside this test declares the field in the class of `fem` and names it as a key in the scene's block. Nothing
else is changed in the copy: reading, units, refusals, the JSON Schema and the object of `fem` follow.
"""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
PATCH = Path(__file__).with_name("new_transducer_field.patch")
ASK = """
import json
from studies import Scene, SceneError
from studies.model.model import Model
from studies.scene.reference import schema
left, right = Model(Scene.load("rayleigh-of-two")).transducers
try:
    Scene.load("refused")
except SceneError as error:
    refusal = str(error)
key = schema()["properties"]["transducer"]["items"]["properties"]["finger_height"]
print(json.dumps([left.finger_height, right.finger_height, refusal, key["description"]]))
"""


@pytest.fixture(scope="module")
def patched(tmp_path_factory):
    """A copy of the packages with the patch applied."""
    root = tmp_path_factory.mktemp("patched")
    for name in ("fem", "contact", "studies"):
        shutil.copytree(ROOT / name, root / name, ignore=shutil.ignore_patterns("__pycache__", "evidence", "pictures"))
    subprocess.run(["git", "apply", "-C1", str(PATCH)], cwd=root, check=True)
    return root


def test_it_touches_two_files():
    files = re.findall(r"^\+\+\+ b/(\S+)", PATCH.read_text(), re.MULTILINE)
    assert sorted(files) == ["fem/geometry.py", "studies/scene/stator_keys.py"]


def test_the_field_is_read_checked_and_passed_on(patched):
    text = (ROOT / "studies" / "scenes" / "twente.toml").read_text().replace('"half-space"', '"1 mm"')
    first = text.index("[[transducer]]\n") + len("[[transducer]]\n")
    for name, value in (("rayleigh-of-two", "80 nm"), ("refused", "-80 nm")):
        scene = f'{text[:first]}finger_height = "{value}"\n{text[first:]}'
        (patched / "studies" / "scenes" / f"{name}.toml").write_text(scene)
    environment = os.environ | {"PYTHONPATH": str(patched)}
    done = subprocess.run(
        [sys.executable, "-c", ASK], cwd=patched, env=environment, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    left, right, refusal, description = json.loads(done.stdout)
    assert (left, right) == (80e-9, 0.0)
    line = text[:first].count("\n") + 1
    assert refusal.endswith(
        f"refused.toml, line {line}: transducer.0.finger_height must be zero or positive, got -8e-08 m"
    )
    assert description.startswith("Height of the fingers. Allowed: a length in m, zero or positive")
