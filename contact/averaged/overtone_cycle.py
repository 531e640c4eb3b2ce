"""All pillars of a slider through one cycle on a wave whose overtones they radiate.

The wave that drives is followed from row to row with its overtones (`overtone_march`). Of the wave against it the
fundamental alone is kept, that of the last forces, until neither changes: contacts do not see overtones that run back.
"""

import numpy as np

from contact.averaged.cycle_mean import Each, MeanForces, forces_of
from contact.averaged.march import march
from contact.averaged.overtone_march import Classes, Spectrum, Waves, overtone_march, samples
from contact.averaged.pillar_cycle import PillarCycle
from contact.convergence_error import ConvergenceError

SAMPLES, FEWEST = 4, 32  # of a cycle: for each harmonic, and at least
MEMORY = 16  # sweeps that Anderson's method combines
MAX_STEP = 0.3  # largest step of a sweep over the incident amplitude


class OvertoneCycle(PillarCycle):
    """Pillars and the wave's amplitudes: U_1 ... U_N of the driving one, shape (m, N), of the other U_1, (m, 1)."""

    def __init__(self, pillars, wave, loading: bool, harmonics: int):
        self.forward_drives = abs(wave.forward) >= abs(wave.backward)
        # from the rows from left to right to those in the order in which the driving wave meets them, and back
        self.downstream = slice(None) if self.forward_drives else slice(None, None, -1)
        self.numbers, self.harmonics = np.arange(harmonics) + 1, harmonics
        self.samples = samples(harmonics, max(SAMPLES * harmonics, FEWEST))
        super().__init__(pillars, wave, loading)
        behind = np.append(self.first[1:], self.x.size)
        self.contacts = Classes(
            np.ascontiguousarray(self.first[self.downstream]), np.ascontiguousarray(behind[self.downstream]),
            self.weight, self.k_n, self.k_t, self.limit_slope,
        )  # fmt: skip
        self.downstream_turn = np.ascontiguousarray(
            (self.turn if self.forward_drives else self.turn.conj())[self.downstream]
        )
        self.downstream_orbit = np.array([wave.orbit if self.forward_drives else wave.orbit.conjugate()])

    def begin(self, forward, backward):
        """Take the amplitudes at the rows from a search with any number of harmonics."""
        self.reset()
        for own, given in ((self.forward, forward), (self.backward, backward)):
            given = given.reshape(len(given), -1)
            shared = min(own.shape[1], given.shape[1])
            own[:, :shared] = given[:, :shared]

    def reset(self):
        """Let the wave pass as if nothing touched it."""
        super().reset()
        m, n = self.turn.size, self.harmonics
        driving, against = np.zeros((m, n), complex), np.zeros((m, 1), complex)
        self.spectrum = Spectrum(driving.copy(), against.copy(), np.zeros((m, 2, n), complex))
        self.approach, self.sweeps = None, []  # of the last forces; amplitudes and steps of the last sweeps
        fundamental = self.forward, self.backward
        self.forward, self.backward = (driving, against) if self.forward_drives else (against, driving)
        self.forward[:, 0], self.backward[:, 0] = fundamental

    def amplitudes(self):
        """Return the fundamental's u_z and u_x at each row."""
        orbit, forward, backward = self.wave.orbit, self.forward[:, 0], self.backward[:, 0]
        return forward + backward, orbit * forward + orbit.conjugate() * backward

    def forces(self, approach, w: float, side: float) -> MeanForces:
        """Return the forces at mean approaches in m and a velocity over omega, the wave that drives followed."""
        self.evaluations += 1
        if not np.array_equal(approach, self.approach):
            self.approach, self.sweeps = approach, []
        spectrum, incident = self.spectrum, np.zeros(self.harmonics, complex)
        driving, other = (
            (self.forward, self.backward) if self.forward_drives else (self.backward, self.forward)
        )
        spectrum.along[:], spectrum.against[:] = driving[self.downstream], other[self.downstream]
        incident[0] = self.incident[0 if self.forward_drives else 1]
        out = np.zeros((len(Each), self.x.size))
        waves = Waves(self.downstream_turn, self.downstream_orbit, self.g, incident)
        failed = overtone_march(
            self.contacts, waves, np.ascontiguousarray(approach), float(w), float(side), spectrum, self.samples, out
        )  # fmt: skip
        if failed:
            rule = "rows change the wave by more than their midpoint can follow"
            raise ConvergenceError("not converged", f"{failed} of {self.turn.size} {rule}")
        driving[:] = spectrum.along[self.downstream]
        return forces_of(out, self.k_n, self.k_t)

    def advance(self, forces: MeanForces, _slope=None) -> float:
        """Move the wave against the driving one to what the forces leave; return its change over the incident one.

        Contacts in touch are springs to it: the forces F of a row follow F_0 + S (U - U_0), S the sum of their normal
        stiffnesses, each for its share of the cycle. What this leaves out shrinks by about ten times in each sweep.
        """
        side, m = (1 if self.forward_drives else 0), self.turn.size  # of the wave against, in (U+, U-)
        other = (self.forward, self.backward)[side][:, 0]
        orbit = self.wave.orbit if self.forward_drives else self.wave.orbit.conjugate()
        normal, tangential = self.row_forces(forces)[..., 0].T
        force = np.zeros((m, 2), complex)
        amplitude = np.zeros((m, 2), complex)
        slope = np.zeros((m, 2, 2), complex)
        force[:, side], amplitude[:, side] = normal + orbit * tangential, other
        slope[:, side, side] = self.sums(forces.cycles[Each.SHARE] * self.k_n)
        step = march(self.turn, force, slope, amplitude, self.g, self.incident)[:, side] - other
        change = float(np.abs(step).max()) / max(self.wave.amplitude, 1e-300)
        # D. G. Anderson, J. ACM 12 (1965) 547: of the last sweeps the combination with the smallest step
        self.sweeps = [*self.sweeps[1 - MEMORY :], (other.copy(), step)]
        places, steps = (np.array(each).view(float) for each in zip(*self.sweeps, strict=True))
        moved, left = np.diff(places, axis=0), np.diff(steps, axis=0)
        if len(left):
            share = np.linalg.lstsq(left.T, steps[-1], rcond=1e-10)[0]
            step = step - (share @ (moved + left)).view(complex)
        other += step * min(1.0, MAX_STEP * self.wave.amplitude / max(float(np.abs(step).max()), 1e-300))
        return change

    def tangent(self, *_):
        """Return None: there is no step of Newton's, the sweeps go on."""

    def row_forces(self, _forces: MeanForces):
        """Return sum P_n and sum Q_n of the rows from left to right, shape (m, 2, N)."""
        return self.spectrum.force[self.downstream]

    def passed(self, forces: MeanForces):
        """Return U+ behind each row and U- before it, shape (2, m, N); the wave against has no overtones."""
        found = super().passed(forces)
        found[1 if self.forward_drives else 0, :, 1:] = 0.0
        return found

    def radiated(self, g: float, approach, w: float, side: float) -> complex:
        """Return the last overtone at the exit that contacts on the amplitudes as they stand send along with them."""
        forces = self.forces(approach, w, side)
        self.g = g
        found = self.passed(forces)
        return complex(found[0, -1, -1] if self.forward_drives else found[1, 0, -1])

    def work(self, forces: MeanForces):
        """Return the complex power over omega of the surface on each row and in each harmonic."""
        force, (u_z, u_x) = self.row_forces(forces), self.amplitudes()
        driving, orbit = (
            (self.forward, self.wave.orbit)
            if self.forward_drives
            else (self.backward, self.wave.orbit.conjugate())
        )
        u_z, u_x = (
            np.concatenate([one[:, None], c * driving[:, 1:]], axis=1)
            for one, c in ((u_z, 1.0), (u_x, orbit))
        )
        return 0.5 * self.numbers * (force[:, 0] * u_z.conj() + force[:, 1] * u_x.conj())
