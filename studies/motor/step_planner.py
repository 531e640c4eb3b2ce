"""How far a burst of N cycles moves the slider, how many cycles a step of 2 nm takes, where it stops and what it rings.

Method: the slider of a scene (``twente-contact`` when none is named) from rest at up to four of its amplitudes or
voltages above threshold: bursts of 8 to 4096 cycles, each followed until the slider has slipped for the last time and
only rings in its spring; then the inverse, by bisection on whole cycles.  Expected: far from its steady speed the
slider gains speed evenly, so that steps grow as N^2; the step found for a distance reaches it, and a cycle less does
not; the travel is that of the velocity itself.  The wave of a stator is taken at full size from the first cycle on:
how it builds up is not in the steps.  Growth and travel are judged of steps that are large against the ring which the
burst leaves.  Run time: about 5 s, and the stator's.
"""

import math
from collections.abc import Iterator

import numpy as np

import contact
from studies.chain.bridge import DrivenContact
from studies.report.figures import curve, family, finished, logarithmic
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord, driven_contact, judged, of_record, study

QUICK = {"cycles": (64, 512), "wanted": (2e-8,), "lines": 1}
CYCLES = tuple(2**k for k in range(3, 13))
WANTED = (2e-9, 1e-8, 1e-7)  # m
FAR = 0.1  # of the steady speed: below it the slider is taken to gain speed evenly
RING = 0.05  # of the step, from which on the ring hides it: 0.03 bends the exponent by 0.03, 0.13 by 0.12


@study
def run(
    scene: str | Scene = "twente-contact",
    *,
    cycles: tuple[int, ...] = CYCLES,
    wanted: tuple[float, ...] = WANTED,
    lines: int = 4,
    progress=None,
) -> StudyRecord:
    """Return steps over cycles, and cycles over steps.

    Parameters
    ----------
    cycles : tuple of int
        Lengths of the bursts, rising.
    wanted : tuple of float
        Steps to plan, m.
    lines : int
        How many of the scene's levels, at most.
    """
    driven = driven_contact(scene, progress=progress)
    slider, picked = driven.slider, driven.spread(1.5, lines)
    steps, planned = {}, {}
    for level in picked:
        name, orbits = driven.named(level), driven.at(level)
        progress(f"step planner: {name}")
        steps[name] = [contact.step(slider, orbits, cycles=number) for number in cycles]
        planned[name] = [contact.cycles_for(slider, orbits, displacement=size) for size in wanted]
    pairs = [(size, *pair) for plans in planned.values() for size, pair in zip(wanted, plans, strict=True)]
    counts = {name: [enough.cycles for _, enough in plans] for name, plans in planned.items()}
    slowest, orbits = steps[driven.named(picked[0])], driven.at(picked[0])
    steady = contact.mean_motion(slider, orbits).velocity
    findings = [
        judged("The cycles found for a step reach it, and a cycle less does not.", "smallest step that was planned, m",
               min(abs(enough.displacement) for _, _, enough in pairs),
               holds=all(abs(less.displacement) < size <= abs(enough.displacement) for size, less, enough in pairs),
               expected=f"{wanted[0]:g} m and up to a cycle's worth more",
               remark="; ".join(f"{name}: {', '.join(f'{each} cycles' for each in plans)}"
                                for name, plans in counts.items())),
        *_growth([each for each in slowest if each.ring < RING * abs(each.displacement)], steady, driven, orbits),
    ]  # fmt: skip

    def table(value):
        return {key: np.array([getattr(each, value) for each in line]) for key, line in steps.items()}

    panels = [
        Panel(name=file, title=f"{driven.scene.title}: {title}", data={
            "cycles": np.array(cycles),
            "distance_m": {key: np.sign(steady) * values for key, values in table(value).items()},
            "velocity_m_per_s": table("velocity"), "ring_m": table("ring"), "stopping_time_s": table("stopping_time"),
            "planned_cycles": counts, "wanted_m": np.array(wanted), "axis": f"{title} (nm)",
        })
        for file, title, value in (
            ("step_planner", "step", "displacement"), ("stopping", "slide after the burst", "stopping")
        )
    ]  # fmt: skip
    return panels, findings


def _growth(clear, steady: float, driven: DrivenContact, orbits: tuple) -> Iterator[Finding]:
    """Yield the findings on steps that stand clear of the ring: their growth, and the travel of the longest but one."""
    far = [each for each in clear if abs(each.velocity) < FAR * abs(steady)][-2:]
    if len(far) == 2:
        short, long = far
        exponent = math.log(long.displacement / short.displacement) / math.log(long.cycles / short.cycles)
        yield judged("Far from its steady speed the slider gains speed evenly: steps grow as cycles squared.",
                     f"exponent between {short.cycles} and {long.cycles} cycles at the smallest amplitude", exponent,
                     low=1.9, high=2.1, expected="2")  # fmt: skip
    if clear:
        step = clear[-2:][0]
        yield judged("The step is the integral of the velocity.",
                     f"travel in {step.cycles} cycles and the slide after over the step",
                     _travelled(driven.slider, orbits, driven.scene.frequency, step), low=0.98, high=1.02,
                     expected="1, but for the ring about where the slider stays")  # fmt: skip


def _travelled(slider, orbits, frequency, step) -> float:
    """Return the integral of a trajectory's velocity over a step."""
    found = contact.burst(
        slider, orbits, duration=step.cycles / frequency, after=10.0 * step.stopping_time, tolerance=1e-6,
        samples=4000, method="exact",
    )  # fmt: skip
    return float(np.trapezoid(found.velocity, found.time) / step.displacement)


@of_record
def figure(record: Panel, ax):
    """Draw distance against cycles; what was planned as crosses."""
    data, planned = record.data, record.name == "step_planner"
    cycles, wanted = np.asarray(data["cycles"]), np.asarray(data["wanted_m"]) * 1e9
    for name, distance, colour in family(data["distance_m"]):
        values = np.asarray(distance) * 1e9
        curve(ax, cycles[values > 0.0], values[values > 0.0], ".-", colour, name)
        if planned:
            curve(ax, data["planned_cycles"][name], wanted, "x", colour, size=6.0)
    if planned:
        steps = ", ".join(f"{size:g}" for size in wanted)
        curve(ax, [], [], "x", "line", f"planned for {steps} nm", size=6.0)
    logarithmic(ax.xaxis)
    logarithmic(ax.yaxis)
    return finished(ax, "cycles of the wave", data["axis"], record.title, columns=5)
