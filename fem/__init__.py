"""How the stator's surface moves: piezoelectric fields of a SAW motor's stator, from voltage to surface motion.

Conventions: exp(+i omega t), complex peak amplitudes, SI; x along the propagation, z out of the surface, body at
z < 0; Voigt order 11 22 33 23 13 12 with engineering shear.  The folders are the steps of the method: materials -
geometry - analytic (answers without a mesh) - discretize (elements through the depth) - condense (superelements) -
waveguide (guided modes, ends, network) - circuit - results - reduce (a band of frequencies) - beam (a finite aperture
in three dimensions) - solve (answers with an error).
"""

from importlib import import_module

# Public names by the module that defines them, in the order of the method.
_PUBLIC = {
    "materials": "anisotropic catalogue fields isotropic material rotated Solid VACUUM_PERMITTIVITY",
    "materials.solids": "IsotropicConstants",
    "materials.rotation": "CONVENTIONS euler_angles isotropic_about_normal named_cut rotation_matrix",
    "materials.tables": "catalogue_table catalogue_text material_names",
    "materials.temperature": "COEFFICIENT_ORDERS expansion_along expansions in_cold_lengths solid_at table_at",
    "materials.class_tables": "class_tables CLASSES constant_names TIED_C66",
    "materials.forms": (
        "at_constant_field at_constant_strain Conditions FORMS from_strain_charge in_order ORDERS stress_charge"
    ),
    "materials.limits": "refuse_impossible",
    "materials.plausibility": "plausibility",
    "materials.medium": "media medium",
    "materials.christoffel": "slowest_wavelength",
    "materials.strength": "Strength strength",
    "mesh.section_mesh": "MeshError read_mesh SectionMesh",
    "mesh.mesh_piece": "MeshPiece",
    "geometry": (
        "Bond cell_signs covers fingers_off_stator Layer one_electrode outer_gaps plane_rule repeated_names Stator "
        "strips_of Transducer"
    ),
    "layout": "check_beside_pieces check_layout check_plan check_turned LENGTH_UNITS TURNED turned_rules",
    "analytic.wave_compliance": ("bound_compliance film_shift spring_shift travelling_compliance wave_compliance"),
    "analytic.half_space": "automatic_period coupling HalfSpaceWave rayleigh surface_named",
    "analytic.layered_wave": (
        "bound_period bound_wave layered_waves LayeredWave principal_wave shorted_velocities shorted_velocity"
    ),
    "analytic.leaky_wave": "leaky_waves LeakyWave",
    "analytic.wave_branches": "wave_branches WaveBranch",
    "analytic.slowness": "Slowness",
    "analytic.point_load": "point_load PointLoad",
    "analytic.quasistatic": (
        "end_excess layered_estimate plane_permittivity surface_permittivity transducer_estimate TransducerEstimate"
    ),
    "analytic.coupled_modes": "relative_amplitude",
    "heat": "drive_folds foldover_number FOLDOVER_LIMIT folds heated_powers heated_states HeatedPlate HeatedState "
    "HeatSource MAX_BIOT_NUMBER runaway_rise sampled_foldover_number temperature_profile TemperatureProfile",
    "discretize.absorber": "absorber_kind",
    "discretize.element_sizes": "Resolution",
    "discretize.mesh_refinement": "LEVELS planned_levels",
    "discretize.spectral": "reference_matrices",
    "discretize.depth_mesh": "discretise",
    "condense.problem_size": "stator_size",
    "waveguide.line_force": "force_response ForceResponse LineForce",
    "waveguide.grating": "grating",
    "sources": "SourceRules",
    "circuit": (
        "best_match Drive Element matched_load motional_model MotionalModel "
        "rectifier_resistance solve_circuit touchstone"
    ),
    "results.field_evaluation": "surface_of",
    "results.driven_answer": "surface_wave SurfaceWave",
    "results.surface": "standing_wave_ratio",
    "results.segment_modes": "FreeWave SegmentModes",
    "results.interior_field": "free_field PieceField wave_field WaveField",
    "results.energy_densities": "Densities",
    "results.field_files": "write_instant write_surface write_vtu",
    "solve.driven_stator": "driven_wave solve_driven",
    "solve.port_admittance": "port_admittance PortAdmittance",
    "solve.band_solution": "Band frequency_band",
    "solve.beam_band": "beam_band BeamBand",
    "solve.periodic_cell": "cell_parameters CellParameters",
    "solve.burst_envelope": "burst_response BurstEnvelope",
    "solve.forced_surface": "forced_wave",
    "solve.guided": "free_wave guided_modes",
    "solve.best_frequency": "best_frequency best_period",
    "solve.p_matrix_from_field": "cascade_admittance p_matrix PMatrix",
    "solve.piece_scattering": "Reflector reflector",
    "beam.surface_beam": "BeamError SurfaceBeam",
    "beam.beam_of_section": "aperture_beam beam_refusal surface_beam",
    "beam.crossed_beam": "crossed_beam CrossedBeam",
    "beam.parallel_groups": "rows_of",
    "beam.strip_beam": "strip_beam StripBeam",
    "exceptions": "ConvergenceError InputError",
    "threads": "blas_on_one_thread one_blas_thread set_workers side_by_side",
}
_HOME = {name: module for module, names in _PUBLIC.items() for name in names.split()}
__all__ = sorted(_HOME)


def __getattr__(name: str):
    """Import a public name from its module on first use: importing the package stays cheap."""
    if name not in _HOME:
        raise AttributeError(f"module 'fem' has no attribute {name!r}")
    return getattr(import_module(f"fem.{_HOME[name]}"), name)


def __dir__():
    return __all__
