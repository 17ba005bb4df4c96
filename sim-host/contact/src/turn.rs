//! Sine and cosine of an angle in turns. Scalar and vector code share this implementation, so that
//! both give the same bits.
//!
//! The reduction of the angle to an eighth of a turn is exact, so only the polynomials limit the
//! accuracy. They are power series whose truncation error is below a quarter of the last place.

use std::f64::consts::TAU;

/// 1.5 2^52: adding it to a value puts the nearest integer into the lowest bits.
pub(crate) const ROUNDING_OFFSET: f64 = 6_755_399_441_055_744.0;
/// Number of series terms after the leading ones.
const TERMS: usize = 7;
/// Coefficients of `(sin a - a) / a^3` in powers of a^2.
pub(crate) const SINE: [f64; TERMS] = {
    let (mut terms, mut term, mut k) = ([0.0; TERMS], 1.0, 0);
    while k < TERMS {
        term /= -(((2 * k + 2) * (2 * k + 3)) as f64);
        terms[k] = term;
        k += 1;
    }
    terms
};
/// Coefficients of `(cos a - 1 + a^2 / 2) / a^4` in powers of a^2.
pub(crate) const COSINE: [f64; TERMS] = {
    let (mut terms, mut term, mut k) = ([0.0; TERMS], -0.5, 0);
    while k < TERMS {
        term /= -(((2 * k + 3) * (2 * k + 4)) as f64);
        terms[k] = term;
        k += 1;
    }
    terms
};

/// Returns sine and cosine of an angle in turns.
#[inline]
pub(crate) fn sine_cosine(turns: f64) -> (f64, f64) {
    let quarters = turns * 4.0 + ROUNDING_OFFSET;
    let angle = (turns - (quarters - ROUNDING_OFFSET) * 0.25) * TAU;
    let square = angle * angle;
    let sine = angle + angle * square * series(&SINE, square);
    let cosine = (1.0 - 0.5 * square) + square * square * series(&COSINE, square);
    let quarter = quarters.to_bits();
    let (sine, cosine) = if quarter & 1 == 1 { (cosine, sine) } else { (sine, cosine) };
    let flip = |value: f64, quarter: u64| f64::from_bits(value.to_bits() ^ (quarter & 2) << 62);
    (flip(sine, quarter), flip(cosine, quarter.wrapping_add(1)))
}

/// Evaluates the series with even and odd powers separated.
#[inline]
fn series(c: &[f64; TERMS], x: f64) -> f64 {
    let square = x * x;
    let even = ((c[6] * square + c[4]) * square + c[2]) * square + c[0];
    let odd = (c[5] * square + c[3]) * square + c[1];
    even + x * odd
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Compared with the standard library, at angles where the rounding of its argument is at most
    /// round-off.
    #[test]
    fn sine_and_cosine_are_exact_to_the_last_place() {
        let mut worst = 0.0f64;
        for n in -300_000..=300_000 {
            let turns = f64::from(n) * 1e-5;
            let (sine, cosine) = sine_cosine(turns);
            let exact = (TAU * (turns - turns.round())).sin_cos();
            worst = worst.max((sine - exact.0).abs()).max((cosine - exact.1).abs());
            assert!((sine * sine + cosine * cosine - 1.0).abs() < 5e-16, "{turns}");
        }
        // Half of this error comes from the rounding of the standard library's argument.
        assert!(worst < 4.5e-16, "{worst:e}");
        // Whole quarters are exact; small angles keep their relative precision.
        assert_eq!([0.25, 0.5, 0.75, 7.0, -0.25].map(|turns| sine_cosine(turns).0), [1.0, 0.0, -1.0, 0.0, -1.0]);
        for turns in [1e-3, 1e-9, -1e-20] {
            assert!((sine_cosine(turns).0 / (TAU * turns).sin() - 1.0).abs() < 3e-16);
        }
    }
}
