"""Extreme cases of the whole chain: the scene of a small motor with one key set to extreme values.

The motor has a plate of hard PZT of 9 x 0.7 mm, one transducer of two finger pairs, the slider of Feenstra and
Breedveld and two voltages. The reference is either the same scene at a hundredth of the tolerance, or an equivalent
scene: a voltage divider instead of a source impedance, one ball instead of three, the mirror image, or a longer block
with absorbing ends. Errors are those of the velocity relative to max(|v|, omega |u_x| / 10).
"""

import math
from collections.abc import Callable

import numpy as np

import contact
from studies.evidence.stability.verdict import Case, Comparison, NoReference
from studies.record import Record
from studies.refusal import RunError
from studies.runs import run
from studies.scene import Scene

TOLERANCE, TIGHTER = 1e-3, (1e-5, 1e-4)
MOTOR = Scene.from_table(
    "",
    {
        "title": "a small motor",
        "stator": {"material": "PZT-8", "length": 9e-3, "thickness": 0.7e-3, "width": 0.025, "ends": "absorbing"},
        "transducer": [{"name": "left", "center": 3e-3, "finger_pairs": 2, "metallisation": 0.5, "aperture": 0.02}],
        "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [15.0, 60.0]},
        "slider": Scene.load("twente-contact").to_table()["slider"] | {"position": 6e-3},
    },
)  # fmt: skip
SIDES = tuple(
    (ends, bottom)
    for ends in ("absorbing", "free", "clamped")
    for bottom in ("free", "grounded", "clamped", "absorbing")
)
CUTS = (("LiNbO3 (Warner)", "YZ"), ("LiNbO3 (Warner)", "128YX"), ("quartz (Bechmann)", "ST-X"), ("PZT-8", "X"))
LAWS = ({"law": "hysteretic"}, {"reciprocal": True}, {"law": "hysteretic", "reciprocal": True}, {"stick_band": 1e-4})
BALLS = (("PZT-8", "Z"), ("PZT-8", "X"), ("LiNbO3 (Warner)", "YZ"))


def _key(block: str, key: str) -> Callable[[float], Scene]:
    """Return the scene as a function of the value of one key."""
    return lambda value: MOTOR.replace(**{block: {key: value}})


def _apart(distance: float) -> Scene:
    return MOTOR.replace(slider={"contacts": [-distance, 0.0, distance]})


def _at(frequency: float) -> Scene:
    """Return the scene at a frequency that its fingers are not made for."""
    return MOTOR.replace(drive={"frequency": frequency}, transducer={"left": {"period": 0.98e-3}})


def _ends(number: float) -> Scene:
    ends, bottom = SIDES[int(number)]
    return MOTOR.replace(stator={"ends": ends, "bottom": bottom})


def _cut(number: float) -> Scene:
    material, orientation = CUTS[int(number)]
    return MOTOR.replace(stator={"material": material, "orientation": orientation})


def _ball(number: float) -> Scene:
    material, orientation = BALLS[int(number)]
    moduli = {"effective_modulus": None, "tangential_modulus": None}
    return MOTOR.replace(stator={"material": material, "orientation": orientation}, slider={"ball": "steel"} | moduli)


def _third() -> Scene:
    """Return the scene of one ball with a third of the mass and of the damping."""
    slider = MOTOR.slider
    third = {name: getattr(slider.damping, name) / 3 for name in ("normal", "tangential")}
    return MOTOR.replace(slider={"mass": slider.mass / 3, "damping": third})


def _mirrored() -> Scene:
    """Return the mirror image of the scene: the transducer on the right, the slider to its left."""
    center, position = (MOTOR.stator.length - each for each in (MOTOR.transducer[0].center, MOTOR.slider.position))
    return MOTOR.replace(transducer={"left": {"center": center}}, slider={"position": position})


# quantity: unit, values, scene as a function of the value, kind of reference
VARIED: dict[str, tuple[str, tuple, Callable[[float], Scene], str]] = {
    "voltage": ("V", (0.0, 1e-9, 1e-3, 7.0, 300.0, 1e3, 1e6), _key("drive", "voltage"), "tighter"),
    "source impedance": ("ohm", (1e-9, 50.0, 1e4, 1e9), _key("drive", "source_impedance"), "divider"),
    "load": ("N", (1e-9, 1e-6, 1e-5, 1e-3, 1.0), _key("slider", "load"), "tighter"),
    "three contacts": ("", (3.0,), lambda _: MOTOR.replace(slider={"contacts": 3}), "third"),
    "three contacts apart": ("m", (1e-12, 1e-6, 3e-4, 1.5e-3), _apart, "tighter"),
    "mirror image": ("", (1.0,), lambda _: _mirrored(), "mirror"),
    "length": ("m", (0.1, 10.0, 1e4), _key("stator", "length"), "same"),
    "ends and bottom": ("", tuple(range(len(SIDES))), _ends, "tighter"),
    "cut": ("", tuple(range(len(CUTS))), _cut, "tighter"),
    "ball of steel on a cut": ("", tuple(range(len(BALLS))), _ball, "tighter"),
    "contact law": ("", tuple(range(len(LAWS))), lambda v: MOTOR.replace(slider=LAWS[int(v)]), "tighter"),
    "position": ("m", (0.0, 1e-4, 2.9e-3, 4.1e-3, 9e-3), _key("slider", "position"), "tighter"),
    "burst": ("s", (1e-6, 2e-5), _key("drive", "burst"), "tighter"),
    "tolerance": ("", (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), lambda _: MOTOR, "tighter"),
    "thickness": ("m", (1e-6, 0.2, 1e6), _key("stator", "thickness"), "tighter"),
    "frequency": ("Hz", (1e3, 2.2e5, 8e6), _at, "tighter"),
}


def compared(case: Case, tolerance: float) -> Comparison:
    """Return error, estimate and status of a case."""
    _, _, scene_of, reference = VARIED[case.varied]
    scene = scene_of(case.value)
    record = run(scene, tolerance=tolerance)
    if record.shortfall:
        raise NoReference(f"not computed, because the answer itself is flagged: {record.shortfall}")
    return *_worst(record, _reference_velocities(reference, scene, tolerance)), True


def _reference_velocities(reference: str, scene: Scene, tolerance: float) -> np.ndarray:
    """Return the velocities of the reference in m/s."""
    if reference == "divider":
        admittance = _tighter(MOTOR, tolerance).electrical.admittance_S
        share = 1 / abs(1 + scene.drive.source_impedance * admittance)
        scene = MOTOR.replace(drive={"voltage": [level * share for level in MOTOR.levels]})
    elif reference == "third":
        scene = _third()
    elif reference in ("same", "mirror"):
        scene = MOTOR
    velocity = _tighter(scene, tolerance).velocity
    return -velocity if reference == "mirror" else velocity


def _tighter(scene: Scene, tolerance: float) -> Record:
    """Return the record at a hundredth of a tolerance, or at a tenth if there is no answer."""
    reason = ""
    for finer in TIGHTER:
        try:
            record = run(scene, tolerance=tolerance * finer / TOLERANCE)
            if not record.shortfall:
                return record
            reason = record.shortfall
        except RunError as error:
            reason = str(error)
    raise NoReference(reason)


def _worst(record: Record, reference: np.ndarray) -> tuple[float, float]:
    """Return error and estimate of the point whose error exceeds twice its estimate the most."""
    omega = 2 * math.pi * record.scene.frequency
    errors = []
    for point, truth in zip(record.points, reference, strict=True):
        scale = contact.speed_scale(truth, omega * point.tangential_amplitude_m)
        difference = abs(point.velocity_m_per_s - truth)
        errors.append((difference / scale if scale > 0 else difference, point.relative_error))
    return max(errors, key=lambda pair: pair[0] - 2 * pair[1])
