"""How the stator's surface moves: piezoelectric fields of a SAW motor's stator, from voltage to surface motion.

Conventions: exp(+i omega t), complex peak amplitudes, SI; x along the propagation, z out of the surface, body at
z < 0; Voigt order 11 22 33 23 13 12 with engineering shear.  The folders are the steps of the method: materials -
geometry - analytic (answers without a mesh) - discretize (elements through the depth) - condense (superelements) -
waveguide (guided modes, ends, network) - circuit - results - solve (error estimate, bands, bursts) - beam (a finite
aperture in three dimensions).  Two checks stand beside them: direct (the whole stator as one sparse matrix) and
cell_wave (a meshed cell of one wavelength).
"""

from importlib import import_module

_HOME = {
    "Band": "solve.band",
    "BeamError": "beam.surface_beam",
    "BurstEnvelope": "solve.burst",
    "CellTriple": "waveguide.cell_parameters",
    "ConvergenceError": "convergence",
    "Drive": "circuit",
    "Densities": "results.densities",
    "FreeWave": "results.free_wave",
    "HalfSpaceWave": "analytic.half_space",
    "PeriodicWave": "cell_wave",
    "SegmentModes": "results.segment_modes",
    "PointLoad": "analytic.point_load",
    "Solid": "materials",
    "Strength": "materials.strength",
    "Stator": "geometry",
    "SurfaceBeam": "beam.surface_beam",
    "SurfaceWave": "results.surface_wave",
    "Transducer": "geometry",
    "TransducerEstimate": "analytic.quasistatic",
    "WaveField": "results.field",
    "anisotropic": "materials",
    "automatic_period": "analytic.half_space",
    "frequency_band": "solve.band_setup",
    "blas_on_one_thread": "threads",
    "burst_response": "solve.burst",
    "catalogue": "materials",
    "cell_triple": "waveguide.cell_parameters",
    "coupling": "analytic.half_space",
    "direct_solution": "direct",
    "driven_wave": "solve.harmonic",
    "fields": "materials",
    "free_field": "results.field",
    "free_wave": "solve.free",
    "guided_modes": "solve.guided",
    "isotropic": "materials",
    "material": "materials",
    "one_blas_thread": "threads",
    "periodic_wave": "cell_wave",
    "point_load": "analytic.point_load",
    "rayleigh": "analytic.half_space",
    "read_vtu": "results.files",
    "relative_amplitude": "analytic.coupled_modes",
    "rotated": "materials",
    "strength": "materials.strength",
    "surface_beam": "beam.surface_beam",
    "transducer_estimate": "analytic.quasistatic",
    "wave_field": "results.field",
    "write_instant": "results.files",
    "write_vtu": "results.files",
}
__all__ = sorted(_HOME)


def __getattr__(name: str):
    """Import a public name from its module when it is first asked for: importing the package stays cheap."""
    if name not in _HOME:
        raise AttributeError(f"module 'fem' has no attribute {name!r}")
    return getattr(import_module(f"fem.{_HOME[name]}"), name)


def __dir__():
    return __all__
