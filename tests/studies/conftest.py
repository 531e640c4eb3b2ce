"""Fixtures that the tests of studies share."""

import contextlib
import io
import json
from dataclasses import dataclass
from functools import cache
from inspect import signature
from pathlib import Path

import pytest

import fem
from studies.__main__ import main
from studies.scene import Scene
from studies.study_list import module
from tests.studies.solved_once import solved_once

SMALL = Path(__file__).parent / "scenes" / "small.toml"  # a whole motor whose stator costs a second


@pytest.fixture(autouse=True, scope="session")
def _fields_are_solved_once():
    """Let tests that ask for the same field share its solution."""
    from studies.solve import stators

    with pytest.MonkeyPatch.context() as patch:
        for name in ("driven_wave", "frequency_band", "port_admittance"):
            patch.setattr(fem, name, solved_once(getattr(fem, name)), raising=False)
        patch.setattr(stators, "ring_up", solved_once(stators.ring_up))
        yield


@dataclass(frozen=True)
class Studied:
    """A study that was run through its command: exit code, stdout, stderr and directory."""

    status: int
    out: str
    err: str
    folder: Path

    @property
    def record(self) -> dict:
        """What study.json holds."""
        return json.loads((self.folder / "study.json").read_text(encoding="utf-8"))


@pytest.fixture(scope="session")
def small():
    """Give the scene of the small motor."""
    return Scene.load(SMALL)


@pytest.fixture(scope="session")
def small_run(small):
    """Give the record of a burst of the small motor."""
    from studies.runs import run

    return run(small.replace(drive={"burst": "0.05 ms"}), tolerance=1e-2)


@pytest.fixture(scope="session")
def studied(tmp_path_factory):
    """Give a function that runs the small version of a study through its command, once in a session."""

    @cache
    def run(name: str) -> Studied:
        folder = tmp_path_factory.mktemp("studies") / name
        takes_scene = "scene" in signature(module(name).run).parameters
        # a stator for each of the numbers of a sensitivity, and its band for a position loop, are slow
        others = dict.fromkeys(("sensitivity", "positioning"), "twente-contact")
        others |= {"reflector": "reflector"}  # needs a piece
        others |= {"trajectory": "twente-planar"}  # follows the plane
        scene = others.get(name, str(SMALL))
        words = ["study", name, *([scene] if takes_scene else []), "--quick", "--out", str(folder)]
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(words)
        return Studied(status, out.getvalue(), err.getvalue(), folder)

    return run
