"""Every code block of every document runs, every command that a document names is one, every link leads somewhere.

The blocks of a document are run in their order, in one temporary directory and one Python namespace; those that take
long (`SLOW_DOCUMENTS`, `LONG`) in the slow set, by default their commands are parsed.  Python blocks are
executed; of shell blocks the ``sawmotor`` lines are run and other known tools are left to the reader; TOML blocks are
read as scenes.  A line ``<!-- not run: REASON -->`` before a block exempts it, ``<!-- part of a scene -->`` a TOML
block that is no whole scene.
"""

import json
import re
import shlex
from pathlib import Path

import pytest

import fem
from studies.__main__ import main
from studies.command.parser import COMMANDS, parser
from studies.scene import Scene, shipped_scenes
from studies.website.fenced import BLOCK, TOOLS, Fenced, blocks, is_shell, named_file
from tests.studies.solved_once import solved_once

ROOT = Path(__file__).parents[1]
DOCUMENTS = sorted(
    path
    for pattern in ("README.md", "*/README.md", "*/*/README.md")
    for path in ROOT.glob(pattern)
    if not path.parts[len(ROOT.parts)].startswith(".")
)
NAMES = [str(path.relative_to(ROOT)) for path in DOCUMENTS]
# tutorials whose steps tests/studies/test_lab.py, test_positioning.py and test_export_motor.py take on small motors
SLOW_DOCUMENTS = ("studies/lab/README.md", "studies/motor/README.md")
# commands whose study, field, measurement and bands test_studies.py, test_view.py, test_measured.py and
# test_uncertain.py have on small motors
LONG = (
    "--set uncertain.slider.preload",
    "sawmotor study reflector",
    "sawmotor view results/my-motor",
    "sawmotor run reflector",
    "--measured measured.csv",
)
OPTION = re.compile(r"--[a-z][a-z0-9-]*")
INLINE = re.compile(r"(?<!`)`(sawmotor [^`]+)`(?!`)")
PLACEHOLDER = re.compile(r"[\[\]|<>]|\.\.\.|\b[A-Z]{3,}\b")
LINK = re.compile(r"\]\((?!https?:|#|mailto:)([^)#\s]+)")


def commands(text: str) -> list[list[str]]:
    """Return the commands of a shell block, as words."""
    lines = text.replace("\\\n", " ").splitlines()
    parts = [part.strip() for line in lines for part in re.split(r"\s&&\s|\s&\s", line.split(" #")[0])]
    return [shlex.split(part) for part in parts if part and not part.startswith("#")]


def is_sawmotor(each: list[list[str]]) -> bool:
    """Return whether one of these commands is the program's."""
    return any(words[0] == "sawmotor" for words in each)


def run_command(words: list[str]) -> None:
    """Run a command of a document; a window cannot be opened here."""
    if words[0] != "sawmotor":
        assert words[0] in TOOLS, f"no command that a reader has: {words[0]}"
        return
    files = ("--screenshot", "--movie", "--html", "--data", "--surface")
    if words[1:2] == ["view"] and not any(option in words for option in files):
        parser().parse_args(words[1:])
        return
    assert main(words[1:]) == 0, " ".join(words)


# what the model leaves out of a shipped motor counts a tenth and more: said by design
STANDING = "partly a standing one"  # the second transducer, free ends or a groove send a part of the wave back
WARNED = {
    "crossed": (STANDING,),
    "lithium-niobate-128yx": ("moves sideways",),
    "reflector": (STANDING,),
    "silicon-slider": ("overtones of the wave", "leaks into bulk waves", "adhesion", STANDING),
    "twente": (STANDING,),
    "twente-left": (STANDING,),
}
NUMBER = re.compile(r"[+-]?\d+(?:\.\d+)?(?:e[+-]?\d+)?")
UNTOLD = ("seconds", "expected", "results")  # lines that differ from machine to machine


def same(shown: str, printed: str) -> bool:
    """Return whether a line of a document is one that was printed: same words, numbers to a part in 500."""
    if NUMBER.sub("#", " ".join(shown.split())) != NUMBER.sub("#", " ".join(printed.split())):
        return False
    pairs = zip(map(float, NUMBER.findall(shown)), map(float, NUMBER.findall(printed)), strict=True)
    return all(abs(a - b) <= 2e-3 * abs(a) or (abs(a) < 5e-2 and abs(a - b) <= 0.5 * abs(a)) for a, b in pairs)


def unprinted(block: Fenced, printed: str) -> list[str]:
    """Return the lines of a block that the command before it did not print; "..." stands for others left out."""
    known = printed.splitlines()
    return [
        line
        for line in block.text.splitlines()
        if line.strip() not in ("", "...")
        and not line.startswith(UNTOLD)
        and not any(same(line, each) for each in known)
    ]


@pytest.fixture
def solved_fields(monkeypatch):
    """Let the commands of a document that ask for the same field get the same answer, solved once."""
    monkeypatch.setattr(fem, "driven_wave", solved_once(fem.driven_wave), raising=False)


def has_long_commands(document: Path) -> bool:
    """Return whether a document holds a block with one of the commands that take long."""
    return any(each in block.text for block in blocks(document.read_text()) for each in LONG)


CASES = [
    pytest.param(document, False, id=name)
    for document, name in zip(DOCUMENTS, NAMES, strict=True)
    if name not in SLOW_DOCUMENTS
] + [
    pytest.param(document, True, id=f"whole {name}", marks=pytest.mark.slow)
    for document, name in zip(DOCUMENTS, NAMES, strict=True)
    if name in SLOW_DOCUMENTS or has_long_commands(document)
]


@pytest.mark.parametrize(("document", "whole"), CASES)
def test_the_blocks_of_a_document_run(document, whole, tmp_path, monkeypatch, solved_fields, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    space: dict = {"__name__": "document"}
    printed, wrong = "", []
    for block in blocks(document.read_text(encoding="utf-8")):
        if block.remark.startswith("<!-- not run:"):
            continue
        if block.language == "python":
            exec(compile(block.text, f"{document.name}, line {block.line}", "exec"), space)
        elif block.language == "toml":
            if "part of a scene" not in block.remark:
                # a first line such as "# my-motor.toml" tells the reader, and the later blocks, the file's name
                file = tmp_path / (named_file(block) or "scene of a document.toml")
                file.write_text(block.text, encoding="utf-8")
                Scene.load(file)
        elif is_shell(block):
            ran = commands(block.text)
            if not whole:
                ran = [words for words in ran if not any(each in " ".join(words) for each in LONG)]
            for words in ran:
                run_command(words)
            if is_sawmotor(commands(block.text)):
                printed = capsys.readouterr().out  # nothing where the command was not run
        elif not block.language and printed and "not printed" not in block.remark:
            wrong += [f"line {block.line}: {line}" for line in unprinted(block, printed)]
    capsys.readouterr()
    assert not wrong, "\n".join(wrong)
    if "matplotlib" in space or "pyplot" in str(space.keys()):
        from matplotlib import pyplot

        pyplot.close("all")


def options_of(command: str, capsys) -> set[str]:
    """Return the options that the help of a command lists."""
    with pytest.raises(SystemExit):
        parser().parse_args([command, "--help"])
    return set(OPTION.findall(capsys.readouterr().out))


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_the_commands_that_a_document_names_exist(document, capsys):
    for block in filter(is_shell, blocks(document.read_text(encoding="utf-8"))):
        for words in commands(block.text):
            if words[0] == "sawmotor" and "not run" not in block.remark:
                parser().parse_args(words[1:])
    for text in INLINE.findall(document.read_text(encoding="utf-8")):
        call = text.split()[1].strip("[],")
        if not PLACEHOLDER.search(text):
            parser().parse_args(shlex.split(text)[1:])
        elif call in COMMANDS:
            assert set(OPTION.findall(text)) <= options_of(call, capsys), text
        else:
            assert call.isupper() or call.startswith("--"), text


@pytest.mark.parametrize("document", DOCUMENTS, ids=NAMES)
def test_the_links_and_pictures_of_a_document_exist(document):
    missing = [
        target
        for target in LINK.findall(BLOCK.sub("", document.read_text(encoding="utf-8")))
        if not (document.parent / target).exists()
    ]
    assert missing == []


def test_the_tests_of_documents_find_what_is_wrong(tmp_path):
    text = "```python\nx = 1\n```\n\n<!-- not run: no reason -->\n```\nsawmotor run nothing\n```\n\n```\n 1  2\n```\n"
    python, shell, printed = blocks(text)
    assert (python.language, python.text, python.line) == ("python", "x = 1\n", 1)
    assert shell.remark == "<!-- not run: no reason -->"
    assert is_shell(shell)
    assert not is_shell(printed)
    assert commands(shell.text) == [["sawmotor", "run", "nothing"]]
    assert commands("pip install x && sawmotor scenes  # list\nsawmotor \\\n check twente") == [
        ["pip", "install", "x"],
        ["sawmotor", "scenes"],
        ["sawmotor", "check", "twente"],
    ]
    with pytest.raises(AssertionError, match="no command"):
        run_command(["rm", "-r", "results"])
    with pytest.raises(AssertionError):
        run_command(["sawmotor", "check", "nothing"])


@pytest.mark.parametrize("name", shipped_scenes())
def test_a_shipped_scene_is_checked_and_planned(name):
    assert main(["check", name]) == 0
    assert main(["run", name, "--explain"]) == 0


# README.md runs twente, test_warnings.py asks for its warnings, test_crossed.py runs crossing beams,
# test_piece_scene.py a groove and test_pillars.py pillars
RUN_ELSEWHERE = ("twente", "twente-left", "crossed", "reflector", "silicon-slider")


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in RUN_ELSEWHERE)) for name in shipped_scenes()]
)
def test_a_shipped_scene_is_run_without_a_warning(name, capsys):
    assert main(["run", name, "--json", "--tolerance", "3e-2"]) == 0
    warnings = json.loads(capsys.readouterr().out).get("warnings", ())
    expected = (*WARNED.get(name, ()), "the balls are computed smooth, dry and clean")
    assert [each for each in warnings if not any(word in each for word in expected)] == []
    assert (STANDING in expected) == any(STANDING in each for each in warnings)
