r"""Where slip starts and where contact is first lost: closed forms for a slider that is heavy on the wave's time scale.

Such a slider rides at the height at which the cycle mean of the normal forces is the preload, <sum P_i> = preload, so
contact i has the approach z_i = h + Re(U_i exp(i omega t)) with one h.

Release: the first contact to part has h = |U_i|. For one contact that is z0/<(1 + sin)^1.5>^(2/3),
<> = 16 sqrt 2/(6 pi).

Threshold: nothing slips while every contact has an offset x0 with |x0 + u_x| <= c (h + u_z) at all times, that is
x0 + |U_x - c U_z| <= c h and -x0 + |U_x + c U_z| <= c h (complex amplitudes, any phase), and the offsets carry the
load, <sum Q_i> = load.
"""

import math

import numpy as np

from contact.convergence import ConvergenceError
from contact.law import normal
from contact.law.elastic import tangential_force
from contact.orbit import Orbit, as_orbits
from contact.slider import Slider

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(48)
_PSI = 0.25 * math.pi * (_NODES + 1.0)
_SIN, _RATE = np.sin(_PSI), 0.25 * math.pi * _WEIGHTS * np.cos(_PSI)


def mean_load(height: float, amplitude: float, shape: int, of=normal.load) -> float:
    """Return the cycle mean of p(h + A cos phi), or of dp/dz with `of=normal.slope`; h and A in m.

    Gauss-Legendre on the arc in contact, half-angle beta, with phi = beta sin(psi): the root at the end of the arc
    becomes smooth.
    """
    h, A = height, abs(amplitude)
    if h <= -A:
        return 0.0
    if A == 0.0:
        return float(of(h, shape))
    beta = math.pi if h >= A else 2.0 * math.asin(math.sqrt(0.5 * (A + h) / A))
    phi = beta * _SIN
    if h >= A:
        z = h + A * np.cos(phi)
    else:  # h + A cos(phi) = A (cos phi - cos beta), without cancellation
        z = 2.0 * A * np.sin(0.5 * (beta + phi)) * np.sin(0.5 * (beta - phi))
    return float(beta / math.pi * np.dot(_RATE, of(z, shape)))


def riding_height(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return h in m, the mean approach of each contact at which <sum P_i> is the preload (preload > 0).

    Negative when the slider hops: it rides above the undisturbed surface.
    """
    amplitudes = [abs(orbit.normal) for orbit in as_orbits(orbits)]
    shape, target = slider.contact_shape, slider.preload / slider.normal_stiffness
    high = slider.rest_approach(len(amplitudes))
    low = -max(amplitudes)
    if high == 0.0 or low == 0.0:
        return high if low == 0.0 else low

    # Convexity of p: the mean at z0 is at least p(z0) itself, so [low, high] brackets the root. The approach with the
    # mean load is nearly straight in h, and Newton's method from above on it takes a few steps.
    h = high
    for _ in range(100):
        mean = sum(mean_load(h, A, shape) for A in amplitudes)
        if mean > target:
            high = h
        else:
            low = h
        slope = sum(mean_load(h, A, shape, normal.slope) for A in amplitudes)
        step = math.inf
        if mean > 0.0:
            z = normal.approach(mean, shape)
            step = float((normal.approach(target, shape) - z) * normal.slope(z, shape) / slope)
        if abs(step) <= 2e-15 * (abs(h) + max(amplitudes)) or high - low <= 4e-16 * (abs(low) + abs(high)):
            break
        h = h + step if low < h + step < high else 0.5 * (low + high)
    return h


def release_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the factor on all orbits at which the first contact is lost once per cycle; inf without normal motion."""
    amplitudes = np.array([abs(orbit.normal) for orbit in as_orbits(orbits)])
    top = float(np.max(amplitudes))
    if top == 0.0:
        return math.inf
    shape = slider.contact_shape
    mean = sum(mean_load(1.0, float(A) / top, shape) for A in amplitudes)
    return float(normal.approach(slider.preload / mean / slider.normal_stiffness, shape)) / top


def threshold_factor(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the factor on all orbits above which the slider cannot be held without slip.

    Zero without friction; inf without motion. With a load larger than friction can hold at rest it is zero.
    """
    listed = as_orbits(orbits)
    if all(orbit.normal == 0 and orbit.tangential == 0 for orbit in listed):
        return math.inf
    if (
        slider.limit_slope == 0.0
        or slider.preload == 0.0
        or slider.load >= slider.friction_coefficient * slider.preload
    ):
        return 0.0
    c = slider.limit_slope
    # room for the offsets: h over the factor is fixed where it ends, and the preload gives the factor
    end = max(abs(o.tangential - c * o.normal) + abs(o.tangential + c * o.normal) for o in listed) / (2.0 * c)
    unit = max(end, max(abs(o.normal) for o in listed))
    shape = slider.contact_shape
    mean = sum(mean_load(end / unit, abs(o.normal) / unit, shape) for o in listed)
    most = float(normal.approach(slider.preload / mean / slider.normal_stiffness, shape)) / unit
    if _holding_margin(slider, listed, most * (1.0 - 1e-9)) >= 0.0:
        return most
    return _bracketed_root(lambda factor: _holding_margin(slider, listed, factor), 0.0, most)


def release_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit, in m, at which a contact is first lost once per cycle.

    The orbits are scaled together; only their ratios and phases matter.
    """
    return release_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def threshold_amplitude(slider: Slider, orbits: Orbit | tuple[Orbit, ...]) -> float:
    """Return the amplitude |u_z| of the first orbit, in m, above which the slider starts to move.

    The orbits are scaled together; only their ratios and phases matter. `threshold_factor` serves where u_z is zero.
    """
    return threshold_factor(slider, orbits) * abs(as_orbits(orbits)[0].normal)


def _holding_margin(slider, orbits, factor):
    """Return a margin, positive while all contacts stick and the load is held; it falls through zero with factor.

    It is the least of the room left for the offsets and of the distances of the load from the mean tractions that
    the highest and the lowest offsets give.
    """
    c, mu = slider.limit_slope, slider.friction_coefficient
    scaled = tuple(orbit.scaled(factor) for orbit in orbits)
    h = riding_height(slider, scaled)
    load = math.copysign(slider.load, sum(orbit.crest_velocity for orbit in orbits))
    phase = np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 512, endpoint=False))
    room, highest, lowest = math.inf, 0.0, 0.0
    for orbit in scaled:
        up = c * h - abs(orbit.tangential - c * orbit.normal)
        down = c * h - abs(orbit.tangential + c * orbit.normal)
        room = min(room, 0.5 * (up + down) / (c * slider.rest_approach(len(orbits))))
        z = h + (orbit.normal * phase).real
        u_x = (orbit.tangential * phase).real
        friction = mu * slider.normal_stiffness
        highest += float(np.mean(tangential_force(u_x + up, z, friction, c, slider.contact_shape)))
        lowest += float(np.mean(tangential_force(u_x - down, z, friction, c, slider.contact_shape)))
    scale = mu * slider.preload
    return min(room, (highest - load) / scale, (load - lowest) / scale)


def _bracketed_root(function, low, high):
    """Return the root of a monotone function between `low` and `high` to rounding (regula falsi, Illinois)."""
    f_low, f_high = function(low), function(high)
    if f_low == 0.0:
        return low
    if f_high == 0.0:
        return high
    if (f_low > 0.0) == (f_high > 0.0):
        raise ConvergenceError(
            "not converged", f"no change of sign between {low} and {high} m; check the amplitudes"
        )
    last = math.inf
    for count in range(300):
        x = high - f_high * (high - low) / (f_high - f_low)
        if count % 4 == 3 or not (min(low, high) < x < max(low, high)):
            x = 0.5 * (low + high)
        f = function(x)
        if f == 0.0 or abs(high - low) <= 1e-14 * (abs(low) + abs(high)) or abs(x - last) <= 1e-15 * abs(x):
            return x
        last = x
        if (f > 0.0) == (f_high > 0.0):
            high, f_high, f_low = x, f, 0.5 * f_low
        else:
            low, f_low, f_high = x, f, 0.5 * f_high
    return 0.5 * (low + high)
