//! Waveforms of many harmonics without aliases: for each band of frequencies a table of one period,
//! the sum of the harmonics below half the sample rate. In fixed point: 16 bits, interpolated to
//! 30.
//!
//! A two-level square sent through a converter at 25 samples a period folds its upper harmonics
//! back into the band: in total 14 dB below the fundamental. Tables of 1024 entries with linear
//! interpolation are exact to `(2 pi k / 1024)^2 / 8` of harmonic `k`, and to half of 2^-15 of the
//! peak: a sixteenth of the smallest step of a 12-bit converter.
//!
//! A sum of sines is odd, so that half of its period is stored. The other half is read backwards
//! from its end and negated, because `wave(-phase)` is `-wave(phase)`. The complement of the phase
//! replaces its negative, which is an error of 2^-32 turns.
//!
//! When the frequency changes, the topmost harmonics must neither fold nor jump: they fade as they
//! approach half the sample rate. Between two bands the waveform is a blend of both tables, and the
//! weight depends only on the frequency.

use super::sine::sine_of_turns;
use crate::seam::fixed_point::upper;

/// Number of entries in a period.
pub(super) const LENGTH: usize = 1 << INDEX_BITS;
const INDEX_BITS: u32 = 10;
const FRACTION_BITS: u32 = 32 - INDEX_BITS;
/// Number of fraction bits of an entry.
const ENTRY_BITS: u32 = 15;
/// Number of bits of the interpolation between two entries.
const INTERPOLATION_BITS: u32 = 14;
/// Frequency up to which a harmonic has its full amplitude, cycles a sample.
const FADE_START: f32 = 0.46;
/// Frequency from which a harmonic has faded out, cycles a sample.
const FADE_END: f32 = 0.5;

/// Number of stored entries: half a period, and the next one for interpolation.
const HALF: usize = LENGTH / 2 + 1;

/// One period of a waveform, stored as its first half.
#[derive(Debug)]
pub(crate) struct Table {
    /// 2^15 for one; one itself is stored as 2^15 - 1.
    entries: [i16; HALF],
    /// Amplitude of the fundamental.
    fundamental: f32,
}

impl Table {
    /// Returns the waveform at a phase of `phase / 2^32` turns: 2^30 for one.
    #[inline(always)]
    pub(crate) fn at(&self, phase: u32) -> i32 {
        let half = Half::from_phase(phase);
        (self.in_half(half) << 1) ^ half.turned
    }

    /// Returns half of the waveform's value at a place in the stored half.
    #[inline(always)]
    fn in_half(&self, half: Half) -> i32 {
        i32::from(self.entries[half.index]) * half.rest + i32::from(self.entries[half.index + 1]) * half.way
    }
}

/// Place of a phase in the stored half, which the second half of a period reads backwards.
#[derive(Clone, Copy)]
struct Half {
    index: usize,
    /// Part of the way to the next entry, of 2^14.
    way: i32,
    /// Remaining part of the way, of 2^14.
    rest: i32,
    /// All bits set in the second half, none in the first.
    turned: i32,
}

impl Half {
    #[inline(always)]
    fn from_phase(phase: u32) -> Self {
        let turned = phase as i32 >> 31;
        let phase = phase ^ turned as u32;
        let index = (phase >> FRACTION_BITS) as usize % (LENGTH / 2);
        let way = (phase >> (FRACTION_BITS - INTERPOLATION_BITS) & ((1 << INTERPOLATION_BITS) - 1)) as i32;
        Half { index, way, rest: (1 << INTERPOLATION_BITS) - way, turned }
    }
}

/// Tables of a waveform.
#[derive(Debug)]
pub struct Bands {
    /// Highest harmonic of each table, rising, and the table. Each is above the one before by a
    /// tenth at least, so that no two fade at once.
    tables: &'static [(u8, &'static Table)],
    /// The last of them, which always exists.
    last: (u8, &'static Table),
}

/// Waveform at one frequency: `lower + weight (upper - lower)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    /// Table with fewer harmonics.
    pub(crate) lower: &'static Table,
    /// Table with more harmonics.
    pub(crate) upper: &'static Table,
    /// Weight of the upper table, 0 to 1.
    pub(crate) weight: f32,
}

impl Blend {
    /// Returns the weight of the upper table as a factor for [`at`](Self::at): 2^31 for one, which
    /// itself becomes 2^31 - 1.
    #[inline(always)]
    pub(crate) fn weight(&self) -> i32 {
        (self.weight * 2_147_483_648.0) as i32
    }

    /// Returns the waveform at a phase of `phase / 2^32` turns: 2^30 for one.
    #[inline(always)]
    pub(crate) fn at(&self, phase: u32, weight: i32) -> i32 {
        let half = Half::from_phase(phase);
        let (low, high) = (self.lower.in_half(half), self.upper.in_half(half));
        ((low + (upper(high - low, weight) << 1)) << 1) ^ half.turned
    }

    /// Returns the amplitude of the fundamental.
    pub(crate) fn fundamental(&self) -> f32 {
        self.lower.fundamental + self.weight * (self.upper.fundamental - self.lower.fundamental)
    }
}

impl Bands {
    pub(super) const fn new(tables: &'static [(u8, &'static Table)]) -> Self {
        Bands { tables, last: tables[tables.len() - 1] }
    }

    /// Returns the waveform at a frequency, cycles a sample.
    // Inlined, so that it is in the fast memory of a board like its caller.
    #[inline(always)]
    pub(crate) fn at(&self, cycles_per_sample: f32) -> Blend {
        // The highest harmonic that has not faded out completely; the conversion saturates.
        let there = (FADE_END / cycles_per_sample) as u32;
        let above = self.tables.iter().position(|&(highest, _)| u32::from(highest) > there).unwrap_or(self.tables.len());
        let at = |n: usize| self.tables.get(n).copied().unwrap_or(self.last);
        let ((_, lower), (highest, upper)) = (at(above.saturating_sub(2)), at(above.saturating_sub(1)));
        let weight = ((FADE_END - f32::from(highest) * cycles_per_sample) / (FADE_END - FADE_START)).clamp(0.0, 1.0);
        Blend { lower, upper, weight }
    }
}

/// Sines of equal parts of a turn.
const SINES: [f64; LENGTH] = {
    let mut sines = [0.0; LENGTH];
    let mut n = 0;
    while n < LENGTH {
        sines[n] = sine_of_turns(n as f64 / LENGTH as f64);
        n += 1;
    }
    sines
};

/// Returns the table of `p sum_k a(k) sin(2 pi k phase)` over every `every`-th harmonic up to
/// `highest`. `a(k)` is `1 / k`, or `(-1)^(k + 1) / k` if `alternating`; `p` makes the peak one.
pub(super) const fn additive(highest: usize, every: usize, alternating: bool) -> Table {
    let mut sums = [0.0; HALF];
    let mut peak = 0.0;
    let mut n = 0;
    while n < HALF {
        let mut sum = 0.0;
        let mut k = 1;
        while k <= highest {
            let term = SINES[(n * k) % LENGTH] / k as f64;
            sum += if alternating && k % 2 == 0 { -term } else { term };
            k += every;
        }
        sums[n] = sum;
        // The other half has the same values with the opposite sign.
        let size = if sum < 0.0 { -sum } else { sum };
        if size > peak {
            peak = size;
        }
        n += 1;
    }
    let one = (1i32 << ENTRY_BITS) as f64;
    let mut entries = [0; HALF];
    n = 0;
    while n < HALF {
        let entry = sums[n] / peak * one;
        // Rounded to the nearest; one itself saturates.
        entries[n] = (entry + if entry < 0.0 { -0.5 } else { 0.5 }) as i16;
        n += 1;
    }
    Table { entries, fundamental: (1.0 / peak) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::shape::{sawtooth, square};

    const ONE: f64 = 1_073_741_824.0;

    /// Returns the amplitude of harmonic `k` of a blend.
    fn harmonic(blend: &Blend, k: usize) -> f64 {
        let at = |n: usize| {
            let phase = (n << FRACTION_BITS) as u32;
            let (lower, upper) = (f64::from(blend.lower.at(phase)), f64::from(blend.upper.at(phase)));
            (lower + f64::from(blend.weight) * (upper - lower)) / ONE
        };
        2.0 * (0..LENGTH).map(|n| at(n) * SINES[(n * k) % LENGTH]).sum::<f64>() / LENGTH as f64
    }

    #[test]
    fn harmonics_below_half_the_sample_rate_are_exact() {
        for (bands, even) in [(&square::BANDS, 0.0), (&sawtooth::BANDS, -1.0)] {
            for cycles in [0.001, 0.02, 0.04, 0.0401, 0.046, 0.11, 0.2, 0.4] {
                let blend = bands.at(cycles);
                let fundamental = harmonic(&blend, 1);
                assert!((fundamental - f64::from(blend.fundamental())).abs() < 2e-5, "{cycles}: {fundamental}");
                for k in 2..26 {
                    let expected = if k % 2 == 0 { even / k as f64 } else { 1.0 / k as f64 };
                    let found = harmonic(&blend, k) / fundamental;
                    // The bound is the rounding to 16 bits, in a single harmonic.
                    if k as f32 * cycles >= FADE_END {
                        assert!(found.abs() < 3e-6, "{k} of {cycles}: {found}");
                    }
                    // A harmonic below the fade of the next table has its full amplitude.
                    if k as f32 * cycles < 0.35 {
                        assert!((found - expected).abs() < 3e-6, "{k} of {cycles}: {found}");
                    }
                }
            }
        }
    }

    #[test]
    fn harmonics_are_continuous_when_the_band_changes() {
        for bands in [&square::BANDS, &sawtooth::BANDS] {
            let mut last: Option<[f64; 25]> = None;
            for n in 0..20_000 {
                let blend = bands.at(0.015 + 0.43 * n as f32 / 20_000.0);
                let harmonics = core::array::from_fn(|k| if n % 20 == 0 { harmonic(&blend, k + 1) } else { 0.0 });
                if n % 20 == 0 {
                    // In a step of 430 Hz at 1 Msps the topmost harmonic moves by up to 11 kHz of
                    // the 40 kHz of its fade.
                    let jump = last.map_or(0.0, |last| (0..25).map(|k| (harmonics[k] - last[k]).abs()).fold(0.0, f64::max));
                    assert!(jump < 0.03, "{n}: {jump}");
                    last = Some(harmonics);
                }
            }
        }
    }

    /// Compares with the sum of sines, at phases between the entries and at both ends of either
    /// half.
    #[test]
    fn a_wave_is_the_sum_of_its_harmonics() {
        for (bands, every, alternating) in [(&square::BANDS, 2, false), (&sawtooth::BANDS, 1, true)] {
            for &(highest, table) in bands.tables {
                let sum = |turns: f64| {
                    (1..=usize::from(highest)).step_by(every).fold(0.0, |sum, k| {
                        let term = libm::sin(core::f64::consts::TAU * turns * k as f64) / k as f64;
                        sum + if alternating && k % 2 == 0 { -term } else { term }
                    })
                };
                let peak = (0..=LENGTH).map(|n| sum(n as f64 / LENGTH as f64)).fold(0.0, f64::max);
                // Error of linear interpolation, from the second derivative; and half of 2^-15, or
                // all of it at the peak.
                let squares = (1..=usize::from(highest)).step_by(every).map(|k| k as f64).sum::<f64>();
                let step = core::f64::consts::TAU / LENGTH as f64;
                let bound = step * step / 8.0 * squares / peak + 1.0 / 32_768.0;
                let phases =
                    (0..1 << 14).map(|n: u32| n << 18 | n << 4).chain([0, 1, u32::MAX, 1 << 31, (1 << 31) - 1, (1 << 31) + 1]);
                let worst = phases.fold(0.0, |worst: f64, phase| {
                    let found = f64::from(table.at(phase)) / ONE;
                    worst.max((found - sum(f64::from(phase) / 4_294_967_296.0) / peak).abs())
                });
                assert!(worst < bound && worst > 0.2 * bound, "{highest}: {worst} of {bound}");
            }
        }
    }

    #[test]
    fn the_peak_is_one() {
        for bands in [&square::BANDS, &sawtooth::BANDS] {
            for (highest, table) in bands.tables {
                let peak = table.entries.iter().fold(0, |peak, x| peak.max(x.abs()));
                assert_eq!(peak, i16::MAX, "{highest}");
            }
        }
    }
}
