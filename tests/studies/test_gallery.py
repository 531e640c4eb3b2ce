"""The gallery: what it finds, that it is small and that the documents show all of it."""

import re
from pathlib import Path

import pytest

from studies.results import MANIFEST
from studies.study_list import Panel, StudyRecord, draw_study, run_study
from tests.studies.settings import SHORT, changed

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "studies" / "pictures" / "gallery"


@pytest.fixture(scope="module")
def small_motor():
    """A short motor of three finger pairs, whose voltages are none of the shipped motor's."""
    return changed("twente-left", *SHORT, "drive.voltage=[35, 44, 61, 80]")


def test_the_documents_show_every_picture_of_the_gallery_and_all_are_small():
    pictures = {path.name: path.stat().st_size for path in KEPT.iterdir() if path.suffix in (".png", ".gif")}
    documents = (ROOT / "README.md", ROOT / "studies" / "README.md")
    text = "".join(document.read_text(encoding="utf-8") for document in documents)
    shown = set(re.findall(r"pictures/gallery/([\w.]+)", text))
    assert shown == set(pictures)
    assert len(pictures) >= 16
    assert max(pictures.values()) < 600e3
    assert sum(pictures.values()) < 1.5e6


@pytest.mark.slow
def test_the_gallery_draws_what_is_kept(tmp_path):
    record = run_study("gallery", None, tmp_path)
    draw_study("gallery", record, tmp_path)
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in KEPT.iterdir()} - {MANIFEST}


def test_every_picture_of_the_gallery_is_of_the_scene_that_it_is_given(small_motor, monkeypatch):
    """The studies inside it are run on that scene, and contact and bursts at its own voltages."""
    from studies.motor import gallery, regime_map
    from studies.stator import admittance

    asked = []

    def noted(scene, **given):
        asked.append(scene)
        return StudyRecord(name="", panels=(Panel(name="", title="", data={}),), findings=(), seconds=0.0)

    monkeypatch.setattr(regime_map, "run", noted)
    monkeypatch.setattr(admittance, "run", noted)
    shown = gallery.run(small_motor)
    assert asked == [small_motor, small_motor]
    assert shown.voltage == 44.0
    assert [name for name, _ in shown.bursts] == ["35 V", "61 V"]
    assert shown.record.scene.stator.length == small_motor.stator.length
