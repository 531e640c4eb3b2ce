"""Electrical condition of electrodes: grounded or shorted, open or floating, loaded, connected to a source.

An electrode is equipotential, and its charge is minus the reaction of its potential, Q_f = -sum_j A_fj u_j, with A the
condensed matrix of the piece that it lies on.  The functions of this module set all conditions of the stator, except
in `tests/fem/direct.py`, the plain solver that the others are checked against:

| condition | of | equation | set by |
|---|---|---|---|
| equipotential | every electrode | phi = v at all its nodes | `equipotential`, `MeshElectrodes` |
| open (floating) | one finger or strip | Q_f = 0, v_f is eliminated | `open_circuit`, `MeshElectrodes` |
| grounded | one strip of a mesh | v_f = 0 | `MeshElectrodes` |
| terminals | the two electrodes of a transducer | Q_+ + Q_- = 0, v_+ - v_- = V | `transducer_ports`, `uncharged` |
| short, open, loaded | a transducer without a source | V = 0, I = 0, V + Z I = 0 | `terminated` |

A source of voltage S behind an impedance Z, V + Z I = S, is set in `fem.circuit.ports`, the only module in which
transducers are driven; the loads of a P-matrix, whose ports are waves too, in `fem.solve.p_matrix_from_field`.
"""

from collections.abc import Callable

import numpy as np

from fem.condense.cascade_piece import Port
from fem.discretize.quad_elements import QuadSpace
from fem.geometry import Transducer
from fem.mesh.mesh_piece import FLOATING, GROUNDED, MeshPiece
from fem.mesh.section_mesh import ELECTRODE


def equipotential(matrix: np.ndarray, nodes: np.ndarray, port: int) -> np.ndarray:
    """Tie potentials of nodes to that of an electrode: their rows and columns are added to its own and set to zero.

    ``nodes``, ``port``: numbers in the matrix of the nodes' potentials and of the electrode's.
    """
    matrix = matrix.copy()
    matrix[port] += matrix[nodes].sum(axis=0)
    matrix[nodes] = 0.0
    matrix[:, port] += matrix[:, nodes].sum(axis=1)
    matrix[:, nodes] = 0.0
    return matrix


def open_circuit(matrix: np.ndarray, port: int) -> tuple[np.ndarray, Callable[[np.ndarray], np.ndarray]]:
    """Eliminate the potential of an electrode without net charge.

    The charge of the electrode is minus the reaction A_f u of its row f.  It vanishes if its potential is

        v_f = -(sum over j != f of A_fj u_j) / A_ff.

    Parameters
    ----------
    matrix : ndarray
        A, over lines and ports.
    port : int
        f.

    Returns
    -------
    ndarray
        The matrix without v_f, whose row and column remain, with zeros.
    callable
        Returns the unknowns u with the potential v_f, for unknowns with any value instead of it.
    """
    by_others = -matrix[port] / matrix[port, port]
    by_others[port] = 0.0
    opened = matrix + np.outer(matrix[port], by_others)
    opened[port], opened[:, port] = 0.0, 0.0

    def with_potential(unknowns: np.ndarray) -> np.ndarray:
        potential = np.tensordot(by_others[None], unknowns, axes=1)
        return np.concatenate([unknowns[:port], potential, unknowns[port + 1 :]])

    return 0.5 * (opened + opened.T), with_potential


class MeshElectrodes:
    """Electrodes of a meshed piece: floating, grounded, or connected to a transducer.

    Attributes
    ----------
    held : list of ndarray
        Functions of the space whose potential is zero: those of grounded electrodes, and those inside the edges of the
        others, because the potential is constant there.
    tied : dict of int to ndarray
        Functions whose value is the potential of an electrode, by the number of that electrode.
    floating, connected : list of int
        Numbers of the electrodes without net charge, and of those connected to a transducer.
    ports : tuple of Port
        Of the connected electrodes.
    grounded : bool
        True if one at least is grounded.
    """

    def __init__(self, piece: MeshPiece, space: QuadSpace, names: tuple[str, ...]):
        electrodes = [name for name in piece.mesh.electrodes if "phi" in names]
        connections = [piece.connection(name) for name in electrodes]
        self.floating = [k for k, each in enumerate(connections) if each == FLOATING]
        self.connected = [k for k, each in enumerate(connections) if each not in (FLOATING, GROUNDED)]
        self.ports = tuple(Port(kind="voltage", name=connections[k]) for k in self.connected)
        self.grounded = GROUNDED in connections
        self.held: list[np.ndarray] = []
        self.tied: dict[int, np.ndarray] = {}
        for index, name in enumerate(electrodes):
            numbers = space.edge_numbers(space.mesh.lines[ELECTRODE + name])
            self.held.append(np.unique(numbers[:, 2:]))
            vertices = np.unique(numbers[:, :2])
            if connections[index] == GROUNDED:
                self.held.append(vertices)
            else:
                self.tied[index] = vertices


def charged(signs: str) -> np.ndarray:
    """True for the fingers "+" and "-" of a pattern, which an electrode connects, shape (fingers,)."""
    return np.array([sign in "+-" for sign in signs], dtype=bool)


def is_port(transducer: Transducer) -> bool:
    """True if a transducer has both electrodes, between which a voltage can stand."""
    return {"+", "-"} <= set(transducer.signs)


def transducer_ports(transducer: Transducer, mean: bool) -> tuple[Port, ...]:
    """Ports of a transducer: the voltage of two electrodes, and their mean potential unless it is arbitrary."""
    own = (Port(kind="voltage", name=transducer.name),) if is_port(transducer) else ()
    return (*own, Port(kind="mean", name=transducer.name)) if mean and charged(transducer.signs).any() else own


def electrode_potentials(transducer: Transducer, ports: tuple[Port, ...]) -> np.ndarray:
    """Potentials of a transducer's two electrodes for a unit at each of its ports, shape (2, ports)."""
    exists = [float(sign in transducer.signs) for sign in "+-"]
    columns = [(0.5, -0.5) if port.kind == "voltage" else exists for port in ports]
    return np.array(columns).reshape(-1, 2).T


def uncharged(charges: np.ndarray, voltage: np.ndarray) -> np.ndarray:
    """Weights of the excitations for a unit of each voltage, force and wave from outside, with no net charge.

    ``charges``: of the ports, means included, by unit potentials of these, then by forces and waves from outside.
    """
    count, excitations = charges.shape
    independent = np.append(voltage, np.ones(excitations - count, dtype=bool))  # the others are mean potentials
    out = np.eye(excitations, dtype=complex)[:, independent]
    if not voltage.all():
        net_charges = charges[~voltage] / abs(np.diag(charges))[~voltage, None]  # scaled, one row per mean
        out[~independent] = -np.linalg.solve(net_charges[:, ~independent], net_charges[:, independent])
    return out


def terminated(termination: str | complex, admittance: complex) -> tuple[complex, complex]:
    """Return a and b of the condition a V + b I = 0 of a transducer without a source: open, short or loaded.

    Parameters
    ----------
    termination : "open", "short" or complex
        As of `Transducer`; the impedance Z of a load in ohm.
    admittance : complex
        Of the transducer while all others are shorted, S; it scales the condition of an open one.
    """
    if termination == "open":
        return 0.0, 1 / abs(admittance)
    return 1.0, 0.0 if termination == "short" else complex(termination)
