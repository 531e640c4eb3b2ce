"""A burst through the whole chain: the contact sees the wave grow.  Limits and the record's words."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import fem
from studies import Scene
from studies.model.model import Model
from studies.model.resolve import build, resolved
from studies.remarks.neglected_effects import left_out
from studies.runs import run
from studies.scene import read_table
from studies.solve.ring_up import RingUp, ring_up
from tests.studies.settings import assigned


def chip(*settings):
    base = [
        "stator.length=30 mm",
        "stator.thickness=3 mm",
        "transducer.0.center=7 mm",
        "transducer.0.period=0.98 mm",
        "transducer.0.finger_pairs=8",
        "slider.position=18 mm",
        "drive.voltage=[0, 150]",
        "drive.burst=0.1 ms",
    ]
    table = read_table("twente-left")
    table["stator"]["material"] = {"name": "lossy", **_lossy()}
    for setting in [*base, *settings]:
        table = assigned(table, setting)
    return Scene.from_table("", table)


def _lossy():
    """PZT-8 of quality 40, so that the plate falls silent soon."""
    solid = fem.material("PZT-8")
    return {
        "stiffness": solid.stiffness.tolist(),
        "coupling": solid.coupling.tolist(),
        "permittivity": (solid.permittivity / 8.8541878128e-12).tolist(),
        "density": solid.density,
        "mechanical_quality": 40,
    }


@pytest.fixture(scope="module")
def record():
    return run(chip(), tolerance=2e-2)


def test_the_slider_starts_when_the_wave_arrives(record):
    """Nothing before the way over the velocity, less half the transit; steady waves start at once."""
    (_, still), (_, motion) = record.trajectories
    assert np.all(still.velocity == 0.0)
    assert motion.method == "stepped"
    speed = record.wave["phase_velocity_m_per_s"]
    arrival, transit = 11e-3 / speed, 8e-3 / speed
    before = motion.time < arrival - 0.6 * transit
    during = (motion.time > 30e-6) & (motion.time < motion.duration)
    assert abs(motion.velocity[before]).max() < 0.02 * abs(motion.velocity[during]).max()
    steady = run(replace(chip(), slider=replace(chip().slider, method="exact")), tolerance=2e-2)
    (_, plain) = steady.trajectories[1]
    assert plain.method == "exact"
    early = plain.velocity[plain.time < arrival - 0.6 * transit]
    assert abs(early).max() > 5 * abs(motion.velocity[before]).max()
    assert any("2 of 2 bursts, which are computed on a steady wave" in reason for reason in steady.left_out)
    assert any("ring-down: in 2 of 2 bursts the surface stops" in reason for reason in steady.left_out)


def test_the_record_says_how_long_the_wave_takes_to_settle(record):
    speed = record.wave["phase_velocity_m_per_s"]
    settling = record.wave["settling_time_s"]
    assert (11e-3 + 3e-3) / speed < settling < 5 * 18e-3 / speed


def test_the_surface_rings_down_under_the_slider():
    """While waves still arrive the slider goes on with them: it is faster than at the burst's end."""
    record = run(chip("drive.voltage=40"), tolerance=2e-2)
    ((_, motion),) = record.trajectories
    assert motion.rang > 0.5 * record.wave["settling_time_s"]
    later = (motion.time > motion.duration) & (motion.time <= motion.duration + motion.rang)
    assert later.sum() > 10
    # the way from the comb takes 11 mm over the velocity, at the drive's own rise of v
    way = 11e-3 / record.wave["phase_velocity_m_per_s"]
    slope = abs(motion.velocity_at_burst_end) / motion.duration
    assert abs(motion.velocity[later]).max() > abs(motion.velocity_at_burst_end) + 0.3 * slope * way
    assert not any("ring-down" in reason for reason in record.left_out)


@pytest.mark.slow
def test_the_error_knows_the_envelope_s(record):
    """Its part: the envelope's error for as long as it rings up, over the burst."""
    longer = run(chip("drive.burst=0.4 ms"), tolerance=2e-2)
    parts = [each.error["parts"]["stator"] for each in (record, longer)]
    scene = resolved(chip())
    own = ring_up(Model(scene), scene.slider.center)
    assert own.error == pytest.approx(own.response.relative_error * own.response.settling / 0.1e-3, rel=1e-12)
    assert parts[0] - parts[1] == pytest.approx(0.75 * own.error, rel=1e-2)


def test_without_a_burst_nothing_rings():
    scene = replace(chip(), drive=replace(chip().drive, burst=None))
    assert not any("ring-up" in reason for reason in left_out(build(scene)))
    assert "the burst's ring-up: the slider stands over a transducer or a meshed piece" in left_out(build(chip()))


def test_a_stator_that_rings_too_long_is_an_error_and_said(monkeypatch):
    from importlib import import_module

    ring = import_module("studies.solve.ring_up")

    monkeypatch.setattr(ring, "MAX_FREQUENCIES", 40)
    scene = chip("drive.burst=2 ms", "drive.voltage=60", "stator.material=PZT-8")
    record = run(scene, tolerance=2e-2)
    assert "settling_time_s" not in record.wave
    width = 2 * 1.2 / 8 * 2.2e6
    rings = 40 / width / 2e-3
    assert rings < record.error["parts"]["stator"] < 1.4 * rings  # and the steady wave's own
    assert any("rings for too long to be followed" in reason for reason in record.left_out)


@pytest.mark.parametrize(("burst", "error"), [("2 ms", 1.0), ("9 ms", 4096 / 0.66e6 / 9e-3)])
def test_a_ring_up_that_is_not_resolved_errs_by_its_part_of_the_burst_or_the_whole(monkeypatch, burst, error):
    """4096 frequencies over 0.66 MHz (1.2 / 8 of 2.2 MHz on both sides) resolve 6.2 ms."""
    from importlib import import_module

    def refuse(*given, **rest):
        raise fem.ConvergenceError("rings on")

    ring = import_module("studies.solve.ring_up")
    monkeypatch.setattr(ring, "response", lambda *given, **rest: None)
    monkeypatch.setattr(fem, "burst_response", refuse)
    monkeypatch.setattr(ring, "MAX_FREQUENCIES", 4096)
    found = ring.ring_up(Model(chip(f"drive.burst={burst}")), (0.018, 0.0))
    assert found.response is None
    assert found.error == pytest.approx(error, rel=1e-12)


@pytest.mark.parametrize(("settling", "share"), [(2e-5, 0.4), (9e-5, 1.0)])
def test_the_error_of_a_burst_is_the_envelopes_while_it_settles(settling, share):
    """An envelope that is wrong by 0.02 while it settles moves the velocity at the burst's end by that share of it."""
    time = np.linspace(0.0, 1e-4, 11)
    burst = SimpleNamespace(
        normal=np.full(11, 2j), steady_normal=4.0, time=time, duration=5e-5, settling=settling, relative_error=0.02
    )
    found = RingUp.of(burst)
    assert found.error == pytest.approx(0.02 * share, rel=1e-12)
    assert found.envelope.amplitude == pytest.approx(np.full(5, 0.5))
    assert found.ring_down.time[0] == pytest.approx(0.0, abs=1e-18)


@pytest.mark.parametrize("first", ["left", "right"])
def test_the_band_of_several_sources_is_that_of_the_transducer_of_fewest_pairs(monkeypatch, first):
    """Its main lobe is the widest; whichever of both is the first, and only if it is driven."""

    class FoundError(Exception):
        pass

    def response(model, low, high, **_):
        raise FoundError(low / model.scene.frequency, high / model.scene.frequency)

    monkeypatch.setattr("studies.solve.ring_up.response", response)
    scene = resolved(Scene.load("twente").replace(transducer={"right": {"finger_pairs": 6}}))
    scene = scene.with_source(burst=1e-3)
    for sources, pairs in (({first: 1.0, {"left": "right", "right": "left"}[first]: 0.3}, 6), ({"left": 1.0}, 10)):
        drive = replace(scene.drive, transducer=None, sources=tuple(sources.items()))
        with pytest.raises(FoundError) as found:
            ring_up(Model(replace(scene, drive=drive)), (0.08, 0.0))
        assert found.value.args == pytest.approx((1 - 1.2 / pairs, 1 + 1.2 / pairs), rel=1e-12)
