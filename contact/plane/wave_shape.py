r"""Shape of a burst in the plane: a complex factor over time on the waves of each frequency.

    u = Re sum_j e_j(t) U_j exp(i omega_j t),      e_j = a_j exp(i p_j),

amplitude and phase linear between knots, as of `contact.Envelope`. A phase that grows at the rate p' is a frequency
that is p'/2 pi higher.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from contact.envelope import Envelope
from contact.exceptions import InputError
from contact.plane.plane_equations import Knots
from contact.plane.plane_waves import SurfaceWaves

# Change of a factor between two stops of the averaged motion, in which its frequency counts ten times as much
PART, FREQUENCY = 0.25, 10.0

Shape = Envelope | Mapping[float, Envelope]


@dataclass(frozen=True, kw_only=True, eq=False)
class WaveShape:
    """Factors on the waves of w frequencies from the start of a burst until the surface is at rest.

    Attributes
    ----------
    time : (k,) array
        Knots, s, rising.
    amplitude, phase : (w, k) array
        Factor and phase advance in rad.
    duration, end : float
        Length of the burst, and time at which the surface comes to rest, s.
    omega : float
        Angular frequency of the fastest wave, rad/s.
    """

    time: np.ndarray
    amplitude: np.ndarray
    phase: np.ndarray
    duration: float
    end: float
    omega: float

    @classmethod
    def of(
        cls, waves: SurfaceWaves, duration: float, envelope: Shape | None, ring_down: Shape | None
    ) -> "WaveShape | None":
        """Return the shape of a burst in s on waves; None without an envelope.

        ``envelope``, ``ring_down``: of all waves, or by frequency in Hz; the time of the second is counted from the end
        of the burst. From the one to the other the factor passes within half a period.
        """
        if envelope is None:
            if ring_down is not None:
                raise InputError("ring_down", "needs an envelope")
            return None
        during, stop = _of_each(waves, "envelope", envelope), duration
        fading: tuple[Envelope, ...] = ()
        if ring_down is not None:
            fading = _of_each(waves, "ring_down", ring_down)
            stop = duration - min(0.5 * 2.0 * math.pi / waves.omega, 0.5 * duration)
        time = np.unique(np.concatenate([np.clip(each.time, 0.0, stop) for each in during] + [[0.0, stop]]))
        amplitude = [np.interp(time, each.time, each.amplitude) for each in during]
        phase = [np.interp(time, each.time, each.phase) for each in during]
        if fading:
            later = np.unique(np.concatenate([each.time for each in fading]))
            amplitude = [
                np.append(a, np.interp(later, b.time, b.amplitude)) for a, b in zip(amplitude, fading, strict=True)
            ]
            phase = [
                np.append(a, _near(a[-1], np.interp(later, b.time, b.phase)))
                for a, b in zip(phase, fading, strict=True)
            ]
            time = np.append(time, duration + later)
        return cls(
            time=time, amplitude=np.array(amplitude), phase=np.array(phase), duration=duration,
            end=max(float(time[-1]), duration), omega=waves.omega,
        )  # fmt: skip

    @property
    def knots(self) -> Knots:
        """The table for the kernels, whose phase is that of the fastest wave."""
        return Knots(self.omega * self.time, np.ascontiguousarray(self.amplitude), np.ascontiguousarray(self.phase))

    def corners(self, change: float) -> np.ndarray:
        """Return the times at which the rate of a factor over omega changes by more than ``change``, s."""
        if self.time.size < 3:
            return np.zeros(0)
        width = self.omega * np.diff(self.time)
        turns = np.maximum(self.amplitude[:, :-1], self.amplitude[:, 1:]) * np.diff(self.phase, axis=1)
        bends = [np.abs(np.diff(each / width, axis=1)).max(axis=0) for each in (np.diff(self.amplitude, axis=1), turns)]
        return self.time[1:-1][np.maximum(*bends) > change]

    def parts(self, begin: float, end: float) -> np.ndarray:
        """Return times from `begin` to `end`, s, between which no factor changes much."""
        change = np.abs(np.diff(self.amplitude, axis=1))
        shifts = np.diff(self.phase, axis=1) / (self.omega * np.diff(self.time))
        change[:, 1:] += FREQUENCY * np.abs(np.diff(shifts, axis=1))
        way = np.append(0.0, np.cumsum(change.max(axis=0)))
        first, last = np.interp([begin, end], self.time, way)
        count = max(1, math.ceil((last - first) / PART))
        rising = way + np.linspace(0.0, 1e-9 * (1.0 + way[-1]), way.size)  # where a factor stands still too
        low, high = np.interp([begin, end], self.time, rising)
        inner = np.interp(np.linspace(low, high, count + 1)[1:-1], rising, self.time)
        return np.concatenate([[begin], inner[(inner > begin) & (inner < end)], [end]])

    def factors(self, t: float) -> np.ndarray:
        """Return the complex factors (w,) at a time in s, up to `end`."""
        amplitude, phase = (
            np.array([np.interp(t, self.time, row) for row in rows]) for rows in (self.amplitude, self.phase)
        )
        return amplitude * np.exp(1j * phase)

    def shifts(self, t: float) -> np.ndarray:
        """Return by how much the frequency of each wave is higher at a time, Hz."""
        k = min(max(int(np.searchsorted(self.time, t, side="right")) - 1, 0), self.time.size - 2)
        if self.time.size < 2 or not self.time[0] <= t <= self.time[-1]:
            return np.zeros(len(self.phase))
        return np.diff(self.phase[:, k : k + 2], axis=1)[:, 0] / (2.0 * math.pi * (self.time[k + 1] - self.time[k]))

    def on(self, waves: SurfaceWaves, t: float, after: bool) -> SurfaceWaves:
        """Return the waves at a time, with frequencies that are all changed as the mean one is; see `spread`.

        ``after``: True after the burst.
        """
        if after and t >= self.end:
            return waves.scaled(0.0)
        shift = float(np.mean(self.shifts(t) / waves.frequencies))
        changed = replace(waves, amplitudes=waves.amplitudes * self.factors(t)[:, None, None])
        return changed if shift == 0.0 else replace(changed, frequencies=waves.frequencies * (1.0 + shift))

    def spread(self, waves: SurfaceWaves) -> float:
        """Return how far the relative shifts of the frequencies differ from their mean, at most."""
        rates = np.diff(self.phase, axis=1) / np.diff(self.time) / (2.0 * math.pi) / waves.frequencies[:, None]
        return float(np.ptp(rates, axis=0).max(initial=0.0))

    @property
    def root_mean_square(self) -> np.ndarray:
        """Root mean square of the factor of each frequency over the burst, (w,)."""
        at = np.union1d(self.time[self.time < self.duration], [0.0, self.duration])
        rows = np.array([np.interp(at, self.time, row) for row in self.amplitude])
        a, b = rows[:, :-1], rows[:, 1:]
        return np.sqrt(((a * a + a * b + b * b) * np.diff(at)).sum(axis=1) / (3.0 * self.duration))


def _near(last: float, phase: np.ndarray) -> np.ndarray:
    """Return phases plus the whole turns with which their first one is nearest to the last one before."""
    return phase + 2.0 * math.pi * round((last - phase[0]) / (2.0 * math.pi))


def _of_each(waves: SurfaceWaves, name: str, shape: Shape) -> tuple[Envelope, ...]:
    """Return the envelope of each frequency."""
    if isinstance(shape, Envelope):
        return (shape,) * len(waves.frequencies)
    lacking = [float(each) for each in waves.frequencies if float(each) not in shape]
    if lacking:
        raise InputError(name, "must have an Envelope for each frequency of the waves, Hz; lacking", lacking)
    return tuple(shape[float(each)] for each in waves.frequencies)
