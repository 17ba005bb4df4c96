//! Voltage and current relative to a reference of constant frequency, one phasor per block.
//!
//! ```text
//! X(k) = (2 / N) sum over blocks k - 1 and k of triangle(n) x(n) exp(-j theta(n)),    theta(n) = theta0 + n omega
//! ```
//!
//! The [lock-in](crate::sense::demod) follows the phase of the drive. This filter is linear and the
//! same for every signal. The relation between voltage and current is therefore exactly preserved,
//! and the droop is the same in both. For a tone at the reference, the triangle leaves the image
//!
//! ```text
//! k exp(-2 j theta0) X*,    k = (sin(N omega) / (N sin(omega)))^2
//! ```
//!
//! (L. Fejer 1900), 1.5 % for 32 samples of 40 kHz at 1 MHz. It is subtracted, which leaves little
//! of it in slowly varying signals.
//!
//! If the reference takes at least eight samples a period and a block has an even number of them,
//! the triangle has steps of two samples, which halves the number of partial sums. They move its
//! middle by half a sample: `k` is multiplied by `exp(-j omega) / cos(omega)`. Half of the sample
//! rate away from the reference, 0.7 % of a signal passes (100 samples).

use crate::generate::nco::Stretch;
use crate::generate::shape::sine::{self, Steady};
use crate::seam::block::{MAX_BLOCK_SAMPLES, SenseBlock};
use crate::seam::phasor::Phasor;
use crate::sense::convert::{Convert, SenseScale};
use crate::sense::demod::Sensed;

/// Bits of a code: the sum over a block of the largest codes stays below 2^31.
const CODE_BITS: u32 = 13;
/// Amplitude of the reference.
const REFERENCE_AMPLITUDE: f32 = 2047.0;
/// Bits by which each sum is shifted right before it enters the sum of sums.
const SUM_SHIFT_BITS: u32 = 8;
/// Tuning word from which a triangle with steps of two samples would be too coarse: an eighth of a
/// turn a sample.
const MAX_WORD_OF_PAIRS: u64 = 1 << 61;

/// Reference, and the sums of the rising half of the triangle.
#[derive(Clone, Debug)]
pub(crate) struct Baseband {
    word: u64,
    phase: u64,
    /// Cosine (lower half) and sine of the reference, for a block that starts at phase zero.
    waves: [u32; MAX_BLOCK_SAMPLES],
    unit: Unit,
    /// Image factor `k`.
    image: Phasor,
    /// Normalisation `1 / (1 - |k|^2)`.
    whole: f32,
    rising: Sensed,
}

impl Default for Baseband {
    fn default() -> Self {
        let (waves, unit, rising) = ([0; MAX_BLOCK_SAMPLES], Unit::default(), Sensed::default());
        Baseband { word: 0, phase: 0, waves, unit, image: Phasor::default(), whole: 1.0, rising }
    }
}

impl Baseband {
    /// Sets the tuning word of the reference; [`prepare`](Self::prepare) must follow, then
    /// [`weigh`](Self::weigh). The first phasor lacks its rising half and must be discarded.
    pub(crate) fn restart(&mut self, word: u64) {
        (self.word, self.phase, self.rising) = (word, 0, Sensed::default());
    }

    /// Computes the reference.
    // Not inlined, and in two parts: each takes as long as a block can spare.
    #[inline(never)]
    pub(crate) fn prepare(&mut self) {
        let word = self.word;
        let steady = Steady::new(&Stretch { phase: 0, word, step: 0 });
        let (mut cosine, mut sine) =
            (steady.swing(Phasor::new(0.0, REFERENCE_AMPLITUDE)), steady.swing(Phasor::new(REFERENCE_AMPLITUDE, 0.0)));
        // The conversion truncates, which rounds correctly above zero only.
        let rounded = |x: f32| (x + (4096.0 + 0.5)) as i32 - 4096;
        for wave in &mut self.waves {
            *wave = (rounded(sine.take()) as u32) << 16 | rounded(cosine.take()) as u32 & 0xffff;
        }
    }

    /// Computes moments and image of the reference for blocks of `samples` samples with codes up to
    /// `max_code`.
    #[inline(never)]
    pub(crate) fn weigh(&mut self, samples: usize, max_code: u16) {
        let word = self.word;
        self.unit = Unit::new(self.waves.get(..samples).unwrap_or_default(), max_code, word < MAX_WORD_OF_PAIRS);
        let whole_turn = sine::rotation(word.wrapping_mul(samples as u64)).im;
        let turn = sine::rotation(word);
        let part = whole_turn / (samples.max(1) as f32 * turn.im);
        let square = part * part;
        self.image = Phasor::new(square, if self.unit.pairs { -square * turn.im / turn.re } else { 0.0 });
        self.whole = 1.0 / (1.0 - self.image.norm_sqr());
    }

    /// Processes a block and returns its phasors.
    pub(crate) fn process(&mut self, convert: &Convert, sense: &SenseBlock) -> Sensed {
        let first = sine::rotation(self.phase).conj();
        let of = |codes: &[u16], channel: &SenseScale| {
            let (falling, rising) = self.unit.halves(codes, &self.waves, channel);
            (first * falling, first * rising)
        };
        let ((v_falling, v_rising), (i_falling, i_rising)) = (of(&sense.v, &convert.v), of(&sense.i, &convert.i));
        self.phase = self.phase.wrapping_add(self.word.wrapping_mul(sense.v.len() as u64));
        let image = first * first * self.image;
        let whole = |x: Phasor| (x - x.conj() * image) * self.whole;
        let sensed = Sensed { v: whole(self.rising.v + v_falling), i: whole(self.rising.i + i_falling) };
        self.rising = Sensed { v: v_rising, i: i_rising };
        sensed
    }
}

/// Sum of codes times reference, and the sum of its partial sums after each sample or each second
/// one, which weights the first most; cosine, then sine.
#[derive(Clone, Copy, Debug, Default)]
struct Moments {
    sum: [i32; 2],
    sums: [i32; 2],
}

impl Moments {
    /// Computes the moments of the raw codes of a channel. Without subtraction of the zero, they
    /// can be read and multiplied as half-words, each in one cycle of a Cortex-M4 (`SMLABB`,
    /// `SMLATT`). Codes wider than [`CODE_BITS`] lose their `less` lowest bits.
    #[inline(never)]
    fn new(codes: &[u16], waves: &[u32], unit: &Unit) -> Self {
        if !unit.pairs {
            return sampled(codes, waves, unit.less);
        }
        let mut moments = Moments::default();
        // One pair at a time; more would need additional registers.
        for ([first, second], [wave, next]) in codes.as_chunks::<2>().0.iter().zip(waves.as_chunks::<2>().0) {
            moments.add((*first as i16).into(), *wave);
            moments.add((*second as i16).into(), *next);
            moments.step();
        }
        moments
    }

    #[inline(always)]
    fn add(&mut self, code: i32, wave: u32) {
        self.sum[0] = self.sum[0].wrapping_add(code * i32::from(wave as i16));
        self.sum[1] = self.sum[1].wrapping_add(code * (wave as i32 >> 16));
    }

    #[inline(always)]
    fn step(&mut self) {
        self.sums[0] = self.sums[0].wrapping_add(self.sum[0] >> SUM_SHIFT_BITS);
        self.sums[1] = self.sums[1].wrapping_add(self.sum[1] >> SUM_SHIFT_BITS);
    }
}

/// Computes the moments with a step of the triangle at each sample.
// Not for the fast memory of the board: it is only for odd blocks, wide codes and high frequencies.
#[cold]
#[inline(never)]
fn sampled(codes: &[u16], waves: &[u32], less: u32) -> Moments {
    let mut moments = Moments::default();
    for (code, wave) in codes.iter().zip(waves) {
        moments.add((code >> less).into(), *wave);
        moments.step();
    }
    moments
}

/// Moments of codes of one, for the subtraction of the zero, and constants for a block length.
#[derive(Clone, Copy, Debug, Default)]
struct Unit {
    sum: [i32; 2],
    /// Sum of partial sums, not shifted by [`SUM_SHIFT_BITS`].
    sums: [i32; 2],
    /// Bits of a code above [`CODE_BITS`], which are dropped.
    less: u32,
    /// `true` if the triangle has steps of two samples.
    pairs: bool,
    /// Size of one step of the original code after the shift.
    size: f32,
    /// Factor from a sum of sums to a mean.
    mean: f32,
    /// Factor from a mean to an amplitude.
    amplitude: f32,
}

impl Unit {
    fn new(waves: &[u32], max_code: u16, pairs: bool) -> Self {
        let less = (u16::BITS - max_code.leading_zeros()).saturating_sub(CODE_BITS);
        let pairs = pairs && less == 0 && waves.len().is_multiple_of(2);
        let (mut sum, mut sums, mut steps) = ([0; 2], [0; 2], !pairs);
        for wave in waves {
            sum = [sum[0] + i32::from(*wave as i16), sum[1] + (*wave as i32 >> 16)];
            if steps {
                sums = [sums[0] + sum[0], sums[1] + sum[1]];
            }
            steps = !(steps && pairs);
        }
        let (count, size) = (waves.len().max(1) as f32, 1.0 / (1 << less) as f32);
        Unit {
            sum,
            sums,
            less,
            pairs,
            size,
            mean: ((1 + i32::from(pairs)) << SUM_SHIFT_BITS) as f32 / count,
            amplitude: 2.0 / (count * REFERENCE_AMPLITUDE * size),
        }
    }

    /// Computes the phasors of a channel weighted by the falling and by the rising half of the
    /// triangle, in SI units.
    fn halves(&self, codes: &[u16], waves: &[u32], channel: &SenseScale) -> (Phasor, Phasor) {
        let Moments { sum, sums } = Moments::new(codes, waves, self);
        // Corrects the mean of the dropped bits.
        let zero = (channel.zero() + 0.5) * self.size - 0.5;
        let (whole, part) = (zero as i32, zero - (zero as i32) as f32);
        let about = |n: usize| {
            let sums_of_zero = ((i64::from(whole) * i64::from(self.sums[n])) >> SUM_SHIFT_BITS) as i32;
            (
                sum[n].wrapping_sub(whole.wrapping_mul(self.sum[n])) as f32 - part * self.sum[n] as f32,
                sums[n].wrapping_sub(sums_of_zero) as f32 - part * self.sums[n] as f32 * (1.0 / (1 << SUM_SHIFT_BITS) as f32),
            )
        };
        let ((sum_re, sums_re), (sum_im, sums_im)) = (about(0), about(1));
        // exp(-j theta) has the opposite sign of the sine.
        let sum = Phasor::new(sum_re, -sum_im);
        let falling = Phasor::new(sums_re, -sums_im) * self.mean;
        (channel.scale(falling * self.amplitude), channel.scale((sum - falling) * self.amplitude))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::find::scan::bench::front_end;
    use crate::generate::nco::tuning_word;
    use crate::seam::block::Codes;
    use crate::seam::config::FrontEnd;
    use crate::seam::phasor::magnitude;

    /// Returns the amplitude of a tone at an offset from the reference, over 4 ms.
    fn sensed(hz: f64, reference_hz: f64, offset_hz: f64) -> Phasor {
        sensed_by(&front_end(), 32, 0.0, (hz, reference_hz, offset_hz))
    }

    /// Does the same for another front end and block length, with the zero shifted by `zero_shift`
    /// codes.
    fn sensed_by(
        front_end: &FrontEnd,
        samples: usize,
        zero_shift: f32,
        (hz, reference_hz, offset_hz): (f64, f64, f64),
    ) -> Phasor {
        let mut convert = Convert::build(front_end).unwrap();
        convert.v.shift_zero(zero_shift);
        let (mid, amplitude) =
            (f64::from(front_end.sense_mid_code) + f64::from(zero_shift), 0.73 * f64::from(front_end.sense_mid_code));
        let mut baseband = Baseband::default();
        baseband.restart(tuning_word(reference_hz / 1e6));
        baseband.prepare();
        baseband.weigh(samples, front_end.sense_max_code);
        let (mut sum, blocks) = (Phasor::default(), 4032 / samples);
        for block in 0..blocks {
            let at = |n: usize| (samples * block + n) as f64;
            let wave = |n: usize| amplitude * libm::cos(core::f64::consts::TAU * hz * 1e-6 * at(n));
            let codes: Codes = (0..samples).map(|n| libm::round(mid + wave(n)) as u16).collect();
            let x = baseband.process(&convert, &SenseBlock { v: codes.clone(), i: codes, ..SenseBlock::default() }).v;
            if block > 0 {
                sum += x * sine::rotation(tuning_word((offset_hz * 1e-6 * at(0)).rem_euclid(1.0))).conj();
            }
        }
        sum / ((blocks - 1) as f32 * amplitude as f32 * front_end.volt_per_lsb)
    }

    #[test]
    fn a_tone_at_the_reference_is_one() {
        let x = sensed(40_000.0, 40_000.0, 0.0);
        assert!((x - Phasor::new(1.0, 0.0)).norm_sqr() < 1e-4 * 1e-4, "{x}");
    }

    /// Tests converters of 12, 13 and 16 bits (shifted to 13), several block lengths, low and high
    /// frequencies, and zeros between two codes.
    #[test]
    fn tone_is_one_for_any_converter_and_block_length() {
        for (mid, max) in [(2048, 4095), (4096, 8191), (32_768, 65_535)] {
            let front_end = FrontEnd { sense_mid_code: mid, sense_max_code: max, ..front_end() };
            for samples in [31, 32, 64, 99, 100] {
                for hz in [18_000.0, 40_000.0, 97_000.0, 300_000.0] {
                    for zero_shift in [0.0, 3.3, -150.7] {
                        let x = sensed_by(&front_end, samples, zero_shift, (hz, hz, 0.0));
                        let off = magnitude(x - Phasor::new(1.0, 0.0));
                        assert!(off < 3e-4, "{max} {samples} {hz} {zero_shift}: {x}, {off}");
                    }
                }
            }
        }
    }

    /// Twice 46.875 kHz is three times the block rate, so the image folds onto the other sideband.
    #[test]
    fn an_image_that_folds_into_the_band_is_small() {
        let (there, image) = (sensed(47_875.0, 46_875.0, 1000.0), magnitude(sensed(47_875.0, 46_875.0, -1000.0)));
        // 1.2e-4; a boxcar leaves 1.1 %.
        assert!(magnitude(there) > 0.99 && image < 2e-4, "{there} {image}");
    }
}
