"""The record of a scene without transducers: the free wave of its section."""

import time

import fem
from studies.chain import fem_model
from studies.chain.left_out import left_out
from studies.chain.solver_errors import answered
from studies.record import Record
from studies.scene import Scene


def free_wave_record(scene: Scene, tolerance: float) -> Record:
    """Return the record of the free wave of a section."""
    start_time = time.perf_counter()
    with answered():
        wave = fem.free_wave(fem_model.stator(scene.stator), frequency=scene.frequency, tolerance=tolerance)
    names = ("u_x", "u_y", "u_z", "phi_V")
    columns = {"z_m": wave.depth}
    columns |= {f"{name}_per_m_of_u_z": wave.profile[:, k] for k, name in enumerate(names)}
    return Record(
        scene=scene,
        tolerance=tolerance,
        wave={
            "frequency_Hz": wave.frequency,
            "phase_velocity_m_per_s": wave.velocity,
            "surface_ratio": wave.surface_ratio,
            "attenuation_per_m": wave.attenuation,
        },
        error={"relative": wave.relative_error, "parts": {"stator": wave.relative_error}},
        seconds={"stator": time.perf_counter() - start_time},
        left_out=left_out(scene),
        surface=columns,
    )
