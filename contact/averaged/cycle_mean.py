r"""One cycle of the wave under a heavy slider: means of the contact forces between exact events.

The slider's path is given: mean approach h, mean velocity v, and a fast part in a few harmonics of the wave. At the
phase phi each contact then has, with z_k and y_k the harmonics of its motion relative to the slider,

    z = h + sum z_k,        x = x_1 + y - y_1  while it sticks from phi_1 on,        y = -v phi + sum y_k.         (1)

Everything that ends a regime is therefore known or bracketed:

    contact, release    z = 0, a cosine                                                                          (2)
    slip towards s      goes on while g_s = s y' - c z' > 0, s = +1 or -1: a window of the cycle (Feenstra and
                        Breedveld, eq. 3, with the sign left out there; `body.slip_window`)                      (3)
    stick               ends where D_s = c z - s x = 0. As D_s' = -g_s, D_s falls only inside the window of s, so
                        that there is at most one root in it                                                     (4)
    x = 0               lies between the turning points of y                                                     (5)

A slip limit X(z) that is not c z (`law.bent`) has no such windows: its cycle is scanned.

The forces are integrated from event to event in theta, phi = phi_1 + (phi_2 - phi_1)(1 - cos theta)/2, which makes the
square roots at contact, release and the end of stick smooth: Gauss-Legendre quadrature converges exponentially.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.body import Coordinates, approach, circle, slip_speed, slip_window
from contact.codes import Slips
from contact.jit.compiled import compiled, native, summed
from contact.law.normal import load
from contact.law.protocol import slip_limit

TURN = 2.0 * np.pi
# events of a contact in a cycle; phases of a cycle at which (3) and (4) of a bent limit are evaluated
MAX_EVENTS, SCANNED = 40, 128


class Mean(IntEnum):
    """Places in the means: sum of P and of Q."""

    NORMAL = 0
    TANGENTIAL = 1


class Counted(IntEnum):
    """Places in the counts: contacts made, slips begun, contacts that stick on with their memory."""

    MADE = 0
    SLIPS = 1
    STUCK = 2


class Each(IntEnum):
    """Columns of the forces of each contact: means, and parts of P = ... + a cos phi + b sin phi and of Q."""

    NORMAL = 0
    TANGENTIAL = 1
    NORMAL_COS = 2
    NORMAL_SIN = 3
    TANGENTIAL_COS = 4
    TANGENTIAL_SIN = 5


class Harmonics(NamedTuple):
    """Amplitudes of a normal and a tangential quantity in the first K harmonics of the wave; arrays (K,)."""

    normal_cos: np.ndarray
    normal_sin: np.ndarray
    tangential_cos: np.ndarray
    tangential_sin: np.ndarray


class Nodes(NamedTuple):
    """Work arrays at the n nodes of a piece: cos and sin of the harmonics (K, n); z, x and then the forces, (n,)."""

    cos: np.ndarray
    sin: np.ndarray
    normal: np.ndarray
    tangential: np.ndarray


class Cycle(NamedTuple):
    """What a cycle is taken on, and what it gives."""

    fast: Harmonics  # The slider's own fast motion: z_s, and its travel
    path: Harmonics  # Room for that of a contact relative to the slider
    force: Harmonics  # Of P (1 + chi z') and of Q; empty where only the means are wanted
    nodes: Nodes  # As many as the quadrature has; empty likewise
    means: np.ndarray  # (2,) array: Of sum P and sum Q
    counts: np.ndarray  # (3,) int array: See `Counted`
    each: np.ndarray  # (contacts, len(Each)) array: Of each contact; empty where they are not wanted


class Path(NamedTuple):
    """Motion of one contact: mean approach, mean velocity of the slider, and harmonics of z and y."""

    h: float
    v: float
    wave: Harmonics


class Anchor(NamedTuple):
    """Where stick began: deformation x and travel y there."""

    x: float
    y: float


class Passage(NamedTuple):
    """The part of the cycle that a contact is followed through, and how it begins: slip of a sign, or stick (0)."""

    start: float
    stop: float
    slip: float
    x: float  # deformation at the start


def cycle_room(harmonics: int, nodes: int = 0, contacts: int = 0) -> Cycle:
    """Return the arrays of a cycle of so many harmonics, the slider without fast motion.

    `nodes` of the quadrature, where the harmonics of the forces are wanted; `contacts`, where those of each; else 0.
    """
    fast, path, force = (
        Harmonics(*np.zeros((4, n))) for n in (harmonics, harmonics, harmonics * (nodes > 0))
    )
    room = Nodes(*np.zeros((2, harmonics, nodes)), *np.zeros((2, nodes)))
    each = np.zeros((contacts, len(Each)))
    return Cycle(fast, path, force, room, np.zeros(2), np.zeros(len(Counted), np.int64), each)


@compiled
def _motion_at(path, phi):
    """Return z, z', y, y' of a path at a phase, eq. (1)."""
    a, b, d, e = path.wave
    co, si = np.cos(phi), np.sin(phi)
    c, s = co, si
    z, z_rate, y, y_rate = path.h, 0.0, -path.v * phi, -path.v
    for k in range(a.size):
        z += a[k] * c + b[k] * s
        y += d[k] * c + e[k] * s
        z_rate += (k + 1) * (b[k] * c - a[k] * s)
        y_rate += (k + 1) * (e[k] * c - d[k] * s)
        c, s = c * co - s * si, s * co + c * si
    return z, z_rate, y, y_rate


@compiled
def _crossing(path, alpha, beta, anchor, low, high, rises):
    """Return the root of alpha z + beta x between `low` and `high` (safeguarded Newton).

    `rises`: whether it is negative at `low` and positive at `high`; else the other way round.
    """
    phi = 0.5 * (low + high)
    for _ in range(60):
        z, zr, y, yr = _motion_at(path, phi)
        f, rate = alpha * z + beta * (anchor.x + y - anchor.y), alpha * zr + beta * yr
        if (f > 0.0) == rises:
            high = phi
        else:
            low = phi
        new = phi - f / rate if rate != 0.0 else low
        # Newton's next step would be the square of this one, and the square of that the error of the integrals
        if abs(new - phi) < 1e-5:
            return min(max(new, low), high)
        phi = new if low < new < high else 0.5 * (low + high)
        if high - low < 1e-8:
            break
    return phi


@compiled
def _window(path, c, s):
    """Return (start, end, kind) of the window (3): in closed form for one harmonic, corrected for several."""
    a, b, d, e = path.wave
    start, end, kind = slip_window(s, a[0], b[0], d[0], e[0], path.v, c)
    if kind == Slips.WINDOW and a.size > 1:
        return _edge(path, c, s, start), _edge(path, c, s, end), kind
    return start, end, kind


@compiled
def _edge(path, c, s, phi):
    """Return the root of g_s near phi (Newton's method with the first harmonic's slope)."""
    a, b, d, e = (
        path.wave.normal_cos[0],
        path.wave.normal_sin[0],
        path.wave.tangential_cos[0],
        path.wave.tangential_sin[0],
    )
    across, along = s * e - c * b, c * a - s * d
    rate = along * np.cos(phi) - across * np.sin(phi)
    if abs(rate) > 1e-3 * np.hypot(across, along):
        for _ in range(12):
            _, zr, _, yr = _motion_at(path, phi)
            step = -slip_speed(s, zr, yr, c) / rate
            phi += step
            if abs(step) < 1e-12:
                break
    return phi


@compiled
def _stick_margin(problem, path, s, anchor, phi):
    """Return D_s, eq. (4)."""
    z, _, y, _ = _motion_at(path, phi)
    return slip_limit(problem, z) - s * (anchor.x + y - anchor.y)


@compiled
def _next_slip(problem, path, s, window, anchor, start, stop):
    """Return the first phase in (start, stop) at which stick ends by slip towards s, eq. (4); stop if none."""
    if problem.law.bent:
        return _next_slip_scanned(problem, path, s, anchor, start, stop)
    low, high, kind = window
    if kind == Slips.NEVER:
        return stop
    if kind == Slips.ALWAYS:
        low, high = start, stop
    else:
        shift = TURN * np.ceil((start + 1e-9 - high) / TURN)
        low, high = low + shift, high + shift
    while low < stop:
        a, b = max(low, start), min(high, stop)
        # below rounding: a spring that comes back to its limit after a whole cycle of stick has not slipped
        if b > a and _stick_margin(problem, path, s, anchor, b) < -1e-14:
            return _crossing(path, problem.law.limit_rate(problem, 0.0), -s, anchor, a, b, False)
        low, high = low + TURN, high + TURN
    return stop


@compiled
def _add_integrals(problem, path, rule, work, start, stop, slip, offset):
    """Add the integrals of the forces from one event to the next; `slip` is its sign, 0 in stick: x = offset + y.

    The quadrature is cut at the trough of a contact that stays closed: where z almost comes to zero, its 3/2 power has
    branch points just off the real axis.
    """
    a, b = path.wave.normal_cos[0], path.wave.normal_sin[0]
    if path.h >= np.hypot(a, b):
        trough = np.arctan2(b, a) + np.pi
        trough += TURN * np.ceil((start - trough) / TURN)
        while trough < stop:
            _add_piece(problem, path, rule, work, start, trough - start, slip, offset)
            start, trough = trough, trough + TURN
    _add_piece(problem, path, rule, work, start, stop - start, slip, offset)


@compiled
def _add_piece(problem, path, rule, work, start, width, slip, offset):
    """Add the integrals of the forces over one smooth piece."""
    kappa = problem.stiffness
    if path.wave.normal_cos.size == 1 and work.force.normal_cos.size == 0:
        push, pull = _first_harmonic_sums(problem, path, rule, start, width, slip, offset)
    else:
        _motion_at_nodes(path, rule, work.nodes, start, width, offset)
        push, pull = _forces_at_nodes(problem, path, rule, work.nodes, slip)
        _add_harmonics(problem, path, rule, work, kappa * width)
    work.means[Mean.NORMAL] += kappa * width * push
    work.means[Mean.TANGENTIAL] += kappa * width * pull


@summed
def _motion_at_nodes(path, rule, nodes, start, width, offset):
    """Fill the harmonics' cosines and sines, the approach and the deformation at the nodes of a piece."""
    h, v, wave, n = path.h, path.v, path.wave, rule.place.size
    cos, sin, z, x = nodes.cos, nodes.sin, nodes.normal, nodes.tangential
    for j in range(n):
        phi = start + width * rule.place[j]
        cos[0, j], sin[0, j] = circle(phi)
        z[j] = h
        x[j] = offset - v * phi
    for k in range(wave.normal_cos.size):
        a, b, d, e = wave.normal_cos[k], wave.normal_sin[k], wave.tangential_cos[k], wave.tangential_sin[k]
        if k > 0:
            for j in range(n):
                cos[k, j] = cos[k - 1, j] * cos[0, j] - sin[k - 1, j] * sin[0, j]
            for j in range(n):
                sin[k, j] = sin[k - 1, j] * cos[0, j] + cos[k - 1, j] * sin[0, j]
        for j in range(n):
            z[j] += a * cos[k, j] + b * sin[k, j]
        for j in range(n):
            x[j] += d * cos[k, j] + e * sin[k, j]


@summed
def _forces_at_nodes(problem, path, rule, nodes, slip):
    """Replace approach and deformation at the nodes by the weighted forces P/kappa and Q/kappa; return their sums."""
    law, shape, wave = problem.law, problem.shape, path.wave
    z, x = nodes.normal, nodes.tangential
    push = pull = 0.0
    if slip != 0.0:  # in slip x holds the speed of slip, which the force may depend on
        for j in range(rule.weight.size):
            x[j] = -slip * path.v
            if law.rated:
                slope = law.limit_rate(problem, z[j])
                for k in range(wave.normal_cos.size):
                    co, si = (k + 1) * nodes.cos[k, j], (k + 1) * nodes.sin[k, j]
                    x[j] += slip * (wave.tangential_sin[k] * co - wave.tangential_cos[k] * si)
                    x[j] -= slope * (wave.normal_sin[k] * co - wave.normal_cos[k] * si)
    for j in range(rule.weight.size):
        if slip == 0.0:
            force = law.stuck(problem, z[j], abs(x[j]))
            force = -force if x[j] < 0.0 else force
        else:
            force = slip * law.sliding(problem, z[j], max(x[j], 0.0))
        z[j] = rule.weight[j] * load(z[j], shape)
        x[j] = rule.weight[j] * force
        push += z[j]
        pull += x[j]
    return push, pull


@summed
def _add_harmonics(problem, path, rule, work, scale):
    """Add the harmonics of the forces at the nodes, the damper's with them."""
    wave, force, nodes = path.wave, work.force, work.nodes
    cos, sin, normal, tangential = nodes.cos, nodes.sin, nodes.normal, nodes.tangential
    # P z' is a total derivative, so that the damper's mean over a cycle is zero
    if problem.contact_damping > 0.0:
        for j in range(rule.weight.size):
            rate = 0.0
            for k in range(wave.normal_cos.size):
                rate += (k + 1) * (wave.normal_sin[k] * cos[k, j] - wave.normal_cos[k] * sin[k, j])
            normal[j] *= 1.0 + problem.contact_damping * rate
    for k in range(force.normal_cos.size):
        a = b = d = e = 0.0
        for j in range(rule.weight.size):
            a += normal[j] * cos[k, j]
            b += normal[j] * sin[k, j]
            d += tangential[j] * cos[k, j]
            e += tangential[j] * sin[k, j]
        force.normal_cos[k] += scale * a
        force.normal_sin[k] += scale * b
        force.tangential_cos[k] += scale * d
        force.tangential_sin[k] += scale * e


@summed
def _first_harmonic_sums(problem, path, rule, start, width, slip, offset):
    """Return the integrals of normal force and traction over a smooth piece of a path of one harmonic."""
    law, shape = problem.law, problem.shape
    h, v, wave = path.h, path.v, path.wave
    a, b, d, e = wave.normal_cos[0], wave.normal_sin[0], wave.tangential_cos[0], wave.tangential_sin[0]
    push, pull = 0.0, 0.0
    for j in range(rule.weight.size):
        phi = start + width * rule.place[j]
        co, si = circle(phi)
        z = h + a * co + b * si
        push += rule.weight[j] * load(z, shape)
        if slip == 0.0:
            x = offset + d * co + e * si - v * phi
            force = law.stuck(problem, z, abs(x))
            pull += rule.weight[j] * (-force if x < 0.0 else force)
        else:
            speed = slip * (e * co - d * si - v) - law.limit_rate(problem, z) * (b * co - a * si)
            pull += rule.weight[j] * slip * law.sliding(problem, z, max(speed, 0.0))
    return push, pull


@compiled
def _add_stick(problem, path, rule, work, start, stop, anchor):
    """Add the integrals of a time of stick, cut where x = 0 (5), at which the force is not smooth."""
    d, e = path.wave.tangential_cos[0], path.wave.tangential_sin[0]
    size, offset = np.hypot(d, e), anchor.x - anchor.y
    # y of the first harmonic turns at centre - half, centre + half, and so on in every cycle
    centre, half = np.arctan2(-d, e), 0.0
    if abs(path.v) < size:
        half = np.arccos(path.v / size)
        centre += TURN * np.floor((start - centre + half) / TURN)
    begin, left, before, side = start, start, anchor.x, 0
    while left < stop:
        right = stop
        while half > 0.0 and side < 16:
            turning = centre + (half if side % 2 == 1 else -half) + TURN * (side // 2)
            side += 1
            if turning > left:
                right = min(turning, stop)
                break
        after = offset + _motion_at(path, right)[2]
        if before * after < 0.0:
            root = _crossing(path, 0.0, 1.0, anchor, left, right, after > 0.0)
            _add_integrals(problem, path, rule, work, begin, root, 0.0, offset)
            begin = root
        before, left = after, right
    _add_integrals(problem, path, rule, work, begin, stop, 0.0, offset)


@compiled
def _slip_rate(problem, path, s, phi):
    """Return g_s, the speed of slip towards s at its limit."""
    z, zr, _, yr = _motion_at(path, phi)
    return slip_speed(s, zr, yr, problem.law.limit_rate(problem, z))


@compiled
def _slip_end(problem, path, s, window, phi, stop):
    """Return where slip towards s ends, at most `stop`: from the window (3), or scanned for a bent limit."""
    if not problem.law.bent:
        _, end, kind = window
        if kind == Slips.WINDOW:
            end += TURN * np.ceil((phi + 1e-12 - end) / TURN)
        return stop if kind != Slips.WINDOW or end > stop - 1e-12 else end
    left = phi
    while left < stop:
        right = min(left + TURN / SCANNED, stop)
        if _slip_rate(problem, path, s, right) < 0.0:
            return _slip_end_between(problem, path, s, left, right)
        left = right
    return stop


@compiled
def _slip_end_between(problem, path, s, a, b):
    """Return where g_s falls through zero between a and b (bisection)."""
    for _ in range(46):
        middle = 0.5 * (a + b)
        if _slip_rate(problem, path, s, middle) < 0.0:
            b = middle
        else:
            a = middle
    return b


@compiled
def _next_slip_scanned(problem, path, s, anchor, start, stop):
    """Return the root (4) of a bent limit in (start, stop), stop if there is none: the cycle is scanned."""
    left, falling = start, _slip_rate(problem, path, s, start) > 0.0
    while left < stop:
        right = min(left + TURN / SCANNED, stop)
        low, still = right, _slip_rate(problem, path, s, right) > 0.0
        if falling and not still:  # the margin has its least value between
            low = _slip_end_between(problem, path, s, left, right)
        if _stick_margin(problem, path, s, anchor, low) < -1e-14:
            a, b = left, low
            for _ in range(46):
                middle = 0.5 * (a + b)
                if _stick_margin(problem, path, s, anchor, middle) < 0.0:
                    b = middle
                else:
                    a = middle
            return b
        left, falling = right, still
    return stop


@compiled
def _first_passage(problem, path, windows, counts):
    """Return where the cycle of a contact begins: where it closes, or where slip ends if it never opens."""
    law = problem.law
    crest = np.arctan2(path.wave.normal_sin[0], path.wave.normal_cos[0])
    reach = np.hypot(path.wave.normal_cos[0], path.wave.normal_sin[0])
    if path.h >= reach:
        # a cycle with v > 0 stretches every contact backwards, so it must slip that way, up to the window's end
        back = 1.0 if path.v < 0.0 else -1.0
        if law.bent:
            start = _slip_end(problem, path, back, windows[0], 0.0, TURN)
            if start == TURN and _slip_rate(problem, path, back, 0.0) > 0.0:
                return Passage(0.0, TURN, back, 0.0)
            start = start if start < TURN else 0.0
        else:
            _, start, kind = windows[0] if path.v < 0.0 else windows[1]
            if kind == Slips.ALWAYS:
                return Passage(0.0, TURN, back, 0.0)
        return Passage(start, start + TURN, 0.0, back * slip_limit(problem, _motion_at(path, start)[0]))
    half = np.arccos(-path.h / reach)
    start, stop = crest - half, crest + half
    for _ in range(8 if path.wave.normal_cos.size > 1 else 0):
        z, rate, _, _ = _motion_at(path, start)
        z_end, rate_end, _, _ = _motion_at(path, stop)
        if rate <= 0.0 or rate_end >= 0.0:
            break
        start, stop = start - z / rate, stop - z_end / rate_end
    counts[Counted.MADE] += 1
    _, zr, _, yr = _motion_at(path, start)
    sign = 1.0 if yr >= 0.0 else -1.0
    slips = slip_speed(sign, zr, yr, law.limit_rate(problem, 0.0)) > 0.0
    return Passage(start, stop, sign if slips else 0.0, 0.0)


@compiled
def _add_contact(problem, path, rule, work):
    """Add the integrals of one contact over one cycle of the motion that repeats."""
    counts, c = work.counts, problem.law.limit_rate(problem, 0.0)
    reach = np.hypot(path.wave.normal_cos[0], path.wave.normal_sin[0])
    if path.h <= -reach:
        return
    windows = _window(path, c, 1.0), _window(path, c, -1.0)
    passage = _first_passage(problem, path, windows, counts)
    if (
        problem.law.bent and path.h >= reach
    ):  # of several windows it is not known which one is the last to slip
        slip, x, _ = _follow_contact(problem, path, rule, work, windows, passage, False)
        passage = Passage(passage.start, passage.stop, slip, x)
    _, _, slips = _follow_contact(problem, path, rule, work, windows, passage, True)
    counts[Counted.SLIPS] += slips
    # slip one way only, by less than a fraction of the spring's range: it takes many cycles to forget
    forgets = TURN * abs(path.v) >= 0.4 * slip_limit(problem, path.h)
    if path.h >= reach and (slips == 0 or (slips == 1 and not forgets)):
        counts[Counted.STUCK] += 1


@compiled
def _follow_contact(problem, path, rule, work, windows, passage, counted):
    """Follow one contact from event to event; return (slip, x, slips begun). Its integrals are added where `counted`.

    After `MAX_EVENTS` without an end the means are set to NaN, which the callers refuse.
    """
    phi, stop, slip, x = passage
    slips = 1 if slip != 0.0 else 0
    for _ in range(MAX_EVENTS):
        if slip != 0.0:
            end = _slip_end(problem, path, slip, windows[0] if slip > 0.0 else windows[1], phi, stop)
            if counted:
                _add_integrals(problem, path, rule, work, phi, end, slip, 0.0)
            if end >= stop:
                return slip, x, slips
            x, slip, phi = slip * slip_limit(problem, max(_motion_at(path, end)[0], 0.0)), 0.0, end
        else:
            anchor = Anchor(x, _motion_at(path, phi)[2])
            up = _next_slip(problem, path, 1.0, windows[0], anchor, phi, stop)
            end = _next_slip(problem, path, -1.0, windows[1], anchor, phi, up)
            if counted:
                _add_stick(problem, path, rule, work, phi, end, anchor)
            x, phi = x + _motion_at(path, end)[2] - anchor.y, end
            if end >= stop:
                return 0.0, x, slips
            slip = 1.0 if end == up else -1.0
            slips += 1
    work.means[Mean.NORMAL] = work.means[Mean.TANGENTIAL] = np.nan
    return slip, x, slips


@compiled
def _add_to_contact(work, row, sign):
    """Add the sums over the contacts so far, times `sign`, to the forces of one: after it less before it."""
    force = work.force
    row[Each.NORMAL] += sign * work.means[Mean.NORMAL] / TURN
    row[Each.TANGENTIAL] += sign * work.means[Mean.TANGENTIAL] / TURN
    row[Each.NORMAL_COS] += sign * force.normal_cos[0] / np.pi
    row[Each.NORMAL_SIN] += sign * force.normal_sin[0] / np.pi
    row[Each.TANGENTIAL_COS] += sign * force.tangential_cos[0] / np.pi
    row[Each.TANGENTIAL_SIN] += sign * force.tangential_sin[0] / np.pi


@native(
    "t f f t t",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "rule.place": "q", "rule.weight": "q",
        "work.fast.normal_cos": "k", "work.path.normal_cos": "k", "work.force.normal_cos": "0 | k", "work.means": "2",
        "work.counts": "3", "work.nodes.cos": "k q | 1 0", "work.each": "0 6 | n 6",
    },
)  # fmt: skip
def cycle(problem, h, v, rule, work):
    """Fill means, harmonics of the forces and counts of a cycle that repeats; return 0.

    `h`: mean approach of a contact of height 0; `v`: mean velocity; `rule`: quadrature of each smooth piece, see
    `riding.quadrature`; `work`: a `Cycle`, of which the slider's fast motion is given.
    """
    fast, path, force, paths = work.fast, work.path, work.force, problem.paths
    q = Coordinates(-h, 0.0)
    work.each[:] = 0.0
    work.means[:] = 0.0
    work.counts[:] = 0
    for k in range(force.normal_cos.size):
        force.normal_cos[k] = force.normal_sin[k] = force.tangential_cos[k] = force.tangential_sin[k] = 0.0
    for i in range(paths.height.size):
        for k in range(fast.normal_cos.size):
            path.normal_cos[k], path.normal_sin[k] = -fast.normal_cos[k], -fast.normal_sin[k]
            path.tangential_cos[k], path.tangential_sin[k] = -fast.tangential_cos[k], -fast.tangential_sin[k]
        path.normal_cos[0] += paths.normal_cos[i]
        path.normal_sin[0] += paths.normal_sin[i]
        path.tangential_cos[0] += paths.tangential_cos[i]
        path.tangential_sin[0] += paths.tangential_sin[i]
        if work.each.size > 0:
            _add_to_contact(work, work.each[i], -1.0)
        _add_contact(problem, Path(approach(paths, i, 0.0, q), v, path), rule, work)
        if work.each.size > 0:
            _add_to_contact(work, work.each[i], 1.0)
    work.means[Mean.NORMAL] /= TURN
    work.means[Mean.TANGENTIAL] /= TURN
    for k in range(force.normal_cos.size):
        force.normal_cos[k] /= np.pi
        force.normal_sin[k] /= np.pi
        force.tangential_cos[k] /= np.pi
        force.tangential_sin[k] /= np.pi
    return 0


@compiled
def respond(problem, work):
    """Set the fast motion that the harmonics of the forces drive, dampers included."""
    d_n, d_t, fast, force = problem.normal_damping, problem.tangential_damping, work.fast, work.force
    for k in range(fast.normal_cos.size):
        n = k + 1.0
        fast.normal_cos[k], fast.normal_sin[k] = _amplitudes(n, d_n, force.normal_cos[k], force.normal_sin[k])
        fast.tangential_cos[k], fast.tangential_sin[k] = _amplitudes(
            n, d_t, force.tangential_cos[k], force.tangential_sin[k]
        )


@compiled
def _amplitudes(n, d, a, b):
    """Return the amplitudes (a - i b)/(-n^2 + i n d) of the answer to a force a cos + b sin."""
    size = n * n * (n * n + d * d)
    return -n * (n * a + d * b) / size, -n * (n * b - d * a) / size
