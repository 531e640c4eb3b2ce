"""The steady velocity of a ball on a surface wave, event by event and by averages over a cycle.

The slider is that of Feenstra and Breedveld. A Rayleigh wave towards -x drives it towards +x, and never faster than the
crests move, omega |u_x|.
"""

import math

from contact import Orbit, Slider, steady

PRELOAD, FRICTION = 0.089e-3 * 9.81, 0.08
slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=PRELOAD, load=0.0, friction_coefficient=FRICTION, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=10e-9, tangential=-7e-9j)  # m, peak
exact = steady(slider, wave, tolerance=1e-6, method="exact")
mean = steady(slider, wave, tolerance=1e-2, method="averaged")

print(f"event by event {1e3 * exact.velocity:.4f} mm/s, by averages {1e3 * mean.velocity:.4f} mm/s: {exact.regime}")
crests = 2 * math.pi * wave.frequency * abs(wave.tangential)
assert 0 < exact.velocity < crests
assert abs(mean.velocity - exact.velocity) < 2 * mean.relative_error * max(exact.velocity, crests / 10)
assert abs(exact.velocity - 0.069263) < 1e-6  # m/s: Runge-Kutta in small steps, tests/oracles/contact_steps.py
