"""Waves of layers followed against the thickness: ends, names, and the waves of each thickness alone."""

import numpy as np
import pytest

import fem

SILICON, PZT8 = (fem.rotated(fem.material(name), "Z") for name in ("silicon (cubic)", "PZT-8"))
KOVACS = fem.rotated(fem.material("LiNbO3 (Kovacs)"), "128YX")


def layer(solid, wavelengths=1.0):
    return fem.Layer(solid=solid, wavelengths=wavelengths)


def test_each_wave_is_that_of_its_thickness_and_none_is_missed():
    factors = np.array([0.05, 0.2, 0.3, 0.5])
    branches = fem.wave_branches(SILICON, [layer(PZT8)], factors)
    assert [each.name for each in branches] == ["Rayleigh", "Sezawa", "sagittal 3", "sagittal 4"]
    for factor in factors:
        alone = fem.layered_waves(SILICON, [layer(PZT8, factor)])
        followed = [wave for branch in branches for at, wave in zip(branch.factors, branch.waves, strict=True)
                    if at == factor]  # fmt: skip
        assert sorted(wave.velocity for wave in followed) == [wave.velocity for wave in alone]


def test_a_stiff_coating_ends_the_bound_wave():
    """layered.md, section 4: AlN on 128YX has none from h/lambda between 0.005 and 0.006 on."""
    aln = fem.rotated(fem.material("AlN (Tsubouchi)"), "Z")
    (branch,) = fem.wave_branches(KOVACS, [layer(aln)], np.linspace(0.0005, 0.01, 12))
    assert branch.begins is None
    assert branch.ends is not None
    assert 0.005 < branch.ends < 0.006
    fem.layered_waves(KOVACS, [layer(aln, branch.ends * (1 - 1e-3))])
    with pytest.raises(fem.ConvergenceError):
        fem.layered_waves(KOVACS, [layer(aln, branch.ends * (1 + 1e-3))])


def test_a_wave_begins_where_its_velocity_is_the_limit():
    _, sezawa = fem.wave_branches(SILICON, [layer(PZT8)], [0.04, 0.1])
    assert sezawa.begins is not None
    just_bound = fem.layered_waves(SILICON, [layer(PZT8, sezawa.begins * (1 + 1e-3))])[1]
    assert just_bound.velocity == pytest.approx(just_bound.limiting_velocity, rel=1e-3)


def test_waves_that_come_close_keep_their_motion():
    """LN on SiO2 on silicon: a transverse wave crosses; each branch stays of its kind."""
    stack = [layer(fem.rotated(fem.material("fused silica"), "Z"), 0.4), layer(KOVACS, 0.6)]
    for branch in fem.wave_branches(SILICON, stack, np.linspace(0.05, 0.7, 20)):
        velocities = np.array([each.velocity for each in branch.waves])
        assert np.all(abs(np.diff(velocities)) < 0.12 * velocities[1:])
        kinds = {each.name.split()[0] == "Love" for each in branch.waves}
        assert kinds == {branch.name.startswith("Love")}


def test_thicknesses_that_do_not_rise_are_refused():
    with pytest.raises(fem.InputError, match="at least two that are positive and rise"):
        fem.wave_branches(SILICON, [layer(PZT8)], [0.2, 0.1])
    with pytest.raises(fem.ConvergenceError, match="leaks"):
        fem.wave_branches(KOVACS, [layer(fem.material("diamond"))], [0.3, 0.4])
