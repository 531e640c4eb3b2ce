r"""A motor integrated through every cycle of the wave in fixed steps: the reference of the averaged motor.

Model: the equations that `contact` solves, without averaging,

    m z_s'' = sum P_i - preload - d_n z_s',   z_i = u_z,i - z_s,   P_i = K z_i^e (1 + chi z_i') where z_i > 0
    m V'    = sum Q_i - d_t V + F,            x_i' = u_x,i' - V,    |x_i| <= c z_i,   Q_i of Cattaneo and Mindlin

(signs as in `studies.export.reduced_motor`).  P and Q of other balls have the table of the repulsion at rest that the
averaged motor has, P(z):

    DMT, meniscus   a constant attraction while z > 0; friction feels the repulsion alone
    JKR, Maugis     closed from z = `MAKES` until z falls through `START`; the limit is c d and Q that of Hertz with the
                    depth d of the same circle in the place of z; what the spring holds at the end is lost
    rough           layers that touch one after the other, at eta: Q = mu/c sum dP'(eta) (x - y), |x - y| <= c (z - eta)
                    (Jaeger and Ciavarella; the memory of Mindlin and Deresiewicz), or one stop with slider.law elastic

u_i = Re(sum_d e_d(t) U_i,d exp(i omega t)): each drive's envelope e_d
follows from the step response of the surface under the slider, so that waves grow, fade and overlap.  At time 0 the
first drive's u_z of the first contact passes zero upwards.

Integration: Verlet's method with the deformation cut to its limit, `STEPS` per cycle of the wave; without a wave,
`REST_STEPS` per period of the contact's fastest ring.  Where a contact that attracts closes or opens within a step, the
impulse is that of the part of the step in which it is closed (`jump`).  It shares no code with the solvers of
`contact`.  Error against `contact.step`: 1e-5 of a step and 5e-3 nm (tests/studies/test_positioning.py).
"""

import numpy as np

from contact.jit.compiled import compiled, native
from studies.export import reduced_motor as model
from studies.export.law_grid import places
from studies.export.motor_model import AveragedMotor
from studies.export.reduced_motor import index

# steps per cycle of the wave; error over 10 um of twente and back: 0.006 nm, with 800 steps 0.02, with 400 0.3 nm
STEPS = 1600
LAYERS = 257  # of a rough ball: P between them is a straight line
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
        self.layers = self._layers(contacts)
        rooms = slider.limit_slope * np.maximum(at_rest.numbers[index.APPROACH] - self.layers[0], 0.0)
        self.anchors = np.tile(np.clip(0.0, at_rest.deformation - rooms, at_rest.deformation + rooms), (contacts, 1))
        # displacement of the surface past the slider, number of layers that touch, and whether a contact is closed
        self.touching = np.tile([at_rest.deformation, float(np.count_nonzero(rooms)), 1.0], (contacts, 1))
        self.state = np.concatenate([[-at_rest.numbers[index.APPROACH], 0.0, 0.0, 0.0], strain])

    def _layers(self, contacts: int) -> np.ndarray:
        """Return eta in m and mu/c dP' in N/m of the layers of each contact, shape (2, k); none of one stop."""
        p, tables, slider = self.motor.parameters, self.motor.tables, self.motor.slider
        if p[index.SPRING] < 0.5 or slider.law != "hysteretic":
            return np.zeros((2, 0))
        z = places(LAYERS, float(p[index.DEEPEST]), float(p[index.FORCE_SCALE]))
        force = np.array([0.0, *(model.contact_force(p, tables, float(each)) for each in z[1:])]) / contacts
        weights = slider.friction_coefficient / slider.limit_slope * np.diff(np.diff(force) / np.diff(z), prepend=0.0)
        return np.ascontiguousarray([z[:-1] + p[index.START], weights])

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
            p, motor.tables, self.state, self.layers, self.anchors, self.touching, self.normal[waves],
            self.tangential[waves], envelopes[waves], self.omega, self.time,
            np.array([duration, longest, force / motor.share, preload / motor.share]),
            np.zeros((7, self.normal.shape[1])),
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
def closed_stop(p, i, x, moved, before, depth, rate_x, rate, h):
    """Return the deformation of contact i after a step, cut to its limit of c times a depth; see `follow`."""
    c, old = p[index.LIMIT_SLOPE], before[0, i]
    if old <= 0.0:  # contact begins within the step
        x += moved * max(depth, 0.0) / (depth - old) if depth > old else 0.0
    elif abs(x) < c * old:
        x += moved
    # it slips, until the slip velocity changes its sign within the step
    else:
        side = 1.0 if x > 0.0 else -1.0
        first, last = side * before[3, i] - c * before[2, i], side * rate_x - c * rate
        x += moved
        if first > 0.0 > last:
            x -= side * 0.5 * h * first * first / (first - last)
    return min(max(x, -c * depth), c * depth) if depth > 0.0 else 0.0


@compiled
def jump(h, z_before, z, edge):
    """Return the time in s by which half a step is wrong as the duration of a contact that opens or closes within it.

    The impulse of its force is that times the force. Negative: the contact is closed for less than half a step.
    """
    share = abs(edge - z_before) / abs(z - z_before)  # of the step before the contact changes
    return h * ((share - 0.5) if z < z_before else (0.5 - share))


@compiled
def layered_force(p, layers, anchors, touching, i, before, z, moved):
    """Return Q in N of the layers of contact i at an approach z, whose surface has moved past the slider in a step.

    ``before``: approach before the step, ``touching``: displacement and number of layers in contact then.
    """
    c, q, k, touched, displacement = p[index.LIMIT_SLOPE], 0.0, 0, int(touching[i, 1]), touching[i, 0] + moved
    while k < layers.shape[1] and z > layers[0, k]:
        above = z - layers[0, k]
        # a layer touches within the step
        y = anchors[i, k] if k < touched else displacement - moved * above / max(z - before, above)
        y = min(max(y, displacement - c * above), displacement + c * above)
        anchors[i, k] = y
        q += layers[1, k] * (displacement - y)
        k += 1
    touching[i, 0], touching[i, 1] = displacement, k
    return q


@native(
    "f1 f1 f1 f2 f2 f2 c2 c2 c2 f f f1 f2",
    {"layers": "2 k", "anchors": "n k", "touching": "n 3", "normal": "d n", "tangential": "d n", "envelopes": "d m",
     "inputs": "4", "before": "7 n"},
)  # fmt: skip
def follow(
    p, tables, state, layers, anchors, touching, normal, tangential, envelopes, omega, time, inputs, before,
):  # fmt: skip
    """Integrate a state; ``inputs`` are duration and longest step in s, force along +x and preload in N.

    ``before``, zero at first, holds values of the previous step for each contact: approach, or the depth of one stop,
    u_x, rates of both; approach, normal force and Q.
    """
    duration, longest, force, preload = inputs[0], inputs[1], inputs[2], inputs[3]
    steps = int(np.ceil(duration / longest * (1.0 - 1e-12)))
    h = duration / steps
    drives, contacts = normal.shape
    nodes = envelopes.shape[1]
    stiffness, exponent = p[index.STIFFNESS] / contacts, p[index.EXPONENT]
    mass, friction, c, pull = p[index.MASS], p[index.FRICTION], p[index.LIMIT_SLOPE], p[index.PULL]
    tabulated, pulls = p[index.FORCE_NODES] > 0.5, int(p[index.FIRST_DRIVE + index.PULLS])
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
        total, drag, push, pulled = 0.0, 0.0, 0.0, 0.0  # forces, and impulses of forces that jump within the step
        for i in range(contacts):
            u_z, u_x, rate_z, rate_x = 0.0, 0.0, -state[NORMAL_VELOCITY], -state[VELOCITY]
            for d in range(drives):
                e = phase * (envelopes[d, node] + (at - node) * (envelopes[d, node + 1] - envelopes[d, node]))
                z_part, x_part = e * normal[d, i], e * tangential[d, i]
                u_z += z_part.real
                u_x += x_part.real
                rate_z -= omega * z_part.imag
                rate_x -= omega * x_part.imag
            z, x = u_z - state[HEIGHT], state[DEFORMATION + i]
            moved = u_x - before[1, i] - h * state[VELOCITY] if k > 0 else 0.0
            if not tabulated:
                if k > 0:
                    x = closed_stop(p, i, x, moved, before, z, rate_x, rate_z, h)
                x = min(max(x, -c * z), c * z) if z > 0.0 else 0.0
                if k > 0 and (z > 0.0) != (before[0, i] > 0.0):
                    push -= pull * jump(h, before[0, i], z, 0.0)
                if z > 0.0:
                    load = stiffness * model.power(z, exponent)
                    total += load * (1.0 + p[index.CONTACT_DAMPING] * rate_z) - pull
                    if x != 0.0:
                        drag += friction * load * model.power_share(x / (c * z), exponent)
                before[0, i], before[2, i] = z, rate_z
            elif layers.shape[1] > 0:
                q = layered_force(p, layers, anchors, touching, i, before[4, i], z, moved)
                before[4, i] = z
                load = model.contact_force(p, tables, max(z - p[index.START], 0.0)) / contacts
                total += load * (1.0 + p[index.CONTACT_DAMPING] * rate_z)
                drag += q
                if k == steps:
                    x = model.spring_deformation(p, tables, contacts * load, contacts * q)
            else:
                deep, closed = z - p[index.START], touching[i, 2] > 0.5
                if deep <= 0.0:
                    touching[i, 2] = 0.0
                elif z >= p[index.MAKES]:
                    touching[i, 2] = 1.0
                depth, load, net, q = 0.0, 0.0, 0.0, 0.0
                if touching[i, 2] > 0.5:
                    load = model.contact_force(p, tables, deep)
                    depth = deep if p[index.SPRING] > 0.5 else model.rest_approach(p, tables, load)
                rate = (depth - before[0, i]) / h if k > 0 else rate_z
                makes = k > 0 and touching[i, 2] > 0.5 and not closed
                if makes:  # x begins at 0 within the step
                    after = (z - p[index.MAKES]) / (z - before[4, i])
                    x = moved * after
                elif k > 0:
                    x = closed_stop(p, i, x, moved, before, depth, rate_x, rate, h)
                x = min(max(x, -c * depth), c * depth) if depth > 0.0 else 0.0
                if depth > 0.0:
                    net = load * (1.0 + p[index.CONTACT_DAMPING] * rate_z) / contacts
                    if pulls >= 0:
                        net -= load * model.share_at(p, tables, pulls, deep, 0.0) / contacts
                    q = friction * load / contacts * model.spring_share(p, tables, x / (c * depth), depth)
                if makes:
                    push += net * jump(h, before[4, i], z, p[index.MAKES])
                elif k > 0 and closed and touching[i, 2] < 0.5:
                    push += before[5, i] * jump(h, before[4, i], z, p[index.START])
                    pulled += before[6, i] * jump(h, before[4, i], z, p[index.START])
                total += net
                drag += q
                before[0, i], before[2, i], before[4, i], before[5, i], before[6, i] = depth, rate, z, net, q
            state[DEFORMATION + i] = x
            before[1, i], before[3, i] = u_x, rate_x
        normal_acceleration = (total - preload - p[index.NORMAL_DAMPING] * state[NORMAL_VELOCITY]) / mass
        acceleration = (drag + force - p[index.TANGENTIAL_DAMPING] * state[VELOCITY]) / mass
        if k > 0:
            state[NORMAL_VELOCITY] += 0.5 * h * normal_acceleration + push / mass
            state[VELOCITY] += 0.5 * h * acceleration + pulled / mass
    return 0
