//! The settings that are proposed for a mode.

use std::f64::consts::TAU;

use firmware::seam::transducer::Transducer;

use super::limits::Bounds;

/// Part of the current limit that the drive takes at the resonance.
pub const USED: f64 = 0.8;
/// What is left of the voltage where it was too much.
pub const LESS: f64 = 0.6;
/// Window to each side: what a resonance may move by; as a part of the distance to the parallel resonance, and at least.
const SPAN: (f64, f64, f64) = (0.025, 0.9, 0.005);

/// What a frequency may be off by, as a part of the bandwidth, which is 0.6 degrees of the motional phase, or Hz, if that is more.
const AGREES: (f64, f64) = (0.005, 1.0);
/// Time constants that a change has to settle beyond those that bring a bandwidth down to the bound; and in all at most; and least time, s.
const SETTLE: (f64, f64, f64) = (3.0, 8.0, 2e-3);

/// Bandwidth of a resonance, Hz.
pub fn width_hz(of: &Transducer) -> f64 {
    f64::from(of.series_resonance_hz) / f64::from(of.q)
}

/// What the frequency of a lock may be off by, Hz.
pub fn bound_hz(of: &Transducer) -> f64 {
    AGREES.1.max(AGREES.0 * width_hz(of))
}

/// Time that a change has to settle, s, so that what is left of it moves no frequency by the bound.
pub fn settle_s(of: &Transducer) -> f64 {
    let time_constants = SETTLE.0 + (width_hz(of) / bound_hz(of)).ln().max(1.0);
    (time_constants.min(SETTLE.1) * f64::from(of.time_constant_s())).max(SETTLE.2)
}

/// Settings for a mode, as they are proposed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proposal {
    /// The mode as it was identified.
    pub transducer: Transducer,
    /// Peak drive voltage, V.
    pub volts: f64,
    /// Peak current expected at the resonance, A.
    pub amperes: f64,
    /// Limit of the voltage, V, and of the current, A.
    pub limits: (f64, f64),
    /// Frequency window to each side, relative.
    pub span: f64,
    /// Whether the observer tracks; else the phase loop.
    pub observer: bool,
}

impl Proposal {
    /// The proposal for a mode.
    pub fn of(it: &Transducer, bounds: &Bounds) -> Self {
        let hz = f64::from(it.series_resonance_hz);
        let siemens = (1.0 / f64::from(it.rm_ohm)).hypot(TAU * hz * f64::from(it.c0_f));
        let volts = three_digits((USED * bounds.amperes / siemens).min(bounds.volts));
        let parallel = f64::from(it.parallel_resonance_hz) / hz - 1.0;
        let span = SPAN.0.min(SPAN.1 * parallel).max(SPAN.2).max(2.0 / f64::from(it.q)).min(0.1);
        Proposal {
            transducer: *it,
            volts,
            amperes: volts * siemens,
            limits: (bounds.volts, bounds.given_a),
            span,
            observer: true,
        }
    }

    /// The same as loud as a measurement of this peak voltage, V, and peak current, A, allows.
    pub fn as_loud_as(self, volts: f64, amperes: f64, bounds: &Bounds) -> Self {
        let siemens = amperes / volts;
        let volts = three_digits((USED * bounds.amperes / siemens).min(bounds.volts));
        Proposal { volts, amperes: volts * siemens, ..self }
    }

    /// The same at less voltage.
    pub fn quieter(self) -> Self {
        let volts = three_digits(LESS * self.volts);
        Proposal { volts, amperes: self.amperes * volts / self.volts, ..self }
    }

    /// As parameters of the board, by their names.
    pub fn settings(&self) -> Vec<(&'static str, f32)> {
        let it = &self.transducer;
        vec![
            ("drive.frequency_hz", it.series_resonance_hz),
            ("drive.amplitude_v", self.volts as f32),
            ("drive.scan_volts", self.volts as f32),
            ("limits.voltage_v", self.limits.0 as f32),
            ("limits.current_a", self.limits.1 as f32),
            ("tracking.mode", if self.observer { 0.0 } else { 1.0 }),
            ("tracking.span", self.span as f32),
            ("tracking.nominal_q", it.q.clamp(2.0, 1e5)),
            ("tracking.nominal_lm_h", it.lm_h),
            ("tracking.nominal_c0_f", it.c0_f),
        ]
    }
}

/// Three digits, downwards.
fn three_digits(value: f64) -> f64 {
    let step = 10f64.powf(value.log10().floor() - 2.0);
    let digits = (value / step + 1e-9).floor();
    // By way of text, so that it is the number nearest to what is printed.
    format!("{:.4e}", digits * step).parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_voltage_has_three_digits_and_is_not_more() {
        for (value, expected) in [(4.999, 4.99), (0.012_34, 0.0123), (5.0, 5.0), (123.9, 123.0)] {
            assert!((three_digits(value) - expected).abs() < 1e-9, "{value}");
        }
    }
}
