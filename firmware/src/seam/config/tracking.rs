//! Search and tracking of the resonance.

use config_macro::settings;
#[cfg(feature = "scene")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Choice;

/// Search and tracking of the resonance. The nominal values are priors; they need not be exact.
#[settings(table = "tracking", scene = Tracking, new)]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Tracking {
    /// Quantity that is tracked.
    #[setting(default, key = 22)]
    pub mode: TrackingMode,
    /// Frequency window on each side, as a fraction of the nominal frequency.
    #[setting(default = 0.025, min = 1e-4, max = 0.2, key = 17)]
    pub span: f32,
    /// Bandwidth of the phase loop, Hz.
    #[setting(default = 200.0, min = 0.1, max = 1000.0, key = 18)]
    pub bandwidth_hz: f32,
    /// Quality factor, accurate to a factor of three.
    #[setting(min = 2.0, max = 1e5, key = 15)]
    pub nominal_q: f32,
    /// Motional inductance, H, accurate to a factor of two. Default: the result of the power-on
    /// calibration.
    #[setting(min = 1e-9, max = 1e4, key = 23)]
    pub nominal_lm_h: Option<f32>,
    /// Clamped capacitance, F, accurate to a third. Default: the result of the self-test, from 0.1
    /// nF to 20 µF; then no result is compared with nominal values.
    #[setting(min = 1e-12, max = 1e-3, key = 16)]
    pub nominal_c0_f: Option<f32>,
    /// Largest relative drift of the clamped capacitance, 1/s. The observer then repeats its
    /// measurement in a run as often as necessary, by small steps of the frequency. Zero: measured
    /// only after a lock and after an abrupt change of the load.
    #[setting(default, min = 0.0, max = 10.0, key = 24, quiet)]
    pub c0_drift_per_s: f32,
    /// Force factor, N/V: tip force per volt, and motional current per tip velocity.
    #[setting(scene, min = 1e-6, max = 1e4)]
    pub nominal_force_factor_n_per_v: Option<f32>,
}

impl Tracking {
    /// Smallest and largest clamped capacitance of a transducer, F.
    pub(crate) const CAPACITANCES_F: (f32, f32) = (0.1e-9, 20e-6);

    /// Returns the clamped capacitance to start with, F: the nominal one, or one in the middle of
    /// the range.
    pub fn c0_f(&self) -> f32 {
        self.nominal_c0_f.unwrap_or(30e-9)
    }
}

/// Quantity that is tracked.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "scene", derive(JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TrackingMode {
    /// The resonance, estimated from the change of the motional current: without a scan and without
    /// waiting for the ring-up.
    #[default]
    Observer,
    /// The phase of the motional current, after a scan: the series resonance, at any load.
    PhaseLock,
    /// The phase of the total current: the plain V-I loop, a reference that fails under load.
    ZeroPhase,
    /// Nothing: the nominal frequency is held.
    Off,
}

impl Choice for TrackingMode {
    const ALL: &'static [Self] = &[TrackingMode::Observer, TrackingMode::PhaseLock, TrackingMode::ZeroPhase, TrackingMode::Off];
    const NAMES: &'static [&'static str] = &["observer", "phase_lock", "zero_phase", "off"];
}
