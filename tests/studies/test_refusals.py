"""Bad scenes: each is refused with the key's path, what is allowed and what was given, on one line.

One table for each shipped scene that is spoilt. A row holds the settings, separated by semicolons, of which ``-KEY``
removes a key, and after the bar parts of the sentence, which begins with the first of them.
"""

import pytest

from studies import Scene, SceneError, Wave
from studies.chain.resolve import resolved
from studies.scene import read_table
from tests.studies.settings import assigned

SHORT = {
    "FALLING": "slider.friction_coefficient={static=0.3, sliding=0.15, speed=0.05}",
    "MM_PERIODS": "transducer.0.period=1 mm; transducer.1.period=1 mm",
    "NO_MODULI": "-slider.effective_modulus; -slider.tangential_modulus",
    "SLIDER": 'slider={mass=1, preload=1, friction_coefficient=1, ball="steel", contacts=1, radius=1, position=0.01}',
}
TABLES = {
    "twente": """
slider.mas=1 | slider.mas ... did you mean mass?
sliders.mass=1 | sliders ... did you mean slider?
transducer.1.centre=1 | transducer.1.centre ... did you mean center?
slider.damping.tangental=1 | slider.damping.tangental ... did you mean tangential?
slider.mass=0 | slider.mass ... positive and finite ... 0.0 kg
slider.mass=-1 | slider.mass ... positive ... -1.0 kg
slider.mass=nan | slider.mass ... finite ... nan kg
slider.mass=inf | slider.mass ... finite ... inf kg
slider.mass=1e200 | slider.mass ... between 1e-30 and 1e+30 ... 1e+200 kg
slider.mass=1e-200 | slider.mass ... between 1e-30 and 1e+30 ... 1e-200 kg
drive.voltage=1e31 | drive.voltage ... between 0 and 1e+30 ... 1e+31 V
slider.mass=5 mm | slider.mass ... a mass ... '5 mm' ... a length
slider.mass=true | slider.mass ... True
slider.mass=2020-01-01 | slider.mass ... a mass ... '2020-01-01'
drive.frequency=2.2 Mhz | drive.frequency ... 'Mhz' is no known unit; did you mean MHz?
stator.orientation=Q | stator.orientation ... "Z" or "X" or "YZ" or "128YX" or "ST-X" or three angles ... 'Q'
slider.preload=-1 mN | slider.preload ... zero or positive ... -0.001 N
slider.preload=wait | slider.preload ... "weight" ... 'wait'
slider.friction_coefficient=-0.1 | slider.friction_coefficient ... -0.1
slider.ball="steel" | slider.ball ... effective_modulus
slider.contacts=0 | slider.contacts ... integer from 1 ... 0
slider.contacts=[] | slider.contacts ... empty list
slider.contacts=["1 mm", 0.001] | slider.contacts ... differ
slider.contacts=["1 mm", "1 kg"] | slider.contacts.1 ... '1 kg'
slider.law=hertz | slider.law ... "elastic" ... 'hertz'
slider.reciprocal=1 | slider.reciprocal ... true or false
slider.position=170 mm | slider.position ... 0 to 160 mm ... 170 mm
slider.contacts=["0 mm", "81 mm"] | slider.position ... 161 mm
slider=3 | slider ... block of keys ... 3
drive.voltage=[] | drive.voltage ... empty list
drive.voltage=[1, -2] | drive.voltage.1 ... zero or positive ... -2.0 V
drive.voltage=5 A | drive.voltage ... a voltage ... '5 A'
drive.frequency=0 | drive.frequency ... positive
drive.frequency=2.2 rad/s | drive.frequency ... a frequency
drive.frequency=center | transducer.0.period ... a length in m ... got 'half-space'
drive.transducer=lift | drive.transducer ... did you mean left?
drive.source_impedance=[-5, 0] | drive.source_impedance.0 ... -5.0 ohm
transducer.0.finger_pairs=0 | transducer.0.finger_pairs ... integer
transducer.0.finger_pairs=9.5 | transducer.0.finger_pairs ... 9.5
transducer.0.metallisation=1 | transducer.0.metallisation ... below 1 ... 1.0
transducer.0.metallisation=0.9999999 | transducer.0.metallisation ... 0.001 and 0.999 ... 0.9999999
transducer.0.metallisation=1e-4 | transducer.0.metallisation ... 0.001 and 0.999 ... 0.0001
slider.a\x1eb=1 | slider.a\\x1eb ... is no key
transducer.0.termination=closed | transducer.0.termination ... "open" or "short"
transducer.0.termination=[1, 2, 3] | transducer.0.termination ... [resistance, reactance]
transducer.1.name=left | transducer.1.name ... 'left'
transducer.1.center=170 mm | transducer.1.center ... 0 to 160 mm ... 170 mm
transducer=4 | transducer ... [[transducer]]
transducer.1.aperture=36 mm | transducer.1.aperture ... at most stator.width, 35 mm ... 36 mm
stator.ends=open | stator.ends ... "absorbing" ... 'open'
stator.bottom=fre | stator.bottom ... did you mean free?
stator.orientation=128XY | stator.orientation ... did you mean 128YX?
stator.orientation=[1, 2] | stator.orientation ... three angles
stator.thickness=infinite | stator.thickness ... "half-space"
stator.length=-1 | stator.length ... -1.0 m
title=3 | title ... text
slider.heights=["1 nm"] | slider.heights needs slider.contacts as a list of places
slider.contacts=[0, "5 mm"]; slider.heights=["1 nm"] | slider.heights must hold one height ... 2 contacts, got 1
slider.shape=punch; slider.law=hysteretic | slider.law must be "elastic" with shape = "punch"
slider.shape=cone | slider.shape
transducer.0.pattern=+-+ | transducer.0.pattern must have 20 signs, two ... got 3: '+-+'
transducer.1.split=true; transducer.1.pattern=+-+- | transducer.1.pattern must have 40 ... four
transducer.0.pattern=+-x- | transducer.0.pattern must be a text of the signs + - 0 o
transducer.0.pattern=1 | transducer.0.pattern must be a text ... got 1
transducer.0.pattern='' | transducer.0.pattern must be a text
transducer.1.finger_pairs=2; transducer.1.pattern=0000 | transducer.1.pattern must leave at least one finger
transducer.0.finger_pairs=2; transducer.0.pattern=+0+o | transducer.0.pattern must have + and - ... driven
transducer.0.split=1 | transducer.0.split must be true or false
transducer.0.patern=+-+- | transducer.0.patern ... did you mean pattern?
drive.sources={left="fast"} | drive.sources.left must be a plain number or "amplitude at phase deg"
drive.sources={left="1 at ten deg"} | drive.sources.left must be a plain number
drive.sources={left="-1 at 10 deg"} | drive.sources.left must be a plain number
drive.sources={left=true} | drive.sources.left must be a plain number
drive.sources={left=1, middle=1} | drive.sources must name one of the transducers, got 'middle'
drive.sources={left=0, right=0} | drive.sources must have at least one amplitude that is not 0
drive.sources={} | drive.sources must be a table of transducers
drive.sources=left | drive.sources must be a table of transducers
drive.power=1 W; drive.source_impedance=50 | drive.voltage must be absent with drive.power
-drive.voltage; drive.power=1 W | drive.power needs a drive.source_impedance
-drive.voltage; drive.power=1 V | drive.power ... a power
drive.match=best | drive.match must be "none" or "auto" or one or more blocks
drive.match=auto; drive.source_impedance=[0, 9] | drive.match needs ... for "auto"
drive.match=[{series_M=1}] | drive.match.0.series_M is no key of a scene; did you mean
drive.match=[{series_L="1 nF"}] | drive.match.0.series_L ... an inductance
drive.match=[{series_L=1, shunt_C=1}] | drive.match.0 must be a table of one
drive.match=[{shunt_R=1, Q=3}] | drive.match.0.Q must be absent
drive.match=auto; drive.source_impedance=50; drive.sources={left=1, right=1} | drive.match must be ... several sources
drive.recovery.receiver=left | drive.recovery.receiver must name a transducer that is not driven, got 'left'
drive.recovery.receiver=rigth | drive.recovery.receiver must name ... right
drive.recovery={receiver="right", load=[0, 20]} | drive.recovery.load must have a resistance
drive.recovery={receiver="right", load=50, rectifier=50} | drive.recovery.load must be absent with
drive.recovery={receiver="right", efficiency=0} | drive.recovery.efficiency
drive.recovery={receiver="right", gain=2} | drive.recovery.gain is no key
drive.recovery.receiver=right; transducer.1.termination=50 | transducer.1.termination must be absent on the receiving
NO_MODULI; slider.ball=steal | slider.ball ... steel
NO_MODULI; slider.ball=PZT-4 | slider.ball ... isotropic
NO_MODULI; slider.ball=LiNbO3 (Ogi) | slider.ball ... isotropic
stator.material=PZT8 | stator.material ... PZT-8
stator.material=steel | transducer ... not piezoelectric
transducer.0.center=2 mm | transducer.0
transducer.0.center=136 mm | transducer.1.center ... off those of
transducer.0.finger_pairs=500 | transducer.0 ... stator
MM_PERIODS; transducer.1.center=20 mm | transducer.1.center must keep the fingers ... the former begin at 1
transducer.1.center=158 mm; transducer.1.period=1 mm | transducer.1.center ... 0 to 160 mm, ... to 16
drive.burst=1 h | drive.burst ... 364 s ... got 3600 s
drive.burst=1 h; drive.frequency=center; MM_PERIODS | drive.burst ... 370 s ... got 3600 s
wave={frequency="2.2 MHz", normal_amplitude="1 nm", tangential_ratio=0.7} | wave must not stand beside [stator]
-slider.radius | slider.radius is required and missing
-slider.mass | slider.mass is required and missing
-slider.position | slider.position is required and missing
-slider.contacts | slider.contacts is required and missing
-slider.preload | slider.preload is required and missing
-slider.friction_coefficient | slider.friction_coefficient is required and missing
-slider.effective_modulus | slider.effective_modulus is required and missing
-slider.tangential_modulus | slider.tangential_modulus is required and missing
-stator | stator is missing
-stator.material | stator.material is required and missing
-stator.thickness | stator.thickness is required and missing
-stator.width | stator.width is required and missing
-stator.ends | stator.ends is required and missing
-drive | drive is missing
-drive.voltage | drive.voltage is required and missing
-drive.transducer | drive.transducer is required and missing
-drive.frequency | drive.frequency is required and missing
""",
    "rayleigh": """
drive.frequency=center | drive.frequency ... transducer
drive.voltage=3 | drive.voltage ... transducer
drive.transducer=left | drive.transducer ... transducer
stator.material.densty=1 | stator.material ... 'PZT-8'
SLIDER | slider must be absent without a [[transducer]]
""",
    "twente-contact": """
slider.position=1 mm | slider.position ... [wave]
slider.contacts=["1 mm"] | slider.contacts ... [wave]
wave.normal_amplitude=[] | wave.normal_amplitude ... empty list
wave.tangential_ratio=x | wave.tangential_ratio ... 'x'
drive.frequency=1 | wave ... [drive]
NO_MODULI; slider.ball=steel | slider.ball must not be given with [wave]
wave.burst=1e6 | wave.burst ... at most ... 2.2e+12 cycles ... hours ... 1e+06 s
wave.burst=4; slider.law=hysteretic | wave.burst ... 2.73 s ... got 4 s
slider.friction_coefficient={static=1, sliding=0.1, speed="3 m"} | slider.friction_coefficient.speed must be a velocity
slider.friction_coefficient={static=0.3, sliding=0.1} | slider.friction_coefficient.speed is required and missing
slider.friction_coefficient={static=0.3} | slider.friction_coefficient.static alone is a number
slider.friction_coefficient={sliding=0.3, speed=1.0} | slider.friction_coefficient.static is required and missing
FALLING; slider.law=hysteretic | slider.law must be "elastic" with a table
FALLING; slider.reciprocal=true | slider.reciprocal must be false with a table
FALLING; slider.stick_band=0.1 | slider.stick_band must be 0 with a table
slider.law=no_law.py | slider.law names the file 'no_law.py', which cannot be read
FALLING; slider.law={name="a.py", source="b"} | slider.friction_coefficient must be a number with a law of one's own
-slider | slider is missing
-wave.frequency | wave.frequency is required and missing
-wave.normal_amplitude | wave.normal_amplitude is required and missing
-wave.tangential_ratio | wave.tangential_ratio is required and missing
""",
}
CASES = [(name, *row.split(" | ")) for name, rows in TABLES.items() for row in rows.strip().split("\n")]


def spoilt(name: str, settings: str) -> dict:
    """Return the table of a shipped scene with settings that are separated by semicolons."""
    table = read_table(name)
    for short, whole in SHORT.items():
        settings = settings.replace(short, whole)
    for setting in settings.split("; "):
        if setting.startswith("-"):
            *blocks, key = setting[1:].split(".")
            del (table[blocks[0]] if blocks else table)[key]
        else:
            table = assigned(table, setting)
    return table


@pytest.mark.parametrize(("name", "settings", "sentence"), CASES, ids=[f"{c[0]}:{c[1]}" for c in CASES])
def test_a_bad_scene_is_refused_with_key_rule_value_and_unit(name, settings, sentence):
    with pytest.raises(SceneError) as refusal:
        resolved(Scene.from_table("", spoilt(name, settings)))
    said, parts = str(refusal.value), sentence.split(" ... ")
    assert said.startswith(parts[0])
    assert all(part in said for part in parts), said
    assert "\n" not in said


def test_an_empty_scene_lacks_a_stator():
    with pytest.raises(SceneError, match=r"^stator is missing"):
        Scene.from_table("", {})


def test_zero_voltage_is_no_error():
    assert Scene.from_table("", spoilt("twente", "drive.voltage=0")).levels == (0.0,)


def test_python_construction_is_refused_in_the_same_words():
    with pytest.raises(SceneError, match=r"^wave\.frequency must be positive and finite, got -1\.0 Hz$"):
        Wave(frequency=-1, normal_amplitude=1e-9, tangential_ratio=0.7)


@pytest.mark.parametrize("settings", ["wave.burst=100", "wave.burst=2; slider.law=hysteretic"])
def test_a_long_burst_is_not_refused(settings):
    assert resolved(Scene.from_table("", spoilt("twente-contact", settings))).burst > 1
