"""Estimates of what the surfaces of real balls change, as fields of `stator_effects.Effect`.

Without ``slider.roughness`` the model's balls are smooth; they are dry and clean. Effects that a run computes have no
line: with a roughness there is that by which one ball differs from another. Sources:

- roughness: `rough_balls.csv`, computed with samples of asperities by ``python -m studies.evidence.rough_balls`` for
  the ball of Feenstra and Breedveld; by Johnson's number alpha = sigma/z_0 (Greenwood, Johnson and Matsubara, Wear 100
  (1984) 47) and the amplitude over the approach at rest it serves others;
- tangential law: the same table, the hysteretic law over the elastic one on the smooth ball;
- adhesion: Derjaguin, Muller and Toporov, J. Colloid Interface Sci. 53 (1975) 314, removed by roughness where
  E sigma^1.5/(w beta^0.5) is above 10 (Fuller and Tabor, Proc. R. Soc. A 345 (1975) 327);
- meniscus: 4 pi gamma R.
"""

import csv
import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

import contact
from studies.model.wave_to_contact import contact_slider
from studies.record import Record
from studies.record.point import Point
from studies.remarks.stator_effects import Effects
from studies.solve.solved_stator import contact_of_run

TABLE = Path(__file__).with_name("rough_balls.csv")
RMS = 3e-9  # m: of a bearing ball over the size of its contact (ISO 3290-1 allows 10 to 20 nm over larger lengths)
ADHESION = 0.05  # J/m^2: work of adhesion of clean oxides in air, also of pillars
WATER = 0.072  # N/m: surface tension
MEMORY_TOLERANCE = 3e-3  # of a velocity that is compared
REMOVED = 10.0  # Fuller's and Tabor's number above which roughness removes adhesion
DECIDES = 0.1  # relative change from which a warning is given, also of `run_warnings`
STEPS, BALANCED = 20, 1e-6  # of the search for tilts; moment over the preload and the largest distance
ON_A_LINE = 0.999  # correlation of the balls' places above which they stand on one line
ROUGHNESS, MEMORY = "roughness of the balls", "memory of the tangential contact"
FIELD = "single asperities instead of their mean field"
STARTS, LOST, CLEAN, WET = (
    f"{ROUGHNESS}: where they start",
    f"{ROUGHNESS}: their adhesion",
    "adhesion of clean smooth balls",
    "meniscus of water at the balls",
)
OTHER_BALL, SPLIT = "another ball of the same roughness", "loads of the balls by statics instead of one height"
AT_LARGEST = (
    ROUGHNESS,
    MEMORY,
    OTHER_BALL,
    FIELD,
    SPLIT,
)  # stated at the largest level: near the threshold they decide everything


@cache
def _table() -> dict[float, np.ndarray]:
    """Return the rows of `rough_balls.csv` by alpha: amplitude, median, lowest, highest, mean field, shape (5, k)."""
    with TABLE.open(encoding="utf-8") as file:
        rows = np.array([[float(each) for each in row] for row in list(csv.reader(file))[1:]])
    return {float(alpha): rows[rows[:, 0] == alpha, 1:].T for alpha in np.unique(rows[:, 0])}


def ratio(alpha: float, amplitude: float) -> tuple[float, float, float, float]:
    """Return the velocity of rough balls over that of the smooth elastic one: median, lowest, highest, mean field.

    Parameters
    ----------
    alpha : float
        sigma/z_0; 0 for the hysteretic law on the smooth ball. Beyond the table its last value counts.
    amplitude : float
        |u_z|/z_0; 0 gives ratios of the threshold amplitudes.

    Returns
    -------
    tuple of float
        Of eight samples of asperities the first three.
    """

    def at(rows: np.ndarray) -> list[float]:
        if amplitude == 0.0:
            return [float(each) for each in rows[1:, 0]]
        x = np.log(rows[0, 1:])
        return [float(np.interp(math.log(amplitude), x, each[1:])) for each in rows[1:]]

    columns = np.array([at(rows) for rows in _table().values()]).T
    median, lowest, highest, field = (float(np.interp(alpha, list(_table()), each)) for each in columns)
    return median, lowest, highest, field


def ball_surface(record: Record) -> Effects:
    """Yield what does not depend on the level: the threshold of rough balls, adhesion and a meniscus."""
    slider = record.scene.slider
    if not _on_balls(record):
        return
    body, balls = contact_slider(slider.along_x), slider.computed_contacts
    alpha, preload, rms, block = _alpha(record), body.preload, _rms(record), slider.roughness
    if block is None and slider.normal_law is None:
        median, lowest, highest, _ = np.array(ratio(alpha, 0.0)) / _own(slider, 0.0)
        how = f"{rms * 1e9:g} nm assumed, {alpha:.2g} of the approach at rest"
        yield STARTS, "the threshold", float(median) - 1.0, f"{how}; eight balls: {lowest:.3g} to {highest:.3g}"
    own: Any = slider.adhesion
    if own is not None and own.work is None:
        return
    work, model = (ADHESION, "DMT") if own is None else (own.work, own.model)
    asperity = (block and block.asperity_radius) or contact.Roughness(rms=rms).asperity_radius
    number = body.effective_modulus * rms**1.5 / (work * math.sqrt(asperity))
    model = "JKR" if model == "JKR" else "DMT"  # of Maugis between both
    pull = contact.AdhesiveSphere(radius=slider.radius, modulus=body.effective_modulus, work=work, model=model).pull_off
    if own is not None:
        if number > REMOVED:
            how = f"which {rms * 1e9:.3g} nm, assumed, remove (number of Fuller and Tabor {number:.2g})"
            yield LOST, "the preload", -balls * pull / preload, f"{work:g} J/m^2, {how}"
        return
    removed = f"which a roughness of {rms * 1e9:.3g} nm removes" if number > REMOVED else "which their roughness leaves"
    how = f"{work:g} J/m^2, {removed} (number of Fuller and Tabor {number:.2g})"
    yield CLEAN, "the preload", balls * pull / preload, how
    meniscus = contact.meniscus_force(slider.radius, WATER)
    yield WET, "the preload", balls * meniscus / preload, "4 pi gamma R; none in vacuum"


def ball_surface_at(record: Record, point: Point) -> Effects:
    """Yield the changes of the velocity at a point by roughness and by the tangential law."""
    speed, slider = point.velocity_m_per_s or point.rotation_rpm, record.scene.slider
    if not _on_balls(record) or not speed or not point.normal_amplitude_m:
        return
    alpha, block = _alpha(record), slider.roughness
    amplitude = point.normal_amplitude_m * alpha / _rms(record)
    median, lowest, highest, field = (each / _own(slider, amplitude) for each in ratio(alpha, amplitude))
    if slider.normal_law is not None:
        pass  # a law of one's own has its roughness in it
    elif block is None:
        how = f"{RMS * 1e9:g} nm assumed; eight balls: {100 * (lowest - 1):+.2g} to {100 * (highest - 1):+.2g} %"
        yield ROUGHNESS, "velocity", median - 1.0, how
    elif block.sampled:
        low, high = point.sample_lowest_m_per_s, point.sample_highest_m_per_s
        how = f"half the range of eight samples, {1e3 * low:.3g} to {1e3 * high:.3g} mm/s"
        yield OTHER_BALL, "velocity", 0.5 * (high - low) / abs(speed), how
    else:
        how = "half the range of eight samples on the seed's ball, over the root of the number of balls"
        size = 0.5 * (highest - lowest) / median / math.sqrt(len(slider.offsets))
        yield OTHER_BALL, "velocity", size, how
        if field > 0.0:
            how = "median of eight samples over the mean field, which is softer, on the seed's ball"
            yield FIELD, "velocity", median / field - 1.0, how
    yield from _split(record, point)
    if slider.tangential_law == "elastic" and block is not None:
        from studies.model.roughness_of_balls import orbits_of_each, rough_balls

        driven = contact_of_run(record)
        largest = max(abs(each.normal) for each in driven.at(max(record.scene.levels)))
        with suppress(contact.ConvergenceError):
            other = rough_balls(replace(slider, law="hysteretic"), largest)[0]
            orbits = orbits_of_each(slider, driven.at(point.level))
            remembers = other.velocity(orbits, tolerance=MEMORY_TOLERANCE).value
            how = "asperities that draw each other along and remember, over those that slip by the elastic law"
            yield MEMORY, "velocity", remembers / speed - 1.0, how
    elif slider.tangential_law == "elastic":
        how = "hysteretic law (Mindlin and Deresiewicz) over the elastic one, smooth ball"
        yield MEMORY, "velocity", ratio(0.0, amplitude)[0] - 1.0, how


def _own(slider, amplitude: float) -> float:
    """Return the ratio of the smooth ball with the slider's own tangential law to that with the elastic one."""
    return ratio(0.0, amplitude)[0] if slider.remembers and slider.roughness is None else 1.0


def _split(record: Record, point: Point) -> Effects:
    """Yield the change of the velocity where statics, and not one height of all, gives each ball its load."""
    slider = record.scene.slider
    if slider.computed_contacts < 2 or slider.planar:
        return
    places = np.array(slider.offsets).T
    if min(map(np.ptp, places)) > 0.0 and abs(np.corrcoef(places)[0, 1]) > ON_A_LINE:
        return  # a line askew does not hold the tilt about itself
    smooth = replace(
        slider, law="elastic", roughness=None, adhesion=None, friction_coefficient=slider.static_coefficient
    )
    body, orbits = contact_slider(smooth), contact_of_run(record).at(point.level)
    with suppress(contact.ConvergenceError):
        together = float(contact.mean_motion(body, orbits).velocity)
        alone = _balanced_velocity(body, orbits, places[np.ptp(places, axis=1) > 0.0])
        if together != 0.0 and alone is not None:
            how = "averaged motion of balls at the heights that balance their loads about the slider's centre"
            yield SPLIT, "velocity", alone / together - 1.0, how


def _balanced_velocity(body, orbits, places: np.ndarray) -> float | None:
    """Return the velocity in m/s where tilts balance the moments of the loads; None without such a balance.

    Newton's method on the slopes of the balls' heights along each row of ``places``, shape (1 or 2, n).
    """
    size, own = np.abs(places).max(), np.array(body.offsets(places.shape[1]))
    slopes, step = np.zeros(len(places)), 1e-3 * body.rest_approach(places.shape[1]) / size

    def at(slopes):
        tilted = replace(body, heights=tuple(map(float, own + slopes @ places)))
        motion = contact.mean_motion(tilted, orbits)
        return float(motion.velocity), places @ contact.mean_forces(tilted, orbits, motion).normal / body.preload / size

    for _ in range(STEPS):
        velocity, moment = at(slopes)
        if np.abs(moment).max() < BALANCED:
            return velocity
        rates = np.array([at(slopes + step * each)[1] - moment for each in np.eye(len(places))]).T / step
        if abs(np.linalg.det(rates)) == 0.0:
            return None  # a ball hangs in the air
        slopes = slopes - np.linalg.solve(rates, moment)
    return None


def smooth_balls(record: Record) -> Iterator[str]:
    """Yield a warning that the balls are computed smooth and dry, where their surfaces change the answer by 10 %."""
    sizes = {each.effect: each.size for each in record.model_error}
    told = (STARTS, LOST, ROUGHNESS, MEMORY, OTHER_BALL, FIELD, SPLIT, WET)
    decisive = {name: sizes[name] for name in told if abs(sizes.get(name, 0.0)) >= DECIDES}
    sentences = {
        FIELD: "single asperities would change the velocity of their mean field by about {percent:+.0f} %",
        OTHER_BALL: "another ball of this roughness runs up to {percent:.0f} % faster or slower",
        SPLIT: "loads of the balls by statics would change the velocity by about {percent:+.0f} %",
        STARTS: "with a roughness of {rms:g} nm they start at about {factor:.2g} times the threshold",
        LOST: "a roughness of {rms:g} nm takes their adhesion away, {percent:+.0f} % of the preload",
        ROUGHNESS: "a roughness of {rms:g} nm changes the velocity at the largest level by about {percent:+.0f} %",
        MEMORY: 'slider.law = "hysteretic" by about {percent:+.0f} %',
        WET: "a meniscus of water would pull with {size:.2g} times the preload",
    }
    said = [
        sentences[name].format(rms=RMS * 1e9, factor=1.0 + size, percent=100.0 * size, size=size)
        for name, size in decisive.items()
    ]
    if said:
        slider = record.scene.slider
        words = ["smooth"] * (slider.roughness is None and slider.normal_law is None)
        words += ["dry", "clean"] * (slider.adhesion is None)
        computed = " and ".join(filter(None, (", ".join(words[:-1]), *words[-1:])))
        computed = computed or "without a memory of their contact"
        yield f"the balls are computed {computed}: {'; '.join(said)} (model_error in run.json)"


def of_patch(record: Record) -> Iterator[str]:
    """Yield what a user must know about the patch of an atomic force microscope: its rms, and what its file lacks."""
    block = record.scene.slider.roughness
    if block is None or block.file is None:
        return
    from studies.model.roughness_of_balls import patch_of

    patch = patch_of(block)
    along, across = (each * 1e6 for each in patch.size)
    radii = patch.peaks()[3] * 1e6
    yield (
        f"{patch.name} has an rms of {patch.rms * 1e9:.3g} nm over {along:.3g} x {across:.3g} um without its plane and "
        f"its sphere, and {radii.size} asperities of {np.median(radii):.3g} um in the median; it continues periodically"
    )
    for remark in patch.remarks:
        yield f"{patch.name}: {remark}"


def _on_balls(record: Record) -> bool:
    """Return whether the slider presses smooth balls on the stator."""
    slider = record.scene.slider
    return slider is not None and slider.shape == "sphere" and bool(slider.radius) and slider.preload_force > 0.0


def _alpha(record: Record) -> float:
    """Return Johnson's number: the roughness of the balls over the approach of smooth ones."""
    slider = record.scene.slider
    dry = {"adhesion": None} if slider.adhesion is not None and slider.adhesion.holds else {}
    smooth = contact_slider(replace(slider.along_x, roughness=None, **dry))
    return contact.johnson_number(_rms(record), smooth.rest_approach(slider.computed_contacts))


def _rms(record: Record) -> float:
    """Return the roughness of the balls in m: that of the scene, or the assumed one."""
    block = record.scene.slider.roughness
    if block is None:
        return RMS
    from studies.model.roughness_of_balls import realised_rms

    return realised_rms(block)
