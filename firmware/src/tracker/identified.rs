//! The transducer as the observer knows it: resonance and damping from the pole, inductance from the strength; the clamped capacitance is what the
//! calibration has measured. The strength is learned while the current builds up, so that Q and Rm are as good as it is.

use crate::identify::{Deviations, Transducer};
use crate::tracker::observer::Observer;

const TAU: f32 = core::f32::consts::TAU;

/// What was known before: the clamped capacitance, and how many resonances there are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Clamped capacitance and its standard deviation, F.
    pub c0_f: (f32, f32),
    /// Resonances that were found, and the place of this one in their list.
    pub modes: (u8, u8),
}

/// The equivalent circuit, with deviations.
pub fn circuit(observer: &Observer, nominal_hz: f32, known: &Known) -> Transducer {
    let hz = nominal_hz + observer.offset_hz();
    let omega = TAU * hz;
    let (lm_h, alpha, c0_f) = (observer.lm_h(), observer.damping(), known.c0_f.0);
    let cm_f = 1.0 / (omega * omega * lm_h);
    let part = cm_f / (c0_f + cm_f);
    // Relative deviations of what it follows from, each on its own; a sum of them adds up in squares.
    let (resonance, strength, clamped) = (observer.deviation_hz() / hz, observer.strength_deviation(), known.c0_f.1 / c0_f);
    let root = |sum: f32| libm::sqrtf(sum);
    let square = |x: f32| x * x;
    let q = 0.5 * omega / alpha;
    // `Cm = 1 / (w^2 Lm)`, and `fp / fs = sqrt(1 + Cm / C0)`, in which the resonance takes back a part of what it moves `fs` by.
    let cm = square(2.0 * resonance) + square(strength);
    let ratio = square(strength) + square(clamped);
    let parallel_resonance_hz = hz * root(1.0 + cm_f / c0_f);
    let coupling = root(part);
    let rm_ohm = 2.0 * alpha * lm_h;
    let deviations = Deviations {
        series_resonance_hz: resonance * hz,
        parallel_resonance_hz: root(square((1.0 - part) * resonance) + square(0.5 * part) * ratio) * parallel_resonance_hz,
        q: 2.0 * q * resonance * q,
        // `Rm = ws Lm / Q`, whose Q is known to half a bandwidth as the resonance is.
        rm_ohm: root(square(resonance) * (1.0 + square(2.0 * q)) + square(strength)) * rm_ohm,
        lm_h: strength * lm_h,
        cm_f: root(cm) * cm_f,
        c0_f: clamped * c0_f,
        coupling: root(square(2.0 * resonance) + ratio) * 0.5 * (1.0 - part) * coupling,
    };
    Transducer {
        series_resonance_hz: hz,
        parallel_resonance_hz,
        q,
        rm_ohm,
        lm_h,
        cm_f,
        c0_f,
        coupling,
        deviations,
        modes: known.modes.0,
        chosen: known.modes.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::identify::scatter::Scatter;
    use crate::phasor::Phasor;
    use crate::tracker::observer::Prior;

    /// By the scatter of independent parts, as a fit states it.
    #[test]
    fn the_deviations_are_those_of_the_scatter() {
        let mut observer = Observer::new(40e3, 32e-6);
        let axis = Phasor::new(1.0, 0.0);
        observer.start(&Prior { offset_hz: (300.0, 25.0), q: 30.0, lm_h: (0.8e-3, 0.08e-3), axis, noise_a: 1e-3 });
        let known = Known { c0_f: (290e-9, 4e-9), modes: (1, 0) };
        let found = circuit(&observer, 40e3, &known);
        // `w = f / fs - fs / f` changes twice as much as the frequency does, and a part has a variance of one half each way.
        let (none, part) = (Phasor::new(0.0, 0.0), |size: f32| Phasor::new(core::f32::consts::SQRT_2 * size, 0.0));
        let scatter = Scatter {
            pole: [part(2.0 * observer.deviation_hz() / found.series_resonance_hz), none, none],
            strength: [none, part(observer.strength_deviation()), none],
            y0: [none, none, part(TAU * found.series_resonance_hz * known.c0_f.1)],
        };
        let (told, all) = (found.deviations, scatter.deviations(&found));
        for (name, told, expected) in [
            ("series", told.series_resonance_hz, all.series_resonance_hz),
            ("parallel", told.parallel_resonance_hz, all.parallel_resonance_hz),
            ("Q", told.q, all.q),
            ("Rm", told.rm_ohm, all.rm_ohm),
            ("Lm", told.lm_h, all.lm_h),
            ("Cm", told.cm_f, all.cm_f),
            ("C0", told.c0_f, all.c0_f),
            ("coupling", told.coupling, all.coupling),
        ] {
            // Measured: 2e-7, rounding.
            assert!((told / expected - 1.0).abs() < 1e-6, "{name}: {told} {expected}");
        }
    }
}
