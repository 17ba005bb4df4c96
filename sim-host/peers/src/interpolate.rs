//! What an error costs, on a measured work-precision curve.

/// A point of the curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Measured {
    /// Error; positive, or zero if none could be seen.
    pub error: f64,
    /// Cost, ns a period.
    pub cost: f64,
}

/// What an error costs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cost {
    /// So much, between two points.
    At(f64),
    /// At most so much: already the cheapest point is better than asked.
    AtMost(f64),
    /// More than any point; this is the one with the least error.
    NotReached(Measured),
}

/// Errors below this count as this: double precision shows no less.
const LEAST_ERROR: f64 = 1e-17;

/// Cost of an error on a curve that is given from coarse to fine, straight between points in logarithms.
///
/// The error has to hold from there on: a coarse point that is better than its finer neighbours by luck does not count. None if there
/// is no curve.
pub fn cost(curve: &[Measured], target: f64) -> Option<Cost> {
    let least = *curve.iter().min_by(|a, b| a.error.total_cmp(&b.error))?;
    let cheapest = curve.iter().map(|point| point.cost).fold(f64::INFINITY, f64::min);
    let Some(above) = curve.iter().rposition(|point| point.error > target) else { return Some(Cost::AtMost(cheapest)) };
    let Some(below) = curve.get(above + 1) else { return Some(Cost::NotReached(least)) };
    let above = curve[above];
    let (from, to) = (above.error.ln(), below.error.max(LEAST_ERROR).ln());
    let part = (from - target.ln()) / (from - to);
    Some(Cost::At((above.cost.ln() + part * (below.cost.ln() - above.cost.ln())).exp()))
}

impl Cost {
    /// The number, where there is one.
    pub fn value(self) -> Option<f64> {
        match self {
            Cost::At(cost) | Cost::AtMost(cost) => Some(cost),
            Cost::NotReached(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(points: &[(f64, f64)]) -> Vec<Measured> {
        points.iter().map(|&(error, cost)| Measured { error, cost }).collect()
    }

    #[test]
    fn a_power_law_is_met_between_its_points() {
        // cost = error^-1/4, as of a method of order four
        let points = curve(&[(1e-2, 10f64.powf(0.5)), (1e-4, 10.0), (1e-8, 100.0)]);
        for target in [1e-3, 1e-4, 3e-6, 1e-8] {
            let Some(Cost::At(found)) = cost(&points, target) else { panic!("{target}") };
            assert!((found / f64::powf(target, -0.25) - 1.0).abs() < 1e-12, "{target}: {found}");
        }
    }

    #[test]
    fn nothing_is_extrapolated() {
        let points = curve(&[(1e-2, 3.0), (1e-4, 10.0)]);
        assert_eq!(cost(&points, 1e-5), Some(Cost::NotReached(points[1])));
        assert_eq!(cost(&points, 1e-1), Some(Cost::AtMost(3.0)));
        assert_eq!(cost(&[], 1e-1), None);
    }

    #[test]
    fn luck_does_not_count() {
        // The coarse point is below 1e-5 once; only from 1e-6 on does it stay there.
        let points = curve(&[(1e-3, 1.0), (1e-6, 2.0), (1e-4, 4.0), (1e-6, 8.0)]);
        let Some(Cost::At(found)) = cost(&points, 1e-5) else { panic!() };
        assert!((found - 32f64.sqrt()).abs() < 1e-12, "{found}");
        // Better than asked at first, worse at the end: not reached.
        let points = curve(&[(1e-6, 1.0), (1e-4, 4.0)]);
        assert_eq!(cost(&points, 1e-5), Some(Cost::NotReached(points[0])));
    }

    #[test]
    fn an_error_of_zero_has_a_place() {
        let points = curve(&[(1e-7, 1.0), (0.0, 10.0)]);
        // Half way from 1e-7 to 1e-17.
        let Some(Cost::At(found)) = cost(&points, 1e-12) else { panic!() };
        assert!((found - 10f64.sqrt()).abs() < 1e-12, "{found}");
    }
}
