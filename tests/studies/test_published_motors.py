"""Published motors: the bands, the verdicts, and the models behind them against closed forms."""

import csv
import io
import json
import math

import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from studies.papers import published_kurosawa as model
from studies.papers import published_motors as study
from studies.papers import published_rotors as rotors
from studies.papers.published import Comparison, Unknown, comparisons, corners, left_aside
from studies.record.plots import SIZE
from studies.study_list import Panel
from tests.studies.legible import assert_legible

BY_QUANTITY = {(each.motor, each.quantity): each for each in comparisons()}
TAKEN = BY_QUANTITY["Kurosawa 1998", "speed at its amplitude"].taken


def row(published, what=lambda case: case["a"] * case["b"], **swept):
    swept = swept or {"a": Unknown(name="A", taken=2.0, swept=(1.0, 3.0)),
                      "b": Unknown(name="B", taken=1.0, swept=(0.9, 1.2), unit="m", scale=10)}  # fmt: skip
    published = published if isinstance(published, tuple) else (published,)
    return study.compared(
        Comparison(motor="motor", quantity="quantity", published=published, model="", taken={"a": 2.0, "b": 1.0},
                   swept=swept, unit="m"), what,
    )  # fmt: skip


def compared(motor, quantity):
    comparison = BY_QUANTITY[motor, quantity]
    return study.compared(comparison, study.MODELS[comparison.model])


def test_a_band_is_every_corner_and_names_what_moves_it_most():
    found = row(2.5)
    assert (found["low"], found["predicted"], found["high"]) == (0.9, 2.0, pytest.approx(3.6))
    assert found["most"] == "A (3x)"
    assert found["swept"] == "A 1 to 3, B 9 to 12 m"
    assert found["verdict"] == "within the band; as taken -20 %"


def test_what_lies_outside_is_said_so_and_how_far():
    assert row(7.2)["verdict"] == "outside the band, whose nearer end is -50 %"
    assert row(0.6)["verdict"] == "outside the band, whose nearer end is +50 %"
    assert not study.finding_of(row(7.2)).confirmed
    assert study.finding_of(row(2.5)).confirmed


def test_a_published_range_is_compared_as_a_range():
    """Nothing between its ends is called the published value."""
    found = row((0.5, 4.0))
    assert (found["published_low"], found["published_high"]) == (0.5, 4.0)
    assert "published" not in found
    assert found["verdict"] == "the whole band lies within the published range"
    assert row((3.0, 4.0))["verdict"] == "band and published range overlap"
    assert row((4.0, 5.0))["verdict"] == "outside the band, whose nearer end is -10 %"
    assert row((0.5, 0.8))["verdict"].startswith("outside")
    assert "published 0.5 to 4 m" in study.finding_of(found).statement


def test_every_row_compares_a_motor_with_its_own_prediction():
    """The seed's row holds the paper's two amplitudes; Shilton's run-up, which is not computed, has no row."""
    seed = compared("Feenstra and Breedveld", "release amplitude")
    assert (seed["published_low"], seed["published_high"]) == (3e-9, 10e-9)
    assert seed["verdict"] == "the whole band lies within the published range"
    assert any("Shilton" in what for what in left_aside())


def test_the_torque_needs_the_friction_that_its_remark_states():
    """5.37 pN m over 41.1 uN times 0.5 mm."""
    verdict = compared("Tjeung 2011", "torque, at most")["verdict"]
    assert verdict.endswith(f"; needs a friction coefficient of {5.37e-9 / (41.1e-6 * 0.5e-3):.2f} at least")


def test_rotors_are_those_of_two_integrators():
    """One ball, and a ring of balls over two beams, by an event-driven integrator and one of fixed steps.

    The ring of `published_rotors` has 8 contacts, that of the oracle is dense.
    """
    case = {
        "radius": 1e-3, "preload": 0.87309e-3, "friction": 0.08, "modulus": 64e9, "frequency": 2.2e6, "ratio": 0.67,
        "amplitude": 10e-9, "beams": "two", "arm": 6e-3, "mass": 1e-3,
    }  # fmt: skip
    assert rotors.rolling_speed(case) * 2 * math.pi / 60 * 1e-3 == pytest.approx(0.0683658806, rel=1e-5)
    ring = case | {"preload": rotors.CONTACTS * 0.87309e-3}
    for amplitude, speed, torque in ((3e-9, 0.0040941355, 3.12542911e-5), (10e-9, 0.046385, 6.91668571e-5)):
        found = rotors.rotor_speed(ring | {"amplitude": amplitude}) * 2 * math.pi / 60
        assert found * 6e-3 == pytest.approx(speed, rel=0.1)
        # a dense ring of n contacts stalls at n b (2/pi) Q0
        least = 1e-3 * 6e-3 * found / (rotors.CONTACTS * 2 / math.pi * torque)
        assert rotors.run_up_time(ring | {"amplitude": amplitude}) == pytest.approx(least, rel=0.1)


def test_every_model_of_the_table_exists_and_is_used():
    names = {each.model for each in comparisons()}
    names |= {end for each in comparisons() for end in each.published if isinstance(end, str)}
    assert names == set(study.MODELS)


def test_a_band_that_holds_anything_says_little():
    wide = {"a": Unknown(name="A", taken=2.0, swept=(1.0, 8.0))}
    assert row(2.5, **wide)["verdict"].endswith("a band 8x wide says little")


def test_corners_are_all_combinations():
    found = list(
        corners({"a": Unknown(name="A", taken=1, swept=(1, 2)), "b": Unknown(name="B", taken=1, swept=(1, 2, 3))})
    )
    assert len(found) == 6
    assert {"a": 2, "b": 3} in found


def test_the_rows_of_the_picture_can_be_read():
    """Eighteen rows, as many as the study has: no label on another, and ticks as far as the bands reach."""
    quantities = ["wave power at 40 nm, above", "amplitude left of 15 nm, below 1", "speed"] * 6
    one = [1.0] * len(quantities)
    data = {
        "motor": ["Kurosawa and Asai, 10 MHz"] * len(quantities), "quantity": quantities, "published_low": one,
        "published_high": one, "predicted": one, "low": [0.03] * len(quantities), "high": [60.0] * len(quantities),
    }  # fmt: skip
    figure = Figure(figsize=SIZE, dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    study.figure(Panel(name="published", title="Published motors", data=data), figure.add_subplot())
    assert_legible(figure)
    assert [each.get_text() for each in figure.axes[0].get_xticklabels()] == ["0.1", "0.2", "0.5", "1", "2", "5", "10"]


def test_the_contact_radius_is_hertz():
    radius, modulus = 0.5e-3, TAKEN["modulus"]
    pressure = TAKEN["pressure"]
    # Johnson (1985), eq. 4.24 solved for the load, then eq. 4.22
    load = pressure**3 * math.pi**3 * radius**2 / (6 * modulus**2)
    expected = (3 * load * radius / (4 * modulus)) ** (1 / 3)
    assert model.contact_radius(TAKEN) == pytest.approx(expected, rel=1e-12, abs=0)


def test_the_balls_mass_is_that_of_a_millimetre_of_steel():
    assert TAKEN["mass"] == pytest.approx(7850 * math.pi / 6 * 1e-9, rel=1e-5, abs=0)


def test_speed_and_thrust_keep_within_what_wave_and_friction_give():
    wave = 2 * math.pi * TAKEN["frequency"] * model.surface_ratio("LiNbO3 (Kovacs)") * TAKEN["amplitude"]
    assert 0.1 * wave < model.speed(TAKEN) < wave
    friction = TAKEN["friction"] * TAKEN["preload"]
    assert 0.1 * friction < model.thrust(TAKEN) < friction


def test_the_needed_amplitude_gives_the_published_speed():
    needed = model.needed_amplitude(TAKEN)
    assert model.speed(TAKEN | {"amplitude": needed}) == pytest.approx(0.43, rel=2e-3, abs=0)


@pytest.mark.slow
def test_the_study_says_what_agrees_and_what_does_not():
    record = study.run()
    data = record.panels[0].data
    verdicts = dict(zip(zip(data["motor"], data["quantity"], strict=True), data["verdict"], strict=True))
    assert verdicts["Kurosawa 1998", "contact radius at its pressure"].startswith("within")
    assert verdicts["Kurosawa 1998", "speed at its amplitude"].startswith("outside")
    assert verdicts["Kurosawa 1998", "speed from 180 V"].endswith("says little")
    assert not any("run-up" in quantity for motor, quantity in verdicts if "Shilton" in motor)
    assert verdicts["Cheng 2003", "speed"].endswith("says little")
    written = study.tables(record)
    assert "| 9000 1/min |" in written["published_motors.md"]  # not 9e+03
    rows = list(csv.DictReader(io.StringIO(written["published_motors.csv"])))
    assert [float(each["predicted"]) for each in rows] == data["predicted"]
    assert written["published_motors.md"].count("\n| ") == len(rows)
    assert json.dumps(record.to_dict(), allow_nan=False)


@pytest.mark.slow
def test_the_amplitude_per_volt_is_near_the_strip_charges():
    import fem

    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    period = float(fem.automatic_period(solid, 10e6, 0.5))
    transducer = fem.Transducer(
        name="t", center=period * 7, finger_pairs=10, period=period, metallisation=0.5, aperture=9e-3
    )
    estimate = fem.transducer_estimate(solid, transducer, "open")
    # no reflections, no bulk waves in the estimate: nearer than 15 % would be luck
    expected = float(abs(estimate.normal(10e6)))
    assert model.per_volt(10, "LiNbO3 (Kovacs)", 10e6) == pytest.approx(expected, rel=0.3, abs=0)


def test_the_silicon_slider_is_slower_than_the_surface_and_meets_what_is_published():
    found = compared("Raj and Behera 2025", "speed, at least")
    ratio = model.surface_ratio("LiNbO3 (Kovacs)")
    assert found["published_high"] == pytest.approx(2 * math.pi * 13.5e6 * 12e-9 * ratio)
    assert 0 < found["low"] < found["predicted"] < found["high"] < found["published_high"]
    assert not found["verdict"].startswith("outside")
