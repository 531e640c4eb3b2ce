"""Motion beside a line force, against exact partial waves: its logarithm, its stated error, both components and sides.

The true errors of the levels here (order 7 to 8, two to three layers) differ by 3.8 to 5, of which
`fem.discretize.mesh_refinement.GAIN_NEAR_FORCE` is the lower side.
"""

from dataclasses import replace

import numpy as np
import pytest

from fem.analytic.half_space import rayleigh
from fem.exceptions import InputError
from fem.geometry import Stator
from fem.materials import isotropic
from fem.solve.forced_surface import forced_wave
from fem.waveguide.line_force import LineForce
from tests.fem.stators import FREQUENCY, constants, cut, lossless, plate
from tests.frozen import frozen
from tests.oracles.fem_plate_response import PlateResponse

DISTANCES = np.array([-0.4, -0.05, 0.005, 0.2])  # wavelengths
ORACLE = 2e-8  # accuracy of the oracle's integrals: they change by less on panels a third as wide


STATORS, COMPONENTS = [("PZT-8", 1.2), ("PZT-5H", 0.4), ("PZT-4", np.inf)], ["x", "z"]


@frozen([(*stator, component) for stator in STATORS for component in COMPONENTS])
def exact_motion(name, thickness, component):
    """Motion at `DISTANCES`."""
    _, wavelength, oracle = stator_of(cut(name, "Z", quality=30.0), thickness)
    return oracle.forced(component, DISTANCES * wavelength)


def stator_of(solid, thickness):
    """Stator without ends and without transducers, its Rayleigh wavelength and the oracle."""
    wavelength = rayleigh(solid, "open").velocity / FREQUENCY
    stator = Stator(solid=solid, length=20 * wavelength, thickness=thickness * wavelength, ends="absorbing")
    oracle = PlateResponse(thickness=stator.thickness, frequency=FREQUENCY, **constants(solid))
    return stator, wavelength, oracle


@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
@pytest.mark.parametrize("component", COMPONENTS)
@pytest.mark.parametrize(("name", "thickness"), STATORS)
def test_the_motion_beside_a_force_errs_as_stated(name, thickness, component, tolerance):
    stator, wavelength, _ = stator_of(cut(name, "Z", quality=30.0), thickness)
    distances = DISTANCES * wavelength
    force = LineForce(name="f", position=stator.length / 2, component=component)
    exact = exact_motion(name, thickness, component)
    for places in (distances[:1], distances):
        at = force.position + places
        wave = forced_wave(stator, (), (force,), frequency=FREQUENCY, tolerance=tolerance, places=tuple(at))
        truth = exact[:, : len(places)]
        error = max(abs(wave.motion(at) - truth).max(axis=0) / abs(truth).max(axis=0))
        assert error < max(2 * wave.relative_error, ORACLE)
        assert wave.relative_error < tolerance
        assert error < tolerance


def test_the_oracle_is_symmetric_and_logarithmic():
    """Mirror: u_z is even and u_x odd beside a normal force; close by, u_z falls by c ln 2 / pi each time r doubles."""
    _, wavelength, oracle = stator_of(cut("PZT-8", "Z", quality=30.0), 0.7)
    near = np.array([1e-4, 2e-4, 4e-4]) * wavelength
    right, left = oracle.forced("z", near), oracle.forced("z", -near)
    assert abs(right - np.array([-left[0], left[1]])).max() < 1e-9 * abs(right).max()
    steps = -np.diff(right[1])
    assert steps[0] == pytest.approx(steps[1], rel=1e-4, abs=0)
    assert steps[0].real > 0


def test_the_logarithm_beside_a_force_on_glass_is_flamants():
    """Flamant, isotropic: u_z falls by 2 (1 - nu^2) / (pi E) ln(r2 / r1) from r1 to r2, close to a normal force."""
    glass = replace(
        isotropic(name="glass", density=2500.0, youngs_modulus=70e9, poisson_ratio=0.25), mechanical_quality=1e6
    )
    wavelength = rayleigh(glass, "open").velocity / FREQUENCY
    stator = Stator(solid=glass, length=10 * wavelength, thickness=1.3 * wavelength, ends="absorbing")
    force = LineForce(name="f", position=5 * wavelength, component="z")
    at = force.position + np.array([2e-3, 4e-3]) * wavelength
    wave = forced_wave(stator, (), (force,), frequency=FREQUENCY, tolerance=1e-4, places=tuple(at))
    steps = -np.diff(wave.motion(at)[1])
    assert steps[0].real == pytest.approx(2 * (1 - 0.25**2) / (np.pi * 70e9) * np.log(2), rel=1e-3, abs=0)


def test_a_place_under_a_force_is_refused():
    stator = plate(lossless("PZT-8", "Z"))
    force = LineForce(name="f", position=stator.length / 2)
    with pytest.raises(InputError, match=r"places must lie beside the forces: .* infinite, got .* m"):
        forced_wave(stator, (), (force,), frequency=FREQUENCY, tolerance=1e-2, places=(1e-3, force.position))


def test_strips_a_wavelength_apart_have_the_error_of_places_beside_both():
    """The error of a strip is also that a wavelength beside it, of which one place lies under the other strip."""
    stator = plate(cut("PZT-8", "Z", quality=60.0), length=12.0)
    unit = stator.thickness / 0.8
    one, other = (LineForce(name=name, position=at * unit, width=2e-3) for name, at in (("one", 5.0), ("other", 6.0)))
    given = {"frequency": FREQUENCY, "tolerance": 1e-2, "places": (10.0 * unit,)}
    lines = forced_wave(stator, (), (replace(one, width=np.inf), replace(other, width=np.inf)), **given)
    strips = forced_wave(stator, (), (one, other), **given)
    assert lines.relative_error < strips.relative_error < 1e-2
    assert strips.motion(10.0 * unit) == pytest.approx(lines.motion(10.0 * unit), rel=1e-3)
