"""The contact's costs and accuracies: prints the README's tables.

    python tests/benchmarks/contact_ways.py

The seed's slider (1 mm ball, 0.089 g, mu 0.08) on its 2.2 MHz wave.  Times are the best of three, kernels compiled
beforehand; errors are relative to max(|v|, omega |u_x|/10).
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import math
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np

import contact
from contact.ways import rest, rest_problem

SLIDER = contact.Slider(
    radius=1e-3, mass=0.089e-3, preload=0.089e-3 * 9.81, load=0.0, friction_coefficient=0.08, effective_modulus=64e9,
    tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0, normal_damping=0.5,
    tangential_damping=1e-4,
)  # fmt: skip
FREQUENCY = 2.2e6


def orbit(amplitude: float) -> contact.Orbit:
    """Return the seed's orbit."""
    return contact.Orbit(frequency=FREQUENCY, normal=amplitude, tangential=-0.7j * amplitude)


def timed(work, repeats: int = 3):
    """Return the result and the best time in s of some work, after one run that compiles."""
    work()
    best = math.inf
    for _ in range(repeats):
        begun = time.perf_counter()
        result = work()
        best = min(best, time.perf_counter() - begun)
    return result, best


def over(difference: float, v: float, amplitude: float) -> float:
    """Return a difference over the reference speed."""
    return abs(difference) / max(abs(v), 2.0 * math.pi * FREQUENCY * 0.07 * amplitude)


def ways():
    """Print the agreement of the ways after 2200 cycles."""
    print("\nv after 2200 cycles: error against the event-exact way; ms")
    print(f"{'amplitude':>10} {'exact us/cycle':>15} {'estimate':>9} | {'stepped 1e-4':>20} | {'stepped 1e-6':>20} | "
          f"{'averaged 1e-4':>20} | {'averaged 1e-6':>20}")  # fmt: skip
    for A in (0.75e-9, 1e-9, 3e-9, 5e-9, 10e-9, 20e-9):
        given = {"duration": 1e-3, "after": 0.0, "samples": 2}
        exact, seconds = timed(
            lambda A=A, g=given: contact.burst(SLIDER, orbit(A), tolerance=1e-8, method="exact", **g), 1
        )
        v, cells = exact.velocity_at_burst_end, []
        for method, tolerance in (
            ("stepped", 1e-4),
            ("stepped", 1e-6),
            ("averaged", 1e-4),
            ("averaged", 1e-6),
        ):
            found, spent = timed(
                lambda A=A, m=method, t=tolerance, g=given: contact.burst(
                    SLIDER, orbit(A), tolerance=t, method=m, **g
                )
            )
            cells.append(f"{over(found.velocity_at_burst_end - v, v, A):9.1e} {spent * 1e3:7.2f} ms")
        cells = " | ".join(cells)
        print(f"{A * 1e9:7.2f} nm {seconds / 4400 * 1e6:15.1f} {exact.relative_error:9.1e} | {cells}")


def long_bursts():
    """Print long bursts: the averaged response of 0.1 s, the stepped burst of 0.3 s."""
    print("\nlong bursts, time with the error estimate (two runs)")
    for A in (3e-9, 10e-9):
        for method, duration, tolerance in (
            ("averaged", 0.1, 1e-4), ("averaged", 0.1, 1e-6), ("stepped", 0.3, 1e-4), ("stepped", 0.3, 1e-6),
        ):  # fmt: skip
            found, spent = timed(
                lambda A=A, m=method, d=duration, t=tolerance: contact.burst(
                    SLIDER, orbit(A), duration=d, after=0.0, tolerance=t, samples=200, method=m
                ),
                1,
            )
            print(f"{A * 1e9:5.1f} nm {method:9} {duration} s at {tolerance:g}: {spent * 1e3:9.2f} ms, "
                  f"estimated error {found.relative_error:.1e}, v {found.velocity_at_burst_end:.9g} m/s")  # fmt: skip


def steady_states():
    """Print steady states one at a time and a map of a thousand."""
    print("\nsteady states: averaged with second order, from scratch, against the periodic motion")
    for A in (0.75e-9, 1e-9, 3e-9, 5e-9, 10e-9, 20e-9):
        found, spent = timed(lambda A=A: contact.mean_motion(SLIDER, orbit(A)), 20)
        full = contact.steady(SLIDER, orbit(A), tolerance=1e-8)
        first, second = (over(v - full.velocity, v, A) for v in (found.first_order, found.velocity))
        print(
            f"{A * 1e9:7.2f} nm: {spent * 1e3:6.3f} ms, error {second:.1e} (first order {first:.1e}), "
            f"estimate {over(found.error, found.velocity, A):.1e}; periodic motion {full.seconds * 1e3:.2f} ms"
        )
    factors, preloads = np.linspace(0.5, 20.0, 40), np.geomspace(1e-4, 1e-2, 25)
    for workers in (1, 2):
        found, spent = timed(
            lambda w=workers: contact.steady_map(
                SLIDER, orbit(1e-9), factors=factors, preloads=preloads, workers=w
            )
        )
        print(
            f"map of {found.velocity.size} steady states, {workers} threads: {spent:.3f} s, "
            f"{np.sum(found.regime == 'unknown')} unknown"
        )


def simulated():
    """Print the rate of full simulations on two threads."""
    from concurrent.futures import ThreadPoolExecutor

    from contact.stepped import steps

    print("\nfull simulation, many runs on two threads")
    number, nothing, flat = 20000, np.empty((0, 3)), np.empty(0, complex)
    for per_cycle in (16, 24, 32):
        worst, jobs = 0.0, []
        for A in (3e-9, 5e-9, 10e-9, 20e-9):
            problem = rest_problem(SLIDER, (orbit(A),))
            begin = rest(SLIDER, (orbit(A),), problem, nodes=12, truncation=1e-10)
            jobs.append((problem, begin.state.copy()))
            begin.turn(2000)
            state = jobs[-1][1].copy()
            steps(problem.parameters, problem.waves, state, 2000, per_cycle, 0, nothing, flat)
            worst = max(
                worst, abs(state[2] - begin.state[2]) / max(begin.state[2], 0.07 * A / problem.length)
            )

        def one(job, per_cycle=per_cycle):
            problem, state = job
            steps(problem.parameters, problem.waves, state.copy(), number, per_cycle, 0, nothing, flat)

        with ThreadPoolExecutor(2) as pool:
            _, spent = timed(lambda pool=pool, jobs=jobs, one=one: list(pool.map(one, jobs)))
        print(
            f"{per_cycle} steps per cycle: {len(jobs) * number / spent / 1e6:.2f}e6 cycles/s, worst error {worst:.1e}"
        )


def limits():
    """Print the cost of the closed forms."""
    print("\nclosed forms")
    for work in (contact.threshold_factor, contact.release_factor, contact.riding_height):
        _, spent = timed(lambda work=work: work(SLIDER, orbit(3e-9)), 20)
        print(f"{work.__name__}: {spent * 1e3:.3f} ms")


def starts():
    """Print the first use ever and the start from the cache of kernels."""
    print("\nstarting a new process: first use ever, then from the cache")
    script = (
        "import sys, time; t = time.perf_counter(); import contact as c; "
        "s = c.Slider(radius=1e-3, mass=8.9e-5, preload=8.7e-4, load=0.0, friction_coefficient=0.08, "
        "effective_modulus=64e9, tangential_modulus=12e9, law='elastic', reciprocal=False, stick_band=0.0, "
        "contact_damping=0.0, normal_damping=0.5, tangential_damping=1e-4); "
        "o = c.Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j); {}; print(time.perf_counter() - t)"
    )
    for name, call in (
        ("steady", "c.steady(s, o, tolerance=1e-3)"),
        ("averaged burst", "c.burst(s, o, duration=0.01, after=0.0, tolerance=1e-4, samples=2)"),
    ):
        with tempfile.TemporaryDirectory() as folder:
            for label in ("first", "cached"):
                done = subprocess.run(
                    [sys.executable, "-c", script.format(call)], env=os.environ | {"NUMBA_CACHE_DIR": folder},
                    capture_output=True, text=True, check=True,
                )  # fmt: skip
                print(f"{name}, {label}: {float(done.stdout):.2f} s")


if __name__ == "__main__":
    print(
        f"{platform.machine()}, {os.cpu_count()} processors, Python {platform.python_version()}, numpy {np.__version__}"
    )
    ways()
    long_bursts()
    steady_states()
    simulated()
    limits()
    starts()
