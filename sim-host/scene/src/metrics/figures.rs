//! Figures of a run and the columns of their CSV files.

use columns::heading::axis_unit;

/// The data of a figure, `ID.csv`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FigureData {
    /// Name of its files, without extension; `*` stands for any text.
    pub id: &'static str,
    /// Quantity of its first column, with its unit.
    pub x: &'static str,
    /// Possible columns of the file after the first; `*` stands for any text.
    pub columns: &'static [&'static str],
    /// Contents of the figure.
    pub meaning: &'static str,
}

/// Prefix of the column of a measured curve that is drawn over a figure
/// ([`Overlay`](crate::Overlay)).
pub const MEASURED: &str = "measured_";

/// Unit of an axis over which seconds are valid too: the frequency is known.
const PERIODS: &str = "periods of the excitation";

/// Returns the units that measured points over the axis with this label may have.
pub fn axis_units(label: &str) -> [Option<&str>; 2] {
    let own = axis_unit(label);
    [own, if own == Some(PERIODS) { Some("s") } else { own }]
}

impl FigureData {
    /// Returns `true` if this is the figure's name.
    pub fn has_id(&self, id: &str) -> bool {
        fits(self.id, id)
    }

    /// Returns `true` if it shows curves of a run, not a map or points of a grid.
    pub fn has_curves(&self) -> bool {
        !self.columns.iter().any(|column| column.starts_with("power_db") || *column == "*")
    }

    /// Returns `true` if the file can have this column.
    pub fn has(&self, column: &str) -> bool {
        self.columns.iter().any(|known| fits(known, column))
    }

    /// Returns `true` if the file can have this column, measured curves included.
    pub fn may_have(&self, column: &str) -> bool {
        self.has(column) || column.strip_prefix(MEASURED).is_some_and(|curve| self.has(curve))
    }

    /// Returns the data of the figure with this name.
    pub fn of(id: &str) -> Option<&'static FigureData> {
        FIGURES.iter().find(|figure| fits(figure.id, id))
    }
}

/// Returns `true` if a name matches a pattern with at most one `*`.
fn fits(pattern: &str, name: &str) -> bool {
    match pattern.split_once('*') {
        Some((begin, end)) => name.len() >= begin.len() + end.len() && name.starts_with(begin) && name.ends_with(end),
        None => pattern == name,
    }
}

/// The figures of all scenes, by name.
#[rustfmt::skip]
pub const FIGURES: &[FigureData] = &[
    FigureData { id: "acquisition", x: "time from the first sample of the scan [ms]", columns: &["frequency_played_hz", "series_resonance_true_hz"], meaning: "Drive frequency during the search for the resonance" },
    FigureData { id: "admittance", x: "conductance [S]", columns: &["susceptance_measured_s", "susceptance_true_s", "susceptance_identified_s"], meaning: "Admittance loop: measured by the scan, of the simulated circuit, and of the identified circuit. One row per point: `series` (one of these names), `frequency_hz`, `conductance_s`, `susceptance_s`" },
    FigureData { id: "admittance-bode", x: "frequency [Hz]", columns: &["admittance_s", "phase_deg", "admittance_measured_s", "admittance_true_s", "admittance_identified_s", "phase_measured_deg", "phase_true_deg", "phase_identified_deg"], meaning: "Bode plot of the admittance: magnitude and phase; measured values exist only at the frequencies of the scan; for a design, of its chain" },
    FigureData { id: "belt-drive", x: "time from the mute [ms]", columns: &["drive_v", "tip_velocity_m_per_s", "friction_n", "force_n"], meaning: "A belt that stops: amplitudes of drive and tip velocity, mean friction, and the force channel" },
    FigureData { id: "belt-motion", x: "time from the mute [ms]", columns: &["belt_true_mm", "belt_counted_mm"], meaning: "A belt that stops: its position, true and by its encoder" },
    FigureData { id: "burst-on", x: "time from the edge [ms]", columns: &["tip_velocity_m_per_s", "tip_envelope_m_per_s", "friction_n", "rotor_speed_rad_per_s"], meaning: "The first edge of a burst, sample by sample" },
    FigureData { id: "burst-off", x: "time from the edge [ms]", columns: &["tip_velocity_m_per_s", "tip_envelope_m_per_s", "friction_n", "rotor_speed_rad_per_s"], meaning: "The last edge of that burst, sample by sample" },
    FigureData { id: "crash-excursion", x: "time since the crash began [ms]", columns: &["switched_excursion_mm", "passive_excursion_mm"], meaning: "Excursion of the torso, with the switched and the passive belt" },
    FigureData { id: "crash-force", x: "time since the crash began [ms]", columns: &["switched_shoulder_n", "passive_shoulder_n"], meaning: "Force at the shoulder" },
    FigureData { id: "crash-payout", x: "time since the crash began [ms]", columns: &["switched_payout_m_per_s", "passive_payout_m_per_s"], meaning: "Sliding speed of the webbing over the D-ring" },
    FigureData { id: "detents", x: "travel of the knob [mm]", columns: &["friction_ratio_true", "friction_ratio_estimate", "friction_ratio_wanted"], meaning: "The friction ratio of a knob over its last detents: true value, estimate, set point" },
    FigureData { id: "displacement", x: "time [periods of the excitation]", columns: &["displacement_um"], meaning: "Displacement over the last periods of a contact study" },
    FigureData { id: "displacement-run", x: "time [periods of the excitation]", columns: &["displacement_middle_um"], meaning: "Displacement over the whole contact study; `_lower` and `_upper` are the extremes" },
    FigureData { id: "distribution", x: "the main metric, with its unit", columns: &["runs_percent"], meaning: "Part of the runs in each interval of the main metric of several runs, in per cent" },
    FigureData { id: "energy", x: "time [s]", columns: &["supplied_j", "lost_j", "friction_on_wave_j", "friction_on_rotor_j", "friction_on_slider_j", "friction_on_tip_j"], meaning: "Work since the beginning; empty below 1 nJ" },
    FigureData { id: "frequency", x: "time [s]", columns: &["frequency_command_hz", "resonance_estimate_hz", "series_resonance_true_hz"], meaning: "Frequency: command, estimate, true value" },
    FigureData { id: "frequency-error", x: "time from the first sample of the lock stage [ms]", columns: &["frequency_error_hz", "frequency_error_rms_hz", "cramer_rao_hz"], meaning: "Distance from the true resonance over several runs: median, root mean square, Cramér-Rao bound; `_lower` and `_upper` enclose the middle 90 %" },
    FigureData { id: "friction", x: "time [s]", columns: &["friction_true_n", "load_cell_n", "friction_lasting_n", "friction_n", "friction_across_n"], meaning: "Friction, or the pull of a belt, and the load cell; `_lower` and `_upper` are the extremes in a period of the vibration. For a contact study, `friction_n` over time in periods, and `friction_across_n` if the vibration is at an angle to the sliding" },
    FigureData { id: "friction-path", x: "friction along the sliding [N]", columns: &["friction_across_n"], meaning: "Friction across against friction along the sliding over the last period of a contact study, for a vibration at an angle to the sliding" },
    FigureData { id: "friction-ratio", x: "time [s]", columns: &["friction_ratio_true", "friction_ratio_estimate", "friction_ratio_wanted", "friction_floor_estimate"], meaning: "The friction ratio: true value, estimate, set point, and its floor" },
    FigureData { id: "friction-run", x: "time [periods of the excitation]", columns: &["friction_mean_n"], meaning: "Friction over the whole contact study; `_lower` and `_upper` are the extremes" },
    FigureData { id: "grid-*", x: "a key, with its unit", columns: &["*"], meaning: "A metric of a scene's grid: a curve over one key, a family of curves or a map over two; over more keys, the points with the smallest and largest value" },
    FigureData { id: "hysteresis", x: "displacement x [µm]", columns: &["friction_n"], meaning: "Friction against displacement over the last periods of a contact study" },
    FigureData { id: "lanes", x: "time [µs]", columns: &["lane_0_v", "lane_1_v", "lane_2_v", "lane_3_v"], meaning: "Voltages at the four electrodes over the last periods before the drive ends" },
    FigureData { id: "lock-acquisition", x: "time from the first sample of the lock stage [ms]", columns: &["frequency_off_hz", "estimate_off_hz"], meaning: "Distance of the drive frequency and of the estimate from the true resonance" },
    FigureData { id: "lock-times", x: "time from the first sample of the lock stage [ms]", columns: &["lock_time_100hz_ms_percent", "lock_time_20hz_ms_percent", "lock_time_4hz_ms_percent"], meaning: "Part of the runs that stay within each bound from then on, in per cent" },
    FigureData { id: "mode-shape", x: "distance from the back [mm]", columns: &["displacement_um", "axis_mm"], meaning: "Displacement along the axis of a design at its operating point, and its outline; `_lower` and `_upper` are the radius" },
    FigureData { id: "normal-force", x: "time [periods of the excitation]", columns: &["normal_n", "friction_limit_n", "spring_n"], meaning: "Normal force, mu times normal force, and friction of a compliant contact over the last periods, under a vibration across the surface" },
    FigureData { id: "power", x: "time [periods of the excitation]", columns: &["power_mw"], meaning: "Power into friction over the last periods of a contact study" },
    FigureData { id: "reduction-load", x: "load [N]", columns: &["law_*_percent"], meaning: "Friction reduction of a belt against load, by the law, for each amplitude" },
    FigureData { id: "reduction-on-time", x: "time since the horn is ON [s]", columns: &["reduction_percent", "law_*_n_percent"], meaning: "Friction reduction of a belt against ON time: simulated, and by the law for each load" },
    FigureData { id: "relock-times", x: "time from the last step [ms]", columns: &["relock_time_100hz_ms_percent", "relock_time_20hz_ms_percent", "relock_time_4hz_ms_percent"], meaning: "Part of the runs that stay within each bound from then on, after the last step disturbance, in per cent" },
    FigureData { id: "ring-friction", x: "angle along the wrap, from the retractor [degrees]", columns: &["coefficient", "mean_coefficient", "passive_coefficient"], meaning: "Coefficient of friction along the wrap of a D-ring that vibrates as a whole, at the fastest sliding under its full amplitude: local value, mean, and value without vibration" },
    FigureData { id: "rotor-speed", x: "time [s]", columns: &["rotor_rad_per_s", "crests_rad_per_s"], meaning: "Speed of the rotor, and of the crests that drive it" },
    FigureData { id: "slip-loop", x: "slip velocity V [m/s]", columns: &["friction_against_slip_n"], meaning: "Friction against slip velocity over the last periods of a contact study" },
    FigureData { id: "carriage-force", x: "time [s]", columns: &["friction_true_n", "pull_n", "force_n"], meaning: "Friction of a carriage at the tip, its pull, and the reading of the force channel" },
    FigureData { id: "carriage-motion", x: "time [s]", columns: &["carriage_mm", "spring_end_mm", "carriage_mm_per_s"], meaning: "Positions of a carriage and of the end of its spring, and speed of the carriage" },
    FigureData { id: "stack-temperature", x: "time [s]", columns: &["stack_temperature_k"], meaning: "Temperature over ambient of a stack that heats itself" },
    FigureData { id: "stft-*", x: "time from the sweep's beginning [ms]", columns: &["power_db*"], meaning: "Short-time spectrum of a sweep, in dB relative to the strongest cell: one row per time, one column per frequency; the column's name contains its centre frequency in kHz" },
    FigureData { id: "stress", x: "distance from the back [mm]", columns: &["stress_mpa"], meaning: "Static stress along the axis of a design; `_lower` and `_upper` are the extremes over a period at its operating point" },
    FigureData { id: "surface", x: "displacement along the ring [nm]", columns: &["across_nm", "across_pure_nm"], meaning: "Path of a point of the stator, and of a pure travelling wave" },
    FigureData { id: "tip-velocity", x: "time [s]", columns: &["tip_velocity_command_m_per_s", "tip_velocity_estimate_m_per_s", "tip_velocity_true_m_per_s"], meaning: "Amplitude of the tip velocity: command, estimate, true value" },
    FigureData { id: "velocity", x: "time [periods of the excitation]", columns: &["velocity_m_per_s", "slip_m_per_s", "slip_across_m_per_s"], meaning: "Velocity of the vibration and of the slip over the last periods of a contact study; `slip_across_m_per_s` for a vibration at an angle to the sliding" },
    FigureData { id: "velocity-run", x: "time [periods of the excitation]", columns: &["velocity_middle_m_per_s"], meaning: "Velocity over the whole contact study; `_lower` and `_upper` are the extremes" },
    FigureData { id: "waves", x: "time [s]", columns: &["forward_wave_um", "backward_wave_um"], meaning: "Amplitudes of the two waves of a stator" },
    FigureData { id: "wigner-*", x: "time from the sweep's beginning [ms]", columns: &["power_db*"], meaning: "Wigner-Ville distribution of a sweep about the resonance, in the format of `stft-*`" },
];
