"""What the stator's problem is solved without is said where it holds, and only there."""

from studies import Scene
from studies.model.resolve import build
from studies.remarks.neglected_effects import left_out


def reasons(name, **stator):
    return left_out(build(Scene.load(name).replace(stator=stator)))


def said(reasons, word):
    return any(word in reason for reason in reasons)


def test_a_free_wave_says_which_fields_it_lacks():
    ceramic, steel = reasons("rayleigh"), reasons("rayleigh", material="steel")
    assert said(ceramic, "out-of-plane")
    assert not said(ceramic, "electric potential")
    assert said(steel, "electric potential")


def test_a_driven_stator_says_what_it_lacks():
    thick, thin = (reasons("twente-left", thickness=size) for size in (5e-3, 5e-4))
    assert said(thin, "a Rayleigh wave")
    assert not said(thick, "a Rayleigh wave")
    assert said(thick, "x -> -x is a symmetry")
    assert said(thick, "vacuum above")
    assert not said(reasons("twente-left", above="vacuum"), "vacuum above")
