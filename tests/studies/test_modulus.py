"""Moduli of a ball on a stator: the pair's, how they enter a scene, and what is said of their average."""

import pytest

import fem
from studies.__main__ import main
from studies.model.contact_moduli import direction_dependence, pair_moduli
from studies.model.resolve import build, resolved
from studies.remarks.neglected_effects import left_out
from studies.scene import Scene, read_table
from tests.oracles import fem_surface_compliance as oracle


def test_steel_on_hard_pzt_gives_the_values_of_the_paper():
    normal, tangential = pair_moduli("steel", fem.material("PZT-8"))
    assert normal == pytest.approx(65.8e9, rel=1e-3)  # contract.md; the paper: 64 GPa
    assert tangential == pytest.approx(13.7e9, rel=5e-3)  # contract.md; the paper: 12 GPa


@pytest.mark.parametrize("orientation", ["YZ", "128YX", "Z"])
def test_steel_on_any_cut_of_lithium_niobate(orientation):
    """Oracle: Stroh's eigenproblem over directions, and steel's closed forms."""
    solid = fem.rotated(fem.material("LiNbO3 (Warner)"), orientation)
    mean = oracle.averaged(solid.stiffness, 60)
    normal, tangential = pair_moduli("steel", solid)
    assert 1 / normal == pytest.approx(mean[2, 2] / 2 + (1 - 0.3**2) / 210e9, rel=1e-9)
    assert 1 / tangential == pytest.approx(2 * mean[0, 0] + (2 - 0.3) * 2.6 / 210e9, rel=1e-9)


def test_a_ball_in_a_scene_resolves_to_its_moduli():
    table = read_table("twente-left")
    del table["slider"]["effective_modulus"], table["slider"]["tangential_modulus"]
    table["slider"]["ball"] = "steel"
    slider = resolved(Scene.from_table("", table)).slider
    assert (slider.effective_modulus, slider.tangential_modulus) == pair_moduli("steel", fem.material("PZT-8"))
    assert slider.ball is None


def test_the_lithium_niobate_scene_takes_its_moduli_from_the_ball():
    scene = Scene.load("lithium-niobate-yz")
    assert scene.slider.ball == "steel"
    slider = resolved(scene).slider
    assert slider.effective_modulus == pytest.approx(101e9, rel=5e-3)  # as it was given by hand, rounded
    assert slider.tangential_modulus == pytest.approx(21e9, rel=2e-2)


def test_the_average_is_stated_where_there_is_one(capsys):
    solid = fem.rotated(fem.material("LiNbO3 (Warner)"), "YZ")
    compliances = [oracle.surface_compliance(solid.stiffness, angle * 0.01).real[2, 2] for angle in range(315)]
    spread = (max(compliances) - min(compliances)) / (max(compliances) + min(compliances))
    said = direction_dependence(solid)
    assert float(said.partition("+-")[2].split()[0]) == pytest.approx(100 * spread, abs=0.06)
    assert direction_dependence(fem.material("PZT-8")) == ""
    assert any(said in line for line in left_out(build(Scene.load("lithium-niobate-yz"))))
    assert main(["check", "lithium-niobate-yz"]) == 0
    assert said in capsys.readouterr().out
