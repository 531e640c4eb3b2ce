"""Selection of the surface wave among the guided modes of a section.

The surface wave is the mode whose motion is most localised at the surface, with a wavenumber near that of the
half-space.  In a plate with two equal faces it is split into two modes of nearly equal wavenumbers, which
`solve.p_matrix_from_field.waves_of` and `solve.guided` combine to the wave of one face.

`CutSource.select_poles` (oblique waves) weighs modes in the same way, but accepts no twin by nearness alone (ONE_WAVE),
because its bulk waves may have nearly the wavenumber of the surface wave.  `Grating` selects among the waves of a
loaded surface, which are few, by localisation alone.
"""

import numpy as np

# Relative distance of k from that of the half-space at which a mode's localisation counts half
NEAR_HALF_SPACE = 0.02
# Two modes form the surface wave of a plate if their k differ relatively by less than ONE_WAVE, or by less than
# TWIN_MODES while the less localised one has at least the fraction TWIN_SHARE of the other's localisation.
ONE_WAVE, TWIN_MODES = 1e-3, 3e-2
TWIN_SHARE = 0.4


def weighed(share: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Localisations of modes, weighed by the relative ``distance`` of their k from the expected one."""
    return share / (1.0 + (distance / NEAR_HALF_SPACE) ** 2)


def surface_modes(
    wavenumbers: np.ndarray, share: np.ndarray, expected: float | None, lateral_wavenumber: complex = 0.0
) -> np.ndarray:
    """Select the surface wave among modes that propagate in one direction: their indices, most localised first.

    Parameters
    ----------
    wavenumbers : ndarray, shape (modes,)
        k_x.
    share : ndarray, shape (modes,)
        Squared motion at the surface over its integral through the depth.
    expected : float or None
        Approximate sqrt(k_x^2 + k_y^2) of the surface wave, such as that of the half-space, if it is known.
    lateral_wavenumber : complex
        k_y.
    """
    localised = share
    if expected is not None:
        total = np.sqrt(wavenumbers**2 + lateral_wavenumber**2) if lateral_wavenumber else wavenumbers
        localised = weighed(share, abs(total / expected - 1.0))
    best = int(np.argmax(localised))
    distance = abs(wavenumbers / wavenumbers[best] - 1)
    split = (distance < TWIN_MODES) & (localised > TWIN_SHARE * localised[best])
    selected = np.flatnonzero((distance < ONE_WAVE) | split)
    return selected[np.argsort(-localised[selected])]
