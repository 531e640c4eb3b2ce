"""A slider on three balls between two beams at right angles: velocity, yaw, a load across, and the start from rest.

Equal waves a quarter of a period apart do not drive along the diagonal, and across the wave there is no threshold.
"""

import math
from dataclasses import replace

import numpy as np

from contact import Slider
from contact.plane import PlaneWave, PlaneWaves, burst, stall, steady

slider = Slider(
    radius=1e-3, x=[6e-3, -3e-3, -3e-3], y=[0.0, 5.196e-3, -5.196e-3], mass=0.267e-3, preload=2.619e-3, load=(0.0, 0.0),
    friction_coefficient=0.08, effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
    stick_band=0.0, contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0, tilt="free", freedom="xy yaw",
    inertia=5e-9,
)  # fmt: skip
beam = PlaneWave(frequency=2.2e6, wavelength=1.8e-3, direction=math.pi, normal=10e-9, ratio=0.67)  # drives to +x
along = PlaneWaves(waves=(beam,))
both = PlaneWaves(waves=(beam, replace(beam, direction=-0.5 * math.pi, normal=10e-9j)))

one = steady(slider, along, tolerance=1e-3)
two = steady(slider, both, tolerance=1e-3)
pushed = steady(replace(slider, load=(0.0, 0.01 * 0.08 * 2.619e-3)), along, tolerance=1e-3)
start = burst(slider, along, duration=20e-6, after=5e-6, tolerance=1e-3, samples=5)
for name, state in (("one beam", one), ("two beams", two), ("pushed across", pushed)):
    v_x, v_y = 1e3 * state.velocity
    print(f"{name}: {v_x:.3f}, {v_y:.3f} mm/s, {state.yaw_rate:.4f} rad/s, {state.status}: {', '.join(state.regimes)}")
print(f"after 20 us {1e3 * start.velocity[-2, 0]:.4f} mm/s ({start.method}); stall {stall(slider, along, (1, 0))}")
assert abs(two.powers.residual) < 1e-6 * two.power
assert np.all(np.abs(one.velocity - [0.0683658806, 0.0]) < 2 * one.error)  # m/s, one ball by events: tests/contact
