//! Bounds of voltage and current during a commissioning.

use super::board_settings::BoardSettings;
use crate::scale::Scale;

/// Current limit of the board during the commissioning, relative to the given current. It leaves a
/// margin, because a fault ends the drive only within a block after the first excess.
const CURRENT_LIMIT_REL: f64 = 0.8;
/// Smallest first level, codes of the coarser converter.
const FIRST_LEVEL_CODES: f64 = 8.0;
/// Smallest level, codes of the coarser converter.
const MIN_LEVEL_CODES: f64 = 4.0;
/// Part of a sense channel's range that is used.
const USED_RANGE_REL: f64 = 0.9;
/// First level, relative to the largest voltage.
const FIRST_LEVEL_REL: f64 = 1.0 / 32.0;

/// Bounds of voltage and current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest peak voltage at the amplifier, V.
    pub volts: f64,
    /// Voltage limit that is stored, V: the given one, or the board's own limit.
    pub given_v: f64,
    /// Largest peak current, A: the given one, or the board's own limit.
    pub given_a: f64,
    /// Current limit of the board during the commissioning, A.
    pub amperes: f64,
    /// First level, V.
    pub first_v: f64,
    /// Smallest level, V.
    pub min_v: f64,
    /// Duration of a sample, s.
    pub sample_s: f64,
}

impl Bounds {
    /// Creates the bounds from the arguments, the limits of the board and the ranges of its
    /// channels.
    pub fn new(volts: f64, amperes: Option<f64>, board: &BoardSettings, scale: &Scale) -> Self {
        let range = |per_lsb: f64| USED_RANGE_REL * scale.sense_mid_code * per_lsb;
        let volts = volts.min(board.before("limits.voltage_v").into()).min(range(scale.volt_per_lsb));
        let limit_a = f64::from(board.before("limits.current_a")).min(range(scale.ampere_per_lsb));
        let given_a = amperes.map_or(limit_a, |given| given.min(limit_a));
        let given_v = volts;
        let volts = played_v(given_v, scale.drive_volt_per_lsb);
        let code_v = scale.volt_per_lsb.max(scale.drive_volt_per_lsb);
        let min_v = (MIN_LEVEL_CODES * code_v).min(volts);
        let first_v = (FIRST_LEVEL_REL * volts).max(FIRST_LEVEL_CODES * code_v).min(volts);
        let (amperes, sample_s) = (CURRENT_LIMIT_REL * given_a, 1.0 / scale.sample_hz);
        Bounds { volts, given_v, given_a, amperes, first_v, min_v, sample_s }
    }

    /// Returns the limits as settings of the board. Schedules that change the drive by themselves
    /// are switched off.
    pub fn settings(&self) -> Vec<(&'static str, f32)> {
        vec![
            ("limits.voltage_v", self.volts as f32),
            ("limits.current_a", self.amperes as f32),
            ("drive.shape", 0.0),
            ("tracking.c0_drift_per_s", 0.0),
            ("sweep.time_s", 0.0),
            ("restraint.enabled", 0.0),
            ("friction.enabled", 0.0),
        ]
    }
}

/// Returns the largest voltage whose nearest code does not exceed a voltage.
fn played_v(volts: f64, code_v: f64) -> f64 {
    let codes = volts / code_v;
    if codes.round() > codes && codes >= 1.0 { codes.floor() * code_v } else { volts }
}
