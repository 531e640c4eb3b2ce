"""The free numbers of a fit: keys of a scene with their ranges, positive ones as logarithms.

Some names stand for what is no key of a scene: ``amplitude_per_volt`` (m/V) turns the voltages of a measurement into
amplitudes of a given [wave]; ``amplitude_factor`` multiplies the surface motion computed for a stator.  Three belong
to instruments: ``wave_velocity_factor`` multiplies the surface wave's velocity in a vibrometer's scan,
``bandwidth`` is that of an encoder (a low-pass filter of first order), and ``time_offset`` the time of its trace at
which the burst begins.
"""

import math
from dataclasses import dataclass, replace
from pathlib import Path

from studies.record.measured import Measurement, read_measured
from studies.refusal import SceneError, nearest, shown
from studies.scene.keys import rule_at
from studies.scene.numbers import Quantity
from studies.scene.override import parts_of, toml_value
from studies.scene.rule import Count

AMPLITUDE_FACTOR, AMPLITUDE_PER_VOLT, SYSTEMATIC = "amplitude_factor", "amplitude_per_volt", "systematic"
WAVE_VELOCITY_FACTOR, BANDWIDTH, TIME_OFFSET = "wave_velocity_factor", "bandwidth", "time_offset"
OWN = {
    AMPLITUDE_FACTOR: Quantity(), AMPLITUDE_PER_VOLT: Quantity("m"), SYSTEMATIC: Quantity(),
    WAVE_VELOCITY_FACTOR: Quantity(), BANDWIDTH: Quantity("Hz"), TIME_OFFSET: Quantity("s", negative=True),
}  # fmt: skip
LEVELS = ("drive.voltage", "wave.normal_amplitude")


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A free number with its range, in SI units; with whole ends a count."""

    key: str  # of the scene, its lists numbered from 0; or one of this module's two names
    low: float
    high: float

    @property
    def logarithmic(self) -> bool:
        """Whether it is worked with as its logarithm."""
        return self.low > 0.0

    @property
    def counted(self) -> bool:
        """Whether it takes whole numbers alone."""
        return isinstance(self.low, int)

    def at(self, share: float) -> float:
        """Return the value at a share of the range, 0 to 1."""
        share = min(max(float(share), 0.0), 1.0)
        if self.counted:
            return min(self.low + int(share * (self.high - self.low + 1)), self.high)
        low, high = self.inner(self.low), self.inner(self.high)
        return self.outer(low + share * (high - low))

    def share(self, value: float) -> float:
        """Return the share of the range at which a value stands."""
        if self.counted:
            return (value - self.low + 0.5) / (self.high - self.low + 1)
        low, high = self.inner(self.low), self.inner(self.high)
        return (self.inner(value) - low) / (high - low)

    def inner(self, value: float) -> float:
        """Return what the solvers work with."""
        return math.log(value) if self.logarithmic else value

    def outer(self, x: float) -> float:
        """Return the value of what the solvers work with; at an end of the range that end itself."""
        value = math.exp(x) if self.logarithmic else float(x)
        return min(max(value, self.low), self.high)

    def start(self, value: float | None) -> float:
        """Return where a search begins: a value within the range, or its middle."""
        if value is not None and self.low < value < self.high:
            return self.inner(value)
        return 0.5 * (self.inner(self.low) + self.inner(self.high))


def read_parameter(text: str, option: str = "--free", *, design: bool = False) -> Parameter:
    """Read ``KEY=LOW:HIGH``; for a ``design`` voltage, amplitude and counts too.

    Raises
    ------
    SceneError
        If the key is no number of a scene, or the range is none.

    Examples
    --------
    >>> read_parameter("slider.preload=1 mN:5 mN")
    Parameter(key='slider.preload', low=0.001, high=0.005)
    """
    key, span = parts_of(option, text, "KEY=LOW:HIGH")
    ends = [end.strip() for end in span.split(":")]
    if len(ends) != 2:
        raise SceneError(option, f"must be KEY=LOW:HIGH, got {shown(text)}")
    if key in LEVELS and not design:
        raise SceneError(f"{option} {key}", "is given by the measurement, point by point, and cannot be free")
    if design and "." in key and isinstance(rule_at(key), Count):
        if not all(end.isdigit() for end in ends):
            raise SceneError(f"{option} {key}", f"must be LOW:HIGH of whole numbers, got {shown(span)}")
        low, high = map(int, ends)
    else:
        low, high = (_number(option, key, end) for end in ends)
    if not low < high:
        raise SceneError(f"{option} {key}", f"must have LOW below HIGH, got {low:g} and {high:g}")
    return Parameter(key=key, low=low, high=high)


def read_setting(text: str, option: str = "--data") -> tuple[str, object]:
    """Read ``KEY=VALUE``, what holds for one measurement; the value as in a scene file."""
    key, value = parts_of(option, text, "FILE.csv KEY=VALUE ...")
    if key in OWN:
        return key, _number(option, key, value)
    return key, rule_at(key).read(key, toml_value(value))


def read_measurement(path: str | Path, settings: tuple[str, ...] = ()) -> Measurement:
    """Read a CSV file with its own fixed keys, ``KEY=VALUE``; ``systematic=0.02`` is a common error of 2 %.

    Raises
    ------
    SceneError
        If the file cannot be read or is no measurement, or a setting is wrong.
    """
    if "=" in str(path):
        raise SceneError("--data", f"must begin with a file: FILE.csv KEY=VALUE ..., got {str(path)!r}")
    fixed = dict(read_setting(text) for text in settings)
    systematic = float(fixed.pop(SYSTEMATIC, 0.0))
    return replace(read_measured(path, "--data"), systematic=systematic, settings=fixed)


def _number(option: str, key: str, text: str) -> float:
    if "." not in key and key not in OWN:
        raise SceneError(f"{option} {key}", f"is no key of a scene{nearest(key, OWN)}")
    rule = (OWN.get(key) or rule_at(key)).number
    value = rule.read(key, toml_value(text)) if isinstance(rule, Quantity) else None
    if isinstance(value, bool) or not isinstance(value, float):
        raise SceneError(
            f"{option} {key}", f"must be a number of a scene, such as a length, got {shown(text)}"
        )
    return value
