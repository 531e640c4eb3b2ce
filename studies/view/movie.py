"""Moving pictures, GIF by Pillow, which every installation has, MP4 by ffmpeg."""

import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from studies.refusal import RunError

COLOURS = 128  # of a GIF that comes without a palette: one is made of its pictures


def save(
    image: Callable[[int], np.ndarray],
    count: int,
    file: str | Path,
    *,
    rate: float,
    progress=lambda text: None,
    palette=None,
) -> None:
    """Write a count of pictures as a movie that repeats (GIF) or plays (MP4), ``rate`` per second.

    ``image`` returns a picture by its number, bytes of shape (height, width, 3).  The colours of a GIF are those of
    the ``palette`` (an image); without one they are chosen from its pictures, where rare colours are lost.
    """
    pictures = []
    for number in range(count):
        progress(f"picture {number + 1} of {count}")
        pictures.append(image(number))
    if Path(file).suffix.lower() == ".gif":
        _gif(pictures, file, rate, palette)
    else:
        _mp4(pictures, file, rate)


def _gif(pictures, file, rate: float, palette) -> None:
    # one palette for all pictures: a third of the size
    if palette is None:
        palette = Image.fromarray(np.concatenate(pictures[:: max(1, len(pictures) // 4)])).quantize(COLOURS)
    first, *others = (
        Image.fromarray(each).quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures
    )
    first.save(file, save_all=True, append_images=others, duration=round(1000 / rate), loop=0, optimize=False)


def _mp4(pictures, file, rate: float) -> None:
    height, width, _ = pictures[0].shape
    options = f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate:g} -i -"
    # the format has sizes that are even
    written = "-vf pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white -c:v libx264 -pix_fmt yuv420p"
    call = [ffmpeg(), *options.split(), *written.split(), str(Path(file).absolute())]
    done = subprocess.run(call, input=b"".join(each.tobytes() for each in pictures), capture_output=True)
    if done.returncode:
        raise RunError(
            f"the movie {str(file)!r} cannot be written: {done.stderr.decode(errors='replace').strip()}"
        )


def ffmpeg() -> str:
    """Return the program: the system's, or the one that the package imageio-ffmpeg carries."""
    program = shutil.which("ffmpeg")
    if program is not None:
        return program
    try:
        import imageio_ffmpeg
    except ImportError:
        raise RunError(
            "an MP4 needs ffmpeg, which is not installed: pip install imageio-ffmpeg, or name a .gif, "
            "which needs nothing"
        ) from None
    return imageio_ffmpeg.get_ffmpeg_exe()
