r"""One cycle of the wave under a flat pillar of a heavy slider, in closed form: means and first harmonics.

The pillar's approach is z = h + A cos phi (phi = 0 on the crest of u_z), its normal force P = k_n z while z > 0. Its
deformation x follows the surface, y = d cos phi + e sin phi - w phi with w = v/omega, and is kept within |x| <= c z
(a stop operator); Q = k_t x, c = mu k_n/k_t. Between events z and x are linear in (1, cos, sin, phi), so that every
integral is closed. The events (compare Feenstra and Breedveld, eq. 3):

* contact lasts over |phi| <= p, cos p = -h/A;
* slip towards s = +1, -1 goes on while g_s = s y' - c z' = alpha + beta cos phi + gamma sin phi > 0, one window of the
  cycle with a centre and a half-width in closed form;
* stick ends where D_s = c z - s x = 0. D_s' = -g_s, so D_s falls only inside the window of s: at most one root in it.

Normal part: <P> = k A (sin p - p cos p)/pi and P_1 = k A (p - sin p cos p)/pi. The work lost to friction is that of the
limit force on the slip, c z g_s, also a sum of closed integrals: it is not obtained from the energy balance, which
therefore checks it. `cycle_mean` takes the same cycle for any profile, by quadrature.
"""

import numpy as np

from contact.body import slip_window
from contact.codes import Slips
from contact.jit.compiled import compiled, native

TURN = 2.0 * np.pi
# Columns of `flat_cycles`: lengths in m, works in m^2 per radian of phase.
#   MEAN_APPROACH: <z>, of the contact, so <P> = k_n <z>;  FIRST_APPROACH: z_1, P_1 = k_n z_1 a/|a|
#   MEAN_STRETCH: <x>, <Q> = k_t <x>;  COS, SIN_STRETCH: x = ... + COS cos phi + SIN sin phi
#   FRICTION: <c z |slip|>, the power is k_t omega times this;  SHARE: part of the cycle in contact, also d<z>/dh
MEAN_APPROACH, FIRST_APPROACH, MEAN_STRETCH, COS_STRETCH, SIN_STRETCH, FRICTION, SHARE = range(7)
COLUMNS = 7
ROOT = 1e-9  # rad; forces are continuous at an event, so the integrals err by the square of it


@compiled
def _slip_start(path, c, s, window, x0, phi0, start, stop):
    """Return the first phase in (start, stop) at which stick from (x0, phi0) ends by slip towards s; stop if none."""
    h, A, d, e, w = path
    low, high, kind = window
    if kind == Slips.NEVER:
        return stop
    if kind == Slips.ALWAYS:
        low, high = start, stop
    else:
        shift = TURN * np.ceil((start + 1e-12 - high) / TURN)
        low, high = low + shift, high + shift
    base = c * h - s * (x0 - d * np.cos(phi0) - e * np.sin(phi0) + w * phi0)
    co, si, drift = c * A - s * d, -s * e, s * w
    scale = abs(c * h) + abs(c * A) + abs(d) + abs(e)
    while low < stop:
        a, b = max(low, start), min(high, stop)
        if b > a and base + co * np.cos(b) + si * np.sin(b) + drift * b < -1e-15 * scale:
            phi = 0.5 * (a + b)
            for _ in range(80):
                cos, sin = np.cos(phi), np.sin(phi)
                value = base + co * cos + si * sin + drift * phi
                rate = si * cos - co * sin + drift
                if value > 0.0:
                    a = phi
                else:
                    b = phi
                new = phi - value / rate if rate < 0.0 else b
                if abs(new - phi) < ROOT or b - a < 1e-14:
                    return min(max(new, a), b)
                phi = new if a < new < b else 0.5 * (a + b)
            return phi
        low, high = low + TURN, high + TURN
    return stop


@compiled
def _add(out, path, c, slip, x0, phi0, start, stop):
    """Add the integrals of a piece: slip towards `slip`, or stick (0) with x = x0 at phi0."""
    h, A, d, e, w = path
    c1, s1, c2, s2 = np.cos(start), np.sin(start), np.cos(stop), np.sin(stop)
    width = stop - start
    cos, sin = s2 - s1, c1 - c2
    cos_cos = 0.5 * (width + s2 * c2 - s1 * c1)
    cos_sin, sin_sin = 0.5 * (s2 * s2 - s1 * s1), width - cos_cos
    if slip != 0.0:
        base, co, si, drift = slip * c * h, slip * c * A, 0.0, 0.0
        alpha, beta, gamma = -slip * w, slip * e, c * A - slip * d
        out[FRICTION] += c * (
            h * alpha * width + (h * beta + A * alpha) * cos + h * gamma * sin + A * beta * cos_cos
            + A * gamma * cos_sin
        )  # fmt: skip
    else:
        base = x0 - d * np.cos(phi0) - e * np.sin(phi0) - w * (start - phi0)
        co, si, drift = d, e, -w
    # integrals of (phi - start) times 1, cos, sin
    t = 0.5 * width * width
    t_cos, t_sin = width * s2 - sin, cos - width * c2
    out[MEAN_STRETCH] += base * width + co * cos + si * sin + drift * t
    out[COS_STRETCH] += base * cos + co * cos_cos + si * cos_sin + drift * t_cos
    out[SIN_STRETCH] += base * sin + co * cos_sin + si * sin_sin + drift * t_sin


@compiled
def _normal(out, h, A):
    """Fill the normal part; return the half-width p of the contact's part of the cycle."""
    if h >= A:
        out[MEAN_APPROACH], out[FIRST_APPROACH], out[SHARE] = h, A, 1.0
        return np.pi
    p = 2.0 * np.arcsin(np.sqrt(0.5 * (h + A) / A))
    sin, cos = np.sin(p), np.cos(p)
    out[SHARE] = p / np.pi
    if p < 0.1:  # series: the closed form loses digits as p^-3 does
        q = p * p
        out[MEAN_APPROACH] = (
            A * p * q * (1.0 / 3.0 - q * (1.0 / 30.0 - q * (1.0 / 840.0 - q / 45360.0))) / np.pi
        )
        out[FIRST_APPROACH] = (
            A * p * q * (2.0 / 3.0 - q * (2.0 / 15.0 - q * (4.0 / 315.0 - q / 1417.5))) / np.pi
        )
        return p
    out[MEAN_APPROACH] = A * (sin - p * cos) / np.pi
    out[FIRST_APPROACH] = A * (p - sin * cos) / np.pi
    return p


@compiled
def flat_cycle(h, A, d, e, w, c, side, out):
    """Fill the columns of one contact; `side`: sign of a velocity that is zero, the motion which it comes from."""
    for k in range(COLUMNS):
        out[k] = 0.0
    if h <= -A:
        return
    p = _normal(out, h, A)
    path = h, A, d, e, w
    windows = slip_window(1.0, A, 0.0, d, e, w, c), slip_window(-1.0, A, 0.0, d, e, w, c)
    x = slip = 0.0
    if h < A:
        phi, stop = -p, p
        rate = d * np.sin(p) + e * np.cos(p) - w  # y' at phi = -p, where z' = A sin p
        sign = 1.0 if rate >= 0.0 else -1.0
        if sign * rate > c * A * np.sin(p):
            slip = sign
    else:
        # the drift stretches the contact backwards, so it slips that way up to the end of that window
        back = 1.0 if (w < 0.0 or (w == 0.0 and side < 0.0)) else -1.0
        _, phi, kind = windows[0] if back > 0.0 else windows[1]
        if kind != Slips.WINDOW:
            phi = 0.0
        stop, x = phi + TURN, back * c * (h + A * np.cos(phi))
        if kind == Slips.ALWAYS:
            slip = back
    for _ in range(60):
        if slip != 0.0:
            _, end, kind = windows[0] if slip > 0.0 else windows[1]
            if kind == Slips.WINDOW:
                end += TURN * np.ceil((phi + 1e-13 - end) / TURN)
            if kind != Slips.WINDOW or end > stop:
                end = stop
            _add(out, path, c, slip, 0.0, 0.0, phi, end)
            x, slip = slip * c * max(h + A * np.cos(end), 0.0), 0.0
        else:
            up = _slip_start(path, c, 1.0, windows[0], x, phi, phi, stop)
            end = _slip_start(path, c, -1.0, windows[1], x, phi, phi, up)
            _add(out, path, c, 0.0, x, phi, phi, end)
            x += d * (np.cos(end) - np.cos(phi)) + e * (np.sin(end) - np.sin(phi)) - w * (end - phi)
            if end < stop:
                slip = 1.0 if end == up else -1.0
        phi = end
        if phi >= stop:
            break
    out[MEAN_STRETCH] /= TURN
    out[FRICTION] /= TURN
    out[COS_STRETCH] /= np.pi
    out[SIN_STRETCH] /= np.pi


@native(
    "f1 f1 f1 f1 f1 f f f2", {name: "n" for name in ("height", "A", "d", "e", "limit_slope")} | {"out": "n 7"}
)
def flat_cycles(height, A, d, e, limit_slope, w, side, out):
    """Fill the columns of many contacts; returns 0.

    `height`: mean approach h of each, m; `A`, `d`, `e`: amplitudes of u_z = A cos phi and u_x = d cos phi + e sin phi,
    m; `limit_slope`: c; `w`: slider velocity over omega, m; `side`: see `flat_cycle`.
    """
    for i in range(height.size):
        flat_cycle(height[i], A[i], d[i], e[i], w, limit_slope[i], side, out[i])
    return 0


@native("f1 f1 f2", {"height": "n", "A": "n", "out": "n 7"})
def _normal_parts(height, A, out):
    for i in range(height.size):
        if height[i] > -A[i]:
            _normal(out[i], height[i], A[i])
    return 0


def mean_normal(height, A):
    """Return <z> of contacts at mean approaches on amplitudes, arrays, and its derivative in the approach."""
    out = np.zeros((height.size, COLUMNS))
    _normal_parts(np.ascontiguousarray(height), np.ascontiguousarray(A), out)
    return out[:, MEAN_APPROACH], out[:, SHARE]
