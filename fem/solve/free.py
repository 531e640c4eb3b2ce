"""The free wave of a section without transducers: velocity, ellipse and profile of its surface mode.

Guided modes of the bare section at the drive frequency; the one whose motion hugs the surface is the answer.  In a
block of several wavelengths it is the Rayleigh wave of the half-space up to a splitting that decays exponentially
with the thickness.
"""

import time

import numpy as np

from fem.convergence import ConvergenceError
from fem.discretize.grading import Resolution
from fem.discretize.refinement import refine
from fem.discretize.section import FIELD_COLUMN, Section, discretise
from fem.geometry import Stator
from fem.materials.christoffel import slowest_wavelength, stretch_absorbs
from fem.results.free_wave import FreeWave
from fem.threads import one_blas_thread
from fem.waveguide.modes import GuidedModes, guided_modes

ORDERS = (4, 6, 8, 10, 12)
GAIN = 10.0  # two orders more divide the error of the velocity by far more than this
LOSSY_GAIN = 1.4  # where a lossy layer stands for the half-space: its thickness grows with the order, squared


@one_blas_thread
def free_wave(stator: Stator, *, frequency: float, tolerance: float) -> FreeWave:
    """Rayleigh wave of a bare section at a frequency.

    Parameters
    ----------
    stator : Stator
    frequency : float
        Hz.
    tolerance : float
        Relative, of the velocity.

    Returns
    -------
    FreeWave

    Raises
    ------
    ConvergenceError
        If the highest order does not reach the tolerance.
    """
    if not (np.isfinite(tolerance) and tolerance > 0):
        raise ValueError(f"tolerance must be positive and finite, got {tolerance!r}")
    begun = time.perf_counter()
    unit = slowest_wavelength(stator.solid, frequency)

    def at_order(order: int) -> tuple[GuidedModes, complex]:
        section = discretise(
            stator,
            Resolution(order=order, edge_layers=0, lossy_elements=order + 2),
            wavelength=unit,
            surface_scale=np.inf,
        )
        modes = guided_modes(section, frequency)
        return modes, complex(np.mean(modes.wavenumbers[modes.rayleigh]) / unit)

    refined = refine(
        at_order,
        ORDERS,
        differences=lambda fine, coarse: (abs(coarse[1].real / fine[1].real - 1),),
        gain=LOSSY_GAIN if stator.absorbs_below and not stretch_absorbs(stator.solid) else GAIN,
        tolerance=tolerance,
    )
    modes, wavenumber = refined.answer
    section, error = modes.section, refined.errors[0]
    if error > tolerance:
        raise ConvergenceError(
            f"the free wave's velocity is known to {error:.1e} only, {tolerance:.1e} was asked for: ask for less"
        )
    shape = _at_the_upper_face(modes.right[:, modes.rayleigh], section)
    profile = np.zeros((len(section.dofs), 4), dtype=complex)
    exists = section.dofs >= 0
    profile[exists] = shape[section.dofs[exists]]
    profile[:, FIELD_COLUMN["phi"]] *= section.solid.potential_unit
    profile /= profile[section.surface, FIELD_COLUMN["uz"]]
    body = slice(section.bottom, section.surface + 1)
    return FreeWave(
        frequency=frequency,
        velocity=2 * np.pi * frequency / wavenumber.real,
        attenuation=float(-wavenumber.imag),
        surface_ratio=float(abs(profile[section.surface, FIELD_COLUMN["ux"]])),
        depth=section.nodes[body],
        profile=profile[body],
        order=section.order,
        solid=stator.solid,
        relative_error=float(error),
        unknowns=section.size,
        seconds=time.perf_counter() - begun,
    )


def _at_the_upper_face(twins: np.ndarray, section: Section) -> np.ndarray:
    """Return the sum of one or two modes of (nearly) one velocity with u_z = 1 at the surface and the least motion.

    Two like faces guide two such modes, and any mixture of them is as good a solution: this one leaves the lower face
    at rest.
    """
    top = twins[section.surface_dofs["uz"]]
    moved = twins[section.mechanical]
    towards = np.linalg.solve(moved.conj().T @ moved, top.conj())
    return twins @ (towards / (top @ towards))
