//! Selects the cheapest setting of a peer that meets an error.

use std::collections::BTreeSet;

use crate::bench::{Entry, Point, Quantity};
use crate::peer::Family;

/// Errors at which peers are compared. The end is known only to 1e-12, because its moment is
/// rounded to that.
pub const TARGETS: [(Quantity, f64); 7] = [
    (Quantity::Mean, 1e-6),
    (Quantity::Mean, 1e-8),
    (Quantity::Mean, 1e-11),
    (Quantity::Mean, 1e-13),
    (Quantity::End, 1e-6),
    (Quantity::End, 1e-8),
    (Quantity::End, 1e-11),
];

/// Ratio to the cheapest time in the search up to which a setting is timed too.
const TIMED_RATIO: f64 = 1.3;
/// Largest number of settings that are timed for one error.
const MAX_TIMED: usize = 3;

/// Returns the settings that meet an error.
///
/// All finer settings of the same way, down to the most accurate, must meet it as well: a coarse
/// setting that beats its finer neighbours by luck does not count.
fn meeting(points: &[Point], quantity: Quantity, level: f64) -> Vec<usize> {
    let mut found = Vec::new();
    let mut start = 0;
    for way in points.chunk_by(|a, b| a.way == b.way) {
        let errors: Vec<(usize, f64)> =
            (start..).zip(way).filter_map(|(index, point)| Some((index, point.result.as_ref().ok()?.error(quantity)))).collect();
        start += way.len();
        let Some(best) = (0..errors.len()).min_by(|&a, &b| errors[a].1.total_cmp(&errors[b].1)) else { continue };
        found.extend(errors[..=best].iter().rev().take_while(|(_, error)| *error <= level).map(|(index, _)| *index));
    }
    found
}

/// Returns the settings to be timed: for every error those that look cheapest.
pub fn candidates(points: &[Point]) -> Vec<usize> {
    let mut chosen = BTreeSet::new();
    let ns = |index: usize| points[index].ns().unwrap_or(f64::INFINITY);
    for (quantity, level) in TARGETS {
        let mut found = meeting(points, quantity, level);
        found.sort_by(|&a, &b| ns(a).total_cmp(&ns(b)));
        let least = found.first().map_or(0.0, |&index| ns(index));
        chosen.extend(found.into_iter().take(MAX_TIMED).filter(|&index| ns(index) <= TIMED_RATIO * least));
    }
    chosen.into_iter().collect()
}

/// Returns the cheapest timed setting that meets an error.
pub fn cheapest(points: &[Point], quantity: Quantity, level: f64) -> Option<&Point> {
    let timed = meeting(points, quantity, level).into_iter().map(|index| &points[index]).filter(|point| !point.rounds.is_empty());
    timed.min_by(|a, b| a.ns().unwrap_or(f64::INFINITY).total_cmp(&b.ns().unwrap_or(f64::INFINITY)))
}

/// Returns the time of our cheapest setting for an error, ns a period.
pub fn ours(entries: &[Entry], quantity: Quantity, level: f64) -> Option<f64> {
    let ours = entries.iter().find(|entry| entry.family == Family::Ours)?;
    cheapest(&ours.points, quantity, level)?.ns()
}

/// Returns the least error of a peer.
pub fn least_error(points: &[Point], quantity: Quantity) -> Option<f64> {
    points.iter().filter_map(|point| Some(point.result.as_ref().ok()?.error(quantity))).reduce(f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::Run;
    use crate::peer::{Setting, Way};

    fn points(number: usize, errors: &[(f64, f64)]) -> Vec<Point> {
        let point = |&(error, ns): &(f64, f64)| Point {
            way: Way::new(number, "", Vec::new()),
            setting: Setting::Steps(1),
            result: Ok(Run { searched_ns: ns, mean_error: error, end_error: 1.0 }),
            rounds: vec![ns],
        };
        errors.iter().map(point).collect()
    }

    #[test]
    fn a_lucky_coarse_setting_does_not_count() {
        // One coarse point is below 1e-6 by luck; the errors stay below it only from 1e-7 on.
        let curve = points(0, &[(1e-8, 1.0), (1e-4, 2.0), (1e-7, 4.0), (1e-9, 8.0)]);
        assert_eq!(cheapest(&curve, Quantity::Mean, 1e-6).and_then(Point::ns), Some(4.0));
        assert!(cheapest(&curve, Quantity::Mean, 1e-11).is_none());
        assert!(cheapest(&curve, Quantity::End, 1e-6).is_none());
        assert_eq!(least_error(&curve, Quantity::Mean), Some(1e-9));
    }

    #[test]
    fn round_off_beyond_the_most_accurate_does_not_exclude() {
        let curve = points(0, &[(1e-9, 1.0), (1e-12, 2.0), (3e-8, 4.0)]);
        assert_eq!(cheapest(&curve, Quantity::Mean, 1e-8).and_then(Point::ns), Some(1.0));
    }

    #[test]
    fn the_cheapest_of_all_ways_counts() {
        let mut all = points(0, &[(1e-7, 5.0), (1e-9, 9.0)]);
        all.extend(points(1, &[(1e-5, 1.0), (1e-8, 3.0)]));
        assert_eq!(cheapest(&all, Quantity::Mean, 1e-6).and_then(Point::ns), Some(3.0));
        assert_eq!(candidates(&all), vec![3]);
    }

    #[test]
    fn rounds_give_their_median() {
        let mut point = points(0, &[(1e-7, 5.0)]).remove(0);
        point.rounds = vec![9.0, 1.0, 4.0];
        assert_eq!(point.ns(), Some(4.0));
        point.rounds.push(6.0);
        assert_eq!(point.ns(), Some(5.0));
    }
}
