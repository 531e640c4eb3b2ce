"""P-matrix of a transducer or of meshed pieces from their field: waves that arrive and leave, voltage and current.

The transducer stands alone between uniform segments that continue without end.  For waves of amplitude a that arrive at
the outer edges of its outer gaps and a voltage V, the waves b that leave and the current I into it are

    b = S a + p V,    I = -2 p^T a + Y V,

the P-matrix of Tobolka (IEEE Ultrasonics Symp. 1979, 676) in the form of Morgan (*Surface Acoustic Wave Filters*, 2nd
ed., 2007, appendix D): amplitudes are such that a wave carries |a|^2 / 2, peak values.  Every propagating mode may be
kept, or those of the surface wave alone; bulk waves are then left out, as by coupled modes (COM).  Modes
that decay are left out in both cases, the field beside the fingers included.

Waves are scaled by the reciprocity of the field, i omega (l_i^T F_rj - F_li^T r_j) = 2 delta_ij per aperture (r, l:
shapes to the right and to the left, F their fluxes), so that S is symmetric with losses too.  In a thick plate the
surface waves of both faces have one wavenumber to rounding, and the eigensolver may return any two mixtures of them.
The waves are therefore the mixture of which the first alone moves the surface, whatever the solver returned.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fem.convergence import refuse_above
from fem.discretize.grading import Resolution
from fem.discretize.refinement import refine_stator
from fem.discretize.section import FIELD_COLUMN
from fem.geometry import Stator, Transducer
from fem.threads import one_blas_thread
from fem.waveguide.modes import ONE_WAVE, GuidedModes, power
from fem.waveguide.network import SegmentWaves
from fem.waveguide.port_fields import solve_ports
from fem.waveguide.row_solver import Element, solve_row


@dataclass(frozen=True, kw_only=True)
class PMatrix:
    """P-matrix of a transducer, or of meshed pieces, at one frequency.

    Attributes
    ----------
    frequency : float
        Hz.
    wavenumbers : ndarray, shape (modes,)
        Of the modes to the right on the bare surface, rad/m.
    mixture : ndarray, shape (modes, modes)
        The waves, in columns, as sums of modes; diagonal but for modes that are one surface wave.
    surface_motion : ndarray, shape (modes,)
        |u_z| of a wave of amplitude 1 at the bare surface, m / W^1/2.
    scattering : ndarray, shape (2 modes, 2 modes)
        S: waves at the left edge first, then those at the right edge; electrodes short-circuited.
    excitation, detection : ndarray, shape (2 modes,)
        p in W^1/2 per V and, computed by itself, -2 p^T.
    admittance : complex
        Y in S; 0 without electrodes of both signs.
    length : float
        Between the edges, m.
    relative_error : float
        Of S and of p over its largest entry, from two discretisations.
    """

    frequency: float
    wavenumbers: np.ndarray = field(repr=False)
    mixture: np.ndarray = field(repr=False)
    surface_motion: np.ndarray = field(repr=False)
    scattering: np.ndarray = field(repr=False)
    excitation: np.ndarray = field(repr=False)
    detection: np.ndarray = field(repr=False)
    admittance: complex
    length: float
    relative_error: float

    def loaded(self, impedance: complex) -> np.ndarray:
        """Return the scattering matrix with an impedance (ohm) across the electrodes; 0: short, infinite: open."""
        if impedance == 0:
            return self.scattering
        load = 0.0 if np.isinf(impedance) else 1 / impedance
        return self.scattering - np.outer(self.excitation, self.detection) / (self.admittance + load)

    def travelled(self, distance: float) -> np.ndarray:
        """Return waves to the right after a distance in m, (modes, modes); the transpose is for waves to the left."""
        return np.linalg.solve(
            self.mixture, np.exp(-1j * self.wavenumbers * distance)[:, None] * self.mixture
        )


@one_blas_thread
def p_matrix(
    stator: Stator, transducer: Transducer, *, frequency: float, tolerance: float, every_mode: bool = False
) -> PMatrix:
    """P-matrix of a transducer on a stator's section.

    Parameters
    ----------
    stator : Stator
        Its length and ends are not read.
    transducer : Transducer
        Its place is not read.
    frequency : float
        Hz.
    tolerance : float
        Of S and, relative, of p and Y.
    every_mode : bool
        All propagating modes instead of those of the surface wave.

    Returns
    -------
    PMatrix

    Raises
    ------
    ConvergenceError
        If the finest discretisation does not reach the tolerance.

    Examples
    --------
    >>> from fem import Stator, Transducer, material, p_matrix, rotated
    >>> stator = Stator(solid=rotated(material("PZT-8"), "Z"), length=1.0, thickness=6e-4, ends="absorbing")
    >>> row = Transducer(name="t", center=0.5, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=9e-3)
    >>> found = p_matrix(stator, row, frequency=2.2e6, tolerance=0.3)
    >>> bool(abs(found.detection + 2 * found.excitation).max() < 1e-9 * abs(found.excitation).max())
    True
    """
    length = (len(transducer.signs) + 4) * transducer.pitch
    alone = replace(stator, length=length, ends="absorbing", pieces=())
    row = replace(transducer, center=length / 2, termination="open")

    def at_level(resolution: Resolution) -> PMatrix:
        return _on_level(alone, row, frequency, resolution, every_mode)

    refined = refine_stator(stator, at_level, differences=_difference, tolerance=tolerance)
    found = replace(refined.answer, relative_error=refined.errors[0])
    refuse_above(found.relative_error, tolerance, "the P-matrix is", reached=found)
    return found


def cascade_admittance(parts: Sequence[PMatrix], distances: Sequence[float]) -> np.ndarray:
    """Admittance matrix of transducers and pieces in a row, coupled by the modes of their P-matrices alone.

    Parameters
    ----------
    parts : sequence of PMatrix
        From left to right, of the same modes; nothing comes back from the outer sides.
    distances : sequence of float
        m of bare surface between the edges of neighbours.

    Returns
    -------
    ndarray, shape (n, n)
        S.
    """
    modes = len(parts[0].wavenumbers)
    waves = [np.arange(2 * modes * at, 2 * modes * (at + 1)) for at in range(len(parts))]
    travel = np.zeros((2 * modes * len(parts),) * 2, dtype=complex)
    for part, distance, left, right in zip(parts, distances, waves, waves[1:], strict=False):
        rightwards = part.travelled(distance)
        travel[np.ix_(right[:modes], left[modes:])] = rightwards
        travel[np.ix_(left[modes:], right[:modes])] = rightwards.T
    unit = np.eye(len(parts))
    elements = [
        Element(
            scattering=part.scattering, excitation=np.outer(part.excitation, volts), leaves=own, arrives=own
        )
        for part, own, volts in zip(parts, waves, unit, strict=True)
    ]
    arriving = solve_row(elements, travel).arriving
    detected = [part.detection @ arriving[own] for part, own in zip(parts, waves, strict=True)]
    return np.diag([part.admittance for part in parts]) + np.array(detected)


def _on_level(
    stator: Stator, transducer: Transducer, frequency: float, resolution: Resolution, every_mode: bool
) -> PMatrix:
    """P-matrix on one discretisation of a lone transducer between absorbing ends."""

    def chosen(modes: GuidedModes) -> np.ndarray:
        return modes.propagating if every_mode else modes.rayleigh

    fields = solve_ports(
        stator,
        (transducer,),
        frequency=frequency,
        resolution=resolution,
        solve=lambda network, _: (network, network.solve(chosen(network.modes))),
    )
    waves = waves_of(
        fields.modes, chosen(fields.modes), fields.section.solid.stress_unit * transducer.aperture
    )
    port = bool(fields.names)
    return of_segments(
        fields.segments,
        waves,
        length=fields.network.scatterers[0].piece.width,
        received=fields.received[0] if port else None,
        admittance=complex(fields.admittances[0, 0]) if port else 0j,
    )


def of_segments(
    segments: tuple[tuple[SegmentWaves, ...], ...],
    waves: "ScaledWaves",
    *,
    length: float,
    received: np.ndarray | None = None,
    admittance: complex = 0j,
) -> PMatrix:
    """P-matrix of a row between endless segments, by the amplitudes in them for a voltage and for arriving modes.

    ``length`` in length units; ``received``: current per arriving mode, A, of a row with a port; ``admittance`` in S.
    """
    modes, m = waves.section_modes, len(waves.modes)
    leaving = waves.leaving(segments)
    excitation = np.zeros(2 * m) if received is None else leaving[:, 0]
    return PMatrix(
        frequency=modes.frequency,
        wavenumbers=modes.wavenumbers[waves.modes] / modes.section.length_unit,
        mixture=waves.right,
        surface_motion=abs(modes.section.surface_rows @ modes.right[:, waves.modes] @ waves.right)[1],
        scattering=leaving[:, -2 * m :] @ waves.arriving,
        excitation=excitation,
        detection=np.zeros(2 * m) if received is None else received @ waves.arriving,
        admittance=admittance,
        length=length * modes.section.length_unit,
        relative_error=np.nan,
    )


@dataclass(frozen=True, kw_only=True)
class ScaledWaves:
    """Waves of amplitude 1 (|a|^2 / 2 their power) as sums of modes of a section.

    Attributes
    ----------
    section_modes : GuidedModes
    modes : ndarray of int
        Those that the waves are made of.
    right, left : ndarray, shape (modes, waves)
        Going right and going left, in columns.
    """

    section_modes: GuidedModes
    modes: np.ndarray
    right: np.ndarray
    left: np.ndarray

    @property
    def arriving(self) -> np.ndarray:
        """Amplitudes of the modes that arrive from the left, then from the right, for unit waves."""
        return _block_diagonal(self.right, self.left)

    def leaving(self, segments: tuple[tuple[SegmentWaves, ...], ...]) -> np.ndarray:
        """Waves that leave a row to the left, then to the right, by excitation."""
        amplitudes = [segments[0][-1].left[self.modes], segments[-1][0].right[self.modes]]
        return np.linalg.solve(_block_diagonal(self.left, self.right), np.concatenate(amplitudes))


def _block_diagonal(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    nothing = np.zeros((len(first), second.shape[1]))
    return np.block([[first, nothing], [nothing.T, second]])


def waves_of(modes: GuidedModes, chosen: np.ndarray, per_area: float) -> ScaledWaves:
    """Return the waves of amplitude 1 that some modes make."""
    omega = 2 * np.pi * modes.frequency
    shape, backward, flux, backward_flux = (
        each[:, chosen] for each in (modes.right, modes.left, modes.right_flux, modes.left_flux)
    )
    right = np.diag(np.sqrt(0.5 / (power(shape, flux, modes.frequency) * per_area))).astype(complex)
    one = np.flatnonzero(abs(modes.wavenumbers[chosen] / modes.wavenumbers[modes.rayleigh[0]] - 1) < ONE_WAVE)
    if len(one) > 1:
        crossed = shape[:, one].conj().T @ flux[:, one]
        carried = 0.5j * omega * per_area * (crossed - crossed.conj().T)  # Hermitian: 2 W of any sum of them
        orthonormal = np.linalg.inv(np.linalg.cholesky(carried)).conj().T
        top = (modes.section.surface_rows @ shape[:, one])[1]
        turn, _ = np.linalg.qr((top @ orthonormal).conj()[:, None], mode="complete")
        right[np.ix_(one, one)] = orthonormal @ turn

    def moved(shapes: np.ndarray, mixture: np.ndarray) -> np.ndarray:
        """u_z of every wave on the upper face; on the lower one of the waves that do not move the upper."""
        both = modes.section.full.on_nodes(modes.section.lift(shapes))[..., FIELD_COLUMN["uz"]]
        top, bottom = (modes.section.surface_rows @ shapes)[1] @ mixture, both[:, 0] @ mixture
        top[one[1:]] = bottom[one[1:]]
        return top

    right = right * np.exp(-1j * np.angle(moved(shape, right)))
    products = 0.5j * omega * per_area * (backward.T @ flux - backward_flux.T @ shape) @ right
    left = np.linalg.inv(products).T
    # With loss the scale is shared between both, so that a reflection is the ratio of two equal waves' motion.
    apart = moved(backward, left) / moved(shape, right)
    share = np.sqrt(np.where(apart.real < 0, -apart, apart))
    return ScaledWaves(section_modes=modes, modes=chosen, right=right * share, left=left / share)


def _difference(fine: PMatrix, coarse: PMatrix) -> tuple[float]:
    if len(fine.wavenumbers) != len(coarse.wavenumbers):
        return (1.0,)
    apart = [abs(fine.scattering - coarse.scattering).max()]
    for each in ("excitation", "admittance"):
        size = np.max(abs(getattr(fine, each)))
        if size > 0:
            apart.append(np.max(abs(getattr(fine, each) - getattr(coarse, each))) / size)
    return (float(max(apart)),)
