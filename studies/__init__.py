"""Questions to a SAW motor: scenes, the chain from drive voltage to slider velocity, records, sweeps, pictures.

>>> from studies import Scene, run
>>> motor = Scene.load("twente").replace(slider={"preload": "5 mN"}, drive={"voltage": "5:60:12"})
>>> motor.slider.preload, len(motor.drive.voltage)
(0.005, 12)

``run(motor)`` gives a `Record`, ``sweep(motor, {...})`` a `Sweep`.  Conventions: exp(+i omega t), peak amplitudes,
SI units, x along the surface, z out of it, slider velocity positive along +x.  Importing this package imports no
numerical library; ``run`` imports what its scene needs.

Packages, bottom to top: scene (the file and its rules), results (directories) - record - chain (voltage to velocity) -
report (the files of a run) - view (looking at fields and contacts), sweep (many runs of one scene) - command (the
command line) - stator, papers, motor (questions, one file each) - evidence (what shows that the rest can be trusted).
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from studies.chain import run
    from studies.record import Record
    from studies.refusal import RunError, SceneError
    from studies.scene import Scene, shipped_scenes
    from studies.scene.blocks import Drive, IsotropicSolid, PiezoelectricSolid, Stator, Transducer
    from studies.scene.slider import Damping, Slider, Wave
    from studies.sweeps import Sweep, sweep

__all__ = [
    "Damping", "Drive", "IsotropicSolid", "PiezoelectricSolid", "Record", "RunError", "Scene", "SceneError", "Slider",
    "Stator", "Sweep", "Transducer", "Wave", "run", "shipped_scenes", "sweep",
]  # fmt: skip

_HOME = {
    "Damping": "scene.slider",
    "Record": "record",
    "RunError": "refusal",
    "Scene": "scene",
    "SceneError": "refusal",
    "Slider": "scene.slider",
    "Sweep": "sweeps",
    "Wave": "scene.slider",
    "run": "chain",
    "shipped_scenes": "scene",
    "sweep": "sweeps",
}


def __getattr__(name: str):
    """Import a public name when it is first asked for: importing the package stays cheap."""
    if name not in __all__:
        raise AttributeError(f"module 'studies' has no attribute {name!r}")
    return getattr(import_module(f"studies.{_HOME.get(name, 'scene.blocks')}"), name)


class _FormerName(ModuleType):
    """A package under the name that it had before; it leaves the name in ``studies`` to the function."""

    def __getattr__(self, name: str):
        return getattr(import_module("studies.sweeps"), name)


sys.modules["studies.sweep"] = _FormerName("studies.sweep")


def __dir__():
    return sorted({*globals(), *__all__})
