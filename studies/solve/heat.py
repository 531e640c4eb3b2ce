"""Where the power of a run goes, and how warm the stator becomes: the block ``heat`` of run.json.

At the largest level. The dielectric loss arises under the fingers, V^2 B tan(delta)/2 with the susceptance B of each
driven transducer; the rest of the loss in the solid follows the square of the surface's motion along x; what absorbing
ends take is heat of the absorber, of which `stator.cooling.ends_heat_stator` comes back over the last `END_LENGTH`.
Temperatures are those of `fem.heat`, uniform over the cross-section, and carry the band of the air's coefficient. They
are of a continuous drive, or with `drive.duty` of bursts with that share of its heat; of a lone burst
(`drive.burst` without a duty) the rise of the mean temperature is stated.

Powers of sources at several frequencies add. The heat of those that have not the first frequency lies below their own
transducer's span in x.

Not in it: friction of balls (below 1e-3 of these powers), heat of bulk waves that leave the section, and a half-space,
whose temperature never becomes steady.
"""

import math
from collections.abc import Iterator

import numpy as np

import fem
from studies.model.fem_objects import relative_frequency
from studies.model.scene_errors import input_errors
from studies.model.solid_of_material import crystal, frequency_coefficient, knows_temperature, thermal_table
from studies.record import Record
from studies.record.blocks import HeatBlock
from studies.record.waveform import modulation
from studies.scene import Scene
from studies.scene.drive import Drive
from studies.scene.stator_keys import Cooling, Stator

END_LENGTH = 5e-3  # m: of the absorber's share that heats the stator
AIR_BAND = 0.4  # of the air's coefficient, with radiation: relative half-width
FAST = 10.0  # K/s, from which on the rate of heating is a warning
POLED = 0.5  # of the Curie temperature in degC, up to which a ceramic keeps its poling
THERMAL = ("conductivity", "heat_capacity", "curie_temperature")
KNOWN_RISE = 400.0  # K, up to which coefficients of the constants are followed
STEP = 1.0  # K, of the differences that give the coefficient of the frequency


def thermal_constants(material) -> dict[str, float | None]:
    """Return the thermal constants of a stator's material; None for those that nobody gave.

    ``conductivity`` in W/(m K), ``heat_capacity`` in J/(kg K), ``curie_temperature`` in degC.
    """
    table = thermal_table(material)
    return {key: table.get(key) for key in THERMAL}


def duty(drive: Drive) -> float | None:
    """Return the share of the time for which a drive is on; None for a lone burst."""
    if drive.duty is not None or drive.burst is not None:
        return drive.duty
    return 1.0


def plate(stator: Stator, *, air: float = 1.0) -> fem.HeatedPlate | None:
    """Return the stator as a heated plate; None for a half-space or without a conductivity.

    ``air``: factor of the air's coefficient.
    """
    cooling, constants = stator.cooling or Cooling(), thermal_constants(stator.material)
    if isinstance(stator.thickness, str) or constants["conductivity"] is None:
        return None
    capacity, bottom = constants["heat_capacity"], None if cooling.bottom == "air" else cooling.bottom
    density = crystal(stator.material).density
    with input_errors("stator.cooling.air"):
        return fem.HeatedPlate(
            length=stator.length, width=stator.width, thickness=stator.thickness,
            conductivity=constants["conductivity"], volumetric_heat=None if capacity is None else density * capacity,
            film=air * cooling.air, bottom=math.inf if isinstance(bottom, str) else bottom,
        )  # fmt: skip


def powers(record: Record) -> HeatBlock:
    """Return where the power goes at the largest level, W: dielectric, along the beam, into each end, into loads."""
    electrical, highest = record.electrical, max(record.scene.levels, default=0.0)
    solid = electrical.power_solid_W_per_V2 * highest**2
    dielectric = min(sum(each for _, each in _dielectric(record)) * highest**2, max(solid, 0.0))
    return HeatBlock(
        power_W=electrical.power_W_per_V2 * highest**2,
        power_dielectric_W=dielectric,
        power_along_beam_W=solid - dielectric,
        power_left_end_W=electrical.power_radiated_left_W_per_V2 * highest**2,
        power_right_end_W=electrical.power_radiated_right_W_per_V2 * highest**2,
        power_loads_W=max(electrical.power_loads_W_per_V2, 0.0) * highest**2,
    )


def _dielectric(record: Record) -> list[tuple[str, float]]:
    """Return each driven transducer with the dielectric loss under it per squared volt of the source, W/V^2."""
    scene, electrical = record.scene, record.electrical
    loss = scene.stator.dielectric_loss
    if loss is None:
        loss = crystal(scene.stator.material).dielectric_loss
    if electrical.sources is None:
        power = abs(electrical.comb_voltage_per_volt) ** 2 * electrical.admittance_S.imag
        reactive = {str(scene.drive.transducer): power}
    else:
        reactive = {
            name: (each["current_A_per_V"] * complex(each["voltage_per_volt"]).conjugate()).imag
            for name, each in electrical.sources.items()
        }
    return [(name, 0.5 * loss * max(float(each), 0.0)) for name, each in reactive.items()]


def sources(record: Record, share: float = 1.0) -> list[fem.HeatSource]:
    """Return the sources of heat in the stator at the largest level, driven for a share of the time."""
    scene, split = record.scene, powers(record)
    split = HeatBlock(**{key: share * power for key, power in split.items()})
    length, dielectric = scene.stator.length, _dielectric(record)
    spans = {each.name: _span(each, length) for each in scene.transducer}
    scale = split.power_dielectric_W / (sum(each for _, each in dielectric) or 1.0)
    heated = [_below(spans[name], scale * power) for name, power in dielectric]
    returned, along = (scene.stator.cooling or Cooling()).ends_heat_stator, 1.0
    for name, part in _beside(record):
        along -= part
        ends = returned * (split.power_left_end_W + split.power_right_end_W)
        heated.append(_below(spans[name], part * (split.power_along_beam_W + ends)))
    heated.append(
        fem.HeatSource(
            start=0.0,
            stop=length,
            power=along * split.power_along_beam_W,
            density=_along(record),
            scale=0.5 * _wavelength(record),
        )
    )
    end = min(END_LENGTH, 0.5 * length)
    for start, power in ((0.0, split.power_left_end_W), (length - end, split.power_right_end_W)):
        heated.append(fem.HeatSource(start=start, stop=start + end, power=along * returned * power))
    return [each for each in heated if each.power > 0.0]


def _below(span: tuple[float, float], power: float) -> fem.HeatSource:
    return fem.HeatSource(start=span[0], stop=span[1], power=power)


def _beside(record: Record) -> Iterator[tuple[str, float]]:
    """Yield each source at another frequency than the first, whose wave is not recorded, and its share of the power."""
    known = record.electrical.sources or {}
    whole = sum(each["power_W_per_V2"] for each in known.values())
    for name in record.scene.drive.at_other_frequencies if known else ():
        yield name, max(known[name]["power_W_per_V2"], 0.0) / whole


def _span(transducer, length: float) -> tuple[float, float]:
    """Return where a transducer begins and ends along x, m."""
    angle, center = math.radians(transducer.angle), transducer.center_xy[0]
    half = transducer.half_length * abs(math.cos(angle)) + 0.5 * transducer.aperture * abs(math.sin(angle))
    return max(center - half, 0.0), min(center + half, length)


def _wavelength(record: Record) -> float:
    return record.wave.phase_velocity_m_per_s / record.wave.frequency_Hz


def _along(record: Record):
    """Return the density of the loss along x: the mean square of u_z over half a wavelength."""
    x, square = record.surface.x_m, np.abs(record.surface.u_z_m_per_V) ** 2
    width = 0.5 * _wavelength(record)
    integral = np.concatenate([[0.0], np.cumsum(0.5 * (square[1:] + square[:-1]) * np.diff(x))])

    def density(at: np.ndarray) -> np.ndarray:
        low, high = np.clip(at - 0.5 * width, x[0], x[-1]), np.clip(at + 0.5 * width, x[0], x[-1])
        return (np.interp(high, x, integral) - np.interp(low, x, integral)) / (high - low)

    return density


def temperature(record: Record, *, air: float = 1.0, share: float | None = None) -> fem.TemperatureProfile | None:
    """Return the temperature along the stator at the largest level; None where there is no plate or no heat.

    ``air``: factor of the air's coefficient; ``share``: of the time for which the drive is on, by default the scene's.
    """
    share = (duty(record.scene.drive) or 1.0) if share is None else share
    body, heated = plate(record.scene.stator, air=air), sources(record, share)
    return None if body is None or not heated else fem.temperature_profile(body, heated)


def heat_block(record: Record) -> HeatBlock:
    """Return the block ``heat`` of run.json; temperatures only of a plate whose conductivity is known."""
    scene, block = record.scene, powers(record)
    if not block.power_W > 0.0:
        return HeatBlock()
    block |= HeatBlock(voltage_V=max(scene.levels), duty=scene.drive.duty)
    body, on = plate(scene.stator), duty(scene.drive)
    if body is None:
        return block
    kept = sum(each.power for each in sources(record, on or 1.0))
    rate, settling = body.heating_rate(kept), body.time_constant
    if rate is not None and settling is not None:
        block |= HeatBlock(heating_rate_K_per_s=rate, time_constant_s=settling)
        if on is None:
            shape = modulation(scene)
            share = 1.0 if shape is None else shape.mean_square
            block |= HeatBlock(burst_rise_K=rate * share * scene.drive.burst)
    if on is None:
        return block
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
    return block | limits(scene, block) | _effects(record, block)


def allowed_rise(block: Stator) -> float | None:
    """Return the rise in K to half the Curie temperature; None where this is not known."""
    curie = thermal_constants(block.material)["curie_temperature"]
    return None if curie is None else POLED * curie - block.ambient


def limits(scene: Scene, block: HeatBlock) -> HeatBlock:
    """Return the largest voltages and the duty that keep the stator below half its Curie temperature and 10 K/s.

    Heat grows with the square of the voltage, as of constants that do not change with the temperature.
    """
    found, rise = HeatBlock(), allowed_rise(scene.stator)
    share = scene.drive.duty or 1.0
    if block.heating_rate_K_per_s:
        found |= HeatBlock(
            pulsed_limit_voltage_V=block.voltage_V * math.sqrt(FAST * share / block.heating_rate_K_per_s)
        )
    if rise is not None and block.highest_rise_K:
        allowed = rise * share / block.highest_rise_K
        if allowed > 0.0:
            found |= HeatBlock(
                continuous_limit_voltage_V=block.voltage_V * math.sqrt(allowed), duty_limit=min(allowed, 1.0)
            )
    return found


def drift(block: Stator, rise: float, frequency: float) -> float | None:
    """Return the relative change of the best frequency from the ambient temperature by a rise in K; None if unknown.

    ``frequency``: of the drive, Hz.
    """
    coefficient, ambient = frequency_coefficient(block), block.ambient
    if coefficient is not None:
        return coefficient * rise
    if not knows_temperature(block) or rise > KNOWN_RISE:
        return None
    warm, cold = (relative_frequency(block, each, frequency) for each in (ambient + rise, ambient))
    return warm / cold - 1.0


def frequency_slope(block: Stator, frequency: float) -> float:
    """Return the temperature coefficient of the best frequency at the ambient temperature, 1/K; ``frequency`` in Hz."""
    coefficient = frequency_coefficient(block)
    if coefficient is not None:
        return coefficient
    ambient = block.ambient
    ahead, here, behind = (relative_frequency(block, ambient + step, frequency) for step in (STEP, 0.0, -STEP))
    return (ahead - behind) / (2 * STEP * here)


def _effects(record: Record, block: HeatBlock) -> HeatBlock:
    """Return what the temperature does to the frequency; nothing without temperature coefficients."""
    scene, stator = record.scene, record.scene.stator
    change, body = drift(stator, block.fingers_rise_K, scene.frequency), plate(stator)
    if change is None or body is None:
        return HeatBlock()
    pairs = scene.driven_transducer.finger_pairs
    effects = HeatBlock(frequency_drift=change, warm_amplitude_factor=float(np.sinc(pairs * change)))
    quality = stator.mechanical_quality or crystal(stator.material).mechanical_quality
    if stator.ends != "absorbing" and math.isfinite(quality):
        number = fem.foldover_number(
            quality=quality, frequency_coefficient=frequency_slope(stator, scene.frequency), resistance=body.resistance,
            peak_power=(scene.drive.duty or 1.0) * block.power_W,
        )  # fmt: skip
        effects |= HeatBlock(foldover_number=number)
    return effects
