"""Mutual admittance of two transducers on one surface, by reciprocity, from the charges of each alone.

Let q_i be the charges per volt at port i of one transducer, alone on the bare surface, and q_j those at port j of the
other.  By reciprocity

    Y_ij = -i omega int q_j phi_i dA = -i omega int dk_t / 2 pi  sum_p A_p (k_p / kappa_p) q_i^(k) q_j^(-k),

with phi_i the potential of the beam that port i excites, k = kappa_p n + k_t t, n any direction along which there is a
gap between the transducers, t the direction across n, q^ the Fourier transform of the charges in the plane and A_p the
potential of mode p per line charge.  The solid is isotropic about z.
"""

import numpy as np

from fem.beam.electrode_charges import ElectrodeCharges
from fem.beam.lateral import evanescent, highest_wavenumber, lateral_rule, turned, wavenumber_along
from fem.beam.line_source import KEPT, LOCAL, line_source
from fem.geometry import Transducer, separation, turn
from fem.waveguide.modes import GuidedModes

# A mode is neglected if its decay from centre to centre has a larger exponent.
MAX_DECAY_EXPONENT = 300.0


def mutual_admittance(
    modes: GuidedModes,
    plan: tuple[Transducer, Transducer],
    origins: tuple[float, float],
    angles: tuple[float, float],
    charges: tuple[ElectrodeCharges, ElectrodeCharges],
    *,
    along: float | None = None,
) -> complex:
    """Short-circuit current at one transducer per volt at another, in S, from the charges of each alone.

    Parameters
    ----------
    modes : GuidedModes
        Modes of the bare section.
    plan : tuple of Transducer
        The two transducers, as they lie on the surface.
    origins : tuple of float
        Positions of their centres in the coordinates of ``charges``, m.
    angles : tuple of float
        Angles of the axes of these coordinates to x, rad.
    charges : tuple of ElectrodeCharges
        Charges of each transducer per volt.
    along : float, optional
        Direction in rad of a gap between them; by default that of the widest gap.

    Returns
    -------
    complex
        Mutual admittance, which does not depend on the order of the two.
    """
    one, other = plan
    gap, widest = separation(one, other)
    forward, across = turn(widest if along is None else along)
    between = np.array([other.center - one.center, other.center_y - one.center_y])
    distance, offset = float(between @ forward), float(between @ across)
    source = line_source(modes)
    k = source.wavenumbers
    wavelength = 2 * np.pi / float(np.mean(k[source.surface].real))
    # A mode is kept if its amplitude is more than exp(-LOCAL) after a wavelength, more than exp(-MAX_DECAY_EXPONENT)
    # from centre to centre, and more than KEPT after the gap.
    kept = -k.imag * max(wavelength / LOCAL, distance / MAX_DECAY_EXPONENT, gap / -np.log(KEPT)) < 1
    reach = abs(offset) + sum(float(abs((each.corners - each.corners.mean(axis=0)) @ across).max()) for each in plan)
    highest = highest_wavenumber(k)
    rule = lateral_rule(highest, reach, evanescent(highest, max(gap, wavelength)))
    total = 0.0
    pairs = [(number, contour) for some, contour in rule.contours(k) for number in np.flatnonzero(kept & some)]
    for number, contour in pairs:
        kappa = wavenumber_along(k[number], contour.nodes)
        for side in (1, -1):  # both signs of k_t, half the weight each
            lateral = side * contour.nodes
            vector = np.outer(forward, kappa) + np.outer(across, lateral)
            transforms = [  # q_i^(k) and q_j^(-k)
                own.plane_transform(sign * (turn(angle) @ vector), each.aperture, origin)
                for sign, angle, each, origin, own in zip((1, -1), angles, plan, origins, charges, strict=True)
            ]
            phase = np.exp(-1j * (kappa * distance + lateral * offset))
            total += source.potential[number] * np.sum(
                contour.weights / 2 * turned(k[number], kappa) * transforms[0] * transforms[1] * phase
            )
    return complex(-2j * np.pi * modes.frequency * total)
