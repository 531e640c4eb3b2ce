"""``frequency = "center"``: the frequency at which a transducer of given period makes the largest wave.

The size is that of the surface mode under the slider (or mid-stator): the plate's other modes would put the
maximum on a ripple.  Sought within one relative bandwidth 1/N of v/period, first on a grid, then by Brent's
bounded search.
"""

from collections.abc import Callable

from studies import resolved
from studies.refusal import RunError
from studies.scene import Scene

__all__ = ["center_frequency"]

GRID = 9
ACCURACY = 1e-5  # of the frequency: the amplitude is flat there, to about (N * 1e-5)^2


def center_frequency(scene: Scene, place: float, *, progress: Callable[[str], None]) -> float:
    """Return the frequency in Hz of the largest surface amplitude at a place (m from the left end)."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    from fem.half_space import rayleigh
    from fem.harmonic import driven_wave

    solid = resolved.solid(scene.stator)
    block, transducers = resolved.stator(scene.stator), resolved.transducers(scene)
    driven = next(t for t in transducers if t.name == scene.drive.transducer)
    middle = rayleigh(solid, "open").velocity / driven.period

    def size(frequency: float) -> float:
        progress(f"stator: looking for the centre frequency, {frequency / 1e6:.5g} MHz")
        wave = driven_wave(
            block,
            transducers,
            frequency=float(frequency),
            driven=driven.name,
            source_impedance=scene.drive.source_impedance,
            tolerance=3e-2,
            places=(place,),
        )
        motion = wave.motion(place) if wave.covered(place) else wave.rayleigh_motion(place)
        return float(abs(motion[1]))

    reach = 1 / driven.finger_pairs if driven.finger_pairs > 1 else 0.5
    grid = middle * np.linspace(1 - reach, 1 + reach, GRID)
    sizes = [size(frequency) for frequency in grid]
    best = int(np.argmax(sizes))
    if best in (0, GRID - 1):
        ends = f"{grid[0] / 1e6:.5g} and {grid[-1] / 1e6:.5g} MHz"
        raise RunError(f"the amplitude has no maximum between {ends}: give drive.frequency a number")
    found = minimize_scalar(
        lambda frequency: -size(frequency),
        bounds=(grid[best - 1], grid[best + 1]),
        method="bounded",
        options={"xatol": ACCURACY * middle},
    )
    return float(found.x)
