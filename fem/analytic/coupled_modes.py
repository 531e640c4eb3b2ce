"""Wave amplitude of a transducer against frequency, with the reflections of its own fingers: coupled modes.

Massless strips reflect the wave because they short-circuit its field. In an endless grating of shorted strips, one per
pitch p, the two standing waves of wavelength 2 p have the velocities v_free (1 - e dv/v),

    e = (1 - cos D)/2        potential odd about the strips,                    D = pi metallisation
    e = (1 + cos D)/2 + x    even: driven by the two electrodes,                x = P_1/2(-cos D) / P_-1/2(-cos D)   (1)

to first order in dv/v: K. Blotekjaer, K. A. Ingebrigtsen and H. Skeie, IEEE Trans. Electron Devices 20 (1973) 1133.
Between these edges of the stop band the grating reflects. Let d = (omega - omega_0)/v be the detuning from their middle
and k the reflection per length. Its size is half the width of the stop band in d, and it is negative because the driven
standing wave is the slower one. The waves R exp(-i pi x/p) to the right and S exp(+i pi x/p) to the left obey

    R' = -i d R + i k S + i a V,    S' = -i k R + i d S - i a V,    R(0) = S(L) = 0,                              (2)

with a the excitation per length and volt, V the voltage and L the length of the transducer (D. P. Morgan, Surface
Acoustic Wave Filters, 2nd ed. 2007, chapter 8). The sign of k decides on which side of the middle the maximum lies.
"""

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.geometry import Transducer
from fem.materials import Solid

__all__ = ["leaving", "relative_amplitude", "stop_band_edges"]


def stop_band_edges(metallisation: float) -> tuple[float, float]:
    """Return e of the odd and of the even standing wave in a grating of shorted strips: equation (1).

    Examples
    --------
    >>> [round(edge, 4) for edge in stop_band_edges(0.5)]
    [0.5, 0.9569]
    """
    cos = np.cos(np.pi * metallisation)
    return float((1 - cos) / 2), float((1 + cos) / 2 + _legendre_ratio(-cos))


def relative_amplitude(
    solid: Solid, transducer: Transducer, frequency: np.ndarray, *, surface: str = "vacuum"
) -> np.ndarray:
    """Return the amplitude of the wave that leaves a transducer, against frequency, in arbitrary units.

    Parameters
    ----------
    solid : Solid
        In the stator's frame, piezoelectric.
    transducer : Transducer
        Of alternate fingers, two to a period.
    frequency : ndarray
        Hz, near v / period.
    surface : str
        Of the bare parts: "vacuum" or "open" (D_n = 0).

    Returns
    -------
    ndarray
        Positive, of the shape of ``frequency``.

    Raises
    ------
    ConvergenceError
        If the cut has no Rayleigh wave.
    """
    free, metallised = (rayleigh(solid, each).velocity for each in (surface, "metallised"))
    odd, even = (free - edge * (free - metallised) for edge in stop_band_edges(transducer.metallisation))
    velocity = (odd + even) / 2
    length = transducer.finger_pairs * transducer.period
    detuning = 2 * np.pi * (np.asarray(frequency, dtype=float) / velocity - 1 / transducer.period) * length
    coupling = -np.pi * (odd - even) / velocity * length / transducer.period
    return leaving(detuning, coupling)


def leaving(detuning: np.ndarray, coupling: float) -> np.ndarray:
    """Return |S(0)| by equations (2) for a V L = 1; ``detuning``: d L, ``coupling``: k L, both without unit."""
    g = np.sqrt((detuning**2 - coupling**2).astype(complex))
    small = abs(g) < 1e-4
    g = np.where(small, 1.0, g)
    cos = np.where(small, 1.0, np.cos(g))
    sine = np.where(small, 1.0, np.sin(g) / g)  # sin(g)/g
    versine = np.where(small, 0.5, (1 - np.cos(g)) / g**2)
    # A = i [[-d, k], [-k, d]], b = i (1, -1): exp(A) = cos(g) I + sin(g)/g A, the integral of exp(s A) over
    # s from 0 to 1 is sin(g)/g I + (1 - cos g)/g^2 A
    driven = -1j * sine + versine * (coupling + detuning)
    return abs(driven / (cos + 1j * detuning * sine))


def _legendre_ratio(x: float) -> float:
    """P_1/2 / P_-1/2 = 2 E / K - 1 for the parameter (1 - x) / 2, by the arithmetic-geometric mean."""
    ratio, weight, above, below = (1 + x) / 2, 1.0, 1.0, np.sqrt((1 + x) / 2)
    for _ in range(10):
        difference = (above - below) / 2
        above, below, weight = (above + below) / 2, np.sqrt(above * below), 2 * weight
        ratio -= weight * difference**2
    return ratio
