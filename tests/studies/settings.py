"""Settings of a scene's table, as ``--set KEY=VALUE`` makes them; ``-KEY`` leaves a key or a block out."""

from functools import reduce
from pathlib import Path

from studies.scene import Scene, read_table
from studies.scene.override import replaced, setting_of

# A stator of 24 wavelengths in the place of the 160 mm of "twente-left", with a period for which no section is solved
SHORT = (
    "stator.length=24 mm", "stator.thickness=2 mm", "transducer.0.center=5 mm", "transducer.0.finger_pairs=3",
    "transducer.0.period=0.98 mm", "slider.position=14.123 mm",
)  # fmt: skip


def assigned(table: dict, *settings: str) -> dict:
    """Return a copy of a scene's table changed by settings."""
    return reduce(
        lambda changed, setting: (
            without(changed, setting[1:]) if setting.startswith("-") else replaced(changed, *setting_of(setting))
        ),
        settings,
        table,
    )


def without(table: dict, key: str) -> dict:
    """Return a copy of a scene's table that lacks a key."""
    first, _, rest = key.partition(".")
    kept = dict(table)
    value = kept.pop(first)
    return kept | {first: without(value, rest)} if rest else kept


def changed(source: str | Path, *settings: str) -> Scene:
    """Return a shipped scene, or one of a file, changed by settings."""
    return Scene.from_table("", assigned(read_table(source), *settings))
