//! Sobol indices of a metric: which part of its variance over the sample comes from each key.
//!
//! ```text
//! f over points A_j, B_j and AB_ij (as A_j, with key i from B_j); V = variance of f over all A_j and B_j
//! first order   S_i = mean over j of f(B_j) (f(AB_ij) - f(A_j)) / V                  Saltelli et al. 2010, table 2 (b)
//! total         T_i = mean over j of (f(A_j) - f(AB_ij))^2 / 2 V                     Jansen 1999, ibid. (f)
//! ```
//!
//! The first is the part of the variance that would be gone if the key alone were known; the second the part that would be left if all others
//! were known, so that T - S is what the key does together with others. Intervals are of a bootstrap over j, in which a mean of f is taken off first.
//! A pair of draws with a point that has no value is left out.

use rand_core::{Rng, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;
use rayon::prelude::*;
use report::statistics::ascending;

/// How often a bootstrap draws.
const RESAMPLES: usize = 500;
/// Of the estimates of a bootstrap, the part within the interval.
const CONFIDENCE: f64 = 0.95;
/// Fewest pairs of draws that have indices.
const FEWEST: usize = 8;

/// An estimate and the interval that holds it with 95 % confidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The estimate from all pairs of draws.
    pub value: f64,
    /// Lower and upper end of its interval.
    pub interval: (f64, f64),
}

/// The indices of a key.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Indices {
    /// The part of the variance that the key makes alone.
    pub first: Estimate,
    /// The part of the variance that the key has a share in.
    pub total: Estimate,
}

/// The indices of a metric.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// For each key its indices.
    pub keys: Vec<Indices>,
    /// Pairs of draws that were used.
    pub used: usize,
}

/// What the sums are made of: for each pair of draws A, AB of each key, and B.
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

    /// First-order and total index of each key over these pairs; none where nothing varies.
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
        // What round-off makes of a constant is no variance.
        (variance > 1e-24 * squares / (2.0 * count))
            .then(|| sums.iter().map(|&(first, total)| (first / count / variance, total / (2.0 * count) / variance)).collect())
    }
}

/// The indices of a metric over so many keys, from its values in the order of the points; none if too few pairs of draws have all their values, or
/// the metric is the same in all.
pub fn of(keys: usize, values: &[Option<f64>]) -> Option<Sensitivity> {
    let whole = values.chunks_exact(keys + 2).filter_map(|pair| pair.iter().copied().collect::<Option<Vec<f64>>>());
    let mut pairs = Pairs { keys, values: whole.flatten().collect() };
    let used = pairs.len();
    if used < FEWEST {
        return None;
    }
    // The same indices, with less round-off and less noise, without the mean.
    let mean = pairs.values.iter().sum::<f64>() / pairs.values.len() as f64;
    pairs.values.iter_mut().for_each(|value| *value -= mean);
    let scale = pairs.values.iter().fold(0.0f64, |most, value| most.max(value.abs()));
    if scale <= 1e-12 * mean.abs() || scale == 0.0 {
        return None;
    }
    let values = pairs.indices(0..used)?;
    let resample = |number: usize| {
        let mut random = Xoshiro256PlusPlus::seed_from_u64(number as u64);
        // Of 64 random bits the upper half times the count, as a fraction of two to the 32.
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

/// An estimate with the interval that holds most of those of a bootstrap.
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

    /// Ishigami's function, whose indices are known: with a = 7 and b = 0.1 and arguments from -pi to pi, V = 1/2 + a^2/8 + b pi^4/5 + b^2 pi^8/18,
    /// V1 = (1 + b pi^4/5)^2/2, V2 = a^2/8, V3 = 0, V13 = 8 b^2 pi^8/225 (Ishigami and Homma 1990).
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
    fn indices_of_ishigamis_function_are_the_analytic_ones() {
        let pi = std::f64::consts::PI;
        let v = 0.5 + 49.0 / 8.0 + 0.1 * pi.powi(4) / 5.0 + 0.01 * pi.powi(8) / 18.0;
        let (v1, v2, v13) = ((1.0 + 0.1 * pi.powi(4) / 5.0).powi(2) / 2.0, 49.0 / 8.0, 8.0 * 0.01 * pi.powi(8) / 225.0);
        let truth = [(v1 / v, (v1 + v13) / v), (v2 / v, v2 / v), (0.0, v13 / v)];
        for (draws, off) in [(1 << 10, 0.03), (1 << 14, 0.003)] {
            let found = of(3, &sample(draws, ishigami)).expect("indices");
            assert_eq!(found.used as u64, draws);
            for (indices, truth) in found.keys.iter().zip(truth) {
                for (estimate, truth) in [(indices.first, truth.0), (indices.total, truth.1)] {
                    let (low, high) = estimate.interval;
                    assert!((estimate.value - truth).abs() < off, "{draws}: {estimate:?}, {truth}");
                    // A bootstrap takes the draws for independent, which makes the intervals of a sequence wide.
                    assert!(low <= truth && truth <= high && high - low < 0.4, "{draws}: {estimate:?}, {truth}");
                }
            }
        }
    }

    /// A constant that is added changes nothing, a point without a value takes only its own pair away, and what is constant has no indices.
    #[test]
    fn what_is_missing_or_constant_is_left_out() {
        let plain = sample(256, ishigami);
        let shifted: Vec<Option<f64>> = plain.iter().map(|value| value.map(|value| value + 1e6)).collect();
        let (a, b) = (of(3, &plain).expect("indices"), of(3, &shifted).expect("indices"));
        assert!(a.keys.iter().zip(&b.keys).all(|(a, b)| (a.first.value - b.first.value).abs() < 1e-8));
        let mut holed = plain.clone();
        (holed[3], holed[4], holed[777]) = (None, None, None);
        assert_eq!(of(3, &holed).expect("indices").used, 254);
        assert_eq!(of(3, &sample(256, |_| 0.3)), None);
        assert_eq!(of(3, &plain[..35]), None);
    }
}
