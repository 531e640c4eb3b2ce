"""What thrust the motor gives at what speed, where it stalls and how efficient it is.

Method: the slider of a scene (``twente-contact`` when none is named) at up to four of its amplitudes or voltages above
threshold: steady velocity against a constant load up to the blocked thrust, efficiency from the energy ledger of the
periodic motion.  Expected: velocity falls to zero at the blocked thrust, which stays within friction's mu times
preload; efficiency between 0 and 1, largest inside the line; the ledger closes to 1e-7.  Run time: about 2 s,
and the stator's.
"""

from studies.chain.driven_contact import driven_contact
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord, of_record, study

__all__ = ["figure", "run"]

TAKES_SCENE = True
QUICK = {"points": 3}
LINES = 4


@study
def run(scene: str | Scene = "twente-contact", *, points: int = 17, progress=None) -> StudyRecord:
    """Return load lines and efficiencies.

    Parameters
    ----------
    points : int
        Loads of each line.
    """
    import numpy as np

    import contact

    driven = driven_contact(scene, progress=progress)
    chosen, slider, moving = driven.scene, driven.slider, driven.above(1.05)
    picked = sorted({moving[round(k * (len(moving) - 1) / LINES)] for k in range(1, LINES + 1)})
    drawn = {driven.named(level): driven.at(level) for level in picked}
    lines = {}
    for name, orbits in drawn.items():
        progress(f"load line: {name}")
        lines[name] = contact.load_line(slider, orbits, points=points, tolerance=1e-4)
    # of the balls that are computed as one, the whole thrust
    balls = chosen.slider.preload / slider.preload
    friction = slider.friction_coefficient * slider.preload
    best = max(float(np.max(line.efficiency)) for line in lines.values())
    inside = all(0 < int(np.argmax(line.efficiency)) < points - 1 for line in lines.values())
    falling = all(bool(np.all(np.diff(line.velocity) < 0.0)) for line in lines.values())
    largest = max(line.blocked_thrust for line in lines.values())
    findings = [
        Finding(statement="Velocity falls with load, to zero at the blocked thrust.",
                quantity="blocked thrust over mu times preload, the largest", expected="above 0, up to 1",
                found=largest / friction, confirmed=falling and 0 < largest < friction * (1 + 1e-9)),
        Finding(statement="The motor gives out less than the wave puts in, most of it at some load in between.",
                quantity="largest mechanical efficiency of the contact", expected="between 0 and 1",
                found=best, confirmed=inside and 0 < best < 1,
                remark="of the power that the wave gives the contacts, not of the electrical power"),
    ]  # fmt: skip
    panels = [
        Panel(name=file, title=f"{chosen.title}: {title}", data={
            "load_N": {key: balls * line.load for key, line in lines.items()},
            "value": {key: getattr(line, value) for key, line in lines.items()}, "axis": axis, "factor": factor,
            "blocked_thrust_N": {key: balls * line.blocked_thrust for key, line in lines.items()},
        })
        for file, title, value, axis, factor in (
            ("load_line", "load line", "velocity", "slider velocity (mm/s)", 1e3),
            ("efficiency", "efficiency of the contact", "efficiency", "mechanical efficiency (%)", 1e2),
        )
    ]  # fmt: skip
    return tuple(panels), tuple(findings)


@of_record
def figure(record: Panel, ax):
    """Draw a quantity against load."""
    import numpy as np

    from studies.report.figures import curves, finished

    data, palette = record.data, ("stick", "slip", "second", "intermittent", "line")
    for (name, load), colour in zip(data["load_N"].items(), palette, strict=False):
        values = np.asarray(data["value"][name]) * data["factor"]
        curves(ax, [(np.asarray(load) * 1e6, values, ".-", colour, name)])
    ax.set_ylim(bottom=0)
    return finished(ax, "load (\u00b5N)", data["axis"], record.title, columns=3)
