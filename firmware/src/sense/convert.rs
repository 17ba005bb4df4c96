//! Conversion between converter codes and SI units; the only place that knows the value of a code.

use crate::generate::drive_scale::DriveScale;
use crate::seam::block::Codes;
use crate::seam::config::FrontEnd;
use crate::seam::error::{Error, in_range};
use crate::seam::phasor::Phasor;
use crate::sense::resonator::Scale;

/// One sense channel: `x = (code - zero) * per_lsb`.
#[derive(Clone, Debug)]
pub struct SenseScale {
    mid_code: u16,
    zero: f32,
    /// Fixed-point scale for the lock-in.
    fixed: Scale,
    per_lsb: f32,
    max_code: u16,
    /// Maximum permitted value, in SI units.
    limit: f32,
    /// Distance from the zero of the lock-in within which a code is certainly not clipped nor
    /// beyond the limit, codes.
    reach: f32,
    /// Mean square around the zero of the lock-in below which a block cannot be clipped, codes
    /// squared; zero if a limit is set.
    unclipped: f32,
    /// Square of a fiftieth of the range, codes squared.
    large_square: f32,
}

/// Maximum rms residual from rounding, noise and a small tone, relative to the range.
const QUIET_PART: f32 = 0.02;
/// Inverse of the part of the codes of a block that may be at the ends of the range.
pub(crate) const CLIPPED_PART: usize = 8;

impl SenseScale {
    fn build(per_lsb: f32, mid_code: u16, max_code: u16) -> Result<Self, Error> {
        in_range("front_end.sense_mid_code", mid_code.into(), 1.0, f64::from(max_code) - 1.0)?;
        let zero = f32::from(mid_code);
        let fixed = Scale::new(zero, max_code);
        let large_square = QUIET_PART * QUIET_PART * f32::from(max_code) * f32::from(max_code);
        let mut scale = SenseScale {
            mid_code,
            zero,
            fixed,
            per_lsb,
            max_code,
            limit: f32::INFINITY,
            reach: 0.0,
            unclipped: 0.0,
            large_square,
        };
        scale.set_limit(f32::INFINITY);
        Ok(scale)
    }

    /// Returns a code relative to the nominal middle.
    #[inline]
    fn centred(&self, code: u16) -> i32 {
        i32::from(code) - i32::from(self.mid_code)
    }

    /// Converts a phasor from codes to SI units.
    pub fn scale(&self, codes: Phasor) -> Phasor {
        codes * self.per_lsb
    }

    /// Computes the mean of a block relative to the present zero, codes, and the mean square
    /// deviation from that mean, codes squared. The integer sums are exact.
    pub(crate) fn mean_and_variance(&self, codes: &Codes) -> (f32, f32) {
        let (count, mid) = (codes.len().max(1) as i64, i32::from(self.mid_code));
        let (mut sum, mut squares) = (0i32, 0i64);
        for &code in codes {
            let code = i32::from(code) - mid;
            sum += code;
            squares += i64::from(code) * i64::from(code);
        }
        let scatter = count * squares - i64::from(sum) * i64::from(sum);
        let count = count as f32;
        (sum as f32 / count + (mid as f32 - self.zero), scatter as f32 / (count * count))
    }

    /// Computes the variance (both components, SI units) of a phasor fitted to `samples` codes of
    /// variance `code_variance`. Rounding adds a twelfth.
    pub(crate) fn phasor_variance(&self, code_variance: f32, samples: usize) -> f32 {
        4.0 / samples as f32 * (code_variance + 1.0 / 12.0) * self.per_lsb * self.per_lsb
    }

    /// Converts a value from SI units to codes.
    pub(crate) fn codes(&self, value: f32) -> f32 {
        value / self.per_lsb
    }

    /// Sets the maximum permitted value, in SI units.
    pub fn set_limit(&mut self, limit: f32) {
        self.limit = limit;
        let ends = (self.zero - 1.0).min(f32::from(self.max_code) - 1.0 - self.zero);
        self.reach = self.codes(limit).min(ends) - self.fixed.zero_error();
        let end = ends - self.fixed.zero_error();
        self.unclipped = if limit < f32::INFINITY || end < 0.0 { 0.0 } else { end * end / CLIPPED_PART as f32 };
    }

    /// Returns `true` if no code of a block can be clipped or beyond the limit, for a tone with
    /// this squared amplitude and this unexplained energy, both in codes squared. Tests
    /// `a + e <= reach` with squares, because a square root takes as long as two periods of the
    /// lock-in.
    pub(crate) fn holds(&self, amplitude_square: f32, energy: f32) -> bool {
        // Rounding may have reduced the energy.
        let energy = energy + 1e-5 * amplitude_square + 1.0;
        let rest = self.reach * self.reach - amplitude_square - energy;
        self.reach > 0.0 && rest >= 0.0 && rest * rest >= 4.0 * amplitude_square * energy
    }

    /// Returns `true` if the energy of `samples` samples, codes squared, is too small for a clipped
    /// block, and no limit is set.
    pub(crate) fn is_unclipped(&self, energy: f32, samples: usize) -> bool {
        energy < self.unclipped * samples as f32
    }

    /// Returns `true` if the rms of `samples` samples with this energy, codes squared, exceeds a
    /// fiftieth of the range.
    pub(crate) fn is_large(&self, energy: f32, samples: usize) -> bool {
        energy > self.large_square * samples as f32
    }

    /// Returns the fixed-point scale of codes around zero.
    pub(crate) fn fixed(&self) -> &Scale {
        &self.fixed
    }

    /// Returns the code of zero, including its measured offset.
    pub(crate) fn zero(&self) -> f32 {
        self.zero
    }

    /// Returns the maximum code.
    pub(crate) fn max_code(&self) -> u16 {
        self.max_code
    }

    /// Counts the samples of a block beyond `limit`, SI units, on either side of zero.
    pub(crate) fn beyond(&self, codes: &Codes, limit: f32) -> usize {
        let limit = self.codes(limit);
        // Casts truncate and saturate.
        let (least, most) = (self.zero - limit, (self.zero + limit) as u16);
        outside(codes, least as u16 + u16::from(f32::from(least as u16) < least), most)
    }

    /// Shifts the zero by a measured offset, codes.
    pub fn shift_zero(&mut self, codes: f32) {
        self.set_zero(self.zero + codes);
    }

    /// Removes measured offsets.
    pub(crate) fn restore_zero(&mut self) {
        self.set_zero(f32::from(self.mid_code));
    }

    fn set_zero(&mut self, zero: f32) {
        self.zero = zero;
        self.fixed = Scale::new(zero, self.max_code);
        self.set_limit(self.limit);
    }

    /// Returns half the range, codes.
    pub(crate) fn half_range(&self) -> f32 {
        0.5 * f32::from(self.max_code)
    }

    /// Counts the samples of a block at either end of the range.
    pub(crate) fn clipped(&self, codes: &Codes) -> usize {
        outside(codes, 1, self.max_code - 1)
    }
}

/// Counts the codes below `least` or above `most`; `least` must not exceed `most`.
fn outside(codes: &Codes, least: u16, most: u16) -> usize {
    let is_outside = |code: &&u16| **code < least || **code > most;
    let count = |codes: &[u16]| codes.iter().filter(is_outside).count();
    if most > MAX_CLEAR_TOP_BIT || least > MAX_CLEAR_TOP_BIT {
        return count(codes);
    }
    // Two codes at a time: bit 15 or 31 is set if one is outside. A carry between the halves needs
    // such a bit.
    let twice = |code: u16| u32::from(code) * 0x1_0001;
    let (above, below) = (twice(MAX_CLEAR_TOP_BIT - most), twice(MAX_CLEAR_TOP_BIT + least));
    let bits = |first: u16, second: u16| {
        let both = u32::from(first) | u32::from(second) << 16;
        both.wrapping_add(above) | below.wrapping_sub(both)
    };
    let (eights, rest) = codes.as_chunks::<8>();
    let mut all = count(rest);
    for eight @ [a, b, c, d, e, f, g, h] in eights {
        if (bits(*a, *b) | bits(*c, *d) | bits(*e, *f) | bits(*g, *h)) & twice(MAX_CLEAR_TOP_BIT + 1) != 0 {
            all += count(eight);
        }
    }
    all
}

/// Maximum code with a clear top bit.
const MAX_CLEAR_TOP_BIT: u16 = 0x7fff;

/// All converters of the front end.
#[derive(Clone, Debug)]
pub struct Convert {
    /// Scale of the voltage channel.
    pub v: SenseScale,
    /// Scale of the current channel.
    pub i: SenseScale,
    /// Scale of the drive converters.
    pub drive: DriveScale,
}

impl Convert {
    /// Checks that zero is within the range and creates the scales.
    pub fn build(front_end: &FrontEnd) -> Result<Self, Error> {
        let sense = |per_lsb| SenseScale::build(per_lsb, front_end.sense_mid_code, front_end.sense_max_code);
        Ok(Convert {
            v: sense(front_end.volt_per_lsb)?,
            i: sense(front_end.ampere_per_lsb)?,
            drive: DriveScale::build(front_end)?,
        })
    }

    /// Computes the mean of voltage times current over the samples of a block, W: the electrical
    /// power of any waveform. The integer sums are exact.
    // Not inlined: the fast memory of a board has no room for it.
    #[inline(never)]
    pub(crate) fn mean_power(&self, v: &Codes, i: &Codes) -> f32 {
        let (mut products, mut v_sum, mut i_sum) = (0i64, 0i32, 0i32);
        for (&v, &i) in v.iter().zip(i) {
            let (v, i) = (self.v.centred(v), self.i.centred(i));
            products += i64::from(v) * i64::from(i);
            (v_sum, i_sum) = (v_sum + v, i_sum + i);
        }
        let count = v.len().min(i.len()).max(1) as f32;
        let zero = |channel: &SenseScale| channel.zero - f32::from(channel.mid_code);
        let (v_zero, i_zero) = (zero(&self.v), zero(&self.i));
        let codes = (products as f32 - v_zero * i_sum as f32 - i_zero * v_sum as f32) / count + v_zero * i_zero;
        codes * self.v.per_lsb * self.i.per_lsb
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with a simple count, over all codes, including codes that no converter has.
    #[test]
    fn all_codes_outside_are_counted() {
        let mut random = 1u64;
        let mut next = |most: u64| {
            random = random.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
            (((random >> 33) * most) >> 31) as u16
        };
        let mut seen = [0; 3];
        for trial in 0..200_000 {
            let range = [0x1000, 0x2000, 0x8000, 0x1_0000][trial % 4];
            let (one, other) = (next(range), next(range));
            let (least, most) = (one.min(other), one.max(other));
            let codes: Codes = (0..8 + trial % 90).map(|_| next(if trial % 3 == 0 { 0x1_0000 } else { range })).collect();
            let expected = codes.iter().filter(|&&code| code < least || code > most).count();
            assert_eq!(outside(&codes, least, most), expected, "{least} to {most}: {codes:?}");
            seen[if expected == 0 {
                0
            } else if expected < codes.len() {
                1
            } else {
                2
            }] += 1;
        }
        assert!(seen[1] > 100_000 && seen[2] > 100, "{seen:?}");
        // Blocks with a single code outside.
        for at in 0..32 {
            let mut codes: Codes = core::iter::repeat_n(4096, 32).collect();
            assert_eq!(outside(&codes, 1, 8190), 0);
            for code in [0, 8191, 0x7fff, 0x8000, 0x9000, 0xffff] {
                codes[at] = code;
                assert_eq!(outside(&codes, 1, 8190), 1, "{code} at {at}");
            }
        }
    }
}
