"""How the stator's surface moves: piezoelectric fields of a SAW motor's stator, from voltage to surface motion.

Conventions: exp(+i omega t), complex peak amplitudes, SI; x along the propagation, z out of the surface, body at
z < 0; Voigt order 11 22 33 23 13 12 with engineering shear.  The rooms, bottom to top: materials - spectral, forms -
stroh, half_space - geometry - quasistatic - section - guided, modes - cell - chain - network, electrodes - solution -
surface, readout, densities - audit, field, field_file - gratings - harmonic, free - triple, reduced - band -
preparation; burst reads waves; direct stands beside them as the check.
"""

from importlib import import_module

_HOME = {
    "Band": "band",
    "BurstEnvelope": "burst",
    "CellTriple": "triple",
    "ConvergenceError": "convergence",
    "Densities": "densities",
    "FreeWave": "free",
    "HalfSpaceWave": "half_space",
    "PeriodicWave": "modes",
    "PointLoad": "analytic.point_load",
    "Solid": "materials",
    "Stator": "geometry",
    "SurfaceWave": "surface",
    "Transducer": "geometry",
    "TransducerEstimate": "quasistatic",
    "WaveField": "field",
    "anisotropic": "materials",
    "automatic_period": "geometry",
    "frequency_band": "preparation",
    "burst_response": "burst",
    "catalogue": "materials",
    "cell_triple": "triple",
    "coupling": "half_space",
    "direct_solution": "direct",
    "driven_wave": "harmonic",
    "fields": "materials",
    "free_field": "field",
    "free_wave": "free",
    "isotropic": "materials",
    "material": "materials",
    "periodic_wave": "modes",
    "point_load": "analytic.point_load",
    "rayleigh": "half_space",
    "read_vtu": "field_file",
    "rotated": "materials",
    "transducer_estimate": "quasistatic",
    "wave_field": "field",
    "write_instant": "field_file",
    "write_vtu": "field_file",
}
__all__ = sorted(_HOME)


def __getattr__(name: str):
    """Import a public name from its room when it is first asked for: importing the package stays cheap."""
    if name not in _HOME:
        raise AttributeError(f"module 'fem' has no attribute {name!r}")
    return getattr(import_module(f"fem.{_HOME[name]}"), name)


def __dir__():
    return __all__
