r"""Rows of contacts on a surface wave with overtones: one pass along the wave, contacts in samples of the cycle.

A bare crystal has no dispersion, so that each harmonic n of the contacts' forces feeds an overtone in phase, with the
compliance Gamma of the fundamental (`march`; n = 1, 2 ... N)

    dU_n/dx = i g sum_i (P_n + C* Q_n) exp(i n k x) delta(x - x_i)                                              (1)

with U_1 known at the slider's edge and the other U_n = 0 there. Each row is passed by the implicit midpoint rule: its
forces are those at the mean of the amplitudes on its two sides, which is iterated (`overtone_march`).

Between two of the M samples of a cycle the surface moves along a straight line, so that z and y of a contact are linear
in the fraction t of the interval. On such a path contact, stick and slip end at roots of linear functions, and all
integrals are closed (`_cycle`). With x the deformation, c z its limit and dz, dy the changes of z and y in the
interval,

    stick               x(t) = x(0) + t dy,    until  c z(t) - s x(t) = 0,
                        t_s = (c z(0) - s x(0))/(s dy - c dz)             for the s for which this is smaller,      (2)
    slip towards s      x(t) = s c z(t),       to the end of the interval,
                        friction work over the stiffness  int c z (s dy - c dz) dt.                                 (3)

P_n is the coefficient of the piecewise constant mean force; with it sum_n n omega Im(U_n* P_n + ...)/2 is the power of
the path to rounding. Amplitudes and forces are both multiplied by s_n = (n pi/M)/sin(n pi/M), with which the result is
exact for a contact that never lifts off nor slips. The error falls as 1/M^2 (tests/contact/test_pillars_overtones.py).
"""

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from contact.averaged.cycle_mean import ContactMean
from contact.jit.compiled import compiled, native
from contact.law.elastic import coulomb_limit

MAX_PASSES = 400  # iterations of the amplitudes at one row
SETTLED = 1e-13  # change of the amplitudes over the incident amplitude at which the iteration ends
SHRINKING = 0.97  # ratio of successive changes above which the step is halved


class Classes(NamedTuple):
    """Contacts in classes, ordered by the rows as the wave meets them."""

    first: np.ndarray  # index of the first class of each row
    behind: np.ndarray  # index after the last class of each row
    weight: np.ndarray
    normal_stiffness: np.ndarray  # N/m
    tangential_stiffness: np.ndarray
    limit_slope: np.ndarray  # c


class Waves(NamedTuple):
    """The incident wave, and its phase at the rows."""

    turn: np.ndarray  # exp(-i k x) of the rows as the wave meets them, (m,)
    orbit: np.ndarray  # C, (1,)
    g: float  # Gamma/w, 1/(Pa m)
    incident: np.ndarray  # U_n where the wave comes in, m, (N,)


class Spectrum(NamedTuple):
    """Amplitudes in m at each row, means of its two sides with the phase at the row, and forces in N, (m, 2, N)."""

    along: np.ndarray  # of the wave that is followed, (m, N)
    against: np.ndarray  # of the wave from the other side, U_1 alone, (m, 1); input
    force: np.ndarray  # sum P_n and sum Q_n


class SurfaceSample(IntEnum):
    """Rows of `Samples.surface`, at the samples of a cycle."""

    U_Z = 0
    U_X = 1
    Z = 2
    Y = 3


class IntervalMean(IntEnum):
    """Rows of `Samples.mean`, means over each interval: z and x of a contact, forces of a row in N."""

    Z = 0
    X = 1
    NORMAL = 2
    TANGENTIAL = 3


class Samples(NamedTuple):
    """One cycle in M samples, with N harmonics."""

    table: np.ndarray  # exp(i n phi_j), (N, M + 1)
    scale: np.ndarray  # s_n, (N,)
    before: np.ndarray  # amplitudes that reach a row, with the phase at the row, m, (N,)
    surface: np.ndarray  # (len(SurfaceSample), M + 1), m
    mean: np.ndarray  # (len(IntervalMean), M)


def samples(number: int, count: int) -> Samples:
    """Return the arrays for so many harmonics in so many samples of a cycle."""
    n = np.arange(1, number + 1)
    table = np.exp(1j * np.outer(n, 2.0 * np.pi * np.arange(count + 1) / count))
    return Samples(
        table, n * np.pi / count / np.sin(n * np.pi / count), np.empty(number, dtype=complex),
        np.empty((4, count + 1)), np.empty((4, count)),
    )  # fmt: skip


@compiled
def _cycle(surface, mean, c, back, out):
    """Fill the means of z and x in each interval from z and y at the samples; friction and share in contact in `out`.

    The cycle is followed from a sample without contact. If there is none, it begins at the limit of the deformation on
    the side `back`, to which the slider's drift stretches the contact, and the second cycle is recorded.
    """
    z, y = surface[SurfaceSample.Z], surface[SurfaceSample.Y]
    count = z.size - 1
    start = -1
    for j in range(count):
        if z[j] <= 0.0:
            start = j
            break
    x, turns = 0.0, 1
    if start < 0:
        start, x, turns = 0, back * coulomb_limit(c, z[0]), 2
    friction = share = 0.0
    for _ in range(turns):
        friction = share = 0.0
        for i in range(count):
            j = (start + i) % count
            low, high = z[j], z[j + 1]
            if low <= 0.0 and high <= 0.0:
                mean[IntervalMean.Z, j] = mean[IntervalMean.X, j] = x = 0.0
                continue
            touching = 1.0  # fraction of the interval in contact, in which z goes from `low` to `high`
            if low < 0.0:
                touching, low, x = high / (high - low), 0.0, 0.0
            elif high < 0.0:
                touching, high = low / (low - high), 0.0
            dy = (y[j + 1] - y[j]) * touching
            limit, c_dz = coulomb_limit(c, low), coulomb_limit(c, high - low)
            # eq. (2): stick lasts for the fraction `stick` of the time in contact, then slip towards `slip`
            slip, stick = 0.0, 1.0
            for s in (1.0, -1.0):
                closing = s * dy - c_dz
                if closing > 0.0 and limit - s * x < stick * closing:
                    slip, stick = s, max((limit - s * x) / closing, 0.0)
            after = x + dy * stick
            mean_x = 0.5 * (x + after) * stick
            if slip != 0.0:  # eq. (3)
                mean_limit = limit + 0.5 * c_dz * (1.0 + stick)  # of c z while it slips
                mean_x += slip * mean_limit * (1.0 - stick)
                friction += mean_limit * (1.0 - stick) * (slip * dy - c_dz)
                after = slip * (limit + c_dz)
            x = after if z[j + 1] > 0.0 else 0.0
            share += touching
            mean[IntervalMean.Z, j], mean[IntervalMean.X, j] = 0.5 * (low + high) * touching, mean_x * touching
    out[ContactMean.FRICTION], out[ContactMean.SHARE] = friction / (2.0 * np.pi), share / count


@compiled
def _coefficient(values, table, scale, n):
    """Return the coefficient of the harmonic n + 1 of a piecewise constant function, times s_n."""
    total, last = 0.0j, values[values.size - 1]
    for j in range(values.size):
        total += (values[j] - last) * table[n, j].conjugate()
        last = values[j]
    return total * scale[n] / (1j * np.pi * (n + 1))


@compiled
def _row(classes, j, approach, w, back, spectrum, cycle, out):
    """Fill the forces of the row j at its amplitudes; `cycle`: `Samples` with the surface motion."""
    table, surface, mean, scale = cycle.table, cycle.surface, cycle.mean, cycle.scale
    number, count = scale.size, mean.shape[1]
    highest = -np.inf
    for i in range(count + 1):
        highest = max(highest, surface[SurfaceSample.U_Z, i])
    for i in range(count):
        mean[IntervalMean.NORMAL, i] = mean[IntervalMean.TANGENTIAL, i] = 0.0
    for k in range(classes.first[j], classes.behind[j]):
        out[:, k] = 0.0
        if approach[k] + highest <= 0.0:
            continue
        for i in range(count + 1):
            surface[SurfaceSample.Z, i] = approach[k] + surface[SurfaceSample.U_Z, i]
            surface[SurfaceSample.Y, i] = surface[SurfaceSample.U_X, i] - w * (2.0 * np.pi * i / count)
        _cycle(surface, mean, classes.limit_slope[k], back, out[:, k])
        normal, tangential = (
            classes.weight[k] * classes.normal_stiffness[k], classes.weight[k] * classes.tangential_stiffness[k]
        )  # fmt: skip
        for i in range(count):
            out[ContactMean.NORMAL, k] += mean[IntervalMean.Z, i] / count
            out[ContactMean.TANGENTIAL, k] += mean[IntervalMean.X, i] / count
            mean[IntervalMean.NORMAL, i] += normal * mean[IntervalMean.Z, i]
            mean[IntervalMean.TANGENTIAL, i] += tangential * mean[IntervalMean.X, i]
        first = _coefficient(mean[IntervalMean.Z], table, scale, 0)
        out[ContactMean.NORMAL_COS, k], out[ContactMean.NORMAL_SIN, k] = first.real, -first.imag
        first = _coefficient(mean[IntervalMean.X], table, scale, 0)
        out[ContactMean.TANGENTIAL_COS, k], out[ContactMean.TANGENTIAL_SIN, k] = first.real, -first.imag
    for n in range(number):
        for side in range(2):
            spectrum.force[j, side, n] = _coefficient(mean[IntervalMean.NORMAL + side], table, scale, n)


@compiled
def _surface_motion(waves, spectrum, cycle, j):
    """Fill u_z and u_x at the samples from the amplitudes of the row j."""
    table, surface, scale, orbit = cycle.table, cycle.surface, cycle.scale, waves.orbit[0]
    along, against = spectrum.along, spectrum.against
    for i in range(cycle.mean.shape[1] + 1):
        u_z = u_x = 0.0
        for n in range(scale.size):
            a, c = along[j, n], table[n, i]
            b = against[j, 0] if n == 0 else 0.0j
            p = scale[n] * (a + b)
            q = scale[n] * (orbit * a + orbit.conjugate() * b)
            u_z += p.real * c.real - p.imag * c.imag
            u_x += q.real * c.real - q.imag * c.imag
        surface[SurfaceSample.U_Z, i], surface[SurfaceSample.U_X, i] = u_z, u_x


@compiled
def _improved(classes, waves, spectrum, before, out, j, step):
    """Move the amplitudes of the row j by a part `step` of the way to the root of (4); return the largest change.

    The change of the normal force with a_n is estimated as that of springs, each for its share of the cycle in contact:
    a_n = before_n + h F_n + spring (a_n - old a_n).
    """
    along, force, orbit, half = spectrum.along, spectrum.force, waves.orbit[0], 0.5j * waves.g
    spring, change = 0.0j, 0.0
    for k in range(classes.first[j], classes.behind[j]):
        spring += half * classes.weight[k] * classes.normal_stiffness[k] * out[ContactMean.SHARE, k]
    for n in range(before.size):
        by_forces = before[n] + half * (force[j, 0, n] + orbit.conjugate() * force[j, 1, n])
        new = (by_forces - spring * along[j, n]) / (1.0 - spring)
        change = max(change, abs(new - along[j, n]))
        along[j, n] += step * (new - along[j, n])
    return change


@native(
    "t t f1 f f t t f2",
    {"classes.first": "m", "classes.behind": "m", "classes.weight": "n", "classes.normal_stiffness": "n",
     "classes.tangential_stiffness": "n", "classes.limit_slope": "n", "waves.turn": "m", "waves.orbit": "1",
     "waves.incident": "h", "approach": "n", "spectrum.along": "m h", "spectrum.against": "m 1",
     "spectrum.force": "m 2 h", "cycle.table": "h 1+s", "cycle.scale": "h", "cycle.before": "h",
     "cycle.surface": "4 1+s", "cycle.mean": "4 s", "out": "9 n"},
)  # fmt: skip
def overtone_march(classes, waves, approach, w, side, spectrum, cycle, out):
    """Follow the wave through all rows; fill its amplitudes, the forces and the rows of `cycle_mean.ContactMean`.

    g = 0 keeps `spectrum.along` as it is. `w`: velocity over omega, m; `side`: sign of the motion before w = 0. With
    h = i g/2, the amplitudes at a row (means of its two sides) are the root of

        a_n = before_n + h (P_n + C* Q_n)(a),       behind the row  2 a_n - before_n.                                (4)

    Its search begins with the forces that are there. Returns how many rows did not settle.
    """
    before, force, along = cycle.before, spectrum.force, spectrum.along
    number, orbit, half = cycle.scale.size, waves.orbit[0], 0.5j * waves.g
    back = 1.0 if (w < 0.0 or (w == 0.0 and side < 0.0)) else -1.0
    size = abs(waves.incident[0])
    failed = 0
    for j in range(waves.turn.size):
        turn = 1.0 + 0.0j
        for n in range(number):
            turn *= waves.turn[j]
            if waves.g > 0.0:
                came = waves.incident[n] if j == 0 else before[n]
                before[n] = came * turn
                along[j, n] = before[n] + half * (force[j, 0, n] + orbit.conjugate() * force[j, 1, n])
        step, last, change = 1.0, np.inf, np.inf
        for _ in range(MAX_PASSES):
            _surface_motion(waves, spectrum, cycle, j)
            _row(classes, j, approach, w, back, spectrum, cycle, out)
            if waves.g == 0.0:
                change = 0.0
                break
            change = _improved(classes, waves, spectrum, before, out, j, step)
            if change <= SETTLED * size:
                break
            if change > SHRINKING * last:
                step *= 0.5
            last = change
        if change > 1e-10 * size:
            failed += 1
        turn = 1.0 + 0.0j
        for n in range(number):
            turn *= waves.turn[j].conjugate()
            before[n] = (2.0 * along[j, n] - before[n]) * turn
    return failed
