"""A motor's datasheet: its numbers against the contact's own answers, and the page that shows them."""

import json
import re
import shutil
import subprocess
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

import contact
from contact import steady
from studies.__main__ import main
from studies.record.plots import new_figure
from studies.record.text import sentences
from studies.report import datasheet_page
from studies.report.motor_datasheet import GROUPS, datasheet
from studies.runs import run
from studies.scene import Scene, read_table
from studies.solve.burst_steps import Steps
from studies.solve.solved_stator import contact_of_run
from tests.studies.legible import assert_legible
from tests.studies.settings import assigned

CHROMIUM = shutil.which("chromium")
MOTOR = ("stator.length=24 mm", "stator.thickness=1 mm", "transducer.0.center=9 mm", "transducer.0.finger_pairs=10",
         "transducer.0.period=0.98 mm", "slider.position=18 mm", "slider.contacts=2",
         "drive.voltage=[20, 60, 90]")  # fmt: skip


@pytest.fixture(scope="module")
def motor():
    """A short motor of ten finger pairs and two balls at one position, with a name that a page must escape."""
    table = read_table("twente-left")
    table = assigned(table, *MOTOR)
    return Scene.from_table("", table | {"title": "Motor <A> & co"})


@pytest.fixture(scope="module")
def sheet(motor):
    return datasheet(motor, tolerance=1e-2)


def row(sheet, name):
    (found,) = (each for each in sheet.rows if each.name == name)
    return found


def test_the_heat_allows_what_the_run_states(sheet):
    """Heat grows with V^2: half of 300 degC less 20 degC over the rise at the rated level."""
    rise = row(sheet, "rise of the hottest place").value
    assert rise == sheet.record.heat.highest_rise_K
    assert row(sheet, "largest continuous voltage").value == pytest.approx(90.0 * (130.0 / rise) ** 0.5, rel=1e-12)
    assert row(sheet, "largest duty").value == pytest.approx(min(130.0 / rise, 1.0), rel=1e-12)
    rate = sheet.record.heat.heating_rate_K_per_s
    assert row(sheet, "largest pulsed voltage").value == pytest.approx(90.0 * (10.0 / rate) ** 0.5, rel=1e-12)


def test_speed_and_thresholds_are_the_run_s(sheet):
    assert sheet.rated == 90.0
    point = sheet.record.points[-1]
    assert row(sheet, "speed at the position").value == abs(point["velocity_m_per_s"])
    slider = sheet.driven.slider
    threshold = row(sheet, "threshold").value
    assert steady(slider, sheet.driven.at(0.99 * threshold), tolerance=1e-6).velocity == 0.0
    assert steady(slider, sheet.driven.at(1.01 * threshold), tolerance=1e-6).velocity != 0.0


def test_the_speed_is_the_mean_over_the_stroke(sheet):
    """Oracle: averaged states at 300 places, the trapezoidal rule, half a wavelength clear of the fingers."""
    scene, motion = sheet.record.scene, sheet.record.surface_motion
    fingers, wavelength = 9e-3 + 10 * 0.98e-3 / 2, motion.wave.phase_velocity / motion.wave.frequency
    stroke, speed = row(sheet, "stroke"), row(sheet, "speed")
    assert fingers - 0.25 * 0.98e-3 < 24e-3 - stroke.value < fingers
    x = np.linspace(24e-3 - stroke.value + wavelength / 2, 24e-3, 300)
    u_x, _, u_z = motion.along(x * (1 - 1e-12), 0.0)
    velocities = np.array([
        contact.mean_motion(sheet.driven.slider, (
            contact.Orbit(frequency=scene.frequency, tangential=complex(a), normal=complex(b)).scaled(90.0),
        )).velocity
        for a, b in zip(u_x, u_z, strict=True)
    ])  # fmt: skip
    assert speed.value == pytest.approx(abs(np.trapezoid(velocities)) / 299, rel=3e-3)
    assert 0.0 < speed.error < 0.02
    assert abs(speed.value / row(sheet, "speed at the position").value - 1) > 0.02
    low, high = (float(part) for part in re.search(r"\((\S+) to (\S+) mm/s\)", speed.condition).groups())
    assert (low, high) == pytest.approx((1e3 * velocities.min(), 1e3 * velocities.max()), rel=5e-3)
    point = sheet.record.points[-1]
    width = point["highest_velocity_m_per_s"] - point["lowest_velocity_m_per_s"]
    assert row(sheet, "ripple").value == pytest.approx(width / abs(point["mean_velocity_m_per_s"]), rel=1e-12)


def test_a_start_that_does_not_fit_in_the_stroke_is_a_warning(sheet):
    motion, distance = sheet.start_stop, row(sheet, "start distance")
    covered = np.interp(
        row(sheet, "start time").value, motion.time[1:], np.cumsum(np.diff(motion.time) * motion.velocity[1:])
    )
    assert distance.value == pytest.approx(abs(covered), rel=2e-2)
    free = 18e-3 - (24e-3 - row(sheet, "stroke").value)  # towards the transducer
    assert distance.value > free
    assert distance.condition.endswith("it does not fit")
    assert sum("the slider does not reach its speed" in each for each in sheet.record.warnings) == 1


def test_a_start_that_fits_is_none(motor):
    slow = datasheet(replace(motor, drive=replace(motor.drive, voltage=(20.0,))), tolerance=1e-2)
    assert row(slow, "start distance").condition.endswith("it fits")
    assert not any("does not reach its speed" in each for each in slow.record.warnings)


def test_the_motor_stalls_at_its_blocked_thrust_and_not_before(sheet):
    """Two balls share the load: the slider that is computed is half of the motor."""
    assert sheet.balls == 2.0
    slider, orbits, thrust = sheet.driven.slider, sheet.driven.at(90.0), row(sheet, "blocked thrust").value
    forward = steady(slider, orbits, tolerance=1e-6).velocity
    for share, moves in ((0.99, True), (1.01, False)):
        velocity = steady(replace(slider, load=share * thrust / 2), orbits, tolerance=1e-6).velocity
        assert (velocity * forward > 0.0) == moves
    block = sheet.record.scene.slider
    holding = block.friction_coefficient * block.preload
    assert row(sheet, "holding force").value == pytest.approx(holding, rel=1e-12)
    assert row(sheet, "largest acceleration").value == pytest.approx(holding / block.mass, rel=1e-12)
    assert thrust <= holding * (1 + 1e-9)


def test_powers_are_load_times_speed_and_what_the_source_gives(sheet):
    line = sheet.lines["90 V"]
    most = 2.0 * float(np.max(line.load * line.velocity))
    drawn = sheet.record.electrical["power_W_per_V2"] * 90.0**2
    assert row(sheet, "largest mechanical power").value == pytest.approx(most, rel=1e-12)
    assert row(sheet, "electrical power").value == pytest.approx(drawn, rel=1e-12)
    assert row(sheet, "efficiency of the motor").value == pytest.approx(most / drawn, rel=1e-12)
    admittance = abs(sheet.record.electrical["admittance_S"])
    assert row(sheet, "current").value == pytest.approx(90.0 * admittance, rel=1e-12)
    assert 0.0 < row(sheet, "efficiency of the contact").value < 1.0


def test_the_smallest_step_is_one_cycle_too_long_to_be_shorter(sheet):
    smallest = sheet.steps[0]
    found = row(sheet, "smallest step of 1 nm or more")
    assert found.value == abs(smallest.displacement) >= 1e-9
    bursts = Steps.of(sheet.driven)
    assert bursts.step(90.0, smallest.cycles) == smallest
    assert abs(bursts.step(90.0, smallest.cycles - 1).displacement) < 1e-9
    assert f"{smallest.cycles} cycles" in found.condition


def test_a_step_is_what_a_burst_of_as_many_cycles_moves(motor, sheet):
    """The chain's own burst, ring-up and ring-down included; at full size from the first cycle it is another."""
    step = sheet.steps[2]  # against 1e-2 of it the ring, at which the trajectory ends somewhere, is small
    burst = step.cycles / sheet.driven.scene.frequency
    (point,) = run(replace(motor, drive=replace(motor.drive, burst=burst, voltage=(90.0,))), tolerance=1e-2).points
    assert point["displacement_m"] == pytest.approx(step.displacement, rel=1e-2)
    sudden = contact.step(sheet.driven.slider, sheet.driven.at(90.0), cycles=step.cycles)
    assert abs(sudden.displacement / step.displacement - 1.0) > 0.02


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"position": ("9 mm", "0 mm")}, "the slider stands over a transducer or a meshed piece"),
        ({"method": "exact"}, "slider.method is exact"),
        ({"stick_band": 1e-3}, "the motion in the contact must be followed event by event"),
    ],
)
def test_where_the_wave_s_growth_is_not_in_the_steps_they_say_so(sheet, changes, words):
    scene = replace(sheet.record.scene, slider=replace(sheet.record.scene.slider, **changes))
    driven = contact_of_run(replace(sheet.record, scene=scene))
    bursts = Steps.of(driven)
    assert bursts.reason == words
    assert "at full size from the first cycle" in bursts.sentence
    assert bursts.shape(5) == (None, None)


def test_start_and_stop_times_are_read_from_the_motion(sheet):
    motion, final = sheet.start_stop, abs(row(sheet, "speed at the position").value)
    at = np.interp(row(sheet, "start time").value, motion.time, abs(motion.velocity))
    assert at == pytest.approx(0.9 * final, rel=1e-2)
    after = motion.duration + row(sheet, "stop time").value
    assert np.interp(after, motion.time, abs(motion.velocity)) < 0.02 * final
    # m dv/dt = -F - R v from the full speed to 1 % of it
    slider, friction = sheet.record.scene.slider, row(sheet, "holding force").value
    forces = [friction + slider.damping.tangential * share * final for share in (1.0, 0.01)]
    stopping = slider.mass / slider.damping.tangential * np.log(forces[0] / forces[1])
    assert row(sheet, "stop time").value == pytest.approx(stopping, rel=0.02)


def test_every_number_has_a_unit_and_a_finite_error(sheet):
    whole = json.loads(json.dumps(sheet.to_dict(), allow_nan=False))
    assert whole["rated_voltage_V"] == 90.0
    for each in whole["rows"]:
        assert each["unit"]
        assert np.isfinite(each["value"])
        assert 0.0 <= each.get("error", 0.0) < (0.2 if "smallest step" in each["name"] else 0.05)
    assert {each["group"] for each in whole["rows"]} == set(GROUPS)


def test_the_page_is_self_contained_and_says_what_is_not_modelled(sheet):
    page = datasheet_page.page(sheet)
    assert "Motor &lt;A&gt; &amp; co" in page
    assert page.count('src="data:image/svg+xml;base64,') == 3
    assert not re.search(r"(src|href)=(?!\"data:)|<script|https?:", page)
    assert "@page { size: A4" in page
    assert "no lateral modes of the width" in page
    for each in sheet.rows:
        assert f"<td>{each.name}</td>" in page
    text = str(sheet)
    assert all(each.name in text for each in sheet.rows)


@pytest.mark.parametrize("draw", [datasheet_page.speed, datasheet_page.load_lines, datasheet_page.start_and_stop])
def test_its_pictures_can_be_read(sheet, draw):
    figure, ax = new_figure(*datasheet_page.PICTURE)
    draw(sheet, ax)
    assert_legible(figure)


def test_it_says_what_the_model_leaves_out_with_its_size(sheet):
    sizes = sentences(sheet.record)
    assert sizes[-1].startswith("below the tolerance")
    for text in (unescape(datasheet_page.page(sheet)), str(sheet)):
        assert all(each in text for each in sizes)
    assert sheet.to_dict()["model_error"] == [each.to_dict() for each in sheet.record.model_error]


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_it_prints_on_one_page(sheet, tmp_path):
    (tmp_path / "a.html").write_text(datasheet_page.page(sheet), encoding="utf-8")
    flags = f"--headless --no-sandbox --disable-gpu --no-first-run --user-data-dir={tmp_path / 'profile'}"
    command = [CHROMIUM, *flags.split(), f"--print-to-pdf={tmp_path / 'a.pdf'}", (tmp_path / "a.html").as_uri()]
    subprocess.run(command, capture_output=True, timeout=120, check=True)
    assert len(re.findall(rb"/Type\s*/Page\b", (tmp_path / "a.pdf").read_bytes())) == 1


def test_a_given_wave_has_a_datasheet_without_electrical_rows(tmp_path, monkeypatch, capsys):
    words = ["datasheet", "twente-contact", "--set", "wave.normal_amplitude=[3e-9, 10e-9]"]
    monkeypatch.setattr("sys.argv", ["sawmotor", *words, "--out", str(tmp_path / "a")])
    assert main() == 0
    assert "rated at 10 nm peak" in capsys.readouterr().out
    whole = json.loads((tmp_path / "a" / "datasheet.json").read_text())
    names = [each["name"] for each in whole["rows"]]
    assert "speed" in names
    assert "electrical power" not in names
    assert "frequency of the largest wave" not in names
    assert (tmp_path / "a" / "datasheet.html").read_text().startswith("<!DOCTYPE html>")


def test_rows_without_a_load_are_those_of_the_unloaded_motor():
    """Speed, start time and smallest step were those under slider.load: 139.6 mm/s for 152.9 mm/s under 20 uN."""
    free = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["20 nm"]}, title="one level")
    loaded = free.replace(slider={"load": "60 uN"}, uncertain={"slider": {"load": "+- 5 %", "mass": "+- 1 %"}})
    ours, theirs = (datasheet(each) for each in (loaded, free))
    (under_load,) = (each for each in ours.rows if each.name == "speed under load")
    assert [each for each in ours.rows if each is not under_load] == list(theirs.rows)
    assert under_load.value == pytest.approx(float(run(loaded.replace(uncertain=None)).velocity[0]), rel=1e-6)
    assert under_load.condition == "under slider.load = 60 \u00b5N, steady"
    assert ours.rows[1] is under_load


@pytest.mark.parametrize(("load", "kind"), [(6.0e-5, "dragged back"), (1.0, "")])
def test_a_load_that_the_motor_cannot_drive_and_a_step_that_fails_leave_the_other_rows(monkeypatch, load, kind):
    reaching = Steps.reaching

    def short(self, level, size):
        if size > 1e-9:
            raise contact.ConvergenceError("out of reach", "2097152 cycles move the slider by 1e-09 m")
        return reaching(self, level, size)

    monkeypatch.setattr(Steps, "reaching", short)
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": ["1.5 nm"]}, slider={"load": load})
    sheet = datasheet(scene)
    names, warnings = [each.name for each in sheet.rows], sheet.record.warnings
    assert names[0] == "speed"
    assert "smallest step of 1 nm or more" in names
    assert not {"step of 10 nm or more", "step of 100 nm or more"} & set(names)
    missing = "the datasheet has no step of 100 nm: out of reach: 2097152 cycles move the slider by 1e-09 m"
    assert warnings[-1] == missing
    assert ("speed under load" in names) == bool(kind)
    if kind:
        under_load = row(sheet, "speed under load")
        assert under_load.value == pytest.approx(float(run(scene).velocity[0]), rel=1e-6, abs=0.0)
        assert under_load.condition.endswith(kind)
    else:
        assert warnings[-3].startswith("the datasheet has no speed under load, slider.load = 1 N: ")
