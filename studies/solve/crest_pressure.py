"""Contact pressure on the highest crest of the wave, and the margin of its amplitude below the threshold."""

import math

import contact
from studies.record.point import Point


def contact_load(slider, orbits: tuple, threshold: float) -> Point:
    """Return the contact pressure on the highest crest, and the margin of the amplitude below the threshold.

    ``threshold`` is the factor on the orbits at which the slider starts to move; it is infinite if the slider never
    moves.
    """
    load = Point(stick_margin=threshold - 1.0 if math.isfinite(threshold) else None)
    if slider.preload > 0.0:
        crests = slider.offsets(len(orbits)) + [abs(orbit.normal) for orbit in orbits]
        deepest = contact.riding_height(slider, orbits) + max(crests)
        load |= Point(contact_pressure_Pa=float(slider.pressure(deepest)))
    return load
