"""A meshed piece over a band of frequencies: the nodes of its interpolation, and the error of the interpolation.

A piece may resonate in the band, so that the number of nodes is not known beforehand.  The interpolation through all
nodes (`fem.condense.interpolated_piece`) is compared with two others: one omits the first node, which spoils the low
end of the band, and one the last but one, which spoils the high end.  At each frequency the smaller of the two changes
therefore counts as the error.  A node is added at the frequency where it is largest.
"""

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fem.block_matrix import block_diagonal
from fem.condense.cascade_piece import Blocks
from fem.condense.condensed_mesh import MeshedPiece, MeshField
from fem.condense.interpolated_piece import PieceSample, RationalPiece, ReducedPiece, rational_piece
from fem.reduce.basis import ReducedSection
from fem.results.stator_solution import Solution
from fem.waveguide.end_conditions import Wall
from fem.waveguide.guided_modes import guided_modes
from fem.waveguide.scattering_network import Scatterer

# Frequencies at which interpolations are compared, and largest number of nodes: of a piece in a cascade, and of a mesh
# that is the whole stator and has all of its resonances
CASCADE_CHECKS, MAX_CASCADE_NODES = 21, 9
WHOLE_CHECKS, MAX_WHOLE_NODES = 81, 30


def interpolated(
    pieces: list[MeshedPiece],
    frame: np.ndarray,
    size: int,
    *,
    answers: Callable[[RationalPiece, float], np.ndarray],
    frequencies: np.ndarray,
    tolerance: float,
    max_nodes: int,
) -> tuple[RationalPiece, float]:
    """Interpolate a piece, with nodes added until one node fewer changes the answers by less than a tolerance.

    Parameters
    ----------
    pieces : list of MeshedPiece
        The condensed piece at the first nodes; those at further nodes are appended.
    frame : ndarray, shape (lines and ports, reduced lines and ports)
        Matrix from reduced to full lines, and ports.
    size : int
        Unknowns of a reduced line.
    answers : callable
        Returns the answers of an interpolated piece at a frequency in Hz, shape (m, columns).
    frequencies : ndarray
        Hz: where the answers are compared and where nodes may be added.
    tolerance : float
        Relative.
    max_nodes : int
        No node is added beyond this number.

    Returns
    -------
    RationalPiece
    float
        Largest relative change of a column of the answers when one node is left out.
    """
    samples = [PieceSample.of(each, frame) for each in pieces]
    while True:
        order = np.argsort([each.frequency for each in pieces])
        pieces[:] = [pieces[k] for k in order]
        samples = [samples[k] for k in order]
        all_nodes = rational_piece(pieces[0], frame, size, samples)
        # two comparisons: without the first node, and without the last but one
        fewer = [
            rational_piece(pieces[0], frame, size, [*samples[:omitted], *samples[omitted + 1 :]])
            for omitted in {0, len(samples) - 2}
        ]
        changes = []  # at each frequency, the smaller of the two changes
        for frequency in frequencies:
            if frequency in all_nodes.nodes:
                changes.append(0.0)
                continue
            reference = answers(all_nodes, frequency)
            norm = np.linalg.norm(reference, axis=0)
            relative = [np.linalg.norm(answers(each, frequency) - reference, axis=0) / norm for each in fewer]
            changes.append(np.min(np.max(relative, axis=1)))
        error = float(max(changes))
        if error <= tolerance or len(samples) >= max_nodes:
            return all_nodes, error
        pieces.append(pieces[0].assembly.condensed(float(frequencies[int(np.argmax(changes))])))
        samples.append(PieceSample.of(pieces[-1], frame))


def piece_of_cascade(
    pieces: list[MeshedPiece],
    section: ReducedSection,
    solutions: list[Solution],
    limits: tuple[float, float],
    tolerance: float,
) -> tuple[RationalPiece, float]:
    """A piece between uniform segments, or an end, on reduced lines over a band, and its error.

    The answers are the fields on its lines: those of the ``solutions`` for a piece between segments, the reflection of
    all propagating modes for an end.
    """
    assembly, basis = pieces[0].assembly, section.basis
    lines, ports = len(assembly.lines), len(assembly.ports)
    frame = block_diagonal(*[basis] * lines, np.eye(ports))
    modes = guided_modes(section, sum(limits) / 2)
    incoming = [_incident(each, pieces[0], basis) for each in solutions if lines == 2]

    def fields_on_lines(piece: RationalPiece, frequency: float) -> np.ndarray:
        at = piece.at(frequency)
        if lines == 1:
            wall = Wall(matrix=at.matrix, recover=at.recover, floating_potential=at.floating_potential)
            return wall.reflection(modes, 0 if "right" in assembly.sides else 1, modes.propagating)
        own = Scatterer(piece=at, modes=modes, potentials=np.zeros((ports, 0)))
        return np.hstack([own.sides(*each) for each in incoming])

    return interpolated(
        pieces,
        frame,
        section.size,
        answers=fields_on_lines,
        frequencies=np.linspace(*limits, CASCADE_CHECKS),
        tolerance=tolerance,
        max_nodes=MAX_CASCADE_NODES,
    )


def _incident(solution: Solution, sample: MeshedPiece, basis: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Incident fields on reduced lines and potentials of the ports, by excitation, at all occurrences of a piece.

    ``sample``: the piece, condensed at any frequency.
    """
    fields, lines, ports = solution.fields, [], []
    for index, scatterer in enumerate(fields.network.scatterers):
        piece = scatterer.piece
        if isinstance(piece, MeshedPiece) and piece.assembly is sample.assembly:
            at, volt = Blocks(len(basis)), fields.section.solid.potential_unit
            incident = volt * fields.incoming[index]
            lines.append(np.concatenate([basis.T @ incident[at.left], basis.T @ incident[at.right]]))
            ports.append(volt * fields.sides[index][at.ports])
    return np.hstack(lines), np.hstack(ports)


@dataclass(frozen=True, kw_only=True, eq=False)
class WholePiece:
    """A mesh that is the whole stator, over a band of frequencies."""

    rational: RationalPiece
    # shape (nodes, functions, ports): skeleton of the field for unit potentials (`MeshedPiece.skeleton`)
    skeletons: np.ndarray = field(repr=False)

    def at(self, frequency: float) -> ReducedPiece:
        """The piece at a frequency in Hz.

        Its skeleton is interpolated too; the interior of its elements is condensed at that frequency on first use.
        """
        assembly, weights = self.rational.assembly, self.rational.weights(frequency)

        def recover(sides: np.ndarray) -> MeshField:
            skeleton = sum(node @ own for node, own in zip(self.skeletons, weights @ sides, strict=True))
            return MeshField(assembly=assembly, skeleton=skeleton, condense=lambda: assembly.condensed(frequency))

        return self.rational.at(frequency, recover)


def piece_of_whole_stator(
    pieces: list[MeshedPiece],
    potentials: np.ndarray,
    positions: np.ndarray,
    limits: tuple[float, float],
    tolerance: float,
) -> tuple[WholePiece, float]:
    """A mesh that is the whole stator over a band, and its error, which `MAX_WHOLE_NODES` may leave too large.

    The answers are the motion at ``positions`` (length units from the left end) and the reactions of the ports, for
    each column of their ``potentials``.
    """
    unit = np.eye(len(pieces[0].ports))
    motions: dict[float, np.ndarray] = {}  # by frequency of the node: for unit potentials, (2 positions, ports)

    def motion_and_reactions(rational: RationalPiece, frequency: float) -> np.ndarray:
        for piece in pieces:
            if piece.frequency not in motions:
                columns = [piece.recover(potential).motion(positions).ravel() for potential in unit]
                motions[piece.frequency] = np.stack(columns, axis=1)
        at_nodes = np.stack([motions[node] for node in rational.nodes])
        motion = np.sum(at_nodes @ rational.weights(frequency) @ potentials, axis=0)
        reactions = rational.at(frequency).matrix @ potentials
        size = max(len(motion), len(reactions))
        return np.hstack([np.pad(each, ((0, size - len(each)), (0, 0))) for each in (motion, reactions)])

    rational, error = interpolated(
        pieces,
        unit,
        0,
        answers=motion_and_reactions,
        frequencies=np.linspace(*limits, WHOLE_CHECKS),
        tolerance=tolerance,
        max_nodes=MAX_WHOLE_NODES,
    )
    return WholePiece(rational=rational, skeletons=np.stack([each.skeleton(unit) for each in pieces])), error
