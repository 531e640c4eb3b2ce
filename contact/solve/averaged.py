r"""The slow motion of a slider that is heavy on the wave's time scale: kernels of the averaged way.

In the units of `scaling`, with h the mean approach, V the mean velocity and <> the event-exact means of `cycle`:

    h'' = p - <sum P>(h) (1 + chi h') - d_n h'      the bounce,
    V'  = <sum Q>(h, V) - d_t V - q                 the velocity.

Both are first-order averaging, error O((f_n/f)^2). The correction of second order feeds the fast part of the
slider's own motion, the answer to the harmonics of the forces, back into the cycle (`cycle_mean.respond`); at a steady
height and velocity its fixed point is the full periodic motion but for the harmonics left out.
"""

import numpy as np

from contact.jit.compiled import compiled, native, summed
from contact.solve.cycle_mean import STUCK, circle, cycle, respond

# why a computation ended
DONE, STICKS, UNSETTLED = 0, 1, 2


@summed
def _mean_powers(h, a, half, rule):
    """Return the sums of z^1.5 and z^0.5 over the half of a cycle that is in contact."""
    force = rate = 0.0
    for j in range(rule.shape[1]):
        co, _ = circle(half * rule[0, j])
        z = h + a * co
        z = z if z > 0.0 else 0.0
        root = np.sqrt(z)
        force += rule[1, j] * z * root
        rate += rule[1, j] * root
    return force, rate


@compiled
def mean_push(kappa, waves, h, rule):
    """Return the cycle mean of sum P at constant approach and its derivative in h; it depends on h/|u_z| alone."""
    total = slope = force = rate = 0.0
    last = -1.0
    for i in range(waves.shape[0]):
        a = np.hypot(waves[i, 0], waves[i, 1])
        if a != last:
            force = rate = 0.0
            last = a
            if h > -a:
                half = np.pi if h >= a else np.arccos(-h / a)
                force, rate = _mean_powers(h, a, half, rule)
                force *= kappa * half / np.pi
                rate *= 1.5 * kappa * half / np.pi
        total += force
        slope += rate
    return total, slope


@compiled
def riding(kappa, waves, target, rule):
    """Return the mean approach at which the cycle mean of sum P is the target > 0 (safeguarded Newton)."""
    n = waves.shape[0]
    high = (target / (kappa * n)) ** (2.0 / 3.0)
    reach = 0.0
    for i in range(n):
        reach = max(reach, np.hypot(waves[i, 0], waves[i, 1]))
    low = -reach
    h = high
    for _ in range(80):
        force, slope = mean_push(kappa, waves, h, rule)
        if force > target:
            high = h
        else:
            low = h
        step = (target - force) / slope if slope > 0.0 else high - low
        new = h + step
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - h) < 1e-15 * (reach + abs(h)) or high - low < 1e-15 * (reach + abs(h)):
            return new
        h = new
    return h


@compiled
def settled(parameters, waves, h, v, fast, rule, sums, counts, most):
    """Set fast motion, means and height of the cycle that repeats at mean velocity v; return (h, residual change).

    The first guess is what `fast` and `h` hold; each round gains a factor of about (f_n/f)^2.
    """
    change = np.inf
    for _ in range(most):
        cycle(parameters, waves, h, v, fast, rule, sums, counts)
        _, slope = mean_push(parameters[0], waves, h, rule)
        step = (parameters[3] - sums[0]) / slope if slope > 0.0 else 0.0
        a, b, c, d = fast[0, 0], fast[1, 0], fast[2, 0], fast[3, 0]
        respond(parameters, sums, fast)
        h += step
        change = max(abs(step), abs(fast[0, 0] - a), abs(fast[1, 0] - b))
        change = max(change, abs(fast[2, 0] - c), abs(fast[3, 0] - d))
        if change < 1e-13:
            break
    return h, change


@compiled
def _excess(parameters, waves, h, v, fast, rule, sums, counts):
    cycle(parameters, waves, h, v, fast, rule, sums, counts)
    return sums[1] - parameters[4] * v - parameters[5]


@compiled
def balance_row(parameters, waves, rule, out, harmonics, still, sums, fast, all_sums, counts):
    """Fill a row of `balances`; return the reason for ending; the last arguments are of `room`."""
    for k in range(4):
        still[k, 0] = 0.0
        for m in range(fast.shape[1]):
            fast[k, m] = 0.0
    reach_x = 0.0
    for i in range(waves.shape[0]):
        reach_x = max(reach_x, np.hypot(waves[i, 2], waves[i, 3]))
    h = riding(parameters[0], waves, parameters[3], rule)
    friction = parameters[6] * parameters[3]
    for k in range(out.size):
        out[k] = 0.0
    out[1] = h
    low = _excess(parameters, waves, h, 0.0, still, rule, sums, counts)
    out[4], out[5] = counts[0], counts[1]
    sticks = counts[STUCK] > 0
    way = 1.0
    if low <= 1e-13 * friction:
        high = _excess(parameters, waves, h, -1e-300, still, rule, sums, counts)
        if high >= -1e-13 * friction:
            out[3] = 1.0
            return DONE
        way, low = -1.0, high
    a, fa, b = 0.0, low, 1.05 * way * reach_x
    fb = _excess(parameters, waves, h, b, still, rule, sums, counts)
    for _ in range(60):
        if fb * way < 0.0:
            break
        if parameters[4] == 0.0:
            return UNSETTLED
        b *= 2.0
        fb = _excess(parameters, waves, h, b, still, rule, sums, counts)
    v = b
    top, wide = abs(b), 1e-11 if harmonics == 0 else 1e-4
    v_old, f_old = a, fa
    slope = (fb - fa) / (b - a)
    for count in range(100):
        v = b - fb * (b - a) / (fb - fa)
        if not min(a, b) < v < max(a, b) or count % 12 == 11:
            v = 0.5 * (a + b)
        f = _excess(parameters, waves, h, v, still, rule, sums, counts)
        if v != v_old:
            slope = (f - f_old) / (v - v_old)
        moved = abs(v - v_old)
        v_old, f_old = v, f
        if (f > 0.0) == (fb > 0.0):
            kept = 1.0 - f / fb
            fa *= kept if kept > 0.0 else 0.5
            b, fb = v, f
        else:
            a, fa, b, fb = b, fb, v, f
        if f == 0.0 or abs(f) < 1e-13 * friction or moved < wide * top:
            break
    out[4], out[5] = counts[0], counts[1]
    out[0], out[2] = v, abs(f_old / slope)
    if harmonics == 0 or not slope < 0.0:
        return DONE
    v -= f_old / slope
    v_old, f_old, change = v, 0.0, np.inf
    for count in range(40):
        h, change = settled(parameters, waves, h, v, fast, rule, all_sums, counts, 1)
        f = all_sums[1] - parameters[4] * v - parameters[5]
        if count > 1 and abs(v - v_old) > 1e-9 * top:
            new = (f - f_old) / (v - v_old)
            if 0.5 * slope > new > 2.0 * slope:
                slope = new
        v_old, f_old = v, f
        v -= f / slope
        change = max(change, abs(f / slope))
        if change < 1e-12:
            break
    out[0], out[1], out[2] = v, h, change
    out[4], out[5] = counts[0], counts[1]
    # the coefficients fall as n^-4.5 and the tail enters the mean with its own small share of the force
    last = all_sums.size - 1
    out[6] = np.hypot(all_sums[last - 1], all_sums[last]) / (harmonics + 1.0) ** 2
    if sticks and abs(v) < 1e-6 * top:
        return STICKS
    return DONE if change < 1e-7 else UNSETTLED


@native("f2 f3 f2 f2 i1 i i f2 f1 f2 f1 i1")
def _balances(parameters, waves, rule, out, why, first, stride, still, sums, fast, all_sums, counts):
    """Fill a row of `out` and the reason for ending for every `stride`-th problem from `first` on; return 0."""
    for m in range(first, parameters.shape[0], stride):
        why[m] = balance_row(
            parameters[m], waves[m], rule, out[m], fast.shape[1], still, sums, fast, all_sums, counts
        )
    return 0


def room(harmonics):
    """Return work for one problem at a time: fast motions and sums of first order, the same with harmonics, counts."""
    return (
        np.zeros((8, 1)),
        np.zeros(2),
        np.zeros((8, harmonics)),
        np.zeros(2 + 4 * harmonics),
        np.zeros(4, np.int64),
    )


def balances(parameters, waves, rule, harmonics, out, why, first, stride):
    """Balance every `stride`-th problem from `first` on.

    Parameters
    ----------
    parameters, waves : (k, 11), (k, contacts, 4) arrays
        See `scaling`.
    rule : (2, n) array
        See `quadrature`.
    harmonics : int
        Of the fast motion; 0: first order.
    out : (k, 7) array
        Rows to be filled: v, h, residual, held, contacts made, slips, error of the fast motion.
    why : (k,) int array
        To be filled with the reasons for ending.
    first, stride : int
        Which problems.
    """
    _balances(parameters, waves, rule, out, why, first, stride, *room(harmonics))


def balance(parameters, waves, rule, harmonics, out):
    """Fill one row of `balances`; return the reason for ending."""
    why = np.zeros(1, np.int64)
    balances(parameters[None], waves[None], rule, harmonics, out[None], why, 0, 1)
    return int(why[0])


@native("f1 f2 f f f2 f2 f1 f2 f1 i1 f1")
def _gap(parameters, waves, v, span, rule, still, sums, fast, all_sums, counts, answer):
    """Fill the answers of `first_order_gap` and `rest_tractions`; return 0."""
    h = riding(parameters[0], waves, parameters[3], rule)
    answer[1] = _excess(parameters, waves, h, 0.0, still, rule, sums, counts) + parameters[5]
    answer[2] = _excess(parameters, waves, h, -1e-300, still, rule, sums, counts) + parameters[5]
    if fast.shape[1] > 0:
        plain = _excess(parameters, waves, h, v, still, rule, sums, counts)
        step = 1e-3 * max(abs(v), 1e-3)
        slope = (_excess(parameters, waves, h, v + step, still, rule, sums, counts) - plain) / step
        settled(parameters, waves, h, v, fast, rule, all_sums, counts, 6)
        gap = abs(all_sums[1] - parameters[4] * v - parameters[5] - plain)
        answer[0] = gap * min(span, 1.0 / max(-slope, 1e-300))
    return 0


def first_order_gap(parameters, waves, v, span, rule, harmonics):
    """Return the error in V that first order collects by mean velocity v in a span of phase, or settles to."""
    answer = np.zeros(3)
    _gap(parameters, waves, v, span, rule, *room(harmonics), answer)
    return float(answer[0])


def rest_tractions(parameters, waves, rule):
    """Return the least and the largest mean traction of a cycle at rest; they differ where a contact sticks."""
    answer = np.zeros(3)
    _gap(parameters, waves, 0.0, 0.0, rule, *room(0), answer)
    return float(answer[1]), float(answer[2])


def drives_back(parameters, waves, rule):
    """Return whether the unloaded wave drives against its crests."""
    return rest_tractions(parameters, waves, rule)[1] < 0.0
