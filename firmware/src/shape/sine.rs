//! The sine, and with it every rotation the controller needs.

use super::{LENGTH, Table};
use crate::phasor::Phasor;

/// One period of the sine.
pub static TABLE: Table = {
    let mut entries = [0.0; LENGTH + 1];
    let mut n = 0;
    while n <= LENGTH {
        entries[n] = sine_of_turns(n as f64 / LENGTH as f64) as f32;
        n += 1;
    }
    Table(entries)
};

/// `exp(j 2 pi phase)` for a phase of `phase / 2^64` turns.
#[inline]
pub fn rotation(phase: u64) -> Phasor {
    const QUARTER: u32 = 1 << 30;
    let phase = (phase >> 32) as u32;
    Phasor::new(TABLE.at(phase.wrapping_add(QUARTER)), TABLE.at(phase))
}

/// `sin(2 pi turns)` at compile time, for turns in 0 to 1: Taylor series about zero of the angle folded into a quarter
/// turn either side; the last term is below 1e-17.
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

    #[test]
    fn table_interpolates_within_5e_minus_6() {
        let worst = (0..1_000_003u32)
            .map(|n| {
                let phase = n.wrapping_mul(4_294_000_000);
                let exact = libm::sin(core::f64::consts::TAU * f64::from(phase) / 4_294_967_296.0);
                (f64::from(TABLE.at(phase)) - exact).abs()
            })
            .fold(0.0, f64::max);
        assert!(worst < 5e-6 && worst > 1e-6, "{worst}");
    }

    /// Why the drive does not come from micromath: half a step of a 12-bit converter is 2.4e-4.
    #[test]
    fn micromath_is_too_coarse_for_the_drive() {
        let error = |x: f32| (micromath::F32(x).sin().0 - libm::sinf(x)).abs();
        let worst = (0..10_000).map(|n| error(core::f32::consts::TAU * n as f32 / 10_000.0)).fold(0.0, f32::max);
        assert!((5e-4..2e-3).contains(&worst), "{worst}");
    }

    #[test]
    fn rotation_is_counter_clockwise() {
        let eighth = rotation(1 << 61);
        assert!((eighth.re - eighth.im).abs() < 1e-6 && eighth.re > 0.707);
    }
}
