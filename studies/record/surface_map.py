"""The beam over the whole surface: its motion on a grid of places (x, y)."""

import numpy as np

PER_WAVELENGTH, LINES = 4, 81  # places along x, and across the width
CROSSED = 6  # places per wavelength along both where beams cross


def surface_map(beam, stator):
    """Return x in m, y in m, and u_x, u_y and u_z of a beam on a scene's stator in m per V, (3, len(x), len(y))."""
    wave, crossed = beam.wave, hasattr(beam, "rows")
    step = wave.phase_velocity / wave.frequency / (CROSSED if crossed else PER_WAVELENGTH)
    x = np.linspace(0.0, stator.length, int(np.ceil(stator.length / step)) + 1)
    lines = int(np.ceil(stator.width / step)) + 1 if crossed else LINES
    y = np.linspace(-stator.width / 2, stator.width / 2, lines)
    return x, y, beam.motion(x[:, None], y)
