"""Scenes with a normal force of one's own or balls that attract: what reaches the contact, what takes no such."""

import math

import pytest

import contact
from studies import run
from studies.__main__ import main
from studies.export.averaged_motor import first_drive
from studies.model.wave_to_contact import contact_slider
from studies.motor import regime_map
from studies.refusal import SceneError
from studies.scene import Scene
from studies.scene.toml import document
from tests.studies.settings import changed

STIFF = """
def force(approach, contact):
    return 4 / 3 * contact.effective_modulus * contact.radius**0.5 * approach**1.5
"""
DMT = 'slider.adhesion={work="0.05 J/m^2",model="DMT"}'


def test_a_scene_with_adhesion_attracts():
    dry = contact_slider(changed("twente-contact").slider)
    ball = contact_slider(changed("twente-contact", DMT).slider)
    assert ball.attraction(1) == pytest.approx(2.0 * math.pi * 0.05 * dry.radius, rel=1e-14)
    wet = 'slider.adhesion={surface_tension="72 mN/m",contact_angle="60 deg",model="meniscus"}'
    ball = contact_slider(changed("twente-contact", wet).slider)
    assert ball.attraction(1) == pytest.approx(2.0 * math.pi * 0.072 * dry.radius, rel=1e-14)
    assert dry.attraction(1) == 0.0


def test_equal_balls_attract_each_with_their_own_radius():
    one, three = (contact_slider(changed("twente-contact", f"slider.contacts={n}", DMT).slider) for n in (1, 3))
    assert three.attraction(1) == one.attraction(1)  # of one of the equal parts
    assert three.preload == pytest.approx(one.preload / 3.0, rel=1e-14)


def test_a_file_is_read_from_the_folder_and_kept_in_the_resolved_scene(tmp_path, monkeypatch, capsys):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "my_law.py").write_text(STIFF)
    table = changed("twente-contact").to_table()
    table["slider"]["normal_law"] = "my_law.py"
    (tmp_path / "here" / "scene.toml").write_text(document(table))
    monkeypatch.chdir(tmp_path)  # elsewhere
    scene = Scene.load(tmp_path / "here" / "scene.toml")
    assert scene.slider.normal_law.source == STIFF
    ball = contact_slider(scene.slider)
    assert ball == contact_slider(Scene.from_table("", scene.to_table()).slider)
    smooth = contact_slider(changed("twente-contact").slider)
    wave = contact.Orbit(frequency=2.2e6, normal=3e-9, tangential=-2.01e-9j)
    speeds = [float(contact.mean_motion(each, wave).velocity) for each in (smooth, ball)]
    assert speeds[1] == pytest.approx(speeds[0], rel=1e-10)
    assert main(["check", "twente-contact", "--set", "slider.normal_law=here/my_law.py"]) == 0
    assert capsys.readouterr().err == ""


def test_the_tables_of_an_averaged_motor_do_not_take_a_law_of_ones_own(tmp_path, monkeypatch):
    (tmp_path / "my_law.py").write_text(STIFF)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=r"slider\.normal_law must be absent: the tables of the averaged motor"):
        first_drive(changed("twente-contact", "slider.normal_law=my_law.py"))


@pytest.mark.parametrize("key", ["adhesion", "normal_law"])
def test_a_map_of_the_regimes_does_not_take_them(tmp_path, monkeypatch, key):
    (tmp_path / "my_law.py").write_text(STIFF)
    monkeypatch.chdir(tmp_path)
    scene = changed("twente-contact", {"adhesion": DMT, "normal_law": "slider.normal_law=my_law.py"}[key])
    with pytest.raises(SceneError, match="slider must stand on smooth dry balls"):
        regime_map.run(scene, amplitudes=2, preloads=2, checked=0, tolerance=1e-3)


@pytest.mark.parametrize("key", ["adhesion", "normal_law"])
def test_pillars_are_dry_and_flat(tmp_path, monkeypatch, key):
    (tmp_path / "my_law.py").write_text(STIFF)
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=rf"slider\.{key} must be absent with \[slider\.pillars\]"):
        changed("silicon-slider", {"adhesion": DMT, "normal_law": "slider.normal_law=my_law.py"}[key])


@pytest.mark.parametrize("command", ["check", "run"])
@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("def force(z, contact): return float('nan')", "must give a force that is finite and not negative"),
        ("def force(z, contact): return 0.0", "must give a force that rises with the approach"),
        ("def force(z): return z", "must define force(approach, contact), but law.py takes other arguments"),
        ("x = 1", "must define force(approach, contact), but law.py has none"),
        ("def force(z, contact)", "names law.py, which cannot be run: SyntaxError"),
        (
            "def force(z, contact): raise ValueError('no')",
            "names law.py, whose force cannot be evaluated: ValueError: no",
        ),
    ],
)
def test_a_faulty_law_is_refused_with_its_key(tmp_path, monkeypatch, capsys, command, text, sentence):
    (tmp_path / "law.py").write_text(text)
    monkeypatch.chdir(tmp_path)
    assert main([command, "twente-contact", "--set", "slider.normal_law=law.py"]) == 2
    assert f"slider.normal_law {sentence}" in capsys.readouterr().err


def test_without_friction_the_face_is_driven_along_the_normal_alone():
    (point,) = run(changed("twente-contact", "slider.friction_coefficient=0", "wave.normal_amplitude=3 nm")).points
    assert point.velocity_m_per_s == point.face_tangential_m == 0.0
    assert point.face_normal_m > 0.0
