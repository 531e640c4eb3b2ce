"""The admittance of a transducer: below its passband a capacitor, in its passband the load of the waves that it sends.

Two sheets of fingers of equal width and gap hold eps_s per finger pair and metre of aperture (Engan 1969), eps_s the
permittivity of surface and vacuum; the fingers at the two ends hold less.
"""

import math

import numpy as np

import fem

PAIRS = 10
solid = fem.rotated(fem.material("quartz (Bechmann)"), "ST-X")
frequency = 100e6
period = fem.automatic_period(solid, frequency, 0.5)
transducer = fem.Transducer(
    name="only", center=10 * period, finger_pairs=PAIRS, period=period, metallisation=0.5, aperture=50 * period
)
stator = fem.Stator(
    solid=solid, length=20 * period, thickness=math.inf, bottom="free", ends="absorbing", above="vacuum"
)

low, middle = (
    fem.port_admittance(stator, (transducer,), frequency=each, tolerance=1e-2) for each in (0.1 * frequency, frequency)
)
capacitance = low.matrix[0, 0].imag / (2 * np.pi * low.frequency)
expected = PAIRS * fem.surface_permittivity(solid) * transducer.aperture
conductance = fem.transducer_estimate(solid, transducer).conductance(frequency)
print(f"capacitance {capacitance:.4g} F, Engan {expected:.4g} F; conductance {middle.matrix[0, 0].real:.4g} S")
assert 0.96 < capacitance / expected < 1.0
assert abs(middle.matrix[0, 0].real / conductance - 1) < 0.05  # of fingers that do not reflect
