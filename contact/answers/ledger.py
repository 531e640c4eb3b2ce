r"""The energy balance of a run or of one cycle, in joules.

    work of the wave = lost in slip + in the three dampers + against the load + leak of the law
                       + what springs, preload and slider hold more at the end than at the start.

The wave works through the normal and the tangential force on the moving surface. A leak belongs to the elastic law
without the reciprocal normal force alone: it has no potential (positive: energy vanishes in the law). The residual is
what the balance misses by truncation and rounding.
"""

from typing import NamedTuple

from contact.events.energy import Sum
from contact.slider import Slider


class Ledger(NamedTuple):
    """Energies over a span of the motion, J.

    Attributes
    ----------
    wave_normal, wave_tangential : float
        Work of the surface through the normal and the tangential force.
    slip : float
        Lost in slip.
    contact_damper, normal_damper, tangential_damper : float
        Lost in R_n1, R_n2 and R_t.
    load : float
        Work against the load.
    leak : float
        Lost in the elastic law without reciprocal normal force; zero for the other laws.
    stored : float
        Gained by the springs of the contacts.
    lifted : float
        Gained by the preload's potential.
    slider : float
        Gained by the slider's kinetic energy.
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
        """Everything that the work of the wave became, J."""
        dampers = self.contact_damper + self.normal_damper + self.tangential_damper
        held = self.stored + self.lifted + self.slider
        return self.slip + dampers + self.load + self.leak + held

    @property
    def residual(self) -> float:
        """What the balance misses, J."""
        return self.wave - self.spent

    @property
    def relative_residual(self) -> float:
        """Residual over the work of the wave; over the slip and damper losses where no wave works."""
        scale = abs(self.wave_normal) + abs(self.wave_tangential)
        if scale == 0.0:
            scale = self.slip + self.contact_damper + self.normal_damper + self.tangential_damper
        return abs(self.residual) / scale if scale > 0.0 else 0.0


def together(*ledgers: Ledger) -> Ledger:
    """Return the ledger of spans one after the other."""
    return Ledger(*map(sum, zip(*ledgers, strict=True)))


def ledger(slider: Slider, motion, spans: int = 1) -> Ledger:
    """Return the ledger of what a `motion.Motion` has done since it began, shared among some spans."""
    unit = slider.mass * motion.problem.speed**2 / spans
    done, gained = motion.sums[Sum.WAVE_NORMAL : Sum.LEAK + 1], motion.energy() - motion.begun
    return Ledger(*(unit * done).tolist(), *(unit * gained).tolist())
