"""``sawmotor export``: a run or a scene as a file of another world."""

import argparse
from pathlib import Path

from studies.export.exported import Exported
from studies.refusal import SceneError, nearest
from studies.scene import Scene

# by format: ending of its file, and the options of the command that it takes beside the scene's own
FORMATS = {
    "fmu": (".fmu", ("fmi",)), "c": ("", ()), "gds": (".gds", ("size",)), "dxf": (".dxf", ("size",)),
    "uff": (".uff", ("scan", "band", "noise", "seed")), "csv": ("", ("scan", "band", "noise", "seed")),
    "touchstone": (".snp", ("band", "z0", "noise", "seed")), "vtu": (".vtu", ()),
}  # fmt: skip


def exported(
    arguments: argparse.Namespace, scene: Scene, name: str, *, tolerance: float, progress
) -> Exported:
    """Return what a call of the command exports, nothing written; options that a format does not take are refused."""
    from studies.export import instruments, mask_files, simulators

    calls = {
        "fmu": simulators.fmu_files, "c": simulators.c_files, "gds": mask_files.gds_files, "dxf": mask_files.dxf_files,
        "uff": instruments.uff_files, "csv": instruments.csv_files, "touchstone": instruments.touchstone_files,
        "vtu": instruments.vtu_files,
    }  # fmt: skip
    _, taken = checked(arguments)
    options = {key: value for key in taken if (value := getattr(arguments, key)) not in (None, [])}
    return calls[arguments.format](scene, name, tolerance=tolerance, progress=progress, **options)


def checked(arguments: argparse.Namespace) -> tuple[str, tuple[str, ...]]:
    """Return the ending and the options of the format that was asked for; SceneError for what does not fit."""
    wanted = arguments.format
    if wanted is None:
        raise SceneError("--format", f"is missing; known: {', '.join(FORMATS)}")
    if wanted not in FORMATS:
        raise SceneError("--format", f"{wanted!r} is not known{nearest(wanted, FORMATS)}")
    ending, taken = FORMATS[wanted]
    every = {option for _, options in FORMATS.values() for option in options}
    for option in sorted(every - set(taken)):
        if getattr(arguments, option) not in (None, []):
            raise SceneError(f"--{option}", f"is not taken by the format {wanted}")
    return ending, taken


def scene_of(word: str) -> str:
    """Return the scene of a run's directory, or the word itself.

    Raises
    ------
    SceneError
        If a directory holds no run.
    """
    if not Path(word).is_dir():
        return word
    scene = Path(word) / "scene.toml"
    if not scene.is_file():
        raise SceneError("export", f"{word!r} holds no run: scene.toml is missing")
    return str(scene)
