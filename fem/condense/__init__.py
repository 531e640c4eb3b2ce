"""From columns of elements under fingers, or a mesh, to a piece of the stator: condensation, join, mirror, double.

Input: a section and the transducer's fingers, or a mesh.  Output: a `fem.condense.cascade_piece.Piece`, a matrix
between two lines and the ports (the potentials of electrodes), with the way back to every interior unknown.

The condition of every electrode - open, short, grounded, loaded - is set in `fem.condense.electrode_conditions`.
"""
