"""Elements through the depth and the half-space without a mesh, both against the closed form of Rayleigh's wave.

A solid with Poisson's ratio 1/4 has (v / v_s)^2 = 2 - 2 / sqrt(3) (Rayleigh 1885).
"""

import math

import fem

YOUNG, DENSITY = 70e9, 2700.0
solid = fem.isotropic(name="Poisson's", youngs_modulus=YOUNG, poisson_ratio=0.25, density=DENSITY)
shear = math.sqrt(YOUNG / 2.5 / DENSITY)
exact = shear * math.sqrt(2 - 2 / math.sqrt(3))

analytic = fem.rayleigh(solid, "open")
half_space = fem.Stator(solid=solid, length=1.0, thickness=math.inf, bottom="absorbing", ends="absorbing")
meshed = fem.free_wave(half_space, frequency=2.2e6, tolerance=1e-7)

print(f"closed form {exact:.6f} m/s, partial waves {analytic.velocity:.6f} m/s, elements {meshed.velocity:.6f} m/s")
assert abs(analytic.velocity / exact - 1) < 1e-10
assert abs(meshed.velocity / exact - 1) < 2 * meshed.relative_error < 2e-7
