"""A model of few unknowns over a band of frequencies: interpolated superelements on a basis of the lines' fields.

Input: a band's problem on one discretisation, solved at a few nodes.  Output: a `ReducedModel` with fields per volt at
every port at any frequency of the band.
"""
