"""The reference of all keys of a scene: ``studies/scenes/README.md`` and the JSON Schema, for an editor's completion.

``python -m studies.scene.reference`` writes both from the blocks and the catalogue; the text before the tables is
written by hand. The schema (draft 2020-12) holds the rules of single keys; combinations of keys and the geometry are
checked by the program alone. Quantities may have the usual units; the program reads every unit of the right dimension.
"""

import json
from collections.abc import Sequence

import fem
from studies.scene import (
    adhesion_keys,
    drive,
    friction,
    pillar_keys,
    plane_keys,
    roughness_keys,
    slider_keys,
    stator_keys,
    waveform_keys,
)
from studies.scene.block import Block, block_schema, keys_of
from studies.scene.file import SCHEMA, SHIPPED, shipped_scenes
from studies.scene.scene import Scene

BLOCKS = {
    "The file": Scene,
    "[stator]": stator_keys.Stator,
    "[stator.cooling]": stator_keys.Cooling,
    "[[stator.layer]]": stator_keys.Layer,
    "[stator.layer.bond]": stator_keys.Bond,
    "[stator.material.temperature]": stator_keys.TemperatureCoefficients,
    "[[transducer]]": stator_keys.Transducer,
    "[[piece]]": stator_keys.Piece,
    "[drive]": drive.Drive,
    "[[drive.match]]": drive.Element,
    "[drive.recovery]": drive.Recovery,
    "[drive.waveform]": waveform_keys.Waveform,
    "[wave]": drive.Wave,
    "[[wave.sources]]": plane_keys.WaveSource,
    "[slider]": slider_keys.Slider,
    "[slider.damping]": slider_keys.Damping,
    "[slider.friction_coefficient]": friction.Friction,
    "[slider.law]": friction.LawText,
    "[slider.normal_law]": adhesion_keys.NormalLawText,
    "[slider.adhesion]": adhesion_keys.Adhesion,
    "[slider.pillars]": pillar_keys.Pillars,
    "[slider.roughness]": roughness_keys.Roughness,
    "[stator.material], a piezoelectric crystal or ceramic": stator_keys.PiezoelectricSolid,
    "[stator.material], an isotropic solid": stator_keys.IsotropicSolid,
}
PAGE = SHIPPED / "README.md"
MARK = "<!-- From here on: generated from the blocks and the catalogue by `python -m studies.scene.reference`. -->\n"


def reference() -> str:
    """Return the text of ``studies/scenes/README.md``: the part that is written by hand, and the tables."""
    parts = [PAGE.read_text(encoding="utf-8").partition(MARK)[0] + MARK]
    for header, kind in BLOCKS.items():
        name = f"`{header}`" if header.startswith("[") and "," not in header else header
        parts.append(f"## {name}\n\n{(kind.__doc__ or '').splitlines()[0]}\n\n{_keys(kind)}\n")
    shipped = _table([("name", "title"), *((f"`{name}`", Scene.load(name).title) for name in shipped_scenes())])
    return "\n".join([*parts, f"## Materials\n\n{_materials()}\n", f"## Scenes that ship\n\n{shipped}\n"])


def _keys(kind: type[Block]) -> str:
    rows = [("key", "unit", "default", "allowed", "meaning")]
    for name, key in keys_of(kind).items():
        default = "required" if key.required else _written(key.rule, key.default)
        rows.append((f"`{name}`", key.rule.unit or "-", default, key.rule.range, key.meaning))
    return _table(rows)


def _written(rule, default) -> str:
    if default in (None, (), "") or isinstance(default, Block):
        return "-"
    return f"`{json.dumps(rule.written(default))}`"


def _materials() -> str:
    rows = [("name", "also", "class", "density (kg/m^3)", "Q", "tan delta", "source", "confirmed by")]
    for name, solid in fem.catalogue().items():
        lossless = solid.mechanical_quality == float("inf")
        own, quality = fem.catalogue_table(name), f"{solid.mechanical_quality:g}"
        numbers = (f"{solid.density:g}", "lossless" if lossless else quality, f"{solid.dielectric_loss:g}")
        aliases = ", ".join(f"`{each}`" for each in own.get("aliases", ())) or "-"
        kind, confirmed = own.get("crystal_class", "isotropic"), own.get("confirmed", "-")
        rows.append((f"`{name}`", aliases, kind, *numbers, solid.source, confirmed))
    text = "`stator.mechanical_quality` and `stator.dielectric_loss` replace a material's own Q and tan delta. "
    text += (
        "Sets of constants of one material differ between authors by more than this program's errors. The last column "
    )
    text += "has published values that a test computes from the constants; - where none was found. "
    text += "Second-hand: quoted from other works, not compared with the paper itself.\n\n"
    return text + _table(rows)


def _table(rows: Sequence[tuple[str, ...]]) -> str:
    lines = [" | ".join(("", *(cell.replace("|", "\\|") for cell in row), "")).strip() for row in rows]
    lines.insert(1, "|" + "---|" * len(rows[0]))
    return "\n".join(lines)


def schema() -> dict:
    """Return the JSON Schema of a scene."""
    isotropic = [name for name in fem.material_names() if "youngs_modulus" in fem.catalogue_table(name)]
    whole = block_schema(Scene)
    stator, slider = (whole["properties"][name]["properties"] for name in ("stator", "slider"))
    stator["material"]["anyOf"][1] = {"enum": list(fem.material_names())}
    slider["ball"] = {"description": slider["ball"]["description"], "enum": isotropic}
    slider_block, drive = whole["properties"]["slider"], whole["properties"]["drive"]
    slider_block["anyOf"] = [{"required": ["ball"]}, {"required": ["effective_modulus", "tangential_modulus"]}]
    driven = {"anyOf": [{"required": ["transducer"]}, {"required": ["sources"]}]}
    drive["oneOf"] = [
        {"required": ["voltage"], "properties": {"power": False}, **driven},
        {"required": ["power"], "properties": {"voltage": False}, **driven},
        {"properties": dict.fromkeys(("voltage", "power", "transducer", "sources"), False)},
    ]
    computed = {"required": ["stator", "drive"], "properties": {"wave": False}}
    absent = dict.fromkeys(("stator", "transducer", "drive"), False)
    with_wave = {"required": ["wave", "slider"], "properties": absent}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A scene of sawmotor",
        **whole,
        "anyOf": [computed, with_wave],
    }


def schema_text() -> str:
    """Return the schema as the text of its file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    PAGE.write_text(reference(), encoding="utf-8")
    PAGE.with_name(SCHEMA).write_text(schema_text(), encoding="utf-8")
