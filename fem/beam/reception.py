"""Coupling of transducers of finite aperture in one row: each receives the beams of the others and sends its own.

In the section a transducer sends waves of amplitude c_p, and another one receives c_p exp(-i k_p L), with L the
distance of their centres.  For fingers of finite length, charges that are uniform over lengths W_i and W_j along y
(sheets, own_aperture.py) receive B_ij,p times this amplitude,

    B_ij,p = int dk_y / 2 pi  W_i sinc(k_y W_i / 2) sinc(k_y W_j / 2) (k_p / kappa_p) exp(-i (kappa_p - k_p) L)    (1)

if their centres have the same y; if these differ by d, the integrand has the factor cos(k_y d).

Massless fingers scatter by their charges alone.  The wave that a transducer sends when a wave arrives is therefore the
response of the section minus the transmitted wave, and the waves of all other transducers pass it as if its surface
were bare.  W_j B_ij,p does not change if i and j are exchanged, so that the admittance matrix is symmetric.

For one transducer, let q_b be the charges of its fingers on sheet b (a vector over the fingers), a_b the amplitudes of
the arriving waves, U_b the potentials of the fingers that would cause q_b in the section, O_cb = min(L_c, L_b) the
overlaps of the sheets of lengths L, D_cb the change of the potentials in own_aperture.py and V the potentials of the
fingers by the voltages.  Then, with the matrices Q_a and Q_U of the section,

    q_b = Q_a a_b + Q_U U_b,                                                                                    (2)
    sum_b O_cb U_b - sum_b D_cb q_b = L_c V     for all sheets c.                                               (3)

Sheet 0 is the whole aperture, so that L_c = O_c0 and O^-1 L V = V on sheet 0, zero on the others.  With this, (2)
in (3) gives the system that `_response` solves for the U of all sheets,

    (1 - O^-1 D Q_U) U = [V on sheet 0] + O^-1 D Q_a a.                                                         (4)

An arriving beam phi(y) is projected on the sheets f_c: sum_b O_cb a_b = int f_c phi dy.

The waves between transducers are those at the receiver's centre.  Those of a force are a_b there and a_b + A_bf on
finger f.  By (2) the change A has the same effect as additional potentials (Q_U^-1 Q_a A)_f, which are added to the
right side of (4).

Limits: the solid must be isotropic about z and the ends must absorb.  Otherwise transducers receive waves, and respond
to their own charges, as in the section.  Open strips always respond as in the section.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import combinations
from threading import Lock
from typing import NamedTuple

import numpy as np

from fem.beam.lateral import evanescent, highest_wavenumber, lateral_rule, sheet_spectrum, turned, wavenumber_along
from fem.beam.line_source import line_source
from fem.beam.own_aperture import MAX_UNKNOWNS, Coupling, finger_coupling, sheet_lengths
from fem.condense.transducer import finger_ports
from fem.discretize.spectral import chebyshev_nodes, lagrange_weights
from fem.exceptions import InputError
from fem.geometry import Stator, Transducer
from fem.materials import isotropic_about_normal
from fem.waveguide.modes import guided_modes
from fem.waveguide.network import Network, PortSolution, Scatterer, Sheet
from fem.waveguide.port_fields import PortFields, StatorRow
from fem.waveguide.row_solver import Element, solve_row

SHORTEST = 0.5  # smallest aperture over wavelength: shorter fingers are not line sources
# Largest size of the system of waves between transducers, two waves per sheet and mode.  To keep it, modes that decay
# by exp(-NEEDED) or more on the way are left out first, then shorter sheets.
MAX_WAVES, NEEDED = 3000, 11.5
# Nodes for interpolation over a band: smallest number, and number per rad of phase; the admittance is accurate to 1e-5.
LEAST_NODES, NODES_PER_SWING = 5, 1.2


def refuse_short_apertures(transducers: tuple[Transducer, ...], wavelength: float) -> None:
    """Refuse apertures below half a wavelength (m) of the surface wave."""
    for each in transducers:
        if each.aperture < SHORTEST * abs(wavelength):
            raise InputError(
                "transducer.aperture",
                f"must be at least half a wavelength, {SHORTEST * abs(wavelength):.4g} m, unless "
                "stator.diffraction is false",
                each.aperture,
                "m",
                owner=each.name,
            )


def aperture_coupling(
    wavenumbers: np.ndarray,
    sender: float | np.ndarray,
    receiver: float | np.ndarray,
    distance: float,
    mirror_width: float | None = None,
    offset: float = 0.0,
    *,
    tangential: bool = False,
) -> np.ndarray:
    """Mean of each mode's beam over the receiving aperture, relative to the wave in the section (B of the module).

    Parameters
    ----------
    wavenumbers : ndarray, shape (modes,)
        k_p of waves to the right, rad/m.
    sender, receiver : float or ndarray
        Apertures in m, one or several.
    distance : float
        m.
    mirror_width : float, optional
        Distance of two reflecting side faces, m; both apertures must then be centred between them.
    offset : float
        Distance along y from the centre of one aperture to that of the other, m.
    tangential : bool
        Whether the sender is a force along x, of which the part kappa_p / k_p acts along the wave vector.

    Returns
    -------
    ndarray, shape (*receivers, *senders, modes)
    """
    highest = highest_wavenumber(wavenumbers)
    reach = (np.max(sender) + np.max(receiver)) / 2 + abs(offset)
    rule = lateral_rule(highest, reach, evanescent(highest, distance), mirror_width)
    out = np.empty((*np.shape(receiver), *np.shape(sender), len(wavenumbers)), dtype=complex)
    for some, one in rule.contours(wavenumbers):
        k = wavenumbers[some, None]
        along = wavenumber_along(k, one.nodes)
        waves = turned(k, along, tangential=tangential) * np.exp(-1j * (along - k) * distance)
        waves = waves * (one.weights * np.cos(one.nodes * offset))
        sent, received = (sheet_spectrum(each, one.nodes) for each in (sender, receiver))
        received = received / np.asarray(receiver)[..., None]
        both = np.expand_dims(received, tuple(range(np.ndim(receiver), np.ndim(receiver) + np.ndim(sender)))) * sent
        out[..., some] = both @ waves.T
    return out


def with_apertures(fields: PortFields, mirror_width: float | None = None, fineness: int = 0) -> PortFields:
    """Solve the ports of a stator again for fingers of finite length, along which the charges vary.

    Parameters
    ----------
    fields : PortFields
        Solution of the section.
    mirror_width : float, optional
        Distance of two reflecting side faces, m.
    fineness : int
        Number of finer sets of steps along the fingers that are skipped (`sheet_lengths`).

    Returns
    -------
    PortFields
        Charges and admittances of transducers of finite aperture.  ``sides`` are the unknowns on their lines for the
        waves averaged over the aperture, with the potential of every finger that would cause its charge in the section.
        ``fields`` itself is returned if the limits of this module are not met.
    """
    solve = aperture_solver(fields.stator, mirror_width, fineness)
    if solve is None or None in fields.owners or not fields.transducers:
        return fields
    return solve(fields)


def aperture_solver(
    stator: Stator, mirror_width: float | None = None, fineness: int = 0, limits: tuple[float, float] | None = None
) -> Callable[[StatorRow], PortFields] | None:
    """Solver of a stator's row for finite apertures; None if the limits of this module are not met.

    ``limits``: lowest and highest frequency (Hz), if the solver will be called at many frequencies of a band.
    """
    if stator.pieces or stator.ends != "absorbing" or not isotropic_about_normal(stator.solid):
        return None
    return partial(_solved, OwnApertures(mirror_width, limits), fineness=fineness)


class OwnApertures:
    """Coupling of a transducer's fingers by `finger_coupling`, interpolated in frequency if there is a band.

    The modes of the full section are used, because those of a band's reduced basis do not resolve the near field.
    """

    def __init__(self, mirror_width: float | None, limits: tuple[float, float] | None):
        self.mirror_width, self.limits = mirror_width, limits
        self._at_nodes: dict[tuple, tuple] = {}
        self._lock = Lock()

    def coupling(self, network: Network, transducer: Transducer, lengths: np.ndarray) -> Coupling:
        """Coupling at the frequency of the network."""
        section, frequency = network.modes.section, network.modes.frequency
        section = getattr(section, "full", section)
        if self.limits is None:
            modes = network.modes if section is network.modes.section else guided_modes(section, frequency)
            return finger_coupling(line_source(modes), transducer, lengths, self.mirror_width)
        key = id(section), transducer, tuple(lengths)
        with self._lock:
            if key not in self._at_nodes:
                wavenumber = abs(network.modes.wavenumbers[network.modes.rayleigh[0]]) / section.length_unit
                self._at_nodes[key] = (section, *self._solved(section, transducer, lengths, wavenumber / frequency))
        _, nodes, values = self._at_nodes[key]
        weights = lagrange_weights(nodes, frequency)
        return Coupling(*(np.tensordot(weights, each, axes=1) for each in values))

    def _solved(self, section, transducer: Transducer, lengths: np.ndarray, slowness: float) -> tuple[np.ndarray, list]:
        """Nodes in Hz, and the arrays of `Coupling` at the nodes; ``slowness``: wavenumber over frequency, rad s/m."""
        low, high = self.limits
        farthest = np.hypot(np.diff(transducer.extent).item(), transducer.aperture)
        swing = slowness * farthest * (high - low) / 2  # change of a wave's phase over half the band, rad
        nodes = chebyshev_nodes(low, high, int(np.ceil(LEAST_NODES + NODES_PER_SWING * swing)))
        at = [
            finger_coupling(line_source(guided_modes(section, float(each))), transducer, lengths, self.mirror_width)
            for each in nodes
        ]
        return nodes, [np.stack(each) for each in zip(*at, strict=True)]


@dataclass(frozen=True, kw_only=True)
class _Response:
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
    # first moments of the fingers' reactions that the section does not have, (sheets, fingers, columns)
    dipoles: np.ndarray = field(repr=False)

    def sheets(self, weights: np.ndarray) -> tuple[Sheet, ...]:
        """Fields of the sheets for a combination of the columns, ``weights`` of shape (columns, ports)."""
        waves = weights[: len(self.sent)].reshape(len(self.lengths), -1, weights.shape[1])
        potentials = self.potentials @ weights
        return tuple(
            Sheet(
                length=float(length),
                sides=np.concatenate([self.lines @ np.concatenate([waves[at], potentials[at]]), potentials[at]]),
                dipoles=self.dipoles[at] @ weights,
            )
            for at, length in enumerate(self.lengths)
        )

    def incoming(self, weights: np.ndarray) -> np.ndarray:
        """Mean over the aperture of the incident waves on both lines, (2 n, ports)."""
        waves = weights[: len(self.sent)].reshape(len(self.lengths), -1, weights.shape[1])
        return self.arriving @ np.tensordot(self.lengths / self.lengths[0], waves, axes=1)


def _solved(own_apertures: OwnApertures, row: StatorRow, *, fineness: int) -> PortFields:
    """Fields of the row's ports, with one potential per finger."""
    network, transducers = row.network, row.transducers
    section = network.modes.section
    surface = network.modes.wavenumbers[network.modes.rayleigh].real.mean() / section.length_unit
    refuse_short_apertures(transducers, 2 * np.pi / surface)
    lengths, kept = _sheets_and_modes(network, transducers, fineness)
    travel = _travel(network, transducers, kept, lengths, own_apertures.mirror_width)
    outside, changes = _from_forces(network, transducers, kept, lengths, own_apertures.mirror_width)
    responses = _responses(own_apertures, row, kept, lengths, changes)
    network = replace(network, scatterers=tuple(each.scatterer for each in responses))
    return replace(row, network=network).solved(_port_solution(network, responses, travel, outside, kept))


def _sheets_and_modes(
    network: Network, transducers: tuple[Transducer, ...], fineness: int
) -> tuple[list[np.ndarray], np.ndarray]:
    """Lengths of the sheets of each transducer, and numbers of the modes that couple transducers, within MAX_WAVES."""
    # Between transducers the waves that couple them are enough: what a force adds nearby decays before the next one.
    between = np.diff(network.segments[1:-1], axis=1).ravel()
    gaps = between if len(between) else [abs(gap) for _, _, gap in _force_gaps(network)]
    kept = network.survivors(float(min(gaps))) if len(gaps) else np.empty(0, int)
    decay = -network.modes.wavenumbers[kept].imag * float(min(gaps, default=0.0))
    needed = np.count_nonzero(decay < NEEDED)
    lengths = []
    for each in transducers:
        fingers = max(sum(sign in "+-" for sign in each.signs), 1)
        most_sheets = MAX_WAVES // max(2 * needed * len(transducers), 1)  # forces alone do not change the sheets
        limit = {} if len(transducers) == 1 else {"most": min(MAX_UNKNOWNS, most_sheets * fingers)}
        lengths.append(sheet_lengths(each, fineness, **limit))
    most_modes = max(MAX_WAVES // (2 * sum(map(len, lengths))), needed if len(transducers) > 1 else 1)
    return lengths, np.sort(kept[np.argsort(decay, kind="stable")[:most_modes]])


def _responses(
    own_apertures: OwnApertures, row: StatorRow, kept: np.ndarray, lengths: list[np.ndarray], changes: list[np.ndarray]
) -> list[_Response]:
    """Response of each transducer; equal transducers share a scatterer, and without forces a response."""
    network = row.network
    responses, couplings, by_kind = [], {}, {}
    for index, (plain, transducer, own_lengths) in enumerate(
        zip(network.scatterers, row.transducers, lengths, strict=True)
    ):
        kind = id(plain), transducer.aperture
        if kind not in couplings:
            couplings[kind] = own_apertures.coupling(network, replace(transducer, name="", center=0.0), own_lengths)
        key = (*kind, index if network.forces else 0)
        if key not in by_kind:
            by_kind[key] = _response(plain, transducer.signs, kept, own_lengths, couplings[kind], changes[index])
        responses.append(by_kind[key])
    return responses


def _port_solution(
    network: Network, responses: list[_Response], travel: np.ndarray, outside: np.ndarray | None, kept: np.ndarray
) -> PortSolution:
    """Solve the row for the waves between the transducers, and return the fields for a unit at each port."""
    ports, first = len(network.ports), np.cumsum([0, *(len(each.sent) for each in responses)])
    # of each transducer: which ports and forces its last columns belong to
    own_ports = [np.eye(ports)[[*numbers, *network.forces]] for numbers in network.numbers]
    elements = [
        Element(
            scattering=each.sent[:, : stop - start],
            excitation=each.sent[:, stop - start :] @ selection,
            leaves=np.arange(start, stop),
            arrives=np.arange(start, stop),
        )
        for each, selection, start, stop in zip(responses, own_ports, first, first[1:], strict=False)
    ]
    solved = solve_row(elements, travel, outside)
    sides, incoming, charges, sheets = [], [], [], []
    for each, selection, element in zip(responses, own_ports, elements, strict=True):
        weights = np.concatenate([solved.arriving[element.arrives], selection])
        sheets.append(each.sheets(weights))
        shares = each.lengths / each.lengths[0]
        sides.append(sum(share * sheet.sides for share, sheet in zip(shares, sheets[-1], strict=True)))
        incoming.append(each.incoming(weights))
        charges.append(each.scatterer.reactions(sides[-1]))
    return PortSolution(
        sides=tuple(sides),
        incoming=tuple(incoming),
        segments=network.segment_waves(sides, incoming),
        reactions=np.concatenate(charges),
        coupling=solved.coupling,
        waves=np.concatenate([np.tile(kept, 2 * len(each.lengths)) for each in responses]),
        sheets=tuple(sheets),
        own_apertures=True,
    )


def _by_fingers(scatterer: Scatterer, signs: str) -> tuple[Scatterer, np.ndarray]:
    """Scatterer with one potential per finger, and the matrix from its sides to the dipoles of the fingers."""
    electrodes = ["+-".index(sign) for sign in signs if sign in "+-"]
    superelement, dipoles = finger_ports(scatterer.piece, signs)
    own = scatterer.potentials[electrodes]
    return Scatterer(piece=superelement, modes=scatterer.modes, potentials=own), dipoles


def _travel(
    network: Network,
    transducers: tuple[Transducer, ...],
    kept: np.ndarray,
    lengths: list[np.ndarray],
    mirror_width: float | None,
) -> np.ndarray:
    """Matrix from the amplitudes that are sent to those that arrive.

    Its rows and columns are ordered by transducer and sheet, then waves to the right, waves to the left.  With B of
    `aperture_coupling`, the amplitudes c_b on the sheets b of one transducer arrive on the sheets of another, at the
    distance l of their facing lines, as a = (O / L)^-1 B c exp(-i k l), (O / L)_cb = O_cb / L_c, because B is a mean
    over the receiving sheet.
    """
    modes, unit, m = network.modes, network.modes.section.length_unit, len(kept)
    edges = [  # left and right line of each transducer
        (place, place + each.piece.width) for place, each in zip(network.places, network.scatterers, strict=True)
    ]
    first = np.cumsum([0, *(2 * m * len(each) for each in lengths)])
    out = np.zeros((first[-1], first[-1]), dtype=complex)
    overlaps = [np.minimum.outer(each, each) / each[:, None] for each in lengths]  # O / L
    for one, other in combinations(range(len(edges)), 2):
        gap, pair = edges[other][0] - edges[one][1], (transducers[one], transducers[other])
        to_other = aperture_coupling(
            modes.wavenumbers[kept] / unit,
            lengths[one],
            lengths[other],
            (sum(edges[other]) - sum(edges[one])) / 2 * unit,
            mirror_width,
            pair[1].center_y - pair[0].center_y,
        )
        to_one = np.swapaxes(to_other * (lengths[other][:, None] / lengths[one])[..., None], 0, 1)
        for sender, receiver, mean_beams, phase in (
            (one, other, to_other, modes.wavenumbers[kept] * gap),
            (other, one, to_one, -modes.backwards[kept] * gap),
        ):
            amplitudes = np.tensordot(np.linalg.inv(overlaps[receiver]), mean_beams, axes=1)
            block = out[first[receiver] : first[receiver + 1], first[sender] : first[sender + 1]]
            block = block.reshape(len(lengths[receiver]), 2, m, len(lengths[sender]), 2, m)
            direction, each = int(sender > receiver), np.arange(m)  # direction: 0 to the right, 1 to the left
            block[:, direction, each, :, direction, each] = np.moveaxis(amplitudes * np.exp(-1j * phase), 2, 0)
    return out


def _force_gaps(network: Network) -> list[tuple[int, int, float]]:
    """Return number of the port, number of the transducer and gap between them, for each force and transducer.

    The gap is the distance to the nearest line of the transducer, length units; positive if it lies on the right.
    """
    edges = [(place, place + each.piece.width) for place, each in zip(network.places, network.scatterers, strict=True)]
    places = [(number, network.ports[number].place) for number in network.forces]
    return [
        (number, index, left - place if left > place else right - place)
        for number, place in places
        for index, (left, right) in enumerate(edges)
    ]


def _from_forces(
    network: Network,
    transducers: tuple[Transducer, ...],
    kept: np.ndarray,
    lengths: list[np.ndarray],
    mirror_width: float | None,
) -> tuple[np.ndarray | None, list[np.ndarray]]:
    """Waves that arrive directly from the strips of force, and their change from finger to finger.

    The amplitudes (waves, ports) are those at the centre of a transducer, None without a force; their rows are those of
    `_travel`.  A force of a width w sends its waves as a sheet of charge of this length does.

    The changes A of the module docstring are (sheets, fingers, 2 modes, forces) for each transducer: on each finger the
    mean over a sheet is B of equation (1) at the distance of the finger instead of that of the centre.
    """
    modes, unit, m = network.modes, network.modes.section.length_unit, len(kept)
    first = np.cumsum([0, *(2 * m * len(each) for each in lengths)])
    out = np.zeros((first[-1], len(network.ports)), dtype=complex)
    numbers = list(network.forces)
    finger_x = [  # middles of the fingers "+" and "-" of each transducer, length units
        (each.center + (np.flatnonzero([sign in "+-" for sign in each.signs]) - (len(each.signs) - 1) / 2) * each.pitch)
        / unit
        for each in transducers
    ]
    changes = [
        np.zeros((len(own), len(fingers), 2, m, len(numbers)), dtype=complex)
        for own, fingers in zip(lengths, finger_x, strict=True)
    ]
    for number, index, gap in _force_gaps(network):
        port, force, own_lengths = network.ports[number], network.forces[number], lengths[index]
        k, sent = (modes.wavenumbers, force.right) if gap > 0 else (-modes.backwards, force.left)
        direction = int(gap < 0)  # 0 to the right, 1 to the left
        to_centre = abs(gap) + network.scatterers[index].piece.width / 2
        mean_beams = [
            aperture_coupling(
                k[kept] / unit,
                port.width * unit,
                own_lengths,
                distance * unit,
                mirror_width,
                transducers[index].center_y - port.center * unit,
                tangential=port.component == "x",
            )
            for distance in (to_centre, *abs(finger_x[index] - port.place))
        ]
        overlaps = np.minimum.outer(own_lengths, own_lengths) / own_lengths[:, None]  # O / L, as in `_travel`
        amplitudes = np.linalg.solve(overlaps, np.array(mean_beams))  # at the centre, then on each finger
        amplitudes *= (sent * np.exp(-1j * k * abs(gap)))[kept]
        block = out[first[index] : first[index + 1], number].reshape(len(own_lengths), 2, m)
        block[:, direction] = amplitudes[0]
        on_fingers = np.swapaxes(amplitudes[1:] - amplitudes[0], 0, 1)
        changes[index][:, :, direction, :, numbers.index(number)] = on_fingers
    return out if numbers else None, [each.reshape(*each.shape[:2], 2 * m, len(numbers)) for each in changes]


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


def _in_section(scatterer: Scatterer, moments: np.ndarray, kept: np.ndarray, arriving: np.ndarray) -> _InSection:
    """Response in the section; ``arriving``: incident fields on both lines, (2 n, 2 modes), ``moments``: by sides."""
    modes, width, at, m = scatterer.modes, scatterer.piece.width, scatterer.at, len(kept)
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
    passed = np.append(np.exp(-1j * modes.wavenumbers[kept] * width), np.exp(1j * modes.backwards[kept] * width))
    outgoing = lines - incident
    leaving = np.concatenate(
        [modes.right_amplitudes(outgoing[at.right])[kept], modes.left_amplitudes(outgoing[at.left])[kept]]
    )
    leaving[:, : 2 * m] -= np.diag(passed)
    return _InSection(lines, by_waves, by_potentials, leaving, effective, dipoles)


def _change_by_charges(
    scatterer: Scatterer, signs: str, lengths: np.ndarray, change: Coupling, dipoles: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """O^-1 D of equation (4), and the dipoles that the change of the potentials adds, per charge (reaction).

    Both are matrices over the fingers of all sheets, (sheets fingers, sheets fingers).  ``change`` has the blocks of
    `Coupling`: C of charges to potentials, X of dipoles to potentials, Y of dipoles to gradients.  A charge has the
    dipoles P of the section, ``dipoles``, and causes the gradient G of the potential on each finger; with the
    polarisability alpha of a strip this adds the dipoles A, which act back on the potentials by G^T (reciprocity):

        G = X^T + Y P,    A = alpha O^-1 G,    D = C + X P + P^T G + G^T A.
    """
    section = scatterer.modes.section
    medium, unit = section.solid, section.length_unit
    scale = medium.stress_unit / medium.potential_unit**2  # of charges in SI to reactions
    charged = np.flatnonzero([sign in "+-" for sign in signs])
    offsets = np.subtract.outer(charged, charged) + len(signs) - 1  # place of each pair of fingers in ``change``
    charges, mixed, moments = (
        scale * unit**power * each[..., offsets]
        for power, each in enumerate((change.charges, change.mixed, change.moments))
    )
    polarisability = -change.polarisability / (scale * unit**2)
    inverse = np.linalg.inv(np.minimum.outer(lengths, lengths))  # O^-1
    sheets, fingers = len(lengths), len(charged)
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
    added = polarisability * projected(gradient)
    return projected(direct + gradient.T @ added), added


def _response(
    plain: Scatterer, signs: str, kept: np.ndarray, lengths: np.ndarray, change: Coupling, of_forces: np.ndarray
) -> _Response:
    """Response of a transducer with fingers of finite length, from that of the section: equation (4).

    ``kept``: modes by which the transducers are coupled; ``of_forces``: changes A of the amplitudes from finger to
    finger (`_from_forces`).  The waves that it sends are S_a a + S_U U, with the blocks S of ``leaving``.
    """
    scatterer, moments = _by_fingers(plain, signs)
    modes, at, m, sheets = scatterer.modes, scatterer.at, len(kept), len(lengths)
    fingers, ports = scatterer.potentials.shape
    arriving = np.zeros((at.ports.start, 2 * m), dtype=complex)
    arriving[at.left, :m] = modes.right[:, kept]
    arriving[at.right, m:] = modes.left[:, kept]
    section = _in_section(scatterer, moments, kept, arriving)
    change_by_charge, added = _change_by_charges(scatterer, signs, lengths, change, section.dipoles)

    size, waves = sheets * fingers, sheets * 2 * m
    before_forces = waves + ports
    columns = before_forces + of_forces.shape[-1]
    by_arriving = np.zeros((sheets, fingers, columns), dtype=complex)  # Q_a a
    load = np.zeros((sheets, fingers, columns), dtype=complex)  # right side of (4)
    for sheet in range(sheets):
        by_arriving[sheet, :, sheet * 2 * m : (sheet + 1) * 2 * m] = section.charge_by_waves
    load[0, :, waves:before_forces] = scatterer.potentials
    load[..., before_forces:] = np.einsum("fp,sfpn->sfn", section.effective, of_forces)
    load += (change_by_charge @ by_arriving.reshape(size, columns)).reshape(load.shape)
    by_potentials = (change_by_charge.reshape(size, sheets, fingers) @ section.charge_by_potentials).reshape(size, size)
    finger_potentials = np.linalg.solve(np.eye(size) - by_potentials, load.reshape(size, columns)).reshape(load.shape)
    charges = by_arriving + section.charge_by_potentials @ finger_potentials  # equation (2)

    sent = section.leaving[:, 2 * m :] @ finger_potentials
    for sheet in range(sheets):
        sent[sheet, :, sheet * 2 * m : (sheet + 1) * 2 * m] += section.leaving[:, : 2 * m]
    return _Response(
        scatterer=scatterer,
        lengths=lengths,
        arriving=arriving,
        lines=section.lines,
        potentials=finger_potentials,
        sent=sent.reshape(waves, columns),
        dipoles=(added @ charges.reshape(size, columns)).reshape(finger_potentials.shape),
    )
