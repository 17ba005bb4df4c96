//! Interpolation of a cost-error curve between its points, and its order of convergence.

/// Point of a curve: steps a period or cost, and error.
pub type Point = (f64, f64);

/// Returns the cost at which a curve first falls to an error, by linear interpolation on
/// logarithmic axes.
///
/// If the first point is accurate enough its own cost counts, as curves are never extrapolated.
pub fn cost_at(curve: &[Point], error: f64) -> Option<f64> {
    if curve.first()?.1 <= error {
        return Some(curve[0].0);
    }
    let pair = curve.windows(2).find(|pair| pair[1].1 <= error)?;
    let [(cost_0, error_0), (cost_1, error_1)] = [pair[0], pair[1]].map(|(cost, error)| (cost.ln(), error.ln()));
    // An error of zero has no logarithm; the cost of its point is an upper bound.
    if !error_1.is_finite() {
        return Some(pair[1].0);
    }
    Some((cost_0 + (error.ln() - error_0) / (error_1 - error_0) * (cost_1 - cost_0)).exp())
}

/// Error at and below which round-off dominates.
const ROUND_OFF_ERROR: f64 = 1e-13;
/// Error below which a curve has its asymptotic slope.
const ASYMPTOTIC_ERROR: f64 = 1e-2;

/// Returns the order of convergence: the slope of the line through the logarithms of error against
/// steps, over the range of constant slope. The range ends when an error is not smaller than the
/// one before. `None` for fewer than two points.
pub fn order(curve: &[Point]) -> Option<f64> {
    let straight = |point: &&Point| point.1 > ROUND_OFF_ERROR && point.1 < ASYMPTOTIC_ERROR;
    let mut logs: Vec<Point> = Vec::new();
    for (steps, error) in curve.iter().filter(straight).map(|(steps, error)| (steps.ln(), error.ln())) {
        if logs.last().is_some_and(|last| error >= last.1) {
            break;
        }
        logs.push((steps, error));
    }
    let count = logs.len() as f64;
    let middle = (logs.iter().map(|p| p.0).sum::<f64>() / count, logs.iter().map(|p| p.1).sum::<f64>() / count);
    let (across, along) = logs.iter().fold((0.0, 0.0), |(across, along), p| {
        (across + (p.0 - middle.0) * (p.1 - middle.1), along + (p.0 - middle.0) * (p.0 - middle.0))
    });
    (logs.len() >= 2).then_some(-across / along)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_read_exactly() {
        let curve: Vec<Point> = [10.0, 20.0, 80.0, 160.0].map(|n: f64| (n, 3.0 * n.powi(-4))).into();
        assert!((order(&curve).unwrap() - 4.0).abs() < 1e-12);
        let cost = cost_at(&curve, 3.0 * 50f64.powi(-4)).unwrap();
        assert!((cost - 50.0).abs() < 1e-9, "{cost}");
    }

    #[test]
    fn curves_are_not_extrapolated() {
        let curve = [(10.0, 1e-3), (20.0, 1e-4)];
        assert_eq!(order(&curve[..1]), None);
        assert_eq!(cost_at(&curve, 1e-2), Some(10.0));
        assert_eq!(cost_at(&curve, 1e-5), None);
        assert_eq!(cost_at(&[], 1e-5), None);
    }

    #[test]
    fn round_off_has_no_order() {
        let floor = [(8.0, 1e-6), (16.0, 1e-9), (32.0, 1e-12), (64.0, 2e-14), (128.0, 4e-14)];
        assert!((order(&floor).unwrap() - 3.0 * 10f64.log2()).abs() < 0.1);
    }

    #[test]
    fn the_first_crossing_counts() {
        // An error that falls, rises, and falls again.
        let curve = [(1.0, 1.0), (2.0, 1e-2), (4.0, 1e-1), (8.0, 1e-3)];
        assert!((cost_at(&curve, 1e-1).unwrap() - 2f64.sqrt()).abs() < 1e-12);
    }
}
