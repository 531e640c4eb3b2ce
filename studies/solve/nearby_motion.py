"""Motion of the surface within a quarter of a wavelength on either side of a position, per volt.

The motion is interpolated in x through Chebyshev points, so that a contact can be solved at any place of this interval
without another evaluation of the stator's field. The interval ends where the slider would leave the stator, run onto
fingers or a meshed piece (or off them), or where the model does not resolve the field.
"""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from studies.solve import chebyshev

if TYPE_CHECKING:
    from studies.solve.surface_motion import SurfaceMotion

# Points of the interpolation. On the free surface of `twente`, `echoes` and `crossed` the motion between them agrees to
# 1e-9 of the largest with that of 17 points (tests/studies/test_ripple.py); beside fingers it is less smooth.
POINTS = 33
TRIED = 24  # places on either side of a position at which the end of the interval is looked for


@dataclass(frozen=True, kw_only=True, eq=False)
class NearbyMotion:
    """Motion of the surface about one position; displacements are along x from that position."""

    low: float  # smallest displacement, m
    high: float  # largest displacement, m
    tangential: np.ndarray  # u_x at the Chebyshev points of the interval, m per V, complex, shape (POINTS,)
    normal: np.ndarray  # u_z there
    error: np.ndarray  # of both, m per V, shape (POINTS,)

    def at(self, displacements) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return u_x and u_z in m per V and their relative error over the larger of both, at displacements in m."""
        inside = (2.0 * np.asarray(displacements) - self.low - self.high) / (self.high - self.low)
        matrix = chebyshev.interpolation(POINTS, inside)
        tangential, normal = matrix @ self.tangential, matrix @ self.normal
        error = np.interp(inside, chebyshev.points(POINTS), self.error)
        return tangential, normal, error / np.maximum(np.abs(tangential), np.abs(normal))


def nearby_motions(motion: "SurfaceMotion", positions) -> list[NearbyMotion | None]:
    """Return the motion about each of some positions (x, y) in m, all evaluated together; None at the stator's ends."""
    reach = 0.25 * abs(motion.wave.phase_velocity) / motion.wave.frequency
    found: list[NearbyMotion | None] = [None] * len(positions)
    spans = {k: _span(motion, position, reach) for k, position in enumerate(positions)}
    spans = {k: (low, high) for k, (low, high) in spans.items() if high > low}
    along = 0.5 * (1.0 + chebyshev.points(POINTS))
    ends = [(*positions[k], *span) for k, span in spans.items()]
    places = [(x + low * (1.0 - t) + high * t, y) for x, y, low, high in ends for t in along]
    if not places:
        return found
    tangential, _, normal = motion.at(places).reshape(3, len(spans), POINTS)
    sizes = np.maximum(np.abs(tangential), np.abs(normal))
    errors = sizes * np.reshape(motion.errors(places), sizes.shape)
    for own, (k, (low, high)) in enumerate(spans.items()):
        u_x, _, u_z = abs(motion.at([positions[k]])[:, 0])
        # The stator was solved for the motion at the position: in a minimum beside it, the error is no smaller
        error = np.maximum(errors[own], motion.errors([positions[k]])[0] * max(u_x, u_z))
        found[k] = NearbyMotion(low=low, high=high, tangential=tangential[own], normal=normal[own], error=error)
    return found


def _span(motion: "SurfaceMotion", position: tuple[float, float], reach: float) -> tuple[float, float]:
    """Return the ends in m, within -reach and +reach, of the interval about a position."""
    x, y = position
    covered, length = motion.covered(position), (motion.beam or motion.wave).length

    def alike(displacement: float) -> bool:
        place = (x + displacement, y)
        return 0.0 <= place[0] <= length and motion.covered(place) == covered and not motion.unresolved([place])

    ends = []
    for side in (-reach, reach):
        steps = side * np.arange(1, TRIED + 1) / TRIED
        outside = next((k for k, step in enumerate(steps) if not alike(step)), TRIED)
        ends.append(float(steps[outside - 1]) if outside else 0.0)
    return ends[0], ends[1]
