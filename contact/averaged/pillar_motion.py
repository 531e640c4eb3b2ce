"""How fast a slider on many contacts runs on a wave that it loads, what it takes from the wave, and its load line."""

import math
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from contact import bounds
from contact.averaged import flat_cycle as columns
from contact.averaged.equilibrium import balanced_speed
from contact.averaged.overtone_cycle import OvertoneCycle
from contact.averaged.pillar_cycle import PillarCycle
from contact.averaged.pillar_equilibrium import SPEED, Balance, Equilibrium
from contact.averaged.pillars import PassingWave, Pillars
from contact.codes import Status
from contact.convergence_error import ConvergenceError
from contact.input_error import InputError

LOADED = 0.05  # loading number above which a slider acts back on the wave, where `loading` is None
FULL_SLIP = 1.001  # of the velocity beyond which every contact slips all the time
HARMONICS = "harmonics"  # the word for a load on the wave with its overtones
NUMBERS = (8, 16, 32, 64)  # harmonics, until the last doubling leaves the velocity an error below
OVERTONE_ERROR = 5e-4  # half of the default tolerance


@dataclass(frozen=True, kw_only=True)
class PillarMotion:
    """Steady motion of a slider on pillars or balls, averaged over the wave's cycle.

    Attributes
    ----------
    velocity : float
        m/s, along +x.
    held : bool
        True: v = 0, and contacts that stick carry the load.
    approach : float
        Mean approach H of a pillar of height 0 at the slider's centre, m; of a soft backing the mean over the rows.
    tilt : tuple of float
        Rotations in rad: growth of the approach along x (pitch) and along y (roll).
    load : float
        Force on the slider against which it runs, N, with the sign of the motion it opposes.
    traction : float
        Mean tangential force of all pillars, N.
    row_x : ndarray, shape (m,)
        Places of the rows, m.
    forward, backward : ndarray, shape (m,), complex
        U+ behind each row and U- before it (at smaller x), m, without the factors exp(-i k x) and exp(+i k x).
    exit_over_entry, reflected_over_entry : complex
        Of the larger incident wave: what leaves of it, and what leaves against it beyond the other incident wave, over
        the incident amplitude.
    share_in_contact, duty : float
        Part of the pillars that touch at all, and the mean part of the cycle for which these do.
    friction_power, thrust_power, damping_power : float
        Of slip, of the load, and of the viscous damper, W. The elastic law's spring of a ball is not conservative: what
        it loses or gains counts as friction.
    wave_power_in, wave_power_out : float
        Of both waves within the strip, W; 0 without Gamma.
    loading_number : float
        Lambda = 2 Gamma F/(w A).
    loading : bool
        Whether the wave was loaded.
    harmonics : int
        Number of harmonics of the wave that were followed; 1: the fundamental alone.
    overtones : ndarray, shape (m, harmonics - 1), complex
        U_2, U_3 ... of the wave that drives, m, behind each row as it meets them, in the order of `row_x`.
    wave_work, apparent_power : float
        Power that the surface under the pillars gives them by the harmonics of their forces, W, and in VA.
    normal_force, friction : ndarray, shape (n,)
        Of each pillar: mean normal force in N and mean friction power in W.
    first_normal, first_tangential : ndarray, shape (n,), complex
        First harmonics P_1 and Q_1 of the force of each pillar on the slider, N.
    relative_error, truncation : float
        Numerical, of the velocity, over max(|v|, omega |u_x|/10), and the part of it that is left by the number of
        harmonics: a third of the change by its last doubling, for it falls as their square.
    sweeps : int
        Cycles of all pillars that were computed.
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
    # From which a near motion begins: unknowns of `Equilibrium`, amplitudes of U+ and of U- at the rows, mean
    # approaches of the pillars, w = v/omega in m, sign of the motion from which a velocity of zero comes
    state: tuple = field(repr=False)

    @property
    def ledger_residual(self) -> float:
        """What the energy balance misses: power taken from the wave less friction, load and damper, over the incident.

        Without loading, the work of the surface on the pillars takes the wave's place, over the apparent power.
        """
        spent = self.friction_power + self.thrust_power + self.damping_power
        if self.loading:
            return float((self.wave_power_in - self.wave_power_out - spent) / self.wave_power_in)
        return float((self.wave_work - spent) / max(self.apparent_power, 1e-300))

    @property
    def speed_scale(self) -> float:
        """The velocity that errors are measured by, max(|v|, omega |u_x|/10), m/s."""
        wave = self.wave
        return max(abs(self.velocity), wave.omega * abs(wave.orbit) * wave.amplitude / 10.0, 1e-300)

    @property
    def exit_overtones(self) -> np.ndarray:
        """U_2, U_3 ... where the wave that drives leaves the slider, m, shape (harmonics - 1,)."""
        return self.overtones[-1 if abs(self.wave.forward) >= abs(self.wave.backward) else 0]

    @property
    def overtone(self) -> float:
        """|U_2| at the exit over the incident |U_1|; of a motion without overtones what its contacts would radiate.

        0 for balls, for which it is not computed.
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
    """Steady motions under loads from nothing to the stall.

    Attributes
    ----------
    motions : tuple of PillarMotion
        In the order of the loads; the last at the stall, held.
    stall : float
        Largest load that a slider in motion carries, N: the mean tangential force for v -> 0 from its side.
    held_up_to : float
        Largest load that holds it at rest, N; larger ones drag it backwards. Between both is the stick band.
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
        """Mechanical powers, load times speed, W."""
        return np.array([each.thrust_power for each in self.motions])

    @property
    def efficiency(self) -> np.ndarray:
        """Mechanical power over what the wave gives the pillars."""
        taken = [each.thrust_power + each.friction_power + each.damping_power for each in self.motions]
        return np.divide(self.power, taken, out=np.zeros(len(taken)), where=np.array(taken) > 0.0)

    @property
    def relative_error(self) -> np.ndarray:
        """Numerical errors of the velocities."""
        return np.array([each.relative_error for each in self.motions])

    @property
    def status(self) -> str:
        """Always "ok": a motion that is not found raises."""
        return "ok"

    @property
    def message(self) -> str:
        """How the velocities were found, as a `LoadLine` says it."""
        return "averaged equilibria of the pillars"

    @property
    def blocked_thrust(self) -> float:
        """The stall, as a `LoadLine` names it, N."""
        return self.stall


class Asked(NamedTuple):
    """What `balanced_speed` asks of a problem, velocities over omega."""

    friction: float
    preload: float
    load: float
    tangential_damping: float


class _Slider:
    """The equilibria of one slider on one wave, each begun at the last; w = v/omega is the velocity, m."""

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
        """Begin the search at a motion of the same pillars."""
        unknowns, forward, backward, *_ = near.state
        if len(forward) == len(self.cycle.forward):
            size = self.wave.amplitude / near.wave.amplitude if near.wave.amplitude > 0.0 else 1.0
            self.equilibrium.unknowns = unknowns.copy()
            if self.loading == near.loading and self.loading:
                self.cycle.begin(forward * size, backward * size)
        self.truncation = near.truncation

    def rest(self, side: float, load: float = 0.0) -> Balance:
        """Return the equilibrium at v = 0 of a slider that came from a motion of this sign."""
        return self.equilibrium.solve(load, 0.0, side)

    def under(self, load: float) -> Balance:
        """Return the equilibrium under a load with its sign, which may be held."""
        kept = self.equilibrium.unknowns.copy()
        if self.wave.amplitude == 0.0:
            return self._bracketed(load)
        try:
            found = self.equilibrium.solve(load)
            if self._is_moving(found):
                return found
        except ConvergenceError:
            pass
        self.equilibrium.unknowns = kept
        self.cycle.reset()
        return self._bracketed(load)

    def _is_moving(self, found):
        """Whether the velocity is above rounding: below, it may be that of a band of sticking contacts."""
        return abs(found.w) > 1e-9 * self.equilibrium.speed

    def _bracketed(self, load):
        """Return the equilibrium by a search for the velocity alone: at rest, or where the mean force changes sign."""
        side = -1.0 if load <= 0.0 else 1.0
        other = self.rest(-side, load)
        # the last, so that the wave's amplitudes are those of its forces if the slider is held
        held = self.rest(side, load)
        low, high = (other, held) if side < 0.0 else (held, other)
        rounding = 1e-12 * self.equilibrium.friction
        if low.traction - load <= rounding and high.traction - load >= -rounding:
            return replace(held, traction=load)
        way = 1.0 if low.traction > load else -1.0
        reach = abs(self.wave.forward) + abs(self.wave.backward)
        fastest = FULL_SLIP * reach * (abs(self.wave.orbit) + float(self.cycle.limit_slope.max()))
        asked = Asked(
            self.pillars.friction_coefficient, self.pillars.preload, load,
            self.pillars.tangential_damping * self.wave.omega,
        )  # fmt: skip
        found = balanced_speed(
            asked, self, way, (low if way > 0.0 else high).traction, max(fastest, 1e-300), 1e-6
        )
        if found.status == Status.RUNAWAY:
            raise ConvergenceError(
                "runaway",
                f"friction of {self.equilibrium.friction:.4g} N cannot balance the load of {abs(load):.4g} N",
            )
        self.equilibrium.unknowns[SPEED] = found.velocity
        return self.equilibrium.solve(load)

    @staticmethod
    def left(asked, slider, w):
        """Return the mean tangential force that is left to accelerate the slider at a velocity over omega."""
        return slider.equilibrium.solve(asked.load, w).traction - asked.load - asked.tangential_damping * w

    def directed(self, load: float) -> float:
        """Return a load with the sign of the motion that it opposes."""
        if load == 0.0:
            return 0.0
        free = self.under(0.0)
        if self._is_moving(free):
            return math.copysign(load, free.w)
        return math.copysign(load, -1.0 if self.rest(-1.0).traction < 0.0 else 1.0)

    def stall(self, way: float) -> tuple[float, float]:
        """Return the sums of <Q> over v -> 0 from a motion of sign `way` and from the other side, times `way`, N."""
        ends = []
        for side in (way, -way):
            load = 0.0
            # a load at a height tilts the slider and so changes the traction: repeat with load = traction until both
            # agree
            for _ in range(40):
                found = self.rest(side, load)
                if (
                    self.pillars.load_height == 0.0
                    or abs(found.traction - load) < 1e-12 * self.equilibrium.friction
                ):
                    break
                load = found.traction
            ends.append(way * found.traction)
        return ends[0], ends[1]

    def motion(self, found: Balance, load: float) -> PillarMotion:
        """Return the answer at an equilibrium."""
        pillars, wave, cycle = self.pillars, self.wave, self.cycle
        forces, classes, weight = found.forces, cycle.classes, cycle.weight
        passed, velocity = cycle.passed(forces), found.w * wave.omega
        order = np.arange(passed.shape[2]) + 1
        forward_drives = abs(wave.forward) >= abs(wave.backward)
        entry, other = (wave.forward, wave.backward) if forward_drives else (wave.backward, wave.forward)
        gone, back = (passed[0, -1], passed[1, 0]) if forward_drives else (passed[1, 0], passed[0, -1])
        entry = entry if entry != 0 else 1.0
        friction = cycle.k_t * wave.omega * forces.cycles[:, columns.FRICTION]
        share = forces.cycles[:, columns.SHARE]
        touching = float(np.sum(weight[share > 0.0]))
        work, held = cycle.work(forces), found.w == 0.0
        motion = PillarMotion(
            pillars=pillars, wave=wave, velocity=velocity, held=held, approach=float(np.mean(found.height)),
            tilt=(found.pitch, found.roll), load=load, traction=found.traction, row_x=cycle.row_x,
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
        left = float(found.error * wave.omega / motion.speed_scale)
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
        Force against the direction in which the unloaded slider runs, N, zero or positive.
    loading : bool or "harmonics", optional
        Whether the pillars act back on the wave; None: where the loading number is above 0.05; "harmonics": also with
        the overtones that their forces radiate, which a bare crystal lets grow in phase.
    near : PillarMotion, optional
        A motion of pillars at the same places on much the same wave, from which the search begins, with as many
        harmonics if the overtones are asked for.

    Returns
    -------
    PillarMotion

    Raises
    ------
    ValueError
        For a load above the largest that the slider holds.
    ConvergenceError
        If no equilibrium was reached.

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
    except InputError:  # a load that only the overtones carry, or nothing does
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
    """Return the motion with so many harmonics; see `pillar_motion`."""
    slider = _Slider(pillars, wave, loading, harmonics)
    if near is not None:
        slider.begin_at(near)
    signed = (
        slider.directed(load) if near is None or near.velocity == 0.0 else math.copysign(load, near.velocity)
    )
    try:
        found = slider.under(signed)
    except ConvergenceError as error:
        if error.status != "runaway":
            raise
        found = None
    if load > 0.0 and (found is None or found.w * signed < 0.0):
        stall, most = slider.stall(math.copysign(1.0, signed))
        raise InputError(
            "load",
            f"must be at most {most:.6g} N, above which it drags the slider backwards (in motion this carries "
            f"{stall:.6g} N, its stall)", load, "N",
        )  # fmt: skip
    return slider.motion(found, signed)


def pillar_load_line(
    pillars: Pillars, wave: PassingWave, *, points: int = 20, loading: bool | str | None = None
) -> PillarLoadLine:
    """Return the load line of a slider on pillars: loads in equal steps from nothing to the stall.

    Parameters are those of `pillar_motion`; `points`: number of motions, at least 2.
    """
    points = bounds.count("points", points, 2)
    free = pillar_motion(pillars, wave, loading=loading)
    if free.held:
        raise ConvergenceError("not applicable", "the slider is at rest without a load: it has no load line")
    slider = _Slider(pillars, wave, free.loading, free.harmonics)
    slider.begin_at(free)
    way, motions = math.copysign(1.0, free.velocity), [free]
    start = slider.equilibrium.unknowns.copy()
    stall, held = slider.stall(way)
    slider.equilibrium.unknowns = start
    for number in range(1, points - 1):
        load = way * stall * number / (points - 1)
        motions.append(slider.motion(slider.under(load), load))
    last = slider.rest(way, way * stall)
    motions.append(slider.motion(last, way * stall))
    return PillarLoadLine(motions=tuple(motions), stall=stall, held_up_to=held)


def pillar_traction(
    pillars: Pillars, wave: PassingWave, *, load: float = 0.0, loading: bool | None = None,
    near: PillarMotion | None = None,
):  # fmt: skip
    """Return a function of velocity in m/s and a factor on the wave's amplitude: the sum of <Q> in N that they give.

    For averaged motion through time, height and tilts in balance at every instant. `load` in N, with the sign of the
    motion it opposes, tips the slider where it acts at a height. Each call begins at the last, the first at `near`,
    whose overtones are followed as well.
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
