"""The period, or the frequency, at which a transducer radiates the strongest surface wave.

The transducer stands alone on the stator's section, which is taken as infinite on both sides.  Coupled-mode theory for
the half-space (coupled_modes.py; the charges of quasistatic.py if the fingers do not simply alternate) gives a first
guess of the product of frequency and period at which the power per volt in the surface wave is largest.  Modes of a
plate and unusual patterns split the passband.  The power of the discretised stator is therefore scanned two bandwidths
1/N to either side of the guess, and Brent's method refines the highest maxima of the scan.

Only the power of the surface wave counts, not the whole conductance: loss in the solid and bulk waves would shift the
maximum of a transducer with few fingers to much longer periods.  The coarsest level gives the maximum to 4e-4, which
suffices for few pairs; from MANY_PAIRS on, where the passband is narrower, the next level gives it to 1e-5 (PZT-8 and
LiNbO3).
"""

import logging
from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from fem.analytic.coupled_modes import relative_amplitude
from fem.analytic.half_space import automatic_period
from fem.analytic.layered_wave import bound_period
from fem.analytic.quasistatic import transducer_estimate
from fem.condense.transducer import Condensation, transducer_superelements
from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS
from fem.geometry import Stator, Transducer
from fem.threads import one_blas_thread
from fem.waveguide.guided_modes import GuidedModes, guided_modes, power
from fem.waveguide.port_fields import PortFields, joined_cascade, stator_cascade

LOGGER = logging.getLogger(__name__)

MANY_PAIRS = 25  # finger pairs from which the finer level is used
SCAN, STEP = 2.0, 0.2  # half-width of the scan and its step, over the relative width 1/N of the passband
MIN_SCAN = 0.25  # lower limit of the scan over the first guess, for few fingers
CELL_REACH = 0.4  # of the scan of a cell of three fingers: its second harmonic is as strong as the first one
RIVAL = 0.9  # a second local maximum of the scan is refined too if it exceeds this share of the highest
ACCURACY = 1e-4  # of the position of the maximum, over the width of the passband: the power is flat there
MAX_GUESS_RANGE = 0.45  # relative range in which the first guess is sought, for few fingers
GRID = 801  # points in that range
FREQUENCY_STEPS = 4  # of the fixed point of frequency and velocity of a wave on layers


def best_period(stator: Stator, transducer: Transducer, frequency: float) -> float:
    """Return the period at which a transducer radiates most power into the surface wave, per volt, at a frequency.

    Parameters
    ----------
    stator : Stator
        Its ends are taken as absorbing.
    transducer : Transducer
        With fingers of both electrodes; its period is ignored.
    frequency : float
        Hz.

    Returns
    -------
    float
        m.

    Raises
    ------
    ConvergenceError
        If the cut has no Rayleigh wave on a half-space.

    Examples
    --------
    >>> from fem import Stator, Transducer, best_period, material, rotated
    >>> stator = Stator(solid=rotated(material("PZT-8"), "Z"), length=0.1, thickness=5e-3, ends="free")
    >>> transducer = Transducer(name="t", center=0.05, finger_pairs=10, period=1e-3, metallisation=0.5, aperture=0.02)
    >>> round(best_period(stator, transducer, 2.2e6) * 1e3, 3)
    0.981
    """
    return _best_period(*_alone(stator, replace(transducer, period=1.0)), float(frequency))


def best_frequency(stator: Stator, transducer: Transducer) -> float:
    """Return the frequency in Hz at which a transducer radiates most power into the surface wave, per volt."""
    return _best_frequency(*_alone(stator, transducer))


@lru_cache(256)
@one_blas_thread
def _best_period(stator: Stator, transducer: Transducer, frequency: float) -> float:
    unit = stator.slowest_wavelength(frequency)
    guess = _guess(stator, transducer, frequency) / frequency
    scale = replace(transducer, period=guess).finger_width / 2

    @cache
    def section_at(level: Resolution) -> tuple[Condensation, GuidedModes]:
        section = discretise(stator, level, wavelength=unit, surface_scale=scale)
        return Condensation(section, frequency), guided_modes(section, frequency)

    def power_at(period: float, level: Resolution) -> float:
        condensation, modes = section_at(level)
        alone, own = _alone(stator, replace(transducer, period=period))
        pieces = transducer_superelements(condensation, alone, (own,), level)
        return surface_power(joined_cascade(alone, (own,), pieces, modes=modes, resolution=level).solved())

    return _maximise(power_at, guess, transducer)


@lru_cache(256)
@one_blas_thread
def _best_frequency(stator: Stator, transducer: Transducer) -> float:
    def power_at(frequency: float, level: Resolution) -> float:
        return surface_power(stator_cascade(stator, (transducer,), frequency=frequency, resolution=level).solved())

    return _maximise(power_at, _guess(stator, transducer) / transducer.period, transducer)


def surface_power(fields: PortFields) -> float:
    """Power in W per V^2 (peak) and metre of aperture that a transducer alone radiates in the surface wave."""
    modes, surface = fields.modes, fields.modes.rayleigh
    (before,), (after,) = fields.segments
    right, left = after.right[surface], before.left[surface]
    outward = power(modes.right[:, surface] @ right, modes.right_flux[:, surface] @ right, fields.frequency)
    outward -= power(modes.left[:, surface] @ left, modes.left_flux[:, surface] @ left, fields.frequency)
    return float(outward[0]) * fields.section.solid.stress_unit


def _alone(stator: Stator, transducer: Transducer) -> tuple[Stator, Transducer]:
    """Place the transducer in the middle of a section with absorbing ends.

    Name, position and aperture are normalised, so that equal transducers share an entry of the cache; an apodised or
    slanted one stands for its middle line.
    """
    length = (transducer.finger_pairs + 2) * transducer.period
    return replace(stator, length=length, ends="absorbing", pieces=()), replace(
        transducer, name="alone", center=length / 2, aperture=1.0, termination="open", overlaps=None, slant=0.0
    )


def _guess(stator: Stator, transducer: Transducer, frequency: float | None = None) -> float:
    """Return the product of frequency and period in m/s for a half-space.

    ``frequency``: in Hz; None if the period is known. With layers the product depends on it, and reflections, which
    shift it little, are left out.
    """
    if stator.layers:
        known = frequency or automatic_period(stator.solid, 1.0, transducer.metallisation) / transducer.period
        for _ in range(1 if frequency else FREQUENCY_STEPS):
            product = bound_period(stator, known, transducer.metallisation) * known
            known = product / transducer.period
        return product
    solid, surface = stator.solid, stator.bare_surface
    velocity = automatic_period(solid, 1.0, transducer.metallisation)
    half_range = min(1 / transducer.finger_pairs, MAX_GUESS_RANGE)
    if transducer.cell != "plain":
        half_range = min(half_range, CELL_REACH)
    products = velocity * np.linspace(1 - half_range, 1 + half_range, GRID)
    of_unit_period = replace(transducer, period=1.0)
    if transducer.pattern is None and not transducer.split and transducer.even:
        power = relative_amplitude(solid, of_unit_period, products, surface=surface)
    else:
        power = transducer_estimate(solid, of_unit_period, surface).conductance(products)
    return float(products[np.argmax(power)])


def _maximise(power_at: Callable[[float, Resolution], float], guess: float, transducer: Transducer) -> float:
    """Return the argument of the largest power within SCAN / N of a guess and above MIN_SCAN times the guess."""
    from scipy.optimize import minimize_scalar

    pairs = transducer.finger_pairs
    level = LEVELS[int(pairs >= MANY_PAIRS)]
    count, reach = 2 * round(SCAN / STEP) + 1, SCAN / pairs
    if transducer.cell != "plain":
        reach = min(reach, CELL_REACH)
    scan = guess * np.linspace(max(1 - reach, MIN_SCAN), 1 + reach, count)
    power = np.empty(count)
    for k, value in enumerate(scan.tolist()):
        LOGGER.debug("trial %d of %d", k + 1, count)
        power[k] = power_at(value, LEVELS[0])
    LOGGER.debug("between the best trials")
    padded = np.concatenate([[-np.inf], power, [-np.inf]])
    peaks = np.flatnonzero((power >= padded[:-2]) & (power >= padded[2:]) & (power >= RIVAL * power.max()))
    highest = peaks[np.argsort(-power[peaks])][:2]
    maxima = [
        minimize_scalar(
            lambda value: -power_at(float(value), level),
            bounds=(scan[max(peak - 1, 0)], scan[min(peak + 1, count - 1)]),
            method="bounded",
            options={"xatol": ACCURACY / pairs * guess},
        )
        for peak in highest
    ]
    return float(min(maxima, key=lambda maximum: maximum.fun).x)
