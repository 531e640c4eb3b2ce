"""Many frequencies of a scene, and the centre frequency: bands against single solves, the maximum against a scan."""

from dataclasses import replace

import numpy as np
import pytest

from fem import ConvergenceError
from studies import Scene
from studies.chain import run
from studies.chain.center import center_frequency
from studies.chain.spectrum import Response, response, spectrum
from studies.refusal import RunError
from studies.scene import read_table
from studies.scene.override import assigned
from studies.scene.resolved import resolved


def quiet(text):
    return None


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
    return response(scene, lowest, highest, places=(place,), tolerance=3e-2, progress=quiet)


@pytest.fixture(scope="module")
def banded():
    scene = resolved(chip("drive.source_impedance=[20, 10]"))
    return scene, prepared(scene)


def test_a_band_gives_what_single_solves_give(banded):
    scene, many = banded
    assert len(many.bands) == 1
    frequencies = [2.12e6, 2.19e6]
    fast = spectrum(scene, many, frequencies, 20e-3)
    slow = spectrum(scene, replace(many, bands=()), frequencies, 20e-3)
    np.testing.assert_array_equal(fast.frequency, frequencies)
    for name in ("admittance", "normal", "tangential", "rayleigh_normal"):
        np.testing.assert_allclose(getattr(fast, name), getattr(slow, name), rtol=2e-3)
    assert 0 < fast.relative_error < 3e-2
    assert 0 < fast.admittance_error < 3e-2


@pytest.mark.parametrize(
    ("settings", "place"),
    [
        (["transducer.0.pattern=+-+-0-+-+-"], 20e-3),
        (["transducer.0.center=2.45 mm"], 20e-3),
        ([], 6e-3),
    ],
    ids=["a finger left out", "an end within half a gap", "a place under the fingers"],
)
def test_where_no_band_serves_each_frequency_is_solved_alone(settings, place):
    scene = resolved(chip(*settings))
    many = prepared(scene, place=place)
    assert many.bands == ()
    found = spectrum(scene, many, [2.15e6], place)
    single = run(replace(scene, drive=replace(scene.drive, frequency=2.15e6)), tolerance=3e-2)
    assert found.admittance[0] == pytest.approx(single.electrical["admittance_S"], rel=1e-2)
    assert np.isfinite(found.normal[0])
    assert np.isnan(found.rayleigh_normal[0]) == (place == 6e-3)


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


@pytest.mark.parametrize("ends", ["absorbing", pytest.param("free", marks=pytest.mark.slow)])
def test_the_centre_is_the_largest_of_a_scan(ends):
    """The surface mode's amplitude, against single solves over the lobe and close by."""
    scene = resolved(chip("drive.frequency=center", f"stator.ends={ends}"))
    found = center_frequency(scene, 20e-3, progress=quiet)
    alone = replace(prepared(scene, 0.9 * found, 1.1 * found), bands=())

    def size(frequency):
        return abs(spectrum(scene, alone, [frequency], 20e-3).rayleigh_normal[0])

    best = size(found)
    for offset in (-0.03, 0.007):
        assert size(found * (1 + offset)) < best
    for offset in (-1e-3, 1e-3):
        assert size(found * (1 + offset)) < best * (1 + 1e-6)


def test_the_centre_of_a_run_is_a_number_in_its_scene():
    record = run(chip("drive.frequency=center", "transducer.0.pattern=+-+-+-+-+-"), tolerance=3e-2)
    assert record.scene.frequency == record.wave["frequency_Hz"]
    assert record.scene.frequency == pytest.approx(2.17e6, rel=2e-2)  # v / period, v = 2170 m/s


def test_a_lobe_beyond_the_range_is_refused(monkeypatch):
    from types import SimpleNamespace

    import studies.chain.center as center

    rising = SimpleNamespace(
        waves=lambda frequencies, drive: [
            SimpleNamespace(
                covered=lambda place: False, rayleigh_motion=lambda place, f=f: np.array([0.0, f])
            )
            for f in frequencies
        ],
        limits=(1.7e6, 2.6e6),
    )
    monkeypatch.setattr(center, "response", lambda *arguments, **rest: rising)
    with pytest.raises(RunError, match=r"no maximum between 1\.7 and 2\.6 MHz: give drive\.frequency"):
        center_frequency(resolved(chip("drive.frequency=center")), 20e-3, progress=quiet)


def test_a_frequency_at_which_the_band_fails_is_solved_by_itself():
    class Failing:
        limits = (1.0, 3.0)

        def wave(self, frequency, drive):
            raise ConvergenceError("its modes leave a residual")

    failing = Response(limits=(1.0, 3.0), bands=(Failing(),), alone=lambda frequency: ("alone", frequency))
    assert failing.wave(2.0, "left") == ("alone", 2.0)
