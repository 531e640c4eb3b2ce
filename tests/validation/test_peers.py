"""Contenders of the stator: each gives the small stator's answer; the benchmarks print what they find."""

import math
import os

import numpy as np
import pytest

from studies.refusal import RunError
from tests.studies.motors import small_problem, truth
from tests.validation import attempt, contenders
from tests.validation import ngsolve_stator as peer
from tests.validation.attempt import Attempt, attempted
from tests.validation.contenders import CURVES
from tests.validation.stator_reference import seconds_at

THIN = 0.35e-3  # m: a plate without backward waves, which matched layers would amplify


def point(seconds: float, error: float) -> Attempt:
    return Attempt(
        curve="band",
        setting="",
        unknowns=1,
        setup_seconds=0.0,
        seconds=seconds,
        peak_bytes=1,
        admittance=1.0 + 0j,
        motion=np.array([1.0, 1.0 + error]),
    )


def errors(curve: str, posed, **setting) -> tuple[float, float]:
    admittance, motion, _ = CURVES[curve][0](posed, **setting)()
    true_admittance, true_motion = truth(posed.stator.thickness)
    return abs(admittance / true_admittance - 1), abs(motion[1] / true_motion[1] - 1)


def test_time_at_an_error_lies_on_the_power_between_the_points():
    exact = (1.0, (1.0, 1.0))
    points = [point(4.0, 1e-4), point(1.0, 1e-2)]
    assert seconds_at(points, exact, 1e-3) == pytest.approx(2.0, rel=1e-9)
    assert seconds_at(points, exact, 1e-1) == 1.0
    assert math.isnan(seconds_at(points, exact, 1e-5))


@pytest.mark.slow
def test_the_direct_contender_agrees():
    found = errors("high order, edge layers", small_problem(thickness=THIN), order=5, edge_layers=1)
    assert max(found) < 2e-2


@pytest.mark.parametrize("condense", [pytest.param(False, marks=pytest.mark.slow), True])
def test_the_peer_agrees(condense):
    pytest.importorskip("ngsolve", reason="NGSolve is the optional extra `peers`")
    posed = small_problem(thickness=THIN)
    found = errors("NGSolve", posed, order=6, edge_layers=2, element_size=0.5, absorber=6.0, condense=condense)
    assert max(found) < 2e-3


def test_the_peer_solves_again_at_another_frequency():
    pytest.importorskip("ngsolve", reason="NGSolve is the optional extra `peers`")
    posed = small_problem("free")
    mesh = peer.PeerMesh(order=4, edge_layers=1, element_size=0.5)
    one, other = (peer.Peer(posed.stator, posed.transducers, wavelength=posed.wavelength, mesh=mesh) for _ in range(2))
    one.solve(2.1e6, driven="left", place=posed.place)
    again, fresh = (each.solve(2.2e6, driven="left", place=posed.place) for each in (one, other))
    assert again[0] == pytest.approx(fresh[0], rel=1e-9)
    assert again[1] == pytest.approx(fresh[1], rel=1e-9)


@pytest.mark.slow
def test_a_contender_runs_alone_on_one_thread():
    posed = small_problem()
    found = attempted("structured", posed, {"level": 1}, repeats=1)
    assert max(found.errors(truth())) < 2e-2
    assert found.seconds > 0
    assert found.peak_bytes > 3e7


def test_a_process_that_is_ended_is_a_sentence(monkeypatch):
    from concurrent.futures import ProcessPoolExecutor
    from concurrent.futures.process import BrokenProcessPool

    def ended(*given):
        raise BrokenProcessPool

    monkeypatch.setattr(ProcessPoolExecutor, "submit", ended)
    monkeypatch.setenv("OMP_NUM_THREADS", "2")
    with pytest.raises(RunError, match="structured, level 1: its process was ended"):
        attempted("structured", small_problem(), {"level": 1})
    assert os.environ["OMP_NUM_THREADS"] == "2"


@pytest.fixture
def tiny(monkeypatch):
    """The study on the small stator, in this process, with what needs no extra, and the peer said to be missing."""
    curves = {
        "NGSolve": (None, ({"order": 2},), ("no_such_package",)),
        "structured": (CURVES["structured"][0], ({"level": 0}, {"level": 1}), ()),
    }
    monkeypatch.setattr(contenders, "CURVES", curves)
    monkeypatch.setattr(attempt, "CURVES", curves)
    for module in _benchmarks():
        for name, value in (
            ("CURVES", curves),
            ("ENDS", ("absorbing",)),
            ("problem", small_problem),
            ("reference", lambda posed: truth(posed.stator.thickness)),
            ("attempted", lambda *given, repeats: attempt.measured(*given, repeats)),
        ):
            if hasattr(module, name):
                monkeypatch.setattr(module, name, value)


def _benchmarks():
    from tests.benchmarks import stator_peers, stator_table

    return stator_peers, stator_table


@pytest.mark.slow
def test_the_benchmarks_print_their_tables(tiny, capsys):
    peers, table = _benchmarks()
    peers.main(["--curves", "NGSolve", "structured"])
    assert "pip install no_such_package" in capsys.readouterr().out
    table.physics()
    table.row("what", 2.0, 1.0, "s")
    table.row("what", 2.0, 1.0, "times", least=True)
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 5
    assert all(line.endswith("| pass |") for line in lines[:2])
    assert [line.split()[-2] for line in lines[-2:]] == ["pass", "SHORT"]
