"""The blocks of run.json and the columns of surface.csv that describe the motion of a driven stator."""

import numpy as np

from studies.record.blocks import WaveBlock
from studies.record.point import Point
from studies.record.status import Status
from studies.record.values import Columns
from studies.scene import Scene
from studies.solve.surface_motion import SurfaceMotion

NODE = 1e-9  # relative to the largest |u_z| of the section; smaller amplitudes are rounding errors
PER_WAVELENGTH = 12  # lines of surface.csv per wavelength if the section does not lie along x


def wave_block(scene: Scene, motion: SurfaceMotion, ringing) -> WaveBlock:
    """Return the block ``wave`` of run.json.

    It contains the motion at the slider's centre, its relative error and the properties of the section's wave.
    ``ringing`` is the `RingUp` of a burst or None.
    """
    wave, slider, position = motion.wave, scene.slider, scene.positions[0]
    positions = [position] if slider is None else [position, *slider.contact_positions]
    components = motion.at(positions)
    tangential, lateral, normal = map(complex, components[:, 0])
    block = WaveBlock(frequency_Hz=wave.frequency, normal_m_per_V=normal, tangential_m_per_V=tangential)
    if motion.spreads:
        tangential, normal = map(complex, wave.motion(motion.in_section(position)))
        block |= WaveBlock(
            lateral_m_per_V=lateral,
            largest_lateral_ratio=float((abs(components[1]) / abs(components[0])).max()),
            section_tangential_m_per_V=tangential,
            section_normal_m_per_V=normal,
        )
    if not motion.covered(position):
        block |= WaveBlock(rayleigh_normal_m_per_V=motion.surface_mode_at(position))
    block |= WaveBlock(
        standing_wave_ratio=motion.standing_wave_ratio(position),
        phase_velocity_m_per_s=wave.phase_velocity,
        surface_ratio=wave.surface_ratio,
        relative_error=motion.relative_error(positions),
        resolution=wave.resolution,
    )
    if ringing is not None and ringing.response is not None:
        block |= WaveBlock(settling_time_s=ringing.response.settling)
    return block


def node(motion: SurfaceMotion, positions) -> str:
    """Return that u_z vanishes under every contact, if it does, otherwise an empty string."""
    under, largest = abs(motion.at(positions)[2]).max(), abs(motion.wave.samples()[1][1]).max()
    if under > NODE * largest:
        return ""
    return (
        f"u_z vanishes under the slider ({under:.1e} m per V, {largest:.1e} elsewhere), as in the middle of "
        "a transducer by symmetry: choose another slider.position"
    )


def amplitude_points(scene: Scene, motion: SurfaceMotion) -> tuple[Point, ...]:
    """Return the points of a scene without a slider, whose result is the amplitude at its position."""
    position = scene.positions[0]
    tangential, _, normal = (float(size) for size in abs(motion.at([position])[:, 0]))
    error = motion.relative_error([position])
    return tuple(
        Point(
            voltage_V=voltage, normal_amplitude_m=normal * voltage, tangential_amplitude_m=tangential * voltage,
            relative_error=error if voltage else 0.0, status=Status.OK.value,
        )
        for voltage in scene.levels
    )  # fmt: skip


def surface_columns(scene: Scene, motion: SurfaceMotion) -> Columns:
    """Return x and the motion per volt along the section, or along y = 0 if the section does not lie along x."""
    if scene.driven_obliquely:
        spacing = motion.wave.phase_velocity / scene.frequency / PER_WAVELENGTH
        x = np.linspace(0.0, scene.stator.length, int(scene.stator.length / spacing) + 1)
        tangential, _, normal = motion.along(x, 0.0)
    else:
        x, (tangential, normal) = motion.wave.samples()
    return Columns(x_m=x, u_x_m_per_V=tangential, u_z_m_per_V=normal)
