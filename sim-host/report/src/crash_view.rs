//! A crash that can be played: the belt as it is beside the belt whose friction is switched, drawn from the side, with the force at the
//! shoulder as bars over time. For readers who do not know what a capstan is.
//!
//! Plain data: the page draws it.

use serde::Serialize;

/// A crash. Of pairs, the first is the passive belt, the second the one that is switched.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CrashView {
    /// Who sits there, in words.
    pub occupant: String,
    /// Mass of the torso, kg.
    pub torso_kg: f64,
    /// How far the torso goes before the belt stretches, mm.
    pub slack_mm: f64,
    /// Length of the pulse, ms.
    pub pulse_ms: f64,
    /// When the drive went ON, ms; never, if it did not.
    pub low_ms: Option<f64>,
    /// The crash, at even steps.
    pub instants: Vec<Instant>,
}

/// One moment of a crash.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Instant {
    /// Since the crash began, ms.
    pub ms: f64,
    /// How far friction has been lowered, 0 to 1.
    pub low: f64,
    /// Deceleration of the car, g.
    pub pulse_g: f64,
    /// How far the torso has gone, mm.
    pub mm: [f64; 2],
    /// Force at the shoulder, N.
    pub newton: [f64; 2],
    /// Webbing that has slid over the D-ring, mm.
    pub payout_mm: [f64; 2],
}
