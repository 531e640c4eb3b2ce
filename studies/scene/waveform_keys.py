"""The block of a scene that shapes a burst: amplitude and phase of the source, or of a prescribed wave, over time."""

from dataclasses import dataclass
from typing import Annotated, Any, ClassVar

from studies.scene.block import Block
from studies.scene.numbers import FixedList, Quantity
from studies.scene.rule import TEXT, choice

OFFSET = Quantity("Hz", negative=True)
# Keys that one shape alone takes, and requires
OF_SHAPE = {"modulated": ("depth", "frequency"), "chirp": ("sweep",)}


@dataclass(frozen=True, kw_only=True)
class Waveform(Block):
    """The shape of a burst: a factor on the level, with a phase, from the beginning of the burst to its end."""

    block: ClassVar[str] = "drive.waveform"
    shape: Annotated[
        str | None,
        choice("ramp", "modulated", "chirp"),
        "ramp: linear edges (rise, fall; those shorter than a period of the wave are steps). modulated: 1 + depth "
        "sin(2 pi frequency t). chirp: a linear sweep of the frequency. Each may have edges. Required unless file is "
        "given.",
    ] = None
    rise: Annotated[float, Quantity("s", zero=True), "Time in which the amplitude rises linearly from 0 to 1."] = 0.0
    fall: Annotated[
        float,
        Quantity("s", zero=True),
        "Time before the burst's end in which the amplitude falls linearly from 1 to 0.",
    ] = 0.0
    depth: Annotated[
        float | None, Quantity(least=0.0, most=1.0), "Modulation depth, of modulated; the carrier keeps the level."
    ] = None
    frequency: Annotated[float | None, Quantity("Hz"), "Frequency of the modulation, of modulated."] = None
    sweep: Annotated[
        tuple[float, float] | None,
        FixedList((OFFSET, OFFSET), '[first, last], such as ["-10 kHz", "10 kHz"]'),
        "Frequency less that of the source at the beginning and at the end of the burst, of chirp.",
    ] = None
    file: Annotated[
        str | None,
        TEXT,
        "CSV file of the waveform, from the scene's folder: columns time_s and amplitude (a factor on the level, or "
        "amplitude_percent), and perhaps phase_deg or frequency_offset_Hz, no others; linear between its rows, "
        "constant before the first and after the last.",
    ] = None

    def check_file(self) -> Any:
        if self.file is None:
            if self.shape is None:
                yield "shape", "is required and missing: give ramp, modulated or chirp, or a file"
            return
        names = ("shape", *self.shape_keys)
        given = [name for name in (*names, "rise", "fall") if getattr(self, name)]
        for name in given:
            yield name, "must be absent with file, which is the whole waveform"

    def check_shape(self) -> Any:
        if self.file is not None or self.shape is None:
            return
        for shape, names in OF_SHAPE.items():
            for name in names:
                present = getattr(self, name) is not None
                if present and self.shape != shape:
                    yield name, f"must be absent with the shape {self.shape}: it is of the shape {shape}"
                if not present and self.shape == shape:
                    yield name, f"is required and missing with the shape {shape}"
        if self.shape == "ramp" and self.rise == self.fall == 0.0:
            yield "rise", "is required and missing with the shape ramp, or fall: the burst would be rectangular"

    @property
    def shape_keys(self) -> tuple[str, ...]:
        """The keys of all shapes."""
        return tuple(name for names in OF_SHAPE.values() for name in names)


def check_burst(burst: float | None, waveform: Waveform | None) -> Any:
    """Yield what a waveform needs of its burst."""
    if waveform is None:
        return
    if burst is None:
        yield "waveform", "needs a burst: it is the shape of one"
    elif waveform.rise + waveform.fall > burst:
        edges = waveform.rise + waveform.fall
        yield "waveform.rise", f"and fall must together be at most the burst, {burst:g} s, got {edges:g} s"
