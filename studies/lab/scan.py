"""Vibrometer scans: the motion of the surface against position or frequency, and their CSV files.

A CSV file has one row per point. The columns are

- the position (``x_mm``, optionally ``y_mm``) or the frequency (``frequency_MHz``), or both: then the points at the
  frequency of the drive are taken;
- the motion, as ``u_z_real_nm`` and ``u_z_imag_nm``, or as ``u_z_magnitude_nm`` with an optional ``u_z_phase_rad``.
  Columns of u_x and u_y have the same form. Velocities have names such as ``v_z_real_mm_per_s``, accelerations such as
  ``a_z_real_m_per_s2``;
- optionally ``u_z_standard_deviation_nm``, the standard deviation of the real part and of the imaginary part, or of the
  magnitude;
- ``voltage_V``, unless the unit of the motion ends in ``_per_V`` (per volt of the source, peak).

Lines that begin with # are comments.

The time convention is exp(+i omega t) with peak amplitudes.
"""

from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from studies.lab.column_heads import ACCELERATIONS, DISPLACEMENTS, FREQUENCIES, PHASES, POSITIONS, VELOCITIES, VOLTAGES
from studies.lab.csv_columns import CsvColumns, above_zero, csv_text, written
from studies.refusal import SceneError, refuse_if

COMPONENTS = ("u_x", "u_y", "u_z")
# units by motion; each is the derivative by time of the one before, i omega times its complex amplitude
MOTIONS = {"displacement": DISPLACEMENTS, "velocity": VELOCITIES, "acceleration": ACCELERATIONS}
LETTERS = dict(zip("uva", MOTIONS, strict=True))  # that heads of columns begin with
HEADS = tuple(f"{letter}_{axis}" for letter in LETTERS for axis in "xyz")
SAME_FREQUENCY = 1e-6  # relative difference of a spectral line and the drive


@dataclass(frozen=True, kw_only=True)
class Scan:
    """Motion of the surface at several positions or frequencies. All arrays have one length; units are SI."""

    name: str  # of the file
    component: str = "u_z"  # "u_x", "u_y" or "u_z"
    x: np.ndarray = field(repr=False)
    y: np.ndarray = field(repr=False)
    # complex amplitudes or real magnitudes of the motion in SI units, or in these per V
    values: np.ndarray = field(repr=False)
    frequency: np.ndarray | None = field(default=None, repr=False)  # of each point; None: the drive frequency
    # standard deviation of the real part and of the imaginary part, or of the magnitude
    deviation: np.ndarray | None = field(default=None, repr=False)
    per_volt: bool = True  # values are per volt of the source
    voltage: float | None = None  # peak, of the source, if the values are not per volt and the file states it
    motion: str = "displacement"  # one of MOTIONS
    # relative difference up to which frequencies are equal: what the digits of the file leave open
    resolution: float = SAME_FREQUENCY
    remarks: tuple[str, ...] = ()  # on the reading of the file, for the user

    @property
    def is_complex(self) -> bool:
        """True if the phase was measured."""
        return bool(np.iscomplexobj(self.values))

    @property
    def kind(self) -> str:
        """The varying coordinate: "frequency", "x", "y" or "x, y"."""
        if self.frequency is not None and np.ptp(self.frequency) > 0.0:
            return "frequency"
        return ", ".join(name for name in "xy" if np.ptp(getattr(self, name)) > 0.0) or "x"

    @property
    def coordinate(self) -> np.ndarray:
        """The varying coordinate: frequency in Hz or position in m. For a scan of an area it is x."""
        if self.frequency is not None and self.kind == "frequency":
            return self.frequency
        return self.y if self.kind == "y" else self.x

    def as_displacement(self, drive_frequency: float) -> "Scan":
        """Return the scan as displacements; ``drive_frequency`` in Hz is used if the scan has no frequencies."""
        order = list(MOTIONS).index(self.motion)
        if order == 0:
            return self
        omega = 2.0 * np.pi * (drive_frequency if self.frequency is None else self.frequency)
        factor = (1j * omega) ** -order if self.is_complex else omega ** -float(order)
        deviation = None if self.deviation is None else self.deviation / omega**order
        return replace(self, values=self.values * factor, deviation=deviation, motion="displacement")

    def at_line(self, frequency: float, option: str = "--measured") -> "Scan":
        """Return the spectral line of a scan over positions and frequencies that lies at a frequency in Hz.

        A scan over positions alone, or over frequencies at one position, is returned as it is.

        Raises
        ------
        SceneError
            If no line lies at the frequency.
        """
        if self.frequency is None or self.kind != "frequency" or not any(map(_varies, (self.x, self.y))):
            return self
        lines = np.unique(self.frequency)
        line = float(lines[np.argmin(np.abs(lines - frequency))])
        if abs(line / frequency - 1.0) > self.resolution:
            nearest = np.sort(lines[np.argsort(np.abs(lines - frequency))[:2]])
            got = " and ".join(f"{each:.9g}" for each in nearest)
            rule = f"has no spectral line at the drive's {frequency:.9g} Hz; the nearest are at {got} Hz"
            raise self._refused(option, rule)
        at = self.frequency == line
        rule = f"{self.name!r} holds several values for one position at {line:.9g} Hz"
        refuse_if(
            len(set(zip(self.x[at].tolist(), self.y[at].tolist(), strict=True))) < np.count_nonzero(at),
            option,
            f"{rule}: are its frequencies rounded?",
        )
        taken = f"of {len(lines)} spectral lines that at {line:.9g} Hz is taken"
        return replace(
            self, x=self.x[at], y=self.y[at], values=self.values[at], frequency=self.frequency[at],
            deviation=None if self.deviation is None else self.deviation[at], remarks=(*self.remarks, taken),
        )  # fmt: skip

    def per_volt_of_source(self, option: str = "--measured") -> "Scan":
        """Return the scan per volt of the source; SceneError if its voltage is unknown or not positive."""
        if self.per_volt:
            return self
        if self.voltage is None or not self.voltage > 0.0:
            raise self._refused(option, "holds motions at an unknown voltage: add a column voltage_V, or units _per_V")
        deviation = None if self.deviation is None else self.deviation / self.voltage
        return replace(self, values=self.values / self.voltage, deviation=deviation, per_volt=True)

    def _refused(self, option: str, rule: str) -> SceneError:
        return SceneError(option, f"{self.name!r} {rule}")

    def without_rest(self, option: str = "--measured") -> "Scan":
        """Return the scan without its points at 0 Hz, where no wave is driven and velocities have no displacement."""
        if self.frequency is None or np.all(self.frequency > 0.0):
            return self
        kept = above_zero(self.frequency, partial(self._refused, option))
        return replace(
            self, x=self.x[kept], y=self.y[kept], values=self.values[kept], frequency=self.frequency[kept],
            deviation=None if self.deviation is None else self.deviation[kept],
            remarks=(*self.remarks, "the points at 0 Hz are left out"),
        )  # fmt: skip

    def flat(self) -> np.ndarray:
        """Return the values as a real array: real parts followed by imaginary parts, or magnitudes."""
        return np.concatenate([self.values.real, self.values.imag]) if self.is_complex else self.values


def motions(names: list[str]) -> list[str]:
    """Return the motions among the names of columns, such as ``u_z``; a file with one is a scan."""
    return sorted({each for each in HEADS for name in names if name.startswith(f"{each}_")})


def _varies(values: np.ndarray) -> bool:
    return bool(np.ptp(values) > 0.0)


def scan_of_columns(columns: CsvColumns) -> Scan:
    """Return the scan from columns with `motions`; raise SceneError for a missing column or a wrong unit."""
    noun, *others = motions(columns.names)
    columns.refuse_if(others, f"must hold one motion, such as u_z, got {', '.join([noun, *others])}")
    motion, component = LETTERS[noun[0]], "u" + noun[1:]
    base = MOTIONS[motion]
    units = base | {f"{unit}_per_V": factor for unit, factor in base.items()}
    x, y = (columns.column(name, POSITIONS) for name in "xy")
    frequency = columns.column("frequency", FREQUENCIES)
    columns.refuse_if(
        x is None and y is None and frequency is None,
        f"must have a column x_UNIT, y_UNIT or frequency_UNIT, got {', '.join(columns.names)}",
    )
    values, unit = _values(columns, noun, units)
    deviation = columns.column(f"{noun}_standard_deviation", units)
    columns.refuse_if(
        deviation is not None and deviation[1].endswith("_per_V") != unit.endswith("_per_V"),
        f"must state {noun} and its standard deviation both per volt, or none of them",
    )
    columns.refuse_signs(f"{noun}_standard_deviation", units, zero=False)
    voltage = columns.column("voltage", VOLTAGES)
    if voltage is not None and np.ptp(voltage[0]) > 0.0:
        raise columns.error(
            f"must hold one voltage, got {np.min(voltage[0]):g} to {np.max(voltage[0]):g} V in voltage_{voltage[1]}"
        )
    columns.refuse_signs("voltage", VOLTAGES, zero=False)
    columns.refuse_signs("frequency", FREQUENCIES, zero=True)
    zeros = np.zeros(len(columns.rows))
    # without a column, the position is that of the slider or of the middle of the stator, which the scene states
    unknown = zeros * np.nan
    return Scan(
        name=columns.path.name, component=component, x=unknown if x is None else x[0],
        y=(zeros if x is not None else unknown) if y is None else y[0],
        frequency=None if frequency is None else frequency[0], values=values,
        deviation=None if deviation is None else deviation[0], per_volt=unit.endswith("_per_V"),
        voltage=None if voltage is None else float(voltage[0][0]), motion=motion,
    )  # fmt: skip


def _values(columns: CsvColumns, noun: str, units) -> tuple[np.ndarray, str]:
    """Return the motion as complex amplitudes or magnitudes, and its unit."""
    real, imaginary = (columns.column(f"{noun}_{part}", units) for part in ("real", "imag"))
    magnitude, phase = columns.column(f"{noun}_magnitude", units), columns.column(f"{noun}_phase", PHASES)
    missing = "imag" if imaginary is None else "real"
    columns.refuse_if(
        (real is None) != (imaginary is None), f"must have a column {noun}_{missing}_UNIT beside the other part"
    )
    if real is not None and imaginary is not None:
        columns.refuse_if(magnitude is not None, f"must hold {noun} once, as complex parts or as a magnitude")
        units_got = f"{written(real[1])} and {written(imaginary[1])}"
        columns.refuse_if(real[1] != imaginary[1], f"must have one unit for {noun}, got {units_got}")
        return real[0] + 1j * imaginary[0], real[1]
    if magnitude is None:
        wanted = f"{noun}_real_UNIT with {noun}_imag_UNIT, or {noun}_magnitude_UNIT"
        raise columns.lacking(wanted)
    columns.refuse_signs(f"{noun}_magnitude", units, zero=True)
    return (magnitude[0] if phase is None else magnitude[0] * np.exp(1j * phase[0])), magnitude[1]


def scan_csv(scan: Scan, remarks: tuple[str, ...] = ()) -> str:
    """Return a scan as CSV. `scan_of_columns` reads exactly the same numbers from it."""
    unit = next(iter(MOTIONS[scan.motion])) + ("_per_V" if scan.per_volt else "")  # the first one is of SI
    noun = {motion: letter for letter, motion in LETTERS.items()}[scan.motion] + scan.component[1:]
    columns = {}
    if scan.frequency is not None:
        columns["frequency_Hz"] = scan.frequency
    columns |= {"x_m": scan.x, "y_m": scan.y}
    if scan.is_complex:
        columns |= {f"{noun}_real_{unit}": scan.values.real, f"{noun}_imag_{unit}": scan.values.imag}
    else:
        columns[f"{noun}_magnitude_{unit}"] = scan.values
    if scan.deviation is not None:
        columns[f"{noun}_standard_deviation_{unit}"] = scan.deviation
    if scan.voltage is not None:
        columns["voltage_V"] = np.full(len(scan.x), scan.voltage)
    return csv_text(columns, remarks)
