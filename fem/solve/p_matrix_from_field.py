"""P-matrix of a transducer or of meshed pieces from their field: incident and outgoing waves, voltage and current.

The transducer stands alone between uniform semi-infinite segments.  For waves of amplitude a incident on the outer
edges of its outer gaps and a voltage V, the outgoing waves b and the current I into it are

    b = S a + p V,    I = -2 p^T a + Y V,                                                                       (1)

the P-matrix of Tobolka (IEEE Ultrasonics Symp. 1979, 676) in the form of Morgan (*Surface Acoustic Wave Filters*, 2nd
ed., 2007, appendix D): amplitudes are such that a wave carries the power |a|^2 / 2, peak values.  Either all
propagating modes are kept or only those of the surface wave; bulk waves are then left out, as in coupled-mode (COM)
theory.  Decaying modes are left out in both cases, the near field of the fingers included.

Waves are scaled by the reciprocity of the field,

    i omega (l_i^T F_rj - F_li^T r_j) = 2 delta_ij per aperture,                                                (2)

with the shapes r to the right and l to the left and their fluxes F, so that S is symmetric with losses too.  In a thick
plate the surface waves of both faces have equal wavenumbers up to rounding, and the eigensolver may return any two
combinations of them.  The waves used here are the combinations of which only the first moves the upper surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from fem.block_matrix import block_diagonal
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import refine_stator
from fem.discretize.section import FIELD_COLUMN
from fem.exceptions import refuse_above
from fem.geometry import Stator, Transducer
from fem.threads import one_blas_thread
from fem.waveguide.cascade_system import Element, Travel, solve_cascade
from fem.waveguide.guided_modes import GuidedModes, power
from fem.waveguide.port_fields import stator_cascade
from fem.waveguide.scattering_network import SegmentWaves
from fem.waveguide.surface_modes import ONE_WAVE


@dataclass(frozen=True, kw_only=True)
class PMatrix:
    """P-matrix of a transducer, or of meshed pieces, at one frequency.

    Attributes
    ----------
    frequency : float
        Hz.
    wavenumbers : ndarray, shape (modes,)
        Of the modes travelling to the right on the bare surface, rad/m.
    mixture : ndarray, shape (modes, modes)
        The waves, in columns, as sums of modes; diagonal except for the two modes of equal faces.
    surface_motion : ndarray, shape (modes,)
        |u_z| of a wave of amplitude 1 at the bare surface, m / W^1/2.
    scattering : ndarray, shape (2 modes, 2 modes)
        S: waves at the left edge first, then those at the right edge; electrodes short-circuited.
    excitation, detection : ndarray, shape (2 modes,)
        p in W^1/2 per V, and -2 p^T, computed independently.
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
        """Propagation over a distance in m: waves to the right, (modes, modes); its transpose for waves to the left."""
        return np.linalg.solve(self.mixture, np.exp(-1j * self.wavenumbers * distance)[:, None] * self.mixture)


@one_blas_thread
def p_matrix(stator: Stator, transducer: Transducer, *, frequency: float, tolerance: float) -> PMatrix:
    """P-matrix of a transducer on a stator's section, for the surface wave.

    Parameters
    ----------
    stator : Stator
        Its length and ends are ignored.
    transducer : Transducer
        Its position is ignored.
    frequency : float
        Hz.
    tolerance : float
        Of S and, relative, of p and Y.

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
    >>> transducer = Transducer(name="t", center=0.5, finger_pairs=2, period=1e-3, metallisation=0.5, aperture=9e-3)
    >>> p = p_matrix(stator, transducer, frequency=2.2e6, tolerance=0.3)
    >>> bool(abs(p.detection + 2 * p.excitation).max() < 1e-9 * abs(p.excitation).max())
    True
    """
    length = (len(transducer.signs) + 4) * transducer.pitch
    alone = replace(stator, length=length, ends="absorbing", pieces=())
    centred = replace(transducer, center=length / 2, termination="open")

    def at_level(resolution: Resolution) -> PMatrix:
        return p_matrix_on_level(alone, centred, frequency, resolution)

    refined = refine_stator(stator, at_level, differences=matrix_difference, tolerance=tolerance)
    result = replace(refined.answer, relative_error=refined.errors[0])
    refuse_above(result.relative_error, tolerance, "the P-matrix is", reached=result)
    return result


def cascade_admittance(parts: Sequence[PMatrix], distances: Sequence[float]) -> np.ndarray:
    """Admittance matrix of transducers and pieces in cascade, coupled by the modes of their P-matrices alone.

    Parameters
    ----------
    parts : sequence of PMatrix
        From left to right, all with the same modes.  No wave returns from beyond the outermost parts.
    distances : sequence of float
        m of bare surface between the edges of neighbours.

    Returns
    -------
    ndarray, shape (n, n)
        S.
    """
    modes = len(parts[0].wavenumbers)
    waves = [np.arange(2 * modes * at, 2 * modes * (at + 1)) for at in range(len(parts))]
    travel = []
    for part, distance, left, right in zip(parts, distances, waves, waves[1:], strict=False):
        rightwards = part.travelled(distance)
        travel += [
            Travel(right[None, :modes], left[None, modes:], rightwards[None]),
            Travel(left[None, modes:], right[None, :modes], rightwards.T[None]),
        ]
    unit = np.eye(len(parts))
    elements = [
        Element(scattering=part.scattering, excitation=np.outer(part.excitation, volts), leaves=own, arrives=own)
        for part, own, volts in zip(parts, waves, unit, strict=True)
    ]
    arriving = solve_cascade(elements, travel).arriving
    detected = [part.detection @ arriving[own] for part, own in zip(parts, waves, strict=True)]
    return np.diag([part.admittance for part in parts]) + np.array(detected)


def p_matrix_on_level(
    stator: Stator, transducer: Transducer, frequency: float, resolution: Resolution, *, every_mode: bool = False
) -> PMatrix:
    """P-matrix on one discretisation of a lone transducer between absorbing ends.

    ``every_mode``: for all propagating modes, with which power is conserved, instead of the surface wave's.
    """
    cascade = stator_cascade(stator, (transducer,), frequency=frequency, resolution=resolution)
    port_modes = cascade.modes.propagating if every_mode else cascade.modes.rayleigh
    fields = cascade.solved(cascade.network.solve(port_modes))
    waves = waves_of(cascade.modes, port_modes, cascade.section.solid.stress_unit * transducer.aperture)
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
    """P-matrix of a cascade between semi-infinite segments, from their amplitudes for a voltage and incident modes.

    ``length`` in length units; ``received``: current per incident mode, A, of a port; ``admittance`` in S.
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
    """Waves of amplitude 1 (power |a|^2 / 2) as sums of modes of a section.

    Attributes
    ----------
    section_modes : GuidedModes
    modes : ndarray of int
        Indices of the modes in the sums.
    right, left : ndarray, shape (modes, waves)
        Waves travelling to the right and to the left, in columns.
    """

    section_modes: GuidedModes
    modes: np.ndarray
    right: np.ndarray
    left: np.ndarray

    @property
    def arriving(self) -> np.ndarray:
        """Amplitudes of the modes incident from the left, then from the right, for unit waves."""
        return block_diagonal(self.right, self.left)

    def leaving(self, segments: tuple[tuple[SegmentWaves, ...], ...]) -> np.ndarray:
        """Waves that leave a cascade to the left, then to the right, by excitation."""
        amplitudes = [segments[0][-1].left[self.modes], segments[-1][0].right[self.modes]]
        return np.linalg.solve(block_diagonal(self.left, self.right), np.concatenate(amplitudes))


def waves_of(modes: GuidedModes, indices: np.ndarray, per_area: float) -> ScaledWaves:
    """Waves of amplitude 1 made of the modes with these indices; ``per_area``: unit of stress times aperture, N/m."""
    omega = 2 * np.pi * modes.frequency
    shape, backward, flux, backward_flux = (
        each[:, indices] for each in (modes.right, modes.left, modes.right_flux, modes.left_flux)
    )
    right = np.diag(np.sqrt(0.5 / (power(shape, flux, modes.frequency) * per_area))).astype(complex)
    k_ratio = modes.wavenumbers[indices] / modes.wavenumbers[modes.rayleigh[0]]
    both_faces = np.flatnonzero(abs(k_ratio - 1) < ONE_WAVE)
    if len(both_faces) > 1:
        # Orthonormal in the power (Hermitian matrix of 2 W), then turned so that only the first moves the upper face
        mutual = shape[:, both_faces].conj().T @ flux[:, both_faces]
        power_matrix = 0.5j * omega * per_area * (mutual - mutual.conj().T)
        orthonormal = np.linalg.inv(np.linalg.cholesky(power_matrix)).conj().T
        top = (modes.section.surface_rows @ shape[:, both_faces])[1]
        rotation, _ = np.linalg.qr((top @ orthonormal).conj()[:, None], mode="complete")
        right[np.ix_(both_faces, both_faces)] = orthonormal @ rotation

    def face_motion(shapes: np.ndarray, mixture: np.ndarray) -> np.ndarray:
        """u_z of each wave at the upper face; at the lower one for the wave that leaves the upper at rest."""
        upper = (modes.section.surface_rows @ shapes)[1] @ mixture
        if len(both_faces) > 1:
            nodal = modes.section.full.on_nodes(modes.section.lift(shapes))
            lower = nodal[:, 0, FIELD_COLUMN["uz"]] @ mixture
            upper[both_faces[1:]] = lower[both_faces[1:]]
        return upper

    right = right * np.exp(-1j * np.angle(face_motion(shape, right)))
    # equation (2) determines the waves to the left
    products = 0.5j * omega * per_area * (backward.T @ flux - backward_flux.T @ shape) @ right
    left = np.linalg.inv(products).T
    # With loss both directions share the scale, so that a reflection is the ratio of the motions of two equal waves.
    ratio = face_motion(backward, left) / face_motion(shape, right)
    share = np.sqrt(np.where(ratio.real < 0, -ratio, ratio))
    return ScaledWaves(section_modes=modes, modes=indices, right=right * share, left=left / share)


def matrix_difference(fine: PMatrix, coarse: PMatrix) -> tuple[float]:
    """Return the largest relative difference of two P-matrices in a tuple, 1 where they have other modes."""
    if len(fine.wavenumbers) != len(coarse.wavenumbers):
        return (1.0,)
    differences = [abs(fine.scattering - coarse.scattering).max()]
    for name in ("excitation", "admittance"):
        size = np.max(abs(getattr(fine, name)))
        if size > 0:
            differences.append(np.max(abs(getattr(fine, name) - getattr(coarse, name))) / size)
    return (float(max(differences)),)
