"""Errors that were planted once and that no test noticed: values where there were bounds, unequal cases."""

import math

import numpy as np
import pytest

from contact import steady
from contact.codes import Regime
from contact.error_estimate import reference_speed
from contact.events.collocation import collocation
from contact.events.motion import Motion
from contact.jit import compiled
from contact.periodic import settling
from contact.problem import scaled
from tests.contact.motors import orbit, slider


def test_a_copied_hysteretic_motion_goes_on_as_the_first_while_a_contact_grows():
    """The loading curve of a growing contact is a part of what it remembers: cut the run there and go on twice."""
    body = slider(law="hysteretic")
    problem = scaled(body, (orbit(2e-9, 0.1),), direction=1.0, start=-0.5 * np.pi)
    motion = Motion(problem, grid=collocation(12), truncation=1e-10)
    motion.set_state(-body.rest_approach(1) / problem.length, 0.0, 0.0, 0.0)
    motion.turn(30)
    grew, at = 0, np.linspace(0.05, 1.0, 4)
    for phase in np.linspace(0.2, 5.2, 26):
        first = motion.copy()
        first.move(0.0, phase, np.empty(0))
        grew += int(first.regime[0] == Regime.GROW)
        second = first.copy()
        ahead = first.move(phase, phase + 1.0, phase + at)
        again = second.move(phase, phase + 1.0, phase + at)
        np.testing.assert_array_equal(again, ahead)
        assert np.array_equal(second.state, first.state)
    assert grew >= 2


def test_two_starts_that_end_at_different_speeds_widen_the_stated_error(monkeypatch):
    """Near its resonance the slider hops irregularly; the second start is told to end faster by a known amount."""
    body, wave = slider(normal_damping=0.1), orbit(6e-9, frequency=8e3)
    calls, real = [], settling.run_from

    def followed(*given):
        run = real(*given)
        calls.append(run)
        return settling.replace(run, speed=run.speed + 3.0 * run.error) if len(calls) == 2 else run

    monkeypatch.setattr(settling, "run_from", followed)
    run = settling.long_run(body, (wave,), 1.0)
    assert len(calls) == 2
    assert run.starts == 2
    apart = abs(calls[1].speed + 3.0 * calls[1].error - calls[0].speed)
    assert run.error == pytest.approx(max(calls[0].error, calls[1].error, apart), rel=1e-12)
    assert run.error >= apart


@pytest.mark.parametrize("changed", [{"law": "hysteretic"}, {"reciprocal": True}])
@pytest.mark.parametrize("amplitude", [1.5e-9, 5e-9, 15e-9])
def test_averaged_errors_of_laws_that_only_the_events_know_bound_the_exact_difference(changed, amplitude):
    body = slider(**changed, mass=2e-5)
    wave = orbit(amplitude)
    mean = steady(body, wave, tolerance=1.0, method="averaged")
    full = steady(body, wave, tolerance=1e-6, method="exact")
    error = abs(mean.velocity - full.velocity) / reference_speed(full.velocity, (wave,))
    assert 0.0 < error < mean.relative_error
    ratio = body.normal_resonance(1) / wave.frequency
    assert mean.relative_error == pytest.approx(3.0 * ratio**2, rel=1e-12)


def test_the_energies_of_a_hop_of_two_cycles_are_joules_of_one_cycle():
    """By the definition alone: force times surface velocity, summed over both cycles and halved."""
    body, wave = slider(), orbit(3e-9, frequency=12e3)
    found = steady(body, wave, tolerance=1e-8)
    assert found.statistics["period_cycles"] == 2
    run = settling.long_run(body, (wave,), 1.0)
    motion, problem = run.motion.copy(), run.motion.problem
    unit = body.mass * problem.omega**2 * problem.length**2
    at = 2.0 * math.pi * (np.arange(20000) + 0.5) / 20000
    work = 0.0
    for _ in range(2):
        _, _, normal, tangential, _, _ = np.moveaxis(motion.move(0.0, 2.0 * math.pi, at)[:, 0], -1, 0)
        paths = problem.paths
        w_z = -paths.normal_cos[0] * np.sin(at) + paths.normal_sin[0] * np.cos(at)
        w_x = -paths.tangential_cos[0] * np.sin(at) + paths.tangential_sin[0] * np.cos(at)
        work += float(np.mean(normal * w_z + tangential * w_x)) * 2.0 * math.pi * unit
    assert found.ledger.wave == pytest.approx(0.5 * work, rel=2e-4, abs=0.0)
    assert found.ledger.wave > 0.0


def test_kernels_for_other_processors_lie_in_another_folder(monkeypatch):
    """The same processor name with other features, as in two virtual machines on one host."""
    import llvmlite.binding as llvm

    features = llvm.get_host_cpu_features()
    own = compiled.source_digest()

    class Other(dict):
        def flatten(self):
            return features.flatten().replace("+sse4.2", "-sse4.2") + ",+another"

    monkeypatch.setattr(llvm, "get_host_cpu_features", Other)
    assert compiled.source_digest() != own
