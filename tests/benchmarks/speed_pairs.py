"""CPU times in several trees of this repository by turns: contact, bands of frequencies, commands, compilation.

    python tests/benchmarks/speed_pairs.py TREE [TREE ...] [--only WORDS]

TREE is a folder with a checkout and its environment in `.venv`.  Each row is the median of several calls on one thread
in a process of its own, kernels compiled before, with the stated error; the time is that of its child processes too.
It imports the public interface alone, so that it runs in old trees too.  Motor: the seed's ball at 10 nm; balls with
phases drawn; flat pillars at drawn places; the seed's stator with free ends.  The command rows take minutes.
"""

import argparse
import json
import math
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from pathlib import Path
from statistics import median

FREQUENCY, AMPLITUDE = 2.2e6, 10e-9
BALL = {
    "radius": 1e-3, "mass": 0.089e-3, "preload": 0.089e-3 * 9.81, "load": 0.0, "friction_coefficient": 0.08,
    "effective_modulus": 64e9, "tangential_modulus": 12e9, "law": "elastic", "reciprocal": False, "stick_band": 0.0,
    "contact_damping": 0.0, "normal_damping": 0.5, "tangential_damping": 1e-4,
}  # fmt: skip


def wave(factor: complex = 1.0):
    """Return the seed's orbit times a factor."""
    from contact import Orbit

    return Orbit(frequency=FREQUENCY, normal=AMPLITUDE * factor, tangential=-0.7j * AMPLITUDE * factor)


def burst(duration: float, tolerance: float, method: str):
    """Return (velocity, relative error, status) of a burst of the seed's ball."""
    import contact

    samples = 200 if duration >= 1e-3 else 2
    options = {"duration": duration, "after": 0.0, "tolerance": tolerance, "samples": samples, "method": method}
    found = contact.burst(contact.Slider(**BALL), wave(), **options)
    return found.velocity_at_burst_end, found.relative_error, found.status


def steady(count: int):
    """Return the same of the steady state of so many balls."""
    import numpy as np

    import contact

    draw = np.random.default_rng(count)
    turns = (0.8 + 0.4 * draw.random(count)) * np.exp(2j * np.pi * draw.random(count)) if count > 1 else [1.0]
    own = {"mass": count * BALL["mass"], "preload": count * BALL["preload"]} | ({"heights": (0.0,) * count})
    found = contact.steady(contact.Slider(**BALL | own), tuple(wave(turn) for turn in turns), tolerance=1e-6)
    return found.velocity, found.relative_error, found.status


def pillars(count: int):
    """Return the same of so many pillars at drawn places that load the wave."""
    import numpy as np

    import contact

    draw = np.random.default_rng(7)
    x, y = draw.uniform(-2.5e-3, 2.5e-3, (2, count))
    slider = replace(
        contact.Slider(**BALL), radius=None, normal_stiffness=1.8e10 / count, tangential_stiffness=1.52e10 / count,
        shape="punch", x=x, y=y, heights=draw.normal(scale=10e-9, size=count), friction_coefficient=0.18,
        mass=math.inf, preload=30.0, normal_damping=0.0, tangential_damping=0.0, load=1.0,
    )  # fmt: skip
    passing = contact.PassingWave(
        frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9, backward=0.0, compliance=2.5078e-12,
        strip_width=5e-3, loading=None,
    )  # fmt: skip
    found = contact.steady(slider, passing, tolerance=1e-3)
    return found.velocity, found.relative_error, found.status


def band(tolerance: float):
    """Return the same of a band of frequencies of the seed's stator with free ends: mean size of the motion in m/V."""
    import numpy as np

    from fem import frequency_band
    from tests.validation.stator_reference import problem

    posed = problem("free")
    found = frequency_band(
        posed.stator, posed.transducers, lowest=2.1e6, highest=2.3e6, drive="left", tolerance=tolerance,
        places=(posed.place,),
    )  # fmt: skip
    motion = [
        abs(each.motion(np.array([posed.place]))).max() for each in found.waves(np.linspace(2.1e6, 2.3e6, 3), "left")
    ]
    return (
        float(np.mean(motion)),
        found.relative_error,
        "ok" if found.relative_error <= tolerance else "above tolerance",
    )


def command(*words: str, tree: Path | None = None):
    """Run a command of the tree, or of a copy of it; return (0, 0, how it ended)."""
    own = "PYTHONPATH", "NUMBA_CACHE_DIR", "XDG_CACHE_HOME"
    environment = os.environ | ({} if tree is None else dict.fromkeys(own, str(tree)))
    call = [sys.executable, "-m", "studies", *words]
    ran = subprocess.run(call, env=environment, cwd=tree, capture_output=True, text=True, check=False)
    return 0.0, 0.0, "ok" if ran.returncode == 0 else f"ended with {ran.returncode}"


# invented, and fitted well by `twente-contact`: chi^2 of 6.7 with 4 degrees of freedom; m and m/s
CURVE = """normal_amplitude_m,velocity_m_per_s,velocity_standard_deviation_m_per_s
2e-9,0.0087,4e-4
5e-9,0.0305,8e-4
8e-9,0.0545,1.2e-3
1.1e-8,0.0772,1.6e-3
1.5e-8,0.105,2.2e-3
2e-8,0.140,3e-3
"""


def fitted(folder: Path):
    """Fit two numbers to a curve and rank the next measurements."""
    (folder / "curve.csv").write_text(CURVE)
    free = "slider.friction_coefficient=0.02:0.3", "slider.preload=0.2 mN:4 mN"
    out = "--out", str(folder / "fitted"), "--no-plot"
    return command("fit", "twente-contact", "--data", str(folder / "curve.csv"), "--free", *free, *out)


def prepared(folder: Path):
    """Run the seed's motor once, for `viewed`."""
    if not (folder / "run").exists():
        command("run", "twente", "--no-plot", "--out", str(folder / "run"))
    return folder / "run"


def viewed(folder: Path):
    """Draw the solid of a run; the run itself is made in the first call, which is not timed."""
    return command("view", str(prepared(folder)), "--show", "solid", "--screenshot", str(folder / "solid.png"))


def masked(folder: Path):
    """Export the seed's mask with its picture."""
    return command("export", "twente", "--format", "gds", "--out", str(folder / "mask"))


def compiled(folder: Path):
    """Compute a first contact in a copy of the packages, beside which no kernels lie; the copy takes 0.1 s."""
    copy = Path(tempfile.mkdtemp(dir=folder))
    for package in ("fem", "contact", "studies"):
        shutil.copytree(package, copy / package, ignore=shutil.ignore_patterns("__pycache__"))
    return command("run", "twente-contact", "--no-plot", "--out", str(copy / "first"), tree=copy)


# what is computed, and how often
ROWS = {
    "averaged burst of 0.1 s at 1e-4": (lambda: burst(0.1, 1e-4, "averaged"), 9),
    "averaged burst of 200 cycles at 1e-4": (lambda: burst(200 / FREQUENCY, 1e-4, "averaged"), 9),
    "burst of 200 cycles at 1e-4, auto": (lambda: burst(200 / FREQUENCY, 1e-4, "auto"), 9),
    "stepped burst of 0.1 s at 1e-4": (lambda: burst(0.1, 1e-4, "stepped"), 5),
    "stepped burst of 0.1 s at 1e-6": (lambda: burst(0.1, 1e-6, "stepped"), 5),
    "exact burst of 2200 cycles at 1e-8": (lambda: burst(2200 / FREQUENCY, 1e-8, "exact"), 7),
    "steady state of 1 ball": (lambda: steady(1), 9),
    "steady state of 100 balls": (lambda: steady(100), 5),
    "steady state of 1000 balls": (lambda: steady(1000), 3),
    "steady state of 3000 balls": (lambda: steady(3000), 1),
    "steady state of 100 000 pillars": (lambda: pillars(100_000), 1),
    "band set-up at 1e-2": (lambda: band(1e-2), 3),
    "band set-up at 1e-3": (lambda: band(1e-3), 3),
    "band set-up at 1e-4": (lambda: band(1e-4), 3),
    "fit of two numbers, next measurements": (fitted, 1),
    "view --show solid": (viewed, 3),
    "mask with its picture": (masked, 3),
    "compiling at first use": (compiled, 1),
}


def measured(row: str) -> dict:
    """Return the CPU time of a row in this process, ms, its answer and the memory, MB."""
    work, count = ROWS[row]
    with tempfile.TemporaryDirectory() as folder:
        arguments = (Path(folder),) if work in (fitted, viewed, masked, compiled) else ()
        work(*arguments)
        times = []
        for _ in range(count):
            start = _spent()
            velocity, error, status = work(*arguments)
            times.append(1e3 * (_spent() - start))
    memory = max(resource.getrusage(who).ru_maxrss for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)) // 1024
    return {"time": median(times), "velocity": velocity, "error": error, "status": status, "memory": memory}


def _spent() -> float:
    """Return the CPU time of this process and of its children that have ended, s."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def in_tree(tree: Path, row: str) -> str:
    """Return the cell of a row in a tree."""
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "1", "SAWMOTOR_THREADS": "1", "PYTHONPATH": str(tree)}
    words = [str(tree / ".venv" / "bin" / "python"), str(Path(__file__).resolve()), "--inside", row]
    for _ in range(2):  # the first process compiles, which takes memory
        ran = subprocess.run(words, cwd=tree, env=environment, capture_output=True, text=True, check=False)
    if ran.returncode != 0:
        return "-"
    found = json.loads(ran.stdout.splitlines()[-1])
    return f"{found['time']:.3g} ms, {found['error']:.1e} {found['status']}, {found['memory']} MB"


def main() -> None:
    """Print the table, or one row of this process."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("trees", nargs="*", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--inside", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.inside:
        sys.path.insert(0, os.getcwd())
        print(json.dumps(measured(arguments.inside)))
        return
    names = [
        subprocess.run(
            ["git", "-C", tree, "log", "-1", "--format=%h"], capture_output=True, text=True, check=True
        ).stdout.strip()
        for tree in arguments.trees
    ]
    print(f"| what | {' | '.join(names)} |\n|---|{'---|' * len(names)}")
    for row in ROWS:
        if arguments.only in row:
            print(f"| {row} | {' | '.join(in_tree(tree.resolve(), row) for tree in arguments.trees)} |", flush=True)


if __name__ == "__main__":
    main()
