"""The glossary: every word that users had to decode has an entry, and the command prints it."""

import pytest

from studies.__main__ import main
from studies.command.help import entries, meaning

WORDS = (
    "plane section", "comb", "level", "release", "stick margin", "stick band", "chi", "reciprocal", "ledger",
    "leak of the elastic law", "graze", "chatter", "position", "ring", "surface ratio", "radiation of a contact",
    "charge at the finger ends", "circulation", "motional branch", "elasticity", "shortfall", "seed",
)  # fmt: skip


@pytest.mark.parametrize("word", WORDS)
def test_word_has_an_entry(word):
    assert len(entries()[word]) > 30


def test_entries_are_in_order_and_one_line_each():
    words = [word.lower().replace("-", " ") for word in entries()]
    assert words == sorted(words)
    assert not any("\n" in text or "**" in text for text in entries().values())


def test_command_prints_entries_that_contain_a_word(capsys):
    assert main(["help", "Stick"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert [line.partition(":")[0] for line in printed] == ["stick band", "stick margin"]
    assert main(["help"]) == 0
    assert capsys.readouterr().out.startswith("absorbing, admittance, aperture")


def test_unknown_word_is_refused_with_the_nearest(capsys):
    assert main(["help", "ledgr"]) == 2
    assert "did you mean ledger?" in capsys.readouterr().err
    assert meaning("k2").startswith("K2: electromechanical")
