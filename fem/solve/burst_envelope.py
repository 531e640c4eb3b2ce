"""Ring-up and ring-down of the surface during and after a burst: complex envelope over time, from a frequency band.

The source's voltage is cos(omega0 t) from 0 to the burst's end and zero otherwise.  The surface moves as
Re(U(t) exp(i omega0 t)), where the burst is a voltage that is switched on at 0 minus one that is switched on at its
end,

    U(t) = S(t, 0) - S(t - duration, omega0 duration).                                                      (1)

S(t, phase) is the envelope, relative to exp(i omega0 t + i phase), of the response to cos(omega0 t + phase) for t > 0.
This voltage has the spectrum [exp(i phase) / (i x) + exp(-i phase) / (i (x + 2 omega0))] / 2 with x = omega - omega0.
With the response H(f) per volt, a window G and x = 2 pi (f_k - f0), the inverse transform over positive frequencies, as
a sum over f_k with step df, is

    S(t, phase) = sum_k G_k H_k df [ (exp(i x t) - exp(-i x a)) / (i x)
                                     + exp(i x t - 2 i phase) / (i (x + 2 omega0)) ].                       (2)

The second term, the counter-rotating half of the voltage, matters close to the switch.  The constant exp(-i x a) makes
the first term vanish at t = -a, before which the motion is taken as zero; at x = 0 this term is t + a.  S tends to
H(f0), and f0 is one of the frequencies.

A burst may have a shape: a factor a(t) on the voltage, with amplitude and phase.  It is a sum of steps da,

    U(t) = a(0) S(t, 0) + sum da(t') S(t - t') - a(duration) S(t - duration, omega0 duration),                 (3)

at instants much closer than 1 / width of the band.  The sum has no counter-rotating half: its steps are gradual.

Two truncations cause errors.
Band: the window G falls smoothly to zero at the band's ends, which rounds corners over a time of 1 / width and lets a
small part of the motion precede its cause.  A band half as wide doubles that error, so the difference measures it.
Time: a frequency step df aliases whatever rings longer than 1 / df to the beginning; df is halved until this no longer
matters.  The error is measured with every second frequency, and at frequencies between the steps, where the transform
of S back to frequencies must reproduce the response.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Protocol

import numpy as np

from fem.circuit import Drive
from fem.discretize.mesh_refinement import refine
from fem.exceptions import ConvergenceError
from fem.parameters import positive
from fem.results.driven_answer import SurfaceWave
from fem.solve.band_solution import refuse_outside

FLAT = 0.5  # G = 1 up to this fraction of the distance from the drive's frequency to either end of the band
NARROWER = 0.5  # width of the narrower band that shows the error, over the width of the band
PROBES = 6  # frequencies between the steps where the response is checked
GOLDEN = 0.6180339887498949  # spreads the probes evenly between two steps
LEAD = 0.125  # the time -a before the switch, over 1 / df
FIRST_FREQUENCIES, MAX_FREQUENCIES = 32, 4096  # approximate numbers of frequencies in the band
PER_BAND = 4  # instants of the envelope per 1 / width of the band
# Instants of equation (3) for each of those.  At the largest turn of the phase within the flat band, a quarter of its
# width, an instant turns it by 0.1 rad, and a step at its middle is off by 0.1^2/24.
FINER = 4


class Response(Protocol):
    """The surface's motion at any frequency of a range in Hz, for instance `fem.Band`."""

    limits: tuple[float, float]

    def waves(self, frequencies, drive: str | Drive) -> list[SurfaceWave]:
        """Surface motion at frequencies in Hz, in their order."""


@dataclass(frozen=True, kw_only=True)
class BurstEnvelope:
    """Motion of one point of the surface during a burst and after it, per volt of the source (peak).

    Attributes
    ----------
    position : float
        m from the left end.
    frequency : float
        Hz, of the drive.
    duration : float
        Of the burst, s.
    time : ndarray, shape (k,)
        s from the beginning of the burst, increasing; fine where the motion changes, without a long burst's middle.
    normal, tangential : ndarray, shape (k,)
        Complex envelopes of u_z and u_x, m per V.
    steady_normal, steady_tangential : complex
        Motion under continuous drive, m per V.
    settling : float
        From the burst's beginning until u_z stays within 1 % of the steady state, s.
    early : float
        Largest |u_z| before the burst over the steady one, an artefact of the band's finite width.
    band_error, step_error, response_error : float
        Relative to the steady envelope: largest change with a narrower band; with wider frequency steps or at
        frequencies between them; error of the response itself.
    frequencies : int
        Number of frequencies solved.
    lasting : callable
        ``lasting(duration)`` is the `BurstEnvelope` of a burst of another duration in s from the same solutions;
        ``share`` below 1 uses that share of the band, to show the effect of the band's width on an answer; ``shape``
        is the complex factor on the voltage as a function of the times of an array, in s from the beginning.
    mean_error : float
        Of u_z over the time of the burst, relative to the steady envelope: by the band, and by the other two errors
        where the motion is not the steady one times the shape.
    """

    position: float
    frequency: float
    duration: float
    time: np.ndarray = field(repr=False)
    normal: np.ndarray = field(repr=False)
    tangential: np.ndarray = field(repr=False)
    steady_normal: complex
    steady_tangential: complex
    settling: float
    early: float
    band_error: float
    step_error: float
    response_error: float
    frequencies: int
    lasting: Callable[..., "BurstEnvelope"] = field(repr=False)
    mean_error: float

    @property
    def relative_error(self) -> float:
        """Sum of the three errors.  It occurs at the corners of the envelope; elsewhere the error is far smaller."""
        return self.band_error + self.step_error + self.response_error


@dataclass(frozen=True, kw_only=True)
class _Spectrum:
    """Responses (u_z, u_x) at evenly spaced frequencies, the drive's among them."""

    offsets: np.ndarray  # f_k - f0, Hz
    motion: np.ndarray  # H_k, m per V, shape (2, frequencies)
    step: float  # df, Hz
    reach: tuple[float, float]  # from the drive's frequency down and up to the ends of the band, Hz
    frequency: float  # f0 of the drive, Hz
    per_band: int = PER_BAND

    def taper(self, share: float) -> np.ndarray:
        """Window G of a band narrowed to a share of its reach on either side."""
        relative = np.where(self.offsets < 0, -self.offsets / self.reach[0], self.offsets / self.reach[1]) / share
        return np.cos(np.pi / 2 * np.clip((relative - FLAT) / (1 - FLAT), 0.0, 1.0)) ** 2

    @property
    def tick(self) -> float:
        """Time between two instants of an envelope, s."""
        return 1 / (self.per_band * (self.reach[0] + self.reach[1]))

    def switched(self, first: float, count: int, phase: float | None = 0.0, share: float = 1.0) -> np.ndarray:
        """S of equation (2) at ``count`` instants from ``first`` on, one tick apart, shape (2, count).

        The sum has the period 1 / df in t.  It is used from -a to 1 / df - a; S is zero before and H(f0) after that.

        ``phase``: of the voltage when it is switched on, rad, None without its counter-rotating half; ``share`` narrows
        the band.
        """
        a = LEAD / self.step
        last = (1 - LEAD) / self.step
        time = first + self.tick * np.arange(count)
        inside = (time >= -a) & (time < last)
        x = 2 * np.pi * self.offsets
        weights = self.motion * self.taper(share) * self.step  # G_k H_k df
        steady = self.motion[:, self.offsets == 0]  # H(f0), where G = 1
        out = np.where(time >= last, steady, 0.0 * steady)
        rotating = np.where(x == 0, 0.0, weights / (1j * np.where(x == 0, 1.0, x)))  # the limit x = 0 is added below
        counter_rotating = 0.0 * weights
        if phase is not None:
            counter_rotating = weights * np.exp(-2j * phase) / (1j * (x + 4 * np.pi * self.frequency))
        # Offsets and instants are evenly spaced, so that the sum of exp(i x t) is a discrete Fourier transform.
        ticks_per_period = round(1 / (self.step * self.tick))
        coefficients = np.zeros((2, ticks_per_period), complex)
        numbers = np.round(self.offsets / self.step).astype(int) % ticks_per_period
        coefficients[:, numbers] = (rotating + counter_rotating) * np.exp(1j * x * first)
        varying = ticks_per_period * np.fft.ifft(coefficients)[:, np.arange(count) % ticks_per_period]
        constant = (rotating @ np.exp(-1j * x * a))[:, None]
        total = varying - constant + steady * self.step * (time + a)  # the last term is that of x = 0
        out[:, inside] = total[:, inside]
        return out

    def shaped(self, shape: Callable, duration: float, share: float) -> tuple[np.ndarray, np.ndarray]:
        """Return instants in s from the beginning of a burst of a shape, and U of equation (3) at them, shape (2, k).

        Its steps act through D = S - H(f0) theta(t), which is 0 before -a and after 1 / df - a: the sum is
        H(f0) a(t) + sum da D.
        """
        fine = replace(self, per_band=FINER * self.per_band)
        tick, memory = fine.tick, math.ceil(1 / (self.step * fine.tick))
        count = math.ceil(duration / tick)  # instants before the end of the burst
        at = tick * np.arange(count + memory)
        factors = np.asarray(shape(np.append(at[:count], duration)), complex)
        lead = math.ceil(LEAD / self.step / tick)
        # D at odd multiples of half a tick: each da acts in the middle of its tick
        kernel = fine.switched((0.5 - lead) * tick, memory + lead, None, share)
        steady = self.motion[:, self.offsets == 0]
        kernel[:, lead:] -= steady
        size = 1 << (count + 2 * memory + lead).bit_length()
        spread = np.fft.ifft(np.fft.fft(kernel, size) * np.fft.fft(np.diff(factors), size))
        motion = spread[:, lead - 1 : lead - 1 + at.size]
        driven = at < duration
        motion[:, driven] += steady * factors[:count]
        for instant, jump in ((0.0, factors[0]), (duration, -factors[-1])):
            if jump:
                turn = 2 * np.pi * self.frequency * instant + np.angle(jump)
                motion += jump * (fine.switched(-instant, at.size, turn, share) - steady * (at >= instant))
        kept = slice(None, None, FINER)
        return at[kept], motion[:, kept]

    def probes(self) -> np.ndarray:
        """Offsets in Hz between the steps, in the flat part of the band, at irrational fractions of a step."""
        spread = (np.arange(PROBES) + 0.5) / PROBES * 2 - 1  # evenly over (-1, 1)
        offsets = FLAT * np.where(spread < 0, spread * self.reach[0], spread * self.reach[1])
        return (np.floor(offsets / self.step) + GOLDEN * np.arange(1, PROBES + 1) % 1.0) * self.step

    def between(self, offsets: np.ndarray) -> np.ndarray:
        """Response (u_z, u_x) at other offsets, Hz, from the impulse response between -a and 1 / df - a.

        H(f) = sum_k G_k H_k df int exp(2 pi i (f_k - f) t) dt over that time, a sinc function times a phase factor.
        """
        in_steps = np.subtract.outer(self.offsets, offsets) / self.step  # (f_k - f) / df
        kernel = np.sinc(in_steps) * np.exp(2j * np.pi * in_steps * (0.5 - LEAD))
        return (self.motion * self.taper(1.0)) @ kernel


def burst_response(
    band: Response,
    position: float,
    *,
    drive: str | Drive,
    frequency: float,
    duration: float,
    tolerance: float,
    max_frequencies: int = MAX_FREQUENCIES,
) -> BurstEnvelope:
    """Envelope of the surface's motion at a position for a rectangular burst.

    Parameters
    ----------
    band : Response
        For instance from `fem.frequency_band`; a wider band resolves sharper corners.
    position, duration : float
        m from the left end; s.
    drive : str or Drive
        Name of the driven transducer, or sources at several.
    frequency : float
        Hz, well inside the band.
    tolerance : float
        Of the aliased motion, relative to the steady amplitude.
    max_frequencies : int
        Approximate number of frequencies after which the search ends with an error.

    Raises
    ------
    ValueError
        If the frequency does not lie in the band or the duration is not positive.
    ConvergenceError
        If the surface rings longer than the largest number of frequencies can resolve.
    """
    refuse_outside(band.limits, frequency, ends=False)
    positive("duration", duration, "s")
    motions = _Motions(band, position, drive, frequency)
    # Gain 2: the coarse level uses every second frequency of the fine one, so the whole difference is the error.
    divisions = [FIRST_FREQUENCIES // 2, FIRST_FREQUENCIES]
    while 2 * divisions[-1] <= max_frequencies:
        divisions.append(2 * divisions[-1])
    refined = refine(motions.spectrum, divisions, differences=motions.aliased, gain=2.0, tolerance=tolerance)
    (spectrum, response), error = refined.answer, refined.errors[0]
    if error > tolerance:
        raise ConvergenceError(
            f"the surface still rings {1 / spectrum.step:.1e} s after the switch, by {error:.1e} of its amplitude: "
            "give the solid a mechanical_quality, or ask for less"
        )
    return _envelope(duration, spectrum, position, (error, response), len(motions.known))


class _Motions:
    """Motion of the surface at a position, solved once at every frequency that is needed."""

    def __init__(self, band: Response, position: float, drive: str | Drive, frequency: float):
        self.band, self.position, self.drive, self.frequency = band, position, drive, frequency
        self.known: dict[float, tuple[complex, complex, float]] = {}  # by frequency: u_z, u_x, relative error

    def at(self, frequencies: np.ndarray) -> np.ndarray:
        """Rows (u_z, u_x, relative error) at frequencies in Hz."""
        new = [float(each) for each in frequencies if float(each) not in self.known]
        for each, wave in zip(new, self.band.waves(new, self.drive), strict=True):
            tangential, normal = wave.motion(self.position)
            self.known[each] = (complex(normal), complex(tangential), wave.relative_error)
        return np.array([self.known[float(each)] for each in frequencies])

    def spectrum(self, divisions: int) -> tuple[_Spectrum, float]:
        """Spectrum with the band divided into so many steps, and the largest relative error of its responses."""
        low, high = self.band.limits
        step, reach = (high - low) / divisions, (self.frequency - low, high - self.frequency)
        numbers = np.arange(-int(reach[0] / step), int(reach[1] / step) + 1)
        samples = self.at(self.frequency + numbers * step)
        spectrum = _Spectrum(
            offsets=numbers * step, motion=samples[:, :2].T, step=step, reach=reach, frequency=self.frequency
        )
        return spectrum, float(samples[:, 2].real.max())

    def aliased(self, fine: tuple[_Spectrum, float], coarse: tuple[_Spectrum, float]) -> tuple[float]:
        """Aliased motion over the steady one, from steps twice as wide and from frequencies between the steps."""
        spectrum = fine[0]
        count = math.ceil((1 - LEAD) / (2 * spectrum.step * spectrum.tick))
        change = abs(spectrum.switched(0.0, count) - coarse[0].switched(0.0, count)).max()
        exact = self.at(self.frequency + spectrum.probes())[:, :2].T
        missed = abs(spectrum.between(spectrum.probes()) - exact).max()
        steady = abs(spectrum.motion[0, spectrum.offsets == 0])[0]
        return (float(max(change, missed) / steady),)


def _envelope(
    duration: float,
    spectrum: _Spectrum,
    position: float,
    errors: tuple[float, float],
    frequencies: int,
    share: float = 1.0,
    shape: Callable | None = None,
) -> BurstEnvelope:
    """Envelopes of a burst; ``errors``: by the frequency step, of the response; ``frequencies``: number solved."""
    positive("duration", duration, "s")
    span = np.arange(0.0, 1 / spectrum.step, spectrum.tick)
    during = int(np.count_nonzero(span < duration))
    time = np.append(span[:during], duration + span)
    end_phase = 2 * np.pi * spectrum.frequency * duration

    def burst(share: float) -> np.ndarray:
        """U of equation (1) during the burst and after it, with a share of the band."""
        s = partial(spectrum.switched, share=share)
        rise = s(0.0, during) - s(-duration, during, end_phase)
        fall = s(duration, len(span)) - s(0.0, len(span), end_phase)
        return np.concatenate((rise, fall), axis=1)

    steady = spectrum.motion[:, spectrum.offsets == 0][:, 0]
    if shape is None:
        whole, narrower = burst(share), burst(NARROWER * share)
        factors = np.ones(len(time), complex)
    else:
        (time, whole), (_, narrower) = (spectrum.shaped(shape, duration, each * share) for each in (1.0, NARROWER))
        factors = np.asarray(shape(time), complex)
    driven = time < duration
    change = abs(whole - narrower) / abs(steady[0])
    unsteady = abs(whole[0] / steady[0] - factors)
    mean_error = _mean(time[driven], change[0][driven] + sum(errors) * unsteady[driven], duration)
    lead = LEAD / spectrum.step
    before_switch = spectrum.switched(-lead, math.ceil(lead / spectrum.tick))[0]
    after_switch = spectrum.switched(0.0, len(span))[0]
    unsettled = np.flatnonzero(abs(after_switch / steady[0] - 1) > 0.01)
    return BurstEnvelope(
        position=position,
        frequency=spectrum.frequency,
        duration=duration,
        time=time,
        normal=whole[0],
        tangential=whole[1],
        steady_normal=complex(steady[0]),
        steady_tangential=complex(steady[1]),
        settling=float(span[unsettled[-1]] if len(unsettled) else 0.0),
        early=float(abs(before_switch).max() / abs(steady[0])),
        band_error=float(change.max()),
        step_error=errors[0],
        response_error=errors[1],
        frequencies=frequencies,
        lasting=partial(_envelope, spectrum=spectrum, position=position, errors=errors, frequencies=frequencies),
        mean_error=mean_error,
    )


def _mean(time: np.ndarray, values: np.ndarray, duration: float) -> float:
    """Return the mean over a duration of values at times from 0 on; the last one stays."""
    ends = np.append(time, duration)
    return float(np.sum(values * np.diff(ends)) / duration)
