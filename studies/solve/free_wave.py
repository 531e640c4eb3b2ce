"""The record of a scene without transducers: the free wave of its section."""

import time

import fem
from studies.model.model import Model
from studies.model.scene_errors import as_run_errors
from studies.record import Record
from studies.record.blocks import ErrorBlock, WaveBlock
from studies.record.values import Columns


def free_wave_record(model: Model, tolerance: float) -> Record:
    """Return the record of the free wave of a section."""
    start_time = time.perf_counter()
    with as_run_errors():
        wave = fem.free_wave(model.plain, frequency=model.scene.frequency, tolerance=tolerance)
    u_x, u_y, u_z, phi = wave.profile.T
    block = WaveBlock(
        frequency_Hz=wave.frequency, phase_velocity_m_per_s=wave.velocity, surface_ratio=wave.surface_ratio,
        attenuation_per_m=wave.attenuation,
    )  # fmt: skip
    return Record(
        scene=model.scene, tolerance=tolerance, wave=block,
        error=ErrorBlock(relative=wave.relative_error, parts={"stator": wave.relative_error}),
        seconds={"stator": time.perf_counter() - start_time},
        surface=Columns(
            z_m=wave.depth, u_x_per_m_of_u_z=u_x, u_y_per_m_of_u_z=u_y, u_z_per_m_of_u_z=u_z, phi_V_per_m_of_u_z=phi
        ),
    )  # fmt: skip
