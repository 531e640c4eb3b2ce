"""Compilation at first use by two processes: this one and another.

Kernels are compiled when they are first called. A run needs large ones after each other: the averaged steady states
with the forces of each contact, and the motion from event to event. The other process begins with the averages while
this one solves its stator. Then this one finds their kernel being compiled (`contact.jit.compiled`) and compiles the
kernel of the events while it waits for the file. Whichever is first to wait does so.
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
    """Compile the kernels of the elastic law in another process and in this one, if no kernels lie there.

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
            [sys.executable, "-P", "-m", __name__], env=os.environ | {"PYTHONPATH": paths}, stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        compiled.MEANWHILE.append(compile_events)
    try:
        yield
    finally:
        compiled.MEANWHILE.clear()
        if process is not None:
            process.kill()
            process.wait()


def _any_motion():
    """Return a slider of the elastic law and a wave under it."""
    slider = Slider(
        radius=1e-3, mass=1e-4, preload=1e-3, load=0.0, friction_coefficient=0.1, effective_modulus=64e9,
        tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=0.5, tangential_damping=1e-4,
    )  # fmt: skip
    return slider, Orbit(frequency=1e6, normal=1e-9, tangential=-1e-9j)


def compile_averages():
    """Compile the kernels of averaged steady states and of the forces of their contacts."""
    # where kernels are compiled already, a run does not wait for these imports
    from contact.averaged.steady_sweep import mean_forces, mean_motion

    slider, wave = _any_motion()
    mean_forces(slider, wave, mean_motion(slider, wave))


def compile_events():
    """Compile the event-driven kernel, by one cycle.

    No other thread is started: this one may hold the lock of the kernels (`contact.jit.compiled`).
    """
    # likewise, and where another process compiles the events
    from contact.events.collocation import collocation
    from contact.events.motion import Motion
    from contact.problem import scaled

    problem = scaled(*_any_motion(), direction=1.0, start=0.0)
    Motion(problem, grid=collocation(8), truncation=1e-6).turn(1)


def main() -> None:
    """Compile all of them: the averages, and the events when there is nothing else to do."""
    compiled.MEANWHILE.append(compile_events)
    compile_averages()
    compile_events()


if __name__ == "__main__":
    main()
