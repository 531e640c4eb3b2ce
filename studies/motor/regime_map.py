"""Where the slider sticks, slips, is thrown off and hops, against amplitude and preload.

Method: the slider of ``twente-contact``, or of a scene with a given wave, on a grid of amplitudes and preloads: steady
states by averaging with its second-order correction.  Beside them the closed forms: the threshold A sqrt(r^2 + c^2) =
c |h|, the release A = h, and hopping, where the slider rides above the surface at rest (h < 0, contact for less than
half of each cycle).  The scene's own levels are marked.  Expected: every simulated point on the side of the lines that
its regime says; a dozen of them the same by the event-exact way to 1e-6.  Run time: about 1 s.
"""

import sys
import time
from collections.abc import Callable
from dataclasses import replace

from studies.chain import bridge
from studies.scene import Scene
from studies.study import Finding, Panel, StudyRecord, of_record

__all__ = ["figure", "run"]

TAKES_SCENE = True
AMPLITUDES, PRELOADS = 36, 28
KINDS = ("stick", "slip", "intermittent", "hopping")
CHECKED = 12


def run(
    scene: str | Scene = "twente-contact", *, progress: Callable[[str], None] | None = None
) -> StudyRecord:
    """Return the map, its lines and the operating points.

    Parameters
    ----------
    scene : str or Scene
        A path, a shipped name or a scene with a given wave and a slider.
    progress : callable, optional
        Told what is being done.
    """
    import numpy as np

    import contact

    begun = time.perf_counter()
    say = progress or (lambda text: None)
    chosen, slider, shape = bridge.on_given_wave(scene)
    own = slider.preload
    if own == 0.0 or slider.friction_coefficient == 0.0:
        chosen.refuse("slider.preload", "must be positive, with friction, for a map of regimes")
    threshold = contact.threshold_amplitude(slider, shape)
    release = contact.release_amplitude(slider, shape)
    reach = [level for level in chosen.levels if level > 0.0]
    amplitudes = np.geomspace(
        min([0.4 * threshold, *reach]), max([6.0 * release, *(1.2 * a for a in reach)]), AMPLITUDES
    )
    preloads = own * np.geomspace(0.08, 12.0, PRELOADS)
    say(f"regime map: {amplitudes.size * preloads.size} steady states")
    found = contact.steady_map(slider, shape, factors=amplitudes, preloads=preloads)
    kind = np.where((found.regime == "intermittent") & (found.height < 0.0), "hopping", found.regime)
    loaded = [replace(slider, preload=float(preload)) for preload in preloads]
    lines = {
        "threshold": np.array([contact.threshold_amplitude(s, shape) for s in loaded]),
        "release": np.array([contact.release_amplitude(s, shape) for s in loaded]),
        "hopping": np.array([s.rest_approach(1) for s in loaded]) / _half_wave() ** (2.0 / 3.0),
    }
    A = amplitudes[None, :]
    expected = np.select(
        [A < lines["threshold"][:, None], A < lines["release"][:, None], A < lines["hopping"][:, None]],
        KINDS[:3],
        KINDS[3],
    )
    # a load can only move the threshold, not the lines of the normal motion
    agree = float(np.mean(expected[kind != "unknown"] == kind[kind != "unknown"]))
    say("regime map: checks by the event-exact way")
    worst = _worst(slider, shape, amplitudes, preloads, found)
    findings = [
        Finding(
            statement="Threshold, release and hopping lines in closed form part the simulated regimes.",
            quantity="share of simulated points on the expected side",
            expected="1",
            found=agree,
            confirmed=agree == 1.0,
            remark=f"{int(np.sum(kind == 'unknown'))} points where the averaged way does not apply",
        ),
        Finding(
            statement="The averaged steady states are those of the full motion.",
            quantity=f"largest difference over max(|v|, omega |u_x|/10) at {CHECKED} points",
            expected="below 1e-6",
            found=worst,
            confirmed=worst < 1e-6,
        ),
    ]
    data = {
        "amplitude_m": amplitudes,
        "preload_N": preloads,
        "kind": kind.tolist(),
        "velocity_m_per_s": found.velocity,
        "lines_m": lines,
        "operating_amplitude_m": np.array(reach),
        "operating_preload_N": own,
    }
    panel = Panel(name="regime_map", title=f"{chosen.title}: regimes", data=data)
    return StudyRecord(
        name="regime_map", panels=(panel,), findings=tuple(findings), seconds=time.perf_counter() - begun
    )


def _half_wave() -> float:
    """Return the cycle mean of max(cos, 0)^1.5, Gamma(5/4)/(2 sqrt(pi) Gamma(7/4))."""
    from math import gamma, pi, sqrt

    return gamma(1.25) / (2.0 * sqrt(pi) * gamma(1.75))


def _worst(slider, shape, amplitudes, preloads, found) -> float:
    """Return the largest difference to the event-exact way over a scatter of moving points."""
    import numpy as np

    import contact

    at = np.argwhere(np.abs(np.nan_to_num(found.velocity)) > 0.0)
    differences = []
    for i, j in at[:: max(1, len(at) // CHECKED)][:CHECKED]:
        orbits = bridge.scaled(shape, float(amplitudes[j]))
        full = contact.steady(replace(slider, preload=float(preloads[i])), orbits, tolerance=1e-6)
        scale = max(abs(full.velocity), orbits[0].omega * abs(orbits[0].tangential) / 10.0)
        differences.append(abs(full.velocity - found.velocity[i, j]) / scale)
    return float(max(differences, default=0.0))


@of_record
def figure(record: Panel, ax):
    """Draw simulated regimes as points, closed forms as lines, the operating points as stars."""
    import numpy as np

    from studies.report.figures import COLOURS

    data = record.data
    A, preload = np.asarray(data["amplitude_m"]) * 1e9, np.asarray(data["preload_N"]) * 1e3
    kind = np.array(data["kind"])
    marks = {"stick": "s", "slip": "o", "intermittent": "^", "hopping": "d"}
    colours = COLOURS | {"hopping": COLOURS["second"]}
    for name, mark in marks.items():
        i, j = np.nonzero(kind == name)
        ax.plot(A[j], preload[i], mark, color=colours[name], markersize=3.2, label=f"{name} (simulated)")
    for (name, values), style in zip(data["lines_m"].items(), (":", "--", "-."), strict=True):
        values = np.asarray(values) * 1e9
        ax.plot(values, preload, style, color=COLOURS["line"], linewidth=1.3, label=f"{name} (theory)")
    ours = np.asarray(data["operating_amplitude_m"]) * 1e9
    ax.plot(ours, np.full(ours.size, data["operating_preload_N"] * 1e3), "*", color="#CC79A7", markersize=8,
            markeredgecolor=COLOURS["line"], markeredgewidth=0.4, label="operating points")  # fmt: skip
    ax.set_xscale("log")
    ax.set_yscale("log")
    ax.set_xlim(A[0], A[-1])
    ax.set_xlabel("normal amplitude (nm)")
    ax.set_ylabel("preload (mN)")
    ax.set_title(record.title, fontsize="medium")
    ax.legend(loc="upper left", bbox_to_anchor=(1.01, 1.0), frameon=False, fontsize="small")
    return ax


if __name__ == "__main__":
    from studies.__main__ import main

    sys.exit(main(["study", "regime_map", *sys.argv[1:]]))
