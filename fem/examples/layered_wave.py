"""A surface wave under a film: from the substrate's Rayleigh wave without the film to the film's own under a thick one.

Gold is slow, so that its wave stays bound to it. In between, the film slows the wave from the first nanometre on.
"""

import fem

substrate, film = fem.material("fused silica"), fem.material("gold")
bare, own = (fem.rayleigh(solid, "open").velocity for solid in (substrate, film))


def velocity(wavelengths: float) -> float:
    """Return the velocity in m/s of the wave under a film of a thickness in wavelengths."""
    layer = fem.Layer(solid=film, wavelengths=wavelengths)
    return fem.principal_wave(fem.layered_waves(substrate, [layer])).velocity


for thickness in (1e-4, 1e-3, 1e-2, 0.1, 4.0):
    print(f"{thickness:7g} wavelengths of gold: {velocity(thickness):8.2f} m/s")
assert abs(velocity(1e-9) / bare - 1) < 1e-6
assert abs(velocity(4.0) / own - 1) < 1e-6
# a thin film acts to first order in its thickness
slope = (velocity(1e-4) - bare) / 1e-4
assert abs((velocity(2e-4) - bare) / 2e-4 / slope - 1) < 1e-2
