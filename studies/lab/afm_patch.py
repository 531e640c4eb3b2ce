r"""Patches of a surface's heights, as an atomic force microscope measures them, and the asperities on them.

Files, by their suffix: Gwyddion's native ``.gwy`` (package gwyfile; the first channel of heights), NumPy's ``.npy``,
text (``.txt``, ``.csv``, ``.asc``, ``.dat``: one row of the image per line, heights in m), and otherwise whatever the
package SurfaceTopography reads. Rows are lines along x, at rising y. A file that does not state the size of its pixels
needs ``step``.

A mask of Gwyddion is a selection of the person who looked at the image, and no gap: masked pixels count. Pixels without
a value (NaN) are counted, and no asperity is sought beside one.

The patch is **levelled** before it is taken as periodic: a plane and a paraboloid x^2 + y^2, the form of the sphere,
are removed by least squares; what is left has the rms that is stated. **Asperities** are pixels higher than their eight
neighbours. A quadratic through these nine gives place, height and the two curvatures; the radius is
1/sqrt(kappa_1 kappa_2), that of the sphere with the same Gaussian curvature.
"""

import struct
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import contact
from studies.refusal import SceneError, refuse_if

LENGTHS = {"m": 1.0, "mm": 1e-3, "um": 1e-6, "µm": 1e-6, "μm": 1e-6, "nm": 1e-9, "pm": 1e-12, "Å": 1e-10, "A": 1e-10}
TEXTS = (".txt", ".csv", ".asc", ".dat")
SMALLEST = 5  # pixels of a side: fewer hold no asperity beside a form of four coefficients
MISSING = 0.1  # largest share of pixels without a value
# what gwyfile raises for a file that is another one or is cut off
UNREADABLE = (ValueError, EOFError, AssertionError, struct.error, NotImplementedError, KeyError, TypeError)
NEIGHBOURS = [(i, j) for i in (-1, 0, 1) for j in (-1, 0, 1)]


@dataclass(frozen=True, kw_only=True)
class AfmPatch:
    """Heights of a surface on a rectangular grid.

    Attributes
    ----------
    name : str
        Of the file.
    heights : ndarray, shape (rows, columns)
        Levelled, m, out of the surface; NaN where the file has no value. Columns are along x.
    step : tuple of float
        Size of a pixel along x and y, m.
    remarks : tuple of str
        What a user must know about the file: pixels without a value, a mask that was not taken as a gap.
    """

    name: str
    heights: np.ndarray = field(repr=False)
    step: tuple[float, float]
    remarks: tuple[str, ...] = ()

    @property
    def rms(self) -> float:
        """Standard deviation of the levelled heights, m."""
        return float(np.nanstd(self.heights))

    @property
    def size(self) -> tuple[float, float]:
        """Period along x and y, m."""
        rows, columns = self.heights.shape
        return columns * self.step[0], rows * self.step[1]

    @property
    def missing(self) -> int:
        """Pixels without a value."""
        return int(np.count_nonzero(~np.isfinite(self.heights)))

    def peaks(self) -> np.ndarray:
        """Return x, y, heights and radii of the asperities of one period in m, shape (4, n); x and y from a corner."""
        h, (dx, dy) = self.heights, self.step
        with np.errstate(invalid="ignore"):
            # NaN compares as False: neither such a pixel nor its neighbours are peaks
            higher = [h > np.roll(h, (-i, -j), (0, 1)) for i, j in NEIGHBOURS if (i, j) > (0, 0)]
            higher += [h >= np.roll(h, (-i, -j), (0, 1)) for i, j in NEIGHBOURS if (i, j) < (0, 0)]
        row, column = np.nonzero(np.all(higher, axis=0))
        values = np.array([h[(row + i) % h.shape[0], (column + j) % h.shape[1]] for i, j in NEIGHBOURS])
        design = np.array([(1.0, j, i, 0.5 * j * j, i * j, 0.5 * i * i) for i, j in NEIGHBOURS])
        base, slope_x, slope_y, xx, xy, yy = np.linalg.lstsq(design, values, rcond=None)[0]
        determinant = xx * yy - xy**2
        summit = (determinant > 0.0) & (xx < 0.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            offset = -(yy * slope_x - xy * slope_y) / determinant, -(xx * slope_y - xy * slope_x) / determinant
        # the summit of a flat top may lie far off: it is held within its pixel
        across = [np.where(summit, np.clip(each, -0.5, 0.5), 0.0) for each in offset]
        height = base + 0.5 * (slope_x * across[0] + slope_y * across[1])
        keep = summit & np.isfinite(height)
        radius = dx * dy / np.sqrt(determinant[keep])
        return np.array([(column + across[0])[keep] * dx, (row + across[1])[keep] * dy, height[keep], radius])

    def asperities(self, reach: float, *, shift: tuple[float, float] = (0.0, 0.0)) -> contact.Asperities:
        """Return the asperities within a distance in m of a sphere's lowest point, of the patch continued periodically.

        The lowest point is above the middle of the patch, plus ``shift`` in m.
        """
        x, y, heights, radius = self.peaks()
        if not x.size:
            raise SceneError(
                "slider.roughness.file", f"must show an asperity, a pixel above its neighbours: {self.name}"
            )
        places = []
        for values, period, offset in zip((x, y), self.size, shift, strict=True):
            count = int(np.ceil(reach / period)) + 1
            places.append(np.mod(values - 0.5 * period - offset, period)[:, None] + period * np.arange(-count, count))
        all_x = np.repeat(places[0], places[1].shape[1], axis=1)
        all_y = np.tile(places[1], (1, places[0].shape[1]))
        near = np.hypot(all_x, all_y) < reach
        who = np.nonzero(near)[0]
        return contact.Asperities(x=all_x[near], y=all_y[near], heights=heights[who], radius=radius[who])


def levelled(heights: np.ndarray, step: tuple[float, float]) -> np.ndarray:
    """Return heights in m less the plane and the paraboloid x^2 + y^2 that fit them best."""
    rows, columns = heights.shape
    y, x = np.meshgrid(np.arange(rows) * step[1], np.arange(columns) * step[0], indexing="ij")
    x, y = (each - each.mean() for each in (x, y))
    square = (x**2 + y**2) / (x**2 + y**2).max()
    design = np.stack([np.ones_like(x), x / x.max(), y / y.max(), square], axis=-1)
    known = np.isfinite(heights)
    form = design @ np.linalg.lstsq(design[known], heights[known], rcond=None)[0]
    return heights - form


def read_patch(path: str | Path, step: float | None = None, *, key: str = "slider.roughness.file") -> AfmPatch:
    """Return the levelled patch of a file.

    Parameters
    ----------
    path : str or Path
    step : float, optional
        Size of a pixel in m, of files that do not state it.
    key : str
        Named in refusals.

    Raises
    ------
    SceneError
        If the file cannot be read or holds no heights.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    reader = READERS.get(suffix, _of_surface_topography)
    try:
        heights, own_step, remarks = reader(path, key)
    except OSError as error:
        raise SceneError(key, f"cannot be read: {error.strerror or error}") from None
    heights = np.asarray(heights, dtype=float)
    refuse_if(
        heights.ndim != 2 or min(heights.shape) < SMALLEST,
        key,
        f"must hold at least {SMALLEST} x {SMALLEST} heights, got the shape {heights.shape}",
    )
    pixel = _pixel(path.name, own_step, step, key)
    missing = int(np.count_nonzero(~np.isfinite(heights)))
    refuse_if(
        missing > MISSING * heights.size,
        key,
        f"{missing} of {heights.size} pixels of {path.name} have no value, more than 10 %",
    )
    if missing:
        remarks = (*remarks, f"{missing} of {heights.size} pixels have no value; no asperity is sought beside them")
    heights = levelled(np.where(np.isfinite(heights), heights, np.nan), pixel)
    patch = AfmPatch(name=path.name, heights=heights, step=pixel, remarks=remarks)
    refuse_if(not patch.rms > 0.0, key, f"{path.name} is flat: its levelled heights do not differ")
    return patch


def _pixel(name: str, own: tuple[float, float] | None, step: float | None, key: str) -> tuple[float, float]:
    """Return the size of a pixel along x and y from a file or from a scene, never both, m."""
    if own is not None and step is not None:
        size = " x ".join(f"{each:.4g}" for each in own)
        raise SceneError(key, f"{name} states the size of its pixels, {size} m: leave slider.roughness.step out")
    if own is not None:
        return own
    if step is None:
        raise SceneError(key, f"{name} does not state the size of its pixels: give slider.roughness.step")
    return step, step


Reading = tuple[Any, tuple[float, float] | None, tuple[str, ...]]


def _of_gwyddion(path: Path, key: str) -> Reading:
    """Return heights, step and remarks of the first channel of a .gwy file whose z is a length."""
    try:
        import gwyfile
        from gwyfile.objects import GwyDataField
    except ImportError:
        raise SceneError(key, "needs the package gwyfile: pip install gwyfile") from None
    try:
        content = gwyfile.load(str(path))
    except UNREADABLE:
        raise SceneError(key, f"{path.name} is not a file of Gwyddion, or it is cut off") from None
    fields = {name: each for name, each in content.items() if isinstance(each, GwyDataField) and name.endswith("/data")}
    refuse_if(not fields, key, f"{path.name} holds no channel")
    units = []
    for name, each in sorted(fields.items()):
        across, up = (LENGTHS.get(_unit(getattr(each, axis))) for axis in ("si_unit_xy", "si_unit_z"))
        units.append(f"{name} in {_unit(each.si_unit_z) or 'no unit'}")
        if across is None or up is None:
            continue
        rows, columns = each.data.shape  # yres and xres
        step = float(each.xreal) * across / columns, float(each.yreal) * across / rows
        heights = np.asarray(each.data, dtype=float)[::-1] * up  # images begin at the top
        mask = content.get(name.removesuffix("data") + "mask")
        remarks: tuple[str, ...] = ()
        if mask is not None:
            number = int(np.count_nonzero(np.asarray(mask.data)))
            remarks = (f"a mask of {number} pixels is a selection and not a gap: these pixels count",)
        return heights, step, remarks
    raise _no_length(key, ", ".join(units))


def _no_length(key: str, units: str) -> SceneError:
    return SceneError(key, f"must hold heights with a unit of length, got {units}")


def _unit(unit) -> str:
    return "" if unit is None else str(unit.unitstr)


def _of_numpy(path: Path, key: str) -> Reading:
    try:
        heights = np.load(path, allow_pickle=False)
        if heights.dtype.kind not in "iuf":
            raise ValueError(f"heights are real numbers, got {heights.dtype}")
        return heights, None, ()
    except ValueError as error:
        raise SceneError(key, f"{path.name} is not an array of NumPy's that holds heights: {error}") from None


def _of_text(path: Path, key: str) -> Reading:
    text = path.read_text(encoding="utf-8")
    lines = [line.partition("#")[0] for line in text.splitlines()]
    words = [line.replace(",", " ").replace(";", " ").split() for line in lines if line.strip()]
    lengths = {len(each) for each in words}
    if len(lengths) > 1:
        raise SceneError(key, f"{path.name} must have rows of one length, got {min(lengths)} to {max(lengths)} values")
    try:
        return np.array([[float(word) for word in row] for row in words]), None, ()
    except ValueError as error:
        raise SceneError(key, f"{path.name} must hold numbers: {error}") from None


def _of_surface_topography(path: Path, key: str) -> Reading:
    """Return what the package SurfaceTopography reads; its masked pixels have no value."""
    refuse_if(not path.exists(), key, f"cannot be read: no file {path.name}")
    try:
        import SurfaceTopography
        from SurfaceTopography.Exceptions import CannotDetectFileFormat
    except ImportError:
        known = ", ".join(READERS)
        rule = f"must end in {known}, or needs the package SurfaceTopography: pip install SurfaceTopography"
        raise SceneError(key, f"{rule}, got {path.suffix or path.name}") from None
    try:
        topography = SurfaceTopography.read_topography(str(path))
    except CannotDetectFileFormat:
        raise SceneError(key, f"{path.name} has no format that the package SurfaceTopography knows") from None
    scale = LENGTHS.get(topography.unit or "")
    if scale is None:
        raise _no_length(key, topography.unit or "no unit")
    heights = np.ma.filled(np.ma.asarray(topography.heights(), dtype=float), np.nan).T * scale
    rows, columns = heights.shape
    step = topography.physical_sizes[0] * scale / columns, topography.physical_sizes[1] * scale / rows
    return heights, step, ()


READERS: dict[str, Callable[[Path, str], Reading]] = {
    ".gwy": _of_gwyddion, ".npy": _of_numpy, **dict.fromkeys(TEXTS, _of_text),
}  # fmt: skip
