"""What sweeps must show: prints the whole table of figures, measured, pass or short.

    python tests/benchmarks/sweep_table.py [--quick]

Every figure is that of the command, started as a user starts it, with its store on the disk; kernels are compiled
beforehand.  Wall time, and beside it the CPU time of all processes, which other work on the machine does not change.
--quick leaves out the million points and all but 3 of the 20 kills.  Run time: about 8 min, 2 min with --quick.
"""

import argparse
import json
import os
import platform
import random
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
from contextlib import closing, contextmanager
from pathlib import Path

from studies.model.resolve import resolved
from studies.scene import Scene

CONTACT = ("--over", "slider.preload=0.1 mN:10 mN:100:log", "--over", "wave.normal_amplitude=0.5 nm:20 nm:{}")
LONG = (
    "--over", "wave.burst=8e-4", "--set", "slider.method=exact", "--over", "slider.preload=0.3 mN:3 mN:12:log",
    "--over", "wave.normal_amplitude=2 nm:6 nm:8",
)  # fmt: skip
MEASURED = """
import json, resource, sys, time
from studies.__main__ import main
begun = time.perf_counter()
status = main(sys.argv[1:])
own = resource.getrusage(resource.RUSAGE_SELF)
print(json.dumps([status, own.ru_maxrss / 1024, own.ru_utime + own.ru_stime]), file=sys.stderr)
"""


def environment() -> dict:
    here = str(Path(__file__).parents[2])
    return os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "PYTHONPATH": here}


def swept(folder: Path, *words: str, before: str = "") -> dict:
    """Run the command; return its answer with wall, CPU (all processes, driver), memory of the driver in MB."""
    then, begun = os.times(), time.perf_counter()
    process = subprocess.run(
        [sys.executable, "-c", before + MEASURED, "sweep", *words, "--json", "--out", str(folder)],
        capture_output=True, text=True, env=environment(), check=False,
    )  # fmt: skip
    wall, after = time.perf_counter() - begun, os.times()
    cpu = after.children_user + after.children_system - then.children_user - then.children_system
    status, memory, own = json.loads(process.stderr.splitlines()[-1])
    found = json.loads(process.stdout) if process.stdout else {}
    return found | {"wall": wall, "cpu": cpu, "own": own, "memory": memory, "status": status, "said": process.stderr}


def rows(folder: Path) -> list[tuple]:
    with closing(sqlite3.connect(folder / "points.sqlite")) as connection:
        return connection.execute("select * from points order by point").fetchall()


def line(what: str, wanted: str, found: str, passed: bool) -> None:
    print(f"| {what} | {wanted} | {found} | {'yes' if passed else 'short'} |", flush=True)


def contact_map(folder: Path) -> None:
    found = swept(folder / "map", "twente-contact", *_with(CONTACT, 100))
    line("10 000-point contact map", "10 s (3 s)", f"{found['wall']:.1f} s (CPU {found['cpu']:.1f} s)",
         found["wall"] <= 10 and found["counts"] == {"ok": 10_000})  # fmt: skip


def frequencies(folder: Path) -> None:
    scene = resolved(Scene.load("twente"))
    kept = [f"transducer.{k}.period={each.period!r}" for k, each in enumerate(scene.transducer)]
    found = swept(
        folder / "frequencies", "twente", *(word for each in kept for word in ("--set", each)), "--voltage", "30",
        "--over", "drive.frequency=2.15 MHz:2.25 MHz:100", "--over", "slider.preload=0.1 mN:10 mN:100:log",
    )  # fmt: skip
    text = f"{found['wall']:.1f} s (CPU {found['cpu']:.1f} s), {found['counts']}"
    text += f", error {found['largest_relative_error']:.1e}"
    line("100 frequencies x 100 preloads, stator included", "8 s", text, found["wall"] <= 8)


@contextmanager
def cluster(number: int):
    """Lend the address of a scheduler with so many separate workers, all of one thread."""
    from distributed import Client, LocalCluster

    with (
        LocalCluster(n_workers=number, threads_per_worker=1, processes=True, dashboard_address=None) as some,
        Client(some) as client,
    ):
        client.run(_warm)
        yield some.scheduler_address


def _warm() -> None:
    from studies.sweeps import sweep

    sweep("twente-contact", {"wave.burst": [8e-4], "slider.method": ["exact"], "wave.normal_amplitude": [3e-9]})


def dask_workers(folder: Path) -> None:
    walls, work, busy = {}, {}, {}
    for number in (1, 2):
        with cluster(number) as address:
            found = swept(folder / f"dask{number}", "twente-contact", *LONG, "--scheduler", address)
            walls[number], work[number] = found["seconds"], found["work_seconds"] / found["points"]
            busy[number] = found["work_seconds"] / (number * found["seconds"])
    same = rows(folder / "dask1") == rows(folder / "dask2")
    gain = walls[1] / walls[2]
    text = f"{gain:.2f}x ({walls[1]:.1f} s, {walls[2]:.1f} s; points of {work[1] * 1e3:.0f} ms, workers busy for "
    text += f"{busy[1]:.0%} and {busy[2]:.0%} of the time, same bits: {same})"
    line("2 Dask workers against 1", ">= 1.8x", text, gain >= 1.8 and same)


def threads(folder: Path) -> None:
    """Measure two processes of one thread against two of two, for bursts, which can use two."""
    found = {}
    for number in (1, 2):
        setting = f"from studies.sweeps.workers import Processes; Processes.threads = {number}\n"
        found[number] = swept(folder / f"threads{number}", "twente-contact", *LONG, "--workers", "2", before=setting)
    text = ", ".join(
        f"{number} thread{'s' * (number > 1)}: {each['wall']:.1f} s, CPU {each['cpu']:.1f} s"
        for number, each in found.items()
    )
    better = found[1]["cpu"] <= 1.05 * found[2]["cpu"]  # on a busy machine more threads are given more time
    line("one thread per worker or two, 2 workers on 2 processors", "one, measured", text, better)


def overhead(folder: Path) -> None:
    for name, words in (("processes", ("--workers", "2")), ("Dask", ())):
        if name == "Dask":
            with cluster(2) as address:
                found = swept(folder / name, "twente-contact", *_with(CONTACT, 100), "--scheduler", address)
                none = swept(folder / "none", "twente-contact", *_with(CONTACT, 1)[:4], "--scheduler", address)
        else:
            found = swept(folder / name, "twente-contact", *_with(CONTACT, 100), *words)
            none = swept(folder / f"none {name}", "twente-contact", *_with(CONTACT, 1)[:4], *words)
        each = (found["own"] - none["own"]) / 10_000 * 1e3
        line(f"overhead per point, {name}: CPU of the driver beyond its start", "<= 1 ms", f"{each:.3f} ms", each <= 1)


def kills(folder: Path, times: int) -> None:
    words = ("twente-contact", *_with(CONTACT, 50))
    undisturbed = swept(folder / "undisturbed", *words)
    generator, lost, reported, done, stores = random.Random(1), 0, 0, 0, 1
    while done < times:
        place = folder / f"killed{stores}"
        process = subprocess.Popen(
            [sys.executable, "-m", "studies", "sweep", *words, "--workers", str(1 + done % 2), "--out", str(place)],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment(),
        )  # fmt: skip
        wait, begun, seen = generator.uniform(0.1, 1.2 * undisturbed["wall"]), time.perf_counter(), []
        while time.perf_counter() - begun < wait and process.poll() is None:
            time.sleep(0.02)
            try:
                seen = rows(place) if (place / "points.sqlite").exists() else seen
            except sqlite3.OperationalError:
                continue  # before its tables stand
        if process.poll() is not None:  # it was done before: another one
            stores += 1
            continue
        process.send_signal(signal.SIGKILL)
        process.wait()
        kept = {row[0]: row for row in rows(place)} if seen else {}
        lost += sum(kept.get(row[0]) != row for row in seen)
        reported += len(seen)
        done += 1
    places = sorted(folder.glob("killed*"))
    for place in places:
        swept(place, *words)
    same = [rows(place) == rows(folder / "undisturbed") for place in places]
    text = f"{done} kills, {reported} rows seen before them, {lost} lost; "
    text += f"{sum(same)} of {len(same)} stores the same bits"
    line("kill -9 in a 5000-point sweep, then resume", "nothing lost, equal", text, all(same) and lost == 0)


def million(folder: Path) -> None:
    found = swept(
        folder / "million", "twente-contact", "--over", "slider.preload=1 mN:10 mN:1000:log",
        "--over", "wave.normal_amplitude=0.1 nm:0.6 nm:1000", "--workers", "2",
    )  # fmt: skip
    size = (folder / "million" / "points.sqlite").stat().st_size / 2**20
    text = f"{found['memory']:.0f} MB ({found['wall']:.0f} s, CPU {found['cpu']:.0f} s, store {size:.0f} MB)"
    line("memory of the driver at 1e6 points", "< 500 MB", text, found["memory"] < 500 and found["points"] == 10**6)


def bad_points(folder: Path) -> None:
    masses = [-1e-4 if k % 10 == 3 else 1e-4 * (1 + k / 100) for k in range(100)]
    table = folder / "points.csv"
    pairs = [f"{mass!r},{(0.5 + 0.195 * k) * 1e-9!r}" for mass in masses for k in range(100)]
    table.write_text("\n".join(["slider.mass,wave.normal_amplitude", *pairs]))
    found = swept(folder / "bad", "twente-contact", "--points", str(table))
    named = found["reasons"][0] if found["reasons"] else {"status": "-", "points": 0}
    text = f"{found['counts']}; {named['points']} x {named['status']!r}"
    line("10 % impossible values", "the rest complete, each named", text,
         found["counts"] == {"ok": 9000, "refused": 1000} and named["points"] == 1000)  # fmt: skip


def _with(words, *values) -> tuple[str, ...]:
    return tuple(word.format(*values) for word in words)


def main() -> None:
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--quick", action="store_true")
    arguments.add_argument("--only", help="one of the lines, such as kills")
    given = arguments.parse_args()
    quick = given.quick
    print(f"{platform.machine()}, {os.cpu_count()} processors, load {os.getloadavg()[0]:.1f}\n")
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        swept(folder / "warm", "twente-contact", "--over", "slider.preload=1 mN,2 mN")
        print("| what | wanted | found | passed |\n|---|---|---|---|")
        for measured in (contact_map, frequencies, dask_workers, threads, overhead, kills, million, bad_points):
            if given.only in (None, measured.__name__) and not (quick and measured is million):
                measured(folder, *([3 if quick else 20] if measured is kills else []))


if __name__ == "__main__":
    main()
