"""Balls of two radii in one slider: each carries its share, and equal ones may be given by their number.

At one approach Hertz's force grows as the root of the radius: a ball of 4 mm carries twice that of one of 1 mm.
"""

from contact import Orbit, Slider, mean_forces, mean_motion, steady

body = {
    "mass": 0.4e-3, "preload": 4e-3, "load": 0.0, "friction_coefficient": 0.08, "effective_modulus": 64e9,
    "tangential_modulus": 12e9, "law": "elastic", "reciprocal": False, "stick_band": 0.0, "contact_damping": 0.0,
    "normal_damping": 2.0, "tangential_damping": 1e-4,
}  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=6e-9, tangential=-4e-9j)
listed = Slider(**body, radius=[1e-3, 1e-3, 1e-3, 4e-3], heights=(0.0, 0.0, 0.0, 0.0))
counted = Slider(**body, radius=[1e-3, 4e-3], heights=(0.0, 0.0), weights=[3.0, 1.0])
one, other = steady(listed, (wave,) * 4, tolerance=1e-6), steady(counted, (wave,) * 2, tolerance=1e-6)
forces = mean_forces(counted, (wave,) * 2, mean_motion(counted, (wave,) * 2)).normal  # N, of one ball each
print(
    f"{1e3 * one.velocity:.4f} mm/s; a small ball carries {1e3 * forces[0]:.3f} mN, the large {1e3 * forces[1]:.3f} mN"
)
assert abs(other.velocity / one.velocity - 1.0) < 1e-9
assert abs(forces[1] / forces[0] - 2.0) < 1e-9
assert abs(forces @ counted.weights / counted.preload - 1.0) < 1e-9
