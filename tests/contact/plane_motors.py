"""Sliders and waves of the tests of motion in the plane."""

import math

import numpy as np

from contact import Slider
from contact.plane import SurfaceWaves

F, MU, R_X = 0.87309e-3, 0.08, 0.67


def ball(**changes):
    """Return a slider on one ball, without dampers and too heavy to move within a cycle."""
    values = dict(
        radius=1e-3, mass=math.inf, preload=F, load=(0.0, 0.0), friction_coefficient=MU, effective_modulus=64e9,
        tangential_modulus=12e9, law="elastic", reciprocal=False, stick_band=0.0, contact_damping=0.0,
        normal_damping=0.0, tangential_damping=0.0, freedom="xy",
    )  # fmt: skip
    return Slider(**(values | changes))


def beams(x_nm, y_nm, delta=0.0, frequencies=(2.2e6,), contacts=1):
    """Return waves that drive towards +x and +y, equal under all contacts."""
    a, b = x_nm * 1e-9, y_nm * 1e-9 * np.exp(1j * delta)
    rows = [[[-1j * R_X * a, -1j * R_X * b, a + b]]]
    if len(frequencies) == 2:
        rows = [[[-1j * R_X * a, 0.0, a]], [[0.0, -1j * R_X * b, b]]]
    return SurfaceWaves(frequencies=frequencies, amplitudes=np.repeat(rows, contacts, axis=1))
