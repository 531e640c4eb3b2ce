"""Moduli of a ball on a stator.  Oracle: the static surface compliance by Stroh's eigenproblem, no closed form."""

import numpy as np
import pytest

import fem
from studies.refusal import SceneError
from studies.scene import Scene, read_table
from studies.scene.modulus import indentation_modulus, pair_moduli, tangential_compliance
from studies.scene.resolved import resolved

VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])


def surface_compliance(c, angle):
    """Displacement times |k| for unit traction exp(i k.x) on the half-space z < 0; shape (3, 3), 1/Pa."""
    full = c[VOIGT][:, :, VOIGT]  # c_ijkl
    m, n = np.array([np.cos(angle), np.sin(angle), 0.0]), np.array([0.0, 0.0, 1.0])

    def mixed(a, b):
        return np.einsum("i,ijkl,l->jk", a, full, b)

    q, r, t = mixed(m, m), mixed(m, n), mixed(n, n)
    inverse = np.linalg.inv(t)
    stroh = np.block([[-inverse @ r.T, inverse], [r @ inverse @ r.T - q, -r @ inverse]])
    roots, vectors = np.linalg.eig(stroh)
    decaying = roots.imag < 0  # exp(i k p z) at z -> -infinity
    a, b = vectors[:3, decaying], vectors[3:, decaying]
    return np.linalg.inv(1j * b @ np.linalg.inv(a))


def averaged(c):
    """Normal and tangential compliance of a pressed circle: over the directions of k."""
    angles = np.arange(16) * np.pi / 16 + 0.1
    every = [surface_compliance(c, angle).real for angle in angles]
    return np.mean([s[2, 2] for s in every]), np.mean([s[0, 0] + s[1, 1] for s in every])


def test_the_oracle_gives_the_isotropic_half_space():
    steel = fem.isotropic(name="steel", youngs_modulus=210e9, poisson_ratio=0.3, density=7850).stiffness
    near = steel + np.diag([0, 0, 1e3, 0, 0, 0])  # Stroh's eigenvalues of an isotropic solid coincide
    normal, tangential = averaged(near)
    assert normal == pytest.approx(2 * (1 - 0.3**2) / 210e9, rel=1e-3)
    assert tangential == pytest.approx((2 - 0.3) / (210e9 / 2.6), rel=1e-3)


@pytest.mark.parametrize("name", ["PZT-4", "PZT-8", "PZT-5H", "PIC181"])
def test_closed_forms_against_the_oracle(name):
    c = fem.material(name).stiffness
    normal, tangential = averaged(c)
    assert 2 / indentation_modulus(c) == pytest.approx(normal, rel=1e-9)
    assert tangential_compliance(c) == pytest.approx(tangential, rel=1e-9)


def test_closed_forms_in_the_isotropic_limit():
    steel = fem.isotropic(name="steel", youngs_modulus=210e9, poisson_ratio=0.3, density=7850).stiffness
    assert indentation_modulus(steel) == pytest.approx(210e9 / (1 - 0.3**2), rel=1e-12)
    assert tangential_compliance(steel) == pytest.approx((2 - 0.3) / (210e9 / 2.6), rel=1e-12)


def test_steel_on_hard_pzt_gives_the_values_of_the_paper():
    normal, tangential = pair_moduli("steel", fem.material("PZT-8"))
    assert normal == pytest.approx(65.8e9, rel=1e-3)  # contract.md; the paper: 64 GPa
    assert tangential == pytest.approx(13.7e9, rel=5e-3)  # contract.md; the paper: 12 GPa


def test_a_ball_in_a_scene_resolves_to_its_moduli():
    table = read_table("twente-left")
    del table["slider"]["effective_modulus"], table["slider"]["tangential_modulus"]
    table["slider"]["ball"] = "steel"
    slider = resolved(Scene.from_table("", table)).slider
    assert (slider.effective_modulus, slider.tangential_modulus) == pair_moduli(
        "steel", fem.material("PZT-8")
    )
    assert slider.ball is None


@pytest.mark.parametrize(
    ("ball", "material", "orientation", "words"),
    [
        ("steal", "PZT-8", "Z", "steel"),
        ("PZT-4", "PZT-8", "Z", "isotropic"),
        ("steel", "PZT-8", "X", "no axis of symmetry"),
        ("steel", "LiNbO3 (Warner)", "YZ", "no axis of symmetry"),
        ("steel", "LiNbO3 (Warner)", "Z", "no axis of symmetry"),
    ],
)
def test_what_has_no_closed_form_is_refused(ball, material, orientation, words):
    with pytest.raises(SceneError, match=rf"^slider\.ball .*{words}"):
        pair_moduli(ball, fem.rotated(fem.material(material), orientation))
