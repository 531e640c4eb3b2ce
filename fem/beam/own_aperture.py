"""Response of a transducer with fingers of finite length to waves, voltages and its own charges.

The fingers end at y = +-W/2.  Along y the charge is computed by Galerkin's method.  It is a sum of sheets, each uniform
over |y| < L_b / 2: L_0 = W is the aperture, and the other sheets are shorter, because the charge concentrates and
oscillates near both ends (`sheet_lengths`).  The potential of every finger is integrated over the same sheets (it is
tested by them).  Let Z(x) be the potential of a line of charge in the section, where all is infinitely long in y.  The
potential of sheet b of one finger, integrated over sheet c of another at the distance x, differs from the integral of Z
over the length that both sheets cover, min(L_c, L_b) = s - d, by

    D_cb(x) = [T(s, x) - s Z(x)] - [T(d, x) - d Z(x)],    s = (L_c + L_b) / 2,    d = |L_c - L_b| / 2,          (1)

with T of `point_potential.py`, equation (1).

Across the fingers the charge is a combination of the distributions that the section has for one volt on each finger.
The change D is small, so that for D alone a simple distribution suffices: a finger of half width a with charge q has
the density q / (pi (a^2 - x^2)^(1/2)), and its dipole moment adds a density proportional to x / (a^2 - x^2)^(1/2).  If
the potential varies across a finger, the finger gets an additional dipole moment M, to first order that of a strip on a
half-space,

    M = -(a^2 / 2) (d phi / d x) / [x d Z / d x],    x << wavelength,                                           (2)

where x dZ/dx hardly depends on x, because Z is a logarithm there; it is taken at x = a.

Massless fingers scatter by their charges alone.  Let q_b be the charges of a transducer's fingers on sheet b (a vector
over the fingers), a_b the amplitudes of the arriving waves, U_b the potentials of the fingers that would cause q_b in
the section, O_cb = min(L_c, L_b) the overlaps of the sheets, and V the potentials of the fingers by the voltages.
Then, with the matrices Q_a and Q_U of the section,

    q_b = Q_a a_b + Q_U U_b,                                                                                    (3)
    sum_b O_cb U_b - sum_b D_cb q_b = L_c V     for all sheets c.                                               (4)

Sheet 0 is the whole aperture, so that L_c = O_c0 and O^-1 L V = V on sheet 0, zero on the others.  With this, (3) in
(4) gives the system that `aperture_response` solves for the U of all sheets,

    (1 - O^-1 D Q_U) U = [V on sheet 0] + O^-1 D Q_a a.                                                         (5)

The fingers of an apodised transducer reach over a part of the aperture, and dummy fingers of the other electrode go on
from their tips: finger f has the potential V_f on |y| < R_f / 2 and, in the mean over y and -y, that of both electrodes
beyond.  The right side of (4) is then its integral over sheet c, and a port's charge is the sum of all charges, each
times the integral of this potential, at a unit of the port, over its sheet.

A force sends waves of amplitudes a_b at the transducer's centre and a_b + A_bf at finger f.  By (3) the change A has
the same effect as additional potentials (Q_U^-1 Q_a A)_f, which are added to the right side of (5).
"""

from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any, NamedTuple
from weakref import WeakKeyDictionary

import numpy as np

from fem.beam.lateral import amplitude_ratio, highest_wavenumber, sheet_spectrum, wavenumber_along
from fem.beam.line_source import LineSource
from fem.beam.point_potential import Panels, StripPotential
from fem.condense.electrode_conditions import charged
from fem.condense.transducer import finger_ports
from fem.geometry import Transducer
from fem.waveguide.scattering_network import Scatterer, Sheet

# Points across a finger for the density 1 / sqrt(1 - s^2): Chebyshev nodes, exact up to the seventh power of s.
ACROSS = 4
DENSE = 1_000_000  # entries of weights that are kept as a full array
# Sums over mirror images, with k_max the largest wavenumber of a propagating mode: they end at k_y = MAX_LATERAL k_max,
# and include the modes with |k| < MAX_IMAGED k_max.  The others decay before they reach the mirrors.
MAX_LATERAL, MAX_IMAGED = 16.0, 4.0
# Distance in periods from a finger's end to the end of each shorter sheet, finest set first.  Errors against 64 and 96
# equal steps in PZT-8: maximum and rms of |u_z| relative to the section's, and admittance
# (tests/fem/beam/test_finger_ends.py).
#              20 fingers of 20 wavelengths    60 fingers of 15 wavelengths
# first set    0.4 %, 0.1 %, 1e-4              0.7 %, 0.3 %, 1e-4
# third set    1.0 %, 0.3 %, 8e-4              3.9 %, 1.6 %, 3e-4
# no steps     4.5 %, 1.4 %, 2e-3              10 %, 3.7 %, 6e-3
# Without the step of 0.004 periods the admittance of fingers of 1.5 wavelengths errs by 4e-3 instead of 2e-3, of 5
# wavelengths by 1.1e-3 instead of 4e-4 (boundary elements, tests/validation/test_finite_fingers.py).
STEPS = (
    (0.004, 0.02, 0.08, 0.25, 0.6, 1.15, 1.9, 3.0, 4.3, 5.9, 7.5),
    (0.06, 0.35, 1.0, 1.8, 3.0),
    (0.1, 1.0, 2.5),
    (0.1,),
    (),
)
DIGITS = 12  # of lengths in m that are compared
# D is interpolated from the nodes of panels where these are so many times fewer than its distances: in transducers of
# uneven fingers, whose pairs are all different.  It changes D by 1e-9 (test_own_aperture.py).  At 1 it costs the same;
# at 4 a DART of 10 periods takes all its distances, and its beam 1.4 times as long.
FEWER_NODES = 2
# The same about the tips of fingers that end within the aperture, on both sides of each and beside half a gap; and the
# smallest difference of two lengths, in periods.  Largest error of |u_z| over its maximum, on the middle line of 5
# pairs of 8 wavelengths whose fingers end in a cosine, at 0.5 and at 0.8 of the aperture: 0.11, 0.04 and 0.3 %, of the
# strips' sections 2.0, 2.7 and 3.4 % (boundary elements, tests/validation/test_finite_fingers.py).
TIPS = ((0.5, 1.3, 2.5), (1.0,), ())
SAME_END = 0.02
SHORTEST_SHEET = 0.2  # fraction of the aperture; shorter sheets are omitted
MAX_UNKNOWNS = 1500  # sheets of all fingers of a transducer; solving for them takes 0.5 s


# Results of `_by_fingers`, which the error estimate asks for again (`SurfaceBeam.coarser`).
_with_fingers: WeakKeyDictionary[Scatterer, tuple[Scatterer, np.ndarray]] = WeakKeyDictionary()


class Coupling(NamedTuple):
    """Change of the fingers' potentials by the charges and dipoles of all sheets, tested by all sheets; in SI units.

    ``charges``, ``mixed`` and ``moments`` couple charge to charge, charge to dipole and dipole to dipole, in V m, V and
    V/m per C/m or C m/m.  Shape (sheets, sheets, kinds); the last index is the kind of two fingers, `FingerPairs`.
    """

    charges: np.ndarray
    mixed: np.ndarray
    moments: np.ndarray
    polarisability: np.ndarray  # of each finger, C per V/m


class FingerPairs(NamedTuple):
    """Kinds of two fingers of a transducer, "+" or "-": their distance and widths, which pairs may share.

    Of equal and equidistant fingers there are twice as many kinds as fingers, less one, of a chirp one for each pair.
    """

    half_widths: np.ndarray  # (fingers,), m
    offset: np.ndarray  # (kinds,): from the middle of the second finger to that of the first, m
    first: np.ndarray  # (kinds,): a first finger of this kind
    second: np.ndarray  # (kinds,)
    kind: np.ndarray  # (fingers, fingers)


@lru_cache(maxsize=4)
def finger_pairs(transducer: Transducer) -> FingerPairs:
    """Return the kinds of two fingers; lengths that differ by less than a picometre are equal."""
    numbers = np.flatnonzero(charged(transducer.signs))
    edges = transducer.fingers[numbers]
    half_widths, middles = np.ptp(edges, axis=1) / 2, edges.mean(axis=1)
    offset = np.subtract.outer(middles, middles)
    if transducer.even:  # the kind follows from the numbers of the fingers: a sort of integers instead of rows
        apart = np.subtract.outer(numbers, numbers)
        _, some, kind = np.unique(apart, return_index=True, return_inverse=True)
    else:
        widths = np.broadcast_to(half_widths, offset.shape)
        alike = np.stack([offset, widths.T, widths], axis=-1).round(DIGITS).reshape(-1, 3)
        _, some, kind = np.unique(alike, axis=0, return_index=True, return_inverse=True)
    first, second = np.unravel_index(some, offset.shape)
    return FingerPairs(half_widths, offset[first, second], first, second, kind.reshape(offset.shape))


def sheet_lengths(transducer: Transducer, fineness: int = 0, most: int = MAX_UNKNOWNS) -> np.ndarray:
    """Lengths along y in m of the sheets of a finger's charge, the aperture first.

    ``fineness``: number of finer sets of STEPS that are skipped; ``most``: largest number of sheets on all fingers.
    """
    fingers, aperture = np.count_nonzero(charged(transducer.signs)), transducer.aperture
    sets = [  # for each set of STEPS, without sheets that would be too short
        np.array([aperture, *(shorter for shorter in ends if shorter > SHORTEST_SHEET * aperture)])
        for ends in ([aperture - 2 * step * transducer.period for step in steps] for steps in STEPS)
    ]
    small_enough = [lengths for lengths in sets if len(lengths) * fingers <= most] or sets[-1:]
    return small_enough[min(fineness, len(small_enough) - 1)]


def tips(transducer: Transducer, overlaps: tuple[float, ...], *, sharp: bool) -> np.ndarray:
    """How far each finger "+" or "-" reaches over the aperture, 0 to 1; unless ``sharp`` to its end if no gap fits."""
    reach = np.array(overlaps)[charged(transducer.signs)]
    whole = (1.0 - reach) * transducer.aperture / 2 < (0.0 if sharp else transducer.half_gap)
    return np.where(whole, 1.0, reach)


def with_tips(lengths: np.ndarray, reach: np.ndarray, transducer: Transducer, *, sharp: bool = False) -> np.ndarray:
    """Lengths of sheets, and of those that end beside the tips of fingers that reach so far over the aperture.

    The finest set of TIPS is taken for which all sheets of all fingers are at most MAX_UNKNOWNS; of too many some are
    omitted.  The potential changes between the two sheets nearest to a tip, over the width of a gap between fingers, as
    if such a gap were there; ``sharp``: at the tip.
    """
    most, period, gap = MAX_UNKNOWNS // max(len(reach), 1), transducer.period, transducer.half_gap
    kept = lengths.tolist()
    for beside in [()] if sharp else TIPS:
        offsets = np.array(
            [0.0] if sharp else [side * each for each in (gap, *np.multiply(period, beside)) for side in (-1.0, 1.0)]
        )
        kept = lengths.tolist()
        for end in (np.unique(reach[reach < 1.0] * lengths[0])[::-1, None] + 2 * offsets).ravel():
            if 0.0 < end < lengths[0] and min(abs(np.array(kept) - end)) > SAME_END * period:
                kept.append(float(end))
        if len(kept) <= most:
            break
    added = np.array(kept[len(lengths) :])
    some = np.unique(np.linspace(0, len(added) - 1, max(min(most - len(lengths), len(added)), 0)).astype(int))
    return np.sort(np.append(lengths, added[some]))[::-1]


def section_potential(source: LineSource, distances: np.ndarray) -> np.ndarray:
    """Potential Z(x) of a line of charge in the section, V per C/m, at distances in m, shape (n,)."""
    return np.exp(-1j * np.outer(distances, source.wavenumbers)) @ source.potential + source.slope * distances


def mirrored_mode_mean(k: complex, aperture: float, x: np.ndarray, width: float, highest: float) -> np.ndarray:
    """Mean of a mode over the aperture between two mirrors, minus its value in the plane section.

    The mean is a sum over k_y = 2 pi n / width up to ``highest``. ``k`` and ``highest`` are in rad/m, ``aperture``, the
    distances ``x`` (n,) along the propagation and the distance ``width`` of the mirrors in m. The mode has a unit
    amplitude, so that the result, shape (n,), has no unit.
    """
    lateral = np.arange(1, int(highest * width / (2 * np.pi))) * (2 * np.pi / width)
    along = wavenumber_along(k, lateral)
    shares = 2 / (aperture * width) * sheet_spectrum(aperture, lateral) ** 2 * amplitude_ratio(k, along)
    return shares @ np.exp(-1j * np.outer(along, x)) + (aperture / width - 1) * np.exp(-1j * k * x)


def image_potential(source: LineSource, aperture: float, x: np.ndarray, width: float) -> np.ndarray:
    """Mean potential over the aperture by its mirror images in two faces ``width`` apart, V per C/m, shape (n,)."""
    k = source.wavenumbers
    k_max = highest_wavenumber(k)
    imaged = source.some(abs(k) < MAX_IMAGED * k_max)
    with_images = sum(
        potential * mirrored_mode_mean(mode, aperture, x, width, MAX_LATERAL * k_max)
        for mode, potential in zip(imaged.wavenumbers, imaged.potential, strict=True)
    )
    alone = StripPotential(imaged, x, aperture)(np.array([aperture]))[0] / aperture  # mean without images
    return with_images - (alone - section_potential(imaged, x))


def polarisability(source: LineSource, finger_width: float) -> complex:
    """Dipole moment of a strip per length, C, over the potential gradient across it in V/m: equation (2)."""
    a, k = finger_width / 2, source.wavenumbers
    slope = np.sum(-1j * k * source.potential * np.exp(-1j * k * a)) + source.slope
    return complex(-a / (2 * slope))


@lru_cache(maxsize=2)
def _strip_potential(source: LineSource, distances: tuple[float, ...], aperture: float) -> StripPotential:
    """T of one transducer, kept for the error estimate, which takes fewer sheets (`SurfaceBeam.coarser`)."""
    return StripPotential(source, np.array(distances), aperture)


def finger_coupling(
    source: LineSource, transducer: Transducer, lengths: np.ndarray, mirror_width: float | None = None
) -> Coupling:
    """Change of a transducer's potentials by its own charges, for sheets of the lengths (m).

    D_cb(x) of equation (1) is evaluated at all distances between points on two fingers and averaged over them with the
    weights of a charge, 1 / ACROSS each, and of a unit dipole, x / sum x^2.
    """
    pairs = finger_pairs(transducer)
    if not pairs.kind.size:  # open strips alone
        return no_coupling(transducer, len(lengths))
    at, weights = _averages(source, pairs)
    change = _change_of_potential(source, lengths, at)
    if mirror_width is not None:
        images = image_potential(source, transducer.aperture, at, mirror_width)
        change += np.multiply.outer(np.outer(lengths, lengths) / transducer.aperture, images)
    flat = change.reshape(-1, len(at)).T
    charges, mixed, moments = ((each @ flat).T.reshape(*change.shape[:2], -1) for each in weights)
    own = [polarisability(source, 2 * half) for half in pairs.half_widths]
    return Coupling(charges, mixed, moments, np.array(own))


def no_coupling(transducer: Transducer, sheets: int) -> Coupling:
    """Return the coupling of fingers whose charges are those of the section."""
    pairs = finger_pairs(transducer)
    nothing = np.zeros((sheets, sheets, len(pairs.offset)), dtype=complex)
    return Coupling(nothing, nothing, nothing, np.zeros(len(pairs.half_widths)))


def _averages(source: LineSource, pairs: FingerPairs) -> tuple[np.ndarray, list[Any]]:
    """Distances in m at which D is evaluated, and weights (kinds, distances) of its three averages over two fingers."""
    across = np.cos(np.pi * (np.arange(ACROSS) + 0.5) / ACROSS)
    one, other = (np.multiply.outer(pairs.half_widths[each], across) for each in (pairs.first, pairs.second))
    apart = abs(pairs.offset[:, None, None] + one[:, :, None] - other[:, None, :])  # (kinds, ACROSS, ACROSS)
    # A point's distance to itself is replaced by the one for which the rule gives the exact mean of log |x| over two
    # densities 1 / sqrt(1 - s^2).
    own = np.flatnonzero(pairs.first == pairs.second)
    itself = pairs.half_widths[pairs.first[own]] / (ACROSS * 2 ** (2 - 1 / ACROSS))
    apart[own[:, None], np.arange(ACROSS), np.arange(ACROSS)] = itself[:, None]
    at, number = np.unique(apart.round(DIGITS), return_inverse=True)
    charge, dipole = np.full(ACROSS, 1 / ACROSS), across / np.sum(across**2)
    unit = np.ones((len(apart), 1))
    moment_of_one, moment_of_other = (dipole / pairs.half_widths[each][:, None] for each in (pairs.first, pairs.second))
    on_pairs = ((unit * charge, unit * charge), (unit * charge, moment_of_other), (moment_of_one, moment_of_other))
    starts = np.arange(len(apart) + 1) * ACROSS**2
    values = [(first[:, :, None] * second[:, None, :]).ravel() for first, second in on_pairs]
    weights: list[Any] = [np.zeros((len(apart), len(at))) for _ in values] if len(apart) * len(at) <= DENSE else []
    for each, of_pairs in zip(weights, values, strict=False):
        np.add.at(each, (np.repeat(np.arange(len(apart)), ACROSS**2), number.ravel()), of_pairs)
    if not weights:
        from scipy.sparse import csr_array  # its import takes longer than a run

        weights = [csr_array((each, number.ravel(), starts), (len(apart), len(at))) for each in values]
    panels = Panels.of(source, at[0], at[-1])
    if panels.nodes.size * FEWER_NODES > at.size:
        return at, weights
    interpolation = panels.interpolation(at)
    return panels.nodes, [each @ interpolation for each in weights]


def _change_of_potential(source: LineSource, lengths: np.ndarray, distances: np.ndarray) -> np.ndarray:
    """D_cb of equation (1) in V m per C/m at distances in m, shape (sheets, sheets, distances)."""
    line, strips = section_potential(source, distances), _strip_potential(source, tuple(distances), lengths[0])
    s, d = (np.add.outer(lengths, lengths) / 2, abs(np.subtract.outer(lengths, lengths)) / 2)  # of all pairs of sheets
    distinct, number = np.unique(np.concatenate([[0.0], s.ravel(), d.ravel()]).round(12), return_inverse=True)
    terms = np.zeros((len(distinct), len(distances)), dtype=complex)  # T(h) - h Z for each distinct h; 0 for h = 0
    terms[1:] = strips(distinct[1:]) - np.multiply.outer(distinct[1:], line)
    number_of_s, number_of_d = np.split(number[1:], 2)
    change = (terms[number_of_s] - terms[number_of_d]).reshape(*s.shape, -1)
    # The zero of the potential is arbitrary if the section floats.  For fingers without net charge it cancels, but only
    # after a loss of digits, so that it is subtracted here.
    if source.slope:
        change -= np.multiply.outer(np.outer(lengths, lengths), change[0, 0].mean(keepdims=True)) / lengths[0] ** 2
    return change


@dataclass(frozen=True, kw_only=True)
class ApertureResponse:
    """Response of a transducer to the waves that arrive on each of its sheets, to its ports and to forces.

    The columns of the arrays are, for every sheet, the modes from the left and those from the right; then the ports;
    then for each force the change of its waves from finger to finger.
    """

    scatterer: Scatterer
    lengths: np.ndarray
    # (2 n, 2 modes): incident fields on both lines, for a unit amplitude of each mode
    arriving: np.ndarray = field(repr=False)
    # (2 n, 2 modes + fingers): total fields on both lines, for unit modes and unit finger potentials
    lines: np.ndarray = field(repr=False)
    potentials: np.ndarray = field(repr=False)  # U, (sheets, fingers, columns)
    sent: np.ndarray = field(repr=False)  # (sheets 2 modes, columns): amplitudes to the right and to the left
    charges: np.ndarray = field(repr=False)  # q, (sheets, fingers, columns)
    # from charges to the first moments of the fingers' reactions that the section does not have, square over the
    # fingers of all sheets
    added_dipoles: np.ndarray = field(repr=False)
    # reactions at the ports of a transducer whose fingers do not all reach over the aperture, (ports, columns), or None
    at_ports: np.ndarray | None = field(default=None, repr=False)

    def sheets(self, weights: np.ndarray) -> tuple[Sheet, ...]:
        """Fields of the sheets for a combination of the columns, ``weights`` of shape (columns, ports)."""
        waves = weights[: len(self.sent)].reshape(len(self.lengths), -1, weights.shape[1])
        potentials, charges = self.potentials @ weights, self.charges @ weights
        dipoles = (self.added_dipoles @ charges.reshape(-1, weights.shape[1])).reshape(charges.shape)
        return tuple(
            Sheet(
                length=float(length),
                sides=np.concatenate([self.lines @ np.concatenate([waves[at], potentials[at]]), potentials[at]]),
                dipoles=dipoles[at],
            )
            for at, length in enumerate(self.lengths)
        )

    def incoming(self, weights: np.ndarray) -> np.ndarray:
        """Mean over the aperture of the incident waves on both lines, (2 n, ports)."""
        waves = weights[: len(self.sent)].reshape(len(self.lengths), -1, weights.shape[1])
        return self.arriving @ np.tensordot(self.lengths / self.lengths[0], waves, axes=1)


class _InSection(NamedTuple):
    """Response of a transducer in the section to unit modes from both sides and unit finger potentials.

    The columns are the modes from the left, those from the right, and the fingers.
    """

    lines: np.ndarray  # (2 n, 2 modes + fingers): fields on both lines
    charge_by_waves: np.ndarray  # Q_a, (fingers, 2 modes), of reactions
    charge_by_potentials: np.ndarray  # Q_U, (fingers, fingers)
    leaving: np.ndarray  # (2 modes, 2 modes + fingers): waves sent, without those that pass the bare surface
    effective: np.ndarray  # Q_U^-1 Q_a, (fingers, 2 modes): finger potentials that have the effect of a wave
    dipoles: np.ndarray  # (fingers, fingers): dipole moment of each finger per charge on each finger


def aperture_response(
    plain: Scatterer,
    transducer: Transducer,
    coupling_modes: np.ndarray,
    lengths: np.ndarray,
    change: Coupling,
    of_forces: np.ndarray,
    reach: np.ndarray | None = None,
) -> ApertureResponse:
    """Response of a transducer with fingers of finite length, from that of the section: equation (5).

    ``coupling_modes``: those that couple the transducers; ``of_forces``: changes A of the amplitudes from finger
    to finger (`reception`); ``reach``: R_f of each finger over the aperture, if not all reach over it.  The waves that
    it sends are S_a a + S_U U, with the blocks S of ``leaving``.
    """
    scatterer, moments = _by_fingers(plain, transducer.signs)
    modes, at, m, sheets = scatterer.modes, scatterer.at, len(coupling_modes), len(lengths)
    fingers, ports = scatterer.potentials.shape
    arriving = np.zeros((at.ports.start, 2 * m), dtype=complex)
    arriving[at.left, :m] = modes.right[:, coupling_modes]
    arriving[at.right, m:] = modes.left[:, coupling_modes]
    section = _in_section(scatterer, moments, coupling_modes, arriving)
    kind = finger_pairs(replace(transducer, name="", center=0.0)).kind
    change_by_charge, added = _change_by_charges(scatterer, kind, lengths, change, section.dipoles)

    size, waves = sheets * fingers, sheets * 2 * m
    before_forces = waves + ports
    columns = before_forces + of_forces.shape[-1]
    by_arriving = np.zeros((sheets, fingers, columns), dtype=complex)  # Q_a a
    load = np.zeros((sheets, fingers, columns), dtype=complex)  # right side of (5)
    for sheet in range(sheets):
        by_arriving[sheet, :, sheet * 2 * m : (sheet + 1) * 2 * m] = section.charge_by_waves
    if reach is None:
        load[0, :, waves:before_forces] = scatterer.potentials
    else:
        both = plain.potentials.mean(axis=0)
        held = np.minimum.outer(lengths, reach * lengths[0])[..., None]
        tested = held * scatterer.potentials + (lengths[:, None, None] - held) * both
        load[..., waves:before_forces] = np.tensordot(np.linalg.inv(np.minimum.outer(lengths, lengths)), tested, axes=1)
    load[..., before_forces:] = np.einsum("fp,sfpn->sfn", section.effective, of_forces)
    change_by_finger = change_by_charge.reshape(size * sheets, fingers)
    load.reshape(size, columns)[:, :waves] += (change_by_finger @ section.charge_by_waves).reshape(size, waves)
    by_potentials = (change_by_finger @ section.charge_by_potentials).reshape(size, size)
    finger_potentials = np.linalg.solve(np.eye(size) - by_potentials, load.reshape(size, columns)).reshape(load.shape)
    charges = by_arriving + section.charge_by_potentials @ finger_potentials  # equation (3)

    sent = section.leaving[:, 2 * m :] @ finger_potentials
    for sheet in range(sheets):
        sent[sheet, :, sheet * 2 * m : (sheet + 1) * 2 * m] += section.leaving[:, : 2 * m]
    return ApertureResponse(
        scatterer=scatterer,
        lengths=lengths,
        arriving=arriving,
        lines=section.lines,
        potentials=finger_potentials,
        sent=sent.reshape(waves, columns),
        charges=charges,
        added_dipoles=added,
        at_ports=None if reach is None else np.einsum("sfp,sfc->pc", tested, charges) / lengths[0],
    )


def _by_fingers(scatterer: Scatterer, signs: str) -> tuple[Scatterer, np.ndarray]:
    """Scatterer with one potential per finger, and the matrix from its sides to the dipoles of the fingers."""
    if scatterer not in _with_fingers:
        electrodes = ["+-".index(sign) for sign in signs if sign in "+-"]
        superelement, dipoles = finger_ports(scatterer.columns, signs)
        own = Scatterer(piece=superelement, modes=scatterer.modes, potentials=scatterer.potentials[electrodes])
        _with_fingers[scatterer] = own, dipoles
    return _with_fingers[scatterer]


def _in_section(
    scatterer: Scatterer, moments: np.ndarray, coupling_modes: np.ndarray, arriving: np.ndarray
) -> _InSection:
    """Response in the section; ``arriving``: incident fields on both lines, (2 n, 2 modes), ``moments``: by sides."""
    modes, width, at, m = scatterer.modes, scatterer.piece.width, scatterer.at, len(coupling_modes)
    fingers = len(scatterer.potentials)
    incident = np.concatenate([arriving, np.zeros((len(arriving), fingers))], axis=1)
    potentials = np.eye(fingers, 2 * m + fingers, 2 * m)
    lines = scatterer.sides(incident, potentials)
    sides = np.concatenate([lines, potentials])
    reactions = scatterer.piece.matrix[at.ports] @ sides
    by_waves, by_potentials = reactions[:, : 2 * m], reactions[:, 2 * m :]
    # In a floating section the same potential on all fingers causes no charge; a constant removes this null vector.
    gauge = abs(np.diag(by_potentials)).sum() / max(fingers, 1) ** 2 if modes.section.floating_potential else 0.0
    dipoles = np.linalg.solve((by_potentials + gauge).T, (moments @ sides[:, 2 * m :]).T).T
    effective = np.linalg.solve(by_potentials + gauge, by_waves)
    passed = np.append(
        np.exp(-1j * modes.wavenumbers[coupling_modes] * width), np.exp(1j * modes.backwards[coupling_modes] * width)
    )
    outgoing = lines - incident
    leaving = np.concatenate(
        [
            modes.right_amplitudes(outgoing[at.right])[coupling_modes],
            modes.left_amplitudes(outgoing[at.left])[coupling_modes],
        ]
    )
    leaving[:, : 2 * m] -= np.diag(passed)
    return _InSection(lines, by_waves, by_potentials, leaving, effective, dipoles)


def _change_by_charges(
    scatterer: Scatterer, kind: np.ndarray, lengths: np.ndarray, change: Coupling, dipoles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """O^-1 D of equation (5), and the dipoles that the change of the potentials adds, per charge (reaction).

    Both are matrices over the fingers of all sheets, (sheets fingers, sheets fingers).  ``kind``: of each two fingers
    (`FingerPairs`).  ``change`` has the blocks of `Coupling`: C of charges to potentials, X of dipoles to potentials,
    Y of dipoles to gradients.  A charge has the dipoles P of the section, ``dipoles``, and causes the gradient G of the
    potential on each finger; with the polarisability alpha of each strip this adds the dipoles A, which act back on the
    potentials by G^T (reciprocity):

        G = X^T + Y P,    A = alpha O^-1 G,    D = C + X P + P^T G + G^T A.
    """
    section = scatterer.modes.section
    medium, unit = section.solid, section.length_unit
    scale = medium.stress_unit / medium.potential_unit**2  # of charges in SI to reactions
    charges, mixed, moments = (
        scale * unit**power * each[..., kind]
        for power, each in enumerate((change.charges, change.mixed, change.moments))
    )
    polarisability = -change.polarisability / (scale * unit**2)
    inverse = np.linalg.inv(np.minimum.outer(lengths, lengths))  # O^-1
    sheets, fingers = len(lengths), len(kind)
    size = sheets * fingers

    def stacked(each: np.ndarray) -> np.ndarray:
        """One matrix over the fingers of all sheets, from (sheets, sheets, fingers, fingers)."""
        return each.transpose(0, 2, 1, 3).reshape(size, size)

    def projected(each: np.ndarray) -> np.ndarray:
        """O^-1 times a matrix over the fingers of all sheets; O mixes the sheets of each finger alone."""
        return np.tensordot(inverse, each.reshape(sheets, fingers, size), axes=1).reshape(size, size)

    by_sheets = np.swapaxes(mixed, 2, 3) + moments @ dipoles  # G
    direct = stacked(charges + mixed @ dipoles + dipoles.T @ by_sheets)
    gradient = stacked(by_sheets)
    added = np.tile(polarisability, sheets)[:, None] * projected(gradient)
    return projected(direct + gradient.T @ added), added
