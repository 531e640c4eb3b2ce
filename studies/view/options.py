"""What ``sawmotor view`` is asked for: files, quantity, instant, stretch, sizes."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from studies.refusal import SceneError, shown
from studies.scene.override import toml_value

__all__ = ["Wanted"]

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
        return cls(
            **{name: getattr(arguments, name) for name in same},
            phase=np.radians(_number("--phase", arguments.phase, "degrees")),
            span=_span(arguments.span),
            factor=_number("--scale", arguments.scale, "times", low=0.0),
            size=_size(arguments.size),
            frames=_count("--frames", arguments.frames),
            level=_number("--voltage", arguments.voltage, "V", low=0.0),
        )


def _span(text: str | None):
    if text is None or text in ("whole", "slider", "wavelength"):
        return text
    try:
        start, stop = (float(part) for part in text.split(":"))
    except ValueError:
        rule = "must be whole, slider, wavelength or START:STOP in mm"
        raise SceneError("--span", f"{rule}, got {text!r}") from None
    return start * 1e-3, stop * 1e-3


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError:
        width = height = 0
    if not (200 <= width <= 8000 and 100 <= height <= 8000):
        raise SceneError("--size", f"must be WIDTHxHEIGHT in pixels, 200x100 to 8000x8000, got {text!r}")
    return width, height


def _number(option: str, text: str | None, unit: str, *, low: float = -np.inf) -> float | None:
    value = None if text is None else toml_value(text)
    if value is None:
        return None
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if not (number and np.isfinite(value) and value >= low):
        bound = "" if low == -np.inf else f" of at least {low:g}"
        raise SceneError(option, f"must be a finite number{bound} ({unit}), got {shown(text)}")
    return float(value)


def _count(option: str, text: str | None) -> int | None:
    value = None if text is None else toml_value(text)
    if text is not None and not (type(value) is int and 2 <= value <= 2000):
        raise SceneError(option, f"must be a whole number from 2 to 2000, got {shown(text)}")
    return value
