"""Tables of constants: each form, order, unit and convention gives the same solid, and tables that cannot be right."""

import numpy as np
import pytest

import fem
from studies import Scene, SceneError
from studies.model.fem_objects import solid
from studies.model.solid_of_material import crystal
from studies.remarks.scene_warnings import scene_warnings
from studies.scene.block import keys_of
from studies.scene.stator_keys import PiezoelectricSolid, Stator
from tests.fem.materials.test_forms import strain_charge

EPS0 = 8.8541878188e-12
LN = fem.material("LiNbO3 (Kovacs)")
TRUE = {
    "name": "niobate",
    "density": 4628.0,
    "stiffness": LN.stiffness,
    "coupling": LN.coupling,
    "permittivity": LN.permittivity / EPS0,
}
S, D, EPS_T = strain_charge(LN)
C_D = LN.stiffness + LN.coupling.T @ np.linalg.solve(LN.permittivity, LN.coupling)
ANSYS = [0, 1, 2, 5, 3, 4]  # 11 22 33 12 23 13 of 11 22 33 23 13 12


def scene(material, **stator):
    """A free wave on a chip of 128YX."""
    table = {key: each.tolist() if hasattr(each, "tolist") else each for key, each in material.items()}
    block = {"length": "10 mm", "thickness": "1 mm", "width": "5 mm", "ends": "absorbing", "orientation": "128YX"}
    return Scene.from_table("", {"stator": block | {"material": table} | stator, "drive": {"frequency": "10 MHz"}})


def changed(*left_out, **changes):
    return {key: each for key, each in (TRUE | changes).items() if key not in left_out}


def remarks(material):
    return [each for each in scene_warnings(scene(material)) if each.startswith("stator.material")]


def test_the_words_of_the_scene_are_those_of_fem():
    keys = keys_of(PiezoelectricSolid) | {"euler_convention": keys_of(Stator)["euler_convention"]}
    words = [keys[name].rule.words for name in ("form", "order", "euler_convention")]
    assert words == [fem.FORMS, fem.ORDERS, fem.CONVENTIONS]
    assert keys["form"].default == fem.FORMS[0]
    assert keys["order"].default == fem.ORDERS[0]


STRAIN_CHARGE = changed("stiffness", form="strain-charge", compliance=S, coupling=D, permittivity=EPS_T / EPS0)
SAME = {
    "stress-charge": TRUE,
    "strain-charge": STRAIN_CHARGE,
    "strain-charge in pC/N, pm^2/N, F/m": STRAIN_CHARGE
    | {"compliance": S * 1e12, "coupling": D * 1e12, "permittivity": EPS_T}
    | {"units": {"compliance": "1/TPa", "coupling": "pC/N", "permittivity": "F/m"}},
    "strain-charge with c^E": changed(form="strain-charge", coupling=D, permittivity=EPS_T / EPS0),
    "strain-charge by the other key": changed(form="strain-charge", stiffness=S, coupling=D, permittivity=EPS_T / EPS0),
    "constant D": changed(stiffness=C_D, stiffness_at="constant D"),
    "constant stress": changed(permittivity=EPS_T / EPS0, permittivity_at="constant stress"),
    "order of Ansys": changed(
        stiffness=LN.stiffness[np.ix_(ANSYS, ANSYS)], coupling=LN.coupling[:, ANSYS], order="11 22 33 12 23 13"
    ),
    "units": changed(
        density="4.628 g/cm^3", stiffness=LN.stiffness / 1e9, permittivity=LN.permittivity * 1e12,
        units={"stiffness": "GPa", "permittivity": "pF/m"},
    ),
    "dyn/cm^2": changed(stiffness=LN.stiffness * 10, units={"stiffness": "dyn/cm^2", "permittivity": "relative"}),
}  # fmt: skip


@pytest.mark.parametrize("name", SAME)
def test_each_way_of_writing_gives_the_same_solid(name):
    given = scene(SAME[name])
    found = crystal(given.stator.material)
    assert found.stiffness == pytest.approx(LN.stiffness, rel=1e-10, abs=10.0)
    assert found.coupling == pytest.approx(LN.coupling, rel=1e-10, abs=1e-10)
    assert found.permittivity == pytest.approx(LN.permittivity, rel=1e-10, abs=1e-20)
    assert found.density == pytest.approx(4628.0, rel=1e-12)
    assert remarks(SAME[name]) == []
    again = Scene.from_table("", given.to_table())
    assert crystal(again.stator.material) == found


@pytest.mark.parametrize("convention", ["COMSOL", "sawsim"])
def test_euler_angles_of_other_programs(convention):
    own = solid(scene(TRUE).stator)
    turned = solid(scene(TRUE, orientation=[0, -38, 0], euler_convention=convention).stator)
    assert turned.stiffness == pytest.approx(own.stiffness, rel=1e-12, abs=1.0)
    other = solid(scene(TRUE, orientation=[0, -38, 0]).stator)
    assert abs(other.stiffness - own.stiffness).max() > 1e10


IMPOSSIBLE = {
    "g/cm^3": (changed(density=4.628), "density", 'Then write "4.628 g/cm^3"'),
    "GPa": (changed(stiffness=LN.stiffness / 1e9), "stiffness", 'Then write units = { stiffness = "GPa" }'),
    "MPa": (changed(stiffness=LN.stiffness / 1e6), "stiffness", 'Then write units = { stiffness = "MPa" }'),
    "dyn/cm^2": (changed(stiffness=LN.stiffness * 10), "stiffness", 'units = { stiffness = "dyn/cm^2" }'),
    "compliances": (changed(stiffness=S), "stiffness", 'Then write form = "strain-charge"'),
    "d for e": (changed(coupling=D), "coupling", "are these d, in C/N?"),
    "d in pC/N": (changed(coupling=D * 1e13), "coupling", "are these d, in pC/N?"),
    "F/m": (changed(permittivity=LN.permittivity), "permittivity", 'Then write units = { permittivity = "F/m" }'),
    "pF/m": (changed(permittivity=LN.permittivity * 1e9), "permittivity", "must be 1 to 100000 times that of vacuum"),
    "less than vacuum": (changed(permittivity=np.eye(3) * 0.9), "permittivity", "in every direction, got 0.9"),
    "e^2/(c eps)": (changed(coupling=LN.coupling * 10), "coupling", "e^2/(c eps) is at most 20 for every strain, got"),
    "GPa of an isotropic solid": (
        {"youngs_modulus": 70.0, "poisson_ratio": 0.3, "density": 2700.0}, "youngs_modulus", 'Then write "70 GPa"'
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_constants_that_no_solid_has_are_refused_with_the_probable_unit(name):
    material, key, words = IMPOSSIBLE[name]
    with pytest.raises(SceneError) as error:
        solid(scene(material).stator)
    assert str(error.value).startswith(f"stator.material.{key} must")
    assert words in str(error.value)


def test_every_solid_of_the_catalogue_is_possible_and_right():
    for known in fem.catalogue().values():
        fem.refuse_impossible(known)
        assert list(fem.plausibility(known)) == []


REMARKED = {
    "order of Ansys": (
        changed(stiffness=LN.stiffness[np.ix_(ANSYS, ANSYS)]), 'fit class 3m in the order 11 22 33 12 23 13',
    ),
    "constant D": (changed(stiffness=C_D), "the stiffness of niobate: as of LiNbO3 (Kovacs) at constant D"),
    "constant stress": (changed(permittivity=EPS_T / EPS0), "permittivity of niobate: as of LiNbO3 (Kovacs) at"),
    "constant D and stress": (
        changed(stiffness=C_D, permittivity=EPS_T / EPS0),
        "the stiffness and permittivity of niobate: as of LiNbO3 (Kovacs) at constant D and at constant stress",
    ),
    "pF/m": (
        changed(permittivity=LN.permittivity * 1e12),
        "permittivity of niobate differs by 785 % from that of LiNbO3 (Kovacs), whose other constants are the same",
    ),
    "half of e": (changed(coupling=LN.coupling / 2), "the coupling of niobate differs by 50 % from that of LiNbO3"),
    "a wrong sign": (changed(coupling=LN.coupling * np.where(np.arange(6) == 5, -1, 1)), "coupling (1, 6) differs by"),
    "another material": (changed(name="pzt4"), "of pzt4 differs by"),
    "rotated to the cut": (
        changed(stiffness=fem.rotated(LN, "128YX").stiffness, coupling=fem.rotated(LN, "128YX").coupling,
                permittivity=fem.rotated(LN, "128YX").permittivity / EPS0),
        "already rotated to a cut, which orientation would rotate again",
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", REMARKED)
def test_tables_that_are_probably_wrong_are_remarked(name):
    material, words = REMARKED[name]
    if name == "order of Ansys":
        material["coupling"] = LN.coupling[:, ANSYS]
    (remark,) = remarks(material)
    assert remark.startswith("stator.material: the ")
    assert words in remark


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"units": {"stiffness": "GHz"}}, r"stator\.material\.units\.stiffness must be a stiffness"),
        ({"units": {"density": "g/cm^3"}}, r"stator\.material\.units\.density must be one of stiffness, compliance"),
        ({"units": {"coupling": "pC/N"}}, r"stator\.material\.units\.coupling must be a piezoelectric stress constant"),
        ({"order": "1 2 3 4 5 6"}, r'stator\.material\.order must be "11 22 33 23 13 12" or'),
        ({"compliance": S}, r"stator\.material\.compliance must be absent beside stiffness"),
        (
            {"stiffness_at": "constant D", "permittivity_at": "constant stress"},
            r"stator\.material\.stiffness_at must be",
        ),
        ({"form": "strain-charge", "stiffness_at": "constant D"}, r"stator\.material\.stiffness_at must be"),
    ],
)
def test_keys_that_contradict_each_other_are_refused(changes, sentence):
    with pytest.raises(SceneError, match=sentence):
        scene(TRUE | changes)
    with pytest.raises(SceneError, match=r"stator\.material\.stiffness is required and missing: give a 6x6 table"):
        scene(changed("stiffness"))
    with pytest.raises(SceneError, match=r"stator\.material\.form must be \"strain-charge\" with compliance"):
        scene(changed("stiffness", compliance=S))
