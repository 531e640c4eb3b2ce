"""The stator of a scene without its slider and its levels: many scenes share one."""

from dataclasses import replace
from functools import lru_cache

from studies.scene import Scene
from studies.scene.drive import Drive

MAX_DRIVES = 10_000  # in memory
POSITION_KEYS = ("slider.position", "slider.contacts")


def changes_stator(key: str) -> bool:
    """Return whether a change of a key requires a new solution of the section or its circuit."""
    in_stator = key.startswith(("stator.", "transducer.", "drive."))
    return in_stator and key not in ("drive.voltage", "drive.power", "drive.burst", "drive.duty")


def stator_alone(scene: Scene) -> Scene:
    """Return the stator of a resolved scene alone, at 1 V, without burst and duty."""
    alone = {name: getattr(scene, name) for name in ("stator", "transducer", "piece")}
    return Scene(**alone, drive=at_one_volt(scene.drive))


@lru_cache(MAX_DRIVES)
def at_one_volt(drive: Drive) -> Drive:
    """Return a drive at 1 V, without power, burst and duty."""
    return replace(drive, voltage=(1.0,) if drive.levels else None, power=None, burst=None, duty=None)
