"""The ring-up of a burst: growth of the surface motion under the slider to its steady amplitude.

The frequency response in a band around the drive frequency gives the complex envelope of the surface motion
(`fem.burst_response`). The envelope divided by the steady motion is a factor on the steady orbits of the contact. The
same factor is used for all balls and for both directions. After the burst, the rest of the envelope describes the
ring-down under the slider.

A waveform of the drive (`studies.record.waveform`) passes through the same response: it is followed exactly, whether it
changes slowly or fast against the ring-up.
"""

import logging
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

import contact
import fem
from studies.model.model import Model
from studies.record.waveform import modulation
from studies.solve.spectrum import response

if TYPE_CHECKING:
    from contact.envelope import Envelope
    from fem.solve.burst_envelope import BurstEnvelope
    from studies.model.wave_to_contact import Contact

LOGGER = logging.getLogger(__name__)

# half-width of the band over f/N, for the fewest finger pairs N of a driven transducer: its main lobe and a margin
LOBES = 1.2
MAX_HALF_BAND = 0.22  # over the frequency; one interpolation of the response covers at most this band
# Of the distance from the drive's frequency to either end of the band, the part that a chirp may use: the response is
# not tapered there (`fem.burst_response`), in the narrower band that shows its error neither
SWEPT = 0.25
TOLERANCE = 2e-2  # of the response and of the truncated ring-down, relative to the steady amplitude
MAX_FREQUENCIES = 1024  # about half a minute; a longer ring-up enters the error of the burst instead


@dataclass(frozen=True, kw_only=True)
class RingUp:
    """Growth and decay of the surface motion under the slider in a burst, as factors on the steady orbits."""

    # Relative error of the velocity at the end of the burst. With an envelope: the error of the envelope times
    # (settling time / burst duration), of a waveform its mean over the burst. Without one: a lower bound of the ring-up
    # time over the burst duration.
    error: float
    envelope: "Envelope | Any" = field(default=None, repr=False)  # None if the ring-up is too long to be computed
    ring_down: "Envelope | None" = field(default=None, repr=False)  # its time is counted from the end of the burst
    response: "BurstEnvelope | Any" = field(default=None, repr=False)  # fem.BurstEnvelope

    @classmethod
    def of(cls, burst_envelope, shaped: bool = False) -> "RingUp":
        """Return the ring-up that follows from a `fem.BurstEnvelope`; ``shaped``: of a waveform."""
        time, duration = burst_envelope.time, burst_envelope.duration
        factors, during = burst_envelope.normal / burst_envelope.steady_normal, time < duration

        def shape(selected, start):
            values = factors[selected]
            return contact.Envelope(
                time=time[selected] - start, amplitude=abs(values), phase=np.unwrap(np.angle(values))
            )

        error = float(burst_envelope.relative_error * min(1.0, burst_envelope.settling / duration))
        error = burst_envelope.mean_error if shaped else error
        envelope, ring_down = shape(during, 0.0), shape(~during, duration)
        return cls(error=error, envelope=envelope, ring_down=ring_down, response=burst_envelope)

    def lasting(self, duration: float, share: float = 1.0) -> "RingUp":
        """Return the ring-up of a burst of another duration in s, computed from a fraction ``share`` of the band."""
        return RingUp.of(self.response.lasting(duration, share=share))

    @property
    def sentence(self) -> str:
        """Return a description of the ring-up time for a reader."""
        if self.response is None:
            return "the stator rings for too long to be followed"
        return f"{self.response.settling * 1e6:.4g} us to within 1 % of the steady motion"


def switched(driven: "Contact") -> tuple[RingUp | None, str]:
    """Return the ring-up under the slider when the drive of a run is switched on; or None, and why there is none."""
    record, center = driven.record, driven.scene.slider.center
    if record.surface_motion.covered(center):
        return None, "the slider stands over a transducer or a meshed piece"
    # of a burst of one cycle: that of any other burst follows from the same response (`RingUp.lasting`)
    ringing = ring_up(Model(record.scene.with_source(burst=1.0 / record.scene.frequency)), center)
    return (None, ringing.sentence) if ringing.response is None else (ringing, "")


def ring_up(model: Model, point: tuple[float, float]) -> RingUp:
    """Return the ring-up at a point (x, y) in m of a scene with transducers, a burst and a frequency."""
    section, x = model.first_section(point)
    scene = section.scene
    fewest = min(each.finger_pairs for each in scene.driven_transducers)
    half_band = min(LOBES / fewest, MAX_HALF_BAND) * scene.frequency
    waveform = modulation(scene)
    if waveform is not None:
        widest = MAX_HALF_BAND * scene.frequency
        if waveform.offset > SWEPT * widest:
            rule = f"must stay within {SWEPT * widest:.4g} Hz of drive.frequency, got {waveform.offset:.4g} Hz"
            scene.refuse("drive.waveform", rule)
        half_band = min(max(half_band, waveform.offset / SWEPT), widest)
    low, high = scene.frequency - half_band, scene.frequency + half_band
    over_band = response(section, low, high, positions=(x,), tolerance=TOLERANCE)
    LOGGER.info("stator: ring-up of the burst")
    try:
        burst_envelope = fem.burst_response(
            over_band, x, drive=section.drive, frequency=scene.frequency, duration=scene.burst,
            tolerance=TOLERANCE, max_frequencies=MAX_FREQUENCIES,
        )  # fmt: skip
        if waveform is None:
            return RingUp.of(burst_envelope)
        return RingUp.of(burst_envelope.lasting(scene.burst, shape=waveform.envelope.at), shaped=True)
    except fem.ConvergenceError as error:
        if waveform is not None:
            scene.refuse("drive.waveform", f"does not reach the slider as it is, and cannot be followed: {error}")
        # n frequencies over a band b resolve a time of n/b, which the ring-up exceeds
        return RingUp(error=min(1.0, MAX_FREQUENCIES / (2 * half_band) / scene.burst))
