"""A scene as text, with each number's size in a unit of its order beside it."""

from collections.abc import Iterator

from studies.record.prefixes import si
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.toml import document

# units that take a prefix, the unit that is written instead, and its size
WRITTEN = {unit: (unit, 1.0) for unit in ("m", "s", "Hz", "N", "Pa", "V", "ohm", "m/s", "N s/m")} | {"kg": ("g", 1e-3)}


def scene_text(scene: Scene, written: dict | None = None) -> str:
    """Return the TOML text of a resolved scene, with the size of each number that has a unit in a comment.

    Parameters
    ----------
    scene : Scene
    written : dict, optional
        The table of its file: what stands there as text, such as "5.74 V" or "auto", is the comment as it was written.
    """
    table = scene.to_table()
    return document(table, beside=dict(_sizes("", table, [type(scene)])) | dict(_texts("", written or {}, table)))


def _texts(path: str, written: dict, table: dict) -> Iterator[tuple[str, str]]:
    """Yield dotted key and text of what a file holds as text and the resolved scene as something else."""
    for key, value in written.items():
        resolved = table.get(key)
        if isinstance(value, dict) and isinstance(resolved, dict):
            yield from _texts(f"{path}{key}.", value, resolved)
        elif isinstance(value, list) and value and all(isinstance(each, dict) for each in value):
            for number, (one, other) in enumerate(zip(value, resolved or [], strict=False)):
                yield from _texts(f"{path}{key}.{number}.", one, other)
        elif isinstance(value, list) and value and all(isinstance(each, str) for each in value):
            yield f"{path}{key}", ", ".join(value)
        elif isinstance(value, str) and resolved is not None and not isinstance(resolved, (str, dict)):
            yield f"{path}{key}", value


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
