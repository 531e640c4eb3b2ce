"""``sawmotor scenes``: list the shipped scenes, or copy one."""

import argparse
from pathlib import Path

from studies.scene import Scene, shipped_scenes

HELP = "list the scenes that come with the program, or copy one to start from"
EXAMPLE = "sawmotor scenes --copy lithium-niobate-yz my-motor.toml"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument(
        "--copy", nargs=2, metavar=("NAME", "FILE"), help="write a scene that ships, and its meshes, into new files"
    )


def call(arguments: argparse.Namespace) -> int:
    """Print the shipped scenes, one line each, or copy one of them."""
    from studies.record.text import labelled

    if arguments.copy is not None:
        from studies.scene.file import copied

        name, file = arguments.copy
        for beside in copied(name, Path(file))[1:]:
            print(beside)
        print(f"{file}: sawmotor check {file}, sawmotor run {file}")
        return 0
    titles = [(name, Scene.load(name).title) for name in shipped_scenes()]
    print("\n".join(labelled(titles, 2 + max(map(len, shipped_scenes())))))
    return 0
