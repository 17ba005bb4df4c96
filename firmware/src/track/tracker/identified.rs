//! The transducer as identified by the observer: resonance and damping from the pole, inductance
//! from the strength. The clamped capacitance comes from the calibration. The strength is learned
//! while the current builds up, so that Q and Rm are as accurate as the strength.

use crate::find::scan::ring_down::C0_UNCERTAINTY_REL;
use crate::seam::transducer::{LockQuality, Transducer};
use crate::track::tracker::observer::{Observer, Spread};

const TAU: f32 = core::f32::consts::TAU;

/// Uncertainty of the motional phase at the lock point apart from noise, rad: from the axis of the
/// sensing chain and the clamped branch that is subtracted.
const PHASE_UNCERTAINTY_RAD: f32 = 6e-4;
/// Relative uncertainty of the strength apart from noise (same file, column `lm_error_h`).
const STRENGTH_UNCERTAINTY_REL: f32 = 4e-3;
/// Relative uncertainty of a strength measured only off resonance: others nearby may add to it.
pub(crate) const OFF_RESONANCE_UNCERTAINTY_REL: f32 = 3e-2;
/// Relative uncertainty of the motional resistance apart from noise: from gains and the loss of the
/// clamped branch.
const RM_UNCERTAINTY_REL: f32 = 1.5e-3;

/// Results of earlier stages: the clamped capacitance, and the number of resonances.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Clamped capacitance, and its standard deviation, F.
    pub c0_f: (f32, f32),
    /// Number of resonances found, and the index of this one among them.
    pub modes: (u8, u8),
    /// Turn of the motional phase at the lock point by other resonances, rad.
    pub phase_rad: f32,
    /// `true` if the strength was measured at the resonance; `false` if only off resonance, where
    /// the strengths of those nearby add up.
    pub closely: bool,
}

/// Returns the equivalent circuit, with deviations.
pub(crate) fn circuit(observer: &Observer, nominal_hz: f32, known: &Known) -> Transducer {
    let mut learning = Learning::default();
    learning.begin(observer, nominal_hz, known);
    while !learning.is_over() {
        learning.advance();
    }
    learning.transducer
}

/// Identification in parts, because a square root takes as long as two periods of the lock-in. The
/// values that the loops need are complete at once; the rest follows a few roots at a time.
#[derive(Clone, Debug)]
pub(crate) struct Learning {
    transducer: Transducer,
    spread: Spread,
    /// Relative deviation of the resonance.
    resonance: f32,
    /// Relative deviation of the strength.
    strength: f32,
    /// Relative deviation of the clamped capacitance.
    clamped: f32,
    /// `Cm / (C0 + Cm)`.
    part: f32,
    /// Turn of the motional phase at the lock point by other resonances, rad; they change its
    /// amplitude by the same part.
    phase_rad: f32,
    /// `true` if it began in a settled block under drive.
    settled: bool,
    /// Number of remaining parts; negative before the first identification.
    parts_left: i8,
}

impl Default for Learning {
    /// Returns an identification that has not begun.
    fn default() -> Self {
        let (transducer, spread) = (Transducer::default(), Spread::default());
        let (resonance, strength, clamped, part, phase_rad) = (0.0, 0.0, 0.0, 0.0, 0.0);
        Learning { transducer, spread, resonance, strength, clamped, part, phase_rad, settled: false, parts_left: -1 }
    }
}

impl Learning {
    /// Computes resonance, Q and circuit elements, without deviations and values that need a root.
    pub(crate) fn begin(&mut self, observer: &Observer, nominal_hz: f32, known: &Known) {
        let hz = nominal_hz + observer.offset_hz();
        let omega = TAU * hz;
        let (lm_h, alpha, c0_f) = (observer.lm_h(), observer.damping(), known.c0_f.0);
        let cm_f = 1.0 / (omega * omega * lm_h);
        let reported = &mut self.transducer;
        (reported.series_resonance_hz, reported.q, reported.rm_ohm) = (hz, 0.5 * omega / alpha, 2.0 * alpha * lm_h);
        (reported.lm_h, reported.cm_f, reported.c0_f) = (lm_h, cm_f, c0_f);
        (reported.modes, reported.chosen) = known.modes;
        (self.part, self.clamped) = (cm_f / (c0_f + cm_f), C0_UNCERTAINTY_REL + known.c0_f.1 / c0_f);
        (self.phase_rad, self.strength) =
            (known.phase_rad, if known.closely { STRENGTH_UNCERTAINTY_REL } else { OFF_RESONANCE_UNCERTAINTY_REL });
        (self.spread, self.settled, self.parts_left) = (observer.spread(), observer.has_settled(), 4);
    }

    /// Returns `true` if no part remains.
    #[inline]
    pub(crate) fn is_over(&self) -> bool {
        self.parts_left <= 0
    }

    /// Returns `true` if there is a transducer, complete or not.
    #[inline]
    pub(crate) fn has_begun(&self) -> bool {
        self.parts_left >= 0
    }

    /// Returns `true` if the identification began in a settled block under drive.
    pub(crate) fn is_settled(&self) -> bool {
        self.settled
    }

    /// Takes a transducer that is known completely.
    pub(crate) fn adopt(&mut self, transducer: &Transducer) {
        (self.transducer, self.parts_left) = (*transducer, 0);
    }

    /// Returns the transducer as computed so far; complete if [`is_over`](Self::is_over).
    pub(crate) fn transducer(&self) -> &Transducer {
        &self.transducer
    }

    /// Returns the quality of the lock; identifications do not change it.
    pub(crate) fn quality(&mut self) -> &mut LockQuality {
        &mut self.transducer.quality
    }

    /// Computes the next part.
    #[inline(never)]
    pub(crate) fn advance(&mut self) {
        let Learning { transducer, spread, resonance, strength, clamped, part, phase_rad, parts_left, .. } = self;
        let Transducer { series_resonance_hz: hz, q, cm_f, c0_f, deviations, .. } = transducer;
        let root = |sum: f32| fpu::sqrtf(sum);
        let square = |x: f32| x * x;
        // Independent relative deviations add up in squares. `Cm = 1 / (w^2 Lm)` and
        // `fp / fs = sqrt(1 + Cm / C0)`, in which the resonance cancels a part of its own effect
        // on `fs`.
        let ratio = |strength: f32, clamped: f32| square(strength) + square(clamped);
        // The relative deviation of `Rm` equals the deviation of the resonance in half bandwidths.
        // `Q = ws Lm / Rm`.
        let half = 2.0 * *q * *resonance;
        match *parts_left {
            4 => {
                // A radian of motional phase is half a bandwidth: `1 / (2 Q)` of the frequency.
                *resonance = root(square(spread.deviation_hz() / *hz) + square(0.5 * (PHASE_UNCERTAINTY_RAD + *phase_rad) / *q));
                *strength = root(spread.strength + square(*strength + *phase_rad));
            }
            3 => {
                transducer.parallel_resonance_hz = *hz * root(1.0 + *cm_f / *c0_f);
                deviations.series_resonance_hz = *resonance * *hz;
                deviations.lm_h = *strength * transducer.lm_h;
                deviations.c0_f = *clamped * *c0_f;
                deviations.q = root(square(half) + square(*strength)) * *q;
                deviations.rm_ohm = root(square(half) + square(RM_UNCERTAINTY_REL + *phase_rad)) * transducer.rm_ohm;
            }
            2 => {
                let ratio = ratio(*strength, *clamped);
                deviations.parallel_resonance_hz =
                    root(square((1.0 - *part) * *resonance) + square(0.5 * *part) * ratio) * transducer.parallel_resonance_hz;
                deviations.cm_f = root(square(2.0 * *resonance) + square(*strength)) * *cm_f;
            }
            _ => {
                let ratio = ratio(*strength, *clamped);
                transducer.coupling = root(*part);
                deviations.coupling = root(square(2.0 * *resonance) + ratio) * 0.5 * (1.0 - *part) * transducer.coupling;
            }
        }
        *parts_left -= 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::identify::scatter::Scatter;
    use crate::seam::phasor::Phasor;
    use crate::seam::transducer::Deviations;
    use crate::track::tracker::observer::Prior;

    /// The deviations equal those of a fit with independent parts, except for Q and Rm: the steady
    /// current gives Rm, the strength gives Lm.
    #[test]
    fn the_deviations_match_those_of_a_fit() {
        let mut observer = Observer::new(40e3, 32e-6, 2e3);
        let axis = Phasor::new(1.0, 0.0);
        observer.start(&Prior { offset_hz: (300.0, 25.0), q: 30.0, lm_h: (0.8e-3, 0.08e-3), axis, noise_a: 1e-3 });
        let known = Known { c0_f: (290e-9, 4e-9), modes: (2, 0), phase_rad: 0.01, closely: true };
        let found = circuit(&observer, 40e3, &known);
        let resonance = (observer.deviation_hz() / found.series_resonance_hz)
            .hypot(0.5 * (PHASE_UNCERTAINTY_RAD + known.phase_rad) / found.q);
        let strength = observer.strength_deviation().hypot(STRENGTH_UNCERTAINTY_REL + known.phase_rad);
        // `w = f / fs - fs / f` changes twice as much as the frequency; each component has half the
        // variance.
        let (none, part) = (Phasor::new(0.0, 0.0), |size: f32| Phasor::new(core::f32::consts::SQRT_2 * size, 0.0));
        let scatter = Scatter {
            pole: [part(2.0 * resonance), none, none],
            strength: [none, part(strength), none],
            y0: [none, none, part(TAU * found.series_resonance_hz * (known.c0_f.1 + C0_UNCERTAINTY_REL * known.c0_f.0))],
        };
        let (reported, mut all) = (found.deviations, Deviations::default());
        [0, 1].into_iter().for_each(|part| scatter.products().deviate(&found, part, &mut all));
        let half = 2.0 * found.q * resonance;
        for (name, reported, expected) in [
            ("series", reported.series_resonance_hz, all.series_resonance_hz),
            ("parallel", reported.parallel_resonance_hz, all.parallel_resonance_hz),
            ("Q", reported.q, half.hypot(strength) * found.q),
            ("Rm", reported.rm_ohm, half.hypot(RM_UNCERTAINTY_REL + known.phase_rad) * found.rm_ohm),
            ("Lm", reported.lm_h, all.lm_h),
            ("Cm", reported.cm_f, all.cm_f),
            ("C0", reported.c0_f, all.c0_f),
            ("coupling", reported.coupling, all.coupling),
        ] {
            // Measured: 2e-7, which is rounding.
            assert!((reported / expected - 1.0).abs() < 1e-6, "{name}: {reported} {expected}");
        }
    }

    #[test]
    fn a_strength_measured_off_resonance_is_less_certain() {
        let mut observer = Observer::new(40e3, 32e-6, 2e3);
        let axis = Phasor::new(1.0, 0.0);
        observer.start(&Prior { offset_hz: (300.0, 25.0), q: 30.0, lm_h: (0.8e-3, 0.1e-6), axis, noise_a: 1e-3 });
        let noise = observer.strength_deviation();
        for (closely, uncertainty) in [(true, STRENGTH_UNCERTAINTY_REL), (false, OFF_RESONANCE_UNCERTAINTY_REL)] {
            let found = circuit(&observer, 40e3, &Known { c0_f: (290e-9, 4e-9), modes: (1, 0), phase_rad: 0.0, closely });
            let (stated, expected) = (found.deviations.lm_h / found.lm_h, noise.hypot(uncertainty));
            // Only rounding.
            assert!((stated / expected - 1.0).abs() < 1e-6, "{closely}: {stated} {expected}");
        }
    }
}
