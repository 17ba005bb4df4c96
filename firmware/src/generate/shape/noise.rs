//! Noise within a band: white noise through a Butterworth band-pass of eighth order, in four
//! sections; and dither.
//!
//! With corners `w = 2 tan(pi f / fs)`, `w0^2 = w1 w2`, `B = w2 - w1`, each pole `p` of the
//! low-pass prototype of fourth order gives two of the band-pass,
//! `s = (p B +- sqrt(p^2 B^2 - 4 w0^2)) / 2`. The bilinear transform `z = (2 + s) / (2 - s)` gives
//! a section with zeros at 1 and -1:
//!
//! ```text
//! H(z) = (1 - z^-2) / (1 - 2 Re(z) z^-1 + |z|^2 z^-2)
//! ```
//!
//! (S. Butterworth 1930; the transforms are in any text on digital filters.) The output is scaled
//! by the energy of the impulse response to an rms of a quarter, and clipped at one, which affects
//! 6e-5 of Gaussian samples.

use num_complex::Complex64;
use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoroshiro64Star;

use crate::generate::shape::sine::sine_of_turns;
use crate::generate::sweep::MAX_FREQUENCY_REL;
use crate::seam::config::{Config, Drive};
use crate::seam::error::Error;

const SECTIONS: usize = 4;
/// The two poles of the prototype above the real axis, `exp(j pi (5 + 2 n) / 8)`, as computed by
/// libm. Those below are their conjugates, and give the conjugate poles.
const PROTOTYPE: [(f64, f64); 2] = [(-0.3826834323650897, 0.9238795325112867), (-0.9238795325112867, 0.3826834323650899)];
/// Ratio of peak to rms.
const CREST_FACTOR: f32 = 4.0;
/// Narrowest band, relative to its lower corner: in a narrower one, poles are too near the unit
/// circle for single precision.
const MIN_WIDTH_REL: f64 = 0.02;
/// Lowest corner, relative to the sample rate, for the same reason.
const MIN_CORNER_REL: f64 = 1e-3;
/// Number of samples of the impulse response that are evaluated. The response of the narrowest band
/// at the lowest corner is longer, and its output 3 per cent larger.
const RESPONSE_SAMPLES: usize = 1 << 16;

/// Generator of words of uniformly distributed bits.
#[derive(Clone, Debug)]
struct White(Xoroshiro64Star);

impl White {
    fn new(seed: u64) -> Self {
        White(Xoroshiro64Star::seed_from_u64(seed))
    }

    #[inline]
    fn word(&mut self) -> u32 {
        self.0.next_u32()
    }
}

/// Filter section `y = x - x(n - 2) + a1 y(n - 1) - a2 y(n - 2)`, in transposed direct form.
#[derive(Clone, Copy, Debug, Default)]
struct Section {
    a1: f32,
    a2: f32,
    s1: f32,
    s2: f32,
}

impl Section {
    #[inline(always)]
    fn next(&mut self, x: f32) -> f32 {
        let y = x + self.s1;
        self.s1 = self.s2 + self.a1 * y;
        self.s2 = -x - self.a2 * y;
        y
    }
}

/// Generator of band-limited noise.
#[derive(Clone, Debug)]
pub struct Noise {
    white: White,
    sections: [Section; SECTIONS],
    scale: f32,
}

impl Noise {
    /// Builds the generator, and checks the band.
    pub(crate) fn build(config: &Config) -> Result<Self, Error> {
        let sample_hz = f64::from(config.sample_hz);
        let (low, high) = (f64::from(config.drive.noise_band_hz.0), f64::from(config.drive.noise_band_hz.1));
        Drive::NOISE_LOW_HZ.check_within(low, MIN_CORNER_REL * sample_hz, MAX_FREQUENCY_REL * sample_hz)?;
        Drive::NOISE_HIGH_HZ.check_within(high, low * (1.0 + MIN_WIDTH_REL), MAX_FREQUENCY_REL * sample_hz)?;
        let mut noise =
            Noise { white: White::new(config.drive.seed), sections: sections(low / sample_hz, high / sample_hz), scale: 1.0 };
        noise.scale = 1.0 / (CREST_FACTOR * noise.rms());
        Ok(noise)
    }

    /// Fills in the next samples, -1 to 1, where 2^30 is one.
    #[inline(never)]
    pub(crate) fn fill(&mut self, samples: &mut [i32]) {
        // Local copies, so that the whole state is in registers.
        let (mut white, mut sections) = (self.white.clone(), self.sections);
        // A word has twice the scale of a sample, whose conversion saturates beyond two.
        let (scale, one) = (self.scale * 0.5, 1 << 30);
        for place in samples {
            let noise = filter(&mut sections, white.word() as i32 as f32 * scale);
            *place = (noise as i32).clamp(-one, one - 1);
        }
        (self.white, self.sections) = (white, sections);
    }

    /// Returns the rms of the output, from the energy of the impulse response: uniformly
    /// distributed numbers have a mean square of a third.
    fn rms(&self) -> f32 {
        let mut sections = self.sections;
        let response = (0..RESPONSE_SAMPLES).map(|n| filter(&mut sections, if n == 0 { 1.0 } else { 0.0 }));
        fpu::sqrtf(response.map(|y| y * y).sum::<f32>() / 3.0)
    }
}

/// Passes a sample through all sections.
#[inline(always)]
fn filter([a, b, c, d]: &mut [Section; SECTIONS], x: f32) -> f32 {
    d.next(c.next(b.next(a.next(x))))
}

/// Returns the band-pass between two frequencies, cycles a sample.
fn sections(low: f64, high: f64) -> [Section; SECTIONS] {
    // Up to a quarter turn; libm's tangent would take 5 KB more flash.
    let warped = |cycles: f64| 2.0 * sine_of_turns(0.5 * cycles) / sine_of_turns(0.25 - 0.5 * cycles);
    let (width, square) = (warped(high) - warped(low), warped(high) * warped(low));
    let section = |prototype: usize, sign: f64| {
        let (re, im) = PROTOTYPE[prototype];
        let half = Complex64::new(re, im) * (0.5 * width);
        let s = half + root(half * half - square) * sign;
        let z = (Complex64::new(2.0, 0.0) + s) / (Complex64::new(2.0, 0.0) - s);
        Section { a1: (2.0 * z.re) as f32, a2: z.norm_sqr() as f32, ..Section::default() }
    };
    [section(0, 1.0), section(0, -1.0), section(1, 1.0), section(1, -1.0)]
}

/// Returns a square root; every target computes the same bits.
fn root(z: Complex64) -> Complex64 {
    let size = real_root(z.norm_sqr());
    let (re, im) = (real_root(0.5 * (size + z.re)), real_root(0.5 * (size - z.re)));
    Complex64::new(re, if z.im < 0.0 { -im } else { im })
}

/// Returns the square root of a number below 3e38, from 1e-40 to a few units of the last place, and
/// zero below 1e-45. libm's would take half a kilobyte more flash.
fn real_root(x: f64) -> f64 {
    let first = f64::from(fpu::sqrtf(x.max(0.0) as f32));
    // Newton's method doubles the number of right digits.
    let improved = |root: f64| 0.5 * (root + x / root);
    if first > 0.0 { improved(improved(first)) } else { 0.0 }
}

/// Dither: the difference of successive uniformly distributed numbers, triangular within -1 to 1,
/// with less power at low frequencies. Added before rounding, it makes the rounding error
/// independent of the signal.
#[derive(Clone, Debug)]
pub(crate) struct Dither {
    white: White,
    /// Last number.
    last: i32,
}

impl Dither {
    /// Creates a dither.
    pub(crate) fn new(seed: u64) -> Self {
        // A stream other than that of the noise.
        Dither { white: White::new(!seed), last: 0 }
    }

    /// Returns the next two values, codes, with `FRACTION` fraction bits. A random word gives two
    /// numbers, the upper bits of either half. Their mean of a half cancels in the difference.
    #[inline(always)]
    pub(crate) fn take<const FRACTION: u32>(&mut self) -> [i32; 2] {
        let word = self.white.word();
        let (one, other) = (((word & 0xffff) >> (16 - FRACTION)) as i32, (word >> (32 - FRACTION)) as i32);
        let taken = [one - self.last, other - one];
        self.last = other;
        taken
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_root_in_double_precision() {
        for x in (-40..30).flat_map(|n| [1.0, 1.7, 2.9].map(|x| x * libm::pow(10.0, f64::from(n)))) {
            assert!((real_root(x) / libm::sqrt(x) - 1.0).abs() < 5e-16, "{x}");
        }
        assert_eq!((real_root(0.0), real_root(-1e-17)), (0.0, 0.0));
    }

    #[test]
    fn prototype_poles_equal_those_of_libm() {
        for (n, pole) in PROTOTYPE.into_iter().enumerate() {
            let angle = core::f64::consts::PI * (5.0 + 2.0 * n as f64) / 8.0;
            assert_eq!(pole, (libm::cos(angle), libm::sin(angle)));
        }
    }
}
