"""A transducer over a band of frequencies: the group delay between two places is their distance over the velocity.

The section is condensed once for the band; each frequency then takes milliseconds.
"""

import math

import numpy as np

import fem

FREQUENCY = 2.2e6
solid = fem.rotated(fem.material("PZT-8"), "Z")
period = fem.automatic_period(solid, FREQUENCY, 0.5)
transducer = fem.Transducer(
    name="left", center=4 * period, finger_pairs=4, period=period, metallisation=0.5, aperture=40 * period
)
stator = fem.Stator(solid=solid, length=40 * period, thickness=math.inf, bottom="free", ends="absorbing")

ends = (0.98 * FREQUENCY, 1.02 * FREQUENCY)
band = fem.frequency_band(stator, (transducer,), lowest=ends[0], highest=ends[1], drive="left", tolerance=1e-2)
frequencies, places = np.linspace(*ends, 21), np.array([18, 38]) * period
u_z = np.array([wave.motion(places)[1] for wave in band.waves(frequencies, "left")])
phase = np.unwrap(np.angle(u_z[:, 1] / u_z[:, 0]))
delay = -np.polyfit(2 * np.pi * frequencies, phase, 1)[0]
expected = (places[1] - places[0]) / fem.rayleigh(solid, "open").velocity
print(f"group delay {1e6 * delay:.4f} us, distance over velocity {1e6 * expected:.4f} us")
assert abs(delay / expected - 1) < 2e-3
