"""What `sawmotor view` shows: the drawn data measured back, and refusals in one sentence; everything off screen."""

import base64
import gzip
import io
import json
import re
import shutil
import subprocess
import sys
import tomllib
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
import pyvista
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from studies import view
from studies.__main__ import main
from studies.model.resolve import resolved
from studies.record.files import write_run
from studies.refusal import RunError, SceneError
from studies.report import beam_map
from studies.runs import run
from studies.scene import Scene, read_table
from studies.view import field_data, field_points, gallery_pictures, movie, overlays, wave_page
from studies.view.field_points import SectionPart, beam_sheet, magnification, sheets
from studies.view.field_quantities import shade
from studies.view.overlays import electrodes, shown_fingers
from studies.view.picture import Picture, validity
from studies.view.plane_contact_view import plane_contact_writers
from studies.view.run_field import run_field
from studies.view.view_options import Wanted
from studies.view.views import RIGHT, View, frames, limits, near, span_views, views
from tests.studies.legible import assert_legible
from tests.studies.pixels import BALL, BARE, BLACK, MM, PINK, SolidPicture, Window, close, ink, runs, values
from tests.studies.settings import SHORT, changed

CHROMIUM = shutil.which("chromium")


def quiet(text):
    return None


def picture_of(motor, shown=(), **changes):
    options = {"quantity": "u_z", "phase": 0.0, "factor": None, "size": (700, 300)}
    return Picture(motor, shown, **(options | changes))


def moved(motor, phase, factor):
    """Positions x and z (m) of the nodes on the surface as they are drawn."""
    u = factor * (motor.field.displacement[:, -1] * np.exp(1j * phase)).real
    return motor.field.x + u[:, 0], u[:, 2]


@pytest.fixture(autouse=True, scope="module")
def _the_map_of_a_beam_is_computed_once():
    """Three pictures show the same beam, whose motion over the surface takes most of their time."""
    of_surface, known = field_points.surface_map, {}

    def once(beam, stator, *arguments, **options):
        key = id(beam), stator, arguments
        if key not in known:
            known[key] = beam, of_surface(beam, stator, *arguments, **options)
        return known[key][1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(field_points, "surface_map", once)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A small driven motor that has been run."""
    scene = changed("twente-left", *SHORT, "stator.thickness=3 mm", "drive.voltage=60")
    folder = tmp_path_factory.mktemp("run")
    write_run(run(scene, tolerance=1e-2), folder, field=False)
    return folder


@pytest.fixture(scope="module")
def motor(folder):
    return run_field(folder)


@pytest.fixture(scope="module")
def screenshot(motor, folder, tmp_path_factory):
    """The views of that motor as `sawmotor view --screenshot` writes them: pixels, and its frames."""
    file, size = tmp_path_factory.mktemp("screenshot") / "a.png", (1000, 700)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(view, "run_field", lambda folder: motor)
        view.view(folder, Wanted(screenshot=str(file), size=size))
    with Image.open(file) as image:
        return np.asarray(image.convert("RGB")), frames(motor, views(motor), size=size, framed=True)


@pytest.fixture
def computed(motor, folder, monkeypatch):
    """The same motor, whose field is not computed again by what shows it."""
    monkeypatch.setattr(view, "run_field", lambda folder: motor)
    return folder


@pytest.fixture(scope="module")
def long(tmp_path_factory):
    """Seventy wavelengths of the seed's stator beside a transducer, absorbing ends, without a slider."""
    alone = "stator.length=95 mm", "transducer.0.period=0.98 mm", "drive.voltage=1", "-slider"
    folder = tmp_path_factory.mktemp("long")
    write_run(run(changed("twente-left", *alone), tolerance=1e-2), folder, field=False)
    return run_field(folder)


@pytest.fixture(scope="module")
def prescribed_run(tmp_path_factory):
    """A run whose scene gives the surface motion."""
    folder = tmp_path_factory.mktemp("prescribed")
    scene = changed("twente-contact", "wave.normal_amplitude=[3e-9, 10e-9]")
    write_run(run(scene, tolerance=1e-3), folder, field=False)
    return folder


def test_the_exported_field_moves_the_surface_as_the_run_says(motor, folder, tmp_path):
    """Read by meshio, linear interpolation along the surface gives run.json's motion of the section there."""
    field_data.save(motor, tmp_path / "field.vtu", span=None, instants=0, note=quiet)
    mesh = meshio.read(tmp_path / "field.vtu")
    wave = json.loads((folder / "run.json").read_text())["wave"]
    top = mesh.points[:, 2] == 0
    x, order = mesh.points[top, 0], np.argsort(mesh.points[top, 0])
    for axis, name in ((0, "section_tangential_m_per_V"), (2, "section_normal_m_per_V")):
        for part, key in enumerate(("real", "imag")):
            values = mesh.point_data[f"displacement_m_per_V_{key}"][top, axis]
            assert np.interp(14.123e-3, x[order], values[order]) == pytest.approx(wave[name][part], rel=1e-10, abs=0)
    for name in ("strain_energy_J_per_m3_per_V2", "power_flow_W_per_m2_per_V2"):
        assert {name, f"{name}_pulse_real", f"{name}_pulse_imag"} <= set(mesh.point_data)


def test_a_run_that_does_not_tell_its_resolution_is_run_again(motor, folder, tmp_path):
    shutil.copytree(folder, tmp_path / "older")
    record = json.loads((folder / "run.json").read_text())
    del record["wave"]["resolution"]
    (tmp_path / "older" / "run.json").write_text(json.dumps(record))
    again = run_field(tmp_path / "older")
    assert again.surface(14.123e-3) == pytest.approx(motor.surface(14.123e-3), rel=2e-2)


def test_the_drawn_field_has_the_computed_wavelength(long):
    """Phase of the colours below the surface at two instants a quarter period apart, fitted over 70 wavelengths."""
    drawn = picture_of(long, (View(name="", start=0.022, stop=0.094, weight=1.0),), size=(2400, 200), factor=0.0)
    rows = []
    for phase in (0.0, -0.5 * np.pi):
        window = Window.of(drawn.image(phase), drawn.frames[0])
        rows.append(values(window.pixels[np.searchsorted(-window.z, 0.0) + 3], drawn.shade))
    slope = np.polyfit(window.x, np.unwrap(np.angle(rows[0] + 1j * rows[1])), 1)[0]
    assert slope < 0  # exp(+i omega t): the wave runs to +x
    assert 2 * np.pi / -slope == pytest.approx(long.wavelength, rel=1e-3)


def test_in_time_the_drawn_wave_runs_and_its_crests_move_back(motor):
    """The edge of the section, enlarged to a sixth of a wavelength, has the computed shape; later it lies at larger x.

    Along x the material moves by 20 pixels, at the crests to -x.
    """
    drawn, edges = picture_of(motor, (View(name="", start=0.012, stop=0.016, weight=1.0),), factor=1.5e6), []
    (frame,) = drawn.frames
    for phase in (0.0, 0.3):
        window = Window.of(drawn.image(phase), frame)
        edges.append(window.edge(drawn.shade))
        expected = np.interp(window.x, *moved(motor, phase, 1.5e6))
        assert abs(edges[-1] - expected).max() < 2.5 * frame.pixel
    before, after = edges
    step = round(0.3 / (2 * np.pi) * motor.wavelength / frame.pixel)
    assert np.sum(before[:-step] * after[step:]) > 1.05 * np.sum(before[step:] * after[:-step])


def test_colours_are_the_field_s_from_end_to_end_of_the_bar(motor, screenshot):
    """The undeformed section 0.5 mm below the surface, and the bar beside the frames."""
    drawn = picture_of(motor, views(motor)[1:2], factor=0.0)
    ((start, stop),) = motor.spans
    outside = (motor.field.x < start - 0.25 * motor.wavelength) | (motor.field.x > stop + 0.25 * motor.wavelength)
    largest = abs(motor.field.displacement[outside, :, 2]).max() * 1e9
    assert drawn.shade.limits == pytest.approx((-largest, largest), rel=1e-12)
    assert abs(motor.field.displacement[..., 2]).max() * 1e9 > 1.01 * largest  # singular at the edges
    assert drawn.shade.label == "u_z (nm per V)"
    image, shown = screenshot
    bar = values(image[:, int(shown[0].box[2]) + 20 :], drawn.shade)
    bar = bar[:, np.isfinite(bar).sum(axis=0).argmax()]
    first, last = runs(np.isfinite(bar))[-1]
    ends = bar[first], bar[last - 1]
    assert ends == pytest.approx((largest, -largest), rel=0.02)
    assert last - first > 100
    window = Window.of(drawn.image(0.4), drawn.frames[0])
    depth = abs(motor.field.z + 0.5e-3).argmin()
    row = abs(window.z - motor.field.z[depth]).argmin()
    u_z = (motor.field.displacement[:, depth, 2] * np.exp(0.4j)).real * 1e9
    pixel_values = values(window.pixels[row], drawn.shade)
    assert abs(pixel_values - np.interp(window.x, motor.field.x, u_z)).max() < 0.06 * largest
    energy = picture_of(motor, views(motor)[1:2], quantity="strain_energy", factor=0.0)
    assert energy.shade.limits[0] == 0 < energy.shade.limits[1]
    window = Window.of(energy.image(0.0), energy.frames[0])
    below = values(window.pixels[window.z < 0], energy.shade)
    assert np.isfinite(below).mean() > 0.98
    assert np.nanmax(below) > 0.5 * energy.shade.scale_end


def test_far_away_nodes_are_passed_over_and_none_is_averaged(motor):
    far = SectionPart.of(motor, shade(motor, "u_z"), span=(0.0, motor.length), bottom=-3e-3, spacing=0.1e-3)
    field = motor.field
    lines, rows = np.searchsorted(field.x, far.x), np.abs(field.z[:, None] - far.z).argmin(axis=0)
    assert len(far.x) < 0.6 * len(field.x)
    np.testing.assert_array_equal(field.x[lines], far.x)
    np.testing.assert_allclose(far.displacement, field.displacement[np.ix_(lines, rows)][..., [0, 2]], rtol=1e-9)
    assert np.diff(far.x)[:-1].min() >= 0.1e-3


def test_from_near_the_modes_give_the_lines_between(motor):
    """Within one wavelength hundreds of lines, on the stator's own motion."""
    start, stop = 14e-3, 15e-3
    near = SectionPart.of(motor, shade(motor, "u_z"), span=(start, stop), bottom=-0.4e-3, spacing=1e-6)
    assert len(near.x) > 150
    assert np.diff(near.z).max() < 7e-6
    coarse = motor.compute(span=(start, stop), per_wavelength=4000.0, energies=False)
    for k, axis in enumerate((0, 2)):
        expected = np.interp(near.x, coarse.x, coarse.displacement[:, -1, axis].real)
        np.testing.assert_allclose(near.displacement[:, -1, k].real, expected, atol=4e-6 * abs(expected).max())


def test_the_enlarged_displacement_is_seen_and_its_factor_round(motor):
    factor = magnification(motor)
    assert 0.04 < factor * abs(motor.field.displacement).max() / motor.wavelength < 0.16
    assert len(f"{factor:g}".strip("0")) == 1


def test_a_screenshot_shows_section_electrodes_and_slider_where_they_are(motor, screenshot):
    """In the lowest view the slider, on the crests; in the middle one the fingers: 0.245 mm wide, 0.49 mm apart."""
    image, shown = screenshot
    assert image.shape == (700, 1000, 3)
    window = Window.of(image, shown[-1])
    pixel_values = values(window.pixels, shade(motor, "u_z"))
    assert np.nanmin(pixel_values) < -0.08 < 0.08 < np.nanmax(pixel_values)
    ball = close(window.pixels, BALL, 4)
    columns = np.flatnonzero(ball.sum(axis=0) > 6)
    first, last = window.x[columns[[0, -1]]]
    assert 0.5 * (first + last) == pytest.approx(14.123e-3, abs=2 * shown[-1].pixel)
    assert last - first == pytest.approx(2e-3, rel=0.03)
    crest = magnification(motor) * abs(motor.surface(14.123e-3)[1])
    assert window.z[ball.any(axis=1)].min() == pytest.approx(crest, abs=2 * shown[-1].pixel)
    window = Window.of(image, shown[1])
    surface = abs(window.z) < 0.1e-3
    for colour, fingers in ((BLACK, (0, 2, 4)), (PINK, (1, 3, 5))):
        strips = runs(close(window.pixels, colour)[surface].any(axis=0))
        middles = [window.x[[first, last - 1]].mean() for first, last in strips]
        assert middles == pytest.approx([5e-3 + 0.49e-3 * (k - 2.5) for k in fingers], abs=4 * shown[1].pixel)


@pytest.mark.parametrize("width", [400, 600])
def test_the_first_caption_of_a_narrow_picture_is_legible(motor, width):
    """It stands in at least two lines of 10 pixels above the view, and beside the legend."""
    drawn = picture_of(motor, span_views(motor, (12e-3, 15e-3)), size=(width, 400))
    _, _, right, high = drawn.frames[0].box
    head = ink(drawn.image(0.0)[: 400 - int(high) - 2, : int(right) + 6])
    first, last = np.flatnonzero(head[:, : int(right)].any(axis=1))[[0, -1]]
    assert last - first > 16
    assert not head[:, int(right) :].any()


@pytest.mark.parametrize("show", ["field", "solid"])
def test_the_smallest_picture_is_drawn_whatever_the_case_of_its_format(computed, tmp_path, show):
    wanted = Wanted(screenshot=str(tmp_path / "a.JPEG"), size=(200, 100), show=show)
    view.view(computed, wanted)
    with Image.open(tmp_path / "a.JPEG") as picture:
        assert picture.size == (200, 100)
        assert np.asarray(picture).std() > 5


@pytest.mark.parametrize(("start", "stop", "whole"), [(0.0, 0.024, True), (0.0138, 0.0144, False)])
def test_a_view_has_room_for_depth_and_ball(motor, start, stop, whole):
    """From far the whole depth and the whole ball, from near a part of both; one scale for lengths and heights."""
    drawn = picture_of(motor, (View(name="", start=start, stop=stop, weight=1.0),), size=(1000, 500))
    (frame,) = drawn.frames
    left, _, right, _ = frame.box
    assert (right - left) * frame.pixel == pytest.approx(stop - start)
    window = Window.of(drawn.image(0.0), frame, border=1)
    ball = close(window.pixels, BALL, 4)
    seen = [window.x[ball.any(axis=0)], window.z[ball.any(axis=1)]]
    if whole:
        assert [np.ptp(each) for each in seen] == pytest.approx([2e-3, 2e-3], abs=2.5 * frame.pixel)
        assert frame.bottom == pytest.approx(motor.field.z[0])
    else:
        assert len(seen[0]) == len(window.x)
    coloured = np.isfinite(values(window.pixels, drawn.shade))
    assert window.z[coloured.any(axis=1)].min() == pytest.approx(frame.bottom, abs=3 * frame.pixel)


def test_the_slider_s_view_holds_all_its_balls_and_no_empty_half(motor, tmp_path):
    """Balls farther apart than the usual 14 wavelengths; the picture ends below the views."""
    wide = replace(motor.scene.slider, contacts=((-0.008, 0.0), (0.008, 0.0)))
    wider = replace(motor, record=replace(motor.record, scene=replace(motor.scene, slider=wide)))
    start, stop = limits(wider, "slider")
    assert stop - start >= 0.016 + 2 * wide.radius
    assert stop - start > 14.1 * motor.wavelength
    drawn = picture_of(wider, span_views(wider, (start, stop)), size=(400, 600))
    low = drawn.frames[-1].box[1]
    drawn.save(tmp_path / "a.png", whole=False)
    with Image.open(tmp_path / "a.png") as saved:
        assert saved.size == (400, 650 - int(low))


@pytest.mark.parametrize(("span", "size"), [("wavelength", (800, 550)), ("slider", (720, 300)), (None, (1000, 700))])
def test_captions_rulers_and_legend_do_not_collide(motor, screenshot, span, size):
    """Nothing is cut by the picture's edge; captions lie between the frames, colour bar and legend beside them."""
    if span is None:
        image, shown = screenshot
    else:
        drawn = picture_of(motor, span_views(motor, limits(motor, span)), size=size)
        image, shown = drawn.image(0.0), drawn.frames
    for edge in (image[:2], image[-2:], image[:, :2], image[:, -2:]):
        assert np.all(edge == 255)
    drawn, right = ink(image), int(shown[0].box[2])
    assert not drawn[:, right + 2 : right + 12].any()
    floor = 0
    for number, frame in enumerate(shown):
        top = int(size[1] - frame.box[3])
        lines = runs(drawn[floor + 2 : top - 2, :right].any(axis=1))
        assert len(lines) >= (3 if number else 1)  # the caption, below numbers and title of the ruler above
        first, last = lines[-1]
        assert 4 < last - first < 22
        assert floor + 2 + last < top - 2
        floor = int(size[1] - frame.box[1])
    beside = image[:, right + 12 :]
    black, pink = (np.flatnonzero(close(beside, colour).any(axis=1)) for colour in (BLACK, PINK))
    bar = np.flatnonzero(np.isfinite(values(beside, shade(motor, "u_z"))).sum(axis=1) > 20)
    assert black.min() < pink.min() < pink.max() < bar.min()
    high = int(size[1] - max(shown, key=lambda frame: frame.box[3] - frame.box[1]).box[3])
    if high > 80:
        assert drawn[high:, 5:40].any()  # the title of the upright ruler


def test_captions_name_the_part_and_its_fingers(motor):
    whole, part = span_views(motor, limits(motor, "wavelength"))
    assert part.name == "1 wavelength, 13.63 to 14.62 mm"
    assert shown_fingers(motor, whole.start, whole.stop) == "6 of 6 fingers"
    assert shown_fingers(motor, part.start, part.stop) == ""
    assert [(each.sign, each.label) for each in electrodes(motor)] == [("+", "+ fingers"), ("-", "- fingers")]


def test_fingers_ride_on_the_surface(motor):
    """Black and pink lines lie on the edge of the enlarged section."""
    drawn = picture_of(motor, (View(name="", start=0.003, stop=0.007, weight=1.0),), factor=4e5)
    window = Window.of(drawn.image(0.9), drawn.frames[0])
    x, z = moved(motor, 0.9, 4e5)
    for colour in (BLACK, PINK):
        rows, columns = np.nonzero(close(window.pixels, colour, 4))
        assert len(rows) > 150
        off = window.z[rows] - np.interp(window.x[columns], x, z)
        assert np.quantile(abs(off), 0.9) < 4 * drawn.frames[0].pixel


def test_a_free_wave_is_drawn_from_its_profile(tmp_path):
    write_run(run(Scene.load("rayleigh"), tolerance=1e-3), tmp_path, field=True)
    free = run_field(tmp_path)
    assert free.fingers == {}
    assert free.spans == ()
    u_x, _, u_z = free.field.displacement[0, -1]
    assert u_z == pytest.approx(1.0, abs=1e-12)
    assert (u_x / u_z).imag > 0  # retrograde: exp(+i omega t), towards +x
    steps = np.diff(np.unwrap(np.angle(free.field.displacement[:, -1, 2])))
    np.testing.assert_allclose(steps, -2 * np.pi * np.diff(free.field.x) / free.wavelength, rtol=1e-9)
    # measured in the picture itself: colours of the undeformed section just below the surface
    drawn = picture_of(free, views(free), factor=0.0, size=(1600, 200))
    window, (frame,) = Window.of(drawn.image(0.0), drawn.frames[0]), drawn.frames
    tone = values(window.pixels[np.searchsorted(-window.z, 0.0) + 3], drawn.shade)
    spectrum = abs(np.fft.rfft((tone - tone.mean()) * np.hanning(len(tone)), 1 << 20))
    assert (1 << 20) / spectrum.argmax() * frame.pixel == pytest.approx(free.wavelength, rel=1e-3)


def test_a_field_that_a_solid_does_not_have_is_refused(motor, tmp_path):
    with pytest.raises(
        SceneError, match=r"--quantity 'u_y' is zero everywhere: uncoupled in this solid, orientation Z"
    ):
        picture_of(motor, views(motor), quantity="u_y")


@pytest.fixture(scope="module")
def plane(motor):
    """The same run as if the wave did not spread."""
    scene = motor.scene.replace(stator={"diffraction": False})
    return replace(motor, record=replace(motor.record, scene=scene))


BOX = (0, 24), (-17.5, 17.5), (-3, 0)  # of the solid, mm


def test_the_solid_carries_the_beam_over_its_whole_width(motor):
    """Surface and colours as `fem.surface_beam` has them; what the surface does not have is refused."""
    drawn = picture_of(motor, factor=0.0, size=(900, 450))
    solid = SolidPicture(drawn.image(0.4), drawn.frames[0], BOX)
    drawn.plotter.close()
    assert solid.height[0] == pytest.approx(solid.height[1], abs=3)
    x = np.concatenate([np.linspace(0.5, 3.0, 15), np.linspace(7, 12, 30), np.linspace(16, 23.5, 40)])[:, None]
    y = np.linspace(-16, 16, 17)
    pixel_values = values(solid.colours(np.stack(np.broadcast_arrays(x, y, 0.0), axis=-1)), drawn.shade)
    expected = 1e9 * (motor.beam.motion(x / MM, y / MM)[2] * np.exp(0.4j)).real
    seen = np.isfinite(pixel_values)
    assert seen.mean() > 0.98
    assert (
        np.corrcoef(pixel_values[seen], expected[seen])[0, 1] > 0.9
    )  # the positions are known to a pixel, a thirteenth of a mm
    _, sheet, _ = beam_sheet(motor, "u_z")
    at = np.s_[::74, ::10, 0]
    motion = np.moveaxis(motor.beam.motion(*np.moveaxis(sheet.rest[at], -1, 0)[:2]), 0, -1)
    np.testing.assert_allclose(sheet.displacement[at], motion, atol=1e-6 * abs(motion).max())
    np.testing.assert_allclose(sheet.amplitude[at], 1e9 * motion[..., 2], atol=1e3 * abs(motion).max())
    outer = abs(motor.beam.motion(motor.focus[1], 15e-3)[2])
    assert 1e-3 * abs(motion).max() < outer < 0.2 * abs(motion).max()
    assert "on the surface" in validity(motor)
    with pytest.raises(SceneError, match="--quantity must be one of u_x, u_y, u_z on the surface of the beam"):
        picture_of(motor, quantity="power_flow")


def test_pictures_of_the_gallery_keep_their_colours(motor, tmp_path):
    """The palette is that of the picture's own colour map: the solid of a short stator shows u_z with its sign."""
    picture = picture_of(motor, size=(500, 250))
    whole = picture.image(0.0).astype(int)
    gallery_pictures.still(picture, tmp_path / "saved.png")
    saved = np.asarray(Image.open(tmp_path / "saved.png").convert("RGB")).astype(int)
    assert (whole[..., 0] - whole[..., 2] > 60).mean() > 1e-3
    assert (abs(whole - saved).max(axis=2) > 40).mean() < 1e-3


@pytest.fixture(scope="module")
def solid(plane):
    """Pictures of the solid without spreading at two instants, with the usual factor."""
    drawn = picture_of(plane, size=(900, 450))
    pictures = {phase: SolidPicture(drawn.image(phase), drawn.frames[0], BOX) for phase in (0.4, 2.0)}
    drawn.plotter.close()
    return drawn, pictures


def test_the_solid_carries_field_within_the_aperture_only_and_says_so(plane, solid):
    """Colours as far as 10 mm from the middle line, grey behind it; four lines of text."""
    drawn, pictures = solid
    picture = pictures[0.4]
    assert picture.height[0] == pytest.approx(picture.height[1], abs=3)
    x = np.linspace(15.5, 23.5, 100)[:, None]
    inside, outside = (np.stack(np.broadcast_arrays(x, y, 0.0), axis=-1) for y in (np.linspace(-9, 9, 9), [11, 14, 17]))
    assert np.isfinite(values(picture.colours(inside), drawn.shade)).mean() > 0.95
    assert close(picture.colours(outside), BARE, 2).mean() > 0.95
    assert "only within the 20 mm aperture" in validity(plane)
    first_letters = ink(picture.image[: int(picture.extent[1][0]) - 4, 3:12])
    assert len(runs(first_letters.any(axis=1))) == 4
    written = ink(picture.image[:60, : -RIGHT + 8]).any(axis=0)  # beside the legend, which begins behind these columns
    assert not written[-8:].any()


def test_the_bar_of_a_small_solid_stands_below_the_legend(plane):
    """Two lines of the legend end 62 pixels below the edge; the title of the bar takes two lines of 20 pixels more."""
    drawn = picture_of(plane, size=(600, 300))
    pixel_values = values(drawn.image(0.0)[:, int(drawn.frames[0].box[2]) + 10 :], drawn.shade)
    drawn.plotter.close()
    assert np.flatnonzero(np.isfinite(pixel_values).sum(axis=1) > 20)[0] > 62 + 2 * 20


def test_surface_electrodes_and_balls_of_the_solid_move_as_the_section_does(plane, solid):
    """The sheet has the section's displacement; a little above it are fingers of both colours, and on it the ball."""
    drawn, pictures = solid
    _, surface, _ = sheets(plane, drawn.parts[0], drawn.shade, solid=True)
    assert surface.rest[..., 1].min() == pytest.approx(-10e-3)
    x, displacement = plane.field.x, plane.field.displacement[:, -1]
    expected = np.interp(surface.rest[:, 0, 0, 0], x, displacement[:, 2])
    np.testing.assert_allclose(surface.displacement[:, 0, 0, 2], expected, atol=1e-3 * abs(expected).max())
    y = np.linspace(-9e-3, 9e-3, 19)
    for phase, picture in pictures.items():
        for sign, colour in (("+", BLACK), ("-", PINK)):
            for strip in plane.fingers[sign]:
                along = np.linspace(*strip, 9)[2:-2]
                u_x, _, u_z = drawn.factor * np.array([np.interp(along, x, each) for each in displacement.T])
                at = (along + (u_x * np.exp(1j * phase)).real)[:, None], y, (u_z * np.exp(1j * phase)).real[:, None]
                points = np.stack(np.broadcast_arrays(*at), axis=-1)
                assert close(picture.colours(MM * points + [0, 0, 0.02]), colour, 40).mean() > 0.35
        (red, green, blue), crest = picture.colours([14.123, 0, 1.0]).astype(int), picture.colours([14.123, 0, 2.5])
        assert max(red, green, blue) - min(red, green, blue) < 8
        assert np.isfinite(values(crest[None, None], drawn.shade)).all()  # above the ball is the surface behind it


def test_a_movie_holds_one_period(computed, tmp_path):
    file = tmp_path / "a.gif"
    view.view(computed, Wanted(movie=str(file), size=(500, 220), frames=4, span="slider"))
    with Image.open(file) as picture:
        assert (picture.n_frames, picture.size) == (4, (500, 220))
        frames = []
        for number in range(4):
            picture.seek(number)
            frames.append(np.asarray(picture.convert("RGB")).astype(float))
    tones = [(frame[..., 0] - frame[..., 2])[100:, 100:360] for frame in frames]
    half_a_period, quarter = (np.corrcoef(tones[0].ravel(), tones[k].ravel())[0, 1] for k in (2, 1))
    assert half_a_period < -0.8
    assert abs(quarter) < 0.5


@pytest.mark.skipif(shutil.which("ffmpeg") is None, reason="an MP4 needs ffmpeg")
def test_a_movie_as_mp4(tmp_path):
    movie.save(lambda number: np.full((50, 81, 3), 30 * number, np.uint8), 8, tmp_path / "a.mp4", rate=8.0)
    assert (tmp_path / "a.mp4").read_bytes()[4:8] == b"ftyp"


def test_without_ffmpeg_the_sentence_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(shutil, "which", lambda name: None)
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(RunError, match="ffmpeg, which is not installed: pip install imageio-ffmpeg, or name a"):
        movie.ffmpeg()


def test_without_pyvista_the_sentence_says_what_to_install(monkeypatch, computed, tmp_path):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    with pytest.raises(RunError, match="pip install pyvista"):
        view.view(computed, Wanted(screenshot=str(tmp_path / "a.png")))


def test_without_a_display_the_window_is_refused_with_what_to_do(monkeypatch, folder, prescribed_run):
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    for which in (folder, prescribed_run):
        with pytest.raises(RunError, match="no display to open a window on; --screenshot"):
            view.view(which, Wanted())


def test_without_a_toolkit_the_contact_s_window_is_refused_with_what_to_install(monkeypatch, prescribed_run):
    from matplotlib import pyplot

    monkeypatch.setenv("DISPLAY", ":0")
    monkeypatch.setattr(pyplot, "get_backend", lambda: "agg")
    with pytest.raises(RunError, match="needs a toolkit that matplotlib can use: pip install PySide6"):
        view.view(prescribed_run, Wanted())


def test_the_window_plays_pauses_and_picks(motor, monkeypatch):
    """Two wavelengths fill the window; what is picked is drawn."""
    from studies.view.window import Controls

    monkeypatch.setattr(pyvista, "OFF_SCREEN", True)
    drawn = picture_of(motor, span_views(motor, near(motor))[-1:], phase=1.0, size=(600, 400), framed=False)
    window = Controls(drawn)
    assert window.playing
    window.tick(0)
    assert drawn.phase > 1.0
    window.pick_phase(90.0)
    assert not window.playing
    window.tick(1)
    assert drawn.phase == pytest.approx(np.pi / 2)
    (frame,), start = drawn.frames, near(motor)[0]
    image = drawn.plotter.screenshot(return_img=True)
    seen = Window.of(image, frame._replace(view=replace(frame.view, start=start)))
    assert 600 * frame.pixel == pytest.approx(2 * motor.wavelength)
    expected = np.interp(seen.x, *moved(motor, np.pi / 2, drawn.factor))
    middle = abs(seen.z) < 0.15e-3  # below the text, above the controls
    edge = seen._replace(pixels=seen.pixels[middle], z=seen.z[middle]).edge(drawn.shade)
    assert np.nanmax(abs(edge - expected)[:480]) < 4 * frame.pixel  # the rest is behind the colour bar
    window.pick_quantity("power_flow")
    assert drawn.shade.label.startswith("power flow along x (W/m^2")
    assert (abs(drawn.plotter.screenshot(return_img=True).astype(int) - image)[150:300] > 60).mean() > 0.05
    drawn.plotter.close()


@pytest.fixture(scope="module")
def page(motor):
    return wave_page.page(motor, quantity="potential", phase=0.5, factor=None, span=(0.012, 0.016))


@pytest.mark.parametrize(("length", "width"), [("20 mm", "12 mm"), ("60 mm", "14 mm"), ("160 mm", "35 mm")])
def test_the_map_of_the_beam_has_room_for_its_texts(monkeypatch, length, width):
    """Title, labels and colour bar lie inside the picture, and the stator fills most of it."""
    scene = Scene.load("lithium-niobate-yz").replace(stator={"length": length, "width": width})
    x, y = np.linspace(0, scene.stator.length, 9), np.linspace(-0.5, 0.5, 5) * scene.stator.width
    field = np.multiply.outer(np.ones(3), np.outer(np.cos(3e3 * x), y + scene.stator.width)) * 1e-9
    monkeypatch.setattr(beam_map, "surface_map", lambda beam, stator, *, picture: (x, y, field))
    wide, high = (each / 150 for each in beam_map.pixels(scene.stator))
    figure = Figure(figsize=(wide, high), dpi=150, layout="constrained")
    FigureCanvasAgg(figure)
    ax = figure.add_subplot()
    beam_map.draw_surface_map(None, scene, ax)
    assert_legible(figure)
    drawn = ax.get_window_extent()
    assert drawn.width * drawn.height > 0.45 * figure.bbox.width * figure.bbox.height


def test_the_page_shows_the_beam_beside_the_plane_section(page, plane):
    """A picture of the size of u_z over the surface, in its proportions; none where the wave does not spread."""
    (picture,) = re.findall(r'<img alt="size of u_z over the surface[^>]*base64,([^"]*)"', page)
    width, height = Image.open(io.BytesIO(base64.b64decode(picture))).size
    wide, high = beam_map.pixels(plane.scene.stator)
    assert width / height == pytest.approx(wide / high, rel=0.02)
    assert "plane section" in page
    without = wave_page.page(plane, quantity="u_z", phase=0.0, factor=None, span=None)
    assert "<img" not in without


def test_the_page_needs_nothing_from_elsewhere(page):
    without_data = re.sub(r'<script id="data".*?</script>|base64,[^"]*', "", page, flags=re.S)
    assert not re.search(r"(https?:)?//[a-z]", without_data)
    assert not re.search(r"\b(src|href)=(?!\"data:)", without_data)
    assert "@META@" not in page
    assert "@DATA@" not in page


def test_the_page_carries_the_field(page, motor):
    meta = json.loads(re.search(r'<script id="meta"[^>]*>(.*?)</script>', page, re.S).group(1))
    raw = gzip.decompress(base64.b64decode(re.search(r'<script id="data"[^>]*>(.*?)</script>', page, re.S).group(1)))
    arrays, offset = {}, 0
    for name, kind, length in meta["arrays"]:
        arrays[name] = np.frombuffer(raw, dtype=f"<{kind}", count=length, offset=offset)
        offset += -(-arrays[name].nbytes // 4) * 4
    assert offset == len(raw)
    lines = np.abs(motor.field.x[:, None] - arrays["x"]).argmin(axis=0)
    rows = np.abs(motor.field.z[:, None] - arrays["z"]).argmin(axis=0)
    moved = arrays["moved"].reshape(meta["nx"], meta["nz"], 4) / 32767 * meta["moved_scale"]
    field = motor.field.displacement[np.ix_(lines, rows)]
    assert abs(moved[..., 2] + 1j * moved[..., 3] - field[..., 2]).max() < 3e-5 * meta["moved_scale"]
    names = [each["name"] for each in meta["quantities"]]
    assert names == ["u_z", "u_x", "potential", "strain_energy", "power_flow"]
    power = meta["quantities"][-1]
    mean = arrays["power_flow"].reshape(meta["nx"], meta["nz"], 4)[..., 0] / 32767 * power["scale"]
    expected = motor.with_energies.densities.power_flow[np.ix_(lines, rows)][..., 0]
    assert abs(mean - expected).max() < 3e-5 * power["scale"]
    assert (power["harmonic"], power["signed"], meta["balls"]) == (2, True, [14.123e-3])
    assert len(meta["fingers"]) == 6


def test_what_the_program_reads_is_installed_with_it():
    """Scenes, their reference and schema, templates and the marker of type hints are package data."""
    root = Path(__file__).parents[2]
    patterns = tomllib.loads((root / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]["studies"]
    read = {
        path for suffix in ("toml", "html", "csv", "c", "h", "msh") for path in (root / "studies").rglob(f"*.{suffix}")
    }
    read |= set((root / "studies" / "evidence").rglob("*.json"))
    read |= set((root / "studies" / "scenes" / "meshes").glob("*.py"))  # the scripts that draw the meshes
    assert len(read) > 5
    read |= {root / "studies" / name for name in ("py.typed", "glossary.md", "scenes/README.md", "scenes/schema.json")}
    assert read == {path for pattern in patterns for path in (root / "studies").glob(pattern)}


def chromium_says(file, tmp_path):
    """What headless Chromium writes on the console of a page, without a network, and the page's last state."""
    flags = "--headless --no-sandbox --disable-gpu --disable-quic --no-first-run --disable-background-networking"
    flags += " --disable-component-update --disable-sync --enable-unsafe-swiftshader --enable-logging=stderr --v=0"
    flags += f" --virtual-time-budget=3000 --user-data-dir={tmp_path / 'profile'} --dump-dom"
    done = subprocess.run(
        [CHROMIUM, *flags.split(), file.as_uri()], capture_output=True, text=True, timeout=120, check=True
    )
    return [line for line in done.stderr.splitlines() if "CONSOLE" in line], done.stdout


@pytest.mark.skipif(CHROMIUM is None, reason="chromium is not installed")
def test_the_page_opens_in_a_browser_without_an_error(page, tmp_path):
    (tmp_path / "page.html").write_text(page)
    console, dom = chromium_says(tmp_path / "page.html", tmp_path)
    said = [line for line in console if "GL Driver Message" not in line and "swiftshader" not in line]
    assert said == []
    assert 'data-ready="yes"' in dom
    (tmp_path / "bad.html").write_text("<script>undefined_function()</script>")
    console, _ = chromium_says(tmp_path / "bad.html", tmp_path)
    assert any("undefined_function" in line for line in console)  # an error would be seen


def test_a_time_series_is_the_field_at_its_instants(motor, tmp_path):
    field_data.save(motor, tmp_path / "wave.pvd", span=(0.013, 0.015), instants=3, note=quiet)
    sets = ElementTree.parse(tmp_path / "wave.pvd").getroot().findall("Collection/DataSet")
    assert [float(each.get("timestep")) * 2.2e6 for each in sets] == pytest.approx([0, 1 / 3, 2 / 3])
    field = motor.compute(span=(0.013, 0.015), energies=True)
    for number, each in enumerate(sets):
        mesh = meshio.read(tmp_path / each.get("file"))
        turn = np.exp(2j * np.pi * number / 3)
        expected = (field.displacement * turn).real.reshape(-1, 3)
        moved = mesh.point_data["displacement_m_per_V"]
        np.testing.assert_allclose(moved, expected, atol=1e-6 * abs(expected).max())
        power = field.densities.power_flow + (field.densities.power_flow_pulse * turn**2).real
        stated = mesh.point_data["power_flow_W_per_m2_per_V2"][:, [0, 2]]
        np.testing.assert_allclose(stated, power.reshape(-1, 2), atol=1e-6 * abs(power).max())


def test_a_table_of_the_field_is_one_row_a_node(motor, tmp_path):
    field_data.save(motor, tmp_path / "field.csv", span=(0.0135, 0.014), instants=0, note=quiet)
    table = np.genfromtxt(tmp_path / "field.csv", delimiter=",", names=True)
    field = motor.compute(span=(0.0135, 0.014), energies=True)
    assert len(table) == field.potential.size
    np.testing.assert_array_equal(table["u_z_m_per_V_im"], field.displacement[..., 2].imag.ravel())
    np.testing.assert_array_equal(table["strain_energy_J_per_m3_per_V2"], field.densities.strain_energy.ravel())
    np.testing.assert_array_equal(table["z_m"][: len(field.z)], field.z)


@pytest.mark.parametrize(("name", "instants"), [("a.csv", 0), ("a.vtu", 0), ("a.pvd", 3)])
def test_the_size_of_a_large_file_is_said_before_it_is_written(motor, tmp_path, monkeypatch, name, instants):
    """Within a third of what the file then has; a small one is not worth a word."""
    said, before = [], []

    def note(text):
        before.append(list(tmp_path.iterdir()))
        said.append(text)

    monkeypatch.setattr(field_data, "ANNOUNCED_SIZE", 1e4)
    options = {"span": (0.0135, 0.0155), "instants": instants, "note": note}
    field_data.save(motor, tmp_path / name, **options)
    (sentence,) = said
    assert before == [[]]
    size = sum(path.stat().st_size for path in tmp_path.rglob("*") if path.suffix != ".pvd" and path.is_file())
    field = motor.compute(span=(0.0135, 0.0155), energies=False)
    assert sentence.startswith(
        f"writing about {field_data.expected_size(field, tmp_path / name, instants) / 1e6:.0f} MB"
    )
    assert field_data.expected_size(field, tmp_path / name, instants) == pytest.approx(size, rel=0.33)
    assert ("--surface writes the surface alone" in sentence) == name.endswith(".csv")
    monkeypatch.setattr(field_data, "ANNOUNCED_SIZE", 20e6)
    field_data.save(motor, tmp_path / name, **options)
    assert len(said) == 1


def test_a_table_of_the_surface_alone(motor, computed, tmp_path):
    view.view(computed, Wanted(data=str(tmp_path / "a.csv"), surface=True))
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True)
    np.testing.assert_array_equal(table["x_m"], motor.field.x)
    np.testing.assert_array_equal(table["u_z_m_per_V_im"], motor.field.displacement[:, -1, 2].imag)
    np.testing.assert_array_equal(table["potential_V_per_V_re"], motor.field.potential[:, -1].real)


def test_a_scene_without_a_stator_shows_its_contact_and_says_why(prescribed_run, tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["sawmotor", "view", str(prescribed_run), "--screenshot", str(tmp_path / "a.png")])
    assert main() == 0
    captured = capsys.readouterr()
    assert "no wave field: the scene of this run gives the surface motion itself" in captured.err
    assert captured.out.strip() == str(tmp_path / "a.png")
    assert np.asarray(Image.open(tmp_path / "a.png")).std() > 20
    with pytest.raises(SceneError, match="there is no wave field"):
        view.view(prescribed_run, Wanted(screenshot=str(tmp_path / "a.png"), show="field"))


def test_a_contact_as_page_and_table(prescribed_run, tmp_path, monkeypatch):
    from studies.view import contact_view

    monkeypatch.setattr(contact_view, "FRAMES", 2)
    wanted = Wanted(html=str(tmp_path / "a.html"), data=str(tmp_path / "a.csv"), level=3e-9)
    view.view(prescribed_run, wanted, note=quiet)
    page = (tmp_path / "a.html").read_text()
    assert page.count('src="data:image/') == 2
    assert "3 nm" in page
    head, *rows = (tmp_path / "a.csv").read_text().splitlines()
    assert head.startswith("time_s,u_x_m,u_z_m,approach_m,")
    assert len(rows) == 480


def test_a_run_with_a_stator_shows_its_contact_too(folder, tmp_path):
    """On the orbit of the run's own surface motion."""
    view.view(folder, Wanted(data=str(tmp_path / "a.csv"), show="contact", level=30.0))
    table = np.genfromtxt(tmp_path / "a.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")
    stated = json.loads((folder / "run.json").read_text())["wave"]["normal_m_per_V"]
    assert table["u_z_m"].max() == pytest.approx(30.0 * np.hypot(*stated), rel=1e-3)  # 240 instants a cycle


def test_a_stuck_slider_is_drawn_at_rest(prescribed_run):
    """Below the threshold the run says 0; so does the picture, and its slider only trembles about rest."""
    from studies.view.contact_view import steady_history
    from studies.view.run_field import saved_run

    record = saved_run(prescribed_run)
    drawn, title = steady_history(record, level=0.3e-9)
    assert title.endswith(": 0.3 nm, slider held at rest")
    assert abs(drawn["slider_velocity_m_per_s"].mean()) < 1e-6 * abs(drawn["slider_velocity_m_per_s"]).max()
    _, moving = steady_history(record, level=10e-9)
    speed = next(point["velocity_m_per_s"] for point in record.points if point["normal_amplitude_m"] == 10e-9)
    assert moving.endswith(f": 10 nm, slider at {speed * 1e3:.4g} mm/s")


def test_the_contact_of_a_slider_in_the_plane_is_drawn_and_written(tmp_path):
    """Its means are the preload and the load; what has no picture in the plane is refused by name."""
    ball = {"freedom": "xy", "load": ["0.2 uN", 0]}
    waves = [{}, {"direction": "90 deg", "phase": "90 deg"}]
    scene = changed("twente-contact", "wave.normal_amplitude=10e-9").replace(
        wave={"wavelength": "1 mm", "sources": waves}, slider=ball
    )
    record = run(scene, tolerance=1e-3)
    write_run(record, tmp_path, field=False)
    picture, data = tmp_path / "a.png", tmp_path / "a.csv"
    view.view(tmp_path, Wanted(screenshot=str(picture), data=str(data)), note=quiet)
    assert np.asarray(Image.open(picture)).std() > 20
    table = np.genfromtxt(data, delimiter=",", names=True, dtype=None, encoding="utf-8")
    slider = scene.slider
    assert len(table) == 240
    assert table["normal_force_N"].mean() == pytest.approx(slider.preload_force / slider.share, rel=1e-3)
    friction = slider.static_coefficient * slider.preload_force / slider.share
    (point,) = record.points
    velocity = point.velocity_m_per_s, point.lateral_velocity_m_per_s
    damping = slider.damping.tangential / slider.share
    loads = (0.2e-6 / slider.share + damping * velocity[0], damping * velocity[1])
    for name, load in zip(("tangential_force_N", "lateral_force_N"), loads, strict=True):
        assert table[name].mean() == pytest.approx(load, abs=1e-3 * friction)
    size = np.hypot(table["deformation_m"], table["lateral_deformation_m"])
    slips = table["regime"] == "slip"
    assert size[slips] == pytest.approx(table["limit_m"][slips], rel=1e-9)
    # the surface's velocity has no mean
    for name, speed in zip(("", "lateral_"), velocity, strict=True):
        assert table[f"{name}sliding_velocity_m_per_s"].mean() == pytest.approx(-speed, rel=1e-3)
    for option, file in (("movie", "a.gif"), ("html", "a.html")):
        with pytest.raises(SceneError, match=f"--{option} shows a contact that moves along x: of one in the plane"):
            view.view(tmp_path, Wanted(**{option: str(tmp_path / file)}), note=quiet)
    with pytest.raises(SceneError, match="--show contact opens a window for a slider that moves along x"):
        plane_contact_writers(record, Wanted())


@pytest.mark.parametrize(
    ("content", "said"),
    [
        *((content, "no directory that sawmotor run left") for content in (None, "{}", "[]")),
        ("no json", "is damaged or cut off: line 1, column 1"),
        ('{"scene": {},\n"points": [1.2, ', "is damaged or cut off: line 2, column 17"),
    ],
)  # fmt: skip
def test_what_is_no_run_is_refused(tmp_path, content, said):
    if content is not None:
        (tmp_path / "run.json").write_text(content)
    with pytest.raises(SceneError, match=said):
        run_field(tmp_path)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--screenshot", "a.gif"], "--screenshot must end in one of .png"),
        (["--movie", "a.avi"], "--movie must end in .gif or .mp4, got 'a.avi'"),
        (["--html", "a.txt"], "--html must end in .html or .htm, got 'a.txt'"),
        (["--data", "a.txt"], "--data must end in one of .vtu, .pvd, .csv, got 'a.txt'"),
        (["--screenshot", "a.png", "--quantity", "u_q"], "--quantity 'u_q' does not exist; did you mean u_z?"),
        (["--screenshot", "a.png", "--show", "all"], "--show must be one of field, solid, beam, contact, got 'all'"),
        (["--screenshot", "a.png", "--span", "20:30"], "--span must lie on the stator, 0:24 mm, got 20:30 mm"),
        (["--screenshot", "a.png", "--span", "5:1"], "--span must have START below STOP, got 5:1 mm"),
        (["--screenshot", "a.png", "--span", "here"], "--span must be whole, slider, wavelength or START:STOP in mm"),
        (["--screenshot", "a.png", "--size", "big"], "--size must be WIDTHxHEIGHT in pixels"),
        (["--screenshot", "a.png", "--phase", "nan"], "--phase must be a finite number (degrees), got 'nan'"),
        (["--screenshot", "a.png", "--scale", "-1"], "--scale must be a finite number of at least 0 (times), got '-1'"),
        (["--screenshot", "a.png", "--span", "14:14.001"], "--span must be at least 0.0496 mm long"),
        (["--screenshot", "a.png", "--scale", "1e300"], "--scale must be at most "),
        (["--movie", "a.gif", "--frames", "1"], "--frames must be a whole number from 2 to 2000, got '1'"),
        (["--movie", "a.gif", "--show", "solid"], "--movie does not go with --show solid, got 'a.gif'"),
        (["--data", "a.csv", "--show", "beam"], "--data does not go with --show beam, got 'a.csv'"),
        (["--screenshot", "a.png", "--show", "contact", "--voltage", "0"], "--voltage must be above 0: at 0 nothing"),
        (["--data", "a.vtu", "--surface"], "--data must end in .csv, got 'a.vtu'"),
        (["--surface"], "--surface makes --data FILE.csv of a field a table of its surface"),
        (["--data", "a.csv", "--surface", "--show", "contact"], "--surface makes --data FILE.csv of a field a table"),
        (["--data", "a.vtu", "--show", "contact"], "--data must end in .csv, got 'a.vtu'"),
    ],
)  # fmt: skip
def test_bad_options_are_refused_in_one_sentence(computed, tmp_path, monkeypatch, capsys, words, said):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["sawmotor", "view", str(computed), *words])
    assert main() == 2
    captured = capsys.readouterr()
    (sentence,) = (line for line in captured.err.splitlines() if not line.endswith(" s)"))  # but for progress
    assert sentence.startswith(f"sawmotor: {said}")
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_is_said(computed, tmp_path, motor):
    with pytest.raises(SceneError, match="cannot write"):
        view.view(computed, Wanted(screenshot=str(tmp_path / "no" / "a.png"), size=(300, 200)))
    for option, file in (("movie", "a.gif"), ("data", "a.csv")):
        wanted = Wanted(**{option: str(tmp_path / "no" / file)}, frames=2, size=(300, 200), span=(13.5e-3, 14e-3))
        with pytest.raises(SceneError, match=f"--{option} cannot write .*no/{file}': No such file"):
            view.view(computed, wanted)


def test_interfaces_and_buried_fingers_lie_where_the_layers_end():
    table = read_table("coated-128yx")
    table["stator"]["layer"] = [
        {"material": "fused silica", "thickness": "20 um"}, {"material": "PZT-8", "thickness": "3 um"},
    ]  # fmt: skip
    table["transducer"][0]["plane"] = 2
    run = SimpleNamespace(scene=resolved(Scene.from_table("", table)))
    assert overlays.interfaces(run) == pytest.approx((-3e-6, -23e-6))
    assert overlays.finger_height(run) == pytest.approx(-23e-6)
    bare = SimpleNamespace(scene=resolved(Scene.load("lithium-niobate-128yx")))
    assert overlays.interfaces(bare) == ()
    assert overlays.finger_height(bare) == 0.0


def test_the_motion_at_a_height_lies_between_the_nodes():
    motion = np.stack([np.outer([1.0, 2.0], [1.0, 3.0]), np.outer([0.0, 1.0], [2.0, 4.0])], axis=-1)
    x, z, none = np.array([0.0, 1.0]), np.array([-2.0, 0.0]), np.zeros((2, 2))
    part = SectionPart(x=x, z=z, displacement=motion, mean=none, amplitude=none, inside=none == 0)
    at = np.array([[0.5, 0.0]])
    assert part.at_height(at, -0.5)[0] == pytest.approx([1.5 * 2.5, 0.0, 0.5 * 3.5])
    assert part.surface(at)[0] == pytest.approx([1.5 * 3.0, 0.0, 0.5 * 4.0])


def test_motions_between_lines_are_those_of_scipy():
    """Bilinear interpolation of three complex components on uneven lines, ends included."""
    from scipy.interpolate import RegularGridInterpolator

    draw = np.random.default_rng(3)
    x, y = np.sort(draw.uniform(size=7)), np.sort(draw.uniform(size=5))
    values = draw.normal(size=(7, 5, 3)) + 1j * draw.normal(size=(7, 5, 3))
    points = np.stack([draw.uniform(x[0], x[-1], 40), draw.uniform(y[0], y[-1], 40)], axis=-1)
    points[:2] = (x[0], y[-1]), (x[-1], y[0])
    found = field_points.between_lines(x, y, values, points)
    np.testing.assert_allclose(found, RegularGridInterpolator((x, y), values)(points), rtol=1e-12, atol=1e-14)
