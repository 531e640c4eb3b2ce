"""The package as others get it: a wheel, installed outside the checkout, that runs and has all of its files."""

import html
import json
import os
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

import contact
import fem
import studies

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def installed(tmp_path_factory) -> Path:
    """Return a folder that holds what the wheel installs."""
    folder = tmp_path_factory.mktemp("wheel")
    pip = [sys.executable, "-m", "pip", "--quiet"]
    subprocess.run([*pip, "wheel", "--no-deps", "-w", str(folder), str(ROOT)], check=True, timeout=300)
    (wheel,) = folder.glob("sawmotor-*.whl")
    subprocess.run([*pip, "install", "--no-deps", "--target", str(folder / "site"), str(wheel)], check=True)
    return folder / "site"


def called(installed: Path, *words: str, cwd: Path) -> subprocess.CompletedProcess:
    environment = os.environ | {"PYTHONPATH": str(installed), "PYTHONSAFEPATH": "1"}
    return subprocess.run(
        [sys.executable, *words], cwd=cwd, env=environment, capture_output=True, text=True, timeout=300
    )


@pytest.mark.slow
def test_a_wheel_runs_outside_the_checkout(installed, tmp_path):
    where = called(installed, "-c", "import studies, fem, contact; print(studies.__file__)", cwd=tmp_path)
    assert str(installed) in where.stdout, where.stderr
    done = called(installed, "-m", "studies", "run", "twente-contact", "--json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert len(json.loads(done.stdout)["points"]) > 1
    done = called(installed, "-m", "studies", "study", "stability", "--quick", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    # a case whose reference is stored with the study
    asked = (
        "from studies.evidence.stability import stator, verdict; "
        "case = verdict.Case(part='stator', varied='length', value=0.5, unit=''); "
        "print(verdict.judge(stator, case).verdict)"
    )
    done = called(installed, "-c", asked, cwd=tmp_path)
    assert done.stdout.strip() == "right", done.stderr


@pytest.mark.slow
def test_a_wheel_holds_what_the_packages_hold(installed):
    """All but the pictures of the documents."""
    for package in ("fem", "contact", "studies"):
        listed = subprocess.run(["git", "ls-files", package], cwd=ROOT, capture_output=True, text=True, check=True)
        for name in listed.stdout.split():
            pictures = name.startswith("studies/pictures/") or name.endswith(".md")
            assert pictures or (installed / name).is_file(), name
    assert (installed / "studies" / "glossary.md").is_file()


@pytest.mark.slow
def test_the_api_reference_documents_every_public_name(tmp_path):
    """The names are imported on first use: pdoc alone wrote their headings only."""
    pytest.importorskip("pdoc", reason="pip install 'sawmotor[docs]'")
    words = ["-W", "error", "-m", "studies.website.api_reference", str(tmp_path)]
    done = subprocess.run([sys.executable, *words], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert (done.returncode, done.stderr) == (0, "")
    for package in (fem, contact, studies):
        page = (tmp_path / f"{package.__name__}.html").read_text(encoding="utf-8")
        for name in package.__all__:
            found = getattr(package, name)
            if isinstance(found, ModuleType):
                continue
            documented = found.__doc__ or ""
            section = page.partition(f'<section id="{name}">')[2].partition("</section>")[0]
            words = re.findall(r"\w+", documented.splitlines()[0] if documented else "")
            assert section, name
            if callable(found):
                shown = re.findall(r"\w+", html.unescape(re.sub(r"<[^>]+>", " ", section)))
                assert " ".join(words) in " ".join(shown), name
