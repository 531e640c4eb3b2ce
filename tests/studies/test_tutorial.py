"""The tutorial tells every field that a run writes, with its unit."""

import re
from pathlib import Path

import pytest

from studies.lab.measurement_csv import read_measured
from studies.record import Record
from studies.record.quantities import ENDINGS, quantities, with_quantities
from studies.record.velocity_comparison import compared
from studies.runs import run
from studies.scene import Scene
from tests.studies.settings import changed

TUTORIAL = Path(__file__).parents[2] / "studies" / "README.md"
ROW = re.compile(r"^\| `([a-z_]+(?:\.[\w-]+)*)` \| ([^|]+?) \| ?([^|]*?) ?\|$", re.MULTILINE)


def documented():
    return {key: unit for key, unit, _ in ROW.findall(TUTORIAL.read_text(encoding="utf-8"))}


def keys(path, value):
    """Yield the dotted names of a JSON value; the entries of a list have the list's name."""
    if isinstance(value, dict):
        for name, each in value.items():
            yield from keys(f"{path}.{name}" if path else name, each)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for each in value:
            yield from keys(path, each)
    else:
        yield path


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """Every key that a driven motor, a prescribed wave with a burst and a measurement, and a free wave write."""
    file = tmp_path_factory.mktemp("measured") / "measured.csv"
    file.write_text("normal_amplitude_m,velocity_m_per_s,error_m_per_s\n5e-9,0.03,0.001\n")
    short = ("stator.length=24 mm", "stator.thickness=2 mm", "transducer.0.center=8 mm",
             "transducer.0.period=0.98 mm")  # fmt: skip
    motor = changed("twente-left", *short, "slider.position=17.123 mm", "drive.voltage=[1, 60]", "drive.burst=0.1 ms")
    given = changed("twente-contact", "wave.burst=0.2 ms", "wave.normal_amplitude=[3e-9, 10e-9]", "slider.method=exact")
    found = set()
    for scene in (motor, given, Scene.load("rayleigh")):
        record = run(scene, tolerance=1e-2)
        whole = record.to_dict()
        if scene == given:
            whole["measured"] = compared(read_measured(file), [0.03])
        found |= set(keys("", {name: each for name, each in whole.items() if name not in ("title", "scene")}))
    return found


def test_every_field_of_a_run_is_in_the_tutorial(written):
    assert len(written) > 60
    assert {"measured.chi_square_per_point", "wave.settling_time_s", "wave.attenuation_per_m"} <= written
    undocumented = written - set(documented())
    assert undocumented - {"measured.points.normal_amplitude_m"} == set()  # named beside voltage_V


def test_the_tutorial_holds_the_rows_of_the_table_of_quantities():
    text = TUTORIAL.read_text(encoding="utf-8")
    assert with_quantities(text) == text
    assert with_quantities(text.replace("| `points.travel_m` | m |", "| `points.travel_m` | mm |")) == text
    assert set(documented()) <= set(quantities())


def test_the_tutorial_has_a_row_for_each_quantity_of_the_blocks_of_a_record():
    """What no scene of `written` makes, such as a burst in the plane or a steady temperature, included."""
    fields = Record.__dataclass_fields__
    of_record = {key for key in quantities() if key.partition(".")[0] in {*fields, "seconds", "provenance"}}
    assert {"points.path_length_m", "heat.duty_limit", "heat.foldover_number", "measured.remarks"} <= of_record
    assert of_record - set(documented()) == set()


@pytest.mark.parametrize("missing", ["points.voltage_V", "points.turn_rad", "heat.foldover_number"])
def test_a_missing_row_is_added_beside_its_neighbour(missing):
    """The first, a middle and the last row of a block."""
    text = TUTORIAL.read_text(encoding="utf-8")
    row = re.compile(rf"^\| `{missing}` .*\n", re.MULTILINE)
    assert with_quantities(row.sub("", text)) == text != row.sub("", text)
    assert with_quantities("no table of quantities\n") == "no table of quantities\n"


def test_units_are_those_that_the_names_say():
    for key, each in quantities().items():
        ending = next((each for each in ENDINGS if key.endswith(each)), None)
        if ending is not None:
            assert each.unit == ENDINGS[ending], key
    assert {"points.stick_margin": "1", "points.regime": "-"}.items() <= {
        key: each.unit for key, each in quantities().items()
    }.items()


def test_a_scale_is_that_of_the_unit_that_is_shown():
    """Oracle: pint."""
    import pint

    units = pint.UnitRegistry()
    shown = [each for each in quantities().values() if each.label and each.unit not in ("1", "-")]
    assert len(shown) > 15
    for each in shown:
        factor = units(each.unit).to(each.shown).magnitude
        assert factor == pytest.approx(each.scale), each.key


def test_a_field_that_is_not_documented_would_be_seen():
    table = documented()
    assert "wave.frequency_Hz" in table
    assert "wave.frequency" not in table
    assert set(keys("", {"a": {"b_V": 1.0}, "c": [{"d": 1}, {"e": [1, 2]}]})) == {"a.b_V", "c.d", "c.e"}
