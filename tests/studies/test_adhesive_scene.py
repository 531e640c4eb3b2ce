"""Scenes with balls of JKR and Maugis: answers of the contact, limits, ledger, sweeps, a stator, and refusals."""

import pytest

import contact
from studies import Scene, SceneError, run, sweep
from studies.evidence import rough_balls
from studies.motor import load_line
from studies.report.energies import balances


def scene(model="JKR", amplitudes=("2 nm", "10 nm"), **slider):
    own = {"adhesion": {"work": "0.05 J/m^2", "model": model}, "damping": {"normal": 0.5, "tangential": 0.0}}
    wave = {"normal_amplitude": list(amplitudes), "tangential_ratio": 0.67}
    return Scene.load("twente-contact").replace(wave=wave, slider=own | slider)


@pytest.fixture(scope="module")
def record():
    return run(scene(), tolerance=1e-4)


@pytest.mark.parametrize("model", ["JKR", "Maugis"])
def test_a_run_is_the_motion_of_the_contact(record, model):
    """The exact motion; the heavy slider's leaves out (f_n/f)^2, and the springs of opened contacts in the loss."""
    found = record if model == "JKR" else run(scene(model), tolerance=1e-4)
    for point, amplitude in zip(found.points, (2e-9, 10e-9), strict=True):
        known = contact.adhesive_motion(
            rough_balls.ball(), rough_balls.orbit(amplitude), work=0.05, model=model, tolerance=1e-4
        )
        assert abs(point.velocity_m_per_s) == pytest.approx(known.velocity.value, rel=2e-4)
        assert point.adhesion_power_W == pytest.approx(known.lost_power, rel=1e-3)
        assert point.adhesion_power_W >= known.lost_power
        assert point.regime == known.regime
        assert 0.0 < point.relative_error < 1e-6


def test_auto_takes_the_exact_motion_as_it_does_for_smooth_balls():
    """By the means the answer of a light slider is above this tolerance."""
    auto, exact, means = (
        run(scene(amplitudes=["10 nm"], method=each, mass="1 mg"), tolerance=1e-3).points[0]
        for each in ("auto", "exact", "averaged")
    )
    assert auto.velocity_m_per_s == exact.velocity_m_per_s
    assert (auto.status, means.status[:15]) == ("ok", "above tolerance")
    assert means.velocity_m_per_s == pytest.approx(auto.velocity_m_per_s, rel=2.0 * means.relative_error)


def test_threshold_and_release_are_those_of_the_ball(record):
    """The release amplitude of an independent program, 5.6963 nm."""
    assert record.summary.release_amplitude_m == pytest.approx(5.6963e-9, rel=1e-4)
    below, above = (
        run(scene(amplitudes=[share * record.summary.threshold_amplitude_m]), tolerance=1e-3).points[0]
        for share in (0.99, 1.01)
    )
    assert (below.regime, above.regime) == ("stick", "slip")


def test_attraction_slows_and_the_loss_of_energy_comes_in_hops(record):
    dry = run(scene().replace(slider={"adhesion": None}), tolerance=1e-3)
    assert record.summary.threshold_amplitude_m > 1.5 * dry.summary.threshold_amplitude_m
    for held, free in zip(record.points, dry.points, strict=True):
        assert abs(held.velocity_m_per_s) < abs(free.velocity_m_per_s)
    assert record.points[0].adhesion_power_W == 0.0 < record.points[1].adhesion_power_W
    # 3.008e-13 J in every hop of the independent program, without the spring of the opened contact
    assert record.points[1].adhesion_power_W == pytest.approx(3.008e-13 * 2.2e6, rel=1e-3)


def test_the_ledger_closes(record):
    for balance, point in zip(balances(record), record.points, strict=True):
        assert (
            balance.residual < 3e-10
        )  # the kinetic energy, 3e5 times the work of a cycle, is rounded to 1e-10 of that
        powers = dict(balance.entries)
        assert powers["lost by closing and opening"] == pytest.approx(point.adhesion_power_W, rel=1e-9)


def test_three_equal_balls_are_one_with_a_third():
    one = run(scene(amplitudes=["10 nm"]), tolerance=1e-3).points[0]
    own = {"contacts": 3, "preload": 3 * 0.87309e-3, "mass": "267 mg", "damping": {"normal": 1.5, "tangential": 0.0}}
    three = run(scene(amplitudes=["10 nm"], **own), tolerance=1e-3).points[0]
    assert three.velocity_m_per_s == pytest.approx(one.velocity_m_per_s, rel=1e-6)
    assert three.adhesion_power_W == pytest.approx(3.0 * one.adhesion_power_W, rel=1e-9)


def test_a_sweep_gives_the_points_of_runs(record):
    found = sweep(scene(amplitudes=["10 nm"]), {"slider.adhesion.work": [0.02, 0.05]}, tolerance=1e-3).columns()
    assert found["velocity_m_per_s"][1] == pytest.approx(record.points[1].velocity_m_per_s, rel=1e-4)
    assert abs(found["velocity_m_per_s"][0]) > abs(found["velocity_m_per_s"][1])


@pytest.mark.parametrize("slider", [{}, {"adhesion": None, "roughness": {"rms": "1 nm"}}])
def test_limits_of_a_sweep_are_those_of_the_run(record, slider):
    motor = scene(amplitudes=["10 nm"]).replace(slider=slider)
    summary = run(motor, tolerance=1e-2).summary if slider else record.summary
    found = sweep(motor, {"slider.friction_coefficient": [0.08]}, also=("limits", "ripple"), tolerance=1e-2).columns()
    for name in ("threshold", "release"):
        assert found[f"{name}_factor"][0] == pytest.approx(summary[f"{name}_amplitude_m"] / 10e-9, rel=1e-9)
    assert found["velocity_ripple"][0] == 0.0


def test_on_a_stator_the_error_of_the_wave_counts(small):
    motor = small.replace(drive={"voltage": ["120 V"]}, slider={"adhesion": {"work": 0.05, "model": "JKR"}})
    found, dry = run(motor, tolerance=1e-2), run(motor.replace(slider={"adhesion": None}), tolerance=1e-2)
    assert found.summary.threshold_voltage_V > dry.summary.threshold_voltage_V
    assert found.points[0].amplitude_sensitivity > 0.0
    assert abs(found.velocity[0]) < abs(dry.velocity[0])


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"slider": {"stick_band": 1e-3}}, r"stick_band does not go with slider\.adhesion"),
        ({"slider": {"law": "hysteretic"}}, r"slider\.adhesion has no hysteretic law"),
        (
            {"slider": {"contacts": [["-1 mm", "0 mm"], ["1 mm", "0 mm"]], "heights": ["0 nm", "1 nm"]}},
            r"slider\.heights must be absent with slider\.adhesion: at rest all balls count as closed",
        ),
        ({"slider": {"adhesion": {"separation": "0.3 nm"}}}, r"separation must be left out: the model is \"JKR\""),
        ({"slider": {"adhesion": {"work": None}}}, r"adhesion\.work is required and missing"),
    ],
)  # fmt: skip
def test_what_does_not_go_with_it_is_refused(changes, sentence):
    with pytest.raises(SceneError, match=sentence):
        run(scene().replace(**changes))


def test_a_separation_below_that_of_atoms_is_refused_with_its_key():
    own = {"work": 0.05, "model": "Maugis", "separation": 1e-18}
    with pytest.raises(
        SceneError, match=r"^slider\.adhesion\.separation must give a number of Tabor of at most 1e\+06"
    ):
        run(scene("Maugis", adhesion=own))


def test_the_averaged_method_agrees_and_closes_its_ledger(record):
    found = run(scene(method="averaged"), tolerance=1e-2)
    for own, exact in zip(found.points, record.points, strict=True):
        assert own.velocity_m_per_s == pytest.approx(exact.velocity_m_per_s, rel=1e-4)
        assert own.regime == exact.regime
        assert own.adhesion_power_W == pytest.approx(exact.adhesion_power_W, rel=1e-3)
    for balance in balances(found):
        assert balance.residual < 1e-10


@pytest.mark.slow
@pytest.mark.parametrize("model", ["JKR", "Maugis"])
def test_a_burst_moves_towards_the_steady_velocity(model):
    motor = scene(model, amplitudes=["10 nm"]).replace(wave={"burst": "0.5 ms"})
    exact, stepped = (run(motor.replace(slider={"method": each}), tolerance=1e-3) for each in ("exact", "stepped"))
    (point,), (other,) = exact.points, stepped.points
    assert (point.burst_method, other.burst_method) == ("exact", "stepped")
    ends = [each.velocity_at_burst_end_m_per_s for each in (point, other)]
    assert ends[0] == pytest.approx(ends[1], rel=1e-3)
    assert 0.0 < ends[0] < point.velocity_m_per_s
    assert point.burst_release > 1000


@pytest.mark.parametrize("model", ["JKR", "Maugis"])
def test_a_load_line_falls_to_the_stall(model):
    motor = scene(model, amplitudes=["10 nm"])
    found = load_line.run(motor, points=4, tolerance=1e-2)
    assert all(each.confirmed is not False for each in found.findings)


@pytest.mark.parametrize(("model", "share"), [("JKR", 0.270), ("DMT", 0.360)])
def test_the_budget_says_that_roughness_takes_dry_adhesion_away(model, share):
    """Pull-off over the preload and Fuller's and Tabor's number, 66.5 at 3 nm, of an independent program."""
    found = run(scene(model, amplitudes=["10 nm"]), tolerance=1e-2)
    (effect,) = (each for each in found.model_error if each.effect == "roughness of the balls: their adhesion")
    assert effect.size == pytest.approx(-share, abs=1e-3)
    assert "number of Fuller and Tabor 67" in effect.source
    assert any("takes their adhesion away" in each for each in found.warnings)
    strong = run(scene(model, amplitudes=["10 nm"], adhesion={"work": 1.0, "model": model}), tolerance=1e-2)
    assert all(each.effect != "roughness of the balls: their adhesion" for each in strong.model_error)


def test_a_work_that_no_solid_has_is_warned_of():
    found = run(scene(amplitudes=["10 nm"], adhesion={"work": 50.0, "model": "JKR"}), tolerance=1e-2)
    assert any("slider.adhesion.work is 50 J/m^2: solids have 0.01 to 5" in each for each in found.warnings)
