//! The square, band-limited: the sum of its odd harmonics below half the sample rate,
//! `(4 / pi) sum_k sin(2 pi k phase) / k`.
//!
//! A two-level square sent through a DAC at 25 samples a period folds its upper harmonics back, -14 dBc in all. The
//! fundamental is `4 / pi` and the flat tops are one; the ripple beside each edge exceeds them by up to 18 per cent.

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
    let mut n = 0;
    while n <= LENGTH {
        let mut sum = 0.0;
        let mut k = 1;
        while k <= highest {
            sum += sine_of_turns(((n * k) % LENGTH) as f64 / LENGTH as f64) / k as f64;
            k += 2;
        }
        entries[n] = (4.0 * core::f64::consts::FRAC_1_PI * sum) as f32;
        n += 1;
    }
    Table(entries)
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
    fn mean_square_is_that_of_its_harmonics() {
        let table = table(0.04);
        let mean = (0..LENGTH).map(|n| f64::from(table.0[n]).powi(2)).sum::<f64>() / LENGTH as f64;
        let harmonics: f64 = (1..=11).step_by(2).map(|k| 8.0 / (core::f64::consts::PI * f64::from(k)).powi(2)).sum();
        assert!((mean - harmonics).abs() < 1e-6, "{mean} {harmonics}");
    }
}
