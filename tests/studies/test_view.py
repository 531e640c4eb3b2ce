"""The picture of a run's field: what its data hold, measured back, and that it is drawn off screen."""

import json

import numpy as np
import pytest
from PIL import Image

from studies.__main__ import main
from studies.chain import run
from studies.files import write_run
from studies.override import assigned
from studies.refusal import RunError, SceneError
from studies.run_field import run_field
from studies.scene import Scene, read_table
from studies.view import magnification, screenshot, section


def quiet(text):
    return None


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """A small driven motor, run with its field kept, and the same without."""
    table = read_table("twente-left")
    settings = ["stator.length=24 mm", "transducer.0.center=5 mm", "transducer.0.finger_pairs=3"]
    for setting in [*settings, "slider.position=14 mm", "drive.voltage=60"]:
        table = assigned(table, setting)
    record = run(Scene.from_table("", table), tolerance=1e-2)
    folders = [tmp_path_factory.mktemp(name) for name in ("kept", "anew")]
    for folder, field in zip(folders, (True, False), strict=True):
        write_run(record, folder, field=field)
    return record, *folders


def test_the_field_s_surface_is_the_motion_of_the_record(left):
    record, kept, anew = left
    for folder in (kept, anew):
        found = run_field(folder, progress=quiet)
        surface = found.field.displacement[:, -1]
        # a place where both were sampled: the stator's left end
        assert surface[0, 2] == pytest.approx(record.surface["u_z_m_per_V"][0], rel=1e-9)
        assert found.field.z[-1] == 0.0


def test_the_drawn_section_holds_the_field_with_its_wavelength(left):
    _, kept, _ = left
    found = run_field(kept, progress=quiet)
    grid = section(found, magnification(found), 0.0, 0.024, -0.005)
    values = grid[found.label]
    assert np.abs(values).max() == pytest.approx(
        abs(found.field.displacement[:, :, 2].real).max() * 1e9, rel=1e-12
    )
    far = section(found, 0.0, 0.012, 0.023, -1e-9)
    top = far.points[:, 2].max()
    x, u = far.points[far.points[:, 2] == top, 0], far[found.label][far.points[:, 2] == top]
    even = np.linspace(x[0], x[-1], 4096)
    spectrum = abs(np.fft.rfft(np.interp(even, x, u) * np.hanning(4096), 1 << 17))
    wavelength = (even[1] - even[0]) * (1 << 17) / spectrum.argmax()
    assert wavelength == pytest.approx(
        found.wavelength * 1e3, rel=0.01
    )  # 11 wavelengths and the plate's other modes


def test_the_enlarged_displacement_is_seen_and_its_factor_round(left):
    _, kept, _ = left
    found = run_field(kept, progress=quiet)
    factor = magnification(found)
    assert 0.04 < factor * abs(found.field.displacement).max() / found.wavelength < 0.16
    assert len(f"{factor:g}".strip("0")) == 1


def test_a_screenshot_shows_section_electrodes_and_slider(left, tmp_path):
    _, kept, _ = left
    screenshot(kept, tmp_path / "field.png", progress=quiet)
    pixels = np.asarray(Image.open(tmp_path / "field.png").convert("RGB")).astype(int)
    red = (pixels[:, :, 0] - pixels[:, :, 2] > 80).mean()
    blue = (pixels[:, :, 2] - pixels[:, :, 0] > 80).mean()
    comb = (abs(pixels - [230, 159, 0]).max(axis=2) < 10).sum()
    assert red > 1e-3
    assert blue > 1e-3
    assert comb > 100  # one comb's colour
    lower = pixels[-400:]
    grey = (np.ptp(lower, axis=2) < 12) & (lower.max(axis=2) < 180) & (lower.max(axis=2) > 30)
    assert grey[:, 700:900].sum() > 1000  # the ball, amid the lowest picture


def test_a_free_wave_is_drawn_from_its_profile(tmp_path):
    record = run(Scene.load("rayleigh"), tolerance=1e-3)
    write_run(record, tmp_path, field=True)
    found = run_field(tmp_path, progress=quiet)
    assert found.fingers == {}
    assert found.balls == found.close == ()
    u_x, _, u_z = found.field.displacement[0, -1]
    assert u_z == pytest.approx(1.0, abs=1e-12)
    assert (u_x / u_z).imag > 0  # retrograde: exp(+i omega t), towards +x
    steps = np.diff(np.unwrap(np.angle(found.field.displacement[:, -1, 2])))
    advance = 2 * np.pi * np.diff(found.field.x) / found.wavelength
    np.testing.assert_allclose(steps, -advance, rtol=1e-9)


def test_a_scene_without_a_stator_says_why_there_is_no_field(tmp_path):
    table = assigned(read_table("twente-contact"), "wave.normal_amplitude=3 nm")
    write_run(run(Scene.from_table("", table), tolerance=1e-3), tmp_path, field=False)
    with pytest.raises(SceneError, match="no wave field: its scene gives the surface motion"):
        run_field(tmp_path, progress=quiet)


@pytest.mark.parametrize("content", [None, "{}", "[]", "no json"])
def test_what_is_no_run_is_refused(tmp_path, content):
    if content is not None:
        (tmp_path / "run.json").write_text(content)
    with pytest.raises(SceneError, match="no directory that sawmotor run left"):
        run_field(tmp_path, progress=quiet)


def test_an_unknown_picture_format_is_refused(tmp_path):
    with pytest.raises(SceneError, match=r"^--screenshot must end in one of \.png"):
        screenshot(tmp_path, "field.gif", progress=quiet)


def test_without_a_display_the_window_is_refused_with_what_to_do(monkeypatch, tmp_path):
    from studies.view import show

    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(RunError, match="--screenshot"):
        show(tmp_path, progress=quiet)


def test_the_command_draws_and_names_the_file(left, tmp_path, monkeypatch, capsys):
    _, kept, _ = left
    monkeypatch.setattr("sys.argv", ["sawmotor", "view", str(kept), "--screenshot", str(tmp_path / "a.png")])
    assert main() == 0
    assert capsys.readouterr().out.strip().endswith("a.png")
    assert json.loads((kept / "run.json").read_text())["title"]
