r"""Wave amplitudes at which a slider starts to move (threshold) and at which contact is first lost (release).

Both are factors on the orbits. The averaged theory below assumes a slider that is heavy on the wave's time
scale. It rides at a constant height h such that the cycle mean of the normal forces balances the preload,
<sum P_i> = preload. The approach of contact i is z_i = h + h_i + Re(U_i exp(i omega t)), where h_i is its height.

*Release.* The first contact of those that touch at rest satisfies h + h_i = |U_i|. With the approach z0 at rest this
gives |U| = z0/<(1 + sin)^1.5>^(2/3), <(1 + sin)^1.5> = 16 sqrt 2/(6 pi), for one sphere and |U| = z0 for one punch.

*Threshold, elastic law, equal heights.* No contact slips while each has an offset x0 such that
|x0 + u_x| <= c (h + u_z) at all times. In complex amplitudes, for any phase between them, this is
x0 + |U_x - c U_z| <= c h and -x0 + |U_x + c U_z| <= c h. The offsets must also carry the load, <sum Q_i> = load.
Without a load, and with u_x and u_z in quadrature, the threshold is |U_x|^2 + c^2 |U_z|^2 = c^2 h^2.
The normal force p(z) is a homogeneous function. Hence, at equal heights, approach and orbits grow by the same factor,
and the preload determines this factor.

*Threshold, other cases.* These thresholds follow from bisection of the averaged equilibrium, to a relative accuracy
of 1e-5:

- A hysteretic contact slips in an annulus before it slips as a whole. Its deformation depends on the previous cycle and
  carries the slider along, so that the slider moves at about 10 % below the elastic threshold.
- The reciprocal force adds to the support, so that the slider rides higher and contacts separate earlier.
- If the contacts have different heights or orbits, some may hold the slider while others slip.

*Infinite threshold.* If the wave, mirrored in x, is the same wave at a later time, then no amplitude moves an unloaded
slider. Examples are a surface that moves along one axis only, and pairs of contacts that drive against each other.

*Corrections within a cycle.* The slider's motion within a cycle is smaller than that of the surface by (f_n/f)^2. Up to
the first release the normal motion has no event, and up to the first slip the tangential motion has none. The full
equations are then solved in harmonics of the wave (`periodic.sticking_motion`). The *release* of every law except the
reciprocal one, and the *threshold* of the elastic law, are the factors at which a contact in this motion just separates
or slips. All other factors keep the error of averaging.
"""

import math
from dataclasses import replace
from functools import cache

import numpy as np

from contact.averaged.adhesive_motion import holding_balls
from contact.averaged.coupled_motion import coupled_motion
from contact.averaged.event_equilibrium import balanced
from contact.averaged.riding import mean_load, riding_approach, riding_height
from contact.choice import Answer
from contact.error_estimate import averaged_threshold_error, bounds_error
from contact.exceptions import ConvergenceError
from contact.law.elastic import tangential_force
from contact.law.holding import opens_at
from contact.law.normal import approach, plain
from contact.law.user import UserLaw
from contact.orbit import as_orbits, towards_plus
from contact.passing_wave import PassingWave, Surface, coupling, prescribed
from contact.periodic.sticking_motion import least, normal_motion, room_to_stick
from contact.problem import full_friction, scaled
from contact.roots import bracketed
from contact.slider import Slider

# Relative accuracy of the bisection in the averaged equilibrium. It is part of the error, and below the error of
# averaging for f_n/f above 0.0022.
ACCURACY = 1e-5
# Search of the factor at which the margin of the periodic motion vanishes. SAMPLES: phases per cycle of the motion.
# ROOT: relative tolerance of the factor. MAX_REACH: largest relative distance from the averaged factor; if the search
# ends without a root there, the averaged factor is the answer. In 207 searches for drawn motors a larger distance was
# needed 16 times, always at f_n/f above 0.5.
SAMPLES, ROOT, MAX_REACH = 256, 1e-10, 0.5
# The threshold is infinite if the slider is still held at this many times the factor of the first slip of any contact.
# In 38 drawn motors with unequal contacts it was 1 to 1.36 times that factor.
CLIMB = 100.0
# A load may move a slider on unequal contacts within a range of factors that is narrower than the usual step, beyond
# which the wave holds it again: seen up to this many times the first slip.
NARROW = 1.5
# Orbits within this relative difference count as equal: a thousandth of the least stated error, and far above rounding.
ALIKE = 1e-9
OPEN = 1e-9  # of the largest factor: smallest one of a search that needs closed contacts
PHASES = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 512, endpoint=False))


def threshold(slider: Slider, orbits: Surface) -> Answer:
    """Return the factor on all orbits above which the slider starts to move, with its error.

    The factor is zero without friction or if friction cannot hold the load, and inf if no amplitude moves the slider.

    Parameters
    ----------
    slider, orbits
        As for `steady`; only ratios and phases of the orbits matter.

    Examples
    --------
    >>> from contact import Orbit
    >>> slider = Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08,
    ...                 effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    ...                 stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4)
    >>> print(threshold(slider, Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j)))
    0.706283 +- 7.1e-07 (ok: periodic motion up to the first event)
    """
    if coupling(slider, orbits):
        return _coupled_threshold(slider, orbits)
    slider, listed = prescribed(slider, orbits)
    _, listed = towards_plus(listed)
    if listed.still:
        return Answer(value=math.inf, error=0.0, reasons=("there is no wave",))
    if slider.static_friction(len(listed)) <= slider.load:
        return Answer(value=0.0, error=0.0, reasons=("friction cannot hold the load",))
    if slider.load == 0.0 and _own_mirror_image(slider, listed):
        return Answer(value=math.inf, error=0.0, reasons=("the wave drives both ways alike",))
    if slider.profile.hold is not None:
        return _by_averaging(slider, listed, holding_balls(slider).threshold(tuple(listed)))
    bent = bool(slider.tangential_law.bent)  # the slip limit is not proportional to the approach
    elastic = _elastic_threshold(_simplified(slider) if bent or not slider.level else slider, listed)
    if slider.law == "elastic" and not (slider.reciprocal or bent) and slider.level and slider.even and _alike(listed):
        own_spring = isinstance(slider.friction, UserLaw)
        return (_by_averaging if own_spring else _by_full_motion)(slider, listed, elastic)
    fine = NARROW if slider.load != 0.0 else 1.0
    held = _edge(lambda k: not balanced(slider, listed.scaled(k)).held, elastic, fine)
    return _by_averaging(slider, listed, held)


def threshold_factor(slider: Slider, orbits: Surface) -> float:
    """Return the value of `threshold`."""
    return threshold(slider, orbits).value


def release(slider: Slider, orbits: Surface) -> Answer:
    """Return the factor on all orbits at which a contact is first lost once per cycle, with its error.

    The factor is inf without normal motion. Contacts that do not touch at rest are ignored. The parameters are those
    of `threshold`.
    """
    slider, listed = prescribed(slider, orbits)
    _, listed = towards_plus(listed)
    if slider.profile.hold is not None:
        return _by_averaging(slider, listed, holding_balls(slider).release(tuple(listed)))
    factor = _released(slider, listed)
    if slider.reciprocal and slider.law == "elastic":
        return _by_averaging(slider, listed, factor)
    return _by_full_motion(slider, listed, factor, _contact_margins)


def release_factor(slider: Slider, orbits: Surface) -> float:
    """Return the value of `release`."""
    return release(slider, orbits).value


def releases(slider: Slider, orbits: Surface) -> tuple[Answer | None, ...]:
    """Return for each contact the factor on all orbits above which it leaves the surface once per cycle.

    The smallest is `release`; the others follow from cycle means, because contacts that have separated make the motion
    itself one with events. The factor is inf for a contact whose surface has no normal motion that lifts it off. None
    stands for a contact that does not touch at rest. The parameters are those of `threshold`.

    Examples
    --------
    >>> from contact import Orbit
    >>> slider = Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08,
    ...                 effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    ...                 stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4,
    ...                 heights=(0.0, -1e-9))
    >>> orbit = Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j)
    >>> [round(each.value, 3) for each in releases(slider, (orbit, orbit))]
    [2.959, 2.206]
    """
    slider, listed = prescribed(slider, orbits, each=True)
    _, listed = towards_plus(listed)
    count, first = len(listed), release(slider, listed)
    touch = slider.rest_approach(count) + slider.offsets(count) > 0.0
    factors = [_released_contact(slider, listed, i) if touch[i] else None for i in range(count)]
    earliest = min((each for each in factors if each is not None), default=math.inf)
    return tuple(
        None if each is None else first if each <= earliest * (1.0 + ALIKE) else _by_averaging(slider, listed, each)
        for each in factors
    )


def _released_contact(slider, listed, i):
    """Return the averaged factor at which contact i leaves the surface, inf if none does."""
    normal, height, leaves = listed.normal_size[i], slider.offsets(len(listed))[i], opens_at(slider.profile.hold)

    def approach(factor):
        return riding_height(slider, listed.scaled(factor)) + height - factor * normal - leaves

    largest = float(listed.normal_size.max())
    if largest == 0.0 or approach(CLIMB * float(np.max(slider.rest_approaches(len(listed)))) / largest) > 0.0:
        return math.inf
    averaged = _falling_root(approach, slider, listed)
    if not slider.reciprocal or slider.law != "elastic" or slider.static_friction(len(listed)) <= slider.load:
        return averaged

    def separates(factor):
        balance = balanced(slider, listed.scaled(factor))
        return balance.height * balance.problem.length + height - factor * normal < 0.0

    return _edge(separates, averaged)


def _by_averaging(slider, orbits, factor):
    """Return the answer for a factor from the averaged theory, with the error of averaging."""
    if math.isinf(factor):
        return Answer(value=float(factor), error=0.0, reasons=(f"none up to {CLIMB:g} times the first slip",))
    ratio = slider.normal_resonance(len(orbits)) / orbits.frequency
    error = float(factor * averaged_threshold_error(ratio, ACCURACY))
    return Answer(value=float(factor), error=float(error), reasons=("cycle means",))


def _by_full_motion(slider, orbits, averaged_factor, margins=None):
    """Return the factor from the periodic motion of the full equations, searched near the averaged factor.

    `margins(problem, motion, slider)` returns two margins that decrease with the factor: the first vanishes at a lower
    bound of the threshold (or release), the second at an upper bound. The root of each is computed, with a different
    number of samples per cycle, so that their distance shows both the uncertainty of the bounds and that of sampling.
    The answer is their mean, and their distance is its error. If one has no root, the averaged factor is returned.
    """
    averaged, margins = _by_averaging(slider, orbits, averaged_factor), margins or _stick_margins
    if math.isinf(averaged_factor) or averaged_factor == 0.0 or slider.mass == math.inf:
        return averaged

    def root(samples, which):
        """Return the factor at which one of the two margins vanishes; `which` is its index."""

        @cache
        def margin(factor):
            problem = scaled(slider, orbits.scaled(factor), direction=1.0, start=0.0)
            motion = normal_motion(problem, riding_approach(problem), samples)
            return margins(problem, motion, slider)[which]

        distance = averaged.error
        while not (margin(averaged_factor - distance) > 0.0 > margin(averaged_factor + distance)):
            distance *= 2.0
            if distance > MAX_REACH * averaged_factor:
                raise ConvergenceError("not converged", "the periodic motion has no such factor near that of averaging")
        low, high = averaged_factor - distance, averaged_factor + distance
        return bracketed(margin, low, high, tolerance=ROOT * averaged_factor)

    try:
        lower, upper = root(SAMPLES, 0), root(SAMPLES // 2, 1)
    except ConvergenceError:
        return averaged
    error = bounds_error(lower, upper)
    return Answer(
        value=float(0.5 * (lower + upper)), error=float(error), reasons=("periodic motion up to the first event",)
    )


def _contact_margins(problem, motion, slider):
    """Return the smallest approach of the contacts that touch at rest, as both margins: it is exact."""
    contacts = problem.contacts
    touch = slider.rest_approach(contacts) + slider.offsets(contacts) > 0.0
    margin = float(np.min(least(motion.approaches[touch])))
    return margin, margin


def _stick_margins(problem, motion, slider):
    """Return the stick margins of the first and of the last contact to slip; both include the margin of the load.

    The offset x0 of a sticking contact depends on the history and lies in an interval; the slip margin is half the
    width of this interval over the slip limit at rest. The first slip is a lower bound of the threshold. The last slip
    is an upper bound, because one sticking contact holds the slider.
    """
    forward, backward = (room_to_stick(problem, motion, side) for side in (1.0, -1.0))
    limit_at_rest = problem.limit_slope * slider.rest_approach(problem.contacts) / problem.length
    slip_margins = np.array([0.5 * (room.forward + room.backward) / limit_at_rest for room in (forward, backward)])
    friction = full_friction(problem)
    load_margin = _load_margin(backward.tangential_force, forward.tangential_force, problem.load, friction)
    return min(float(np.min(slip_margins)), load_margin), min(float(np.max(slip_margins)), load_margin)


def _load_margin(least, largest, load, friction):
    """Return the distance of a load from the nearer end of the interval that contacts can hold, over `friction`.

    It is negative outside the interval. The load is taken as positive: its sign is that of the unloaded motion that it
    opposes, and below the threshold there is no such motion.
    """
    return min(largest - load, load - least) / friction


def _own_mirror_image(slider, orbits):
    """True if the orbits with u_x negated equal the orbits at a later time, on contacts of the same heights.

    A later time multiplies all amplitudes by one phase factor. Every factor that turns the first mirrored orbit that
    moves into one of the orbits is tried.
    """
    own = np.vstack([slider.offsets(len(orbits)), slider.contact_factors(len(orbits))]).T
    amplitudes = [np.array([o.normal, o.tangential]) for o in orbits]
    size = max(float(np.max(np.abs(each))) for each in amplitudes)
    mirrored = [np.array([o.normal, -o.tangential]) for o in orbits]
    component = 0 if any(o.normal != 0 for o in orbits) else 1  # u_z, or u_x if no orbit has a u_z
    first = next(k for k, each in enumerate(amplitudes) if each[component] != 0)

    def equal_after(phase_factor):
        """Return True if the mirrored orbits times a phase factor are the orbits, in any order."""
        unmatched = list(range(len(orbits)))
        for each, height in zip(mirrored, own, strict=True):
            match = [
                k for k in unmatched
                if np.max(np.abs(amplitudes[k] - phase_factor * each)) < ALIKE * size
                and np.max(np.abs(own[k] - height)) < 1e-15
            ]  # fmt: skip
            if not match:
                return False
            unmatched.remove(match[0])
        return True

    factors = [each[component] / mirrored[first][component] for each in amplitudes]
    return any(abs(abs(factor) - 1.0) < ALIKE and equal_after(factor / abs(factor)) for factor in factors)


def _released(slider, listed):
    """Return the averaged factor at which a contact is first lost."""
    if slider.level and not slider.reciprocal:
        normal = listed.normal_size
        return _factor_at(max(normal), slider, normal) if normal.any() else math.inf
    touch = slider.rest_approach(len(listed)) + slider.offsets(len(listed)) > 0.0  # at rest
    normal, heights = listed.normal_size[touch], slider.offsets(len(listed))[touch]
    if not touch.any() or np.max(normal) == 0.0:
        return math.inf if slider.preload > 0.0 else 0.0

    def smallest_approach(factor):
        h = riding_height(slider, listed.scaled(factor))
        return float(np.min(h + heights - factor * normal))

    elastic = _falling_root(smallest_approach, slider, listed)
    friction = slider.static_friction(len(listed))
    if not slider.reciprocal or slider.law != "elastic" or friction <= slider.load:
        return elastic

    def separates(factor):
        balance = balanced(slider, listed.scaled(factor))
        return np.min(balance.height * balance.problem.length + heights - factor * normal) < 0.0

    return _edge(separates, elastic)


def threshold_amplitude(slider: Slider, orbits: Surface) -> float:
    """Return the amplitude |u_z| of the first orbit in m above which the slider starts to move.

    All orbits are scaled by the same factor. Use `threshold_factor` if u_z is zero.
    """
    return threshold_factor(slider, orbits) * _first_normal(slider, orbits)


def release_amplitude(slider: Slider, orbits: Surface) -> float:
    """Return the amplitude |u_z| of the first orbit in m at which a contact is first lost once per cycle."""
    return release_factor(slider, orbits) * _first_normal(slider, orbits)


def _first_normal(slider, orbits):
    """Return |u_z| of the first orbit, or of the larger wave, m."""
    return orbits.amplitude if isinstance(orbits, PassingWave) else float(as_orbits(orbits).normal_size[0])


def _coupled_threshold(slider, wave):
    """Return the threshold of a slider whose wave or tilts depend on its forces, searched in the averaged motion."""
    held = replace(slider, tilt="held", backing="rigid")
    guess = threshold(held, replace(wave, loading=False)).value
    if not 0.0 < guess < math.inf:
        return _by_averaging(slider, wave.orbits_at(0.0), guess)
    factor = _edge(lambda k: coupled_motion(slider, wave.scaled(k)).velocity != 0.0, guess)
    return _by_averaging(slider, wave.orbits_at(np.zeros(slider.count)), factor)


def _simplified(slider):
    """Return the slider with all contacts at the same height and with a constant coefficient of friction."""
    return replace(slider, heights=(), curvature=0.0, friction=None, friction_coefficient=slider.static_coefficient)


def _elastic_threshold(slider, orbits):
    """Return the factor at which a contact first slips, for equal heights (see the module docstring)."""
    c = slider.slope_unit
    # smallest h at which the two bounds on the offset of every contact leave an interval, for the orbits as they are
    ends = abs(orbits.tangential - c * orbits.normal) + abs(orbits.tangential + c * orbits.normal)
    lowest = float(ends.max()) / (2.0 * c)
    # at this factor the slider rides at that height, and the interval of one contact vanishes
    first_slip = _factor_at(lowest, slider, orbits.normal_size)
    if _holding_margin(slider, orbits, first_slip * (1.0 - 1e-9)) >= 0.0:
        return first_slip
    return bracketed(lambda factor: _holding_margin(slider, orbits, factor), 0.0, first_slip)


def _factor_at(height, slider, normal):
    """Return the factor f for which a slider on the amplitudes f `normal` rides at the mean approach f `height`.

    Contacts have equal heights. The mean force is homogeneous: with P = K p(z), the one at the factor f is
    K p(f unit) sum <p>, the sum that of the means at lengths over `unit`. Hence f unit is the approach of one contact
    under the force preload / sum <p>.
    """
    if not plain(slider.profile):
        return _factor_searched(height, slider, normal)
    unit = max(height, *normal)
    law, (share, _) = slider.profile, slider.contact_factors(len(normal))
    mean_sum = sum(part * mean_load(height / unit, each / unit, law) for part, each in zip(share, normal, strict=True))
    return float(approach(slider.preload / mean_sum / slider.stiffness_unit, law)) / unit


def _factor_searched(height, slider, normal):
    """Do the work of `_factor_at` where the normal force is not homogeneous; contacts are closed all the time."""
    law, (share, _) = slider.profile, slider.contact_factors(len(normal))

    def unbalanced(factor):
        loads = (mean_load(factor * height, factor * each, law) for each in normal)
        carried = slider.stiffness_unit * sum(part * each for part, each in zip(share, loads, strict=True))
        return carried - slider.preload

    high = slider.rest_approach(len(normal)) / height
    while unbalanced(high) < 0.0:
        high *= 2.0
    # without a preload the forces balance at 0 too, where an attraction ends
    return bracketed(unbalanced, OPEN * high if slider.preload == 0.0 else 0.0, high)


def _alike(orbits):
    """True if all orbits are equal except for their phases."""
    first, *others = ((abs(o.normal), abs(o.tangential), o.normal * np.conj(o.tangential)) for o in orbits)
    return all(np.allclose(each, first, rtol=ALIKE, atol=0.0) for each in others)


def _holding_margin(slider, orbits, factor):
    """Return a margin that is positive while all contacts stick and hold the load, and decreases with the factor.

    It is the smaller of two margins: half the width of the interval of allowed offsets over the slip limit at rest, and
    the distance of the load from the mean tangential forces at the largest and the smallest offsets.
    """
    mu, law, (share, slopes) = slider.static_coefficient, slider.profile, slider.contact_factors(len(orbits))
    scaled = orbits.scaled(factor)
    h = riding_height(slider, scaled)
    margin, largest, smallest = math.inf, 0.0, 0.0
    for part, slope, orbit in zip(share, slopes, scaled, strict=True):
        c = slope * slider.slope_unit
        # -backward <= x0 <= forward
        forward = c * h - abs(orbit.tangential - c * orbit.normal)
        backward = c * h - abs(orbit.tangential + c * orbit.normal)
        margin = min(margin, 0.5 * (forward + backward) / (c * slider.rest_approach(len(orbits))))
        z, u_x = h + (orbit.normal * PHASES).real, (orbit.tangential * PHASES).real
        friction = mu * slider.stiffness_unit * part
        largest += float(np.mean(tangential_force(u_x + forward, z, friction, c, law)))
        smallest += float(np.mean(tangential_force(u_x - backward, z, friction, c, law)))
    return min(margin, _load_margin(smallest, largest, slider.load, slider.static_friction(len(orbits))))


def _falling_root(function, slider, orbits):
    """Return the root of a decreasing function that is positive at 0."""
    amplitude = orbits.reach
    high = float(np.max(slider.rest_approaches(len(orbits)))) / amplitude
    while function(high) > 0.0:
        high *= 2.0
    return bracketed(function, 0.0, high)


def _edge(is_above, guess, fine=1.0):
    """Return the factor at which `is_above` becomes true, by bisection from a guess; inf above `CLIMB` guesses.

    ``fine``: factor on the guess up to which a narrow range in which it is true is not passed over.
    """
    low, high = guess, guess
    while not is_above(high):
        low, high = high, (1.01 if high < fine * guess else 1.1) * high
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
