"""What a point of a run says about its own motion."""

import csv
import json

import contact
from studies.record.files import write_run
from studies.runs import run
from studies.scene import Scene
from studies.solve.event_counts import EVENTS, burst_events, steady_events
from tests.contact.motors import orbit, slider


def test_a_steady_point_counts_a_cycle():
    parted = steady_events(contact.steady(slider(), orbit(10e-9), tolerance=1e-3))
    assert (parted["contact_per_cycle"], parted["release_per_cycle"]) == (1.0, 1.0)
    assert parted["ledger_relative_residual"] < 1e-8
    assert 0.0 < parted["smallest_gap_s"] < 1.0 / 2.2e6
    assert parted["chatter"] is False
    assert "period_cycles" not in parted


def test_a_hop_in_two_cycles_is_half_a_contact_per_cycle():
    found = steady_events(contact.steady(slider(), orbit(3e-9, frequency=12e3), tolerance=1e-3))
    assert found["period_cycles"] == 2
    assert found["contact_per_cycle"] == 0.5


def test_where_the_wave_does_no_work_there_is_no_residual_to_state():
    held = steady_events(contact.steady(slider(), orbit(0.5e-9), tolerance=1e-3))
    assert "ledger_relative_residual" not in held
    assert steady_events(contact.steady(slider(), orbit(0.0), tolerance=1e-3)) == {}


def test_a_burst_counts_what_was_followed():
    asked = {"duration": 5e-5, "after": 1e-3, "tolerance": 1e-3, "samples": 9}
    exact = burst_events(contact.burst(slider(), orbit(10e-9), method="exact", **asked))
    assert {f"burst_{name}" for name in EVENTS} <= set(exact)
    assert exact["burst_contact"] > 0
    assert max(exact["burst_ledger_relative_residual"], exact["after_ledger_relative_residual"]) < 1e-8
    stepped = burst_events(contact.burst(slider(), orbit(10e-9), method="stepped", **asked))
    assert stepped["burst_method"] == "stepped"
    assert "burst_contact" not in stepped
    assert "burst_ledger_relative_residual" not in stepped
    assert stepped["after_reversal"] > 0


def test_run_and_table_carry_the_tally(tmp_path):
    scene = Scene.load("twente-contact")
    record = run(scene, tolerance=1e-3)
    write_run(record, tmp_path, field=False)
    point = json.loads((tmp_path / "run.json").read_text())["points"][-1]
    assert point["contact_per_cycle"] == 1.0
    assert point["ledger_relative_residual"] < 1e-8
    with (tmp_path / "velocity.csv").open() as file:
        row = list(csv.DictReader(file))[-1]
    assert row["chatter"] == "False"
    assert float(row["smallest_gap_s"]) == point["smallest_gap_s"]
