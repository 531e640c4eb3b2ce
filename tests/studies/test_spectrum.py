"""Many frequencies of a scene, and the centre frequency: bands against single solves, the maximum against a scan."""

from dataclasses import replace

import numpy as np
import pytest

from fem import ConvergenceError, automatic_period, best_frequency, best_period
from studies import Scene
from studies.model.fem_objects import stator
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.runs import run
from studies.scene import read_table
from studies.solve.spectrum import Response, response
from tests.studies.settings import assigned


def chip(*settings):
    """A short motor with its periods fixed, its slider left out."""
    base = [
        "stator.length=30 mm",
        "stator.thickness=2 mm",
        "transducer.0.center=6 mm",
        "transducer.0.finger_pairs=5",
        "transducer.0.period=1 mm",
        "drive.frequency=2.17 MHz",
        "slider.position=20 mm",
        "drive.voltage=60",
    ]
    table = read_table("twente-left")
    for setting in [*base, *settings]:
        table = assigned(table, setting)
    return replace(Scene.from_table("", table), slider=None)


def prepared(scene, lowest=2.1e6, highest=2.2e6, place=20e-3):
    return response(Model(scene), lowest, highest, positions=(place,), tolerance=3e-2)


@pytest.fixture(scope="module")
def banded():
    scene = resolved(chip("drive.source_impedance=[20, 10]"))
    return scene, prepared(scene)


def test_a_band_gives_what_single_solves_give(banded):
    scene, many = banded
    assert len(many.bands) == 1
    frequencies = [2.12e6, 2.19e6]
    waves = many.waves(frequencies, Model(scene).drive), replace(many, bands=()).waves(frequencies, Model(scene).drive)
    assert [each.frequency for each in waves[0]] == frequencies
    for name in ("motion", "rayleigh_motion"):
        fast, slow = (np.array([getattr(each, name)(20e-3) for each in some]) for some in waves)
        np.testing.assert_allclose(fast, slow, rtol=2e-3)
    assert all(0 < each.relative_error < 3e-2 for each in waves[0])


@pytest.mark.parametrize(
    ("settings", "place"),
    [(["transducer.0.pattern=+-+-0-+-+-"], 20e-3), (["transducer.0.center=2.45 mm"], 20e-3), ([], 6e-3)],
    ids=["a finger left out", "an end within half a gap", "a place under the fingers"],
)
def test_where_no_band_serves_each_frequency_is_solved_alone(settings, place):
    scene = resolved(chip(*settings))
    many = prepared(scene, place=place)
    assert many.bands == ()
    (found,) = many.waves([2.15e6], Model(scene).drive)
    single = run(replace(scene, drive=replace(scene.drive, frequency=2.15e6)), tolerance=3e-2)
    assert found.motion(place)[1] == pytest.approx(single.surface_wave.motion(place)[1], rel=3e-2)
    assert found.covered(place) == (place == 6e-3)


def test_a_wide_range_is_cut_into_bands_that_meet(monkeypatch):
    import fem

    asked = []
    monkeypatch.setattr(
        fem, "frequency_band", lambda *a, lowest, highest, **k: asked.append((lowest, highest)), raising=False
    )
    prepared(resolved(chip()), lowest=1e6, highest=3e6)
    assert [low for low, _ in asked][1:] == [high for _, high in asked][:-1]
    assert (asked[0][0], asked[-1][1]) == (1e6, 3e6)
    assert all(2 * (high - low) / (high + low) <= 0.5 for low, high in asked)


def test_the_centre_of_a_run_is_a_number_in_its_scene():
    record = run(chip("drive.frequency=center", "transducer.0.pattern=+-+-+-+-+-"), tolerance=3e-2)
    assert record.scene.frequency == record.wave["frequency_Hz"]
    assert record.scene.frequency == pytest.approx(2.17e6, rel=2e-2)  # v / period, v = 2170 m/s


def test_the_centre_is_that_of_the_lone_transducer():
    """Free ends and the slider's place leave it; the studies and sweeps take the same number."""
    scene = resolved(chip("drive.frequency=center"))
    assert resolved(chip("drive.frequency=center", "stator.ends=free")).frequency == scene.frequency
    block, (row,) = stator(scene.stator), Model(scene).transducers
    assert scene.frequency == best_frequency(block, row)


def test_periods_that_are_words():
    """auto: the strongest wave; half-space, and a row of one comb: the half-space's rule."""
    words = (chip("transducer.0.period=auto").transducer[0], chip("transducer.0.period=half-space").transducer[0])
    comb = replace(words[0], name="comb", center=16e-3, pattern="+" * 10, termination="open")
    rule_row = replace(words[1], name="rule", center=24e-3)
    found = resolved(replace(chip(), transducer=(words[0], comb, rule_row))).transducer
    block = stator(chip().stator)
    assert found[1].period == found[2].period == automatic_period(block.solid, 2.17e6, 0.5)
    assert found[0].period == best_period(block, build(chip()).transducers[0], 2.17e6)
    assert found[0].period != found[1].period


def test_a_frequency_at_which_the_band_fails_is_solved_by_itself():
    class Failing:
        limits = (1.0, 3.0)

        def wave(self, frequency, drive):
            raise ConvergenceError("its modes leave a residual")

    failing = Response(limits=(1.0, 3.0), bands=(Failing(),), alone=lambda frequency: ("alone", frequency))
    assert failing.wave(2.0, "left") == ("alone", 2.0)
