"""A band of frequencies without a reduced model: every frequency takes the time of one full solution.

For stators with a step of thickness, or of one mesh, which the reduced model cannot represent.  The discretisation is
the finest that three frequencies of the band need to meet the tolerance.
"""

from dataclasses import dataclass

from fem.circuit import Drive
from fem.discretize.grading import Resolution
from fem.geometry import Stator, Transducer
from fem.input_error import InputError
from fem.results.solution import Solution, driven_solution
from fem.waveguide.port_fields import PortFields, Solve, solve_ports


@dataclass(frozen=True, kw_only=True)
class FullModel:
    """A stator solved anew at every frequency of a band; it answers as `fem.reduce.model.ReducedModel` does."""

    stator: Stator
    transducers: tuple[Transducer, ...]  # from left to right
    limits: tuple[float, float]  # lowest and highest frequency in Hz
    resolution: Resolution

    def port_fields(self, frequency: float, solve: Solve | None = None) -> PortFields:
        """Solve for unit voltage at every port at a frequency of the band (Hz); ``solve``: as of `joined_fields`."""
        low, high = self.limits
        if not low <= frequency <= high:
            raise InputError("frequency", f"must lie in the band, {low:g} to {high:g} Hz", frequency, "Hz")
        return solve_ports(
            self.stator, self.transducers, frequency=frequency, resolution=self.resolution, solve=solve
        )

    def solution(self, frequency: float, drive: str | Drive) -> Solution:
        """Solve for a drive at a frequency of the band (Hz)."""
        return driven_solution(self.port_fields(frequency), drive)
