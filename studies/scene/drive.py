"""The blocks of a scene that set frequency, levels and burst: the drive and its circuit, or a prescribed motion.

Everything is in SI units once read.  Amplitudes and voltages are peak values.
"""

from dataclasses import dataclass, replace
from typing import Annotated, Any, ClassVar

import fem
from studies.refusal import nearest
from studies.scene.block import Block, Blocks, Within, keys_of
from studies.scene.numbers import AMPLITUDE, Listed, Quantity, impedance
from studies.scene.plane_keys import WaveSource
from studies.scene.rule import FLAG, TEXT, Named, choice
from studies.scene.waveform_keys import Waveform, check_burst

SUCH = ', such as "50 ohm"'
SOURCES = Named('a table of transducers such as { left = 1, right = "0.5 at 90 deg" }', AMPLITUDE)
FREQUENCIES = Named('a table of transducers such as { front = "2.3 MHz" }', Quantity("Hz"))


@dataclass(frozen=True, kw_only=True)
class Element(Block):
    """One element of a ladder between the source and its transducer; one block for each, in order."""

    block: ClassVar[str] = "drive.match"
    series_L: Annotated[float | None, Quantity("H"), "Inductance in series."] = None
    series_C: Annotated[float | None, Quantity("F"), "Capacitance in series."] = None
    series_R: Annotated[float | None, Quantity("ohm"), "Resistance in series."] = None
    shunt_L: Annotated[float | None, Quantity("H"), "Inductance across the line."] = None
    shunt_C: Annotated[float | None, Quantity("F"), "Capacitance across the line."] = None
    shunt_R: Annotated[float | None, Quantity("ohm"), "Resistance across the line."] = None
    Q: Annotated[
        float | None,
        Quantity(),
        "Quality factor of the inductance or capacitance at drive.frequency. Absent: lossless.",
    ] = None

    def check_one(self) -> Any:
        names = [name for name in keys_of(Element) if name != "Q" and getattr(self, name) is not None]
        if len(names) != 1:
            known = ", ".join(name for name in keys_of(Element) if name != "Q")
            yield "", f"must be a table of one element, one of {known}, got {', '.join(names) or 'none'}"
        elif names[0].endswith("R") and self.Q is not None:
            yield "Q", "must be absent with a resistance"

    @property
    def name(self) -> str:
        """Its position in the ladder and its kind, such as series_L."""
        return next(name for name in keys_of(Element) if getattr(self, name) is not None)

    def __str__(self) -> Any:
        return f"{self.name} {getattr(self, self.name):.4g} {keys_of(Element)[self.name].rule.unit}"


@dataclass(frozen=True, kw_only=True)
class Recovery(Block):
    """A receiving transducer whose load takes the power, or feeds it back to the source in phase."""

    block: ClassVar[str] = "drive.recovery"
    receiver: Annotated[str, TEXT, "Name of the transducer that receives; the load replaces its termination."]
    load: Annotated[
        str | float | complex,
        impedance("matched"),
        "Impedance of the load. matched: the complex conjugate of the transducer's impedance at drive.frequency.",
    ] = "matched"
    rectifier: Annotated[
        float | None,
        Quantity("ohm"),
        "Resistance behind a full-bridge rectifier with a capacitor, instead of load; the load is then 8/pi^2 of it.",
    ] = None
    efficiency: Annotated[
        float,
        Quantity(),
        "Returned power over the power in the load, due to rectifier and return path; above 1 with an amplifier.",
    ] = 1.0
    circulation: Annotated[
        bool,
        FLAG,
        "true: an ideal combiner adds the returned power in phase to that of the source. drive.voltage or "
        "drive.power is that of both together: the motion is unchanged, and the source supplies less.",
    ] = False

    def check_load(self) -> Any:
        if self.rectifier is not None and self.load not in ("matched", self.rectifier_load):
            yield "load", "must be absent with drive.recovery.rectifier: it is the load"
        elif self.load != "matched" and not complex(self.load).real > 0:
            yield "load", f"must have a resistance, which takes the power, got {self.load!r} ohm"

    @property
    def rectifier_load(self) -> float | None:
        """Resistance in ohm that stands for the rectifier, if there is one."""
        return None if self.rectifier is None else fem.rectifier_resistance(self.rectifier)


@dataclass(frozen=True, kw_only=True)
class Drive(Block):
    """The source: its frequency and, with transducers, which one it drives at which peak voltages."""

    block: ClassVar[str] = "drive"
    parameters_of = "fem.SourceRules"
    frequency: Annotated[
        float | str,
        Quantity("Hz") | choice("center"),
        "Frequency of the source. center: the frequency of the strongest surface wave per volt, for the driven "
        "transducer alone; its period must be a number.",
    ]
    transducer: Annotated[
        str | None,
        TEXT,
        "Name of the driven transducer; required if the scene has transducers, unless sources is given.",
    ] = None
    sources: Annotated[
        tuple[tuple[str, complex], ...] | None,
        SOURCES,
        "Amplitude and phase of the source at each driven transducer, relative to the voltage; replaces transducer.",
    ] = None
    source_frequencies: Annotated[
        tuple[tuple[str, float], ...] | None,
        FREQUENCIES,
        "Frequencies of those sources that have one of their own, under a slider in the plane. Absent: frequency.",
    ] = None
    voltage: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("V", zero=True), ranged=True),
        "Peak voltage of the source, one value or several. If the scene has transducers, voltage or power is required.",
    ] = None
    power: Annotated[
        tuple[float, ...] | None,
        Listed(Quantity("W", zero=True), ranged=True),
        "Available power of the sources, instead of voltage: V^2/(8 R) for each, where R is the resistance of "
        "source_impedance.",
    ] = None
    burst: Annotated[
        float | None,
        Quantity("s"),
        "Duration of the drive; the slider starts from rest. Absent: the steady state only.",
    ] = None
    waveform: Annotated[
        Waveform | None, Within(Waveform), "Shape of the burst, a factor on the level. Absent: rectangular."
    ] = None
    duty: Annotated[
        float | None,
        Quantity(),
        "Share of the time for which the drive is on, at most 1, in bursts much shorter than the stator's time "
        "constant; its heat is that share. Absent: a continuous drive, or with burst a single one.",
    ] = None
    source_impedance: Annotated[
        float | complex,
        impedance(),
        "Impedance between each source and its transducer: a resistance or [resistance, reactance].",
    ] = 0.0
    match: Annotated[
        str | tuple,
        choice("none", "auto") | Blocks(Element, least=1),
        "Matching network between each source and its transducer. auto: the lossless L-section of least stored "
        "energy that delivers all available power at drive.frequency; or its elements, from the source on, such as "
        '[{ series_L = "2.6 uH", Q = 80 }, { shunt_C = "1 nF" }].',
    ] = "none"
    recovery: Annotated[Recovery | None, Within(Recovery), "Use of the power that another transducer receives."] = None

    def check_duty(self) -> Any:
        if self.duty is not None and self.duty > 1.0:
            yield "duty", f"must be at most 1, a continuous drive, got {self.duty:g}"

    def check_waveform(self) -> Any:
        yield from check_burst(self.burst, self.waveform)
        if self.waveform is not None and self.duty is not None:
            yield "waveform", "must be absent with drive.duty, whose bursts are rectangular"

    def check_power(self) -> Any:
        if self.power is None:
            return
        if self.voltage is not None:
            yield "voltage", "must be absent with drive.power: it follows from the power"
        if complex(self.source_impedance).real == 0:
            yield "power", f"needs a drive.source_impedance with a resistance{SUCH}, which limits the power"

    def check_frequencies(self) -> Any:
        names = [name for name, _ in self.sources or ()]
        for name, _ in self.source_frequencies or ():
            if name not in names:
                yield f"source_frequencies.{name}", f"must name one of drive.sources{nearest(name, names)}"
        if self.source_frequencies and self.frequency == "center":
            yield "frequency", 'must be a number in Hz beside source_frequencies, got "center"'

    def check_match(self) -> Any:
        if self.match == "auto" and complex(self.source_impedance).real == 0:
            yield "match", f'needs a drive.source_impedance with a resistance for "auto"{SUCH}'
        if self.match == "auto" and len(self.sources or ()) > 1:
            rule = 'must be "none" or a ladder with several sources: what each should see depends on the others'
            yield "match", rule

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.sources is not None:  # reports are about the first source that is not 0
            first = next(name for name, amplitude in self.sources if amplitude)
            object.__setattr__(self, "transducer", first)

    @property
    def driven(self) -> dict[str, complex]:
        """Amplitude of the source at each driven transducer, relative to the voltage."""
        if self.sources is not None:
            return dict(self.sources)
        return {} if self.transducer is None else {self.transducer: 1.0}

    @property
    def frequencies(self) -> tuple[float, ...]:
        """Different frequencies of the sources that are not 0 in Hz, that of the first one first."""
        own: dict[str, Any] = dict(self.source_frequencies or ())
        return tuple(dict.fromkeys(own.get(name, self.frequency) for name, size in self.driven.items() if size))

    @property
    def at_other_frequencies(self) -> tuple[str, ...]:
        """Names of the sources that are not 0 and have another frequency than the first one."""
        own: dict[str, Any] = dict(self.source_frequencies or ())
        first = self.frequencies[0] if own else self.frequency
        return tuple(name for name, size in self.driven.items() if size and own.get(name, self.frequency) != first)

    def at_frequency(self, frequency: float) -> "Drive":
        """Return the drive with one of its frequencies in Hz alone: the sources of the others are 0."""
        if not self.source_frequencies:
            return self
        own = dict(self.source_frequencies)
        sources = tuple(
            (name, size if own.get(name, self.frequency) == frequency else 0.0) for name, size in self.driven.items()
        )
        return replace(self, frequency=frequency, sources=sources, source_frequencies=None)

    @property
    def levels(self) -> tuple[float, ...]:
        """Peak voltages of the source in V, which follow from drive.power where it is set; empty without either."""
        if self.power is None:
            return self.voltage or ()
        return tuple((self._squared_voltage_per_watt * power) ** 0.5 for power in self.power)

    @property
    def available_powers(self) -> tuple[float, ...]:
        """Available power of all sources in W at each level; empty where the sources have no resistance."""
        if complex(self.source_impedance).real == 0:
            return ()
        return tuple(voltage**2 / self._squared_voltage_per_watt for voltage in self.levels)

    @property
    def _squared_voltage_per_watt(self) -> float:
        """Squared peak voltage of the source over the available power of all sources, in V^2/W."""
        squares = sum(abs(amplitude) ** 2 for amplitude in self.driven.values())
        return 8 * complex(self.source_impedance).real / squares


@dataclass(frozen=True, kw_only=True)
class Wave(Block):
    """A prescribed surface motion: u_z and, a quarter period from it, u_x, which at the crest moves towards +x."""

    block: ClassVar[str] = "wave"
    frequency: Annotated[float, Quantity("Hz"), "Frequency of the surface motion."]
    normal_amplitude: Annotated[
        tuple[float, ...], Listed(Quantity("m", zero=True), ranged=True), "Peak of u_z, one value or several."
    ]
    tangential_ratio: Annotated[float, Quantity(), "Amplitude ratio |u_x|/|u_z|."]
    burst: Annotated[
        float | None, Quantity("s"), "Duration of the wave; the slider starts from rest. Absent: the steady state only."
    ] = None
    waveform: Annotated[
        Waveform | None, Within(Waveform), "Shape of the burst, with the keys of drive.waveform. Absent: rectangular."
    ] = None
    wavelength: Annotated[
        float | None,
        Quantity("m"),
        "Wavelength of the wave, which runs towards -x; required for contacts at different positions.",
    ] = None
    compliance: Annotated[
        float | None,
        Quantity("1/Pa"),
        "Compliance Gamma of the surface, G_zz = Gamma/(k - k_R); required for pillars that load the wave.",
    ] = None
    sources: Annotated[
        tuple[WaveSource, ...] | None,
        Blocks(WaveSource, least=1),
        "Several waves under a slider in the plane, each with its direction, phase and frequency. Absent: one along x.",
    ] = None

    def check_waveform(self) -> Any:
        yield from check_burst(self.burst, self.waveform)

    def check_sources(self) -> Any:
        given = [each.normal_amplitude is not None for each in self.sources or ()]
        if any(given) and not all(given):
            yield f"sources.{given.index(False)}.normal_amplitude", "is required and missing: other sources have it"
        if self.sources and self.compliance is not None:
            yield "compliance", "must be absent with wave.sources: contacts in the plane do not load the waves"
