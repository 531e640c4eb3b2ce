"""Answers without a mesh: the half-space Rayleigh wave and the quasi-static estimate of a transducer.

Input: a rotated solid (and a transducer).  Output: velocities, K2, permittivity, conductance, against which the
discretised solutions are held.  Beside them the Hankel functions that a finite aperture takes.
"""
