"""What ``sawmotor view`` is asked for: files, quantity, instant, stretch, sizes."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.refusal import SceneError, shown

OFFERED = {
    "field": ("screenshot", "movie", "html", "data"),
    "solid": ("screenshot", "html", "data"),
    "beam": ("screenshot", "html"),
    "contact": ("screenshot", "movie", "html", "data"),
}  # what is shown: the files that there are of it
FORMATS = {
    "screenshot": (".png", ".jpg", ".jpeg", ".tif", ".tiff"),
    "movie": (".gif", ".mp4"),
    "html": (".html", ".htm"),
    "data": (".vtu", ".pvd", ".csv"),
}
WORDS = ("whole", "slider", "wavelength")
SPAN, SIZE = "whole, slider, wavelength or START:STOP in mm", "WIDTHxHEIGHT in pixels, 200x100 to 8000x8000"


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """What to show of a run, as asked for on the command line; without files a window."""

    screenshot: str | None = None
    movie: str | None = None
    html: str | None = None
    data: str | None = None
    surface: bool = False  # the data are a table of the surface alone
    show: str | None = None  # of `OFFERED`; None: the field, or without a stator the contact
    quantity: str = "u_z"  # colours the field
    phase: float = 0.0  # omega t, rad
    span: str | tuple[float, float] | None = None  # "whole", "slider" or "wavelength", or two places, m
    factor: float | None = None  # by which the displacement is enlarged
    size: tuple[int, int] | None = None  # pixels
    frames: int | None = None  # of a movie, or instants of a .pvd
    level: float | None = None  # V, or m of given amplitude, of the contact; None: the largest

    @property
    def files(self) -> dict[str, str]:
        """What is to be written, by option."""
        return {name: file for name in FORMATS if (file := getattr(self, name)) is not None}

    def check(self, show: str) -> None:
        """Refuse a file whose name has another format, or that there is not of what is shown."""
        for option, file in self.files.items():
            if option not in OFFERED[show]:
                raise SceneError(f"--{option}", f"does not go with --show {show}, got {file!r}")
            allowed = (
                (".csv",) if option == "data" and (self.surface or show == "contact") else FORMATS[option]
            )
            if Path(file).suffix.lower() not in allowed:
                one = f"one of {', '.join(allowed)}" if len(allowed) > 2 else " or ".join(allowed)
                raise SceneError(f"--{option}", f"must end in {one}, got {file!r}")
        if self.surface and (self.data is None or show == "contact"):
            raise SceneError("--surface", "makes --data FILE.csv of a field a table of its surface")

    @classmethod
    def read(cls, arguments) -> "Wanted":
        """Return what the parsed arguments of a call ask for.

        Raises
        ------
        SceneError
            Naming the option and its rule.
        """
        if arguments.show not in (None, *OFFERED):
            raise SceneError("--show", f"must be one of {', '.join(OFFERED)}, got {arguments.show!r}")
        same = ("screenshot", "movie", "html", "data", "surface", "show", "quantity")
        number, positive = "a finite number ({})", "a finite number of at least 0 ({})"
        texts: dict[str, tuple[str, Callable, Callable, str]] = {
            "phase": ("--phase", float, np.isfinite, number.format("degrees")),
            "span": ("--span", _span, lambda span: len(span) == 2 or span in WORDS, SPAN),
            "scale": ("--scale", float, lambda value: 0 <= value < np.inf, positive.format("times")),
            "size": ("--size", _size, lambda size: 200 <= size[0] <= 8000 and 100 <= size[1] <= 8000, SIZE),
            "frames": ("--frames", int, lambda value: 2 <= value <= 2000, "a whole number from 2 to 2000"),
            "voltage": ("--voltage", float, lambda value: 0 <= value < np.inf, positive.format("V")),
        }
        read = {name: _read(getattr(arguments, name), *each) for name, each in texts.items()}
        return cls(
            **{name: getattr(arguments, name) for name in same},
            **{name: read[name] for name in ("span", "size", "frames")},
            phase=np.radians(read["phase"]),
            factor=read["scale"],
            level=read["voltage"],
        )


def _read(text: str | None, option: str, read: Callable, fits: Callable, rule: str):
    """Return what a text means, None for none; refuse one that cannot be read or does not fit."""
    if text is None:
        return None
    try:
        value = read(text)
    except ValueError:
        value = None
    if value is None or not fits(value):
        raise SceneError(option, f"must be {rule}, got {shown(text)}")
    return value


def _span(text: str):
    return text if text in WORDS else tuple(1e-3 * float(part) for part in text.split(":"))


def _size(text: str) -> tuple[int, int]:
    width, height = text.lower().split("x")
    return int(width), int(height)
