"""What the stator must show: prints the whole table of figures, measured, pass or short.

    python -m tests.benchmarks.stator_table [--quick]

Both columns of a comparison come from this one run, the pairs one after the other; times are medians, one thread, CPU
seconds (wall time where processes or threads are started).  The contenders against NGSolve are those of
`stator_peers.py`; --quick leaves them out.  Run time: about 8 min, 1 min with --quick.
"""

import os

os.environ.update(dict.fromkeys(("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"), "1"))

import argparse
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import replace

import numpy as np

from fem import coupling, frequency_band, material, rayleigh, rotated
from fem.condense.finger_columns import condensed
from fem.condense.joined_fingers import repeated
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS
from fem.geometry import Stator, Transducer
from fem.materials.christoffel import slowest_wavelength
from fem.results.field_evaluation import surface_of
from fem.results.power_balance import power_balance
from fem.results.stator_solution import Solution
from fem.solve.driven_stator import solve_driven
from fem.waveguide.end_conditions import Wall
from tests.fem.direct import direct_solution
from tests.validation.attempt import attempted
from tests.validation.contenders import CURVES, missing
from tests.validation.stator_reference import LIMITS, problem, reference, seconds_at

# Largest element (wavelengths) and layers of the direct mesh's stretches: at 0.05 they still err by 1.4e-10; more
# layers at an absorbing end are more than scikit-fem can place points in.
STRETCHES = {"free": (0.03, 3), "absorbing": (0.025, 1)}
SWEEP = """
import numpy as np
from fem import frequency_band
from tests.validation.stator_reference import problem
posed = problem("free")
band = frequency_band(posed.stator, posed.transducers, lowest=2.1e6, highest=2.3e6, drive="left", tolerance=1e-3,
                      places=(posed.place,))
band.waves(np.linspace(2.1e6, 2.3e6, 100), "left")
"""
PEAK = """
from studies.evidence.own_process import peak_memory
print(peak_memory())
"""
RUN = """
from studies.__main__ import main
main(["run", "twente", "--out", {folder!r}])
"""
SOLIDS = (
    ("PZT-8", "Z"),
    ("PZT-5H", "X"),
    ("LiNbO3 (Kovacs)", "128YX"),
    ("LiNbO3 (Warner)", "YZ"),
    ("quartz (Bechmann)", "ST-X"),
)


def row(what: str, figure: float, measured: float, unit: str = "", *, least: bool = False) -> None:
    """Print a line of the table; a figure is a bound from above, or from below if ``least``."""
    met = measured >= figure if least else measured <= figure
    sign, verdict = ">=" if least else "<=", "pass" if met else "SHORT"
    print(f"| {what} | {sign} {figure:g} {unit} | {measured:.3g} {unit} | {verdict} |", flush=True)


def cpu(work, repeats: int = 7) -> float:
    """Median CPU time of some work in s, after one run that does not count."""
    work()
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        work()
        times.append(time.process_time() - begun)
    return float(np.median(times))


def alone(program: str) -> tuple[float, float]:
    """Wall time (s) and peak memory (MB) of a Python process; its own high water, not what it was forked from."""
    begun = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", program + PEAK], check=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
    )
    return time.perf_counter() - begun, float(done.stdout.split()[-1]) / 1e6


def small(ends: str, **rest) -> tuple[Stator, tuple[Transducer, ...]]:
    """Two unlike transducers on a short stator; lengths in wavelengths of the slowest bulk wave."""
    solid = replace(material("PZT-8"), **rest)
    unit = slowest_wavelength(solid, 2.2e6)
    one = Transducer(name="left", center=1.5 * unit, finger_pairs=1, period=unit, metallisation=0.5, aperture=0.02)
    other = replace(one, name="right", center=4 * unit, finger_pairs=2, period=0.9 * unit, metallisation=0.4)
    return Stator(solid=solid, length=5.5 * unit, thickness=0.5 * unit, ends=ends), (one, other)


def structured(stator, transducers, resolution=LEVELS[2]) -> Solution:
    """Solution at 2.2 MHz, the left transducer driven."""
    return solve_driven(stator, transducers, frequency=2.2e6, drive="left", resolution=resolution)


def same_mesh() -> None:
    """Structured against direct: the direct mesh's stretches are fine enough that the transducers' mesh is all."""
    worst = [0.0, 0.0]
    for ends, (size, layers) in STRETCHES.items():
        stator, transducers = small(ends)
        resolution = Resolution(order=8, edge_layers=1)
        ours = structured(stator, transducers, resolution)
        direct = direct_solution(
            stator,
            transducers,
            frequency=2.2e6,
            resolution=resolution,
            wavelength=ours.fields.section.length_unit,
            segment_size=size,
            segment_layers=layers,
        )
        x = np.linspace(0.01, 0.99, 67) * stator.length
        moved, other = surface_of(ours).motion(x), direct.surface(x) @ ours.circuit.voltages
        own = ours.fields.admittances
        worst[0] = max(worst[0], abs(own - direct.admittances).max() / abs(own).max())
        worst[1] = max(worst[1], abs(moved - other).max() / abs(other).max())
    row("structured against direct solve, same mesh: charge", 1e-10, worst[0])
    row("structured against direct solve, same mesh: surface field", 1e-10, worst[1])


def peers() -> None:
    """Band and NGSolve in turns; equal error of both outputs by powers between the settings."""
    for ends, limits in LIMITS.items():
        posed = problem(ends)
        truth = reference(posed)
        found: dict[str, list] = {"band": [], "NGSolve": []}
        with_peer = not missing("NGSolve")
        for index in range(max(len(CURVES[name][1]) for name in found)):
            for name, repeats in (("NGSolve", 1), ("band", 9)):
                settings = CURVES[name][1]
                if index < len(settings) and (name == "band" or with_peer):
                    found[name].append(attempted(name, posed, settings[index], repeats=repeats))
        if not with_peer:
            print("NGSolve is not installed (pip install ngsolve): its rows are left out")
        for error, least in limits:
            own, peer = (seconds_at(found[name], truth, error) if found[name] else np.nan for name in found)
            if with_peer:
                row(
                    f"NGSolve's time over ours, {ends} ends, equal error {error:g} ({peer:.2f} s, {1e3 * own:.1f} ms)",
                    least,
                    peer / own,
                    "times",
                    least=True,
                )


def frequencies() -> None:
    """Per frequency after set-up, with the true error beside it; a hundred of them; length."""
    posed = problem("free")
    truth = reference(posed)
    for tolerance, figure in ((1e-3, 50.0), (1e-5, 200.0)):
        each = attempted("band", posed, {"tolerance": tolerance}, repeats=9)
        true = max(each.errors(truth))
        row(
            f"twente, free ends, per frequency at {tolerance:g} (true error {true:.1e})",
            figure,
            1e3 * each.seconds,
            "ms",
        )
        row(f"its true error at {tolerance:g}", tolerance, true)
    runs = [alone(SWEEP) for _ in range(3)]
    row(
        "100 frequencies, set-up and process start included (wall, 2 cores)",
        3.0,
        float(np.median([run[0] for run in runs])),
        "s",
    )
    row("peak memory of those 100 frequencies", 400.0, max(run[1] for run in runs), "MB")


def length() -> None:
    """Cost of a frequency at 1000 wavelengths over that at 160, in turns."""
    posed = problem("free")
    bands = []
    for stretch in (0.0, 840 * posed.wavelength):
        moved = (posed.transducers[0], replace(posed.transducers[1], center=posed.transducers[1].center + stretch))
        stator = replace(posed.stator, length=posed.stator.length + stretch)
        bands.append(
            frequency_band(stator, moved, lowest=2.1e6, highest=2.3e6, drive="left", tolerance=1e-3, places=(0.08,))
        )
    ratios = []
    for _ in range(9):
        short, long = (cpu(lambda band=band: band.wave(2.2e6, "left"), 1) for band in bands)
        ratios.append(long / short)
    row("cost at 1000 wavelengths over 160, free ends", 1.3, float(np.median(ratios)), "times")


def memory() -> None:
    """Peak memory of the whole run, voltage to velocity."""
    with tempfile.TemporaryDirectory() as folder:
        seconds, peak = alone(RUN.format(folder=f"{folder}/run"))
    row(f"peak memory of the whole run ({seconds:.1f} s)", 400.0, peak, "MB")


def physics() -> None:
    """Absorbing ends, power, reciprocity."""
    posed = problem("absorbing")
    own = structured(posed.stator, posed.transducers)
    modes, n = own.fields.modes, own.fields.section.size
    piece = repeated(condensed(own.fields.section, 2.2e6, width=0.25, electrode=None), 8).matrix
    inner = np.linalg.solve(piece[n : 2 * n, n : 2 * n] - modes.right_impedance, piece[n : 2 * n, :n])
    wall = piece[:n, :n] - piece[:n, n : 2 * n] @ inner  # two wavelengths of elements, then the absorbing end
    back = Wall(matrix=wall, recover=None).reflection(modes, 1, modes.rayleigh)
    sent = abs(back[modes.rayleigh]).max()
    row("absorbing ends: reflection of the Rayleigh wave, met through two wavelengths of elements", 1e-10, sent)
    lossless = replace(posed.stator.solid, mechanical_quality=np.inf, dielectric_loss=0.0)
    powers = power_balance(structured(replace(posed.stator, solid=lossless), posed.transducers))
    row("lossless: power in = power out through the ends", 1e-9, abs(powers.radiated / powers.input - 1))
    worst = 0.0
    for ends in ("free", "absorbing"):
        stator, transducers = small(ends)
        solution = structured(stator, transducers)
        own = solution.fields.admittances
        worst = max(worst, abs(own[0, -1] / own[-1, 0] - 1))
    row("reciprocity between two unlike transducers", 1e-11, worst)


def waves() -> None:
    """Half-space; a density that changes keeps every cache out."""
    slowest = 0.0
    for name, orientation in SOLIDS:
        base = rotated(material(name), orientation)
        times = []
        for turn in range(9):
            solid = replace(base, density=base.density * (1 + 1e-6 * turn))
            begun = time.process_time()
            rayleigh(solid, "vacuum")
            coupling(solid)
            times.append(time.process_time() - begun)
        slowest = max(slowest, float(np.median(times)))
    row("half-space v and K2, slowest of five cuts", 10.0, 1e3 * slowest, "ms")


def main(arguments: list[str] | None = None) -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args(arguments).quick
    print(f"{platform.machine()}, {os.cpu_count()} cores, numpy {np.__version__}; CPU time, one thread, unless said\n")
    print("| what | figure | measured | |")
    print("|---|---|---|---|")
    for part in (same_mesh, frequencies, length, memory, physics, waves):
        part()
    if not quick:
        peers()


if __name__ == "__main__":
    main()
