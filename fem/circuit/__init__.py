"""The circuit of a stator: sources, ladders, impedances, open and short electrodes at the ports of the admittances."""

from fem.circuit.ladder import Element, Ladder, best_match, carried
from fem.circuit.motional import MotionalModel, motional_model
from fem.circuit.ports import Circuit, Drive, SourcePowers, as_drive, matched_load, rectifier_resistance, solve_circuit
from fem.circuit.touchstone_file import touchstone

__all__ = [
    "Circuit",
    "Drive",
    "Element",
    "Ladder",
    "MotionalModel",
    "SourcePowers",
    "as_drive",
    "best_match",
    "carried",
    "matched_load",
    "motional_model",
    "rectifier_resistance",
    "solve_circuit",
    "touchstone",
]
