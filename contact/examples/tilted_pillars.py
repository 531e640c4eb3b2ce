"""A slider that may tilt: a preload beside its centre presses one end deeper, until the moments balance."""

import numpy as np

from contact import PassingWave, Slider, steady

PILLARS, PRELOAD, OFFSET = 100, 0.3, 0.4e-3
x = (np.arange(PILLARS) - 0.5 * (PILLARS - 1)) * 50e-6
slider = Slider(
    x=x, normal_stiffness=1.8e6, tangential_stiffness=1.52e6, shape="punch", preload=PRELOAD, load=0.0,
    friction_coefficient=0.18, mass=np.inf, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
    normal_damping=0.0, tangential_damping=0.0, tilt="pitch", preload_at=(OFFSET, 0.0),
)  # fmt: skip
wave = PassingWave(frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9)
state = steady(slider, wave, tolerance=1e-6)
forces = state.loaded.forces.normal
print(
    f"pitch {1e6 * state.tilt[0]:.3f} urad, {state.velocity:.4f} m/s, force acts at {1e3 * forces @ x / PRELOAD:.3f} mm"
)
assert state.tilt[0] > 0.0
assert abs(forces.sum() / PRELOAD - 1.0) < 1e-9
assert abs(forces @ x / (PRELOAD * OFFSET) - 1.0) < 1e-9
