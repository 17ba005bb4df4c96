//! The square, band-limited: the sum of its odd harmonics below half the sample rate,
//! `p sum_k sin(2 pi k phase) / k`, scaled to a peak of one.
//!
//! A two-level square sent through a DAC at 25 samples a period folds its upper harmonics back into the band. The peaks are the
//! ripple beside each edge; the tops lie 15 per cent below them, and the fundamental is 1.08 with eleven harmonics.

use super::sine::sine_of_turns;
use super::{LENGTH, Table};

/// The highest harmonic that has a table. A lower drive frequency would have room for more.
const HIGHEST_HARMONIC: usize = 11;

static TABLES: [Table; HIGHEST_HARMONIC.div_ceil(2)] = [up_to(1), up_to(3), up_to(5), up_to(7), up_to(9), up_to(11)];

/// The table with all harmonics of `cycles_per_sample` that lie below half the sample rate, up to the eleventh.
pub(super) fn table(cycles_per_sample: f32) -> &'static Table {
    // Counted upwards, not divided: the frequency may be zero.
    let odd_below_half = (1..).step_by(2).take_while(|&k| k as f32 * cycles_per_sample < 0.5 && k <= HIGHEST_HARMONIC).count();
    &TABLES[odd_below_half.saturating_sub(1)]
}

const fn up_to(highest: usize) -> Table {
    let mut entries = [0.0; LENGTH + 1];
    let mut peak = 0.0;
    let mut n = 0;
    while n <= LENGTH {
        let mut sum = 0.0;
        let mut k = 1;
        while k <= highest {
            sum += sine_of_turns(((n * k) % LENGTH) as f64 / LENGTH as f64) / k as f64;
            k += 2;
        }
        entries[n] = sum;
        if sum > peak {
            peak = sum;
        }
        n += 1;
    }
    let mut scaled = [0.0; LENGTH + 1];
    n = 0;
    while n <= LENGTH {
        scaled[n] = (entries[n] / peak) as f32;
        n += 1;
    }
    Table(scaled)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn harmonics_stop_below_half_the_sample_rate() {
        let same = |a: &Table, b: &Table| core::ptr::eq(a, b);
        assert!(same(table(0.04), &TABLES[5]));
        assert!(same(table(0.046), &TABLES[4]));
        assert!(same(table(0.2), &TABLES[0]));
        assert!(same(table(0.0), &TABLES[5]));
    }

    #[test]
    fn peak_is_one_and_the_rest_are_its_harmonics() {
        let table = table(0.04);
        let peak = table.0.iter().fold(0.0f32, |peak, x| peak.max(x.abs()));
        assert_eq!(peak, 1.0);
        // Parseval: mean square over square of the fundamental is half the sum of 1 / k^2.
        let sum = |f: &dyn Fn(usize) -> f64| (0..LENGTH).map(f).sum::<f64>() / LENGTH as f64;
        let mean_square = sum(&|n| f64::from(table.0[n]).powi(2));
        let fundamental = 2.0 * sum(&|n| f64::from(table.0[n]) * sine_of_turns(n as f64 / LENGTH as f64));
        let harmonics: f64 = (1..=11).step_by(2).map(|k| 0.5 / f64::from(k * k)).sum();
        assert!((mean_square / fundamental.powi(2) - harmonics).abs() < 1e-6, "{mean_square} {fundamental}");
        assert!((1.07..1.09).contains(&fundamental), "{fundamental}");
    }
}
