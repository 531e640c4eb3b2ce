"""Mean forces of all contacts of a slider over one wave cycle, and the wave amplitudes at the rows of contacts.

Contacts at the same x form a row. Contacts of a row with equal height and stiffness (and equal y, if the slider tilts
about x) form a class, which is computed once with the sum of their weights. The cycle means are those of
`cycle_mean.contact_cycles`: closed for flat contacts, by quadrature for balls. In both P = k_n p(z), and Q is k_t times
a function of approach and deformation. The tangential spring of a ball does not act back on its normal motion, so that
it is not conservative: what a ball takes from the wave and gives neither to the slider nor to friction is the leak of
its law (`answers.ledger`), which may be negative.

`contact_cycles` solves contacts of one stiffness and one slip limit c. All classes are brought to that form by scaling:
with normal lengths over a unit ell and tangential lengths over c ell,

    P/(k_n p(ell))   and   Q/(c k_t p(ell))                                                                     (1)

are the forces of a contact with stiffness, mu and c equal to 1 and the normal law in units of ell, which for a power of
z is the law itself. A velocity over omega is divided by c ell. The friction power over omega, a force times a length
along the wave, has the unit (c k_t p(ell)) (c ell).

The unknown waves are U+ and U- at the rows, `forward` and `backward`; `march` states their equations.
"""

from functools import cached_property

import numpy as np

from contact import body
from contact.averaged.cycle_mean import ContactMean, MeanForces, contact_cycles, forces_of
from contact.averaged.cycle_pieces import BACKWARD, CLOSED, FORWARD, cycle_arrays
from contact.averaged.march import march, passed, real_form
from contact.averaged.riding import mean_loads, quadrature
from contact.body import Coordinates, Paths, tilted
from contact.codes import Shape, Tangential
from contact.law.elastic import coulomb
from contact.law.normal import load, plain, scaled
from contact.passing_wave import PassingWave
from contact.problem import ContactFactors, Problem
from contact.slider import Slider

STEP = 1e-7  # step of finite differences, relative to the incident amplitude
# The ratio Q_1/u_x is used as a stiffness only if |u_x| exceeds this fraction of its largest possible value.
TANGENTIAL_SHARE = 0.3
NODES = 24  # per smooth piece of a ball's cycle; errors of 1e-10 of the largest force


class RowCycle:
    """Contacts in classes and rows, with the current wave amplitudes at the rows.

    Attributes
    ----------
    g : float
        Gamma/w of `march`, 1/(Pa m); 0 if the contacts do not act back on the wave.
    turn : ndarray, shape (m,)
        Phase factor exp(-i k x) of the forward wave from the slider's centre to each row.
    incident : ndarray, shape (2,)
        U+ on the left and U- on the right of the slider, m.
    forward, backward : ndarray, shape (m,)
        Mean amplitudes u_z of the two waves on the two sides of each row, m.
    evaluations : int
        Number of cycles solved for all contacts.
    problem : Problem
        Contacts in the scaled form of equation (1); its paths are overwritten by `forces`.

    `_set_classes` adds those of classes and rows.
    """

    def __init__(self, slider: Slider, wave: PassingWave, loads: bool):
        self.slider, self.wave, self.normal = slider, wave, slider.profile
        self.g = wave.compliance_per_width if loads else 0.0
        self._set_classes(slider)
        self.turn = np.exp(-1j * wave.wavenumber * self.row_x)
        self.incident = np.array([wave.forward, wave.backward])
        self.evaluations = 0
        closed = self.normal.shape == Shape.PUNCH and self.normal.smooth
        rule = CLOSED if closed else quadrature(NODES)
        paths = Paths(*np.empty((5, self.x.size)))
        self.problem = Problem(
            stiffness=1.0, contact_damping=0.0, normal_damping=0.0, preload=1.0, tangential_damping=0.0, load=0.0,
            friction=1.0, limit_slope=1.0, stick_band=0.0, longest=1.0, normal=self.normal, paths=paths,
            factors=ContactFactors(*np.ones((2, self.x.size))), length=1.0, omega=1.0, law=coulomb(Tangential.ELASTIC),
        )  # fmt: skip
        self._rule, self._work = rule, cycle_arrays(1, max(len(rule.node), 1))
        self.reset()

    def _set_classes(self, slider: Slider):
        """Sort the contacts into classes and rows.

        Per class: `weight`, `x`, `y`, `height`, `k_n`, `k_t`, `limit_slope` and its number of the `row`; per row: the
        `first` class and `row_x`; per contact: its number in `classes`.
        """
        x, y, heights, k_n, k_t, limit_slope, weights = slider.contacts(slider.count)
        across = y if slider.tilt == "free" else np.zeros_like(y)
        member, self.classes, self.row = slider.classes(across[None])
        self.weight = np.bincount(self.classes, weights)
        self.x, self.y, self.height = x[member], across[member], heights[member]
        self.k_n, self.k_t, self.limit_slope = k_n[member], k_t[member], limit_slope[member]
        self.first = np.unique(self.row, return_index=True)[1]
        self.row_x = self.x[self.first]

    def reset(self):
        """Set the amplitudes of the undisturbed wave."""
        self.forward, self.backward = self.incident[0] * self.turn, self.incident[1] * self.turn.conj()

    def begin(self, forward, backward):
        """Set the amplitudes at the rows to those of an earlier search."""
        self.forward, self.backward = forward.copy(), backward.copy()

    def sums(self, values):
        """Return the weighted sums of values per class over each row."""
        return np.add.reduceat(self.weight * values, self.first)

    def amplitudes(self):
        """Return u_z and u_x at each row, from the mean amplitudes of its two sides."""
        orbit = self.wave.orbit
        return self.forward + self.backward, orbit * self.forward + orbit.conjugate() * self.backward

    def approaches(self, height, pitch: float, roll: float):
        """Return the mean approach of each class for a height of the plane (or one per row) and tilts in rad."""
        height_at_row = height[self.row] if np.ndim(height) else height
        plane = tilted(Coordinates(-height_at_row, 0.0), pitch, roll, self.x, self.y)
        return body.approach(self, slice(None), 0.0, plane)  # `self` stands for the paths, of which `height` is read

    def mean_normal(self, height):
        """Return <P> of each class in N and its derivative with respect to the approach in N/m, without tilt."""
        return self.mean_loads(self.approaches(height, 0.0, 0.0))

    def mean_loads(self, approach):
        """Return <P> of each class in N and its derivative in N/m at mean approaches in m."""
        (u_z, _) = self.amplitudes()
        return (self.k_n * each for each in mean_loads(approach, abs(u_z)[self.row], self.normal))

    def forces(self, approach, w: float, side: float) -> MeanForces:
        """Return the forces per class, without weights, at mean approaches in m and a velocity over omega, `w`, in m.

        At rest the forces depend on the motion before: it was towards +x or, if `side` is negative, towards -x.
        """
        self.evaluations += 1
        c, (u_z, u_x) = self.limit_slope, (each[self.row] for each in self.amplitudes())
        ell = max(float(np.max(np.abs(approach))), float(np.max(np.abs(u_z))), 1e-300)
        # the scaled problem of the module docstring; the mean approach stands for the contact's height
        paths = self.problem.paths
        np.divide(approach, ell, out=paths.height)
        np.divide(u_z.real, ell, out=paths.normal_cos)
        np.divide(-u_z.imag, ell, out=paths.normal_sin)
        np.divide(u_x.real, c * ell, out=paths.tangential_cos)
        np.divide(-u_x.imag, c * ell, out=paths.tangential_sin)
        velocities, before = float(w) / (c * ell), BACKWARD if side < 0.0 else FORWARD
        out, force = np.empty((len(ContactMean), self.x.size)), float(load(ell, self.normal))  # p(ell)
        own = plain(self.normal)  # a power of z, the same at every ell
        problem = self.problem if own else self.problem._replace(normal=scaled(self.normal, ell))
        contact_cycles(problem, 0.0, velocities, before, self._rule, self._work, out)
        out[[ContactMean.FRICTION, ContactMean.LEAK]] *= force * ell * c**2  # over k_t, m^2
        return forces_of(out, self.k_n * force, self.k_t * force * c)

    @property
    def waves(self):
        """The unknown amplitudes, complex: U+ and U- at all rows, or none if the contacts do not act on the wave."""
        return np.concatenate([self.forward, self.backward]) if self.g > 0.0 else np.empty(0, complex)

    @waves.setter
    def waves(self, values):
        self.forward, self.backward = values.reshape(2, -1)

    def wave_step(self, forces: MeanForces, slope=None):
        """Return the step of `waves` towards the amplitudes that the forces leave.

        `slope` holds the derivatives of the rows' forces from `tangent`. If it is None, the forces are taken as
        proportional to the amplitudes.
        """
        amplitude = np.stack([self.forward, self.backward], axis=1)
        slope = self._proportional(forces) if slope is None else slope
        new_amplitude = march(self.turn, self._driving(forces), slope, amplitude, self.g, self.incident)
        return (new_amplitude - amplitude).T.ravel()

    def _proportional(self, forces):
        """Return the slope for forces P_1 = s_n u_z and Q_1 = s_t u_x, which is exact for sticking contacts."""
        normal, tangential = self.row_forces(forces)[..., 0].T
        (u_z, u_x), c = self.amplitudes(), self.wave.orbit
        largest = abs(self.forward) + abs(self.backward)  # possible |u_z| of a standing wave; times |C| that of u_x
        moves = abs(u_x) > TANGENTIAL_SHARE * abs(c) * largest
        s_n = np.divide(normal, u_z, out=np.zeros_like(u_z), where=abs(u_z) > 1e-9 * largest)
        s_t = np.divide(tangential, u_x, out=np.zeros_like(u_x), where=moves)
        parts = np.stack([s_n, s_t], axis=1).view(float)
        return (parts @ self._by_stiffness).reshape(-1, 4, 4)

    @cached_property
    def _by_stiffness(self):
        """Real matrices J of `march`, (4, 16), for the real and the imaginary part of s_n and of s_t.

        J = dF/dq of F = (P_1 + C* Q_1, P_1 + C Q_1), P_1 = s_n u_z and Q_1 = s_t u_x, with u_z = q_0 + q_1 and
        u_x = C q_0 + C* q_1 in the amplitudes q = (forward, backward).
        """
        c = self.wave.orbit
        by_normal = np.ones((2, 2), complex)
        by_tangential = np.array([[abs(c) ** 2, c.conjugate() ** 2], [c**2, abs(c) ** 2]])
        return real_form(np.array([by_normal, 1j * by_normal, by_tangential, 1j * by_tangential])).reshape(4, 16)

    def tangent(self, approach, w: float, side: float, forces: MeanForces):
        """Return the derivatives of the rows' forces with respect to their amplitudes, shape (m, 4, 4); see `march`."""
        driving, size = self._driving(forces).view(float), max(self.wave.amplitude, 1e-300)
        slope = np.empty((self.turn.size, 4, 4))
        amplitudes = self.forward, self.backward
        # Column k: real and imaginary part of U+, then of U-. All rows are changed at once, because the forces of a row
        # depend on its own amplitudes only. The views alternate real and imaginary parts.
        for k, step in enumerate((STEP, 1j * STEP, STEP, 1j * STEP)):
            changed = list(amplitudes)
            changed[k // 2] = amplitudes[k // 2] + step * size
            self.forward, self.backward = changed
            changed_driving = self._driving(self.forces(approach, w, side)).view(float)
            slope[:, :, k] = (changed_driving - driving) / (STEP * size)
        self.forward, self.backward = amplitudes
        return slope

    def row_forces(self, forces: MeanForces):
        """Return sum P_n and sum Q_n of the rows from left to right, shape (m, 2, harmonics); here one harmonic."""
        return np.stack([self.sums(forces.first_normal), self.sums(forces.first_tangential)], axis=1)[..., None]

    def passed(self, forces: MeanForces):
        """Return U+ on the right and U- on the left of each row, shape (2, m, number of harmonics).

        The forces must belong to the current amplitudes.
        """
        force = self.row_forces(forces)
        return passed(self.turn, force[:, 0], force[:, 1], self.wave.orbit, self.g, self.incident)

    def work(self, forces: MeanForces):
        """Return the complex powers over omega of P and Q of the surface on each row, shape (2, m, harmonics).

        Their imaginary parts are the mean powers.
        """
        force, (u_z, u_x) = self.row_forces(forces)[..., 0], self.amplitudes()
        return 0.5 * np.stack([force[:, 0] * u_z.conj(), force[:, 1] * u_x.conj()])[..., None]

    def _driving(self, forces):
        """Return (sum P_1 + C* Q_1, sum P_1 + C Q_1) of each row, shape (m, 2)."""
        orbit = self.wave.orbit
        return self.row_forces(forces)[..., 0] @ np.array([[1.0, 1.0], [orbit.conjugate(), orbit]])
