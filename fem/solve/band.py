"""A stator prepared for a band of frequencies: a reduced model with its error, asked at one frequency after another."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from fem.circuit import Drive
from fem.convergence import ConvergenceError
from fem.results.solution import driven_solution
from fem.results.surface_wave import SurfaceWave, surface_wave
from fem.solve.reduced_model import ReducedModel
from fem.threads import side_by_side
from fem.waveguide.port_fields import PortFields, solve_ports


@dataclass(frozen=True, kw_only=True)
class Band:
    """A stator prepared for any frequency of a band; make it with `frequency_band`.

    Attributes
    ----------
    model : ReducedModel
    relative_error, admittance_error : float
        Of the surface motion at the places asked for and of the admittance, at the worst frequency of the band.
    seconds : float
        Set-up.
    """

    model: ReducedModel = field(repr=False)
    relative_error: float
    admittance_error: float
    seconds: float

    @property
    def limits(self) -> tuple[float, float]:
        """Lowest and highest frequency in Hz."""
        return self.model.limits

    @property
    def port_names(self) -> tuple[str, ...]:
        """Transducers that are ports, from left to right."""
        return tuple(each.name for each in self.model.transducers if {"+", "-"} <= set(each.signs))

    def wave(self, frequency: float, drive: str | Drive) -> SurfaceWave:
        """Surface motion at a frequency of the band (Hz).

        Places under a transducer and beside a free or clamped end, the interior and the power balance take the time
        of a condensation when they are first asked for.
        """
        begun = time.perf_counter()
        solution = driven_solution(self.model.port_fields(frequency), drive)
        return surface_wave(
            solution,
            relative_error=self.relative_error,
            admittance_error=self.admittance_error,
            seconds=time.perf_counter() - begun,
            solve=lambda: self.model.solution(frequency, drive),
        )

    def waves(self, frequencies: np.ndarray, drive: str | Drive) -> list[SurfaceWave]:
        """Surface motion at many frequencies of the band (Hz), in their order, side by side."""
        return side_by_side(lambda frequency: self.wave(float(frequency), drive), frequencies)

    def admittances(
        self, frequencies: np.ndarray, adapted: Callable[[PortFields], PortFields] | None = None
    ) -> np.ndarray:
        """Admittance matrix of all ports in S at frequencies of the band (Hz), shape (frequencies, ports, ports).

        ``adapted`` is what is done with the section's fields before, for instance `fem.beam.reception.with_apertures`.
        """

        def at(frequency: float) -> np.ndarray:
            model = self.model
            try:
                found = model.port_fields(float(frequency))
            except ConvergenceError:  # too few reduced lines to close the ends with, at this frequency
                found = solve_ports(
                    model.stator, model.transducers, frequency=float(frequency), resolution=model.resolution
                )
            return (adapted(found) if adapted else found).admittances

        return np.array(side_by_side(at, frequencies))
