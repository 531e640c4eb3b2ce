"""Constants at a temperature: published temperature coefficients of surface and plate waves, and an expanded body."""

import numpy as np
import pytest

import fem
from fem.materials.tables import catalogue_table
from fem.materials.temperature import expansion_along, in_cold_lengths, solid_at

# material, cut, surface, TCF in ppm/K at 25 degC, its tolerance. 128YX, YZ and X-112Y of LiNbO3 and LiTaO3: handbook
# values of the delay's coefficient (TCD = -TCF) 75 to 77, 94, 18 ppm/K. ST-X quartz: zero at room temperature.
PUBLISHED = (
    ("LiNbO3 (Kovacs)", "128YX", "vacuum", -76.0, 2.0),
    ("LiNbO3 (Warner)", "YZ", "vacuum", -94.0, 1.0),
    ("LiTaO3 (Warner)", "X112Y", "vacuum", -18.0, 1.0),
    ("quartz (Bechmann)", "ST-X", "vacuum", 0.0, 1.0),
    ("fused silica", "Z", "vacuum", 80.0, 6.0),
    ("silicon (cubic)", "Z", "vacuum", -25.0, 5.0),
)
# computed for `heating.md` by another program, with the same constants and coefficients: material, cut, surface, TCV
COMPUTED = (
    ("LiNbO3 (Kovacs)", "128YX", "vacuum", -61.63), ("LiNbO3 (Kovacs)", "128YX", "metallised", -65.00),
    ("LiNbO3 (Warner)", "128YX", "vacuum", -62.76), ("LiNbO3 (Warner)", "128YX", "metallised", -65.61),
    ("LiNbO3 (Warner)", "YZ", "vacuum", -87.11), ("LiNbO3 (Warner)", "YZ", "metallised", -81.73),
)  # fmt: skip


def velocity(name, cut, surface, temperature):
    return fem.rayleigh(fem.rotated(solid_at(name, temperature), cut), surface).velocity


def frequency(name, cut, surface, temperature):
    stretch = expansion_along(catalogue_table(name), cut, temperature)
    return velocity(name, cut, surface, temperature) / (1.0 + stretch)


def slope(function, *where, at=25.0):
    return 1e6 * (function(*where, at + 1.0) - function(*where, at - 1.0)) / (2.0 * function(*where, at))


@pytest.mark.parametrize(("name", "cut", "surface", "published", "tolerance"), PUBLISHED)
def test_published_coefficients_of_the_frequency(name, cut, surface, published, tolerance):
    assert slope(frequency, name, cut, surface) == pytest.approx(published, abs=tolerance)


@pytest.mark.parametrize(("name", "cut", "surface", "computed"), COMPUTED)
def test_coefficients_of_the_velocity_of_another_program(name, cut, surface, computed):
    assert slope(velocity, name, cut, surface) == pytest.approx(computed, abs=6e-3)


def test_st_quartz_turns_over_near_room_temperature():
    """Second order -0.032 to -0.036 ppm/K^2 (handbooks: -0.034), no first order at 15 to 35 degC."""
    at = np.array([-20.0, 0.0, 20.0, 40.0, 60.0])
    shifts = [frequency("quartz (Bechmann)", "ST-X", "vacuum", 25.0 + each) for each in at]
    cubic = np.polynomial.Polynomial.fit(at, np.array(shifts) / shifts[1], 3).convert().coef
    assert 1e9 * cubic[2] == pytest.approx(-34.0, abs=4.0)
    assert 15.0 < 25.0 - cubic[1] / (2 * cubic[2]) < 35.0


def test_an_at_cut_plate_does_not_change_its_frequency():
    """Thickness shear of rotated Y cuts: c66 cos^2 + c44 sin^2 + 2 c14 sin cos; zero at 35.25 degrees."""

    def plate(angle, temperature):
        solid = solid_at("quartz (Bechmann)", temperature)
        c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
        stiffened = solid.coupling[1, 5] * c * c + solid.coupling[1, 4] * s * c
        modulus = solid.stiffness[5, 5] * c * c + solid.stiffness[4, 4] * s * s + 2 * solid.stiffness[4, 5] * c * s
        modulus += stiffened**2 / (solid.permittivity[1, 1] * c * c + solid.permittivity[2, 2] * s * s)
        normal = np.array([0.0, c, s])
        growth = 1.0 + normal**2 @ fem.expansions(catalogue_table("quartz (Bechmann)"), temperature)
        return np.sqrt(modulus / solid.density) / growth

    assert abs(slope(plate, 35.25)) < 1.5
    assert slope(plate, 49.0 - 98.0) == pytest.approx(0.0, abs=3.0)  # BT cut
    assert abs(slope(plate, 20.0)) > 20.0


def test_density_and_tied_constants():
    warm = solid_at("quartz (Bechmann)", 125.0)
    cold = fem.material("quartz (Bechmann)")
    grown = (1 + 13.71e-4 + 6.5e-5 - 1.9e-6) ** 2 * (1 + 7.48e-4 + 2.9e-5 - 1.5e-6)
    assert warm.density == pytest.approx(cold.density / grown, rel=1e-12)
    assert warm.stiffness[5, 5] == pytest.approx(39.875e9 * (1 + 178e-4 + 118e-5 + 21e-6), rel=1e-12)
    assert warm.stiffness[0, 0] - warm.stiffness[0, 1] == pytest.approx(2 * warm.stiffness[5, 5], rel=1e-12)
    assert solid_at("quartz (Bechmann)", 25.0).stiffness == pytest.approx(cold.stiffness, rel=1e-12)


def test_an_expanded_body_in_its_old_lengths():
    """Frequency per wavenumber falls by the stretch beside the velocity; force per volt and displacement stay."""
    solid = fem.rotated(solid_at("LiNbO3 (Kovacs)", 80.0), "128YX")
    stretch = 8e-4
    cold = in_cold_lengths(solid, stretch)
    ratio = fem.rayleigh(cold, "open").velocity / fem.rayleigh(solid, "open").velocity
    assert ratio == pytest.approx(1 / (1 + stretch), rel=1e-10)
    plate = fem.Stator(solid=solid, length=2e-3 * (1 + stretch), thickness=4e-4 * (1 + stretch), ends="free")
    old = fem.Stator(solid=cold, length=2e-3, thickness=4e-4, ends="free")

    def driven(block, scale):
        fingers = fem.Transducer(
            name="t", center=8e-4 * scale, finger_pairs=2, period=4e-4 * scale, metallisation=0.5, aperture=2e-3 * scale
        )
        return fem.driven_wave(block, (fingers,), frequency=9.7e6, drive="t", tolerance=1e-2)

    grown, before = driven(plate, 1 + stretch), driven(old, 1.0)
    assert before.circuit.admittance == pytest.approx(grown.circuit.admittance, rel=1e-8)
    assert before.motion(1.6e-3) == pytest.approx(grown.motion(1.6e-3 * (1 + stretch)), rel=1e-8)


def test_a_solid_without_coefficients_is_refused():
    with pytest.raises(fem.InputError, match="temperature needs coefficients, and PZT-8 has none"):
        solid_at("PZT-8", 60.0)
