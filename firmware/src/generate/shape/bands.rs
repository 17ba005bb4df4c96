//! Waveforms of many harmonics, free of aliases: for each band of frequencies a table of one period, the sum of those harmonics that lie
//! below half the sample rate.
//!
//! A two-level square sent through a converter at 25 samples a period folds its upper harmonics back into the band: 14 dB below the
//! fundamental, all together. Tables of 1024 entries with linear interpolation are exact to `(2 pi k / 1024)^2 / 8` of harmonic `k`.
//!
//! A wave of sines is odd, so that half of its period is stored; one of odd harmonics is its own mirror within that half as well, and a quarter is. What
//! is read is the same to the last bit as in a table of the whole period: mirrored entries have the same bits, and interpolation goes the same way.
//!
//! Where the frequency moves, the topmost harmonics must neither fold nor jump: they fade as they come near half the sample rate.
//! Between two bands the waveform is a blend of both tables, and the weight depends on nothing but the frequency.

use super::sine::sine_of_turns;

/// Entries in a period.
pub(super) const LENGTH: usize = 1 << INDEX_BITS;
const INDEX_BITS: u32 = 10;
const FRACTION_BITS: u32 = 32 - INDEX_BITS;
const FRACTION_SCALE: f32 = 1.0 / (1u32 << FRACTION_BITS) as f32;
/// A harmonic is whole up to the first of these frequencies (cycles a sample), and gone from the second on.
const FADE: (f32, f32) = (0.46, 0.5);

/// Entries of half a period and of a quarter, with the first of what follows, for interpolation.
pub(super) const HALF: usize = LENGTH / 2 + 1;
pub(super) const QUARTER: usize = LENGTH / 4 + 1;

/// The stored part of one period of a waveform.
#[derive(Debug)]
pub(super) struct Part<const N: usize> {
    entries: [f32; N],
    /// Amplitude of its fundamental.
    fundamental: f32,
}

/// One period of a waveform, by the part of it that is stored.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Table {
    entries: &'static [f32],
    fundamental: f32,
}

impl<const N: usize> Part<N> {
    /// The period that this is the half or the quarter of.
    pub(super) const fn table(&'static self) -> Table {
        assert!(N == HALF || N == QUARTER);
        Table { entries: &self.entries, fundamental: self.fundamental }
    }
}

impl Table {
    /// The waveform at a phase of `phase / 2^32` turns.
    #[inline]
    pub(crate) fn at(&self, phase: u32) -> f32 {
        let index = (phase >> FRACTION_BITS) as usize;
        let fraction = (phase & ((1 << FRACTION_BITS) - 1)) as f32 * FRACTION_SCALE;
        let within = index & (LENGTH / 2 - 1);
        // The second half of a period, or the second quarter of each half, is read from its end.
        let mirrored = index & (self.entries.len() - 1) != 0;
        let (here, next) = if mirrored { (LENGTH / 2 - within, LENGTH / 2 - 1 - within) } else { (within, within + 1) };
        let entry = |place: usize| self.entries.get(place).copied().unwrap_or(0.0);
        let (here, next) = (entry(here), entry(next));
        let value = here + (next - here) * fraction;
        if index & (LENGTH / 2) != 0 { -value } else { value }
    }
}

/// The tables of a waveform.
#[derive(Debug)]
pub struct Bands {
    /// The highest harmonic of each table, rising, and the tables. From one to the next by a tenth at least, so that no two fade at once.
    tables: &'static [(u8, Table)],
}

/// The waveform at one frequency: `lower + weight (upper - lower)`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Blend {
    /// The table with fewer harmonics.
    pub(crate) lower: Table,
    /// The table with more.
    pub(crate) upper: Table,
    /// The weight of the upper, 0 to 1.
    pub(crate) weight: f32,
}

impl Blend {
    /// Amplitude of the fundamental.
    pub(crate) fn fundamental(&self) -> f32 {
        self.lower.fundamental + self.weight * (self.upper.fundamental - self.lower.fundamental)
    }
}

impl Bands {
    pub(super) const fn new(tables: &'static [(u8, Table)]) -> Self {
        Bands { tables }
    }

    /// The waveform at a frequency, in cycles a sample.
    pub(crate) fn at(&self, cycles_per_sample: f32) -> Blend {
        let (_, fundamental) = self.tables[0];
        let mut blend = Blend { lower: fundamental, upper: fundamental, weight: 0.0 };
        for &(highest, table) in self.tables {
            let weight = ((FADE.1 - f32::from(highest) * cycles_per_sample) / (FADE.1 - FADE.0)).clamp(0.0, 1.0);
            if weight == 0.0 {
                break;
            }
            blend = Blend { lower: blend.upper, upper: table, weight };
        }
        blend
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
/// makes the peak one. Of the first `N` entries.
pub(super) const fn additive<const N: usize>(highest: usize, every: usize, alternating: bool) -> Part<N> {
    // A quarter is all there is of odd harmonics only.
    assert!(N == HALF || N == QUARTER && every == 2);
    let mut sums = [0.0; N];
    let mut peak = 0.0;
    let mut n = 0;
    while n < N {
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
    let mut entries = [0.0; N];
    n = 0;
    while n < N {
        entries[n] = (sums[n] / peak) as f32;
        n += 1;
    }
    Part { entries, fundamental: (1.0 / peak) as f32 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::shape::{sawtooth, square};

    /// Amplitude of harmonic `k` of a blend.
    fn harmonic(blend: &Blend, k: usize) -> f64 {
        let at = |n: usize| {
            let phase = (n << FRACTION_BITS) as u32;
            let (lower, upper) = (blend.lower.at(phase), blend.upper.at(phase));
            f64::from(lower + blend.weight * (upper - lower))
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
                    if k as f32 * cycles >= FADE.1 {
                        assert!(found.abs() < 1e-6, "{k} of {cycles}: {found}");
                    }
                    // What is below the fade of the next table is whole.
                    if k as f32 * cycles < 0.35 {
                        assert!((found - expected).abs() < 1e-6, "{k} of {cycles}: {found}");
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

    /// By a table of the whole period, as the definition has it.
    #[test]
    fn a_part_reads_as_the_whole_period_to_the_last_bit() {
        for (bands, every, alternating) in [(&square::BANDS, 2, false), (&sawtooth::BANDS, 1, true)] {
            for &(highest, table) in bands.tables {
                let sum = |n: usize| {
                    (1..=usize::from(highest)).step_by(every).fold(0.0, |sum, k| {
                        let term = SINES[(n * k) % LENGTH] / k as f64;
                        sum + if alternating && k % 2 == 0 { -term } else { term }
                    })
                };
                let sums: std::vec::Vec<f64> = (0..=LENGTH).map(sum).collect();
                let peak = sums.iter().copied().fold(0.0, f64::max);
                let entry = |n: usize| (sums[n] / peak) as f32;
                for phase in (0..1 << 18).map(|n: u32| n << 14 | n & 0x3fff) {
                    let (index, fraction) = ((phase >> FRACTION_BITS) as usize, phase & ((1 << FRACTION_BITS) - 1));
                    let whole = entry(index) + (entry(index + 1) - entry(index)) * (fraction as f32 * FRACTION_SCALE);
                    // Two zeros are equal, whatever their signs; no other two numbers are.
                    assert_eq!(table.at(phase), whole, "{highest} at {phase:#x}");
                }
                assert_eq!(table.fundamental, (1.0 / peak) as f32);
            }
        }
    }

    #[test]
    fn the_peak_is_one() {
        for bands in [&square::BANDS, &sawtooth::BANDS] {
            for (highest, table) in bands.tables {
                let peak = table.entries.iter().fold(0.0f32, |peak, x| peak.max(x.abs()));
                assert_eq!(peak, 1.0, "{highest}");
            }
        }
    }
}
