"""How the stator's surface moves: piezoelectric fields of a SAW motor's stator, from voltage to surface motion.

Conventions: exp(+i omega t), complex peak amplitudes, SI; x along the propagation, z out of the surface, body at
z < 0; Voigt order 11 22 33 23 13 12 with engineering shear.  The folders are the steps of the method: materials -
geometry - analytic (answers without a mesh) - discretize (elements through the depth) - condense (superelements) -
waveguide (guided modes, ends, network) - circuit - results - solve (error estimate, bands, bursts) - beam (a finite
aperture in three dimensions).  A check stands beside them: direct (the whole stator as one sparse matrix).
"""

from importlib import import_module

_HOME = {
    "anisotropic": "materials",
    "automatic_period": "analytic.half_space",
    "Band": "solve.band",
    "BeamError": "beam.surface_beam",
    "beam_refusal": "beam.surface_beam",
    "best_match": "circuit",
    "best_frequency": "solve.passband",
    "best_period": "solve.passband",
    "blas_on_one_thread": "threads",
    "cascade_admittance": "solve.p_matrix",
    "burst_response": "solve.burst",
    "BurstEnvelope": "solve.burst",
    "catalogue": "materials",
    "cell_parameters": "waveguide.cell_parameters",
    "CellParameters": "waveguide.cell_parameters",
    "check_layout": "geometry",
    "ConvergenceError": "convergence",
    "coupling": "analytic.half_space",
    "Densities": "results.densities",
    "direct_solution": "direct",
    "discretise": "discretize.elements",
    "Drive": "circuit",
    "Element": "circuit",
    "driven_wave": "solve.harmonic",
    "fields": "materials",
    "free_field": "results.field",
    "free_wave": "solve.guided",
    "FreeWave": "results.segment_modes",
    "frequency_band": "solve.band_setup",
    "grating": "waveguide.grating",
    "guided_modes": "solve.guided",
    "HalfSpaceWave": "analytic.half_space",
    "isotropic": "materials",
    "isotropic_about_normal": "beam.line_source",
    "LEVELS": "discretize.refinement",
    "matched_load": "circuit",
    "material": "materials",
    "medium": "materials.medium",
    "one_blas_thread": "threads",
    "motional_model": "circuit",
    "MotionalModel": "circuit",
    "p_matrix": "solve.p_matrix",
    "PMatrix": "solve.p_matrix",
    "outer_gaps": "geometry",
    "planned_levels": "discretize.refinement",
    "point_load": "analytic.point_load",
    "PointLoad": "analytic.point_load",
    "port_admittance": "solve.port_admittance",
    "PortAdmittance": "solve.port_admittance",
    "rayleigh": "analytic.half_space",
    "read_touchstone": "circuit",
    "read_vtu": "results.files",
    "rectifier_resistance": "circuit",
    "reference_matrices": "discretize.spectral",
    "relative_amplitude": "analytic.coupled_modes",
    "Resolution": "discretize.grading",
    "rotated": "materials",
    "rotation_matrix": "materials.rotation",
    "SegmentModes": "results.segment_modes",
    "set_workers": "threads",
    "side_by_side": "threads",
    "slowest_wavelength": "materials.christoffel",
    "Solid": "materials",
    "solve_circuit": "circuit",
    "solve_driven": "results.solution",
    "sparse_solution": "direct",
    "Stator": "geometry",
    "stator_size": "condense.size",
    "Strength": "materials.strength",
    "strength": "materials.strength",
    "surface_beam": "beam.surface_beam",
    "surface_named": "analytic.half_space",
    "surface_of": "results.evaluation",
    "surface_permittivity": "analytic.quasistatic",
    "surface_wave": "results.surface_wave",
    "SurfaceBeam": "beam.surface_beam",
    "SurfaceWave": "results.surface_wave",
    "touchstone": "circuit",
    "Transducer": "geometry",
    "transducer_estimate": "analytic.quasistatic",
    "TransducerEstimate": "analytic.quasistatic",
    "VACUUM_PERMITTIVITY": "materials",
    "wave_field": "results.field",
    "WaveField": "results.field",
    "write_instant": "results.files",
    "write_surface": "results.files",
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
