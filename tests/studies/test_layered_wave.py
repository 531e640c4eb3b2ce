"""``sawmotor wave --layer``: layers as a user types them, the keys of its answer, and what it refuses."""

import json

import numpy as np
import pytest

import fem
from studies.__main__ import main
from studies.refusal import SceneError
from studies.report.layered_surface import layered_surface_wave, read_layer


def answer(capsys, *arguments) -> dict:
    assert main(["wave", *arguments, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_layers_of_the_half_space_s_solid_change_nothing(capsys):
    bare = answer(capsys, "LiNbO3 (Kovacs)", "--orientation", "128YX")
    layers = ("--layer", "LiNbO3 (Kovacs) 128YX, 0.4 lambda", "--layer", "LiNbO3 (Kovacs) 128YX, 5 um")
    layered = answer(capsys, "LiNbO3 (Kovacs)", "--orientation", "128YX", *layers, "--frequency", "100 MHz")
    for key in ("velocity_m_per_s", "surface_ratio"):
        assert layered[key] == pytest.approx(bare[key], rel=1e-11)
    assert layered["coupling_K2"]["surface"] == pytest.approx(bare["coupling_K2"], rel=1e-9)
    for part in ("u_x", "u_y", "u_z"):
        np.testing.assert_allclose(layered["depth_profile"][part], bare["depth_profile"][part], atol=1e-10)
    wavelength = bare["velocity_m_per_s"] / 100e6
    assert [each["thickness_m"] for each in layered["layers"]] == pytest.approx([0.4 * wavelength, 5e-6], rel=1e-10)
    assert list(layered["shorted_velocity_m_per_s"]) == ["surface", "1", "2"]


def test_the_planes_count_the_layers_above_the_electrode():
    """The first layer of the command lies on the half-space: plane "1" is below the last one alone."""
    typed = layered_surface_wave("silicon", ["LiNbO3 (Kovacs) 128YX, 0.3 lambda", "PZT-8, 0.02 lambda"])
    solid = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")
    layers = [fem.Layer(solid=solid, wavelengths=0.3), fem.Layer(solid=fem.material("PZT-8"), wavelengths=0.02)]
    for plane, above in (("surface", 0), ("1", 1), ("2", 2)):
        wave = fem.principal_wave(fem.layered_waves(fem.rotated(fem.material("silicon"), "Z"), layers, shorted=above))
        assert typed["shorted_velocity_m_per_s"][plane] == pytest.approx(wave.velocity, rel=1e-10)
    assert typed["velocity_m_per_s"] > max(typed["shorted_velocity_m_per_s"].values())


def test_a_film_of_a_file(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["materials", "PZT-4", "--copy", "mine.toml"]) == 0
    capsys.readouterr()
    own = answer(capsys, "silicon", "--layer", "mine.toml, 0.1 lambda")
    assert own["velocity_m_per_s"] == answer(capsys, "silicon", "--layer", "PZT-4, 0.1 lambda")["velocity_m_per_s"]


def test_the_text_lists_layers_from_the_surface_down(capsys):
    layers = ("--layer", "PZT-8, 0.1 lambda", "--layer", "PZT-5A, 0.05 lambda")
    assert main(["wave", "silicon", *layers]) == 0
    text = capsys.readouterr().out
    assert text.index("PZT-5A") < text.index("PZT-8")
    for words in ("electrode", "below 2 layers", "Rayleigh"):
        assert words in text


@pytest.mark.parametrize(
    ("layer", "words"),
    [
        ("PZT-8", 'must be "MATERIAL'),
        ("PZT-8, x lambda", "no number of wavelengths"),
        ("PZT-8, 1 N", "a force"),
        ("PZT-8, -1 um", "positive"),
        ("PZT-8 128ZZ, 1 um", "128ZZ"),
        ("PZT-80, 1 um", "nearest known one is 'PZT-8'"),
    ],
)
def test_a_layer_that_cannot_be_read(layer, words):
    with pytest.raises(SceneError, match=words):
        read_layer(layer)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("silicon", "--layer", "PZT-8, 3 um"), "--frequency is missing"),
        (("silicon", "--layer", "PZT-8, 4 lambda"), "it is the substrate"),
        (("silicon", "--layer", "PZT-8, 1 um", "--frequency", "3 mm"), "--frequency must be a frequency"),
        (("silicon", "--layer", "PZT-8, 1 lambda", "--plot", "a.png"), "--plot must be absent"),
    ],
)
def test_a_stack_that_cannot_be_is_refused(arguments, words, capsys):
    assert main(["wave", *arguments]) == 2
    assert words in capsys.readouterr().err


def test_a_wave_that_leaks_is_no_answer(capsys):
    assert main(["wave", "PZT-8", "--layer", "silicon, 1 lambda"]) == 3
    assert "it leaks" in capsys.readouterr().err


def test_a_wave_that_leaks_little_has_its_attenuation(capsys):
    """The issue's coating: 2.4 um of AlN on 128YX at 9.6 MHz is faster than the slow shear, 4030.8 m/s."""
    film = ("--layer", "AlN (Tsubouchi), 2.4 um", "--frequency", "9.6 MHz")
    leaky = answer(capsys, "LiNbO3 (Kovacs)", "--orientation", "128YX", *film)
    assert leaky["limiting_velocity_m_per_s"] == pytest.approx(4030.8, abs=0.05)
    assert leaky["limiting_velocity_m_per_s"] < leaky["velocity_m_per_s"] < 4035.0
    assert 0.0 < leaky["attenuation_dB_per_wavelength"] < 0.01
    assert "depth_profile" not in leaky
    thin = answer(capsys, "LiNbO3 (Kovacs)", "--orientation", "128YX", "--layer", "AlN (Tsubouchi), 0.0056 lambda")
    assert thin["velocity_m_per_s"] < thin["limiting_velocity_m_per_s"]
    assert main(["wave", "LiNbO3 (Kovacs)", "--orientation", "128YX", *film]) == 0
    assert "leaks into it" in capsys.readouterr().out


def test_a_cut_without_a_bound_wave_names_its_leaky_one(capsys):
    assert main(["wave", "PZT-4", "0,20,0", "--surface", "open"]) == 3
    sentence = capsys.readouterr().err
    cut = fem.rotated(fem.material("PZT-4"), (0, 20, 0))
    wave = fem.leaky_waves(cut, surface="open")[0]
    assert f"Its leaky wave has {wave.velocity:.6g} m/s and loses {wave.decibels:.3g} dB in a wavelength" in sentence
