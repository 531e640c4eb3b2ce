"""The beam over the whole surface: its motion on a grid of points (x, y)."""

import numpy as np

import fem

PER_WAVELENGTH = 4, 6  # points along x; along x and y where beams cross
LINES = 81  # points across the width where they do not


def surface_map(beam, stator, per_wavelength: tuple[int, int] = PER_WAVELENGTH, *, picture: bool = False):
    """Return x in m, y in m, and u_x, u_y and u_z of a beam on a scene's stator in m per V, (3, len(x), len(y)).

    ``picture``: to the accuracy of a picture, which on some cuts takes a quarter of the time.
    """
    wave, crossed = beam.wave, hasattr(beam, "rows")
    step = wave.phase_velocity / wave.frequency / per_wavelength[crossed]
    x = np.linspace(0.0, stator.length, int(np.ceil(stator.length / step)) + 1)
    lines = int(np.ceil(stator.width / step)) + 1 if crossed else LINES
    y = np.linspace(-stator.width / 2, stator.width / 2, lines)
    return x, y, fem.one_blas_thread((beam.pictured if picture else beam).motion)(x[:, None], y)
