//! Complete elliptic integrals by the arithmetic-geometric mean (Abramowitz and Stegun 17.6).

use std::f64::consts::FRAC_PI_2;

/// Computes K(m) and E(m) of the parameter 0 <= m <= 1 from `1 - m`, which must not be rounded;
/// K(1) is infinite.
pub(crate) fn complete(complement: f64) -> (f64, f64) {
    if complement == 0.0 {
        return (f64::INFINITY, 1.0);
    }
    let (mut a, mut b) = (1.0, complement.sqrt());
    // E / K = 1 - sum of 2^(n-1) c_n^2, c_0^2 = m
    let mut sum = 0.5 * (1.0 - complement);
    let mut power = 1.0;
    for _ in 0..9 {
        let c = 0.5 * (a - b);
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
        sum += power * c * c;
        power *= 2.0;
    }
    let k = FRAC_PI_2 / a;
    (k, k * (1.0 - sum))
}

/// Computes the general complete integral of Bulirsch (1969, *Numerical calculation of elliptic
/// integrals and elliptic functions III*): of
/// `(a cos^2 + b sin^2) / ((cos^2 + p sin^2) sqrt(cos^2 + kc^2 sin^2))` over 0 to pi/2, for kc > 0,
/// p > 0.
///
/// With positive a and b no terms cancel.
pub(crate) fn general(kc: f64, p: f64, a: f64, b: f64) -> f64 {
    /// Relative difference of the means before the last step; the step squares it.
    const NEAR_REL: f64 = 1e-8;
    let mut p = p.sqrt();
    let (mut a, mut b) = (a, b / p);
    let (mut qc, mut e, mut em) = (kc, kc, 1.0);
    loop {
        let f = a;
        a += b / p;
        let g = e / p;
        b = 2.0 * (b + f * g);
        p += g;
        let before = em;
        em += qc;
        if (before - qc).abs() <= before * NEAR_REL {
            return FRAC_PI_2 * (b + a * em) / (em * (em + p));
        }
        qc = 2.0 * e.sqrt();
        e = qc * em;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Abramowitz and Stegun, table 17.1.
    #[test]
    fn tabulated_values() {
        for (m, k, e) in [
            (0.0, FRAC_PI_2, FRAC_PI_2),
            (0.5, 1.854_074_677_301_372, 1.350_643_881_047_675),
            (1.0, f64::INFINITY, 1.0),
            (0.99, 3.695_637_362_989_875, 1.015_993_545_025_224),
        ] {
            let got = complete(1.0 - m);
            assert!((got.0 == k || (got.0 - k).abs() < 2e-15) && (got.1 - e).abs() < 2e-15, "{m}: {got:?}");
        }
    }
}
