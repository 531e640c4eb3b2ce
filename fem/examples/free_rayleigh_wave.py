"""The Rayleigh wave of three cuts: velocity and coupling against published values.

Velocities and K2 from tables of cuts (Campbell, Surface Acoustic Wave Devices, 1998, table 2.1).
"""

import fem

cuts = {
    name: fem.rotated(fem.material(material), name)
    for material, name in (("LiNbO3 (Kovacs)", "128YX"), ("LiNbO3 (Kovacs)", "YZ"), ("quartz (Bechmann)", "ST-X"))
}
velocity = {name: fem.rayleigh(solid, "vacuum").velocity for name, solid in cuts.items()}
coupling = {name: fem.coupling(solid) for name, solid in cuts.items()}

for name in cuts:
    print(f"{name}: {velocity[name]:.1f} m/s, K2 {100 * coupling[name]:.3f} %")

# the constants of different authors differ by that much
for name, published in {"128YX": 3992, "YZ": 3488, "ST-X": 3158}.items():
    assert abs(velocity[name] / published - 1) < 4e-3
published_coupling = {"128YX": 0.053, "YZ": 0.045, "ST-X": 0.0011}
assert all(abs(coupling[name] / published_coupling[name] - 1) < 0.06 for name in cuts)
