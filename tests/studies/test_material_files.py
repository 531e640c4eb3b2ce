"""Materials as files: shared by scenes, shown and copied by the command, and the constants of crystal classes."""

import json
import re
import textwrap
from pathlib import Path

import numpy as np
import pytest

import fem
from studies import Scene, SceneError
from studies.__main__ import main
from studies.model.fem_objects import solid
from studies.model.solid_of_material import crystal, named_solid
from studies.scene.block import keys_of
from studies.scene.stator_keys import PiezoelectricSolid

SCENE = """
[stator]
material = "{material}"
length = "10 mm"
thickness = "1 mm"
width = "5 mm"
ends = "absorbing"
orientation = "128YX"

[drive]
frequency = "10 MHz"
"""


def test_every_file_of_the_catalogue_is_a_material_of_a_scene(tmp_path, monkeypatch):
    """Copied and named by its file, it is the same solid; the words of classes are those of fem."""
    monkeypatch.chdir(tmp_path)
    assert keys_of(PiezoelectricSolid)["crystal_class"].rule.words == fem.CLASSES
    for known in fem.catalogue().values():
        Path("own.toml").write_text(fem.catalogue_text(known.name))
        _, found = named_solid("own.toml")
        assert found.name == known.name
        for key in ("stiffness", "coupling", "permittivity", "density"):
            assert getattr(found, key) == pytest.approx(getattr(known, key), rel=1e-12, abs=1e-25)


def test_names_and_aliases_are_found_as_people_write_them():
    for name, expected in (
        ("LiNbO3", "LiNbO3 (Kovacs)"), ("lithium niobate", "LiNbO3 (Kovacs)"), ("pzt8", "PZT-8"), ("PZT 5h", "PZT-5H"),
        ("Quartz", "quartz (Bechmann)"), ("Al", "aluminium"), ("linbo3(warner)", "LiNbO3 (Warner)"),
    ):  # fmt: skip
        assert fem.material(name).name == expected
    files = {path.stem for path in (Path(fem.__file__).parent / "materials" / "catalogue").glob("*.toml")}
    stems = {re.sub("[^a-z0-9]+", "-", name.casefold()).strip("-") for name in fem.catalogue()}
    assert files == stems
    plain = ["".join(each.split()).replace("-", "").casefold() for each in fem.material_names()]
    assert len(set(plain)) == len(plain)


def test_scenes_share_a_file_from_their_own_folder(tmp_path, monkeypatch, capsys):
    """The scene that is written back holds the table, so that it does not change with the file."""
    (tmp_path / "lab").mkdir()
    monkeypatch.chdir(tmp_path)
    assert main(["materials", "LiNbO3", "--copy", "lab/ours.toml"]) == 0
    file = tmp_path / "lab" / "ours.toml"
    file.write_text(file.read_text().replace("density = 4628.0", 'density = "4.65 g/cm^3"'))
    (tmp_path / "lab" / "scene.toml").write_text(SCENE.format(material="ours.toml"))
    scene = Scene.load("lab/scene.toml")
    assert solid(scene.stator).density == 4650.0
    written = scene.to_table()
    assert written["stator"]["material"]["density"] == 4650.0
    file.unlink()
    assert solid(Scene.from_table("", written).stator) == solid(scene.stator)
    assert main(["check", "lab/scene.toml"]) == 2
    assert "stator.material names the file" in capsys.readouterr().err


def test_faults_of_a_file_name_the_file_and_the_key(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE.format(material="ours.toml"))
    for text, words in (
        (
            "density = 7600\nyoungs_modulus = 1e11\npoisson_ratio = 0.3\ncolour = 'red'",
            "ours.toml: stator.material.colour",
        ),
        ("density = ", "is no TOML"),
        (
            "density = 7600",
            "ours.toml: stator.material.stiffness is required and missing: give a 6x6 table of numbers, or",
        ),
    ):
        (tmp_path / "ours.toml").write_text(text)
        with pytest.raises(SceneError) as error:
            Scene.load("scene.toml")
        assert words in str(error.value)


CERAMIC = """
    crystal_class = "6mm"
    form = "strain-charge"
    density = "7.5 g/cm^3"
    units = { compliance = "1/TPa", coupling = "pC/N" }
    [constants]
    s11 = 16.5
    s12 = -4.78
    s13 = -8.45
    s33 = 20.7
    s44 = 43.5
    d15 = 741
    d31 = -274
    d33 = 593
    eps11 = 3130
    eps33 = 3400
    """


def test_a_data_sheet_s_constants(tmp_path):
    """PZT-5H as its data sheet gives it, in strain-charge form; c^E, e and eps^S are published too."""
    file = tmp_path / "pzt.toml"
    file.write_text(textwrap.dedent(CERAMIC))
    _, found = named_solid(str(file))
    known = fem.material("PZT-5H")
    assert found.name == "pzt"
    assert found.stiffness == pytest.approx(known.stiffness, rel=0.02, abs=1e8)
    assert found.coupling == pytest.approx(known.coupling, rel=0.02, abs=1e-9)
    assert found.permittivity == pytest.approx(known.permittivity, rel=0.03, abs=1e-14)


@pytest.mark.parametrize("name", ["LiNbO3 (Kovacs)", "quartz (Bechmann)"])
def test_compliances_of_a_trigonal_class(name):
    """The inverse of a trigonal stiffness, by its independent entries: factors 2 in s56, s66, d16."""
    known = fem.material(name)
    compliance = np.linalg.inv(known.stiffness)
    charge = known.coupling @ compliance
    stress = known.permittivity + charge @ known.coupling.T
    own = fem.catalogue_table(name)
    names = fem.constant_names(own["crystal_class"], compliant=True)
    tables = {"s": compliance, "d": charge, "e": stress / fem.VACUUM_PERMITTIVITY}
    constants = {each: float(tables[each[0]][int(each[-2]) - 1, int(each[-1]) - 1]) for each in names}
    found, coupling, _ = fem.class_tables(own["crystal_class"], constants, compliant=True)
    assert found == pytest.approx(compliance, rel=1e-12, abs=1e-25)
    assert coupling == pytest.approx(charge, rel=1e-9, abs=1e-22)
    material = {
        "crystal_class": own["crystal_class"],
        "form": "strain-charge",
        "density": 4628.0,
        "constants": constants,
    }
    table = {"stator": {"material": material, "length": 0.01, "thickness": 1e-3, "width": 5e-3, "ends": "free"}}
    scene = Scene.from_table("", table | {"drive": {"frequency": 1e7}})
    assert crystal(scene.stator.material).coupling == pytest.approx(known.coupling, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"constants": {"c11": 1e11}}, r"constants must be c11, c12, c13, c33, c44, e15.* of class 6mm, got c12, c13"),
        ({"crystal_class": "7mm"}, r"crystal_class must be \"6mm\" or"),
        ({"crystal_class": None}, r"crystal_class is required and missing beside constants"),
        ({"permittivity": np.eye(3).tolist()}, r"permittivity must be absent beside constants"),
        ({"order": "11 22 33 12 23 13"}, r"order must be absent beside constants"),
    ],
)
def test_constants_that_do_not_fit_are_refused(changes, sentence):
    own = {"crystal_class": "6mm", "density": 7500.0, "constants": dict(fem.catalogue_table("PZT-4")["constants"])}
    material = {key: value for key, value in (own | changes).items() if value is not None}
    table = {"stator": {"material": material, "length": 0.01, "thickness": 1e-3, "width": 5e-3, "ends": "free"}}
    with pytest.raises(SceneError, match=r"stator\.material\." + sentence):
        Scene.from_table("", table | {"drive": {"frequency": 1e7}})


def test_the_command_lists_and_shows_materials(capsys, tmp_path):
    assert main(["materials"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in fem.catalogue())
    assert main(["materials", "LiNbO3", "--json"]) == 0
    shown = json.loads(capsys.readouterr().out)
    assert (shown["name"], shown["class"], shown["density_kg_per_m3"]) == ("LiNbO3 (Kovacs)", "3m", 4628.0)
    assert shown["cuts"]["128YX"]["velocity_m_per_s"] == pytest.approx(3979, abs=1.0)
    assert main(["materials", "PZT-8"]) == 0
    text = capsys.readouterr().out
    assert "surface wave 2181.91 m/s, K2 1.78 %" in text
    file = tmp_path / "ours.toml"
    file.write_text(fem.catalogue_text("LiNbO3").replace("c33 = 227.9", "c33 = 127.9"))
    assert main(["materials", str(file)]) == 0
    assert "stiffness of LiNbO3 (Kovacs) differs by" in capsys.readouterr().err
    assert main(["materials", "unobtainium"]) == 2
    assert main(["materials", "PZT-8", "--copy", "x.txt"]) == 2
