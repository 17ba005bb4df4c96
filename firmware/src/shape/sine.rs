//! The sine, and with it every rotation the controller needs.
//!
//! A table of 512 pairs (cosine, sine) is read at the nearest entry and turned by the angle `d` that remains, at most 6.2e-3 rad:
//!
//! ```text
//! cos(a + d) = c (1 - d^2 / 2) - s d,    sin(a + d) = s (1 - d^2 / 2) + c d,    error d^3 / 6 = 4e-8
//! ```
//!
//! Sample after sample, [`Rotor`] multiplies by the rotation of one step instead: `z(n + 1) = z(n) w`. It is seeded from the phase at the
//! beginning of each block, so that what the rotation of a step is off never grows beyond a block.

use crate::nco::Stretch;
use crate::phasor::Phasor;

const INDEX_BITS: u32 = 9;
const LENGTH: usize = 1 << INDEX_BITS;
/// Phase steps (2^32 a turn) from one entry to the next.
const SPACING: u32 = 1 << (32 - INDEX_BITS);
const RADIANS_PER_STEP: f32 = (core::f64::consts::TAU / 4_294_967_296.0) as f32;

/// Cosine and sine of one period.
static PAIRS: [(f32, f32); LENGTH] = {
    let mut pairs = [(0.0, 0.0); LENGTH];
    let mut n = 0;
    while n < LENGTH {
        let turns = n as f64 / LENGTH as f64;
        let quarter_on = if turns >= 0.75 { turns - 0.75 } else { turns + 0.25 };
        pairs[n] = (sine_of_turns(quarter_on) as f32, sine_of_turns(turns) as f32);
        n += 1;
    }
    pairs
};

/// `exp(j 2 pi phase)` for a phase of `phase / 2^64` turns. Error: 1.4e-7.
#[inline]
pub fn rotation(phase: u64) -> Phasor {
    let phase = (phase >> 32) as u32;
    let nearest = phase.wrapping_add(SPACING / 2) / SPACING;
    let (c, s) = PAIRS[nearest as usize % LENGTH];
    let d = phase.wrapping_sub(nearest.wrapping_mul(SPACING)) as i32 as f32 * RADIANS_PER_STEP;
    let (c_d, s_d, half) = (c * d, s * d, 0.5 * d);
    Phasor::new(c - s_d - c_d * half, s + c_d - s_d * half)
}

/// `exp(j 2 pi phase(n))` of a stretch, sample after sample.
#[derive(Clone, Copy, Debug)]
pub struct Rotor(Stretch);

impl Rotor {
    /// At the first sample of a stretch.
    pub fn new(stretch: &Stretch) -> Self {
        Rotor(*stretch)
    }

    /// Calls `take` for each of `samples` samples.
    #[inline(always)]
    pub fn each(self, samples: usize, mut take: impl FnMut(Phasor)) {
        let Stretch { mut phase, mut word, step } = self.0;
        if step == 0 {
            let (mut z, turn) = (rotation(phase), rotation(word));
            (0..samples).for_each(|_| {
                take(z);
                z *= turn;
            });
        } else {
            // A word that moves would be turned by less than single precision resolves.
            (0..samples).for_each(|_| {
                take(rotation(phase));
                phase = phase.wrapping_add(word);
                word = word.wrapping_add(step);
            });
        }
    }
}

/// `sin(2 pi turns)` at compile time, for turns in 0 to 1: Taylor series about zero of the angle folded into a quarter
/// turn either side; the last term is below 1e-17.
pub(super) const fn sine_of_turns(turns: f64) -> f64 {
    let turns = turns - if turns > 0.75 { 1.0 } else { 0.0 };
    let turns = if turns > 0.25 { 0.5 - turns } else { turns };
    let x = core::f64::consts::TAU * turns;
    let mut term = x;
    let mut sum = x;
    let mut k = 1;
    while k < 12 {
        term = -term * x * x / ((2 * k) * (2 * k + 1)) as f64;
        sum += term;
        k += 1;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nco::tuning_word;

    /// How far a rotation is from the exact one.
    fn error(z: Phasor, phase: u64) -> f64 {
        let angle = core::f64::consts::TAU * (phase as f64 / 18_446_744_073_709_551_616.0);
        libm::hypot(f64::from(z.re) - libm::cos(angle), f64::from(z.im) - libm::sin(angle))
    }

    #[test]
    fn rotation_is_within_the_last_digits_of_single_precision() {
        let phases = (0..1_000_003u64).map(|n| n.wrapping_mul(4_294_000_000 << 32));
        let worst = phases.map(|phase| error(rotation(phase), phase)).fold(0.0, f64::max);
        assert!(worst < 1.5e-7 && worst > 5e-8, "{worst}");
    }

    /// Over the longest block, at any frequency, still or moving: thirty times below half a step of a 16-bit converter.
    #[test]
    fn the_rotor_stays_with_the_phase() {
        let mut worst = 0.0f64;
        for (n, step) in (0..2000u64).zip([0, 1 << 38, (1u64 << 40).wrapping_neg()].into_iter().cycle()) {
            let stretch =
                Stretch { phase: n.wrapping_mul(0x9e37_79b9_7f4a_7c15), word: tuning_word(0.45 * n as f64 / 2000.0), step };
            let mut at = 0;
            Rotor::new(&stretch).each(64, |z| {
                worst = worst.max(error(z, stretch.phase_at(at)));
                at += 1;
            });
        }
        assert!(worst < 1e-5, "{worst}");
    }

    /// Why the drive does not come from micromath: half a step of a 12-bit converter is 2.4e-4.
    #[test]
    fn micromath_is_too_coarse_for_the_drive() {
        let error = |x: f32| (micromath::F32(x).sin().0 - libm::sinf(x)).abs();
        let worst = (0..10_000).map(|n| error(core::f32::consts::TAU * n as f32 / 10_000.0)).fold(0.0, f32::max);
        assert!((5e-4..2e-3).contains(&worst), "{worst}");
    }

    #[test]
    fn rotation_is_counter_clockwise() {
        let eighth = rotation(1 << 61);
        assert!((eighth.re - eighth.im).abs() < 1e-6 && eighth.re > 0.707);
    }
}
