//! `[stator]`: the ring of a travelling-wave motor, driven by up to four lanes.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The stator of a travelling-wave motor: a ring with a sine and a cosine bending mode, driven
/// through electrode tabs. Tab `j` is connected to lane `j` mod 4. The defaults of the tabs are
/// those of the thesis's sheet (B.4.1).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Stator {
    /// Series resonance midway between the two modes, with the rotor pressed on, Hz.
    #[schemars(range(min = 100.0, max = 450e3))]
    pub series_resonance_hz: f64,
    /// Quality factor of both modes.
    #[schemars(range(min = 1.0, max = 1e6))]
    pub q: f64,
    /// Frequency of the sine mode above that of the cosine mode, Hz.
    #[serde(default)]
    #[schemars(range(min = -1e4, max = 1e4))]
    pub split_hz: f64,
    /// Modal mass of each mode, kg: half the mass of the ring.
    #[schemars(range(min = 1e-6, max = 1e3))]
    pub modal_mass_kg: f64,
    /// Clamped capacitance of each lane, F.
    #[schemars(range(min = 1e-13, max = 1e-3))]
    pub c0_f: f64,
    /// Modal force per volt of a lane whose tabs are at crests, N/V.
    #[schemars(range(min = 1e-6, max = 1e4))]
    pub force_factor_n_per_v: f64,
    /// Wavelength of the working modes, m.
    #[schemars(range(min = 1e-4, max = 10.0))]
    pub wave_length_m: f64,
    /// Height of the driving surface above the neutral plane, m: half the thickness of a uniform
    /// stator.
    #[schemars(range(min = 1e-6, max = 1.0))]
    pub surface_height_m: f64,
    /// Number of electrode tabs around the ring.
    #[serde(default = "default::tabs")]
    #[schemars(range(min = 1, max = 240))]
    pub tabs: u16,
    /// Width of a tab along the wave, m.
    #[serde(default = "default::tab_width_m")]
    #[schemars(range(min = 1e-5, max = 10.0))]
    pub tab_width_m: f64,
    /// Gap between two tabs, m.
    #[serde(default = "default::tab_gap_m")]
    #[schemars(range(min = 0.0, max = 10.0))]
    pub tab_gap_m: f64,
    /// Position of the centre of the first tab on the modes, turns; 0 is a crest of the cosine
    /// mode.
    #[serde(default)]
    #[schemars(range(min = -1.0, max = 1.0))]
    pub first_tab_turns: f64,
}

/// Defaults that serde needs as functions.
mod default {
    const INCH_M: f64 = 25.4e-3;

    pub(super) fn tabs() -> u16 {
        12
    }
    /// 0.2196 inch.
    pub(super) fn tab_width_m() -> f64 {
        0.2196 * INCH_M
    }
    /// 0.0196 inch.
    pub(super) fn tab_gap_m() -> f64 {
        0.0196 * INCH_M
    }
}
