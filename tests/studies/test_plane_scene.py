"""Scenes whose slider moves in the plane: their keys, and what is refused with key and line."""

import pytest

from studies import Scene, SceneError
from studies.scene.keys import rule_at

WAVES = """
[wave]
frequency = "2.2 MHz"
normal_amplitude = "10 nm"
tangential_ratio = 0.67
wavelength = "1 mm"
[[wave.sources]]
[[wave.sources]]
direction = "90 deg"
phase = "90 deg"
"""
SLIDER = """
[slider]
radius = "1 mm"
mass = "0.089 g"
contacts = [["6 mm", 0], ["-3 mm", "5 mm"], ["-3 mm", "-5 mm"]]
preload = "weight"
friction_coefficient = 0.08
effective_modulus = "64 GPa"
tangential_modulus = "12 GPa"
"""


@pytest.fixture
def scene(tmp_path):
    """A function that reads a scene whose slider has further keys, with several waves."""

    def read(keys, waves=WAVES, slider=SLIDER):
        path = tmp_path / "motor.toml"
        path.write_text(waves + slider + keys)
        return Scene.load(path)

    return read


@pytest.mark.parametrize("keys", ['freedom = "xy"', 'freedom = "xy yaw"', 'axis = ["1 mm", 0]'])
def test_a_motion_in_the_plane_is_written_back(scene, keys):
    planar = scene(keys)
    assert planar.planar
    assert planar.slider.turns == (keys != 'freedom = "xy"')
    assert Scene.from_table("", planar.to_table()) == planar


REFUSED = [  # keys of the slider, and the refused key and words of its sentence
    ("", "wave.sources", 'choose slider.freedom = "xy"'),
    ("load = [0, 1e-6]", "slider.load", "must be a number where the slider moves along x"),
    ('torque = "1 uN m"', "slider.torque", "must be absent where the slider moves along x"),
    ('freedom = "xy"\ntorque = "1 uN m"', "slider.torque", 'choose slider.freedom = "xy yaw"'),
    ('freedom = "xy yaw"\naxis = [0, 0]', "slider.freedom", "must be absent with slider.axis"),
    ('freedom = "xy"\nlaw = "hysteretic"', "slider.law", 'has one direction: choose "elastic"'),
    ('freedom = "xy"\nstick_band = 1e-3', "slider.stick_band", "must be 0 with slider.freedom"),
    ("axis = [0, 0]\nreciprocal = true", "slider.reciprocal", "must be false"),
    ('freedom = "xy"\nadhesion = { model = "meniscus" }', "slider.adhesion", "must be left out with slider.freedom"),
    ('torque = "1 uN m"', "slider.torque", 'choose slider.freedom = "xy yaw", or give slider.axis'),
    ('freedom = "axle"', "slider.axis", "is required and missing"),
    ('axis = [0, 0]\nload = "1 uN"', "slider.load", "whose axle carries it: give slider.torque"),
    ('freedom = "xy"\ntravel = true', "slider.travel", "a burst follows the slider"),
    ('freedom = "xy"\ntilt = "pitch"', "slider.tilt", '"held" or "free"'),
    ('freedom = "xy"\nincline = [90, 0]', "slider.incline.0", "below 90"),
]


@pytest.mark.parametrize(("keys", "key", "words"), REFUSED)
def test_what_does_not_go_together_is_refused(scene, keys, key, words):
    with pytest.raises(SceneError) as refused:
        scene(keys)
    found = {each.path: each.rule for each in refused.value.problems}
    assert words in found[key], found


@pytest.mark.parametrize(
    ("places", "keys", "key", "words"),
    [
        ("1", 'freedom = "xy yaw"', "slider.freedom", "needs two contacts apart: one ball has no yaw stiffness"),
        ('[["1 mm", 0]]', 'axis = ["1 mm", 0]', "slider.axis", "a contact away from the axle"),
        ('["-1 mm", 0, "2 mm"]', 'freedom = "xy"\ntilt = "free"', "slider.tilt", "balls on a line do not fix the tilt"),
    ],
)
def test_places_that_do_not_hold_the_body_are_refused(scene, places, keys, key, words):
    slider = "\n".join(f"contacts = {places}" if each.startswith("contacts") else each for each in SLIDER.split("\n"))
    with pytest.raises(SceneError) as refused:
        scene(keys, slider=slider)
    (problem,) = refused.value.problems
    assert problem.path == key
    assert words in problem.rule


def test_waves_at_several_places_need_a_wavelength_and_all_amplitudes(scene):
    with pytest.raises(SceneError, match="the contacts stand at different positions"):
        scene('freedom = "xy"', waves=WAVES.replace('wavelength = "1 mm"', ""))
    with pytest.raises(SceneError) as refused:
        scene('freedom = "xy"', waves=WAVES + 'normal_amplitude = "5 nm"\n')
    assert refused.value.problems[0].path == "wave.sources.0.normal_amplitude"


def test_an_empty_list_of_waves_is_refused():
    with pytest.raises(SceneError) as refused:
        Scene.from_table("", {"wave": {"sources": []}})
    assert "wave.sources" in {each.path for each in refused.value.problems}


def test_the_rule_of_a_source_is_that_of_its_table():
    assert rule_at("drive.source_frequencies.front").read("", "2.3 MHz") == 2.3e6
    with pytest.raises(SceneError, match="holds no keys"):
        rule_at("drive.source_frequencies.front.phase")


def test_sources_of_own_frequency_need_a_slider_in_the_plane():
    own = {"source_frequencies": {"front": "2.3 MHz"}}
    with pytest.raises(SceneError) as refused:
        Scene.load("crossed").replace(drive=own)
    assert refused.value.problems[0].path == "drive.source_frequencies"
    planar = Scene.load("crossed").replace(slider={"freedom": "xy"})
    assert planar.replace(drive=own).drive.source_frequencies == (("front", 2.3e6),)
    with pytest.raises(SceneError, match=r"must name one of drive\.sources; did you mean front"):
        planar.replace(drive={"source_frequencies": {"frond": "2.3 MHz"}})


def test_beams_across_may_drive_a_slider_in_the_plane():
    across = {"transducer": "front", "sources": None}
    with pytest.raises(SceneError, match=r'or choose slider\.freedom = "xy"'):
        Scene.load("crossed").replace(drive=across)
    assert Scene.load("crossed").replace(drive=across, slider={"freedom": "xy"}).planar
