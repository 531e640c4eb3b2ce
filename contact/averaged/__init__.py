"""Averaged equilibria: sliders that are heavy on the wave's time scale, from the cycle means of their contacts.

Held bodies on a given wave: `equilibrium` (one problem; `sweep_kernel` solves many), and `event_equilibrium` for laws
without closed means.
Sliders that tilt, have a soft backing or load the wave: `coupled_motion`, with `coupled_equilibrium`.
"""
