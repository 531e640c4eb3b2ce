"""The circuit of a stator: sources, ladders, impedances and terminations at the ports of its admittance matrix."""

from fem.circuit.ladder import Element, Ladder, best_match, carried
from fem.circuit.ports import Circuit, Drive, SourcePowers, as_drive, solve_circuit

__all__ = [
    "Circuit",
    "Drive",
    "Element",
    "Ladder",
    "SourcePowers",
    "as_drive",
    "best_match",
    "carried",
    "solve_circuit",
]
