"""The free numbers of a fit: keys of a scene with their ranges, positive ones as logarithms.

Some of them are no keys of a scene.  ``amplitude_per_volt`` (m/V) converts the voltages of a measurement to amplitudes
of a [wave]; ``amplitude_factor`` multiplies the surface motion computed for a stator.  Four belong to instruments:
``wave_velocity_factor`` multiplies the surface wave's velocity in a vibrometer's scan, ``bandwidth`` is that of an
encoder (a low-pass filter of first order), ``sampling`` the time over which each of its readings is averaged, and
``time_offset`` the time of its trace at which the burst begins.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from studies.lab.measurement import Measurement
from studies.lab.measurement_csv import measured_network, read_measured
from studies.record.prefixes import scaled_unit
from studies.refusal import SceneError, all_answers, misread, nearest, refuse_if, suggestion
from studies.scene import Scene
from studies.scene.block import keys_of
from studies.scene.keys import LEVELS, rule_at, unit_of
from studies.scene.numbers import Quantity
from studies.scene.override import parts_of, toml_value
from studies.scene.rule import Count

AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT, SYSTEMATIC = "amplitude_factor", "amplitude_per_volt", "systematic"
WAVE_VELOCITY_FACTOR, BANDWIDTH = "wave_velocity_factor", "bandwidth"
SAMPLING, TIME_OFFSET = "sampling", "time_offset"
PORT = "port"  # of a network analyser's file, counted from 1; no number of the motor
OWN = {
    AMPLITUDE_FACTOR: Quantity(), AMPLITUDE_PER_VOLT: Quantity("m"), SYSTEMATIC: Quantity(),
    WAVE_VELOCITY_FACTOR: Quantity(), BANDWIDTH: Quantity("Hz"), SAMPLING: Quantity("s"),
    TIME_OFFSET: Quantity("s", negative=True),
}  # fmt: skip
FREE = tuple(name for name in OWN if name != SYSTEMATIC)


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A number of a fit or a design with its range, in SI units; a count if the ends are integers.

    Attributes
    ----------
    key : str
        Of the scene, its lists numbered from 0; or one of this module's ``OWN``. Also ``name``.
    low, high : float
        Ends of the range. Also ``min`` and ``max``.
    value : float or None
        Start of the search (by default the scene's own value), or the estimate.
    vary : bool
        False: the number is held at its value.
    stderr : float or None
        Standard error of an estimate; None where the data do not determine it.
    """

    key: str
    low: float
    high: float
    value: float | None = None
    vary: bool = True
    stderr: float | None = None

    name = property(lambda self: self.key, doc="The key.")
    min = property(lambda self: self.low, doc="Lower end of the range.")
    max = property(lambda self: self.high, doc="Upper end of the range.")

    @property
    def unit(self) -> str:
        """SI unit; empty for a pure number."""
        if self.key not in OWN and "." not in self.key:
            return ""  # a name of lmfit's, in expressions
        return unit_of(OWN.get(self.key) or rule_at(self.key)) or ""

    @property
    def logarithmic(self) -> bool:
        """True if the solvers work with its logarithm."""
        return self.low > 0.0

    @property
    def counted(self) -> bool:
        """True if its values are integers."""
        return isinstance(self.low, int)

    def at(self, share: float) -> float:
        """Return the value at a share of the range, 0 to 1."""
        share = min(max(float(share), 0.0), 1.0)
        if self.counted:
            return min(self.low + int(share * (self.high - self.low + 1)), self.high)
        low, high = self.inner(self.low), self.inner(self.high)
        return self.outer(low + share * (high - low))

    def share(self, value: float) -> float:
        """Return the share of the range, 0 to 1, at a value: the inverse of `at`."""
        if self.counted:
            return (value - self.low + 0.5) / (self.high - self.low + 1)
        low, high = self.inner(self.low), self.inner(self.high)
        return (self.inner(value) - low) / (high - low)

    def text(self, value: float, digits: int = 4) -> str:
        """Return a value with a unit that suits its size.

        Examples
        --------
        >>> Parameter(key="slider.mass", low=1e-5, high=1e-3).text(3e-5)
        '30 mg'
        """
        factor, unit = scaled_unit(value, self.unit)
        return f"{value * factor:.{digits}g} {unit}".rstrip()

    def end_reached(self, value: float, within: float) -> str | None:
        """Return "lower" or "upper" for a value at an end, or a fraction ``within`` of the range from it; else None."""
        if self.counted:
            return {self.high: "upper", self.low: "lower"}.get(value)
        share = self.share(value)
        return "lower" if share < within else "upper" if share > 1.0 - within else None

    def end_in_words(self, value: float, within: float) -> list[str]:
        """Return the remark that a best value lies at an end of the range; nothing where it does not."""
        side = self.end_reached(value, within)
        where = f"at the {side} end of its range, {self.text(value)}"
        return [] if side is None else [f"{self.key} is best {where}: a wider range may hold a better value"]

    def inner(self, value: float) -> float:
        """Return the solvers' variable x at a value."""
        return math.log(value) if self.logarithmic else value

    def outer(self, x: float) -> float:
        """Return the value at a variable x of the solvers, cut to the range."""
        value = math.exp(x) if self.logarithmic else float(x)
        return min(max(value, self.low), self.high)

    def start(self, value: float | None) -> float:
        """Return the start of a search as x: a value within the range, or the middle of the range."""
        if value is not None and self.low < value < self.high:
            return self.inner(value)
        return 0.5 * (self.inner(self.low) + self.inner(self.high))


def read_parameter(text: str | Parameter, option: str = "parameters", *, design: bool = False) -> Parameter:
    """Read ``KEY=LOW:HIGH``; of a ``design`` also voltage, amplitude and counts.  A parameter is returned as it is.

    Raises
    ------
    SceneError
        If the key is no number of a scene, or the range is wrong.

    Examples
    --------
    >>> read_parameter("slider.preload=1 mN:5 mN")
    Parameter(key='slider.preload', low=0.001, high=0.005, value=None, vary=True, stderr=None)
    """
    parameter = text if isinstance(text, Parameter) else _parsed(text, option, design=design)
    low, high = parameter.low, parameter.high
    refuse_if(
        parameter.vary and not -math.inf < low < high < math.inf,
        f"{option} {parameter.key}",
        f"must have LOW below HIGH, got {low:g} and {high:g} {parameter.unit}".rstrip(),
    )
    return parameter


def _parsed(text: str, option: str, *, design: bool) -> Parameter:
    low: float
    high: float
    if not isinstance(text, str):
        raise misread(option, "KEY=LOW:HIGH or a Parameter", text)
    key, span = parts_of(option, text, "KEY=LOW:HIGH")
    ends = [end.strip() for end in span.split(":")]
    if len(ends) != 2:
        raise misread(option, "KEY=LOW:HIGH", text)
    refuse_if(key in LEVELS and not design, f"{option} {key}", "follows from each measured point and cannot be free")
    refuse_if(key == SYSTEMATIC, f"{option} {key}", "belongs to a measurement, as in FILE.csv systematic=0.02")
    if design and "." in key and isinstance(rule_at(key), Count):
        if not all(end.isdigit() for end in ends):
            raise misread(f"{option} {key}", "LOW:HIGH of whole numbers", span)
        low, high = (int(end) for end in ends)
    else:
        low, high = (_number(option, key, end, known=() if design else FREE) for end in ends)
    return Parameter(key=key, low=low, high=high)


def as_parameters(parameters: Any) -> tuple[Parameter, ...]:
    """Return the parameters of a fit from any of the forms in which a user may write them.

    Parameters
    ----------
    parameters : list, dict or lmfit.Parameters
        `Parameter` objects or texts ``"slider.preload=1 mN:5 mN"``; a dict of a key's range, (low, high) in SI units or
        with units, or ``"1 mN:5 mN"``; or lmfit's, in whose names ``__`` stands for a dot. Those with an expression
        are left out: they are no free numbers (`studies.inverse.ties`).

    Examples
    --------
    >>> [each.max for each in as_parameters({"slider.preload": "1 mN:5 mN", "slider.mass": (1e-5, 1e-3)})]
    [0.005, 0.001]
    """
    if hasattr(parameters, "valuesdict"):
        own = (
            Parameter(
                key=key_of(each.name), low=float(each.min), high=float(each.max), value=float(each.value),
                vary=bool(each.vary),
            )
            for each in parameters.values()
            if not each.expr
        )  # fmt: skip
        return tuple(all_answers(partial(read_parameter, each) for each in own))
    return tuple(all_answers(partial(read_parameter, each) for each in ranges(parameters)))


def key_of(name: str) -> str:
    """Return the key of a name of lmfit's, in which ``__`` stands for a dot."""
    return name.replace("__", ".")


def ranges(parameters: Sequence | Parameter | dict) -> list:
    """Return a list of parameters or their texts, from one, such a list or a dict of a key's range.

    Examples
    --------
    >>> ranges({"slider.preload": ("1 mN", "5 mN"), "slider.mass": (1e-5, 1e-3)})
    ['slider.preload=1 mN:5 mN', 'slider.mass=1e-05:0.001']
    """
    refuse_if(
        hasattr(parameters, "valuesdict"),
        "variables",
        "must be KEY=LOW:HIGH or a dict of ranges; lmfit's parameters belong to studies.fit",
    )
    if not isinstance(parameters, dict):
        return [parameters] if isinstance(parameters, (str, Parameter)) else list(parameters)
    return [
        f"{key}={':'.join(map(str, span)) if isinstance(span, (tuple, list, np.ndarray)) else span}"
        for key, span in parameters.items()
    ]


def as_measurements(measurements: Any) -> list[Measurement]:
    """Return measurements: `Measurement` objects or paths of CSV files, one or a list."""
    several = measurements if isinstance(measurements, (list, tuple)) else [measurements]
    return all_answers(partial(read_measurement, each) for each in several)


def read_measurement(path: str | Path | Measurement, settings: tuple[str, ...] = ()) -> Measurement:
    """Read a CSV file and the keys ``KEY=VALUE`` that hold for it alone; a measurement is returned as it is.

    ``systematic=0.02`` is a common error of 2 %; ``port=2`` takes one port of a network analyser's file of several.

    Raises
    ------
    SceneError
        If the file cannot be read or is no measurement, or a setting is wrong.
    """
    if isinstance(path, Measurement):
        return path
    refuse_if("=" in str(path), "measurements", f"must begin with a file: FILE.csv KEY=VALUE ..., got {str(path)!r}")
    pairs = [parts_of("measurements", text, "FILE.csv KEY=VALUE ...") for text in settings]
    ports = [value for key, value in pairs if key == PORT]
    fixed = dict(_setting(key, value) for key, value in pairs if key != PORT)
    systematic = float(str(fixed.pop(SYSTEMATIC, 0.0)))
    measured = read_measured(path, "measurements")
    if ports:
        if measured.network is None or not ports[-1].isdigit():
            rule = f"port={ports[-1]} must be the number of a port, and the file that of a network analyser"
            raise SceneError(f"measurements {measured.name}", rule)
        measured = measured_network(measured.network.one_port(int(ports[-1]), f"measurements {measured.name}"))
    return replace(measured, systematic=systematic, settings=fixed)


def _setting(key: str, value: str) -> tuple[str, object]:
    """Read a key and a value of a measurement, the value as in a scene file."""
    return key, _number("measurements", key, value) if key in OWN else rule_at(key).read(key, toml_value(value))


def _number(option: str, key: str, text: str, known: Iterable[str] = OWN) -> float:
    """Read a number of a key of the scene, or of a ``known`` name, in SI units."""
    if "." not in key and key not in known:
        blocks = [(block, kind) for block, each in keys_of(Scene).items() for kind in getattr(each.rule, "kinds", ())]
        of_blocks = {name: f"{block}.{name}" for block, kind in blocks for name in keys_of(kind)}
        meant = suggestion(key, known) or of_blocks.get(suggestion(key, of_blocks) or "")
        hint = nearest(key, known) if meant is None else f"; did you mean {meant}?"
        raise SceneError(f"{option} {key}", f"is no key of a scene{hint}")
    rule = (OWN.get(key) or rule_at(key)).number
    value = rule.read(key, toml_value(text)) if isinstance(rule, Quantity) else None
    if isinstance(value, bool) or not isinstance(value, float):
        raise misread(f"{option} {key}", "a number of a scene, such as a length", text)
    return value
