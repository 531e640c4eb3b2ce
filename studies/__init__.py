"""Questions to a SAW motor: scenes, the chain from drive voltage to slider velocity, records, sweeps, pictures.

>>> from studies import Scene, run
>>> motor = Scene.load("twente").replace(slider={"preload": "5 mN"}, drive={"voltage": "5:60:12"})
>>> motor.slider.preload, len(motor.drive.voltage)
(0.005, 12)

``run(motor)`` gives a `Record`, ``sweep(motor, {...})`` a `Sweep`, ``fit`` a `Fit`, ``design`` a `Design`,
``datasheet`` a `Datasheet`, ``compare`` a `Comparison`, ``network`` a `skrf.Network`; what they do meanwhile is logged
by the loggers below ``studies``.  Conventions: exp(+i omega t), peak amplitudes, SI units, x along the surface, z out
of it, slider velocity positive along +x.  Importing this package imports no numerical library; ``run`` imports what its
scene needs.

Packages, bottom to top: scene (the file and its rules), results (directories) - record - model (a scene as objects of
fem and contact) - solve (surface motion, contact, velocity, errors) - remarks (what is left out, warnings) - runs (from
a scene to its record) - report (the files of a run) - view (looking at fields and contacts), sweep (many runs of one
scene) - command (the command line) - stator, papers, motor (questions, one file each) - evidence (what shows that the
rest can be trusted).
"""

import sys
from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from studies.inverse.fit_result import Fit
    from studies.inverse.fitting import fit
    from studies.inverse.free_parameters import Parameter
    from studies.inverse.optimum import Design, design
    from studies.inverse.residual import Residual
    from studies.lab.measurement import Measurement
    from studies.record.record import Record
    from studies.refusal import RunError, SceneError
    from studies.report.comparison import Comparison, compare
    from studies.report.motor_datasheet import Datasheet, datasheet
    from studies.runs import run
    from studies.scene.drive import Drive, Wave
    from studies.scene.file import shipped_scenes
    from studies.scene.scene import Scene
    from studies.scene.slider_keys import Damping, Slider
    from studies.scene.stator_keys import IsotropicSolid, PiezoelectricSolid, Stator, Transducer
    from studies.solve.predictor import Predictor
    from studies.solve.scattering import network
    from studies.sweeps import Sweep, sweep

_PUBLIC = {
    "solve.predictor": "Predictor",
    "runs": "run",
    "solve.scattering": "network",
    "inverse.fitting": "fit",
    "inverse.optimum": "Design design",
    "inverse.free_parameters": "Parameter",
    "inverse.residual": "Residual",
    "inverse.fit_result": "Fit",
    "lab.measurement": "Measurement",
    "record.record": "Record",
    "refusal": "RunError SceneError",
    "report.comparison": "Comparison compare",
    "report.motor_datasheet": "Datasheet datasheet",
    "scene.stator_keys": "IsotropicSolid PiezoelectricSolid Stator Transducer",
    "scene.file": "shipped_scenes",
    "scene.scene": "Scene",
    "scene.slider_keys": "Damping Slider",
    "scene.drive": "Drive Wave",
    "sweeps": "Sweep sweep",
}  # names by the module that defines them
_HOME = {name: module for module, names in _PUBLIC.items() for name in names.split()}
__all__ = [
    "Comparison", "Damping", "Datasheet", "Design", "Drive", "Fit", "IsotropicSolid", "Measurement", "Parameter",
    "PiezoelectricSolid", "Predictor", "Record", "Residual", "RunError", "Scene", "SceneError", "Slider",
    "Stator", "Sweep", "Transducer", "Wave", "compare", "datasheet", "design", "fit", "network", "run",
    "shipped_scenes", "sweep",
]  # fmt: skip


def __getattr__(name: str) -> Any:
    """Import a public name when it is first asked for: importing the package stays cheap."""
    if name not in _HOME:
        raise AttributeError(f"module 'studies' has no attribute {name!r}")
    return getattr(import_module(f"studies.{_HOME[name]}"), name)


class _FormerName(ModuleType):
    """A package under the name that it had before; it leaves the name in ``studies`` to the function."""

    def __getattr__(self, name: str) -> Any:
        return getattr(import_module("studies.sweeps"), name)


sys.modules["studies.sweep"] = _FormerName("studies.sweep")


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
