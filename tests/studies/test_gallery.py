"""The gallery: what it finds, that it is small and that README shows all of it."""

import json
import re
from pathlib import Path

import pytest

from studies.results import MANIFEST
from studies.scene import Scene
from studies.study import draw_study, run_study, study_answer

ROOT = Path(__file__).parents[2]
KEPT = ROOT / "studies" / "pictures" / "gallery"


def test_readme_shows_every_picture_of_the_gallery_and_all_are_small():
    pictures = {path.name: path.stat().st_size for path in KEPT.iterdir() if path.suffix in (".png", ".gif")}
    shown = set(
        re.findall(r"studies/pictures/gallery/([\w.]+)", (ROOT / "README.md").read_text(encoding="utf-8"))
    )
    assert shown == set(pictures)
    assert len(pictures) >= 16
    assert max(pictures.values()) < 500e3
    assert sum(pictures.values()) < 1.5e6


def test_what_the_kept_gallery_found_was_confirmed():
    record = json.loads((KEPT / "study.json").read_text(encoding="utf-8"))
    assert [finding["confirmed"] for finding in record["findings"]] == [True] * 5


@pytest.mark.slow
def test_the_gallery_confirms_its_findings_and_draws_what_is_kept(tmp_path):
    record = run_study("gallery", None, tmp_path, progress=lambda text: None)
    draw_study("gallery", record, tmp_path, progress=lambda text: None)
    assert study_answer(record).count(": confirmed") == 5
    assert {path.name for path in tmp_path.iterdir()} == {path.name for path in KEPT.iterdir()} - {MANIFEST}


def test_a_scene_without_a_whole_motor_is_refused():
    from studies.motor import gallery
    from studies.refusal import SceneError

    with pytest.raises(SceneError, match="transducer and slider are needed: the gallery shows a whole motor"):
        gallery.run(Scene.load("rayleigh"))
