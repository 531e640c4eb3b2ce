"""Results of a solution: surface motion, interior field, densities, power balance, files.

Input: a solution of the driven stator, or a free wave.  Output: arrays in SI units per volt of the source.
"""
