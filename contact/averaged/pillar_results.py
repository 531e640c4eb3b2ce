"""Results for a slider on pillars: its steady motion, and its load line.

Symbols as in `pillars` and `march`: a *row* is the set of all pillars at one x, where the wave changes its amplitude by
the forces of these pillars; U+ and U- are the amplitudes of the waves towards +x and -x, A the amplitude of the larger
incident one, Gamma the surface's compliance for a line force, w the width of the strip in which the wave runs, F the
preload, v the slider velocity and omega the angular frequency of the wave.
"""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from contact.averaged.overtone_cycle import OvertoneCycle
from contact.averaged.pillars import PassingWave, Pillars
from contact.error_estimate import speed_scale


class SearchState(NamedTuple):
    """Start values for the search of a similar motion."""

    unknowns: np.ndarray  # `Equilibrium.unknowns`: mean approach, pitch, roll and speed over their scales
    forward: np.ndarray  # amplitudes U+ and U- at the rows, m
    backward: np.ndarray
    approaches: np.ndarray  # mean approaches of the pillars, m
    velocity_over_omega: float  # v/omega, m
    side: float  # sign of v; for v = 0 that of the motion before it came to rest


@dataclass(frozen=True, kw_only=True)
class PillarMotion:
    """Steady motion of a slider on pillars or balls, averaged over the wave's cycle.

    Attributes
    ----------
    velocity : float
        Velocity along +x, m/s.
    held : bool
        True if v = 0: the contacts that stick carry the load.
    approach : float
        Mean approach H of a pillar of height 0 at the slider's centre, m. With a soft backing it is the mean over the
        rows.
    tilt : tuple of float
        Rotations in rad: increase of the approach along x (pitch) and along y (roll).
    load : float
        External force on the slider, N, with the sign of the motion that it opposes.
    traction : float
        Mean tangential force of all pillars, N.
    row_x : ndarray, shape (m,)
        Positions of the rows, m.
    forward, backward : ndarray, shape (m,), complex
        Wave amplitudes in m without the factors exp(-i k x) and exp(+i k x): U+ on the side of each row at larger x,
        U- on the side at smaller x.
    exit_over_entry, reflected_over_entry : complex
        Transmission and reflection of the larger incident wave, over its incident amplitude. The other incident wave is
        subtracted from the reflected wave.
    share_in_contact, duty : float
        Fraction of the pillars that touch at some time of the cycle, and the mean fraction of the cycle during which
        these pillars touch.
    friction_power, thrust_power, damping_power : float
        Mean power of the friction, of the load and of the viscous damper, W. The elastic law's spring of a ball is not
        conservative; its loss or gain counts as friction.
    wave_power_in, wave_power_out : float
        Power of both waves within the strip, W; 0 if Gamma is not known.
    loading_number : float
        Lambda = 2 Gamma F/(w A), about the phase in rad by which a bouncing slider advances the wave.
    loading : bool
        True if the pillars act back on the wave.
    harmonics : int
        Number of harmonics of the wave in the computation; 1 is the fundamental alone.
    overtones : ndarray, shape (m, harmonics - 1), complex
        Amplitudes U_2, U_3 ... of the larger incident wave after it has passed each row, m, in the order of `row_x`.
    wave_work, apparent_power : float
        Power that the surface transfers to the pillars by the harmonics of their forces, W, and its apparent power, VA.
    normal_force, friction : ndarray, shape (n,)
        Mean normal force in N and mean friction power in W of each pillar.
    first_normal, first_tangential : ndarray, shape (n,), complex
        First harmonics P_1 and Q_1 of the force of each pillar on the slider, N.
    relative_error : float
        Numerical error of the velocity over max(|v|, omega |u_x|/10).
    truncation : float
        Part of `relative_error` that is due to the number of harmonics. It is a third of the change by the last
        doubling, because this error is inversely proportional to the square of the number.
    sweeps : int
        How often a cycle of all pillars was computed in the search.
    """

    pillars: Pillars = field(repr=False)
    wave: PassingWave = field(repr=False)
    velocity: float
    held: bool
    approach: float
    tilt: tuple[float, float]
    load: float
    traction: float
    row_x: np.ndarray = field(repr=False)
    forward: np.ndarray = field(repr=False)
    backward: np.ndarray = field(repr=False)
    exit_over_entry: complex
    reflected_over_entry: complex
    share_in_contact: float
    duty: float
    friction_power: float
    thrust_power: float
    damping_power: float
    wave_power_in: float
    wave_power_out: float
    loading_number: float
    loading: bool
    harmonics: int
    overtones: np.ndarray = field(repr=False)
    wave_work: float
    apparent_power: float
    normal_force: np.ndarray = field(repr=False)
    friction: np.ndarray = field(repr=False)
    first_normal: np.ndarray = field(repr=False)
    first_tangential: np.ndarray = field(repr=False)
    relative_error: float
    truncation: float
    sweeps: int
    state: SearchState = field(repr=False)

    @property
    def ledger_residual(self) -> float:
        """Residual of the energy balance: power taken from the wave less friction, load and damper powers.

        It is relative to the incident power. Without loading, the work of the surface on the pillars replaces the power
        taken from the wave, and the residual is relative to the apparent power.
        """
        spent = self.friction_power + self.thrust_power + self.damping_power
        if self.loading:
            return float((self.wave_power_in - self.wave_power_out - spent) / self.wave_power_in)
        return float((self.wave_work - spent) / max(self.apparent_power, 1e-300))

    @property
    def speed_scale(self) -> float:
        """Reference speed of velocity errors, max(|v|, omega |u_x|/10), m/s."""
        wave = self.wave
        return max(speed_scale(self.velocity, wave.omega * abs(wave.orbit) * wave.amplitude), 1e-300)

    @property
    def exit_overtones(self) -> np.ndarray:
        """U_2, U_3 ... of the larger incident wave where it leaves the slider, m, shape (harmonics - 1,)."""
        return self.overtones[-1 if abs(self.wave.forward) >= abs(self.wave.backward) else 0]

    @property
    def overtone(self) -> float:
        """|U_2| at the exit over the incident |U_1|; 0 for balls, for which it is not computed.

        If the motion was computed without overtones, |U_2| is the amplitude that its contacts would radiate.
        """
        wave = self.wave
        if wave.compliance == 0.0 or wave.amplitude == 0.0 or self.pillars.shape != "punch":
            return 0.0
        if self.harmonics > 1:
            second = self.exit_overtones[0]
        else:
            cycle, state = OvertoneCycle(self.pillars, wave, False, 2), self.state
            cycle.begin(state.forward, state.backward)
            second = cycle.radiated(wave.compliance_per_width, state.approaches, state.velocity_over_omega, state.side)
        return float(abs(second)) / wave.amplitude


@dataclass(frozen=True, kw_only=True)
class PillarLoadLine:
    """Steady motions under loads from zero to the stall.

    Attributes
    ----------
    motions : tuple of PillarMotion
        Motions in the order of the loads. The slider is held in the last one, at the stall.
    stall : float
        Largest load under which the slider moves forward, N: the mean tangential force in the limit v -> 0 of a forward
        motion.
    held_up_to : float
        Largest load under which the slider stays at rest, N. A larger load drags it backwards. The slider is held under
        loads between `stall` and `held_up_to`.
    """

    motions: tuple[PillarMotion, ...]
    stall: float
    held_up_to: float

    @property
    def load(self) -> np.ndarray:
        """Loads in N."""
        return np.array([abs(each.load) for each in self.motions])

    @property
    def velocity(self) -> np.ndarray:
        """Velocities in m/s, along +x."""
        return np.array([each.velocity for each in self.motions])

    @property
    def power(self) -> np.ndarray:
        """Mechanical powers (load times speed) in W."""
        return np.array([each.thrust_power for each in self.motions])

    @property
    def efficiency(self) -> np.ndarray:
        """Mechanical power over the power that the wave gives to the pillars."""
        taken = [each.thrust_power + each.friction_power + each.damping_power for each in self.motions]
        return np.divide(self.power, taken, out=np.zeros(len(taken)), where=np.array(taken) > 0.0)

    @property
    def relative_error(self) -> np.ndarray:
        """Numerical errors of the velocities."""
        return np.array([each.relative_error for each in self.motions])

    @property
    def status(self) -> str:
        """Always "ok", because a motion that cannot be computed raises an error."""
        return "ok"

    @property
    def message(self) -> str:
        """How the velocities were computed, as in `LoadLine.message`."""
        return "averaged equilibria of the pillars"

    @property
    def blocked_thrust(self) -> float:
        """The stall in N, under the name that `LoadLine` uses."""
        return self.stall
