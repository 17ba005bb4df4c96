//! Lane offsets and trims.

use config_macro::settings;
use heapless::Vec;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Choice;
use crate::seam::block::MAX_LANES;

/// The most frequencies at which lanes are calibrated.
pub const MAX_TRIM_POINTS: usize = 5;

/// Lane offsets and trims of a multi-phase drive.
#[settings(table = "phasing", scene = Phasing)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Phasing {
    /// Turning direction of a four-phase drive.
    #[setting(default, key = 63)]
    pub direction: Direction,
    /// How far lanes 1 and 3 lead lanes 0 and 2, turns: a quarter runs forward, zero stands. Takes the place of `direction`.
    #[setting(scene, min = -0.25, max = 0.25)]
    pub quadrature_turns: Option<f32>,
    /// Phase correction of each lane, turns.
    #[setting(min = -0.5, max = 0.5)]
    pub phase_trim_turns: Vec<f32, MAX_LANES>,
    /// Gain correction of each lane.
    #[setting(min = 0.0, max = 2.0)]
    pub gain_trim: Vec<f32, MAX_LANES>,
    /// First measure what each lane adds, and trim the lanes by it; then run. The controller listens to one lane after the other, at
    /// `drive.scan_v` and over the window of `tracking.span`. Windows of a burst count from its beginning all the same.
    #[setting(scene, default)]
    pub calibrate: bool,
    /// The other lanes are watched beside the first: faults 24 and 29. Needs the multiplexer at the sense channels. Of a stator; a stack hangs on the first lane alone.
    #[setting(default = true, key = 92)]
    pub watch: bool,
    /// What a calibration has found, on top of these.
    #[setting(controller)]
    pub calibration: Vec<TrimPoint, MAX_TRIM_POINTS>,
}

/// Trims of all lanes at rising frequencies; straight lines between them, and the nearest beyond.
pub type LaneTrims = Vec<TrimPoint, MAX_TRIM_POINTS>;

/// Trims of all lanes at one frequency.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct TrimPoint {
    /// Frequency at which the trims were measured, Hz.
    pub hz: f32,
    /// Trims, lane by lane.
    pub lanes: [Trim; MAX_LANES],
}

/// Correction of one lane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Trim {
    /// Added to the lane's phase, turns.
    pub phase_turns: f32,
    /// Multiplies the lane's gain.
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
