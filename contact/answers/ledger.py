r"""Energy balance of a run or of one cycle, in joules.

    work of the wave = loss by slip + loss in the three dampers + work against the load + leak of the law
                       + loss where adhesive contacts open + increase of the energies of springs, preload and slider.

The wave does work through the normal and the tangential force on the moving surface. Only the elastic law without the
reciprocal normal force has a leak, because that law has no potential. A positive leak is a loss of energy. The residual
of the balance is due to truncation and rounding.
"""

from collections.abc import Sequence
from typing import NamedTuple

from contact.averaged.asperity_motion import RoughBalls, RoughMotion
from contact.events.energy import EnergySum
from contact.orbit import Orbit
from contact.slider import Slider


class Ledger(NamedTuple):
    """Energies over an interval of the motion, J.

    `ledger` relies on the order of the fields: to `adhesion` that of `energy.EnergySum`, then that of `Motion.energy`.

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
    adhesion : float
        Loss where contacts that hold on beyond the touch open: of their normal force around both branches, and of their
        springs; zero for the other contacts.
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
    adhesion: float
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
        return self.slip + dampers + self.load + self.leak + self.adhesion + held

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
    works_and_losses = motion.sums[EnergySum.WAVE_NORMAL : EnergySum.ADHESION_LOSS + 1]
    return Ledger(*(unit * works_and_losses).tolist(), *(unit * motion.increases()).tolist())


def rough_ledger(balls: RoughBalls, orbits: Orbit | Sequence[Orbit], motion: RoughMotion) -> Ledger:
    """Return the ledger of a cycle of a heavy slider on rough balls, from its `RoughBalls.motion` on the same orbits.

    The normal force depends on the approach alone and does no work in a cycle; at one velocity nothing is stored. The
    memory of Mindlin and Deresiewicz conserves what it does not lose by slip, stops of the elastic law have a leak.

    Examples
    --------
    >>> from contact import MeanField, Orbit, Roughness
    >>> ball = Slider(radius=1e-3, mass=0.089e-3, preload=0.87309e-3, load=5e-6, friction_coefficient=0.08,
    ...     effective_modulus=64e9, tangential_modulus=12e9, law="hysteretic", reciprocal=False, stick_band=0.0,
    ...     contact_damping=0.0, normal_damping=0.5, tangential_damping=0.0)
    >>> rough = RoughBalls(ball, [MeanField(1e-3, 64e9, Roughness(rms=3e-9))])
    >>> wave = Orbit(frequency=2.2e6, normal=5e-9, tangential=-3.35e-9j)
    >>> energies = rough_ledger(rough, wave, rough.motion(wave, tolerance=1e-3))
    >>> print(f"{energies.load / energies.wave:.3f} of the work reaches the load, {energies.relative_residual < 1e-10}")
    0.147 of the work reaches the load, True
    """
    powers, period = balls.powers(orbits, motion), 1.0 / (orbits if isinstance(orbits, Orbit) else orbits[0]).frequency
    speed, slider = abs(powers.velocity), balls.slider
    return Ledger(
        wave_normal=0.0, wave_tangential=period * powers.work, slip=period * powers.slip, contact_damper=0.0,
        normal_damper=0.0, tangential_damper=period * slider.tangential_damping * speed**2,
        load=period * motion.solved.load * speed, leak=period * powers.leak, adhesion=0.0, stored=0.0, lifted=0.0,
        slider=0.0,
    )  # fmt: skip
