"""The contact against event solvers off the shelf and the paper's scheme, on the seed's slider."""

import math

import pytest

from tests.benchmarks.contact_peers import NAIVE, SCIPY, WRONG, quickest, rows_of


@pytest.mark.slow  # tests/contact compares with tests/oracles/contact_steps.py by default
def test_an_event_solver_held_to_small_steps_agrees_and_the_paper_s_scheme_does_not():
    # Oracle: an event solver held to a twentieth of a cycle computes the same motion independently
    found = rows_of(10e-9, cycles=6, chosen=("DOP853",), tolerances=(1e-9,))
    rows = {(row["curve"], row["setting"]): row for row in found}
    assert rows["exact", "12 nodes, 1e-09"]["error"] < 1e-9
    assert rows["stepped", "256 steps"]["error"] < 1e-5
    assert rows["fixed steps with DV", "5000 steps"]["silent"]
    assert rows["solve_ivp DOP853, held steps", "rtol 1e-09"]["error"] < 1e-4


@pytest.mark.slow
def test_what_chooses_its_steps_freely_misses_contacts_and_says_nothing():
    rows = rows_of(10e-9, chosen=SCIPY, tolerances=(1e-6, 1e-9))
    assert min(row["error"] for row in rows if row["curve"] == "exact") < 1e-9
    fixed = [row for row in rows if row["curve"].startswith("fixed")]
    assert min(row["error"] for row in fixed if row["setting"].startswith(str(NAIVE[-1]))) > WRONG
    free = [row for row in rows if "solve_ivp" in row["curve"] and "held" not in row["curve"]]
    assert any(row["silent"] for row in free)
    assert not any(row["silent"] for row in rows if "held" in row["curve"])
    assert math.isfinite(quickest(rows, 1e-5, ours=True))
