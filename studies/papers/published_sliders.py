"""Published motors with silicon sliders in the model of pillars on a wave that they load.

No source gives the number of pillars, the scatter of their heights or the slider's mass: every combination of usual
values is computed and makes the band. Sources as their authors name them: M. K. Kurosawa and K. Asai's 10 MHz motor;
the reports of KAKEN 22360101 and 15H03943; T. Shigematsu, M. K. Kurosawa and K. Asai, IEEE Trans. UFFC 50 (2003) 376;
T. Shigematsu and M. K. Kurosawa, *Friction drive of an SAW motor, Part I*, IEEE Trans. UFFC (2008), abstract, who saw
the slider's own face move; R. Takasaki's thrust is predicted with the texture that this motion fits.

What keeps that prediction wide, each alone: the preload of Takasaki's motor, which no source at hand states (30 to 100
N move the thrust 2.4 times), the friction coefficient (0.1 to 0.3: 1.8 times) and the last digit of the face's 10 nm
(9.5 to 10 nm: 1.6 times), for from a scatter of 80 to 150 nm the face moves by 9.7 to 10.2 nm. Its tangential motion
does not narrow the friction: the published 10 nm ask for more than 0.3 (6.6 nm there, 2.7 nm at 0.1), the delay of at
most 60 degrees for at most 0.1. The authors' own model had this difficulty: "the friction coefficient drastically
changes the tangential displacement" (Part III, IEEE Trans. UFFC 55 (2008), abstract). With one preload for both, 1.1
m/s and 6.4 to 8 N together ask for a friction of 0.1, a face of 9.5 nm and 139 N (6.9 N); with 0.18 the slider of 1.1
m/s has 2.2 to 5 N.
"""

import math
from functools import cache

import numpy as np
from scipy.optimize import brentq

import contact
import fem
from studies.solve.face_motion import face_motion, foot_compliances

SURFACE, MATERIAL = "open", "LiNbO3 (Kovacs)"
STIFFNESS = 1.8e6, 1.52e6  # N/m, normal and tangential: a silicon pillar of 20 um x 2 um on 128YX
LENGTH = 4e-3  # m, of Kurosawa's slider, along and across
FRICTION, STEP_FREQUENCY, STEP_PRELOAD = 0.18, 9.6e6, 30.0  # of the silicon slider that makes a step; Hz, N
CLASSES = 32  # of the normal distribution of the heights, equally likely
ROWS = 50  # of pillars, along the slider
PILLAR_RADIUS = 10e-6  # m
TEXTURE, REACH = 64, 3.5  # classes of a rough texture, and standard deviations up to which they reach
SCATTERS = 5e-9, 150e-9  # m, between which a texture is sought


def wave(*, frequency: float, amplitude: float, width: float):
    """Return the `contact.PassingWave` of 128YX in a strip."""
    solid = fem.rotated(fem.material(MATERIAL), "128YX")
    half_space = fem.rayleigh(solid, SURFACE)
    return contact.PassingWave(
        frequency=frequency, wavelength=half_space.velocity / frequency, ratio=half_space.surface_ratio,
        forward=amplitude, compliance=fem.wave_compliance(solid, SURFACE), strip_width=width,
    )  # fmt: skip


def slider(*, friction: float, scatter: float, number: float, preload: float, length: float = LENGTH):
    """Return `contact.Pillars` whose heights are a normal distribution in each row."""
    from scipy.special import ndtri

    heights = scatter * ndtri((np.arange(CLASSES) + 0.5) / CLASSES)
    positions = ((np.arange(ROWS) + 0.5) / ROWS - 0.5) * length
    return contact.Pillars(
        x=np.repeat(positions, CLASSES), y=np.zeros(ROWS * CLASSES), heights=np.tile(heights, ROWS),
        weights=number / (ROWS * CLASSES), normal_stiffness=STIFFNESS[0], tangential_stiffness=STIFFNESS[1],
        friction_coefficient=friction, preload=preload,
    )  # fmt: skip


def wave_power(width: float) -> float:
    """Return the power in W of a wave of 40 nm at 10 MHz in a beam of a width in m."""
    passing = wave(frequency=10e6, amplitude=40e-9, width=width)
    return passing.power(passing.forward)


def kurosawa_speed(case: dict) -> float:
    """Return the speed of the 10 MHz motor in m/s; 0 if the slider stays at rest.

    ``case``: ``amplitude`` of the wave (m, peak), ``friction``, ``scatter`` (m) and ``number`` of the pillars,
    ``preload`` (N).
    """
    return abs(contact.pillar_motion(*_kurosawa(case)).velocity)


def kurosawa_stall(case: dict) -> float:
    """Return the stall force of the 10 MHz motor in N; 0 if the slider stays at rest.

    ``case`` is that of `kurosawa_speed`.
    """
    return _stall(*_kurosawa(case))


def _stall(body, passing) -> float:
    try:
        return contact.pillar_load_line(body, passing, points=2).stall
    except contact.ConvergenceError as error:
        if error.status != "not applicable":
            raise
        return 0.0


def _kurosawa(case: dict) -> tuple:
    """Return pillars and wave of the 10 MHz motor."""
    passing = wave(frequency=10e6, amplitude=case["amplitude"], width=LENGTH)
    names = ("friction", "scatter", "number", "preload")
    return slider(**{name: case[name] for name in names}), passing


def textured(*, friction: float, scatter: float, number: float, preload: float):
    """Return `contact.Pillars` of silicon whose heights scatter far beyond the wave's amplitude.

    Classes at equal distances resolve the few highest pillars, which carry all; those of `slider` are equally likely.
    """
    steps = np.linspace(-REACH, REACH, TEXTURE)
    share = np.exp(-0.5 * steps**2)
    positions = ((np.arange(ROWS) + 0.5) / ROWS - 0.5) * LENGTH
    return contact.Pillars(
        x=np.repeat(positions, TEXTURE), y=np.zeros(ROWS * TEXTURE), heights=np.tile(scatter * steps, ROWS),
        weights=np.tile(number / ROWS * share / share.sum(), ROWS), normal_stiffness=STIFFNESS[0],
        tangential_stiffness=STIFFNESS[1], friction_coefficient=friction, preload=preload,
    )  # fmt: skip


@cache
def _face(friction: float, scatter: float, number: float) -> tuple[float, float, float]:
    """Return the motion of the face at 15 N on a wave of 20 nm and 9.61 MHz: amplitudes in m, delay in degrees."""
    body = textured(friction=friction, scatter=scatter, number=number, preload=15.0)
    state = contact.pillar_motion(body, wave(frequency=9.61e6, amplitude=20e-9, width=LENGTH))
    feet = foot_compliances(fem.material("silicon"), PILLAR_RADIUS)[:, None]
    return face_motion(state.forces, np.asarray(body.weights), math.inf, feet)


def face_normal(case: dict) -> float:
    """Return the normal amplitude of the face in m; ``case``: ``friction``, ``scatter`` (m) and ``number``."""
    return _face(case["friction"], case["scatter"], case["number"])[0]


def face_tangential(case: dict) -> float:
    """Return the tangential amplitude of the face in m; ``case`` as for `face_normal`."""
    return _face(case["friction"], case["scatter"], case["number"])[1]


def face_delay(case: dict) -> float:
    """Return the size of the delay of the tangential motion in degrees, up to 90; ``case`` as for `face_normal`.

    The abstract has no convention of signs: a motion that lags by 120 degrees leads by 60 where its axis is turned.
    """
    delay = abs(_face(case["friction"], case["scatter"], case["number"])[2])
    return min(delay, 180.0 - delay)


@cache
def fitted_scatter(face: float, friction: float, number: float) -> float:
    """Return the scatter of the heights in m with which the face moves normally by ``face`` in m; see `face_normal`."""

    def left(scatter):
        return _face(friction, float(scatter), number)[0] - face

    low, high = SCATTERS
    return float(brentq(left, low, high, xtol=1e-10)) if left(low) * left(high) < 0.0 else high


def _of_texture(case: dict) -> tuple:
    scatter = fitted_scatter(case["face"], case["friction"], case["number"])
    body = textured(**{name: case[name] for name in ("friction", "number", "preload")}, scatter=scatter)
    return body, wave(frequency=10e6, amplitude=case["amplitude"], width=LENGTH)


def textured_speed(case: dict) -> float:
    """Return the speed in m/s of a slider whose texture is fitted to the motion of its face.

    ``case``: ``face`` (m), ``friction``, ``number``, ``preload`` (N) and the ``amplitude`` of the wave (m).
    """
    return abs(contact.pillar_motion(*_of_texture(case)).velocity)


def textured_stall(case: dict) -> float:
    """Return the stall force of that slider in N; 0 if it stays at rest."""
    return _stall(*_of_texture(case))


def rear_amplitude(length: float) -> float:
    """Return the amplitude behind a slider over that before it, for a slider of a length in m.

    The wave has 15 nm before the slider; the contact pressure is 1.2 MPa over the slider's area, mu = 0.3, one pillar
    stands on every 40 um x 40 um, and the load is half the stall.
    """
    area = length * LENGTH
    passing = wave(frequency=9.6e6, amplitude=15e-9, width=LENGTH)
    body = slider(friction=0.3, scatter=10e-9, number=area / (40e-6) ** 2, preload=1.2e6 * area, length=length)
    stall = contact.pillar_load_line(body, passing, points=2).stall
    return abs(contact.pillar_motion(body, passing, load=0.5 * stall).exit_over_entry)


@cache
def _traction_at_rest(amplitude: float) -> float:
    """Return the force in N on the silicon slider of `shigematsu_step` at rest, on a wave of an amplitude in m."""
    body = slider(friction=FRICTION, scatter=10e-9, number=1e4, preload=STEP_PRELOAD)
    return abs(contact.pillar_traction(body, wave(frequency=STEP_FREQUENCY, amplitude=amplitude, width=LENGTH))(0.0))


def shigematsu_step(mass: float, *, cycles: int, amplitude: float) -> float:
    """Return the distance in m that a burst of a number of cycles moves a slider of a mass in kg.

    A slider that has hardly moved is driven by the tangential force at rest, so that the speed rises linearly during
    the burst. Afterwards the friction mu F, F the preload, stops it.
    """
    duration = cycles / STEP_FREQUENCY
    velocity = _traction_at_rest(amplitude) / mass * duration
    return 0.5 * velocity * duration + velocity**2 * mass / (2 * FRICTION * STEP_PRELOAD)


def crest_speed(amplitude: float, frequency: float) -> float:
    """Return the speed of the wave's crests along x, m/s."""
    ratio = wave(frequency=frequency, amplitude=amplitude, width=1.0).ratio
    return 2.0 * math.pi * frequency * abs(ratio) * amplitude
