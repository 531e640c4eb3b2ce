"""A scene's model: the objects of fem are those of its blocks, made once, and shared by what stands on one stator."""

from dataclasses import replace

import pytest

import fem
from studies.model.model import Model, model_of
from studies.model.resolve import build, following, with_numbers
from studies.refusal import SceneError
from studies.scene import Scene


@pytest.fixture(scope="module")
def motor():
    return Scene.load("twente")


def test_its_objects_are_made_once_and_only_where_they_exist(motor):
    model = build(motor)
    assert model.stator is model.stator
    assert model.transducers is model.transducers
    assert model.drive is model.drive
    assert model.solid == fem.rotated(fem.material(motor.stator.material), motor.stator.cut)
    assert [each.name for each in model.transducers] == [each.name for each in motor.transducer]
    assert model.driven.name == motor.drive.transducer
    with pytest.raises(SceneError, match=r"transducer.* must be a number"):
        _ = Model(motor).transducers  # their period is that of a wave which is not known yet


def test_the_written_scene_is_kept_beside_the_numbers(motor):
    weighed = motor.replace(slider={"preload": "weight", "mass": "2 g", "load": 0.0})
    model = build(weighed)
    assert model.written is weighed
    assert model.scene.slider.preload == pytest.approx(2e-3 * weighed.slider.gravity, rel=1e-12)
    assert with_numbers(model).scene == model.scene  # numbers stay


def test_an_absent_law_is_stored_by_its_name_and_follows_the_roughness():
    smooth = Scene.load("twente-contact")
    rough = smooth.replace(slider={"roughness": {"rms": "3 nm"}})
    assert smooth.slider.law is None
    assert build(smooth).scene.to_table()["slider"]["law"] == "elastic"
    assert build(rough).scene.to_table()["slider"]["law"] == "hysteretic"
    stored = build(rough).scene
    assert following(stored.replace(slider={"roughness": None}), rough).slider.tangential_law == "elastic"


def test_sliders_and_levels_share_one_stator(motor):
    lighter = motor.replace(slider={"preload": "1 mN"}, drive={"voltage": [1.0, 7.0]})
    first, second = build(motor).alone, build(lighter).alone
    assert first is second
    assert first.scene.slider is None
    assert first.scene.levels == (1.0,)
    other = motor.replace(stator={"length": motor.stator.length * 1.001})
    assert build(other).alone is not first
    grooved = build(Scene.load("reflector"))
    assert grooved.alone == grooved.alone
    assert grooved.alone is not grooved.alone  # its mesh is read again: the file may have changed


def test_the_models_of_recent_scenes_are_kept_but_for_their_meshes(motor):
    scene, grooved = build(motor).scene, build(Scene.load("reflector")).scene
    assert model_of(scene) is model_of(replace(scene))
    assert model_of(grooved) is not model_of(grooved)


def test_a_steady_temperature_is_cold_until_it_is_found(motor):
    block = motor.stator
    waiting = Model(replace(motor, stator=replace(block, temperature="steady")))
    assert waiting.before_heat.scene.stator == waiting.cold.scene.stator == block
    with pytest.raises(SceneError, match="is found by sawmotor run"):
        _ = waiting.solid
    warm = Model(motor).at_temperature(60.0)
    assert warm.before_heat is warm
    assert Model(motor).at_temperature_of(warm) == warm
    assert Model(motor).cold.scene.stator.temperature is None
