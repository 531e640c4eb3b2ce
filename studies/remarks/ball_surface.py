"""Estimates of what the surfaces of real balls change, as fields of `stator_effects.Effect`.

The model's balls are smooth, dry and clean.  Sources:

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
from functools import cache
from pathlib import Path

import numpy as np

import contact
from studies.model.contact import contact_slider
from studies.record import Record
from studies.record.point import Point
from studies.remarks.stator_effects import Effects

TABLE = Path(__file__).with_name("rough_balls.csv")
RMS = 3e-9  # m: of a bearing ball over the size of its contact (ISO 3290-1 allows 10 to 20 nm over larger lengths)
ADHESION = 0.05  # J/m^2: work of adhesion of clean oxides in air, also of pillars
WATER = 0.072  # N/m: surface tension
REMOVED = 10.0  # Fuller's and Tabor's number above which roughness removes adhesion
DECIDES = 0.1  # relative change from which a warning is given, also of `run_warnings`
ROUGHNESS, MEMORY = "roughness of the balls", "memory of the tangential contact"
STARTS, CLEAN, WET = (
    f"{ROUGHNESS}: where they start",
    "adhesion of clean smooth balls",
    "meniscus of water at the balls",
)
AT_LARGEST = (ROUGHNESS, MEMORY)  # stated at the largest level: near the threshold they decide everything


@cache
def _table() -> dict[float, np.ndarray]:
    """Return the rows of `rough_balls.csv` by alpha: amplitude, median, lowest and highest, shape (4, k)."""
    with TABLE.open(encoding="utf-8") as file:
        rows = np.array([[float(each) for each in row] for row in list(csv.reader(file))[1:]])
    return {float(alpha): rows[rows[:, 0] == alpha, 1:].T for alpha in np.unique(rows[:, 0])}


def ratio(alpha: float, amplitude: float) -> tuple[float, float, float]:
    """Return median, lowest and highest of the velocity of eight rough balls over that of the smooth elastic one.

    Parameters
    ----------
    alpha : float
        sigma/z_0; 0 for the hysteretic law on the smooth ball. Beyond the table its last value counts.
    amplitude : float
        |u_z|/z_0; 0 gives ratios of the threshold amplitudes.
    """

    def at(rows: np.ndarray) -> list[float]:
        if amplitude == 0.0:
            return [float(each) for each in rows[1:, 0]]
        x = np.log(rows[0, 1:])
        return [float(np.interp(math.log(amplitude), x, each[1:])) for each in rows[1:]]

    columns = np.array([at(rows) for rows in _table().values()]).T
    median, lowest, highest = (float(np.interp(alpha, list(_table()), each)) for each in columns)
    return median, lowest, highest


def ball_surface(record: Record) -> Effects:
    """Yield what does not depend on the level: the threshold of rough balls, adhesion and a meniscus."""
    slider = record.scene.slider
    if not _on_balls(record):
        return
    body, balls = contact_slider(slider.along_x), slider.computed_contacts
    alpha, preload = _alpha(record), body.preload
    median, lowest, highest = ratio(alpha, 0.0)
    how = f"{RMS * 1e9:g} nm assumed, {alpha:.2g} of the approach at rest; eight balls: {lowest:.3g} to {highest:.3g}"
    yield STARTS, "the threshold", median - 1.0, how
    number = body.effective_modulus * RMS**1.5 / (ADHESION * math.sqrt(contact.Roughness(rms=RMS).asperity_radius))
    removed = f"which a roughness of {RMS * 1e9:g} nm removes" if number > REMOVED else "which their roughness leaves"
    pull = contact.AdhesiveSphere(radius=slider.radius, modulus=body.effective_modulus, work=ADHESION).pull_off
    how = f"{ADHESION:g} J/m^2, {removed} (number of Fuller and Tabor {number:.2g})"
    yield CLEAN, "the preload", balls * pull / preload, how
    meniscus = contact.meniscus_force(slider.radius, WATER)
    yield WET, "the preload", balls * meniscus / preload, "4 pi gamma R; none in vacuum"


def ball_surface_at(record: Record, point: Point) -> Effects:
    """Yield the changes of the velocity at a point by roughness and by the tangential law."""
    speed = point.velocity_m_per_s
    if not _on_balls(record) or not speed or not point.normal_amplitude_m:
        return
    alpha, amplitude = _alpha(record), point.normal_amplitude_m * _alpha(record) / RMS
    median, lowest, highest = ratio(alpha, amplitude)
    how = f"{RMS * 1e9:g} nm assumed; eight balls: {100 * (lowest - 1):+.2g} to {100 * (highest - 1):+.2g} %"
    yield ROUGHNESS, "velocity", median - 1.0, how
    if record.scene.slider.law == "elastic":
        how = "hysteretic law (Mindlin and Deresiewicz) over the elastic one, smooth ball"
        yield MEMORY, "velocity", ratio(0.0, amplitude)[0] - 1.0, how


def smooth_balls(record: Record) -> Iterator[str]:
    """Yield a warning that the balls are computed smooth and dry, where their surfaces change the answer by 10 %."""
    sizes = {each.effect: each.size for each in record.model_error}
    decisive = {name: sizes[name] for name in (STARTS, ROUGHNESS, MEMORY, WET) if abs(sizes.get(name, 0.0)) >= DECIDES}
    sentences = {
        STARTS: "with a roughness of {rms:g} nm they start at about {factor:.2g} times the threshold",
        ROUGHNESS: "a roughness of {rms:g} nm changes the velocity at the largest level by about {percent:+.0f} %",
        MEMORY: 'slider.law = "hysteretic" by about {percent:+.0f} %',
        WET: "a meniscus of water would pull with {size:.2g} times the preload",
    }
    said = [
        sentences[name].format(rms=RMS * 1e9, factor=1.0 + size, percent=100.0 * size, size=size)
        for name, size in decisive.items()
    ]
    if said:
        yield f"the balls are computed smooth, dry and clean: {'; '.join(said)} (model_error in run.json)"


def _on_balls(record: Record) -> bool:
    """Return whether the slider presses smooth balls on the stator."""
    slider = record.scene.slider
    return slider is not None and slider.shape == "sphere" and bool(slider.radius) and slider.preload_force > 0.0


def _alpha(record: Record) -> float:
    """Return Johnson's number of the balls with the assumed roughness."""
    slider = record.scene.slider
    return contact.johnson_number(RMS, contact_slider(slider.along_x).rest_approach(slider.computed_contacts))
