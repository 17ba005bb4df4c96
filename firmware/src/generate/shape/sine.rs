//! The sine, and all rotations that the controller needs.
//!
//! A table of 512 pairs (cosine, sine) is read at the nearest entry, and rotated by the remaining
//! angle `d`, at most 6.2e-3 rad:
//!
//! ```text
//! cos(a + d) = c (1 - d^2 / 2) - s d,    sin(a + d) = s (1 - d^2 / 2) + c d,    error d^3 / 6 = 4e-8
//! ```
//!
//! A sine of constant frequency is not looked up for each sample. Two operations advance its value
//! and its difference:
//!
//! ```text
//! y(n + 1) = y(n) + d(n),    d(n + 1) = d(n) - c y(n + 1),    c = 4 sin^2(omega / 2)
//! ```
//!
//! This is `y(n + 1) = 2 cos(omega) y(n) - y(n - 1)` in a form with small rounding errors even at
//! low frequencies (C. Reinsch). It is seeded from the phase at the beginning of each block, so
//! that rounding errors do not grow beyond a block. In fixed point each operation takes one cycle
//! of a Cortex-M4: [`Steps`].

use crate::generate::nco::Stretch;
use crate::seam::fixed_point::{nearest, upper};
use crate::seam::phasor::Phasor;

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

/// Returns `exp(j 2 pi phase)` for a phase of `phase / 2^64` turns. Error: 1.4e-7.
#[inline]
pub fn rotation(phase: u64) -> Phasor {
    let phase = (phase >> 32) as u32;
    let nearest = phase.wrapping_add(SPACING / 2) / SPACING;
    let (c, s) = PAIRS[nearest as usize % LENGTH];
    let d = phase.wrapping_sub(nearest.wrapping_mul(SPACING)) as i32 as f32 * RADIANS_PER_STEP;
    let (c_d, s_d, half) = (c * d, s * d, 0.5 * d);
    Phasor::new(c - s_d - c_d * half, s + c_d - s_d * half)
}

/// Tone of constant frequency, from which its sines are generated.
#[derive(Clone, Copy, Debug)]
pub struct Steady {
    start: Phasor,
    /// Rotation of half a sample.
    half: Phasor,
}

/// Generator of one sine of a tone, sample after sample.
#[derive(Clone, Copy, Debug)]
pub struct Swing {
    y: f32,
    d: f32,
    c: f32,
}

impl Steady {
    /// Creates the tone of a stretch, from its first sample on.
    pub fn new(stretch: &Stretch) -> Self {
        Steady { start: rotation(stretch.phase), half: rotation(stretch.word / 2) }
    }

    /// Returns the generator of `Im(row exp(j theta(n)))`: the sine of amplitude `|row|` that leads
    /// the tone by the argument of `row`.
    #[inline]
    pub fn swing(&self, row: Phasor) -> Swing {
        let Steady { start, half } = self;
        let first = start * row;
        Swing { y: first.im, d: 2.0 * half.im * (first.re * half.re - first.im * half.im), c: 4.0 * half.im * half.im }
    }
}

/// Coefficient `-c = -4 sin^2(omega / 2)` in fixed point: times 2^32, or times 2^29 if that is too
/// large.
#[derive(Clone, Copy, Debug)]
pub enum Coefficient {
    /// Above minus a half: up to 0.115 of the sample rate.
    Small(i32),
    /// Down to minus four: to half of the sample rate.
    Large(i32),
}

impl Coefficient {
    /// Number of bits by which the product of a large coefficient must be shifted.
    pub const SHIFT: u32 = 3;

    /// Returns the coefficient for `sin^2(omega / 2)`, 0 to 1.
    #[inline]
    pub fn of(sine_square: f32) -> Self {
        let minus_c = -4.0 * sine_square;
        if minus_c > -0.5 {
            Coefficient::Small((minus_c * 4_294_967_296.0) as i32)
        } else {
            Coefficient::Large((minus_c * 536_870_912.0) as i32)
        }
    }

    /// Returns `d - c y` for a small coefficient if `SHIFT` is zero, otherwise for a large one.
    /// Wraps. A small product is rounded down, which takes one cycle (`SMMLA`).
    #[inline(always)]
    pub(crate) fn add<const SHIFT: u32>(d: i32, minus_c: i32, y: i32) -> i32 {
        d.wrapping_add(if SHIFT == 0 { upper(minus_c, y) } else { nearest(minus_c, y) << SHIFT })
    }
}

/// [`Swing`] in fixed point, for amplitudes up to 2^15. At an amplitude of 1500 the error is 0.0154
/// at most over 100 samples, at 0.01 to 0.06 of the sample rate.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    y: i32,
    d: i32,
    minus_c: i32,
}

impl Steps {
    /// Number of fraction bits.
    pub const FRACTION_BITS: u32 = 15;
    /// Highest tuning word whose coefficient is certainly a small one.
    pub const MAX_SMALL_WORD: u64 = (0.115 * 18_446_744_073_709_551_616.0) as u64;

    /// Returns the next sample of the wave, times 2^15; `SHIFT` is zero, or that of a large
    /// [`Coefficient`].
    #[inline(always)]
    pub fn take<const SHIFT: u32>(&mut self) -> i32 {
        let y = self.y;
        self.y = y.wrapping_add(self.d);
        self.d = Coefficient::add::<SHIFT>(self.d, self.minus_c, self.y);
        y
    }
}

impl Swing {
    /// Returns the sine in fixed point, and `true` if its coefficient is a large one.
    #[inline]
    pub fn steps(&self) -> (Steps, bool) {
        let one = (1 << Steps::FRACTION_BITS) as f32;
        let (minus_c, large) = match Coefficient::of(0.25 * self.c) {
            Coefficient::Small(minus_c) => (minus_c, false),
            Coefficient::Large(minus_c) => (minus_c, true),
        };
        (Steps { y: (one * self.y) as i32, d: (one * self.d) as i32, minus_c }, large)
    }

    /// Returns the next sample of the wave.
    #[inline]
    pub fn take(&mut self) -> f32 {
        let y = self.y;
        self.y += self.d;
        self.d -= self.c * self.y;
        y
    }
}

/// Returns `sin(2 pi turns)`, for turns in 0 to 1: the Taylor series about zero of the angle folded
/// into a quarter turn on either side. The last term is below 1e-17.
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
    use crate::generate::nco::tuning_word;
    use crate::seam::block::MAX_BLOCK_SAMPLES;

    /// Returns the deviation of a rotation from the exact one.
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

    /// Returns the largest error of a swing over `samples` samples, at frequencies between two,
    /// cycles a sample.
    fn swing_error(from: f64, to: f64, samples: usize) -> f64 {
        let mut worst = 0.0f64;
        for n in 0..2000u64 {
            let word = tuning_word(from + (to - from) * n as f64 / 2000.0);
            let stretch = Stretch { phase: n.wrapping_mul(0x9e37_79b9_7f4a_7c15), word, step: 0 };
            let row = rotation(n.wrapping_mul(0x1234_5678_9abc_def1));
            let mut swing = Steady::new(&stretch).swing(row);
            for at in 0..samples {
                let phase = core::f64::consts::TAU * (stretch.phase_at(at) as f64 / 18_446_744_073_709_551_616.0);
                let (re, im) = (f64::from(row.re), f64::from(row.im));
                worst = worst.max((f64::from(swing.take()) - im * libm::cos(phase) - re * libm::sin(phase)).abs());
            }
        }
        worst
    }

    /// Bounds the error of the swing, for an amplitude of one. For comparison: half a step of a
    /// 12-bit converter is 2.4e-4, of a 16-bit converter 1.5e-5.
    #[test]
    fn the_swing_follows_the_phase() {
        for (from, to, samples, bound) in [
            (0.0, 0.01, 32, 3e-6),
            (0.01, 0.06, 32, 9e-6),
            (0.01, 0.06, 64, 1.8e-5),
            (0.06, 0.2, 32, 1e-5),
            (0.2, 0.45, 64, 6e-5),
        ] {
            let worst = swing_error(from, to, samples);
            assert!(worst < bound && worst > 0.2 * bound, "{from} to {to}, {samples} samples: {worst}");
        }
    }

    /// Returns the largest error of steps over `samples` samples, at frequencies between two, in
    /// the unit of the amplitude.
    fn steps_error(from: f64, to: f64, amplitude: f32, samples: usize) -> f64 {
        let mut worst = 0.0f64;
        for n in 0..5000u64 {
            let stretch = Stretch {
                phase: n.wrapping_mul(0x9e37_79b9_7f4a_7c15),
                word: tuning_word(from + (to - from) * n as f64 / 5000.0),
                step: 0,
            };
            let (mut steps, large) = Steady::new(&stretch).swing(Phasor::new(amplitude, 0.0)).steps();
            for at in 0..samples {
                let phase = core::f64::consts::TAU * (stretch.phase_at(at) as f64 / 18_446_744_073_709_551_616.0);
                let y = if large { steps.take::<{ Coefficient::SHIFT }>() } else { steps.take::<0>() };
                worst = worst.max((f64::from(y) / 32_768.0 - f64::from(amplitude) * libm::sin(phase)).abs());
            }
        }
        worst
    }

    /// Bounds the error in codes. At a large amplitude it comes from the initial values, which are
    /// in single precision, as for a swing.
    #[test]
    fn steps_follow_the_phase() {
        for (from, to, amplitude, bounds) in [
            (0.0, 0.01, 1500.0, [0.06, 0.15]),
            (0.01, 0.06, 1500.0, [0.0125, 0.0154]),
            (0.06, 0.2, 1500.0, [0.025, 0.0385]),
            (0.2, 0.45, 1500.0, [0.09, 0.127]),
            (0.01, 0.06, 32_000.0, [0.23, 0.32]),
            (0.2, 0.45, 32_000.0, [1.9, 2.7]),
        ] {
            for (samples, bound) in [64, MAX_BLOCK_SAMPLES].into_iter().zip(bounds) {
                let worst = steps_error(from, to, amplitude, samples);
                assert!(worst < bound && worst > 0.5 * bound, "{from} to {to}, {amplitude}, {samples} samples: {worst}");
            }
        }
    }

    #[test]
    fn rotation_is_counter_clockwise() {
        let eighth = rotation(1 << 61);
        assert!((eighth.re - eighth.im).abs() < 1e-6 && eighth.re > 0.707);
    }
}
