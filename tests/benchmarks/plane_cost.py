"""CPU time of motion in the plane: an averaged point of three balls, and the exact motion against that along a line.

    python -m tests.benchmarks.plane_cost

Run it with OMP_NUM_THREADS=1 on a machine that does nothing else: medians of CPU time.
"""

import math
import time

import numpy as np

from contact import Orbit, plane
from contact import burst as burst_along_x
from tests.contact.plane_motors import R_X, F, ball, beams

X, Y = np.array([6e-3, -3e-3, -3e-3]), np.array([0.0, 5.19615e-3, -5.19615e-3])
CYCLES, T = 2000, 1.0 / 2.2e6


def three(freedom="xy yaw", **changes):
    """Return a slider on three balls, without dampers."""
    return ball(**({"x": X, "y": Y, "preload": 3 * F, "tilt": "free", "freedom": freedom} | changes))


def uneven(nm: float, slope: float):
    """Return one wave whose amplitude changes across."""
    rows = [[-1j * R_X * a, 0.0, a] for a in nm * 1e-9 * (1.0 + slope * Y / 5.19615e-3)]
    return plane.SurfaceWaves(frequencies=[2.2e6], amplitudes=[rows])


def crossing(nm: float):
    """Return two crossing waves of one frequency with another phase at each ball: some contacts never open."""
    x, y = nm * 1e-9 * np.exp(2j * np.pi * np.random.default_rng(1).random((2, 3)))
    y = y * np.exp(1j)
    amplitudes = np.stack([-1j * R_X * x, -1j * R_X * y, x + y], axis=-1)[None]
    return plane.SurfaceWaves(frequencies=[2.2e6], amplitudes=amplitudes)


POINTS = {
    "uneven wave, 10 nm": (three(), uneven(10, 0.2)),
    "uneven wave, 3 nm": (three(), uneven(3, 0.05)),
    "the same, 10 nm, yaw locked": (three("xy"), uneven(10, 0.2)),
    "crossing waves, 10 nm": (three(), crossing(10)),
    "crossing waves, 3 nm": (three(), crossing(3)),
    "crossing waves, 10 nm, yaw locked": (three("xy"), crossing(10)),
    "crossing waves, 10 nm, load": (three(load=(0.0, 1e-5)), crossing(10)),
    "crossing waves, 1 nm": (three(), crossing(1)),
}


def cpu(compute, repeats: int = 15) -> float:
    """Return the median CPU time in s."""
    compute()
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        compute()
        times.append(time.process_time() - begun)
    return float(np.median(times))


def main() -> None:
    """Print both tables."""
    print("averaged point of three balls, ms, at tolerances 1e-3, 1e-6, 1e-8")
    for name, (slider, waves) in POINTS.items():
        times = [
            1e3 * cpu(lambda s=slider, w=waves, t=tolerance: plane.steady(s, w, tolerance=t))
            for tolerance in (1e-3, 1e-6, 1e-8)
        ]
        print(f"  {name:36s}" + "".join(f"{each:8.2f}" for each in times))
    print("exact burst of one ball, us per cycle: along a line, in the plane on the same wave, on two waves; ratios")
    slider = ball(mass=0.089e-3, normal_damping=0.5)
    line = ball(mass=0.089e-3, normal_damping=0.5, freedom="x", load=0.0)
    given = {"duration": CYCLES * T, "after": 0.0, "samples": 2, "method": "exact"}
    for nm in (3, 10):
        orbit = Orbit(frequency=2.2e6, normal=nm * 1e-9, tangential=-1j * R_X * nm * 1e-9)
        for tolerance in (1e-3, 1e-6):
            times = [
                1e6 / CYCLES * cpu(lambda t=tolerance, o=orbit: burst_along_x(line, o, tolerance=t, **given), 5),
                *(
                    1e6 / CYCLES * cpu(lambda t=tolerance, w=w: plane.burst(slider, w, tolerance=t, **given), 5)
                    for w in (beams(nm, 0), beams(nm, nm, math.pi / 3))
                ),
            ]
            ratios = [each / times[0] for each in times[1:]]
            print(f"  {nm:2d} nm, {tolerance:.0e}" + "".join(f"{each:8.1f}" for each in times)
                  + "".join(f"{each:6.1f}x" for each in ratios))  # fmt: skip


if __name__ == "__main__":
    main()
