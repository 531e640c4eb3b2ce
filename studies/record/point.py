"""A point of a run or a sweep: the answer at one level of the drive."""

from studies.record.values import Complex, Count, Flag, Number, Pair, Text, Values


class Point(Values):
    """The answer at one level of the drive, and the quantities that a sweep adds to it.

    The fields are the keys ``points.*`` and ``sweep.*`` of ``quantities.csv``, where their meaning stands;
    ``python -m studies.record.quantities studies/record/point.py`` adds those of new rows.  A point without an answer
    has no ``relative_error``, and its ``status`` says why.

    Examples
    --------
    >>> point = Point(normal_amplitude_m=5e-9, velocity_m_per_s=0.03)
    >>> point.velocity_m_per_s, point["velocity_m_per_s"], point.level, point.answered
    (0.03, 0.03, 5e-09, False)
    """

    # points.*
    voltage_V: Number = None
    available_power_W: Number = None
    normal_amplitude_m: Number = None
    tangential_amplitude_m: Number = None
    velocity_m_per_s: Number = None
    lateral_velocity_m_per_s: Number = None
    yaw_rate_rad_per_s: Number = None
    rotation_rpm: Number = None
    torque_N_m: Number = None
    contact_regimes: Text = None
    drift_m_per_s_per_deg: Pair = None
    yaw_stability_per_s: Number = None
    mean_velocity_m_per_s: Number = None
    mean_lateral_velocity_m_per_s: Number = None
    mean_rotation_rpm: Number = None
    lowest_velocity_m_per_s: Number = None
    highest_velocity_m_per_s: Number = None
    lowest_lateral_velocity_m_per_s: Number = None
    highest_lateral_velocity_m_per_s: Number = None
    lowest_rotation_rpm: Number = None
    highest_rotation_rpm: Number = None
    mean_velocity_relative_error: Number = None
    velocity_at_burst_end_m_per_s: Number = None
    displacement_m: Number = None
    travel_m: Number = None
    lateral_velocity_at_burst_end_m_per_s: Number = None
    yaw_rate_at_burst_end_rad_per_s: Number = None
    lateral_displacement_m: Number = None
    displacement_error_m: Number = None
    turn_rad: Number = None
    turn_error_rad: Number = None
    path_length_m: Number = None
    way_ends_after_s: Number = None
    other_velocity_m_per_s: Number = None
    velocity_low_m_per_s: Number = None
    velocity_high_m_per_s: Number = None
    contact_pressure_Pa: Number = None
    stick_margin: Number = None
    regime: Text = None
    relative_error: Number = None
    amplitude_sensitivity: Number = None
    model_relative_error: Number = None
    status: Text = None
    approach_m: Number = None
    tilt_rad: Pair = None
    share_in_contact: Number = None
    duty: Number = None
    friction_power_W: Number = None
    adhesion_power_W: Number = None
    thrust_power_W: Number = None
    wave_power_in_W: Number = None
    wave_power_out_W: Number = None
    sample_lowest_m_per_s: Number = None
    sample_median_m_per_s: Number = None
    sample_highest_m_per_s: Number = None
    face_normal_m: Number = None
    face_tangential_m: Number = None
    face_delay_deg: Number = None
    face_wave_normal_m: Number = None
    face_wave_tangential_m: Number = None
    loading_number: Number = None
    overtone_ratio: Number = None
    harmonics: Count = None
    received_over_free: Complex = None
    recovered_power_W: Number = None
    admittance_change_S: Complex = None
    exit_over_entry: Complex = None
    reflected_over_entry: Complex = None
    contact_per_cycle: Number = None
    release_per_cycle: Number = None
    stick_to_slip_per_cycle: Number = None
    slip_to_stick_per_cycle: Number = None
    reversal_per_cycle: Number = None
    graze_per_cycle: Number = None
    period_cycles: Count = None
    smallest_gap_s: Number = None
    chatter: Flag = None
    ledger_relative_residual: Number = None
    burst_method: Text = None
    burst_contact: Count = None
    burst_release: Count = None
    burst_stick_to_slip: Count = None
    burst_slip_to_stick: Count = None
    burst_reversal: Count = None
    burst_graze: Count = None
    burst_smallest_gap_s: Number = None
    burst_chatter: Flag = None
    burst_ledger_relative_residual: Number = None
    after_contact: Count = None
    after_release: Count = None
    after_stick_to_slip: Count = None
    after_slip_to_stick: Count = None
    after_reversal: Count = None
    after_graze: Count = None
    after_smallest_gap_s: Number = None
    after_chatter: Flag = None
    after_ledger_relative_residual: Number = None
    # sweep.*
    frequency_Hz: Number = None
    thrust_N: Number = None
    stall_torque_N_m: Number = None
    contact_efficiency: Number = None
    motor_efficiency: Number = None
    threshold_factor: Number = None
    release_factor: Number = None
    step_m: Number = None
    start_up_time_s: Number = None
    conductance_S: Number = None
    susceptance_S: Number = None
    power_W: Number = None
    velocity_ripple: Number = None
    phase_velocity_m_per_s: Number = None
    surface_ratio: Number = None
    attenuation_per_m: Number = None

    @property
    def answered(self) -> bool:
        """Whether the solvers gave an answer, within the tolerance or not."""
        return self.relative_error is not None

    @property
    def level(self) -> float:
        """Level of the drive at a point of a run: voltage in V, with a prescribed wave the normal amplitude in m."""
        return self.normal_amplitude_m if self.voltage_V is None else self.voltage_V
