//! Steady parts of a log: neighbouring samples of one state at nearly constant speed and load.

use std::ops::Range;

/// Largest deviation of the speed or the normal force within a part, relative to its mean.
const MAX_CHANGE_REL: f64 = 0.2;
/// Number of neighbouring samples outside this range that end a part.
const OUTSIDE_SAMPLES: usize = 5;
/// Smallest number of samples of a long part.
pub(super) const MIN_SAMPLES: usize = 20;
/// First samples of a part that are not used, relative to all: contact and load cell settle.
const SETTLING_REL: f64 = 0.1;

/// Strength of the vibration that counts as zero, relative to the largest.
const ZERO_REL: f64 = 0.05;
/// Largest difference of two strengths of the same condition, relative.
const SAME_LEVEL_REL: f64 = 0.1;

/// Steady part of a log.
pub(super) struct Part {
    /// Samples.
    pub(super) rows: Range<usize>,
}

impl Part {
    /// Returns `true` if the part has enough samples for a mean.
    pub(super) fn is_long(&self) -> bool {
        self.rows.len() >= MIN_SAMPLES
    }

    /// Returns the samples after the settling.
    pub(super) fn settled(&self) -> Range<usize> {
        self.rows.start + (SETTLING_REL * self.rows.len() as f64) as usize..self.rows.end
    }
}

/// Divides a log. `key` are the properties of a sample that do not vary within a part.
pub(super) fn parts<K: PartialEq>(speed: &[f64], normal: Option<&[f64]>, key: impl Fn(usize) -> K) -> Vec<Part> {
    let mut parts = Vec::new();
    let mut start = 0;
    while start < speed.len() {
        let end = (start + 1..speed.len()).find(|row| key(*row) != key(start)).unwrap_or(speed.len());
        let mut begin = start;
        while begin < end {
            let columns = [Some(speed), normal];
            let until = columns.iter().flatten().map(|values| begin + steady(&values[begin..end])).min().unwrap_or(end);
            parts.push(Part { rows: begin..until });
            begin = until;
        }
        start = end;
    }
    parts
}

/// Returns the number of samples before the values leave the range about their mean.
fn steady(values: &[f64]) -> usize {
    let (mut sum, mut count, mut outside) = (0.0, 0.0, 0);
    for (at, value) in values.iter().enumerate() {
        let mean = sum / f64::max(count, 1.0);
        if count > 0.0 && (value - mean).abs() > MAX_CHANGE_REL * mean.abs() {
            outside += 1;
            if outside == OUTSIDE_SAMPLES {
                return at + 1 - OUTSIDE_SAMPLES;
            }
        } else {
            (sum, count, outside) = (sum + value, count + 1.0, 0);
        }
    }
    values.len()
}

/// Returns levels without their noise: those near zero are zero, and others that differ by less
/// than a tenth have their mean.
pub(super) fn grouped(values: &[f64]) -> Vec<f64> {
    let most = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for at in order {
        let is_near = |group: &&mut Vec<usize>| {
            let first = values[group[0]];
            let is_zero = |value: f64| value.abs() <= ZERO_REL * most;
            is_zero(first) && is_zero(values[at]) || !is_zero(first) && values[at] - first <= SAME_LEVEL_REL * first.abs()
        };
        match groups.last_mut().filter(is_near) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    let mut grouped = vec![0.0; values.len()];
    for group in &groups {
        let mean = group.iter().map(|at| values[*at]).sum::<f64>() / group.len() as f64;
        let same = group.iter().all(|at| values[*at] == values[group[0]]);
        let value = if mean.abs() <= ZERO_REL * most {
            0.0
        } else if same {
            values[group[0]]
        } else {
            mean
        };
        group.iter().for_each(|at| grouped[*at] = value);
    }
    grouped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_of_a_strength_is_removed() {
        assert_eq!(grouped(&[0.0, 5.0, -0.003, 5.25, 10.0, 0.002]), [0.0, 5.125, 0.0, 5.125, 10.0, 0.0]);
    }

    #[test]
    fn a_log_is_divided_by_state_and_speed() {
        let speed: Vec<f64> = (0..300).map(|n| if n < 200 { 0.1 + 0.001 * f64::from(n % 7) } else { -0.2 }).collect();
        let found = parts(&speed, None, |row| row >= 100);
        let rows: Vec<_> = found.iter().map(|part| part.rows.clone()).collect();
        assert_eq!(rows, [0..100, 100..200, 200..300]);
        assert_eq!(found[0].settled(), 10..100);
    }
}
