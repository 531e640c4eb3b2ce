"""``frequency = "center"``: the frequency at which a transducer of given period makes the largest wave.

The size is that of the surface mode under the slider (or mid-stator): the plate's other modes would put the
maximum on a ripple.  Sought within one relative bandwidth 1/N of v/period: on a coarse grid for the lobe, on one that
resolves the ripple of waves sent back by ends and other transducers, then by Brent's bounded search.
"""

from collections.abc import Callable

from studies.chain.spectrum import response
from studies.refusal import RunError
from studies.scene import Scene, resolved

__all__ = ["center_frequency"]

COARSE = 17
LOBE = (
    0.6  # half of the range searched finely, in bandwidths 1/N: beyond it the lobe is below half its height
)
PER_RIPPLE = 4  # fine steps in one ripple v / (2 d) of waves that return from a distance d
ACCURACY = 1e-5  # of the frequency: the amplitude is flat there, to about (N * 1e-5)^2
TOLERANCE = 3e-2  # of the wave: an error common to neighbouring frequencies moves no maximum


def center_frequency(scene: Scene, place: float, *, progress: Callable[[str], None]) -> float:
    """Return the frequency in Hz of the largest surface amplitude at a place (m from the left end)."""
    import numpy as np
    from scipy.optimize import minimize_scalar

    from fem import rayleigh

    driven = next(each for each in scene.transducer if each.name == scene.drive.transducer)
    middle = rayleigh(resolved.solid(scene.stator), "open").velocity / driven.period
    reach = 1 / max(driven.finger_pairs, 2)
    grid = middle * np.linspace(1 - reach, 1 + reach, COARSE)
    prepared = response(scene, grid[0], grid[-1], places=(place,), tolerance=TOLERANCE, progress=progress)

    def sizes(frequencies) -> np.ndarray:
        inside = np.clip(frequencies, *prepared.limits)
        waves = prepared.waves(inside, resolved.drive(scene))
        at = (wave.motion if wave.covered(place) else wave.rayleigh_motion for wave in waves)
        return np.array([abs(motion(place)[1]) for motion in at])

    progress("stator: looking for the centre frequency")
    best = grid[int(np.argmax(sizes(grid)))]
    step = min(grid[1] - grid[0], middle * driven.period / (2 * PER_RIPPLE * _detour(scene)))
    count = int(np.ceil(LOBE * reach * middle / step))
    fine = np.clip(best + step * np.arange(-count, count + 1), *prepared.limits)
    at = int(np.argmax(sizes(fine)))
    if fine[at] in prepared.limits:
        ends = " and ".join(f"{limit / 1e6:.5g}" for limit in prepared.limits)
        raise RunError(f"the amplitude has no maximum between {ends} MHz: give drive.frequency a number")
    found = minimize_scalar(
        lambda frequency: -float(sizes([frequency])[0]),
        bounds=(fine[at - 1], fine[at + 1]),
        method="bounded",
        options={"xatol": ACCURACY * middle},
    )
    return float(found.x)


def _detour(scene: Scene) -> float:
    """Return the largest distance in m over which waves are sent to and fro; a period where none are."""
    centres = [each.center for each in scene.transducer]
    between = scene.stator.length if scene.stator.ends != "absorbing" else max(centres) - min(centres)
    return max(between, min(each.period for each in scene.transducer))
