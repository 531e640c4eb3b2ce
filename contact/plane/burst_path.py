"""Motion of a slider in the plane during and after a burst: what `contact.plane.burst` answers."""

from dataclasses import dataclass

import numpy as np

from contact.answers.ledger import Ledger
from contact.choice import Answer, HasAnswer


@dataclass(frozen=True, kw_only=True)
class PlaneTrajectory(HasAnswer):
    """Motion of a slider in the plane through a burst.

    Attributes
    ----------
    answer : Answer
        Speed |V| at the end of the burst in m/s (of an axle that of the farthest contact), its error, status, reasons.
    time : (k,) array
        Instants, s.
    pose, rates : (k, 3) array
        (x, y, yaw) of the slider's centre, or of its axle, from the start in m and rad, and their rates.
    height : (k,) array
        Position z_s of the slider, m; minus the approach of a contact of height 0 without a wave.
    error : (3,) array
        Largest error of the rates over the whole way, m/s and rad/s.
    pose_error : (3,) array
        The same of the pose, m and rad; of a slider that friction has stopped with what its contacts' springs move it.
    duration : float
        Of the burst, s.
    stopped : float
        Time at which friction has stopped the slider, s; inf where it was not followed so far.
    reference : float
        Speed to which the relative error refers: max(|V|, omega |u_t|/10), m/s.
    ledger : Ledger or None
        Energies over the whole way, J, of a motion that is followed within the cycles; torque and yaw are included.
    method : str
        "exact", "stepped" or "averaged".
    statistics : dict
        Segments and their trials, or steps, or evaluations.
    seconds : float
        Computing time.
    """

    answer: Answer
    time: np.ndarray
    pose: np.ndarray
    rates: np.ndarray
    height: np.ndarray
    error: np.ndarray
    pose_error: np.ndarray
    duration: float
    stopped: float
    reference: float
    ledger: Ledger | None
    method: str
    statistics: dict
    seconds: float

    @property
    def relative_error(self) -> float:
        """Error of the speed at the end of the burst over `reference`."""
        return self.answer.error / self.reference if self.reference > 0.0 else 0.0

    @property
    def burst_end(self) -> int:
        """Index of the instant at which the burst ends."""
        return min(int(np.searchsorted(self.time, self.duration * (1.0 - 1e-12))), len(self.time) - 1)

    @property
    def velocity(self) -> np.ndarray:
        """(k, 2), m/s."""
        return self.rates[:, :2]

    @property
    def yaw(self) -> np.ndarray:
        """(k,), rad."""
        return self.pose[:, 2]
