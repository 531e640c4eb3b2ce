"""The JSON Schema of a scene: it accepts what the program reads and refuses what it refuses, key by key.

Oracle: the draft 2020-12 validator of the library ``jsonschema``; the scene's own reader.
"""

import json
import re
import tomllib
from dataclasses import fields
from pathlib import Path

import jsonschema
import pytest

from studies import Scene, SceneError
from studies.__main__ import main
from studies.model.resolve import resolved
from studies.scene import read_table, shipped_scenes
from studies.scene.block import Block, Blocks, Within, keys_of
from studies.scene.file import SCHEMA as FILE_NAME
from studies.scene.quantity import POWERS, si_value
from studies.scene.reference import BLOCKS, schema, schema_text

SCHEMA = schema()
VALIDATOR = jsonschema.Draft202012Validator(SCHEMA)
PILLARS = {"diameter": "20 um", "pitch": "50 um", "rows": 5, "columns": 4}
GOOD = {  # a value for every key that is given in no shipped scene, by its dotted path
    "uncertain": [{"slider": {"preload": "+- 5 %"}, "method": "sampled", "samples": 50}],
    "stator.orientation": ["X", [0, 38, 0], "64YX", "41.5 YX", "128° Y-X", "36-YX", "X-112Y", "ZX", "XY"],
    "stator.euler_convention": ["SAW", "COMSOL", "sawsim"],
    "stator.thickness": ["half-space", "5 mm", 5e-3],
    "stator.bottom": ["grounded", "clamped"],
    "stator.above": ["vacuum"],
    "stator.mechanical_quality": [700],
    "stator.dielectric_loss": [0, 0.01],
    "stator.diffraction": [True, False],
    "drive.duty": [0.1, 1],
    "stator.temperature": ["steady", 60, "60 degC"],
    "stator.temperature_coefficient": [-4e-5, "-75e-6 1/K"],
    "stator.material.temperature": [{"first": {"c11": -1e-4}, "expansion": [1e-5, 1e-5, 7e-6]}],
    "stator.cooling": [{"air": "8 W/(m^2 K)", "bottom": "held"}, {}],
    "stator.cooling.air": [0.5, "10 W/(m^2 K)"],
    "stator.cooling.bottom": ["air", "held", "2000 W/(m^2 K)", 500],
    "stator.cooling.ends_heat_stator": [0, 1],
    "stator.cooling.ambient": [-20, 25.5, "25 degC"],
    "stator.sides": ["mirror"],
    "stator.layer": [[{"material": "fused silica", "thickness": "20 um"}], []],
    "stator.layer.0.material": ["AlN", {"youngs_modulus": "70 GPa", "poisson_ratio": 0.3, "density": 2700}],
    "stator.layer.0.orientation": ["X", [0, 38, 0], "64YX"],
    "stator.layer.0.euler_convention": ["SAW", "COMSOL", "sawsim"],
    "stator.layer.0.thickness": ["20 um", 2e-5, "0.05 lambda", "1e-3 \u03bb", ".5lambda"],
    "stator.layer.0.bond": [{"normal": "1e15 N/m^3", "tangential": 3e14}],
    "stator.layer.0.bond.normal": [1e15, "1e15 Pa/m"],
    "stator.layer.0.bond.tangential": [1e15, "3e14 N/m^3"],
    "transducer.0.plane": ["surface"],
    "stator.material": ["LiNbO3", {"youngs_modulus": "70 GPa", "poisson_ratio": 0.3, "density": 2700, "name": "x"}],
    "transducer.0.period": ["auto", "0.99 mm"],
    "transducer.0.termination": ["short", "50 ohm", [50, -3]],
    "transducer.0.pattern": ["+-" * 10],
    "transducer.0.split": [True],
    "transducer.0.cell": ["plain", "DART", "EWC"],
    "transducer.0.mirrored": [True],
    "transducer.0.chirp": [0, 0.1, -0.5],
    "transducer.0.apodisation": ["cosine", "hamming", 0.5, [1, 0.5] * 10],
    "transducer.0.slant": [0, 0.1, -0.5],
    "transducer.0.slant_strips": [4],
    "transducer.0.angle": ["30 deg", 360],
    "transducer.0.center": ["15 mm", ["20 mm", "-2 mm"]],
    "piece": [[{"file": "groove.msh", "length_unit": "mm", "position": "40 mm"}]],
    "piece.0.name": ["groove"],
    "piece.0.file": ["meshes/groove.msh"],
    "piece.0.length_unit": ["um"],
    "piece.0.position": [0.04, ["40 mm", "41 mm"], "40 mm : 50 mm : 5", "-1 mm"],
    "piece.0.materials": [{"strip": "aluminium"}],
    "piece.0.electrodes": [{"strip": "floating", "a": "left+"}],
    "drive.frequency": ["2200 kHz", 2.2e6],
    "drive.burst": ["10 ms"],
    "drive.waveform": [{"shape": "ramp", "rise": "1 ms"}, {"file": "drive.csv"}],
    "drive.waveform.shape": ["ramp"],
    "drive.waveform.rise": [0, "1 ms"],
    "drive.waveform.fall": [0, "1 ms"],
    "drive.waveform.depth": [0, 0.5, 1],
    "drive.waveform.frequency": ["1 kHz"],
    "drive.waveform.sweep": [["-10 kHz", 1e4]],
    "drive.waveform.file": ["drive.csv"],
    "wave.waveform": [{"shape": "ramp", "fall": "1 ms"}],
    "wave.waveform.shape": ["ramp"],
    "wave.waveform.rise": [0, "1 ms"],
    "wave.waveform.fall": [0, "1 ms"],
    "wave.waveform.depth": [0, 0.5, 1],
    "wave.waveform.frequency": ["1 kHz"],
    "wave.waveform.sweep": [["-10 kHz", 1e4]],
    "wave.waveform.file": ["drive.csv"],
    "drive.voltage": [10, ["5 V", 6], "20:100:5", "1 V : 1 kV : 4 : log"],
    "slider.friction_coefficient": [0.08, "0.08 +- 0.02", "0.08 +/- 20 %"],
    "slider.radius": ["1 mm", "1 +- 0.01 mm", "1 mm±1 %", "1 mm +- 2 um"],
    "drive.source_impedance": [50, [1, 2]],
    "drive.power": ["1 W", [0.5, "20 mW"]],
    "drive.match": ["auto", [{"series_L": "2.6 uH", "Q": 80}, {"shunt_C": 1e-9}, {"series_R": "3 ohm"}]],
    "drive.recovery": [{"receiver": "right", "load": [70, -3]}],
    "drive.recovery.receiver": ["right"],
    "drive.recovery.load": ["matched", "70 ohm"],
    "drive.recovery.rectifier": ["80 ohm"],
    "drive.recovery.efficiency": [0.9],
    "drive.recovery.circulation": [True],
    "drive.source_frequencies": [{"left": "2.3 MHz"}],
    "drive.sources": [{"left": 1, "right": "0.5 at 90 deg"}, {"right": [0.3, -1]}],
    "slider.contacts": [2, ["-1 mm", 0, "1 mm"]],
    "slider.shape": ["punch"],
    "slider.heights": [["0 nm", "-3 nm", 2e-9]],
    "slider.preload": ["weight", "5 mN", 0],
    "slider.gravity": [0],
    "slider.load": ["1 uN"],
    "slider.freedom": ["x", "xy", "xy yaw"],
    "slider.axis": [["1 mm", 0]],
    "slider.inertia": ["2 g mm^2", 1e-9],
    "slider.torque": ["-1 uN m", 0],
    "slider.incline": [["1 deg", -2]],
    "slider.law": ["hysteretic"],
    "slider.normal_law": [{"name": "stiff.py", "source": "def force(approach, contact): return 3e9 * approach**1.5"}],
    "slider.adhesion": [
        {"work": "0.05 J/m^2", "model": "DMT"},
        {"surface_tension": "72 mN/m", "contact_angle": "30 deg", "model": "meniscus"},
    ],
    "slider.adhesion.model": ["DMT", "JKR", "Maugis"],
    "slider.adhesion.separation": ["0.3 nm", 2e-10],
    "slider.adhesion.work": ["0.05 J/m^2", "50 mJ/m^2", 0.05],
    "slider.adhesion.surface_tension": ["0.072 N/m"],
    "slider.adhesion.contact_angle": ["30 deg", 0],
    "slider.position": ["80 mm", ["80 mm", "-2 mm"], "80 +- 0.1 mm"],
    "slider.travel": [False],
    "slider.reciprocal": [True],
    "slider.stick_band": ["1 mm/s"],
    "slider.method": ["exact"],
    "slider.damping.contact": [0.1],
    "slider.pillars": [PILLARS, {"file": "pillars.csv", "diameter": "20 um"}],
    "slider.pillars.diameter": ["20 um"],
    "slider.pillars.height": ["2 um"],
    "slider.pillars.pitch": ["50 um", [50e-6, "60 um"]],
    "slider.pillars.rows": [10],
    "slider.pillars.columns": [10],
    "slider.pillars.area": ["1 mm", ["1 mm", 2e-3]],
    "slider.pillars.height_scatter": ["10 nm", 0],
    "slider.pillars.seed": [0, 7],
    "slider.pillars.file": ["pillars.csv"],
    "slider.pillars.width": ["5 mm"],
    "slider.roughness": [{"rms": "3 nm"}, {"rms": 3e-9, "seed": 1}, {"file": "patch.npy", "step": "20 nm"}],
    "slider.roughness.rms": ["3 nm"],
    "slider.roughness.asperity_radius": ["10 um"],
    "slider.roughness.density": ["1.7 1/um^2", 1.7e12],
    "slider.roughness.seed": [0, 7],
    "slider.roughness.file": ["patch.gwy"],
    "slider.roughness.step": ["20 nm"],
    "slider.pillars.curvature": ["-0.1 1/m", 0],
    "slider.pillars.interaction": [True],
    "slider.pillars.youngs_modulus": ["162 GPa"],
    "slider.pillars.poisson_ratio": [0.22],
    "slider.tilt": ["pitch", "free"],
    "slider.preload_at": [["1 mm", 0]],
    "slider.load_height": ["1 mm"],
    "slider.backing": ["soft"],
    "slider.loading": [True, False],
    "wave.wavelength": ["0.4 mm"],
    "wave.sources": [[{"direction": "90 deg", "phase": "90 deg"}]],
    "wave.sources.0.normal_amplitude": ["10 nm"],
    "wave.sources.0.tangential_ratio": [0.7],
    "wave.sources.0.direction": [90, "-30 deg"],
    "wave.sources.0.phase": [90, "-30 deg"],
    "wave.sources.0.frequency": ["2.3 MHz"],
    "wave.compliance": ["2.5e-12 1/Pa", 2.5e-12],
}
OF_PILLARS = ("slider.tilt", "slider.preload_at", "slider.load_height", "slider.backing", "slider.loading")
TURNING = ("slider.inertia", "slider.torque")
BAD = ([[]], "5 furlongs per apple", -1e31, {"method": "quick"})


def keys_with_paths(kind=Scene, at=""):
    """Every key of a scene with its dotted path; the first transducer stands for all, tables of constants apart."""
    for name, key in keys_of(kind).items():
        path = f"{at}.{name}" if at else name
        yield path, key
        if isinstance(key.rule, Within):
            yield from keys_with_paths(key.rule.kinds[0], path)
        elif isinstance(key.rule, Blocks):
            yield from keys_with_paths(key.rule.kinds[0], f"{path}.0")


PATHS = dict(keys_with_paths())


def changed(path: str, value) -> dict:
    """The table of a shipped scene that has the block, with one key set."""
    table = json.loads(json.dumps(read_table("twente-contact" if path.startswith("wave") else "twente")))
    if path == "slider.ball":
        del table["slider"]["effective_modulus"], table["slider"]["tangential_modulus"]
    if path in ("drive.power", "drive.match"):
        table["drive"]["source_impedance"] = 50
    if path == "drive.power":
        del table["drive"]["voltage"]
    if path.startswith("drive.recovery."):
        table["drive"]["recovery"] = {"receiver": "right"}
    block, _, key = path.partition(".waveform")
    if key or path.endswith(".waveform"):
        own = {".depth": {"shape": "modulated", "frequency": 1e3}, ".frequency": {"shape": "modulated", "depth": 0.5}}
        own |= {".sweep": {"shape": "chirp"}, ".file": {}}
        table[block] |= {"burst": 0.01, "waveform": own.get(key, {"shape": "ramp", "rise": "1 ms", "fall": "1 ms"})}
    if path == "transducer.0.mirrored":
        table["transducer"][0]["cell"] = "DART"
    if path.startswith("piece"):
        table["piece"] = [{"file": "groove.msh", "length_unit": "mm", "position": "40 mm"}]
    if path == "slider.heights":
        table["slider"]["contacts"] = ["-1 mm", 0, "1 mm"]
    if path.startswith("slider.adhesion."):
        wet = path.endswith(("surface_tension", "contact_angle"))
        dry = {"work": 0.05, "model": "Maugis" if path.endswith("separation") else "DMT"}
        table["slider"]["adhesion"] = {"surface_tension": 0.072, "model": "meniscus"} if wet else dry
    if path.startswith("slider.roughness."):
        own = {"slider.roughness.file": {}, "slider.roughness.step": {"file": "patch.npy"}}
        table["slider"]["roughness"] = own.get(path, {"rms": "3 nm"})
    if path.startswith("slider.pillars") or path in OF_PILLARS:
        own = {"slider.pillars.file": {"diameter": "20 um"}, "slider.pillars.area": dict(list(PILLARS.items())[:2])}
        del table["slider"]["radius"], table["slider"]["contacts"]
        table["slider"]["pillars"] = dict(own.get(path, PILLARS))
    if path in (*TURNING, "slider.incline", "slider.freedom", "drive.source_frequencies") or "wave.sources" in path:
        table["slider"]["freedom"] = "xy yaw"
        table["slider"]["contacts"] = [["1 mm", 0], ["-1 mm", "1 mm"], ["-1 mm", "-1 mm"]]
    if path == "drive.source_frequencies":
        table["drive"]["sources"] = {"left": 1, "right": 1}
    if path.startswith("wave.sources"):
        table["wave"] |= {"wavelength": "1 mm", "sources": [{}]}
    if path.startswith("stator.layer."):
        bond = {"bond": {"normal": 1e15, "tangential": 1e15}} if path.startswith("stator.layer.0.bond.") else {}
        table["stator"]["layer"] = [{"material": "fused silica", "thickness": "20 um"} | bond]
    if path.startswith("stator.cooling."):
        table["stator"]["cooling"] = {}
    holder = table
    *blocks, last = [int(part) if part.isdigit() else part for part in path.split(".")]
    for block in blocks:
        holder = holder[block]
    holder[last] = value
    return table


def test_the_schema_is_one():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)


def test_the_file_beside_the_shipped_scenes_is_current(capsys):
    """It is written by ``python -m studies.scene.reference``."""
    assert main(["schema"]) == 0
    assert capsys.readouterr().out == schema_text()
    assert (shipped_scenes()["twente"].parent / FILE_NAME).read_text(encoding="utf-8") == schema_text()


@pytest.mark.parametrize("name", sorted(shipped_scenes()))
def test_a_shipped_scene_is_valid_and_names_the_schema(name):
    text = shipped_scenes()[name].read_text(encoding="utf-8")
    assert text.startswith(f"#:schema {FILE_NAME}\n")
    VALIDATOR.validate(tomllib.loads(text))
    VALIDATOR.validate(Scene.load(name).to_table())


def test_every_key_of_every_block_is_in_the_schema():
    documented = {(kind, name) for kind in BLOCKS.values() for name in keys_of(kind)}
    assert {(kind, entry.name) for kind in BLOCKS.values() for entry in fields(kind)} == documented
    assert set(BLOCKS.values()) == {*Block.__subclasses__()}
    for path, key in PATHS.items():
        node = SCHEMA
        for part in path.split("."):
            node = node["items"] if part == "0" else node["properties"][part]
        assert node["description"].startswith(key.meaning), path


@pytest.mark.parametrize("path", sorted(PATHS))
def test_a_key_takes_in_the_schema_what_the_program_reads(path):
    values = GOOD.get(path)
    if values is None:
        value = _value(read_table("twente-contact" if path.startswith("wave") else "twente"), path)
        values = [] if value is None else [value]
    if path == "slider.ball":
        values = ["steel"]
    if path == "wave.burst":
        values = ["1 ms"]
    assert values, f"no example of {path}"
    for value in values:
        table = changed(path, value)
        Scene.from_table("", table)
        VALIDATOR.validate(table)


@pytest.mark.parametrize("path", sorted(PATHS))
def test_a_key_refuses_in_the_schema_what_the_program_refuses(path):
    refused = [value for value in BAD if not VALIDATOR.is_valid(changed(path, value))]
    assert refused
    for value in refused:
        with pytest.raises(SceneError):
            resolved(Scene.from_table("", changed(path, value)))


@pytest.mark.parametrize(
    ("path", "value"),
    [
        ("drive.voltage", "20:100"),
        ("drive.voltage", "20 kg:100 kg:5"),
        ("slider.friction_coefficient", "0.08+-0.02"),
        ("slider.radius", "1 mm +- 1 kg"),
    ],
)
def test_what_is_no_range_and_no_tolerance_is_neither_in_the_schema(path, value):
    with pytest.raises(SceneError):
        resolved(Scene.from_table("", changed(path, value)))
    with pytest.raises(jsonschema.ValidationError):
        VALIDATOR.validate(changed(path, value))


@pytest.mark.parametrize("path", [path for path, key in PATHS.items() if key.required and path != "stator.material"])
def test_a_missing_key_is_missed_by_the_schema(path):
    table = changed(path, None)
    *blocks, last = [int(part) if part.isdigit() else part for part in path.split(".")]
    holder = table
    for block in blocks:
        holder = holder[block]
    del holder[last]
    with pytest.raises(jsonschema.ValidationError):
        VALIDATOR.validate(table)


@pytest.mark.parametrize(
    "table",
    [
        {},
        {"stator": read_table("twente")["stator"]},
        read_table("twente") | {"sliders": {}},
        read_table("twente") | {"wave": read_table("twente-contact")["wave"]},
        {"wave": read_table("twente-contact")["wave"]},
    ],
    ids=["empty", "no drive", "unknown block", "stator and wave", "wave alone"],
)
def test_blocks_that_do_not_go_together(table):
    with pytest.raises(SceneError):
        Scene.from_table("", table)
    with pytest.raises(jsonschema.ValidationError):
        VALIDATOR.validate(table)


@pytest.mark.parametrize("unit", sorted(unit for unit in POWERS if unit))
def test_the_pattern_of_a_unit_accepts_what_is_read(unit):
    from studies.scene.numbers import Quantity

    pattern = Quantity(unit, negative=True).schema()["anyOf"][1]["pattern"]
    for name in POWERS[unit]:
        glued = () if name[0].isdigit() else (f"-2.5e-3{name}",)
        for text in (f"1 {name}", *glued, f" .5  {name} ", f"+7. {name}"):
            assert re.search(pattern, text), text
            si_value("key", text, unit)
    for text in ("1", f"1,5 {unit}", "5 apples", f"{unit} 1"):
        assert not re.search(pattern, text), text


def _value(table, path):
    for part in path.split("."):
        table = table[int(part)] if isinstance(table, list) else table.get(part) if table else None
    return table


def test_a_shipped_scene_is_copied_to_start_from(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert main(["scenes", "--copy", "twente", "motor.toml"]) == 0
    assert "sawmotor run motor.toml" in capsys.readouterr().out
    assert Scene.load("motor.toml") == Scene.load("twente")
    named = Path("motor.toml").read_text().splitlines()[0].removeprefix("#:schema file://")
    assert json.loads(Path(named).read_text()) == SCHEMA
    Path("motor.toml").write_text("mine")
    assert main(["scenes", "--copy", "twente", "motor.toml"]) == 2
    assert main(["scenes", "--copy", "twent", "other.toml"]) == 2
    assert main(["scenes", "--copy", "twente", "nowhere/motor.toml"]) == 2
    said = capsys.readouterr().err.splitlines()
    assert Path("motor.toml").read_text() == "mine"
    assert ["does not overwrite" in said[0], "did you mean twente?" in said[1], len(said)] == [True, True, 3]


def test_a_copied_scene_brings_its_meshes(tmp_path, capsys, monkeypatch):
    """The copy passes its check in a directory of its own, and a mesh that was changed there is not overwritten."""
    monkeypatch.chdir(tmp_path)
    assert main(["scenes", "--copy", "reflector", "motor.toml"]) == 0
    assert main(["check", "motor.toml"]) == 0
    assert "meshes/groove.msh" in capsys.readouterr().out
    assert main(["scenes", "--copy", "reflector", "again.toml"]) == 0
    Path("meshes/groove.msh").write_text("mine")
    assert main(["scenes", "--copy", "reflector", "third.toml"]) == 2
    assert "does not overwrite 'meshes/groove.msh'" in capsys.readouterr().err
    assert Path("meshes/groove.msh").read_text() == "mine"
    assert not Path("third.toml").exists()
