"""Equilibria of one slider on pillars under loads: moving, held, at the stall."""

import math
from contextlib import suppress
from dataclasses import replace

import numpy as np

from contact.averaged.cycle_mean import Each
from contact.averaged.equilibrium import balanced_speed, force_left
from contact.averaged.overtone_cycle import OvertoneCycle
from contact.averaged.pillar_cycle import PillarCycle
from contact.averaged.pillar_equilibrium import SPEED, Balance, Equilibrium
from contact.averaged.pillar_results import PillarMotion, SearchState
from contact.codes import Status
from contact.exceptions import ConvergenceError, InputError

LOADED = 0.05  # loading number above which the slider acts back on the wave if `loading` is None
FULL_SLIP = 1.001  # safety factor on the velocity above which every contact slips through the whole cycle


class PillarSlider:
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
        self.moves = False  # whether the last equilibrium moves

    def begin_at(self, near: PillarMotion) -> None:
        """Start the next search from a motion of the same pillars."""
        state = near.state
        if len(state.forward) == len(self.cycle.forward):
            size = self.wave.amplitude / near.wave.amplitude if near.wave.amplitude > 0.0 else 1.0
            self.equilibrium.unknowns = state.unknowns.copy()
            if self.loading == near.loading and self.loading:
                self.cycle.begin(state.forward * size, state.backward * size)
        self.moves, self.truncation = near.velocity != 0.0, near.truncation

    def rest(self, side: float, load: float = 0.0) -> Balance:
        """Return the equilibrium in the limit v -> 0 of motions of sign `side`."""
        return self.equilibrium.solve(load, 0.0, side)

    def under(self, load: float) -> Balance:
        """Return the equilibrium under a signed load; the slider moves or is held."""
        start, waves = self.equilibrium.unknowns.copy(), (self.cycle.forward, self.cycle.backward)
        if self.wave.amplitude == 0.0:
            return self._bracketed(load)
        if not self.moves:
            # one contact at rest takes 8 evaluations; a search for the velocity of a held slider gives up after 200
            with suppress(ConvergenceError):
                low, high, held = self._at_rest(load)
                if low.traction <= load <= high.traction:
                    return replace(held, traction=load)
            self.equilibrium.unknowns = start.copy()
            self.cycle.begin(*waves)
        try:
            equilibrium = self.equilibrium.solve(load)
            self.moves = self._is_moving(equilibrium)
            if self.moves:
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
        low, high, held = self._at_rest(load)
        reach = abs(self.wave.forward) + abs(self.wave.backward)
        fastest = FULL_SLIP * reach * (abs(self.wave.orbit) + float(self.cycle.limit_slope.max()))
        problem = self.cycle.problem._replace(  # forces in N, velocities over omega in m
            friction=self.pillars.friction_coefficient, preload=self.pillars.preload, load=load,
            tangential_damping=self.pillars.tangential_damping * self.wave.omega,
        )  # fmt: skip
        search = balanced_speed(problem, self, low.traction, high.traction, max(fastest, 1e-300), 1e-6)
        if search.way == 0.0:
            return replace(held, traction=load)
        if search.status == Status.RUNAWAY:
            raise ConvergenceError(
                "runaway", f"friction of {self.equilibrium.friction:.4g} N cannot balance the load of {abs(load):.4g} N"
            )
        self.equilibrium.unknowns[SPEED] = search.velocity
        return self.equilibrium.solve(load)

    def _at_rest(self, load) -> tuple[Balance, Balance, Balance]:
        """Return the equilibria at v = 0 with the least and the largest <sum Q>, and that of the two that is held."""
        side = -1.0 if load <= 0.0 else 1.0
        other = self.rest(-side, load)
        # computed last, so that the wave amplitudes belong to these forces if the slider is held
        held = self.rest(side, load)
        return (other, held, held) if side < 0.0 else (held, other, held)

    @staticmethod
    def left(problem, slider, w):
        """Return the mean tangential force less load and damper, which accelerates the slider at v = omega w."""
        return force_left(problem, slider.equilibrium.solve(problem.load, w).traction, w)

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
            state=SearchState(
                self.equilibrium.unknowns.copy(), cycle.forward.copy(), cycle.backward.copy(),
                self.equilibrium.approaches, *self.equilibrium.moving,
            ),
            sweeps=cycle.evaluations,
        )  # fmt: skip
        if held:
            return motion
        left = float(equilibrium.error * wave.omega / motion.speed_scale)
        return replace(motion, relative_error=left + self.truncation)
