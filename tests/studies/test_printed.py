"""The printed page of a run: one sheet A4 whose text fits above its pictures."""

import re
from dataclasses import replace

import pytest

from studies import run
from studies.__main__ import main
from studies.report import printed


def test_page_is_one_sheet_of_a4_with_the_answer(tmp_path):
    folder = tmp_path / "run"
    assert main(["run", "twente-contact", "--no-plot", "--report", "pdf", "--out", str(folder)]) == 0
    data = (folder / printed.FILE).read_bytes()
    assert len(re.findall(rb"/Type /Page\b", data)) == 1
    width, height = map(float, re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ([\d.]+) \]", data).groups())
    assert (width / 72, height / 72) == pytest.approx(printed.A4)
    assert not (folder / "report.html").exists()


def test_text_is_as_large_as_its_place_permits():
    lines = [f"line {k}" for k in range(20)]
    size, wrapped = printed.fitted(lines, 7.0, 6.0)
    assert (size, wrapped) == (printed.LARGEST, lines)
    smaller, wrapped = printed.fitted([f"{k} " + "word " * 60 for k in range(20)], 7.0, 5.0)
    assert printed.SMALLEST < smaller < printed.LARGEST
    assert "".join(wrapped).count("word") == 1200
    size, wrapped = printed.fitted(lines * 10, 7.0, 1.0)
    assert size == printed.SMALLEST
    hidden = int(wrapped[-1].strip("(").split()[0])
    assert len(wrapped) - 1 + hidden == 200


def test_text_holds_velocity_warnings_motor_and_what_the_model_leaves_out():
    record = replace(run("twente-contact"), warnings=("the balls are too warm",))
    text = "\n".join(printed.text(record))
    for words in ("velocity", "roughness", "radius 1 mm", "the balls are too warm", *record.left_out):
        assert words in text
