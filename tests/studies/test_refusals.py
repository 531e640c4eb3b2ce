"""Bad scenes: each is refused with the key's path, what is allowed and what was given, on one line."""

import pytest

from studies import Scene, SceneError
from studies.chain.resolve import resolved
from studies.scene import read_table
from studies.scene.override import assigned

NAN = float("nan")
CASES = [
    # scene, setting, parts of the sentence
    ("twente", "slider.mas=1", ["slider.mas", "did you mean mass?"]),
    ("twente", "sliders.mass=1", ["sliders", "did you mean slider?"]),
    ("twente", "transducer.1.centre=1", ["transducer.1.centre", "did you mean center?"]),
    ("twente", "slider.damping.tangental=1", ["slider.damping.tangental", "did you mean tangential?"]),
    ("twente", "slider.mass=0", ["slider.mass", "positive and finite", "0.0 kg"]),
    ("twente", "slider.mass=-1", ["slider.mass", "positive", "-1.0 kg"]),
    ("twente", "slider.mass=nan", ["slider.mass", "finite", "nan kg"]),
    ("twente", "slider.mass=inf", ["slider.mass", "finite", "inf kg"]),
    ("twente", "slider.mass=1e200", ["slider.mass", "between 1e-30 and 1e+30", "1e+200 kg"]),
    ("twente", "slider.mass=1e-200", ["slider.mass", "between 1e-30 and 1e+30", "1e-200 kg"]),
    ("twente", "drive.voltage=1e31", ["drive.voltage", "between 0 and 1e+30", "1e+31 V"]),
    ("twente", "slider.mass=5 mm", ["slider.mass", "a mass", "'5 mm'", "a length"]),
    ("twente", "slider.mass=true", ["slider.mass", "True"]),
    ("twente", "slider.mass=2020-01-01", ["slider.mass", "a mass", "'2020-01-01'"]),
    ("twente", "drive.frequency=2.2 Mhz", ["drive.frequency", "'Mhz' is no known unit; did you mean MHz?"]),
    (
        "twente",
        "stator.orientation=Q",
        ["stator.orientation", '"Z" or "X" or "YZ" or "128YX" or "ST-X" or three angles', "'Q'"],
    ),
    ("twente", "slider.preload=-1 mN", ["slider.preload", "zero or positive", "-0.001 N"]),
    ("twente", "slider.preload=wait", ["slider.preload", '"weight"', "'wait'"]),
    ("twente", "slider.friction_coefficient=-0.1", ["slider.friction_coefficient", "-0.1"]),
    ("twente", 'slider.ball="steel"', ["slider.ball", "effective_modulus"]),
    ("twente", "slider.contacts=0", ["slider.contacts", "integer from 1", "0"]),
    ("twente", "slider.contacts=[]", ["slider.contacts", "empty list"]),
    ("twente", 'slider.contacts=["1 mm", 0.001]', ["slider.contacts", "differ"]),
    ("twente", 'slider.contacts=["1 mm", "1 kg"]', ["slider.contacts.1", "'1 kg'"]),
    ("twente", "slider.law=hertz", ["slider.law", '"elastic"', "'hertz'"]),
    ("twente", "slider.reciprocal=1", ["slider.reciprocal", "true or false"]),
    ("twente", "slider.position=170 mm", ["slider.position", "0 to 0.16 m", "0.17 m"]),
    ("twente", 'slider.contacts=["0 mm", "81 mm"]', ["slider.position", "0.161 m"]),
    ("twente", "slider=3", ["slider", "block of keys", "3"]),
    ("twente", "drive.voltage=[]", ["drive.voltage", "empty list"]),
    ("twente", "drive.voltage=[1, -2]", ["drive.voltage.1", "zero or positive", "-2.0 V"]),
    ("twente", "drive.voltage=5 A", ["drive.voltage", "a voltage", "'5 A'"]),
    ("twente", "drive.frequency=0", ["drive.frequency", "positive"]),
    ("twente", "drive.frequency=2.2 rad/s", ["drive.frequency", "a frequency"]),
    ("twente", "drive.frequency=center", ["transducer.0.period", "a length in m", "got 'half-space'"]),
    ("rayleigh", "drive.frequency=center", ["drive.frequency", "transducer"]),
    ("twente", "drive.transducer=lift", ["drive.transducer", "did you mean left?"]),
    ("twente", "drive.source_impedance=[-5, 0]", ["drive.source_impedance.0", "-5.0 ohm"]),
    ("twente", "transducer.0.finger_pairs=0", ["transducer.0.finger_pairs", "integer"]),
    ("twente", "transducer.0.finger_pairs=9.5", ["transducer.0.finger_pairs", "9.5"]),
    ("twente", "transducer.0.metallisation=1", ["transducer.0.metallisation", "below 1", "1.0"]),
    (
        "twente",
        "transducer.0.metallisation=0.9999999",
        ["transducer.0.metallisation", "0.001 and 0.999", "0.9999999"],
    ),
    (
        "twente",
        "transducer.0.metallisation=1e-4",
        ["transducer.0.metallisation", "0.001 and 0.999", "0.0001"],
    ),
    ("twente", "slider.a\x1eb=1", ["slider.a\\x1eb", "is no key"]),
    ("twente", "transducer.0.termination=closed", ["transducer.0.termination", '"open" or "short"']),
    ("twente", "transducer.0.termination=[1, 2, 3]", ["transducer.0.termination", "[resistance, reactance]"]),
    ("twente", "transducer.1.name=left", ["transducer.1.name", "'left'"]),
    ("twente", "transducer.1.center=170 mm", ["transducer.1.center", "0 to 0.16 m", "0.17 m"]),
    ("twente", "transducer=4", ["transducer", "[[transducer]]"]),
    (
        "twente",
        "transducer.1.aperture=36 mm",
        ["transducer.1.aperture", "at most stator.width, 0.035 m", "0.036 m"],
    ),
    ("twente", "stator.ends=open", ["stator.ends", '"absorbing"', "'open'"]),
    ("twente", "stator.bottom=fre", ["stator.bottom", "did you mean free?"]),
    ("twente", "stator.orientation=128XY", ["stator.orientation", "did you mean 128YX?"]),
    ("twente", "stator.orientation=[1, 2]", ["stator.orientation", "three angles"]),
    ("twente", "stator.thickness=infinite", ["stator.thickness", '"half-space"']),
    ("twente", "stator.length=-1", ["stator.length", "-1.0 m"]),
    ("twente", "title=3", ["title", "text"]),
    ("rayleigh", "drive.voltage=3", ["drive.voltage", "transducer"]),
    ("rayleigh", "drive.transducer=left", ["drive.transducer", "transducer"]),
    ("rayleigh", "stator.material.densty=1", ["stator.material", "'PZT-8'"]),
    ("twente-contact", "slider.position=1 mm", ["slider.position", "[wave]"]),
    ("twente-contact", 'slider.contacts=["1 mm"]', ["slider.contacts", "[wave]"]),
    ("twente-contact", "wave.normal_amplitude=[]", ["wave.normal_amplitude", "empty list"]),
    ("twente-contact", "wave.tangential_ratio=x", ["wave.tangential_ratio", "'x'"]),
    ("twente-contact", "drive.frequency=1", ["wave", "[drive]"]),
]


@pytest.mark.parametrize(("name", "setting", "parts"), CASES, ids=[f"{c[0]}:{c[1]}" for c in CASES])
def test_a_bad_value_is_refused_with_key_rule_value_and_unit(name, setting, parts):
    with pytest.raises(SceneError) as refusal:
        Scene.from_table("", assigned(read_table(name), setting))
    sentence = str(refusal.value)
    assert sentence.startswith(parts[0])
    assert all(part in sentence for part in parts), sentence
    assert "\n" not in sentence


@pytest.mark.parametrize(
    ("name", "path"),
    [
        ("twente", "slider.radius"),
        ("twente", "slider.mass"),
        ("twente", "slider.position"),
        ("twente", "slider.contacts"),
        ("twente", "slider.preload"),
        ("twente", "slider.friction_coefficient"),
        ("twente", "slider.effective_modulus"),
        ("twente", "slider.tangential_modulus"),
        ("twente", "stator"),
        ("twente", "stator.material"),
        ("twente", "stator.thickness"),
        ("twente", "stator.width"),
        ("twente", "stator.ends"),
        ("twente", "drive"),
        ("twente", "drive.voltage"),
        ("twente", "drive.transducer"),
        ("twente", "drive.frequency"),
        ("twente-contact", "slider"),
        ("twente-contact", "wave.frequency"),
        ("twente-contact", "wave.normal_amplitude"),
        ("twente-contact", "wave.tangential_ratio"),
    ],
)
def test_what_is_required_is_missed_by_its_name(name, path):
    table = read_table(name)
    *blocks, key = path.split(".")
    holder = table[blocks[0]] if blocks else table
    del holder[key]
    with pytest.raises(SceneError, match=rf"^{path} is (required and )?missing"):
        Scene.from_table("", table)


def test_blocks_that_contradict_each_other_are_refused():
    driven, given = read_table("twente"), read_table("twente-contact")
    with pytest.raises(SceneError, match=r"^wave must not stand beside \[stator\]"):
        Scene.from_table("", driven | {"wave": given["wave"]})
    with pytest.raises(SceneError, match=r"^slider must be absent without a \[\[transducer\]\]"):
        Scene.from_table("", read_table("rayleigh") | {"slider": driven["slider"]})
    with pytest.raises(SceneError, match=r"^stator is missing"):
        Scene.from_table("", {})
    slider = {key: value for key, value in given["slider"].items() if "modulus" not in key}
    with pytest.raises(SceneError, match=r"^slider\.ball must not be given with \[wave\]"):
        Scene.from_table("", given | {"slider": slider | {"ball": "steel"}})


def test_transducers_that_overlap_are_refused():
    table = read_table("twente")
    for transducer, center in zip(table["transducer"], ("15 mm", "20 mm"), strict=True):
        transducer |= {"period": "1 mm", "center": center}
    with pytest.raises(
        SceneError, match=r"^transducer 'left' and 'right' must not overlap: the first ends at 0\.01"
    ):
        resolved(Scene.from_table("", table))


def test_fingers_that_leave_the_stator_are_refused():
    table = assigned(assigned(read_table("twente"), "transducer.1.center=158 mm"), "transducer.1.period=1 mm")
    with pytest.raises(
        SceneError, match=r"^transducer\.1 must lie on the stator, 0 to 0\.16 m, .* to 0\.16\d+ m"
    ):
        resolved(Scene.from_table("", table))


@pytest.mark.parametrize("key", ["voltage"])
def test_zero_voltage_is_no_error(key):
    assert Scene.from_table("", assigned(read_table("twente"), f"drive.{key}=0")).levels == (0.0,)


def test_python_construction_is_refused_in_the_same_words():
    from studies import Wave

    with pytest.raises(SceneError, match=r"^wave\.frequency must be positive and finite, got -1\.0 Hz$"):
        Wave(frequency=-1, normal_amplitude=1e-9, tangential_ratio=0.7)


@pytest.mark.parametrize(
    ("name", "settings", "parts"),
    [
        (
            "twente-contact",
            ["wave.burst=1e6"],
            ["wave.burst", "at most", "2.2e+12 cycles", "hours", "1e+06 s"],
        ),
        ("twente-contact", ["wave.burst=4", "slider.law=hysteretic"], ["wave.burst", "2.73 s", "got 4 s"]),
        ("twente", ["drive.burst=1 h"], ["drive.burst", "364 s", "got 3600 s"]),
        (
            "twente",
            [
                "drive.burst=1 h",
                "drive.frequency=center",
                "transducer.0.period=1 mm",
                "transducer.1.period=1 mm",
            ],
            ["drive.burst", "370 s", "got 3600 s"],
        ),
    ],
)
def test_a_burst_that_takes_hours_is_refused(name, settings, parts):
    table = read_table(name)
    for setting in settings:
        table = assigned(table, setting)
    with pytest.raises(SceneError) as refusal:
        resolved(Scene.from_table("", table))
    assert all(part in str(refusal.value) for part in parts), str(refusal.value)


@pytest.mark.parametrize("settings", [["wave.burst=100"], ["wave.burst=2", "slider.law=hysteretic"]])
def test_a_long_burst_is_not_refused(settings):
    table = read_table("twente-contact")
    for setting in settings:
        table = assigned(table, setting)
    assert resolved(Scene.from_table("", table)).burst > 1
