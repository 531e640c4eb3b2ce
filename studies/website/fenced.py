"""The fenced blocks of a Markdown document, and the texts between them."""

import re
from dataclasses import dataclass

__all__ = ["BLOCK", "TOOLS", "Fenced", "blocks", "is_shell", "named_file", "pieces"]

BLOCK = re.compile(
    r"^(?P<remark><!--[^\n]*-->)?\n*^```(?P<language>[^\n`]*)\n(?P<text>.*?)^```$", re.MULTILINE | re.DOTALL
)
SHELLS = ("sh", "bash", "shell", "console")
# commands, beside the program's own, that a document may show a reader
TOOLS = ("python3", "python", "pip", ".", "ruff", "lint-imports", "mypy", "pytest", "dask", "git", "cd", "export")


@dataclass(frozen=True)
class Fenced:
    """A fenced block: the comment on the line before it, its language, its text and its first line's number."""

    remark: str
    language: str
    text: str
    line: int


def pieces(text: str) -> list[str | Fenced]:
    """Return a document as its texts and fenced blocks, in their order."""
    result: list[str | Fenced] = []
    end = 0
    for found in BLOCK.finditer(text):
        result.append(text[end : found.start()])
        line = text[: found.start()].count("\n") + 1
        result.append(Fenced(found["remark"] or "", found["language"].strip(), found["text"], line))
        end = found.end()
    return [*result, text[end:]]


def blocks(text: str) -> list[Fenced]:
    """Return the fenced blocks of a document."""
    return [piece for piece in pieces(text) if isinstance(piece, Fenced)]


def is_shell(block: Fenced) -> bool:
    """Return whether a block holds commands; one without a language may be what a command prints."""
    words = block.text.split()[:1]
    return block.language in SHELLS or (not block.language and words != [] and words[0] in ("sawmotor", *TOOLS))


def named_file(block: Fenced) -> str | None:
    """Return the file's name in the first line of a TOML block, such as ``# my-motor.toml``; None without one."""
    named = re.match(r"# ([\w-]+\.toml)$", block.text.splitlines()[0]) if block.language == "toml" else None
    return named[1] if named else None
