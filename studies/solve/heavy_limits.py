"""Threshold and release of sliders whose answers are those of a heavy one: rough balls, and adhesion that holds on."""

import contact
from studies.model.scene_errors import slider_keys
from studies.model.wave_to_contact import STOPS, Contact


def heavy_limits(driven: Contact) -> tuple[float, float]:
    """Return the factors on the orbits at which the slider starts to move and its first ball leaves the surface."""
    if driven.rough:
        from studies.solve.rough_answer import rough_limits

        if driven.scene.burst is not None and not driven.as_law:
            driven.scene.refuse("slider.law", STOPS.format(where="with a burst"))
        return rough_limits(driven)
    scale = 1e-9 / max(abs(each.normal) for each in driven.orbits)
    with slider_keys():
        slider = driven.slider
    threshold, release = (
        limit(slider, driven.at(scale)) for limit in (contact.threshold_factor, contact.release_factor)
    )
    return scale * threshold, scale * release
