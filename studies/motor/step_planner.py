"""How far a burst of N cycles moves the slider, how many cycles a step of 2 nm takes, where it stops and what it rings.

Method: the slider of a scene (``twente-contact`` when none is named) from rest at up to four of its amplitudes or
voltages above threshold: bursts of 8 to 4096 cycles of the drive, each followed until the slider has slipped for the
last time and only rings in its spring; then the inverse, by bisection on whole cycles. On a stator the wave arrives
late, grows over the transducer's length and rings on after the drive, as in a run with ``drive.burst``: a burst
shorter than that hardly moves the slider. Where the growth cannot be computed the findings say so, and the wave is at
full size from the first cycle on, as a given [wave] is. Expected: far from its steady speed the slider gains speed
evenly, so that steps grow as N^2; the step planned for a distance reaches it, and a cycle less does not; the travel is
that of the velocity itself. Growth and travel are judged of steps that are large against the ring which the burst
leaves, growth of bursts that are long against the wave's and against the bounce of the start. Run time: about 5 s, and
twice the stator's.
"""

import math
from collections.abc import Iterator

import numpy as np

import contact
from studies.chain.steps import Steps
from studies.record.plots import COLOURS, curve, family, finished, logarithmic
from studies.scene import Scene
from studies.study import Answered, Finding, Panel, driven_contact, judged, of_record, study

QUICK = {"cycles": (64, 512), "wanted": (2e-8,), "lines": 1}
CYCLES = tuple(2**k for k in range(3, 13))
WANTED = (2e-9, 1e-8, 1e-7)  # m
FAR = 0.1  # of the steady speed: below it the slider is taken to gain speed evenly
RING = 0.05  # of the step, from which on the ring hides it: 0.03 bends the exponent by 0.03, 0.13 by 0.12
TRAVEL = 0.01  # of the step: the integral of a trajectory of 4000 samples
SETTLINGS = 20.0  # of the wave, in a burst whose growth is judged: a delay of 1/20 bends the exponent by 0.1

# A bounce whose first swing is larger than this, over the approach at rest, changes the force while it lasts: growth is
# judged of bursts of twice the cycles in which it falls to 1/e. At 2.9 it bends the exponent by 0.02, at 9.6 by 0.4.
LIVELY, DECAYS = 5.0, 2.0

HOLLOW = {"markersize": 5.0, "markerfacecolor": "white"}


@study("twente-contact")
def run(
    scene: Scene,
    *,
    cycles: tuple[int, ...] = CYCLES,
    wanted: tuple[float, ...] = WANTED,
    lines: int = 4,
    progress=None,
) -> Answered:
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
    picked = driven.spread(1.5, lines)
    bursts = Steps.of(driven, progress=progress)
    steps, planned = {}, {}
    for level in picked:
        name = driven.named(level)
        progress(f"step planner: {name}")
        steps[name] = [bursts.step(level, number) for number in cycles]
        planned[name] = [bursts.reaching(level, size) for size in wanted]
    pairs = [(size, *pair) for plans in planned.values() for size, pair in zip(wanted, plans, strict=True)]
    counts = {name: [enough.cycles for _, enough in plans] for name, plans in planned.items()}
    slowest = picked[0]
    steady = contact.mean_motion(driven.slider, driven.at(slowest)).velocity
    what = "amplitude " if driven.scene.wave is not None else ""
    said = [f"{what}{name}: {', '.join(map(_plan, wanted, numbers))}" for name, numbers in counts.items()]
    findings = [
        judged("The cycles found for a step reach it, and a cycle less does not.", "smallest step that was planned, m",
               min(abs(enough.displacement) for _, _, enough in pairs),
               holds=all(abs(less.displacement) < size <= abs(enough.displacement) for size, less, enough in pairs),
               expected=f"{wanted[0]:g} m and up to a cycle's worth more",
               remark="; ".join(said + [bursts.sentence] * bool(bursts.sentence))),
        *_growth([each for each in steps[driven.named(slowest)] if each.ring < RING * abs(each.displacement)],
                 steady, bursts, slowest),
    ]  # fmt: skip

    def table(value):
        return {key: np.array([getattr(each, value) for each in line]) for key, line in steps.items()}

    panels = [
        Panel(name=file, title=f"{driven.scene.title}: {title}", data={
            "cycles": np.array(cycles),
            "distance_m": {key: np.sign(steady) * values for key, values in table(value).items()},
            "velocity_m_per_s": table("velocity"), "ring_m": table("ring"), "stopping_time_s": table("stopping_time"),
            "planned_cycles": counts, "wanted_m": np.array(wanted), "axis": f"{title} (nm)",
            "planned_distance_m": {key: np.sign(steady) * np.array([getattr(each, value) for _, each in plans])
                                   for key, plans in planned.items()},
        })
        for file, title, value in (
            ("step_planner", "step", "displacement"), ("stopping", "slide after the burst", "stopping")
        )
    ]  # fmt: skip
    return panels, findings


def _plan(size: float, number: int) -> str:
    return f"{size * 1e9:g} nm in {number} cycle{'s' * (number != 1)}"


def _growth(clear, steady: float, bursts: Steps, level: float) -> Iterator[Finding]:
    """Yield the findings on steps that stand clear of the ring: their growth, and the travel of the longest but one."""
    least = max(
        SETTLINGS * bursts.settling * bursts.driven.scene.frequency, DECAYS * _bouncing(bursts, level)
    )
    far = [each for each in clear if abs(each.velocity) < FAR * abs(steady) and each.cycles >= least][-2:]
    if len(far) == 2:
        short, long = far
        exponent = math.log(long.displacement / short.displacement) / math.log(long.cycles / short.cycles)
        yield judged("Far from its steady speed the slider gains speed evenly: steps grow as cycles squared.",
                     f"exponent between {short.cycles} and {long.cycles} cycles at the smallest amplitude", exponent,
                     low=1.9, high=2.1, expected="2")  # fmt: skip
    if clear:
        step = clear[-2:][0]
        most = TRAVEL + step.ring / abs(step.displacement)
        yield judged("The step is the integral of the velocity.",
                     f"travel in {step.cycles} cycles and the slide after over the step",
                     _travelled(bursts, level, step), low=1.0 - most, high=1.0 + most,
                     expected=f"1 within {most:.2g}, {TRAVEL:g} and the ring about where the slider stays")  # fmt: skip


def _bouncing(bursts: Steps, level: float) -> float:
    """Return the cycles in which the bounce of a start from rest falls to 1/e; 0 where it is too small to matter."""
    slider, orbits = bursts.driven.slider, bursts.driven.at(level)
    rest = slider.rest_approach(len(orbits))
    if abs(rest - contact.riding_height(slider, orbits)) <= LIVELY * rest:
        return 0.0
    damping = slider.normal_damping + slider.contact_damping * slider.preload
    return 2.0 * slider.mass * orbits[0].frequency / damping if damping > 0.0 else math.inf


def _travelled(bursts: Steps, level: float, step) -> float:
    """Return the integral of a trajectory's velocity over a step."""
    (envelope, fading), after = bursts.shape(step.cycles), 10.0 * step.stopping_time
    motion = contact.burst(
        bursts.driven.slider, bursts.driven.at(level), duration=step.cycles / bursts.driven.scene.frequency,
        after=after if fading is None else (after + float(fading.time[-1]), fading), tolerance=1e-6, samples=4000,
        method="exact" if envelope is None else "stepped", envelope=envelope,
    )  # fmt: skip
    return float(np.trapezoid(motion.velocity, motion.time) / step.displacement)


@of_record
def figure(record: Panel, ax):
    """Draw distance against cycles, what was planned as crosses; what goes against the motor's direction is hollow."""
    data, planned = record.data, record.name == "step_planner"
    hollow = False
    for name, distance, colour in family(data["distance_m"]):
        reached = np.array([data["planned_cycles"][name], data["planned_distance_m"][name]])
        known = np.hstack(([data["cycles"], distance], reached))
        cycles, values = known[:, np.argsort(known[0])] * [[1.0], [1e9]]
        curve(ax, cycles, abs(values), ".-", colour, name)
        back = values < 0.0
        ax.plot(cycles[back], -values[back], "o", color=COLOURS[colour], **HOLLOW)
        hollow |= bool(np.any(back))
        if planned:
            curve(ax, reached[0], abs(reached[1]) * 1e9, "x", colour, size=6.0)
    if hollow:
        ax.plot([], [], "o", color=COLOURS["line"], label="against the motor's direction", **HOLLOW)
    if planned:
        steps = ", ".join(f"{size * 1e9:g}" for size in data["wanted_m"])
        curve(ax, [], [], "x", "line", f"planned for {steps} nm", size=6.0)
    logarithmic(ax.xaxis)
    logarithmic(ax.yaxis)
    return finished(ax, "cycles of the drive", data["axis"], record.title, columns=3)
