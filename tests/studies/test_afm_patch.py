"""AFM patches: levelling, asperities of surfaces known in closed form, the files' conventions, and refusals."""

import numpy as np
import pytest

from studies import SceneError
from studies.lab.afm_patch import read_patch

gwyfile = pytest.importorskip("gwyfile")
objects = pytest.importorskip("gwyfile.objects")

STEP = 20e-9, 30e-9  # m, along x and y: oblong pixels
SHAPE = 80, 96  # rows, columns


def grid():
    y, x = np.meshgrid(np.arange(SHAPE[0]) * STEP[1], np.arange(SHAPE[1]) * STEP[0], indexing="ij")
    return x, y


def egg_box(amplitude=3e-9):
    """cos(k_x x) cos(k_y y), four periods along x and five along y: peaks of known radius and place."""
    x, y = grid()
    size_x, size_y = SHAPE[1] * STEP[0], SHAPE[0] * STEP[1]
    k_x, k_y = 2 * np.pi * 4 / size_x, 2 * np.pi * 5 / size_y
    return amplitude * np.cos(k_x * x) * np.cos(k_y * y), k_x, k_y


def written(path, heights, *, unit_z="m", unit_xy="m", mask=None, scale=1.0):
    content = objects.GwyContainer()
    # an image begins at the top
    field = objects.GwyDataField(
        heights[::-1] / scale, xreal=SHAPE[1] * STEP[0], yreal=SHAPE[0] * STEP[1],
        si_unit_xy=objects.GwySIUnit(unitstr=unit_xy), si_unit_z=objects.GwySIUnit(unitstr=unit_z),
    )  # fmt: skip
    content["/0/data"] = field
    if mask is not None:
        content["/0/mask"] = objects.GwyDataField(mask.astype(float), xreal=1e-6, yreal=1e-6)
    content.tofile(str(path))
    return path


def test_peaks_of_an_egg_box(tmp_path):
    heights, k_x, k_y = egg_box()
    patch = read_patch(written(tmp_path / "patch.gwy", heights))
    assert patch.step == pytest.approx(STEP)
    assert patch.size == pytest.approx((96 * 20e-9, 80 * 30e-9))
    assert patch.rms == pytest.approx(3e-9 / 2, rel=1e-3)
    x, y, height, radius = patch.peaks()
    # two peaks in each period: at (0, 0) and at half a period of both
    assert x.size == 2 * 4 * 5
    assert height == pytest.approx(3e-9, rel=0.02)
    # the quadratic of nine pixels sees the curvature A (2 - 2 cos(k step))/step^2, averaged over three lines
    curvatures = [
        3e-9 * (2 - 2 * np.cos(own * step)) / step**2 * (1 + 2 * np.cos(other * beside)) / 3
        for own, step, other, beside in ((k_x, STEP[0], k_y, STEP[1]), (k_y, STEP[1], k_x, STEP[0]))
    ]
    assert radius == pytest.approx(1 / np.sqrt(np.prod(curvatures)), rel=1e-3)
    phase = np.exp(1j * k_x * x).round(6), np.exp(1j * k_y * y).round(6)
    # a peak is where both cosines are 1, or both -1
    assert np.abs(phase[0] - phase[1]).max() < 0.05
    assert np.abs(phase[0].imag).max() < 0.05


def test_one_summit_between_pixels():
    """A paraboloid of radius 5 um whose summit is a third of a pixel off: place, height and radius to rounding."""
    from studies.lab.afm_patch import AfmPatch

    x, y = grid()
    at, radius = (40.3 * STEP[0], 29.8 * STEP[1]), 5e-6
    bump = 8e-9 - ((x - at[0]) ** 2 + (y - at[1]) ** 2) / (2 * radius)
    found = AfmPatch(name="", heights=np.maximum(bump, 0.0), step=STEP).peaks()
    assert found[:, 0] == pytest.approx([*at, 8e-9, radius], rel=1e-6)


def test_form_and_plane_are_removed_and_the_rest_stays(tmp_path):
    heights, *_ = egg_box()
    x, y = grid()
    tilted = heights + 5e-9 + 1e-3 * x - 2e-3 * y - (x**2 + y**2) / (2 * 1e-3)
    patch = read_patch(written(tmp_path / "patch.gwy", tilted))
    assert np.abs(patch.heights - heights).max() < 0.03 * 3e-9
    assert patch.rms == pytest.approx(1.5e-9, rel=5e-3)


def test_a_mask_is_a_selection_and_no_gap(tmp_path):
    heights, *_ = egg_box()
    mask = heights > 1e-9
    with_mask = read_patch(written(tmp_path / "a.gwy", heights, mask=mask))
    without = read_patch(written(tmp_path / "b.gwy", heights))
    assert with_mask.rms == pytest.approx(without.rms, rel=1e-12)
    assert with_mask.missing == 0
    assert with_mask.remarks == (f"a mask of {mask.sum()} pixels is a selection and not a gap: these pixels count",)


def test_missing_pixels_are_counted_and_hold_no_peak(tmp_path):
    heights, *_ = egg_box()
    heights[0, 0] = np.nan  # where a peak stood
    patch = read_patch(written(tmp_path / "patch.gwy", heights))
    assert patch.missing == 1
    assert patch.remarks == (f"1 of {heights.size} pixels have no value; no asperity is sought beside them",)
    assert patch.peaks().shape[1] == 39
    assert np.isfinite(patch.peaks()).all()


def test_units_of_a_channel(tmp_path):
    heights, *_ = egg_box()
    patch = read_patch(written(tmp_path / "nm.gwy", heights, unit_z="nm", scale=1e-9))
    assert patch.rms == pytest.approx(1.5e-9, rel=1e-3)
    with pytest.raises(SceneError, match="must hold heights with a unit of length, got /0/data in V"):
        read_patch(written(tmp_path / "volt.gwy", heights, unit_z="V"))


@pytest.mark.parametrize("suffix", [".npy", ".txt", ".csv"])
def test_arrays_and_texts_take_a_step(tmp_path, suffix):
    heights, *_ = egg_box()
    path = tmp_path / f"patch{suffix}"
    if suffix == ".npy":
        np.save(path, heights)
    else:
        np.savetxt(path, heights, delimiter="," if suffix == ".csv" else " ", header="heights in m")
    patch = read_patch(path, 20e-9)
    assert patch.heights.shape == SHAPE
    assert patch.step == (20e-9, 20e-9)
    with pytest.raises(SceneError, match=r"does not state the size of its pixels: give slider\.roughness\.step"):
        read_patch(path)


def test_the_patch_continues_periodically(tmp_path):
    heights, *_ = egg_box()
    patch = read_patch(written(tmp_path / "patch.gwy", heights))
    width, depth = patch.size
    reach = 2.3 * width
    sample = patch.asperities(reach)
    assert len(sample) == pytest.approx(40 * np.pi * reach**2 / (width * depth), rel=0.05)
    assert np.hypot(sample.x, sample.y).max() < reach
    assert sample.nearest.min() > 0.2e-6
    moved = patch.asperities(reach, shift=(width, -2 * depth))
    order, other = (np.lexsort((each.y.round(12), each.x.round(12))) for each in (sample, moved))
    assert moved.heights[other] == pytest.approx(sample.heights[order], rel=1e-9)
    shifted = patch.asperities(reach, shift=(0.1e-6, 0.0))
    near = np.argmin(np.hypot(shifted.x + 0.1e-6 - sample.x[0], shifted.y - sample.y[0]))
    assert shifted.x[near] + 0.1e-6 == pytest.approx(sample.x[0], abs=1e-12)


def array(heights):
    return lambda folder: np.save(folder / "a.npy", heights)


def text(name, content):
    return lambda folder: (folder / name).write_text(content)


@pytest.mark.parametrize(
    ("make", "step", "sentence"),
    [
        (array(np.zeros((3, 80))), 1e-8, r"must hold at least 5 x 5 heights, got the shape \(3, 80\)"),
        (array(np.zeros((8, 8))), 1e-8, "a.npy is flat: its levelled heights do not differ"),
        (array(np.full((8, 8), np.nan)), 1e-8, "64 of 64 pixels of a.npy have no value, more than 10 %"),
        (text("a.txt", "1 2\n3\n"), 1e-8, "must have rows of one length, got 1 to 2 values"),
        (text("a.txt", "1 b\n3 4\n"), 1e-8, "a.txt must hold numbers"),
        (text("a.npy", "text"), 1e-8, "a.npy is not an array of NumPy"),
        (array(np.full((8, 8), 1j)), 1e-8, "a.npy .* heights are real numbers, got complex128"),
        (text("a.gwy", "text"), None, "a.gwy is not a file of Gwyddion"),
        (text("a.gwy", "GWYPGwyContainer"), None, "a.gwy is not a file of Gwyddion"),
        (lambda p: written(p / "a.gwy", egg_box()[0]), 1e-8, "states the size of its pixels, 2e-08 x 3e-08 m: leave"),
        (lambda p: None, None, "cannot be read: No such file"),
    ],
)
def test_refusals(tmp_path, make, step, sentence):
    make(tmp_path)
    path = next(iter(tmp_path.iterdir()), tmp_path / "none.txt")
    with pytest.raises(SceneError, match=sentence):
        read_patch(path, step)


def test_what_surface_topography_reads(tmp_path):
    topography = pytest.importorskip("SurfaceTopography")
    heights, *_ = egg_box()
    sizes = SHAPE[1] * STEP[0] * 1e9, SHAPE[0] * STEP[1] * 1e9
    path = tmp_path / "patch.nc"
    topography.Topography(1e9 * heights.T, sizes, unit="nm").to_netcdf(str(path))
    patch = read_patch(path)
    assert patch.heights.shape == SHAPE
    assert patch.step == pytest.approx(STEP)
    assert patch.rms == pytest.approx(1.5e-9, rel=1e-3)
    (tmp_path / "patch.xxx").write_text("text")
    with pytest.raises(SceneError, match="has no format that the package SurfaceTopography knows"):
        read_patch(tmp_path / "patch.xxx")
