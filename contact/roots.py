r"""Roots of a scalar function between two points, and of the interpolant of values at the nodes of a segment.

*Bracketed roots* (`bracketed`): regula falsi with the modification of Anderson and Bjorck (BIT 13 (1973) 253), and
every twelfth step a bisection. A loop that evaluates the function itself uses its two halves: `trial` returns the next
point, and `narrowed` the new bracket.

*Roots of an interpolant* (`first_root`): values at Chebyshev-Lobatto points in sigma on [-1, 1] define a polynomial
(barycentric formula, Berrut and Trefethen, SIAM Review 46 (2004) 501). Here the function is a *guard*, which is
positive as long as the regime of a contact lasts, so that its first root is an event. Between two nodes it may also
turn negative and positive again, or touch zero; this is searched where the values and slopes at the nodes allow it.

`sigma` (n,) are the nodes, `bary` (n,) their barycentric weights, `values` (n,) those of the function at the nodes, and
`rates` (n, n) the matrix that takes values to their derivatives in sigma (`events.collocation`).
"""

from contact.jit.compiled import compiled, formula

# Rounding of a guard, which is a difference of lengths of order one. Guards are shifted by as much
# (`law.elastic.FAR_SIDE`), so that one that begins at zero begins here.
ROUNDING = 1e-15


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


def bracketed(function, a: float, b: float, *, tolerance: float = 0.0) -> float:
    """Return the root of a function between two points at which its signs differ, to rounding or a tolerance."""
    fa, fb = function(a), function(b)
    if fa == 0.0:
        return a
    for count in range(200):
        if fb == 0.0 or abs(b - a) <= tolerance + 4e-16 * (abs(a) + abs(b)):
            break
        x = trial(a, fa, b, fb, count)
        if abs(x - b) <= tolerance + 1e-15 * abs(x):
            return x
        a, fa, b, fb = narrowed(a, fa, b, fb, x, function(x))
    return b


@formula
def trial(a, fa, b, fb, count):
    """Return the next point at which a bracketed function is evaluated: the secant's zero, or the middle."""
    x = b - fb * (b - a) / (fb - fa)
    if not min(a, b) < x < max(a, b) or count % 12 == 11:
        x = 0.5 * (a + b)
    return x


@formula
def narrowed(a, fa, b, fb, x, f):
    """Return the bracket (a, fa, b, fb) with the value f at x, which becomes b.

    If a stays, fa is reduced by Anderson and Bjorck's factor, so that the next secant does not end on the same side.
    """
    if (f > 0.0) == (fb > 0.0):
        factor = 1.0 - f / fb
        return a, fa * (factor if factor > 0.0 else 0.5), x, f
    return b, fb, x, f


@compiled
def root(a, b, sigma, bary, values):
    """Return the root of the interpolant between a (positive side) and b (negative side) to 1e-9.

    The method is regula falsi, Illinois variant.
    """
    fa = interpolate(a, sigma, bary, values)
    fb = interpolate(b, sigma, bary, values)
    if not fa > 0.0:
        return a
    for _ in range(60):
        m = b - fb * (b - a) / (fb - fa)
        fm = interpolate(m, sigma, bary, values)
        if fm > 0.0:
            if b - m < 1e-9:
                return m
            a, fa, fb = m, fm, 0.5 * fb
        else:
            if m - a < 1e-9:
                return m
            b, fb, fa = m, fm, 0.5 * fa
        if b - a < 1e-9:
            return b
    return b


@compiled
def largest(values):
    """Return the largest magnitude."""
    result = 0.0
    for k in range(values.size):
        result = max(result, abs(values[k]))
    return result


@compiled
def _wiggles(u, v, du, dv):
    """Return True if the cubic with the end values u, v and end slopes du, dv (times width) has an extremum inside."""
    quadratic, linear = 3.0 * (2.0 * (u - v) + du + dv), 2.0 * (3.0 * (v - u) - 2.0 * du - dv)
    if (du < 0.0) != (dv < 0.0):
        return True
    if quadratic == 0.0 or linear * linear < 4.0 * quadratic * du:
        return False
    return 0.0 < -0.5 * linear / quadratic < 1.0


@compiled
def first_root(sigma, bary, rates, values, searched):
    """Return the smallest sigma at which a guard turns negative; 2.0, outside of [-1, 1], if it does not.

    `searched`: number of nodes up to which it is searched.

    An interval between two nodes is searched for further roots if the cubic through the values and slopes at its ends
    has an extremum inside and may come close to zero.
    """
    n = sigma.size
    for j in range(1, searched):
        low = min(values[j - 1], values[j])
        # First a cheap estimate of how far the cubic reaches below its ends, because a slope costs a sum over all nodes
        steps = abs(values[j] - values[j - 1])
        if j > 1:
            steps = max(steps, abs(values[j - 1] - values[j - 2]))
        if j < n - 1:
            steps = max(steps, abs(values[j + 1] - values[j]))
        if low < 2.0 * steps:
            width = sigma[j] - sigma[j - 1]
            before, slope = _slope(rates, j - 1, values), _slope(rates, j, values)
            near = low < 0.5 * width * max(abs(before), abs(slope))
            if near and j == 1 and values[0] < 1e-12 * largest(values) + 4.0 * ROUNDING:
                # the guard is zero where the regime begins: a dip there would be the interpolation's own error
                near = False
            if near and _wiggles(values[j - 1], values[j], before * width, slope * width):
                dip = _searched(sigma[j - 1], sigma[j], sigma, bary, values)
                if dip < 2.0:
                    return dip
        if values[j] < 0.0:
            return root(sigma[j - 1], sigma[j], sigma, bary, values)
    return 2.0


@compiled
def _slope(rates, j, values):
    """Return the derivative in sigma at node j."""
    slope = 0.0
    for k in range(values.size):
        slope += rates[j, k] * values[k]
    return slope


@compiled
def _searched(start, stop, sigma, bary, values):
    """Return the first sigma between two nodes at which the interpolant turns negative, 2.0 if it does not.

    Values within the rounding of the interpolation do not count as negative: a guard that starts from zero with zero
    slope has no root there.
    """
    rounding = -1e-13 * largest(values) - ROUNDING
    parts = 8
    step = (stop - start) / parts
    left, middle = interpolate(start - step, sigma, bary, values), interpolate(start, sigma, bary, values)
    for m in range(parts + 1):
        if m > 0 and middle < rounding:
            return root(start + (m - 1) * step, start + m * step, sigma, bary, values)
        right = interpolate(start + (m + 1) * step, sigma, bary, values)  # for the last m beyond the interval
        if middle <= left and middle <= right:  # golden section for a negative dip
            a, b = max(start + (m - 1) * step, start), min(start + (m + 1) * step, stop)
            for _ in range(40):
                p, q = a + 0.381966011250105 * (b - a), b - 0.381966011250105 * (b - a)
                f, g = interpolate(p, sigma, bary, values), interpolate(q, sigma, bary, values)
                if min(f, g) < rounding:
                    return root(max(start + (m - 1) * step, start), p if f < rounding else q, sigma, bary, values)
                if f < g:
                    b = q
                else:
                    a = p
        left, middle = middle, right
    return 2.0
