//! Long measurements: a fit works on a bounded number of points, and statistics of its residuals
//! take a time proportional to the number of rows.

use std::collections::BinaryHeap;
use std::ops::Range;

use num_complex::Complex64;

/// Maximum number of points of a fit; the rows of a longer measurement are averaged in bins.
pub(crate) const MAX_POINTS: usize = 4000;

/// Divides the rows of a measurement into at most this number of bins of neighbours; each row of a
/// short one is a bin.
///
/// ```text
/// sum over rows (y - f)^2 = sum over bins n (mean y - f)^2 + rest,   gain = n1 n2 / (n1 + n2) |mean1 - mean2|^2
/// ```
///
/// A fit to the means with the weights `n` equals a fit to the rows if the model `f` is constant in
/// each bin. Half of the bins are of equal length. Then the bin is halved whose halves reduce the
/// rest most, so that single rows remain where the measurement changes quickly.
pub(crate) fn bins(values: &[Complex64], points: usize) -> Vec<Range<usize>> {
    let (rows, first) = (values.len(), points / 2);
    if rows <= points {
        return (0..rows).map(|row| row..row + 1).collect();
    }
    let mut sums = vec![Complex64::ZERO];
    sums.extend(values.iter().scan(Complex64::ZERO, |sum, value| {
        *sum += value;
        Some(*sum)
    }));
    let half = |from: usize, to: usize| {
        let middle = from.midpoint(to);
        let (before, after) = ((middle - from) as f64, (to - middle) as f64);
        let apart = (sums[middle] - sums[from]) / before - (sums[to] - sums[middle]) / after;
        // The bits of a non-negative number have its order. A single row cannot be halved.
        let gain = if to - from < 2 { 0.0 } else { before * after / (before + after) * apart.norm_sqr() };
        (gain.to_bits(), to - from, from, to)
    };
    let mut heap: BinaryHeap<_> = (0..first).map(|n| half(n * rows / first, (n + 1) * rows / first)).collect();
    while heap.len() < points
        && let Some((.., from, to)) = heap.pop()
    {
        let middle = from.midpoint(to);
        heap.extend([half(from, middle), half(middle, to)]);
    }
    let mut bins: Vec<_> = heap.into_iter().map(|(.., from, to)| from..to).collect();
    bins.sort_by_key(|bin| bin.start);
    bins
}

/// Returns the means of values over bins.
pub(crate) fn means<T>(values: &[T], bins: &[Range<usize>]) -> Vec<T>
where
    T: Copy + std::iter::Sum + std::ops::Div<f64, Output = T>,
{
    bins.iter().map(|bin| values[bin.clone()].iter().copied().sum::<T>() / bin.len() as f64).collect()
}

/// Returns the correlation of neighbouring residuals, and the factor of the variance of their mean
/// due to all significant correlations. The parts have equal lengths.
///
/// ```text
/// factor = 1 + 2 sum rho(k);   many rows: b var(means of b rows) / var(rows) factor(means)
/// ```
pub(crate) fn memory(parts: &[&[f64]]) -> (f64, f64) {
    let rows = parts[0].len();
    let square = |parts: &[&[f64]]| parts.iter().flat_map(|part| part.iter()).map(|r| r * r).sum::<f64>();
    let whole = square(parts);
    if whole == 0.0 {
        return (0.0, 1.0);
    }
    let correlation = |lag: usize| {
        let product = |part: &&[f64]| part.iter().zip(&part[lag..]).map(|(a, b)| a * b).sum::<f64>();
        parts.iter().map(product).sum::<f64>() / whole
    };
    let chance = 2.0 / ((parts.len() * rows.min(MAX_POINTS)) as f64).sqrt();
    let first = if rows < 8 { 0.0 } else { correlation(1) };
    if rows > MAX_POINTS {
        let length = rows.div_ceil(MAX_POINTS);
        let sum = |rows: &[f64]| rows.iter().sum::<f64>() / (length as f64).sqrt();
        let blocks: Vec<Vec<f64>> = parts.iter().map(|part| part.chunks(length).map(sum).collect()).collect();
        let blocks: Vec<&[f64]> = blocks.iter().map(Vec::as_slice).collect();
        let factor = length as f64 * square(&blocks) / whole * memory(&blocks).1;
        return (first, if factor > 1.0 + 3.0 * chance { factor } else { 1.0 });
    }
    let significant = (1..rows / 4).map(correlation).take_while(|rho| *rho >= chance);
    (first, 1.0 + 2.0 * significant.sum::<f64>())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic::random::Random;

    #[test]
    fn bins_are_bounded_and_resolve_a_narrow_resonance() {
        let mut random = Random::new(3);
        let own = |row: usize| Complex64::new(1.0, (row as f64 - 432_100.3) / 2.0).inv();
        let values: Vec<Complex64> = (0..1_000_000).map(|row| own(row) + 1e-2 * random.normal()).collect();
        let bins = bins(&values, MAX_POINTS);
        assert_eq!((bins.len(), bins[0].start, bins[MAX_POINTS - 1].end), (MAX_POINTS, 0, values.len()));
        assert!(bins.windows(2).all(|pair| pair[0].end == pair[1].start && pair[0].start < pair[0].end));
        assert!(bins.iter().filter(|bin| (432_094..432_107).contains(&bin.start)).all(|bin| bin.len() == 1));
    }
}
