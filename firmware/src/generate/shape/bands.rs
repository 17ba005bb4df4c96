//! Waveforms of many harmonics, free of aliases: for each band of frequencies a table of one period, the sum of those harmonics that lie
//! below half the sample rate. In fixed point: 16 bits, interpolated to 30.
//!
//! A two-level square sent through a converter at 25 samples a period folds its upper harmonics back into the band: 14 dB below the
//! fundamental, all together. Tables of 1024 entries with linear interpolation are exact to `(2 pi k / 1024)^2 / 8` of harmonic `k`, and to half of
//! 2^-15 of the peak: a sixteenth of the smallest step of a 12-bit converter.
//!
//! A wave of sines is odd, so that half of its period is stored. The other half is read backwards from its end, and turned over: `wave(-phase)`
//! is `-wave(phase)`, with the complement of the phase in place of its opposite, 2^-32 of a turn beside it.
//!
//! Where the frequency moves, the topmost harmonics must neither fold nor jump: they fade as they come near half the sample rate.
//! Between two bands the waveform is a blend of both tables, and the weight depends on nothing but the frequency.

use super::sine::sine_of_turns;
use crate::seam::fixed_point::upper;

/// Entries in a period.
pub(super) const LENGTH: usize = 1 << INDEX_BITS;
const INDEX_BITS: u32 = 10;
const FRACTION_BITS: u32 = 32 - INDEX_BITS;
/// Bits of an entry's fraction, and of the part of the way to the next one.
const ENTRY_BITS: u32 = 15;
const WAY_BITS: u32 = 14;
/// A harmonic is whole up to the first of these frequencies (cycles a sample), and gone from the second on.
const FADE: (f32, f32) = (0.46, 0.5);

/// Entries of half a period, with the first of what follows, for interpolation.
const HALF: usize = LENGTH / 2 + 1;

/// One period of a waveform, by its first half.
#[derive(Debug)]
pub(crate) struct Table {
    /// 2^15 for one, which itself is one less.
    entries: [i16; HALF],
    /// Amplitude of its fundamental.
    fundamental: f32,
}

impl Table {
    /// The waveform at a phase of `phase / 2^32` turns: 2^30 for one.
    #[inline(always)]
    pub(crate) fn at(&self, phase: u32) -> i32 {
        let half = Half::of(phase);
        (self.in_half(half) << 1) ^ half.turned
    }

    /// The same in the first half, whichever it is in, and half of it.
    #[inline(always)]
    fn in_half(&self, half: Half) -> i32 {
        i32::from(self.entries[half.index]) * half.rest + i32::from(self.entries[half.index + 1]) * half.way
    }
}

/// Where a phase is in the first half of a period, or in the second read backwards.
#[derive(Clone, Copy)]
struct Half {
    index: usize,
    /// Part of the way to the next entry, and what is left of it, of 2^14.
    way: i32,
    rest: i32,
    /// All bits of the sign, in the second half.
    turned: i32,
}

impl Half {
    #[inline(always)]
    fn of(phase: u32) -> Self {
        let turned = phase as i32 >> 31;
        let phase = phase ^ turned as u32;
        let index = (phase >> FRACTION_BITS) as usize % (LENGTH / 2);
        let way = (phase >> (FRACTION_BITS - WAY_BITS) & ((1 << WAY_BITS) - 1)) as i32;
        Half { index, way, rest: (1 << WAY_BITS) - way, turned }
    }
}

/// The tables of a waveform.
#[derive(Debug)]
pub struct Bands {
    /// The highest harmonic of each table, rising, and the tables. From one to the next by a tenth at least, so that no two fade at once.
    tables: &'static [(u8, &'static Table)],
    /// The last of them, which there is.
    last: (u8, &'static Table),
}

/// The waveform at one frequency: `lower + weight (upper - lower)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    /// The table with fewer harmonics.
    pub(crate) lower: &'static Table,
    /// The table with more.
    pub(crate) upper: &'static Table,
    /// The weight of the upper, 0 to 1.
    pub(crate) weight: f32,
}

impl Blend {
    /// The weight of the upper table as [`at`](Self::at) multiplies by it: 2^31 for one, which itself is one less.
    #[inline(always)]
    pub(crate) fn weight(&self) -> i32 {
        (self.weight * 2_147_483_648.0) as i32
    }

    /// The waveform at a phase of `phase / 2^32` turns: 2^30 for one.
    #[inline(always)]
    pub(crate) fn at(&self, phase: u32, weight: i32) -> i32 {
        let half = Half::of(phase);
        let (low, high) = (self.lower.in_half(half), self.upper.in_half(half));
        ((low + (upper(high - low, weight) << 1)) << 1) ^ half.turned
    }

    /// Amplitude of the fundamental.
    pub(crate) fn fundamental(&self) -> f32 {
        self.lower.fundamental + self.weight * (self.upper.fundamental - self.lower.fundamental)
    }
}

impl Bands {
    pub(super) const fn new(tables: &'static [(u8, &'static Table)]) -> Self {
        Bands { tables, last: tables[tables.len() - 1] }
    }

    /// The waveform at a frequency, in cycles a sample.
    pub(crate) fn at(&self, cycles_per_sample: f32) -> Blend {
        // Harmonics that are there, if only just; a conversion saturates.
        let there = (FADE.1 / cycles_per_sample) as u32;
        let above = self.tables.iter().position(|&(highest, _)| u32::from(highest) > there).unwrap_or(self.tables.len());
        let at = |n: usize| self.tables.get(n).copied().unwrap_or(self.last);
        let ((_, lower), (highest, upper)) = (at(above.saturating_sub(2)), at(above.saturating_sub(1)));
        let weight = ((FADE.1 - f32::from(highest) * cycles_per_sample) / (FADE.1 - FADE.0)).clamp(0.0, 1.0);
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

/// `p sum_k a(k) sin(2 pi k phase)` of every `every`-th harmonic up to `highest`, `a(k) = 1 / k`, or with falling signs `(-1)^(k + 1) / k`; `p`
/// makes the peak one.
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
        // The other half has the same values with the other sign.
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
        // To the nearest; one itself saturates.
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

    /// Amplitude of harmonic `k` of a blend.
    fn harmonic(blend: &Blend, k: usize) -> f64 {
        let at = |n: usize| {
            let phase = (n << FRACTION_BITS) as u32;
            let (lower, upper) = (f64::from(blend.lower.at(phase)), f64::from(blend.upper.at(phase)));
            (lower + f64::from(blend.weight) * (upper - lower)) / ONE
        };
        2.0 * (0..LENGTH).map(|n| at(n) * SINES[(n * k) % LENGTH]).sum::<f64>() / LENGTH as f64
    }

    #[test]
    fn harmonics_are_those_of_the_waveform_below_half_the_rate() {
        for (bands, even) in [(&square::BANDS, 0.0), (&sawtooth::BANDS, -1.0)] {
            for cycles in [0.001, 0.02, 0.04, 0.0401, 0.046, 0.11, 0.2, 0.4] {
                let blend = bands.at(cycles);
                let fundamental = harmonic(&blend, 1);
                assert!((fundamental - f64::from(blend.fundamental())).abs() < 2e-5, "{cycles}: {fundamental}");
                for k in 2..26 {
                    let expected = if k % 2 == 0 { even / k as f64 } else { 1.0 / k as f64 };
                    let found = harmonic(&blend, k) / fundamental;
                    // What 16 bits leave of rounding, in a single harmonic.
                    if k as f32 * cycles >= FADE.1 {
                        assert!(found.abs() < 3e-6, "{k} of {cycles}: {found}");
                    }
                    // What is below the fade of the next table is whole.
                    if k as f32 * cycles < 0.35 {
                        assert!((found - expected).abs() < 3e-6, "{k} of {cycles}: {found}");
                    }
                }
            }
        }
    }

    #[test]
    fn nothing_jumps_when_the_band_changes() {
        for bands in [&square::BANDS, &sawtooth::BANDS] {
            let mut last: Option<[f64; 25]> = None;
            for n in 0..20_000 {
                let blend = bands.at(0.015 + 0.43 * n as f32 / 20_000.0);
                let harmonics = core::array::from_fn(|k| if n % 20 == 0 { harmonic(&blend, k + 1) } else { 0.0 });
                if n % 20 == 0 {
                    // In a step of 430 Hz at 1 Msps the topmost harmonic moves by up to 11 kHz of the 40 kHz of its fade.
                    let jump = last.map_or(0.0, |last| (0..25).map(|k| (harmonics[k] - last[k]).abs()).fold(0.0, f64::max));
                    assert!(jump < 0.03, "{n}: {jump}");
                    last = Some(harmonics);
                }
            }
        }
    }

    /// Against the sum of sines itself, at phases between the entries and at both ends of either half.
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
                // Of linear interpolation, by the second derivative; and half of 2^-15, or all of it at the peak.
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
