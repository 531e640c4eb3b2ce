"""A normal force of one's own: the table against the function, the motion against an independent integration."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from contact import (
    Adhesion,
    InputError,
    PassingWave,
    TabulatedForce,
    UserForce,
    burst,
    contact_history,
    mean_motion,
    release_amplitude,
    riding_height,
    steady,
    steady_sweep,
    threshold_amplitude,
)
from contact.law import normal
from tests.contact.motors import HEAVY, orbit, slider

R, E, MU = 1e-3, 64e9, 0.08
K = 4.0 / 3.0 * E * math.sqrt(R)
SOFT = 3e-9  # m, the approach over which `bent` stiffens
TEXT = """
def force(approach, contact):
    return 4 / 3 * contact.effective_modulus * contact.radius**0.5 * approach**1.5
"""


def hertz(z):
    """Return Hertz's force, N."""
    return K * z**1.5


def bent(z):
    """Return a force that begins with a third of Hertz's and comes to it, as that of a rough ball, N."""
    return K * z**1.5 * (1.0 - math.exp(-z / SOFT) / 1.5)


@pytest.fixture(scope="module")
def table():
    return TabulatedForce.of(bent, scale=1e-9, end=1e-6)


def test_the_table_is_the_function_with_its_slope_energy_and_inverse(table):
    assert table.error < 1e-9
    law = table.law(K)
    for z in (1e-12, 3e-10, 2.345e-9, 4.7e-8, 8.9e-7):
        assert K * normal.load(z, law) == pytest.approx(bent(z), rel=3e-9)
        step = 1e-4 * z
        assert K * normal.slope(z, law) == pytest.approx((bent(z + step) - bent(z - step)) / (2.0 * step), rel=3e-8)
        work = quad(bent, 0.0, z, epsabs=0.0, epsrel=1e-12)[0]
        assert K * normal.energy(z, law) == pytest.approx(work, rel=3e-9)
        assert normal.approach(normal.load(z, law), law) == pytest.approx(z, rel=1e-13)
    several = np.array([0.0, 1e-9, 5e-6])
    assert normal.load(several, law)[0] == normal.load(-1e-9, law) == normal.slope(-1e-9, law) == 0.0
    # beyond the table P^(2/3) goes on as a straight line, and the energy and the inverse with it
    work = quad(lambda z: normal.load(z, law), 0.9e-6, 5e-6, epsabs=0.0, epsrel=1e-10)[0]
    assert normal.energy(5e-6, law) - normal.energy(0.9e-6, law) == pytest.approx(work, rel=1e-9)
    assert normal.approach(normal.load(5e-6, law), law) == pytest.approx(5e-6, rel=1e-13)


def test_a_law_in_another_unit_is_the_same_law(table):
    law, length = table.law(K), 4.7e-9
    own = normal.scaled(law, length)
    unit = normal.load(length, law)
    assert normal.unit_load(own, length) == pytest.approx(unit, rel=1e-13)
    for z in (0.01, 0.7, 9.0, 400.0):
        assert normal.load(z, own) * unit == pytest.approx(normal.load(z * length, law), rel=1e-13)
        assert normal.slope(z, own) * unit / length == pytest.approx(normal.slope(z * length, law), rel=1e-13)
        assert normal.energy(z, own) * unit * length == pytest.approx(normal.energy(z * length, law), rel=1e-12)
    assert normal.edge_load(1e-5, own) == pytest.approx(normal.load(1e-5, own), rel=1e-4)
    assert normal.curvature(0.7, own) == pytest.approx(normal.curvature(0.7 * length, law), rel=1e-6)


def test_hertz_as_a_table_answers_as_hertz():
    smooth = slider()
    same = replace(smooth, normal_law=TabulatedForce.of(hertz, scale=1e-9, end=1e-6))
    for u in (2e-9, 10e-9):
        one, other = mean_motion(smooth, orbit(u)), mean_motion(same, orbit(u))
        assert float(other.velocity) == pytest.approx(float(one.velocity), rel=1e-11)
        assert float(other.height) == pytest.approx(float(one.height), rel=1e-11)
    assert threshold_amplitude(same, orbit(1e-9)) == pytest.approx(threshold_amplitude(smooth, orbit(1e-9)), rel=1e-9)
    assert release_amplitude(same, orbit(1e-9)) == pytest.approx(release_amplitude(smooth, orbit(1e-9)), rel=1e-9)
    assert same.normal_resonance(1) == pytest.approx(smooth.normal_resonance(1), rel=1e-12)
    assert same.pressure(4e-9) == pytest.approx(smooth.pressure(4e-9), rel=1e-12)
    one, other = (steady(each, orbit(10e-9), tolerance=1e-6) for each in (smooth, same))
    assert other.status == "ok"
    assert other.velocity == pytest.approx(one.velocity, rel=1e-10)
    for method, close in (("stepped", 1e-9), ("exact", 1e-11), ("averaged", 1e-9)):
        options = {"duration": 2e-5, "after": 0.0, "tolerance": 1e-3, "samples": 5, "method": method}
        one, other = (burst(each, orbit(10e-9), **options) for each in (smooth, same))
        assert other.velocity_at_burst_end == pytest.approx(one.velocity_at_burst_end, rel=close)


def mean_load(h, amplitude):
    """Return the cycle mean of `bent` at h + amplitude cos, N, by adaptive quadrature."""
    half = math.acos(max(-1.0, min(1.0, -h / amplitude)))
    return (
        quad(lambda phi: bent(max(h + amplitude * math.cos(phi), 0.0)), 0.0, half, epsabs=0.0, epsrel=1e-11)[0]
        / math.pi
    )


def stop_velocity(h, amplitude, ratio, c, steps=40_000):
    """Return the velocity at which a stop of the force `bent` has no mean, by equal steps; heavy slider."""
    phi = 2.0 * math.pi * np.arange(3 * steps + 1) / steps
    z = h + amplitude * np.cos(phi)
    u_x = ratio * amplitude * np.sin(phi)
    force = np.array([bent(each) if each > 0.0 else 0.0 for each in z[: steps + 1]])
    limit = c * np.maximum(z, 0.0)

    def mean(v):  # over omega, m
        moved = np.diff(u_x) - v * 2.0 * math.pi / steps
        x, total = 0.0, 0.0
        for k in range(3 * steps):
            x = min(max(x + moved[k], -limit[k + 1]), limit[k + 1])
            if k >= 2 * steps and limit[k + 1] > 0.0:
                rest = z[k + 1] - abs(x) / c
                stuck = bent(rest) if rest > 0.0 else 0.0
                total += math.copysign(force[(k + 1) % steps] - stuck, x)
        return total

    return brentq(mean, 0.0, ratio * amplitude, xtol=1e-13, rtol=1e-7)


@pytest.mark.parametrize("u", [1.5e-9, 6e-9])
def test_the_mean_motion_is_that_of_an_independent_stop(table, u):
    own, wave = slider(normal_law=table, mass=HEAVY, normal_damping=0.0, tangential_damping=0.0), orbit(u)
    h = brentq(lambda h: mean_load(h, u) - own.preload, -0.999 * u, 20e-9, xtol=1e-17)
    assert riding_height(own, wave) == pytest.approx(h, rel=1e-8)
    v = stop_velocity(h, u, 0.7, own.slope_unit) * wave.omega
    assert float(mean_motion(own, wave).velocity) == pytest.approx(v, rel=2e-4)


def test_the_methods_agree_and_the_ledger_closes(table):
    own, wave = slider(normal_law=table), orbit(10e-9)
    found = steady(own, wave, tolerance=1e-6)
    assert found.status == "ok"
    assert found.velocity == pytest.approx(float(mean_motion(own, wave).velocity), rel=1e-5)
    lost = found.ledger.wave - found.ledger.normal_damper - found.ledger.tangential_damper
    assert lost - found.ledger.slip - found.ledger.leak == pytest.approx(0.0, abs=1e-8 * found.ledger.wave)
    options = {"duration": 2e-5, "after": 0.0, "tolerance": 1e-3, "samples": 5}
    exact = burst(own, wave, method="exact", **options).velocity_at_burst_end
    for method in ("stepped", "averaged"):
        other = burst(own, wave, method=method, **options)
        unit = max(abs(exact), wave.omega * abs(wave.tangential) / 10.0)
        assert abs(other.velocity_at_burst_end - exact) < 1.01 * other.relative_error * unit
    history = contact_history(own, wave, stage="steady", skip=0, cycles=1, points_per_cycle=50)
    touching = history.approach > 0.0
    assert history.normal_force[touching] == pytest.approx([bent(z) for z in history.approach[touching]], rel=1e-8)


def test_release_and_threshold_of_a_force_that_is_no_power(table):
    own = slider(normal_law=table, mass=HEAVY)
    amplitude = brentq(lambda a: mean_load(a, a) - own.preload, 1e-9, 20e-9, xtol=1e-18)
    assert release_amplitude(own, orbit(1e-9)) == pytest.approx(amplitude, rel=1e-6)
    found, c = threshold_amplitude(own, orbit(1e-9)), own.slope_unit
    # |u_x|^2 + c^2 |u_z|^2 = c^2 h^2
    assert math.hypot(0.7 * found, c * found) == pytest.approx(c * riding_height(own, orbit(found)), rel=1e-6)


def test_a_sweep_keeps_laws_apart(table):
    smooth, own = slider(), slider(normal_law=table)
    which = np.array([[0, 0], [1, 0], [0, 0]])
    both = steady_sweep([smooth, own], [(orbit(5e-9),)], which=which, factors=np.ones(3), wave_errors=[0.0])
    alone = [float(mean_motion(each, orbit(5e-9)).velocity) for each in (smooth, own, smooth)]
    assert both.velocity.tolist() == alone
    assert alone[0] != alone[1]


def test_a_file_is_tabulated():
    own = slider(normal_law=UserForce("hertz.py", TEXT))
    wave = orbit(5e-9)
    assert float(mean_motion(own, wave).velocity) == pytest.approx(
        float(mean_motion(slider(), wave).velocity), rel=1e-9
    )
    assert own == slider(normal_law=UserForce("hertz.py", TEXT))
    assert hash(own) != hash(slider())


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("x = 1", r"slider\.normal_law must define force\(approach, contact\)"),
        ("def force(z): return z", "takes other arguments"),
        ("def force(z, contact): return 1 / 0", "cannot be evaluated: ZeroDivisionError"),
        ("def force(z, contact): return -z", "finite and not negative at an approach of"),
        ("def force(z, contact): return 1.0", "rises with the approach"),
        ("def force(z, contact): return 1e6 * z", "must be smooth: a table of 2048 pieces errs by"),
        ("import nowhere", "cannot be run"),
    ],
)
def test_files_are_refused(text, sentence):
    with pytest.raises(InputError, match=sentence):
        slider(normal_law=UserForce("own.py", text))


def test_refusals(table):
    with pytest.raises(InputError, match=r'slider\.normal_law must begin as the shape does, "punch"'):
        slider(normal_law=table, shape="punch", radius=1e-6)
    with pytest.raises(InputError, match=r"slider\.radius must be equal"):
        slider(normal_law=table, radius=[1e-3, 2e-3])
    with pytest.raises(InputError, match="cannot be read"):
        slider(normal_law="nowhere.py")


@pytest.mark.parametrize("tilt", ["held", "pitch"])
def test_pillars_with_a_table_load_the_wave_as_those_without(tilt):
    x = np.arange(12) * 50e-6 - 275e-6
    k = 1.8e6
    own = {"radius": None, "effective_modulus": None, "tangential_modulus": None, "shape": "punch"}
    own |= {"normal_stiffness": k, "tangential_stiffness": 1.52e6, "x": x, "tilt": tilt}
    flat = slider(preload=0.06, friction_coefficient=0.18, normal_damping=0.0, tangential_damping=0.0, **own)
    table = TabulatedForce.of(lambda z: k * z, scale=1e-9, end=1e-6, shape="punch")
    wave = PassingWave(
        frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=20e-9, backward=0.0, compliance=2.5078e-12,
        strip_width=0.5e-3, loading=True,
    )  # fmt: skip
    one, other = (steady(each, wave, tolerance=1e-3) for each in (flat, replace(flat, normal_law=table)))
    assert other.velocity == pytest.approx(one.velocity, rel=1e-6)
    assert other.tilt == pytest.approx(one.tilt, rel=1e-5, abs=1e-12)
    with pytest.raises(InputError, match=r'slider\.normal_law must be absent with loading "harmonics"'):
        steady(replace(flat, normal_law=table), replace(wave, loading="harmonics"), tolerance=1e-3)


def test_rows_of_a_force_that_is_no_power_are_the_contacts_of_a_given_wave():
    k, x = 1.8e6, np.arange(3) * 70e-6
    own = {"radius": None, "effective_modulus": None, "tangential_modulus": None, "shape": "punch"}
    own |= {"normal_stiffness": k, "tangential_stiffness": 1.52e6, "x": x, "mass": math.inf}
    table = TabulatedForce.of(lambda z: k * z * (1.0 - math.exp(-z / SOFT) / 2.0), scale=1e-9, end=1e-6, shape="punch")
    body = slider(preload=0.015, friction_coefficient=0.18, normal_damping=0.0, tangential_damping=0.0, **own)
    body = replace(body, normal_law=table)
    given = PassingWave(
        frequency=9.61e6, wavelength=414.05e-6, ratio=0.88995, forward=15e-9, backward=0.0, compliance=1e-20,
        strip_width=0.5e-3, loading=False,
    )  # fmt: skip
    one, other = (mean_motion(body, replace(given, loading=loads)) for loads in (False, True))
    assert float(other.velocity) == pytest.approx(float(one.velocity), rel=1e-6)
    assert float(other.height) == pytest.approx(float(one.height), rel=1e-6)


def test_a_ball_that_loads_the_wave_is_dry():
    wave = PassingWave(
        frequency=2.2e6, wavelength=1.8e-3, ratio=0.7, forward=5e-9, backward=0.0, compliance=2.5e-12,
        strip_width=1e-3, loading=True,
    )  # fmt: skip
    with pytest.raises(InputError, match=r"slider\.adhesion must be absent, on a wave that it loads"):
        steady(slider(adhesion=Adhesion(model="DMT", work=0.05)), wave, tolerance=1e-3)
