"""Steps of a motor: how far bursts of whole cycles of the drive move its slider.

On a stator the wave of a burst arrives late, grows over the transducers' length and rings on after the drive's end.
The response to one switched drive gives all of it for bursts of any length and voltage: it is solved once.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import contact
from studies.chain.bridge import DrivenContact
from studies.chain.ring_up import RingUp, switched

NARROWER = 0.5  # of the ring-up's band: the corners of the wave err as one over its width


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Bursts from rest of a driven contact, until the slider has stopped."""

    driven: DrivenContact
    # Of a number of cycles, and a share of the band; None for a wave at full size
    ringing: Callable[..., RingUp] | None = field(default=None, repr=False)
    reason: str = ""  # why a stator's wave is taken at full size from the first cycle; empty where it is not

    @classmethod
    def of(cls, driven: DrivenContact) -> "Steps":
        """Return the steps of a driven contact, with the ring-up of the stator's wave where it can be computed."""
        scene = driven.scene
        if scene.wave is not None:
            return cls(driven=driven)
        if scene.slider.method == "exact":
            return cls(driven=driven, reason="slider.method is exact")
        flat = contact.Envelope(time=[0.0], amplitude=[1.0], phase=[0.0])
        try:
            contact.step(driven.slider, driven.at(driven.levels[-1]), cycles=1, envelope=flat)
        except contact.ConvergenceError as error:
            if error.status != "not applicable":
                raise
            return cls(driven=driven, reason="the motion in the contact must be followed event by event")
        ringing, reason = switched(driven)
        if ringing is None:
            return cls(driven=driven, reason=reason)
        shaped = cache(lambda cycles, share=1.0: ringing.lasting(cycles / scene.frequency, share))
        return cls(driven=driven, ringing=shaped)

    @property
    def sentence(self) -> str:
        """What a reader of a step must know of the wave; empty where its growth is in the step."""
        if not self.reason:
            several = self.ringing is not None and len(self.driven.orbits) > 1
            return "the growth of the wave at the slider's centre is used for all balls" if several else ""
        return (
            f"the wave is taken at full size from the first cycle, because {self.reason}: "
            "a burst shorter than the wave's settling time moves the slider less far"
        )

    @property
    def settling(self) -> float:
        """From the burst's beginning until the wave stays within 1 % of its size, s; 0 where that is not known."""
        return 0.0 if self.ringing is None else self.ringing(1).response.settling

    def shape(self, cycles: int, share: float = 1.0) -> tuple:
        """Return the `contact.Envelope` during a burst of some cycles and that after it; None for a sudden wave."""
        if self.ringing is None:
            return None, None
        ringing = self.ringing(cycles, share)
        return ringing.envelope, ringing.ring_down

    def step(self, level: float, cycles: int, share: float = 1.0):
        """Return the `contact.Step` of a burst of some cycles at a level.

        ``share``: of the band in which the ring-up was solved, 1 but for estimates of its error.
        """
        envelope, after = self.shape(cycles, share)
        return contact.step(self.driven.slider, self.driven.at(level), cycles=cycles, envelope=envelope, after=after)

    def error(self, level: float, step) -> float:
        """Return the relative error that a `contact.Step` at a level has from the wave: its size, and its growth."""
        amplitude, others = self.driven.stator_error, []
        if self.ringing is not None:
            envelope = self.ringing(step.cycles).response
            amplitude += envelope.step_error + envelope.response_error
            others.append(self.step(level, step.cycles, share=NARROWER))
        if amplitude:
            others.append(self.step(level * (1.0 + amplitude), step.cycles))
        return sum(abs(each.displacement / step.displacement - 1.0) for each in others)

    def reaching(self, level: float, displacement: float) -> tuple:
        """Return the longest `contact.Step` short of a displacement in m, and the next, which reaches it."""
        options = {} if self.ringing is None else {"envelopes": self.shape}
        return contact.cycles_for(self.driven.slider, self.driven.at(level), displacement=displacement, **options)
