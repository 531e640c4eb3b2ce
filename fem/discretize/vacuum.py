"""Elements of the vacuum above the surface: their heights grow as a geometric series, and the last one stands for more.

The charge that a field exp(-i k x) leaves to the vacuum is eps_0 |k| phi.  A column of height H up to which D leaks
nowhere gives eps_0 k tanh(k H) instead: wrong for k H < 1, that is for the static field at a distance H.  In a plate
whose potential floats that field reaches far.  With the permittivity of the plate along x, eps_p, a source of charge s
makes

    phi = s / (eps_0 (D k^2 + |k|)),    D = h eps_p / eps_0,                                                   (1)

so that the vacuum decides beyond D, tens or thousands of wavelengths.  The height is therefore a multiple of D and of
the length, which a level doubles, so that the error estimate sees it.

Of the field E = -d phi / d x of a dipole, the part that a wrong charge Y(k) instead of |k| adds is

    int k^2 (1 / (D k^2 + Y) - 1 / (D k^2 + k)) dk = int (k^2 / Y - k) dk - D (...) / H^3.                      (2)

The first integral is pi^2 / 12 H^2 for Y = k tanh(k H), and zero if the last element conducts D along the surface
`LAST_ALONG` times as well as vacuum does.  A level then divides the error by 8.  Between closed ends all k are
multiples of pi / length; a column a few lengths high is then exact.
"""

from collections.abc import Sequence

import numpy as np

from fem.discretize.element_sizes import LAYER_RATIO, Resolution, graded
from fem.geometry import Stator
from fem.materials.medium import Medium, units, vacuum_medium

# Height up to an element over that below it.  At the orders of the levels, from 5 to 10, eps_0 |k| is then right to
# 6e-6 to 1e-9 from k = 20 / H to 2 wavenumbers of the slowest bulk wave, if the first element is at most START.
GROWTH, START = 4.0, 0.25
# Permittivity along the surface of the last of these elements for which the first integral of (2) vanishes.
LAST_ALONG = 1.3526658716
# Height over D + length at the coarsest level, and the least height in length units, which the field of fingers needs.
REACH, LEAST = 2.0, 64.0
CLOSED_REACH = 4.0  # over the length between closed ends, where the error is exp(-2 pi H / length)


def vacuum_elements(
    stator: Stator, bodies: Sequence[Medium], resolution: Resolution, *, wavelength: float, top: float, layers: int
) -> tuple[np.ndarray, list[Medium]]:
    """Heights of the elements above the surface from there up, length units, and the medium of each.

    Parameters
    ----------
    stator : Stator
    bodies : sequence of Medium
        Its solids from the bottom up, in the fields that take part.
    resolution : Resolution
    wavelength : float
        Length unit, m.
    top : float
        Height of the solid's uppermost element before it is graded, length units.
    layers : int
        Layers into which it is graded.
    """
    medium = vacuum_medium(*units(*stator.solids))
    if stator.plane:  # the fingers are below the surface: the field above varies over their distance from it
        distance = sum(each.thickness or 0.0 for each in stator.layers[-stator.plane :]) / wavelength
        top, growth = START, 1.0 / LAYER_RATIO
        finer = np.log(START / (growth - 1.0) / distance) / np.log(growth)
        layers = min(layers, max(0, int(np.ceil(finer))))
    first = graded(min(top, START), layers, largest=resolution.element_size, smallest_first=True)
    height, closed = needed_height(stator, bodies, resolution, wavelength)
    start, stop = first.sum(), height / GROWTH
    count = max(1, int(np.ceil(np.log(stop / start) / np.log(GROWTH))))
    between = np.diff(np.geomspace(start, stop, count + 1))
    heights = np.concatenate([first, between, [height - stop]])
    last = medium if closed else vacuum_medium(*units(*stator.solids), along=LAST_ALONG)
    return heights, [medium] * (len(heights) - 1) + [last]


def needed_height(
    stator: Stator, bodies: Sequence[Medium], resolution: Resolution, wavelength: float
) -> tuple[float, bool]:
    """Least height of the vacuum in length units, and whether closed ends bound the field."""
    length = stator.length / wavelength
    if stator.ends != "absorbing":
        return float(np.clip(CLOSED_REACH * length, LEAST, resolution.vacuum)), True
    reach = length
    if stator.bottom != "grounded" and not stator.absorbs_below:
        thicknesses = [stator.thickness, *(each.thickness or 0.0 for each in stator.layers)]
        reach += sum(
            plate_reach(stator, body, wavelength, thickness)
            for body, thickness in zip(bodies, thicknesses, strict=True)
            if "phi" in body.fields
        )
    return float(np.clip(REACH * 2**resolution.absorber * reach, LEAST, resolution.vacuum)), False


def plate_reach(stator: Stator, body: Medium, wavelength: float, thickness: float) -> float:
    """D of equation (1) in length units: the larger one of the static plate's and of that at the frequency.

    ``thickness``: of the plate, or of one of its layers as if it were alone, m.

    With phi = -x and u = u(z), D_z = 0 inside and no traction on the faces, the plate's permittivity along x is

        eps_p = eps + sum over the waves along z of (r . a)^2 / c * tan(X) / X,    X = omega h / (2 v),

    c = rho v^2 and a eigenvalue and eigenvector of the stiffness along z at constant D, and r its coupling to phi; X is
    twice as large over a clamped bottom.
    """
    phi = body.fields.index("phi")
    moving = np.delete(np.arange(len(body.fields)), phi)
    across, through = body.xz[phi], body.zz[phi]
    permittivity = -(body.xx[phi, phi] - across[phi] ** 2 / through[phi])
    coupling = across[moving] - through[moving] * across[phi] / through[phi]
    stiffness = body.zz[np.ix_(moving, moving)] - np.outer(through[moving], through[moving]) / through[phi]
    moduli, shapes = np.linalg.eig(stiffness)
    shares = (coupling @ shapes) ** 2 / np.sum(shapes**2, axis=0) / moduli
    angular = 2 * np.pi * stator.slowest_wavelength(1.0) / wavelength
    held = 1.0 if stator.bottom == "clamped" else 0.5
    phases = angular * thickness * held * np.sqrt(body.inertia[moving] / moduli)
    vacuum = -vacuum_medium(*units(*stator.solids)).xx[0, 0]
    sizes = [abs(permittivity + np.sum(shares * factors)) for factors in (1.0, np.tan(phases) / phases)]
    return max(sizes) / vacuum * thickness / wavelength
