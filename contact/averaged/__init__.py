"""Averaged equilibria: sliders that are heavy on the wave's time scale, from the cycle means of their contacts.

Balls: `equilibrium` (one problem; `sweep_kernel` solves many), and `event_equilibrium` for laws without closed means.
Pillars: `pillar_equilibrium`, with tilts and the wave that the pillars load.
"""
