"""A driven stator on one discretisation: the ports' fields and the circuit that weighs them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.circuit import Circuit, Drive, receiving_circuit, solve_circuit
from fem.waveguide.port_fields import PortFields


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Fields of the excitations, the voltages that a circuit sets and the forces: their product is the field."""

    fields: PortFields
    circuit: Circuit
    forces: np.ndarray | None = None  # N/m of each force; none act if not given

    @cached_property
    def weights(self) -> np.ndarray:
        """Of each excitation of the fields: V, then N/m."""
        silent = np.zeros(self.fields.received.shape[1])
        return np.concatenate([self.circuit.voltages, silent if self.forces is None else self.forces])

    def sides(self, index: int) -> np.ndarray:
        """Lines and electrode potentials of a transducer, scaled, shape (2 n + 2,)."""
        return self.fields.sides[index] @ self.weights

    def incoming(self, index: int) -> np.ndarray:
        """Part of a transducer's lines that comes in, scaled, shape (2 n,)."""
        return self.fields.incoming[index] @ self.weights


def driven_solution(fields: PortFields, drive: str | Drive) -> Solution:
    """Weigh the ports' fields with the voltages of a circuit."""
    circuit = solve_circuit(fields.admittances, fields.names, fields.transducers, drive, fields.frequency)
    return Solution(fields=fields, circuit=circuit)


def forced_solution(fields: PortFields, forces: np.ndarray, drive: str | Drive | None = None) -> Solution:
    """Weigh the fields with forces (N/m) and with the voltages that they make across the terminations.

    ``drive``: as of `fem.circuit.receiving_circuit`.
    """
    circuit = receiving_circuit(
        fields.admittances, fields.names, fields.transducers, fields.received @ forces, fields.frequency, drive
    )
    return Solution(fields=fields, circuit=circuit, forces=forces)
