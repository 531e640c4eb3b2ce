"""The ring-up of a burst under the slider: how the surface's motion grows to its steady size, for the contact.

The response over a band about the drive's frequency gives the complex envelope (fem.burst); over the steady motion it
is the factor on the orbits that the contact takes.  One factor serves all balls and both directions.  After the burst's
end the surface rings down under the slider as the same envelope goes on, until it is spent.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

import contact
import fem
from studies.chain import resolve
from studies.chain.spectrum import response
from studies.scene import Scene

if TYPE_CHECKING:
    from contact.envelope import Envelope
    from fem.solve.burst import BurstEnvelope

LOBES = 1.2  # of 1/N: the band taken on either side, the main lobe and a little
MAX_HALF_BAND = 0.22  # over the frequency: one band of interpolation
TOLERANCE = 2e-2  # of the response and of what rings on, over the steady amplitude
MAX_FREQUENCIES = 1024  # half a minute; a stator that rings longer is an error of the burst instead


@dataclass(frozen=True, kw_only=True)
class RingUp:
    """Growth and decay of the surface's motion under the slider in a burst, as factors on the steady orbits."""

    # Of a velocity at the burst's end: the envelope's error for as long as it rings up, over the burst's
    # length; without an envelope, how long it certainly rings over the burst's length
    error: float
    # Factor on the steady orbits; None where the stator rings for too long to be followed
    envelope: "Envelope | None" = field(default=None, repr=False)
    ring_down: "Envelope | None" = field(
        default=None, repr=False
    )  # the same from the burst's end on, time from there
    response: "BurstEnvelope | Any" = field(default=None, repr=False)  # fem's answer

    @classmethod
    def of(cls, burst_envelope) -> "RingUp":
        """Return what a `fem.BurstEnvelope` says."""
        factor, on = (
            burst_envelope.normal / burst_envelope.steady_normal,
            burst_envelope.time < burst_envelope.duration,
        )

        def shape(which, start):
            part = factor[which]
            return contact.Envelope(
                time=burst_envelope.time[which] - start, amplitude=abs(part), phase=np.unwrap(np.angle(part))
            )

        error = float(
            burst_envelope.relative_error * min(1.0, burst_envelope.settling / burst_envelope.duration)
        )
        return cls(
            error=error,
            envelope=shape(on, 0.0),
            ring_down=shape(~on, burst_envelope.duration),
            response=burst_envelope,
        )

    def lasting(self, duration: float, share: float = 1.0) -> "RingUp":
        """Return the ring-up of a burst of another duration, s, from a share of the band."""
        return RingUp.of(self.response.lasting(duration, share=share))

    @property
    def sentence(self) -> str:
        """What it is, for a reader."""
        if self.response is None:
            return "the stator rings for too long to be followed"
        return f"{self.response.settling * 1e6:.4g} us to within 1 % of the steady motion"


def ring_up(scene: Scene, place: tuple[float, float], *, progress: Callable[[str], None]) -> RingUp:
    """Return the ring-up at a place (x, y) in m of a scene with transducers, a burst and a frequency in Hz."""
    scene, x = resolve.first_row(scene, place)
    driven = scene.driven_transducer
    half = min(LOBES / driven.finger_pairs, MAX_HALF_BAND) * scene.frequency
    prepared = response(
        scene,
        scene.frequency - half,
        scene.frequency + half,
        places=(x,),
        tolerance=TOLERANCE,
        progress=progress,
    )
    progress("stator: ring-up of the burst")
    try:
        response_envelope = fem.burst_response(
            prepared,
            x,
            drive=resolve.drive(scene),
            frequency=scene.frequency,
            duration=scene.burst,
            tolerance=TOLERANCE,
            max_frequencies=MAX_FREQUENCIES,
        )
    except fem.ConvergenceError:
        return RingUp(error=min(1.0, MAX_FREQUENCIES / (2 * half) / scene.burst))
    return RingUp.of(response_envelope)
