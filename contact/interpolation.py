"""Barycentric interpolation between Chebyshev-Lobatto points (Berrut and Trefethen, SIAM Review 46 (2004) 501)."""

from contact.jit.compiled import compiled


@compiled
def interpolate(s, sigma, bary, values):
    """Return the interpolating polynomial at s (barycentric formula)."""
    above, below = 0.0, 0.0
    for k in range(sigma.size):
        gap = s - sigma[k]
        if gap == 0.0:
            return values[k]
        weight = bary[k] / gap
        above += weight * values[k]
        below += weight
    return above / below
