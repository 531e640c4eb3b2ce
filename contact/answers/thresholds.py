r"""Where a slider starts to move and where contact is first lost, for every law.

With the elastic law both are closed forms (`limits`). A hysteretic contact slips at its rim long before it slips as a
whole, and what it remembers of a cycle carries the slider along: it starts some 10 % below the elastic threshold. The
reciprocal force adds to the support, so that the slider rides higher and parts earlier. There the two are searched in
the averaged balance, to 1e-5.
"""

import math

from contact.drive import towards_plus
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider
from contact.solve import limits

ACCURACY = 1e-5


def threshold_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the factor on all orbits above which the slider starts to move.

    Zero without friction, or with a load that friction cannot hold; inf without motion.

    Parameters
    ----------
    slider : Slider
        The slider.
    orbits : Orbit or tuple of Orbit
        Motion of the surface under each contact; only ratios and phases matter.
    """
    from contact.solve.equilibrium import balanced

    elastic = limits.threshold_factor(slider, orbits)
    if _closed(slider) or elastic == 0.0 or math.isinf(elastic):
        return elastic
    _, driven = towards_plus(as_orbits(orbits))
    return _edge(lambda k: not balanced(slider, tuple(o.scaled(k) for o in driven)).held, elastic)


def release_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the factor on all orbits at which the first contact is lost once per cycle; inf without normal motion.

    Parameters as for `threshold_factor`.
    """
    from contact.solve.equilibrium import balanced

    elastic = limits.release_factor(slider, orbits)
    friction = slider.friction_coefficient * slider.preload
    if not slider.reciprocal or slider.law != "elastic" or math.isinf(elastic) or friction <= slider.load:
        return elastic
    _, driven = towards_plus(as_orbits(orbits))
    top = max(abs(orbit.normal) for orbit in driven)

    def parts(factor):
        found = balanced(slider, tuple(orbit.scaled(factor) for orbit in driven))
        return found.height * found.problem.length < factor * top

    return _edge(parts, elastic)


def threshold_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit in m above which the slider starts to move."""
    return threshold_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def release_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit in m at which a contact is first lost once per cycle."""
    return release_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def _closed(slider):
    return slider.law == "elastic" and not slider.reciprocal


def _edge(beyond, guess):
    """Return the factor from which on `beyond` holds, at or below the guess or a little above it."""
    low, high = guess, guess
    while not beyond(high):
        low, high = high, 1.1 * high
    while low == high or beyond(low):
        low *= 0.8
        if low < 1e-6 * guess:
            return 0.0
    while high - low > ACCURACY * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if beyond(middle) else (middle, high)
    return 0.5 * (low + high)
