//! The transducer as the observer knows it: resonance and damping from the pole, inductance from the strength; the clamped capacitance is what the
//! calibration has measured. The strength is learned while the current builds up, so that Q and Rm are as good as it is.

use crate::identify::scatter::Scatter;
use crate::identify::{Deviations, Transducer};
use crate::phasor::Phasor;
use crate::tracker::observer::Observer;

const TAU: f32 = core::f32::consts::TAU;
const NONE: Phasor = Phasor::new(0.0, 0.0);

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
    let transducer = Transducer {
        series_resonance_hz: hz,
        parallel_resonance_hz: hz * libm::sqrtf(1.0 + cm_f / c0_f),
        q: 0.5 * omega / alpha,
        rm_ohm: 2.0 * alpha * lm_h,
        lm_h,
        cm_f,
        c0_f,
        coupling: libm::sqrtf(cm_f / (c0_f + cm_f)),
        deviations: Deviations::default(),
        modes: known.modes.0,
        chosen: known.modes.1,
    };
    // `w = f / fs - fs / f` changes twice as much as the frequency does. A deviation is of one part of two.
    let both = core::f32::consts::SQRT_2;
    let part = |size: f32| Phasor::new(both * size, 0.0);
    let scatter = Scatter {
        pole: [part(2.0 * observer.deviation_hz() / hz), NONE, NONE],
        strength: [NONE, part(observer.strength_deviation()), NONE],
        y0: [NONE, NONE, part(omega * known.c0_f.1)],
    };
    Transducer { deviations: scatter.deviations(&transducer), ..transducer }
}
