"""What others' methods find on the seed's contact, and at what cost: prints a table.

    python -m tests.benchmarks.contact_peers

The seed's slider from rest through 200 cycles; error of the velocity at the end against the event-exact method at its
finest, over CPU time of one thread, all compiled beforehand.  Peers: ``scipy.integrate.solve_ivp`` (RK45, DOP853,
LSODA, Radau) and SUNDIALS CVODE (Adams, BDF; left out where scikit-sundae is not installed) with events or root
functions and compiled right-hand sides, free in their steps and held to a twentieth of a cycle; the paper's algorithm
in fixed steps with DV of 1 mm/s.  About 2 minutes of one processor.
"""

import math
import time

from studies.papers.seed import Seed
from tests.validation import contact_peers as peers

AMPLITUDES = (5e-9, 10e-9)  # m
CYCLES = 200
EXACT = ((8, 1e-5), (10, 1e-7), (12, 1e-9), (14, 1e-11))  # nodes, truncation
FINEST = (20, 1e-13)
STEPS = (24, 32, 48, 64, 96, 128, 192, 256)
AVERAGED = (1e-3, 1e-4, 1e-5, 1e-6)
NAIVE, BAND = (50, 200, 1000, 5000), 1e-3  # steps per cycle; DV in m/s
TOLERANCES = (1e-6, 1e-9, 1e-12)
HELD = math.pi / 10.0  # phase: a twentieth of a cycle
SCIPY, CVODE = ("RK45", "DOP853", "LSODA", "Radau"), ("Adams", "BDF")
LIMIT = 15.0  # s for one run of a peer
OURS = ("exact", "stepped", "averaged")  # which state their error
WRONG = 1e-3  # an error above it, without a complaint, is a silent failure


def rows_of(
    amplitude: float, *, cycles: int = CYCLES, chosen: tuple = (*SCIPY, *CVODE), tolerances: tuple = TOLERANCES
) -> list[dict]:
    """Return one row per run: curve, setting, seconds, error over v, complaint, and whether it is silently wrong."""
    import contact
    from contact.answers.rest_motion import rest, rest_problem
    from contact.stepping.time_stepping import steps

    seed = Seed()
    slider, orbits = seed.slider, seed.orbits(amplitude)
    problem = rest_problem(slider, orbits)

    def exact(nodes, truncation):
        motion = rest(slider, orbits, problem, nodes=nodes, truncation=truncation)
        motion.turn(cycles)
        return float(motion.state[2])

    def stepped(per_cycle, cycles=cycles):
        state = begin.copy()
        steps(problem, state, cycles, per_cycle)
        return float(state[2])

    def averaged(tolerance):
        found = contact.burst(
            slider, orbits, duration=cycles / orbits[0].frequency, after=0.0, tolerance=tolerance, samples=2,
            method="averaged",
        )  # fmt: skip
        return found.velocity_at_burst_end / problem.speed

    def fixed(per_cycle, cycles=cycles):
        numbers, wave = peers.numbers(problem), peers.first_wave(problem)
        return peers.naive(numbers, wave, begin, cycles, per_cycle, BAND / problem.speed)

    begin = rest(slider, orbits, problem, nodes=16, truncation=1e-12).state.copy()
    truth = exact(*FINEST)
    for warm in (lambda: stepped(16, 1), lambda: averaged(1e-4), lambda: averaged(1e-6), lambda: fixed(50, 1)):
        warm()
    rows = []

    def add(curve, setting, work, repeats=3):
        seconds, complaint = math.inf, ""
        for _ in range(repeats):
            at = time.process_time()
            answer = work()
            seconds = min(seconds, time.process_time() - at)
        if isinstance(answer, tuple):
            answer, complaint = answer[0], answer[2]
        error = abs(answer / truth - 1.0)
        rows.append({
            "curve": curve, "setting": setting, "seconds": seconds, "error": error, "complaint": complaint,
            "silent": bool(not complaint and not error < WRONG and curve not in OURS),
        })  # fmt: skip

    for nodes, truncation in EXACT:
        add("exact", f"{nodes} nodes, {truncation:g}", lambda n=nodes, t=truncation: exact(n, t))
    for per_cycle in STEPS:
        add("stepped", f"{per_cycle} steps", lambda n=per_cycle: stepped(n))
    for tolerance in AVERAGED:
        add("averaged", f"{tolerance:g}", lambda t=tolerance: averaged(t))
    for per_cycle in NAIVE:
        add("fixed steps with DV", f"{per_cycle} steps", lambda n=per_cycle: fixed(n))
    held = (("", math.inf, 0.0), (", held steps", HELD, HELD))
    for label, step, for_cvode in held:
        families = [("solve_ivp", m, peers.scipy_solver, step) for m in SCIPY if m in chosen]
        families += [("CVODE", m, peers.cvode, for_cvode) for m in CVODE if m in chosen]
        for family, method, make, max_step in families:
            for rtol in tolerances[:1] if method == "Radau" else tolerances:
                segment = make(method, rtol=rtol, max_step=max_step)
                if segment is None:  # scikit-sundae is not installed
                    break
                add(
                    f"{family} {method}{label}", f"rtol {rtol:g}",
                    lambda s=segment: peers.with_events(problem, begin, cycles, s, limit=LIMIT), repeats=1,
                )  # fmt: skip
    return rows


def quickest(rows: list[dict], error: float, *, ours: bool) -> float:
    """Return the least time in s of our methods, or of the others, that reach an error; inf if none does."""
    kept = [row for row in rows if (row["curve"] in OURS) is ours and not row["complaint"]]
    return min((row["seconds"] for row in kept if row["error"] <= error), default=math.inf)


def main() -> None:
    """Print a row for each run, and what the quickest other method costs at equal error."""
    for amplitude in AMPLITUDES:
        rows = rows_of(amplitude)
        print(f"\n{amplitude * 1e9:g} nm\n\n| method | setting | ms | error | |\n|---|---|---|---|---|")
        for row in rows:
            remark = row["complaint"] or ("wrong without a word" if row["silent"] else "")
            print(f"| {row['curve']} | {row['setting']} | {1e3 * row['seconds']:.3g} | {row['error']:.1e} | {remark} |")
        for error in (1e-5, 1e-8):
            own, peer = (quickest(rows, error, ours=each) for each in (True, False))
            print(f"equal error {error:g}: {1e3 * own:.2g} ms against {1e3 * peer:.3g} ms")


if __name__ == "__main__":
    main()
