"""Scenes: what ships loads, what is built equals what is read, what is written reads back the same."""

import re
import tomllib
from dataclasses import replace

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from studies import Damping, Drive, Scene, SceneError, Slider, Stator, Transducer, Wave, shipped_scenes
from studies.scene import read_table
from studies.scene.toml import document
from tests.seed_motor import PRELOAD

SHIPPED = sorted(shipped_scenes())


def table(name="twente"):
    return read_table(name)


def test_the_scenes_of_the_contract_ship():
    assert {"twente", "twente-contact", "twente-left", "rayleigh"} <= set(SHIPPED)
    assert any("lithium" in name for name in SHIPPED)


def test_the_default_scene_is_the_motor_of_the_paper():
    scene = Scene.load("twente")
    assert [t.center for t in scene.transducer] == [0.015, 0.145]
    assert scene.levels == pytest.approx([3.0 * k for k in range(1, 21)], rel=1e-15)
    assert scene.burst is None
    assert scene.slider.preload_force == pytest.approx(PRELOAD, rel=1e-15)


def test_a_scene_built_in_python_equals_the_scene_read():
    left, right = (
        Transducer(name=n, center=c, finger_pairs=10, period="half-space", metallisation=0.5, aperture="20 mm")
        for n, c in (("left", "15 mm"), ("right", 0.145))
    )
    built = Scene(
        title="Feenstra and Breedveld: 2.2 MHz motor on hard PZT",
        stator=Stator(material="PZT-8", length=0.16, thickness="5 mm", width=0.035, ends="absorbing"),
        transducer=[left, right],
        drive=Drive(frequency=2.2e6, transducer="left", voltage=[3 * k for k in range(1, 21)]),
        slider=Slider(
            position="80 mm",
            radius=1e-3,
            mass="0.089 g",
            contacts=1,
            preload="weight",
            friction_coefficient=0.08,
            effective_modulus="64 GPa",
            tangential_modulus=12e9,
            damping=Damping(normal=0.5, tangential="1e-4 N s/m"),
        ),
    )
    assert built == Scene.load("twente")
    assert hash(built) == hash(Scene.load("twente"))


@pytest.mark.parametrize("name", SHIPPED)
def test_a_shipped_scene_survives_being_written(name):
    scene = Scene.load(name)
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


@pytest.mark.parametrize("title", ['"quoted"', "back\\slash", "Größe µm # no comment", "a = 'b'"])
def test_a_title_of_any_characters_survives_being_written(title):
    scene = replace(Scene.load("twente-contact"), title=title)
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


@pytest.mark.parametrize("name", ["left one", "a.b", 'in "quotes"', "µ"])
def test_a_transducer_of_any_name_survives_being_written(name):
    scene = Scene.load("twente").replace(transducer={"left": {"name": name}}, drive={"sources": {name: 1}})
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


positive = st.floats(1e-9, 1e9)
COMMON = dict(
    radius=positive,
    mass=positive,
    contacts=st.integers(1, 9),
    preload=st.one_of(st.just("weight"), positive),
    gravity=st.floats(0, 1e3),
    load=st.floats(0, 1e3),
    friction_coefficient=st.floats(0, 3),
    effective_modulus=positive,
    tangential_modulus=positive,
    reciprocal=st.booleans(),
    method=st.sampled_from(["auto", "exact", "stepped", "averaged"]),
    damping=st.builds(Damping, contact=st.floats(0, 1), normal=st.floats(0, 1), tangential=st.floats(0, 1)),
)
SLIDERS = st.builds(Slider, law=st.just("elastic"), stick_band=st.floats(0, 1), **COMMON) | st.builds(
    Slider, law=st.just("hysteretic"), **COMMON
)
AT_ANY_SPEED = settings(deadline=None, suppress_health_check=[HealthCheck.too_slow])
TITLES = st.text(max_size=40).filter(str.isprintable)


@AT_ANY_SPEED
@given(
    TITLES,
    st.builds(
        Wave,
        frequency=positive,
        normal_amplitude=st.lists(st.floats(0, 1e-3), min_size=1, max_size=4),
        tangential_ratio=positive,
        burst=st.none() | positive,
    ),
    SLIDERS,
)
def test_any_contact_scene_survives_being_written(title, wave, slider):
    scene = Scene(title=title, wave=wave, slider=slider)
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


@AT_ANY_SPEED
@given(
    st.one_of(
        st.sampled_from(["Z", "X", "YZ", "128YX", "ST-X"]), st.lists(st.floats(-360, 360), min_size=3, max_size=3)
    ),
    st.one_of(st.just("half-space"), positive),
    st.sampled_from(["free", "grounded", "clamped", "absorbing"]),
    st.one_of(st.sampled_from(["open", "short"]), st.floats(0, 1e6), st.complex_numbers(max_magnitude=1e6)),
    st.floats(0.001, 0.999),
    st.none() | positive,
    st.lists(st.floats(-0.01, 0.01), min_size=1, max_size=4, unique=True),
)
def test_any_driven_scene_survives_being_written(
    orientation, thickness, bottom, termination, metallisation, burst, offsets
):
    if isinstance(termination, complex):
        termination = complex(abs(termination.real), termination.imag)
    scene = Scene.load("twente")
    scene = replace(
        scene,
        stator=replace(scene.stator, orientation=orientation, thickness=thickness, bottom=bottom),
        transducer=[replace(t, termination=termination, metallisation=metallisation) for t in scene.transducer],
        drive=replace(scene.drive, burst=burst, source_impedance=0 if isinstance(termination, str) else termination),
        slider=replace(scene.slider, contacts=offsets),
    )
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene


@pytest.mark.parametrize(
    "material",
    [
        {"youngs_modulus": "70 GPa", "poisson_ratio": 0.33, "density": "2.7 g/cm^3", "mechanical_quality": 900},
        {
            "stiffness": [[100e9 if i == j else 0 for j in range(6)] for i in range(6)],
            "coupling": [[0.0] * 6] * 3,
            "permittivity": [[10, 0, 0], [0, 10, 0], [0, 0, 10]],
            "density": 5000,
            "dielectric_loss": 0.01,
        },
    ],
)
def test_a_material_table_survives_being_written(material):
    text = table("rayleigh")
    text["stator"]["material"] = material
    scene = Scene.from_table("", text)
    assert Scene.from_table("", tomllib.loads(document(scene.to_table()))) == scene
    assert scene.stator.material.density in (2700.0, 5000.0)


def test_frozen():
    with pytest.raises(AttributeError):
        Scene.load("twente").slider.mass = 1.0


def test_a_scene_file_is_read_like_a_shipped_one(tmp_path):
    path = tmp_path / "motor.toml"
    path.write_text(shipped_scenes()["twente"].read_text())
    assert Scene.load(path) == Scene.load(str(path)) == Scene.load("twente")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"title = ", b"a = 1\na = 2", b"a = " + b"[" * 3000])
def test_a_file_that_is_no_toml_is_refused(tmp_path, content):
    path = tmp_path / "motor.toml"
    path.write_bytes(content)
    with pytest.raises(SceneError, match=r"motor\.toml"):
        Scene.load(path)


def test_a_scene_of_no_name_is_refused_with_the_nearest():
    with pytest.raises(SceneError, match=r"'twent'.*did you mean twente\?"):
        Scene.load("twent")


def test_a_scene_of_no_name_tells_shipped_scenes_from_ones_own_files(tmp_path):
    for name in "abcdefg":
        (tmp_path / f"{name}.toml").touch()
    own = ", ".join(str(tmp_path / f"{name}.toml") for name in "abcde")
    sentence = re.escape(f"; shipped: {', '.join(shipped_scenes())}; files there: {own}, ...") + "$"
    with pytest.raises(SceneError, match=sentence):
        Scene.load(tmp_path / "wxyz")


def test_one_level_of_a_power_is_its_voltage_and_of_a_wave_its_amplitude():
    motor = Scene.load("twente").replace(
        drive={"voltage": None, "power": [1.0, 4.0], "source_impedance": 50.0}, uncertain={"slider.preload": "+- 5 %"}
    )
    high = motor.at_level(max(motor.levels))
    assert high.levels == (pytest.approx(40.0),)  # V^2 / (8 R) = 4 W
    assert high.drive.power is None
    assert high.uncertain is None
    assert Scene.load("twente-contact").at_level(7e-9).levels == (7e-9,)
