r"""One cycle of the wave under a heavy slider: means of the contact forces between exact events.

The slider's path is prescribed: mean approach h, mean velocity v, a fast part in a few harmonics of the wave. At the
phase phi each contact then has, with z_k and y_k the harmonics of its motion relative to the slider,

    z = h + sum z_k,        x = x_1 + y - y_1  while it sticks from phi_1 on,        y = -v phi + sum y_k.         (1)

Everything that ends a regime is therefore known or bracketed:

    contact, release    z = 0, a cosine                                                                          (2)
    slip towards s      goes on while g_s = s y' - c z' > 0, s = +1 or -1: a window of the cycle (Feenstra and
                        Breedveld, eq. 3, with the sign left out there; `body.slip_window`)                      (3)
    stick               ends where D_s = c z - s x = 0. As D_s' = -g_s, D_s falls only inside the window of s, so
                        that there is at most one root in it                                                     (4)
    x = 0               lies between the turning points of y                                                     (5)

A slip limit X(z) that is not c z (`law.bent`) has no such windows: its cycle is scanned. The forces are integrated from
event to event by quadrature or, for flat contacts, in closed form (`cycle_pieces`). `cycle` sums them over the contacts
of a slider with fast motion; `contact_cycles` gives those of each contact, with its own position, height and friction.
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_pieces import (
    BACKWARD,
    FORWARD,
    TURN,
    Anchor,
    Counted,
    Mean,
    Passage,
    Path,
    add_closed_normal,
    add_integrals,
    first_harmonic,
    motion_at,
)
from contact.averaged.riding import arc
from contact.body import Coordinates, approach, at_phase, harmonic_response, normal_amplitude, slip_speed, slip_window
from contact.codes import SlipWindow
from contact.jit.compiled import compiled, native
from contact.law.protocol import slip_limit
from contact.problem import contact_parameters, unpacked

# Largest number of events of a contact in a cycle; phases per cycle at which (3) and (4) of a bent limit are evaluated
MAX_EVENTS, SCANNED = 60, 128
# Newton step in rad at which the search for an event ends: with quadrature, and with closed integrals. The remaining
# error e of the phase is about the square of this step. The means err by e^2, but the friction power of closed
# integrals by e.
ROOT, CLOSED_ROOT = 1e-5, 1e-9


class ContactMean(IntEnum):
    """Index of the forces of each contact, P and Q = mean + cos part times cos phi + sin part times sin phi."""

    NORMAL = 0
    TANGENTIAL = 1
    NORMAL_COS = 2
    NORMAL_SIN = 3
    TANGENTIAL_COS = 4
    TANGENTIAL_SIN = 5
    FRICTION = 6  # mean power lost in slip, per radian
    SHARE = 7  # fraction of the cycle in contact
    LEAK = 8  # mean power lost in a law that is not conservative, per radian; negative for a gain


class MeanForces(NamedTuple):
    """Forces of each of n contacts on the slider over a cycle: P = P_0 + Re P_1 exp(i omega t), Q likewise.

    Attributes
    ----------
    normal, tangential : (n,) array
        Means over the cycle, N.
    first_normal, first_tangential : (n,) array, complex
        First harmonics, N.
    cycles : (len(ContactMean), n) array
        The values `ContactMean` that they were made from, in the units of the computation; nan of balls of JKR and
        Maugis.
    """

    normal: np.ndarray
    tangential: np.ndarray
    first_normal: np.ndarray
    first_tangential: np.ndarray
    cycles: np.ndarray


def forces_of(cycles, normal_unit, tangential_unit) -> MeanForces:
    """Return the forces of values `ContactMean` for units of force in N, one or of each contact."""
    first = np.empty((2, cycles.shape[1]), complex)
    first[0].real = normal_unit * cycles[ContactMean.NORMAL_COS]
    first[0].imag = -normal_unit * cycles[ContactMean.NORMAL_SIN]
    first[1].real = tangential_unit * cycles[ContactMean.TANGENTIAL_COS]
    first[1].imag = -tangential_unit * cycles[ContactMean.TANGENTIAL_SIN]
    normal, tangential = normal_unit * cycles[ContactMean.NORMAL], tangential_unit * cycles[ContactMean.TANGENTIAL]
    return MeanForces(normal, tangential, first[0], first[1], cycles)


@compiled
def _crossing(path, alpha, beta, anchor, low, high, rises, close):
    """Return the root of alpha z + beta x between `low` and `high` (safeguarded Newton).

    `rises`: whether it is negative at `low` and positive at `high`; else the other way round. `close`: see `ROOT`.
    """
    # of one harmonic: base + co cos phi + si sin phi + drift phi
    a, b, d, e = first_harmonic(path)
    co, si, drift = alpha * a + beta * d, alpha * b + beta * e, -beta * path.v
    base, phi = alpha * path.h + beta * (anchor.x - anchor.y), 0.5 * (low + high)
    for _ in range(60):
        if path.wave.normal_cos.size == 1:
            c, s = np.cos(phi), np.sin(phi)
            f, rate = base + co * c + si * s + drift * phi, si * c - co * s + drift
        else:
            z, zr, y, yr = motion_at(path, phi)
            f, rate = alpha * z + beta * (anchor.x + y - anchor.y), alpha * zr + beta * yr
        if (f > 0.0) == rises:
            high = phi
        else:
            low = phi
        new = phi - f / rate if rate != 0.0 else low
        if abs(new - phi) < close:
            return min(max(new, low), high)
        phi = new if low < new < high else 0.5 * (low + high)
        if high - low < 1e-3 * close:
            break
    return phi


@compiled
def _window(path, c, s):
    """Return (start, end, kind) of the window (3): in closed form for one harmonic, corrected for several."""
    a, b, d, e = first_harmonic(path)
    start, end, kind = slip_window(s, a, b, d, e, path.v, c)
    if kind == SlipWindow.WINDOW and path.wave.normal_cos.size > 1:
        return _edge(path, c, s, start), _edge(path, c, s, end), kind
    return start, end, kind


@compiled
def _edge(path, c, s, phi):
    """Return the root of g_s near phi (Newton's method with the first harmonic's slope)."""
    a, b, d, e = first_harmonic(path)
    across, along = s * e - c * b, c * a - s * d
    rate = along * np.cos(phi) - across * np.sin(phi)
    if abs(rate) > 1e-3 * np.hypot(across, along):
        for _ in range(12):
            _, zr, _, yr = motion_at(path, phi)
            step = -slip_speed(s, zr, yr, c) / rate
            phi += step
            if abs(step) < 1e-12:
                break
    return phi


@compiled
def _stick_margin(problem, path, s, anchor, phi):
    """Return D_s, eq. (4)."""
    z, _, y, _ = motion_at(path, phi)
    return slip_limit(problem, z) - s * (anchor.x + y - anchor.y)


@compiled
def _next_slip(problem, path, s, window, anchor, start, stop, close):
    """Return the first phase in (start, stop) at which stick ends by slip towards s, eq. (4); stop if none."""
    if problem.law.bent:
        return _next_slip_scanned(problem, path, s, anchor, start, stop)
    low, high, kind = window
    if kind == SlipWindow.NEVER:
        return stop
    if kind == SlipWindow.ALWAYS:
        low, high = start, stop
    else:
        shift = TURN * np.ceil((start + 1e-9 - high) / TURN)
        low, high = low + shift, high + shift
    while low < stop:
        a, b = max(low, start), min(high, stop)
        # The margin must be negative beyond rounding: a contact that sticks for a whole cycle and returns to its limit
        # has not slipped.
        if b > a and _stick_margin(problem, path, s, anchor, b) < -1e-14:
            return _crossing(path, problem.law.limit_rate(problem, 0.0), -s, anchor, a, b, False, close)
        low, high = low + TURN, high + TURN
    return stop


@compiled
def _add_stick(problem, path, rule, work, start, stop, anchor):
    """Add the integrals over an interval of stick, cut where x = 0, at which the force of a ball is not smooth.

    Between two turning points of y (5) x is monotonic and has at most one zero. They are computed for the first
    harmonic: y' = 0 where e cos phi - d sin phi = v, that is at centre - half and centre + half in every cycle.
    """
    offset = anchor.x - anchor.y
    if rule.weight.size == 0:
        add_integrals(problem, path, rule, work, start, stop, 0.0, offset)
        return
    _, _, d, e = first_harmonic(path)
    size = np.hypot(d, e)
    centre, half = np.arctan2(-d, e), 0.0
    if abs(path.v) < size:
        half = np.arccos(path.v / size)
        centre += TURN * np.floor((start - centre + half) / TURN)
    begin, left, x_left, number = start, start, anchor.x, 0
    while left < stop:
        right = stop
        while half > 0.0 and number < 16:  # the next turning point, of which some may lie before `start`
            turning = centre + (half if number % 2 == 1 else -half) + TURN * (number // 2)
            number += 1
            if turning > left:
                right = min(turning, stop)
                break
        x_right = offset + motion_at(path, right)[2]
        if x_left * x_right < 0.0:
            root = _crossing(path, 0.0, 1.0, anchor, left, right, x_right > 0.0, ROOT)
            add_integrals(problem, path, rule, work, begin, root, 0.0, offset)
            begin = root
        x_left, left = x_right, right
    add_integrals(problem, path, rule, work, begin, stop, 0.0, offset)


@compiled
def _slip_rate(problem, path, s, phi):
    """Return g_s, the speed of slip towards s at its limit."""
    z, zr, _, yr = motion_at(path, phi)
    return slip_speed(s, zr, yr, problem.law.limit_rate(problem, z))


@compiled
def _slip_end(problem, path, s, window, phi, stop):
    """Return where slip towards s ends, at most `stop`: from the window (3), or scanned for a bent limit."""
    if not problem.law.bent:
        _, end, kind = window
        if kind == SlipWindow.WINDOW:
            end += TURN * np.ceil((phi + 1e-12 - end) / TURN)
        return stop if kind != SlipWindow.WINDOW or end > stop - 1e-12 else end
    left = phi
    while left < stop:
        right = min(left + TURN / SCANNED, stop)
        if _slip_rate(problem, path, s, right) < 0.0:
            return _bisected(problem, path, s, None, left, right)
        left = right
    return stop


@compiled
def _bisected(problem, path, s, anchor, a, b):
    """Return where D_s or, without an anchor, g_s falls through zero between a and b."""
    for _ in range(46):
        middle = 0.5 * (a + b)
        if anchor is None:
            value = _slip_rate(problem, path, s, middle)
        else:
            value = _stick_margin(problem, path, s, anchor, middle)
        if value < 0.0:
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
            low = _bisected(problem, path, s, None, left, right)
        if _stick_margin(problem, path, s, anchor, low) < -1e-14:
            return _bisected(problem, path, s, anchor, left, low)
        left, falling = right, still
    return stop


@compiled
def _first_passage(problem, path, windows, half, counts):
    """Return the part of a cycle through which a contact is followed: from its closing, or from the end of a slip.

    `half`: half of the arc in contact, by the first harmonic. A contact that never opens (`half` = pi) is stretched
    backwards by the slider's drift, so that it slips in that direction `back` in every cycle; at the end of that slip
    its deformation is known.
    """
    law = problem.law
    if half == np.pi:
        back = -path.side
        if law.bent:
            start = _slip_end(problem, path, back, windows[0], 0.0, TURN)
            if start == TURN and _slip_rate(problem, path, back, 0.0) > 0.0:
                return Passage(0.0, TURN, back, 0.0)
            start = start if start < TURN else 0.0
        else:
            _, start, kind = windows[0] if path.side < 0.0 else windows[1]
            if kind == SlipWindow.ALWAYS:
                return Passage(0.0, TURN, back, 0.0)
        return Passage(start, start + TURN, 0.0, back * slip_limit(problem, motion_at(path, start)[0]))
    start, stop = path.crest - half, path.crest + half  # of the first harmonic, refined by Newton's method
    for _ in range(8 if path.wave.normal_cos.size > 1 else 0):
        z, rate, _, _ = motion_at(path, start)
        z_end, rate_end, _, _ = motion_at(path, stop)
        if rate <= 0.0 or rate_end >= 0.0:
            break
        start, stop = start - z / rate, stop - z_end / rate_end
    counts[Counted.MADE] += 1
    _, zr, _, yr = motion_at(path, start)
    sign = 1.0 if yr >= 0.0 else -1.0
    slips = slip_speed(sign, zr, yr, law.limit_rate(problem, 0.0)) > 0.0
    return Passage(start, stop, sign if slips else 0.0, 0.0)


@compiled
def _add_contact(problem, path, rule, work):
    """Add the integrals of one contact over one cycle of a periodic motion; return half of its arc in contact."""
    counts, c = work.counts, problem.law.limit_rate(problem, 0.0)
    if path.h <= -path.reach:
        return 0.0
    half = add_closed_normal(problem, path, work) if rule.weight.size == 0 else arc(path.h, path.reach)
    never_opens = half == np.pi
    windows = _window(path, c, 1.0), _window(path, c, -1.0)
    passage = _first_passage(problem, path, windows, half, counts)
    if problem.law.bent and never_opens:
        # There may be several windows, and which of them slips last is known only after a first cycle.
        slip, x, _ = _follow_contact(problem, path, rule, work, windows, passage, False)
        passage = Passage(passage.start, passage.stop, slip, x)
    _, _, slips = _follow_contact(problem, path, rule, work, windows, passage, True)
    counts[Counted.SLIPS] += slips
    # A contact that slips in one direction only, by less than 0.4 of its limit per cycle, keeps its initial deformation
    # for many cycles.
    forgets = TURN * abs(path.v) >= 0.4 * slip_limit(problem, path.h)
    if never_opens and (slips == 0 or (slips == 1 and not forgets)):
        counts[Counted.STUCK] += 1
    return half


@compiled
def _follow_contact(problem, path, rule, work, windows, passage, counted):
    """Follow one contact from event to event; return (slip, x, slips begun). Its integrals are added where `counted`.

    After `MAX_EVENTS` without an end the means are set to NaN, which the callers refuse.
    """
    phi, stop, slip, x = passage
    slips, close = 1 if slip != 0.0 else 0, CLOSED_ROOT if rule.weight.size == 0 else ROOT
    for _ in range(MAX_EVENTS):
        if slip != 0.0:
            end = _slip_end(problem, path, slip, windows[0] if slip > 0.0 else windows[1], phi, stop)
            if counted:
                add_integrals(problem, path, rule, work, phi, end, slip, 0.0)
            if end >= stop:
                return slip, x, slips
            x, slip, phi = slip * slip_limit(problem, max(motion_at(path, end)[0], 0.0)), 0.0, end
        else:
            anchor = Anchor(x, motion_at(path, phi)[2])
            up = _next_slip(problem, path, 1.0, windows[0], anchor, phi, stop, close)
            end = _next_slip(problem, path, -1.0, windows[1], anchor, phi, up, close)
            if counted:
                _add_stick(problem, path, rule, work, phi, end, anchor)
            x, phi = x + motion_at(path, end)[2] - anchor.y, end
            if end >= stop:
                return 0.0, x, slips
            slip = 1.0 if end == up else -1.0
            slips += 1
    work.means[Mean.NORMAL] = work.means[Mean.TANGENTIAL] = np.nan
    return slip, x, slips


@compiled
def clear(harmonics):
    """Set the amplitudes of all harmonics to zero."""
    harmonics.normal_cos[:] = harmonics.normal_sin[:] = 0.0
    harmonics.tangential_cos[:] = harmonics.tangential_sin[:] = 0.0


@compiled
def _clear(work):
    """Set the sums over the contacts to zero."""
    clear(work.force)
    work.means[:] = 0.0
    work.counts[:] = 0


@compiled
def _side(v, before):
    """Return the side of a slider with the mean velocity v; `before`: that of its motion before, see `FORWARD`."""
    if v == 0.0:
        return before
    return FORWARD if v > 0.0 else BACKWARD


@compiled
def _relative_path(paths, i, h, v, before, work):
    """Return the path of a contact relative to a slider with fast motion; its harmonics are written to `work`."""
    fast, path = work.fast, work.path
    for k in range(fast.normal_cos.size):
        path.normal_cos[k], path.normal_sin[k] = -fast.normal_cos[k], -fast.normal_sin[k]
        path.tangential_cos[k], path.tangential_sin[k] = -fast.tangential_cos[k], -fast.tangential_sin[k]
    path.normal_cos[0] += paths.normal_cos[i]
    path.normal_sin[0] += paths.normal_sin[i]
    path.tangential_cos[0] += paths.tangential_cos[i]
    path.tangential_sin[0] += paths.tangential_sin[i]
    a, b = path.normal_cos[0], path.normal_sin[0]
    z = approach(paths, i, 0.0, Coordinates(-h, 0.0))
    return Path(z, v, _side(v, before), path, np.hypot(a, b), np.arctan2(b, a))


@native(
    "t f f f t t",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.factors.stiffness": "n",
        "problem.factors.limit_slope": "n", "rule.node": "q", "rule.weight": "q",
        "work.fast.normal_cos": "k", "work.path.normal_cos": "k", "work.force.normal_cos": "0 | k", "work.means": "3",
        "work.counts": "3", "work.nodes.cos": "k q | 1 0",
    },
)  # fmt: skip
def cycle(problem, h, v, before, rule, work):
    """Fill means, harmonics of the forces and counts of a cycle that repeats; return 0.

    `h`: mean approach of a contact of height 0; `v`: mean velocity; `before`: where it is 0, the side of the motion
    before (`cycle_pieces.FORWARD`); `rule`: quadrature of each smooth piece, see `riding.quadrature`; `work`: a
    `Cycle`, which holds the slider's fast motion.
    """
    force, paths = work.force, problem.paths
    _clear(work)
    for i in range(paths.height.size):
        _add_contact(contact_parameters(problem, i), _relative_path(paths, i, h, v, before, work), rule, work)
    work.means[Mean.NORMAL] /= TURN
    work.means[Mean.TANGENTIAL] /= TURN
    for k in range(force.normal_cos.size):
        force.normal_cos[k] /= np.pi
        force.normal_sin[k] /= np.pi
        force.tangential_cos[k] /= np.pi
        force.tangential_sin[k] /= np.pi
    return 0


@native(
    "t f f1 f t t f2",
    {
        "problem.paths.height": "n", "problem.paths.normal_cos": "n", "problem.factors.stiffness": "n",
        "problem.factors.limit_slope": "n", "v": "n", "rule.node": "q", "rule.weight": "q",
        "work.path.normal_cos": "1", "work.force.normal_cos": "1", "work.means": "3", "work.counts": "3",
        "work.nodes.cos": "1 q | 1 1", "out": "9 n",
    },
)  # fmt: skip
def contact_cycles(problem, h, v, before, rule, work, out):
    """Fill the values `ContactMean` for every contact by itself, in a cycle of a slider without fast motion; return 0.

    `v`: mean velocity for each contact, so that contacts with another limit X = c z can have units of their own;
    `before`: as in `cycle`; `rule`: as there, or `cycle_pieces.CLOSED` for flat contacts with Coulomb's friction;
    `work`: a `Cycle` of one harmonic.
    """
    force, means, paths, wave = work.force, work.means, problem.paths, work.path
    for i in range(paths.height.size):
        _clear(work)
        # Phases are counted from the crest of u_z, because sines and cosines of small phases are cheaper.
        reach = normal_amplitude(paths, i)
        co, si = (paths.normal_cos[i] / reach, paths.normal_sin[i] / reach) if reach > 0.0 else (1.0, 0.0)
        _, _, d, e = at_phase(paths, i, co, si)
        wave.normal_cos[0], wave.normal_sin[0], wave.tangential_cos[0], wave.tangential_sin[0] = (reach, 0.0, d, e)
        path = Path(approach(paths, i, 0.0, Coordinates(-h, 0.0)), v[i], _side(v[i], before), wave, reach, 0.0)
        half = _add_contact(unpacked(contact_parameters(problem, i)), path, rule, work)
        out[ContactMean.NORMAL, i] = means[Mean.NORMAL] / TURN
        out[ContactMean.TANGENTIAL, i] = means[Mean.TANGENTIAL] / TURN
        cos, sin = force.normal_cos[0] / np.pi, force.normal_sin[0] / np.pi
        out[ContactMean.NORMAL_COS, i], out[ContactMean.NORMAL_SIN, i] = cos * co - sin * si, cos * si + sin * co
        cos, sin = force.tangential_cos[0] / np.pi, force.tangential_sin[0] / np.pi
        out[ContactMean.TANGENTIAL_COS, i] = cos * co - sin * si
        out[ContactMean.TANGENTIAL_SIN, i] = cos * si + sin * co
        out[ContactMean.SHARE, i] = half / np.pi
        out[ContactMean.FRICTION, i], out[ContactMean.LEAK, i] = means[Mean.FRICTION] / TURN, 0.0
        if rule.weight.size > 0:
            out[ContactMean.LEAK, i] = (
                0.5 * (cos * e - sin * d) - out[ContactMean.TANGENTIAL, i] * v[i] - out[ContactMean.FRICTION, i]
            )
    return 0


@compiled
def respond(problem, work):
    """Set the fast motion that the harmonics of the forces drive, dampers included."""
    d_n, d_t, fast, force = problem.normal_damping, problem.tangential_damping, work.fast, work.force
    for k in range(fast.normal_cos.size):
        normal = (force.normal_cos[k] - 1j * force.normal_sin[k]) * harmonic_response(k + 1.0, d_n)
        along = (force.tangential_cos[k] - 1j * force.tangential_sin[k]) * harmonic_response(k + 1.0, d_t)
        fast.normal_cos[k], fast.normal_sin[k] = normal.real, -normal.imag
        fast.tangential_cos[k], fast.tangential_sin[k] = along.real, -along.imag
