"""The absorbing bottom against the exact half-space: partial waves and boundary elements, no mesh (tests/oracles)."""

import numpy as np
import pytest

from fem.discretize.absorber import absorber_kind
from fem.discretize.mesh_refinement import LEVELS, level_gain
from fem.geometry import Stator, Transducer
from fem.materials.christoffel import slowest_wavelength
from fem.results.field_evaluation import surface_of
from fem.solve.driven_stator import driven_wave, motion_difference, solve_driven
from tests.fem.stators import cut
from tests.frozen import frozen
from tests.oracles.fem_half_space import FingerStrips

FREQUENCY, PAIRS, CENTER = 9.6e6, 3, 4e-3
PLACES = np.array([6.5e-3, 9.1e-3, 14.3e-3])


def layout(name, orientation, period):
    solid = cut(name, orientation, quality=300.0, loss=2e-3)
    transducer = Transducer(
        name="a", center=CENTER, finger_pairs=PAIRS, period=period, metallisation=0.5, aperture=5e-3
    )
    return Stator(solid=solid, length=0.02, thickness=np.inf, ends="absorbing"), transducer


def exact(stator, transducer, places=PLACES, panels=400):
    """Admittance in S and u_x, u_z at the places for one volt, shape (2, places)."""
    solid, count = stator.solid, len(transducer.signs)
    centers = (np.arange(count) - (count - 1) / 2) * transducer.pitch
    strips = FingerStrips(
        (solid.stiffness_lossy, solid.coupling, solid.permittivity_lossy, solid.density),
        FREQUENCY,
        centers,
        transducer.finger_width / 2,
        slowest_wavelength(solid, FREQUENCY) * FREQUENCY,
        panels,
    )
    signs = (-1.0) ** np.arange(count)
    charges = strips.charges(signs)
    admittance = 2j * np.pi * FREQUENCY * transducer.aperture * charges[signs > 0, 0].sum()
    return admittance, strips.motion(charges, places - transducer.center)[:, [0, 2]].T


CASES = {  # period in m, kind of the layer
    ("LiNbO3 (Warner)", "128YX"): (0.41e-3, "selective"),
    ("LiNbO3 (Kovacs)", (0.0, 38.0, 10.0)): (0.41e-3, "selective"),
    ("LiNbO3 (Kovacs)", "YZ"): (0.36e-3, "matched"),
    ("quartz (Bechmann)", "ST-X"): (0.33e-3, "matched"),
    ("PZT-5A", "Z"): (0.2e-3, "matched"),
}
SLOW, DEFAULT = pytest.mark.slow, (("128YX", 1), ("Z", 1))


@frozen(list(CASES))
def truth(name, orientation):
    """Admittance in S, then u_x and u_z at `PLACES` for one volt."""
    admittance, motion = exact(*layout(name, orientation, CASES[name, orientation][0]))
    return np.array([admittance, *motion.ravel()])


@pytest.mark.parametrize(
    ("case", "levels"),
    [
        pytest.param(case, levels, marks=[] if (case[1], levels[0]) in DEFAULT else [SLOW])
        for case in CASES
        for levels in ((1, 2), (2, 3))
    ],
)
def test_motion_and_admittance_are_the_half_spaces(case, levels):
    """Of the default level and of the next: the errors, and that their estimate is true within a factor of 2."""
    period, kind = CASES[case]
    stator, transducer = layout(*case, period)
    assert absorber_kind(stator.solid) == kind
    admittance, *motion = truth(*case)
    motion = np.reshape(motion, (2, -1))
    coarse, fine = (
        solve_driven(stator, (transducer,), frequency=FREQUENCY, drive="a", resolution=LEVELS[level])
        for level in levels
    )
    theirs, ours = (surface_of(each).motion(PLACES) for each in (coarse, fine))
    error = motion_difference(ours, motion)
    of_admittance = abs(fine.circuit.source_admittances[0] / admittance - 1)
    assert error < (7.2e-5 if levels[-1] == 2 else 1.1e-5)
    assert of_admittance < (1.4e-4 if levels[-1] == 2 else 1.6e-5)
    estimate = motion_difference(ours, theirs) / (level_gain(stator) - 1)
    assert 0.5 < estimate / error < 5


@pytest.mark.slow
@pytest.mark.parametrize("rest", [{"thickness": np.inf}, {"thickness": 1e-3, "bottom": "absorbing"}])
def test_shipped_lithium_niobate_is_within_its_stated_error(rest):
    """Transducer and frequency of the scene lithium-niobate-128yx, with loss, at the default tolerance."""
    solid = cut("LiNbO3 (Warner)", "128YX", quality=1000.0)
    stator = Stator(solid=solid, length=0.04, ends="absorbing", **rest)
    transducer = Transducer(
        name="left", center=6e-3, finger_pairs=20, period=0.402e-3, metallisation=0.5, aperture=9e-3
    )
    place = 0.024
    wave = driven_wave(stator, (transducer,), frequency=FREQUENCY, drive="left", tolerance=1e-3, places=(place,))
    admittance, motion = exact(stator, transducer, np.array([place]), panels=1600)
    assert 1e-5 < wave.relative_error < 1e-3
    assert motion_difference(wave.motion([place]), motion) < 1.5 * wave.relative_error
    assert abs(wave.admittance / admittance - 1) < 1.5 * wave.admittance_error
