"""How far a burst of N cycles moves the slider, the number of cycles for a step, stopping time and ring.

Method: the slider of a scene (``twente-contact`` by default) starts from rest at up to four of its levels (amplitudes
or voltages) above the threshold. Bursts of 8 to 4096 cycles are computed until the slider has slipped for the last time
and only rings on its contact springs. The inverse problem, the number of cycles for a step, is solved by bisection on
whole cycles. On a stator, the wave arrives late, grows over the length of the transducer and rings down after the
drive, as in a run with ``drive.burst``; a burst shorter than this hardly moves the slider. If the growth cannot be
computed, the findings say so, and the wave has its full amplitude from the first cycle, as for a scene with a [wave].
Expected: far below its steady speed the slider accelerates uniformly, so that steps grow as N^2; the step planned for a
distance reaches it, and one cycle less does not; the step equals the integral of the velocity. Growth and integral are
judged only for steps that are large compared with the ring after the burst. Growth is judged only for bursts that are
long compared with the settling of the wave and with the bounce of the start. Run time: about 5 s, and twice the
stator's.
"""

import logging
import math
from collections.abc import Iterator

import numpy as np

import contact
from studies.record.plots import COLOURS, curve, family, finished, logarithmic
from studies.record.quantities import quantity
from studies.scene import Scene
from studies.solve.burst_steps import Steps
from studies.study_list import Answered, Finding, Panel, driven_contact, judged, of_record, study

LOGGER = logging.getLogger(__name__)

QUICK = {"cycles": (64, 512), "wanted": (2e-8,), "lines": 1}
CYCLES = tuple(2**k for k in range(3, 13))
WANTED = (2e-9, 1e-8, 1e-7)  # planned steps, m
FAR = 0.1  # fraction of the steady speed below which the acceleration counts as uniform
# A step is judged if the ring after it is below this share of it; a share of 0.03 changes the exponent by 0.03, one of
# 0.13 by 0.12.
RING = 0.05
TRAVEL = 0.01  # relative error of the integral over a trajectory of 4000 samples
# least burst length in settling times of the wave: a delay of 1/20 changes the exponent by 0.1
SETTLINGS = 20.0

# A bounce whose first amplitude over the approach at rest exceeds LIVELY changes the driving force. Growth is then
# judged only for bursts of at least DECAYS decay times of the bounce. A ratio of 2.9 changes the exponent by 0.02, 9.6
# by 0.4.
LIVELY, DECAYS = 5.0, 2.0

HOLLOW = {"markersize": 5.0, "markerfacecolor": "white"}


@study("twente-contact")
def run(
    scene: Scene, *, cycles: tuple[int, ...] = CYCLES, wanted: tuple[float, ...] = WANTED, lines: int = 4,
    tolerance: float = 1e-3,
) -> Answered:  # fmt: skip
    """Return the step of each number of cycles, and the number of cycles for each wanted step.

    Parameters
    ----------
    cycles : tuple of int
        Lengths of the bursts in ascending order.
    wanted : tuple of float
        Steps to plan, m.
    lines : int
        Largest number of levels of the scene.
    tolerance : float
        Of the slider velocity, for the stator.
    """
    driven = driven_contact(scene, tolerance=tolerance)
    levels = driven.spread(1.5, lines)
    bursts = Steps.of(driven)
    steps, planned = {}, {}
    for level in levels:
        name = driven.scene.named(level)
        LOGGER.info(f"step planner: {name}")
        steps[name] = [bursts.step(level, number) for number in cycles]
        planned[name] = [bursts.reaching(level, size) for size in wanted]
    pairs = [(size, *pair) for plans in planned.values() for size, pair in zip(wanted, plans, strict=True)]
    counts = {name: [enough.cycles for _, enough in plans] for name, plans in planned.items()}
    slowest = levels[0]
    steady = contact.mean_motion(driven.slider, driven.at(slowest)).velocity
    level_name = "amplitude " if driven.scene.wave is not None else ""
    plan_texts = [f"{level_name}{name}: {', '.join(map(_plan, wanted, numbers))}" for name, numbers in counts.items()]
    findings = [
        judged("The planned number of cycles reaches the step, and one cycle less does not.",
               "smallest step that was planned, m",
               min(abs(enough.displacement) for _, _, enough in pairs),
               holds=all(abs(less.displacement) < size <= abs(enough.displacement) for size, less, enough in pairs),
               expected=f"{wanted[0]:g} m and up to a cycle's worth more",
               remark="; ".join(plan_texts + [bursts.sentence] * bool(bursts.sentence))),
        *_growth([each for each in steps[driven.scene.named(slowest)] if each.ring < RING * abs(each.displacement)],
                 steady, bursts, slowest),
    ]  # fmt: skip

    def table(value):
        return {key: np.array([getattr(each, value) for each in line]) for key, line in steps.items()}

    panels = [
        Panel(name=file, title=f"{driven.scene.title}: {title}", data=dict(
            cycles=np.array(cycles),
            distance_m={key: np.sign(steady) * values for key, values in table(value).items()},
            velocity_m_per_s=table("velocity"), ring_m=table("ring"), stopping_time_s=table("stopping_time"),
            planned_cycles=counts, wanted_m=np.array(wanted), axis=quantity(key).axis,
            planned_distance_m={key: np.sign(steady) * np.array([getattr(each, value) for _, each in plans])
                                   for key, plans in planned.items()},
        ))
        for file, title, value, key in (
            ("step_planner", "step", "displacement", "burst_step_m"),
            ("stopping", "slide after the burst", "stopping", "slide_m"),
        )
    ]  # fmt: skip
    return panels, findings


def _plan(size: float, number: int) -> str:
    return f"{size * 1e9:g} nm in {number} cycle{'s' * (number != 1)}"


def _growth(clear, steady: float, bursts: Steps, level: float) -> Iterator[Finding]:
    """Yield the findings on steps much larger than the ring: their growth, and the integral of the velocity."""
    min_cycles = max(SETTLINGS * bursts.settling * bursts.driven.scene.frequency, DECAYS * _bouncing(bursts, level))
    uniform = [each for each in clear if abs(each.velocity) < FAR * abs(steady) and each.cycles >= min_cycles][-2:]
    if len(uniform) == 2:
        short, long = uniform
        exponent = math.log(long.displacement / short.displacement) / math.log(long.cycles / short.cycles)
        yield judged("Far below its steady speed the slider accelerates uniformly: steps grow as cycles squared.",
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
    """Return the decay time (to 1/e) of the bounce after a start in cycles; 0 for a negligible bounce."""
    slider, orbits = bursts.driven.slider, bursts.driven.at(level)
    rest = slider.rest_approach(len(orbits))
    if abs(rest - contact.riding_height(slider, orbits)) <= LIVELY * rest:
        return 0.0
    damping = slider.normal_damping + slider.contact_damping * slider.preload
    return 2.0 * slider.mass * orbits[0].frequency / damping if damping > 0.0 else math.inf


def _travelled(bursts: Steps, level: float, step) -> float:
    """Return the integral of the velocity of a trajectory divided by the step."""
    (envelope, fading), after = bursts.shape(step.cycles), 10.0 * step.stopping_time
    motion = contact.burst(
        bursts.driven.slider, bursts.driven.at(level), duration=step.cycles / bursts.driven.scene.frequency,
        after=after if fading is None else (after + float(fading.time[-1]), fading), tolerance=1e-6, samples=4000,
        method="exact" if envelope is None else "stepped", envelope=envelope,
    )  # fmt: skip
    return float(np.trapezoid(motion.velocity, motion.time) / step.displacement)


@of_record
def figure(record: Panel, ax):
    """Draw distance against cycles; crosses are planned steps, hollow marks are steps against the motor's direction."""
    data, planned = record.data, record.name == "step_planner"
    scale, hollow = quantity.burst_step_m.scale, False
    for name, distance, colour in family(data["distance_m"]):
        reached = np.array([data["planned_cycles"][name], data["planned_distance_m"][name]])
        all_points = np.hstack(([data["cycles"], distance], reached))
        cycles, values = all_points[:, np.argsort(all_points[0])] * [[1.0], [scale]]
        curve(ax, cycles, abs(values), ".-", colour, name)
        backwards = values < 0.0
        ax.plot(cycles[backwards], -values[backwards], "o", color=COLOURS[colour], **HOLLOW)
        hollow |= bool(np.any(backwards))
        if planned:
            curve(ax, reached[0], abs(reached[1]) * scale, "x", colour, size=6.0)
    if hollow:
        ax.plot([], [], "o", color=COLOURS["line"], label="against the motor's direction", **HOLLOW)
    if planned:
        steps = ", ".join(f"{size * scale:g}" for size in data["wanted_m"])
        curve(ax, [], [], "x", "line", f"planned for {steps} nm", size=6.0)
    logarithmic(ax.xaxis)
    logarithmic(ax.yaxis)
    return finished(ax, quantity.drive_cycles.axis, data["axis"], record.title, columns=3)
