"""The amplitude of the waves from which on a slider in the plane moves.

Below it every contact sticks at least once in a period, and the slider at rest can carry a convex set of forces and
torques about zero, a disc for one contact. It moves where that set no longer holds the load, at the latest where all
contacts open: across the wave there is no threshold then.
"""

import math

from contact.plane.averaged import Averaged, held_rest
from contact.plane.plane_waves import Surface, SurfaceWaves, surface_under
from contact.plane.scaling import refuse_slow_beat
from contact.plane.steady_state import refuse
from contact.slider import Slider

# Relative, of the factor. Just above the threshold of a slider without a load the force of rest rises with a power of
# about 2.5: 1e-9 of the friction, which `rest.settled` takes for none, is 2e-4 of the factor, by which it is too large
ACCURACY = 4e-4
LARGEST = 1e9  # of the first guess, up to which a factor is sought


def threshold_factor(slider: Slider, surface: Surface) -> float:
    """Return the factor on the amplitudes of all waves from which on the slider moves in the mean.

    0 where its load moves it without waves; inf where no wave does. As the averaged motion, it is first order in
    (f_n/f)^2.

    Examples
    --------
    >>> slider = Slider(
    ...     radius=1e-3, mass=math.inf, preload=0.87309e-3, load=(0.0, 0.0), friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    ... )
    >>> wave = SurfaceWaves(frequencies=[2.2e6], amplitudes=[[[-0.67e-9j, 0.0, 1e-9]]])
    >>> print(f"{threshold_factor(slider, wave):.2f} nm")
    0.74 nm
    """
    refuse(slider)
    waves = surface_under(slider, surface)
    refuse_slow_beat(slider, waves)
    reach = float(abs(waves.amplitudes).max())
    if reach == 0.0:
        return math.inf if _held(slider, waves, 0.0) else 0.0
    if not _held(slider, waves, 0.0):
        return 0.0
    first = float(slider.rest_approaches(waves.count).max()) / reach
    low, high = 0.0, first
    while _held(slider, waves, high):
        low, high = high, 2.0 * high
        if high > LARGEST * first:
            return math.inf
    while high - low > ACCURACY * high:
        middle = 0.5 * (low + high)
        low, high = (middle, high) if _held(slider, waves, middle) else (low, middle)
    return 0.5 * (low + high)


def _held(slider: Slider, waves: SurfaceWaves, factor: float) -> bool:
    averaged = Averaged.of(slider, waves.scaled(factor))
    return held_rest(averaged) is not None
