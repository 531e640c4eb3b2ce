"""Compilation at first use by two processes: this one and another, which compiles the event-driven kernel.

Kernels are compiled when they are first called. A run needs two large ones after each other: the averaged steady states
and the motion from event to event. Of a kernel that another process compiles, this one waits for the file
(`contact.jit.compiled`).
"""

import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager

from contact.jit import compiled, kernels
from contact.orbit import Orbit
from contact.slider import Slider


@contextmanager
def compiled_aside() -> Iterator[None]:
    """Compile the event-driven kernel of the elastic law in another process meanwhile, if no kernels lie there.

    The other process ends with the block. Nothing is compiled where the kernels cannot be kept, or with one processor.

    Examples
    --------
    >>> with compiled_aside():
    ...     pass
    """
    process = None
    if not kernels.ready() and compiled.cache_folder() is not None and (os.cpu_count() or 1) > 1 and sys.executable:
        paths = os.pathsep.join(path for path in (os.getcwd() if each == "" else each for each in sys.path))
        process = subprocess.Popen(
            [sys.executable, "-m", __name__], env=os.environ | {"PYTHONPATH": paths}, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
    try:
        yield
    finally:
        if process is not None:
            process.kill()
            process.wait()


def main() -> None:
    """Compile the event-driven kernel of the elastic law, by a burst of one cycle of any slider."""
    # only the other process needs it: the run's own process does not wait for its import
    from contact.answers.burst_motion import burst

    slider = Slider(
        radius=1e-3, mass=1e-4, preload=1e-3, load=0.0, friction_coefficient=0.1, effective_modulus=64e9,
        tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=0.5, tangential_damping=1e-4,
    )  # fmt: skip
    wave = Orbit(frequency=1e6, normal=1e-9, tangential=-1e-9j)
    burst(slider, wave, duration=1e-6, after=0.0, tolerance=1e-3, samples=2, method="exact")


if __name__ == "__main__":
    main()
