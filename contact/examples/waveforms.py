"""Forces within a cycle of the steady motion: mean normal force and preload, mean friction and damper are equal."""

import numpy as np

from contact import Orbit, Slider, contact_history

slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=0.873e-3, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-3,
)  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=10e-9, tangential=-7e-9j)
history = contact_history(slider, wave, stage="steady", skip=0, cycles=1, points_per_cycle=2000)
push, pull, speed = history.normal_force[:-1, 0], history.tangential_force[:-1, 0], history.slider_velocity[:-1]
print(f"largest normal force {1e3 * push.max():.2f} mN; in contact for {np.mean(push > 0.0):.0%} of the cycle")
assert abs(push.mean() / slider.preload - 1.0) < 1e-3
assert abs(pull.mean() / (slider.tangential_damping * speed.mean()) - 1.0) < 2e-2
