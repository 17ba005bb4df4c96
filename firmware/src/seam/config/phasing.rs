//! Lane offsets and trims.

use config_macro::settings;
use heapless::Vec;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Choice;
use crate::seam::block::MAX_LANES;

/// Largest number of frequencies at which lanes are calibrated.
pub const MAX_TRIM_POINTS: usize = 5;

/// Lane offsets and trims of a multi-phase drive.
#[settings(table = "phasing", scene = Phasing)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phasing {
    /// Turning direction of a four-phase drive.
    #[setting(default, key = 63)]
    pub direction: Direction,
    /// Phase by which lanes 1 and 3 lead lanes 0 and 2, turns: 0.25 runs forward, zero is a
    /// standing wave. Replaces `direction`.
    #[setting(scene, min = -0.25, max = 0.25)]
    pub quadrature_turns: Option<f32>,
    /// Phase correction of each lane, turns.
    #[setting(min = -0.5, max = 0.5)]
    pub phase_trim_turns: Vec<f32, MAX_LANES>,
    /// Gain correction of each lane.
    #[setting(min = 0.0, max = 2.0)]
    pub gain_trim: Vec<f32, MAX_LANES>,
    /// Calibrates the lanes before the run: measures each lane and trims it. The controller listens
    /// to one lane after the other, at `drive.scan_v` and over the window of `tracking.span`. The
    /// windows of a burst count from the start of the calibration.
    #[setting(scene, default)]
    pub calibrate: bool,
    /// Checks the other lanes in addition to the first: faults 24 and 29. Needs the multiplexer at
    /// the sense channels. For a stator; a stack is connected to the first lane only.
    #[setting(default = true, key = 92)]
    pub watch: bool,
    /// Trims from a calibration, in addition to these.
    #[setting(controller)]
    pub calibration: Vec<TrimPoint, MAX_TRIM_POINTS>,
}

/// Trims of all lanes at rising frequencies: interpolated between them, constant beyond them.
pub type LaneTrims = Vec<TrimPoint, MAX_TRIM_POINTS>;

/// Trims of all lanes at one frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrimPoint {
    /// Frequency at which the trims were measured, Hz.
    pub hz: f32,
    /// Trims of lanes 0 to 3.
    pub lanes: [Trim; MAX_LANES],
}

/// Correction of one lane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trim {
    /// Phase added to that of the lane, turns.
    pub phase_turns: f32,
    /// Factor of the lane's gain.
    pub gain: f32,
}

impl Default for Trim {
    fn default() -> Self {
        Trim { phase_turns: 0.0, gain: 1.0 }
    }
}

/// Turning direction of a four-phase drive.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    // Lanes lead one another in the order 0, 1, 2, 3.
    /// Lane 1 leads lane 0.
    #[default]
    Forward,
    /// Lane 0 leads lane 1.
    Reverse,
}

impl Choice for Direction {
    const ALL: &'static [Self] = &[Direction::Forward, Direction::Reverse];
    const NAMES: &'static [&'static str] = &["forward", "reverse"];
}
