"""The problem of a slider on surface waves in the units of `plane_equations`, and the period of the waves."""

import math
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from contact.error_estimate import beat_error, first_order_error
from contact.exceptions import ConvergenceError, InputError
from contact.law import normal
from contact.plane.plane_equations import UNSHAPED, Knots, PlaneProblem
from contact.plane.plane_waves import SurfaceWaves
from contact.slider import Slider

MAX_CYCLES = 400  # of the fastest wave in a common period
FREE = {"x": (0,), "xy": (0, 1), "xy yaw": (0, 1, 2), "axle": (2,)}  # of (V_x, V_y, yaw rate)


class Scaled(NamedTuple):
    """A problem and its units."""

    problem: PlaneProblem
    length: float  # ell, m
    omega: float  # rad/s
    force: float  # N
    period: float  # of the waves, rad of the fastest
    period_change: float  # relative change of a frequency by which the waves were made commensurable

    @property
    def speed(self) -> float:
        """Unit of velocity, m/s."""
        return self.length * self.omega

    @property
    def power(self) -> float:
        """Unit of power, W."""
        return self.force * self.speed


def common_period(frequencies: np.ndarray, denominator: int = MAX_CYCLES) -> tuple[np.ndarray, float, float]:
    """Return (frequencies over the largest, common period in rad of the fastest, largest relative change of them).

    Frequencies without a common period of at most `denominator` cycles take the nearest ones that have one.
    """
    largest = float(frequencies.max())
    for limit in (denominator, denominator // 4, 20, 8, 3, 1):
        ratios = [Fraction(float(each) / largest).limit_denominator(limit) for each in frequencies]
        cycles = math.lcm(*(each.denominator for each in ratios))
        if cycles <= denominator:
            break
    found = np.array([float(each) for each in ratios])
    return found, 2.0 * math.pi * cycles, float(np.max(np.abs(found * largest / frequencies - 1.0)))


def slowest_beat(frequencies: np.ndarray) -> float:
    """Return the least difference of two frequencies, Hz; inf of one."""
    return float(np.diff(np.sort(frequencies)).min()) if frequencies.size > 1 else math.inf


def scaled(
    slider: Slider, waves: SurfaceWaves, *, heavy: bool, rise: float = 0.0, stop: float = math.inf, commensurable=True,
    knots: Knots | None = None,
) -> Scaled:  # fmt: skip
    """Return the problem; `heavy`: no coordinate answers the forces. `rise` and `stop` of the envelope are in s."""
    n = waves.count
    if slider.count not in (1, n):
        raise InputError("wave.amplitudes", f"must hold one row per contact, {slider.count}", n)
    own, omega = slider.contacts(n), waves.omega
    reach = float(np.abs(waves.amplitudes).sum(axis=0).max())
    length = max(float(slider.rest_approaches(n).max()), reach, 1e-300)
    force = slider.unit_mass * omega**2 * length
    about = slider.axis if slider.freedom == "axle" else (0.0, 0.0)
    load = (slider.load, 0.0) if slider.freedom == "x" else slider.load
    ratio, period, change = common_period(waves.frequencies)
    if not commensurable:
        ratio = waves.frequencies / waves.frequencies.max()
    stiffness = own.weight * own.normal_stiffness * float(normal.load(length, slider.profile)) / force
    inverse = np.zeros(4)
    if not heavy:
        inverse[0] = 1.0
        for k in FREE[slider.freedom]:
            inverse[1 + k] = 1.0 if k < 2 else slider.unit_mass * length**2 / inertia_of(slider)
    damping = np.array([slider.normal_damping, *[slider.tangential_damping] * 2, slider.yaw_damping / length**2])
    problem = PlaneProblem(
        friction=float(slider.friction_coefficient), contact_damping=slider.contact_damping * omega * length,
        normal=normal.scaled(slider.profile, length), inverse=inverse,
        force=np.array([-slider.preload, -load[0], -load[1], -slider.torque / length]) / force,
        damping=damping / (slider.unit_mass * omega), x=(own.x - about[0]) / length, y=(own.y - about[1]) / length,
        height=own.height / length, stiffness=stiffness, limit_slope=np.array(own.limit_slope, float), ratio=ratio,
        cos=np.ascontiguousarray(waves.amplitudes.real / length),
        sin=np.ascontiguousarray(-waves.amplitudes.imag / length), rise=rise * omega, stop=stop * omega,
        knots=UNSHAPED if knots is None else knots,
    )  # fmt: skip
    return Scaled(problem, length, omega, force, period, change)


def inertia_of(slider: Slider) -> float:
    """Return the moment of inertia of a slider that turns, kg m^2."""
    if slider.inertia is None:
        raise InputError("slider.inertia", "is required where the yaw is followed in time, kg m^2")
    return slider.inertia


def resonance_ratios(slider: Slider, waves: SurfaceWaves) -> tuple[float, float]:
    """Return the contact resonance over the largest frequency and over the slowest beat."""
    resonance = slider.normal_resonance(waves.count)
    return resonance * 2.0 * math.pi / waves.omega, resonance / slowest_beat(waves.frequencies)


def averaging_error(slider: Slider, waves: SurfaceWaves) -> float:
    """Return the relative error of a velocity by first-order averaging, which neglects the slider's bounce.

    It bounces at the frequencies of the waves and, far more, at their beat; a slider of infinite mass does not.
    """
    if slider.mass == math.inf:
        return 0.0
    ratio, of_beat = resonance_ratios(slider, waves)
    return first_order_error(ratio) + beat_error(of_beat)


def beats_slowly(slider: Slider, waves: SurfaceWaves) -> bool:
    """Return True where the height of the slider follows the beat of two waves, so that no period is its mean."""
    return slowest_beat(waves.frequencies) < 2.0 * slider.normal_resonance(waves.count)


def refuse_slow_beat(slider: Slider, waves: SurfaceWaves, why: str = "") -> None:
    """Raise where waves beat slowly; ``why``: why the motion that repeats was not found either."""
    if not beats_slowly(slider, waves):
        return
    beat, resonance = slowest_beat(waves.frequencies), slider.normal_resonance(waves.count)
    remedy = 'method "exact" (slider.method of a scene), or the same method through a burst'
    if why:
        remedy = f"the motion that repeats was not found ({why}): follow it through a burst of several beats"
    raise ConvergenceError(
        "not applicable",
        f"the beat of {beat / 1e3:.3g} kHz is slower than twice the contact resonance of {resonance / 1e3:.2g} kHz: "
        f"{remedy}",
    )
