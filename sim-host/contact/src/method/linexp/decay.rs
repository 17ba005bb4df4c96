//! `exp(-x)` of several numbers at once, for exponents that are small.
//!
//! The slip of one step is a fraction of the Dahl length, so the short series is the usual way: all lanes at once, and nothing to call.

use super::simd_nodes::SimdNodes;

/// Up to here the series is good to a few units of the last place: the term left out is below 1e-15.
pub(super) const SHORT: f64 = 0.5;

/// `exp(-x)` of each. A slip against its sign is round-off: it does not grow beyond `exp(0.5)`, so that nothing times it is nothing.
#[inline]
pub(super) fn decay<L: SimdNodes>(x: L) -> L {
    if (0..=L::END).any(|lane| x.lane(lane).abs() > SHORT) {
        return L::each(|lane| (-x.lane(lane)).min(SHORT).exp());
    }
    // The series to the thirteenth power, in pairs (Estrin) for short chains.
    let pair = |even: usize| L::all(INVERSE[even]) - x * L::all(INVERSE[even + 1]);
    let x2 = x * x;
    let x4 = x2 * x2;
    let low = pair(0) + x2 * pair(2);
    let low = low + x4 * (pair(4) + x2 * pair(6));
    let high = pair(8) + x2 * pair(10) + x4 * pair(12);
    low + (x4 * x4) * high
}

/// One over the factorial.
pub(super) const INVERSE: [f64; 14] = {
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
    use wide::f64x4;

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
