"""The waveform of a burst as numbers: factor and phase of the drive over time.

    a(t) = A(t) exp(i phi(t)),   0 <= t <= duration,

on the voltage of the source, or on a prescribed wave. Its knots are so close that amplitude and phase are linear
between them to 1e-4.
"""

import math
from dataclasses import dataclass

import numpy as np

import contact
from studies.lab.column_heads import FREQUENCIES, PHASES, SHARES, TIMES, VOLTAGES
from studies.lab.csv_columns import CsvColumns
from studies.refusal import refuse_if
from studies.scene import Scene
from studies.scene.waveform_keys import Waveform

ERROR = 1e-4  # of the factor between the knots, about
MAX_KNOTS = 1_000_000
# frequency of a modulation, or offset of the frequency, over that of the wave: above it, the factor is no envelope
FASTEST = 0.1
WANTED = "time_s, amplitude and perhaps phase_deg or frequency_offset_Hz"
COLUMNS = {"time": TIMES, "amplitude": SHARES, "phase": PHASES, "frequency_offset": FREQUENCIES}


@dataclass(frozen=True, kw_only=True)
class Modulation:
    """The factor on the drive of a burst."""

    envelope: contact.Envelope
    # largest frequency in Hz by which the drive, or a side band of its modulation, differs from the carrier
    offset: float
    turns: bool  # whether its phase changes
    mean_square: float  # of the amplitude, over the burst


def modulation(scene: Scene) -> Modulation | None:
    """Return the waveform of a scene's burst; None for a rectangular one.

    Raises
    ------
    SceneError
        If the waveform's file cannot be read, or the waveform changes too fast.
    """
    block, duration = scene.source.waveform, scene.burst
    if block is None:
        return None
    path = f"{scene.source.block}.waveform"
    if block.file is not None:
        envelope, offset = _of_file(_table(block, block.file, path), duration, scene.frequency)
    else:
        envelope, offset = _of_shape(block, path, duration, scene.frequency)
    if np.all(envelope.amplitude == 1.0) and np.all(envelope.phase == 0.0):
        return None
    inside = instants(envelope, duration)
    amplitude = abs(envelope.at(inside))
    squares = amplitude[1:] ** 2 + amplitude[1:] * amplitude[:-1] + amplitude[:-1] ** 2  # Simpson's rule, exact here
    mean = float(np.sum(squares * np.diff(inside)) / (3.0 * duration))
    return Modulation(
        envelope=envelope, offset=offset, turns=bool(np.ptp(envelope.phase) > 0.0), mean_square=mean,
    )  # fmt: skip


def _table(block: Waveform, file: str, path: str) -> CsvColumns:
    """Return the columns of the file of a waveform, which is read once for each block: a run keeps its first state."""
    kept = vars(block)  # the block is frozen; functools.cached_property keeps its value in the same way
    if "_table" not in kept:
        kept["_table"] = CsvColumns.read(file, f"{path}.file")
    return kept["_table"]


def instants(envelope: contact.Envelope, duration: float) -> np.ndarray:
    """Return the times in a burst between which the amplitude of its envelope is linear, s."""
    return np.unique(np.clip(np.concatenate([[0.0, duration], envelope.time]), 0.0, duration))


def _of_shape(block: Waveform, path: str, duration: float, carrier: float) -> tuple[contact.Envelope, float]:
    """Return the envelope of a shape and its largest frequency offset, Hz; edges shorter than a period are steps."""
    rises, falls = (0.0 if is_step(edge, carrier) else edge for edge in (block.rise, block.fall))
    edges = [0.0, rises, duration - falls, duration]
    parts, offset = 1.0, 0.0
    depth, slow, (first, last) = block.depth or 0.0, block.frequency or 0.0, block.sweep or (0.0, 0.0)
    if block.shape == "modulated":
        offset = slow
        refuse_if(offset > FASTEST * carrier, f"{path}.frequency", _slower(offset, carrier))
        # a sine's chord over an angle h is off by h^2/8
        parts = duration * offset * 2.0 * math.pi * math.sqrt(depth / (8.0 * ERROR))
    elif block.shape == "chirp":
        offset = max(abs(first), abs(last))
        refuse_if(offset > FASTEST * carrier, f"{path}.sweep", _slower(offset, carrier))
        # the chord of a phase of curvature c is off by c h^2/8
        parts = duration * math.sqrt(2.0 * math.pi * abs(last - first) / duration / (8.0 * ERROR))
    rule = f"changes so fast that {parts:.1e} instants are needed, at most {MAX_KNOTS:g}: shorten the burst"
    refuse_if(parts > MAX_KNOTS, path, rule)
    time = np.unique(np.concatenate([edges, np.linspace(0.0, duration, max(2, math.ceil(parts) + 1))]))
    rise = np.clip(time / rises, 0.0, 1.0) if rises > 0.0 else np.ones_like(time)
    fall = np.clip((duration - time) / falls, 0.0, 1.0) if falls > 0.0 else np.ones_like(time)
    amplitude, phase = np.minimum(rise, fall), np.zeros_like(time)
    if block.shape == "modulated":
        amplitude = amplitude * (1.0 + depth * np.sin(2.0 * math.pi * slow * time))
    elif block.shape == "chirp":
        phase = 2.0 * math.pi * (first * time + (last - first) * time**2 / (2.0 * duration))
    return contact.Envelope(time=time, amplitude=np.maximum(amplitude, 0.0), phase=phase), offset


def is_step(edge: float, carrier: float) -> bool:
    """Whether an edge in s of a burst at a frequency in Hz is a step: it takes less than a period of the wave.

    The factor on a wave means nothing within a period, and its slope there would throw the slider: at 1e-15 s it left
    the burst at 285 m/s instead of 13.5 mm/s.  At one period a ramp still changes the velocity after 440 cycles by
    0.2 % (seed's ball at 10 nm with 1/89 of its mass).
    """
    return edge * carrier < 1.0


def _slower(offset: float, carrier: float) -> str:
    """Return the rule that the frequency of a drive differs little from that of its wave."""
    return f"must be at most {FASTEST:g} of the wave's frequency, {FASTEST * carrier:g} Hz, got {offset:g} Hz"


def _of_file(table: CsvColumns, duration: float, carrier: float) -> tuple[contact.Envelope, float]:
    """Return the envelope in a file and its largest frequency offset, Hz."""
    table.refuse_uneven()
    volts = [name for name in table.names if name.rpartition("_")[2] in VOLTAGES]
    if volts and not {"amplitude", "amplitude_percent"} & set(table.names):
        raise table.lacking(WANTED, f": amplitude is a factor on the level, so divide {volts[0]} by the level in V")
    time, amplitude, phase, offset = (table.column(noun, units) for noun, units in COLUMNS.items())
    if time is None or amplitude is None:
        raise table.lacking(WANTED)
    read = {f"{noun}_{unit}".removesuffix("_") for noun, units in COLUMNS.items() for unit in units}
    other = [name for name in table.names if name not in read]
    table.refuse_if(bool(other), f"must have the columns {WANTED} alone: remove {', '.join(other)}")
    both = phase is not None and offset is not None
    table.refuse_if(both, "must have one of the columns phase_deg and frequency_offset_Hz, not both")
    at, size = time[0], amplitude[0]
    table.refuse_falling("time", at, "s")
    if np.any(size < 0.0):
        row = int(np.flatnonzero(size < 0.0)[0])
        raise table.error(
            f"{table.line(row)}amplitude must not be negative, got {size[row]:g}: write a phase of 180 deg"
        )
    driven = abs(contact.Envelope(time=at, amplitude=size, phase=0.0 * at).at(np.clip(at, 0.0, duration)))
    table.refuse_if(not np.any(driven > 0.0), "must have an amplitude that is not 0 in the burst")
    if offset is None:
        angle = np.zeros_like(at) if phase is None else phase[0]
        moving = np.maximum(size[1:], size[:-1]) > 0.0
        rates = abs(np.diff(angle) / np.diff(at))[moving] / (2.0 * math.pi)
        return contact.Envelope(time=at, amplitude=size, phase=angle), float(rates.max(initial=0.0))
    largest = float(abs(offset[0]).max())
    table.refuse_if(largest > FASTEST * carrier, f"frequency_offset {_slower(largest, carrier)}")
    return _integrated(table, at, size, offset[0], duration), largest


def _integrated(table: CsvColumns, at, size, offset, duration: float) -> contact.Envelope:
    """Return the envelope whose phase is the integral of a frequency offset (Hz) that is linear between the rows."""
    inside = np.unique(np.clip(np.concatenate([[0.0, duration], at]), 0.0, duration))
    rates = abs(np.diff(np.interp(inside, at, offset)) / np.diff(inside))
    parts = np.ceil(np.diff(inside) * np.sqrt(2.0 * math.pi * rates / (8.0 * ERROR))).astype(int)
    rule = f"sweeps the frequency so fast that {parts.sum()} instants are needed, at most {MAX_KNOTS}"
    table.refuse_if(parts.sum() > MAX_KNOTS, rule)
    time = np.concatenate(
        [np.linspace(a, b, max(1, n), endpoint=False) for a, b, n in zip(inside[:-1], inside[1:], parts, strict=True)]
        + [[duration]]
    )
    f = np.interp(time, at, offset)
    phase = 2.0 * math.pi * np.concatenate([[0.0], np.cumsum(0.5 * (f[1:] + f[:-1]) * np.diff(time))])
    return contact.Envelope(time=time, amplitude=np.interp(time, at, size), phase=phase)
