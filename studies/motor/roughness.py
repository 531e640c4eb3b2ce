"""What the roughness of the balls does to threshold, release and velocity, and which roughness a threshold tells.

Method: the balls of a scene (``twente-contact`` by default) with a roughness of 0.5 to 10 nm: eight samples of
asperities (`contact.RoughBalls`), and the mean field where ten asperities or more carry a ball. The threshold is the
level at which the slider runs at 0.2 mm/s, because rough balls have no sharp one; the release is that at which the
first ball leaves the surface in every cycle. Beside them stand smooth balls with the elastic law, and with the
hysteretic one. A measured threshold (``--measured "4.2 V"``, or ``"0.9 nm"`` on a prescribed
wave) becomes a roughness: that at which the median of the samples has this threshold, with the range in which one of
the eight has it. Expected: the threshold grows with the roughness; rough balls differ more from each other the rougher
they are; the mean field lies at their lower end, for it is softer. Run time: about 50 s, plus the time of the stator.
"""

import logging
import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

import contact
from studies.model.roughness_of_balls import FEWEST, drawn_asperities, limits_of, orbits_of_each, rough_balls, touching
from studies.model.scene_errors import as_run_errors, slider_keys
from studies.model.wave_to_contact import Contact, scaled
from studies.record.plots import COLOURS, curve, family, finished, logarithmic, titled, upper_half
from studies.record.prefixes import key_axis, si
from studies.record.quantities import quantity
from studies.record.text import csv_text, percent
from studies.scene import Scene
from studies.scene.numbers import Quantity
from studies.scene.override import toml_value
from studies.scene.roughness_keys import STARTS, Roughness
from studies.scene.slider_keys import Slider
from studies.study_list import Answered, Panel, StudyRecord, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

RMS = (0.5e-9, 1e-9, 2e-9, 3e-9, 5e-9, 7e-9, 10e-9)  # m: balls of bearings have 1 to 10 nm over some um
QUICK = {"rms": (3e-9, 7e-9), "levels": 2}
CROWD = 1200  # asperities drawn for a ball from which on samples differ by less than 5 % and cost minutes
LATER = 1.5  # release of rough balls over that of smooth ones: 1.1 to 3
SCATTER = 3e-3  # tolerance of the velocities, whose scatter is far larger
RANGE = ("lowest", "median", "highest")  # of the samples
FRICTION = 1.1  # factor on the friction coefficient that a reading is repeated with


@dataclass(frozen=True)
class Read:
    """Threshold and release as levels, and the speeds in m/s at levels, of balls with one sample or one mean field."""

    threshold: float
    release: float
    speeds: tuple[float | None, ...]  # None: samples of too many asperities


@study("twente-contact")
def run(
    scene: Scene, *, measured: str | float | None = None, rms: tuple[float, ...] = RMS, levels: int = 4,
    tolerance: float = 1e-3,
) -> Answered:  # fmt: skip
    """Return threshold, release and velocity against the roughness, and the roughness of a measured threshold.

    Parameters
    ----------
    measured : str or float, optional
        Level at which the slider runs at 0.2 mm/s, as text with its unit, or in V or m.
    rms : tuple of float
        Roughnesses, m, rising.
    levels : int
        Number of the scene's levels at which velocities are computed, the largest included.
    tolerance : float
        Of the stator's wave.
    """
    block, smooth = _without_roughness(scene)
    level = None if measured is None else _level(smooth, measured)
    driven = driven_contact(smooth, tolerance=tolerance)
    at, limits, rows = driven.spread(1.05, levels), {}, []
    for law in ("elastic", "hysteretic"):
        limits[law] = _smooth(driven, law, at)
    for k, each in enumerate(rms, start=1):
        LOGGER.info(f"roughness: {k} of {len(rms)}, {each * 1e9:.3g} nm")
        # the law as written: where it is absent, the roughness decides
        slider = replace(driven.scene.slider, law=smooth.slider.law, roughness=replace(block, rms=each))
        rows.append(_row(driven, slider, at))
    rest = float(driven.slider.rest_approach(driven.contacts))
    kinds = (*RANGE, "mean_field")
    data: dict[str, Any] = {
        "rms_m": list(rms), "level_key": driven.scene.level_key,
        "level": at, "names": list(map(driven.scene.named, at)),
        "johnson_number": [contact.johnson_number(each, rest) for each in rms],
        "asperities": [row["asperities"] for row in rows],
        "smooth": {law: vars(each) for law, each in limits.items()},
    }  # fmt: skip
    for key in ("threshold", "release", "speeds"):
        data[key] = {kind: [row[kind] and getattr(row[kind], key) for row in rows] for kind in kinds}
    answer = list(_sentences(driven, data))
    if level is not None:
        data["measured"] = level
        answer.append(("measured", _reading(driven, data, level)))
    panel = Panel(name="roughness", title=f"{driven.scene.title}: roughness of the balls", data=data)
    return (panel,), _findings(data), answer


def _without_roughness(scene: Scene) -> tuple[Roughness, Scene]:
    """Return the roughness of a scene, whose rms is changed, and the scene without it.

    Refuse one whose balls cannot be rough, or have a measured surface.
    """
    if scene.slider is None:
        scene.refuse("slider", "is missing: this study needs a slider")
    scene.refuse_pillars("must be absent: this study is that of balls")
    block = scene.slider.roughness
    if block is not None and block.file is not None:
        scene.refuse("slider.roughness.file", "must be absent in this study, which changes slider.roughness.rms")
    law = {"law": None} if scene.slider.law == "hysteretic" else {}
    if block is None:
        scene.replace(slider=law | {"roughness": {"rms": RMS[0]}})  # what does not go with roughness is refused
    return block or Roughness(rms=RMS[0]), scene.replace(slider=law | {"roughness": None})


def _level(scene: Scene, measured: str | float) -> float:
    """Return a measured threshold as a level."""
    value = toml_value(measured) if isinstance(measured, str) else measured
    return Quantity("V" if scene.wave is None else "m").read("--measured", value)


def _smooth(driven: Contact, law: str, at: list[float]) -> Read:
    """Return the answers of smooth balls with a law."""
    body = replace(driven.slider, law=law)

    def speed(level):
        return abs(float(contact.steady(body, driven.at(level), tolerance=SCATTER).velocity))

    with slider_keys():
        low = high = contact.threshold_factor(body, driven.orbits)
        while speed(high) < STARTS:
            high *= 1.2
        threshold = brentq(lambda level: speed(level) - STARTS, low, high, rtol=1e-3) if high > low else low
        return Read(float(threshold), float(contact.release_factor(body, driven.orbits)), tuple(map(speed, at)))


def _row(driven: Contact, slider: Slider, at: list[float]) -> dict[str, Any]:
    """Return the answers at one roughness, None where there is none: of the mean field, and the range of the samples.

    Lowest, median and highest of each number are taken on their own. Waves that bring more than `CROWD` asperities of
    a ball near the surface have no samples.
    """
    block = slider.roughness
    field, sample = (replace(slider, roughness=replace(block, seed=seed)) for seed in (None, block.seed or 0))
    row: dict[str, Any] = dict.fromkeys((*RANGE, "mean_field")) | {"asperities": touching(field)}
    if row["asperities"] >= FEWEST:
        (row["mean_field"],) = _rough(driven, field, at)
    size = max(abs(each.normal) for each in driven.orbits)
    few = [level for level in at if drawn_asperities(sample, level * size) <= CROWD]
    if drawn_asperities(sample, _first_release(driven) * size) <= CROWD:
        found = _rough(driven, sample, few)
        numbers = np.array([[each.threshold, each.release, *each.speeds] for each in found], dtype=float)
        missing = [None] * (len(at) - len(few))
        for kind, own in zip(RANGE, np.quantile(numbers, (0.0, 0.5, 1.0), axis=0).tolist(), strict=True):
            row[kind] = Read(own[0], own[1], (*own[2:], *missing))
    return row


def _first_release(driven: Contact) -> float:
    """Return the level from which the search for the release of rough balls starts."""
    return LATER * float(contact.release_factor(driven.slider, driven.orbits))


def _rough(driven: Contact, slider: Slider, at: list[float]) -> list[Read]:
    """Return the answers of the mean field of a slider's balls, or of each of its samples."""
    orbits, size = orbits_of_each(slider, driven.orbits), max(abs(each.normal) for each in driven.orbits)
    largest, found = _first_release(driven), []
    with slider_keys(), as_run_errors("slider.roughness:"):
        limits = limits_of(slider, driven.orbits, largest * size, STARTS, tolerance=SCATTER)
        for own, balls in zip(limits, rough_balls(slider, max(at, default=largest) * size), strict=True):
            waves = [scaled(orbits, level) for level in at]
            speeds = (abs(balls.velocity(each, tolerance=SCATTER).value) for each in waves)
            found.append(Read(*own, tuple(speeds)))
    return found


def roughness_at(data: Any, level: float) -> dict[str, str]:
    """Return the roughness whose median threshold is a level, and those at which the lowest and highest are, in words.

    ``data``: of the panel; between its roughnesses the logarithm is interpolated.
    """
    known = [k for k, each in enumerate(data["threshold"]["median"]) if each is not None]
    rms = [data["rms_m"][k] for k in known]

    def at(kind):
        rising = np.maximum.accumulate([data["threshold"][kind][k] for k in known])
        if level < rising[0]:
            return f"less than {rms[0] * 1e9:.3g} nm"
        if level > rising[-1]:
            return f"more than {rms[-1] * 1e9:.3g} nm"
        return f"{1e9 * float(np.exp(np.interp(level, rising, np.log(rms)))):.2g} nm"

    return {kind: at(kind) for kind in RANGE}


def _reading(driven: Contact, data: Any, level: float) -> str:
    """Return in words the roughness that a measured threshold tells."""
    named, smooth = driven.scene.named, data["smooth"]["elastic"]["threshold"]
    if all(each is None for each in data["threshold"]["median"]):
        return f"{named(level)} tells no roughness: there are no samples of so many asperities"
    if level < smooth:
        return (
            f"{named(level)} tells no roughness: smooth balls start at {named(smooth)}; the friction coefficient or "
            "the preload is smaller, or the wave larger"
        )
    found = roughness_at(data, level)
    more = replace(driven.slider, friction_coefficient=FRICTION * driven.slider.friction_coefficient)
    factor = contact.threshold_factor(more, driven.orbits) / contact.threshold_factor(driven.slider, driven.orbits)
    return (
        f"{named(level)} is the threshold of balls with a roughness of {found['median']} (one of eight: "
        f"{found['highest']} to {found['lowest']}); with a friction coefficient larger by 10 %: "
        f"{roughness_at(data, level / factor)['median']}"
    )


def _sentences(driven: Contact, data: Any):
    """Yield label and text of each line of the answer."""
    named = driven.scene.named
    for law, each in data["smooth"].items():
        speed = si(each["speeds"][-1], "m/s", 4)
        yield (
            f"smooth, {law}",
            f"threshold {named(each['threshold'])}, release {named(each['release'])}, {speed} at {data['names'][-1]}",
        )
    first = data["smooth"]["elastic"]["speeds"][0]
    for k, rms in enumerate(data["rms_m"]):
        kind = "median" if data["threshold"]["median"][k] is not None else "mean_field"
        if data["threshold"][kind][k] is None:
            yield f"{rms * 1e9:.3g} nm", "too few asperities for a mean field, too many for samples"
            continue

        def values(key, shown, k=k, kind=kind):
            low, middle, high = (data[key][each][k] for each in ("lowest", kind, "highest"))
            return shown(middle) + (f" ({shown(low)} to {shown(high)})" if low is not None else "")

        text = f"threshold {values('threshold', named)}, release {values('release', named)}"
        if data["speeds"][kind][k][0] is not None:
            change = values("speeds", lambda speeds: percent(speeds[0] / first - 1.0))
            text += f", velocity at {data['names'][0]} {change}"
        yield f"{rms * 1e9:.3g} nm", text


def _findings(data: Any):
    """Yield the checks of what is expected."""
    low, median, high, field = (
        np.array([math.nan if each is None else each for each in data["threshold"][kind]])
        for kind in (*RANGE, "mean_field")
    )
    sampled, both = np.isfinite(median), np.isfinite(median) & np.isfinite(field)
    if sampled.sum() > 1:
        rising = median[sampled]
        yield judged("The threshold grows with the roughness.", "median threshold, largest over smallest roughness",
                     rising[-1] / rising[0], low=1.0, holds=np.all(np.diff(rising) > 0.0))  # fmt: skip
        width = ((high - low) / median)[sampled]
        yield judged("Rougher balls differ more from each other.", "range of the thresholds over their median, largest "
                     "over smallest roughness", width[-1] / width[0], low=1.0)  # fmt: skip
    if both.any():
        inside = (low <= field) & (field <= high)
        yield judged("The mean field lies within the samples.", "mean thresholds within the range of the samples",
                     np.mean(inside[both]), low=0.5, high=1.0 + 1e-9, expected="at least half of them")  # fmt: skip


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the table of all numbers: threshold and release in V or m, speed in m/s at each level."""
    data, rows = record.panel().data, []

    def add(k, name, level, values):
        numbers = {kind: value(k) for kind, value in values.items()}
        rows.append({"rms_m": data["rms_m"][k], "quantity": name, "level": level} | numbers)

    for k in range(len(data["rms_m"])):
        for key in ("threshold", "release"):
            add(k, key, None, {kind: each.__getitem__ for kind, each in data[key].items()})
        for number, level in enumerate(data["level"]):
            add(k, "speed_m_per_s", level, {
                kind: lambda k, each=each, number=number: each[k] and each[k][number]
                for kind, each in data["speeds"].items()
            })  # fmt: skip
    return {"roughness.csv": csv_text(rows)}


@of_record
def figure(record: Panel, ax):
    """Draw threshold and release above, and below the speed over that of smooth balls at each level."""
    data, x = record.data, 1e9 * np.asarray(record.data["rms_m"])
    factor, label = key_axis(data["level_key"], max(data["level"]))
    upper = upper_half(ax, share=True)
    for key, colour in (("threshold", "slip"), ("release", "intermittent")):
        _band(upper, x, {kind: _numbers(each, factor) for kind, each in data[key].items()}, colour, key)
        for law, style in (("elastic", "--"), ("hysteretic", ":")):
            upper.axhline(factor * data["smooth"][law][key], color=COLOURS[colour], linestyle=style, linewidth=0.9)
    if "measured" in data:
        upper.axhline(factor * data["measured"], color=COLOURS["line"], linewidth=1)
        upper.annotate("measured", (1.0, factor * data["measured"]), xycoords=("axes fraction", "data"), ha="right",
                       va="bottom", fontsize="small")  # fmt: skip
    upper.set_ylabel(label, fontsize="small")
    logarithmic(upper.yaxis)
    upper.legend(fontsize="small", loc="upper left", frameon=False)
    for number, (name, _, colour) in enumerate(family(dict(zip(data["names"], data["level"], strict=True)))):
        smooth = data["smooth"]["elastic"]["speeds"][number]
        at = {
            kind: _numbers([each and each[number] for each in speeds], 1.0 / smooth)
            for kind, speeds in data["speeds"].items()
        }
        _band(ax, x, at, colour, name)
        limit = data["smooth"]["hysteretic"]["speeds"][number] / smooth
        ax.axhline(limit, color=COLOURS[colour], linestyle=":", linewidth=0.9)
    ax.axhline(1.0, color=COLOURS["line"], linestyle="--", linewidth=0.9)
    for style, name in (("--", "smooth, elastic"), (":", "smooth, hysteretic")):
        curve(ax, [], [], style, "line", name)
    curve(ax, [], [], "o", "line", "mean field")
    ax.fill_between([], [], color=COLOURS["line"], alpha=0.25, linewidth=0, label="eight samples, median")
    logarithmic(ax.xaxis)
    titled(upper, record.title)
    finished(ax, f"rms roughness of the balls ({quantity.normal_amplitude_m.shown})", "velocity over smooth", "")
    ax.yaxis.label.set_fontsize("small")
    return ax


def _numbers(values, factor: float) -> np.ndarray:
    return np.array([math.nan if each is None else factor * each for each in values])


def _band(ax, x, values: dict, colour: str, label: str) -> None:
    """Draw the range of the samples with their median, and the mean field as points."""
    ax.fill_between(x, values["lowest"], values["highest"], color=COLOURS[colour], alpha=0.25, linewidth=0)
    curve(ax, x, values["median"], "-", colour, label)
    curve(ax, x, values["mean_field"], "o", colour)
