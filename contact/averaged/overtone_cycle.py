"""All contacts of a slider through one cycle on a wave whose overtones they radiate.

Two waves meet the rows. The *driving* wave, the larger one, carries overtones and is followed from row to row
(`overtone_march`). The *opposing* wave runs the other way. It keeps its fundamental only: overtones that run back are
left out. It follows by iteration: follow the driving wave, update the opposing one from the forces, repeat until
neither changes. Arrays per row are ordered from left to right; `self.downstream` takes them to the order in which the
driving wave meets the rows, or back, and `self.downstream_...` are in that order.
"""

import numpy as np

from contact.averaged.cycle_mean import ContactMean, MeanForces, forces_of
from contact.averaged.march import march, real_form
from contact.averaged.overtone_march import Classes, Spectrum, Waves, overtone_march, samples
from contact.averaged.row_cycle import RowCycle
from contact.exceptions import ConvergenceError

SAMPLES, FEWEST = 4, 32  # of a cycle: for each harmonic, and at least


class OvertoneCycle(RowCycle):
    """Contacts and the amplitudes U_1 ... U_N of the driving wave, shape (m, N), and U_1 of the opposing, (m, 1)."""

    def __init__(self, slider, wave, loads: bool, harmonics: int):
        self.forward_drives = abs(wave.forward) >= abs(wave.backward)
        # `super().__init__` calls `reset`, which needs the attributes up to there
        self.downstream = slice(None) if self.forward_drives else slice(None, None, -1)
        self.numbers, self.harmonics = np.arange(harmonics) + 1, harmonics
        self.samples = samples(harmonics, max(SAMPLES * harmonics, FEWEST))
        super().__init__(slider, wave, loads)
        behind = np.append(self.first[1:], self.x.size)
        self.contacts = Classes(
            np.ascontiguousarray(self.first[self.downstream]), np.ascontiguousarray(behind[self.downstream]),
            self.weight, self.k_n, self.k_t, self.limit_slope,
        )  # fmt: skip
        self.downstream_turn = np.ascontiguousarray(
            (self.turn if self.forward_drives else self.turn.conj())[self.downstream]
        )
        self.downstream_orbit = np.array([self.driving_orbit])

    def begin(self, forward, backward):
        """Take the amplitudes at the rows from a search with any number of harmonics."""
        self.reset()
        for own, values in ((self.forward, forward), (self.backward, backward)):
            values = values.reshape(len(values), -1)
            shared = min(own.shape[1], values.shape[1])
            own[:, :shared] = values[:, :shared]

    def reset(self):
        """Let the wave pass as if nothing touched it."""
        super().reset()
        m, n = self.turn.size, self.harmonics
        driving, opposing = np.zeros((m, n), complex), np.zeros((m, 1), complex)
        self.spectrum = Spectrum(driving.copy(), opposing.copy(), np.zeros((m, 2, n), complex))
        fundamental = self.forward, self.backward
        self.forward, self.backward = (driving, opposing) if self.forward_drives else (opposing, driving)
        self.forward[:, 0], self.backward[:, 0] = fundamental

    def _driving_and_opposing(self):
        """Return the amplitudes of the driving and of the opposing wave."""
        return (self.forward, self.backward) if self.forward_drives else (self.backward, self.forward)

    @property
    def driving_orbit(self):
        """u_x/u_z of the driving wave; that of the opposing one is its conjugate."""
        return self.wave.orbit if self.forward_drives else self.wave.orbit.conjugate()

    def amplitudes(self):
        """Return the fundamental's u_z and u_x at each row."""
        orbit, forward, backward = self.wave.orbit, self.forward[:, 0], self.backward[:, 0]
        return forward + backward, orbit * forward + orbit.conjugate() * backward

    def forces(self, approach, w: float, side: float) -> MeanForces:
        """Follow the driving wave; return the forces at mean approaches in m and a velocity over omega in m."""
        self.evaluations += 1
        spectrum, incident = self.spectrum, np.zeros(self.harmonics, complex)
        driving, opposing = self._driving_and_opposing()
        spectrum.along[:], spectrum.against[:] = driving[self.downstream], opposing[self.downstream]
        incident[0] = self.incident[0 if self.forward_drives else 1]
        out = np.zeros((len(ContactMean), self.x.size))
        waves = Waves(self.downstream_turn, self.downstream_orbit, self.g, incident)
        failed = overtone_march(
            self.contacts, waves, np.ascontiguousarray(approach), float(w), float(side), spectrum, self.samples, out
        )  # fmt: skip
        if failed:
            rule = "rows change the wave by more than their midpoint can follow"
            raise ConvergenceError("not converged", f"{failed} of {self.turn.size} {rule}")
        driving[:] = spectrum.along[self.downstream]
        return forces_of(out, self.k_n, self.k_t)

    @property
    def waves(self):
        """The amplitudes of the opposing wave."""
        return self._driving_and_opposing()[1][:, 0]

    @waves.setter
    def waves(self, values):
        self._driving_and_opposing()[1][:, 0] = values

    def wave_step(self, forces: MeanForces, _slope=None):
        """Return the step of the opposing wave towards the one that the forces leave.

        Contacts in touch are springs to it: the forces F of a row follow F_0 + S (U - U_0), where S is the sum of their
        normal stiffnesses, each times its share of the cycle. The rest shrinks by about ten times in each iteration.
        """
        column, m = (1 if self.forward_drives else 0), self.turn.size  # of the opposing wave in (U+, U-)
        normal, tangential = self.row_forces(forces)[..., 0].T
        force, amplitude = np.zeros((2, m, 2), complex)
        slope = np.zeros((m, 2, 2), complex)
        force[:, column], amplitude[:, column] = normal + self.driving_orbit * tangential, self.waves
        slope[:, column, column] = self.sums(forces.cycles[ContactMean.SHARE] * self.k_n)
        return march(self.turn, force, real_form(slope), amplitude, self.g, self.incident)[:, column] - self.waves

    def tangent(self, *_):
        """Return None: the search uses the iteration of `advance` and no Newton step."""

    def row_forces(self, _forces: MeanForces):
        """Return sum P_n and sum Q_n of the rows from left to right, shape (m, 2, N)."""
        return self.spectrum.force[self.downstream]

    def passed(self, forces: MeanForces):
        """Return U+ behind each row and U- before it, shape (2, m, N); the opposing wave has no overtones."""
        amplitudes = super().passed(forces)
        amplitudes[1 if self.forward_drives else 0, :, 1:] = 0.0
        return amplitudes

    def radiated(self, g: float, approach, w: float, side: float) -> complex:
        """Return the complex amplitude in m of the highest overtone that leaves the last row.

        The contacts are moved by the unloaded wave and radiate into it with the compliance `g`.
        """
        forces = self.forces(approach, w, side)
        self.g = g  # switched on only now: the forces above must not load the wave
        amplitudes = self.passed(forces)
        return complex(amplitudes[0, -1, -1] if self.forward_drives else amplitudes[1, 0, -1])

    def work(self, forces: MeanForces):
        """Return the complex powers over omega of P and Q of the surface on each row, in each harmonic."""
        force, (u_z, u_x) = self.row_forces(forces), self.amplitudes()
        overtones = self._driving_and_opposing()[0][:, 1:]
        u_z = np.concatenate([u_z[:, None], overtones], axis=1)
        u_x = np.concatenate([u_x[:, None], self.driving_orbit * overtones], axis=1)
        return 0.5 * self.numbers * np.stack([force[:, 0] * u_z.conj(), force[:, 1] * u_x.conj()])
