//! Sobol indices of a metric: the fraction of its variance over the sample that each key causes.
//!
//! ```text
//! f over points A_j, B_j and AB_ij (as A_j, with key i from B_j); V = variance of f over all A_j and B_j
//! first order   S_i = mean over j of f(B_j) (f(AB_ij) - f(A_j)) / V                  Saltelli et al. 2010, table 2 (b)
//! total         T_i = mean over j of (f(A_j) - f(AB_ij))^2 / 2 V                     Jansen 1999, ibid. (f)
//! ```
//!
//! The first index is the fraction of the variance that would vanish if the key alone were known.
//! The total index is the fraction that would remain if all other keys were known, so T - S is the
//! effect of interactions. Intervals are from a bootstrap over j; the mean of f is subtracted
//! first. A pair of draws with a point without a value is excluded.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use report::statistics::ascending;

/// Number of resamples of a bootstrap.
const RESAMPLES: usize = 500;
/// Fraction of the bootstrap estimates within the interval.
const CONFIDENCE: f64 = 0.95;
/// Minimum number of pairs of draws for indices.
const MIN_PAIRS: usize = 8;

/// An estimate with its 95 % confidence interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// Estimate from all pairs of draws.
    pub value: f64,
    /// Lower and upper end of its interval.
    pub interval: (f64, f64),
}

/// Indices of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// Fraction of the variance that the key causes alone.
    pub first: Estimate,
    /// Fraction of the variance that the key causes alone and in interactions.
    pub total: Estimate,
}

/// Indices of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// Indices of each key.
    pub keys: Vec<Indices>,
    /// Number of pairs of draws used.
    pub used: usize,
}

/// Values of the metric for each pair of draws: A, AB of each key, and B.
struct Pairs {
    keys: usize,
    values: Vec<f64>,
}

impl Pairs {
    fn len(&self) -> usize {
        self.values.len() / (self.keys + 2)
    }

    fn pair(&self, pair: usize) -> &[f64] {
        &self.values[pair * (self.keys + 2)..][..self.keys + 2]
    }

    /// Returns first-order and total index of each key over these pairs; `None` if nothing varies.
    fn indices(&self, pairs: impl Iterator<Item = usize> + Clone) -> Option<Vec<(f64, f64)>> {
        let (mut sum, mut squares, mut count) = (0.0, 0.0, 0.0);
        let mut sums = vec![(0.0, 0.0); self.keys];
        for pair in pairs {
            let pair = self.pair(pair);
            let (a, b) = (pair[0], pair[self.keys + 1]);
            (sum, squares, count) = (sum + a + b, squares + a * a + b * b, count + 1.0);
            for (sums, &ab) in sums.iter_mut().zip(&pair[1..]) {
                sums.0 += b * (ab - a);
                sums.1 += (a - ab) * (a - ab);
            }
        }
        let mean = sum / (2.0 * count);
        let variance = squares / (2.0 * count) - mean * mean;
        // Round-off of a constant does not count as variance.
        (variance > 1e-24 * squares / (2.0 * count))
            .then(|| sums.iter().map(|&(first, total)| (first / count / variance, total / (2.0 * count) / variance)).collect())
    }
}

/// Returns the indices of a metric over `keys` keys, from its values in the order of the points;
/// `None` if too few pairs of draws have all their values, or if the metric is constant.
pub fn compute(keys: usize, values: &[Option<f64>]) -> Option<Sensitivity> {
    let whole = values.chunks_exact(keys + 2).filter_map(|pair| pair.iter().copied().collect::<Option<Vec<f64>>>());
    let mut pairs = Pairs { keys, values: whole.flatten().collect() };
    let used = pairs.len();
    if used < MIN_PAIRS {
        return None;
    }
    // Subtracting the mean keeps the indices, with less round-off and less noise.
    let mean = pairs.values.iter().sum::<f64>() / pairs.values.len() as f64;
    pairs.values.iter_mut().for_each(|value| *value -= mean);
    let scale = pairs.values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    if scale <= 1e-12 * mean.abs() || scale == 0.0 {
        return None;
    }
    let values = pairs.indices(0..used)?;
    let resample = |number: usize| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(number as u64);
        // The upper 32 random bits, as a fraction of 2^32, times the count.
        let draw: Vec<usize> = (0..used).map(|_| (((random.next_u64() >> 32) * used as u64) >> 32) as usize).collect();
        pairs.indices(draw.iter().copied())
    };
    let resampled: Vec<Vec<(f64, f64)>> = (0..RESAMPLES).into_par_iter().filter_map(resample).collect();
    let indices = |(key, &(first, total)): (usize, &(f64, f64))| {
        let (firsts, totals) = resampled.iter().map(|all| all[key]).unzip();
        Indices { first: estimate(first, firsts), total: estimate(total, totals) }
    };
    Some(Sensitivity { keys: values.iter().enumerate().map(indices).collect(), used })
}

/// Returns an estimate with its confidence interval from a bootstrap.
fn estimate(value: f64, resampled: Vec<f64>) -> Estimate {
    let resampled = ascending(resampled);
    let last = resampled.len().max(1) - 1;
    let at = |part: f64| resampled.get((part * last as f64).round() as usize).copied().unwrap_or(value);
    Estimate { value, interval: (at(0.5 - CONFIDENCE / 2.0), at(0.5 + CONFIDENCE / 2.0)) }
}

#[cfg(test)]
mod tests {
    use super::super::design::Design;
    use super::*;

    /// Returns Ishigami's function, whose indices are known. With a = 7, b = 0.1 and arguments from
    /// -pi to pi, V = 1/2 + a^2/8 + b pi^4/5 + b^2 pi^8/18, V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V3
    /// = 0, V13 = 8 b^2 pi^8/225 (Ishigami and Homma 1990).
    fn ishigami(x: &[f64]) -> f64 {
        x[0].sin() + 7.0 * x[1].sin().powi(2) + 0.1 * x[2].powi(4) * x[0].sin()
    }

    fn sample(draws: u64, of: fn(&[f64]) -> f64) -> Vec<Option<f64>> {
        let pi = std::f64::consts::PI;
        let ranges = ["a", "b", "c"].map(|key| format!("{key}={}:{pi}", -pi).parse().expect("a range"));
        let design = Design::sample(ranges.to_vec(), draws).expect("a sample");
        (0..design.count()).map(|point| Some(of(&design.values(point)))).collect()
    }

    #[test]
    fn indices_of_ishigami_match_the_analytic_values() {
        let pi = std::f64::consts::PI;
        let v = 0.5 + 49.0 / 8.0 + 0.1 * pi.powi(4) / 5.0 + 0.01 * pi.powi(8) / 18.0;
        let (v1, v2, v13) = ((1.0 + 0.1 * pi.powi(4) / 5.0).powi(2) / 2.0, 49.0 / 8.0, 8.0 * 0.01 * pi.powi(8) / 225.0);
        let truth = [(v1 / v, (v1 + v13) / v), (v2 / v, v2 / v), (0.0, v13 / v)];
        for (draws, off) in [(1 << 10, 0.03), (1 << 14, 0.003)] {
            let found = compute(3, &sample(draws, ishigami)).expect("indices");
            assert_eq!(found.used as u64, draws);
            for (indices, truth) in found.keys.iter().zip(truth) {
                for (estimate, truth) in [(indices.first, truth.0), (indices.total, truth.1)] {
                    let (low, high) = estimate.interval;
                    assert!((estimate.value - truth).abs() < off, "{draws}: {estimate:?}, {truth}");
                    // A bootstrap assumes independent draws, so the intervals of a sequence are
                    // wide.
                    assert!(low <= truth && truth <= high && high - low < 0.4, "{draws}: {estimate:?}, {truth}");
                }
            }
        }
    }

    /// An added constant changes nothing, a missing value excludes only its own pair, and a
    /// constant has no indices.
    #[test]
    fn missing_or_constant_values_are_excluded() {
        let plain = sample(256, ishigami);
        let shifted: Vec<Option<f64>> = plain.iter().map(|value| value.map(|value| value + 1e6)).collect();
        let (a, b) = (compute(3, &plain).expect("indices"), compute(3, &shifted).expect("indices"));
        assert!(a.keys.iter().zip(&b.keys).all(|(a, b)| (a.first.value - b.first.value).abs() < 1e-8));
        let mut holed = plain.clone();
        (holed[3], holed[4], holed[777]) = (None, None, None);
        assert_eq!(compute(3, &holed).expect("indices").used, 254);
        assert_eq!(compute(3, &sample(256, |_| 0.3)), None);
        assert_eq!(compute(3, &plain[..35]), None);
    }
}
