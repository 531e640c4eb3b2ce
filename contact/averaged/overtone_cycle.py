"""All pillars of a slider through one cycle on a wave whose overtones they radiate.

The wave that drives is followed from row to row with its overtones (`overtone_march`); the one against it, overtones of
what is reflected included, is that of the last forces, until neither changes.
"""

import numpy as np

from contact.averaged import flat_cycle as columns
from contact.averaged.flat_cycle import COLUMNS
from contact.averaged.march import Waves
from contact.averaged.overtone_march import Classes, Spectrum, overtone_march, samples
from contact.averaged.pillar_cycle import Forces, PillarCycle
from contact.convergence import ConvergenceError

SAMPLES = (
    4  # of a cycle, for each harmonic: twice as many change the velocity by less than twice the harmonics do
)


class OvertoneCycle(PillarCycle):
    """Pillars and the wave's amplitudes with `harmonics` of them, shape (m, N), the fundamental first."""

    def __init__(self, pillars, wave, loading: bool, harmonics: int):
        self.ahead = abs(wave.forward) >= abs(wave.backward)
        self.order, self.harmonics = np.arange(harmonics) + 1, harmonics
        self.room = samples(harmonics, max(SAMPLES * harmonics, 32))
        super().__init__(pillars, wave, loading)
        way = slice(None) if self.ahead else slice(None, None, -1)
        behind = np.append(self.first[1:], self.x.size)
        self.contacts = Classes(
            np.ascontiguousarray(self.first[way]), np.ascontiguousarray(behind[way]), self.weight, self.k_n, self.k_t,
            self.limit_slope,
        )  # fmt: skip
        # of the wave that is followed, in the order in which it meets the rows
        self.met = np.ascontiguousarray((self.turn if self.ahead else self.turn.conj())[way])
        self.met_orbit = self.orbit if self.ahead else self.orbit.conj()

    def begin(self, forward, backward):
        """Take the amplitudes at the rows from a search with any number of harmonics."""
        self.reset()
        for own, given in ((self.forward, forward), (self.backward, backward)):
            given = given[:, None] if given.ndim == 1 else given
            shared = min(self.harmonics, given.shape[1])
            own[:, :shared] = given[:, :shared]

    def reset(self):
        """Let the wave pass as if nothing touched it."""
        super().reset()
        m, n = self.turn.size, self.harmonics
        self.spectrum = Spectrum(
            np.zeros((m, n), complex), np.zeros((m, n), complex), np.zeros((m, 2, n), complex),
            np.zeros((self.x.size, 2), complex),
        )  # fmt: skip
        fundamental = self.forward, self.backward
        self.forward, self.backward = np.zeros((2, m, n), complex)
        self.forward[:, 0], self.backward[:, 0] = fundamental

    def amplitudes(self):
        """Return the fundamental's u_z and u_x at each row."""
        orbit, forward, backward = self.wave.orbit, self.forward[:, 0], self.backward[:, 0]
        return forward + backward, orbit * forward + orbit.conjugate() * backward

    def forces(self, approach, w: float, side: float) -> Forces:
        """Return the forces at mean approaches in m and a velocity over omega, the wave that drives followed."""
        self.evaluations += 1
        spectrum, way = self.spectrum, slice(None) if self.ahead else slice(None, None, -1)
        driving, other = (self.forward, self.backward) if self.ahead else (self.backward, self.forward)
        spectrum.along[:], spectrum.against[:] = driving[way], other[way]
        incident = np.zeros(self.harmonics, complex)
        incident[0] = self.incident[0 if self.ahead else 1]
        out = np.empty((self.x.size, COLUMNS))
        failed = overtone_march(
            self.contacts, Waves(self.met, self.met_orbit, self.g, incident), np.ascontiguousarray(approach), float(w),
            float(side), spectrum, self.room, out,
        )  # fmt: skip
        if failed:
            rule = "the row changes the wave by more than its midpoint can follow"
            raise ConvergenceError("not converged", f"{rule}: {failed} of {self.turn.size} rows")
        driving[:] = spectrum.along[way]
        return Forces(
            out, self.k_n * out[:, columns.MEAN_APPROACH], self.k_t * out[:, columns.MEAN_STRETCH],
            self.k_n * spectrum.first[:, 0], self.k_t * spectrum.first[:, 1],
        )  # fmt: skip

    def advance(self, forces: Forces) -> float:
        """Move the wave against the driving one to what the forces leave; return its change over the incident one.

        Contacts in touch are springs to it, which turn its phase: F follows F_0 + S (U - U_0) with S the sum of their
        normal stiffnesses, each for its share of the cycle. What is left converges by sweeps, ten times per sweep.
        """
        way = slice(None, None, -1) if self.ahead else slice(None)
        other, orbit = (
            (self.backward, self.wave.orbit) if self.ahead else (self.forward, self.wave.orbit.conjugate())
        )
        turn = ((self.turn.conj() if self.ahead else self.turn)[:, None] ** self.order)[way]
        force = self._forces()[way]
        spring = 0.5j * self.g * self.sums(forces.cycles[:, columns.SHARE] * self.k_n)[way][:, None]
        # U behind a row, as it meets them, is that before it times (1 + spring)/(1 - spring) and a source; global frame
        phase = np.cumprod((1.0 + spring) / (1.0 - spring), axis=0)
        source = 1j * self.g * (force[:, 0] + orbit * force[:, 1]) - 2.0 * spring * other[way]
        source *= turn.conj() / (1.0 - spring)
        incident = np.zeros(self.harmonics, complex)
        incident[0] = self.incident[1 if self.ahead else 0]
        behind = phase * (incident + np.cumsum(source / phase, axis=0))
        before = np.concatenate([incident[None], behind[:-1]])
        step = 0.5 * (before + behind) * turn - other[way]
        other[way] += step
        return float(np.abs(step).max()) / max(self.wave.amplitude, 1e-300)

    def tangent(self, *_):
        """Return None: there is no step of Newton's, the sweeps go on."""

    def _forces(self):
        """Return sum P_n and sum Q_n of the rows from left to right, shape (m, 2, N)."""
        return self.spectrum.force[:: 1 if self.ahead else -1]

    def _jumps(self):
        """Return what each row adds to U+ and to U-, shape (2, m, N)."""
        force, orbit = self._forces(), self.wave.orbit
        turn = self.turn[:, None] ** self.order
        normal, tangential = force[:, 0], force[:, 1]
        return 1j * self.g * np.array(
            [(normal + orbit.conjugate() * tangential) / turn, (normal + orbit * tangential) * turn]
        )  # fmt: skip

    def _passed(self):
        """Return U+ behind each row and U- before it, of all harmonics."""
        incident = np.zeros((2, self.harmonics), complex)
        incident[:, 0] = self.incident
        forward, backward = self._jumps()
        return np.array(
            [incident[0] + np.cumsum(forward, axis=0), incident[1] + np.cumsum(backward[::-1], axis=0)[::-1]]
        )  # fmt: skip

    def passed(self, _forces: Forces):
        """Return U+ behind each row and U- before it, shape (2, m, N)."""
        return self._passed()

    def radiated(self, g: float, approach, w: float, side: float) -> complex:
        """Return the last overtone at the exit that contacts on the amplitudes as they stand send along with them."""
        self.forces(approach, w, side)
        self.g = g
        return complex(self._passed()[0, -1, -1] if self.ahead else self._passed()[1, 0, -1])

    def work(self, _forces: Forces):
        """Return the complex power over omega of the surface on each row and in each harmonic."""
        force, orbit = self._forces(), self.wave.orbit
        u_z, u_x = self.forward + self.backward, orbit * self.forward + orbit.conjugate() * self.backward
        return 0.5 * self.order * (force[:, 0] * u_z.conj() + force[:, 1] * u_x.conj())
