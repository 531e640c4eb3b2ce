"""Motion of the slider on a prescribed wave: Hertz contact, friction spring, stick, slip and separation.

Conventions: exp(+i omega t), peak amplitudes, x along propagation, z out of the surface, compression positive, slider
velocity positive along +x, SI units. The model is that of Feenstra and Breedveld, *Analysis of a Surface Acoustic Wave
Motor*, with stick and slip as a stop operator. The compiled parts are loaded when first used.
"""

from importlib import import_module

# Public names by the module that defines them.
_PUBLIC = {
    "answers.derivatives": "velocity_derivative",
    "answers.first_use": "compiled_aside",
    "answers.ledger": "rough_ledger",
    "answers.load_and_stall": "blocked_thrust load_line LoadLine mean_traction stall",
    "answers.pull": "damper_pull",
    "answers.steady": "steady SteadyState",
    "answers.steps": "cycles_for Step step",
    "averaged.cycle_mean": "MeanForces",
    "averaged.adhesive_motion": "AdhesiveBalls AdhesiveMotion adhesive_motion holding_balls",
    "averaged.asperity_motion": "asperity_motion RoughBalls RoughMotion",
    "averaged.held_means": "AdhesiveMeans HeldMeans RoughMeans rough_first_normal",
    "averaged.steady_sweep": "mean_forces mean_motion MeanMotion steady_sweep",
    "answers.thresholds": (
        "release release_amplitude release_factor releases threshold threshold_amplitude threshold_factor"
    ),
    "answers.burst_motion": "burst Trajectory",
    "answers.waveforms": "contact_history History",
    "aliases": "balls_of pillar_load_line pillar_motion pillar_traction Pillars",
    "averaged.coupled_motion": "WaveRows",
    "choice": "Answer",
    "error_estimate": "axis_ratio changed_waves_error MIN_WAVE_STEP reference_speed speed_scale",
    "exceptions": "ConvergenceError InputError",
    "envelope": "Envelope",
    "jit": "kernels",
    "law.maugis": "MaugisSphere",
    "law.adhesion": "Adhesion AdhesiveSphere meniscus_force",
    "law.sphere_limits": "tabor_number",
    "law.falling": "FallingFriction",
    "law.asperities": "Asperities sample_force",
    "law.rough": "johnson_number MeanField Roughness",
    "law.table": "TabulatedForce",
    "law.user": "UserForce UserLaw",
    "orbit": "Orbit Orbits as_orbits",
    "rules": "AdhesionRules FrictionRules SliderRules",
    "slider": "Slider",
    "track": "Track",
    "passing_wave": "PassingWave",
    "averaged.riding": "mean_load riding_height",
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names.split()}
__all__ = sorted(_HOME)


def __getattr__(name: str):
    """Import a public name from its module when it is first used: importing the package stays cheap."""
    if name not in _HOME:
        raise AttributeError(f"module 'contact' has no attribute {name!r}")
    return getattr(import_module(f"contact.{_HOME[name]}"), name)


def __dir__():
    return __all__
