r"""The hysteretic law: Mindlin and Deresiewicz with full memory, for any history of approach z and deformation x.

By the method of dimensionality reduction (Popov and Hess, *Method of Dimensionality Reduction in Contact Mechanics and
Friction*, 2015, ch. 5) the contact is a row of independent springs at eta = s^2/R, 0 <= eta <= z, each with normal
stiffness E ds and tangential stiffness 4 G ds. A spring is anchored at y(eta) and slips where its deflection reaches
its own limit,

    |x - y(eta)| <= c (z - eta).                                                                                  (1)

The row returns Hertz's force, x_max = c z and the force of Cattaneo and Mindlin, and it gives out no energy in a closed
loop. With u = x - c z and w = x + c z the rule (1) reads u + c eta <= y <= w - c eta. The anchors therefore form a
*chain* of pieces, from the centre (eta = 0) to the edge (eta = z):

    kind +1, line    y = u + c eta       springs that slipped forward;   u is constant along it                   (2)
    kind -1, line    y = w - c eta       springs that slipped backward;  w is constant along it                   (3)
    kind  0, curve   y = x(t), eta = z(t)   springs that came into contact at t, without slip                     (4)

and the force is the moment of the chain,

    Q = mu K M,    M = (1/c) int_0^z p'(eta) dy,    +-(p(eta_2) - p(eta_1)) of a line from eta_1 to eta_2.        (5)

p = z^1.5 is the normal force of a sphere over K. For any other that begins as a sphere's, of rough balls for instance,
the springs have the stiffnesses p'' d eta, and all else is the same: Jaeger and Ciavarella (`averaged.memory_cycle`).

The spring at eta = 0 follows the same stop operator as the elastic law. Its anchor is y(0) = 0, so that x is its
deflection. A contact that touches is in one of three regimes:

    annulus  The springs from the *front* eta_f to the edge z slip towards s. Their anchors form the *open line*, (2) or
             (3) with the present u or w. The front is where the open line meets the chain: inside it the springs stick.
    grow     No spring slips, |x'| <= c z'. The edge moves outwards and writes a curve (4), dM = p'(z) dx/c.  (6)
    slip     Gross slip: the open line covers all springs, and the chain is empty.

If the front comes back to the inner end of a piece, the piece is *wiped out*: it is removed from the chain. When slip
ends, the open line is *frozen*: it becomes the last piece of the chain. If the edge shrinks down to the front, the path
in the plane of z and x crosses the chain, and slip of the other sign begins.

Only curves are discretised, at the nodes sigma in [-1, 1] of the segment (time step of the event-driven solver) during
which they were written. Segments follow one another while the edge grows, because they have a largest length and end at
the events of other contacts. Their curves join smoothly into one *arc*, which is wiped out as a whole: the front passes
from curve to curve without an event. An event at each joint would end the segments of all contacts, whose curves
would then have more joints: the events of contacts in opposition would multiply from cycle to cycle.

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

A piece is stored by u and w at its inner end (`U`, `W`), where y = (u + w)/2 and eta = (w - u)/2c. In the functions
below s is the sign of slip, z the approach, x the deformation and i the contact.
"""

from typing import NamedTuple

import numpy as np

from contact.body import slip_speed
from contact.codes import Event, Guard, Regime, Tangential
from contact.jit.compiled import compiled, formula
from contact.law import elastic
from contact.law.elastic import FAR_SIDE
from contact.law.normal import energy, hertz, slope
from contact.law.normal import load as any_load
from contact.law.protocol import Law
from contact.roots import interpolate

# Columns of `Memory.corner`: eta, u, w and M at the inner end of a piece
ETA, U, W, MOMENT = 0, 1, 2, 3
# First index of `Memory.curve`: u, w and M at the nodes of a curve, and the derivatives of u and w in sigma
ON_U, ON_W, ON_MOMENT, RATE_U, RATE_W = range(5)
PIECES = 2048  # of one contact; a run that needs more is refused


class Memory(NamedTuple):
    """Chains of n contacts, with room for K pieces each; pieces are ordered from the centre to the edge."""

    number: np.ndarray  # (n,) int: number of pieces
    kind: np.ndarray  # (n, K) int: +1, -1, 0, eqs. (2) to (4)
    corner: np.ndarray  # (n, K, 4): see ETA, U, W, MOMENT
    curve: np.ndarray  # (n, K, 5, nodes): of pieces of kind 0
    arc: (
        np.ndarray
    )  # (n, K) int: the first piece of the arc that a piece of kind 0 belongs to; of a line its own number
    growing: (
        np.ndarray
    )  # (n,) int: 1 if the edge has written the last piece and grows on, so that the next one joins it
    level: np.ndarray  # (n,): M of the whole chain
    grid: tuple  # nodes in sigma of the curves, their barycentric weights and the matrix of derivatives


def blank(contacts: int, grid) -> Memory:
    """Return the memory of open contacts."""
    number, kind = np.zeros(contacts, np.int64), np.zeros((contacts, PIECES), np.int64)
    corner, curve = np.zeros((contacts, PIECES, 4)), np.zeros((contacts, PIECES, 5, grid.sigma.size))
    arc, growing = np.zeros((contacts, PIECES), np.int64), np.zeros(contacts, np.int64)
    return Memory(number, kind, corner, curve, arc, growing, np.zeros(contacts), grid)


def copy(memory: Memory) -> Memory:
    """Return an independent copy; only what is in use is copied."""
    other = blank(memory.number.size, memory.grid)
    other.number[:], other.level[:], other.growing[:] = memory.number, memory.level, memory.growing
    used = int(np.max(memory.number))
    for name in ("kind", "corner", "curve", "arc"):
        getattr(other, name)[:, :used] = getattr(memory, name)[:, :used]
    return other


@formula
def load(z, normal):
    """Return p(z): of a smooth sphere by itself, which saves a fifth of the time of its motion."""
    return hertz(z) if normal.smooth == 1 else any_load(z, normal)


@formula
def _rise(z, normal):
    """Return p'(z), of a smooth sphere by itself."""
    return 1.5 * np.sqrt(max(z, 0.0)) if normal.smooth == 1 else slope(z, normal)


@compiled
def front(memory, i, s, z, x, c, normal):
    """Return (eta_f, M there): where the open line of slip towards s meets the last piece of the chain.

    The open line has one u (s = +1) or w (s = -1), `constant`. It meets a frozen line, which is of the other sign, at
    eta = (w - u)/2c. It meets a curve where the curve's own u (or w) has this value. Neither is limited to the edge, so
    that both move smoothly through the event at which they meet it.
    """
    last = memory.number[i] - 1
    if last < 0 or z <= 0.0:
        return 0.0, 0.0
    corner, kind, constant = memory.corner[i, last], memory.kind[i, last], x - s * c * z
    if kind == 0:
        k = _crossed(memory, i, s, constant)
        return _front_on_curve(memory, i, k, s, c, constant)[:2]
    eta = max(s * (corner[W if s > 0.0 else U] - constant) / (2.0 * c), 0.0)
    return eta, corner[MOMENT] + kind * (load(eta, normal) - load(corner[ETA], normal))


@compiled
def _crossed(memory, i, s, constant):
    """Return the number of the curve that an open line meets, of the arc at the end of the chain."""
    k, own = memory.number[i] - 1, U if s > 0.0 else W
    first = memory.arc[i, k]
    while k > first and s * (memory.corner[i, k, own] - constant) <= 0.0:
        k -= 1
    return k


@compiled
def trim(memory, i, s, z, x, c):
    """Remove the curves which the front has passed, but not the first one of an arc."""
    last = memory.number[i] - 1
    if last >= 0 and memory.kind[i, last] == 0:
        memory.number[i] = _crossed(memory, i, s, x - s * c * z) + 1


@compiled
def _front_on_curve(memory, i, k, s, c, constant):
    """Return (eta_f, M, sigma) where an open line meets curve k (safeguarded Newton)."""
    sigma, bary = memory.grid.sigma, memory.grid.bary
    corner, curve, n = memory.corner[i, k], memory.curve[i, k], sigma.size
    # u and w of the curve for s = +1, w and u for s = -1: the first is constant along the open line
    first, second = (curve[ON_U], curve[ON_W]) if s > 0.0 else (curve[ON_W], curve[ON_U])
    rates = curve[RATE_U] if s > 0.0 else curve[RATE_W]
    if s * (first[0] - constant) <= 0.0:  # the whole curve slips
        return corner[ETA], corner[MOMENT], -1.0
    if s * (first[n - 1] - constant) >= 0.0:  # nothing of it slips
        return (curve[ON_W, n - 1] - curve[ON_U, n - 1]) / (2.0 * c), curve[ON_MOMENT, n - 1], 1.0
    a, b = -1.0, 1.0
    for j in range(1, n):  # s u falls along the curve: two neighbouring nodes bracket the root
        if s * (first[j] - constant) <= 0.0:
            a, b = sigma[j - 1], sigma[j]
            break
    root = 0.5 * (a + b)
    for _ in range(80):
        gap = s * (interpolate(root, sigma, bary, first) - constant)
        if gap > 0.0:
            a = root
        else:
            b = root
        rate = s * interpolate(root, sigma, bary, rates)
        new = root - gap / rate if rate < 0.0 else 0.5 * (a + b)
        if not a < new < b:
            new = 0.5 * (a + b)
        if abs(new - root) < 1e-15 or b - a < 1e-15:
            break
        root = new
    eta = s * (interpolate(root, sigma, bary, second) - constant) / (2.0 * c)
    return max(eta, 0.0), interpolate(root, sigma, bary, curve[ON_MOMENT]), root


@compiled
def moment(memory, i, regime, s, z, x, c, normal):
    """Return (M, eta_f) of a contact with approach z and deformation x, eq. (5)."""
    if regime == Regime.SEPARATED or z <= 0.0:
        return 0.0, 0.0
    whole = load(z, normal)
    if regime == Regime.SLIP:
        return s * whole, 0.0
    if regime == Regime.GROW:
        return memory.level[i], z
    eta, below = front(memory, i, s, z, x, c, normal)
    return below + s * (whole - load(eta, normal)), eta


@formula
def annulus_slip(z, eta, normal):
    """Return the sum of the slip limits (1) of the springs from eta to z over mu K, int (z - t) p''(t) dt.

    All of them slip at the speed of the open line: this sum times mu K and that speed is the friction power.
    """
    return load(z, normal) - load(eta, normal) - (z - eta) * _rise(eta, normal)


@compiled
def write_curve(memory, i, z, x, level, c):
    """Append a curve (4) of z, x and M at the nodes of its segment; False if there is no room.

    It joins the arc of the last piece if the edge has been `growing` since that was written.
    """
    rates, k, n = memory.grid.rates, memory.number[i], z.size
    if k >= memory.kind.shape[1]:
        return False
    curve = memory.curve[i, k]
    for j in range(n):
        curve[ON_U, j], curve[ON_W, j], curve[ON_MOMENT, j] = x[j] - c * z[j], x[j] + c * z[j], level[j]
    for j in range(n):
        curve[RATE_U, j] = curve[RATE_W, j] = 0.0
        for m in range(n):
            curve[RATE_U, j] += rates[j, m] * curve[ON_U, m]
            curve[RATE_W, j] += rates[j, m] * curve[ON_W, m]
    corner = memory.corner[i, k]
    # the approach of a contact that has just closed may be negative by a rounding error
    corner[ETA], corner[U], corner[W] = max(z[0], 0.0), curve[ON_U, 0], curve[ON_W, 0]
    corner[MOMENT] = level[0]
    joins = k > 0 and memory.growing[i] == 1 and memory.kind[i, k - 1] == 0
    memory.arc[i, k] = memory.arc[i, k - 1] if joins else k
    memory.kind[i, k] = 0
    memory.number[i] = k + 1
    memory.level[i] = level[n - 1]
    return True


@compiled
def freeze(memory, i, regime, s, z, x, contact):
    """Make the open line of annular or gross slip the last piece of the chain; False if there is no room."""
    if regime != Regime.ANNULUS and regime != Regime.SLIP:
        return True
    eta, below, c = 0.0, 0.0, contact.limit_slope
    if regime == Regime.ANNULUS:
        trim(memory, i, s, z, x, c)
        eta, below = front(memory, i, s, z, x, c, contact.normal)
    k = memory.number[i]
    if k >= memory.kind.shape[1]:
        return False
    y = x - s * c * (z - eta)
    corner = memory.corner[i, k]
    corner[ETA], corner[U], corner[W], corner[MOMENT] = eta, y - c * eta, y + c * eta, below
    memory.kind[i, k], memory.arc[i, k] = 1 if s > 0.0 else -1, k
    memory.number[i] = k + 1
    memory.level[i] = below + s * (load(z, contact.normal) - load(eta, contact.normal))
    return True


@compiled
def _begin_slip(memory, i, s):
    """Return the regime in which slip towards s begins, annulus or slip.

    Frozen lines of the same sign at the end of the chain have the u (or w) of the open line. They become a part of it
    and are removed.
    """
    while memory.number[i] > 0 and memory.kind[i, memory.number[i] - 1] * s > 0.0:
        memory.number[i] -= 1
    return Regime.ANNULUS if memory.number[i] > 0 else Regime.SLIP


@compiled
def follow(problem, memory, i, regime, which, s, point):
    """Return (regime, sign, x, kind of event) on the far side of guard `which`, the chain changed to match."""
    z, x, z_rate, x_rate = point
    c = problem.limit_slope
    if which == Guard.GAP:
        memory.number[i] = 0
        memory.level[i] = 0.0
        if regime != Regime.SEPARATED:
            return Regime.SEPARATED, s, 0.0, Event.RELEASE
        s = -1.0 if x_rate < 0.0 else 1.0
        return (Regime.SLIP if s * x_rate > c * z_rate else Regime.GROW), s, 0.0, Event.CONTACT
    if regime == Regime.GROW:
        s = 1.0 if which == Guard.GROW_FORWARD else -1.0
        if z_rate < 0.0:  # the edge retreats, and the spring at the new edge slips from its anchor to x
            s = 1.0 if x_rate > _slope_at_edge(memory, i, c) * z_rate else -1.0
        regime = _begin_slip(memory, i, s)
        return regime, s, (s * c * z if regime == Regime.SLIP else x), Event.REVERSAL
    if which == Guard.SLIP_SPEED:  # slip of this sign ends: the contact grows, or slips back from the edge
        kind = Event.SLIP_TO_STICK if regime == Regime.SLIP else Event.REVERSAL
        if regime == Regime.SLIP:
            x = s * c * z
        freeze(memory, i, regime, s, z, x, problem)
        if z_rate > 0.0:
            return Regime.GROW, s, x, kind
        return _begin_slip(memory, i, -s), -s, x, kind
    if which == Guard.ANNULUS_PIECE:  # a piece is wiped out
        memory.number[i] = memory.arc[i, memory.number[i] - 1]
        if _begin_slip(memory, i, s) == Regime.SLIP:
            return Regime.SLIP, s, s * c * z, Event.STICK_TO_SLIP
        return Regime.ANNULUS, s, x, Event.WIPE_OUT
    regime = _begin_slip(memory, i, -s)  # the shrinking edge has met the front
    return regime, -s, (-s * c * z if regime == Regime.SLIP else x), Event.WIPE_OUT


@compiled
def _slope_at_edge(memory, i, c):
    """Return dy/d eta at the edge of a contact that has grown, of a curve between its last two nodes."""
    k = memory.number[i] - 1
    if k < 0 or memory.kind[i, k] != 0:
        return c * memory.kind[i, k] if k >= 0 else 0.0
    u, w, n = memory.curve[i, k, ON_U], memory.curve[i, k, ON_W], memory.grid.sigma.size
    du, dw = u[n - 1] - u[n - 2], w[n - 1] - w[n - 2]
    return c * (du + dw) / (dw - du) if dw > du else 0.0


@compiled
def force(problem, memory, i, regime, s, point, level, front_before):
    """Return Q and the front of an annulus. `level`: M of a contact that grows; `front_before`: for other regimes."""
    z, x = point.approach, point.deformation
    if regime < Regime.ANNULUS:
        return elastic.tangential(problem, regime, s, point)[0], 0.0
    if z <= 0.0:
        return 0.0, front_before
    if regime == Regime.ANNULUS:
        level, front_before = moment(memory, i, regime, s, z, x, problem.limit_slope, problem.normal)
    return problem.friction * problem.stiffness * level, front_before


@compiled
def guard(problem, memory, i, regime, which, s, point, eta):
    """Return guard number `which` (`codes.Guard`) of a regime; 1.0 where the regime has no such guard.

    Separated and gross slip have the guards of the elastic law; `eta` is the front of an annulus. A guard is positive
    inside its regime; `law.elastic.FAR_SIDE` shifts its zero a little past the event.
    """
    if regime < Regime.ANNULUS:  # separated or gross slip
        return elastic.guard(problem, memory, i, regime, which, s, point, eta)
    z, x, z_rate, x_rate = point
    c = problem.limit_slope
    if which == Guard.GAP:
        return FAR_SIDE + z
    if regime == Regime.GROW:
        if which > Guard.GROW_BACKWARD:
            return 1.0
        return FAR_SIDE - slip_speed(1.0 if which == Guard.GROW_FORWARD else -1.0, z_rate, x_rate, c)
    if which == Guard.SLIP_SPEED:
        return FAR_SIDE + slip_speed(s, z_rate, x_rate, c)
    k = memory.number[i] - 1
    own, other = (U, W) if s > 0.0 else (W, U)
    if which == Guard.ANNULUS_PIECE:  # u (or w) of the open line, less that at the inner end of the last arc or line
        return FAR_SIDE + s * (memory.corner[i, memory.arc[i, k], own] - x) + c * z
    # ANNULUS_EDGE: distance of the edge from the front
    if memory.kind[i, k] != 0:  # as in `front`, but not limited to positive values
        eta = 0.5 * (z + s * (memory.corner[i, k, other] - x) / c)
    else:  # A contact that opens along the curve on which it closed has its front at the edge up to rounding: the
        # front is moved inwards by more than that, so that slip does not change its sign again and again.
        eta -= 1e-11
    return FAR_SIDE + z - eta


@compiled
def guard_rate(problem, memory, i, regime, which, s, point, second):
    """Return the rate of a guard; `second` is (z'', x'') of the contact."""
    if regime < Regime.ANNULUS:
        return elastic.guard_rate(problem, memory, i, regime, which, s, point, second)
    _, _, z_rate, x_rate = point
    c = problem.limit_slope
    if which == Guard.GAP:
        return z_rate
    if regime == Regime.GROW:
        if which > Guard.GROW_BACKWARD:
            return 0.0
        return -slip_speed(1.0 if which == Guard.GROW_FORWARD else -1.0, second[0], second[1], c)
    if which == Guard.SLIP_SPEED:
        return slip_speed(s, second[0], second[1], c)
    if which == Guard.ANNULUS_PIECE:
        return c * z_rate - s * x_rate
    if on_curve(memory, i):
        constant = point.deformation - s * c * point.approach
        k = _crossed(memory, i, s, constant)
        at = _front_on_curve(memory, i, k, s, c, constant)[2]
        sigma, bary, curve = memory.grid.sigma, memory.grid.bary, memory.curve[i, k]
        u_slope = interpolate(at, sigma, bary, curve[RATE_U])
        w_slope = interpolate(at, sigma, bary, curve[RATE_W])
        own = u_slope if s > 0.0 else w_slope
        if s * own < 0.0:
            return z_rate - (x_rate - s * c * z_rate) * (w_slope - u_slope) / (2.0 * c * own)
    return 0.5 * (s * x_rate + c * z_rate) / c


@compiled
def on_curve(memory, i):
    """Return True if a chain ends with a curve: the front moves smoothly along it up to the next event only."""
    return memory.kind[i, memory.number[i] - 1] == 0


@compiled
def is_full(memory):
    """Return True if some contact has no room to remember more."""
    for i in range(memory.number.size):
        if memory.number[i] > memory.kind.shape[1] - 4:
            return True
    return False


@formula
def moment_rate(problem, z, x_rate):
    """Return dM/dt of a contact that grows without slip, eq. (6)."""
    return _rise(z, problem.normal) / problem.limit_slope * x_rate


@compiled
def jump(memory, i, regime, s, old, new, contact):
    """Move a contact along a straight line from one point (z, x) to another; return (regime, sign, x).

    The chain at the end is exact for a line of any length. A separated contact is first pressed to the approach z at
    x = 0. Then, by the change (dz, dx): a contact that grows without slip, |dx| <= c dz, writes a curve; otherwise slip
    comes in from the edge, and the pieces that the front has passed are removed.
    """
    (old_z, old_x, _, _), (z, x, _, _), sigma, c = old, new, memory.grid.sigma, contact.limit_slope
    if z <= 0.0:
        memory.number[i] = 0
        memory.level[i] = 0.0
        return Regime.SEPARATED, 1.0, 0.0
    if regime == Regime.SEPARATED:
        memory.number[i] = 0
        line = 0.25 * (sigma + 1.0) ** 2 * z
        write_curve(memory, i, line, 0.0 * line, 0.0 * line, c)
        regime, old_z, old_x = Regime.GROW, z, 0.0
    freeze(memory, i, regime, s, old_z, old_x, contact)
    if abs(x) >= c * z * (1.0 - 1e-13):
        memory.number[i] = 0
        s = 1.0 if x > 0.0 else -1.0
        return Regime.SLIP, s, s * c * z
    dz, dx = z - old_z, x - old_x
    if abs(dx) <= c * dz:
        if dz > 0.0:
            root = np.sqrt(old_z) + 0.5 * (sigma + 1.0) * (np.sqrt(z) - np.sqrt(old_z))
            line = root**2  # so that M of a sphere is a polynomial
            level, below = 0.0 * line, load(old_z, contact.normal)
            for k in range(line.size):
                level[k] = memory.level[i] + dx / (c * dz) * (load(line[k], contact.normal) - below)
            write_curve(memory, i, line, old_x + dx / dz * (line - old_z), level, c)
        return Regime.GROW, s, x
    s = 1.0 if dx > 0.0 else -1.0
    if dz < 0.0:  # the edge retreats, and the spring at the new edge slips from its anchor to x
        s = 1.0 if x > anchor(memory, i, z, c) else -1.0
    own = U if s > 0.0 else W
    while memory.number[i] > 0 and s * (memory.corner[i, memory.number[i] - 1, own] - x) + c * z <= 0.0:
        memory.number[i] -= 1
    regime = _begin_slip(memory, i, s)
    return regime, s, (s * c * z if regime == Regime.SLIP else x)


@compiled
def anchor(memory, i, eta, c):
    """Return the anchor y(eta) of a spring."""
    sigma, bary = memory.grid.sigma, memory.grid.bary
    k = memory.number[i] - 1
    while k > 0 and memory.corner[i, k, ETA] > eta:
        k -= 1
    corner, kind = memory.corner[i, k], memory.kind[i, k]
    if kind != 0:
        return 0.5 * (corner[U] + corner[W]) + kind * c * (eta - corner[ETA])
    at = sigma_on(memory.curve[i, k], eta, c, sigma, bary)
    values = memory.curve[i, k]
    return 0.5 * (interpolate(at, sigma, bary, values[ON_U]) + interpolate(at, sigma, bary, values[ON_W]))


@compiled
def sigma_on(curve, eta, c, sigma, bary):
    """Return sigma on a curve at which the edge was at eta = (w - u)/2c (bisection)."""
    a, b = -1.0, 1.0
    for _ in range(60):
        m = 0.5 * (a + b)
        width = interpolate(m, sigma, bary, curve[ON_W]) - interpolate(m, sigma, bary, curve[ON_U])
        if width < 2.0 * c * eta:
            a = m
        else:
            b = m
    return 0.5 * (a + b)


def chain_energy(problem, memory, i, regime, s, z, x):
    """Return the energy of the tangential springs, (mu K/2c) int_0^z (x - y)^2 p''(eta) d eta."""
    if regime == Regime.SEPARATED or z <= 0.0:
        return 0.0
    c = problem.limit_slope
    pieces = [(memory.kind[i, k], memory.corner[i, k], memory.curve[i, k]) for k in range(memory.number[i])]
    if regime == Regime.SLIP:
        pieces = [(int(s), np.zeros(4), None)]
    elif regime == Regime.ANNULUS:
        eta, _ = front(memory, i, s, z, x, c, problem.normal)
        y = x - s * c * (z - eta)
        pieces.append((int(s), np.array([eta, y - c * eta, y + c * eta, 0.0]), None))
    ends = [corner[ETA] for _, corner, _ in pieces[1:]] + [z]
    total = 0.0
    for (kind, corner, curve), end in zip(pieces, ends, strict=True):
        if kind == 0:
            total += _curve_energy(memory.grid, curve, x, c, corner[ETA], end, problem.normal)
        else:
            total += _line_energy(x - 0.5 * (corner[U] + corner[W]), kind * c, corner[ETA], end, problem.normal)
    return problem.friction * problem.stiffness * 0.5 / c * total


def _line_energy(deflection, bend, start, end, normal):
    """Return int (x - y)^2 p'' d eta over a line: x - y = deflection - bend (eta - start); by parts."""
    ends = np.array([max(start, 0.0), end])
    left = deflection - bend * (ends - start)
    work = np.array([energy(each, normal) for each in ends])
    parts = left**2 * slope(ends, normal) + 2.0 * bend * (left * any_load(ends, normal) + bend * work)
    return parts[1] - parts[0]


def _curve_energy(grid, curve, x, c, start, end, normal):
    """Return the same integral over a curve, up to the node at which the edge was at eta = end.

    With p' dy = c dM, eq. (6), it is [p' (x - y)^2] + 2c int (x - y) dM by parts; y and M are polynomials in sigma,
    which Gauss's rule integrates exactly.
    """
    sigma, bary = grid.sigma, grid.bary
    stop = sigma_on(curve, end, c, sigma, bary) if 2.0 * c * end < curve[ON_W, -1] - curve[ON_U, -1] else 1.0
    anchors, rise = 0.5 * (curve[ON_U] + curve[ON_W]), grid.rates @ curve[ON_MOMENT]
    node, weight = np.polynomial.legendre.leggauss(24)
    middle, half = 0.5 * (stop - 1.0), 0.5 * (stop + 1.0)
    inside = 0.0
    for at, part in zip(middle + half * node, weight, strict=True):
        inside += part * (x - interpolate(at, sigma, bary, anchors)) * interpolate(at, sigma, bary, rise)
    after, before = x - interpolate(stop, sigma, bary, anchors), x - anchors[0]
    edges = slope(end, normal) * after**2 - slope(max(start, 0.0), normal) * before**2
    return 2.0 * c * half * inside + edges


def mindlin_deresiewicz() -> Law:
    """Return the hysteretic law: gross slip is that of the elastic one."""
    return elastic.coulomb(Tangential.HYSTERETIC)._replace(
        force=force, guard=guard, guard_rate=guard_rate, follow=follow
    )
