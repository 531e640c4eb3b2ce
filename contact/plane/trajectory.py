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
    ledger: Ledger | None
    method: str
    statistics: dict
    seconds: float

    @property
    def velocity(self) -> np.ndarray:
        """(k, 2), m/s."""
        return self.rates[:, :2]

    @property
    def yaw(self) -> np.ndarray:
        """(k,), rad."""
        return self.pose[:, 2]
