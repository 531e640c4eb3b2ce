"""Steady velocity, wave loading and load line of a slider on many pillars or balls, averaged over the wave's cycle."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from contact import bounds
from contact.averaged.cycle_mean import Each
from contact.averaged.equilibrium import balanced_speed
from contact.averaged.overtone_cycle import OvertoneCycle
from contact.averaged.pillar_cycle import PillarCycle
from contact.averaged.pillar_equilibrium import SPEED, Balance, Equilibrium
from contact.averaged.pillars import PassingWave, Pillars
from contact.codes import Status
from contact.convergence_error import ConvergenceError
from contact.drive import speed_scale
from contact.input_error import InputError

LOADED = 0.05  # loading number above which the slider acts back on the wave if `loading` is None
FULL_SLIP = 1.001  # safety factor on the velocity above which every contact slips through the whole cycle
HARMONICS = "harmonics"  # value of `loading` that includes the overtones of the wave
# Numbers of harmonics to try, until the change of the velocity by the last doubling gives an error below
# OVERTONE_ERROR.
NUMBERS = (8, 16, 32, 64)
OVERTONE_ERROR = 5e-4  # half of the default tolerance


@dataclass(frozen=True, kw_only=True)
class PillarMotion:
    """Steady motion of a slider on pillars or balls, averaged over the wave's cycle.

    Attributes
    ----------
    velocity : float
        Velocity along +x, m/s.
    held : bool
        True if v = 0 and sticking contacts carry the load.
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
        Power of both waves within the strip, W; 0 without Gamma.
    loading_number : float
        Lambda = 2 Gamma F/(w A).
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
        Number of cycles computed for all pillars.
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
    # Start values for the search of a similar motion: unknowns of `Equilibrium`, amplitudes U+ and U- at the rows, mean
    # approaches of the pillars, w = v/omega in m, and for w = 0 the sign of the motion before it
    state: tuple = field(repr=False)

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
            _, forward, backward, *moving = self.state
            cycle = OvertoneCycle(self.pillars, wave, False, 2)
            cycle.begin(forward, backward)
            second = cycle.radiated(wave.compliance / wave.strip_width, *moving)
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


class VelocityProblem(NamedTuple):
    """The attributes of a problem that `balanced_speed` uses; velocities are divided by omega."""

    friction: float
    preload: float
    load: float
    tangential_damping: float


class _Slider:
    """Solver for the equilibria of one slider on one wave; w = v/omega is the velocity in m.

    Each search starts from the last equilibrium.
    """

    def __init__(self, pillars, wave, loading, harmonics=1):
        if loading is None:
            loading = wave.loading_number(pillars.preload) > LOADED
        if loading and wave.compliance == 0.0:
            raise InputError("wave.compliance", "(Gamma, 1/Pa) is required where the slider loads the wave")
        self.pillars, self.wave, self.loading = pillars, wave, bool(loading) and wave.amplitude > 0.0
        if self.loading and harmonics > 1:
            self.cycle = OvertoneCycle(pillars, wave, True, harmonics)
        else:
            self.cycle = PillarCycle(pillars, wave, self.loading)
        self.equilibrium, self.truncation = Equilibrium(self.cycle), 0.0

    def begin_at(self, near: PillarMotion) -> None:
        """Start the next search from a motion of the same pillars."""
        unknowns, forward, backward, *_ = near.state
        if len(forward) == len(self.cycle.forward):
            size = self.wave.amplitude / near.wave.amplitude if near.wave.amplitude > 0.0 else 1.0
            self.equilibrium.unknowns = unknowns.copy()
            if self.loading == near.loading and self.loading:
                self.cycle.begin(forward * size, backward * size)
        self.truncation = near.truncation

    def rest(self, side: float, load: float = 0.0) -> Balance:
        """Return the equilibrium in the limit v -> 0 of motions of sign `side`."""
        return self.equilibrium.solve(load, 0.0, side)

    def under(self, load: float) -> Balance:
        """Return the equilibrium under a signed load; the slider moves or is held."""
        start = self.equilibrium.unknowns.copy()
        if self.wave.amplitude == 0.0:
            return self._bracketed(load)
        try:
            equilibrium = self.equilibrium.solve(load)
            if self._is_moving(equilibrium):
                return equilibrium
        except ConvergenceError:
            pass
        self.equilibrium.unknowns = start
        self.cycle.reset()
        return self._bracketed(load)

    def _is_moving(self, equilibrium):
        """Return True if the velocity exceeds rounding; a smaller one may belong to sticking contacts."""
        return abs(equilibrium.w) > 1e-9 * self.equilibrium.speed

    def _bracketed(self, load):
        """Return the equilibrium by a bracketing search for the velocity, after a check whether the slider is held."""
        side = -1.0 if load <= 0.0 else 1.0
        other = self.rest(-side, load)
        # computed last, so that the wave amplitudes belong to these forces if the slider is held
        held = self.rest(side, load)
        low, high = (other, held) if side < 0.0 else (held, other)
        rounding = 1e-12 * self.equilibrium.friction
        if low.traction - load <= rounding and high.traction - load >= -rounding:
            return replace(held, traction=load)
        direction = 1.0 if low.traction > load else -1.0
        reach = abs(self.wave.forward) + abs(self.wave.backward)
        fastest = FULL_SLIP * reach * (abs(self.wave.orbit) + float(self.cycle.limit_slope.max()))
        problem = VelocityProblem(
            self.pillars.friction_coefficient, self.pillars.preload, load,
            self.pillars.tangential_damping * self.wave.omega,
        )  # fmt: skip
        at_rest = (low if direction > 0.0 else high).traction
        search = balanced_speed(problem, self, direction, at_rest, max(fastest, 1e-300), 1e-6)
        if search.status == Status.RUNAWAY:
            raise ConvergenceError(
                "runaway", f"friction of {self.equilibrium.friction:.4g} N cannot balance the load of {abs(load):.4g} N"
            )
        self.equilibrium.unknowns[SPEED] = search.velocity
        return self.equilibrium.solve(load)

    @staticmethod
    def left(problem, slider, w):
        """Return the mean tangential force less load and damper, which accelerates the slider at v = omega w."""
        return slider.equilibrium.solve(problem.load, w).traction - problem.load - problem.tangential_damping * w

    def directed(self, load: float) -> float:
        """Return a load with the sign of the motion that it opposes."""
        if load == 0.0:
            return 0.0
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
                if self.pillars.load_height == 0.0 or abs(rest.traction - load) < 1e-12 * self.equilibrium.friction:
                    break
                load = rest.traction
            ends.append(direction * rest.traction)
        return ends[0], ends[1]

    def motion(self, equilibrium: Balance, load: float) -> PillarMotion:
        """Return the `PillarMotion` of an equilibrium under a load."""
        pillars, wave, cycle = self.pillars, self.wave, self.cycle
        forces, classes, weight = equilibrium.forces, cycle.classes, cycle.weight
        passed, velocity = cycle.passed(forces), equilibrium.w * wave.omega
        order = np.arange(passed.shape[2]) + 1
        forward_drives = abs(wave.forward) >= abs(wave.backward)
        entry, other = (wave.forward, wave.backward) if forward_drives else (wave.backward, wave.forward)
        gone, back = (passed[0, -1], passed[1, 0]) if forward_drives else (passed[1, 0], passed[0, -1])
        entry = entry if entry != 0 else 1.0
        friction = cycle.k_t * wave.omega * forces.cycles[Each.FRICTION]
        share = forces.cycles[Each.SHARE]
        touching = float(np.sum(weight[share > 0.0]))
        work, held = cycle.work(forces), equilibrium.w == 0.0
        motion = PillarMotion(
            pillars=pillars, wave=wave, velocity=velocity, held=held, approach=equilibrium.height,
            tilt=equilibrium.tilt, load=load, traction=equilibrium.traction, row_x=cycle.row_x,
            forward=passed[0, :, 0], backward=passed[1, :, 0], exit_over_entry=complex(gone[0] / entry),
            reflected_over_entry=complex((back[0] - other) / entry),
            share_in_contact=touching / pillars.number, duty=float(np.sum(weight * share)) / max(touching, 1.0),
            friction_power=float(np.sum(weight * friction)), thrust_power=load * velocity + 0.0,  # not -0.0
            damping_power=pillars.tangential_damping * velocity**2,
            wave_power_in=wave.power(wave.forward) + wave.power(wave.backward),
            wave_power_out=sum(n * (wave.power(a) + wave.power(b)) for n, a, b in zip(order, gone, back, strict=True)),
            loading_number=wave.loading_number(pillars.preload), loading=self.loading, harmonics=order.size,
            overtones=passed[0 if forward_drives else 1, :, 1:], wave_work=wave.omega * float(work.imag.sum()),
            apparent_power=wave.omega * float(np.abs(work).sum()),
            normal_force=forces.normal[classes],
            friction=friction[classes], first_normal=forces.first_normal[classes],
            first_tangential=forces.first_tangential[classes], relative_error=0.0, truncation=self.truncation,
            state=(
                self.equilibrium.unknowns.copy(), cycle.forward.copy(), cycle.backward.copy(), self.equilibrium.place,
                *self.equilibrium.moving,
            ),
            sweeps=cycle.evaluations,
        )  # fmt: skip
        if held:
            return motion
        left = float(equilibrium.error * wave.omega / motion.speed_scale)
        return replace(motion, relative_error=left + self.truncation)


def pillar_motion(
    pillars: Pillars, wave: PassingWave, *, load: float = 0.0, loading: bool | str | None = None,
    near: PillarMotion | None = None,
) -> PillarMotion:  # fmt: skip
    """Return the steady motion of a slider on pillars.

    Parameters
    ----------
    pillars : Pillars
    wave : PassingWave
    load : float
        Force against the direction of the unloaded motion, N, zero or positive.
    loading : bool or "harmonics", optional
        True if the pillars act back on the wave. None means True if the loading number is above 0.05. "harmonics" also
        includes the overtones that the contact forces radiate; on a bare crystal, which has no dispersion, they add up
        in phase along the slider.
    near : PillarMotion, optional
        A motion of pillars at the same positions on a similar wave, from which the search starts. With "harmonics" its
        number of harmonics is used if it has overtones.

    Returns
    -------
    PillarMotion

    Raises
    ------
    ValueError
        If the load drags the slider backwards.
    ConvergenceError
        If the search for the equilibrium does not converge.

    Examples
    --------
    Ten thousand pillars of 20 um on 5 mm x 5 mm:

    >>> x, y = (each.ravel() for each in np.meshgrid(np.arange(100) * 50e-6 - 2.475e-3, np.arange(100) * 50e-6))
    >>> slider = Pillars(
    ...     x=x, y=y, normal_stiffness=1.8e6, tangential_stiffness=1.52e6, friction_coefficient=0.18, preload=30.0
    ... )
    >>> wave = PassingWave(
    ...     frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9,
    ...     compliance=2.5078e-12, strip_width=5e-3,
    ... )
    >>> round(pillar_motion(slider, wave, loading=False).velocity, 8)
    -0.92621972
    >>> loaded = pillar_motion(slider, wave)
    >>> bool(abs(loaded.ledger_residual) < 1e-12)
    True
    """
    load = bounds.non_negative("load", load, "N")
    if loading != HARMONICS:
        return _motion(pillars, wave, load, loading, near, 1)
    if pillars.backing == "soft" or pillars.shape != "punch":
        raise InputError("loading", 'must not be "harmonics" with a soft backing or with balls', loading)
    if near is not None and near.harmonics > 1:
        return _motion(pillars, wave, load, True, near, near.harmonics)
    try:
        motion = _motion(pillars, wave, load, True, near, 1)
    except InputError:  # the slider cannot carry the load without the overtones, but perhaps with them
        motion = _motion(pillars, wave, load, True, None, NUMBERS[0])
    change = 0.0
    for number in NUMBERS:
        last = motion.velocity
        try:
            motion = _motion(pillars, wave, load, True, motion, number)
        except ConvergenceError:
            if number == NUMBERS[-1]:
                raise
            continue
        change = abs(motion.velocity - last) / motion.speed_scale / 3.0
        if change < OVERTONE_ERROR:
            break
    return replace(motion, relative_error=motion.relative_error + change, truncation=change)


def _motion(pillars, wave, load, loading, near, harmonics) -> PillarMotion:
    """Return the motion with a fixed number of harmonics; see `pillar_motion`."""
    slider = _Slider(pillars, wave, loading, harmonics)
    if near is not None:
        slider.begin_at(near)
    signed = slider.directed(load) if near is None or near.velocity == 0.0 else math.copysign(load, near.velocity)
    try:
        equilibrium = slider.under(signed)
    except ConvergenceError as error:
        if error.status != "runaway":
            raise
        equilibrium = None
    if load > 0.0 and (equilibrium is None or equilibrium.w * signed < 0.0):
        stall, max_load = slider.stall(math.copysign(1.0, signed))
        raise InputError(
            "load",
            f"must be at most {max_load:.6g} N, above which it drags the slider backwards (in motion this carries "
            f"{stall:.6g} N, its stall)", load, "N",
        )  # fmt: skip
    return slider.motion(equilibrium, signed)


def pillar_load_line(
    pillars: Pillars, wave: PassingWave, *, points: int = 20, loading: bool | str | None = None
) -> PillarLoadLine:
    """Return the load line of a slider on pillars, with loads in equal steps from zero to the stall.

    `points` is the number of motions, at least 2. The other parameters are those of `pillar_motion`.
    """
    points = bounds.count("points", points, 2)
    free = pillar_motion(pillars, wave, loading=loading)
    if free.held:
        raise ConvergenceError("not applicable", "the slider is at rest without a load: it has no load line")
    slider = _Slider(pillars, wave, free.loading, free.harmonics)
    slider.begin_at(free)
    direction, motions = math.copysign(1.0, free.velocity), [free]
    start = slider.equilibrium.unknowns.copy()
    stall, held = slider.stall(direction)
    slider.equilibrium.unknowns = start
    for number in range(1, points - 1):
        load = direction * stall * number / (points - 1)
        motions.append(slider.motion(slider.under(load), load))
    last = slider.rest(direction, direction * stall)
    motions.append(slider.motion(last, direction * stall))
    return PillarLoadLine(motions=tuple(motions), stall=stall, held_up_to=held)


def pillar_traction(
    pillars: Pillars, wave: PassingWave, *, load: float = 0.0, loading: bool | None = None,
    near: PillarMotion | None = None,
):  # fmt: skip
    """Return a function traction(velocity in m/s, factor on the wave amplitude) that gives <sum Q> in N.

    It serves the averaged motion as a function of time, with height and tilts in equilibrium at all times. `load` in N
    has the sign of the motion that it opposes; it tilts the slider if it acts at a height. Each call starts from the
    result of the last one, and the first call starts from `near`. If `near` has overtones, they are included.
    """
    if near is None:
        slider = _Slider(pillars, wave, loading)
    else:
        slider = _Slider(pillars, wave, near.loading, near.harmonics)
        slider.begin_at(near)
    cycle, equilibrium, full, last = slider.cycle, slider.equilibrium, slider.cycle.incident.copy(), 1.0

    def traction(velocity: float, size: float = 1.0) -> float:
        nonlocal last
        cycle.incident = full * size
        cycle.forward, cycle.backward = cycle.forward * (size / last), cycle.backward * (size / last)
        last = size
        side = math.copysign(1.0, load) if velocity == 0.0 else math.copysign(1.0, velocity)
        return equilibrium.solve(load, velocity / wave.omega, side).traction

    return traction
