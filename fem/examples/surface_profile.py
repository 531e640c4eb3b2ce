"""The motion of the surface along a stator, written for ParaView, and its wavelength.

Beyond a transducer on a plate of four wavelengths the surface carries the Rayleigh wave of the half-space.
"""

import tempfile
from pathlib import Path

import meshio
import numpy as np

import fem

FREQUENCY = 2.2e6
solid = fem.rotated(fem.material("PZT-8"), "Z")
period = fem.automatic_period(solid, FREQUENCY, 0.5)
transducer = fem.Transducer(
    name="left", center=4 * period, finger_pairs=4, period=period, metallisation=0.5, aperture=40 * period
)
stator = fem.Stator(solid=solid, length=30 * period, thickness=4 * period, ends="absorbing")
wave = fem.driven_wave(stator, (transducer,), frequency=FREQUENCY, drive="left", tolerance=1e-2)

x, y = np.linspace(8 * period, 28 * period, 401), np.array([-period, period])
motion = np.zeros((3, x.size, y.size), dtype=complex)
motion[0], motion[2] = (np.array(each)[:, None] for each in wave.motion(x))
path = Path(tempfile.mkdtemp()) / "surface.vtu"
fem.write_surface(x, y, motion, path)

points = meshio.read(path)
u_z = (points.point_data["displacement_m_per_V_real"] + 1j * points.point_data["displacement_m_per_V_imag"])[:, 2]
along = u_z.reshape(x.size, y.size)[:, 0]
phase = np.unwrap(np.angle(along))
wavelength = -2 * np.pi / np.polyfit(x, phase, 1)[0]  # exp(-i k x) runs to +x
expected = fem.rayleigh(solid, "open").velocity / FREQUENCY
print(f"wavelength {1e6 * wavelength:.2f} um in {path.name}, of the half-space {1e6 * expected:.2f} um")
assert abs(wavelength / expected - 1) < 3e-3
