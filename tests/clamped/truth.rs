//! Exact admittance of a circuit as measured by the converters: the carrier and every image of the
//! held drive, through amplifier, source and stack, at the instants of the converters.
//!
//! ```text
//! E(k) = A(w(k)) / w(k),  V(k) = E(k) / (1 + Rs Y(w(k))),  I(k) = Y V(k),  w(k) = w + 2 pi k fs;   Y seen = sum I(k) exp(j w(k) ti) / sum V(k) exp(j w(k) tv)
//! ```

use std::f64::consts::TAU;

use num_complex::Complex64;
use plant::circuit::Circuit;
use scene::{Amplifier, Sensors};

/// Circuit with its amplifier and converters.
#[derive(Clone)]
pub struct Truth {
    pub circuit: Circuit,
    /// Second motional branch: resistance, inductance, capacitance.
    pub second: Option<[f64; 3]>,
    /// Loss tangent of the clamped capacitance.
    pub loss: f64,
    pub amplifier: Amplifier,
    pub sensors: Sensors,
}

impl Truth {
    fn admittance(&self, omega: f64, motional: bool) -> Complex64 {
        let branch = |r: f64, l: f64, c: f64| Complex64::new(r, omega * l - 1.0 / (omega * c)).inv();
        let Circuit { c0_f, cm_f, lm_h, rm_ohm, .. } = self.circuit;
        let clamped = Complex64::new(self.loss * omega.abs() * c0_f, omega * c0_f);
        let first = if motional { branch(rm_ohm, lm_h, cm_f) } else { Complex64::default() };
        clamped + first + self.second.map_or(Complex64::default(), |[r, l, c]| branch(r, l, c))
    }

    /// Returns the measured admittance at a frequency, with or without the motional branch.
    pub fn admittance_at(&self, hz: f64, motional: bool) -> Complex64 {
        let sample_s = 1.0 / self.sensors.sample_hz;
        let conversions = u32::from(self.sensors.oversample);
        let (mut v, mut i) = (Complex64::default(), Complex64::default());
        for k in -400..=400 {
            let omega = TAU * (hz + f64::from(k) * self.sensors.sample_hz);
            let x = omega / (TAU * self.amplifier.bandwidth_hz);
            let low_pass = Complex64::new(1.0 - x * x, std::f64::consts::SQRT_2 * x).inv();
            let loaded = 1.0 + self.amplifier.source_ohm * self.admittance(omega, true);
            let voltage = low_pass / omega / loaded;
            let current = voltage * self.admittance(omega, motional);
            for conversion in 1..=conversions {
                let at = sample_s * f64::from(conversion) / f64::from(conversions);
                v += voltage * Complex64::from_polar(1.0, omega * (at - self.sensors.skew_s.max(0.0)));
                i += current * Complex64::from_polar(1.0, omega * (at + self.sensors.skew_s.min(0.0)));
            }
        }
        i / v
    }

    /// Returns the distance from the resonance, Hz, at which a tracker drives. The tracker
    /// subtracts `y0`, stated at `nominal_hz`, and rotates by `axis`.
    pub fn bias_hz(&self, nominal_hz: f64, y0: Complex64, axis: Complex64) -> f64 {
        let resonance = self.circuit.series_resonance_hz();
        let phase = |offset: f64| {
            let hz = resonance + offset;
            ((self.admittance_at(hz, true) - Complex64::new(y0.re, y0.im * hz / nominal_hz)) * axis.conj()).arg()
        };
        let half = 0.5 * resonance / self.circuit.q();
        let (mut before, mut at) = (-0.5 * half, 0.5 * half);
        let (mut phase_before, mut phase_at) = (phase(before), phase(at));
        while (at - before).abs() > 1e-5 && phase_at != phase_before {
            let next = at - phase_at * (at - before) / (phase_at - phase_before);
            (before, phase_before) = (at, phase_at);
            (at, phase_at) = (next, phase(next));
        }
        at
    }
}

#[test]
fn a_fast_amplifier_and_a_settled_tone_agree_with_it() {
    use super::rig::{Case, Rig};
    let case = Case { noise_lsb: 0.1, ..Case::default() };
    let mut rig = Rig::new(&case, 1);
    let mut sum = (Complex64::default(), 0.0);
    for block in 0..4000 {
        let exchange = rig.block(|_| (312.0, 3.0));
        if block > 1000 {
            let [v, i] = [exchange.sensed.v, exchange.sensed.i].map(super::rig::wide);
            sum = (sum.0 + i * v.conj(), sum.1 + v.norm_sqr());
        }
    }
    let seen = rig.truth.admittance_at(case.nominal_hz + 312.0, true);
    let error = (sum.0 / sum.1 - seen).norm() / seen.norm();
    println!("{error:.1e} of the admittance");
    assert!(error < 2e-4, "{error}");
}
