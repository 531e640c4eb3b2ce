"""Answers with an error estimate: one frequency, a band of frequencies, a burst, the free wave.

Input: the stator, its transducers and a tolerance.  Output: a result of `fem.results`.
"""
