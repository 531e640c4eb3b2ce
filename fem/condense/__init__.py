"""From a transducer's columns of elements to one superelement: static condensation, join, mirror, double.

Input: a section and the transducer's fingers.  Output: a matrix between the two end lines of the transducer and the
potentials of its two electrodes, with the way back to every interior unknown.
"""
