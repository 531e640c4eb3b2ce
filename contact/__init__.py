"""How the slider answers: Hertz contact, friction spring, stick, slip and separation on a given wave.

Conventions: exp(+i omega t), peak amplitudes, x along propagation, z out of the surface, compression positive, slider
velocity positive along +x, SI units. The model is that of Feenstra and Breedveld, *Analysis of a Surface Acoustic Wave
Motor*, with stick and slip as a stop operator. The compiled parts are loaded when first used.
"""

from contact.answers.derivatives import velocity_derivative
from contact.answers.load_line import LoadLine, blocked_thrust, load_line, mean_traction
from contact.answers.steady import SteadyState, steady
from contact.answers.steps import Step, cycles_for, step
from contact.answers.sweep import MeanMotion, mean_motion, steady_sweep
from contact.answers.thresholds import (
    release_amplitude,
    release_factor,
    threshold_amplitude,
    threshold_factor,
)
from contact.answers.transient import Trajectory, burst
from contact.answers.waveforms import History, contact_history
from contact.convergence import ConvergenceError
from contact.envelope import Envelope
from contact.jit import kernels
from contact.orbit import Orbit
from contact.slider import Slider
from contact.solve.riding import riding_height

__all__ = [
    "ConvergenceError",
    "Envelope",
    "History",
    "LoadLine",
    "MeanMotion",
    "Orbit",
    "Slider",
    "SteadyState",
    "Step",
    "Trajectory",
    "blocked_thrust",
    "burst",
    "contact_history",
    "cycles_for",
    "kernels",
    "load_line",
    "mean_motion",
    "mean_traction",
    "release_amplitude",
    "release_factor",
    "riding_height",
    "steady",
    "steady_sweep",
    "step",
    "threshold_amplitude",
    "threshold_factor",
    "velocity_derivative",
]
