"""Guided modes of a uniform segment: wavenumbers along x, shapes through the depth; the free wave among them."""

from dataclasses import dataclass, field

import numpy as np

from fem.materials import Solid


@dataclass(frozen=True, kw_only=True)
class SegmentModes:
    """Modes that run or decay towards +x, fields ~ exp(i (omega t - k_x x - k_y y)).

    Attributes
    ----------
    frequency : float
        Hz.
    lateral_wavenumber : float
        k_y in rad/m.
    wavenumbers : ndarray, shape (modes,), complex
        k_x in rad/m, those that decay least first; Im k_x <= 0 where a mode decays.
    surface : ndarray of int
        The surface wave's modes; two in a plate whose faces are alike.
    depth : ndarray, shape (nodes,)
        z of the nodes in m, 0 at the surface.
    shapes : ndarray, shape (modes, nodes, 4), complex
        u_x, u_y, u_z and phi, the largest displacement 1; phi in V per m of it.
    surface_share : ndarray, shape (modes,)
        Squared motion at the surface over its integral through the depth, 1/m: large for the surface wave.
    solid : Solid
        The segment's, in the frame of the cut.
    relative_error : float
        Of the surface wave's k_x, or of every propagating mode's if requested, over the surface wave's
        sqrt(k_x^2 + k_y^2).
    unknowns : int
    """

    frequency: float
    lateral_wavenumber: float
    wavenumbers: np.ndarray = field(repr=False)
    surface: np.ndarray
    depth: np.ndarray = field(repr=False)
    shapes: np.ndarray = field(repr=False)
    surface_share: np.ndarray = field(repr=False)
    solid: Solid = field(repr=False)
    relative_error: float
    unknowns: int

    @property
    def surface_wavenumber(self) -> complex:
        """k_x of the surface wave in rad/m; the mean where two modes make it up."""
        return complex(np.mean(self.wavenumbers[self.surface]))

    @property
    def surface_angle(self) -> float:
        """Angle of the surface wave's wave vector from the x axis, rad."""
        return float(np.arctan2(self.lateral_wavenumber, self.surface_wavenumber.real))

    @property
    def surface_velocity(self) -> float:
        """Phase velocity of the surface wave in the direction of its wave vector, m/s."""
        wavenumber = np.hypot(self.surface_wavenumber.real, self.lateral_wavenumber)
        return float(2 * np.pi * self.frequency / wavenumber)


@dataclass(frozen=True, kw_only=True)
class FreeWave:
    """Surface mode of a bare section.

    Attributes
    ----------
    frequency : float
        Hz.
    velocity : float
        m/s.
    attenuation : float
        Of the amplitude, 1/m.
    surface_ratio : float
        |u_x / u_z| at the surface.
    depth : ndarray, shape (nodes,)
        z of the profile's nodes in m, 0 at the surface.
    profile : ndarray, shape (nodes, 4)
        Complex u_x, u_y, u_z over u_z at the surface, and phi in V per m of u_z.
    order : int
        Polynomial order of the elements that the nodes belong to.
    solid : Solid
        The section's below its layers, in the frame of the cut.
    solids : tuple of Solid or None
        Of each element from the bottom up; None for a bond.
    relative_error : float
        Of the velocity, from two orders.
    unknowns : int
    """

    frequency: float
    velocity: float
    attenuation: float
    surface_ratio: float
    depth: np.ndarray = field(repr=False)
    profile: np.ndarray = field(repr=False)
    order: int
    solid: Solid = field(repr=False)
    solids: tuple[Solid | None, ...] = field(repr=False)
    relative_error: float
    unknowns: int
