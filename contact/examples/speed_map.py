"""Speed over the amplitude of the wave and the preload, as one sweep: a larger preload needs a larger wave.

Below the threshold friction holds the slider. The threshold grows as preload^(2/3), for the wave has to undo Hertz's
approach.
"""

import numpy as np

from contact import Orbit, Slider, steady_sweep, threshold_amplitude

PRELOADS, AMPLITUDES = np.array([0.5e-3, 1e-3, 2e-3]), np.linspace(0.2e-9, 8e-9, 40)
sliders = [
    Slider(
        radius=1e-3, mass=1e-3, preload=preload, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
        tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=2.0, tangential_damping=1e-4,
    )
    for preload in PRELOADS
]  # fmt: skip
wave = Orbit(frequency=2.2e6, normal=1e-9, tangential=-0.7e-9j)
which = np.stack([*np.indices((len(sliders), 1))], axis=-1).repeat(AMPLITUDES.size, axis=1)
factors = np.broadcast_to(AMPLITUDES / 1e-9, (len(sliders), AMPLITUDES.size))
found = steady_sweep(sliders, [(wave,)], which=which, factors=factors, wave_errors=np.zeros(1))
thresholds = np.array([threshold_amplitude(slider, wave) for slider in sliders])
for preload, threshold, fastest in zip(PRELOADS, thresholds, found.velocity[:, -1], strict=True):
    print(f"{1e3 * preload:.1f} mN: moves from {1e9 * threshold:.3f} nm on, {1e3 * fastest:.1f} mm/s at 8 nm")
assert np.array_equal(found.velocity != 0.0, AMPLITUDES > thresholds[:, None])
assert np.max(np.abs(thresholds / PRELOADS ** (2 / 3) / (thresholds[0] / PRELOADS[0] ** (2 / 3)) - 1.0)) < 2e-2
