"""Velocity, power and efficiency against load, up to the load at which the motor stalls.

No load above mu times the preload can be held, and the power vanishes at both ends.
"""

from dataclasses import replace

from contact import Orbit, Slider, load_line, steady

PRELOAD, FRICTION = 0.089e-3 * 9.81, 0.08
slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=PRELOAD, load=0.0, friction_coefficient=FRICTION, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j)
line = load_line(slider, wave, points=6, tolerance=1e-3)

for load, velocity, power in zip(line.load, line.velocity, line.power, strict=True):
    print(f"{1e6 * load:7.2f} uN {1e3 * velocity:8.3f} mm/s {1e6 * power:7.3f} uW")
assert 0.0 < line.stall.value < FRICTION * PRELOAD
assert line.power[0] == line.power[-1] == 0.0
assert line.velocity[0] == steady(slider, wave, tolerance=1e-3).velocity
loaded = steady(replace(slider, load=float(line.load[2])), wave, tolerance=1e-3).velocity
assert abs(loaded / line.velocity[2] - 1) < 1e-3
