"""What seeing a run costs: first picture, pictures per second, memory; prints its tables.

``python tests/benchmarks/view.py``: the seed's motor is run into a temporary directory, then drawn.  Processor time (of
all threads) beside the time by the wall, which is longer on a machine that does other things.
"""

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

PICTURES = 60
BEST_OF = 3


def first_picture(folder: Path) -> tuple[float, float]:
    """Seconds by the wall and of the processor that the command takes to draw the whole stator, the best of three."""
    found = []
    for _ in range(BEST_OF):
        begun, before = time.perf_counter(), _children()
        call = [sys.executable, "-m", "studies", "view", str(folder), "--screenshot", str(folder / "a.png")]
        subprocess.run([*call, "--size", "1000x400"], check=True, capture_output=True)
        found.append((time.perf_counter() - begun, _children() - before))
    return min(wall for wall, _ in found), min(own for _, own in found)


def pictures(folder: Path, quantity: str) -> tuple[float, float]:
    """Moving pictures per second of the whole stator and of the slider, 1000 x 400, each read back."""
    from studies.view.picture import Picture
    from studies.view.run_field import run_field
    from studies.view.views import span_views

    found = run_field(folder)
    given = {"quantity": quantity, "phase": 0.0, "factor": None, "size": (1000, 400)}
    drawn = Picture(found, span_views(found, None), **given)
    drawn.image(0.0)
    begun, before = time.perf_counter(), time.process_time()
    for number in range(PICTURES):
        drawn.image(0.1 * number)
    return PICTURES / (time.perf_counter() - begun), PICTURES / (time.process_time() - before)


def _children() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main() -> None:
    """Print the table."""
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name) / "twente"
        call = [sys.executable, "-m", "studies", "run", "twente", "--no-plot", "--out", str(folder)]
        subprocess.run(call, check=True, capture_output=True)
        wall, own = first_picture(folder)
        rows.append(("first picture, from the command's start, s", f"{wall:.1f}", f"{own:.1f}"))
        for quantity in ("u_z", "power_flow"):
            wall, own = pictures(folder, quantity)
            rows.append((f"moving pictures per second, 1000 x 400, {quantity}", f"{wall:.0f}", f"{own:.0f}"))
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3
    print("| what | by the wall | of the processor |\n|---|---|---|")
    print("\n".join(f"| {' | '.join(row)} |" for row in rows))
    print(f"| memory at most, with strain energy and power flow | {memory:.0f} MB | |")


if __name__ == "__main__":
    main()
