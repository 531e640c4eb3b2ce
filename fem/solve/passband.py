"""The period, or the frequency, at which a transducer radiates the strongest surface wave.

The transducer stands alone on the stator's section, which continues without end on both sides.  The power per volt that
leaves it in the surface wave is largest near the product of frequency and period that coupled modes (coupled_modes.py;
the charges of quasistatic.py where fingers do not simply alternate) give for the half-space.  Modes of a plate and
unusual patterns split the passband, so that of the discretised stator is scanned two bandwidths 1/N to either side of
there, and Brent's method follows the highest maxima of the scan.  The power is the whole conductance but for the loss
in the solid and for bulk waves, which in rows of few fingers would draw the maximum to much longer periods.  A coarse
level serves for the scan and for the place of a maximum: the next one moves it by 4e-4; from MANY_PAIRS on, where the
passband is narrower, that next level is taken, whose place is known to 1e-5 (PZT-8 and LiNbO3).
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cache, lru_cache

import numpy as np

from fem.analytic.coupled_modes import relative_amplitude
from fem.analytic.half_space import automatic_period
from fem.analytic.quasistatic import transducer_estimate
from fem.condense.transducer import Condensation, transducer_superelements
from fem.discretize.elements import discretise
from fem.discretize.grading import Resolution
from fem.discretize.refinement import LEVELS
from fem.geometry import Stator, Transducer
from fem.materials.christoffel import slowest_wavelength
from fem.threads import one_blas_thread
from fem.waveguide.modes import GuidedModes, guided_modes, power
from fem.waveguide.port_fields import PortFields, joined_fields, solve_ports

MANY_PAIRS = 25
SCAN, STEP = 2.0, 0.2  # of the scan to either side, and its step, over the relative width 1/N of the passband
SHORTEST = 0.25  # of the first guess: where the scan of a few fingers begins
RIVAL = 0.9  # of the scan's highest value: a second local maximum above it is followed too
ACCURACY = 1e-4  # of the place of the maximum, over that width: the power is flat there
WIDEST = 0.45  # relative range in which the first guess is sought, for transducers of few fingers
GRID = 801  # places of the guess in that range


def best_period(stator: Stator, transducer: Transducer, frequency: float) -> float:
    """Return the period at which a transducer radiates most power into the surface wave, per volt, at a frequency.

    Parameters
    ----------
    stator : Stator
        Its ends are taken as absorbing.
    transducer : Transducer
        Alone on it, with fingers of both electrodes; its period is not read.
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
    >>> row = Transducer(name="t", center=0.05, finger_pairs=10, period=1e-3, metallisation=0.5, aperture=0.02)
    >>> round(best_period(stator, row, 2.2e6) * 1e3, 3)
    0.981
    """
    return _best_period(*_alone(stator, replace(transducer, period=1.0)), float(frequency))


def best_frequency(stator: Stator, transducer: Transducer) -> float:
    """Return the frequency in Hz at which a transducer radiates most power into the surface wave, per volt."""
    return _best_frequency(*_alone(stator, transducer))


@lru_cache(256)
@one_blas_thread
def _best_period(stator: Stator, transducer: Transducer, frequency: float) -> float:
    unit = slowest_wavelength(stator.solid, frequency)
    guess = _guess(stator, transducer) / frequency
    scale = replace(transducer, period=guess).finger_width / 2

    @cache
    def of_level(level) -> tuple[Condensation, GuidedModes]:
        section = discretise(stator, level, wavelength=unit, surface_scale=scale)
        return Condensation(section, frequency), guided_modes(section, frequency)

    def power_at(period: float, level) -> float:
        make, modes = of_level(level)
        alone, row = _alone(stator, replace(transducer, period=period))
        pieces = transducer_superelements(make, alone, (row,), level)
        return surface_power(joined_fields(alone, (row,), pieces, modes=modes, resolution=level))

    return _largest(power_at, guess, transducer)


@lru_cache(256)
@one_blas_thread
def _best_frequency(stator: Stator, transducer: Transducer) -> float:
    def power_at(frequency: float, level) -> float:
        return surface_power(solve_ports(stator, (transducer,), frequency=frequency, resolution=level))

    return _largest(power_at, _guess(stator, transducer) / transducer.period, transducer)


def surface_power(fields: PortFields) -> float:
    """Power in W per V^2 (peak) and metre of aperture that a lone transducer sends out in the surface wave."""
    modes, chosen = fields.modes, fields.modes.rayleigh
    (before,), (after,) = fields.segments
    right, left = after.right[chosen], before.left[chosen]
    outward = power(modes.right[:, chosen] @ right, modes.right_flux[:, chosen] @ right, fields.frequency)
    outward -= power(modes.left[:, chosen] @ left, modes.left_flux[:, chosen] @ left, fields.frequency)
    return float(outward[0]) * fields.section.solid.stress_unit


def _alone(stator: Stator, transducer: Transducer) -> tuple[Stator, Transducer]:
    """Return the transducer in the middle of a section without ends; equal for transducers of one kind."""
    length = (transducer.finger_pairs + 2) * transducer.period
    return replace(stator, length=length, ends="absorbing", pieces=()), replace(
        transducer, name="alone", center=length / 2, aperture=1.0, termination="open"
    )


def _level(transducer: Transducer):
    return LEVELS[int(transducer.finger_pairs >= MANY_PAIRS)]


def _guess(stator: Stator, transducer: Transducer) -> float:
    """Return the product of frequency and period in m/s for a half-space."""
    solid, surface = stator.solid, stator.bare_surface
    velocity = automatic_period(solid, 1.0, transducer.metallisation)
    reach = min(1 / transducer.finger_pairs, WIDEST)
    products = velocity * np.linspace(1 - reach, 1 + reach, GRID)
    row = replace(transducer, period=1.0)
    if transducer.pattern is None and not transducer.split:
        power = relative_amplitude(solid, row, products, surface=surface)
    else:
        power = transducer_estimate(solid, row, surface).conductance(products)
    return float(products[np.argmax(power)])


def _largest(power_at: Callable[[float, Resolution], float], guess: float, transducer: Transducer) -> float:
    """Return where the power is largest within SCAN / N of a guess (and above SHORTEST of it)."""
    from scipy.optimize import minimize_scalar

    pairs, level = transducer.finger_pairs, _level(transducer)
    count = 2 * round(SCAN / STEP) + 1
    scan = guess * np.linspace(max(1 - SCAN / pairs, SHORTEST), 1 + SCAN / pairs, count)
    power = np.array([power_at(float(at), LEVELS[0]) for at in scan])
    beside = np.concatenate([[-np.inf], power, [-np.inf]])
    peaks = np.flatnonzero((power >= beside[:-2]) & (power >= beside[2:]) & (power >= RIVAL * power.max()))
    highest = peaks[np.argsort(-power[peaks])][:2]
    found = [
        minimize_scalar(
            lambda at: -power_at(float(at), level),
            bounds=(scan[max(peak - 1, 0)], scan[min(peak + 1, count - 1)]),
            method="bounded",
            options={"xatol": ACCURACY / pairs * guess},
        )
        for peak in highest
    ]
    return float(min(found, key=lambda each: each.fun).x)
