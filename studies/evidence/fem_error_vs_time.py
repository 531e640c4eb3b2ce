"""What an error of the driven stator costs: first meshes, high order, edge layers, structure, and NGSolve.

Method: the stator of ``twente`` at its frequency (160 x 5 mm, left transducer driven, right one open), with free and
with absorbing ends; error of the admittance and of u_z per volt at the slider's place, both complex, against CPU time
of one more frequency after set-up, one thread, every contender alone in its process.  The reference shares no
discretisation with any of them: for absorbing ends charges on the fingers of an infinite plate by exact partial waves
(strip_charges.py, known to 1e-12); for free ends NGSolve at its finest, stored here, known to 2e-7.  Expected: even
meshes err by tens of per cent; without edge layers the admittance stays near 1 %; the band reaches 1e-3 at least 50
(free ends) and 20 times (absorbing) sooner than NGSolve, 1e-5 at least 30 and 15 times.  What is not installed
(pypardiso, ngsolve) is left out and said so.  Run time: about 12 min, and up to 12 GB for the finest meshes.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace

from studies.evidence.peers.attempt import Attempt, attempted
from studies.evidence.peers.contenders import CURVES, Problem, missing
from studies.refusal import RunError
from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["figure", "problem", "reference", "run", "seconds_at"]

SCENE = "twente"
ENDS = ("free", "absorbing")
LIMITS = {
    "free": ((1e-3, 50.0), (1e-5, 30.0)),
    "absorbing": ((1e-3, 20.0), (1e-5, 15.0)),
}  # error, times sooner
# NGSolve, order 11, 6 edge layers, elements of 0.6 wavelengths: `tests/benchmarks/stator_peers.py --reference`.
# Against order 10, 5 layers, 0.7: 5e-7 in Y, 2e-7 in u; each layer divides the difference by more than 3.
FREE_ENDS = (
    1.082183318e-02 + 2.495454775e-02j,
    (1.610602348e-10 + 3.827739847e-10j, 1.894090783e-10 - 8.220044438e-11j),
)
QUICK = {"all_ends": ("free",), "curves": ("structured",), "settings": 1}
KNOWN = {"free": 2e-7, "absorbing": 1e-11}
DIRECT = ("P2 triangles", "Q2 quadrilaterals", "high order, no edge layers", "high order, edge layers")
STYLES = {
    "P2 triangles": ("#999999", "v"),
    "Q2 quadrilaterals": ("#CC79A7", "s"),
    "high order, no edge layers": ("#E69F00", "D"),
    "high order, edge layers": ("#D55E00", "^"),
    "NGSolve": ("#009E73", "P"),
    "structured": ("#56B4E9", "o"),
    "band": ("#0072B2", "*"),
}


def run(
    *,
    all_ends: tuple[str, ...] = ENDS,
    curves: tuple[str, ...] = tuple(CURVES),
    settings: int | None = None,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return errors and times of every contender for each kind of ends.

    Parameters
    ----------
    all_ends : tuple of str
        Of the stator.
    curves : tuple of str
        The contenders, of `CURVES`.
    settings : int, optional
        How many of each contender's resolutions, from the coarsest; all without a number.
    progress : callable, optional
        Told what is being done.
    """
    begun = time.perf_counter()
    say = progress or (lambda text: None)
    panels, findings = [], []
    for ends in all_ends:
        posed = problem(ends)
        say(f"{ends} ends: reference")
        truth = reference(posed)
        attempts: list[Attempt] = []
        for curve in curves:
            lacking = missing(curve)
            if lacking:
                say(f"{curve}: left out, {' and '.join(lacking)} not installed")
                continue
            for setting in CURVES[curve][1][:settings]:
                say(f"{ends} ends: {curve}, {setting}")
                try:
                    attempts.append(attempted(curve, posed, setting, repeats=0 if curve in DIRECT else 1))
                except RunError as error:
                    say(f"left out: {error}")
        panels.append(_panel(ends, attempts, truth))
        findings += _findings(ends, attempts, truth)
    return StudyRecord(
        name="fem_error_vs_time",
        panels=tuple(panels),
        findings=tuple(findings),
        seconds=time.perf_counter() - begun,
    )


def problem(ends: str) -> Problem:
    """Return the stator of the scene with other ends, the driven transducer first."""
    from studies.chain import resolve
    from studies.scene import Scene

    scene = resolve.resolved(Scene.load(SCENE))
    transducers = sorted(resolve.transducers(scene), key=lambda each: each.center)
    return Problem(
        stator=replace(resolve.stator(scene.stator), ends=ends),
        transducers=tuple(transducers),
        frequency=scene.frequency,
        wavelength=transducers[0].period,
        place=scene.slider.position,
    )


def reference(posed: Problem) -> tuple[complex, tuple[complex, complex]]:
    """Admittance (S) and u_x, u_z (m per V) from a discretisation that no contender shares."""
    if posed.stator.ends == "free":
        return FREE_ENDS
    import numpy as np

    from studies.evidence.peers.plate_response import PlateResponse
    from studies.evidence.peers.strip_charges import StripCharges

    solid = posed.stator.solid
    plate = PlateResponse(
        stiffness=solid.stiffness_lossy,
        coupling=solid.coupling,
        permittivity=solid.permittivity_lossy,
        density=solid.density,
        thickness=posed.stator.thickness,
        frequency=posed.frequency,
    )
    strips = StripCharges(
        plate=plate,
        centers=np.concatenate([each.fingers.mean(axis=1) for each in posed.transducers]),
        half_width=posed.transducers[0].finger_width / 2,
        terms=8,
    )
    owner = [2 * index + (sign == "-") for index, each in enumerate(posed.transducers) for sign in each.signs]
    charges, coefficients = strips.charges(np.array(owner), {0: 0.5, 1: -0.5})
    motion = strips.motion(coefficients, posed.place)
    admittance = 2j * np.pi * posed.frequency * posed.transducers[0].aperture * charges[0]
    return complex(admittance), (complex(motion[0]), complex(motion[1]))


def seconds_at(attempts: list[Attempt], truth, error: float) -> float:
    """Time a curve needs for an error of both outputs, between its points by powers; NaN if it never gets there."""
    points = sorted((max(each.errors(truth)), each.seconds) for each in attempts)[::-1]
    within = [index for index, point in enumerate(points) if point[0] <= error]
    if not within:
        return math.nan
    if within[0] == 0:
        return points[0][1]
    (before, slow), (after, fast) = points[within[0] - 1], points[within[0]]
    share = math.log(error / before) / math.log(after / before)
    return math.exp(math.log(slow) + share * math.log(fast / slow))


@of_record
def figure(record: Panel, ax):
    """Draw error against time: admittance filled and full, motion hollow and dashed."""
    table = record.data
    for curve, (colour, mark) in STYLES.items():
        rows = [row for row, name in enumerate(table["curve"]) if name == curve]
        if not rows:
            continue
        x = [table["seconds"][row] for row in rows]
        for key, line, fill in (("admittance", "-", colour), ("motion", "--", "white")):
            y = [table[f"{key}_relative_error"][row] for row in rows]
            label = curve if key == "admittance" else None
            ax.loglog(
                x,
                y,
                line,
                marker=mark,
                color=colour,
                markerfacecolor=fill,
                markersize=6,
                linewidth=1,
                label=label,
            )
    if table["reference_relative_error"] > 1e-8:
        ax.axhline(table["reference_relative_error"], color="black", linestyle=":", linewidth=0.8)
    ax.set_xlabel("CPU time of one more frequency, one thread (s)")
    ax.set_ylabel("relative error (1): filled admittance, hollow nm/V")
    ax.set_title(record.title, fontsize="medium")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
    return ax


def _panel(ends: str, attempts: list[Attempt], truth) -> Panel:
    errors = [each.errors(truth) for each in attempts]
    return Panel(
        name=f"error_against_time_{ends}",
        title=f"twente, {ends} ends, 2.2 MHz",
        data={
            "curve": [each.curve for each in attempts],
            "setting": [each.setting for each in attempts],
            "unknowns": [each.unknowns for each in attempts],
            "setup_seconds": [each.setup_seconds for each in attempts],
            "seconds": [each.seconds for each in attempts],
            "peak_bytes": [each.peak_bytes for each in attempts],
            "admittance_relative_error": [of_admittance for of_admittance, _ in errors],
            "motion_relative_error": [of_motion for _, of_motion in errors],
            "reference_relative_error": KNOWN[ends],
        },
    )


def _findings(ends: str, attempts: list[Attempt], truth) -> list[Finding]:
    by_curve: dict[str, list[Attempt]] = {}
    for each in attempts:
        by_curve.setdefault(each.curve, []).append(each)
    findings = []
    if "structured" in by_curve:
        best = max(by_curve["structured"][-1].errors(truth))
        findings.append(
            Finding(
                statement=f"The finest level agrees with a discretisation it shares nothing with ({ends} ends).",
                quantity="error, worse of both outputs",
                expected="below 1e-6",
                found=best,
                confirmed=best < 1e-6,
            )
        )
    if "NGSolve" in by_curve and "band" in by_curve:
        for error, least in LIMITS[ends]:
            peer, own = (seconds_at(by_curve[name], truth, error) for name in ("NGSolve", "band"))
            short = math.isnan(peer)
            if short:
                peer = max(each.seconds for each in by_curve["NGSolve"])
            if math.isnan(own):
                own = math.inf
            findings.append(
                Finding(
                    statement=f"The band is as exact as NGSolve in a fraction of the time ({ends} ends, {error:g}).",
                    quantity="NGSolve's time over the band's, per frequency after set-up",
                    expected=f"at least {least:g}",
                    found=peer / own,
                    confirmed=peer / own >= least,
                    remark=f"{'more than ' if short else ''}{peer:.2f} s against {1e3 * own:.1f} ms",
                )
            )
    return findings
