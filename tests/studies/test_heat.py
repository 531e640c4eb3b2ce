"""The heat of a run: the split of its power, temperatures from it by an independent solver, warnings, bad input."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import solve_banded

from studies import Scene, run
from studies.refusal import SceneError
from studies.remarks.heat_warnings import heat_warnings
from studies.scene.stator_keys import Cooling, IsotropicSolid, Stator
from studies.solve.heat import drift, frequency_slope, heat_block, plate, powers, sources


@pytest.fixture(scope="module")
def motor():
    """A short stator of PZT-8 with absorbing ends and a transducer off its middle, at two voltages."""
    scene = Scene.from_table("", {
        "stator": {"material": "PZT-8", "length": "30 mm", "thickness": "2 mm", "width": "12 mm", "ends": "absorbing",
                   "diffraction": False},
        "transducer": [{"name": "t", "center": "8 mm", "finger_pairs": 4, "period": "1 mm", "metallisation": 0.5,
                        "aperture": "8 mm"}],
        "drive": {"frequency": "2.2 MHz", "transducer": "t", "voltage": [20.0, 50.0]},
    })  # fmt: skip
    return run(scene, tolerance=1e-2)


def cooled(record, **cooling):
    """The record of the same run with another cooling."""
    stator = replace(record.scene.stator, cooling=Cooling(**cooling))
    changed = replace(record, scene=replace(record.scene, stator=stator))
    return replace(changed, heat=heat_block(changed))


def test_the_powers_are_those_of_the_balance_at_the_largest_level(motor):
    split = powers(motor)
    parts = sum(size for name, size in split.items() if name != "power_W")
    assert parts == pytest.approx(split["power_W"], rel=1e-9)
    assert split["power_W"] == pytest.approx(2500 * motor.electrical["power_W_per_V2"], rel=1e-12)
    susceptance = motor.electrical["admittance_S"].imag
    assert split["power_dielectric_W"] == pytest.approx(0.5 * 2500 * susceptance * 0.004, rel=1e-12)
    assert motor.heat["voltage_V"] == 50.0


@pytest.mark.parametrize("share", [0.0, 0.7])
def test_temperatures_are_those_of_a_boundary_value_solver(motor, share):
    record = cooled(motor, ends_heat_stator=share, air=8.0)
    heated = sources(record)
    assert sum(each.power for each in heated) == pytest.approx(
        record.heat["power_dielectric_W"] + record.heat["power_along_beam_W"]
        + share * (record.heat["power_left_end_W"] + record.heat["power_right_end_W"]), rel=1e-12,
    )  # fmt: skip
    agrees_with_finite_volumes(record)


def agrees_with_finite_volumes(record):
    """Compare rises with cells for k A T'' = g T - q', with sources summed from their densities here."""
    body, heated, length = plate(record.scene.stator), sources(record), record.scene.stator.length
    cells = round(length / 5e-6)  # the sources of the ends, 5 mm long, are whole cells
    width = length / cells
    x = width * (np.arange(cells) + 0.5)
    heat = np.zeros(cells)
    for each in heated:
        density = np.where((x > each.start) & (x < each.stop), 1.0 if each.density is None else each.density(x), 0.0)
        heat += each.power * density / density.sum()
    between = body.conductivity * body.section / width
    at_end = 1.0 / (1.0 / body.end_loss + 0.5 / between)
    diagonal = np.full(cells, 2.0 * between + body.loss_per_length * width)
    diagonal[[0, -1]] += at_end - between
    bands = np.stack([np.full(cells, -between), diagonal, np.full(cells, -between)])
    rises = solve_banded((1, 1), bands, heat)
    wall = (rises[0] * at_end / body.end_loss, rises[-1] * at_end / body.end_loss)
    fingers = record.scene.driven_transducer.center_xy[0]
    assert record.heat["fingers_rise_K"] == pytest.approx(np.interp(fingers, x, rises), rel=3e-5)
    assert (record.heat["left_end_rise_K"], record.heat["right_end_rise_K"]) == pytest.approx(wall, rel=2e-4)
    assert record.heat["highest_rise_K"] == pytest.approx(rises.max(), rel=1e-3)


def test_the_seed_s_stator_with_cooled_ends_and_with_heated_ones():
    """`run twente` at 60 V: 6.290 W left, 1.196 W right, 5.463 W in the solid, kept aside beside `heating.md`."""
    scene = Scene.load("twente")
    stator = replace(scene.stator, diffraction=True)  # as under its slider
    record = run(
        replace(scene, slider=None, stator=stator, drive=replace(scene.drive, voltage=(60.0,))), tolerance=2e-3
    )
    split = record.heat
    assert (split.power_left_end_W, split.power_right_end_W) == pytest.approx((6.290, 1.196), rel=3e-3)
    assert split.power_dielectric_W + split.power_along_beam_W == pytest.approx(5.463, rel=3e-3)
    assert split.power_dielectric_W == pytest.approx(0.197208, rel=1e-3)
    for share in (0.0, 1.0):
        agrees_with_finite_volumes(cooled(record, ends_heat_stator=share))
    assert "lower the voltage" in " ".join(heat_warnings(cooled(record, ends_heat_stator=1.0)))


def test_the_band_is_that_of_the_air(motor):
    for air, suffix in ((14.0, "_low"), (6.0, "_high")):
        other = cooled(motor, air=air)
        assert other.heat["fingers_rise_K"] == pytest.approx(motor.heat[f"fingers_rise{suffix}_K"], rel=1e-9)
    assert motor.heat["highest_rise_low_K"] < motor.heat["highest_rise_K"] < motor.heat["highest_rise_high_K"]


def test_metal_below_cools(motor):
    held = cooled(motor, bottom="held")
    kept = held.heat["power_dielectric_W"] + held.heat["power_along_beam_W"]
    assert held.heat["mean_rise_K"] < kept * 2e-3 / (1.25 * 0.03 * 0.012)
    assert held.heat["time_constant_s"] == pytest.approx(4 * 4e-6 * 7600 * 420 / (np.pi**2 * 1.25), rel=2e-2)
    assert held.heat["highest_rise_K"] < 0.2 * motor.heat["highest_rise_K"]


def test_a_rise_beyond_the_coefficients_has_no_drift_and_a_small_one_that_of_the_frequency(motor):
    """128YX: -77 ppm/K in vacuum, from the coefficients of the constants."""
    chip = replace(motor.scene.stator, material="LiNbO3 (Kovacs)", orientation="128YX")
    f = 10e6
    assert drift(chip, 2.0, f) == pytest.approx(-154e-6, rel=1e-2)
    assert drift(chip, 5000.0, f) is None
    assert frequency_slope(chip, f) == pytest.approx(drift(chip, 0.1, f) / 0.1, rel=1e-3)
    assert drift(motor.scene.stator, 2.0, f) is None


def test_the_drift_of_layers_is_that_of_each_at_the_temperature(motor):
    chip = replace(motor.scene.stator, material="LiNbO3 (Kovacs)", orientation="128YX")

    def coated(material: str, thickness: str) -> Stator:
        film = {"layer": [{"material": material, "orientation": "128YX", "thickness": thickness}]}
        return Stator.from_table("stator", chip.to_table() | film)

    f = 10e6
    same = coated("LiNbO3 (Kovacs)", "10 um")  # a film of the chip's own solid
    assert drift(same, 2.0, f) == pytest.approx(drift(chip, 2.0, f), rel=1e-6)
    # SiO2 becomes stiffer where lithium niobate becomes softer: the frequency rises less the thicker it is
    drifts = [drift(coated("fused silica", each), 2.0, f) for each in ("1 nm", "20 um", "80 um")]
    assert drifts[0] == pytest.approx(drift(chip, 2.0, f), rel=1e-3)
    assert drifts[0] < drifts[1] < drifts[2]
    assert drift(coated("AlN", "100 nm"), 2.0, f) is None  # no coefficients in the catalogue
    known = replace(coated("AlN", "100 nm"), temperature_coefficient=-5e-5)
    assert drift(known, 2.0, f) == pytest.approx(-1e-4, rel=1e-12)


def driven(record, **drive):
    """The record of the same run with another duty or burst."""
    scene = record.scene
    changed = replace(record, scene=replace(scene, drive=replace(scene.drive, **drive)))
    return replace(changed, heat=heat_block(changed))


def test_a_duty_is_that_share_of_the_heat_and_a_lone_burst_has_no_steady_temperature(motor):
    tenth = driven(motor, duty=0.1)
    assert tenth.heat.power_W == motor.heat.power_W
    for key in ("heating_rate_K_per_s", "mean_rise_K", "fingers_rise_K", "highest_rise_high_K"):
        assert tenth.heat[key] == pytest.approx(0.1 * motor.heat[key], rel=1e-9)
    assert "a drive with a duty of 10 %" in str(tenth)
    burst = driven(motor, burst=5e-3)
    kept = burst.heat.power_dielectric_W + burst.heat.power_along_beam_W
    assert burst.heat.burst_rise_K == pytest.approx(5e-3 * kept / (7600 * 420 * 0.03 * 0.012 * 0.002), rel=1e-9)
    assert burst.heat.highest_rise_K is None
    assert "one burst warms the stator by" in str(burst)
    assert driven(motor, burst=5e-3, duty=0.1).heat == tenth.heat


def test_the_limits_are_those_at_which_the_warnings_begin(motor):
    """Heat grows with V^2: a drive at the limits is warm by half the Curie temperature, or by 10 K in a second."""
    hot = cooled(motor, ends_heat_stator=1.0)

    def at(voltage, **drive):
        return driven(hot, voltage=(voltage,), **drive).heat

    most = hot.heat.continuous_limit_voltage_V
    assert at(most).highest_rise_K == pytest.approx(150.0 - 20.0, rel=1e-9)
    assert at(hot.heat.pulsed_limit_voltage_V).heating_rate_K_per_s == pytest.approx(10.0, rel=1e-9)
    above = at(2.0 * most)
    assert above.duty_limit == pytest.approx(0.25, rel=1e-9)
    assert at(2.0 * most, duty=above.duty_limit).highest_rise_K == pytest.approx(130.0, rel=1e-9)
    assert at(0.5 * most).duty_limit == 1.0
    assert not list(heat_warnings(driven(hot, voltage=(0.999 * most,))))
    assert "half of its Curie" in " ".join(heat_warnings(driven(hot, voltage=(1.001 * most,))))


def test_hot_stators_are_warned_of(motor):
    assert not list(heat_warnings(cooled(motor, bottom="held")))
    hot = replace(
        motor, heat=motor.heat | {"highest_rise_K": 140.0, "heating_rate_K_per_s": 12.0, "foldover_number": 1.6}
    )
    texts = " ".join(heat_warnings(hot))
    for words in ("140 K above 20 degC", "300 degC", "12 K in the first second", "two stable temperatures"):
        assert words in texts


def test_the_velocity_coefficient_gives_drift_and_foldover(motor):
    constants = {"youngs_modulus": 1e11, "poisson_ratio": 0.3, "density": 7600.0}
    own = IsotropicSolid(**constants, conductivity=1.25, velocity_coefficient=-50e-6)
    stator = replace(motor.scene.stator, material=own, ends="free", mechanical_quality=1000.0)
    warm = replace(motor, scene=replace(motor.scene, stator=stator))
    block = heat_block(warm)
    assert block["frequency_drift"] == pytest.approx(-50e-6 * block["fingers_rise_K"], rel=1e-12)
    assert block["warm_amplitude_factor"] == pytest.approx(np.sinc(4 * block["frequency_drift"]), rel=1e-12)
    resistance = plate(warm.scene.stator).resistance
    assert block["foldover_number"] == pytest.approx(2 * 1000 * 50e-6 * resistance * block["power_W"], rel=1e-12)
    assert "time_constant_s" not in block  # no heat capacity


def test_the_text_and_the_files_hold_it(motor, tmp_path):
    text = str(motor)
    assert "power" in text
    assert "K/s at first, with a time constant of" in text
    motor.save(tmp_path / "run")
    from studies.record import Record

    assert Record.load(tmp_path / "run").heat == pytest.approx(motor.heat)


@pytest.mark.parametrize(
    ("cooling", "words"),
    [
        ({"air": 0.0}, "stator.cooling.air must be positive"),
        ({"ends_heat_stator": 1.5}, "stator.cooling.ends_heat_stator must be between 0 and 1, got 1.5"),
        ({"ambient": -300}, "stator.cooling.ambient must be above -273.15 and below 250 degC, got -300"),
        ({"ambient": 293.0}, "stator.cooling.ambient must be above -273.15 and below 250 degC, got 293"),
        ({"air": "10 W"}, "stator.cooling.air must be"),
        ({"bottom": "glue"}, "stator.cooling.bottom must be"),
        ({"wind": 1.0}, "stator.cooling.wind"),
    ],
)
def test_coolings_that_cannot_be_are_refused(cooling, words):
    table = {"material": "PZT-8", "length": 0.1, "thickness": 5e-3, "width": 0.03, "ends": "free", "cooling": cooling}
    with pytest.raises(SceneError, match=words):
        Scene.from_table("", {"stator": table, "drive": {"frequency": 2e6}})
