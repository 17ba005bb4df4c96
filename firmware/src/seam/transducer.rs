//! Description of a transducer: equivalent circuit, deviations, and other resonances.

use serde::{Deserialize, Serialize};

const TAU: f32 = core::f32::consts::TAU;

/// Largest number of listed resonances.
pub const MOST_MODES: usize = 4;

/// Equivalent circuit of a transducer, as identified.
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
    /// Clamped capacitance, F; includes the apparent part by DAC images.
    pub c0_f: f32,
    /// Effective coupling, `sqrt(Cm / (C0 + Cm))`.
    pub coupling: f32,
    /// Standard deviations of these values.
    pub deviations: Deviations,
    /// Number of resonances found.
    pub modes: u8,
    /// Index of this resonance in the list of those found, from zero.
    pub chosen: u8,
}

impl Transducer {
    /// Returns the ring-up time constant `Q / (pi fs)`, s.
    pub fn time_constant_s(&self) -> f32 {
        2.0 * self.q / (TAU * self.series_resonance_hz)
    }

    /// Copies `from` field by field: the compiler moves the whole with a call, which takes three
    /// times as long.
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

/// Standard deviations of the identified values, from the measured noise.
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

/// Resonance found by a scan.
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

/// Item of a list of resonances; the telemetry of a block carries one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Listed {
    /// Index of this resonance in the list, from zero.
    pub place: u8,
    /// Number of resonances in the list.
    pub of: u8,
    /// The resonance itself.
    pub resonance: Resonance,
}

/// Resonances found by a scan, at rising frequencies.
pub type Resonances = heapless::Vec<Resonance, MOST_MODES>;
