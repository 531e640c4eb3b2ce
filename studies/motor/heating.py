"""How warm a drive makes the stator: temperature along it and in time, duty, drift of the passband, velocity when hot.

Method: the power balance of a run of the scene (``twente`` by default) at its largest level gives the sources of heat
along the stator, a fin of uniform cross-section its temperature (Carslaw and Jaeger, section 4.2), steady and after
several times of a continuous drive; the band is that of the air's coefficient, +-40 %. Where temperature coefficients
are known, the passband of the driven transducer warm and cold, and with a slider its velocity at the stator's own
steady temperature beside the cold one. Expected: the faces take the whole heat; the mean temperature first rises by
power over heat capacity. Run time: about 8 s.
"""

import logging
import math
from dataclasses import replace

import numpy as np

import fem
from studies.model.model import model_of
from studies.model.solid_of_material import crystal, knows_temperature
from studies.record import Record
from studies.record.plots import COLOURS, curve, family, finished, lines
from studies.record.prefixes import si
from studies.record.quantities import quantity
from studies.refusal import RunError, SceneError, refuse_if
from studies.runs import run as run_chain
from studies.scene import Scene
from studies.solve import passband
from studies.solve.heat import AIR_BAND, allowed_rise, plate, temperature, thermal_constants
from studies.study_list import Answered, Finding, Panel, StudyRecord, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"tolerance": 0.1}
FRACTIONS = (0.01, 0.1, 0.3, 1.0)  # of the slowest time constant, at which the temperature is drawn
PLACES = 401
DUTIES = np.linspace(0.0, 1.0, 41)
FIRST = 1e-3  # of the time constant, over which the first rise is judged; its loss to the air is half of that


@study("twente")
def run(scene: Scene, *, times: tuple[float, ...] | None = None, tolerance: float = 1e-3) -> Answered:
    """Return the temperature along the stator, its highest against the duty, and what it does to wave and slider.

    Parameters
    ----------
    times : tuple of float, optional
        Times of a continuous drive in s; by default fractions of the time constant.
    tolerance : float
        Of the runs.
    """
    if scene.stator is None:
        scene.refuse("stator", "is missing: this study needs a driven one")
    cold = passband.driven_model(replace(scene, stator=scene.stator.cold)).scene
    cold, warms = cold.with_source(burst=None, duty=None), knows_temperature(cold.stator)
    record = run_chain(cold if warms else cold.at_level(max(cold.levels)), tolerance=tolerance)
    warm, body = temperature(record), plate(cold.stator)
    if body is None:
        known = thermal_constants(cold.stator.material)["conductivity"] is None
        rule = "needs a conductivity" if known else "must be a length: a half-space never becomes steady"
        raise SceneError("stator.material" if known else "stator.thickness", rule)
    if warm is None:
        refuse_if(not max(cold.levels) > 0.0, cold.level_key, "must have a level above 0: nothing is heated")
        rule = "must be given, or stator.cooling.ends_heat_stator: a lossless stator with cooled ends stays cold"
        raise SceneError("stator.mechanical_quality", rule)
    if times is None:
        times = () if body.volumetric_heat is None else tuple(each * warm.time_constants[0] for each in FRACTIONS)
    elif body.volumetric_heat is None:
        name = crystal(cold.stator.material).name
        rule = f'must be given: the solid "{name}" has none; its steady temperature needs none, its time does'
        raise SceneError("stator.material.heat_capacity", rule)
    panels = [_profile(record, warm, times), _duty(record)]
    findings: tuple[Finding, ...] = (
        judged("The faces take the whole heat.", "heat into the surroundings over the sources'",
               warm.heat_to_surroundings() / warm.power, low=1 - 1e-9, high=1 + 1e-9, expected="1"),
    )  # fmt: skip
    if body.volumetric_heat is not None:
        first = FIRST * float(warm.time_constants[0])
        findings += (
            judged("At first the mean temperature rises by power over heat capacity.",
                   "mean rise over that of the power", _mean(warm, first) / body.heating_rate(warm.power) / first,
                   low=0.99, high=1.001, expected="1, less the air's share of 0.0005"),
        )  # fmt: skip
    block = record.heat
    band = f"{block.highest_rise_low_K:.3g} to {block.highest_rise_high_K:.3g} K"
    place = si(block.hottest_x_m, "m", 3)
    answer = [("hottest", f"{si(block.highest_rise_K, 'K', 3)} ({band}) above the surroundings at x = {place}")]
    if block.continuous_limit_voltage_V is not None:
        most = si(block.continuous_limit_voltage_V, "V", 3)
        share = (
            "" if block.duty_limit == 1.0 else f"; {block.voltage_V:g} V for {100 * block.duty_limit:.3g} % of the time"
        )
        answer.append(("at most", f"{most} continuous, by half the Curie temperature{share}"))
    if block.frequency_drift is not None:
        panels.append(_passband(record))
        drifted = f"{1e6 * block.frequency_drift:.3g} ppm of the frequency"
        answer.append(("drift", f"{drifted}, amplitude at a fixed frequency x {block.warm_amplitude_factor:.4g}"))
        if cold.slider is not None:
            answer.append(_velocities(record, panels, tolerance))
    elif warms:
        answer.append(("effect", "too hot for the temperature coefficients: cool the stator, or lower the voltage"))
    else:
        answer.append(("effect", "stator.temperature_coefficient is not given: the temperature is computed, its effect "
                       "on the wave is not"))  # fmt: skip
    return panels, findings, answer


def _mean(warm: fem.TemperatureProfile, time: float) -> float:
    """Return the mean rise in K along the stator after a time, by Gauss's rule on each element."""
    points, weights = np.polynomial.legendre.leggauss(12)
    ends = warm.breakpoints
    x = ends[:-1, None] + 0.5 * np.diff(ends)[:, None] * (points + 1.0)
    return float((0.5 * np.diff(ends)[:, None] * weights * warm.at(x, time)).sum() / warm.plate.length)


def _profile(record: Record, warm: fem.TemperatureProfile, times: tuple[float, ...]) -> Panel:
    x = np.linspace(0.0, warm.plate.length, PLACES)
    curves = {f"after {si(time, 's', 3)}": warm.at(x, time) for time in times} | {"steady": warm.at(x)}
    band = [each.at(x) for sign in (1, -1) if (each := temperature(record, air=1.0 + sign * AIR_BAND)) is not None]
    title = f"{record.scene.title}: continuous drive at {record.heat.voltage_V:g} V"
    data = {"x_m": x, "rise_K": curves, "low_K": band[0], "high_K": band[1]}
    return Panel(name="temperature", title=title, data=data | _limit(record))


def _limit(record: Record) -> dict[str, float]:
    """Return the rise to half the Curie temperature, if it is known."""
    allowed = allowed_rise(record.scene.stator)
    return {} if allowed is None else {"limit_K": allowed}


def _duty(record: Record) -> Panel:
    block = record.heat
    data = {"duty": DUTIES, **{name: DUTIES * block[f"highest_rise{side}_K"] for name, side in
            (("rise_K", ""), ("low_K", "_low"), ("high_K", "_high"))}}  # fmt: skip
    title = f"{record.scene.title}: bursts at {block.voltage_V:g} V"
    return Panel(name="duty", title=title, data=data | _limit(record))


def _passband(record: Record) -> Panel:
    """Return the quasi-static passband cold, and shifted by the rise at the fingers."""
    scene, block = record.scene, record.heat
    model = model_of(scene)
    at, estimate = passband.frequencies(model, None, PLACES), passband.expected(model)
    warm = at / (1.0 + block.frequency_drift)
    data = {"frequency_Hz": at, "normal_m_per_V": estimate.normal(at), "warm_m_per_V": estimate.normal(warm),
            "drive_frequency_Hz": scene.frequency}  # fmt: skip
    title = f"{scene.title}: fingers +{block.fingers_rise_K:.3g} K"
    return Panel(name="passband", title=title, data=data)


def _velocities(cold: Record, panels: list[Panel], tolerance: float) -> tuple[str, str]:
    """Return the velocity at the largest level warm and cold in words, and add the panel of all levels."""
    try:
        hot = run_chain(
            replace(cold.scene, stator=replace(cold.scene.stator, temperature="steady")), tolerance=tolerance
        )
    except RunError as error:
        return "velocity", f"not known when warm: {error}"
    degrees, (slow, fast) = hot.heat.steady_temperature_degC, (float(each.velocity[-1]) for each in (cold, hot))
    curves = {"cold": np.abs(cold.velocity), f"at {degrees:.3g} degC": np.abs(hot.velocity)}
    data = {"level": cold.column(cold.level), quantity.velocity_m_per_s.column: curves, "level_key": cold.level}
    panels.append(Panel(name="velocity", title=f"{cold.scene.title}: velocity warm and cold", data=data))
    return "velocity", f"{si(fast, 'm/s', 4)} at {degrees:.3g} degC, {si(slow, 'm/s', 4)} cold"


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the file of the temperature along the stator: steady, with its band, and after each time."""
    data = record.panel("temperature").data
    columns = {"x_m": data["x_m"], "low_K": data["low_K"], "high_K": data["high_K"]}
    columns |= {f"{name.replace(' ', '_')}_K": values for name, values in data["rise_K"].items()}
    rows = zip(*(np.asarray(each).tolist() for each in columns.values()), strict=True)
    return {"temperature.csv": "\n".join([",".join(columns), *(",".join(map(repr, row)) for row in rows), ""])}


@of_record
def figure(record: Panel, ax):
    """Draw the temperature along the stator or against the duty, the passband, or the velocity against the level."""
    data = record.data
    if record.name == "passband":
        curves = (("normal_m_per_V", "-", "line", "cold"), ("warm_m_per_V", "-", "slip", "warm"))
        across = quantity.frequency_Hz
        ax.axvline(data["drive_frequency_Hz"] * across.scale, color=COLOURS["line"], linewidth=0.8, linestyle=":")
        return lines(ax, record, across, curves, quantity.normal_m_per_V)
    if record.name == "velocity":
        level, speed = quantity(data["level_key"]), quantity.velocity_m_per_s
        for name, values, colour in family(data[quantity.velocity_m_per_s.column]):
            curve(ax, np.asarray(data["level"]) * level.scale, np.asarray(values) * speed.scale, ".-", colour, name)
        return finished(ax, level.axis, speed.axis, record.title)
    if record.name == "duty":
        share = quantity.duty_limit
        label, x = share.axis, share.scale * np.asarray(data["duty"])
        curve(ax, x, data["rise_K"], "-", "slip", "hottest place")
    else:
        label, x = quantity.x_m.axis, np.asarray(data["x_m"]) * quantity.x_m.scale
        for name, values, colour in family(data["rise_K"]):
            curve(ax, x, values, "-", colour, name)
    ax.fill_between(x, data["low_K"], data["high_K"], color=COLOURS["stick"], alpha=0.25, linewidth=0,
                    label=f"steady, air's coefficient {100 * AIR_BAND:+.0f} to {-100 * AIR_BAND:+.0f} %")  # fmt: skip
    highest = float(np.max(data["high_K"]))
    if math.isfinite(limit := data.get("limit_K", math.inf)) and limit < 2.0 * highest:
        ax.axhline(
            limit, color=COLOURS["intermittent"], linewidth=1, linestyle="--", label="half the Curie temperature"
        )
    ax.set_ylim(bottom=0.0)
    return finished(ax, label, quantity("heat.highest_rise_K").axis, record.title, columns=3)
