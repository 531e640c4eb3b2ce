"""``sawmotor schema``: the JSON Schema of a scene, for completion and checks in an editor."""

import argparse

HELP = "print the JSON Schema of scene files, for completion and checks in an editor"
EXAMPLE = "sawmotor schema > scene.schema.json"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    del parser


def call(arguments: argparse.Namespace) -> int:
    """Print the JSON Schema of a scene."""
    from studies.scene.reference import schema_text

    print(schema_text(), end="")
    return 0
