//! Scaling of an amplitude until a metric equals that of another case. The secant rule on
//! logarithms is `ln a <- ln a + ln(target / metric) / n`, with `n` the slope between the last two
//! runs. Initially, `n` is the exponent of a linear plant (1 for a root mean square, 2 for a power,
//! for which one step is the square root). Contact and converters make the plant slightly
//! nonlinear, which takes a run or two more. A reduction of friction has a threshold and saturates:
//! once two runs have the target between them, the search continues there.

use super::solve::Search;

/// Relative deviation from the target that counts as equal.
pub const CLOSE: f64 = 1e-3;
/// Largest ratio of an amplitude to the last one: a saturated metric has no slope to follow.
const MAX_STEP: f64 = 4.0;
/// Maximum number of runs. Codes are integers: at a small amplitude, no run may come close enough.
const MOST_RUNS: usize = 20;

/// Amplitude of a run, and its metric.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Amplitude, in the unit of its key.
    pub amplitude: f64,
    /// Metric of the run.
    pub metric: f64,
}

/// Target of the matching.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// Value of the metric in the first case.
    pub metric: f64,
    /// Exponent of the metric as a function of amplitude in a linear plant.
    pub exponent: f64,
    /// Smallest and largest allowed amplitude.
    pub allowed: (f64, f64),
}

/// Result of the matching.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Match {
    /// Run nearest to the target.
    At(Point),
    /// A match would require more than the largest allowed amplitude.
    Beyond {
        /// Amplitude required for a match, by the slope of the last runs.
        needs: f64,
        /// Run at the largest allowed amplitude, or the best if that one has no effect.
        reached: Point,
    },
    /// A run lacks the metric, or it is nowhere above zero.
    Unmeasured,
}

/// Finds the amplitude at which `measure` returns the target, beginning from an existing run. The
/// metric must grow with the amplitude; it may be zero or negative at small ones.
pub fn find<E>(
    first: Option<f64>,
    amplitude: f64,
    target: Target,
    mut measure: impl FnMut(f64) -> Result<Option<f64>, E>,
) -> Result<Match, E> {
    let (Some(first), true) = (usable(first), target.metric > 0.0) else { return Ok(Match::Unmeasured) };
    let off = |point: &Point| point.metric / target.metric - 1.0;
    let mut last = Point { amplitude, metric: first };
    let mut best = last;
    let mut slope = target.exponent;
    // Last run below the target, and last run above it.
    let (mut below, mut above): (Option<Point>, Option<Point>) = (None, None);
    let mut between: Option<Search> = None;
    for _ in 1..MOST_RUNS {
        if off(&best).abs() <= CLOSE {
            break;
        }
        let side = if off(&last) < 0.0 { &mut below } else { &mut above };
        let one_sided = side.replace(last).is_some();
        let secant = last.amplitude * (target.metric / last.metric).powf(1.0 / slope);
        let needed = match (&between, below.zip(above)) {
            (Some(search), _) => search.next().unwrap_or(last.amplitude),
            (None, Some((low, high)))
                if one_sided || last.metric <= 0.0 || secant <= low.amplitude || secant >= high.amplitude =>
            {
                let search = Search::new((low.amplitude, off(&low)), (high.amplitude, off(&high)));
                between.insert(search).next().unwrap_or(last.amplitude)
            }
            (None, _) if last.metric > 0.0 => secant.min(MAX_STEP * last.amplitude),
            (None, _) => 2.0 * last.amplitude,
        };
        if needed > target.allowed.1 && last.amplitude == target.allowed.1 {
            return Ok(if best.metric > 0.0 { Match::Beyond { needs: secant, reached: best } } else { Match::Unmeasured });
        }
        let next = needed.clamp(target.allowed.0, target.allowed.1);
        if next == last.amplitude {
            break;
        }
        let Some(metric) = usable(measure(next)?) else { return Ok(Match::Unmeasured) };
        let point = Point { amplitude: next, metric };
        if let Some(search) = &mut between {
            search.take(next, off(&point));
        }
        let measured = (point.metric / last.metric).ln() / (point.amplitude / last.amplitude).ln();
        // Two runs that differ only by rounding do not determine the slope.
        slope = if measured.is_finite() { measured.clamp(0.1 * target.exponent, 2.0 * target.exponent) } else { slope };
        if off(&point).abs() < off(&best).abs() {
            best = point;
        }
        last = point;
    }
    Ok(if best.metric > 0.0 { Match::At(best) } else { Match::Unmeasured })
}

fn usable(metric: Option<f64>) -> Option<f64> {
    metric.filter(|metric| metric.is_finite())
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn counted(amplitude: f64, target: f64, exponent: f64, most: f64, plant: impl Fn(f64) -> Option<f64>) -> (Match, usize) {
        let mut runs = 0;
        let target = Target { metric: target, exponent, allowed: (1e-3, most) };
        let found = find(plant(amplitude), amplitude, target, |amplitude| {
            runs += 1;
            Ok::<_, Infallible>(plant(amplitude))
        });
        (found.unwrap_or(Match::Unmeasured), runs)
    }

    #[test]
    fn a_linear_plant_takes_one_run() {
        let (found, runs) = counted(3.0, 4.5, 2.0, 20.0, |a| Some(0.1 * a * a));
        assert_eq!(runs, 1);
        let Match::At(point) = found else { panic!("{found:?}") };
        assert!((point.amplitude - 45f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn nonlinear_plant_takes_at_most_three_runs() {
        // The power of friction is proportional to the amplitude, that of the stack to its square.
        let (found, runs) = counted(3.0, 7.0, 2.0, 20.0, |a| Some(0.1 * a * a + 0.4 * a));
        let Match::At(point) = found else { panic!("{found:?}") };
        assert!(runs <= 3 && (point.metric / 7.0 - 1.0).abs() <= CLOSE, "{runs} {point:?}");
    }

    #[test]
    fn a_metric_with_a_threshold_is_matched() {
        // Coulomb friction under a vibration of velocity a: no reduction below a = 1.
        let reduction = |a: f64| Some(if a > 1.0 { 1.0 - 2.0 / std::f64::consts::PI * (1.0 / a).asin() } else { -1e-12 });
        for amplitude in [0.1, 0.5, 0.9, 1.01, 3.0] {
            for target in [0.02, 0.155, 0.5, 0.9] {
                let Match::At(point) = counted(amplitude, target, 1.0, 40.0, reduction).0 else { panic!("{amplitude} {target}") };
                assert!((point.metric / target - 1.0).abs() <= CLOSE, "{amplitude} {target}: {point:?}");
            }
        }
    }

    #[test]
    fn limited_match_states_the_required_amplitude() {
        let (found, _) = counted(3.0, 40.0, 2.0, 15.466, |a| Some(0.1 * a * a));
        let Match::Beyond { needs, reached } = found else { panic!("{found:?}") };
        assert!((needs - 20.0).abs() < 1e-9 && reached.amplitude == 15.466, "{found:?}");
    }

    #[test]
    fn coarse_steps_end_at_the_nearest_run() {
        let (found, runs) = counted(3.0, 4.53, 1.0, 20.0, |a| Some(a.round()));
        let Match::At(point) = found else { panic!("{found:?}") };
        assert!(runs < MOST_RUNS && (point.metric == 4.0 || point.metric == 5.0), "{runs} {point:?}");
    }

    #[test]
    fn zero_or_missing_metric_cannot_be_matched() {
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |_| None).0, Match::Unmeasured);
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |_| Some(0.0)).0, Match::Unmeasured);
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |a| (a == 3.0).then_some(0.5)).0, Match::Unmeasured);
    }
}
