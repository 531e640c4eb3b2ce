"""Surface motion of a piezoelectric plate of any cut by charges of finite length, without modes and without contour.

Stroh's partial waves at every real wave vector of the surface (Ting, *Anisotropic Elasticity*, 1996, chapter 5), four
counted from the top and four from the bottom, summed over the real plane of wave vectors.  The solid's loss keeps the
poles off that plane, backward waves included, and lets the periodic images of the sums fade.  A plate without a
grounded face has a pole at k = 0 whose field falls as a power: a disc about k = 0 is summed in polar coordinates.

exp(+i omega t), body at -h < z < 0, free faces, no field above or below (D_n = 0 beside the charges).
"""

import numpy as np
from scipy.special import erfc

from tests.oracles.stroh_solid import StrohSolid

CUT_OFF, LATERAL = 2.4, 1.3  # largest k_x and k_y over the wavenumber given; the filters begin at 1.4 and 1.1
DISC = 0.02, 0.14  # radii over the wavenumber given between which the disc fades out; no pole may lie inside
RADII, ANGLES = 80, 160


class PlateField(StrohSolid):
    """The plate of a `StrohSolid`, whose constants and frequency are ``solid``."""

    def __init__(self, *, thickness, **solid):
        super().__init__(**solid)
        self.thickness = thickness * self.wavenumber

    def response(self, kx, ky) -> np.ndarray:
        """u_x, u_y, u_z (m) and phi (V) at the top per charge (C/m2) there, (n, 4); wavenumbers real, rad/m.

        With w = (U, t / i), t the traction and D on planes z = const, w' = i N w.
        """
        plane, out, back, inverse = self.blocks(kx, ky)
        # fields exp(-i k x): d_a = -i k_a; U' = A_zz^-1 (t + i k_a A_za U), t' = (...) U + i k_a A_az A_zz^-1 t
        stroh = np.zeros((len(kx), 8, 8), dtype=complex)
        stroh[:, :4, :4], stroh[:, :4, 4:] = inverse @ back, inverse
        stroh[:, 4:, :4], stroh[:, 4:, 4:] = out @ inverse @ back - plane, out @ inverse
        p, waves = np.linalg.eig(stroh)  # exp(i p z), largest imaginary part last: it decays upwards
        order = np.argsort(p.imag, axis=1)  # Im p < 0 grows upwards: it decays downwards from the top
        p = np.take_along_axis(p, order, axis=1)
        waves = np.take_along_axis(waves, order[:, None, :], axis=2)
        decay = np.exp(-1j * p * self.thickness * np.where(np.arange(8) < 4, 1, -1))
        top = np.where(np.arange(8) < 4, 1.0, decay)
        bottom = np.where(np.arange(8) < 4, decay, 1.0)
        conditions = np.concatenate([waves[:, 4:] * top[:, None], waves[:, 4:] * bottom[:, None]], axis=1)
        load = np.zeros((len(kx), 8, 1), dtype=complex)
        load[:, 3, 0] = 1.0
        fields = ((waves[:, :4] * top[:, None]) @ np.linalg.solve(conditions, load))[:, :, 0]
        # t = i w_2, D_z = -1 at the top: w_2 = i D / (scaled)
        fields = fields * (1j * self.volt / (self.unit * self.wavenumber))
        fields[:, 3] *= self.volt
        return fields

    def motion(self, x, y, *, places, charges, aperture, surface_wavenumber, step, symmetric, chunk=20000):
        """u_x, u_y, u_z in m at points, of lines of charge (C/m) at places x along |y| < aperture / 2, (3, points).

        ``step``: of the sums, rad/m; ``symmetric``: whether y -> -y is a symmetry, which halves the work.
        """
        unit = surface_wavenumber
        along, across = (
            (np.arange(-int(reach * unit / step), int(reach * unit / step)) + 0.5) * step
            for reach in (CUT_OFF, LATERAL)
        )
        if symmetric:
            across = across[across > 0]
        lines = max(1, chunk // len(along))
        total = np.zeros((3, len(x)), dtype=complex)

        def add(kx, ky, weights, both=False):
            sent = (np.exp(1j * np.outer(kx, places)) @ charges) * aperture * weights / (2 * np.pi) ** 2
            sent = sent * np.sinc(ky * aperture / (2 * np.pi)) * _filter(kx / unit, 1.4, CUT_OFF)
            motion = self.response(kx, ky)[:, :3] * (sent * _filter(ky / unit, 1.1, LATERAL))[:, None]
            for sign, factors in ((1, [1, 1, 1]), (-1, [1, -1, 1]))[: 1 + both]:
                phases = np.exp(-1j * (np.outer(x, kx) + sign * np.outer(y, ky)))
                total[:] += (phases @ (motion * factors)).T

        for start in range(0, len(across), lines):
            kx, ky = (each.ravel() for each in np.meshgrid(along, across[start : start + lines]))
            add(kx, ky, step**2 * (1 - _filter(np.hypot(kx, ky) / unit, *DISC)), symmetric)
        nodes, weights = np.polynomial.legendre.leggauss(RADII)
        radius = (nodes + 1) / 2 * DISC[1] * unit
        weights = weights / 2 * DISC[1] * unit * radius * _filter(radius / unit, *DISC) * 2 * np.pi / ANGLES
        radius, angle = (each.ravel() for each in np.meshgrid(radius, (np.arange(ANGLES) + 0.5) * 2 * np.pi / ANGLES))
        add(radius * np.cos(angle), radius * np.sin(angle), np.tile(weights, ANGLES))
        return total


def _filter(ratios, low, high) -> np.ndarray:
    position = (abs(ratios) - low) / (high - low)
    return 0.5 * erfc(7.0 * (position - 0.5))
