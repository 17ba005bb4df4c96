//! A crash that can be played: the passive belt next to the switched one, from the side, with the
//! force at the shoulder as bars over time. For readers without technical knowledge.
//!
//! Plain data; the page draws it.

use serde::Serialize;

/// A crash. In pairs, the first value is the passive belt, the second the switched one.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CrashView {
    /// Description of the occupant.
    pub occupant: String,
    /// Mass of the torso, kg.
    pub torso_kg: f64,
    /// Displacement of the torso before the belt stretches, mm.
    pub slack_mm: f64,
    /// Length of the pulse, ms.
    pub pulse_ms: f64,
    /// Time at which the drive went ON, ms; `None` if it did not.
    pub low_ms: Option<f64>,
    /// The crash, at even steps.
    pub instants: Vec<Instant>,
}

/// One moment of a crash.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Instant {
    /// Time since the crash began, ms.
    pub ms: f64,
    /// Reduction of the friction, 0 to 1.
    pub low: f64,
    /// Deceleration of the car, g.
    pub pulse_g: f64,
    /// Displacement of the torso, mm.
    pub mm: [f64; 2],
    /// Force at the shoulder, N.
    pub newton: [f64; 2],
    /// Webbing that has slid over the D-ring, mm.
    pub payout_mm: [f64; 2],
}
