"""What ``sawmotor view`` is asked for: files, quantity, instant, stretch, sizes."""

from dataclasses import dataclass

import numpy as np

from studies.refusal import SceneError, shown
from studies.scene.override import toml_value

__all__ = ["Wanted"]

SHOWN = ("field", "solid", "beam", "contact")


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """What to show of a run, as asked for on the command line.

    Attributes
    ----------
    screenshot, movie, html, data : str or None
        Files; none at all: a window.
    surface : bool
        Whether the data are a table of the surface alone.
    show : str or None
        "field", "solid", "beam" or "contact"; None: the field, or without a stator the contact.
    quantity : str
        What colours the field.
    phase : float
        omega t, rad.
    span : str or tuple of float or None
        "whole", "slider" or "wavelength", or from where to where, m.
    factor : float or None
        By which the displacement is enlarged.
    size : tuple of int or None
        Pixels.
    frames : int
        Of a movie, or instants of a .pvd.
    level : float or None
        Voltage in V, or amplitude in m, of the contact; None: the largest.
    """

    screenshot: str | None = None
    movie: str | None = None
    html: str | None = None
    data: str | None = None
    surface: bool = False
    show: str | None = None
    quantity: str = "u_z"
    phase: float = 0.0
    span: str | tuple[float, float] | None = None
    factor: float | None = None
    size: tuple[int, int] | None = None
    frames: int | None = None
    level: float | None = None

    @property
    def files(self) -> tuple[str, ...]:
        """What is to be written."""
        return tuple(each for each in (self.screenshot, self.movie, self.html, self.data) if each is not None)

    @classmethod
    def read(cls, arguments) -> "Wanted":
        """Return what the parsed arguments of a call ask for.

        Raises
        ------
        SceneError
            Naming the option and its rule.
        """
        if arguments.show not in (None, *SHOWN):
            raise SceneError("--show", f"must be one of {', '.join(SHOWN)}, got {arguments.show!r}")
        if arguments.surface and arguments.data is None:
            raise SceneError("--surface", "says what --data FILE.csv holds: give --data too")
        return cls(
            screenshot=arguments.screenshot,
            movie=arguments.movie,
            html=arguments.html,
            data=arguments.data,
            surface=arguments.surface,
            show=arguments.show,
            quantity=arguments.quantity,
            phase=np.radians(_number("--phase", arguments.phase, "degrees")),
            span=_span(arguments.span),
            factor=None if arguments.scale is None else _number("--scale", arguments.scale, "times", low=0.0),
            size=_size(arguments.size),
            frames=None if arguments.frames is None else _count("--frames", arguments.frames),
            level=None
            if arguments.voltage is None
            else _number("--voltage", arguments.voltage, "V", low=0.0),
        )


def _span(text: str | None):
    if text is None or text in ("whole", "slider", "wavelength"):
        return text
    try:
        start, stop = (float(part) for part in text.split(":"))
    except ValueError:
        raise SceneError(
            "--span", f"must be whole, slider, wavelength or START:STOP in mm, got {text!r}"
        ) from None
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


def _number(option: str, text: str, unit: str, *, low: float = -np.inf) -> float:
    value = toml_value(text)
    good = (
        isinstance(value, (int, float))
        and not isinstance(value, bool)
        and np.isfinite(value)
        and value >= low
    )
    if not good:
        bound = "" if low == -np.inf else f" of at least {low:g}"
        raise SceneError(option, f"must be a finite number{bound} ({unit}), got {shown(text)}")
    return float(value)


def _count(option: str, text: str) -> int:
    value = toml_value(text)
    if not isinstance(value, int) or isinstance(value, bool) or not 2 <= value <= 2000:
        raise SceneError(option, f"must be a whole number from 2 to 2000, got {shown(text)}")
    return value
