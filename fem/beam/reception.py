"""Coupling of transducers of finite aperture in cascade: each receives the beams of the others and sends its own.

In the section a transducer sends waves of amplitude c_p, and another one receives c_p exp(-i k_p L), with L the
distance of their centres.  For fingers of finite length, charges that are uniform over lengths W_i and W_j along y
(sheets, own_aperture.py) receive B_ij,p times this amplitude,

    B_ij,p = int dk_y / 2 pi  W_i sinc(k_y W_i / 2) sinc(k_y W_j / 2) (k_p / kappa_p) exp(-i (kappa_p - k_p) L)    (1)

if their centres have the same y; if these differ by d, the integrand has the factor cos(k_y d).

Massless fingers scatter by their charges alone.  The wave that a transducer sends when a wave arrives is therefore the
response of the section minus the transmitted wave, and the waves of all other transducers pass it as if its surface
were bare.  W_j B_ij,p does not change if i and j are exchanged, so that the admittance matrix is symmetric.

An arriving beam phi(y) is projected on the sheets f_c of lengths L: sum_b O_cb a_b = int f_c phi dy, with the overlaps
O_cb = min(L_c, L_b).  How a transducer answers the amplitudes a_b is in own_aperture.py.

The waves between transducers are those at the receiver's centre.  Those of a force are a_b there and a_b + A_bf on
finger f.

Limits: the solid must be isotropic about z and the ends must absorb.  Otherwise transducers receive waves, and respond
to their own charges, as in the section.  Open strips always respond as in the section.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import combinations
from threading import Lock

import numpy as np

from fem.beam.lateral import evanescent, highest_wavenumber, lateral_rule, sheet_spectrum, turned, wavenumber_along
from fem.beam.line_source import line_source
from fem.beam.own_aperture import (
    MAX_UNKNOWNS,
    ApertureResponse,
    Coupling,
    aperture_response,
    finger_coupling,
    sheet_lengths,
)
from fem.discretize.section import Section
from fem.discretize.spectral import chebyshev_nodes, lagrange_weights
from fem.exceptions import InputError
from fem.geometry import Stator, Transducer
from fem.materials import isotropic_about_normal
from fem.waveguide.cascade import Element, solve_cascade
from fem.waveguide.modes import guided_modes
from fem.waveguide.network import Network, PortSolution
from fem.waveguide.port_fields import PortFields, StatorCascade

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
) -> Callable[[StatorCascade], PortFields] | None:
    """Solver of a stator's cascade for finite apertures; None if the limits of this module are not met.

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
        section = section.full
        if self.limits is None:
            modes = network.modes if section is network.modes.section else guided_modes(section, frequency)
            return finger_coupling(line_source(modes), transducer, lengths, self.mirror_width)
        key = id(section), transducer, tuple(lengths)
        with self._lock:
            if key not in self._at_nodes:
                wavenumber = abs(network.modes.wavenumbers[network.modes.rayleigh[0]]) / section.length_unit
                at_nodes = self._solved(section, self.limits, transducer, lengths, wavenumber / frequency)
                self._at_nodes[key] = (section, *at_nodes)
        _, nodes, values = self._at_nodes[key]
        weights = lagrange_weights(nodes, frequency)
        return Coupling._make(np.tensordot(weights, each, axes=1) for each in values)

    def _solved(
        self,
        section: Section,
        limits: tuple[float, float],
        transducer: Transducer,
        lengths: np.ndarray,
        slowness: float,
    ) -> tuple[np.ndarray, list]:
        """Nodes in Hz, and the arrays of `Coupling` at the nodes; ``slowness``: wavenumber over frequency, rad s/m."""
        low, high = limits
        farthest = np.hypot(np.diff(transducer.extent).item(), transducer.aperture)
        swing = slowness * farthest * (high - low) / 2  # change of a wave's phase over half the band, rad
        nodes = chebyshev_nodes(low, high, int(np.ceil(LEAST_NODES + NODES_PER_SWING * swing)))
        at = [
            finger_coupling(line_source(guided_modes(section, float(each))), transducer, lengths, self.mirror_width)
            for each in nodes
        ]
        return nodes, [np.stack(each) for each in zip(*at, strict=True)]


def _solved(own_apertures: OwnApertures, cascade: StatorCascade, *, fineness: int) -> PortFields:
    """Fields of the cascade's ports, with one potential per finger."""
    network, transducers = cascade.network, cascade.transducers
    section = network.modes.section
    surface = network.modes.wavenumbers[network.modes.rayleigh].real.mean() / section.length_unit
    refuse_short_apertures(transducers, 2 * np.pi / surface)
    lengths, kept = _sheets_and_modes(network, transducers, fineness)
    travel = _travel(network, transducers, kept, lengths, own_apertures.mirror_width)
    outside, changes = _from_forces(network, transducers, kept, lengths, own_apertures.mirror_width)
    responses = _responses(own_apertures, cascade, kept, lengths, changes)
    network = replace(network, scatterers=tuple(each.scatterer for each in responses))
    return replace(cascade, network=network).solved(_port_solution(network, responses, travel, outside, kept))


def _sheets_and_modes(
    network: Network, transducers: tuple[Transducer, ...], fineness: int
) -> tuple[list[np.ndarray], np.ndarray]:
    """Lengths of the sheets of each transducer, and numbers of the modes that couple transducers, within MAX_WAVES."""
    # Between transducers the waves that couple them are enough: what a force adds nearby decays before the next one.
    between = np.diff(network.segments[1:-1], axis=1).ravel()
    gaps = between if len(between) else [abs(gap) for _, _, gap in _force_gaps(network)]
    kept = network.survivors(float(min(gaps))) if len(gaps) else np.empty(0, int)
    decay = -network.modes.wavenumbers[kept].imag * float(min(gaps, default=0.0))
    needed = int(np.count_nonzero(decay < NEEDED))
    lengths = []
    for each in transducers:
        fingers = max(sum(sign in "+-" for sign in each.signs), 1)
        most_sheets = MAX_WAVES // max(2 * needed * len(transducers), 1)  # forces alone do not change the sheets
        most = MAX_UNKNOWNS if len(transducers) == 1 else min(MAX_UNKNOWNS, most_sheets * fingers)
        lengths.append(sheet_lengths(each, fineness, most))
    most_modes = max(MAX_WAVES // (2 * sum(map(len, lengths))), needed if len(transducers) > 1 else 1)
    return lengths, np.sort(kept[np.argsort(decay, kind="stable")[:most_modes]])


def _responses(
    own_apertures: OwnApertures,
    cascade: StatorCascade,
    kept: np.ndarray,
    lengths: list[np.ndarray],
    changes: list[np.ndarray],
) -> list[ApertureResponse]:
    """Response of each transducer; equal transducers share a scatterer, and without forces a response."""
    network = cascade.network
    responses, couplings, by_kind = [], {}, {}
    for index, (plain, transducer, own_lengths) in enumerate(
        zip(network.scatterers, cascade.transducers, lengths, strict=True)
    ):
        kind = id(plain), transducer.aperture
        if kind not in couplings:
            couplings[kind] = own_apertures.coupling(network, replace(transducer, name="", center=0.0), own_lengths)
        key = (*kind, index if network.forces else 0)
        if key not in by_kind:
            by_kind[key] = aperture_response(
                plain, transducer.signs, kept, own_lengths, couplings[kind], changes[index]
            )
        responses.append(by_kind[key])
    return responses


def _port_solution(
    network: Network,
    responses: list[ApertureResponse],
    travel: np.ndarray,
    outside: np.ndarray | None,
    kept: np.ndarray,
) -> PortSolution:
    """Solve the cascade for the waves between the transducers, and return the fields for a unit at each port."""
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
    solved = solve_cascade(elements, travel, outside)
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
        (left, left + each.piece.width) for left, each in zip(network.positions, network.scatterers, strict=True)
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
    edges = [(left, left + each.piece.width) for left, each in zip(network.positions, network.scatterers, strict=True)]
    positions = [(number, network.ports[number].position) for number in network.forces]
    return [
        (number, index, left - position if left > position else right - position)
        for number, position in positions
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
            for distance in (to_centre, *abs(finger_x[index] - port.position))
        ]
        overlaps = np.minimum.outer(own_lengths, own_lengths) / own_lengths[:, None]  # O / L, as in `_travel`
        amplitudes = np.linalg.solve(overlaps, np.array(mean_beams))  # at the centre, then on each finger
        amplitudes *= (sent * np.exp(-1j * k * abs(gap)))[kept]
        block = out[first[index] : first[index + 1], number].reshape(len(own_lengths), 2, m)
        block[:, direction] = amplitudes[0]
        on_fingers = np.swapaxes(amplitudes[1:] - amplitudes[0], 0, 1)
        changes[index][:, :, direction, :, numbers.index(number)] = on_fingers
    return out if numbers else None, [each.reshape(*each.shape[:2], 2 * m, len(numbers)) for each in changes]
