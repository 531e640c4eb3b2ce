"""Write movies: GIF with Pillow, which is always installed, and MP4 with ffmpeg."""

import logging
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import numpy as np
from PIL import Image

from studies.refusal import RunError

LOGGER = logging.getLogger(__name__)

COLOURS = 128  # palette size of a GIF without a given palette


def save(image: Callable[[int], np.ndarray], count: int, file: str | Path, *, rate: float, palette=None) -> None:
    """Write ``count`` pictures as a repeating GIF or as an MP4 with ``rate`` pictures per second.

    ``image`` returns the picture of a number as bytes of shape (height, width, 3). A GIF uses the colours of
    ``palette`` (an image). Without a palette, its colours are derived from the pictures, and rare colours are lost.
    """
    pictures = []
    for number in range(count):
        LOGGER.info(f"picture {number + 1} of {count}")
        pictures.append(image(number))
    if Path(file).suffix.lower() == ".gif":
        _gif(pictures, file, rate, palette)
    else:
        _mp4(pictures, file, rate)


def _gif(pictures, file, rate: float, palette) -> None:
    # one palette for all pictures reduces the size of the file to a third
    if palette is None:
        palette = Image.fromarray(np.concatenate(pictures[:: max(1, len(pictures) // 4)])).quantize(COLOURS)
    first, *others = (Image.fromarray(each).quantize(palette=palette, dither=Image.Dither.NONE) for each in pictures)
    first.save(file, save_all=True, append_images=others, duration=round(1000 / rate), loop=0, optimize=False)


def _mp4(pictures, file, rate: float) -> None:
    height, width, _ = pictures[0].shape
    input_options = f"-y -loglevel error -f rawvideo -pix_fmt rgb24 -s {width}x{height} -r {rate:g} -i -"
    # H.264 requires even widths and heights
    output_options = "-vf pad=ceil(iw/2)*2:ceil(ih/2)*2:color=white -c:v libx264 -pix_fmt yuv420p"
    call = [ffmpeg(), *input_options.split(), *output_options.split(), str(Path(file).absolute())]
    result = subprocess.run(call, input=b"".join(each.tobytes() for each in pictures), capture_output=True)
    if result.returncode:
        raise RunError(f"the movie {str(file)!r} cannot be written: {result.stderr.decode(errors='replace').strip()}")


def ffmpeg() -> str:
    """Return the path of ffmpeg: the installed program, or that of the package imageio-ffmpeg."""
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
