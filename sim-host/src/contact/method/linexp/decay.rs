//! `exp(-x)` of four numbers at once, for exponents that are small.
//!
//! The slip of one step is a fraction of the Dahl length, so the short series is the usual way: it costs a third of four calls of
//! the library's function (`cargo bench -p sim-host --bench contact`, group `decay`).

use wide::f64x4;

/// Up to here the series is good to a few units of the last place: the term left out is below 1e-15.
const SHORT: f64 = 0.5;

/// `exp(-x)` of each.
#[inline]
pub(super) fn decay(x: f64x4) -> f64x4 {
    let values = x.to_array();
    if values[0].abs().max(values[1].abs()).max(values[2].abs().max(values[3].abs())) > SHORT {
        return f64x4::new(values.map(|x| (-x).exp()));
    }
    // The series to the thirteenth power, in pairs (Estrin) for short chains.
    let pair = |even: f64, odd: f64| f64x4::splat(even) - x * odd;
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(INVERSE[0], INVERSE[1]) + x2 * pair(INVERSE[2], INVERSE[3]);
    let low = low + x4 * (pair(INVERSE[4], INVERSE[5]) + x2 * pair(INVERSE[6], INVERSE[7]));
    let high = pair(INVERSE[8], INVERSE[9]) + x2 * pair(INVERSE[10], INVERSE[11]) + x4 * pair(INVERSE[12], INVERSE[13]);
    low + (x4 * x4) * high
}

/// One over the factorial.
const INVERSE: [f64; 14] = {
    let mut inverse = [1.0; 14];
    let mut k = 1;
    while k < 14 {
        inverse[k] = inverse[k - 1] / k as f64;
        k += 1;
    }
    inverse
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_exponential() {
        for n in -100..=2000 {
            let x = 0.005 * f64::from(n);
            let got = decay(f64x4::new([x, 0.1, x, 0.0])).to_array();
            assert!((got[0] / (-x).exp() - 1.0).abs() < 2e-15, "{x}");
            assert!(got[3] == 1.0);
        }
    }
}
