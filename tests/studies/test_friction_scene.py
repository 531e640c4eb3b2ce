"""Friction that depends on speed and pressure, and a law of one's own, through a scene."""

import textwrap
from dataclasses import replace

import pytest

import contact
from studies import Scene, run
from studies.__main__ import main
from studies.model.wave_to_contact import contact_slider
from studies.scene.toml import document

TABLE = {"static": 0.3, "sliding": 0.15, "speed": "50 mm/s", "high_pressure": 0.2, "pressure": "80 MPa"}
LAW = textwrap.dedent(
    '''
    """Viscous and Coulomb friction."""

    MU, ETA = 0.15, 0.4  # 1, s/m

    def sliding(approach, normal_force, slip_speed, contact):
        return normal_force * (MU + ETA * slip_speed)
    '''
)


def contact_only(**slider):
    return Scene.load("twente-contact").replace(slider=slider, wave={"normal_amplitude": "6 nm"})


def test_a_table_of_friction_reaches_the_contact():
    scene = contact_only(friction_coefficient=TABLE)
    slider = contact_slider(run(scene).scene.slider)
    expected = contact.FallingFriction(sliding=0.15, speed=0.05, high_pressure=0.2, pressure=8e7)
    assert (slider.friction_coefficient, slider.friction) == (0.3, expected)
    point = run(scene).points[0]
    orbit = contact.Orbit(frequency=2.2e6, normal=6e-9, tangential=-4.2e-9j)
    assert point["velocity_m_per_s"] == pytest.approx(contact.steady(slider, orbit, tolerance=1e-6).velocity, rel=1e-6)
    plain = run(contact_only(friction_coefficient=0.3)).points[0]["velocity_m_per_s"]
    assert abs(point["velocity_m_per_s"] / plain - 1.0) > 0.01
    # the resolved scene is the same scene
    assert Scene.from_table("", scene.to_table()) == scene


def test_a_law_file_is_found_beside_the_scene_and_its_text_kept(tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "law.py").write_text(LAW)
    table = contact_only().to_table()
    table["slider"]["law"] = "law.py"
    file = tmp_path / "here" / "scene.toml"
    file.write_text(document(table))
    monkeypatch.chdir(tmp_path)  # elsewhere
    scene = Scene.load(file)
    assert scene.slider.law.source == LAW
    slider = contact_slider(replace(scene.slider, preload=scene.slider.preload_force))
    assert slider.friction == contact.UserLaw("law.py", LAW)
    assert slider.static_coefficient == pytest.approx(0.15, rel=1e-15)
    # what a run leaves needs the file no longer, and what is edited is another scene
    written = tmp_path / "resolved.toml"
    written.write_text(document(scene.to_table()))
    (tmp_path / "here" / "law.py").write_text(LAW.replace("0.4", "0.8"))
    assert Scene.load(written) == scene
    assert Scene.load(file) != scene
    assert main(["check", "twente-contact", "--set", "slider.law=here/law.py"]) == 0
