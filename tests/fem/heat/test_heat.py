"""Temperature of a heated plate against closed forms, an independent series of modes, and the balance of energy.

Numbers of the seed's stator: two independent programs (a Green's function and spectral elements of their own).
"""

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from fem import InputError
from fem.heat import (
    FOLDOVER_LIMIT,
    HeatedPlate,
    HeatSource,
    drive_folds,
    foldover_number,
    folds,
    heated_powers,
    heated_states,
    runaway_rise,
    sampled_foldover_number,
    temperature_profile,
)

SEED = {"length": 0.16, "width": 0.035, "thickness": 5e-3, "conductivity": 1.25, "volumetric_heat": 7600 * 420}
LEFT, RIGHT, SOLID, DIELECTRIC = 5.797986, 2.544466, 4.606748, 0.197208  # W at 60 V
ATTENUATION = 6.335308  # of the power, 1/m


def seed_sources(*, ends: float = 0.0, mirrored: bool = False):
    """Return the seed's sources: fingers of 10 to 20 mm, waves from 15 mm on both sides, a share of the ends' heat."""

    def density(x):
        return np.exp(-ATTENUATION * abs((0.16 - x if mirrored else x) - 0.015))

    def at(start, stop, power, shape=None):
        return HeatSource(
            start=0.16 - stop if mirrored else start, stop=0.16 - start if mirrored else stop, power=power,
            density=shape,
        )  # fmt: skip

    launched = 6.375996  # W to each side
    waves = [
        at(0.0, 0.015, launched * -math.expm1(-ATTENUATION * 0.015), density),
        at(0.015, 0.16, launched * -math.expm1(-ATTENUATION * 0.145), density),
    ]
    absorbed = [at(0.0, 5e-3, ends * LEFT), at(0.155, 0.16, ends * RIGHT)] if ends else []
    return [at(0.01, 0.02, DIELECTRIC), *waves, *absorbed]


PLATE = HeatedPlate(**SEED, film=10.0)


def test_the_split_of_the_seed_is_the_one_of_its_attenuation():
    """Whatever is not absorbed in the solid leaves at the ends."""
    total = sum(each.power for each in seed_sources())
    assert total == pytest.approx(SOLID, rel=1e-6)
    assert 6.375996 * math.exp(-ATTENUATION * 0.015) == pytest.approx(LEFT, rel=1e-6)
    assert 6.375996 * math.exp(-ATTENUATION * 0.145) == pytest.approx(RIGHT, rel=1e-6)


def test_mean_temperature_and_time_in_air():
    assert PLATE.heat_capacity == pytest.approx(89.3760, rel=1e-7)
    assert PLATE.resistance == pytest.approx(7.604563, rel=1e-7)
    assert PLATE.time_constant == pytest.approx(679.6654, rel=1e-7)
    assert PLATE.steady_rise(SOLID) == pytest.approx(35.0323, rel=2e-6)
    assert PLATE.steady_rise(SOLID + LEFT + RIGHT) == pytest.approx(98.473, rel=1e-5)
    assert PLATE.heating_rate(SOLID) == pytest.approx(SOLID / 89.3760, rel=1e-7)


def test_a_chip_in_air_and_on_metal():
    chip = {"length": 0.06, "width": 0.014, "thickness": 1e-3, "conductivity": 4.5, "volumetric_heat": 4650 * 648}
    in_air = HeatedPlate(**chip, film=10.0)
    assert in_air.resistance == pytest.approx(54.70, rel=1e-4)
    held = HeatedPlate(**chip, film=0.0, bottom=math.inf)
    assert held.resistance == pytest.approx(1e-3 / (4.5 * 0.06 * 0.014), rel=1e-12)
    assert held.resistance == pytest.approx(0.26455, rel=1e-5)
    assert held.time_constant == pytest.approx(4 * 1e-6 * 4650 * 648 / (math.pi**2 * 4.5), rel=1e-12)
    assert HeatedPlate(**chip, film=10.0, bottom=math.inf).resistance < held.resistance


def test_a_thin_glue_is_a_resistance_in_series_and_a_weak_one_the_lumped_time():
    chip = {"length": 0.06, "width": 0.014, "thickness": 1e-3, "conductivity": 4.5, "volumetric_heat": 3e6}
    glued = HeatedPlate(**chip, film=0.0, bottom=2000.0)
    assert glued.resistance == pytest.approx((1e-3 / 4.5 + 1 / 2000.0) / (0.06 * 0.014), rel=1e-12)
    weak = HeatedPlate(**chip, film=0.0, bottom=1.0)
    assert weak.time_constant == pytest.approx(3e6 * 1e-3 / 1.0, rel=1e-3)


@pytest.mark.parametrize(
    ("ends", "rises"),
    [(0.0, (46.878500, 51.958203, 33.856487, 19.878816)), (1.0, (380.935702, 213.789587, 38.426102, 166.516822))],
)
@pytest.mark.parametrize("mirrored", [False, True])
def test_the_profile_of_the_seed(ends, rises, mirrored):
    places = np.array([0.0, 0.015, 0.08, 0.16])
    found = temperature_profile(PLATE, seed_sources(ends=ends, mirrored=mirrored))
    assert found.at(0.16 - places if mirrored else places) == pytest.approx(rises, rel=1e-6)
    assert found.heat_to_surroundings() == pytest.approx(found.power, rel=1e-12)


def test_the_seed_after_some_time():
    found = temperature_profile(PLATE, seed_sources())
    times = (10.0, 60.0, 300.0, 683.0)
    at_fingers, at_slider = zip(*(found.at([0.015, 0.08], each) for each in times), strict=True)
    assert at_fingers == pytest.approx((1.054376, 5.558391, 20.686277, 34.900687), rel=1e-6)
    assert at_slider == pytest.approx((0.475666, 2.755510, 11.708116, 20.973204), rel=1e-6)
    heated = temperature_profile(PLATE, seed_sources(ends=1.0))
    assert [float(heated.at(0.0, each)) for each in times] == pytest.approx(
        (20.587012, 89.081840, 227.47709, 311.353335), rel=1e-6
    )
    assert found.time_constants[:3] == pytest.approx((682.958, 605.261, 473.658), rel=1e-6)
    place, rise = heated.hottest()
    # the end itself is cooled by the air: a parabola about the maximum, of the slope and the curvature at the end
    slope = PLATE.film / PLATE.conductivity * 380.935702
    kept = LEFT / 5e-3 - PLATE.loss_per_length * 380.935702
    curvature = kept / (PLATE.conductivity * PLATE.section)
    assert place == pytest.approx(slope / curvature, abs=1e-4)
    assert rise == pytest.approx(380.935702 + slope**2 / (2 * curvature), rel=2e-4)


def test_modes_have_the_wavenumbers_of_a_rod_with_cooled_ends():
    """Even modes: m tan(m L/2) = h/k; odd ones: -m cot(m L/2) = h/k; rate k A m^2 + g."""
    ratio, half = PLATE.film / PLATE.conductivity, PLATE.length / 2
    even = brentq(lambda m: m * math.sin(m * half) - ratio * math.cos(m * half), 0.0, 0.5 * math.pi / half)
    odd = brentq(lambda m: m * math.cos(m * half) + ratio * math.sin(m * half), 0.5 * math.pi / half, math.pi / half)
    rates = [(PLATE.conductivity * PLATE.section * m * m + PLATE.loss_per_length) for m in (even, odd)]
    expected = [PLATE.volumetric_heat * PLATE.section / rate for rate in rates]
    assert temperature_profile(PLATE, seed_sources()).time_constants[:2] == pytest.approx(expected, rel=1e-10)


def test_a_uniform_source_is_a_closed_form():
    """T = T_0 (1 - beta cosh(m (x - L/2))), from the ends' condition."""
    found = temperature_profile(PLATE, [HeatSource(start=0.0, stop=0.16, power=3.0)])
    g, m, half = PLATE.loss_per_length, 1.0 / PLATE.decay_length, 0.08
    level, ratio = 3.0 / 0.16 / g, PLATE.film / PLATE.conductivity
    beta = ratio / (m * math.sinh(m * half) + ratio * math.cosh(m * half))
    x = np.linspace(0.0, 0.16, 9)
    assert found.at(x) == pytest.approx(level * (1 - beta * np.cosh(m * (x - half))), rel=1e-9)


def test_a_uniform_source_on_insulated_ends_warms_as_one_body():
    """No air, a bottom with a conductance: T = q/g (1 - exp(-t g/(rho c A))) everywhere."""
    plate = HeatedPlate(**SEED | {"length": 0.03}, film=0.0, bottom=500.0)
    found = temperature_profile(plate, [HeatSource(start=0.0, stop=0.03, power=2.0)])
    g = plate.loss_per_length
    settling = plate.volumetric_heat * plate.section / g
    assert found.time_constants[0] == pytest.approx(settling, rel=1e-12)
    for time in (0.1 * settling, 2.0 * settling):
        expected = 2.0 / 0.03 / g * -math.expm1(-time / settling)
        assert found.at([0.0, 0.011, 0.03], time) == pytest.approx([expected] * 3, rel=1e-9)


def test_foldover():
    assert FOLDOVER_LIMIT == pytest.approx(1.539601, rel=1e-6)
    for number, expected in (
        (2.0, ((2.0, 0.5), (2.134884, 0.919643))),
        (4.0, ((2.723554, 0.278772), (4.063526, 0.983579))),
    ):
        flat = [each for pair in folds(number) for each in pair]
        assert flat == pytest.approx([each for pair in expected for each in pair], rel=1e-6)
        for x, y in folds(number, -1.0):
            assert x < 0
            assert y * (1 + (x + number * y) ** 2) == pytest.approx(1.0, rel=1e-9)
    assert folds(1.53) == ()
    assert len(heated_powers(2.05, 2.0)) == 3
    assert len(heated_powers(1.9, 2.0)) == len(heated_powers(2.2, 2.0)) == 1
    for y in heated_powers(2.05, 2.0):
        assert y * (1 + (2.05 - 2.0 * y) ** 2) == pytest.approx(1.0, rel=1e-9)
    assert heated_powers(-2.05, 2.0, -1.0) == pytest.approx(heated_powers(2.05, 2.0))
    number = foldover_number(quality=1070, frequency_coefficient=-17e-6, resistance=7.6, peak_power=5.8)
    assert number == pytest.approx(2 * 1070 * 17e-6 * 7.6 * 5.8, rel=1e-12)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("number", [1.2, 2.0, 4.0])
def test_sampled_states_and_folds_are_those_of_the_closed_form(number, sign):
    """A lone resonance of Q 100000 at 1 MHz, with a rise R W_peak of 10 K."""
    quality, peak = 1e5, 10.0
    coefficient = sign * number / (2 * quality * peak)
    x = np.linspace(-12.0, 12.0, 4801)
    cold = 1e6 * (1.0 + x / (2 * quality))
    held = peak / (1.0 + x * x)
    found = [2 * quality * (each / 1e6 - 1.0) for each in drive_folds(cold, held, coefficient)]
    assert found == pytest.approx(sorted(at for at, _ in folds(number, sign)), rel=1e-3)
    assert sampled_foldover_number(cold, held, coefficient) == pytest.approx(number, rel=1e-3)
    rises = np.linspace(0.0, 12.0, 2401)
    for detuning in (1.5, 0.5 * (sum(at for at, _ in folds(number)) or 3.8), 4.5):
        shifted = sign * (detuning - number * rises / peak)
        states = heated_states(rises, peak / (1.0 + shifted**2))
        exact = heated_powers(sign * detuning, number, sign)
        assert [each.rise / peak for each in states] == pytest.approx(exact, rel=1e-6)
        assert [each.stable for each in states] == [True, False, True][: len(exact)]


def test_only_a_flank_against_which_the_resonance_moves_folds():
    """Below the peak the power rises with the frequency: a falling resonance folds there, a rising one does not."""
    cold = 1e6 * (1.0 + np.linspace(-12.0, -0.1, 1201) / 2e5)
    held = 10.0 / (1.0 + np.linspace(-12.0, -0.1, 1201) ** 2)
    assert sampled_foldover_number(cold, held, -2.0 / (2e5 * 10.0)) == pytest.approx(2.0, rel=1e-3)
    assert sampled_foldover_number(cold, held, 2.0 / (2e5 * 10.0)) == 0.0


def test_samples_must_rise():
    with pytest.raises(InputError, match="rises must be at least 4 rising numbers"):
        heated_states([0.0, 1.0, 1.0, 2.0], [1.0] * 4)


def test_runaway():
    assert runaway_rise(2.0, 10.0, 0.01) == pytest.approx(20.0 / 0.8, rel=1e-12)
    with pytest.raises(InputError, match="below 1"):
        runaway_rise(2.0, 10.0, 0.05)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"length": 0.0}, "length"),
        ({"conductivity": -1.0}, "conductivity"),
        ({"film": 0.0}, "nothing cools the plate"),
        ({"bottom": 0.0}, "bottom must be positive, got 0.0 W"),
        ({"film": math.nan}, "film"),
    ],
)
def test_a_plate_that_cannot_be_is_refused(change, words):
    with pytest.raises(InputError, match=words):
        HeatedPlate(**SEED | change)


def test_time_needs_a_heat_capacity():
    plate = HeatedPlate(**SEED | {"volumetric_heat": None})
    assert plate.time_constant is None
    found = temperature_profile(plate, seed_sources())
    assert found.at(0.08) == pytest.approx(33.856487, rel=1e-6)
    with pytest.raises(InputError, match="volumetric_heat"):
        found.at(0.08, 10.0)
    with pytest.raises(InputError, match="within the plate"):
        temperature_profile(plate, [HeatSource(start=0.1, stop=0.2, power=1.0)])
