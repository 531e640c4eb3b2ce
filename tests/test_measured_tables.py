"""Tables of measured times and errors: each states the version that was measured, which is not older than one release.

Regression of documents: a table that nobody prints again after a release says what was true of another program.  The
rule compares versions, so that it fails with a change of the change log alone and never with the date.
"""

import re
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
DOCUMENTS = ("studies/evidence/README.md", "contact/README.md", "fem/README.md")
STAMP = re.compile(r"^\*\d+-core .*\*$", re.MULTILINE)
VERSION = re.compile(r", version (\d+\.\d+\.\d+)[,.]")


def releases() -> list[str]:
    """Return the versions of the change log, the latest first."""
    return re.findall(r"^## (\d+\.\d+\.\d+)$", (ROOT / "studies" / "changelog.md").read_text(), re.MULTILINE)


def too_old(text: str, known: list[str]) -> list[str]:
    """Return the stamps of a document without one of the last two versions."""
    found = [(stamp, VERSION.search(stamp)) for stamp in STAMP.findall(text)]
    return [stamp for stamp, version in found if version is None or version[1] not in known[:2]]


def test_the_change_log_begins_with_the_version_of_the_program():
    assert tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]["version"] == releases()[0]


@pytest.mark.parametrize("document", DOCUMENTS)
def test_no_measured_table_is_older_than_a_release(document):
    assert too_old((ROOT / document).read_text(), releases()) == []


def test_the_evidence_has_measured_tables():
    assert len(STAMP.findall((ROOT / DOCUMENTS[0]).read_text())) > 5


def test_a_stamp_of_an_older_release_or_without_a_version_is_found():
    old, bare, new = (f"*2-core x86_64, 2026-11-21{each}.*" for each in (", version 0.1.0", "", ", version 0.2.0"))
    assert too_old(f"{old}\n\n{bare}\n\n{new}\n", ["0.3.0", "0.2.0", "0.1.0"]) == [old, bare]
