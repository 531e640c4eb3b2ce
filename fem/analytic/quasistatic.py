"""Quasi-static estimate of a transducer: charges of an infinite row of strips, radiated as one Rayleigh wave.

Reflections by the fingers, bulk waves, bottom and ends are left out; a line to hold computed points against.  On an
infinite row of strips of pitch p and metallisation m the charge that one strip at 1 V takes, its neighbours at 0 V,
has the transform (Peach 1981; Datta and Hunsinger 1980; Morgan, *Surface Acoustic Wave Filters*, 2007, chapter 5)

    rho(k) = 2 eps sin(pi s) P_n(cos pi m) / P_-s(-cos pi m),    k p = 2 pi (n + s),  0 <= s < 1,

P the Legendre functions and eps the half-space's static permittivity at k -> infinity (free of traction).  With the
strips' potentials V_f at x_f the wave that leaves either way has the potential

    phi = i (dv/v) / eps  sum_f V_f rho(k) exp(i k (x_f - x)),    dv/v = (v_free - v_metallised) / v_free,

carries the power omega eps |phi|^2 / (4 dv/v) per metre of aperture, and so loads the source by G = omega (dv/v) / eps
|sum_f V_f rho|^2 per metre.  Good to some ten per cent where fingers reflect little.
"""

from dataclasses import dataclass

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.analytic.stroh import SurfaceImpedance
from fem.geometry import Transducer
from fem.materials import VACUUM_PERMITTIVITY, Solid, fields, rotated
from fem.materials.medium import medium

COMB_POTENTIALS = {"+": 0.5, "-": -0.5, "0": 0.0, "o": 0.0}
# Periods by which each end of a finger seems longer where the permittivity has no direction, at a metallisation of 0.5;
# 0.064 at 0.25 and 0.068 at 0.75 (tests/oracles/fem_finger_ends.py)
END_EXCESS = 0.072
NODES = 64  # of the capacitance's integral over s from 0 to 1, which is smooth inside


def surface_permittivity(solid: Solid, surface: str = "vacuum") -> float:
    """Static permittivity in F/m for short charge patterns: D_n over k phi without traction.

    ``solid``: piezoelectric, in the stator's frame, its losses ignored; ``surface``: "vacuum", with the vacuum above,
    or "open", the solid alone.
    """
    coupled = fields(solid)
    if "phi" not in coupled:  # it couples to u_y, as along the fingers in ST-X quartz
        coupled = ("uy", "phi")
    body = medium(solid, coupled, lossy=False)
    impedance = SurfaceImpedance(body, "vacuum")
    full = impedance._full(0.0)
    moves = impedance.displaced
    across = full[np.ix_(moves, ~moves)]
    own = full[-1, -1] - (across.conj().T @ np.linalg.solve(full[np.ix_(moves, moves)], across))[0, 0]
    return VACUUM_PERMITTIVITY * (float(-own.real / impedance.gap) + (surface == "vacuum"))


def end_excess(solid: Solid, surface: str = "vacuum") -> float:
    """Length in periods by which each end of a finger seems longer to its total charge, in a row of + and - fingers.

    The permittivity of a dielectric half-space for charges exp(-i k.r), times |k|, is the root of a quadratic form in
    k_x and k_y: y stretched by the ratio of both permittivities makes it that of an isotropic one.  The solid's
    own motion disturbs that, by 3 % in 128YX and 14 % in YZ lithium niobate.  Arguments as of `surface_permittivity`.
    """
    along_the_fingers = surface_permittivity(rotated(solid, (90.0, 0.0, 0.0)), surface)
    return END_EXCESS * along_the_fingers / surface_permittivity(solid, surface)


def charge_transform(phase: float | np.ndarray, metallisation: float) -> np.ndarray:
    """Transform rho(k) over eps of the charge of one strip at 1 V, its neighbours at 0 V; phase k p >= 0 in rad."""
    from scipy.special import eval_legendre

    order, s = np.divmod(np.asarray(phase, dtype=float) / (2 * np.pi), 1.0)
    cosine = np.cos(np.pi * metallisation)
    return 2 * np.sin(np.pi * s) * eval_legendre(order, cosine) / eval_legendre(-s, -cosine)


def strip_charges(reach: int, metallisation: float) -> np.ndarray:
    """Charges per metre over eps of strips 0 to ``reach`` from one at 1 V, all others at 0 V, shape (reach + 1,).

    The net charge at potentials exp(2 pi i s f) is 2 eps sin(pi s) P_-s(cos pi m) / P_-s(-cos pi m) per strip.
    """
    from scipy.special import eval_legendre

    s, weights = np.polynomial.legendre.leggauss(NODES + 2 * reach)
    s, weights = (s + 1) / 2, weights / 2
    cosine = np.cos(np.pi * metallisation)
    net = 2 * np.sin(np.pi * s) * eval_legendre(-s, cosine) / eval_legendre(-s, -cosine)
    return np.cos(2 * np.pi * np.outer(np.arange(reach + 1), s)) @ (weights * net)


@dataclass(frozen=True, kw_only=True)
class TransducerEstimate:
    """A transducer without reflections on a half-space; make it with `transducer_estimate`.

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
        Of the free wave, V per metre of u_z.
    """

    transducer: Transducer
    permittivity: float
    velocity: float
    velocity_change: float
    potential: complex

    @property
    def capacitance(self) -> float:
        """Between the electrodes in F, of strips in an endless row of grounded ones."""
        row = self.transducer
        potentials = np.array([COMB_POTENTIALS[sign] for sign in row.signs])
        apart = abs(np.subtract.outer(np.arange(len(potentials)), np.arange(len(potentials))))
        charges = strip_charges(len(potentials) - 1, row.metallisation)[apart] @ potentials
        return float(self.permittivity * row.aperture * (potentials @ charges))

    def pattern(self, frequency: float | np.ndarray) -> np.ndarray:
        """Sum of the fingers' charges as the wave sees them, per volt and over eps, complex."""
        row = self.transducer
        frequency = np.asarray(frequency, dtype=float)
        potentials = np.array([COMB_POTENTIALS[sign] for sign in row.signs])
        phase = 2 * np.pi * frequency / self.velocity * row.pitch
        places = np.arange(len(potentials)) - (len(potentials) - 1) / 2
        row_sum = np.exp(1j * np.multiply.outer(phase, places)) @ potentials
        return charge_transform(phase, row.metallisation) * row_sum

    def conductance(self, frequency: float | np.ndarray) -> np.ndarray:
        """G in S at frequencies in Hz."""
        omega = 2 * np.pi * np.asarray(frequency, dtype=float)
        load = omega * self.velocity_change * self.permittivity * self.transducer.aperture
        return load * abs(self.pattern(frequency)) ** 2

    def normal(self, frequency: float | np.ndarray) -> np.ndarray:
        """|u_z| of the wave that leaves either way, m per V, at frequencies in Hz."""
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
