"""From the stator's geometry to elements and matrices through its depth.

Input: a `Stator` and a `Resolution`.  Output: the `Section`, whose matrices K2, K1, K0 and M describe a uniform
segment, and the element matrices of the weak form.
"""
