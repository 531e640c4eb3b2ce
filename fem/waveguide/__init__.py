"""From guided modes to the fields of the whole row: uniform segments, ends, network of superelements.

Input: a section and the transducers' superelements.  Output: the fields for unit potential at each port, and the
charges; for an endless grating its stop bands and the periodic-cell parameters.
"""
