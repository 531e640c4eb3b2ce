"""Scenes that nobody would write: an answer or one sentence, never a traceback, a NaN or no end.

Property (hypothesis): whatever stands in the file and behind ``--set``, `check` and `run` end with exit code 0 and an
answer, or with 1 or 2 and one sentence.  Warnings are errors here, so that an overflow is seen where it happens.
"""

import json
import os
import re
import select
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from hypothesis import HealthCheck, Phase, given, seed, settings

from studies.__main__ import main
from studies.refusal import MAX_PROBLEMS
from studies.report.explanation import TIME_WITHIN, plan
from studies.scene import Scene
from tests.studies.scene_mutations import SMALL, Mutant, bases, document, extreme_tables, mutants, stress_bases

pytestmark = pytest.mark.filterwarnings("ignore:Generating overly large repr")
QUIET = {"deadline": None, "database": None, "suppress_health_check": list(HealthCheck), "phases": [Phase.generate]}
SECONDS = 30.0  # of processor time, the longest that an answer or a refusal may take unless it was predicted
WAIT = 240.0  # s on the clock, of a machine that others use too; before it no progress is shown beside a refusal
RUNS = f"""
import contextlib, io, json, resource, sys, time, traceback, warnings
from pathlib import Path
from studies import progress
from studies.__main__ import main
progress.PATIENCE = {WAIT}
warnings.simplefilter("error")
resource.setrlimit(resource.RLIMIT_AS, (6 << 30, 6 << 30))
stdin, stdout, path = sys.stdin, sys.stdout, sys.argv[1]
for line in stdin:
    Path(path).write_text(json.loads(line))
    out, err, begun, status, trace = io.StringIO(), io.StringIO(), time.process_time(), None, ""
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            status = main(["run", path, "--json"])
    except BaseException:
        trace = traceback.format_exc()
    found = [status, out.getvalue(), err.getvalue(), trace, time.process_time() - begun]
    print(json.dumps(found), file=stdout, flush=True)
"""


def sound(status: int, out: str, err: str) -> None:
    """Assert what every call promises."""
    assert status in (0, 1, 2, 3)
    said = err.splitlines()
    if status:
        assert all(line.startswith("sawmotor: ") for line in said if status == 2 or line is said[-1]), err
        assert "a defect of sawmotor" not in err
        assert len(said[-1]) < 600
    if status == 2:
        assert out == ""
        assert 1 <= len(said) <= MAX_PROBLEMS + 1, err
    if status == 0:
        assert not re.search(r"\b(nan|inf|infinity)\b", out, re.IGNORECASE)


@pytest.fixture
def checked(tmp_path, capsys, monkeypatch):
    """Check a mutant with the command; a defect is raised with its traceback."""
    monkeypatch.setenv("SAWMOTOR_TRACEBACK", "1")
    monkeypatch.setattr("studies.progress.PATIENCE", WAIT)

    def checked(mutant: Mutant) -> None:
        path = tmp_path / "scene.toml"
        path.write_bytes(mutant.content)
        status = main(["check", str(path), *mutant.words])
        said = capsys.readouterr()
        sound(status, said.out, said.err)

    return checked


@seed(1)
@settings(max_examples=8, **QUIET)
@given(mutant=mutants())
def test_a_few_spoilt_scenes_are_refused_in_a_sentence(checked, mutant):
    checked(mutant)


@seed(2)
@settings(max_examples=8, **QUIET)
@given(table=extreme_tables(bases()))
def test_a_few_extreme_scenes_are_checked(checked, table):
    checked(Mutant(document(table)))


@pytest.mark.slow
@seed(3)
@settings(max_examples=2500, **QUIET)
@given(mutant=mutants())
def test_thousands_of_spoilt_scenes_are_refused_in_a_sentence(checked, mutant):
    checked(mutant)


@pytest.mark.slow
@seed(4)
@settings(max_examples=2000, **QUIET)
@given(table=extreme_tables(bases()))
def test_thousands_of_extreme_scenes_are_checked(checked, table):
    checked(Mutant(document(table)))


class Runner:
    """A process that runs one scene after the other; it is started anew when a run does not end."""

    def __init__(self, folder: Path):
        self._path, self._process = folder / "scene.toml", None

    def run(self, text: str) -> list:
        """Status, stdout, stderr, traceback and seconds of a run."""
        if self._process is None:
            self._process = subprocess.Popen(
                [sys.executable, "-c", RUNS, str(self._path)],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                text=True,
                cwd=Path(__file__).parents[2],
                env=os.environ | {"SAWMOTOR_TRACEBACK": "1", "OPENBLAS_NUM_THREADS": "1"},
            )
        self._process.stdin.write(json.dumps(text) + "\n")
        self._process.stdin.flush()
        ready, _, _ = select.select([self._process.stdout], [], [], WAIT)
        line = self._process.stdout.readline() if ready else ""
        if not line:
            self.close()
            pytest.fail(f"{'no end' if not ready else 'the process died'}: {text}")
        return json.loads(line)

    def close(self) -> None:
        """End the process."""
        if self._process is not None:
            self._process.kill()
            self._process.communicate()
            self._process = None


def predicted(text: str) -> float:
    """Seconds that ``--explain`` gives for a scene."""
    return plan(Scene.from_table("", tomllib.loads(text)), tolerance=1e-3)["expected"]["seconds"]


@pytest.fixture
def runner(tmp_path):
    """Runner of scenes, ended with the test."""
    one = Runner(tmp_path)
    yield one
    one.close()


@pytest.mark.slow
@seed(5)
@settings(max_examples=600, **QUIET)
@given(table=extreme_tables([*SMALL, *stress_bases()]))
def test_hundreds_of_extreme_small_scenes_run_to_an_answer_or_a_sentence(runner, table):
    text = document(table).decode()
    status, out, err, trace, seconds = runner.run(text)
    assert not trace, f"{text}\n{trace}"
    sound(status, out, err)
    assert seconds < SECONDS or seconds < TIME_WITHIN * predicted(text), text
    if out:
        json.loads(out, parse_constant=lambda name: pytest.fail(f"{name} in the answer to {text}"))
