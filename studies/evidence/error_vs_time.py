"""What a smaller error of the slider's velocity costs, along the chain and beside the alternatives.

Method: ``twente`` at its voltages for tolerances from 1e-1 to 1e-6, each in a process of its own: true error of the
velocity (against the run at 1e-7 of the stator's levels and the event-exact contact) and wall time, beside the error
that the run states.  In the same picture the stator alone, the contact alone (its ways on the same orbits), and what
others do: even meshes of quadratic elements in front of our contact, and event solvers off the shelf that follow 2200
cycles from rest at one voltage, against the 20 steady states of ours.  Expected: ten times less error costs at most
half as much again from 1e-2 to 1e-5; every true error is at most twice the stated one.  Run time: about 4 min.
"""

import math
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

from studies.evidence.peers.attempt import alone, peak_memory
from studies.refusal import RunError
from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["figure", "run"]

SCENE = "twente"
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6)
MESHES = (2, 4)  # quadratic elements per wavelength
SOLVERS = (("DOP853", 1e-6), ("LSODA", 1e-6), ("DOP853", 1e-9), ("LSODA", 1e-9))
CYCLES, HELD, PATIENCE = 2200, 0.2, 60.0  # of a peer: cycles from rest, largest step (rad), s
PEER_VOLTAGE = 30.0
PER_DECADE, PROMISED = 1.5, 2.0
QUICK = {"tolerances": (3e-1, 1e-1), "meshes": (), "solvers": (), "apart": False}
STYLES = {
    "chain": ("o-", "#0072B2"),
    "stator alone": ("s-", "#009E73"),
    "contact alone": ("^-", "#D55E00"),
    "quadratic mesh, our contact": ("D--", "#CC79A7"),
    "solve_ivp, one voltage": ("v:", "#999999"),
}


def run(
    scene: str | Path = SCENE,
    *,
    tolerances: tuple[float, ...] = TOLERANCES,
    meshes: tuple[int, ...] = MESHES,
    solvers: tuple[tuple[str, float], ...] = SOLVERS,
    apart: bool = True,
    progress: Callable[[str], None] | None = None,
) -> StudyRecord:
    """Return errors, times, unknowns and memory of the chain, of its parts and of the alternatives.

    Parameters
    ----------
    scene : str or Path
        A path or a shipped name of a scene with transducers and a slider.
    tolerances : tuple of float
        From loose to tight; the last gives the converged answer.
    meshes : tuple of int
        Quadratic elements per wavelength of the even meshes.
    solvers : tuple of (str, float)
        Event solvers of scipy with their relative tolerances.
    apart : bool
        Whether each measurement has a process of its own, as figures of time and memory need.
    progress : callable, optional
        Told what is being done.
    """
    begun = time.perf_counter()
    say = progress or (lambda text: None)
    say("error against time: converged answer")
    measured = alone if apart else lambda what, work, *arguments: work(*arguments)
    truth = measured("the converged answer", _chain, str(scene), tolerances[-1])
    rows: list[dict] = []

    def add(curve: str, setting: str, work: Callable, *arguments) -> None:
        say(f"error against time: {curve}, {setting}")
        try:
            found = measured(f"{curve}, {setting}", work, str(scene), *arguments)
        except RunError as error:
            say(f"left out: {error}")
            return
        rows.append({"curve": curve, "setting": setting} | _judged(found, truth))

    for tolerance in tolerances[:-1]:
        add("chain", f"tolerance {tolerance:g}", _chain, tolerance)
    for tolerance in tolerances[:-1]:
        add("stator alone", f"tolerance {tolerance:g}", _stator, tolerance)
    for way in ("first order", "second order", "exact"):
        add("contact alone", way, _contact, way, truth["orbits"])
    for per_wavelength in meshes:
        add("quadratic mesh, our contact", f"{per_wavelength} per wavelength", _mesh, per_wavelength)
    for method, rtol in solvers:
        add("solve_ivp, one voltage", f"{method}, rtol {rtol:g}", _solver, method, rtol, truth["orbits"])
    return StudyRecord(
        name="error_vs_time",
        panels=(_panel(rows, str(scene)),),
        findings=_findings(rows),
        seconds=time.perf_counter() - begun,
    )


def _scene(source: str):
    from studies.chain.resolve import resolved
    from studies.scene import Scene

    return resolved(Scene.load(source))


def _measured(work: Callable) -> dict:
    """Return what the second of two runs found, with its wall time; the first compiles and loads."""
    work()
    begun = time.perf_counter()
    found = work()
    return {"seconds": time.perf_counter() - begun, "peak_bytes": peak_memory(), "unknowns": 0} | found


def _chain(source: str, tolerance: float) -> dict:
    from studies.chain import run as run_chain

    scene = _scene(source)

    def work() -> dict:
        record = run_chain(scene, tolerance=tolerance)
        points = record.points
        return {
            "velocity": [point["velocity_m_per_s"] for point in points],
            "speed": [
                max(
                    abs(p["velocity_m_per_s"]),
                    2 * math.pi * scene.frequency * p["tangential_amplitude_m"] / 10,
                )
                for p in points
            ],
            "estimate": record.error["relative"],
            "unknowns": record.surface_wave.unknowns,
            "motion": (record.wave["tangential_m_per_V"], record.wave["normal_m_per_V"]),
            "orbits": (record.wave["tangential_m_per_V"], record.wave["normal_m_per_V"]),
        }

    return _measured(work)


def _stator(source: str, tolerance: float) -> dict:
    from studies.chain import run as run_chain

    scene = _scene(source)
    place = scene.slider.position

    def work() -> dict:
        wave = run_chain(replace(scene, slider=None), tolerance=tolerance).surface_wave
        motion = wave.motion(place)
        return {
            "motion": (complex(motion[0]), complex(motion[1])),
            "estimate": wave.relative_error,
            "unknowns": wave.unknowns,
        }

    return _measured(work)


def _orbit(scene, motion):
    import contact

    return contact.Orbit(frequency=scene.frequency, tangential=complex(motion[0]), normal=complex(motion[1]))


def _velocities(scene, motion, way: str) -> dict:
    """Return the steady velocities at the scene's voltages for a motion per volt."""
    import contact
    from studies.chain import bridge

    slider, orbit = bridge.contact_slider(scene.slider), _orbit(scene, motion)
    velocities = []
    for voltage in scene.levels:
        if way == "exact":
            velocities.append(contact.steady(slider, orbit.scaled(voltage), tolerance=1e-6).velocity)
        else:
            mean = contact.mean_motion(slider, orbit.scaled(voltage))
            velocities.append(mean.first_order if way == "first order" else mean.velocity)
    return {"velocity": velocities}


def _contact(source: str, way: str, motion) -> dict:
    scene = _scene(source)
    return _measured(lambda: _velocities(scene, motion, way))


def _mesh(source: str, per_wavelength: int) -> dict:
    from studies.chain import resolve
    from studies.evidence.peers.uniform_mesh import uniform_solution

    scene = _scene(source)
    transducers = tuple(sorted(resolve.transducers(scene), key=lambda each: each.center))
    begun = time.perf_counter()
    _, motion, unknowns = uniform_solution(
        resolve.stator(scene.stator),
        transducers,
        frequency=scene.frequency,
        wavelength=transducers[0].period,
        per_wavelength=per_wavelength,
        triangles=False,
        place=scene.slider.position,
    )
    motion = complex(motion[0]), complex(motion[1])
    found = _velocities(scene, motion, "exact")
    seconds = time.perf_counter() - begun
    return found | {"motion": motion, "unknowns": unknowns, "seconds": seconds, "peak_bytes": peak_memory()}


def _solver(source: str, method: str, rtol: float, motion) -> dict:
    """Return v after a number of cycles from rest by an event solver of scipy, against our event-exact way."""
    from contact.answers.methods import rest, rest_problem
    from studies.chain import bridge
    from studies.evidence.peers import contact as contact_peers

    scene = _scene(source)
    slider, orbit = bridge.contact_slider(scene.slider), _orbit(scene, motion).scaled(PEER_VOLTAGE)
    problem = rest_problem(slider, (orbit,))
    exact = rest(slider, (orbit,), problem, nodes=16, truncation=1e-12)
    begin = exact.state.copy()
    exact.turn(CYCLES)
    segment = contact_peers.scipy_solver(method, rtol=rtol, max_step=HELD)
    contact_peers.with_events(problem, begin, 1, segment, limit=PATIENCE)
    started = time.perf_counter()
    velocity, _, complaint = contact_peers.with_events(problem, begin, CYCLES, segment, limit=PATIENCE)
    if complaint:
        raise RunError(f"{method}: {complaint}")
    return {
        "seconds": time.perf_counter() - started,
        "peak_bytes": peak_memory(),
        "unknowns": len(begin),
        "error": abs(velocity / float(exact.state[2]) - 1),
    }


def _judged(found: dict, truth: dict) -> dict:
    """Return a row: time, memory, unknowns, true error (velocity's, else the motion's) and the stated one."""
    error = found.get("error")
    if error is None and "velocity" in found:
        differences = zip(found["velocity"], truth["velocity"], truth["speed"], strict=True)
        error = max(abs(one - other) / speed for one, other, speed in differences)
    elif error is None:
        error = max(
            abs(abs(one) / abs(other) - 1)
            for one, other in zip(found["motion"], truth["motion"], strict=True)
        )
    return {
        "seconds": found["seconds"],
        "peak_bytes": found["peak_bytes"],
        "unknowns": found["unknowns"],
        "true_relative_error": error,
        "stated_relative_error": found.get("estimate", 0.0),
    }


def _panel(rows: list[dict], scene: str) -> Panel:
    import os
    import platform

    keys = (
        "curve",
        "setting",
        "seconds",
        "unknowns",
        "peak_bytes",
        "true_relative_error",
        "stated_relative_error",
    )
    machine = f"{platform.machine()}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"
    return Panel(
        name="error_vs_time",
        title=f"{scene}: error of the velocity against wall time",
        data={key: [row[key] for row in rows] for key in keys} | {"machine": machine},
    )


def _findings(rows: list[dict]) -> tuple[Finding, ...]:
    own = [row for row in rows if row["curve"] == "chain"]
    by_setting = {row["setting"]: row for row in own}
    worst = max(row["true_relative_error"] / row["stated_relative_error"] for row in own)
    meshes = [row for row in rows if row["curve"] == "quadratic mesh, our contact"]
    findings = [
        Finding(
            statement="The error stated is the error made.",
            quantity="true over stated error, worst",
            expected=f"at most {PROMISED:g}",
            found=worst,
            confirmed=worst <= PROMISED,
        )
    ]
    if {"tolerance 0.01", "tolerance 1e-05"} <= by_setting.keys():
        loose, tight = by_setting["tolerance 0.01"], by_setting["tolerance 1e-05"]
        per_decade = (tight["seconds"] / loose["seconds"]) ** (1 / 3)
        findings.append(
            Finding(
                statement="Ten times less error costs at most half as much again.",
                quantity="time per decade from 1e-2 to 1e-5",
                expected=f"at most {PER_DECADE}",
                found=per_decade,
                confirmed=per_decade <= PER_DECADE,
            )
        )
    if meshes:
        best = min(meshes, key=lambda row: row["true_relative_error"])
        rough = by_setting["tolerance 0.1"]
        findings.append(
            Finding(
                statement="An even mesh takes longer than the loosest run and errs more.",
                quantity="its smallest error over that run's",
                expected="above 1",
                found=best["true_relative_error"] / rough["true_relative_error"],
                confirmed=best["true_relative_error"] > rough["true_relative_error"]
                and best["seconds"] > rough["seconds"],
                remark=f"{best['seconds']:.1f} s against {rough['seconds']:.1f} s",
            )
        )
    table = "\n    ".join(
        f"{row['curve']:<28}{row['setting']:<20}{row['seconds']:9.3f} s {row['peak_bytes'] / 1e6:6.0f} MB "
        f"{row['unknowns']:>8} unknowns  error {row['true_relative_error']:.1e} "
        f"stated {row['stated_relative_error']:.1e}"
        for row in rows
    )
    return (*findings[:-1], replace(findings[-1], remark=f"{findings[-1].remark}\n    {table}"))


@of_record
def figure(record: Panel, ax):
    """Draw true error against wall time, log-log; what the chain states is drawn hollow."""
    table = record.data
    for curve, (style, colour) in STYLES.items():
        rows = [row for row, name in enumerate(table["curve"]) if name == curve]
        rows = [
            row for row in rows if table["true_relative_error"][row] > 0
        ]  # what all are compared with has none
        x = [table["seconds"][row] for row in rows]
        ax.loglog(
            x,
            [table["true_relative_error"][row] for row in rows],
            style,
            color=colour,
            markersize=5,
            label=curve,
        )
        stated = [(at, table["stated_relative_error"][row]) for at, row in zip(x, rows, strict=True)]
        stated = [(at, value) for at, value in stated if value > 0]
        if stated:
            ax.plot(*zip(*stated, strict=True), style[0], color=colour, markerfacecolor="none", markersize=6)
    ax.plot([], [], "o", color="black", markerfacecolor="none", label="as stated with the answer")
    ax.set_xlabel("wall time, warm (s)")
    ax.set_ylabel("relative error of the velocity (stator: motion)")
    ax.set_title(f"{record.title}\n{table['machine']}", fontsize="medium")
    ax.grid(alpha=0.3)
    ax.legend(frameon=False, fontsize="small")
    return ax
