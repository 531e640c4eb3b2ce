"""Amplitude and phase of the wave during a burst: ring-up and decay of the stator, or a modulated drive."""

from dataclasses import dataclass

import numpy as np

from contact import parameter_check
from contact.parameter_check import refuse_if


@dataclass(frozen=True, kw_only=True)
class Envelope:
    """Factor on the orbits, piecewise linear in time and constant before the first and after the last time.

    Attributes
    ----------
    time : (k,) array
        Time from the start of the burst, s, strictly increasing.
    amplitude : (k,) array
        Factor on the orbits, zero or positive.
    phase : (k,) array
        Phase advance of the wave, rad.
    """

    time: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray

    def __post_init__(self):
        for name in ("time", "amplitude", "phase"):
            values = np.array(getattr(self, name), float)
            values.setflags(write=False)
            object.__setattr__(self, name, values)
        refuse_if(
            self.time.ndim != 1 or self.time.size < 1 or not np.all(np.diff(self.time) > 0.0),
            "envelope.time",
            "must be a rising list of at least one instant in s",
        )
        for name in ("amplitude", "phase"):
            values = getattr(self, name)
            refuse_if(
                values.shape != self.time.shape or not np.all(np.isfinite(values)),
                f"envelope.{name}",
                "must be finite and as long as envelope.time",
                values,
            )
        parameter_check.non_negative("envelope.amplitude", float(self.amplitude.min()), "")

    def at(self, time: np.ndarray) -> np.ndarray:
        """Return the complex factor at times in s."""
        amplitude = np.interp(time, self.time, self.amplitude)
        return amplitude * np.exp(1j * np.interp(time, self.time, self.phase))

    def largest(self, duration: float) -> float:
        """Return the largest amplitude in the first `duration` seconds."""
        inside = self.time[(self.time > 0.0) & (self.time < duration)]
        return float(np.max(np.abs(self.at(np.array([0.0, *inside, duration])))))
