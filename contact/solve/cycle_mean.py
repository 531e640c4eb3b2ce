r"""One cycle of the wave under a heavy slider: means of the contact forces between exact events.

The slider's path is given: mean approach h, mean velocity v, and a fast part in a few harmonics of the wave that
repeats. With phase phi, each contact then has z = h + sum z_k and, while it sticks, x = x_1 + y - y_1 with
y = -v phi + sum y_k. Everything that ends a regime is then known or bracketed without a search:

* contact and release: z = 0, a cosine;
* slip towards s = +1, -1 goes on while g_s = s y' - c z' > 0, a window of the cycle (Feenstra and Breedveld, eq. 3,
  with the sign left out there);
* stick ends where D_s = c z - s x = 0; D_s' = -g_s, so D_s falls only inside the window of s: one root at most in it;
* x = 0 lies between the turning points of y.

The forces are integrated from event to event in theta, phi = phi_1 + (phi_2 - phi_1)(1 - cos theta)/2, which makes the
square roots at contact, release and the end of stick smooth: Gauss-Legendre quadrature is spectral.
"""

import numpy as np

from contact.jit.compiled import compiled, native, summed
from contact.law.elastic import friction_load
from contact.law.normal import load
from contact.solve.riding import circle

TURN = 2.0 * np.pi
# places in the counts: contacts made, slips begun, reversals, contacts that stick on with their memory
MADE, SLIPS, REVERSALS, STUCK = 0, 1, 2, 3


@compiled
def place(h, v, path, phi):
    """Return z, z', y, y', cos phi, sin phi; the last rows of `path` are cos z, sin z, cos y, sin y by harmonic."""
    co, si = np.cos(phi), np.sin(phi)
    c, s = co, si
    z, z_rate, y, y_rate = h, 0.0, -v * phi, -v
    for k in range(path.shape[1]):
        z += path[4, k] * c + path[5, k] * s
        y += path[6, k] * c + path[7, k] * s
        z_rate += (k + 1) * (path[5, k] * c - path[4, k] * s)
        y_rate += (k + 1) * (path[7, k] * c - path[6, k] * s)
        c, s = c * co - s * si, s * co + c * si
    return z, z_rate, y, y_rate, co, si


@compiled
def _crossing(h, v, path, alpha, beta, x1, y1, low, high):
    """Return the root of alpha z + beta x between `low` and `high`, where its signs differ (safeguarded Newton)."""
    z, _, y, _, _, _ = place(h, v, path, low)
    f_low = alpha * z + beta * (x1 + y - y1)
    phi = 0.5 * (low + high)
    for _ in range(60):
        z, zr, y, yr, _, _ = place(h, v, path, phi)
        f, rate = alpha * z + beta * (x1 + y - y1), alpha * zr + beta * yr
        if (f > 0.0) == (f_low > 0.0):
            low = phi
        else:
            high = phi
        step = -f / rate if rate != 0.0 else 0.0
        new = phi + step
        if not low < new < high:
            new = 0.5 * (low + high)
        # Newton's next step would be the square of this one, and the forces are continuous there
        if abs(new - phi) < 1e-8 or high - low < 1e-8:
            return new
        phi = new
    return phi


@compiled
def _window(v, path, c, s, h):
    """Return (start, end, kind) of slip towards s: kind 0 never, 1 a window, 2 always."""
    across, along = s * path[7, 0] - c * path[5, 0], c * path[4, 0] - s * path[6, 0]
    size = np.hypot(across, along)
    if s * v >= size:
        return 0.0, 0.0, 0.0
    if s * v <= -size:
        return 0.0, 0.0, 2.0
    centre, half = np.arctan2(along, across), np.arccos(s * v / size)
    return _edge(v, path, c, s, h, centre, -half, size), _edge(v, path, c, s, h, centre, half, size), 1.0


@compiled
def _edge(v, path, c, s, h, centre, half, size):
    """Return the phase at which slip towards s begins or ends: of the first harmonic, then of all."""
    phi = centre + half
    slope = -size * np.sin(half)
    if path.shape[1] > 1 and abs(slope) > 1e-3 * size:
        for _ in range(12):
            _, zr, _, yr, _, _ = place(h, v, path, phi)
            step = -(s * yr - c * zr) / slope
            phi += step
            if abs(step) < 1e-12:
                break
    return phi


@compiled
def _next_slip(h, v, path, c, s, window, x1, y1, start, stop):
    """Return the first phase in (start, stop) at which stick ends by slip towards s; stop if none."""
    if window[2] == 0.0:
        return stop
    low, high = window[0], window[1]
    if window[2] == 2.0:
        low, high = start, stop
    else:
        shift = TURN * np.ceil((start + 1e-9 - high) / TURN)
        low, high = low + shift, high + shift
    while low < stop:
        a, b = max(low, start), min(high, stop)
        z, _, y, _, _, _ = place(h, v, path, b)
        # below rounding: a spring that comes back to its limit after a whole cycle of stick has not slipped
        if b > a and c * z - s * (x1 + y - y1) < -1e-14:
            return _crossing(h, v, path, c, -s, x1, y1, a, b)
        low, high = low + TURN, high + TURN
    return stop


@compiled
def _gather(problem, h, v, path, start, stop, slip, x1, y1, parted, rule, sums):
    """Add the integrals of the forces from one event to the next; `slip` is the sign of slip, 0 in stick.

    A contact that almost parts at its trough has its singular points just off the real axis there: cut at it.
    """
    if not parted:
        trough = np.arctan2(path[5, 0], path[4, 0]) + np.pi
        trough += TURN * np.ceil((start - trough) / TURN)
        while trough < stop:
            _piece(problem, h, v, path, start, trough, slip, x1, y1, rule, sums)
            start, trough = trough, trough + TURN
    _piece(problem, h, v, path, start, stop, slip, x1, y1, rule, sums)


@compiled
def _piece(problem, h, v, path, start, stop, slip, x1, y1, rule, sums):
    """Add the integrals of the forces over one smooth piece."""
    kappa, chi, mu, c = problem.stiffness, problem.contact_damping, problem.friction, problem.limit_slope
    harmonics = path.shape[1]
    width = stop - start
    if harmonics == 1 and sums.size == 2:
        push, pull = _plain(
            kappa,
            mu,
            c,
            h,
            v,
            path[4, 0],
            path[5, 0],
            path[6, 0],
            path[7, 0],
            start,
            width,
            slip,
            x1 - y1,
            rule,
            problem.shape,
        )
        sums[0] += push
        sums[1] += pull
        return
    for j in range(rule.shape[1]):
        z, z_rate, y, _, co, si = place(h, v, path, start + width * rule[0, j])
        if z <= 0.0:
            continue
        weight = kappa * width * rule[1, j]
        elastic = weight * load(z, problem.shape)
        if slip != 0.0:
            pull = slip * mu * elastic
        else:
            x = x1 + y - y1
            pull = mu * weight * friction_load(z, z - abs(x) / c, problem.shape)
            if x < 0.0:
                pull = -pull
        push = elastic * (1.0 + chi * z_rate)
        # P z' is a total derivative, so that the damper's mean over a cycle is zero
        sums[0] += elastic
        sums[1] += pull
        if sums.size > 2:
            cos, sin = co, si
            for k in range(harmonics):
                m = 2 + 4 * k
                sums[m] += push * cos
                sums[m + 1] += push * sin
                sums[m + 2] += pull * cos
                sums[m + 3] += pull * sin
                cos, sin = cos * co - sin * si, sin * co + cos * si


@summed
def _plain(kappa, mu, c, h, v, a, b, d, e, start, width, slip, offset, rule, shape):
    """Return the integrals of normal force and traction over a smooth piece of a path of one harmonic."""
    push, pull = 0.0, 0.0
    for j in range(rule.shape[1]):
        phi = start + width * rule[0, j]
        co, si = circle(phi)
        z = h + a * co + b * si
        power = load(z, shape)
        weight = width * rule[1, j]
        push += weight * power
        x = offset + d * co + e * si - v * phi
        stuck = friction_load(z, z - abs(x) / c, shape)
        stuck = -stuck if x < 0.0 else stuck
        pull += weight * (stuck if slip == 0.0 else slip * power)
    return kappa * push, mu * kappa * pull


@compiled
def _stick(problem, h, v, path, start, stop, x1, y1, parted, rule, sums):
    """Add the integrals of a stretch of stick, cut where x passes zero; return the number of passages."""
    size = np.hypot(path[7, 0], path[6, 0])
    # y of the first harmonic turns at centre - half, centre + half, and so on in every cycle
    centre, half = np.arctan2(-path[6, 0], path[7, 0]), 0.0
    if abs(v) < size:
        half = np.arccos(v / size)
        centre += TURN * np.floor((start - centre + half) / TURN)
    begin, left, passages, before, side = start, start, 0, x1, 0
    while left < stop:
        right = stop
        while half > 0.0 and side < 16:
            turning = centre + (half if side % 2 == 1 else -half) + TURN * (side // 2)
            side += 1
            if turning > left:
                right = min(turning, stop)
                break
        after = x1 + place(h, v, path, right)[2] - y1
        if before * after < 0.0:
            root = _crossing(h, v, path, 0.0, 1.0, x1, y1, left, right)
            _gather(problem, h, v, path, begin, root, 0.0, x1, y1, parted, rule, sums)
            begin = root
            passages += 1
        before, left = after, right
    _gather(problem, h, v, path, begin, stop, 0.0, x1, y1, parted, rule, sums)
    return passages


@compiled
def _contact(problem, h, v, path, rule, sums, counts):
    """Add the integrals of one contact over one cycle of the motion that repeats."""
    c = problem.limit_slope
    reach = np.hypot(path[4, 0], path[5, 0])
    if h <= -reach:
        return
    forward, backward = _window(v, path, c, 1.0, h), _window(v, path, c, -1.0, h)
    parted = h < reach
    slip, x = 0.0, 0.0
    if parted:
        crest, half = np.arctan2(path[5, 0], path[4, 0]), np.arccos(-h / reach)
        start, stop = crest - half, crest + half
        for _ in range(8 if path.shape[1] > 1 else 0):
            z, rate, _, _, _, _ = place(h, v, path, start)
            z_end, rate_end, _, _, _, _ = place(h, v, path, stop)
            if rate <= 0.0 or rate_end >= 0.0:
                break
            start, stop = start - z / rate, stop - z_end / rate_end
        counts[MADE] += 1
        _, zr, _, yr, _, _ = place(h, v, path, start)
        sign = 1.0 if yr >= 0.0 else -1.0
        slip = sign if sign * yr - c * zr > 0.0 else 0.0
    else:
        # a cycle with v > 0 stretches every contact backwards, so it must slip that way, up to the window's end
        back = 1.0 if v < 0.0 else -1.0
        window = forward if v < 0.0 else backward
        if window[2] == 2.0:
            slip, start = back, 0.0
        else:
            start = window[1]
            x = back * c * place(h, v, path, start)[0]
        stop = start + TURN
    slips, reversals, phi = 0, 0, start
    if slip != 0.0:
        slips += 1
    for _ in range(40):
        if slip != 0.0:
            window = forward if slip > 0.0 else backward
            end = stop
            if window[2] == 1.0:
                end = window[1] + TURN * np.ceil((phi + 1e-12 - window[1]) / TURN)
                if end > stop - 1e-12:
                    end = stop
            _gather(problem, h, v, path, phi, end, slip, 0.0, 0.0, parted, rule, sums)
            x, slip, phi = slip * c * max(place(h, v, path, end)[0], 0.0), 0.0, end
        else:
            y1 = place(h, v, path, phi)[2]
            up = _next_slip(h, v, path, c, 1.0, forward, x, y1, phi, stop)
            down = _next_slip(h, v, path, c, -1.0, backward, x, y1, phi, stop)
            end = min(up, down)
            reversals += _stick(problem, h, v, path, phi, end, x, y1, parted, rule, sums)
            x, phi = x + place(h, v, path, end)[2] - y1, end
            if end < stop:
                slip = 1.0 if up < down else -1.0
                slips += 1
        if phi >= stop:
            break
    counts[SLIPS] += slips
    counts[REVERSALS] += reversals
    # slip one way only, by less than a fraction of the spring's range: it takes many cycles to forget
    if not parted and (slips == 0 or (slips == 1 and TURN * abs(v) < 0.4 * c * h)):
        counts[STUCK] += 1


@native(
    "t f f f2 f2 f1 i1",
    {
        "problem.paths.height": "n",
        "problem.paths.normal_cos": "n",
        "fast": "8 k",
        "rule": "2 q",
        "sums": "2 | 2+4k",
        "counts": "4",
    },
)
def cycle(problem, h, v, fast, rule, sums, counts):
    """Fill the means (sum of P, sum of Q) and the harmonics of (P (1 + chi z'), Q) over one cycle that repeats.

    Parameters
    ----------
    problem : Problem
    h, v : float
        Mean approach and mean velocity.
    fast : (8, K) array
        The slider's own fast motion by harmonic, in the first rows: cos and sin of z_s, cos and sin of its travel; the
        others are work.
    rule : (2, n) array
        See `riding.quadrature`.
    sums : (2,) or (2 + 4 K,) array
        Overwritten: means, then for each harmonic the amplitudes cos and sin of normal force and of traction.
    counts : (4,) int array
        Overwritten: see the names of this module.

    Returns
    -------
    int
        0.
    """
    for k in range(sums.size):
        sums[k] = 0.0
    for k in range(4):
        counts[k] = 0
    paths = problem.paths
    for i in range(paths.height.size):
        for m in range(4):
            for k in range(fast.shape[1]):
                fast[4 + m, k] = -fast[m, k]
        fast[4, 0] += paths.normal_cos[i]
        fast[5, 0] += paths.normal_sin[i]
        fast[6, 0] += paths.tangential_cos[i]
        fast[7, 0] += paths.tangential_sin[i]
        _contact(problem, h + paths.height[i], v, fast, rule, sums, counts)
    for k in range(sums.size):
        sums[k] /= TURN if k < 2 else np.pi
    return 0


@compiled
def respond(problem, sums, fast):
    """Set the fast motion that the harmonics of the forces drive, dampers included."""
    d_n, d_t = problem.normal_damping, problem.tangential_damping
    for k in range(fast.shape[1]):
        n, m = k + 1.0, 2 + 4 * k
        # (a - i b)/(-n^2 + i n d) for forces a cos + b sin
        size = n * n * (n * n + d_n * d_n)
        a, b = sums[m], sums[m + 1]
        fast[0, k], fast[1, k] = -n * (n * a + d_n * b) / size, -n * (n * b - d_n * a) / size
        size = n * n * (n * n + d_t * d_t)
        a, b = sums[m + 2], sums[m + 3]
        fast[2, k], fast[3, k] = -n * (n * a + d_t * b) / size, -n * (n * b - d_t * a) / size
