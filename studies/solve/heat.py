"""Where the power of a run goes, and how warm the stator becomes: the block ``heat`` of run.json.

At the largest level. The dielectric loss arises under the fingers, V^2 B tan(delta)/2 with the susceptance B of each
driven transducer; the rest of the loss in the solid follows the square of the surface's motion along x; what absorbing
ends take is heat of the absorber, of which `stator.cooling.ends_heat_stator` comes back over the last `END_LENGTH`.
Temperatures are those of `fem.heat`, uniform over the cross-section, and carry the band of the air's coefficient.

Not in it: friction of balls (below 1e-3 of these powers), heat of bulk waves that leave the section, and a half-space,
whose temperature never becomes steady.
"""

import math

import numpy as np

import fem
from studies.model.materials import crystal
from studies.record import Record
from studies.record.blocks import HeatBlock
from studies.refusal import SceneError
from studies.scene.blocks import Cooling

END_LENGTH = 5e-3  # m: of the absorber's share that heats the stator
AIR_BAND = 0.4  # of the air's coefficient, with radiation: relative half-width
FAST = 10.0  # K/s, from which on the rate of heating is a warning
THERMAL = ("conductivity", "heat_capacity", "curie_temperature", "velocity_coefficient")


def thermal_constants(material) -> dict[str, float | None]:
    """Return the thermal constants of a stator's material; None for those that nobody gave.

    ``conductivity`` in W/(m K), ``heat_capacity`` in J/(kg K), ``curie_temperature`` in degC, ``velocity_coefficient``
    in 1/K.
    """
    if isinstance(material, str):
        table = fem.catalogue_table(material)
        return {key: table.get(key) for key in THERMAL}
    return {key: getattr(material, key) for key in THERMAL}


def plate(record: Record, *, air: float = 1.0) -> fem.HeatedPlate | None:
    """Return the stator as a heated plate; None for a half-space or without a conductivity.

    ``air``: factor of the air's coefficient.
    """
    stator, cooling = record.scene.stator, record.scene.stator.cooling or Cooling()
    constants = thermal_constants(stator.material)
    if isinstance(stator.thickness, str) or constants["conductivity"] is None:
        return None
    capacity, bottom = constants["heat_capacity"], None if cooling.bottom == "air" else cooling.bottom
    density = crystal(stator.material).density
    try:
        return fem.HeatedPlate(
            length=stator.length, width=stator.width, thickness=stator.thickness,
            conductivity=constants["conductivity"], volumetric_heat=None if capacity is None else density * capacity,
            film=air * cooling.air, bottom=math.inf if isinstance(bottom, str) else bottom,
        )  # fmt: skip
    except fem.InputError as error:
        raise SceneError("stator.cooling.air", error.rule) from None


def powers(record: Record) -> HeatBlock:
    """Return where the power goes at the largest level, W: dielectric, along the beam, into each end, into loads."""
    electrical, highest = record.electrical, max(record.scene.levels, default=0.0)
    solid = electrical.power_solid_W_per_V2 * highest**2
    dielectric = min(_dielectric(record) * highest**2, max(solid, 0.0))
    return HeatBlock(
        power_W=electrical.power_W_per_V2 * highest**2,
        power_dielectric_W=dielectric,
        power_along_beam_W=solid - dielectric,
        power_left_end_W=electrical.power_radiated_left_W_per_V2 * highest**2,
        power_right_end_W=electrical.power_radiated_right_W_per_V2 * highest**2,
        power_loads_W=max(electrical.power_loads_W_per_V2, 0.0) * highest**2,
    )


def _dielectric(record: Record) -> float:
    """Return the dielectric loss per squared volt of the source, W/V^2."""
    scene, electrical = record.scene, record.electrical
    loss = scene.stator.dielectric_loss
    if loss is None:
        loss = crystal(scene.stator.material).dielectric_loss
    return 0.5 * loss * abs(electrical.comb_voltage_per_volt) ** 2 * max(electrical.admittance_S.imag, 0.0)


def sources(record: Record) -> list[fem.HeatSource]:
    """Return the sources of heat in the stator at the largest level."""
    scene, split = record.scene, powers(record)
    length = scene.stator.length
    heated = []
    driven = [each for each in scene.transducer if each.name in scene.drive.driven]
    for each in driven:
        center, half = each.center_xy[0], each.half_length
        span = max(center - half, 0.0), min(center + half, length)
        heated.append(fem.HeatSource(start=span[0], stop=span[1], power=split.power_dielectric_W / len(driven)))
    heated.append(
        fem.HeatSource(
            start=0.0,
            stop=length,
            power=split.power_along_beam_W,
            density=_along(record),
            scale=0.5 * _wavelength(record),
        )
    )
    share = (scene.stator.cooling or Cooling()).ends_heat_stator
    end = min(END_LENGTH, 0.5 * length)
    for start, power in ((0.0, split.power_left_end_W), (length - end, split.power_right_end_W)):
        heated.append(fem.HeatSource(start=start, stop=start + end, power=share * power))
    return [each for each in heated if each.power > 0.0]


def _wavelength(record: Record) -> float:
    return record.wave.phase_velocity_m_per_s / record.wave.frequency_Hz


def _along(record: Record):
    """Return the density of the loss along x: the mean square of u_z over half a wavelength."""
    x, square = record.surface["x_m"], np.abs(record.surface["u_z_m_per_V"]) ** 2
    width = 0.5 * _wavelength(record)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (square[1:] + square[:-1]) * np.diff(x))])

    def density(at: np.ndarray) -> np.ndarray:
        low, high = np.clip(at - 0.5 * width, x[0], x[-1]), np.clip(at + 0.5 * width, x[0], x[-1])
        return (np.interp(high, x, integral) - np.interp(low, x, integral)) / (high - low)

    return density


def temperature(record: Record, *, air: float = 1.0) -> fem.TemperatureProfile | None:
    """Return the temperature along the stator at the largest level; None where there is no plate or no heat."""
    body, heated = plate(record, air=air), sources(record)
    return None if body is None or not heated else fem.temperature_profile(body, heated)


def heat_block(record: Record) -> HeatBlock:
    """Return the block ``heat`` of run.json; temperatures only of a plate whose conductivity is known."""
    scene, block = record.scene, powers(record)
    if not block.power_W > 0.0:
        return HeatBlock()
    block |= HeatBlock(voltage_V=max(scene.levels))
    body = plate(record)
    if body is None:
        return block
    kept = sum(each.power for each in sources(record))
    rate, settling = body.heating_rate(kept), body.time_constant
    if rate is not None and settling is not None:
        block |= HeatBlock(heating_rate_K_per_s=rate, time_constant_s=settling)
    block |= HeatBlock(mean_rise_K=body.steady_rise(kept))
    places = {"fingers": scene.driven_transducer.center_xy[0], "left_end": 0.0, "right_end": scene.stator.length}
    if scene.slider is not None:
        places["slider"] = scene.slider.center[0]
    of_air = {"": 1.0, "_low": 1.0 + AIR_BAND, "_high": 1.0 - AIR_BAND}
    for suffix, air in of_air.items():
        warm = temperature(record, air=air)
        if warm is None:
            return block
        rises = warm.at(np.clip(list(places.values()), 0.0, scene.stator.length)).tolist()
        block |= {f"{name}_rise{suffix}_K": rise for name, rise in zip(places, rises, strict=True)}
        place, highest = warm.hottest()
        block |= {f"highest_rise{suffix}_K": highest} | ({} if suffix else {"hottest_x_m": place})
    return block | _effects(record, block)


def _effects(record: Record, block: HeatBlock) -> HeatBlock:
    """Return what the temperature does to the frequency, with the velocity's coefficient; nothing without it."""
    constants, stator = thermal_constants(record.scene.stator.material), record.scene.stator
    coefficient = constants["velocity_coefficient"]
    if coefficient is None:
        return HeatBlock()
    drift = coefficient * block.fingers_rise_K
    pairs = record.scene.driven_transducer.finger_pairs
    effects = HeatBlock(frequency_drift=drift, warm_amplitude_factor=float(np.sinc(pairs * drift)))
    if stator.ends != "absorbing":
        quality = stator.mechanical_quality or crystal(stator.material).mechanical_quality
        body = plate(record)
        assert body is not None
        number = fem.foldover_number(
            quality=quality, frequency_coefficient=coefficient, resistance=body.resistance, peak_power=block.power_W
        )
        effects |= HeatBlock(foldover_number=number)
    return effects


def heat_warnings(record: Record):
    """Yield what the heat of a continuous drive asks for, each with a remedy."""
    block, stator = record.heat, record.scene.stator
    cooling = stator.cooling or Cooling()
    constants = thermal_constants(stator.material)
    highest, curie = block.highest_rise_K, constants["curie_temperature"]
    if highest is not None and curie is not None and cooling.ambient + highest > 0.5 * curie:
        yield (
            f"a continuous drive at {block.voltage_V:g} V warms the stator by {highest:.3g} K above "
            f"{cooling.ambient:g} degC at x = {1e3 * block.hottest_x_m:.3g} mm, more than half of its Curie "
            f"temperature of {curie:g} degC: the poling suffers; cool the stator, lower the voltage or drive in bursts"
        )
    if (block.heating_rate_K_per_s or 0.0) > FAST:
        yield (
            f"at {block.voltage_V:g} V the stator warms by {block.heating_rate_K_per_s:.3g} K in the first "
            "second: drive in bursts, or glue it to metal (stator.cooling.bottom)"
        )
    if (block.foldover_number or 0.0) > fem.FOLDOVER_LIMIT:
        yield (
            f"between reflecting ends the warm resonance has two stable temperatures at {block.voltage_V:g} V "
            f"(foldover number {block.foldover_number:.3g}, two states from 1.54 on): approach it from above where "
            "the frequency falls with temperature, from below where it rises, or follow the resonance"
        )
    body = plate(record)
    if body is not None and body.bottom is None and body.biot_number > fem.MAX_BIOT_NUMBER:
        yield (
            f"the Biot number of the stator is {body.biot_number:.2g}: its temperatures differ through the thickness, "
            "which the stated ones leave out"
        )
