"""Predictions for published motors, compared with the values in their papers.

Method: the ball of Kurosawa, Takahashi and Higuchi on 128YX lithium niobate (1998), both the contact alone at the
stated amplitude and the whole chain from 180 V; the motor of the seed paper; three rotors (`published_rotors`); the
silicon slider of Raj and Behera (2025); motors whose silicon sliders load the wave (`published_sliders`). The face of
one of them was seen to move: its texture is fitted to that motion, and thrust and speed of another motor are predicted
with it, in a band that its unknown preload and friction keep wide (`published_sliders`). A published value is a
number, or a range if the paper only bounds it. Quantities that a paper needs but does not state, or states as "about",
are swept in every combination and make the band beside the measurement. The value inside the band is our assumption,
and agreement means only that nothing contradicts it.
Expected: the speed at the published amplitude lies within its band; the band of predictions from the voltage is as
wide as the unknown number of fingers makes it.
Run time: about 60 s.
"""

import logging
import math
from collections.abc import Callable
from dataclasses import replace

import contact
from studies.papers import published_kurosawa as ball
from studies.papers import published_rotors as rotors
from studies.papers import published_sliders as sliders
from studies.papers.published import Comparison, comparisons, corners, left_aside
from studies.papers.seed import Seed
from studies.record.plots import COLOURS, finished
from studies.record.text import csv_text, markdown
from studies.study_list import Answered, Finding, Panel, StudyRecord, of_record, study

LOGGER = logging.getLogger(__name__)

MOTORS = tuple(dict.fromkeys(each.motor for each in comparisons()))
QUICK = {"motors": (*MOTORS[1:4], *MOTORS[5:-2])}  # without the two rings of contacts
WIDE = 5.0  # highest over lowest value of a band beyond which agreement means little


def seed_release(case: dict) -> float:
    """Return the release amplitude of the seed paper's slider with another modulus, m."""
    seed = Seed()
    return contact.release_amplitude(replace(seed.slider, effective_modulus=case["modulus"]), seed.shape)


# functions that predict a quantity from a case: the inputs of published_motors.toml by name, in SI units
MODELS: dict[str, Callable[[dict], float]] = {
    "ball_speed": ball.speed,
    "ball_thrust": ball.thrust,
    "ball_acceleration": lambda case: ball.thrust(case) / case["mass"],
    "surface_speed": ball.surface_speed,
    "contact_radius": ball.contact_radius,
    "needed_amplitude": ball.needed_amplitude,
    "driven_amplitude": ball.driven_amplitude,
    "driven_speed": lambda case: ball.speed(case | {"amplitude": ball.driven_amplitude(case)}),
    "seed_release": seed_release,
    "friction_torque": lambda case: case["friction"] * case["preload"] * case["radius"],  # the largest possible one
    "rolling_speed": rotors.rolling_speed,
    "rotor_speed": rotors.rotor_speed,
    "run_up_time": rotors.run_up_time,
    "wave_power": lambda case: sliders.wave_power(case["beam"]),
    "pillar_speed": sliders.kurosawa_speed,
    "pillar_stall": sliders.kurosawa_stall,
    "rear_amplitude": lambda case: sliders.rear_amplitude(case["length"]),
    "burst_step": lambda case: sliders.shigematsu_step(
        case["mass"], cycles=case["cycles"], amplitude=case["amplitude"]
    ),
    "face_normal": sliders.face_normal,
    "face_tangential": sliders.face_tangential,
    "face_delay": sliders.face_delay,
    "textured_speed": sliders.textured_speed,
    "textured_stall": sliders.textured_stall,
    "crest_speed": lambda case: sliders.crest_speed(case["amplitude"], case["frequency"]),
}


@study()
def run(*, motors: tuple[str, ...] = MOTORS) -> Answered:
    """Return predictions with their bands, and the published values.

    Parameters
    ----------
    motors : tuple of str
        Of `MOTORS`.
    """
    rows = []
    for each in comparisons():
        if each.motor in motors:
            LOGGER.info(f"{each.motor}: {each.quantity}")
            rows.append(compared(each, MODELS[each.model]))
    title = "Published motors (bands: what the papers do not state)"
    return (Panel.of_rows("published_motors", title, rows),), map(finding_of, rows)


@of_record
def figure(panel: Panel, ax):
    """Draw each prediction and the band of its swept inputs over the published value, or a published range's mean."""
    data = panel.data
    count = len(data["quantity"])
    for index in range(count):
        y = count - 1 - index
        stated = [data[key][index] for key in ("published_low", "published_high")]
        published = math.sqrt(stated[0] * stated[1])
        ends = [value / published for value in stated]
        ax.plot(ends, [y, y], color=COLOURS["stick"], linewidth=11, alpha=0.5, solid_capstyle="butt")
        ends = [data[key][index] / published for key in ("low", "high")]
        ax.plot(ends, [y, y], color=COLOURS["slip"], linewidth=5, alpha=0.45, solid_capstyle="butt")
        ax.plot(data["predicted"][index] / published, y, "o", color=COLOURS["slip"])
    ax.axvline(1.0, color=COLOURS["line"], linewidth=1)
    ax.set_xscale("log")
    low, high = ax.get_xlim()
    ticks = [tick for tick in (0.01, 0.1, 0.2, 0.5, 1, 2, 5, 10, 100) if low < tick < high]
    ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    ax.minorticks_off()
    names = [f"{m}: {q}" for m, q in zip(data["motor"], data["quantity"], strict=True)]
    ax.set_yticks(range(count)[::-1], names, fontsize="x-small")
    across = "predicted over published\n(grey: a published range, over its geometric mean)"
    return finished(ax, across, "", panel.title, columns=0)


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the tables in Markdown and in CSV, by file name."""
    rows = record.panels[0].rows()
    head = ("motor", "quantity", "published", "predicted", "band", "swept", "moves it most", "verdict")
    table = []
    for row in rows:
        unit, scale = row["unit"], row["scale"]
        values = [_digits(row[key] * scale) for key in ("predicted", "low", "high")]
        texts = [_stated(row), values[0], f"{values[1]} to {values[2]}"]
        cells = [row["motor"], row["quantity"], *(f"{text} {unit}".rstrip() for text in texts)]
        table.append([*cells, row["swept"], row["most"], row["verdict"]])
    left = [f"- {what}: {why}." for what, why in left_aside().items()]
    lines = [*markdown(head, table), "", "Left aside:", "", *left]
    return {"published_motors.md": "\n".join(lines) + "\n", "published_motors.csv": csv_text(rows)}


def compared(comparison: Comparison, model: Callable[[dict], float]) -> dict:
    """Return a prediction for the assumed inputs, its band over all swept inputs, and the most influential input."""
    taken, swept = comparison.taken, comparison.swept
    predicted = model(taken)
    values = [predicted, *(model(taken | case) for case in corners(swept))]
    reach = {}
    for name, unknown in swept.items():
        alone = [model(taken | {name: value}) for value in unknown.swept]
        reach[unknown.name] = max(alone) / min(alone) if min(alone) > 0 else math.inf
    most = max(reach, key=reach.__getitem__)
    low, high = min(values), max(values)
    ends = [MODELS[each](taken) if isinstance(each, str) else each for each in comparison.published]
    below, above = ends[0], ends[-1]
    if below < above and below < low and high < above:
        verdict = "the whole band lies within the published range"
    elif low <= above and below <= high:
        verdict = "within the band" if below == above else "band and published range overlap"
        verdict += f"; as taken {_apart(predicted / below)}" if below == above else ""
        if high > WIDE * low:
            wide = f"{high / low:.0f}x wide" if low > 0 else "from 0"
            verdict += f"; a band {wide} says little"
    else:
        nearer = low / above if above < low else high / below
        verdict = f"outside the band, whose nearer end is {_apart(nearer)}"
    return {
        "motor": comparison.motor, "quantity": comparison.quantity, "published_low": below, "published_high": above,
        "predicted": predicted, "low": low, "high": high, "unit": comparison.unit, "scale": comparison.scale,
        "swept": ", ".join(map(str, swept.values())), "most": f"{most} ({reach[most]:.2g}x)",
        "verdict": "; ".join(filter(None, (verdict, comparison.remark))),
    }  # fmt: skip


def _stated(row: dict) -> str:
    """Return the published value, or range, in the row's unit."""
    ends = [_digits(row[key] * row["scale"]) for key in ("published_low", "published_high")]
    return " to ".join(dict.fromkeys(ends))


def _digits(value: float) -> str:
    """Return three digits without an exponent: 9000, not 9e+03."""
    return f"{float(f'{value:.3g}'):g}"


def _apart(ratio: float) -> str:
    return f"{100 * (ratio - 1):+.0f} %"


def finding_of(row: dict) -> Finding:
    """Return a row of the table as a finding, confirmed if the band includes or overlaps the published value."""
    band = f"{_digits(row['low'] * row['scale'])} to {_digits(row['high'] * row['scale'])} {row['unit']}".strip()
    return Finding(
        statement=f"{row['motor']}: {row['quantity']}, published {_stated(row)} {row['unit']}",
        quantity=f"predicted ({row['unit']})" if row["unit"] else "predicted",
        expected=f"a band that includes or overlaps the published value: {band}",
        found=row["predicted"] * row["scale"],
        confirmed=not row["verdict"].startswith("outside"),
        remark=f"{row['verdict']}; swept: {row['swept']}; moved most by {row['most']}",
    )
