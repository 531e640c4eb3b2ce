"""The scene that a call of the command names, changed by its options ``--set`` and ``--voltage``."""

import argparse

from studies.command.output import say
from studies.refusal import refuse_if
from studies.scene import Scene, SceneFile
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value
from studies.scene.ranges import is_number
from studies.scene.uncertain import split_tolerances


def changed_scene(arguments: argparse.Namespace) -> Scene:
    """Return the scene of a call with its ``--set`` and ``--voltage`` applied."""
    return Scene.from_file(changed_file(arguments))


def changed_file(arguments: argparse.Namespace) -> SceneFile:
    """Return the document of a call's scene, with its ``--set`` and ``--voltage`` applied."""
    file = SceneFile.read(arguments.scene)
    for setting in arguments.set:
        file = file.assigned(setting)
    if arguments.voltage is not None:
        refuse_if(
            not isinstance(file.table.get("drive"), dict),
            "--voltage",
            "needs a scene with a [drive]; this one has none",
        )
        values = [toml_value(part.strip()) for part in arguments.voltage.split(",")]
        file = file.replaced("drive.voltage", values if len(values) > 1 else values[0])
    if arguments.call in ("sweep", "fit", "design"):
        say_unused_tolerances(file.table)
    else:
        arguments.scene_file = file  # for refusals during the run, which name file and line
    return file


def say_unused_tolerances(table: dict) -> None:
    """Print that this command ignores the tolerances of a scene, if it has any."""
    if "uncertain" in split_tolerances(table):
        say(["[uncertain] is not used here; sawmotor run computes the bands"])


def read_tolerance(text: str | None) -> float:
    """Return the value of ``--tolerance``, a number or a percentage; 1e-3 when absent."""
    value = 1e-3 if text is None else toml_value(text)
    if isinstance(value, str) and value.endswith("%") and is_number(value[:-1]):
        value = float(value[:-1]) / 100
    return Quantity(below=1.0).read("--tolerance", value)
