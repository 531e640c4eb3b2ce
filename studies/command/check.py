"""``sawmotor check``: a scene's text, material and layout, without running it."""

import argparse

from studies.command.options import add_shared
from studies.command.output import warn
from studies.command.scene_argument import changed_file
from studies.scene import Scene

HELP = "check the text, material and layout of a scene without running it"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene", "--voltage", "--set")


def call(arguments: argparse.Namespace) -> int:
    """Check a scene without running it and print what a run would do."""
    from studies.model.resolve import resolved
    from studies.record.text import labelled
    from studies.remarks.scene_warnings import scene_warnings
    from studies.report.contents import contents

    file = changed_file(arguments)
    with file.located():
        scene = resolved(Scene.from_file(file))
    print(f"{arguments.scene}: {scene.title or 'no title'}")
    print("\n".join(f"  {line}" for line in labelled(contents(scene), 12)))
    warn(scene_warnings(scene))
    return 0
