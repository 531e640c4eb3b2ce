"""How the slider answers: Hertz contact, friction spring, stick, slip and separation on a given wave.

Conventions: exp(+i omega t), peak amplitudes, x along propagation, z out of the surface, compression positive, slider
velocity positive along +x, SI units. The model is that of Feenstra and Breedveld, *Analysis of a Surface Acoustic Wave
Motor*, with stick and slip as a stop operator. The compiled parts are loaded when first used.
"""

from contact.averaged import MeanMotion, mean_motion
from contact.batch import SteadyMap, steady_map
from contact.convergence import ConvergenceError
from contact.envelope import Envelope
from contact.history import History, contact_history
from contact.limits import riding_height
from contact.onset import release_amplitude, release_factor, threshold_amplitude, threshold_factor
from contact.orbit import Orbit
from contact.planner import Step, cycles_for, step
from contact.population import Population, steady_population
from contact.second_opinion import SecondOpinion, second_opinion
from contact.slider import Slider
from contact.steady import SteadyState, steady
from contact.thrust import LoadLine, blocked_thrust, load_line
from contact.trajectory import Trajectory, burst

__all__ = [
    "ConvergenceError",
    "Envelope",
    "History",
    "LoadLine",
    "MeanMotion",
    "Orbit",
    "Population",
    "SecondOpinion",
    "Slider",
    "SteadyMap",
    "SteadyState",
    "Step",
    "Trajectory",
    "blocked_thrust",
    "burst",
    "contact_history",
    "cycles_for",
    "load_line",
    "mean_motion",
    "release_amplitude",
    "release_factor",
    "riding_height",
    "second_opinion",
    "steady",
    "steady_map",
    "steady_population",
    "step",
    "threshold_amplitude",
    "threshold_factor",
]
