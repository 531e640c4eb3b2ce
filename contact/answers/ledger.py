r"""Energy balance of a run or of one cycle, in joules.

    work of the wave = loss by slip + loss in the three dampers + work against the load + leak of the law
                       + increase of the energies of springs, preload and slider.

The wave does work through the normal and the tangential force on the moving surface. Only the elastic law without the
reciprocal normal force has a leak, because that law has no potential. A positive leak is a loss of energy. The residual
of the balance is due to truncation and rounding.
"""

from typing import NamedTuple

from contact.events.energy import EnergySum
from contact.slider import Slider


class Ledger(NamedTuple):
    """Energies over an interval of the motion, J.

    `ledger` relies on the order of the fields: to `leak` that of `energy.EnergySum`, then that of `Motion.energy`.

    Attributes
    ----------
    wave_normal, wave_tangential : float
        Work of the surface through the normal and the tangential force.
    slip : float
        Loss by slip.
    contact_damper, normal_damper, tangential_damper : float
        Losses in R_n1, R_n2 and R_t.
    load : float
        Work against the load.
    leak : float
        Loss in the elastic law without reciprocal normal force; zero for the other laws.
    stored : float
        Increase of the energy of the contact springs.
    lifted : float
        Increase of the potential energy of the preload.
    slider : float
        Increase of the slider's kinetic energy.
    """

    wave_normal: float
    wave_tangential: float
    slip: float
    contact_damper: float
    normal_damper: float
    tangential_damper: float
    load: float
    leak: float
    stored: float
    lifted: float
    slider: float

    @property
    def wave(self) -> float:
        """Work of the wave, J."""
        return self.wave_normal + self.wave_tangential

    @property
    def spent(self) -> float:
        """Sum of all losses, the work against the load and all energy increases, J."""
        dampers = self.contact_damper + self.normal_damper + self.tangential_damper
        held = self.stored + self.lifted + self.slider
        return self.slip + dampers + self.load + self.leak + held

    @property
    def residual(self) -> float:
        """Work of the wave less `spent`, J."""
        return self.wave - self.spent

    @property
    def relative_residual(self) -> float:
        """Residual over the work of the wave, or over the slip and damper losses if the wave does no work."""
        scale = abs(self.wave_normal) + abs(self.wave_tangential)
        if scale == 0.0:
            scale = self.slip + self.contact_damper + self.normal_damper + self.tangential_damper
        return abs(self.residual) / scale if scale > 0.0 else 0.0


def together(*ledgers: Ledger) -> Ledger:
    """Return the ledger of consecutive intervals."""
    return Ledger(*map(sum, zip(*ledgers, strict=True)))


def ledger(slider: Slider, motion, spans: int = 1) -> Ledger:
    """Return the ledger of a `motion.Motion` since its start, divided by `spans` (its number of cycles)."""
    unit = slider.unit_mass * motion.problem.speed**2 / spans
    works_and_losses = motion.sums[EnergySum.WAVE_NORMAL : EnergySum.LEAK + 1]
    increases = motion.energy() - motion.begun  # of the springs, the preload and the slider
    return Ledger(*(unit * works_and_losses).tolist(), *(unit * increases).tolist())
