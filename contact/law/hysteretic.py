r"""The hysteretic law: Mindlin and Deresiewicz with full memory, for any history of approach z and deformation x.

By the method of dimensionality reduction (Popov and Hess, *Method of Dimensionality Reduction in Contact Mechanics and
Friction*, 2015, ch. 5) the contact is a row of independent springs at eta = s^2/R on 0..z, each with normal stiffness
E ds, tangential 4 G ds, and its own limit: deflection |x - y(eta)| <= c (z - eta). It returns Hertz, x_max = c z and
Cattaneo-Mindlin, and it is passive: no energy comes out of a closed loop. With u = x - c z and w = x + c z each
anchor y is a play, u + c eta <= y <= w - c eta, so that the profile y(eta) is a chain of

    +1: lines y = u + c eta (forward slip),  -1: lines y = w - c eta (backward slip),
     0: curves y = x at the time at which the growing contact reached eta,

and the force is Q = mu K (3/2c) int sqrt(eta) dy = mu K M: a line adds +-(eta_2^1.5 - eta_1^1.5). The innermost spring
(eta = 0) follows the same stop operator as the elastic law; the gauge is y(0) = 0, x its deflection. Regimes:

    annulus  slip of one sign s from the front eta_f, where the open line meets the chain, to the edge
    grow     no slip, |x'| <= c z'; the edge writes a curve
    slip     the line covers everything: gross slip, the chain is empty

A front that comes back to the start of a piece wipes it out. Only curves are discretised, at their segment's nodes.

Worked example, c = 0.1, lengths and forces scaled so that mu K = 1 (`tests/contact/test_memory_example.py`):

1. Pressed to z = 1 at x = 0. The edge has written one curve, y = 0 on 0 <= eta <= 1: chain (0: curve from 0), M = 0.
2. Sheared to x = 0.04. Slip comes in from the edge: the open line y = x - c (z - eta) = -0.06 + 0.1 eta lies over the
   curve from eta_f = z - x/c = 0.6 on, where it meets y = 0. M = 1 - 0.6^1.5 = 0.5352, Cattaneo's and Mindlin's force.
3. Sheared back to x = 0. The line freezes: chain (0: curve from 0), (+1: line from 0.6, u = -0.06, M there 0). Slip of
   the other sign comes in, its open line is y = x + c (z - eta) = 0.1 - 0.1 eta. It meets -0.06 + 0.1 eta at
   eta_f = 0.8 (half-way: a spring must be turned by twice its limit), so that

       M = (0.8^1.5 - 0.6^1.5) - (1 - 0.8^1.5) = -0.0337:

   at x = 0 the contact pushes back, which is the memory of step 2.
4. Sheared on to x = -0.04. The front has come to eta_f = 0.6, the start of the frozen line, and wipes it out: chain
   (0: curve from 0) as in step 2, and M = -0.5352. Nothing is left of step 2.

In the code `W` of a piece is x + c z at its inner end and `U` is x - c z, so that a line of either sign is constant in
one of them; y there is (U + W)/2 and eta is (W - U)/2c.
"""

from typing import NamedTuple

import numpy as np

from contact.body import slip_speed
from contact.codes import Event, Regime, Shape, Tangential
from contact.jit.compiled import compiled, formula
from contact.law import elastic
from contact.law.elastic import FAR_SIDE
from contact.law.normal import load
from contact.law.protocol import Law
from contact.roots import interpolate

# corner: eta, u, w and the moment M at the inner end of a piece
ETA, U, W, MOMENT = 0, 1, 2, 3
# rows of a curve, at its nodes: u, w, M and the rates of u, w in sigma
ON_U, ON_W, ON_MOMENT, RATE_U, RATE_W = range(5)
PIECES = 2048


class Memory(NamedTuple):
    """Chains of n contacts: number (n,), kind (n, K), corner (n, K, 4), curve (n, K, 5, nodes) of pieces, M (n,).

    `grid` has the nodes in sigma of the curves, their barycentric weights and the matrix of derivatives.
    """

    count: np.ndarray
    kind: np.ndarray
    corner: np.ndarray
    curve: np.ndarray
    level: np.ndarray
    grid: tuple


def blank(contacts: int, grid) -> Memory:
    """Return the memory of contacts that are apart."""
    return Memory(
        np.zeros(contacts, np.int64),
        np.zeros((contacts, PIECES), np.int64),
        np.zeros((contacts, PIECES, 4)),
        np.zeros((contacts, PIECES, 5, grid.sigma.size)),
        np.zeros(contacts),
        grid,
    )


def copy(memory: Memory) -> Memory:
    """Return an independent copy; only what is in use is copied."""
    twin = blank(memory.count.size, memory.grid)
    twin.count[:], twin.level[:] = memory.count, memory.level
    used = int(np.max(memory.count))
    for name in ("kind", "corner", "curve"):
        getattr(twin, name)[:, :used] = getattr(memory, name)[:, :used]
    return twin


@compiled
def front(memory, i, s, z, x, c):
    """Return (eta_f, M there): where the line of sign s through the edge meets the chain's last piece."""
    sigma, bary = memory.grid.sigma, memory.grid.bary
    k = memory.count[i] - 1
    if k < 0 or z <= 0.0:
        return 0.0, 0.0
    corner, kind, level = memory.corner[i, k], memory.kind[i, k], x - s * c * z
    other = W if s > 0.0 else U
    if kind != 0:  # a line of the other sign: its `other` is constant, so that both lines meet half-way
        eta = min(max(s * (corner[other] - level) / (2.0 * c), 0.0), z)
        return eta, corner[MOMENT] + kind * (load(eta, Shape.SPHERE) - load(corner[ETA], Shape.SPHERE))
    curve = memory.curve[i, k]
    values, others = (curve[ON_U], curve[ON_W]) if s > 0.0 else (curve[ON_W], curve[ON_U])
    rates = curve[RATE_U] if s > 0.0 else curve[RATE_W]
    if s * (values[0] - level) <= 0.0:
        return corner[ETA], corner[MOMENT]
    n = sigma.size
    if s * (values[n - 1] - level) >= 0.0:
        return min((curve[ON_W, n - 1] - curve[ON_U, n - 1]) / (2.0 * c), z), curve[ON_MOMENT, n - 1]
    a, b = -1.0, 1.0
    for j in range(1, n):  # monotone: bracketed by two nodes
        if s * (values[j] - level) <= 0.0:
            a, b = sigma[j - 1], sigma[j]
            break
    place = 0.5 * (a + b)
    for _ in range(80):
        gap = s * (interpolate(place, sigma, bary, values) - level)
        if gap > 0.0:
            a = place
        else:
            b = place
        rate = s * interpolate(place, sigma, bary, rates)
        step = place - gap / rate if rate < 0.0 else 0.5 * (a + b)
        if not a < step < b:
            step = 0.5 * (a + b)
        if abs(step - place) < 1e-15 or b - a < 1e-15:
            break
        place = step
    eta = s * (interpolate(place, sigma, bary, others) - level) / (2.0 * c)
    return min(max(eta, 0.0), z), interpolate(place, sigma, bary, curve[ON_MOMENT])


@compiled
def moment(memory, i, regime, s, z, x, c):
    """Return (M, eta_f) of a contact with approach z and deformation x: Q = mu K M."""
    if regime == Regime.SEPARATED or z <= 0.0:
        return 0.0, 0.0
    power = load(z, Shape.SPHERE)
    if regime == Regime.SLIP:
        return s * power, 0.0
    if regime == Regime.GROW:
        return memory.level[i], z
    eta, below = front(memory, i, s, z, x, c)
    return below + s * (power - load(eta, Shape.SPHERE)), eta


@formula
def annulus_slip(z, eta):
    """Return the force of the slipping springs over mu K and their share of the slip speed: eta to z, eta the front."""
    return load(z, Shape.SPHERE) - 1.5 * z * np.sqrt(eta) + 0.5 * load(eta, Shape.SPHERE)


@compiled
def write_curve(memory, i, z, x, level, c):
    """Append the curve that the edge has written: z, x and M at the nodes of a stretch; False if there is no room."""
    rates = memory.grid.rates
    k = memory.count[i]
    if k >= memory.kind.shape[1]:
        return False
    n = z.size
    curve = memory.curve[i, k]
    for j in range(n):
        curve[ON_U, j], curve[ON_W, j], curve[ON_MOMENT, j] = x[j] - c * z[j], x[j] + c * z[j], level[j]
    for j in range(n):
        curve[RATE_U, j] = curve[RATE_W, j] = 0.0
        for m in range(n):
            curve[RATE_U, j] += rates[j, m] * curve[ON_U, m]
            curve[RATE_W, j] += rates[j, m] * curve[ON_W, m]
    corner = memory.corner[i, k]
    # a contact that has just closed may have an approach of minus a rounding error
    corner[ETA], corner[U], corner[W] = max(z[0], 0.0), curve[ON_U, 0], curve[ON_W, 0]
    corner[MOMENT] = level[0]
    memory.kind[i, k] = 0
    memory.count[i] = k + 1
    memory.level[i] = level[n - 1]
    return True


@compiled
def freeze(memory, i, regime, s, z, x, c):
    """Append the open line of annular or gross slip to the chain; False if there is no room."""
    if regime != Regime.ANNULUS and regime != Regime.SLIP:
        return True
    k = memory.count[i]
    if k >= memory.kind.shape[1]:
        return False
    eta, below = 0.0, 0.0
    if regime == Regime.ANNULUS:
        eta, below = front(memory, i, s, z, x, c)
    y = x - s * c * (z - eta)
    corner = memory.corner[i, k]
    corner[ETA], corner[U], corner[W], corner[MOMENT] = eta, y - c * eta, y + c * eta, below
    memory.kind[i, k] = 1 if s > 0.0 else -1
    memory.count[i] = k + 1
    memory.level[i] = below + s * (load(z, Shape.SPHERE) - load(eta, Shape.SPHERE))
    return True


@compiled
def _annulus(memory, i, s):
    """Return the regime that slip of sign s opens: lines of its own sign are taken up again."""
    while memory.count[i] > 0 and memory.kind[i, memory.count[i] - 1] * s > 0.0:
        memory.count[i] -= 1
    return Regime.ANNULUS if memory.count[i] > 0 else Regime.SLIP


@compiled
def follow(problem, memory, i, regime, which, s, point):
    """Return (regime, sign, x, kind of event) on the far side of guard `which`, the chain changed to match."""
    z, x, z_rate, x_rate = point
    c = problem.limit_slope
    if which == 0:
        memory.count[i] = 0
        memory.level[i] = 0.0
        if regime != Regime.SEPARATED:
            return Regime.SEPARATED, s, 0.0, Event.RELEASE
        s = -1.0 if x_rate < 0.0 else 1.0
        return (Regime.SLIP if s * x_rate > c * z_rate else Regime.GROW), s, 0.0, Event.CONTACT
    if regime == Regime.GROW:
        s = 1.0 if which == 1 else -1.0
        regime = _annulus(memory, i, s)
        return regime, s, (s * c * z if regime == Regime.SLIP else x), Event.REVERSAL
    if which == 1:  # slip of this sign ends: the contact grows, or slips back from the edge
        kind = Event.SLIP_TO_STICK if regime == Regime.SLIP else Event.REVERSAL
        if regime == Regime.SLIP:
            x = s * c * z
        freeze(memory, i, regime, s, z, x, c)
        if z_rate > 0.0:
            return Regime.GROW, s, x, kind
        return _annulus(memory, i, -s), -s, x, kind
    if which == 2:  # a piece is wiped out
        memory.count[i] -= 1
        if _annulus(memory, i, s) == Regime.SLIP:
            return Regime.SLIP, s, s * c * z, Event.STICK_TO_SLIP
        return Regime.ANNULUS, s, x, Event.WIPE_OUT
    regime = _annulus(memory, i, -s)  # the shrinking edge has met the front
    return regime, -s, (-s * c * z if regime == Regime.SLIP else x), Event.WIPE_OUT


@compiled
def force(problem, memory, i, regime, s, point, level, front_before):
    """Return Q, and the front of an annulus; M of a growing contact is `level`."""
    z, x = point.approach, point.deformation
    if regime < Regime.ANNULUS:
        return elastic.tangential(problem, regime, s, point)[0], 0.0
    if z <= 0.0:
        return 0.0, front_before
    if regime == Regime.ANNULUS:
        level, front_before = moment(memory, i, regime, s, z, x, problem.limit_slope)
    return problem.friction * problem.stiffness * level, front_before


@compiled
def guard(problem, memory, i, regime, which, s, point, eta):
    """Return a guard; 1 where there is none. Separated and gross slip have those of the elastic law.

    Annulus: z > 0, slip goes on, the front has not reached the start of its piece, the edge has not met the front.
    Grow: z > 0, no forward slip, no backward slip.
    """
    if regime < Regime.ANNULUS:
        return elastic.guard(problem, memory, i, regime, which, s, point, eta)
    z, x, z_rate, x_rate = point
    c = problem.limit_slope
    if which == 0:
        return FAR_SIDE + z
    if regime == Regime.GROW:
        return 1.0 if which == 3 else FAR_SIDE - slip_speed(1.0 if which == 1 else -1.0, z_rate, x_rate, c)
    if which == 1:
        return FAR_SIDE + slip_speed(s, z_rate, x_rate, c)
    k = memory.count[i] - 1
    if which == 2:
        start = memory.corner[i, k, U if s > 0.0 else W]
        return FAR_SIDE + s * (start - x) + c * z
    if memory.kind[i, k] != 0:  # smooth even where the segment has run too far
        eta = 0.5 * (z + s * (memory.corner[i, k, W if s > 0.0 else U] - x) / c)
    else:  # a contact that opens just as it closed goes back along its curve: the front is at the edge all the way
        eta -= 1e-11
    return FAR_SIDE + z - eta


@compiled
def guard_rate(problem, memory, i, regime, which, s, point, second):
    """Return the rate of a guard; `second` is (z'', x'') of the contact."""
    if regime < Regime.ANNULUS:
        return elastic.guard_rate(problem, memory, i, regime, which, s, point, second)
    _, _, z_rate, x_rate = point
    c = problem.limit_slope
    if which == 0:
        return z_rate
    if regime == Regime.GROW:
        return 0.0 if which == 3 else -slip_speed(1.0 if which == 1 else -1.0, second[0], second[1], c)
    if which == 1:
        return slip_speed(s, second[0], second[1], c)
    return c * z_rate - s * x_rate if which == 2 else 0.5 * (s * x_rate + c * z_rate) / c


@compiled
def on_curve(memory, i):
    """Return whether a contact's chain ends with a curve, along which the front is smooth up to the next event only."""
    return memory.kind[i, memory.count[i] - 1] == 0


@compiled
def is_full(memory):
    """Return whether some contact has no room to remember more."""
    for i in range(memory.count.size):
        if memory.count[i] > memory.kind.shape[1] - 4:
            return True
    return False


@formula
def moment_rate(problem, z, x_rate):
    """Return dM/dt of a contact that grows without slip, dM = (3/2c) sqrt(z) dx."""
    return 1.5 / problem.limit_slope * np.sqrt(max(z, 0.0)) * x_rate


@compiled
def jump(memory, i, regime, s, old, new, c):
    """Take a contact along a straight line in (z, x); return (regime, sign, x): exact, however long the line."""
    (old_z, old_x, _, _), (z, x, _, _), sigma = old, new, memory.grid.sigma
    if z <= 0.0:
        memory.count[i] = 0
        memory.level[i] = 0.0
        return Regime.SEPARATED, 1.0, 0.0
    if regime == Regime.SEPARATED:  # pressed on first, as if it had always been so
        memory.count[i] = 0
        line = 0.25 * (sigma + 1.0) ** 2 * z
        write_curve(memory, i, line, 0.0 * line, 0.0 * line, c)
        regime, old_z, old_x = Regime.GROW, z, 0.0
    freeze(memory, i, regime, s, old_z, old_x, c)
    if abs(x) >= c * z * (1.0 - 1e-13):
        memory.count[i] = 0
        s = 1.0 if x > 0.0 else -1.0
        return Regime.SLIP, s, s * c * z
    dz, dx = z - old_z, x - old_x
    if abs(dx) <= c * dz:
        if dz > 0.0:
            root = np.sqrt(old_z) + 0.5 * (sigma + 1.0) * (np.sqrt(z) - np.sqrt(old_z))
            line = root**2  # so that M is a polynomial
            level = memory.level[i] + dx / (c * dz) * (line * root - load(old_z, Shape.SPHERE))
            write_curve(memory, i, line, old_x + dx / dz * (line - old_z), level, c)
        return Regime.GROW, s, x
    s = 1.0 if dx > 0.0 else -1.0
    if dz < 0.0:
        s = 1.0 if x > anchor(memory, i, z, c) else -1.0
    own = U if s > 0.0 else W
    while memory.count[i] > 0 and s * (memory.corner[i, memory.count[i] - 1, own] - x) + c * z <= 0.0:
        memory.count[i] -= 1
    regime = _annulus(memory, i, s)
    return regime, s, (s * c * z if regime == Regime.SLIP else x)


@compiled
def anchor(memory, i, eta, c):
    """Return y(eta) of the chain."""
    sigma, bary = memory.grid.sigma, memory.grid.bary
    k = memory.count[i] - 1
    while k > 0 and memory.corner[i, k, ETA] > eta:
        k -= 1
    corner, kind = memory.corner[i, k], memory.kind[i, k]
    if kind != 0:
        return 0.5 * (corner[U] + corner[W]) + kind * c * (eta - corner[ETA])
    place = place_on(memory.curve[i, k], eta, c, sigma, bary)
    values = memory.curve[i, k]
    return 0.5 * (
        interpolate(place, sigma, bary, values[ON_U]) + interpolate(place, sigma, bary, values[ON_W])
    )


@compiled
def place_on(curve, eta, c, sigma, bary):
    """Return where on a curve the edge was at eta (bisection)."""
    a, b = -1.0, 1.0
    for _ in range(60):
        m = 0.5 * (a + b)
        if (
            interpolate(m, sigma, bary, curve[ON_W]) - interpolate(m, sigma, bary, curve[ON_U])
            < 2.0 * c * eta
        ):
            a = m
        else:
            b = m
    return 0.5 * (a + b)


def chain_energy(problem, memory, i, regime, s, z, x):
    """Return the tangential springs' energy, mu K (3/8c) int (x - y)^2/sqrt(eta) d eta, x - y the deflection.

    On a line y is linear in eta; on a curve sqrt(eta) dy = (2c/3) dM, so that by parts the integral is
    [2 sqrt(eta) (x - y)^2] + (8c/3) int (x - y) dM, by Gauss's rule on its polynomials.
    """
    if regime == Regime.SEPARATED or z <= 0.0:
        return 0.0
    c = problem.limit_slope
    pieces = [(memory.kind[i, k], *memory.corner[i, k, :3], k) for k in range(memory.count[i])]
    if regime == Regime.SLIP:
        pieces = [(int(s), 0.0, 0.0, 0.0, -1)]
    elif regime == Regime.ANNULUS:
        eta, _ = front(memory, i, s, z, x, c)
        y = x - s * c * (z - eta)
        pieces.append((int(s), eta, y - c * eta, y + c * eta, -1))
    node, weight = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for number, (kind, start, u, w, k) in enumerate(pieces):
        stop = pieces[number + 1][1] if number + 1 < len(pieces) else z
        if kind != 0:
            deflection, roots = x - 0.5 * (u + w) + kind * c * start, np.sqrt([max(start, 0.0), stop])
            parts = (
                2.0 * deflection**2 * roots
                - 4.0 / 3.0 * deflection * kind * c * roots**3
                + 0.4 * c**2 * roots**5
            )
            total += parts[1] - parts[0]
            continue
        curve = memory.curve[i, k]
        end = (
            place_on(curve, stop, c, memory.grid.sigma, memory.grid.bary)
            if 2.0 * c * stop < curve[1, -1] - curve[0, -1]
            else 1.0
        )
        middle, half = 0.5 * (end - 1.0), 0.5 * (end + 1.0)
        profile, slope = 0.5 * (curve[0] + curve[1]), memory.grid.rates @ curve[2]

        def at(values, place):
            return interpolate(place, memory.grid.sigma, memory.grid.bary, values)

        inside = sum(
            g * (x - at(profile, middle + half * p)) * at(slope, middle + half * p)
            for p, g in zip(node, weight, strict=True)
        )
        total += 8.0 * c / 3.0 * half * inside
        total += (
            2.0 * np.sqrt(stop) * (x - at(profile, end)) ** 2
            - 2.0 * np.sqrt(max(start, 0.0)) * (x - profile[0]) ** 2
        )
    return problem.friction * problem.stiffness * 0.375 / c * total


def mindlin_deresiewicz() -> Law:
    """Return the hysteretic law: gross slip is that of the elastic one."""
    return elastic.coulomb(Tangential.HYSTERETIC)._replace(
        force=force, guard=guard, guard_rate=guard_rate, follow=follow
    )
