//! Statistics of several numbers.

/// Returns the numbers in ascending order.
pub fn ascending(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    values
}

/// Returns the mean; `None` without numbers.
pub fn mean(values: impl IntoIterator<Item = f64>) -> Option<f64> {
    let (sum, count) = values.into_iter().fold((0.0, 0_usize), |(sum, count), value| (sum + value, count + 1));
    (count > 0).then(|| sum / count as f64)
}

/// Returns the median of ascending numbers: the mean of the middle two if their count is even. NaN
/// without numbers.
pub fn median(ascending: &[f64]) -> f64 {
    let (low, high) = (percentile(ascending, 0.5), quantile(ascending, 0.5).unwrap_or(f64::NAN));
    // An infinite and a finite number have no mean, and infinity minus infinity is NaN.
    if low == high { low } else { 0.5 * (low + high) }
}

/// Returns the smallest of ascending numbers for which at least this fraction of them is not larger
/// (nearest rank). NaN without numbers.
pub fn percentile(ascending: &[f64], part: f64) -> f64 {
    // Rounding must not turn a whole rank into the next one.
    let rank = (part * ascending.len() as f64 - 1e-9).ceil().max(1.0) as usize;
    ascending.get(rank.min(ascending.len()).saturating_sub(1)).copied().unwrap_or(f64::NAN)
}

/// Returns the first of ascending numbers after this fraction of them: for an even count the upper
/// of the middle two at 0.5. `None` without numbers.
pub fn quantile(ascending: &[f64], part: f64) -> Option<f64> {
    ascending.get((part * ascending.len() as f64) as usize).copied()
}
