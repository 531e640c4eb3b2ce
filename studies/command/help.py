"""``sawmotor help``: what a word of the output means, or without one the words that are explained."""

import argparse

HELP = "what a word of the output means, or without one the words that are explained"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of the command."""
    parser.add_argument("word", nargs="?", metavar="WORD", help='such as ledger, or "stick margin"')


def call(arguments: argparse.Namespace) -> int:
    """Print what a word of the output means, or the list of the words."""
    from studies.command.glossary import entries, meaning

    print(", ".join(entries()) if arguments.word is None else meaning(arguments.word))
    return 0
