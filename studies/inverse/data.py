"""Measurements: what was measured, at which levels or instants, under which fixed settings, how well.

A file is CSV with the names of run.json: ``voltage_V`` or ``normal_amplitude_m`` with ``velocity_m_per_s`` is a
velocity curve; ``voltage_V`` with ``normal_amplitude_m`` and no velocity a calibration of the surface amplitude;
``time_s`` with ``velocity_m_per_s`` a burst.  ``velocity_standard_deviation_m_per_s`` and
``normal_amplitude_standard_deviation_m`` hold standard deviations.  ``_mm_per_s``, ``_nm`` and ``_ms`` serve as units
too.
"""

from dataclasses import dataclass, field
from pathlib import Path

from studies.inverse.parameters import SYSTEMATIC, read_setting
from studies.refusal import SceneError
from studies.report.measured import LENGTHS, SPEEDS, TIMES, VOLTAGES, MeasuredTable

OPTION = "--data"
# by quantity: unit, factor to the unit that is shown, its name
UNITS = {
    "velocity": ("m/s", 1e3, "mm/s"),
    "burst": ("m/s", 1e3, "mm/s"),
    "amplitude": ("m", 1e9, "nm"),
    "ring-down frequency": ("Hz", 1e-3, "kHz"),
}


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """Measured or imagined values of one quantity; arrays of one length, SI units.

    Attributes
    ----------
    name : str
        Of the file, or in words.
    quantity : str
        A key of ``UNITS``.
    level_key : str
        ``voltage_V`` or ``normal_amplitude_m``; empty where the scene's own level counts.
    levels : tuple of float
        V or m.
    time : tuple of float
        s from the start of a burst; empty for what is no burst.
    values : tuple of float
        Empty for a measurement that is only imagined.
    deviations : tuple of float or None
        Standard deviations; None where they are not known.
    systematic : float
        Relative standard deviation of one factor that all values of the measurement share.
    settings : dict
        Keys of the scene that hold for this measurement alone.
    """

    name: str
    quantity: str
    level_key: str = ""
    levels: tuple[float, ...] = ()
    time: tuple[float, ...] = ()
    values: tuple[float, ...] = ()
    deviations: tuple[float, ...] | None = None
    systematic: float = 0.0
    settings: dict = field(default_factory=dict)


def read_measurement(path: str | Path, settings: tuple[str, ...] = ()) -> Measurement:
    """Read a CSV file with its own fixed keys, ``KEY=VALUE``; ``systematic=0.02`` is a common error of 2 %.

    Raises
    ------
    SceneError
        If the file cannot be read or is no measurement, or a setting is wrong.
    """
    if "=" in str(path):
        raise SceneError(OPTION, f"must begin with a file: FILE.csv KEY=VALUE ..., got {str(path)!r}")
    fixed = dict(read_setting(text) for text in settings)
    table = MeasuredTable.read(path, OPTION)
    voltage, amplitude = table.column("voltage", VOLTAGES), table.column("normal_amplitude", LENGTHS)
    velocity, time = table.column("velocity", SPEEDS), table.column("time", TIMES)
    level_key = "voltage_V" if voltage is not None else "normal_amplitude_m" if amplitude is not None else ""
    levels = voltage or amplitude or ()
    if min((*levels, *(time or ())), default=0.0) < 0.0:
        raise SceneError(OPTION, f"{str(path)!r}: voltages, amplitudes and times must be zero or positive")
    if velocity is not None and time is not None:
        quantity, values = "burst", velocity
        if len(set(levels)) > 1:
            raise SceneError(OPTION, f"{str(path)!r} must hold one burst: one level, got {len(set(levels))}")
        levels = levels[:1]
        if list(time) != sorted(set(time)) or time[-1] == 0.0:
            raise SceneError(OPTION, f"{str(path)!r}: time must rise from point to point")
    elif velocity is not None and level_key:
        quantity, values = "velocity", velocity
    elif voltage is not None and amplitude is not None:
        quantity, values = "amplitude", amplitude
    else:
        wanted = "voltage_V or normal_amplitude_m with velocity_m_per_s, voltage_V with normal_amplitude_m, "
        wanted += "or time_s with velocity_m_per_s"
        raise SceneError(
            OPTION, f"{str(path)!r} must have the columns {wanted}; got {', '.join(table.names)}"
        )
    if quantity == "amplitude":
        deviations = table.deviation(("normal_amplitude_standard_deviation",), LENGTHS)
    else:
        deviations = table.deviation(("velocity_standard_deviation", "error"), SPEEDS)
    return Measurement(
        name=Path(path).name, quantity=quantity, level_key=level_key, levels=tuple(levels), time=time or (),
        values=values, deviations=deviations, systematic=float(fixed.pop(SYSTEMATIC, 0.0)), settings=fixed,
    )  # fmt: skip
