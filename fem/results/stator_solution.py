"""A driven stator on one discretisation: the ports' fields and the circuit that weighs them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fem.circuit import Circuit, Drive, solve_circuit
from fem.waveguide.port_fields import PortFields


@dataclass(frozen=True, kw_only=True)
class Solution:
    """Fields of the excitations, the voltages that a circuit sets and the forces: their product is the field."""

    fields: PortFields
    circuit: Circuit
    forces: np.ndarray | None = None  # N/m of each force; None if none act

    @cached_property
    def weights(self) -> np.ndarray:
        """Of each excitation of the fields: V, then N/m."""
        silent = np.zeros(self.fields.received.shape[1])
        return np.concatenate([self.circuit.voltages, silent if self.forces is None else self.forces])

    def sides(self, index: int) -> np.ndarray:
        """Unknowns of a scatterer's lines and ports, scaled, shape (2 n + ports,)."""
        return self.fields.sides[index] @ self.weights

    def incoming(self, index: int) -> np.ndarray:
        """Incident part of a scatterer's lines, scaled, shape (2 n,)."""
        return self.fields.incoming[index] @ self.weights


def driven_solution(fields: PortFields, drive: str | Drive | None, forces: np.ndarray | None = None) -> Solution:
    """Weigh the fields with the voltages that a circuit sets, or with forces and the voltages that these make.

    ``forces``: N/m of each; the source voltages of ``drive`` are then zero (`fem.circuit.solve_circuit`).
    """
    received = None if forces is None else fields.received @ forces
    circuit = solve_circuit(fields.admittances, fields.names, fields.transducers, drive, fields.frequency, received)
    return Solution(fields=fields, circuit=circuit, forces=forces)
