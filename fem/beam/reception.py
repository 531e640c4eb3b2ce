"""Transducers that receive the mean of a beam over their aperture, and send their own in turn.

In the section a transducer sends waves of amplitude c_p, and another one at a distance L (from middle to middle)
receives c_p exp(-i k_p L).  Fingers of the lengths W_i and W_j receive B_ij,p times as much,

    B_ij,p = int dk_y / 2 pi  W_i sinc(k_y W_i / 2) sinc(k_y W_j / 2) (k_p / kappa_p) exp(-i (kappa_p - k_p) L)

where their middles lie on one line, and with cos(k_y d) in the integral where they lie d beside each other.

Massless fingers scatter by their charges alone: what a transducer sends for an arriving wave is the section's answer
less the wave that passes, and the waves of all others pass it as they pass a bare surface.  W_j B_ij,p does not change
when i and j are exchanged, so the admittance matrix stays symmetric.

Limits: solids isotropic about z, absorbing ends; elsewhere transducers receive as in the section.  A transducer's
response to its own charges, and how it weighs a wave along its length, are the section's: for 20 wavelengths of
aperture and 10 of length the former leaves out 1.4 % of the power.
"""

import numpy as np

from fem.beam.lateral import evanescent, lateral_rule
from fem.beam.line_source import isotropic_about_normal
from fem.waveguide.network import PortSolution, Scatterer
from fem.waveguide.port_fields import PortFields, connected


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
    """Solve the ports of a stator again, each transducer receiving the mean of the beams over its aperture.

    Parameters
    ----------
    fields : PortFields
        Of the section.
    mirror_width : float, optional
        Of two reflecting side faces, m.

    Returns
    -------
    PortFields
        Charges and admittances of transducers of finite aperture; ``sides`` are their lines for the mean waves.  The
        fields as they are for one transducer, and beyond the limits above.
    """
    network = fields.network
    alone = len(network.scatterers) == 1
    if alone or fields.stator.ends != "absorbing" or not isotropic_about_normal(fields.stator.solid):
        return fields
    kept = network.survivors(float(np.diff(network.segments, axis=1)[1:-1].min()))
    m = len(kept)
    travel = _travel(fields, kept, mirror_width)
    counts = [each.potentials.shape[1] for each in network.scatterers]
    volts = np.split(np.eye(network.ports), np.cumsum(counts)[:-1])
    responses = [_response(scatterer, kept) for scatterer in network.scatterers]
    coupling = np.zeros_like(travel)
    for index, (_, _, sent) in enumerate(responses):
        mine = slice(2 * m * index, 2 * m * (index + 1))
        coupling[mine] = sent[:, : 2 * m] @ travel[mine]
    by_ports = np.concatenate(
        [sent[:, 2 * m :] @ own for (_, _, sent), own in zip(responses, volts, strict=True)]
    )
    arriving = travel @ np.linalg.solve(np.eye(len(coupling)) - coupling, by_ports)
    sides, incoming, charges = [], [], []
    for scatterer, (lines, comes, _), own, waves in zip(
        network.scatterers, responses, volts, np.split(arriving, len(responses)), strict=True
    ):
        weights = np.concatenate([waves, own])
        sides.append(lines @ weights)
        incoming.append(comes @ weights)
        charges.append(scatterer.charge(sides[-1], scatterer.potentials @ own))
    solution = PortSolution(
        sides=tuple(sides),
        incoming=tuple(incoming),
        charges=np.concatenate(charges),
        coupling=coupling,
        waves=np.tile(kept, 2 * len(responses)),
    )
    return connected(
        fields.stator, fields.transducers, network, solution, resolution=fields.resolution, own_apertures=True
    )


def _travel(fields: PortFields, kept: np.ndarray, mirror_width) -> np.ndarray:
    """Amplitudes that arrive from those that are sent: of each transducer, to the right, then to the left."""
    network, modes, unit, m = fields.network, fields.modes, fields.section.length_unit, len(kept)
    edges = [
        (place, place + each.superelement.width)
        for place, each in zip(network.places, network.scatterers, strict=True)
    ]
    out = np.zeros((2 * m * len(edges), 2 * m * len(edges)), dtype=complex)
    for sender, (first, last) in enumerate(edges):
        for receiver, (left, right) in enumerate(edges):
            if sender == receiver:
                continue
            shares = aperture_coupling(
                modes.wavenumbers[kept] / unit,
                fields.transducers[sender].aperture,
                fields.transducers[receiver].aperture,
                abs(left + right - first - last) / 2 * unit,
                mirror_width,
                fields.transducers[receiver].center_y - fields.transducers[sender].center_y,
            )
            leftward = sender > receiver
            phase = (
                modes.backwards[kept] * (right - first)
                if leftward
                else modes.wavenumbers[kept] * (left - last)
            )
            rows, columns = (np.arange(m) + m * (2 * each + leftward) for each in (receiver, sender))
            out[rows, columns] = shares * np.exp(-1j * phase)
    return out


def _response(scatterer: Scatterer, kept: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Lines, what arrives there, and amplitudes sent, for each mode from the left and from the right, and each port."""
    modes, width = scatterer.modes, scatterer.superelement.width
    n, m = modes.section.size, len(kept)
    ports = scatterer.potentials.shape[1]
    incoming = np.zeros((2 * n, 2 * m + ports), dtype=complex)
    incoming[:n, :m] = modes.right[:, kept]
    incoming[n:, m : 2 * m] = modes.left[:, kept]
    potentials = np.hstack([np.zeros((2, 2 * m)), scatterer.potentials])
    sides = scatterer.sides(incoming, potentials)
    out = sides - incoming
    sent = np.concatenate([modes.right_amplitudes(out[n:])[kept], modes.left_amplitudes(out[:n])[kept]])
    passed = np.append(
        np.exp(-1j * modes.wavenumbers[kept] * width), np.exp(1j * modes.backwards[kept] * width)
    )
    sent[:, : 2 * m] -= np.diag(passed)
    return sides, incoming, sent
