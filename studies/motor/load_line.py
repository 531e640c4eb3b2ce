"""What thrust the motor gives at what speed, where it stalls and how efficient it is.

Method: the slider of a scene (``twente-contact`` when none is named) at up to four of its amplitudes or voltages above
threshold: steady velocity against a constant load up to the blocked thrust, efficiency from the energy ledger of the
periodic motion.  Expected: velocity falls to zero at the blocked thrust, which stays within friction's mu times
preload; efficiency between 0 and 1, largest inside the line; the ledger closes to 1e-7.  Run time: about 2 s,
and the stator's.
"""

import numpy as np

import contact
from studies.chain.driven_contact import driven_contact
from studies.report.figures import curve, family, finished
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord, of_record, study

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
    driven = driven_contact(scene, progress=progress)
    chosen, slider = driven.scene, driven.slider
    drawn = {driven.named(level): driven.at(level) for level in driven.spread(1.05, LINES)}
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
        Finding.judged("Velocity falls with load, to zero at the blocked thrust.",
                       "blocked thrust over mu times preload, the largest", largest / friction, low=0, high=1 + 1e-9,
                       holds=falling, expected="above 0, up to 1"),
        Finding.judged("The motor gives out less than the wave puts in, most of it at some load in between.",
                       "largest mechanical efficiency of the contact", best, low=0, high=1, holds=inside,
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
    data = record.data
    for name, load, colour in family(data["load_N"]):
        curve(
            ax, np.asarray(load) * 1e6, np.asarray(data["value"][name]) * data["factor"], ".-", colour, name
        )
    ax.set_ylim(bottom=0)
    return finished(ax, "load (\u00b5N)", data["axis"], record.title, columns=3)
