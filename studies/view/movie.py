"""Pictures in a row as a moving picture: GIF by Pillow, which every installation has, MP4 by ffmpeg."""

import shutil
import subprocess
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from studies.refusal import RunError, SceneError

__all__ = ["FORMATS", "check", "reduced", "save"]

FORMATS = (".gif", ".mp4")
COLOURS = 128  # of a GIF; one palette for all its pictures


def check(file: str | Path) -> None:
    """Refuse a file that no moving picture can be written to, before it is made.

    Raises
    ------
    SceneError
        If its format is unknown.
    RunError
        If what writes the format is missing.
    """
    if Path(file).suffix.lower() not in FORMATS:
        raise SceneError("--movie", f"must end in {' or '.join(FORMATS)}, got {str(file)!r}")
    if Path(file).suffix.lower() == ".mp4":
        _ffmpeg()


def save(
    frames: Iterable[np.ndarray], file: str | Path, *, rate: float, palette: np.ndarray | None = None
) -> int:
    """Write pictures as a movie that repeats (GIF) or plays (MP4).

    Parameters
    ----------
    frames : iterable of ndarray, shape (height, width, 3), uint8
        All of one size.
    file : str or Path
        Ends in .gif or .mp4.
    rate : float
        Pictures per second.
    palette : ndarray, shape (n, 3), uint8, optional
        At most 256 colours of a GIF; found in the pictures if None, which passes over rare ones.

    Returns
    -------
    int
        How many there were.

    Raises
    ------
    SceneError, RunError
        As `check`; or if the file cannot be written.
    """
    check(file)
    try:
        if Path(file).suffix.lower() == ".gif":
            return _gif(frames, Path(file), rate, palette)
        return _mp4(frames, Path(file), rate)
    except OSError as error:
        raise RunError(f"the movie {str(file)!r} cannot be written: {error.strerror or error}") from None


def reduced(picture: np.ndarray, palette: np.ndarray):
    """Return a picture (height, width, 3) of uint8 in the nearest colours of a palette, as a PIL image."""
    from PIL import Image
    from scipy.spatial import cKDTree

    packed = picture.astype(np.uint32) @ np.array([1 << 16, 1 << 8, 1], dtype=np.uint32)
    found, places = np.unique(packed, return_inverse=True)
    seen = np.stack([found >> 16, found >> 8 & 255, found & 255], axis=1)
    _, nearest = cKDTree(palette).query(seen)
    image = Image.fromarray(nearest.astype(np.uint8)[places].reshape(picture.shape[:2]))
    image.putpalette(np.asarray(palette, dtype=np.uint8).tobytes())
    return image


def _gif(frames, file: Path, rate: float, palette) -> int:
    from PIL import Image

    shown = list(frames)
    if palette is None:
        # of pictures spread over the movie, one below the other
        some = Image.fromarray(np.concatenate(shown[:: max(1, len(shown) // 4)])).quantize(COLOURS)
        palette = np.reshape(some.getpalette(), (-1, 3))
    pictures = [reduced(each, palette) for each in shown]
    pictures[0].save(
        file, save_all=True, append_images=pictures[1:], duration=round(1000 / rate), loop=0, optimize=False
    )
    return len(pictures)


def _mp4(frames, file: Path, rate: float) -> int:
    process, count = None, 0
    for frame in frames:
        even = frame[: frame.shape[0] // 2 * 2, : frame.shape[1] // 2 * 2]
        if process is None:
            process = _encoder(even.shape, file, rate)
        try:
            process.stdin.write(np.ascontiguousarray(even).tobytes())
        except BrokenPipeError:
            break
        count += 1
    _, said = process.communicate()
    if process.returncode:
        last = said.decode(errors="replace").strip().splitlines()[-1:]
        raise RunError(f"the movie {str(file)!r} cannot be written: ffmpeg: {' '.join(last)}")
    return count


def _encoder(shape, file: Path, rate: float):
    command = [_ffmpeg(), "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24"]
    command += ["-s", f"{shape[1]}x{shape[0]}", "-r", f"{rate:g}", "-i", "-"]
    command += ["-pix_fmt", "yuv420p", "-vcodec", "libx264", "-crf", "23", str(file)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def _ffmpeg() -> str:
    """Return the program: the system's, or the one that the package imageio-ffmpeg carries."""
    found = shutil.which("ffmpeg")
    if found is not None:
        return found
    try:
        import imageio_ffmpeg
    except ImportError:
        raise RunError(
            "an MP4 needs ffmpeg, which is not installed: pip install imageio-ffmpeg, or name a .gif, "
            "which needs nothing"
        ) from None
    return imageio_ffmpeg.get_ffmpeg_exe()
