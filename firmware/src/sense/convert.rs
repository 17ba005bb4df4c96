//! Converter codes to SI and back: the only place that knows what a code is worth.

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
    /// The same for the lock-in.
    fixed: Scale,
    per_lsb: f32,
    max_code: u16,
    /// The largest value that is in order, in SI.
    limit: f32,
    /// How far from the lock-in's zero a code certainly is neither an end of the range nor beyond the limit.
    reach: f32,
    /// Mean square, about the lock-in's zero, below which no block is clipped, if that is all that can be out of order; codes squared.
    unclipped: f32,
    /// Mean square of a fiftieth of the range, codes squared.
    loud: f32,
}

/// What rounding, noise and a small tone may leave, of the range.
const QUIET_PART: f32 = 0.02;
/// The part of a block's codes that may stand at the ends of the converter's range.
pub(crate) const CLIPPED_PART: usize = 8;

impl SenseScale {
    fn build(per_lsb: f32, mid_code: u16, max_code: u16) -> Result<Self, Error> {
        in_range("front_end.sense_mid_code", mid_code.into(), 1.0, f64::from(max_code) - 1.0)?;
        let zero = f32::from(mid_code);
        let fixed = Scale::new(zero, max_code);
        let loud = QUIET_PART * QUIET_PART * f32::from(max_code) * f32::from(max_code);
        let mut scale =
            SenseScale { mid_code, zero, fixed, per_lsb, max_code, limit: f32::INFINITY, reach: 0.0, unclipped: 0.0, loud };
        scale.set_limit(f32::INFINITY);
        Ok(scale)
    }

    /// A phasor in codes, in SI.
    pub fn scale(&self, codes: Phasor) -> Phasor {
        codes * self.per_lsb
    }

    /// Mean of a block, in codes about the present zero, and mean square about that mean. In whole numbers, which are exact.
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

    /// Variance of a phasor that is fitted to `samples` codes of this variance, both components, in SI. Rounding adds a twelfth.
    pub(crate) fn phasor_variance(&self, code_variance: f32, samples: usize) -> f32 {
        4.0 / samples as f32 * (code_variance + 1.0 / 12.0) * self.per_lsb * self.per_lsb
    }

    /// How many codes a value in SI is.
    pub(crate) fn codes(&self, value: f32) -> f32 {
        value / self.per_lsb
    }

    /// Sets the largest value that is in order, in SI.
    pub fn set_limit(&mut self, limit: f32) {
        self.limit = limit;
        let ends = (self.zero - 1.0).min(f32::from(self.max_code) - 1.0 - self.zero);
        self.reach = self.codes(limit).min(ends) - self.fixed.off();
        let end = ends - self.fixed.off();
        self.unclipped = if limit < f32::INFINITY || end < 0.0 { 0.0 } else { end * end / CLIPPED_PART as f32 };
    }

    /// Whether no code of a block can be out of order: of a tone with this square of its amplitude, and with so much energy beside it (both in
    /// codes). `a + e <= reach`, in squares, because a root takes as long as two periods of the lock-in.
    pub(crate) fn holds(&self, amplitude_square: f32, energy: f32) -> bool {
        // What rounding may have taken from the energy.
        let energy = energy + 1e-5 * amplitude_square + 1.0;
        let rest = self.reach * self.reach - amplitude_square - energy;
        self.reach > 0.0 && rest >= 0.0 && rest * rest >= 4.0 * amplitude_square * energy
    }

    /// Whether so little energy, in codes, of so many samples is no clipping, where nothing else can be out of order.
    pub(crate) fn is_unclipped(&self, energy: f32, samples: usize) -> bool {
        energy < self.unclipped * samples as f32
    }

    /// Whether so much energy, in codes, of so many samples is more than that of a fiftieth of the range, rms.
    pub(crate) fn is_loud(&self, energy: f32, samples: usize) -> bool {
        energy > self.loud * samples as f32
    }

    /// Codes about zero in fixed point.
    pub(crate) fn fixed(&self) -> &Scale {
        &self.fixed
    }

    /// The code of zero, with its measured offset.
    pub(crate) fn zero(&self) -> f32 {
        self.zero
    }

    /// The largest code.
    pub(crate) fn max_code(&self) -> u16 {
        self.max_code
    }

    /// How many samples of a block are beyond `limit` (in SI) on either side of zero.
    pub(crate) fn beyond(&self, codes: &Codes, limit: f32) -> usize {
        let limit = self.codes(limit);
        // Conversions cut off, and saturate.
        let (least, most) = (self.zero - limit, (self.zero + limit) as u16);
        outside(codes, least as u16 + u16::from(f32::from(least as u16) < least), most)
    }

    /// Moves the zero by a measured offset, in codes.
    pub fn shift_zero(&mut self, codes: f32) {
        self.set_zero(self.zero + codes);
    }

    /// Forgets measured offsets.
    pub(crate) fn restore_zero(&mut self) {
        self.set_zero(f32::from(self.mid_code));
    }

    fn set_zero(&mut self, zero: f32) {
        self.zero = zero;
        self.fixed = Scale::new(zero, self.max_code);
        self.set_limit(self.limit);
    }

    /// Full scale to one side, in codes.
    pub(crate) fn half_range(&self) -> f32 {
        0.5 * f32::from(self.max_code)
    }

    /// How many samples of a block stand at either end of the converter.
    pub(crate) fn clipped(&self, codes: &Codes) -> usize {
        outside(codes, 1, self.max_code - 1)
    }
}

/// How many codes are not within `least` to `most`, which is not the lesser one.
fn outside(codes: &Codes, least: u16, most: u16) -> usize {
    let beside = |code: &&u16| **code < least || **code > most;
    let count = |codes: &[u16]| codes.iter().filter(beside).count();
    if most > MIDDLE || least > MIDDLE {
        return count(codes);
    }
    // Two at a time, of which bit 15 and bit 31 say that one is beside: what a carry takes from the other half, it takes only with its own bit set.
    let twice = |code: u16| u32::from(code) * 0x1_0001;
    let (above, below) = (twice(MIDDLE - most), twice(MIDDLE + least));
    let bits = |first: u16, second: u16| {
        let both = u32::from(first) | u32::from(second) << 16;
        both.wrapping_add(above) | below.wrapping_sub(both)
    };
    let (eights, rest) = codes.as_chunks::<8>();
    let mut all = count(rest);
    for eight @ [a, b, c, d, e, f, g, h] in eights {
        if (bits(*a, *b) | bits(*c, *d) | bits(*e, *f) | bits(*g, *h)) & twice(MIDDLE + 1) != 0 {
            all += count(eight);
        }
    }
    all
}

/// The largest code whose uppermost bit is free.
const MIDDLE: u16 = 0x7fff;

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
    /// Checks that zero is within the codes.
    pub fn build(front_end: &FrontEnd) -> Result<Self, Error> {
        let sense = |per_lsb| SenseScale::build(per_lsb, front_end.sense_mid_code, front_end.sense_max_code);
        Ok(Convert {
            v: sense(front_end.volt_per_lsb)?,
            i: sense(front_end.ampere_per_lsb)?,
            drive: DriveScale::build(front_end)?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against one comparison after the other, over all codes, also such as no converter has.
    #[test]
    fn codes_outside_are_counted_one_and_all() {
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
        // Whole blocks in order, but for one code.
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
