"""Bursts drawn to break the fast methods' error estimates: punches, contact dampers, light dampers, few cycles."""

import math
from dataclasses import replace

import numpy as np

from contact import Orbit, Slider


def drawn(number: int):
    """Return (slider, orbits, method, cycles, tolerance) of a draw."""
    draw = np.random.default_rng([2411, number])
    n, frequency = int(draw.integers(1, 4)), 10.0 ** draw.uniform(5, 7.5)
    omega, ratio = 2.0 * math.pi * frequency, 10.0 ** draw.uniform(-3, -1.02)
    punch, mu, preload = draw.random() < 0.4, draw.uniform(0.05, 0.45), 10.0 ** draw.uniform(-4.6, -2.7)
    slider = Slider(
        radius=10.0 ** (draw.uniform(-6.3, -5) if punch else draw.uniform(-4, -3)), preload=preload, mass=1e-6,
        friction_coefficient=mu, effective_modulus=64e9, tangential_modulus=12e9, law="elastic", reciprocal=False,
        stick_band=0.0, shape="punch" if punch else "sphere", contact_damping=0.0, normal_damping=0.0,
        load=float(draw.choice([0.0, draw.uniform(0, 0.9)])) * mu * preload, tangential_damping=0.0,
    )  # fmt: skip
    mass = 1e-6 * (slider.normal_resonance(n) / frequency / ratio) ** 2
    rest = slider.rest_approach(n)
    amplitude = rest * 10.0 ** draw.uniform(-0.4, 1.2)
    chi = float(draw.choice([0.0, 10.0 ** draw.uniform(-3, -0.5)])) / (omega * max(amplitude, rest))
    slider = replace(
        slider, mass=mass, contact_damping=chi,
        normal_damping=float(draw.choice([0.0, mass * omega * ratio * 10.0 ** draw.uniform(-4, 0)])),
        tangential_damping=float(draw.choice([0.0, mass * omega * 10.0 ** draw.uniform(-6, -2.5)])),
        heights=tuple(draw.uniform(0, 1, n) * rest) if n > 1 and draw.random() < 0.3 else (),
    )  # fmt: skip
    slope, tilt = 10.0 ** draw.uniform(-1.4, 0.3), draw.choice([0.0, draw.uniform(-1.4, 1.4)])
    orbits = tuple(
        Orbit(
            frequency=frequency, normal=amplitude * np.exp(1j * phase),
            tangential=-1j * slope * draw.uniform(0.3, 1.0) * amplitude * np.exp(1j * (phase + tilt)),
        )
        for phase in draw.uniform(0, 2 * math.pi, n)
    )  # fmt: skip
    method = ("stepped", "averaged")[int(draw.integers(2))]
    return slider, orbits, method, int(10.0 ** draw.uniform(1.2, 3.9)), 10.0 ** -float(draw.integers(2, 7))
