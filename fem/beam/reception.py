"""Coupling of transducers of finite aperture in cascade: each receives the beams of the others and sends its own.

In the section a transducer sends waves of amplitude c_p, and another one receives c_p exp(-i k_p L), with L the
distance of their centres.  For fingers of finite length, charges that are uniform over lengths W_i and W_j along y
(sheets, own_aperture.py) receive B_ij,p times this amplitude,

    B_ij,p = int dk_y / 2 pi  W_i sinc(k_y W_i / 2) sinc(k_y W_j / 2) (k_p / kappa_p) exp(-i (kappa_p - k_p) L)    (1)

if their centres have the same y; if these differ by d, the integrand has the factor cos(k_y d).

Massless fingers scatter by their charges alone.  The wave that a transducer sends when a wave arrives is therefore the
response of the section minus the transmitted wave, and the waves of all other transducers pass it as if its surface
were bare.  W_j B_ij,p does not change if i and j are exchanged, so that the admittance matrix is symmetric.

An arriving beam phi(y) is projected on the sheets f_c, which are 1 on |y| < L_c / 2: it has the amplitudes a_b with

    sum_b O_cb a_b = int f_c phi dy,    O_cb = min(L_c, L_b).                                                     (2)

The response of a transducer to the a_b is in own_aperture.py.  The waves of another transducer are taken at the
receiver's centre, those of a force at the centre, a_b, and at every finger f, a_b + A_bf.

Limits: the solid must be isotropic about z and the ends must absorb.  Otherwise transducers receive waves, and respond
to their own charges, as in the section.  Open strips always respond as in the section.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial
from itertools import combinations
from threading import Lock

import numpy as np

from fem.beam.lateral import (
    amplitude_ratio,
    evanescent,
    highest_wavenumber,
    lateral_rule,
    sheet_spectrum,
    wavenumber_along,
)
from fem.beam.line_source import line_source
from fem.beam.own_aperture import (
    MAX_UNKNOWNS,
    ApertureResponse,
    Coupling,
    aperture_response,
    finger_coupling,
    no_coupling,
    sheet_lengths,
    tips,
    with_tips,
)
from fem.condense.electrode_conditions import charged
from fem.discretize.section import LineSpace
from fem.discretize.spectral import chebyshev_nodes, lagrange_weights
from fem.exceptions import InputError
from fem.geometry import Stator, Transducer
from fem.materials import isotropic_about_normal
from fem.threads import side_by_side
from fem.waveguide.cascade_system import Element, Travel, solve_cascade
from fem.waveguide.guided_modes import GuidedModes, full_modes, guided_modes
from fem.waveguide.port_fields import PortFields, StatorCascade
from fem.waveguide.scattering_network import Network, PortSolution

SHORTEST = 0.5  # smallest aperture over wavelength: shorter fingers are not line sources
# Largest size of the system of waves between transducers, two waves per sheet and mode.  To keep it, modes that decay
# by exp(-NEEDED_DECAY) or more on the way are left out first, then shorter sheets.
MAX_WAVES, NEEDED_DECAY = 3000, 11.5
# Chebyshev nodes over a band of the coupling by the modes that its reduced lines leave out
BAND_NODES = 5


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
    """Mean of each mode's beam over the receiving aperture, relative to the wave in the section: B of equation (1).

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
        True if the sender is a force along x, of which the part kappa_p / k_p acts along the wave vector.

    Returns
    -------
    ndarray, shape (*receivers, *senders, modes)
    """
    highest = highest_wavenumber(wavenumbers)
    reach = (np.max(sender) + np.max(receiver)) / 2 + abs(offset)
    rule = lateral_rule(highest, reach, evanescent(highest, distance), mirror_width)
    out = np.empty((*np.shape(receiver), *np.shape(sender), len(wavenumbers)), dtype=complex)
    for modes, contour in rule.contours(wavenumbers):
        k = wavenumbers[modes, None]
        along = wavenumber_along(k, contour.nodes)
        waves = amplitude_ratio(k, along, tangential=tangential) * np.exp(-1j * (along - k) * distance)
        waves = waves * (contour.weights * np.cos(contour.nodes * offset))
        sent, received = (sheet_spectrum(each, contour.nodes) for each in (sender, receiver))
        received = received / np.asarray(receiver)[..., None]
        both = np.expand_dims(received, tuple(range(np.ndim(receiver), np.ndim(receiver) + np.ndim(sender)))) * sent
        out[..., modes] = both @ waves.T
    return out


def with_apertures(
    fields: PortFields,
    mirror_width: float | None = None,
    fineness: int = 0,
    reaches: Mapping[str, tuple[float, ...]] | None = None,
    *,
    plane: bool = False,
) -> PortFields:
    """Solve the ports of a stator again for fingers of finite length, along which the charges vary.

    Parameters
    ----------
    fields : PortFields
        Solution of the section.
    mirror_width : float, optional
        Distance of two reflecting side faces, m.
    fineness : int
        Number of finer sets of steps along the fingers that are skipped (`sheet_lengths`).
    reaches : mapping, optional
        Of transducers by name, how far each finger reaches over the aperture, 0 to 1; by default all are 1.
    plane : bool
        True: the charges and waves of the section, on the same sheets; they are compared with those of strips.

    Returns
    -------
    PortFields
        Charges and admittances of transducers of finite aperture.  ``sides`` are the unknowns on their lines for the
        waves averaged over the aperture, with the potential of every finger that would cause its charge in the section.
        ``fields`` itself is returned if the limits of this module are not met.
    """
    solve = aperture_solver(fields.stator, mirror_width, fineness, reaches=reaches, plane=plane)
    if solve is None or None in fields.owners or not fields.transducers:
        return fields
    return solve(fields)


def aperture_solver(
    stator: Stator,
    mirror_width: float | None = None,
    fineness: int = 0,
    limits: tuple[float, float] | None = None,
    *,
    reaches: Mapping[str, tuple[float, ...]] | None = None,
    plane: bool = False,
) -> Callable[[StatorCascade], PortFields] | None:
    """Solver of a stator's cascade for finite apertures; None if the limits of this module are not met.

    ``limits``: lowest and highest frequency (Hz), if the solver will be called at many frequencies of a band; for
    ``reaches`` and ``plane`` see `with_apertures`.
    """
    if stator.pieces or stator.layers or stator.ends != "absorbing" or not isotropic_about_normal(stator.solid):
        return None
    own_apertures = OwnApertures(mirror_width, limits, plane=plane)
    return partial(_port_fields, own_apertures, fineness=fineness, reaches=reaches or {})


class OwnApertures:
    """Coupling of a transducer's fingers by `finger_coupling`, interpolated in frequency if there is a band.

    The modes of the full section are used, because those of a band's reduced basis do not resolve the near field.  In a
    band the coupling is that by the reduced modes at each frequency plus the interpolated difference between that by
    the full modes and that by the reduced ones.  The difference has neither propagating modes nor those near their
    cut-off, where k changes as the square root of the frequency and no polynomial follows.
    """

    def __init__(self, mirror_width: float | None, limits: tuple[float, float] | None, *, plane: bool = False):
        self.mirror_width, self.limits, self.plane = mirror_width, limits, plane
        self._at_nodes: dict[tuple, tuple] = {}
        self._lock = Lock()

    def coupling(self, network: Network, transducer: Transducer, lengths: np.ndarray) -> Coupling:
        """Coupling at the frequency of the network."""
        if self.plane:
            return no_coupling(transducer, len(lengths))
        modes = network.modes
        section = modes.section
        if self.limits is None or section is section.full:
            return self._by_modes(full_modes(modes), transducer, lengths)
        key = id(section), transducer, tuple(lengths)
        with self._lock:
            if key not in self._at_nodes:
                self._at_nodes[key] = section, *self._beyond_reduced(section, self.limits, transducer, lengths)
        _, nodes, beyond = self._at_nodes[key]
        weights, reduced = lagrange_weights(nodes, modes.frequency), self._by_modes(modes, transducer, lengths)
        return Coupling._make(
            own + np.tensordot(weights, each, axes=1) for own, each in zip(reduced, beyond, strict=True)
        )

    def _by_modes(self, modes: GuidedModes, transducer: Transducer, lengths: np.ndarray) -> Coupling:
        return finger_coupling(line_source(modes, "charge"), transducer, lengths, self.mirror_width)

    def _beyond_reduced(
        self, section: LineSpace, limits: tuple[float, float], transducer: Transducer, lengths: np.ndarray
    ) -> tuple[np.ndarray, list[np.ndarray]]:
        """Nodes in Hz, and at each of them the arrays of `Coupling` by the modes that reduced lines leave out."""
        nodes = chebyshev_nodes(*limits, BAND_NODES)

        def at_node(frequency: float) -> Coupling:
            full, reduced = (
                self._by_modes(guided_modes(each, float(frequency)), transducer, lengths)
                for each in (section.full, section)
            )
            return Coupling._make(one - other for one, other in zip(full, reduced, strict=True))

        at = side_by_side(at_node, nodes)
        return nodes, [np.stack(each) for each in zip(*at, strict=True)]


def _port_fields(
    own_apertures: OwnApertures, cascade: StatorCascade, *, fineness: int, reaches: Mapping[str, tuple[float, ...]]
) -> PortFields:
    """Fields of the cascade's ports, with one potential per finger."""
    modes = cascade.network.modes
    surface = modes.wavenumbers[modes.rayleigh].real.mean() / modes.section.length_unit
    refuse_short_apertures(cascade.transducers, 2 * np.pi / surface)
    own_reaches = [
        tips(each, reaches[each.name], sharp=own_apertures.plane) if each.name in reaches else None
        for each in cascade.transducers
    ]
    beams = _Beams.of(cascade.network, cascade.transducers, fineness, own_apertures.mirror_width)
    beams = replace(
        beams,
        plane=own_apertures.plane,
        lengths=[
            lengths if reach is None else with_tips(lengths, reach, each, sharp=own_apertures.plane)
            for lengths, reach, each in zip(beams.lengths, own_reaches, beams.transducers, strict=True)
        ],
    )
    outside, changes = beams.from_forces()
    responses = _responses(own_apertures, beams, changes, own_reaches)
    network = replace(cascade.network, scatterers=tuple(each.scatterer for each in responses))
    return replace(cascade, network=network).solved(_port_solution(network, beams, responses, outside))


def _responses(
    own_apertures: OwnApertures, beams: "_Beams", changes: list[np.ndarray], reaches: list[np.ndarray | None]
) -> list[ApertureResponse]:
    """Response of each transducer; equal transducers share a scatterer, and without forces a response."""
    network, responses, couplings, by_kind = beams.network, [], {}, {}
    for index, (plain, transducer, own_lengths, reach) in enumerate(
        zip(network.scatterers, beams.transducers, beams.lengths, reaches, strict=True)
    ):
        kind = id(plain), transducer.aperture, None if reach is None else tuple(reach.tolist())
        if kind not in couplings:
            couplings[kind] = own_apertures.coupling(network, replace(transducer, name="", center=0.0), own_lengths)
        key = (*kind, index if network.forces else 0)
        if key not in by_kind:
            by_kind[key] = aperture_response(
                plain, transducer, beams.coupling_modes, own_lengths, couplings[kind], changes[index], reach
            )
        responses.append(by_kind[key])
    return responses


def _port_solution(
    network: Network, beams: "_Beams", responses: list[ApertureResponse], outside: np.ndarray | None
) -> PortSolution:
    """Solve the cascade for the waves between the transducers, and return the fields for a unit at each port."""
    ports = len(network.ports)
    # of each transducer: which ports and forces its last columns belong to
    own_ports = [np.eye(ports)[[*numbers, *network.forces]] for numbers in network.numbers]
    elements = [
        Element(
            scattering=each.sent[:, : stop - start],
            excitation=each.sent[:, stop - start :] @ selection,
            leaves=np.arange(start, stop),
            arrives=np.arange(start, stop),
        )
        for each, selection, start, stop in zip(responses, own_ports, beams.first, beams.first[1:], strict=False)
    ]
    solved = solve_cascade(elements, beams.travel(), outside)
    sides, incoming, charges, sheets = [], [], [], []
    for each, selection, element in zip(responses, own_ports, elements, strict=True):
        weights = np.concatenate([solved.arriving[element.arrives], selection])
        sheets.append(each.sheets(weights))
        shares = each.lengths / each.lengths[0]
        sides.append(sum(share * sheet.sides for share, sheet in zip(shares, sheets[-1], strict=True)))
        incoming.append(each.incoming(weights))
        own = each.scatterer.reactions(sides[-1]) if each.at_ports is None else each.at_ports @ weights
        charges.append(own)
    return PortSolution(
        sides=tuple(sides),
        incoming=tuple(incoming),
        segments=network.segment_waves(sides, incoming),
        reactions=np.concatenate(charges),
        coupling=solved.coupling,
        waves=np.concatenate([np.tile(beams.coupling_modes, 2 * len(each.lengths)) for each in responses]),
        sheets=tuple(sheets),
        own_apertures=True,
    )


@dataclass(frozen=True, kw_only=True)
class _Beams:
    """Waves between the transducers of a cascade, and from forces: vectors of amplitudes in a fixed order.

    They are ordered by transducer and sheet, then waves to the right and waves to the left, then by mode.
    """

    network: Network
    transducers: tuple[Transducer, ...]
    lengths: list[np.ndarray]  # of the sheets of each transducer, m
    coupling_modes: np.ndarray  # numbers of the modes that couple transducers
    mirror_width: float | None
    plane: bool = False  # whether a beam arrives as it was sent, as in the section

    @classmethod
    def of(
        cls, network: Network, transducers: tuple[Transducer, ...], fineness: int, mirror_width: float | None
    ) -> "_Beams":
        """Return the sheets and modes within MAX_WAVES."""
        # Between transducers the waves that couple them are enough: what a force adds nearby decays before the next.
        between = np.diff(network.segments[1:-1], axis=1).ravel()
        gaps = between if len(between) else [abs(gap) for _, _, gap in _force_gaps(network)]
        coupling_modes = network.survivors(float(min(gaps))) if len(gaps) else np.empty(0, int)
        decay = -network.modes.wavenumbers[coupling_modes].imag * float(min(gaps, default=0.0))
        needed = int(np.count_nonzero(decay < NEEDED_DECAY))
        lengths = []
        for each in transducers:
            fingers = max(int(np.count_nonzero(charged(each.signs))), 1)
            most_sheets = MAX_WAVES // max(2 * needed * len(transducers), 1)  # forces alone do not change the sheets
            most = MAX_UNKNOWNS if len(transducers) == 1 else min(MAX_UNKNOWNS, most_sheets * fingers)
            lengths.append(sheet_lengths(each, fineness, most))
        most_modes = max(MAX_WAVES // (2 * sum(map(len, lengths))), needed if len(transducers) > 1 else 1)
        coupling_modes = np.sort(coupling_modes[np.argsort(decay, kind="stable")[:most_modes]])
        return cls(
            network=network,
            transducers=transducers,
            lengths=lengths,
            coupling_modes=coupling_modes,
            mirror_width=mirror_width,
        )

    @cached_property
    def first(self) -> np.ndarray:
        """Number of the first wave of each transducer, and the number of all waves."""
        return np.cumsum([0, *(2 * len(self.coupling_modes) * len(each) for each in self.lengths)])

    @cached_property
    def overlaps(self) -> list[np.ndarray]:
        """O / L of the sheets of each transducer, (O / L)_cb = O_cb / L_c."""
        return [np.minimum.outer(each, each) / each[:, None] for each in self.lengths]

    def travel(self) -> list[Travel]:
        """Factors from the amplitudes that are sent to those that arrive, of each mode and two transducers.

        With B of `aperture_coupling`, the amplitudes c_b on the sheets b of one transducer arrive on the sheets of
        another, at the distance l of their facing lines, as a = (O / L)^-1 B c exp(-i k l): equation (2), divided by
        L_c because B is a mean over the receiving sheet.
        """
        modes, unit, m = self.network.modes, self.network.modes.section.length_unit, len(self.coupling_modes)
        lines, lengths = self.network.lines, self.lengths
        out: list[Travel] = []
        for one, other in combinations(range(len(lines)), 2):
            gap = lines[other][0] - lines[one][1]
            to_other = np.minimum.outer(lengths[other], lengths[one])[..., None] / lengths[other][:, None, None]
            to_other = (
                to_other + np.zeros(m)
                if self.plane
                else aperture_coupling(
                    modes.wavenumbers[self.coupling_modes] / unit,
                    lengths[one],
                    lengths[other],
                    (sum(lines[other]) - sum(lines[one])) / 2 * unit,
                    self.mirror_width,
                    self.transducers[other].center_y - self.transducers[one].center_y,
                )
            )
            to_one = np.swapaxes(to_other * (lengths[other][:, None] / lengths[one])[..., None], 0, 1)
            for sender, receiver, mean_beams, phase in (
                (one, other, to_other, modes.wavenumbers[self.coupling_modes] * gap),
                (other, one, to_one, -modes.backwards[self.coupling_modes] * gap),
            ):
                amplitudes = np.tensordot(np.linalg.inv(self.overlaps[receiver]), mean_beams, axes=1)
                direction = int(sender > receiver)  # 0 to the right, 1 to the left
                arriving = np.moveaxis(amplitudes * np.exp(-1j * phase), 2, 0)  # (modes, sheets, sheets)
                arrives, leaves = (self._by_mode(each, direction) for each in (receiver, sender))
                out.append(Travel(arrives, leaves, arriving))
        return out

    def _by_mode(self, index: int, direction: int) -> np.ndarray:
        """Numbers of a transducer's waves to the right (0) or to the left (1), shape (modes, sheets)."""
        start, stop = self.first[index], self.first[index + 1]
        numbers = np.arange(start, stop).reshape(len(self.lengths[index]), 2, len(self.coupling_modes))
        return numbers[:, direction].T

    def from_forces(self) -> tuple[np.ndarray | None, list[np.ndarray]]:
        """Waves that arrive directly from the strips of force, and their change from finger to finger.

        The amplitudes (waves, ports) are those at the centre of a transducer, None without a force.  A force of a width
        w sends its waves as a sheet of charge of this length does.

        The changes A of the module docstring are (sheets, fingers, 2 modes, forces) for each transducer: on each finger
        the mean over a sheet is B of equation (1) at the distance of the finger instead of that of the centre.
        """
        network, m, forces = self.network, len(self.coupling_modes), list(self.network.forces)
        out = np.zeros((self.first[-1], len(network.ports)), dtype=complex)
        changes = [
            np.zeros((len(own), np.count_nonzero(charged(each.signs)), 2, m, len(forces)), dtype=complex)
            for own, each in zip(self.lengths, self.transducers, strict=True)
        ]
        for number, index, gap in _force_gaps(network):
            direction = int(gap < 0)  # 0 to the right, 1 to the left
            amplitudes = self._from_force(number, index, gap)
            out[self._waves(index), number].reshape(-1, 2, m)[:, direction] = amplitudes[0]
            on_fingers = np.swapaxes(amplitudes[1:] - amplitudes[0], 0, 1)
            changes[index][:, :, direction, :, forces.index(number)] = on_fingers
        return out if forces else None, [each.reshape(*each.shape[:2], 2 * m, len(forces)) for each in changes]

    def _from_force(self, number: int, index: int, gap: float) -> np.ndarray:
        """Amplitudes of a force's waves at a transducer's centre, then on its fingers, (1 + fingers, sheets, modes)."""
        network, modes, unit = self.network, self.network.modes, self.network.modes.section.length_unit
        port, force, transducer = network.ports[number], network.forces[number], self.transducers[index]
        k, sent = (modes.wavenumbers, force.right) if gap > 0 else (-modes.backwards, force.left)
        finger_x = transducer.fingers[charged(transducer.signs)].mean(axis=1) / unit
        to_centre = abs(gap) + network.scatterers[index].piece.width / 2
        mean_beams = [
            aperture_coupling(
                k[self.coupling_modes] / unit,
                port.width * unit,
                self.lengths[index],
                distance * unit,
                self.mirror_width,
                transducer.center_y - port.center * unit,
                tangential=port.component == "x",
            )
            for distance in (to_centre, *abs(finger_x - port.position))
        ]
        amplitudes = np.linalg.solve(self.overlaps[index], np.array(mean_beams))
        return amplitudes * (sent * np.exp(-1j * k * abs(gap)))[self.coupling_modes]

    def _waves(self, index: int) -> slice:
        """Numbers of a transducer's waves."""
        return slice(self.first[index], self.first[index + 1])


def _force_gaps(network: Network) -> list[tuple[int, int, float]]:
    """Return number of the port, number of the transducer and gap between them, for each force and transducer.

    The gap is the distance to the nearest line of the transducer, length units; positive if it lies on the right.
    """
    positions = [(number, network.ports[number].position) for number in network.forces]
    return [
        (number, index, left - position if left > position else right - position)
        for number, position in positions
        for index, (left, right) in enumerate(network.lines)
    ]
