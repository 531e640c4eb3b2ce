"""The averaged motor of a scene: parameters and tables for `reduced_motor`, with their errors.

The tables come from `contact.mean_load` and `contact.mean_traction`, event-exact means of a cycle, on a grid of the two
ratios that the averaged equations know; the step response of the surface from `studies.chain.ring_up`.  What the model
leaves out is in ``left_out``, with its size where it is known.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

import contact
from studies.chain.bridge import DrivenContact
from studies.chain.ring_up import RingUp, switched
from studies.chain.solver_errors import answered
from studies.export import reduced_motor as model
from studies.export.reduced_motor import index
from studies.refusal import RunError, SceneError
from studies.scene import Scene
from studies.study import driven_contact

# Nodes of tau and of either side of nu: g between the nodes is within 3e-3 (at kinks) and 4e-5 (99 % of random points)
# of the exact mean, and the steady velocity of twente-contact within 5e-6 from 0.75 to 20 nm. With 361 rows 6e-4 at
# 0.75 nm, next to the threshold; with 601 and 401 columns 3e-6, and a C file twice as long.
ROWS, COLUMNS = 501, 301
SMALLEST = 1e-6  # sqrt(|nu|) next to the jump
LARGEST = 1.0 - 1e-4  # tau of the last row: beyond lies no load
PROBES = 400  # random points at which the interpolation is compared with the exact mean
MAX_STEP, FAST_STEP = 1e-5, 1e-6  # s
RING_STEPS = 30.0  # per period; 80 rings to 6e-4 of their amplitude, 15: 3e-2 (test_export_motor.py)
KICK_CYCLES = 10  # after which the start of a sudden wave is over
DEAD_BOUNCE = 1e-3  # its share in the mean force is the square of it
SETTLED = 2e-4  # of the steady amplitude: from there on the wave counts as settled
RESPONSE_STEP = 2.5e-7  # s; half of the cycle at 2 MHz
MAX_RESPONSE = 20_000  # nodes; what rings longer is taken as settled there
DIGITS = 9  # of the numbers in the tables: Python and C read the same ones


@dataclass(frozen=True, kw_only=True)
class Drive:
    """What drives the slider one way: a transducer at 1 V of its source, or a given wave of 1 m."""

    name: str  # of the transducer; "wave"
    orbits: tuple = field(repr=False)  # contact.Orbit of each contact for a level of 1
    # the surface under the slider from the drive's beginning over its steady motion, at even times; None: at once
    response: np.ndarray | None = field(default=None, repr=False)
    response_step: float = RESPONSE_STEP  # s
    settling: float = 0.0  # s to within 1 %
    power: float = 0.0  # into the transducer, W per V^2
    error: float = 0.0  # relative, of the orbits
    mirrored: bool = False  # the mirror image of the drive before it, whose tables serve

    @property
    def amplitude(self) -> float:
        """Largest |u_z| of the contacts for a level of 1, m."""
        return max(abs(orbit.normal) for orbit in self.orbits)

    def saturation(self, slider) -> float:
        """Return the slider velocity per normal amplitude beyond which friction has one direction all through."""
        fastest = max(abs(each.tangential) + slider.limit_slope * abs(each.normal) for each in self.orbits)
        return self.orbits[0].omega * fastest / self.amplitude


@dataclass(frozen=True, kw_only=True)
class AveragedMotor:
    """A motor whose slider follows the cycle means of the contact forces; what the exports and the position loop run.

    Attributes
    ----------
    scene : Scene
        As resolved.
    slider : contact.Slider
        As the contact's solvers take it: of one ball where several feel one motion.
    share : int
        Number of equal sliders that the real one stands for; forces of the real slider are so many times larger.
    drives : tuple of Drive
        The first is that of positive levels, the second, if any, that of negative ones.
    levels : tuple of float
        Of the scene, rising.
    interpolation_error : tuple of float
        Errors of the mean tangential force over mu preload at random points of the tables: largest (at kinks), and that
        which 99 % of the points keep.
    averaging_error : float
        Largest change of the steady velocity by second-order averaging over the scene's levels, relative to
        max(|v|, omega |u_x|/10).
    velocity_error : float
        Largest change of the steady velocity by the interpolation over the scene's levels, in the same sense.
    left_out : tuple of str
        What the model does without.
    """

    scene: Scene = field(repr=False)
    slider: contact.Slider = field(repr=False)
    share: int
    drives: tuple[Drive, ...]
    levels: tuple[float, ...]
    parameters: np.ndarray = field(repr=False)
    tables: np.ndarray = field(repr=False)
    interpolation_error: tuple[float, float]
    averaging_error: float
    velocity_error: float
    left_out: tuple[str, ...]

    @property
    def title(self) -> str:
        """Of the scene."""
        return self.scene.title or "untitled"

    @property
    def unit(self) -> str:
        """Unit of the level: V, or m for a given wave."""
        return "V" if self.scene.wave is None else "m"

    @property
    def preload(self) -> float:
        """Preload of the real slider, N."""
        return self.slider.preload * self.share

    @property
    def load(self) -> float:
        """Load of the scene as a force along +x on the real slider, N: against the first drive's motion."""
        return (
            -float(np.copysign(self.slider.load, push(self.slider, self.orbits_at(self.levels[-1])))) * self.share + 0.0
        )

    def orbits_at(self, level: float) -> tuple:
        """Return the contacts' orbits at a level of the first drive."""
        return tuple(orbit.scaled(level) for orbit in self.drives[0].orbits)

    def start(self, *, force: float = 0.0, preload: float | None = None) -> "MotorState":
        """Return the motor at rest; forces in N are those of the real slider."""
        state = np.zeros(index.STATE_SIZE)
        preload = self.preload if preload is None else preload
        model.begin(self.parameters, self.tables, state, preload / self.share, force / self.share)
        return MotorState(motor=self, numbers=state)


@dataclass(frozen=True, kw_only=True)
class MotorState:
    """Where a motor is; `advance` moves it on."""

    motor: AveragedMotor = field(repr=False)
    numbers: np.ndarray = field(repr=False)

    def advance(self, duration: float, level: float, *, force: float = 0.0, preload: float | None = None) -> None:
        """Move on by a duration in s under constant inputs.

        Parameters
        ----------
        level : float
            Of the drive, V or m; negative for the second drive.
        force : float
            External, along +x, N.
        preload : float, optional
            N, positive; the scene's when absent.

        Raises
        ------
        SceneError
            For a negative level without a second drive, or a preload that is not positive.
        RunError
            If the motion is not finite.
        """
        motor = self.motor
        if level < 0.0 and len(motor.drives) == 1:
            raise SceneError("level", f"must be zero or positive: nothing drives the other way, got {level!r}")
        preload = motor.preload if preload is None else preload
        if not preload > 0.0:
            raise SceneError("preload", f"must be positive, got {preload!r} N")
        inputs = float(level), force / motor.share, preload / motor.share, float(duration)
        if model.advance(motor.parameters, motor.tables, self.numbers, *inputs) != 0.0:
            raise RunError("the averaged motion is not finite: check level, force and preload")

    time = property(lambda self: float(self.numbers[index.TIME]))
    position = property(lambda self: float(self.numbers[index.POSITION]))
    velocity = property(lambda self: float(self.numbers[index.VELOCITY]))
    deformation = property(lambda self: model.deformation(self.motor.parameters, self.motor.tables, self.numbers))
    surface_amplitude = property(lambda self: float(self.numbers[index.SURFACE]))
    sticks = property(lambda self: bool(self.numbers[index.STICKS]))

    def copy(self) -> "MotorState":
        """Return a state that moves on by itself."""
        return replace(self, numbers=self.numbers.copy())


def push(slider: contact.Slider, orbits: tuple) -> float:
    """Return the mean force of the wave along +x on a slider at rest without a load, N."""
    return float(contact.mean_traction(replace(slider, load=0.0), orbits, np.zeros(1))[0])


def first_drive(
    scene: Scene, *, tolerance: float = 1e-3, progress: Callable[[str], None] = lambda text: None
) -> DrivenContact:
    """Return the contact with the scene's own drive, from which `averaged_motor` goes on.

    Raises
    ------
    SceneError, RunError
        If the scene has no slider, or the averaged motor does not take it.
    """
    if scene.on_pillars:
        rule = "must be absent: tables over two ratios do not hold heights that scatter or a wave that the slider loads"
        scene.refuse("slider.pillars", rule)
    if scene.slider is not None and scene.slider.heights:
        rule = "must be absent: the tables of the averaged motor take contacts of one height"
        scene.refuse("slider.heights", rule)
    driven = driven_contact(scene, tolerance=tolerance, progress=progress)
    if driven.slider.friction is not None:
        rule = "must be a number without a law of one's own: the tables of the averaged motor take one coefficient"
        scene.refuse("slider.friction_coefficient", rule)
    return driven


def averaged_motor(
    scene: str | Scene, *, tolerance: float = 1e-3, first: DrivenContact | None = None,
    progress: Callable[[str], None] = lambda text: None,
) -> AveragedMotor:  # fmt: skip
    """Return the averaged motor of a scene with a slider, its stator solved with each of its drives.

    Parameters
    ----------
    scene
        A path, a shipped name or a scene.  A given wave runs either way; on a stator the second drive is the only other
        transducer, if the scene has two and drives one of them.
    tolerance : float
        Of the slider velocity, for the stator.
    first : DrivenContact, optional
        The `first_drive` of the scene, where it is known.

    Raises
    ------
    SceneError, RunError
        If the scene has no slider, its contacts differ in height, or averaging does not apply to it.
    """
    scene = Scene.load(scene)
    driven = first or first_drive(scene, tolerance=tolerance, progress=progress)
    slider = driven.slider
    left_out = ["the wave is that at the initial position of the slider: its variation along the way is not included"]
    drives = [_drive(driven, progress, left_out)]
    for other in other_drives(scene):
        drives.append(_drive(driven_contact(other, tolerance=tolerance, progress=progress), progress, left_out))
    if driven.scene.wave is not None:
        opposite = tuple(orbit.mirrored() for orbit in driven.orbits)
        drives.append(replace(drives[0], name="wave from the other side", orbits=opposite, mirrored=True))
    if len(drives) == 2:
        left_out.append("where the waves of both drives overlap, only the larger one counts")
    left_out += [
        "below the threshold, sticking contacts have the stiffness of a surface at rest, also with a wave",
        f"a slider that has stopped rings in its contacts at up to {ring_speed(slider, len(driven.orbits)):.2g} m/s; "
        "the phase of the ring is lost within about 10 ms, so that the velocity at the start of a later burst may be "
        "wrong by up to twice that",
    ]
    progress("tables of mean forces")
    with answered():
        tables = [None if drive.mirrored else _tables(slider, drive) for drive in drives]
        known = _steady(slider, drives[0], driven.levels)
    averaging = max((abs(second - first) / scale for _, second, first, scale in known), default=0.0)
    parameters, flat = _packed(slider, drives, tables)
    motor = AveragedMotor(
        scene=driven.scene, slider=slider,
        share=driven.scene.slider.share,
        drives=tuple(drives), levels=driven.levels,
        parameters=parameters, tables=flat, interpolation_error=(0.0, 0.0), averaging_error=averaging,
        velocity_error=0.0,
        left_out=tuple(dict.fromkeys(left_out)),
    )  # fmt: skip
    if drives[0].response is None:
        kick = _kick(motor, [level for level, *_ in known])
        left_out.append(
            f"the sudden start of a wave changes the velocity by up to {kick:.1e} m/s, depending on its phase: "
            "not included"
        )
    return replace(
        motor,
        left_out=tuple(dict.fromkeys(left_out)),
        interpolation_error=_interpolation_error(motor),
        velocity_error=_velocity_error(motor, known),
    )


def other_drives(scene: Scene) -> list[Scene]:
    """Return the scene with its other transducer driven, where there is just one other."""
    if scene.wave is not None or scene.crossed or scene.drive.sources is not None or len(scene.transducer) != 2:
        return []
    name = scene.drive.transducer or scene.driven_transducer.name
    (other,) = (each for each in scene.transducer if each.name != name)
    return [replace(scene, drive=replace(scene.drive, transducer=other.name))] if other.has_two_combs else []


def _drive(driven: DrivenContact, progress, left_out: list) -> Drive:
    if driven.scene.wave is not None:
        return Drive(name="wave", orbits=driven.orbits)
    record, (ringing, reason) = driven.record, switched(driven, progress=progress)
    if reason:
        left_out.append(f"the wave follows its drive at once, because {reason}")
    response, settling = (None, 0.0) if ringing is None else _step_response(ringing)
    return Drive(
        name=driven.scene.driven_transducer.name, orbits=driven.orbits, response=response, settling=settling,
        power=float(record.electrical["power_W_per_V2"]), error=float(driven.stator_error),
    )  # fmt: skip


def _step_response(ringing: RingUp) -> tuple[np.ndarray, float]:
    """Return the surface's factor at even times from a drive's beginning, and when it stays within 1 %, s."""
    settling = float(ringing.response.settling)
    longest = min(MAX_RESPONSE * RESPONSE_STEP, 20.0 * settling)
    envelope = ringing.lasting(2.0 * longest).envelope
    at = np.arange(0.0, longest, RESPONSE_STEP)
    factor = envelope.at(at)
    away = np.flatnonzero(abs(factor - 1.0) > SETTLED)
    nodes = min(int(away[-1]) + 3 if away.size else 2, len(at))
    factor = factor[: max(nodes, 2)]
    factor[-1] = 1.0
    return factor, settling


def _tables(slider, drive: Drive) -> tuple[np.ndarray, np.ndarray]:
    """Return R over tau, shape (ROWS,), and g over side, tau and sqrt|nu|, shape (2, ROWS, COLUMNS)."""
    taus = np.linspace(0.0, 1.0, ROWS)
    loads, forces = np.zeros(ROWS), np.zeros((2, ROWS, COLUMNS))
    loads[0], forces[0, 0], forces[1, 0] = 1.0, 1.0, -1.0  # tau = 0: no wave, friction has one direction
    sizes = np.linspace(0.0, 1.0, COLUMNS)
    for k in range(1, ROWS):
        loads[k], forces[:, k] = mean_forces(slider, drive, min(taus[k], LARGEST), sizes)
    loads[-1] = 0.0  # tau = 1: the wave no longer reaches the slider
    return loads, forces


def mean_forces(slider, drive: Drive, tau: float, sizes: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the exact R and g, shape (2, k), at a ratio tau and at sqrt(|nu|) of either side.

    The ratios fix both, so any amplitude serves: that of the drive at a level of 1.  The slider is made heavy: its mass
    does not enter the means, and averaging asks for a slow bounce.
    """
    size = drive.amplitude
    height = ((1.0 / tau - 1.0) ** 2 - 1.0) * size  # tau = sqrt(s)/(sqrt(s) + sqrt(h + s)) solved for h
    loads = [contact.mean_load(height, abs(orbit.normal), slider.contact_shape) for orbit in drive.orbits]
    preload = slider.normal_stiffness * sum(loads)
    exponent = 1.5 if slider.shape == "sphere" else 1.0
    share = sum(loads) / (len(loads) * (height + size) ** exponent)
    heavy = replace(slider, preload=preload, load=0.0, mass=1e30 * preload * size, tangential_damping=0.0,
                    normal_damping=0.0, contact_damping=0.0)  # fmt: skip
    nu = np.maximum(sizes, SMALLEST) ** 2
    speeds = np.concatenate([-nu, nu]) * drive.saturation(slider) * size
    forces = contact.mean_traction(heavy, drive.orbits, speeds).reshape(2, -1)
    return share, forces / (slider.friction_coefficient * preload)


def _packed(slider, drives, tables) -> tuple[np.ndarray, np.ndarray]:
    """Return parameters and tables as the model reads them."""
    p = np.zeros(index.FIRST_DRIVE + 2 * index.DRIVE_SIZE)
    contacts = len(drives[0].orbits)
    p[index.MASS], p[index.NORMAL_DAMPING] = slider.mass, slider.normal_damping
    p[index.TANGENTIAL_DAMPING], p[index.CONTACT_DAMPING] = slider.tangential_damping, slider.contact_damping
    p[index.FRICTION], p[index.LIMIT_SLOPE] = slider.friction_coefficient, slider.limit_slope
    p[index.STIFFNESS] = slider.normal_stiffness * contacts
    p[index.EXPONENT] = 1.5 if slider.shape == "sphere" else 1.0
    p[index.TAU_NODES], p[index.NU_NODES], p[index.DRIVES] = ROWS, COLUMNS, len(drives)
    fastest = max(slider.normal_resonance(contacts), slider.tangential_resonance(contacts))
    p[index.MAX_STEP], p[index.FAST_STEP] = MAX_STEP, min(FAST_STEP, 1.0 / (100.0 * fastest))
    p[index.RING_STEP] = min(MAX_STEP, 1.0 / (RING_STEPS * fastest))
    p[index.DEAD_BOUNCE] = DEAD_BOUNCE
    parts, length = [], 0
    for number, (drive, table) in enumerate(zip(drives, tables, strict=True)):
        own = index.FIRST_DRIVE + number * index.DRIVE_SIZE
        p[own + index.AMPLITUDE], p[own + index.SATURATION] = drive.amplitude, drive.saturation(slider)
        p[own + index.POWER], p[own + index.RESPONSE_STEP] = drive.power, drive.response_step
        p[own + index.FACING] = -1.0 if drive.mirrored else 1.0
        if table is None:  # all places and numbers of the first but the sign
            first = index.FIRST_DRIVE
            p[own : own + index.FACING] = p[first : first + index.FACING]
            continue
        pieces = {index.LOADS: table[0], index.FORCES: table[1].ravel()}
        if drive.response is not None:
            p[own + index.RESPONSE_NODES] = len(drive.response)
            pieces[index.RESPONSE] = np.ascontiguousarray(drive.response).view(float)
        for place, piece in pieces.items():
            p[own + place] = length
            parts.append(piece)
            length += piece.size
    rounded = [float(f"{value:.{DIGITS}g}") for value in np.concatenate(parts)]
    return p, np.array(rounded)


def _steady(slider, drive: Drive, levels) -> list[tuple[float, float, float, float]]:
    """Return level, steady velocity of second and of first order, and max(|v|, omega |u_x|/10), where it moves."""
    known = []
    for level in levels:
        orbits = tuple(orbit.scaled(level) for orbit in drive.orbits)
        try:
            mean = contact.mean_motion(slider, orbits)
        except contact.ConvergenceError as error:
            if error.status != "near the threshold":
                raise
            continue  # held, or too slow to judge the tables by
        scale = contact.reference_speed(float(mean.velocity), orbits)
        if not mean.held:
            known.append((level, float(mean.velocity), float(mean.first_order), scale))
    return known


def ring_speed(slider, contacts: int) -> float:
    """Return the largest velocity in m/s of a slider that rings in contacts which stick on a surface at rest.

    The energy that the contacts hold at the limit of slip, e/(e + 1) mu P x_max with x_max = c z and e = 3/2 for
    spheres, 1 for flat punches, becomes kinetic energy m v^2/2.
    """
    exponent = 1.5 if slider.shape == "sphere" else 1.0
    energy = slider.friction_coefficient * slider.preload * slider.limit_slope * slider.rest_approach(contacts)
    return float(np.sqrt(2.0 * exponent / (exponent + 1.0) * energy / slider.mass))


def _kick(motor: AveragedMotor, levels) -> float:
    """Return how far the motor is from the exact contact after the first cycles of a sudden wave, m/s."""
    worst = 0.0
    for level in {*levels[:1], *levels[-1:]}:
        orbits = motor.orbits_at(level)
        duration = KICK_CYCLES / orbits[0].frequency
        truth = contact.burst(
            motor.slider, orbits, duration=duration, after=0.0, tolerance=1e-6, samples=2, method="exact"
        )
        state = motor.start(force=motor.load)
        state.advance(duration, level, force=motor.load)
        worst = max(worst, abs(truth.velocity_at_burst_end - state.velocity))
    return worst


def _velocity_error(motor: AveragedMotor, known) -> float:
    """Return what the tables change of the steady velocity of first order, the largest of some levels."""
    p, worst = motor.parameters, 0.0
    for level, _, first, scale in known:
        size = level * motor.drives[0].amplitude
        height = model.riding(p, motor.tables, 0, size, motor.slider.preload)
        nearby = first + 1e-4 * scale * np.array([-1.0, 0.0, 1.0])
        low, here, high = (
            model.slip_force(p, motor.tables, 0, height, size, motor.slider.preload, v)
            - motor.slider.tangential_damping * v
            for v in nearby
        )
        load = -float(np.copysign(motor.slider.load, first)) if motor.slider.load else 0.0
        worst = max(worst, abs((here + load) / (high - low)) * 2e-4)
    return worst


def _interpolation_error(motor: AveragedMotor) -> tuple[float, float]:
    """Return the largest error of g at random points between the nodes, and the error that 99 % of them keep."""
    random, errors = np.random.default_rng(1), []
    for number, drive in enumerate(motor.drives):
        for _ in range(PROBES):
            tau, size = random.uniform(0.05, 0.9), random.uniform(0.0, 1.0)
            _, exact = mean_forces(motor.slider, drive, tau, np.array([size]))
            for side in (0, 1):
                read = model.traction_share(motor.parameters, motor.tables, number, tau, side, size)
                errors.append(abs(read - exact[side, 0]))
    return float(max(errors)), float(np.quantile(errors, 0.99))
