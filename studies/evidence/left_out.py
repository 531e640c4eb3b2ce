"""What it saves to omit parts of a model, and that the answer is the same with each part included.

Method: every entry of ``left_out`` that the Python API can include is computed twice, without and with the part (see
omission.py).  The two are compared by processor time after compilation, peak allocated memory, number of unknowns, and
the relative difference of the answers.  Whole commands in their own processes show the imports, time and memory that
omitted blocks of a scene save.  Expected: differences by rounding (1e-12) or of the size that is stated for the part;
the same wave under the slider, whether the scene has a slider or not.  Run time: about 20 s.
"""

import json
import logging
import subprocess
import sys
import time
import tracemalloc
from collections.abc import Callable

from studies.evidence.omission import OMISSIONS
from studies.record.plots import finished, upper_half
from studies.record.quantities import quantity
from studies.record.text import markdown
from studies.scene import Scene
from studies.study_list import Answered, Finding, Panel, StudyRecord, judged, of_record, study

LOGGER = logging.getLogger(__name__)

# Whole runs: scene, changed keys and tolerance. Diffraction is switched off, because by default it is on with a slider
# and off without one.
DRIVEN = {"drive": {"voltage": 10}, "stator": {"diffraction": False}}
COMMANDS: dict[str, tuple[str, dict, float]] = {
    "whole chain": ("twente-left", DRIVEN, 1e-3),
    "no slider": ("twente-left", DRIVEN | {"slider": None}, 2.5e-4),
    "no transducer": ("rayleigh", {}, 1e-3),
    "no stator": ("twente-contact", {"wave": {"normal_amplitude": 3e-9}}, 1e-3),
}
WATCHED = ("numpy", "scipy", "skfem", "meshio", "numba", "pint", "matplotlib", "pyvista", "rich")
OURS = ("fem", "contact", "studies")
CENSUS = """
import json, sys, time
from studies.scene import Scene
from studies.evidence.own_process import peak_memory
from studies.runs import run
table, tolerance = json.loads(sys.argv[1])
record = run(Scene.from_table("", table), tolerance=tolerance)
wave = record.to_dict()["wave"].get("normal_m_per_V", [])
print(json.dumps([time.process_time(), peak_memory(), wave, sorted(sys.modules)]))
"""
QUICK = {"parts": ("electric potential",), "blocks": ("no stator",)}
SAME = 1e-11  # relative difference up to which two answers are equal but for rounding


@study()
def run(*, parts: tuple[str, ...] | None = None, blocks: tuple[str, ...] = tuple(COMMANDS)) -> Answered:
    """Return the cost that each omission saves, and the change of the answer if the part is included.

    Parameters
    ----------
    parts : tuple of str, optional
        Names of parts in `OMISSIONS`; all by default.
    blocks : tuple of str
        Keys of `COMMANDS`.
    """
    rows = []
    for omission in (each for each in OMISSIONS if parts is None or each.part in parts):
        LOGGER.info(f"left out: {omission.part}")
        rows.append(_measured(omission))
    commands = []
    for name in blocks:
        LOGGER.info(f"left out: {name}")
        commands.append(_command(name, *COMMANDS[name]))
    panels = (
        Panel.of_rows("parts", "What the parts that are left out would cost", rows),
        Panel.of_rows("blocks", "What absent blocks save", commands),
    )
    return panels, _findings(rows, commands)


def tables(record: StudyRecord) -> dict[str, str]:
    """Return the table of the parts and that of the blocks, in markdown."""
    parts, blocks = (panel.data for panel in record.panels)
    sizes = (name for unit in ("ms", "MB", "unknowns") for name in (f"{unit} without", "with"))
    head = ("left out", "question", *sizes, "difference", "allowed")
    rows = []
    for values in zip(*parts.values(), strict=True):
        part, question, *costs, difference, allowed, why = values
        scaled = [f"{factor * x:.3g}" for factor, x in zip((1e3, 1e3, 1e-6, 1e-6), costs, strict=False)]
        unknowns = map(str, costs[4:])
        rows.append([part, question, *scaled, *unknowns, f"{difference:.1e}", f"{allowed:.0e}, {why}"])
    columns = (blocks[key] for key in ("scene", "seconds", "bytes", "modules", "watched"))
    commands = [
        [name, f"{seconds:.2f}", f"{peak / 1e6:.0f}", str(modules), watched]
        for name, seconds, peak, modules, watched in zip(*columns, strict=True)
    ]
    census = markdown(("scene", "CPU s", "peak MB", "modules", "of them loaded"), commands)
    return {"left_out.md": "\n".join([*markdown(head, rows), "", *census]) + "\n"}


@of_record
def figure(record: Panel, ax):
    """Draw the cost with each part over the cost without it, or the time and memory of the whole commands."""
    data = record.data
    ax.invert_yaxis()
    if record.name == "blocks":
        time, y, upper = quantity.cpu_time_s.axis, range(len(data["scene"])), upper_half(ax)
        upper.invert_yaxis()
        memory = [size / 1e6 for size in data["bytes"]]
        for each, values, colour in ((upper, data["seconds"], "#0072B2"), (ax, memory, "#E69F00")):
            each.barh(y, values, 0.6, color=colour)
            each.set_yticks(y, data["scene"])
        finished(upper, time, "scene", record.title, columns=0)
        return finished(ax, "peak memory (MB)", "scene", "", columns=0)
    y = range(len(data["part"]))
    for key, colour, mark, what in (
        ("seconds", "#0072B2", "o", "time"),
        ("bytes", "#E69F00", "s", "memory"),
        ("unknowns", "#009E73", "^", "unknowns"),
    ):
        pairs = zip(data[f"{key}_with"], data[f"{key}_without"], strict=True)
        ax.semilogx([more / less for more, less in pairs], y, mark, color=colour, label=what)
    ax.axvline(1.0, color="black", linewidth=0.8)
    ax.set_yticks(y, data["part"], fontsize="x-small")
    return finished(ax, "with the part over without it (1)", "left out", record.title)


def _measured(omission) -> dict:
    """Return a row of the table of parts: costs with and without the part, relative difference of the answers."""
    first, second = omission.without(), omission.included()  # compiles the kernels, so that this is not timed
    difference = abs(first.values - second.values).max() / abs(second.values).max()
    return {
        "part": omission.part, "question": omission.question,
        "seconds_without": _seconds(omission.without), "seconds_with": _seconds(omission.included),
        "bytes_without": _peak(omission.without), "bytes_with": _peak(omission.included),
        "unknowns_without": int(first.unknowns), "unknowns_with": int(second.unknowns),
        "relative_difference": float(difference), "allowed": omission.allowed, "why": omission.why,
    }  # fmt: skip


def _seconds(work: Callable) -> float:
    """Return the processor time in s of one call."""
    start_time = time.process_time()
    work()
    return time.process_time() - start_time


def _peak(work: Callable) -> int:
    """Return the peak memory in bytes that Python and numpy allocate during one call."""
    tracemalloc.start()
    try:
        work()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


def _command(name: str, scene: str, changes: dict, tolerance: float) -> dict:
    """Run a scene in its own process; return time, memory, wave under the slider and imported modules."""
    request = json.dumps([Scene.load(scene).replace(**changes).to_table(), tolerance])
    done = subprocess.run([sys.executable, "-c", CENSUS, request], capture_output=True, text=True, check=True).stdout
    seconds, peak, wave, modules = json.loads(done.splitlines()[-1])
    tops = {module.split(".")[0] for module in modules}
    own = [f"{package} ({sum(each.startswith(package + '.') for each in modules)})" for package in OURS]
    return {
        "scene": name, "seconds": seconds, "bytes": peak, "wave_m_per_V": wave, "modules": len(modules),
        "watched": ", ".join([each for each in WATCHED if each in tops] + own),
    }  # fmt: skip


def _statement(row: dict) -> str:
    if row["allowed"] <= SAME:
        return f"The answer does not change if this is included: {row['part']}."
    return f"Included, this changes the answer by no more than its own size: {row['part']}."


def _findings(rows: list[dict], commands: list[dict]) -> tuple[Finding, ...]:
    findings = [
        judged(
            _statement(row), f"relative difference of {row['question']}", row["relative_difference"],
            high=1.000001 * row["allowed"], expected=f"at most {row['allowed']:g} ({row['why']})",
            remark=f"{1e3 * row['seconds_without']:.3g} ms without, {1e3 * row['seconds_with']:.3g} ms with it",
        )
        for row in rows
    ]  # fmt: skip
    waves = {each["scene"]: complex(*each["wave_m_per_V"]) for each in commands if each["wave_m_per_V"]}
    if not {"whole chain", "no slider"} <= waves.keys():
        return tuple(findings)
    statement = "The wave under the slider is the same without the contact's solver."
    apart = abs(waves["whole chain"] / waves["no slider"] - 1)
    return (*findings, judged(statement, "relative difference of the motion per volt", apart, high=1e-12))
