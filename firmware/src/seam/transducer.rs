//! What a transducer is: its equivalent circuit, how sure that is, and what else rings.

use serde::{Deserialize, Serialize};

const TAU: f32 = core::f32::consts::TAU;

/// The most resonances that are listed.
pub const MOST_MODES: usize = 4;

/// A transducer's equivalent circuit, as identified.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Transducer {
    /// Series (motional) resonance, Hz.
    pub series_resonance_hz: f32,
    /// Parallel resonance (antiresonance), Hz.
    pub parallel_resonance_hz: f32,
    /// Quality factor at series resonance.
    pub q: f32,
    /// Motional resistance, ohm.
    pub rm_ohm: f32,
    /// Motional inductance, H.
    pub lm_h: f32,
    /// Motional capacitance, F.
    pub cm_f: f32,
    /// Clamped capacitance, F; includes what DAC images make it look like.
    pub c0_f: f32,
    /// Effective coupling, `sqrt(Cm / (C0 + Cm))`.
    pub coupling: f32,
    /// Standard deviations of these values.
    pub deviations: Deviations,
    /// How many resonances were found, and which of the list this is.
    pub modes: u8,
    /// Place of this resonance in the list of those found, from zero.
    pub chosen: u8,
}

impl Transducer {
    /// Ring-up time constant `Q / (pi fs)`, s.
    pub fn time_constant_s(&self) -> f32 {
        2.0 * self.q / (TAU * self.series_resonance_hz)
    }

    /// Becomes a copy, number by number: all of it at once is more than the compiler moves without a call, which takes three times as long.
    #[inline]
    pub(crate) fn copy(&mut self, from: &Transducer) {
        self.series_resonance_hz = from.series_resonance_hz;
        self.parallel_resonance_hz = from.parallel_resonance_hz;
        self.q = from.q;
        self.rm_ohm = from.rm_ohm;
        self.lm_h = from.lm_h;
        self.cm_f = from.cm_f;
        self.c0_f = from.c0_f;
        self.coupling = from.coupling;
        self.deviations = from.deviations;
        (self.modes, self.chosen) = (from.modes, from.chosen);
    }
}

/// Standard deviations of what was identified, by the noise that was seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Deviations {
    /// Standard deviation of the series resonance, Hz.
    pub series_resonance_hz: f32,
    /// Standard deviation of the parallel resonance, Hz.
    pub parallel_resonance_hz: f32,
    /// Standard deviation of the quality factor.
    pub q: f32,
    /// Standard deviation of the motional resistance, ohm.
    pub rm_ohm: f32,
    /// Standard deviation of the motional inductance, H.
    pub lm_h: f32,
    /// Standard deviation of the motional capacitance, F.
    pub cm_f: f32,
    /// Standard deviation of the clamped capacitance, F.
    pub c0_f: f32,
    /// Standard deviation of the coupling.
    pub coupling: f32,
}

/// One of the resonances that a scan has found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Resonance {
    /// Series resonance of this mode, Hz.
    pub hz: f32,
    /// Quality factor of this mode.
    pub q: f32,
    /// Motional inductance of this mode, H.
    pub lm_h: f32,
    /// Motional conductance at the resonance, S.
    pub conductance_s: f32,
}

/// One of the resonances of a list, on its way with the telemetry: a list comes one a block.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Listed {
    /// Place of this resonance in the list, from zero.
    pub place: u8,
    /// Number of resonances in the list.
    pub of: u8,
    /// The resonance at this place.
    pub resonance: Resonance,
}

/// The resonances that a scan has found, at rising frequencies.
pub type Resonances = heapless::Vec<Resonance, MOST_MODES>;
