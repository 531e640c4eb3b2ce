"""Predictions for published motors, compared with the values in their papers.

Method: the ball of Kurosawa, Takahashi and Higuchi on 128YX lithium niobate (1998), both the contact alone at the
stated amplitude and the whole chain from 180 V; the motor of the seed paper; Tjeung and others (2011); the silicon
slider of Raj and Behera (2025); four motors whose silicon sliders load the wave (`published_sliders`). A published
value is a number, or a range if the paper only bounds it. Quantities that a paper needs but does not state, or states
as "about", are swept in every combination and make the band beside the measurement. The value inside the band is our
assumption, and agreement means only that nothing contradicts it. Expected: the speed at the published amplitude lies
within its band; the band of predictions from the voltage is as wide as the unknown number of fingers makes it.
Run time: about 40 s.
"""

import csv
import io
import math
from dataclasses import replace

import contact
from studies.papers import published_sliders as sliders
from studies.papers.published import KUROSAWA, LEFT_ASIDE, RAJ, SEED, TJEUNG, Unknown, corners
from studies.papers.published_kurosawa import contact_radius, needed_amplitude, per_volt, ratio, speed, thrust
from studies.papers.seed import Seed
from studies.record.plots import COLOURS, finished
from studies.record.text import markdown
from studies.study import Answered, Finding, Panel, StudyRecord, of_record, study

MOTORS = (
    "Kurosawa 1998", "Feenstra and Breedveld", "Tjeung 2011", "Raj and Behera 2025", "Kurosawa and Asai, 10 MHz",
    "KAKEN 22360101", "Shigematsu 2003", "KAKEN 15H03943",
)  # fmt: skip
QUICK = {"motors": (*MOTORS[1:4], *MOTORS[5:])}
WIDE = 5.0  # highest over lowest of a band from which on an agreement says little
ON_CONTACT = ("friction", "preload", "amplitude", "frequency", "modulus", "law", "air")


@study()
def run(*, motors: tuple[str, ...] = MOTORS, progress=None) -> Answered:
    """Return predictions with their bands beside what is published.

    Parameters
    ----------
    motors : tuple of str
        Of `MOTORS`.
    progress : callable, optional
        Told what is being done.
    """
    parts = {
        MOTORS[0]: lambda: [*_kurosawa(progress), *_from_voltage(progress)],
        MOTORS[1]: lambda: [feenstra_row()],
        MOTORS[2]: _tjeung,
        MOTORS[3]: raj_rows,
        MOTORS[4]: lambda: _kurosawa_asai(progress),
        MOTORS[5]: _rear,
        MOTORS[6]: _shigematsu,
        MOTORS[7]: _crest,
    }
    rows = [row for motor in motors for row in parts[motor]()]
    columns = {key: [row[key] for row in rows] for key in rows[0]}
    title = "Published motors (bands: what the papers do not state)"
    return (Panel(name="published_motors", title=title, data=columns),), map(finding_of, rows)


@of_record
def figure(panel: Panel, ax):
    """Draw each prediction over the published value: a point as taken, a band over what is swept.

    A published range is drawn in grey, everything of its row over the range's geometric mean.
    """
    data = panel.data
    count = len(data["quantity"])
    for index in range(count):
        place = count - 1 - index
        stated = [data[key][index] for key in ("published_low", "published_high")]
        published = math.sqrt(stated[0] * stated[1])
        ends = [value / published for value in stated]
        ax.plot(ends, [place, place], color=COLOURS["stick"], linewidth=11, alpha=0.5, solid_capstyle="butt")
        ends = [data[key][index] / published for key in ("low", "high")]
        ax.plot(ends, [place, place], color=COLOURS["slip"], linewidth=5, alpha=0.45, solid_capstyle="butt")
        ax.plot(data["predicted"][index] / published, place, "o", color=COLOURS["slip"])
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
    data = record.panels[0].data
    rows = [dict(zip(data, values, strict=True)) for values in zip(*data.values(), strict=True)]
    head = ("motor", "quantity", "published", "predicted", "band", "swept", "moves it most", "verdict")
    table = []
    for row in rows:
        unit, scale = row["unit"], row["scale"]
        values = [f"{row[key] * scale:.3g}" for key in ("predicted", "low", "high")]
        texts = [_stated(row), values[0], f"{values[1]} to {values[2]}"]
        cells = [row["motor"], row["quantity"], *(f"{text} {unit}".rstrip() for text in texts)]
        table.append([*cells, row["swept"], row["most"], row["verdict"]])
    lines = [*markdown(head, table), "", "Left aside:", "", *(f"- {what}: {why}." for what, why in LEFT_ASIDE)]
    file = io.StringIO()
    writer = csv.DictWriter(file, list(data), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return {"published_motors.md": "\n".join(lines) + "\n", "published_motors.csv": file.getvalue()}


def _kurosawa(progress) -> list[dict]:
    """Return the contact at the published amplitude, then the chain from the voltage."""
    published, motor = KUROSAWA.published, "Kurosawa 1998"
    unknowns = {name: KUROSAWA[name] for name in ON_CONTACT}
    known = _known(unknowns)
    progress("Kurosawa: the contact at the published amplitude")

    def pull(case):
        return thrust(case) / published["mass_kg"]

    rows = []
    for quantity, what, key, needs, unit, scale in (
        ("speed at its amplitude", speed, "velocity_m_per_s", ON_CONTACT, "m/s", 1.0),
        ("thrust", thrust, "thrust_N", ON_CONTACT[:-2], "mN", 1e3),
        ("acceleration", pull, "acceleration_m_per_s2", ON_CONTACT[:-2], "m/s\u00b2", 1.0),
        ("contact radius at its pressure", contact_radius, "contact_radius_m", ("modulus",), "\u00b5m", 1e6),
    ):
        swept = {name: unknowns[name] for name in needs}
        rows.append(compared_row(motor, quantity, published[key], what, known, swept, unit, scale))
    swept = {name: unknowns[name] for name in ("friction", "preload", "frequency", "law")}
    amplitude = published["amplitude_m"]
    return [
        *rows,
        compared_row(motor, "amplitude its speed needs", amplitude, needed_amplitude, known, swept, "nm", 1e9),
    ]


def _known(unknowns: dict) -> dict:
    """Return the assumed values of the contact."""
    values = {name: each.taken for name, each in unknowns.items()}
    return {"ratio": ratio(str(KUROSAWA["material"].taken)), **values}


def _from_voltage(progress) -> list[dict]:
    """Return the amplitude and the speed from the voltage."""
    published, motor = KUROSAWA.published, "Kurosawa 1998"
    known = _known({name: KUROSAWA[name] for name in ON_CONTACT})
    stator = {name: KUROSAWA[name] for name in ("pairs", "material")}
    taken = {name: each.taken for name, each in stator.items()}
    amplitudes = {}
    for case in corners(stator):
        progress(f"Kurosawa: {case['pairs']} finger pairs on {case['material']}")
        amplitudes[case["pairs"], case["material"]] = published["voltage_V"] * per_volt(**case)

    def from_voltage(case):
        return amplitudes[case["pairs"], case["material"]]

    def chain(case):
        return speed(case | {"amplitude": from_voltage(case)})

    progress("Kurosawa: from the voltage to the speed")
    swept = stator | {name: KUROSAWA[name] for name in ("friction", "preload", "law")}
    amplitude, velocity = published["amplitude_m"], published["velocity_m_per_s"]
    return [
        compared_row(motor, "amplitude from 180 V", amplitude, from_voltage, taken, stator, "nm", 1e9),
        compared_row(motor, "speed from 180 V", velocity, chain, known | taken, swept, "m/s", 1.0),
    ]


def feenstra_row() -> dict:
    """Return the release amplitude beside the two simulated amplitudes between which the paper places it."""
    seed, published = Seed(lambda text: None), SEED.published

    def release(case):
        return contact.release_amplitude(replace(seed.slider, effective_modulus=case["modulus"]), seed.shape)

    bounds = published["constant_contact_m"], published["intermittent_m"]
    return compared_row(
        "Feenstra and Breedveld", "release amplitude", bounds, release, {"modulus": SEED["modulus"].taken},
        {"modulus": SEED["modulus"]}, "nm", 1e9,
    )  # fmt: skip


def _tjeung() -> list[dict]:
    """Return the largest torque that friction permits, compared with the measured torque."""
    published = TJEUNG.published

    def torque(case):
        return case["friction"] * published["preload_N"] * published["radius_m"]

    friction = TJEUNG["friction"]
    row = compared_row(
        "Tjeung 2011", "torque, at most", published["torque_Nm"], torque, {"friction": friction.taken},
        {"friction": friction}, "\u00b5N mm", 1e9,
    )  # fmt: skip
    needed = published["torque_Nm"] / torque({"friction": 1.0})
    row["verdict"] += f"; needs a friction coefficient of {needed:.2f} at least"
    return [row]


def raj_rows() -> list[dict]:
    """Return the speed of a ball on the published wave: at least the published one, at most the surface's."""
    published, motor = RAJ.published, MOTORS[3]
    swept = {name: RAJ[name] for name in ("radius", "mass", "amplitude")}
    tangential = ratio("LiNbO3 (Kovacs)")
    known = {name: each.taken for name, each in swept.items()} | {
        "modulus": RAJ["modulus"].taken,
        "frequency": published["frequency_Hz"],
        "preload": published["preload_N"],
        "friction": published["friction"],
        "law": "elastic",
        "air": 0.0,
        "ratio": tangential,
    }
    surface = 2 * math.pi * published["frequency_Hz"] * tangential * published["amplitude_m"]
    stated = published["velocity_at_least_m_per_s"], surface
    return [compared_row(motor, "speed, at least", stated, speed, known, swept, "m/s", 1.0)]


def _kurosawa_asai(progress) -> list[dict]:
    """Return wave power, speed and stall of the 10 MHz motor at 40 nm peak."""
    swept = {name: getattr(sliders, name.upper()) for name in ("friction", "scatter", "number", "preload")}
    known = {name: each.taken for name, each in swept.items()} | {"amplitude": 40e-9}
    progress("Kurosawa and Asai: silicon sliders on 40 nm")
    width = Unknown(name="beam", taken=9e-3, swept=(9e-3, 11e-3), unit="mm", scale=1e3)

    def power(case):
        return sliders.wave_power(case["beam"])

    beam, above = "wave power at 40 nm, above", (100.0, 200.0)
    return [
        compared_row(MOTORS[4], beam, above, power, {"beam": width.taken}, {"beam": width}, "W", 1.0),
        compared_row(MOTORS[4], "speed at 40 nm", 1.1, sliders.kurosawa_speed, known, swept, "m/s", 1.0),
        compared_row(MOTORS[4], "stall at 40 nm", 3.5, sliders.kurosawa_stall, known, swept, "N", 1.0),
    ]


def _rear() -> list[dict]:
    """Return the wave amplitude behind a slider of 10 mm, which the report calls too small compared with 5 mm."""
    length = Unknown(name="length along the wave", taken=10e-3, swept=(5e-3, 10e-3), unit="mm", scale=1e3)
    what = "amplitude left of 15 nm, below 1"  # the report: too small behind 10 mm, without a number

    def left(case):
        return sliders.rear_amplitude(case["length"])

    return [compared_row(MOTORS[5], what, (0.01, 1.0), left, {"length": 10e-3}, {"length": length}, "", 1.0)]


def _shigematsu() -> list[dict]:
    """Return steps of 25 cycles, and of as many as no source at hand states: the slider's mass decides."""
    unknowns = {
        "mass": Unknown(name="mass", taken=5e-3, swept=(1e-3, 20e-3), unit="g", scale=1e3),
        "amplitude": Unknown(name="amplitude at 100 V", taken=10e-9, swept=(5e-9, 20e-9), unit="nm", scale=1e9),
    }
    rows = []
    for published, taken, swept in ((2e-9, 25, None), (0.5e-9, 12, (5, 25)), (40e-9, 110, (50, 250))):
        own = unknowns | ({} if swept is None else {"cycles": Unknown(name="cycles", taken=taken, swept=swept)})
        known = {name: each.taken for name, each in unknowns.items()} | {"cycles": taken}
        what = "step of 25 cycles at 30 N" if swept is None else f"step of {published * 1e9:g} nm at 30 N"
        rows.append(compared_row(MOTORS[6], what, published, _step, known, own, "nm", 1e9))
    return rows


def _step(case: dict) -> float:
    return sliders.shigematsu_step(case["mass"], amplitude=case["amplitude"], cycles=case["cycles"])


def _crest() -> list[dict]:
    """Return the crest's own speed at 4.7 nm: the published 0.25 m/s is it, and no slider's."""
    frequency = Unknown(name="frequency", taken=9.6e6, swept=(9.5e6, 9.7e6), unit="MHz", scale=1e-6)

    def speed_of_crest(case):
        return sliders.crest_speed(4.7e-9, case["frequency"])

    known, swept, what = ({"frequency": frequency.taken}, {"frequency": frequency}, "the crest's own speed at 4.7 nm")
    return [compared_row(MOTORS[7], what, (0.245, 0.255), speed_of_crest, known, swept, "m/s", 1.0)]


def compared_row(motor, quantity, published, what, known, swept, unit, scale) -> dict:
    """Return a quantity as taken, over all corners of what is unknown, and the unknown that moves it most.

    ``published`` is a value, or the two ends of a range.
    """
    taken = what(known)
    values = [what(known | case) for case in corners(swept)]
    reach = {}
    for name, unknown in swept.items():
        alone = [what(known | {name: value}) for value in unknown.swept]
        reach[unknown.name] = max(alone) / min(alone) if min(alone) > 0 else math.inf
    most = max(reach, key=reach.__getitem__)
    low, high = min(*values, taken), max(*values, taken)
    below, above = published if isinstance(published, tuple) else (published, published)
    if below < above and below < low and high < above:
        verdict = "the whole band lies within the published range"
    elif low <= above and below <= high:
        verdict = "within the band" if below == above else "band and published range overlap"
        verdict += f"; as taken {_apart(taken / below)}" if below == above else ""
        if high > WIDE * low:
            wide = f"{high / low:.0f}x wide" if low > 0 else "from 0"
            verdict += f"; a band {wide} says little"
    else:
        nearer = low / above if above < low else high / below
        verdict = f"outside the band, whose nearer end is {_apart(nearer)}"
    return {
        "motor": motor, "quantity": quantity, "published_low": below, "published_high": above, "predicted": taken,
        "low": low, "high": high, "unit": unit, "scale": scale, "swept": ", ".join(map(str, swept.values())),
        "most": f"{most} ({reach[most]:.2g}x)", "verdict": verdict,
    }  # fmt: skip


def _stated(row: dict) -> str:
    """Return the published value, or range, in the row's unit."""
    ends = [f"{row[key] * row['scale']:.3g}" for key in ("published_low", "published_high")]
    return " to ".join(dict.fromkeys(ends))


def _apart(ratio: float) -> str:
    return f"{100 * (ratio - 1):+.0f} %"


def finding_of(row: dict) -> Finding:
    """Return a row of the comparison as a finding, confirmed if the band reaches the published value."""
    band = f"{row['low'] * row['scale']:.3g} to {row['high'] * row['scale']:.3g} {row['unit']}".strip()
    return Finding(
        statement=f"{row['motor']}: {row['quantity']}, published {_stated(row)} {row['unit']}",
        quantity=f"predicted ({row['unit']})" if row["unit"] else "predicted",
        expected=f"a band that includes or overlaps the published value: {band}",
        found=row["predicted"] * row["scale"],
        confirmed=not row["verdict"].startswith("outside"),
        remark=f"{row['verdict']}; swept: {row['swept']}; moved most by {row['most']}",
    )
