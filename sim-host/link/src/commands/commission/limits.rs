//! How loud the board may become, and how quiet it can be.

use super::board_settings::BoardSettings;
use crate::scale::Scale;

/// Part of the given current that the board's limit is set to while nothing is known: a fault ends the drive within a block of the limit's first excess.
const MARGIN: f64 = 0.8;
/// Codes of the coarser converter that the smallest useful voltage has, and the quietest.
const LEAST_CODES: (f64, f64) = (8.0, 4.0);
/// Part of a sense channel's range that is used.
const RANGE: f64 = 0.9;
/// The first level as a part of the largest voltage.
const FIRST: f64 = 1.0 / 32.0;

/// Bounds of voltage and current.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Largest peak voltage at the amplifier, V.
    pub volts: f64,
    /// Largest peak current, A: what was given, or the board's own limit.
    pub given_a: f64,
    /// The board's limit on the way, A.
    pub amperes: f64,
    /// The first level, V.
    pub least_v: f64,
    /// The quietest level, V.
    pub quietest_v: f64,
}

impl Bounds {
    /// The given bounds, within the limits and the ranges that the board has.
    pub fn of(volts: f64, amperes: Option<f64>, board: &BoardSettings, scale: &Scale) -> Self {
        let range = |per_lsb: f64| RANGE * scale.sense_mid_code * per_lsb;
        let volts = volts.min(board.before("limits.voltage_v").into()).min(range(scale.volt_per_lsb));
        let limit_a = f64::from(board.before("limits.current_a")).min(range(scale.ampere_per_lsb));
        let given_a = amperes.map_or(limit_a, |given| given.min(limit_a));
        let code_v = scale.volt_per_lsb.max(scale.drive_volt_per_lsb);
        let quietest_v = (LEAST_CODES.1 * code_v).min(volts);
        let least_v = (FIRST * volts).max(LEAST_CODES.0 * code_v).min(volts);
        Bounds { volts, given_a, amperes: MARGIN * given_a, least_v, quietest_v }
    }

    /// The limits as settings of the board, and no schedule that would change the drive by itself.
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
