//! Thins a long trace without losing its peaks.
//!
//! Drawing a million samples across a thousand pixels gains nothing, and taking every n-th sample
//! loses exactly the spikes a reader looks for. So the trace is cut into runs of consecutive
//! samples, and each run keeps the samples that hold its extremes. At the resolution of a pixel the
//! result looks the same as the whole.

/// Number of points above which a curve is thinned.
pub const MAX_POINTS: usize = 4000;

/// Returns the indices worth drawing, ascending, about `limit` of them.
///
/// Every column keeps its extremes in each run. Passing x as a column keeps the ends of each run of
/// a trace in time, and the leftmost and rightmost points of a locus. A run that holds a value that
/// is not finite keeps one such sample, so that gaps survive.
pub fn keep(columns: &[&[f64]], limit: usize) -> Vec<usize> {
    let length = columns.iter().map(|c| c.len()).min().unwrap_or(0);
    if length <= limit {
        return (0..length).collect();
    }
    let runs = (limit / (2 * columns.len())).max(1);
    let mut indices = Vec::with_capacity(limit + runs);
    for run in 0..runs {
        let (start, end) = (run * length / runs, (run + 1) * length / runs);
        let first = indices.len();
        for column in columns {
            let finite = || (start..end).filter(|&i| column[i].is_finite());
            indices.extend(finite().min_by(|&a, &b| column[a].total_cmp(&column[b])));
            indices.extend(finite().max_by(|&a, &b| column[a].total_cmp(&column[b])));
            indices.extend((start..end).find(|&i| !column[i].is_finite()));
        }
        indices[first..].sort_unstable();
    }
    indices.dedup();
    indices
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_traces_are_unchanged() {
        assert_eq!(keep(&[&[3.0, 1.0, 2.0]], 3), [0, 1, 2]);
        assert!(keep(&[&[]], 10).is_empty());
        assert!(keep(&[], 10).is_empty());
    }

    #[test]
    fn single_spikes_and_both_ends_survive() {
        let x: Vec<f64> = (0..100_000).map(f64::from).collect();
        let mut y = vec![0.0; 100_000];
        y[12_345] = 7.0;
        y[54_321] = -9.0;
        let indices = keep(&[&x, &y], 400);
        for index in [0, 12_345, 54_321, 99_999] {
            assert!(indices.contains(&index), "{index} is missing");
        }
        assert!(indices.len() <= 400);
        assert!(indices.is_sorted_by(|a, b| a < b));
    }

    #[test]
    fn gaps_survive() {
        let mut y: Vec<f64> = (0..10_000).map(|i| f64::from(i).sin()).collect();
        y[5_000] = f64::NAN;
        assert!(keep(&[&y], 100).contains(&5_000));
    }

    #[test]
    fn a_trace_of_gaps_keeps_a_sample() {
        let indices = keep(&[&vec![f64::NAN; 5_000]], 100);
        assert!(!indices.is_empty());
    }
}
