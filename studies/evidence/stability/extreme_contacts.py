"""Extreme cases of the contact: each quantity at both ends of its range, and random combinations of extreme values.

Method: the seed's slider on a wave of 5 nm; one quantity at a time, and then all at random between their ends, laws and
numbers of balls too.  The steady velocity at a tolerance of 1e-3 is compared with runs in time that start at it
(`cross_check`).  Expected: an answer within its stated error, an answer whose status says that it misses the
tolerance, or a refusal with the reason; never NaN or a traceback.  Run time: about two minutes of one processor.
"""

import json
import math
from dataclasses import fields
from pathlib import Path

import numpy as np

import contact
from contact.error_estimate import relative_to_reference
from studies.evidence.stability.cross_check import cross_check
from studies.evidence.stability.verdict import Case, Comparison, NoReference
from studies.papers.seed import Seed

TOLERANCE = 1e-3
AMPLITUDE, FREQUENCY, RATIO = 5e-9, 2.2e6, 0.7
SLIDER = {field.name: getattr(Seed().slider, field.name) for field in fields(contact.Slider)}
# random combinations of extreme values, by `tests/stability_cases.py`
CORNERS = json.loads(Path(__file__).with_name("corners.json").read_text(encoding="utf-8"))
# quantities that are varied one at a time: unit and values
SWEPT = {
    "moduli over the seed's": ("", (1e-3, 1e-2, 0.1, 10.0, 100.0, 1e3)),
    "preload": ("N", (0.0, 1e-9, 1e-6, 1e-5, 1e-4, 1e-2, 0.1, 1.0, 10.0, 100.0, 1e3)),
    "amplitude": ("m", (0.0, 1e-12, 1e-10, 0.7e-9, 0.75e-9, 1e-9, 3e-9, 2e-8, 1e-7, 3e-7, 1e-6, 3e-6, 1e-5)),
    "friction_coefficient": ("", (0.0, 1e-6, 1e-3, 0.01, 0.3, 0.5, 1.0, 2.0, 5.0)),
    "mass": ("kg", (1e-12, 1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-3, 1e-2, 0.1, 1.0)),
    "radius": ("m", (1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-2, 0.1, 1.0)),
    "frequency": ("Hz", (1.0, 10.0, 100.0, 1e3, 3e3, 6e3, 9e3, 1.2e4, 2e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10)),
    "stick_band": ("m/s", (1e-6, 1e-4, 1e-3, 1e-2, 0.1, 1.0, 10.0)),
    "contact_damping": ("s/m", (0.0, 1e-3, 1.0, 1e2, 1e3, 1e4, 1e5, 1e6)),
    "normal_damping": ("N s/m", (0.0, 1e-6, 1e-3, 1.0, 1e2, 1e4, 1e6)),
    "tangential_damping": ("N s/m", (0.0, 1e-6, 1e-3, 1e-1, 1e2, 1e4, 1e6)),
    "load": ("N", (1e-7, 1e-5, 5e-5, 1e-4, 1e-2, 1.0, 1e3)),
    "tangential_ratio": ("", (0.0, 1e-3, 1.0, 10.0, 1e3)),
}
VARIED = SWEPT | {"corner": ("", range(len(CORNERS)))}


def motor(case: Case):
    """Return (slider, orbits) of a case."""
    return built(CORNERS[int(case.value)] if case.varied == "corner" else {case.varied: case.value})


def built(values: dict):
    """Return (slider, orbits) from values by name; missing values are those of the default slider and wave."""
    rest = dict(values)
    factor = rest.pop("moduli over the seed's", 1.0)
    amplitude = rest.pop("amplitude", AMPLITUDE)
    ratio = rest.pop("tangential_ratio", RATIO)
    frequency = rest.pop("frequency", FREQUENCY)
    angle, contacts = rest.pop("angle", -0.5 * math.pi), rest.pop("contacts", 1)
    moduli = {name: factor * SLIDER[name] for name in ("effective_modulus", "tangential_modulus")}
    slider = contact.Slider(**(SLIDER | moduli | rest))
    tangential = ratio * amplitude * complex(np.exp(1j * angle))
    one = contact.Orbit(frequency=frequency, normal=amplitude, tangential=tangential)
    return slider, tuple(one.scaled(complex(np.exp(-2j * np.pi * k / 7.0))) for k in range(contacts))


def compared(case: Case, tolerance: float) -> Comparison:
    """Return error, estimate and status of a case."""
    slider, orbits = motor(case)
    answer = contact.steady(slider, orbits, tolerance=tolerance)
    try:
        reference = cross_check(answer)
    except contact.ConvergenceError as error:
        raise NoReference(str(error)) from None
    difference, reference_error = (
        relative_to_reference(each, answer.velocity, orbits)
        for each in (reference.velocity - answer.velocity, reference.error)
    )
    # the reference is often less accurate than the answer: subtract twice its error
    return max(difference - 2.0 * reference_error, 0.0), answer.relative_error, answer.status == "ok" or answer.message
