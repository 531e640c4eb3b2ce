"""What a smaller error costs: of the slider's velocity along the chain, of the stator's motion, of the contact's burst.

Method: three parts, each against its own converged answer, each measurement in a process of its own on one thread, CPU
time of the second of two runs.  *chain*: the scene at its levels for tolerances from 1e-1 to 1e-5, against 1e-6.
*stator*: the motion of the plane section under the slider, for the same tolerances.  *contact*: a burst of 200 cycles
from rest at the largest level and its steady state by every method, against the exact method at 1e-11.  Expected: every
error is at most twice the stated one; from 1e-2 to 1e-5 ten times less error costs at most half as much again.  Other
programs and methods on the same problems: `tests/validation`.  Run time: about 2 min.
"""

import logging
import math
import os
import platform
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import contact
from studies.evidence.own_process import alone, peak_memory
from studies.model.resolve import resolved
from studies.model.wave_to_contact import contact_slider
from studies.record.plots import finished
from studies.record.quantities import quantity
from studies.refusal import RunError
from studies.runs import run as run_chain
from studies.scene import Scene
from studies.study_list import Answered, Finding, Panel, judged, of_record, study

LOGGER = logging.getLogger(__name__)

SCENE = "twente"
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
CYCLES = 200  # of the burst from rest
CONTACT_TOLERANCES = (1e-2, 1e-4, 1e-6)
CONVERGED = 1e-11  # tolerance of the contact's converged answers
PER_DECADE, PROMISED = 1.5, 2.0  # largest cost of ten times less error; largest true over stated error
QUICK = {"tolerances": (3e-1, 1e-1), "contact_tolerances": (1e-3,), "apart": False}
STYLES = {
    "chain": ("o-", "#0072B2"),
    "stator": ("s-", "#009E73"),
    "burst, exact": ("o-", "#0072B2"),
    "burst, stepped": ("s-", "#009E73"),
    "burst, averaged": ("^-", "#D55E00"),
    "steady, exact": ("o--", "#0072B2"),
    "steady, averaged": ("^--", "#D55E00"),
}
COLUMNS = (
    "curve", "setting", "seconds", "unknowns", "peak_bytes", "true_relative_error", "stated_relative_error",
)  # fmt: skip


@study()
def run(
    scene: str | Path = SCENE, *, tolerances: tuple[float, ...] = TOLERANCES,
    contact_tolerances: tuple[float, ...] = CONTACT_TOLERANCES, apart: bool = True,
) -> Answered:  # fmt: skip
    """Return errors, times, unknowns and memory: a panel for each of chain, stator and contact.

    Parameters
    ----------
    scene : str or Path
        A path or a shipped name of a scene with transducers and a slider.
    tolerances : tuple of float
        Of chain and stator, from loose to tight; the last gives the converged answer.
    contact_tolerances : tuple of float
        Of the contact.
    apart : bool
        True if each measurement has a process of its own, which times and memory require.
    """
    source = str(scene)
    measured = alone if apart else lambda what, work, *arguments: work(*arguments)
    LOGGER.info("error against time: converged answer")
    truth = measured("the converged answer", _chain, source, tolerances[-1])
    motion = measured("the converged motion", _stator, source, tolerances[-1])

    def rows(curve: str, work: Callable, settings: tuple, truth: dict, *arguments) -> list[dict]:
        measurements = []
        for setting in settings:
            LOGGER.info(f"error against time: {curve}, {setting:g}")
            try:
                one = measured(f"{curve}, {setting:g}", work, source, setting, *arguments)
            except RunError as error:
                LOGGER.info(f"left out: {error}")
                continue
            measurements.append({"curve": curve, "setting": f"tolerance {setting:g}"} | _judged(one, truth))
        return measurements

    chain = rows("chain", _chain, tolerances[:-1], truth)
    stator = rows("stator", _stator, tolerances[:-1], motion)
    of_contact = []
    for kind, methods in (("burst", ("exact", "stepped", "averaged")), ("steady", ("exact", "averaged"))):
        converged = measured(f"{kind}, converged", _contact, source, CONVERGED, kind, "exact", truth["motion"])
        for method in methods:
            LOGGER.info(f"error against time: {kind}, {method}")
            of_contact += rows(
                f"{kind}, {method}", _contact, contact_tolerances, converged, kind, method, truth["motion"]
            )
    parts = {"chain": chain, "stator": stator, "contact": of_contact}
    panels = [_panel(name, part, source) for name, part in parts.items()]
    return panels, [each for name, part in parts.items() for each in _findings(name, part)]


def _scene(source: str):
    return resolved(Scene.load(source))


def _measured(work: Callable[[], dict]) -> dict:
    """Return the result of the second of two runs with its CPU time; the first one compiles and loads."""
    work()
    start_time = time.process_time()
    answer = work()
    seconds = time.process_time() - start_time
    return {"seconds": seconds, "peak_bytes": peak_memory(), "unknowns": 0} | answer


def _chain(source: str, tolerance: float) -> dict:
    """Return the velocities at the scene's levels, and the motion per volt under the slider."""
    scene = _scene(source)

    def work() -> dict:
        record = run_chain(scene, tolerance=tolerance)
        velocity = [point.velocity_m_per_s for point in record.points]
        surface = [2 * math.pi * scene.frequency * p.tangential_amplitude_m for p in record.points]
        return {
            "values": velocity,
            "scales": list(map(contact.speed_scale, velocity, surface)),
            "stated": record.error.relative,
            "unknowns": record.surface_wave.unknowns,
            "motion": (record.wave.tangential_m_per_V, record.wave.normal_m_per_V),
        }

    return _measured(work)


def _stator(source: str, tolerance: float) -> dict:
    """Return the motion per volt of the plane section at the slider's position, for the scene without its slider."""
    scene = _scene(source)
    bare = replace(scene, slider=None)

    def work() -> dict:
        wave = run_chain(bare, tolerance=tolerance).surface_wave
        motion = tuple(complex(each) for each in wave.motion(scene.slider.position))
        return {"motion": motion, "stated": wave.relative_error, "unknowns": wave.unknowns}

    return _measured(work)


def _contact(source: str, tolerance: float, kind: str, method: str, motion) -> dict:
    """Return the velocity of one slider by one method, on the orbit of a motion per volt at the largest level."""
    scene = _scene(source)
    slider = contact_slider(scene.slider)
    per_volt = contact.Orbit(frequency=scene.frequency, tangential=complex(motion[0]), normal=complex(motion[1]))
    orbit = per_volt.scaled(max(scene.levels))

    def work() -> dict:
        if kind == "steady":
            answer = contact.steady(slider, orbit, tolerance=tolerance, method=method)
            velocity = answer.velocity
        else:
            duration = CYCLES / orbit.frequency
            answer = contact.burst(
                slider, orbit, duration=duration, after=0.0, tolerance=tolerance, samples=2, method=method
            )
            velocity = answer.velocity_at_burst_end
        scale = contact.reference_speed(velocity, (orbit,))
        return {"values": [velocity], "scales": [scale], "stated": answer.relative_error}

    try:
        return _measured(work)
    except contact.ConvergenceError as error:
        raise RunError(f"{method}: {error}") from None


def _judged(measured: dict, truth: dict) -> dict:
    """Return the numbers of a row: costs, and the errors of the velocity, or of the motion if there is no velocity."""
    if "values" in measured:
        differences = zip(measured["values"], truth["values"], truth["scales"], strict=True)
        error = max(abs(one - other) / scale for one, other, scale in differences)
    else:
        pairs = zip(measured["motion"], truth["motion"], strict=True)
        error = max(abs(abs(one) / abs(complex(other)) - 1) for one, other in pairs)
    costs = {key: measured[key] for key in ("seconds", "unknowns", "peak_bytes")}
    return costs | {"true_relative_error": error, "stated_relative_error": measured["stated"]}


def _panel(name: str, rows: list[dict], scene: str) -> Panel:
    machine = f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"
    return Panel(
        name=f"error_vs_time_{name}",
        title=f"{scene}, {name}: error against CPU time",
        data={key: [row[key] for row in rows] for key in COLUMNS} | {"machine": machine},
    )


def _findings(name: str, rows: list[dict]) -> list[Finding]:
    worst = max((row["true_relative_error"] / row["stated_relative_error"] for row in rows), default=math.nan)
    table = "\n    ".join(
        f"{row['curve']:<20}{row['setting']:<18}{row['seconds']:9.4f} s {row['peak_bytes'] / 1e6:6.0f} MB "
        f"error {row['true_relative_error']:.1e} stated {row['stated_relative_error']:.1e}"
        for row in rows
    )
    statement = f"The true error is at most twice the stated one ({name})."
    quantity = "true over stated error, worst"
    findings = [judged(statement, quantity, worst, high=PROMISED, remark=table)]
    by_setting = {row["setting"]: row["seconds"] for row in rows}
    if name == "chain" and {"tolerance 0.01", "tolerance 1e-05"} <= by_setting.keys():
        per_decade = (by_setting["tolerance 1e-05"] / by_setting["tolerance 0.01"]) ** (1 / 3)
        statement = "Ten times less error costs at most half as much again."
        findings.append(judged(statement, "time per decade from 1e-2 to 1e-5", per_decade, high=PER_DECADE))
    return findings


@of_record
def figure(record: Panel, ax):
    """Draw true error against CPU time, log-log; stated errors are hollow."""
    table = record.data
    for curve, (style, colour) in STYLES.items():
        rows = [row for row, name in enumerate(table["curve"]) if name == curve]
        x, true, stated = (
            [table[key][row] for row in rows] for key in ("seconds", "true_relative_error", "stated_relative_error")
        )  # fmt: skip
        if not rows:
            continue
        ax.loglog(x, [max(error, 1e-14) for error in true], style, color=colour, markersize=5, label=curve)
        ax.plot(x, stated, style[0], color=colour, markerfacecolor="none", markersize=6)
    ax.plot([], [], "o", color="black", markerfacecolor="none", label="as stated with the answer")
    title = f"{record.title}\n{table['machine']}"
    return finished(ax, f"{quantity.cpu_time_s.axis}, warm", "relative error (1)", title)
