"""A scene as text, with each number's size in a unit of its order beside it."""

from studies.record.prefixes import si
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.toml import document

# units that take a prefix, the unit that is written instead, and its size
WRITTEN = {unit: (unit, 1.0) for unit in ("m", "s", "Hz", "N", "Pa", "V", "ohm", "m/s", "N s/m")} | {"kg": ("g", 1e-3)}


def scene_text(scene: Scene) -> str:
    """Return the TOML text of a resolved scene; each number with a unit is repeated in a comment with an SI prefix."""
    table = scene.to_table()
    return document(table, beside=dict(_sizes("", table, [type(scene)])))


def _sizes(path: str, table: dict, kinds):
    """Yield dotted key and size of each number with a unit in a table whose classes may be ``kinds``."""
    for key, value in table.items():
        for rule in [keys_of(kind)[key].rule for kind in kinds if key in keys_of(kind)]:
            inner = getattr(rule, "kinds", ())
            if isinstance(value, dict):
                yield from _sizes(f"{path}{key}.", value, inner)
            elif isinstance(value, list) and value and isinstance(value[0], dict):
                for number, each in enumerate(value):
                    yield from _sizes(f"{path}{key}.{number}.", each, inner)
            elif isinstance(value, float) and (unit := getattr(rule, "unit", "")) in WRITTEN:
                written, size = WRITTEN[unit]
                yield f"{path}{key}", si(value / size, written, 7)
