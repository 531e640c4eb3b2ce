"""A burst of the wave: the slider speeds up and afterwards coasts to rest under friction alone.

On a surface at rest a sliding slider is braked with mu g, whatever the wave was (here with a little for its damper).
"""

import numpy as np

from contact import Orbit, Slider, burst

GRAVITY, FRICTION = 9.81, 0.08
PRELOAD = 0.089e-3 * GRAVITY
slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=PRELOAD, load=0.0, friction_coefficient=FRICTION, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=10e-9, tangential=-7e-9j)
motion = burst(slider, wave, duration=0.05, after=0.02, tolerance=1e-3, samples=701)

braking = (motion.time > 0.052) & (motion.time < 0.06)
slowing = -np.polyfit(motion.time[braking], motion.velocity[braking], 1)[0]
print(f"{1e3 * motion.velocity_at_burst_end:.3f} mm/s at the end of the burst, then {slowing:.4f} m/s^2 of braking")
damper = slider.tangential_damping / slider.mass * motion.velocity[braking].mean()
assert 0.03 < motion.velocity_at_burst_end < 0.04
assert abs(slowing / (FRICTION * GRAVITY + damper) - 1) < 1e-3
