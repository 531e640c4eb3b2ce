"""Averaged equilibria: sliders that are heavy on the wave's time scale, from the cycle means of their contacts.

Balls: `equilibrium` (one problem; `sweep_kernel` solves many), and `event_cycle` for laws without closed cycle means.
Pillars: `pillar_equilibrium`, with tilts and the wave that the pillars load.
"""
