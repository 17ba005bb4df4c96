//! The names of all metrics: a contract, units last. What each one means stands in the module `metrics` of the crate `sonoglide-sim`; a scene's
//! expectations are checked against this list before anything is run.

use std::sync::LazyLock;

/// Every metric there is, as of one run.
pub const NAMES: &[&str] = &[
    "friction_off_n",
    "friction_on_n",
    "friction_ratio",
    "friction_ratio_wanted",
    "friction_ratio_estimate",
    "friction_ratio_sensed",
    "friction_ratio_error",
    "ratios_refused",
    "friction_floor_estimate",
    "kappa_estimate",
    "kappa_deviation",
    "survey_time_ms",
    "reduction_percent",
    "load_cell_off_n",
    "load_cell_on_n",
    "load_cell_reduction_percent",
    "velocity_ratio",
    "amplitude_fraction",
    "on_time_s",
    "lasting_reduction_percent",
    "tip_velocity_m_per_s",
    "peak_velocity_m_per_s",
    "peak_displacement_m",
    "peak_force_ratio",
    "reversals",
    "overshoot_percent",
    "rise_time_ms",
    "fall_time_ms",
    "residual_percent",
    "acquire_time_ms",
    "lock_time_100hz_ms",
    "lock_time_20hz_ms",
    "lock_time_4hz_ms",
    "relock_time_100hz_ms",
    "relock_time_20hz_ms",
    "relock_time_4hz_ms",
    "frequency_bias_hz",
    "frequency_jitter_hz",
    "frequency_error_max_hz",
    "false_locks",
    "undetected_losses",
    "runs_completed",
    "runs_locked",
    "runs_faulted",
    "motional_phase_deg",
    "drive_power_w",
    "drive_peak_v",
    "drive_rms_v",
    "input_power_w",
    "tip_velocity_rms_m_per_s",
    "tip_velocity_peak_m_per_s",
    "power_ratio",
    "input_ratio",
    "stored_ratio",
    "damper_ratio",
    "power_ratio_as_printed",
    "energy_residual",
    "peak_shoulder_force_n",
    "passive_peak_shoulder_force_n",
    "torso_excursion_m",
    "passive_torso_excursion_m",
    "added_excursion_m",
    "chest_acceleration_g",
    "passive_chest_acceleration_g",
    "payout_speed_m_per_s",
    "passive_payout_speed_m_per_s",
    "switched",
    "switch_time_ms",
    "actuator_power_w",
    "backward_wave_percent",
    "forward_wave_m",
    "backward_wave_m",
    "surface_speed_m_per_s",
    "rotor_speed_rad_per_s",
    "rotor_speed_ratio",
    "rotor_speed_ratio_closed_form",
    "rotor_torque_nm",
    "rotor_power_w",
    "contact_deg",
    "normal_force_n",
    "normal_shift_hz",
    "start_time_ms",
    "stop_time_ms",
    "lane_phase_error_deg_max",
    "lane_gain_error_percent_max",
    "contact_time_percent",
    "mean_indentation_m",
    "mean_normal_n",
    "peak_normal_n",
    "kappa",
    "error_estimate",
    "series_resonance_hz",
    "series_resonance_error_hz",
    "parallel_resonance_hz",
    "q",
    "rm_ohm",
    "lm_h",
    "cm_f",
    "c0_f",
    "coupling",
    "series_resonance_sd_hz",
    "parallel_resonance_sd_hz",
    "q_sd",
    "rm_sd_ohm",
    "lm_sd_h",
    "cm_sd_f",
    "c0_sd_f",
    "coupling_sd",
    "modes_found",
    "fault_code",
    "fault_latency_us",
    "limit_code",
    "belt_stop_to_mute_ms",
    "ring_down_ms",
    "exposure_j_per_mm",
    "instructions_total",
    "mean_block_instructions",
    "worst_block_instructions",
    "stack_power_up_bytes",
    "stack_blocks_bytes",
    "image_flash_bytes",
    "image_ram_bytes",
    "steps_per_period",
    "plant_states",
    "ns_per_period",
    "simulated_s_per_wall_s",
];

/// Metrics that may have either sign and should be near zero: of several runs, percentile and maximum are of the absolute value.
pub const SIGNED: &[&str] =
    &["frequency_bias_hz", "motional_phase_deg", "series_resonance_error_hz", "energy_residual", "normal_shift_hz"];

/// Metrics that are 0 or 1 of one run, and of several the number of runs that have them.
pub const COUNTED: &[&str] = &["false_locks", "undetected_losses", "switched"];

/// What several runs make of a metric besides its median.
#[derive(Debug)]
pub struct OfRuns {
    /// Name of the metric of one run, and of the median.
    pub name: &'static str,
    /// Name of the 95th percentile.
    pub p95: String,
    /// Name of the maximum.
    pub max: String,
}

/// For each metric, the names of what several runs make of it.
pub static OF_RUNS: LazyLock<Vec<OfRuns>> = LazyLock::new(|| {
    let of = |&name: &&'static str| OfRuns { name, p95: format!("{name}_p95"), max: format!("{name}_max") };
    NAMES.iter().map(of).collect()
});

/// Whether there is such a metric, of one run or of several.
pub fn is_known(name: &str) -> bool {
    NAMES.contains(&name) || of_one_run(name).is_some()
}

/// The place of a metric in the order of [`NAMES`]; a percentile and a maximum come after their metric, and unknown names last.
pub fn rank(name: &str) -> usize {
    let place = |name: &str| NAMES.iter().position(|known| *known == name);
    place(name).or_else(|| place(of_one_run(name)?)).unwrap_or(NAMES.len())
}

/// The metric of one run that a percentile or maximum of several is made of.
pub fn of_one_run(name: &str) -> Option<&'static str> {
    OF_RUNS.iter().find(|of| of.p95 == name || of.max == name).map(|of| of.name)
}
