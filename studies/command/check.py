"""``sawmotor check``: a scene's text, material and layout, without running it."""

import argparse

from studies.command.options import add_shared
from studies.command.output import warn
from studies.command.scene_argument import changed_file
from studies.progress import Progress
from studies.scene import Scene

HELP = "check the text, material and layout of a scene without running it"
EXAMPLE = "sawmotor check twente --set slider.mass=1e-4"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    add_shared(parser, "scene", "--voltage", "--set", "--explain")


def call(arguments: argparse.Namespace) -> int:
    """Check a scene without running it and print what a run would do."""
    from studies.model.resolve import resolved
    from studies.record.text import labelled
    from studies.remarks.scene_warnings import scene_warnings
    from studies.report.contents import contents

    file = changed_file(arguments)
    if arguments.explain:
        from studies.report.explained_calls import explained_check

        print(explained_check(Scene.from_file(file)))
        return 0
    with Progress(), file.located():
        scene = resolved(Scene.from_file(file))
        parts = labelled(contents(scene), 12)
    print(f"{arguments.scene}: {scene.title or 'no title'}")
    print("\n".join(f"  {line}" for line in parts))
    warn(scene_warnings(scene))
    return 0
