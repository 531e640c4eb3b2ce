"""The moduli of a ball on the stator, from the static response of each to a load on its surface.

    1/E* = 1/M + (1 - nu^2)/E of the ball        M: indentation modulus of the stator
    1/G* = S + (2 - nu)/G of the ball            S: tangential compliance of the stator, (2 - nu)/G if it is isotropic

M and S are averages of the stator's compliance over the directions in its surface (``fem.point_load``). They are exact
if the normal is an axis of symmetry; otherwise the slightly elliptical contact is taken as circular. The elastic
constants are c^E: the stiffening by the electric field is neglected, which would raise M by a few per cent. G* gives
the tangential stiffness 8 a G* of R. D. Mindlin, J. Appl. Mech. 16 (1949) 259.
"""

import numpy as np

import fem
from studies.model.scene_errors import input_errors
from studies.refusal import SceneError

ISOTROPY = 1e-6  # relative; a catalogue's digits keep the symmetry far better


def pair_moduli(ball: str, solid) -> tuple[float, float]:
    """Return E* and G* in Pa of a ball, an isotropic solid of the catalogue, on a stator's solid in its own axes.

    Examples
    --------
    >>> import fem
    >>> [round(modulus / 1e9, 1) for modulus in pair_moduli("steel", fem.material("PZT-8"))]
    [65.8, 13.7]
    """
    with input_errors("slider.ball"):
        sphere = fem.material(ball)
    if not _is_isotropic(sphere.stiffness):
        raise SceneError("slider.ball", f'must be an isotropic solid such as "steel", got {ball!r}')
    below, above = fem.point_load(solid.stiffness), fem.point_load(sphere.stiffness)
    normal = 1 / below.indentation_modulus + 1 / above.indentation_modulus
    return 1 / normal, 1 / (below.tangential_compliance + above.tangential_compliance)


def direction_dependence(solid) -> str:
    """Return how the contact's stiffness depends on the direction in a stator's surface; empty where it does not."""
    below = fem.point_load(solid.stiffness)
    if max(below.spread, abs(below.coupling)) < ISOTROPY:
        return ""
    sideways = ""
    if abs(below.coupling) >= 5e-4:  # three decimals
        sideways = f", a normal load moves it along x by {below.coupling:+.3f} of its indentation"
    return f"stiffness +-{100 * below.spread:.1f} %{sideways}"


def _is_isotropic(c: np.ndarray) -> bool:
    """Return whether a stiffness (6, 6) in Pa is that of an isotropic solid."""
    lame, shear = float(c[0, 1]), float(c[3, 3])
    expected = np.diag([2 * shear] * 3 + [shear] * 3)
    expected[:3, :3] += lame
    return bool(np.max(np.abs(c - expected)) <= ISOTROPY * np.max(np.abs(c)))
