"""Quasi-static estimate of a transducer: charges of an infinite array of strips, radiated as one Rayleigh wave.

The estimate is drawn beside computed values.  It neglects reflections by the fingers, bulk waves, bottom and ends, and
is accurate to about ten per cent if the fingers reflect little.  In an infinite array of strips of pitch p and
metallisation m, let one strip have 1 V and all others 0 V.  Its charge has the Fourier transform (Peach 1981; Datta and
Hunsinger 1980; Morgan, *Surface Acoustic Wave Filters*, 2007, chapter 5)

    rho(k) = 2 eps sin(pi s) P_n(cos pi m) / P_-s(-cos pi m),    k p = 2 pi (n + s),  0 <= s < 1,          (1)

with the Legendre functions P and the half-space's static permittivity eps without traction.  If the strips at x_f have
the potentials V_f, the wave that leaves to either side has the potential

    phi = i (dv/v) / eps  sum_f V_f rho(k) exp(i k (x_f - x)),    dv/v = (v_free - v_metallised) / v_free. (2)

It carries the power omega eps |phi|^2 / (4 dv/v) per metre of aperture, which is the power V^2 G / 2 of the source with

    G = omega (dv/v) / eps |sum_f V_f rho|^2 per metre.                                                    (3)
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.analytic.layered_wave import LayeredWave, bound_wave, shorted_velocity
from fem.analytic.stroh import SurfaceImpedance
from fem.exceptions import ConvergenceError
from fem.geometry import Layer, Stator, Transducer
from fem.materials import VACUUM_PERMITTIVITY, Solid, fields, rotated
from fem.materials.medium import medium

COMB_POTENTIALS = {"+": 0.5, "-": -0.5, "0": 0.0, "o": 0.0}
# Apparent lengthening of a finger at each end, in periods, for an isotropic permittivity and a metallisation of 0.5;
# 0.064 at 0.25 and 0.068 at 0.75 (tests/oracles/fem_finger_ends.py)
END_EXCESS = 0.072
NODES = 64  # of Gauss's rule for the integral over s in `strip_charges`, whose integrand is smooth between 0 and 1


def surface_permittivity(solid: Solid, surface: str = "vacuum") -> float:
    """Static permittivity in F/m of a half-space without traction, for charges of short period.

    The solid's own, eps = -D_n / (k phi), follows from its surface impedance Z at v = 0 (stroh.py).  In the blocks of
    displacements (u) and potential (p), no traction means Z_uu u + Z_up phi = 0.  Eliminating u leaves the Schur
    complement,

        -eps = Z_pp - Z_pu Z_uu^-1 Z_up.

    ``solid``: piezoelectric, in the stator's frame, its losses ignored; ``surface``: "vacuum" adds the permittivity of
    the vacuum above, "open" is the solid alone.
    """
    coupled = fields(solid)
    if "phi" not in coupled:  # phi couples to u_y only, as along the fingers in ST-X quartz
        coupled = ("uy", "phi")
    impedance = SurfaceImpedance(medium(solid, coupled, lossy=False), "vacuum")
    z, u = impedance.of_all_fields(0.0), impedance.displaced
    z_up = z[np.ix_(u, ~u)]
    schur = z[-1, -1] - (z_up.conj().T @ np.linalg.solve(z[np.ix_(u, u)], z_up))[0, 0]
    relative = float(-schur.real / impedance.gap)  # ``gap`` is the vacuum's permittivity in the unit of Z
    return VACUUM_PERMITTIVITY * (relative + (surface == "vacuum"))


def end_excess(solid: Solid, surface: str = "vacuum") -> float:
    """Apparent lengthening of a finger at each end, in periods, in an array of alternating + and - fingers.

    A finger that is longer by this at both ends, without end effect, has the same total charge.  For charges
    exp(-i k.r) the permittivity of a dielectric half-space, times |k|, is the square root of a quadratic form in k_x
    and k_y.  Stretching y by the ratio of the permittivities along y and x makes it that of an isotropic solid
    (`END_EXCESS`).  The piezoelectric motion of the solid changes the result by 3 % in 128YX and 14 % in YZ lithium
    niobate.  Arguments as of `surface_permittivity`.
    """
    along_the_fingers = surface_permittivity(rotated(solid, (90.0, 0.0, 0.0)), surface)
    return END_EXCESS * along_the_fingers / surface_permittivity(solid, surface)


def charge_transform(phase: float | np.ndarray, metallisation: float) -> np.ndarray:
    """Transform rho(k) / eps of the charge of a strip at 1 V among strips at 0 V, equation (1); phase k p >= 0, rad."""
    from scipy.special import eval_legendre

    order, s = np.divmod(np.asarray(phase, dtype=float) / (2 * np.pi), 1.0)
    cosine = np.cos(np.pi * metallisation)
    return 2 * np.sin(np.pi * s) * eval_legendre(order, cosine) / eval_legendre(-s, -cosine)


def strip_charges(reach: int, metallisation: float) -> np.ndarray:
    """Charges per metre, over eps, of a strip at 1 V and of its neighbours 1 to ``reach`` at 0 V, shape (reach + 1,).

    If strip f has the potential exp(2 pi i s f), the charge of strip 0 is

        C(s) = 2 eps sin(pi s) P_-s(cos pi m) / P_-s(-cos pi m),

    so that the charge of neighbour n is the Fourier coefficient, int_0^1 C(s) cos(2 pi n s) ds.
    """
    from scipy.special import eval_legendre

    s, weights = np.polynomial.legendre.leggauss(NODES + 2 * reach)
    s, weights = (s + 1) / 2, weights / 2
    cosine = np.cos(np.pi * metallisation)
    net = 2 * np.sin(np.pi * s) * eval_legendre(-s, cosine) / eval_legendre(-s, -cosine)
    return np.cos(2 * np.pi * np.outer(np.arange(reach + 1), s)) @ (weights * net)


@dataclass(frozen=True, kw_only=True)
class TransducerEstimate:
    """Estimate of a transducer without reflections on a half-space; `transducer_estimate` constructs it.

    Attributes
    ----------
    transducer : Transducer
    permittivity : float
        eps, F/m.
    velocity : float
        Of the wave under the fingers, m/s.
    velocity_change : float
        dv/v, half of K2.
    potential : complex
        Of the free Rayleigh wave at the surface, V per metre of u_z.
    """

    transducer: Transducer
    permittivity: float
    velocity: float
    velocity_change: float
    potential: complex

    @property
    def capacitance(self) -> float:
        """Capacitance between the electrodes, F, with grounded strips continuing the array on both sides."""
        transducer = self.transducer
        potentials = np.array([COMB_POTENTIALS[sign] for sign in transducer.signs])
        strip = np.arange(len(potentials))
        distance = abs(np.subtract.outer(strip, strip))
        charges = strip_charges(len(potentials) - 1, transducer.metallisation)[distance] @ potentials
        return float(self.permittivity * transducer.aperture * (potentials @ charges))

    def pattern(self, frequency: float | np.ndarray) -> np.ndarray:
        """Sum over the fingers sum_f V_f rho exp(i k x_f) / eps of equation (2), per volt, x_f from the middle.

        Of uneven fingers rho is that of even ones of the mean pitch.
        """
        transducer = self.transducer
        frequency = np.asarray(frequency, dtype=float)
        potentials = np.array([COMB_POTENTIALS[sign] for sign in transducer.signs])
        phase = 2 * np.pi * frequency / self.velocity * transducer.pitch  # k p
        from_middle = np.arange(len(potentials)) - (len(potentials) - 1) / 2  # x_f / p
        if not transducer.even:
            from_middle = (transducer.fingers.mean(axis=1) - transducer.center) / transducer.pitch
        array_factor = np.exp(1j * np.multiply.outer(phase, from_middle)) @ potentials
        return charge_transform(phase, transducer.metallisation) * array_factor

    def conductance(self, frequency: float | np.ndarray) -> np.ndarray:
        """Radiation conductance G in S, equation (3), at frequencies in Hz."""
        omega = 2 * np.pi * np.asarray(frequency, dtype=float)
        load = omega * self.velocity_change * self.permittivity * self.transducer.aperture
        return load * abs(self.pattern(frequency)) ** 2

    def normal(self, frequency: float | np.ndarray) -> np.ndarray:
        """|u_z| of the wave that leaves to either side, m per V, at frequencies in Hz; equation (2)."""
        return self.velocity_change * abs(self.pattern(frequency)) / abs(self.potential)


def transducer_estimate(solid: Solid, transducer: Transducer, surface: str = "vacuum") -> TransducerEstimate:
    """Estimate a transducer on a half-space.

    Parameters
    ----------
    solid : Solid
        In the stator's frame, piezoelectric.
    transducer : Transducer
    surface : str
        Of the bare parts: "vacuum" or "open" (D_n = 0).

    Raises
    ------
    ConvergenceError
        If the cut has no Rayleigh wave below the limiting velocity.
    """
    bare, metallised = rayleigh(solid, surface), rayleigh(solid, "metallised")
    m = transducer.metallisation
    return TransducerEstimate(
        transducer=transducer,
        permittivity=surface_permittivity(solid, surface),
        velocity=m * metallised.velocity + (1 - m) * bare.velocity,
        velocity_change=(bare.velocity - metallised.velocity) / bare.velocity,
        potential=bare.potential,
    )


def layered_estimate(stator: Stator, transducer: Transducer, frequency: float) -> TransducerEstimate:
    """Estimate a transducer on a half-space with layers, its fingers in the stator's plane; see `transducer_estimate`.

    The permittivity is that at the fingers' period, `plane_permittivity`.

    Raises
    ------
    ConvergenceError
        If no wave with sagittal motion is bound.
    """
    if not stator.layers:
        return transducer_estimate(stator.solid, transducer, stator.bare_surface)
    wave = bound_wave(stator, frequency)
    assert isinstance(wave, LayeredWave)
    shorted = shorted_velocity(wave, stator.plane)
    above = sum(each.thickness or 0.0 for each in stator.layers[len(stator.layers) - stator.plane :])
    m, potential = transducer.metallisation, wave.profile(above * frequency / wave.velocity)[1][0]
    return TransducerEstimate(
        transducer=transducer,
        permittivity=plane_permittivity(stator, np.pi / transducer.pitch),
        velocity=m * shorted + (1 - m) * wave.velocity,
        velocity_change=(wave.velocity - shorted) / wave.velocity,
        potential=complex(potential),
    )


def plane_permittivity(stator: Stator, wavenumber: float) -> float:
    r"""Static permittivity in F/m for charges exp(-i k x) in the plane of the fingers, -D_n / (k phi) on both sides.

    Through a layer of permittivity e and thickness h, with what is beyond it of permittivity e', it becomes

        e (e' + e t) / (e + e' t),    t = tanh(k h),

    which is exact in dielectrics that are isotropic in the section. The piezoelectric part of each solid is that of a
    half-space without traction.
    """
    if stator.solid.conducting or any(each.solid.conducting for each in stator.layers):
        raise ConvergenceError("the permittivity of a stator with a metal layer is not estimated")

    def through(layers: Sequence[Layer], beyond: float) -> float:
        for each in layers:
            own = surface_permittivity(each.solid, "open")
            tanh = np.tanh(wavenumber * (each.thickness or 0.0))
            beyond = own * (beyond + own * tanh) / (own + beyond * tanh)
        return beyond

    split = len(stator.layers) - stator.plane
    vacuum = VACUUM_PERMITTIVITY if stator.bare_surface == "vacuum" else 0.0
    below = through(stator.layers[:split], surface_permittivity(stator.solid, "open"))
    return float(below + through(stator.layers[split:][::-1], vacuum))
