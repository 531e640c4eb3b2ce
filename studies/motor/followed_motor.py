r"""A motor integrated through every cycle of the wave in fixed steps: the reference of the averaged motor.

Model: the equations that `contact` solves, without averaging,

    m z_s'' = sum P_i - preload - d_n z_s',   z_i = u_z,i - z_s,   P_i = K z_i^e (1 + chi z_i') where z_i > 0
    m V'    = sum Q_i - d_t V + F,            x_i' = u_x,i' - V,    |x_i| <= c z_i,   Q_i of Cattaneo and Mindlin

(signs as in `studies.export.reduced_motor`).  u_i = Re(sum_d e_d(t) U_i,d exp(i omega t)): each drive's envelope e_d
follows from the step response of the surface under the slider, so that waves grow, fade and overlap.  At time 0 the
first drive's u_z of the first contact passes zero upwards.

Integration: Verlet's method with the deformation cut to its limit, `STEPS` per cycle of the wave; without a wave,
`REST_STEPS` per period of the contact's fastest ring.  It shares no code with the solvers of `contact`.  Error against
`contact.step`: 1e-5 of a step and 5e-3 nm (tests/studies/test_positioning.py).
"""

import numpy as np

from contact.jit.compiled import compiled
from studies.export import reduced_motor as model
from studies.export.motor_model import AveragedMotor
from studies.export.reduced_motor import index

# steps per cycle of the wave; error over 10 um of twente and back: 0.006 nm, with 800 steps 0.02, with 400 0.3 nm
STEPS = 1600
REST_STEPS = 1000  # steps per period of the ring; differs by 1e-3 nm from 4000 steps
NODES = 8  # nodes of the envelopes per cycle, with linear interpolation
# indices of z_s, z_s', V, position along x, and of the first contact deformation
HEIGHT, NORMAL_VELOCITY, VELOCITY, POSITION, DEFORMATION = range(5)


class FollowedMotor:
    """A motor that starts at rest, with the interface of `studies.export.motor_model.MotorState`."""

    def __init__(self, motor: AveragedMotor, *, force: float = 0.0, preload: float | None = None, steps: int = STEPS):
        drives, slider = motor.drives, motor.slider
        self.motor, self.time, self.steps = motor, 0.0, steps
        self.omega = drives[0].orbits[0].omega
        start = np.exp(-1j * (0.5 * np.pi + np.angle(drives[0].orbits[0].normal)))
        self.normal = start * np.array([[each.normal for each in drive.orbits] for drive in drives])
        self.tangential = start * np.array([[each.tangential for each in drive.orbits] for drive in drives])
        contacts = len(drives[0].orbits)
        ring = max(slider.normal_resonance(contacts), slider.tangential_resonance(contacts))  # Hz
        self.rest_step = 1.0 / (REST_STEPS * ring)
        self.changes: list[list[tuple[float, float]]] = [[] for _ in drives]  # (time, change of the level)
        self.levels = [0.0] * len(drives)
        at_rest = motor.start(force=force, preload=preload)
        strain = np.full(contacts, at_rest.deformation)
        self.state = np.concatenate([[-at_rest.numbers[index.APPROACH], 0.0, 0.0, 0.0], strain])

    position = property(lambda self: float(self.state[POSITION]))
    velocity = property(lambda self: float(self.state[VELOCITY]))
    deformation = property(lambda self: float(np.mean(self.state[DEFORMATION:])))

    def advance(self, duration: float, level: float, *, force: float = 0.0, preload: float | None = None) -> None:
        """Integrate over a duration in s with constant inputs, as `MotorState.advance`."""
        if duration <= 0.0:
            return
        motor, p = self.motor, self.motor.parameters
        # a positive level drives the first drive, a negative one the second
        for drive, new in enumerate((level, -level)[: len(motor.drives)]):
            change = max(new, 0.0) - self.levels[drive]
            if change:
                self.changes[drive].append((self.time, change))
                self.levels[drive] = max(new, 0.0)
        count = max(2, 1 + round(NODES * duration * self.omega / (2.0 * np.pi)))
        at = self.time + np.linspace(0.0, duration, count)
        envelopes = np.array([self._envelope(drive, at) for drive in range(len(motor.drives))])
        waves = np.any(envelopes, axis=1)
        longest = 2.0 * np.pi / (self.omega * self.steps) if np.any(waves) else self.rest_step
        preload = motor.preload if preload is None else preload
        # the integrated slider is `motor.slider`; forces on the real one are `motor.share` times as large
        follow(
            p, self.state, self.normal[waves], self.tangential[waves], envelopes[waves], self.omega, self.time,
            np.array([duration, longest, force / motor.share, preload / motor.share]),
        )  # fmt: skip
        self.time += duration

    def _envelope(self, drive: int, at: np.ndarray) -> np.ndarray:
        """Return the complex factors on the orbits of a drive at times in s, the present one or later."""
        response, step = self.motor.drives[drive].response, self.motor.drives[drive].response_step
        if response is None:
            return np.full(at.size, self.levels[drive], complex)
        total, unsettled = np.zeros(at.size, complex), []
        settled = self.levels[drive] - sum(change for _, change in self.changes[drive])
        nodes = step * np.arange(len(response))
        for time, change in self.changes[drive]:
            if at[0] - time >= nodes[-1]:
                settled += change
            else:
                total += change * np.interp(at - time, nodes, response)
                unsettled.append((time, change))
        self.changes[drive] = unsettled
        return total + (settled if unsettled else self.levels[drive])


@compiled
def follow(p, state, normal, tangential, envelopes, omega, time, inputs):
    """Integrate a state; ``inputs`` are duration and longest step in s, force along +x and preload in N."""
    duration, longest, force, preload = inputs
    steps = int(np.ceil(duration / longest * (1.0 - 1e-12)))
    h = duration / steps
    drives, contacts = normal.shape
    nodes = envelopes.shape[1]
    stiffness, exponent = p[index.STIFFNESS] / contacts, p[index.EXPONENT]
    mass, friction, c = p[index.MASS], p[index.FRICTION], p[index.LIMIT_SLOPE]
    # values of the previous step: approach, u_x, rates of approach and deformation
    before = np.zeros((4, contacts))
    normal_acceleration, acceleration = 0.0, 0.0
    phase, rotation = np.exp(1j * omega * time), np.exp(1j * omega * h)
    for k in range(steps + 1):
        at = k * (nodes - 1) / steps
        node = min(int(at), nodes - 2)
        if k > 0:
            phase *= rotation
            state[NORMAL_VELOCITY] += 0.5 * h * normal_acceleration
            state[VELOCITY] += 0.5 * h * acceleration
            state[HEIGHT] += h * state[NORMAL_VELOCITY]
            state[POSITION] += h * state[VELOCITY]
        total, drag = 0.0, 0.0
        for i in range(contacts):
            u_z, u_x, rate_z, rate_x = 0.0, 0.0, -state[NORMAL_VELOCITY], -state[VELOCITY]
            for d in range(drives):
                e = phase * (envelopes[d, node] + (at - node) * (envelopes[d, node + 1] - envelopes[d, node]))
                z_part, x_part = e * normal[d, i], e * tangential[d, i]
                u_z += z_part.real
                u_x += x_part.real
                rate_z -= omega * z_part.imag
                rate_x -= omega * x_part.imag
            z, z_old = u_z - state[HEIGHT], before[0, i]
            x = state[DEFORMATION + i]
            if k > 0:
                moved = u_x - before[1, i] - h * state[VELOCITY]
                if z_old <= 0.0:  # contact begins within the step
                    x += moved * max(z, 0.0) / (z - z_old) if z > z_old else 0.0
                elif abs(x) < c * z_old:
                    x += moved
                # it slips, until the slip velocity changes its sign within the step
                else:
                    side = 1.0 if x > 0.0 else -1.0
                    first, last = side * before[3, i] - c * before[2, i], side * rate_x - c * rate_z
                    x += moved
                    if first > 0.0 > last:
                        x -= side * 0.5 * h * first * first / (first - last)
            x = min(max(x, -c * z), c * z) if z > 0.0 else 0.0
            if z > 0.0:
                load = stiffness * model.power(z, exponent)
                total += load * (1.0 + p[index.CONTACT_DAMPING] * rate_z)
                if x != 0.0:
                    drag += friction * load * model.spring_share(x / (c * z), exponent)
            state[DEFORMATION + i] = x
            before[0, i], before[1, i], before[2, i], before[3, i] = z, u_x, rate_z, rate_x
        normal_acceleration = (total - preload - p[index.NORMAL_DAMPING] * state[NORMAL_VELOCITY]) / mass
        acceleration = (drag + force - p[index.TANGENTIAL_DAMPING] * state[VELOCITY]) / mass
        if k > 0:
            state[NORMAL_VELOCITY] += 0.5 * h * normal_acceleration
            state[VELOCITY] += 0.5 * h * acceleration
