"""Small stators, in wavelengths of the slowest bulk wave, that the tests of the driven problem share."""

from dataclasses import replace

import numpy as np

from fem.discretize.depth_mesh import discretise
from fem.discretize.element_sizes import Resolution
from fem.discretize.section import Section
from fem.geometry import Stator, Transducer
from fem.materials import Solid, material, rotated
from fem.materials.christoffel import slowest_wavelength
from fem.results.driven_answer import SurfaceWave, surface_wave
from fem.results.stator_solution import Solution
from fem.solve.driven_stator import solve_driven

FREQUENCY = 2.3e6


def cut(name: str, orientation, *, quality: float | None = None, loss: float | None = None) -> Solid:
    """A catalogue solid in the frame of a cut, with other losses if they are given."""
    solid = rotated(material(name), orientation)
    if quality is not None:
        solid = replace(solid, mechanical_quality=quality)
    return solid if loss is None else replace(solid, dielectric_loss=loss)


def lossless(name: str, orientation) -> Solid:
    return cut(name, orientation, quality=np.inf, loss=0.0)


def constants(solid: Solid) -> dict:
    """Stiffness, coupling, permittivity and density with losses, as the oracles take them."""
    return {
        "stiffness": solid.stiffness_lossy, "coupling": solid.coupling, "permittivity": solid.permittivity_lossy,
        "density": solid.density,
    }  # fmt: skip


def plate(solid: Solid, *, length: float = 4.0, thickness: float = 0.8, frequency=FREQUENCY, **rest) -> Stator:
    """Length and thickness in wavelengths."""
    unit = slowest_wavelength(solid, frequency)
    return Stator(solid=solid, length=length * unit, thickness=thickness * unit, **({"ends": "absorbing"} | rest))


def comb(stator: Stator, name: str, center: float, *, frequency=FREQUENCY, period=1.0, **rest) -> Transducer:
    """Centre and period in wavelengths; one pair of half-metallised fingers unless told otherwise."""
    unit = slowest_wavelength(stator.solid, frequency)
    return Transducer(
        name=name,
        center=center * unit,
        period=period * unit,
        **({"finger_pairs": 1, "metallisation": 0.5, "aperture": 0.02} | rest),
    )


def section(stator: Stator, *, order: int = 6, layers: int = 0, frequency=FREQUENCY, scale=0.125, size=1.0) -> Section:
    """Depth of a stator; ``scale`` of the graded element in wavelengths."""
    unit = slowest_wavelength(stator.solid, frequency)
    return discretise(
        stator,
        Resolution(order=order, edge_layers=layers, element_size=size),
        wavelength=unit,
        surface_scale=scale * unit,
    )


def solution(
    stator: Stator,
    transducers: tuple[Transducer, ...],
    *,
    drive="a",
    order: int = 5,
    layers: int = 0,
    frequency=FREQUENCY,
    absorber: int = 2,
) -> Solution:
    """One discretisation of a driven stator."""
    resolution = Resolution(order=order, edge_layers=layers, absorber=absorber)
    return solve_driven(stator, transducers, frequency=frequency, drive=drive, resolution=resolution)


def wave_of(solution: Solution) -> SurfaceWave:
    """The answer of one discretisation, whose error nobody knows."""
    return surface_wave(solution, relative_error=np.inf, admittance_error=np.inf)
