"""A slider on 200 pillars that load the wave: what the wave gives is what friction and thrust take.

Each pillar takes its share of the wave, so that the last ones of a long slider stand on a smaller one.
"""

import numpy as np

from contact import PassingWave, Slider, steady

PILLARS, PRELOAD = 200, 0.6
slider = Slider(
    x=np.arange(PILLARS) * 50e-6 - 5e-3, y=np.zeros(PILLARS), heights=np.zeros(PILLARS), normal_stiffness=1.8e6,
    tangential_stiffness=1.52e6, preload=PRELOAD, load=0.02, friction_coefficient=0.18, mass=np.inf,
    law="elastic", shape="punch", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.0,
    tangential_damping=0.0,
)  # fmt: skip
wave = PassingWave(
    frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9, compliance=2.5078e-12, strip_width=500e-6
)
state = steady(slider, wave, tolerance=1e-6)
rows = state.loaded
entered = wave.power(wave.forward)
left = entered * (abs(rows.exit_over_entry) ** 2 + abs(rows.reflected_over_entry) ** 2)
taken = rows.friction_power + rows.thrust_power
print(
    f"{state.velocity:.3f} m/s; wave loses {1e3 * (entered - left):.3f} mW, friction and load take {1e3 * taken:.3f} mW"
)
assert abs(state.velocity) > 0.1
assert abs(rows.thrust_power / (0.02 * abs(state.velocity)) - 1) < 1e-6
assert abs((entered - left) / taken - 1) < 1e-6
