"""The driven stator's answer at one frequency: surface motion, circuit and power, each with its error."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

from fem.circuit import Circuit
from fem.results.field_evaluation import surface_of
from fem.results.power_balance import PowerBalance, power_balance
from fem.results.stator_solution import Solution
from fem.results.surface import Surface


@dataclass(frozen=True, kw_only=True)
class SurfaceWave(Surface):
    """The driven stator's answer at one frequency, per volt of the drive (peak).

    Attributes
    ----------
    frequency, length, pieces, phase_velocity, surface_ratio
        Of `Surface`, which also gives the motion.
    circuit : Circuit
        Voltages and currents of the transducers.
    relative_error : float
        Of the surface motion at the requested positions, from two discretisations.
    admittance_error : float
        Relative error of the admittance, from two discretisations.
    unknowns : int
        Of the discretised problem that was condensed.
    resolution : str
    solve : callable
        Returns the `Solution` that the interior is evaluated from.
    balance : callable
        Returns the power balance.
    """

    circuit: Circuit
    relative_error: float
    admittance_error: float
    unknowns: int
    resolution: str
    solve: Callable[[], Solution] = field(repr=False, compare=False)
    balance: Callable[[], PowerBalance] = field(repr=False, compare=False)

    @cached_property
    def solution(self) -> Solution:
        """Fields of the ports and the circuit."""
        return self.solve()

    @property
    def admittance(self) -> complex:
        """Current over voltage of the (first) driven transducer, S."""
        return self.circuit.admittance

    @property
    def comb_voltage_per_volt(self) -> complex:
        """Voltage between the electrodes of the (first) driven transducer."""
        return self.circuit.voltage

    @cached_property
    def power(self) -> PowerBalance:
        """Power balance."""
        return self.balance()

    @property
    def power_residual(self) -> float:
        """Largest imbalance of power at a piece or a force, relative to the apparent power of sources and forces."""
        return self.power.residual


def surface_wave(
    solution: Solution,
    *,
    relative_error: float,
    admittance_error: float,
    solve: Callable[[], Solution] | None = None,
    balance: Callable[[], PowerBalance] | None = None,
) -> SurfaceWave:
    """Return the answer of a solution whose motion and admittance have known errors.

    ``solve`` returns the solution again, where keeping it would take too much memory; ``balance`` its power balance,
    where that is known.
    """
    again = solve or (lambda: solution)
    surface = surface_of(solution, again)
    return SurfaceWave(
        **{name: getattr(surface, name) for name in Surface.__dataclass_fields__},
        circuit=solution.circuit,
        relative_error=relative_error,
        admittance_error=admittance_error,
        unknowns=solution.fields.unknowns,
        resolution=solution.fields.resolution.name,
        solve=again,
        balance=balance or (lambda: power_balance(again())),
    )
