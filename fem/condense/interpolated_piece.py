"""A meshed piece over a band of frequencies: rational interpolation of its condensed matrix.

Let s = omega^2, A(s) = K - s M the matrix of the piece, and X_j the field in it at the node s_j for unit values on its
lines and ports.  No load acts inside the piece, so that A(s_j) X_j vanishes there and S_j = X_j^T A(s_j) X_j is the
condensed matrix.  The projections of K and M on all X_j follow from the condensed matrices (Loewner matrices: Mayo and
Antoulas, Linear Algebra Appl. 425 (2007) 634, equations 14 and 15, here symmetric).  On the diagonal the divided
difference is a derivative:

    X_i^T M X_j = (S_i - S_j) / (s_j - s_i),    X_j^T M X_j = -dS/ds (s_j),    X_i^T K X_j = S_i + s_i X_i^T M X_j.  (1)

The differences X_j - X_m are fields that vanish on the lines and ports.  Their elimination at any s gives a rational
function that has the values and derivatives of S at all nodes, and the resonances of the piece with clamped lines.  The
field in the piece at s is the same combination sum_j X_j w_j of the nodes' fields.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fem.condense.cascade_piece import Port, RecoveredField
from fem.condense.condensed_mesh import Assembly, MeshedPiece

# Singular values of M of the clamped fields below this share of the largest are rounding of the divided differences.
ROUNDING = 1e-8


@dataclass(frozen=True, kw_only=True, eq=False)
class ReducedPiece:
    """A meshed piece on reduced lines at one frequency (`fem.condense.cascade_piece.Piece`)."""

    size: int
    matrix: np.ndarray = field(repr=False)
    width: float
    ports: tuple[Port, ...]
    floating_potential: bool
    grounded: bool  # as in `fem.condense.condensed_mesh.MeshedPiece`
    unknowns: int  # of the mesh
    recover: Callable[[np.ndarray], RecoveredField] = field(repr=False)


@dataclass(frozen=True, kw_only=True, eq=False)
class RationalPiece:
    """A meshed piece on reduced lines at any frequency of a band.

    Attributes
    ----------
    assembly : Assembly
    unknowns : int
        Unknowns of the mesh.
    frame : ndarray, shape (lines and ports, reduced lines and ports)
        Matrix from reduced to full lines, and ports.
    size : int
        Unknowns of a reduced line.
    stiffness, inertia : ndarray
        K and M over reduced lines and ports, then clamped fields; M in s^2/rad^2.
    nodes : ndarray, shape (nodes,)
        Frequencies in Hz at which the piece was condensed.
    basis : ndarray, shape (nodes, reduced lines and ports, columns of K)
        The fields of K and M as combinations of the nodes' fields X_j.
    """

    assembly: Assembly
    unknowns: int
    frame: np.ndarray = field(repr=False)
    size: int
    stiffness: np.ndarray = field(repr=False)
    inertia: np.ndarray = field(repr=False)
    nodes: np.ndarray = field(repr=False)
    basis: np.ndarray = field(repr=False)

    @property
    def resonances(self) -> np.ndarray:
        """Omega^2 of the resonances with lines and ports at zero, as far as the nodes show them, (rad/s)^2, complex."""
        from scipy.linalg import eigvals  # see `fem.block_matrix`

        outer = self.frame.shape[1]  # number of lines' unknowns and ports
        return eigvals(self.stiffness[outer:, outer:], self.inertia[outer:, outer:])

    def _eliminated(self, frequency: float) -> tuple[np.ndarray, np.ndarray]:
        """Condensed matrix at a frequency in Hz, and the clamped fields for unit values on lines and ports."""
        system = self.stiffness - (2 * np.pi * frequency) ** 2 * self.inertia
        outer = self.frame.shape[1]
        coupling = system[outer:, :outer]
        clamped = -np.linalg.solve(system[outer:, outer:], coupling)
        matrix = system[:outer, :outer] + coupling.T @ clamped
        return 0.5 * (matrix + matrix.T), clamped

    def weights(self, frequency: float) -> np.ndarray:
        """Weights w_j of the nodes' fields X_j for unit values on lines and ports, shape (nodes, outer, outer)."""
        _, clamped = self._eliminated(frequency)
        return self.basis @ np.concatenate([np.eye(self.frame.shape[1]), clamped])

    def at(self, frequency: float, recover: Callable[[np.ndarray], RecoveredField] | None = None) -> ReducedPiece:
        """Piece at a frequency in Hz.

        ``recover`` returns the field inside for values on reduced lines and ports; without it, the full piece is
        condensed for that.
        """
        low, high = self.assembly.piece.extent
        return ReducedPiece(
            size=self.size,
            matrix=self._eliminated(frequency)[0],
            width=(high - low) / self.assembly.space.unit,
            ports=self.assembly.ports,
            floating_potential=self.assembly.floating_potential,
            grounded=self.assembly.grounded,
            unknowns=self.unknowns,
            recover=recover or (lambda sides: self.assembly.condensed(frequency).recover(self.frame @ sides)),
        )


@dataclass(frozen=True, kw_only=True, eq=False)
class PieceSample:
    """A condensed piece at one node of the band: its matrix S on reduced lines, and -dS/ds."""

    frequency: float  # Hz
    value: np.ndarray = field(repr=False)
    inertia: np.ndarray = field(repr=False)

    @classmethod
    def of(cls, piece: MeshedPiece, frame: np.ndarray) -> "PieceSample":
        """Sample of a piece, with a frame of reduced lines."""
        return cls(frequency=piece.frequency, value=frame.T @ piece.matrix @ frame, inertia=piece.inertia(frame))


def rational_piece(piece: MeshedPiece, frame: np.ndarray, size: int, samples: list[PieceSample]) -> RationalPiece:
    """Interpolate a piece between samples by equations (1); ``piece``: condensed at any frequency."""
    squares = np.array([(2 * np.pi * each.frequency) ** 2 for each in samples])
    count, outer = len(samples), frame.shape[1]
    inertia = np.empty((count, outer, count, outer), dtype=np.result_type(*(each.value for each in samples)))
    stiffness = np.empty_like(inertia)
    for i, one in enumerate(samples):
        for j, other in enumerate(samples):
            quotient = one.inertia if i == j else (one.value - other.value) / (squares[j] - squares[i])
            inertia[i, :, j] = quotient
            stiffness[i, :, j] = 0.5 * (one.value + other.value + (squares[i] + squares[j]) * quotient)
    # New basis: the middle node's fields, and the other nodes' differences from them, which vanish on the lines;
    # linearly dependent differences are dropped.
    middle = count // 2
    change = np.eye(count)[[middle, *(j for j in range(count) if j != middle)]]
    change[1:, middle] = -1.0
    # columns of `first` (middle node) and of `clamped` (differences): coefficients of the fields X_j, node after node
    first, clamped = np.split(np.kron(change, np.eye(outer)).T, [outer], axis=1)
    flat = inertia.reshape(count * outer, -1)
    clamped_inertia = clamped.T @ flat @ clamped
    # unit diagonal before the singular values are compared, because nearby nodes give small differences
    scale = 1 / np.sqrt(abs(np.diag(clamped_inertia)) + np.finfo(float).tiny)
    _, values, right = np.linalg.svd(scale[:, None] * clamped_inertia * scale)
    independent = scale[:, None] * right.conj().T[:, values > ROUNDING * values.max(initial=0.0)]
    basis = np.hstack([first, clamped @ independent])
    return RationalPiece(
        assembly=piece.assembly,
        unknowns=piece.unknowns,
        frame=frame,
        size=size,
        stiffness=basis.T @ stiffness.reshape(count * outer, -1) @ basis,
        inertia=basis.T @ flat @ basis,
        nodes=np.array([each.frequency for each in samples]),
        basis=basis.reshape(count, outer, -1),
    )
