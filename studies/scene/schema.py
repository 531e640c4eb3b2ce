"""A JSON Schema (draft 2020-12) of a scene file, for completion and checks in an editor.

It holds the rules of single keys; combinations of keys and the geometry are checked by the program alone. Quantities
may have the usual units; the program reads every unit of the right dimension.
"""

import json

import fem
from studies.scene.block import block_schema
from studies.scene.scene import Scene


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
