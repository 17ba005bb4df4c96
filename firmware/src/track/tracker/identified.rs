//! The transducer as the observer knows it: resonance and damping from the pole, inductance from the strength; the clamped capacitance is what the
//! calibration has measured. The strength is learned while the current builds up, so that Q and Rm are as good as it is.

use crate::seam::transducer::Transducer;
use crate::track::tracker::observer::{Observer, Spread};

const TAU: f32 = core::f32::consts::TAU;

/// What the clamped capacitance is known to apart from noise, relative: images of the drive's converter flow through it as well, and are read at the drive's
/// frequency. Behind an amplifier of 200 kHz they let it seem up to 3.2 % smaller, the less so the more of them the source's resistance keeps (column `c0_error_f` of the file that
/// `evidence transducers` writes); a faster amplifier lets more of them through.
const IMAGES: f32 = 0.018;

/// What the motional phase at the lock point is known to apart from noise, rad: the axis of the sensing chain, and the clamped branch that is taken away.
const PHASE: f32 = 1e-3;
/// What the strength is known to apart from noise, relative (as above, column `lm_error_h`).
const STRENGTH: f32 = 6e-3;
/// The same where it has only been seen from afar: others nearby may have added to it.
pub(crate) const FROM_AFAR: f32 = 3e-2;
/// What the motional resistance is known to apart from noise, relative: gains, the loss of the clamped branch.
const RESISTANCE: f32 = 2e-3;

/// What was known before: the clamped capacitance, and how many resonances there are.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known {
    /// Clamped capacitance and its standard deviation, F.
    pub c0_f: (f32, f32),
    /// Resonances that were found, and the place of this one in their list.
    pub modes: (u8, u8),
    /// What other resonances may turn the motional phase at the lock point by, rad.
    pub phase_rad: f32,
    /// Whether the resonance has been measured at itself, not only from afar, where the strengths of those nearby add up.
    pub closely: bool,
}

/// The equivalent circuit, with deviations.
pub(crate) fn circuit(observer: &Observer, nominal_hz: f32, known: &Known) -> Transducer {
    let mut learning = Learning::default();
    learning.begin(observer, nominal_hz, known);
    while !learning.is_over() {
        learning.advance();
    }
    learning.transducer
}

/// The same in parts, because a root takes as long as two periods of the lock-in: at once what is followed by, the rest a few roots at a time.
#[derive(Clone, Debug)]
pub(crate) struct Learning {
    transducer: Transducer,
    spread: Spread,
    /// Relative deviations of the resonance, of the strength and of the clamped capacitance.
    resonance: f32,
    strength: f32,
    clamped: f32,
    /// `Cm / (C0 + Cm)`.
    part: f32,
    /// What other resonances turn the motional phase at the lock point by, rad; they add as much to its size.
    phase_rad: f32,
    /// Parts that are left.
    left: u8,
}

impl Default for Learning {
    /// Nothing is being learned.
    fn default() -> Self {
        let (transducer, spread) = (Transducer::default(), Spread::default());
        Learning { transducer, spread, resonance: 0.0, strength: 0.0, clamped: 0.0, part: 0.0, phase_rad: 0.0, left: 0 }
    }
}

impl Learning {
    /// Resonance, Q, and the elements; no deviations, and not what follows from a root.
    pub(crate) fn begin(&mut self, observer: &Observer, nominal_hz: f32, known: &Known) {
        let hz = nominal_hz + observer.offset_hz();
        let omega = TAU * hz;
        let (lm_h, alpha, c0_f) = (observer.lm_h(), observer.damping(), known.c0_f.0);
        let cm_f = 1.0 / (omega * omega * lm_h);
        let reported = &mut self.transducer;
        (reported.series_resonance_hz, reported.q, reported.rm_ohm) = (hz, 0.5 * omega / alpha, 2.0 * alpha * lm_h);
        (reported.lm_h, reported.cm_f, reported.c0_f) = (lm_h, cm_f, c0_f);
        (reported.modes, reported.chosen) = known.modes;
        (self.part, self.clamped) = (cm_f / (c0_f + cm_f), IMAGES + known.c0_f.1 / c0_f);
        (self.phase_rad, self.strength) = (known.phase_rad, if known.closely { STRENGTH } else { FROM_AFAR });
        (self.spread, self.left) = (observer.spread(), 4);
    }

    /// Whether there is nothing to be done.
    #[inline]
    pub(crate) fn is_over(&self) -> bool {
        self.left == 0
    }

    /// Forgets what is half done.
    pub(crate) fn abandon(&mut self) {
        self.left = 0;
    }

    /// What is known so far: all, when it is over.
    pub(crate) fn transducer(&self) -> &Transducer {
        &self.transducer
    }

    /// Some roots more.
    #[inline(never)]
    pub(crate) fn advance(&mut self) {
        let Learning { transducer, spread, resonance, strength, clamped, part, phase_rad, left } = self;
        let Transducer { series_resonance_hz: hz, q, cm_f, c0_f, deviations, .. } = transducer;
        let root = |sum: f32| libm::sqrtf(sum);
        let square = |x: f32| x * x;
        // Relative deviations of what it follows from, each on its own; a sum of them adds up in squares. `Cm = 1 / (w^2 Lm)`, and
        // `fp / fs = sqrt(1 + Cm / C0)`, in which the resonance takes back a part of what it moves `fs` by.
        let ratio = |strength: f32, clamped: f32| square(strength) + square(clamped);
        // The current shows `Rm` to half a bandwidth as the resonance is known; `Q = ws Lm / Rm`.
        let half = 2.0 * *q * *resonance;
        match *left {
            4 => {
                // Half a half bandwidth a radian.
                *resonance = root(square(spread.deviation_hz() / *hz) + square(0.5 * (PHASE + *phase_rad) / *q));
                *strength = root(spread.strength + square(*strength + *phase_rad));
            }
            3 => {
                transducer.parallel_resonance_hz = *hz * root(1.0 + *cm_f / *c0_f);
                deviations.series_resonance_hz = *resonance * *hz;
                deviations.lm_h = *strength * transducer.lm_h;
                deviations.c0_f = *clamped * *c0_f;
                deviations.q = root(square(half) + square(*strength)) * *q;
                deviations.rm_ohm = root(square(half) + square(RESISTANCE + *phase_rad)) * transducer.rm_ohm;
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
        *left = left.saturating_sub(1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::identify::scatter::Scatter;
    use crate::seam::phasor::Phasor;
    use crate::seam::transducer::Deviations;
    use crate::track::tracker::observer::Prior;

    /// By the scatter of independent parts, as a fit states it; but Q and Rm, of which the steady current shows the one, and the strength the other.
    #[test]
    fn the_deviations_are_those_of_the_scatter() {
        let mut observer = Observer::new(40e3, 32e-6);
        let axis = Phasor::new(1.0, 0.0);
        observer.start(&Prior { offset_hz: (300.0, 25.0), q: 30.0, lm_h: (0.8e-3, 0.08e-3), axis, noise_a: 1e-3 });
        let known = Known { c0_f: (290e-9, 4e-9), modes: (2, 0), phase_rad: 0.01, closely: true };
        let found = circuit(&observer, 40e3, &known);
        let resonance = (observer.deviation_hz() / found.series_resonance_hz).hypot(0.5 * (PHASE + known.phase_rad) / found.q);
        let strength = observer.strength_deviation().hypot(STRENGTH + known.phase_rad);
        // `w = f / fs - fs / f` changes twice as much as the frequency does, and a part has a variance of one half each way.
        let (none, part) = (Phasor::new(0.0, 0.0), |size: f32| Phasor::new(core::f32::consts::SQRT_2 * size, 0.0));
        let scatter = Scatter {
            pole: [part(2.0 * resonance), none, none],
            strength: [none, part(strength), none],
            y0: [none, none, part(TAU * found.series_resonance_hz * (known.c0_f.1 + IMAGES * known.c0_f.0))],
        };
        let (reported, mut all) = (found.deviations, Deviations::default());
        [0, 1].into_iter().for_each(|part| scatter.products().deviate(&found, part, &mut all));
        let half = 2.0 * found.q * resonance;
        for (name, reported, expected) in [
            ("series", reported.series_resonance_hz, all.series_resonance_hz),
            ("parallel", reported.parallel_resonance_hz, all.parallel_resonance_hz),
            ("Q", reported.q, half.hypot(strength) * found.q),
            ("Rm", reported.rm_ohm, half.hypot(RESISTANCE + known.phase_rad) * found.rm_ohm),
            ("Lm", reported.lm_h, all.lm_h),
            ("Cm", reported.cm_f, all.cm_f),
            ("C0", reported.c0_f, all.c0_f),
            ("coupling", reported.coupling, all.coupling),
        ] {
            // Measured: 2e-7, rounding.
            assert!((reported / expected - 1.0).abs() < 1e-6, "{name}: {reported} {expected}");
        }
    }

    #[test]
    fn what_was_seen_from_afar_is_known_less() {
        let mut observer = Observer::new(40e3, 32e-6);
        let axis = Phasor::new(1.0, 0.0);
        observer.start(&Prior { offset_hz: (300.0, 25.0), q: 30.0, lm_h: (0.8e-3, 0.1e-6), axis, noise_a: 1e-3 });
        let lm = |closely: bool| {
            let found = circuit(&observer, 40e3, &Known { c0_f: (290e-9, 4e-9), modes: (1, 0), phase_rad: 0.0, closely });
            found.deviations.lm_h / found.lm_h
        };
        assert!(lm(true) < 1.1 * STRENGTH && lm(false) > 0.99 * FROM_AFAR, "{} {}", lm(true), lm(false));
    }
}
