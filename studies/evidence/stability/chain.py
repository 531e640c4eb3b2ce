"""Extreme cases of the whole chain: the scene of a small motor with one key set to extreme values.

The motor has a plate of hard PZT of 9 x 0.7 mm, one transducer of two finger pairs, the slider of Feenstra and
Breedveld and two voltages. The reference is either the same scene at a hundredth of the tolerance, or an equivalent
scene: a voltage divider instead of a source impedance, one ball instead of three, the mirror image, or a longer block
with absorbing ends. Errors are those of the velocity relative to max(|v|, omega |u_x| / 10).
"""

import math
from collections.abc import Callable
from typing import Any

import contact
from studies.chain import run
from studies.evidence.stability.case import Case, Outcome, cases_of
from studies.evidence.stability.verdict import NoWitness, judged
from studies.refusal import RunError
from studies.scene import Scene

PART = "chain"
TOLERANCE, TIGHTER = 1e-3, (1e-5, 1e-4)
SCENE: dict[str, Any] = {
    "title": "a small motor",
    "stator": {"material": "PZT-8", "length": 9e-3, "thickness": 0.7e-3, "width": 0.025, "ends": "absorbing"},
    "transducer": [{"name": "left", "center": 3e-3, "finger_pairs": 2, "metallisation": 0.5, "aperture": 0.02}],
    "drive": {"frequency": 2.2e6, "transducer": "left", "voltage": [15.0, 60.0]},
    "slider": {
        "position": 6e-3,
        "radius": 1e-3,
        "mass": 0.089e-3,
        "contacts": 1,
        "preload": "weight",
        "friction_coefficient": 0.08,
        "effective_modulus": 64e9,
        "tangential_modulus": 12e9,
        "damping": {"normal": 0.5, "tangential": 1e-4},
    },
}
SIDES = tuple(
    (ends, bottom)
    for ends in ("absorbing", "free", "clamped")
    for bottom in ("free", "grounded", "clamped", "absorbing")
)
CUTS = (("LiNbO3 (Warner)", "YZ"), ("LiNbO3 (Warner)", "128YX"), ("quartz (Bechmann)", "ST-X"), ("PZT-8", "X"))
LAWS = ({"law": "hysteretic"}, {"reciprocal": True}, {"law": "hysteretic", "reciprocal": True}, {"stick_band": 1e-4})
BALLS = (("PZT-8", "Z"), ("PZT-8", "X"), ("LiNbO3 (Warner)", "YZ"))


def _changed(**blocks) -> dict:
    """Return the table of the scene with changed keys in its blocks; ``transducer`` changes the first transducer."""
    table = {key: value if key == "title" else _merged(value, blocks.get(key, {})) for key, value in SCENE.items()}
    table["transducer"] = [SCENE["transducer"][0] | blocks.get("transducer", {})]
    return table


def _merged(block, changes: dict):
    return block | changes if isinstance(block, dict) else block


def _driven(**changes) -> dict:
    return _changed(drive=changes)


def _with_slider(**changes) -> dict:
    return _changed(slider=changes)


def _ends(number: float) -> dict:
    ends, bottom = SIDES[int(number)]
    return _changed(stator={"ends": ends, "bottom": bottom})


def _cut(number: float) -> dict:
    material, orientation = CUTS[int(number)]
    return _changed(stator={"material": material, "orientation": orientation})


def _ball(number: float) -> dict:
    material, orientation = BALLS[int(number)]
    table = _changed(stator={"material": material, "orientation": orientation}, slider={"ball": "steel"})
    del table["slider"]["effective_modulus"], table["slider"]["tangential_modulus"]
    return table


def _third() -> dict:
    """Return the scene of one ball with a third of the mass and of the damping."""
    slider, damping = SCENE["slider"], SCENE["slider"]["damping"]
    return _with_slider(mass=slider["mass"] / 3, damping={name: value / 3 for name, value in damping.items()})


def _mirrored() -> dict:
    """Return the mirror image of the scene: the transducer on the right, the slider to its left."""
    length = SCENE["stator"]["length"]
    return _changed(
        transducer={"center": length - SCENE["transducer"][0]["center"]},
        slider={"position": length - SCENE["slider"]["position"]},
    )


# quantity: unit, values, table as a function of the value, kind of reference
VARIED: dict[str, tuple[str, tuple, Callable[[float], dict], str]] = {
    "voltage": ("V", (0.0, 1e-9, 1e-3, 7.0, 300.0, 1e3, 1e6), lambda v: _driven(voltage=v), "tighter"),
    "source impedance": ("ohm", (1e-9, 50.0, 1e4, 1e9), lambda v: _driven(source_impedance=v), "divider"),
    "load": ("N", (1e-9, 1e-6, 1e-5, 1e-3, 1.0), lambda v: _with_slider(load=v), "tighter"),
    "three contacts": ("", (3.0,), lambda _: _with_slider(contacts=3), "third"),
    "three contacts apart": (
        "m",
        (1e-12, 1e-6, 3e-4, 1.5e-3),
        lambda v: _with_slider(contacts=[-v, 0.0, v]),
        "tighter",
    ),
    "mirror image": ("", (1.0,), lambda _: _mirrored(), "mirror"),
    "length": ("m", (0.1, 10.0, 1e4), lambda v: _changed(stator={"length": v}), "same"),
    "ends and bottom": ("", tuple(range(len(SIDES))), _ends, "tighter"),
    "cut": ("", tuple(range(len(CUTS))), _cut, "tighter"),
    "ball of steel on a cut": ("", tuple(range(len(BALLS))), _ball, "tighter"),
    "contact law": ("", tuple(range(len(LAWS))), lambda v: _with_slider(**LAWS[int(v)]), "tighter"),
    "position": ("m", (0.0, 1e-4, 2.9e-3, 4.1e-3, 9e-3), lambda v: _with_slider(position=v), "tighter"),
    "burst": ("s", (1e-6, 2e-5), lambda v: _driven(burst=v), "tighter"),
    "tolerance": ("", (1e-1, 1e-2, 1e-3, 1e-4, 1e-5), lambda _: _changed(), "tighter"),
    "thickness": ("m", (1e-6, 0.2, 1e6), lambda v: _changed(stator={"thickness": v}), "tighter"),
    "frequency": ("Hz", (1e3, 2.2e5, 8e6), lambda v: _driven(frequency=v), "tighter"),
}


def chain_cases() -> list[Case]:
    """Return the cases of the chain."""
    return cases_of(PART, VARIED)


def judge(case: Case) -> Outcome:
    """Return the outcome of a case."""
    _, _, table, witness = VARIED[case.varied]
    tolerance = case.value if case.varied == "tolerance" else TOLERANCE

    def posed():
        changed = table(case.value)
        if case.varied == "frequency":
            changed["transducer"][0]["period"] = 0.98e-3
        record = _run(changed, tolerance)
        if record.shortfall:
            raise NoWitness(f"none is asked where the answer itself is flagged: {record.shortfall}")
        error, estimate = _worst(record, _known(witness, changed, tolerance))
        return error, estimate, True

    return judged(posed, tolerance)


def _run(table: dict, tolerance: float):
    return run(Scene.from_table("", table), tolerance=tolerance)


def _known(witness: str, table: dict, tolerance: float) -> list[float]:
    """Return the velocities of the reference in m/s."""
    if witness == "tighter":
        return _velocities(_tighter(table, tolerance))
    if witness == "divider":
        without_impedance = _tighter(_changed(), tolerance)
        voltage_ratio = 1 / abs(1 + table["drive"]["source_impedance"] * without_impedance.electrical["admittance_S"])
        return _velocities(_tighter(_driven(voltage=[v * voltage_ratio for v in SCENE["drive"]["voltage"]]), tolerance))
    if witness == "third":
        return _velocities(_tighter(_third(), tolerance))
    same = _velocities(_tighter(_changed(), tolerance))
    return [-speed for speed in same] if witness == "mirror" else same


def _tighter(table: dict, tolerance: float):
    """Return the record at a hundredth of a tolerance, or at a tenth if there is no answer."""
    reason = ""
    for relative_tolerance in TIGHTER:
        try:
            record = _run(table, tolerance * relative_tolerance / TOLERANCE)
        except RunError as error:
            reason = str(error)
            continue
        if not record.shortfall:
            return record
        reason = record.shortfall
    raise NoWitness(reason)


def _velocities(record) -> list[float]:
    return [point["velocity_m_per_s"] for point in record.points]


def _worst(record, known: list[float]) -> tuple[float, float]:
    """Return error and estimate of the point whose error exceeds twice its estimate the most."""
    omega = 2 * math.pi * record.scene.frequency
    errors = []
    for point, truth in zip(record.points, known, strict=True):
        scale = contact.speed_scale(truth, omega * point["tangential_amplitude_m"])
        difference = abs(point["velocity_m_per_s"] - truth)
        errors.append((difference / scale if scale > 0 else difference, point["relative_error"]))
    return max(errors, key=lambda pair: pair[0] - 2 * pair[1])
