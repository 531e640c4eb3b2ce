"""Waves in both directions under a slider on pillars, fitted to the motion of the stator's surface.

The fit u_z = U+ exp(-i k x) + U- exp(i k x) is by least squares over the slider's length, and over at least a
wavelength on either side of its centre.  The motion is that of the surface mode alone, averaged over the width of the
strip.  The compliance Gamma and the ratio u_x/u_z are those of the half-space.
"""

from typing import Any

import numpy as np

import contact
import fem
from studies.refusal import SceneError

FITTED = 49  # points along x of the fit
ACROSS = 5  # Gauss points over the width of the strip


def stator_wave(
    stator: fem.Stator, motion: Any, *, center: tuple[float, float], extent: float, width: float,
    loading: bool | str | None,
) -> tuple[contact.PassingWave, float]:  # fmt: skip
    """Return the `contact.PassingWave` for 1 V under a slider, and the rms misfit of the fit.

    ``motion`` is a `studies.solve.surface_motion.SurfaceMotion`; ``center`` (x, y) in m that of the slider, ``extent``
    in m that of its contacts along x, ``width`` in m that of the strip below them; ``loading`` that of the wave.  The
    misfit is relative to the larger of both waves.
    """
    wave, beam = motion.wave, motion.beam
    orbit = complex(fem.bound_wave(stator, motion.wave.frequency).displacement[0])
    wavelength = wave.phase_velocity / wave.frequency
    reach = max(wavelength, extent / 2)
    centre, middle = center
    along = np.clip(centre + np.linspace(-reach, reach, FITTED), 0.0, wave.length)
    if beam is None and any(map(wave.covered, along)):
        rule = "must leave the pillars, and a wavelength either side of their centre, on the bare uniform stator"
        where = f"{along[0] * 1e3:.4g} to {along[-1] * 1e3:.4g} mm"
        raise SceneError("slider.position", f"{rule}: from {where} there are fingers or a meshed piece")
    if beam is None:
        u_z = wave.rayleigh_motion(along)[1]
    else:
        mode = getattr(beam, "surface_mode", None) or beam
        u_z = sum(
            weight / 2 * mode.motion(along, np.full(along.size, middle + y * width / 2))[2]
            for y, weight in zip(*np.polynomial.legendre.leggauss(ACROSS), strict=True)
        )
    k = 2 * np.pi / wavelength
    basis = np.exp(np.outer(along - centre, (-1j * k, 1j * k)))
    (forward, backward), *_ = np.linalg.lstsq(basis, u_z, rcond=None)
    misfit = float(np.sqrt(np.mean(np.abs(basis @ (forward, backward) - u_z) ** 2)))
    passing = contact.PassingWave(
        frequency=wave.frequency, wavelength=wavelength, ratio=orbit / 1j, forward=complex(forward),
        backward=complex(backward), compliance=fem.bound_compliance(stator, wave.frequency),
        strip_width=width, loading=loading,
    )  # fmt: skip
    return passing, misfit / passing.amplitude


def mean_amplitudes(x: np.ndarray, wave: contact.PassingWave) -> tuple[float, float]:
    """Return the rms of |u_z| and |u_x| in m of a wave over contacts at ``x`` in m, without the slider.

    The amplitude at the slider's centre would depend on whether a standing wave has a node there.
    """
    turn = np.exp(-1j * wave.wavenumber * x)
    forward, backward = wave.forward * turn, wave.backward / turn
    normal, tangential = forward + backward, wave.orbit * forward + np.conj(wave.orbit) * backward
    rms_normal, rms_tangential = np.sqrt(np.mean(np.abs([normal, tangential]) ** 2, axis=1)).tolist()
    return rms_normal, rms_tangential
