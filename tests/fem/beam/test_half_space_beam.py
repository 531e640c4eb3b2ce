"""The beam on a half-space of another cut, against an integral over both wavenumbers of the exact half-space."""

import numpy as np

from fem.beam.beam_of_section import surface_beam
from fem.geometry import Stator, Transducer
from fem.solve.driven_stator import driven_wave
from tests.fem.stators import cut

TRUTH = 7.198e-11  # |u_z| in m per V at (15, -2) mm: independent program, four digits


def test_beam_on_128yx_has_the_bulk_waves_of_the_half_space():
    """128YX, 10 pairs, aperture 5 mm: the surface wave alone errs by 2 %, beside 8e-4 of the section."""
    stator = Stator(solid=cut("LiNbO3 (Kovacs)", "128YX"), length=0.07, thickness=np.inf, ends="absorbing")
    transducer = Transducer(name="a", center=0.01, finger_pairs=10, period=0.396e-3, metallisation=0.5, aperture=5e-3)
    wave = driven_wave(stator, (transducer,), frequency=10e6, drive="a", tolerance=2e-3, places=(0.015,))
    motion, error = surface_beam(wave, mirror_width=None).motion_and_error(0.015, -2e-3)
    assert abs(abs(motion[2]) / TRUTH - 1) < 1.5e-3
    assert error < 3e-3
