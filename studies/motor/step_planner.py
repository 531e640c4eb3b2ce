"""How far a burst of N cycles moves the slider, how many cycles a step of 2 nm takes, where it stops and what it rings.

Method: the slider of a scene (``twente-contact`` when none is named) from rest at up to four of its amplitudes or
voltages above threshold: bursts of 8 to 4096 cycles, each followed until the slider has slipped for the last time and
only rings in its spring; then the inverse, by bisection on whole cycles.  Expected: far from its steady speed the
slider gains speed evenly, so that steps grow as N^2; the step found for a distance reaches it, and a cycle less does
not; the travel is that of the velocity itself.  The wave of a stator is taken at full size from the first cycle on:
how it builds up is not in the steps.  Run time: about 5 s, and the stator's.
"""

import math

import numpy as np

import contact
from studies.chain.driven_contact import driven_contact
from studies.report.figures import curve, family, finished, logarithmic
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord, of_record, study

TAKES_SCENE = True
QUICK = {"cycles": (1024, 2048), "wanted": (2e-8,), "lines": 1}
CYCLES = tuple(2**k for k in range(3, 13))
WANTED = (2e-9, 1e-8, 1e-7)  # m
FAR = 0.1  # of the steady speed: below it the slider is taken to gain speed evenly


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
    chosen, slider, picked = driven.scene, driven.slider, driven.spread(1.5, lines)
    steps, planned = {}, {}
    for level in picked:
        name, orbits = driven.named(level), driven.at(level)
        progress(f"step planner: {name}")
        steps[name] = [contact.step(slider, orbits, cycles=number) for number in cycles]
        planned[name] = [contact.cycles_for(slider, orbits, displacement=size) for size in wanted]
    pairs = [(size, *pair) for plans in planned.values() for size, pair in zip(wanted, plans, strict=True)]
    reached = all(abs(less.displacement) < size <= abs(enough.displacement) for size, less, enough in pairs)
    slowest = steps[driven.named(picked[0])]
    steady = contact.mean_motion(slider, driven.at(picked[0])).velocity
    travel = _travelled(slider, driven.at(picked[0]), chosen.frequency, slowest[-2])
    findings = [
        Finding.judged(
            "The cycles found for a step reach it, and a cycle less does not.",
            "smallest step that was planned, m",
            min(abs(enough.displacement) for _, _, enough in pairs),
            holds=reached,
            expected=f"{wanted[0]:g} m and up to a cycle's worth more",
            remark="; ".join(
                f"{name}: {', '.join(f'{pair[1].cycles} cycles' for pair in plans)}"
                for name, plans in planned.items()
            ),
        ),
        *_growth(slowest, steady),
        Finding.judged(
            "The step is the integral of the velocity.",
            f"travel in {cycles[-2]} cycles and the slide after over the step",
            travel,
            low=0.98,
            high=1.02,
            expected="1, but for the ring about where the slider stays",
        ),
    ]

    def table(value):
        return {key: np.array([getattr(each, value) for each in line]) for key, line in steps.items()}

    sides = (("step_planner", "step", "displacement"), ("stopping", "slide after the burst", "stopping"))
    panels = [
        Panel(
            name=file,
            title=f"{chosen.title}: {title}",
            data={
                "cycles": np.array(cycles),
                "distance_m": {key: np.sign(steady) * values for key, values in table(value).items()},
                "velocity_m_per_s": table("velocity"),
                "ring_m": table("ring"),
                "stopping_time_s": table("stopping_time"),
                "planned_cycles": {key: [pair[1].cycles for pair in plans] for key, plans in planned.items()},
                "wanted_m": np.array(wanted),
                "axis": f"{title} (nm)",
            },
        )
        for file, title, value in sides
    ]
    return tuple(panels), tuple(findings)


def _growth(steps, steady: float) -> list[Finding]:
    """Return the finding on the growth of steps, from the two longest bursts that stay far below the steady speed."""
    far = [each for each in steps if abs(each.velocity) < FAR * abs(steady) and each.displacement != 0.0]
    if len(far) < 2:
        return []
    short, long = far[-2:]
    exponent = math.log(long.displacement / short.displacement) / math.log(long.cycles / short.cycles)
    return [
        Finding.judged(
            "Far from its steady speed the slider gains speed evenly: steps grow as cycles squared.",
            f"exponent between {short.cycles} and {long.cycles} cycles at the smallest amplitude", exponent,
            low=1.9, high=2.1, expected="2",
        )
    ]  # fmt: skip


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
