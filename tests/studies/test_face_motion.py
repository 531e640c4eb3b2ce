"""The motion of the slider's face: integrals of Hertz's force, and compliances of a body in closed form."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

import contact
from studies import Scene, run
from studies.model.pillars import prescribed_motion
from studies.model.wave_to_contact import contact_slider
from studies.solve.face_motion import face_point
from studies.solve.solved_stator import contact_of_run

OMEGA = 2 * math.pi * 9.61e6
# silicon of the catalogue, isotropic: E 162 GPa, nu 0.22
E, NU = 162e9, 0.22
G = E / (2 * (1 + NU))


def test_a_ball_moves_by_its_first_harmonic_over_its_mass():
    """P = K z^1.5 of a heavy slider, its mean the preload; integrated here in equal steps."""
    record = run(Scene.load("twente-contact").replace(wave={"normal_amplitude": "10 nm"}), tolerance=1e-2)
    omega, amplitude = 2 * math.pi * 2.2e6, 10e-9
    preload, mass, stiffness = 0.089e-3 * 9.81, 0.089e-3, 4 / 3 * 64e9 * math.sqrt(1e-3)
    phase = 2 * np.pi * np.arange(20_000) / 20_000

    def force(height):
        return stiffness * np.maximum(height + amplitude * np.cos(phase), 0) ** 1.5

    height = brentq(lambda h: force(h).mean() - preload, -amplitude, amplitude)
    first = 2 * np.mean(force(height) * np.cos(phase))
    (point,) = record.points
    assert point.face_normal_m == pytest.approx(first / (mass * omega**2), rel=1e-3)
    assert 0 < point.face_tangential_m < 0.08 * 1.2 * point.face_normal_m
    assert point.face_wave_normal_m is None


def test_a_rough_ball_moves_by_the_first_harmonic_of_its_field():
    """P of the mean field at the approaches of a cycle whose mean is the preload; equal steps and a spline."""
    (point,) = run(
        Scene.load("twente-contact").replace(wave={"normal_amplitude": "6 nm"}, slider={"roughness": {"rms": 3e-9}}),
        tolerance=1e-3,
    ).points
    field = contact.MeanField(1e-3, 64e9, contact.Roughness(rms=3e-9))
    z = np.linspace(-12e-9, 20e-9, 65)
    force = CubicSpline(z, [field.at(each).force for each in z])
    cosine = np.cos(2 * np.pi * np.arange(2000) / 2000)
    preload, inertia = 0.089e-3 * 9.81, 0.089e-3 * (2 * math.pi * 2.2e6) ** 2
    height = brentq(lambda h: force(h + 6e-9 * cosine).mean() - preload, -5e-9, 10e-9)
    first = 2 * np.mean(force(height + 6e-9 * cosine) * cosine)
    assert point.face_normal_m == pytest.approx(first / inertia, rel=1e-3)


@pytest.fixture(scope="module")
def pillars():
    return run("tests/studies/scenes/pillars.toml", tolerance=1e-2)


def motion(record):
    """The slider and the forces of its pillars at 20 nm."""
    slider, given = contact_slider(record.scene.slider), record.scene
    wave = prescribed_motion(given.slider, given.wave).scaled(20e-9)
    return slider, contact.steady(slider, wave, tolerance=1e-3).loaded.forces


def test_the_feet_of_pillars(pillars):
    """P_1/(2 a E/(1 - nu^2)) and Q_1 (2 - nu)/(8 a G), weighted with the loads; the mass of 0.1 g adds 3 %."""
    _, forces = motion(pillars)
    a, inertia = 10e-6, 1e-4 * OMEGA**2
    w = forces.first_normal * (1 - NU**2) / (2 * a * E) - forces.first_normal.sum() / inertia
    x = forces.first_tangential * (2 - NU) / (8 * a * G) - forces.first_tangential.sum() / inertia
    load = forces.normal / forces.normal.sum()
    point = pillars.points[1]
    assert point.face_normal_m == pytest.approx(np.abs(w) @ load, rel=1e-6)
    assert point.face_tangential_m == pytest.approx(np.abs(x) @ load, rel=1e-6)
    # exp(+i omega t): what follows by 30 degrees has the phase -30 degrees
    assert point.face_delay_deg == pytest.approx(math.degrees(np.angle(w @ (x.conj() * load))), abs=1e-6)


def test_the_mean_plane_dents_as_a_half_space_under_a_travelling_pressure(pillars):
    """Rayleigh's function of silicon, with the pressure of all pillars; the tangential traction adds little."""
    slider, forces = motion(pillars)
    v, k = 9.61e6 * 414.05e-6, 2 * np.pi / 414.05e-6
    shear, pressure = math.sqrt(G / 2330.0), math.sqrt(2 * G * (1 - NU) / (1 - 2 * NU) / 2330.0)
    k_t, q_l, q_t = v / shear, math.sqrt(1 - (v / pressure) ** 2), math.sqrt(1 - (v / shear) ** 2)
    compliance = k_t**2 * q_l / (G * (4 * q_l * q_t - (2 - k_t**2) ** 2))
    # the wave of a scene runs towards -x
    turned = np.exp(-1j * k * np.asarray(slider.x))
    area = (11 * 50e-6 + math.sqrt(50e-6 * 60e-6)) * (4 * 60e-6 + 60e-6)
    normal = compliance / k * abs(forces.first_normal @ turned) / area
    tangential = abs(forces.first_tangential @ turned) / area
    found = pillars.points[1].face_wave_normal_m
    assert found == pytest.approx(normal, abs=1.3e-11 / k * tangential * 1.05)
    assert abs(found - normal) > 1e-4 * normal


def test_a_mirrored_wave_gives_the_mirrored_motion(pillars):
    """The wave from the other side: equal amplitudes, and the opposite sign of the tangential motion."""
    driven = contact_of_run(pillars)
    other = replace(driven, orbits=replace(driven.orbits, forward=driven.orbits.backward, backward=0.0))
    here, there = (
        face_point(each, contact.steady(each.slider, each.at(20e-9), tolerance=1e-3), 20e-9) for each in (driven, other)
    )
    for key in ("face_normal_m", "face_tangential_m", "face_wave_normal_m", "face_wave_tangential_m"):
        assert there[key] == pytest.approx(here[key], rel=1e-6), key
    assert abs(there.face_delay_deg - here.face_delay_deg) == pytest.approx(180.0, abs=1e-3)


def test_no_motion_without_a_wave_or_a_preload():
    scene = Scene.load("twente-contact").replace(wave={"normal_amplitude": [0.0, "3 nm"]}, slider={"preload": 0.0})
    assert all(point.face_normal_m is None for point in run(scene, tolerance=1e-2).points)
