"""The amplitude at which a slider starts to move, against the closed form.

On a heavy ball the contact slips first where |u_x|^2 + c^2 |u_z|^2 = c^2 h^2, with c = mu E / (4 G) and the approach h
that gives the mean force the preload (Johnson, Contact Mechanics, 1985, eq. 4.22 and section 7.2).
"""

import math
from dataclasses import replace

import numpy as np

from contact import Orbit, Slider, threshold_amplitude

PRELOAD, FRICTION = 0.089e-3 * 9.81, 0.08
slider = Slider(
    radius=1e-3, mass=0.089e-3, preload=PRELOAD, load=0.0, friction_coefficient=FRICTION, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
RATIO = 0.7
wave = Orbit(frequency=2.2e6, normal=1e-9, tangential=-1e-9j * RATIO)
heavy = threshold_amplitude(replace(slider, mass=1e4), wave)
own = threshold_amplitude(slider, wave)

at_rest = (PRELOAD / (4 / 3 * 64e9 * math.sqrt(1e-3))) ** (2 / 3)
slope = FRICTION * 64e9 / (4 * 12e9)
share = slope / math.hypot(RATIO, slope)  # |u_z| over the approach
cosine = np.cos(np.linspace(0.0, 2.0 * np.pi, 64, endpoint=False))
expected = share * at_rest / np.mean((1 + share * cosine) ** 1.5) ** (2 / 3)
print(f"heavy {1e9 * heavy:.5f} nm, closed form {1e9 * expected:.5f} nm; 0.089 g {1e9 * own:.5f} nm")
assert abs(heavy / expected - 1) < 1e-6
