"""Options of ``sawmotor view``: files, quantity, instant, span and sizes."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from fem.parameters import refuses
from studies.refusal import SceneError, misread, refuse_ending, refuse_other, refuse_unwritable

OFFERED = {
    "field": ("screenshot", "movie", "html", "data"),
    "solid": ("screenshot", "html", "data"),
    "beam": ("screenshot", "html"),
    "contact": ("screenshot", "movie", "html", "data"),
}  # available file options, by the value of --show
FORMATS = {
    "screenshot": (".png", ".jpg", ".jpeg", ".tif", ".tiff"),
    "movie": (".gif", ".mp4"),
    "html": (".html", ".htm"),
    "data": (".vtu", ".pvd", ".csv"),
}
NORMAL = "u_z"  # quantity that colours a field by default
WORDS = ("whole", "slider", "wavelength")
SPAN, SIZE = "whole, slider, wavelength or START:STOP in mm", "WIDTHxHEIGHT in pixels, 200x100 to 8000x8000"


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Parsed options of ``sawmotor view``. Without a file option, a window is opened."""

    screenshot: str | None = None
    movie: str | None = None
    html: str | None = None
    data: str | None = None
    surface: bool = False  # write only the surface into the data file
    show: str | None = None  # key of `OFFERED`; None: the field, or the contact for a scene without a stator
    quantity: str = NORMAL  # quantity that colours the field
    phase: float = 0.0  # omega t, rad
    span: str | tuple[float, float] | None = None  # "whole", "slider", "wavelength", or two positions in m
    factor: float | None = None  # magnification of the displacement
    size: tuple[int, int] | None = None  # pixels
    frames: int | None = None  # pictures of a movie, or instants of a .pvd
    level: float | None = None  # level of the contact, V, or m for a scene with a [wave]; None: the largest

    @property
    def files(self) -> dict[str, str]:
        """The files to be written, by option."""
        return {name: file for name in FORMATS if (file := getattr(self, name)) is not None}

    @refuses(SceneError)
    def check(self, show: str) -> Iterator[Any]:
        """Raise an error for a file that is not available for ``show`` or whose suffix is not allowed."""
        for option, file in self.files.items():
            if option not in OFFERED[show]:
                yield f"--{option}", f"does not go with --show {show}, got {file!r}"
            allowed = (".csv",) if option == "data" and (self.surface or show == "contact") else FORMATS[option]
            refuse_ending(file, allowed, f"--{option}")
            refuse_unwritable(file, f"--{option}")
        if self.surface and (self.data is None or show == "contact"):
            yield "--surface", "makes --data FILE.csv of a field a table of its surface"

    @classmethod
    def read(cls, arguments) -> "Wanted":
        """Return the options from the parsed arguments of the command.

        Raises
        ------
        SceneError
            If the value of an option is invalid; the message names the option and its rule.
        """
        if arguments.show is not None:
            refuse_other(arguments.show, OFFERED, "--show")
        unchanged = ("screenshot", "movie", "html", "data", "surface", "show", "quantity")
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
            **{name: getattr(arguments, name) for name in unchanged},
            **{name: read[name] for name in ("span", "size", "frames")},
            phase=np.radians(read["phase"]),
            factor=read["scale"],
            level=read["voltage"],
        )


def _read(text: str | None, option: str, read: Callable, fits: Callable, rule: str):
    """Return the value of a text, or None for None; raise an error if the value is invalid."""
    if text is None:
        return None
    try:
        value = read(text)
    except ValueError:
        value = None
    if value is None or not fits(value):
        raise misread(option, rule, text)
    return value


def _span(text: str):
    return text if text in WORDS else tuple(1e-3 * float(part) for part in text.split(":"))


def _size(text: str) -> tuple[int, int]:
    width, height = text.lower().split("x")
    return int(width), int(height)
