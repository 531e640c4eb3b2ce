"""The hysteretic law in any normal force that begins as a sphere's, and its loads: limits, energies, other solvers."""

from dataclasses import replace

import numpy as np
import pytest

from contact import MeanField, RoughBalls, Roughness, TabulatedForce, blocked_thrust, mean_traction, steady
from contact.law import hysteretic
from contact.problem import ContactParameters
from tests.contact.test_asperity_motion import orbit
from tests.contact.test_memory import Contact
from tests.contact.test_memory_motion import E, R, body

pytestmark = pytest.mark.slow  # their kernels are compiled for these tests alone

K = 4 / 3 * E * np.sqrt(R)


def bent():
    """Two power laws, over 1 um."""
    return TabulatedForce.of(lambda z: K * (0.4 * z**1.5 + 1e8 * z**2.5), scale=1e-9, end=1e-6)


def test_a_table_of_hertz_has_the_motion_of_the_smooth_ball():
    table = TabulatedForce.of(lambda z: K * z**1.5, scale=1e-9, end=1e-6)
    smooth, tabulated = (steady(each, orbit(3e-9), tolerance=1e-5) for each in (body(), body(normal_law=table)))
    assert float(tabulated.velocity) == pytest.approx(float(smooth.velocity), rel=1e-7)
    assert tabulated.ledger.slip == pytest.approx(smooth.ledger.slip, rel=1e-6)


@pytest.mark.parametrize("force", [bent(), MeanField(R, E, Roughness(rms=3e-9)).tabulated()])
def test_its_energies_balance(force):
    for wave, given in ((orbit(3e-9), {}), (orbit(8e-9), {"load": 5e-6})):
        state = steady(body(normal_law=force, **given), wave, tolerance=1e-4)
        assert state.status == "ok"
        assert state.ledger.relative_residual < 1e-9
        assert state.ledger.slip > 0.0


def test_springs_of_another_force():
    """Stops of equal stiffness, at the depths where p' has risen by equal parts."""
    law = bent().law(K)
    law = law.scaled(law, 1e-9)
    unit = ContactParameters(1.0, 0.107, 1.0, 0.0, 0.0, law, 1.0, 1.0, hysteretic.mindlin_deresiewicz())
    eta = np.linspace(0.0, 3.0, 300_001)
    rise = law.slope(eta, law)
    levels = rise[-1] * (np.arange(4000) + 0.5) / 4000
    depth, stiffness = np.interp(levels, rise, eta), rise[-1] / 4000 / 0.107
    stretched, contact = np.zeros(depth.size), Contact(unit)
    z0, x0 = 1.0, 0.0
    for z, x in ((1.2, 0.05), (0.9, 0.01), (1.6, -0.06), (1.5, 0.09), (2.4, 0.07)):
        for share in np.linspace(0.0, 1.0, 801)[1:]:
            limit = 0.107 * np.maximum(z0 + share * (z - z0) - depth, 0.0)
            stretched = np.clip(stretched + (x - x0) / 800, -limit, limit)
        z0, x0 = z, x
        assert contact.go(z, x) == pytest.approx(stiffness * stretched.sum(), abs=2e-3 * law.force(1.0, z, law))
        assert contact.energy() == pytest.approx(0.5 * stiffness * (stretched**2).sum(), rel=1e-2, abs=1e-4)


@pytest.mark.parametrize("force", [None, MeanField(R, E, Roughness(rms=3e-9)).tabulated()])
def test_loads_of_the_hysteretic_law(force):
    """The mean traction at a velocity is the load under which it runs so; beyond the thrust the load moves it."""
    slider, wave = body(normal_law=force), orbit(8e-9)
    free = float(steady(slider, wave, tolerance=1e-4).velocity)
    (load,) = mean_traction(slider, wave, np.array([0.5 * free]))
    loaded = steady(replace(slider, load=float(load)), wave, tolerance=1e-4)
    assert float(loaded.velocity) == pytest.approx(0.5 * free, rel=1e-3)
    thrust, held = blocked_thrust(slider, wave)
    assert 0.0 < load < thrust <= held + 1e-12
    if force is not None:
        heavy = [
            RoughBalls(body(load=share * thrust), [MeanField(R, E, Roughness(rms=3e-9))]).velocity(wave, tolerance=1e-3)
            for share in (0.995, 1.005)
        ]
        assert heavy[0].value > 0.0 > heavy[1].value  # the load that exceeds the thrust moves it back
