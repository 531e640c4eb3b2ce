"""The electrical circuit of a stator: sources, terminations and impedances at the ports of its admittance matrix.

With I = Y V (currents into the positive electrodes), a source of voltage S behind an impedance Z obeys V + Z I = S, a
loaded transducer V + Z I = 0, a short-circuited one V = 0, an open one I = 0.  A ladder between source and transducer
transforms voltage and current to V' = A V + B I and I' = C V + D I at the source's end, where V' + Z I' = S; its
impedance at the electrodes is then (B + Z D) / (A + Z C).  Only this module knows which transducers are driven:
everything below it solves for unit voltage at every port.  The open strips of a transducer ("o" in its pattern) are not
ports: they are eliminated with the condition of zero charge (`fem.condense.electrode_conditions`).
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated, Any

import numpy as np

from fem.circuit.ladder import Ladder, carried
from fem.condense.electrode_conditions import terminated
from fem.geometry import Transducer
from fem.parameters import ComplexNumber, InputError, refuse_if, refuses
from fem.sources import SourceRules

# Load and source are matched in turn; each round multiplies the error by the power gain there and back, below 1.
MATCHING_ROUNDS = 200
MATCHING_TOLERANCE = 1e-13  # relative change of the source's impedance


@dataclass(frozen=True, kw_only=True)
class Drive(SourceRules):
    """Sources at one or several transducers.

    Attributes
    ----------
    sources : mapping of str to complex
        By name of the transducer: amplitude and phase of its source relative to the drive voltage.
    impedance : complex
        Of each source, ohm.
    match : tuple of Element
        Ladder between each source and its transducer, from the source on.

    Examples
    --------
    >>> Drive(sources={"left": 1.0, "right": 0.5j}, impedance=50.0).sources["right"]
    0.5j
    """

    prefix = "drive"
    sources: Mapping[str, complex]
    impedance: Annotated[complex, ComplexNumber("ohm")] = 0.0
    match: Ladder = ()


def as_drive(drive: "str | Drive") -> Drive:
    """Return a `Drive`; a transducer's name means an ideal source of the full drive voltage there."""
    return Drive(sources={drive: 1.0}) if isinstance(drive, str) else drive


@dataclass(frozen=True, kw_only=True)
class SourcePowers:
    """Powers on the sources' side of the driven transducers, W per V^2 of the drive (peak).

    Attributes
    ----------
    available : float
        Largest power that the sources can deliver to any load; infinite for a source without resistance.
    delivered : float
        Delivered by the voltage sources.
    in_sources, in_ladders : float
        Lost in the sources' impedances and in the elements of the ladders; the rest enters the transducers.
    """

    available: float
    delivered: float
    in_sources: float
    in_ladders: float


@dataclass(frozen=True, kw_only=True)
class Circuit:
    """Voltages and currents of all ports, per volt of the drive (peak).

    Attributes
    ----------
    names : tuple of str
        Transducers that are ports.
    voltages, currents : ndarray, shape (ports,)
        Between the electrodes (V per V), and into the positive ones (A per V).
    sources : tuple of int
        Ports with a source, those of amplitude 0 last; the first is that of ``admittance`` and ``voltage``.
    aperture : float
        Of the first source's transducer, m; without a source the narrowest transducer's, or 1 m.
    drive : Drive or None
    network : SourcePowers
        Powers delivered by the sources and lost before the transducers.
    """

    names: tuple[str, ...]
    voltages: np.ndarray = field(repr=False)
    currents: np.ndarray = field(repr=False)
    sources: tuple[int, ...]
    aperture: float
    drive: Drive | None
    network: SourcePowers

    @property
    def admittance(self) -> complex:
        """Current over voltage of the first source's transducer, all sources on and the others terminated, in S."""
        return complex(self.currents[self.sources[0]] / self.voltages[self.sources[0]])

    @property
    def driven(self) -> tuple[str, ...]:
        """Names of the transducers with a source."""
        return tuple(self.names[at] for at in self.sources)

    @property
    def source_admittances(self) -> np.ndarray:
        """Current over voltage of every source's transducer whose voltage is not 0, in S."""
        on = [at for at in self.sources if self.voltages[at] != 0]
        return self.currents[on] / self.voltages[on]

    @property
    def voltage(self) -> complex:
        """Between the electrodes of the first source's transducer."""
        return complex(self.voltages[self.sources[0]])

    @property
    def power(self) -> float:
        """Mean power from all sources into the stator in W per V^2."""
        at = list(self.sources)
        return float(0.5 * np.sum(np.real(self.voltages[at] * np.conj(self.currents[at]))))

    @property
    def apparent_power(self) -> float:
        """Sum of |V I| / 2 over the sources in W per V^2."""
        at = list(self.sources)
        return float(0.5 * np.sum(abs(self.voltages[at] * self.currents[at])))


def solve_circuit(
    admittances: np.ndarray,
    names: tuple[str, ...],
    transducers: tuple[Transducer, ...],
    drive: str | Drive | None,
    frequency: float,
    received: np.ndarray | None = None,
) -> Circuit:
    """Solve for the voltages of all ports: I = Y V, or I = Y V + I_received if they receive a current and send none.

    Parameters
    ----------
    admittances : ndarray, shape (ports, ports)
        S.
    names : tuple of str
        Transducers that are ports, in the matrix's order.
    transducers : tuple of Transducer
        All of them, with the terminations of those that are not driven.
    drive : str or Drive or None
        With a received current its source voltages are set to zero; its impedances and ladders terminate their
        transducers.
    frequency : float
        Hz, for the elements of a ladder.
    received : ndarray, shape (ports,), optional
        Current into each port while all are shorted, A.

    Returns
    -------
    Circuit

    Raises
    ------
    ValueError
        If a source's transducer does not exist or has one electrode only, or all voltages are zero.
    """
    drive = None if drive is None else as_drive(drive)
    apertures = {each.name: each.aperture for each in transducers}
    _refuse_sources(drive, names, apertures)
    voltages = _voltages(admittances, names, transducers, drive, frequency, received)
    if drive is None or received is not None:
        return Circuit(
            names=names,
            voltages=voltages,
            currents=admittances @ voltages + (0.0 if received is None else received),
            sources=(),
            aperture=min(apertures.values(), default=1.0),
            drive=drive,
            network=SourcePowers(available=0.0, delivered=0.0, in_sources=0.0, in_ladders=0.0),
        )
    currents = admittances @ voltages
    by_amplitude = sorted(drive.sources, key=lambda name: drive.sources[name] == 0)
    driven = [names.index(name) for name in by_amplitude]
    into_ladders = carried(drive.match, 2 * np.pi * frequency, voltages[driven], currents[driven])
    amplitudes = np.array([drive.sources[name] for name in by_amplitude])
    return Circuit(
        names=names,
        voltages=voltages,
        currents=currents,
        sources=tuple(driven),
        aperture=apertures[by_amplitude[0]],
        drive=drive,
        network=_source_powers(drive, amplitudes, *into_ladders[1:]),
    )


@refuses(InputError)
def _refuse_sources(drive: Drive | None, names: tuple[str, ...], known: Collection[str]) -> Iterator[Any]:
    """Raise an InputError for a source at a transducer that is not ``known``, or is no port."""
    for name in drive.sources if drive else ():
        if name not in known:
            yield "sources", f"must name transducers of the stator, {', '.join(known)}", name
        if name not in names:
            yield "sources", f"must name transducers that have two electrodes, but {name!r} has not"


def _voltages(admittances, names, transducers, drive: Drive | None, frequency: float, received=None) -> np.ndarray:
    """Solve ``across * V + along * I = source`` at every port; with a received current all sources are zero."""
    terminations = {each.name: each.termination for each in transducers}
    across, along = np.ones(len(names), dtype=complex), np.zeros(len(names), dtype=complex)
    source = np.zeros(len(names), dtype=complex)
    for port, name in enumerate(names):
        if drive is not None and name in drive.sources:
            across[port], along[port] = _source_condition(drive, 2 * np.pi * frequency)
            source[port] = drive.sources[name]
        else:
            across[port], along[port] = terminated(terminations[name], admittances[port, port])
    load = source if received is None else -along * received
    return np.linalg.solve(np.diag(across) + along[:, None] * admittances, load)


def matched_load(
    admittances: np.ndarray,
    names: tuple[str, ...],
    transducers: tuple[Transducer, ...],
    drive: str | Drive,
    receiver: str,
    frequency: float,
    *,
    source_matched: bool = False,
) -> complex:
    """Return the impedance in ohm that takes the most power from a transducer: its conjugate output impedance.

    Parameters
    ----------
    admittances, names, transducers, drive, frequency
        As for `solve_circuit`.
    receiver : str
        A transducer of two electrodes without a source.
    source_matched : bool
        If true, a lossless network matches the single source to its transducer with this load.  Both ends are
        then matched simultaneously, which gives the load the largest share of the power that the transducers take.

    Raises
    ------
    ValueError
        If the receiver's output impedance has no resistance: its load could take any power.
    """
    drive = as_drive(drive)

    def output_admittance(name: str, terminations: dict) -> complex:
        others = tuple(replace(each, termination=terminations.get(each.name, each.termination)) for each in transducers)
        return solve_circuit(admittances, names, others, name, frequency).admittance

    across, along = _source_condition(drive, 2 * np.pi * frequency)
    source = along / across
    for _ in range(MATCHING_ROUNDS):
        own = output_admittance(receiver, dict.fromkeys(drive.sources, source))
        refuse_if(not own.real > 0, "matched_load", f"needs a transducer that shows a resistance, got {own:g} S")
        load = 1 / own.conjugate()
        if not source_matched:
            break
        driven = output_admittance(next(iter(drive.sources)), {receiver: load})
        before, source = source, 1 / driven.conjugate()
        if abs(source - before) < MATCHING_TOLERANCE * abs(source):
            break
    return complex(load)


def rectifier_resistance(resistance: float) -> float:
    """Return the equivalent resistance in ohm of a full-bridge rectifier with a smoothing capacitor and a resistance.

    For a sinusoidal current its voltage is a square wave whose fundamental alone takes power: R_ac = 8 R / pi^2
    (R. L. Steigerwald, IEEE Trans. Power Electron. 3, 1988, 174).  The diodes' forward voltage is neglected.
    """
    return 8 / np.pi**2 * resistance


def _source_condition(drive: Drive, omega: float) -> tuple[complex, complex]:
    """Return V' + Z I' at the source's end for a unit voltage and for a unit current at the electrodes."""
    across, along = (
        ends[0] + drive.impedance * ends[1]
        for ends in (carried(drive.match, omega, *unit) for unit in ((1.0, 0.0), (0.0, 1.0)))
    )
    return across, along


def _source_powers(drive: Drive, amplitudes, currents, in_ladders) -> SourcePowers:
    """Return the powers of sources whose ladders take these voltages and currents at the source's end."""
    resistance = drive.impedance.real
    squares = float(np.sum(abs(amplitudes) ** 2))
    delivered = 0.5 * np.sum((amplitudes * currents.conj()).real)
    return SourcePowers(
        available=squares / (8 * resistance) if resistance > 0 else np.inf,
        delivered=float(delivered),
        in_sources=float(0.5 * resistance * np.sum(abs(currents) ** 2)),
        in_ladders=float(np.sum(in_ladders)),
    )
