"""Sliders and waves of the tests of motion in the plane."""

import math

import numpy as np

from contact import Slider
from contact.plane import PlaneWave, PlaneWaves, SurfaceWaves

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


def drawn(seed, mass=math.inf):
    """Return a slider on one to three contacts and waves in the plane, drawn by a fixed seed."""
    rng = np.random.default_rng([seed, 20261128])
    n = int(rng.integers(1, 4))
    freedom = "xy" if n == 1 else str(rng.choice(["xy", "xy yaw", "axle"]))
    punch = bool(rng.random() < 0.3)
    angle = rng.uniform(0.0, 2.0 * np.pi) + np.arange(n) * 2.0 * np.pi / n + rng.uniform(-0.4, 0.4, n)
    arm = rng.uniform(2e-3, 6e-3, n)
    mu, preload = float(rng.uniform(0.05, 0.3)), n * float(10 ** rng.uniform(-3.6, -2.6))
    push = 0.3 * mu * preload * rng.uniform() * np.array([np.cos(angle[0]), np.sin(angle[0])])
    radius = rng.uniform(1.5e-6, 4e-6, n) if punch else 10 ** rng.uniform(-3.3, -2.4, n)
    slider = ball(
        x=arm * np.cos(angle) if n > 1 else 0.0, y=arm * np.sin(angle) if n > 1 else 0.0, radius=radius if n > 1 else
        float(radius[0]), shape="punch" if punch else "sphere", preload=preload, freedom=freedom,
        friction_coefficient=mu, load=(0.0, 0.0) if freedom == "axle" else tuple(push),
        heights=rng.uniform(-0.5e-9, 0.5e-9, n) if n > 1 else (), inertia=None if math.isinf(mass) else mass * 1e-5,
        torque=0.0 if freedom == "xy" else 0.1 * mu * preload * float(arm.mean()) * float(rng.uniform(-1, 1)),
        tangential_damping=float(rng.choice([0.0, 1e-4])), mass=mass,
        normal_damping=0.0 if math.isinf(mass) else 0.5 * mass * 2e5,
    )  # fmt: skip
    several = rng.random() < 0.2
    frequencies = (2.2e6, 2.4e6) if several else (float(rng.choice([1e6, 2.2e6, 9.6e6])),)
    size = (2.2e6 / frequencies[0]) * 10 ** rng.uniform(-8.9, -7.9)
    u_z = size * rng.uniform(0.5, 1.0, (len(frequencies), n)) * np.exp(2j * np.pi * rng.random((len(frequencies), n)))
    beta = rng.uniform(0.0, 2.0 * np.pi, (len(frequencies), n))
    along = -1j * rng.uniform(0.4, 1.2) * u_z * np.exp(0.5j * rng.uniform(-1, 1))
    across = along * 0.3 * np.exp(2j * np.pi * rng.random((len(frequencies), n)))
    u_x, u_y = (along * np.cos(beta) - across * np.sin(beta)), (along * np.sin(beta) + across * np.cos(beta))
    return slider, SurfaceWaves(frequencies=frequencies, amplitudes=np.stack([u_x, u_y, u_z], axis=-1))


def drawn_on_three_balls(seed):
    """Return a slider on three equal balls in plane waves, and the rise time in s, drawn by a fixed seed.

    Two balls often meet the same wave, so that their events come at one instant or nearly so.
    """
    rng = np.random.default_rng([seed, 7])
    arm, first = 3e-3 * rng.uniform(0.7, 2), rng.choice([0.0, rng.uniform(0, 2 * np.pi)])
    angle, mass = first + np.arange(3) * 2.0 * np.pi / 3.0, 0.089e-3 * 10 ** rng.uniform(-1, 1)
    freedom, preload = str(rng.choice(["xy", "xy yaw", "axle"])), mass * 9.81 * rng.choice([1.0, 3.0])
    values = dict(
        x=arm * np.cos(angle), y=arm * np.sin(angle), preload=preload, mass=mass, freedom=freedom,
        normal_damping=mass * 10 ** rng.uniform(3, 5), tangential_damping=float(rng.choice([0, 1e-4])),
        tilt=str(rng.choice(["held", "free"])),
    )  # fmt: skip
    if freedom != "xy":
        values |= dict(inertia=mass * 1e-5, torque=float(rng.choice([0.0, 1e-8])))
    if freedom != "axle" and rng.random() < 0.3:
        values |= dict(load=tuple(0.2 * 0.08 * preload * rng.uniform(-1, 1, 2)))
    waves = []
    for k in range(int(rng.integers(1, 3))):
        frequency = 2.2e6 if k == 0 or rng.random() < 0.6 else 2.3e6
        direction = float(rng.choice([0, np.pi / 2, np.pi, rng.uniform(0, 6.28)]))
        wavelength = float(rng.choice([1e-3, 1.8e-3]))
        normal = 10 ** rng.uniform(0, 1.3) * 1e-9 * np.exp(1j * rng.choice([0, 1.57, rng.uniform(0, 6)]))
        waves.append(
            PlaneWave(frequency=frequency, wavelength=wavelength, direction=direction, normal=normal, ratio=R_X)
        )
    slider, rise = ball(**values), float(rng.choice([0.0, 5 / 2.2e6, 30 / 2.2e6]))
    return slider, PlaneWaves(waves=tuple(waves)).at(slider.x, slider.y), rise
