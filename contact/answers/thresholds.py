r"""Where a slider starts to move and where contact is first lost, for a slider that is heavy on the wave's time scale.

Such a slider rides at the height at which the cycle mean of the normal forces is the preload, <sum P_i> = preload, so
contact i has the approach z_i = h + h_i + Re(U_i exp(i omega t)) with one h.

*Release*: the first contact that touches at rest has h + h_i = |U_i|. For one sphere that is z0/<(1 + sin)^1.5>^(2/3),
<> = 16 sqrt 2/(6 pi), for one punch z0.

*Threshold*, elastic law, equal heights: nothing slips while every contact has an offset x0 with
|x0 + u_x| <= c (h + u_z) at all times, that is x0 + |U_x - c U_z| <= c h and -x0 + |U_x + c U_z| <= c h (complex
amplitudes, any phase), and the offsets carry the load, <sum Q_i> = load. In quadrature, unloaded:
|U_x|^2 + c^2 |U_z|^2 = c^2 h^2.

A hysteretic contact slips at its rim long before it slips as a whole, and what it remembers of a cycle carries the
slider along: it starts some 10 % below the elastic threshold. The reciprocal force adds to the support, so that the
slider rides higher and parts earlier. Of contacts at different heights or on different orbits some hold the slider
while others slip. There the factor is searched in the averaged balance, to 1e-5.

p(z) is homogeneous: with equal heights the approach and the orbits grow by one factor, and the preload gives it.

*Never*: without a load nothing moves a slider whose motion is its own mirror image a while later: waves that move the
surface along one axis only, contacts in pairs that drive against each other. Then the threshold is infinite.

The slider does answer within a cycle, by (f_n/f)^2 of the wave. Up to the first release its normal motion, and up to
the first slip its tangential one, is that of the full equations in harmonics of the wave (`periodic.sticking`):
*release* of every law but the reciprocal one, and the *threshold* of the elastic law, are the factors at which a
contact of that motion just parts or slips. The other factors keep the error of averaging (`AVERAGING_ERROR`).
"""

import math
from dataclasses import replace

import numpy as np

from contact.averaged.event_cycle import balanced
from contact.averaged.riding import mean_load, riding_approach, riding_height
from contact.choice import Answer
from contact.convergence_error import ConvergenceError
from contact.drive import towards_plus
from contact.law.elastic import tangential_force
from contact.law.user import UserLaw
from contact.orbit import Orbit, as_orbits
from contact.periodic.sticking import least, normal_motion, room_to_stick
from contact.problem import scaled
from contact.roots import bracketed
from contact.slider import Slider

ACCURACY = 1e-5
# phases of a cycle of the periodic motion; relative tolerance of its roots, and how far from the factor of averaging
# they are searched
SAMPLES, ROOT, MAX_REACH = 256, 1e-10, 0.5
# least relative error of such a root: bisection of the full motion at f_n/f = 0.2 differs by 5e-7
LEAST_ERROR = 1e-6
# relative error of a factor over (f_n/f)^2; true: 0.5 to 1.4 (`tests/contact/test_threshold_answers.py`)
AVERAGING_ERROR = 1.5
# largest factor over that of the first slip of any contact at which the slider may still be held: above, "never"
CLIMB = 100.0
# relative difference of orbits that are alike
ALIKE = 1e-9
PHASES = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 512, endpoint=False))


def threshold(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> Answer:
    """Return the factor on all orbits above which the slider starts to move, with its error.

    Zero without friction, or with a load that friction cannot hold; inf where no amplitude moves it.

    Parameters
    ----------
    slider, orbits
        As for `steady`; only ratios and phases of the orbits matter.

    Examples
    --------
    >>> slider = Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08,
    ...                 effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    ...                 stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4)
    >>> print(threshold(slider, Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j)))
    0.706283 +- 7.1e-07 (ok: periodic motion up to the first event)
    """
    _, listed = towards_plus(as_orbits(orbits))
    if all(orbit.normal == 0 and orbit.tangential == 0 for orbit in listed):
        return Answer(value=math.inf, error=0.0, reasons=("there is no wave",))
    if slider.static_friction(len(listed)) <= slider.load:
        return Answer(value=0.0, error=0.0, reasons=("friction cannot hold the load",))
    if slider.load == 0.0 and _own_mirror_image(slider, listed):
        return Answer(value=math.inf, error=0.0, reasons=("the wave drives both ways alike",))
    bent = bool(slider.tangential_law.bent)
    elastic = _elastic_threshold(_guess(slider) if slider.heights or bent else slider, listed)
    if slider.law == "elastic" and not (slider.reciprocal or slider.heights or bent) and _alike(listed):
        own_spring = isinstance(slider.friction, UserLaw)
        return (_by_averaging if own_spring else _by_full_motion)(slider, listed, elastic)
    held = _edge(lambda k: not balanced(slider, tuple(o.scaled(k) for o in listed)).held, elastic)
    return _by_averaging(slider, listed, held)


def threshold_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the value of `threshold`."""
    return threshold(slider, orbits).value


def release(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> Answer:
    """Return the factor on all orbits at which the first contact is lost once per cycle, with its error.

    Inf without normal motion. Parameters as for `threshold`. Contacts that do not touch at rest do not count.
    """
    _, listed = towards_plus(as_orbits(orbits))
    factor = _released(slider, listed)
    if slider.reciprocal and slider.law == "elastic":
        return _by_averaging(slider, listed, factor)
    return _by_full_motion(slider, listed, factor, _contact_margins)


def release_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the value of `release`."""
    return release(slider, orbits).value


def _by_averaging(slider, orbits, factor):
    """Return a factor that cycle means gave as an answer, with the error of averaging."""
    if math.isinf(factor):
        return Answer(value=factor, error=0.0, reasons=(f"none up to {CLIMB:g} times the first slip",))
    ratio = slider.normal_resonance(len(orbits)) / orbits[0].frequency
    relative = min(AVERAGING_ERROR * ratio**2, 1.0) + ACCURACY
    return Answer(value=factor, error=factor * relative, reasons=("cycle means",))


def _by_full_motion(slider, orbits, first, margins=None):
    """Return the factor by the periodic motion of the full equations, searched near the averaged factor `first`.

    `margins(problem, motion, slider)` returns a lower and an upper bound of a margin that falls through zero at the
    factor. Their roots are taken with different numbers of samples; the answer lies half-way between them, and their
    distance is its error. Without a root the averaged factor is returned.
    """
    averaged, margins = _by_averaging(slider, orbits, first), margins or _stick_margins
    if math.isinf(first) or first == 0.0:
        return averaged

    def root(samples, which):
        def margin(factor):
            problem = scaled(slider, tuple(o.scaled(factor) for o in orbits), direction=1.0, start=0.0)
            motion = normal_motion(problem, riding_approach(problem), samples)
            return margins(problem, motion, slider)[which]

        reach = averaged.error
        while not (margin(first - reach) > 0.0 > margin(first + reach)):
            reach *= 2.0
            if reach > MAX_REACH * first:
                raise ConvergenceError(
                    "not converged", "the periodic motion has no such factor near that of averaging"
                )
        return bracketed(margin, first - reach, first + reach, tolerance=ROOT * first)

    try:
        value, other = root(SAMPLES, 0), root(SAMPLES // 2, 1)
    except ConvergenceError:
        return averaged
    error = abs(value - other) + LEAST_ERROR * value
    return Answer(
        value=0.5 * (value + other), error=error, reasons=("periodic motion up to the first event",)
    )


def _contact_margins(problem, motion, slider):
    """Return the least approach of the contacts that touch at rest, as both bounds: it is exact."""
    contacts = problem.contacts
    touch = slider.rest_approach(contacts) + slider.offsets(contacts) > 0.0
    margin = float(np.min(least(motion.approaches[touch])))
    return margin, margin


def _stick_margins(problem, motion, slider):
    """Return the margins of the first and of the last contact to slip, of contacts that stick and carry the load.

    Contacts that stick have the offsets of their history, the largest or the least ones or any between. As long as one
    contact sticks it holds the slider.
    """
    rooms = [room_to_stick(problem, motion, side) for side in (1.0, -1.0)]
    unit = problem.limit_slope * slider.rest_approach(problem.contacts) / problem.length
    left = np.array([0.5 * (room.forward + room.backward) / unit for room in rooms])
    held = _held_load(rooms[1].traction, rooms[0].traction, problem.load, problem.friction * problem.preload)
    return min(float(np.min(left)), held), min(float(np.max(left)), held)


def _held_load(least, largest, load, friction):
    """Return how far a load lies between the mean forces that contacts can hold, over the friction; < 0 outside.

    No threshold is reached before, so that the wave does not move the unloaded slider and the load is positive.
    """
    return min(largest - load, load - least) / friction


def _own_mirror_image(slider, orbits):
    """True if the orbits with u_x negated are the same orbits some time later, of contacts of the same heights."""
    heights = slider.offsets(len(orbits))
    here = [np.array([o.normal, o.tangential]) for o in orbits]
    size = max(float(np.max(np.abs(each))) for each in here)
    turned = [np.array([o.normal, -o.tangential]) for o in orbits]
    axis = 0 if any(o.normal != 0 for o in orbits) else 1
    first = next(k for k, each in enumerate(here) if each[axis] != 0)

    def same(shift):
        left = list(range(len(orbits)))
        for each, height in zip(turned, heights, strict=True):
            match = [
                k for k in left
                if np.max(np.abs(here[k] - shift * each)) < ALIKE * size and abs(heights[k] - height) < 1e-15
            ]  # fmt: skip
            if not match:
                return False
            left.remove(match[0])
        return True

    shifts = [each[axis] / turned[first][axis] for each in here]
    return any(abs(abs(shift) - 1.0) < ALIKE and same(shift / abs(shift)) for shift in shifts)


def _released(slider, listed):
    """Return the factor at which the first contact is lost."""
    if not slider.heights and not slider.reciprocal:
        reach = [abs(o.normal) for o in listed]
        return _factor_at(max(reach), slider, reach) if max(reach) > 0.0 else math.inf
    touch = slider.rest_approach(len(listed)) + slider.offsets(len(listed)) > 0.0
    reach, heights = np.array([abs(o.normal) for o in listed])[touch], slider.offsets(len(listed))[touch]
    if not touch.any() or np.max(reach) == 0.0:
        return math.inf if slider.preload > 0.0 else 0.0

    def least(factor):
        h = riding_height(slider, tuple(o.scaled(factor) for o in listed))
        return float(np.min(h + heights - factor * reach))

    elastic = _falling_root(least, slider, listed)
    friction = slider.static_friction(len(listed))
    if not slider.reciprocal or slider.law != "elastic" or friction <= slider.load:
        return elastic

    def parts(factor):
        found = balanced(slider, tuple(orbit.scaled(factor) for orbit in listed))
        return np.min(found.height * found.problem.length + heights - factor * reach) < 0.0

    return _edge(parts, elastic)


def threshold_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit in m above which the slider starts to move.

    The orbits are scaled together. `threshold_factor` serves where u_z is zero.
    """
    return threshold_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def release_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit in m at which a contact is first lost once per cycle."""
    return release_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def _guess(slider):
    """Return the slider with all contacts at one height, and one coefficient of friction."""
    return replace(slider, heights=(), friction=None, friction_coefficient=slider.static_coefficient)


def _elastic_threshold(slider, orbits):
    """Return the factor at which the first contact slips, all at one height; see the module's text."""
    c = slider.limit_slope
    end = max(abs(o.tangential - c * o.normal) + abs(o.tangential + c * o.normal) for o in orbits) / (2.0 * c)
    no_room = _factor_at(end, slider, [abs(o.normal) for o in orbits])
    if _holding_margin(slider, orbits, no_room * (1.0 - 1e-9)) >= 0.0:
        return no_room
    return bracketed(lambda factor: _holding_margin(slider, orbits, factor), 0.0, no_room)


def _factor_at(height, slider, reach):
    """Return the factor on |U_z| = reach of all contacts at which the slider rides at the factor times a height."""
    unit = max(height, *reach)
    mean = sum(mean_load(height / unit, each / unit, slider.contact_shape) for each in reach)
    return slider.approach_under(slider.preload / mean, 1) / unit


def _alike(orbits):
    """True if all orbits are one orbit with different phases."""
    first, *others = ((abs(o.normal), abs(o.tangential), o.normal * np.conj(o.tangential)) for o in orbits)
    return all(np.allclose(each, first, rtol=ALIKE, atol=0.0) for each in others)


def _holding_margin(slider, orbits, factor):
    """Return a margin, positive while all contacts stick and the load is held; it falls through zero with factor.

    It is the least of the room left for the offsets and of the distances of the load from the mean tractions that
    the highest and the lowest offsets give.
    """
    c, mu, shape = slider.limit_slope, slider.static_coefficient, slider.contact_shape
    scaled = tuple(orbit.scaled(factor) for orbit in orbits)
    h = riding_height(slider, scaled)
    room, highest, lowest = math.inf, 0.0, 0.0
    for orbit in scaled:
        up = c * h - abs(orbit.tangential - c * orbit.normal)
        down = c * h - abs(orbit.tangential + c * orbit.normal)
        room = min(room, 0.5 * (up + down) / (c * slider.rest_approach(len(orbits))))
        z, u_x = h + (orbit.normal * PHASES).real, (orbit.tangential * PHASES).real
        friction = mu * slider.normal_stiffness
        highest += float(np.mean(tangential_force(u_x + up, z, friction, c, shape)))
        lowest += float(np.mean(tangential_force(u_x - down, z, friction, c, shape)))
    return min(room, _held_load(lowest, highest, slider.load, mu * slider.preload))


def _falling_root(function, slider, orbits):
    """Return the factor at which a function that is positive at 0 falls through zero."""
    reach = max(max(abs(o.normal), abs(o.tangential)) for o in orbits)
    high = float(np.max(slider.rest_approaches(len(orbits)))) / reach
    while function(high) > 0.0:
        high *= 2.0
    return bracketed(function, 0.0, high)


def _edge(is_above, guess):
    """Return the factor at which `is_above` becomes true, found by bisection from a guess; inf far above the guess."""
    low, high = guess, guess
    while not is_above(high):
        low, high = high, 1.1 * high
        if high > CLIMB * guess:
            return math.inf
    while low == high or is_above(low):
        low *= 0.8
        if low < 1e-6 * guess:
            return 0.0
    while high - low > ACCURACY * high:
        middle = 0.5 * (low + high)
        low, high = (low, middle) if is_above(middle) else (middle, high)
    return 0.5 * (low + high)
