"""What the stator's problem is solved without is said where it holds, and only there."""

import fem
from studies.chain.neglected import driven_left_out, free_left_out


def plate(name, thickness=5e-3, **rest):
    return fem.Stator(
        solid=fem.rotated(fem.material(name), "Z"), length=0.02, thickness=thickness, ends="free", **rest
    )


def said(reasons, word):
    return any(word in reason for reason in reasons)


def test_a_free_wave_says_which_fields_it_lacks():
    ceramic, steel = free_left_out(plate("PZT-8")), free_left_out(plate("steel"))
    assert said(ceramic, "out-of-plane")
    assert not said(ceramic, "electric potential")
    assert said(steel, "electric potential")


def test_a_driven_stator_says_what_it_lacks():
    thick, thin = (driven_left_out(plate("PZT-8", size), 2.2e6) for size in (5e-3, 5e-4))
    assert said(thin, "a Rayleigh wave")
    assert not said(thick, "a Rayleigh wave")
    assert said(thick, "x -> -x is a symmetry")
    assert said(thick, "vacuum above")
    assert not said(driven_left_out(plate("PZT-8", above="vacuum"), 2.2e6), "vacuum above")
