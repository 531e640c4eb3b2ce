"""From a transducer's columns of elements, or a mesh, to a piece of the row: static condensation, join, mirror, double.

Input: a section and the transducer's fingers, or a mesh.  Output: a `fem.condense.piece.Piece`, a matrix between two
lines and the ports (the potentials of electrodes), with the way back to every interior unknown.

Open fingers ("o" in a pattern) are eliminated in `fem.condense.join.open_circuited`; whether the electrodes of a whole
transducer are open or short is its termination, which `fem.circuit.ports` sets.
"""
