"""The datasheet of a motor as a self-contained HTML page (A4 when printed): table, characteristics and limits."""

from functools import partial

from studies.record.plots import COLOURS, as_uri, curve, family, finished
from studies.record.prefixes import key_axis
from studies.record.quantities import quantity
from studies.record.run_pictures import velocity
from studies.record.text import sentences
from studies.report.motor_datasheet import GROUPS, SETTLED, Datasheet
from studies.report.page import rendered
from studies.results.content import provenance

TEMPLATE = "datasheet.html"
PICTURE = (4.1, 3.4)  # inches


def page(sheet: Datasheet) -> str:
    """Return the HTML page of a datasheet."""
    record = sheet.record
    if sheet.start_stop is None:
        from studies.report.plane_drawing import drawings_of_sheet

        drawn = drawings_of_sheet(sheet)
    else:
        drawn = {"speed against drive": speed, "speed against load": load_lines, "start and stop": start_and_stop}
    return rendered(
        TEMPLATE,
        title=record.scene.title or "A motor",
        rated=sheet.driven.scene.named(sheet.rated),
        record=record,
        groups={title: [row.texts() for row in sheet.rows if row.group == group] for group, title in GROUPS.items()},
        pictures=[
            {"data": as_uri(partial(draw, sheet), size=PICTURE), "caption": caption} for caption, draw in drawn.items()
        ],
        model_error=sentences(record),
        version=provenance()["version"],
    )


def speed(sheet: Datasheet, ax):
    """Draw the velocity against the voltage, or against the amplitude of a scene with a [wave]."""
    velocity(sheet.record, ax)
    ax.set_title("speed against drive, no load", fontsize="medium")
    return ax


def load_lines(sheet: Datasheet, ax):
    """Draw speed against load at some levels of the drive."""
    up = quantity.velocity_m_per_s
    factor, label = key_axis("slider.load", max(sheet.balls * line.load[-1] for line in sheet.lines.values()))
    for name, line, colour in family(sheet.lines):
        curve(ax, sheet.balls * line.load * factor, line.velocity * up.scale, ".-", colour, name)
    ax.set_xlim(left=0)
    ax.set_ylim(bottom=0)
    return finished(ax, label, up.axis, "speed against load")


def start_and_stop(sheet: Datasheet, ax):
    """Draw the velocity of the slider during start and stop."""
    motion, time, up = sheet.start_stop, quantity.time_s, quantity.velocity_m_per_s
    curve(ax, motion.time * time.scale, motion.velocity * up.scale, "-", "slip", "slider")
    settled_velocity = SETTLED * motion.velocity_at_burst_end * up.scale
    ax.axvline(motion.duration * time.scale, color=COLOURS["line"], linestyle=":", linewidth=1, label="drive off")
    label = f"{SETTLED:.0%} of the speed"
    ax.axhline(settled_velocity, color=COLOURS["stick"], linestyle="--", linewidth=1, label=label)
    title = f"start and stop at {sheet.driven.scene.named(sheet.rated)}"
    return finished(ax, time.axis, up.axis, title)
