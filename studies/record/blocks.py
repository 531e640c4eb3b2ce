"""The blocks of a record: their fields are the keys of run.json, with the meaning that ``quantities.csv`` states."""

from typing import Any

from studies.record.values import Complex, Count, Number, Pair, Text, Values


class WaveBlock(Values):
    """Keys ``wave.*``: the motion under the slider per volt and the properties of the wave."""

    # wave.*
    frequency_Hz: Number = None
    normal_m_per_V: Complex = None
    tangential_m_per_V: Complex = None
    lateral_m_per_V: Complex = None
    largest_lateral_ratio: Number = None
    section_normal_m_per_V: Complex = None
    section_tangential_m_per_V: Complex = None
    rayleigh_normal_m_per_V: Complex = None
    standing_wave_ratio: Number = None
    phase_velocity_m_per_s: Number = None
    surface_ratio: Number = None
    attenuation_per_m: Number = None
    relative_error: Number = None
    resolution: Text = None
    settling_time_s: Number = None


class ElectricalBlock(Values):
    """Keys ``electrical.*``: admittance and powers, per squared volt of the source."""

    # electrical.*
    admittance_S: Complex = None
    comb_voltage_per_volt: Complex = None
    power_W_per_V2: Number = None
    power_dissipated_W_per_V2: Number = None
    power_radiated_W_per_V2: Number = None
    power_solid_W_per_V2: Number = None
    power_loads_W_per_V2: Number = None
    power_radiated_left_W_per_V2: Number = None
    power_radiated_right_W_per_V2: Number = None
    power_recovered_W_per_V2: Number = None
    recovery_ratio: Number = None
    power_net_W_per_V2: Number = None
    power_available_W_per_V2: Number = None
    power_source_W_per_V2: Number = None
    power_network_W_per_V2: Number = None
    power_residual: Number = None
    admittance_relative_error: Number = None
    sources: dict | Any = None  # by name of a driven transducer: ``voltage_per_volt``, ``current_A_per_V``


class SummaryBlock(Values):
    """Keys ``summary.*``: threshold, release and the range of the velocity over half a wavelength."""

    # summary.*
    threshold_amplitude_m: Number = None
    threshold_voltage_V: Number = None
    release_amplitude_m: Number = None
    release_voltage_V: Number = None
    first_released_contact: Count = None
    touching_contacts: Count = None
    last_released_contact: Count = None
    last_release_amplitude_m: Number = None
    last_release_voltage_V: Number = None
    velocity_ripple: Number = None
    ripple_from_m: Number = None
    ripple_to_m: Number = None


class HeatBlock(Values):
    """Keys ``heat.*``: where the power goes and how warm the stator becomes."""

    # heat.*
    voltage_V: Number = None
    duty: Number = None
    power_W: Number = None
    power_dielectric_W: Number = None
    power_along_beam_W: Number = None
    power_left_end_W: Number = None
    power_right_end_W: Number = None
    power_loads_W: Number = None
    heating_rate_K_per_s: Number = None
    time_constant_s: Number = None
    burst_rise_K: Number = None
    mean_rise_K: Number = None
    fingers_rise_K: Number = None
    fingers_rise_low_K: Number = None
    fingers_rise_high_K: Number = None
    left_end_rise_K: Number = None
    left_end_rise_low_K: Number = None
    left_end_rise_high_K: Number = None
    right_end_rise_K: Number = None
    right_end_rise_low_K: Number = None
    right_end_rise_high_K: Number = None
    slider_rise_K: Number = None
    slider_rise_low_K: Number = None
    slider_rise_high_K: Number = None
    highest_rise_K: Number = None
    highest_rise_low_K: Number = None
    highest_rise_high_K: Number = None
    hottest_x_m: Number = None
    steady_temperature_degC: Number = None
    steady_residual_K: Number = None
    branch: Text = None
    other_temperatures_degC: tuple[float, ...] | Any = None
    fold_frequencies_Hz: tuple[float, ...] | Any = None
    continuous_limit_voltage_V: Number = None
    pulsed_limit_voltage_V: Number = None
    duty_limit: Number = None
    frequency_drift: Number = None
    warm_amplitude_factor: Number = None
    foldover_number: Number = None


class ErrorBlock(Values):
    """Keys ``error.*``: the error of the last quantity, at the worst point."""

    # error.*
    relative: Number = None
    parts: dict | Any = None  # of the stator and of the contact, by these names
    model: Number = None


class UncertaintyBlock(Values):
    """Keys ``uncertainty.*``: how the bands of a scene with ``[uncertain]`` were found, and those of its limits."""

    # uncertainty.*
    method: Text = None
    samples: Count = None
    level: Number = None
    tolerances: dict | Any = None  # half width by key of the scene
    velocity_half_width_m_per_s: dict | Any = None  # by key
    bent: dict | Any = None  # number of points by key
    threshold_amplitude_m: Pair = None
    threshold_voltage_V: Pair = None
    release_amplitude_m: Pair = None
    release_voltage_V: Pair = None


class Effect(Values):
    """Keys ``model_error.*``: an effect that the model neglects, with its estimated size."""

    # model_error.*
    effect: Text = None
    quantity: Text = None  # what it changes
    size: Number = None  # relative change or, with a unit, change in that
    source: Text = None
    unit: Text = None
