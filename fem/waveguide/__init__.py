"""From guided modes to the fields of the whole cascade: uniform segments, ends, line forces, network of pieces.

Input: a section and the pieces.  Output: fields and amplitudes for a unit at each port, and the charges; for an endless
grating its stop bands.
"""
