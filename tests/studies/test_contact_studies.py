"""Studies of the contact: what they must find is found, and they draw."""

from matplotlib.figure import Figure

from studies.motor import load_line, regime_map, step_planner


def test_regime_map_lies_on_its_lines(monkeypatch):
    monkeypatch.setattr(regime_map, "AMPLITUDES", 15)
    monkeypatch.setattr(regime_map, "PRELOADS", 9)
    monkeypatch.setattr(regime_map, "CHECKED", 4)
    record = regime_map.run()
    assert [finding.confirmed for finding in record.findings] == [True, True]
    kinds = {kind for row in record.panels[0].data["kind"] for kind in row}
    assert kinds == set(regime_map.KINDS)
    ax = regime_map.figure(record.panels[0], Figure().add_subplot())
    assert "nm" in ax.get_xlabel()
    assert "mN" in ax.get_ylabel()


def test_load_line_stalls_and_is_below_one(monkeypatch):
    monkeypatch.setattr(load_line, "POINTS", 5)
    record = load_line.run()
    assert all(finding.confirmed for finding in record.findings)
    assert [panel.name for panel in record.panels] == ["load_line", "efficiency"]
    ax = load_line.figure(record.panels[0], Figure().add_subplot())
    assert len(ax.get_lines()) == 5


def test_steps_are_planned_and_grow_as_the_square_of_the_cycles(monkeypatch):
    monkeypatch.setattr(step_planner, "LINES", 1)
    monkeypatch.setattr(step_planner, "CYCLES", (64, 512, 1024, 2048))
    monkeypatch.setattr(step_planner, "WANTED", (2e-9, 2e-8))
    record = step_planner.run()
    assert [finding.confirmed for finding in record.findings] == [True, True, True]
    assert [panel.name for panel in record.panels] == ["step_planner", "stopping"]
    (plans,) = record.panels[0].data["planned_cycles"].values()
    assert plans == sorted(plans)
    ax = step_planner.figure(record.panels[0], Figure().add_subplot())
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
    assert len(ax.get_lines()) == 2


def test_error_against_time_names_who_failed_in_silence(monkeypatch):
    from studies.evidence import contact_error_vs_time as study

    monkeypatch.setattr(study, "CYCLES", 12)
    monkeypatch.setattr(study, "AMPLITUDES", (10e-9,))
    monkeypatch.setattr(study, "SCIPY", ("DOP853",))
    monkeypatch.setattr(study, "TOLERANCES", (1e-6, 1e-9))
    record = study.run()
    rows = {(row["curve"], row["setting"]): row for row in record.panels[0].data["rows"]}
    assert rows["exact", "12 nodes, 1e-09"]["error"] < 1e-9
    assert rows["stepped", "256 steps"]["error"] < 1e-5
    assert rows["fixed steps with DV", "5000 steps"]["silent"]
    # Oracle: an event solver held to a twentieth of a cycle is an independent computation of the same motion
    assert rows["solve_ivp DOP853, held steps", "rtol 1e-09"]["error"] < 1e-4
    ax = study.figure(record.panels[0], Figure().add_subplot())
    assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
