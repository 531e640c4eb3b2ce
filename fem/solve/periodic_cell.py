"""Free, metallised and periodically fingered surface of one material: velocity, K2, reflectivity, capacitance.

The first two are half-spaces without a mesh (half_space.py), the third an infinite grating with its fingers shorted and
open (grating.py).  The error is that of the stop bands' edges, from two discretisations.
"""

from dataclasses import dataclass

import numpy as np

from fem.analytic.half_space import rayleigh
from fem.discretize.element_sizes import Resolution
from fem.discretize.mesh_refinement import LEVELS, refine
from fem.exceptions import refuse_above
from fem.geometry import Above
from fem.materials import Solid
from fem.waveguide.grating import Grating, StopBand, grating

GAIN = 6.0  # a level divides the error of the edges by at least this: 8 to 10 measured, 40 from the first level


@dataclass(frozen=True, kw_only=True)
class CellParameters:
    """Parameters of the free, the metallised and the fingered surface of one material.

    Attributes
    ----------
    solid : Solid
    period : float
        Width of two fingers and two gaps, m.
    metallisation : float
    above : str
        "none": D_n = 0 on the bare surface; "vacuum".
    free_velocity, metallised_velocity : float
        Of the half-space, m/s.
    shorted, open : StopBand
        Of gratings of connected and of separate fingers.
    capacitance : float
        Of a finger pair per metre of aperture, F/m.
    relative_error : float
        Of the stop bands' edges over their width, from two discretisations.
    """

    solid: Solid
    period: float
    metallisation: float
    above: Above
    free_velocity: float
    metallised_velocity: float
    shorted: StopBand
    open: StopBand
    capacitance: float
    relative_error: float

    @property
    def coupling(self) -> float:
        """K2 of the half-space, 2 (v_free - v_metallised) / v_free."""
        return 2 * (self.free_velocity - self.metallised_velocity) / self.free_velocity

    @property
    def grating_coupling(self) -> float:
        """K2 of the gratings, 2 (v_open - v_shorted) / v_open."""
        return 2 * (self.open.velocity - self.shorted.velocity) / self.open.velocity


def cell_parameters(
    solid: Solid, *, period: float, metallisation: float, above: Above = "none", tolerance: float
) -> CellParameters:
    """Velocities, stop bands, reflectivity, K2 and capacitance of a periodic transducer's cells.

    Parameters
    ----------
    solid, period, metallisation, above
        As in `grating`.
    tolerance : float
        Of the stop bands' edges, relative to their width.

    Raises
    ------
    ConvergenceError
        If the cut guides no Rayleigh wave, or the finest discretisation does not reach the tolerance.
    """
    free_surface = "open" if above == "none" else "vacuum"
    free, metallised = (rayleigh(solid, surface).velocity for surface in (free_surface, "metallised"))

    def at_level(resolution: Resolution) -> tuple[Grating, list[StopBand]]:
        cells = grating(solid, period=period, metallisation=metallisation, above=above, resolution=resolution)
        return cells, [cells.stop_band(open_fingers=each) for each in (False, True)]

    refined = refine(at_level, LEVELS, differences=_edge_difference, gain=GAIN, tolerance=tolerance)
    (cells, bands), error = refined.answer, refined.errors[0]
    refuse_above(error, tolerance, "the stop bands' edges are, over their width,")
    return CellParameters(
        solid=solid,
        period=period,
        metallisation=metallisation,
        above=above,
        free_velocity=free,
        metallised_velocity=metallised,
        shorted=bands[0],
        open=bands[1],
        capacitance=cells.capacitance(),
        relative_error=error,
    )


def _edge_difference(fine: tuple[Grating, list[StopBand]], coarse: tuple[Grating, list[StopBand]]) -> tuple[float]:
    """Largest difference of the stop bands' edges, over the wider band's width."""
    edges, before = (np.array([(band.lower, band.upper) for band in bands]) for _, bands in (fine, coarse))
    return (float(abs(edges - before).max() / np.diff(edges).max()),)
