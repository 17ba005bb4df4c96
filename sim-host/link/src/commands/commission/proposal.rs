//! Settings proposed for a mode.

use std::f64::consts::TAU;

use firmware::seam::transducer::Transducer;

use super::limits::Bounds;

/// Current of the drive at the resonance, relative to the limit.
pub const USED_CURRENT_REL: f64 = 0.8;
/// Factor of the voltage after it was too high.
pub const REDUCTION: f64 = 0.6;
/// Usual half-width of the window, which is the largest change of a resonance, relative to its
/// frequency.
const SPAN_REL: f64 = 0.025;
/// Largest half-width of the window, relative to the distance to the parallel resonance.
const SPAN_TO_PARALLEL_REL: f64 = 0.9;
/// Minimum half-width of the window, relative to the frequency.
const MIN_SPAN_REL: f64 = 0.005;

/// Distance of the window from the lowest frequency of the board, relative: the rehearsal rounds
/// frequencies to four digits.
const ROUNDING_REL: f64 = 5e-4;
/// Smallest half-width of the window that the board accepts, relative.
const LEAST_SPAN_REL: f64 = 1e-4;

/// Largest frequency error of a lock, relative to the bandwidth: 0.6 degrees of the motional phase.
const BOUND_REL: f64 = 0.005;
/// Minimum of the largest frequency error, Hz.
const MIN_BOUND_HZ: f64 = 1.0;
/// Largest distance of a lock from the identified resonance, relative to the bandwidth: the tip
/// velocity is 0.5 % below its maximum. With [`UNCERTAIN_REL`] it is at most 1 % below.
const GOOD_REL: f64 = 0.05;
/// Largest uncertainty of the identified resonance, relative to the bandwidth.
const UNCERTAIN_REL: f64 = 0.02;
/// Settling time in addition to the time that reduces a bandwidth to the bound, time constants.
const EXTRA_SETTLE_TIME_CONSTANTS: f64 = 3.0;
/// Maximum settling time, time constants.
const MAX_SETTLE_TIME_CONSTANTS: f64 = 8.0;
/// Minimum settling time, s.
const MIN_SETTLE_S: f64 = 2e-3;

/// Returns the bandwidth of a resonance, Hz.
pub fn width_hz(of: &Transducer) -> f64 {
    f64::from(of.series_resonance_hz) / f64::from(of.q)
}

/// Returns the frequency error, Hz, up to which a lock is at the resonance.
pub fn bound_hz(of: &Transducer) -> f64 {
    MIN_BOUND_HZ.max(BOUND_REL * width_hz(of))
}

/// Returns the largest permitted distance of a lock from the identified resonance, Hz. The answer
/// states a distance beyond [`bound_hz`].
pub fn permitted_hz(of: &Transducer) -> f64 {
    MIN_BOUND_HZ.max(GOOD_REL * width_hz(of))
}

/// Returns the largest permitted uncertainty of the identified resonance, Hz.
pub fn uncertain_hz(of: &Transducer) -> f64 {
    MIN_BOUND_HZ.max(UNCERTAIN_REL * width_hz(of))
}

/// Returns the settling time of a change, s, after which its residue moves no frequency by the
/// bound.
pub fn settle_s(of: &Transducer) -> f64 {
    let time_constants = EXTRA_SETTLE_TIME_CONSTANTS + (width_hz(of) / bound_hz(of)).ln().max(1.0);
    (time_constants.min(MAX_SETTLE_TIME_CONSTANTS) * f64::from(of.time_constant_s())).max(MIN_SETTLE_S)
}

/// Proposed settings for a mode.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// Mode as identified.
    pub transducer: Transducer,
    /// Peak drive voltage, V.
    pub volts: f64,
    /// Peak current expected at the resonance, A.
    pub amperes: f64,
    /// Limits of the voltage, V, and of the current, A.
    pub limits: (f64, f64),
    /// Half-width of the frequency window, relative.
    pub span: f64,
    /// `true` if the observer tracks, `false` for the phase loop.
    pub observer: bool,
}

impl Proposal {
    /// Creates the proposal for a mode.
    pub fn new(it: &Transducer, bounds: &Bounds) -> Self {
        let hz = f64::from(it.series_resonance_hz);
        let siemens = (1.0 / f64::from(it.rm_ohm)).hypot(TAU * hz * f64::from(it.c0_f));
        let volts = three_digits((USED_CURRENT_REL * bounds.amperes / siemens).min(bounds.volts));
        let parallel = f64::from(it.parallel_resonance_hz) / hz - 1.0;
        let span = SPAN_REL.min(SPAN_TO_PARALLEL_REL * parallel).max(MIN_SPAN_REL).max(2.0 / f64::from(it.q)).min(0.1);
        Proposal {
            transducer: *it,
            volts,
            amperes: volts * siemens,
            limits: (bounds.given_v, bounds.given_a),
            span,
            observer: true,
        }
    }

    /// Changes the voltage to the largest one within the bounds, by a measurement of peak voltage,
    /// V, and peak current, A.
    pub fn within_limits(self, volts: f64, amperes: f64, bounds: &Bounds) -> Self {
        let siemens = amperes / volts;
        let volts = three_digits((USED_CURRENT_REL * bounds.amperes / siemens).min(bounds.volts));
        Proposal { volts, amperes: volts * siemens, ..self }
    }

    /// Keeps the window above the lowest frequency that the board measures, Hz.
    pub fn above(self, low_hz: f64) -> Self {
        let below = 1.0 - low_hz / f64::from(self.transducer.series_resonance_hz);
        Proposal { span: self.span.min(below - ROUNDING_REL).max(LEAST_SPAN_REL), ..self }
    }

    /// Reduces the voltage.
    pub fn reduced(self) -> Self {
        let volts = three_digits(REDUCTION * self.volts);
        Proposal { volts, amperes: self.amperes * volts / self.volts, ..self }
    }

    /// Returns the proposal as parameters of the board, by their names, with the digits that the
    /// measurement justifies.
    pub fn settings(&self) -> Vec<(&'static str, f32)> {
        let it = &self.transducer;
        let digits = |count: usize, value: f32| report::rounded(value.into(), count) as f32;
        vec![
            ("drive.frequency_hz", digits(7, it.series_resonance_hz)),
            ("drive.amplitude_v", self.volts as f32),
            ("drive.scan_volts", self.volts as f32),
            ("limits.voltage_v", self.limits.0 as f32),
            ("limits.current_a", self.limits.1 as f32),
            ("tracking.mode", if self.observer { 0.0 } else { 1.0 }),
            ("tracking.span", three_digits(self.span) as f32),
            ("tracking.nominal_q", digits(5, it.q.clamp(2.0, 1e5))),
            ("tracking.nominal_lm_h", digits(5, it.lm_h)),
            ("tracking.nominal_c0_f", digits(5, it.c0_f)),
        ]
    }
}

/// Rounds down to three digits.
fn three_digits(value: f64) -> f64 {
    let step = 10f64.powf(value.log10().floor() - 2.0);
    let digits = (value / step + 1e-9).floor();
    // Converted by text, so that the value is the number nearest to its decimal form.
    format!("{:.4e}", digits * step).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_voltage_is_rounded_down_to_three_digits() {
        for (value, expected) in [(4.999, 4.99), (0.012_34, 0.0123), (5.0, 5.0), (123.9, 123.0)] {
            assert!((three_digits(value) - expected).abs() < 1e-9, "{value}");
        }
    }
}
