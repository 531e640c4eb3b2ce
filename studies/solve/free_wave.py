"""The record of a scene without transducers: the free wave of its section."""

import time

import fem
from studies.model import fem_objects
from studies.model.scene_errors import as_run_errors
from studies.record import Record
from studies.record.blocks import ErrorBlock, WaveBlock
from studies.scene import Scene


def free_wave_record(scene: Scene, tolerance: float) -> Record:
    """Return the record of the free wave of a section."""
    start_time = time.perf_counter()
    with as_run_errors():
        wave = fem.free_wave(fem_objects.stator(scene.stator), frequency=scene.frequency, tolerance=tolerance)
    names = [f"{name}_per_m_of_u_z" for name in ("u_x", "u_y", "u_z", "phi_V")]
    block = WaveBlock(
        frequency_Hz=wave.frequency, phase_velocity_m_per_s=wave.velocity, surface_ratio=wave.surface_ratio,
        attenuation_per_m=wave.attenuation,
    )  # fmt: skip
    return Record(
        scene=scene, tolerance=tolerance, wave=block,
        error=ErrorBlock(relative=wave.relative_error, parts={"stator": wave.relative_error}),
        seconds={"stator": time.perf_counter() - start_time},
        surface={"z_m": wave.depth} | dict(zip(names, wave.profile.T, strict=True)),
    )  # fmt: skip
