"""Averaged motion of a slider on the rows of its contacts: moving, held, at the stall.

Rows are the contacts at one x, where the wave changes its amplitude by their forces (`row_cycle`, `march`). Unknown
are the coordinates of the body, and of the wave if it is loaded (`coupled_equilibrium`); the velocity is searched by
`equilibrium.balanced_speed`, as that of every slider, or together with the wave.
"""

import math
from contextlib import suppress
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from contact import parameter_check
from contact.averaged.coupled_equilibrium import CLOSE, SPEED, Balance, Equilibrium
from contact.averaged.cycle_mean import ContactMean, MeanForces
from contact.averaged.equilibrium import balanced_speed, net_force
from contact.averaged.overtone_cycle import OvertoneCycle
from contact.averaged.row_cycle import RowCycle
from contact.codes import Status
from contact.error_estimate import richardson, speed_scale
from contact.exceptions import ConvergenceError, InputError
from contact.passing_wave import HARMONICS, PassingWave, crest_direction
from contact.slider import Slider

FULL_SLIP = 1.001  # safety factor on the velocity above which every contact slips through the whole cycle
# Numbers of harmonics to try, until the error of the velocity by those left out is below OVERTONE_ERROR. It falls with
# the square of the number.
NUMBERS = (8, 16, 32, 64)
OVERTONE_ERROR = 5e-4  # half of the default tolerance
# Tolerance of an equilibrium that only tells whether or which way the slider moves, and the velocity or the force,
# scaled, from which on it tells: 50 times the tolerance.
ROUGH, CLEAR = 1e-3, 0.05
HOPS = 0.999  # mean fraction of the cycle in contact below which the motion counts as intermittent


class SearchState(NamedTuple):
    """Start values for the search of a similar motion."""

    unknowns: np.ndarray  # `Equilibrium.unknowns`: mean approach, pitch, roll and speed over their scales
    forward: np.ndarray  # amplitudes U+ and U- at the rows, m
    backward: np.ndarray
    approaches: np.ndarray  # mean approaches of the contacts, m
    velocity_over_omega: float  # v/omega, m
    side: float  # sign of v; for v = 0 that of the motion before it came to rest


@dataclass(frozen=True, kw_only=True)
class WaveRows:
    """The wave below a slider, row by row, and the mean forces of the contacts there.

    Symbols as in `march`: U+ and U- are the amplitudes of the waves towards +x and -x, A the amplitude of the larger
    incident one, Gamma the surface's compliance for a line force, w the width of the strip in which the wave runs and
    F the preload.

    Attributes
    ----------
    slider, wave
        The slider and the wave as it would be without it.
    loading : bool
        True if the contacts act back on the wave.
    load : float
        External force on the slider, N, with the sign of the motion that it opposes.
    traction : float
        Mean tangential force of all contacts, N.
    row_x : ndarray, shape (m,)
        Positions of the rows, m.
    forward, backward : ndarray, shape (m,), complex
        Wave amplitudes in m without the factors exp(-i k x) and exp(+i k x): U+ on the side of each row at larger x,
        U- on the side at smaller x.
    exit_over_entry, reflected_over_entry : complex
        Transmission and reflection of the larger incident wave, over its incident amplitude. The other incident wave is
        subtracted from the reflected wave.
    share_in_contact, duty : float
        Fraction of the contacts that touch at some time of the cycle, and the mean fraction of the cycle during which
        these contacts touch.
    friction_power, thrust_power, damping_power : float
        Mean power of the friction in slip, of the load and of the viscous damper, W.
    leak_power : float
        Mean power lost in the elastic law's spring of a ball, which is not conservative, W; negative for a gain.
    wave_power_in, wave_power_out : float
        Power of both waves within the strip, W; 0 if Gamma is not known.
    loading_number : float
        Lambda = 2 Gamma F/(w A), about the phase in rad by which a bouncing slider advances the wave.
    harmonics : int
        Number of harmonics of the wave in the computation; 1 is the fundamental alone.
    overtones : ndarray, shape (m, harmonics - 1), complex
        Amplitudes U_2, U_3 ... of the larger incident wave after it has passed each row, m, in the order of `row_x`.
    truncation : float
        Part of the velocity's relative error that is due to the number of harmonics. It is a third of the change by the
        last doubling, because this error is inversely proportional to the square of the number.
    work : tuple of float
        Mean powers that the surface transfers to the contacts through P and through Q, W.
    apparent_power : float
        Apparent power of both, VA.
    deepest : ndarray, shape (n,)
        Approach of each contact on the highest crest of the fundamental, m; negative where it does not touch.
    forces : MeanForces
        Mean forces and first harmonics of each contact, N.
    friction : ndarray, shape (n,)
        Mean friction power of each contact, W.
    sweeps : int
        How often a cycle of all contacts was computed in the search.
    """

    slider: Slider = field(repr=False)
    wave: PassingWave = field(repr=False)
    loading: bool
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
    leak_power: float
    wave_power_in: float
    wave_power_out: float
    loading_number: float
    harmonics: int
    overtones: np.ndarray = field(repr=False)
    truncation: float
    work: tuple[float, float]
    apparent_power: float
    deepest: np.ndarray = field(repr=False)
    forces: MeanForces = field(repr=False)
    friction: np.ndarray = field(repr=False)
    sweeps: int
    state: SearchState = field(repr=False)

    @property
    def ledger_residual(self) -> float:
        """Residual of the energy balance: power taken from the wave less friction, load, damper and leak powers.

        It is relative to the incident power. Without loading, the work of the surface on the contacts replaces the
        power taken from the wave, and the residual is relative to the apparent power.
        """
        spent = self.friction_power + self.thrust_power + self.damping_power + self.leak_power
        if self.loading:
            return float((self.wave_power_in - self.wave_power_out - spent) / self.wave_power_in)
        return float((sum(self.work) - spent) / max(self.apparent_power, 1e-300))

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
        if wave.compliance == 0.0 or wave.amplitude == 0.0 or self.slider.shape != "punch":
            return 0.0
        if self.harmonics > 1:
            second = self.exit_overtones[0]
        else:
            cycle, state = OvertoneCycle(self.slider, wave, False, 2), self.state
            cycle.begin(state.forward, state.backward)
            second = cycle.radiated(wave.compliance_per_width, state.approaches, state.velocity_over_omega, state.side)
        return float(abs(second)) / wave.amplitude


class Coupled(NamedTuple):
    """Averaged motion of a slider on a passing wave."""

    velocity: float  # m/s along +x
    height: float  # mean approach of a contact of height 0 at the slider's centre, m; soft backing: mean over the rows
    tilt: tuple[float, float]  # pitch and roll, rad; positive if the approach increases towards +x and +y
    relative_error: float  # of the velocity over max(|v|, omega |u_x|/10)
    regime: str
    rows: WaveRows


class CoupledSearch:
    """Solver for the equilibria of one slider on one wave; w = v/omega is the velocity in m.

    Each search starts from the last equilibrium. ``harmonics`` counts the driven wave as the first, so that 1 leaves
    out all overtones. ``near``: rows of a motion of the same contacts, from which the first search starts.
    """

    def __init__(self, slider: Slider, wave, harmonics: int = 1, near: WaveRows | None = None):
        slider.refuse_other_laws(", on a wave that it loads or with a tilt or a soft backing")
        for name, unit in (("preload", "N"), ("friction_coefficient", "")):
            parameter_check.positive(f"slider.{name}", getattr(slider, name), unit)
        self.slider, self.wave, self.loads = slider, wave, wave.loaded_by(slider.preload)
        if self.loads and harmonics > 1 and slider.normal_law is not None:
            raise InputError("slider.normal_law", 'must be absent with loading "harmonics", which takes flat pillars')
        if self.loads and harmonics > 1:
            self.cycle: RowCycle = OvertoneCycle(slider, wave, True, harmonics)
        else:
            self.cycle = RowCycle(slider, wave, self.loads)
        self.equilibrium, self.truncation = Equilibrium(self.cycle), 0.0
        self.moves, self.factor = False, 1.0  # whether the last equilibrium moves; factor on the wave
        if near is not None:
            self.begin_at(near)

    def begin_at(self, near: WaveRows) -> None:
        """Start the next search from a motion of the same contacts."""
        state = near.state
        if self.loads and len(state.forward) == len(self.cycle.forward):
            self.equilibrium.unknowns = state.unknowns.copy()
            if near.loading:
                size = self.wave.amplitude / near.wave.amplitude
                self.cycle.begin(state.forward * size, state.backward * size)
        self.moves, self.truncation = state.velocity_over_omega != 0.0, near.truncation

    def rest(self, side: float, load: float = 0.0, close: float = CLOSE) -> Balance:
        """Return the equilibrium in the limit v -> 0 of motions of sign `side`."""
        return self.equilibrium.solve(load, 0.0, side, close)

    def under(self, load: float, close: float = CLOSE) -> Balance:
        """Return the equilibrium under a signed load; the slider moves or is held."""
        if not self.loads:
            return self._bracketed(load)
        start, waves = self.equilibrium.unknowns.copy(), (self.cycle.forward, self.cycle.backward)
        if not self.moves:
            # one contact at rest takes 8 evaluations; a search for the velocity of a held slider gives up after 200
            with suppress(ConvergenceError):
                held = self._held(load)
                if held is not None:
                    return held
            self.equilibrium.unknowns = start.copy()
            self.cycle.begin(*waves)
        try:
            equilibrium = self.equilibrium.solve(load, close=close)
            self.moves = self._is_moving(equilibrium)
            if self.moves:
                return equilibrium
        except ConvergenceError:
            pass
        self.equilibrium.unknowns = start
        self.cycle.reset()
        return self._bracketed(load)

    def _held(self, load) -> Balance | None:
        """Return the equilibrium of a slider that is held under a load; None if it moves."""
        margin = CLEAR * self.equilibrium.friction
        for close, beside in ((ROUGH, margin), (CLOSE, 0.0)):
            low, high, held = self._at_rest(load, close)
            if not low.traction - beside <= load <= high.traction + beside:
                return None
        return replace(held, traction=load)

    def _is_moving(self, equilibrium):
        """Return True if the velocity exceeds rounding; a smaller one may belong to sticking contacts."""
        return abs(equilibrium.w) > 1e-9 * self.equilibrium.speed

    def _bracketed(self, load):
        """Return the equilibrium by a bracketing search for the velocity, after a check whether the slider is held."""
        low, high, held = self._at_rest(load)
        reach = abs(self.wave.forward) + abs(self.wave.backward)
        fastest = FULL_SLIP * reach * (abs(self.wave.orbit) + float(self.cycle.limit_slope.max()))
        problem = self.cycle.problem._replace(  # forces in N, velocities over omega in m
            friction=self.slider.friction_coefficient, preload=self.slider.preload, load=load,
            tangential_damping=self.slider.tangential_damping * self.wave.omega,
        )  # fmt: skip
        # where the wave is an unknown, the search for all unknowns at once takes over from here
        close = 1e-6 if self.loads else 1e-13
        search = balanced_speed(problem, self, low.traction, high.traction, max(fastest, 1e-300), close)
        if search.way == 0.0:
            return replace(held, traction=load)
        if search.status == Status.RUNAWAY:
            raise ConvergenceError(
                "runaway", f"friction of {self.equilibrium.friction:.4g} N cannot balance the load of {abs(load):.4g} N"
            )
        if self.loads:
            self.equilibrium.unknowns[SPEED] = search.velocity
            return self.equilibrium.solve(load)
        moving = self.equilibrium.solve(load, search.velocity)
        return replace(moving, error=abs(search.force / search.slope))  # the last Newton step

    def _at_rest(self, load, close=CLOSE) -> tuple[Balance, Balance, Balance]:
        """Return the equilibria at v = 0 with the least and the largest <sum Q>, and that of the two that is held."""
        side = -1.0 if load <= 0.0 else 1.0
        other = self.rest(-side, load, close)
        # computed last, so that the wave amplitudes belong to these forces if the slider is held
        held = self.rest(side, load, close)
        return (other, held, held) if side < 0.0 else (held, other, held)

    @staticmethod
    def net_force(problem, search, w):
        """Return the mean tangential force less load and damper, which accelerates the slider at v = omega w."""
        return net_force(problem, search.equilibrium.solve(problem.load, w).traction, w)

    def directed(self, load: float) -> float:
        """Return a load with the sign of the motion that it opposes."""
        if load == 0.0:
            return 0.0
        free = self.under(0.0, ROUGH)
        if abs(free.w) < CLEAR * self.equilibrium.speed:
            free = self.under(0.0)
        if self._is_moving(free):
            return math.copysign(load, free.w)
        return math.copysign(load, -1.0 if self.rest(-1.0).traction < 0.0 else 1.0)

    def stall(self, direction: float) -> tuple[float, float]:
        """Return the limits of <sum Q> for v -> 0 from motions of sign `direction` and of the other sign, in N.

        Both are multiplied by `direction`.
        """
        ends = []
        for side in (direction, -direction):
            load = 0.0
            # a load that acts at a height tilts the slider and so changes <sum Q>: iterate until load and <sum Q> agree
            for _ in range(40):
                rest = self.rest(side, load)
                if self.slider.load_height == 0.0 or abs(rest.traction - load) < 1e-12 * self.equilibrium.friction:
                    break
                load = rest.traction
            ends.append(direction * rest.traction)
        return ends[0], ends[1]

    def traction(self, velocity: float, load: float, factor: float = 1.0) -> float:
        """Return <sum Q> in N at a velocity in m/s on the wave times a factor, under a signed load."""
        cycle, last = self.cycle, self.factor
        self.factor, cycle.incident = factor, factor * np.array([self.wave.forward, self.wave.backward])
        if not self.loads and factor != last:
            self.equilibrium.begin()
        elif last == 0.0:
            cycle.reset()
        else:  # the search starts from the amplitudes of the last call, scaled to this wave
            cycle.forward, cycle.backward = cycle.forward * (factor / last), cycle.backward * (factor / last)
        side = math.copysign(1.0, load) if velocity == 0.0 else math.copysign(1.0, velocity)
        return self.equilibrium.solve(load, velocity / self.wave.omega, side).traction

    def motion(self, balance: Balance, load: float) -> Coupled:
        """Return the motion of an equilibrium under a signed load."""
        wave, velocity = self.wave, balance.w * self.wave.omega
        rows = self._rows(balance, load, velocity)
        scale = max(speed_scale(velocity, wave.peak_speed), 1e-300)
        error = 0.0 if balance.w == 0.0 else float(balance.error * wave.omega / scale) + self.truncation
        rides = "slip" if rows.share_in_contact == 1.0 and rows.duty > HOPS else "intermittent"
        regime = "stick" if balance.w == 0.0 else rides
        return Coupled(velocity, balance.height, balance.tilt, error, regime, rows)

    def _rows(self, balance: Balance, load: float, velocity: float) -> WaveRows:
        slider, wave, cycle, forces = self.slider, self.wave, self.cycle, balance.forces
        passed, classes, weight = cycle.passed(forces), cycle.classes, cycle.weight
        order = np.arange(passed.shape[2]) + 1
        forward_drives = abs(wave.forward) >= abs(wave.backward)
        entry, other = (wave.forward, wave.backward) if forward_drives else (wave.backward, wave.forward)
        gone, back = (passed[0, -1], passed[1, 0]) if forward_drives else (passed[1, 0], passed[0, -1])
        entry = entry if entry != 0 else 1.0
        friction, leak = cycle.k_t * wave.omega * forces.cycles[[ContactMean.FRICTION, ContactMean.LEAK]]
        share, work = forces.cycles[ContactMean.SHARE], wave.omega * cycle.work(forces)
        touching = float(np.sum(weight[share > 0.0]))
        each = MeanForces(*(values[..., classes] for values in forces))
        return WaveRows(
            slider=slider, wave=wave, loading=self.loads, load=load, traction=balance.traction, row_x=cycle.row_x,
            forward=passed[0, :, 0], backward=passed[1, :, 0], exit_over_entry=complex(gone[0] / entry),
            reflected_over_entry=complex((back[0] - other) / entry), share_in_contact=touching / slider.number,
            duty=float(np.sum(weight * share)) / max(touching, 1.0), friction_power=float(np.sum(weight * friction)),
            thrust_power=load * velocity + 0.0,  # not -0.0
            damping_power=slider.tangential_damping * velocity**2, leak_power=float(np.sum(weight * leak)),
            wave_power_in=wave.power(wave.forward) + wave.power(wave.backward),
            wave_power_out=sum(n * (wave.power(a) + wave.power(b)) for n, a, b in zip(order, gone, back, strict=True)),
            loading_number=wave.loading_number(slider.preload), harmonics=order.size,
            overtones=passed[0 if forward_drives else 1, :, 1:], truncation=self.truncation,
            work=tuple(work.imag.sum(axis=(1, 2)).tolist()), apparent_power=float(np.abs(work.sum(axis=0)).sum()),
            deepest=(self.equilibrium.approaches + abs(cycle.amplitudes()[0])[cycle.row])[classes],
            forces=each, friction=friction[classes], sweeps=cycle.evaluations,
            state=SearchState(
                self.equilibrium.unknowns.copy(), cycle.forward.copy(), cycle.backward.copy(),
                self.equilibrium.approaches, *self.equilibrium.moving,
            ),
        )  # fmt: skip


def unloaded(slider: Slider, wave) -> tuple[CoupledSearch, Coupled, float]:
    """Return a search that starts from the motion without load, that motion and its direction.

    The direction of a slider that the wave does not move is that of the crests.
    """
    free = replace(slider, load=0.0)
    motion = coupled_motion(free, wave)
    direction = math.copysign(1.0, motion.velocity) if motion.velocity else crest_direction(wave)
    return CoupledSearch(free, wave, motion.rows.harmonics, motion.rows), motion, direction


def coupled_motion(slider: Slider, wave: PassingWave, near: WaveRows | None = None) -> Coupled:
    """Return the averaged motion of a slider on a passing wave.

    With `wave.loading` "harmonics" the number of harmonics is that of ``near``, if it has overtones, or doubled until
    the velocity keeps OVERTONE_ERROR.

    Raises
    ------
    InputError
        If the load drags the slider backwards.
    ConvergenceError
        If the search for the equilibrium does not converge.
    """
    if wave.loading != HARMONICS:
        return truncated_motion(slider, wave, near, 1)
    if slider.backing == "soft" or slider.shape != "punch":
        raise InputError("wave.loading", 'must not be "harmonics" with a soft backing or with balls', wave.loading)
    if near is not None and near.harmonics > 1:
        return truncated_motion(slider, wave, near, near.harmonics)
    try:
        motion = truncated_motion(slider, wave, near, 1)
    except InputError:  # the slider cannot carry the load without the overtones, but perhaps with them
        motion = truncated_motion(slider, wave, None, NUMBERS[0])
    truncation_error = 0.0
    for number in NUMBERS:
        coarser = motion
        try:
            motion = truncated_motion(slider, wave, coarser.rows, number)
        except ConvergenceError:  # this number has no equilibrium within reach of `coarser`; perhaps the next has
            if number == NUMBERS[-1]:
                raise
            continue
        scale = max(speed_scale(motion.velocity, wave.peak_speed), 1e-300)
        truncation_error = richardson(abs(motion.velocity - coarser.velocity) / scale, 2.0, 2)
        if truncation_error < OVERTONE_ERROR:
            break
    return motion._replace(
        relative_error=motion.relative_error + truncation_error, rows=replace(motion.rows, truncation=truncation_error)
    )


def truncated_motion(slider: Slider, wave: PassingWave, near: WaveRows | None, harmonics: int) -> Coupled:
    """Return the motion on a wave whose harmonics above a fixed number are left out; see `coupled_motion`."""
    search = CoupledSearch(slider, wave, harmonics, near)
    velocity = 0.0 if near is None else near.state.velocity_over_omega
    # the load with the sign of the unloaded motion, which it opposes
    load = search.directed(slider.load) if velocity == 0.0 else math.copysign(slider.load, velocity)
    balance = None  # remains so if the load accelerates the slider without end
    try:
        balance = search.under(load)
    except ConvergenceError as error:
        if error.status != "runaway" or load == 0.0:
            raise
    moves_backwards = balance is not None and slider.load > 0.0 and balance.w * load < 0.0
    if balance is None or moves_backwards:
        stall, max_load = search.stall(math.copysign(1.0, load))
        raise InputError(
            "slider.load",
            f"must be at most {max_load:.6g} N, above which it drags the slider backwards (in motion this carries "
            f"{stall:.6g} N, its stall)", slider.load, "N",
        )  # fmt: skip
    return search.motion(balance, load)
