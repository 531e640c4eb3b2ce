"""Transducers that receive the mean of a beam over their aperture, and send their own in turn.

In the section a transducer sends waves of amplitude c_p, and another one at a distance L (from middle to middle)
receives c_p exp(-i k_p L).  Fingers of the lengths W_i and W_j receive B_ij,p times as much,

    B_ij,p = int dk_y / 2 pi  W_i sinc(k_y W_i / 2) sinc(k_y W_j / 2) (k_p / kappa_p) exp(-i (kappa_p - k_p) L)

where their middles lie on one line, and with cos(k_y d) in the integral where they lie d beside each other.

Massless fingers scatter by their charges alone: what a transducer sends for an arriving wave is the section's answer
less the wave that passes, and the waves of all others pass it as they pass a bare surface.  W_j B_ij,p does not change
when i and j are exchanged, so the admittance matrix stays symmetric.

A transducer's response to its own charges is that of own_aperture.py.  Limits: solids isotropic about z, absorbing
ends; elsewhere transducers receive, and respond to their own charges, as in the section.  How a transducer weighs a
wave along its length is the section's.
"""

from dataclasses import replace
from functools import partial
from itertools import combinations

import numpy as np

from fem.beam.lateral import evanescent, lateral_rule
from fem.beam.line_source import line_source
from fem.beam.own_aperture import finger_coupling, polarisability
from fem.condense.transducer import finger_ports
from fem.geometry import Stator, Transducer
from fem.input_error import InputError
from fem.materials import isotropic_about_normal
from fem.waveguide.network import Network, PortSolution, Scatterer
from fem.waveguide.port_fields import PortFields, Solve, connected

SHORTEST = 0.5  # aperture over wavelength: shorter fingers are no line sources, and their charges vary all along them


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
    sender: float,
    receiver: float,
    distance: float,
    mirror_width: float | None = None,
    offset: float = 0.0,
) -> np.ndarray:
    """Mean over the receiving aperture of each mode's beam, over the section's wave.

    Parameters
    ----------
    wavenumbers : ndarray, shape (modes,)
        k_p of waves to the right, rad/m.
    sender, receiver : float
        Apertures in m.
    distance : float
        m.
    mirror_width : float, optional
        Of two reflecting side faces, m; both apertures then lie in the middle.
    offset : float
        Across, from the middle of one aperture to that of the other, m.

    Returns
    -------
    ndarray, shape (modes,)
    """
    highest = float(np.sqrt((wavenumbers**2).real.max()))
    reach = (sender + receiver) / 2 + abs(offset)
    rule = lateral_rule(highest, reach, evanescent(highest, distance), mirror_width)
    out = np.empty(len(wavenumbers), dtype=complex)
    for some, one, sign in ((wavenumbers.real >= 0, rule, 1), (wavenumbers.real < 0, rule.conjugate, -1)):
        k = wavenumbers[some, None]
        along = sign * np.sqrt(k**2 - one.nodes**2)
        both = (
            sender
            * np.prod([np.sinc(one.nodes * each / (2 * np.pi)) for each in (sender, receiver)], axis=0)
            * np.cos(one.nodes * offset)
        )
        out[some] = (k / along * np.exp(-1j * (along - k) * distance)) @ (both * one.weights)
    return out


def with_apertures(fields: PortFields, mirror_width: float | None = None) -> PortFields:
    """Solve the ports of a stator again, the waves and each transducer's own field averaged over its aperture.

    Parameters
    ----------
    fields : PortFields
        Of the section.
    mirror_width : float, optional
        Of two reflecting side faces, m.

    Returns
    -------
    PortFields
        Charges and admittances of transducers of finite aperture; ``sides`` are their lines for the mean waves, with
        the potential of every finger that would make its charge in the section.  Beyond the limits above the fields as
        they are.
    """
    solve = aperture_solver(fields.stator, mirror_width)
    if solve is None:
        return fields
    network, solution = solve(fields.network, fields.transducers)
    return connected(fields.stator, fields.transducers, network, solution, resolution=fields.resolution)


def aperture_solver(stator: Stator, mirror_width: float | None = None) -> Solve | None:
    """What solves a stator's network for finite apertures; None beyond the limits above."""
    if stator.pieces or stator.ends != "absorbing" or not isotropic_about_normal(stator.solid):
        return None
    return partial(_solved, mirror_width=mirror_width)


def _solved(
    network: Network, transducers: tuple[Transducer, ...], mirror_width: float | None
) -> tuple[Network, PortSolution]:
    """The network with a potential for every finger, and the fields of its ports."""
    section = network.modes.section
    surface = network.modes.wavenumbers[network.modes.rayleigh].real.mean() / section.length_unit
    refuse_short_apertures(transducers, 2 * np.pi / surface)
    segments = network.segments[1:-1]
    kept = network.survivors(float(np.diff(segments, axis=1).min())) if len(segments) else np.empty(0, int)
    m = len(kept)
    travel = _travel(network, transducers, kept, mirror_width)
    source = line_source(network.modes)
    # V per C/m, over charge and charge, charge and dipole, dipole and dipole, to scaled ones
    units = section.solid.stress_unit / section.solid.potential_unit**2 * section.length_unit ** np.arange(3)
    scatterers, responses, done = [], [], {}
    for plain, transducer in zip(network.scatterers, transducers, strict=True):
        if id(plain) not in done:
            done[id(plain)] = _by_fingers(plain, transducer.signs)
        scatterer, dipoles = done[id(plain)]
        if (id(plain), transducer.aperture) not in done:
            change = [*finger_coupling(source, transducer, mirror_width)]
            change = [unit * each for unit, each in zip(units, change, strict=True)]
            change.append(-polarisability(source, transducer.finger_width) / units[2])
            done[id(plain), transducer.aperture] = _response(scatterer, dipoles, kept, change)
        scatterers.append(scatterer)
        responses.append(done[id(plain), transducer.aperture])
    network = replace(network, scatterers=tuple(scatterers))
    coupling = np.zeros_like(travel)
    for index, (_, _, sent, _) in enumerate(responses):
        mine = slice(2 * m * index, 2 * m * (index + 1))
        coupling[mine] = sent[:, : 2 * m] @ travel[mine]
    volts = np.split(np.eye(network.ports), np.cumsum([each.potentials.shape[1] for each in scatterers])[:-1])
    by_ports = np.concatenate(
        [sent[:, 2 * m :] @ own for (_, _, sent, _), own in zip(responses, volts, strict=True)]
    )
    arriving = travel @ np.linalg.solve(np.eye(len(coupling)) - coupling, by_ports)
    sides, incoming, charges, dipoles = [], [], [], []
    for scatterer, (lines, comes, _, added), own, waves in zip(
        scatterers, responses, volts, np.split(arriving, len(responses)), strict=True
    ):
        weights = np.concatenate([waves, own])
        sides.append(lines @ weights)
        incoming.append(comes @ weights)
        dipoles.append(added @ weights)
        charges.append(scatterer.charge(*np.split(sides[-1], [2 * section.size])))
    solution = PortSolution(
        sides=tuple(sides),
        incoming=tuple(incoming),
        charges=np.concatenate(charges),
        coupling=coupling,
        waves=np.tile(kept, 2 * len(responses)),
        dipoles=tuple(dipoles),
        own_apertures=True,
    )
    return network, solution


def _by_fingers(scatterer: Scatterer, signs: str) -> tuple[Scatterer, np.ndarray]:
    """The scatterer with a potential for every finger; and the fingers' dipoles by its sides."""
    electrodes = ["+-".index(sign) for sign in signs if sign in "+-"]
    superelement, dipoles = finger_ports(scatterer.superelement, signs)
    own = scatterer.potentials[electrodes]
    return Scatterer(superelement=superelement, modes=scatterer.modes, potentials=own), dipoles


def _travel(
    network: Network, transducers: tuple[Transducer, ...], kept: np.ndarray, mirror_width
) -> np.ndarray:
    """Amplitudes that arrive from those that are sent: of each transducer, to the right, then to the left."""
    modes, unit, m = network.modes, network.modes.section.length_unit, len(kept)
    edges = [
        (place, place + each.superelement.width)
        for place, each in zip(network.places, network.scatterers, strict=True)
    ]
    out = np.zeros((2 * m * len(edges), 2 * m * len(edges)), dtype=complex)
    for one, other in combinations(range(len(edges)), 2):
        (first, last), (left, right), pair = edges[one], edges[other], (transducers[one], transducers[other])
        to_other = aperture_coupling(
            modes.wavenumbers[kept] / unit,
            pair[0].aperture,
            pair[1].aperture,
            (left + right - first - last) / 2 * unit,
            mirror_width,
            pair[1].center_y - pair[0].center_y,
        )
        to_one = to_other * (pair[1].aperture / pair[0].aperture)
        for sender, receiver, shares, phase in (
            (one, other, to_other, modes.wavenumbers[kept] * (left - last)),
            (other, one, to_one, modes.backwards[kept] * (last - left)),
        ):
            rows, columns = (
                np.arange(m) + m * (2 * each + (sender > receiver)) for each in (receiver, sender)
            )
            out[rows, columns] = shares * np.exp(-1j * phase)
    return out


def _response(
    scatterer: Scatterer, dipoles: np.ndarray, kept: np.ndarray, change: tuple[np.ndarray, ...]
) -> tuple[np.ndarray, ...]:
    """Response to each mode from the left and from the right, and to each port.

    Lines with the fingers' potentials in the section, what arrives there, amplitudes sent, and dipoles beyond the
    section's.  ``dipoles`` of the fingers by the sides, ``change`` of their potentials by charges and dipoles, scaled.
    """
    modes, width = scatterer.modes, scatterer.superelement.width
    n, m = modes.section.size, len(kept)
    fingers, ports = scatterer.potentials.shape
    incoming = np.zeros((2 * n, 2 * m + fingers), dtype=complex)
    incoming[:n, :m] = modes.right[:, kept]
    incoming[n:, m : 2 * m] = modes.left[:, kept]
    potentials = np.eye(fingers, 2 * m + fingers, 2 * m)
    lines = scatterer.sides(incoming, potentials)
    sides = np.concatenate([lines, potentials])
    reactions = scatterer.superelement.matrix[2 * n :] @ sides
    by_waves, by_fingers = reactions[:, : 2 * m], reactions[:, 2 * m :]
    # one potential on all fingers of a floating section makes no charge
    gauge = abs(np.diag(by_fingers)).sum() / max(fingers, 1) ** 2 if modes.section.floating_potential else 0.0
    dipole = np.linalg.solve((by_fingers + gauge).T, (dipoles @ sides[:, 2 * m :]).T).T
    charges, mixed, moments, polarisability = change
    gradient = mixed.T + moments @ dipole  # by the charges
    own = charges + mixed @ dipole + dipole.T @ gradient + polarisability * gradient.T @ gradient
    given = np.hstack([own @ by_waves, scatterer.potentials])
    weights = np.eye(2 * m + fingers, 2 * m + ports, dtype=complex)
    weights[2 * m :] = np.linalg.solve(np.eye(fingers) - own @ by_fingers, given)
    lines, incoming = lines @ weights, incoming @ weights
    out = lines - incoming
    sent = np.concatenate([modes.right_amplitudes(out[n:])[kept], modes.left_amplitudes(out[:n])[kept]])
    passed = np.append(
        np.exp(-1j * modes.wavenumbers[kept] * width), np.exp(1j * modes.backwards[kept] * width)
    )
    sent[:, : 2 * m] -= np.diag(passed)
    added = polarisability * gradient @ reactions @ weights
    return np.concatenate([lines, weights[2 * m :]]), incoming, sent, added
