"""Velocity and efficiency of the motor against the load, and the load at which it stalls.

Method: the slider of a scene (``twente-contact`` by default) at up to four of its amplitudes or voltages above the
threshold: the steady velocity against a constant load up to the blocked thrust, and the efficiency from the energy
ledger of the periodic motion. Expected: the velocity falls to zero at the blocked thrust, which is at most mu times the
preload; the efficiency lies between 0 and 1 and is largest at an intermediate load; the ledger closes to 1e-7.
In the plane: the stall force in each direction, or a rotor's speed against torque.
Run time: about 2 s, plus the time of the stator.
"""

import logging

import numpy as np

import contact
from studies.record.plots import curve, family, finished
from studies.record.prefixes import key_axis, si
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.study_list import Answered, Panel, contact_of_study, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"points": 3}
LINES = 4


@study("twente-contact")
def run(scene: Scene, *, points: int = 17, tolerance: float = 1e-3) -> Answered:
    """Return load lines and efficiencies.

    Parameters
    ----------
    points : int
        Number of loads of each line.
    tolerance : float
        Of the slider velocity.
    """
    driven = contact_of_study(scene, tolerance=tolerance, planar=None)
    if driven.scene.planar:
        from studies.motor.plane_load_line import plane_load_lines

        return plane_load_lines(driven, points, tolerance)
    resolved_scene, slider, lines = driven.scene, driven.slider, {}
    for level in driven.spread(1.05, LINES):
        name = driven.scene.named(level)
        LOGGER.info(f"load line: {name}")
        lines[name] = contact.load_line(slider, driven.at(level), points=points, tolerance=0.1 * tolerance)
    balls = resolved_scene.slider.share
    friction = slider.static_friction(driven.contacts)
    what = "mu times preload" if slider.adhesion is None else "the friction at rest"
    findings = (
        judged("Velocity falls with load, to zero at the blocked thrust.",
               f"blocked thrust over {what}, the largest",
               max(line.blocked_thrust for line in lines.values()) / friction, low=0, high=1 + 1e-9,
               holds=all(np.all(np.diff(np.abs(line.velocity)) < 0.0) for line in lines.values()),
               expected="above 0, up to 1",
               remark="; ".join(f"{key}: {line.message}" for key, line in lines.items() if line.status != "ok")),
        judged("The mechanical power is less than that of the wave, and largest at an intermediate load.",
               "largest mechanical efficiency of the contact",
               max(float(np.max(line.efficiency)) for line in lines.values()), low=0, high=1,
               holds=all(0 < int(np.argmax(line.efficiency)) < points - 1 for line in lines.values()),
               remark="relative to the power of the wave at the contacts, not to the electrical power"),
    )  # fmt: skip
    stalls = {key: balls * line.blocked_thrust for key, line in lines.items()}
    best, line = max(lines.items(), key=lambda each: np.max(each[1].efficiency))
    best_index = int(np.argmax(line.efficiency))
    load, speed = si(balls * line.load[best_index], "N", 3), si(abs(line.velocity[best_index]), "m/s", 3)
    efficiency = f"{100 * line.efficiency[best_index]:.3g} %: at {best}, under {load}, at {speed}"
    answer = [
        ("blocked thrust", ", ".join(f"{si(stall, 'N', 4)} at {key}" for key, stall in stalls.items())),
        ("efficiency", f"of the contact at most {efficiency}"),
    ]
    panels = [
        Panel(name=file, title=f"{resolved_scene.title}: {title}", data={
            "load_N": {key: balls * line.load for key, line in lines.items()},
            "value": {key: np.abs(getattr(line, value)) for key, line in lines.items()}, 
            "axis": shown.axis, "factor": shown.scale,
            "blocked_thrust_N": stalls,
        })
        for file, title, value, shown in (
            ("load_line", "load line", "velocity", quantity.velocity_m_per_s),
            ("efficiency", "efficiency of the contact", "efficiency", quantity.efficiency),
        )
    ]  # fmt: skip
    return panels, findings, answer


@of_record
def figure(record: Panel, ax):
    """Draw a quantity against load."""
    data = record.data
    if "value" not in data:
        from studies.motor.plane_load_line import draw

        return draw(record, ax)
    factor, label = key_axis("slider.load", max(max(load) for load in data["load_N"].values()))
    for name, load, colour in family(data["load_N"]):
        values = np.asarray(data["value"][name]) * data["factor"]
        curve(ax, np.asarray(load) * factor, values, ".-", colour, name)
    ax.set_ylim(bottom=0)
    return finished(ax, label, data["axis"], record.title, columns=3)
