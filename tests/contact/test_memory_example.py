"""The worked example in the text of `contact.law.hysteretic`, number by number."""

import pytest

from contact.body import Point
from contact.codes import Regime
from contact.events.collocation import collocation
from contact.law import hysteretic
from contact.law.normal import SPHERE
from contact.problem import ContactParameters

C = 0.1


def test_the_worked_example_of_the_hysteretic_law():
    memory, regime, sign, x = hysteretic.blank(1, collocation(12)), Regime.SEPARATED, 1.0, 0.0
    unit = ContactParameters(1.0, C, 1.0, 0.0, 0.0, SPHERE, 1.0, 1.0, hysteretic.mindlin_deresiewicz())
    known = []
    z = 0.0
    for to in (0.0, 0.04, 0.0, -0.04):
        old, new = Point(z, x, 0.0, 0.0), Point(1.0, to, 0.0, 0.0)
        regime, sign, x = hysteretic.jump(memory, 0, regime, sign, old, new, unit)
        z = 1.0
        force, front = hysteretic.moment(memory, 0, regime, sign, z, x, C, SPHERE)
        chain = [int(kind) for kind in memory.kind[0, : memory.number[0]]]
        known.append((regime, sign, chain, force, front))
    pressed, sheared, back, beyond = known
    assert pressed[0] == Regime.GROW
    assert pressed[2:4] == ([0], 0.0)
    assert sheared[:3] == (Regime.ANNULUS, 1.0, [0])
    assert sheared[3:] == (pytest.approx(1.0 - 0.6**1.5, rel=1e-12), pytest.approx(0.6, rel=1e-12))
    assert back[:3] == (Regime.ANNULUS, -1.0, [0, 1])
    assert back[3] == pytest.approx(2.0 * 0.8**1.5 - 0.6**1.5 - 1.0, rel=1e-12)
    assert back[3] == pytest.approx(-0.0337, abs=5e-5)
    assert back[4] == pytest.approx(0.8, rel=1e-12)
    assert beyond[1:3] == (-1.0, [0])
    assert beyond[3:] == (pytest.approx(0.6**1.5 - 1.0, rel=1e-12), pytest.approx(0.6, rel=1e-12))
