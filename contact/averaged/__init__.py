"""Averaged equilibria: sliders that are heavy on the wave's time scale, from the cycle means of their contacts."""
