"""Overtones of the wave under pillars: an integrator of its own with FFT, closed forms, energy, and published sizes."""

from dataclasses import replace

import numpy as np
import pytest

from contact import pillar_load_line, pillar_motion, pillar_traction
from contact.aliases import Renamed
from contact.averaged import overtone_cycle
from contact.averaged.coupled_equilibrium import Equilibrium
from contact.averaged.coupled_motion import CoupledSearch, truncated_motion
from tests.contact.test_pillars import LENGTH, SCENES, gaussian, grid, scatter, wave

K = 2.0 * np.pi / LENGTH


def named(motion):
    """Return an averaged motion with the attributes of its rows."""
    rows, places = motion.rows, {"velocity": motion.velocity, "approach": motion.height}
    return Renamed(rows, wave_work=sum(rows.work), normal_force=rows.forces.normal, **places)


def truncated(slider, passing, near, harmonics, load=0.0):
    """Return the motion with a fixed number of harmonics on the loaded wave, searched from another motion."""
    body, loaded = replace(slider, load=load), replace(passing, loading=True)
    return named(truncated_motion(body, loaded, near.loaded, harmonics))


def stop(z, y, c, turns=2):
    """Return the deformation at each sample of contacts (M, n) that follow y within |x| <= c z, in small steps."""
    x, out = np.zeros(z.shape[1]), np.empty_like(z)
    for _ in range(turns):
        for j in range(len(z)):
            step = y[j] - (y[j - 1] if j else y[-1] - 2.0 * np.pi * stop.drift)
            x = np.clip(x + step, -c * z[j], c * z[j])
            out[j] = x
    return out


def marched(slider, passing, motion, count, samples=512):
    """Return U_1 ... U_count at the exit and <P>, <Q> of all pillars, of a wave that runs forward alone.

    Rows by the implicit midpoint, the cycle in plain time steps, harmonics by FFT.
    """
    phase = 2.0 * np.pi * np.arange(samples) / samples
    w = motion.velocity / passing.omega
    U = np.zeros(count, dtype=complex)
    U[0] = passing.forward
    n, g = np.arange(1, count + 1), passing.compliance / passing.strip_width
    P0 = Q0 = 0.0
    stop.drift = -w
    for x in np.unique(slider.x):
        here = slider.x == x
        before, jump = U * np.exp(-1j * n * K * x), 0.0
        for _ in range(12):
            spectrum = np.zeros(samples // 2 + 1, dtype=complex)
            spectrum[1 : count + 1] = (before + 0.5 * jump) * samples / 2.0
            u_z = np.fft.irfft(spectrum, samples)
            u_x = np.fft.irfft(1j * passing.ratio * spectrum, samples)
            z = np.maximum(motion.approach + slider.heights[here] + u_z[:, None], 0.0)
            y = np.repeat((u_x - w * phase)[:, None], z.shape[1], axis=1)
            q = slider.tangential_stiffness[here] * stop(z, y, slider.limit_slope[here])
            p = slider.normal_stiffness[here] * z
            force = [(slider.weights[here] * each).sum(axis=1) for each in (p, q)]
            P, Q = (2.0 / samples * np.fft.rfft(each)[1 : count + 1] for each in force)
            jump = 1j * g * (P - 1j * passing.ratio * Q)
        U = (before + jump) * np.exp(1j * n * K * x)
        P0, Q0 = P0 + force[0].mean(), Q0 + force[1].mean()
    return U, P0, Q0


def test_the_overtones_are_those_of_time_steps_and_fft(monkeypatch):
    # Oracle: plain steps, of first order in q; what runs back is left out of both
    monkeypatch.setattr(overtone_cycle, "SAMPLES", 32)
    monkeypatch.setattr(overtone_cycle.OvertoneCycle, "wave_step", lambda self, *_: -self.waves)
    slider = grid(8, 3, pitch=90e-6, heights=scatter(24, 8e-9, 12), preload=0.12)
    passing = wave(strip_width=1e-4)
    motion = truncated(slider, passing, pillar_motion(slider, passing), 6)
    U, P0, Q0 = marched(slider, passing, motion, 6)
    assert motion.overtone > 0.08
    assert motion.overtones[-1] == pytest.approx(U[1:], abs=5e-4 * abs(U[1]))
    assert motion.exit_over_entry == pytest.approx(U[0] / 20e-9, abs=1e-4)
    assert (P0, Q0) == (pytest.approx(slider.preload, rel=1e-4), pytest.approx(0.0, abs=1e-3 * 0.18 * 0.12))


def test_one_harmonic_in_finer_samples_is_the_closed_form(monkeypatch):
    # Two methods of one model; the error falls as the square of the interval
    slider = grid(30, 20, heights=scatter(600, 8e-9, 4), tilt="pitch", preload_at=(1e-4, 0.0), curvature=1e-2)
    for passing in (wave(backward=5e-9j, strip_width=1.5e-3), wave(forward=5e-9j, backward=20e-9, strip_width=1.5e-3)):
        closed, errors = pillar_motion(slider, passing, load=0.01), []
        for samples in (64, 128, 256):
            monkeypatch.setattr(overtone_cycle, "FEWEST", samples)
            search = CoupledSearch(slider, replace(passing, loading=True))
            search.cycle = overtone_cycle.OvertoneCycle(slider, passing, True, 1)
            search.equilibrium = Equilibrium(search.cycle)
            search.begin_at(closed.loaded)
            found = named(search.motion(search.under(closed.load), closed.load))
            errors.append(abs(found.velocity / closed.velocity - 1.0))
            assert abs(found.ledger_residual) < 1e-12
        assert errors[2] < 5e-5
        assert 8.0 < errors[0] / errors[2] < 32.0
        assert found.exit_over_entry == pytest.approx(closed.exit_over_entry, abs=1e-4)
        assert found.reflected_over_entry == pytest.approx(closed.reflected_over_entry, abs=1e-4)


def test_overtones_are_as_large_as_independent_programs_say():
    # 30 N, 20 nm, 10 nm of scatter: |U_1| leaves with 11.9 nm, U_2 with 6 to 7, |v| = 1.07 to 1.14 m/s; at 1 N +3 %
    slider = gaussian(50, steps=24)
    found = truncated(slider, wave(), pillar_motion(slider, wave()), 16)
    assert 20.0 * abs(found.exit_over_entry) == pytest.approx(11.9, abs=0.2)
    assert 6.0 < 20.0 * found.overtone < 7.0
    assert 1.07 < -found.velocity < 1.14
    light = replace(gaussian(50, steps=24), preload=1.0)
    plain, rich = (pillar_motion(light, wave(), loading=each) for each in (True, "harmonics"))
    assert rich.velocity / plain.velocity == pytest.approx(1.03, abs=0.01)


@pytest.mark.parametrize(
    "name", [each for each in SCENES if each not in ("soft backing", "short contacts that answer many times over")]
)
def test_the_overtones_carry_power_away_and_no_more_than_there_is(name):
    slider, passing, load = SCENES[name]
    found = truncated(slider, passing, pillar_motion(slider, passing, load=load, loading=True), 8, load=load)
    assert abs(found.ledger_residual) < 1e-12
    assert found.wave_work == pytest.approx(found.wave_power_in - found.wave_power_out, abs=1e-12 * found.wave_power_in)
    assert 0.0 <= found.friction_power <= found.wave_power_in
    carried = sum(n * passing.power(each) for n, each in enumerate(found.exit_overtones, start=2))
    assert 0.0 < carried < found.wave_power_out
    assert slider.weights @ found.normal_force == pytest.approx(slider.preload, rel=1e-11)


def test_the_number_of_harmonics_follows_the_error():
    slider, passing = grid(12, 2), wave(strip_width=0.15e-3)
    found = pillar_motion(slider, passing, loading="harmonics")
    finer = truncated(slider, passing, found, 2 * found.harmonics)
    assert abs(finer.velocity / found.velocity - 1.0) < 2.0 * found.relative_error < 2e-3
    # a near motion keeps the number, so that derivatives are not those of the truncation
    again = pillar_motion(slider, passing, loading="harmonics", near=found)
    assert (again.harmonics, again.relative_error) == (found.harmonics, pytest.approx(found.relative_error, rel=1e-6))
    assert again.velocity == pytest.approx(found.velocity, rel=1e-10)
    # the estimate without them is that of their first order, an upper bound
    assert found.overtone < pillar_motion(slider, passing).overtone < 3.0 * found.overtone


def test_load_lines_and_tractions_have_the_overtones_of_the_free_motion():
    slider, passing = grid(10, 5, heights=scatter(50, 10e-9, 8)), wave(strip_width=0.25e-3)
    line = pillar_load_line(slider, passing, points=4, loading="harmonics")
    assert {each.harmonics for each in line.motions} == {line.motions[0].harmonics}
    assert line.motions[0].harmonics > 1
    assert np.all(np.diff(abs(line.velocity)) < 0.0)
    plain = pillar_load_line(slider, passing, points=2)
    assert line.stall == pytest.approx(plain.stall, rel=2e-3)
    assert line.stall != pytest.approx(plain.stall, rel=2e-4)
    traction = pillar_traction(slider, passing, near=line.motions[1])
    assert traction(line.velocity[1]) == pytest.approx(line.motions[1].load, rel=1e-8)


def test_a_load_that_only_the_overtones_carry_is_carried():
    slider, passing = grid(12, 2, heights=scatter(24, 20e-9, 8)), wave(strip_width=0.15e-3)
    with pytest.raises(ValueError, match="its stall"):
        pillar_motion(slider, passing, load=12.165e-3)
    assert pillar_motion(slider, passing, load=12.165e-3, loading="harmonics").velocity < 0.0
    with pytest.raises(ValueError, match="its stall"):
        pillar_motion(slider, passing, load=12.25e-3, loading="harmonics")


def test_a_soft_backing_has_no_overtones():
    with pytest.raises(ValueError, match='loading must not be "harmonics" with a soft backing'):
        pillar_motion(SCENES["soft backing"][0], wave(), loading="harmonics")
