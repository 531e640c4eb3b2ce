"""The contact's costs and accuracies: prints its tables, each figure beside the one asked for.

    python -m tests.benchmarks.contact_ways

A figure that is not reached is marked SHORT. The seed's slider (1 mm ball, 0.089 g, mu 0.08) on its 2.2 MHz wave.
Times are CPU times, the best of three, kernels compiled beforehand, on one thread but for the full simulation, which is
timed by the wall; errors are relative to max(|v|, omega |u_x|/10).
"""

import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("SAWMOTOR_THREADS", "1")

import math
import platform
import subprocess
import sys
import tempfile
import time

import numpy as np

import contact
from contact.answers.event_driven_burst import ANSWER, LEFT_OUT, LONG
from contact.answers.rest_motion import rest, rest_problem
from contact.problem import with_longer_segments
from tests import seed_motor
from tests.contact.motors import steady_map
from tests.seed_motor import FREQUENCY

SLIDER = contact.Slider(**seed_motor.SLIDER)


def orbit(amplitude: float) -> contact.Orbit:
    """Return the seed's orbit."""
    return contact.Orbit(frequency=FREQUENCY, normal=amplitude, tangential=-0.7j * amplitude)


def timed(work, repeats: int = 3, clock=time.process_time):
    """Return the result and the best time in s of some work, after one run that compiles."""
    work()
    best = math.inf
    for _ in range(repeats):
        begun = clock()
        result = work()
        best = min(best, clock() - begun)
    return result, best


def over(difference: float, v: float, amplitude: float) -> float:
    """Return a difference over the reference speed."""
    return abs(difference) / max(abs(v), 2.0 * math.pi * FREQUENCY * 0.07 * amplitude)


def asked(figure: float, limit: float, unit: str, least: bool = False) -> str:
    """Return the figure asked for and whether it is reached; `least`: more is better."""
    reached = figure >= limit if least else figure <= limit
    return f"(asked {limit:g} {unit}: {'pass' if reached else 'SHORT'})"


def ways():
    """Print the agreement of the ways after 2200 cycles."""
    print("\nv after 2200 cycles, every event followed; stepped against it, estimates in brackets")
    worst = 0.0
    for A in (0.75e-9, 1e-9, 3e-9, 5e-9, 10e-9, 20e-9):
        given = {"duration": 1e-3, "after": 0.0, "samples": 2}
        finest = contact.burst(SLIDER, orbit(A), tolerance=1e-13, method="exact", **given)
        v, cells = finest.velocity_at_burst_end, []
        for method, tolerance in (
            ("exact", 1e-8), ("stepped", 1e-4), ("stepped", 1e-6), ("stepped", 1e-8), ("averaged", 1e-4),
            ("averaged", 1e-6),
        ):  # fmt: skip
            found, spent = timed(
                lambda A=A, m=method, t=tolerance, g=given: contact.burst(SLIDER, orbit(A), tolerance=t, method=m, **g)
            )
            error = over(found.velocity_at_burst_end - v, v, A)
            if tolerance == 1e-8:
                worst = max(worst, error)
            cells.append(f"{error:.1e} ({found.relative_error:.0e}) {spent * 1e3:.2f} ms")
            if method == "exact":
                problem = with_longer_segments(rest_problem(SLIDER, (orbit(A),)), LONG)
                nodes, truncation, _ = ANSWER
                begin = rest(SLIDER, (orbit(A),), problem, nodes=nodes, truncation=truncation)
                begin.close = LEFT_OUT * tolerance
                _, alone = timed(lambda m=begin: m.copy().turn(2200))
                cells[-1] += f" = {spent / 2200e-6:.1f} us/cycle, one run alone {alone / 2200e-6:.1f}"
                cells[-1] += " " + asked(spent / 2200e-6, 12.0, "us")
        print(f"{A * 1e9:7.2f} nm exact 1e-8 {cells[0]}")
        print(f"           stepped 1e-4 {cells[1]} | 1e-6 {cells[2]} | 1e-8 {cells[3]}")
        print(f"           averaged 1e-4 {cells[4]} | 1e-6 {cells[5]}")
    print(f"exact against stepped at their finest: {worst:.1e} {asked(worst, 5e-9, '')}")


def long_bursts():
    """Print long bursts: the averaged response of 0.1 s, the stepped burst of 0.3 s."""
    print("\nlong bursts, time with the error estimate (two runs)")
    for A in (3e-9, 10e-9):
        for method, duration, tolerance, limit in (
            ("averaged", 0.1, 1e-4, 2.0), ("averaged", 0.1, 1e-6, math.inf), ("stepped", 0.3, 1e-4, 1e3),
            ("stepped", 0.3, 1e-6, 5e3),
        ):  # fmt: skip
            found, spent = timed(
                lambda A=A, m=method, d=duration, t=tolerance: contact.burst(
                    SLIDER, orbit(A), duration=d, after=0.0, tolerance=t, samples=200, method=m
                ),
                20 if method == "averaged" else 1,
            )
            print(f"{A * 1e9:5.1f} nm {method:9} {duration} s at {tolerance:g}: {spent * 1e3:9.2f} ms "
                  f"{asked(spent * 1e3, limit, 'ms') if limit < math.inf else ''} "
                  f"estimated error {found.relative_error:.1e}, v {found.velocity_at_burst_end:.9g} m/s")  # fmt: skip


def steady_states():
    """Print steady states one at a time and a map of a thousand."""
    print("\nsteady states: averaged with second order, from scratch, against the periodic motion")
    for A in (0.75e-9, 1e-9, 3e-9, 5e-9, 10e-9, 20e-9):
        found, spent = timed(lambda A=A: contact.mean_motion(SLIDER, orbit(A)), 20)
        full = contact.steady(SLIDER, orbit(A), tolerance=1e-8)
        first, second = (over(v - full.velocity, v, A) for v in (found.first_order, found.velocity))
        print(
            f"{A * 1e9:7.2f} nm: {spent * 1e3:6.3f} ms {asked(spent * 1e3, 1.0, 'ms')}, error {second:.1e} "
            f"{asked(second, 2e-6, '')}, first order {first:.1e}, "
            f"estimate {found.relative_error:.1e}; periodic motion {full.seconds * 1e3:.2f} ms"
        )
    factors, preloads = np.linspace(0.5, 20.0, 40), np.geomspace(1e-4, 1e-2, 25)
    for workers in (1, 2):
        found, spent = timed(
            lambda w=workers: steady_map(SLIDER, orbit(1e-9), factors=factors, preloads=preloads, threads=w)
        )
        print(
            f"map of {found.velocity.size} steady states, {workers} threads: {spent:.3f} s {asked(spent, 0.5, 's')}, "
            f"{np.sum(found.regime == 'unknown')} unknown"
        )


def simulated():
    """Print the rate of full simulations, twelve runs in each of two threads."""
    from concurrent.futures import ThreadPoolExecutor

    from contact.stepping.time_stepping import steps

    print("\nfull simulation, 24 runs on two threads")
    number, compared = 5000, 2000
    amplitudes = np.linspace(3e-9, 20e-9, 24)
    begins = []
    for A in amplitudes:
        problem = rest_problem(SLIDER, (orbit(A),))
        begins.append((problem, rest(SLIDER, (orbit(A),), problem, nodes=12, truncation=1e-10)))
    states = np.array([motion.state for _, motion in begins])
    for _, motion in begins:
        motion.turn(compared)
    exact = np.array([motion.state[2] for _, motion in begins])
    floor = np.array([0.07 * A / problem.length for A, (problem, _) in zip(amplitudes, begins, strict=True)])
    for per_cycle in (16, 24, 32, 48):

        def half(first, cycles, moved, n=per_cycle):
            for (problem, _), state in zip(begins[first::2], moved[first::2], strict=True):
                steps(problem, state, cycles, n, stride=0)

        moved = states.copy()
        for first in (0, 1):
            half(first, compared, moved)
        worst = np.max(np.abs(moved[:, 2] - exact) / np.maximum(exact, floor))
        with ThreadPoolExecutor(2) as pool:
            _, spent = timed(
                lambda pool=pool, half=half: list(pool.map(lambda k: half(k, number, states.copy()), (0, 1))),
                clock=time.perf_counter,
            )
        rate = len(amplitudes) * number / spent
        verdict = asked(rate, 5e6, "cycles/s at 1e-3", True) if worst <= 1e-3 else "(not within 1e-3)"
        print(f"{per_cycle} steps per cycle: {rate / 1e6:.2f}e6 cycles/s, worst error {worst:.1e} {verdict}")


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
        "import sys, time; t = time.perf_counter(); import contact as c; from contact.jit import compiled as j; "
        # or kernels of this computer's other folders would be found
        "j.cache_folders; j.cache_folders = lambda: (sys.argv[1],); "
        f"s = c.Slider(**{seed_motor.SLIDER}); "
        "o = c.Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.5e-9j); CALL; print(time.perf_counter() - t)"
    )
    for name, call in (
        ("steady", "c.steady(s, o, tolerance=1e-3)"),
        ("averaged burst", "c.burst(s, o, duration=0.01, after=0.0, tolerance=1e-4, samples=2)"),
    ):
        with tempfile.TemporaryDirectory() as folder:
            for label in ("first", "cached"):
                done = subprocess.run(
                    [sys.executable, "-c", script.replace("CALL", call), folder],
                    capture_output=True,
                    text=True,
                    check=True,
                )
                spent = float(done.stdout)
                print(f"{name}, {label}: {spent:.2f} s {asked(spent, 10.0 if label == 'first' else 0.5, 's')}")


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
