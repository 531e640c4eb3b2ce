"""CPU time of the two event-driven solvers over the number of contacts: `contact.events.many_contacts.MANY`.

Run in a copy of the package for each `MANY`, with which the kernels are compiled:
python -m tests.benchmarks.many_contacts
"""

import time

import numpy as np

from contact import Slider, burst, steady
from contact.events.many_contacts import MANY
from tests.contact.motors import orbit
from tests.seed_motor import SLIDER

KINDS = {"balls": {}, "rough balls": {"scatter": 3e-9}, "punches": {"shape": "punch", "radius": 2e-6}}


def motor(kind: str, contacts: int, number: int):
    """Return (slider, orbits) of contacts under different parts of a wave."""
    rng, own = np.random.default_rng([contacts, number, 7]), dict(KINDS[kind])
    heights = tuple(rng.normal(scale=own.pop("scatter", 0.0), size=contacts))
    turns = (0.8 + 0.4 * rng.random(contacts)) * np.exp(2j * np.pi * rng.random(contacts))
    return Slider(**SLIDER | own | {"heights": heights}), tuple(orbit(10e-9).scaled(turn) for turn in turns)


def cpu_time(function) -> float:
    """Return the least CPU time of three calls, s; the first one may compile."""
    times = []
    for _ in range(4):
        start = time.process_time()
        function()
        times.append(time.process_time() - start)
    return min(times[1:])


if __name__ == "__main__":
    options = {"duration": 25e-6, "after": 0.0, "tolerance": 1e-6, "samples": 5, "method": "exact"}
    print(f"MANY = {MANY}: contacts, kind, ms of a steady state, ms of a burst of 55 cycles")
    for kind in KINDS:
        for contacts in (6, 8, 10, 12, 16, 24, 32, 48):
            motors = [motor(kind, contacts, number) for number in range(2)]
            state = sum(cpu_time(lambda m=m: steady(*m, tolerance=1e-6, method="exact")) for m in motors)
            run = sum(cpu_time(lambda m=m, options=options: burst(*m, **options)) for m in motors)
            print(f"{contacts:3d}  {kind:12s} {1e3 * state:8.1f} {1e3 * run:8.1f}", flush=True)
