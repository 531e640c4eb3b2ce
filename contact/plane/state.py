"""A steady motion in the plane: what `contact.plane.steady` answers."""

from dataclasses import dataclass

import numpy as np

from contact.choice import Answer, HasAnswer


@dataclass(frozen=True, kw_only=True)
class Powers:
    """Mean powers in W; `wave` is the sum of the others but for the error of the computation.

    Attributes
    ----------
    wave : float
        From the surface through the tangential forces and, where the slider moves within a cycle, the normal ones.
    slip, dampers : float
        Lost by slip, and in the dampers of slider and contacts.
    load : float
        Given to load and torque, F.V + M omega.
    law : float
        Lost by the elastic law, which has no potential (Feenstra and Breedveld, eq. 2); zero for punches.
    """

    wave: float
    slip: float
    dampers: float
    load: float
    law: float

    @property
    def residual(self) -> float:
        """Power of the wave less the others, W."""
        return self.wave - self.slip - self.dampers - self.load - self.law


@dataclass(frozen=True, kw_only=True)
class Band:
    """Tangential forces that a slider at rest can carry along one direction, N.

    Attributes
    ----------
    direction : (2,) array
        Unit vector.
    least, largest : float
        Both ends, of the contacts' force on the slider.
    """

    direction: np.ndarray
    least: float
    largest: float


@dataclass(frozen=True, kw_only=True)
class PlaneState(HasAnswer):
    """Steady motion of a slider in the plane.

    Attributes
    ----------
    answer : Answer
        Speed |V| in m/s (of an axle: arm times yaw rate, the largest speed of a contact), its error, status, reasons.
    velocity : (2,) array
        Mean velocity of the slider's centre, m/s; exactly 0 where held.
    yaw_rate : float
        rad/s, positive from x to y.
    error : (2,) array
        Of the velocity, m/s.
    yaw_error : float
        Of the yaw rate, rad/s.
    force : (2,) array
        Mean tangential force of the contacts on the slider, N.
    torque : float
        Its mean moment about the centre or the axle, N m.
    powers : Powers
    regimes : tuple of str
        "stick", "slip", "intermittent" or "open" of each contact.
    normal_loads, heights : (n,) array
        Mean normal force in N and mean approach in m of each contact.
    held : bool
        True if friction holds the slider.
    band : Band or None
        Where held: the forces that it can carry along the load, or along x without one.
    reference : float
        Speed to which the relative error refers: max(|V|, omega |u_t|/10), m/s.
    method : str
        "averaged" or "exact".
    statistics : dict
        Evaluations, contacts made and slips begun in a period, cycles of the period.
    seconds : float
        Computing time.
    """

    answer: Answer
    velocity: np.ndarray
    yaw_rate: float
    error: np.ndarray
    yaw_error: float
    force: np.ndarray
    torque: float
    powers: Powers
    regimes: tuple[str, ...]
    normal_loads: np.ndarray
    heights: np.ndarray
    held: bool
    band: Band | None
    reference: float
    method: str
    statistics: dict
    seconds: float

    @property
    def relative_error(self) -> float:
        """Error of the speed over `reference`."""
        return self.answer.error / self.reference if self.reference > 0.0 else 0.0

    @property
    def speed(self) -> float:
        """|V|, m/s."""
        return float(np.hypot(*self.velocity))

    @property
    def power(self) -> float:
        """Mean power from the wave, W."""
        return self.powers.wave

    @property
    def slip_power(self) -> float:
        """Mean power lost by slip, W."""
        return self.powers.slip
