"""Steps of a motor: how far bursts of whole cycles of the drive move its slider.

On a stator the wave of a burst arrives with a delay, grows over the transducers' length and rings down after the end of
the drive.  All of this follows, for bursts of any length and voltage, from one response to a switched drive.
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache

import contact
from studies.model.wave_to_contact import Contact
from studies.solve.ring_up import RingUp, switched

# Fraction of the ring-up's band; the error at the corners of the envelope is proportional to one over the width
NARROWER = 0.5


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Bursts from rest of a driven contact, until the slider has stopped."""

    driven: Contact
    # The ring-up for a number of cycles and a fraction of the band; None for a wave at full size
    ringing: Callable[..., RingUp] | None = field(default=None, repr=False)
    reason: str = ""  # why the ring-up of a stator's wave is neglected; empty if it is not

    @classmethod
    def of(cls, driven: Contact) -> "Steps":
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
        """What a step neglects of the wave's growth; empty if nothing."""
        if not self.reason:
            several = self.ringing is not None and len(self.driven.orbits) > 1
            return "the growth of the wave at the slider's centre is used for all balls" if several else ""
        return (
            f"the wave is taken at full size from the first cycle, because {self.reason}: "
            "a burst shorter than the wave's settling time moves the slider less far"
        )

    @property
    def settling(self) -> float:
        """Time from the beginning of the burst until the wave stays within 1 % of its final size, s; 0 if unknown."""
        return 0.0 if self.ringing is None else self.ringing(1).response.settling

    def shape(self, cycles: int, share: float = 1.0) -> tuple:
        """Return the `contact.Envelope` during a burst of some cycles and that after it; None if neglected."""
        if self.ringing is None:
            return None, None
        ringing = self.ringing(cycles, share)
        return ringing.envelope, ringing.ring_down

    def step(self, level: float, cycles: int, share: float = 1.0):
        """Return the `contact.Step` of a burst of some cycles at a level.

        ``share``: fraction of the band in which the ring-up was solved; below 1 to estimate its error.
        """
        envelope, after = self.shape(cycles, share)
        return contact.step(self.driven.slider, self.driven.at(level), cycles=cycles, envelope=envelope, after=after)

    def error(self, level: float, step) -> float:
        """Return the relative error of a `contact.Step` at a level that is due to the wave's amplitude and growth."""
        amplitude, others = self.driven.stator_error, []
        if self.ringing is not None:
            envelope = self.ringing(step.cycles).response
            amplitude += envelope.step_error + envelope.response_error
            others.append(self.step(level, step.cycles, share=NARROWER))
        if amplitude:
            others.append(self.step(level * (1.0 + amplitude), step.cycles))
        return sum(abs(each.displacement / step.displacement - 1.0) for each in others)

    def reaching(self, level: float, displacement: float) -> tuple:
        """Return the last `contact.Step` that is shorter than a displacement in m, and the first that reaches it."""
        options = {} if self.ringing is None else {"envelopes": self.shape}
        return contact.cycles_for(self.driven.slider, self.driven.at(level), displacement=displacement, **options)
