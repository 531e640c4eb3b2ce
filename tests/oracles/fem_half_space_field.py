"""Surface motion of a piezoelectric half-space by charges of finite length, without modes.

Stroh's problem at every wave vector of the surface (Ting, *Anisotropic Elasticity*, 1996, chapter 5), summed over the
plane of wave vectors.

exp(+i omega t), body at z < 0, no field above (D_n = 0 beside the charges).  Both wave vector components are turned by
one small angle of the complex plane, k (1 + i epsilon), which keeps all poles and branch points at a distance and
leaves the choice of the waves that decay downwards as it is for a lossy body.  G(-k) = G(k)^T.
"""

import math

import numpy as np

from tests.oracles.stroh_solid import StrohSolid


class HalfSpaceField(StrohSolid):
    """The half-space of a `StrohSolid`."""

    def response(self, kx, ky, turn):
        """Motion and potential per force and charge on the surface, scaled alike, (n, 4, 4)."""
        plane, out, back, inverse = self.blocks(kx, ky)
        stroh = np.zeros((len(kx), 8, 8), dtype=complex)
        stroh[:, :4, :4], stroh[:, :4, 4:] = -inverse @ back, inverse
        stroh[:, 4:, :4], stroh[:, 4:, 4:] = out @ inverse @ back - plane, -out @ inverse
        p, waves = np.linalg.eig(stroh)
        down = np.argsort(-(p / turn).imag, axis=1)[:, None, :4]
        waves = np.take_along_axis(waves, down, axis=2)
        return waves[:, :4] @ np.linalg.inv(waves[:, 4:])

    def motion(self, x, y, *, places, charges, aperture, surface_wavenumber, highest=4.0):
        """u_x, u_y, u_z in m at points, of lines of charge (C/m) at places x along |y| < aperture / 2, (3, points).

        ``highest``: end of the sum over the surface wavenumber; the sum fades out between 0.44 and 0.81 of it.  Four
        wavelengths from short fingers the error is 2e-4 with 4 and 2e-5 or less with 8.
        """
        fading = highest * surface_wavenumber * np.array([0.625, 0.375])  # middle and width
        highest, reach = highest * surface_wavenumber, float(np.hypot(x, y).max())
        epsilon = min(3.0 / (surface_wavenumber * reach), 0.04)
        turn, radial = 1 + 1j * epsilon, int(2.5 * highest / (epsilon * surface_wavenumber))
        size = (np.arange(radial) + 0.5) * highest / radial
        fade = [0.5 * math.erfc(5 * (2 * (k - fading[0]) / fading[1] - 1)) for k in size]
        angles = int(2 * highest * reach + 200) // 2
        total = np.zeros((3, len(x)), dtype=complex)
        for angle in (np.arange(angles) + 0.5) * np.pi / angles - np.pi / 2:
            kx, ky = size * np.cos(angle) * turn, size * np.sin(angle) * turn
            both = self.response(kx, ky, turn)
            weights = turn**2 * highest / radial * np.pi / angles / (4 * np.pi**2) * size * np.array(fade)
            weights = weights * self.volt**2 / (1j * self.wavenumber * self.unit)
            for sign, column in ((1, both[:, :3, 3]), (-1, both[:, 3, :3])):
                sent = np.exp(1j * sign * np.outer(kx, places)) @ charges
                sent = sent * aperture * np.sinc(ky * aperture / (2 * np.pi)) * weights
                phases = np.exp(-1j * sign * (np.outer(x, kx) + np.outer(y, ky)))
                total += (phases @ (column * sent[:, None])).T
        return total / self.volt
