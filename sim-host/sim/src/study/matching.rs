//! Scales an amplitude until a metric equals another case's: the secant rule on logarithms,
//! `ln a <- ln a + ln(target / metric) / n`, with `n` the slope between the last two runs, or at first the exponent of a linear
//! plant (1 for a root mean square, 2 for a power, by which one step is the square root). Contact and converters make the plant
//! not quite linear; a run or two more see to that.

/// Relative distance from the target that counts as equal.
pub const CLOSE: f64 = 1e-3;
/// Most runs. Codes are whole numbers: at a small amplitude no run may come close enough.
const MOST_RUNS: usize = 12;

/// A run: amplitude, and the metric it gave.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Amplitude, in the unit of its key.
    pub amplitude: f64,
    /// Metric that the run gave.
    pub metric: f64,
}

/// What was asked for.
#[derive(Clone, Copy, Debug)]
pub struct Target {
    /// The metric's value in the first case.
    pub metric: f64,
    /// The power of the amplitude with which it grows in a linear plant.
    pub exponent: f64,
    /// The least and the largest amplitude allowed.
    pub allowed: (f64, f64),
}

/// How it came out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Found {
    /// The run that is nearest to the target.
    At(Point),
    /// A match would take more than the largest amplitude allowed.
    Beyond {
        /// The amplitude that it would take, by the slope of the last runs.
        needs: f64,
        /// What the largest amplitude allowed gives.
        reached: Point,
    },
    /// A run had no such metric, or none above zero.
    Unmeasured,
}

/// Finds the amplitude at which `measure` gives the target, from a run that is there already.
pub fn find<E>(
    first: Option<f64>,
    amplitude: f64,
    target: Target,
    mut measure: impl FnMut(f64) -> Result<Option<f64>, E>,
) -> Result<Found, E> {
    let usable = |metric: Option<f64>| metric.filter(|metric| *metric > 0.0 && metric.is_finite());
    let (Some(first), true) = (usable(first), target.metric > 0.0) else { return Ok(Found::Unmeasured) };
    let off = |point: &Point| (point.metric / target.metric - 1.0).abs();
    let mut last = Point { amplitude, metric: first };
    let mut best = last;
    let mut slope = target.exponent;
    for _ in 1..MOST_RUNS {
        if off(&best) <= CLOSE {
            break;
        }
        let needed = last.amplitude * (target.metric / last.metric).powf(1.0 / slope);
        if needed > target.allowed.1 && last.amplitude == target.allowed.1 {
            return Ok(Found::Beyond { needs: needed, reached: last });
        }
        let next = needed.clamp(target.allowed.0, target.allowed.1);
        if next == last.amplitude {
            break;
        }
        let Some(metric) = usable(measure(next)?) else { return Ok(Found::Unmeasured) };
        let point = Point { amplitude: next, metric };
        let measured = (point.metric / last.metric).ln() / (point.amplitude / last.amplitude).ln();
        // Two runs so close that rounding parts them say nothing about the slope.
        slope = if measured.is_finite() { measured.clamp(0.5 * target.exponent, 2.0 * target.exponent) } else { slope };
        if off(&point) < off(&best) {
            best = point;
        }
        last = point;
    }
    Ok(Found::At(best))
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    fn counted(amplitude: f64, target: f64, exponent: f64, most: f64, plant: impl Fn(f64) -> Option<f64>) -> (Found, usize) {
        let mut runs = 0;
        let target = Target { metric: target, exponent, allowed: (1e-3, most) };
        let found = find(plant(amplitude), amplitude, target, |amplitude| {
            runs += 1;
            Ok::<_, Infallible>(plant(amplitude))
        });
        (found.unwrap_or(Found::Unmeasured), runs)
    }

    #[test]
    fn a_linear_plant_takes_one_run() {
        let (found, runs) = counted(3.0, 4.5, 2.0, 20.0, |a| Some(0.1 * a * a));
        assert_eq!(runs, 1);
        let Found::At(point) = found else { panic!("{found:?}") };
        assert!((point.amplitude - 45f64.sqrt()).abs() < 1e-12);
    }

    #[test]
    fn a_plant_that_is_not_linear_takes_a_few() {
        // Friction costs in proportion to the amplitude, the stack to its square.
        let (found, runs) = counted(3.0, 7.0, 2.0, 20.0, |a| Some(0.1 * a * a + 0.4 * a));
        let Found::At(point) = found else { panic!("{found:?}") };
        assert!(runs <= 3 && (point.metric / 7.0 - 1.0).abs() <= CLOSE, "{runs} {point:?}");
    }

    #[test]
    fn what_the_limit_forbids_has_what_it_would_take() {
        let (found, _) = counted(3.0, 40.0, 2.0, 15.466, |a| Some(0.1 * a * a));
        let Found::Beyond { needs, reached } = found else { panic!("{found:?}") };
        assert!((needs - 20.0).abs() < 1e-9 && reached.amplitude == 15.466, "{found:?}");
    }

    #[test]
    fn steps_too_coarse_to_be_equal_end_at_the_closest() {
        let (found, runs) = counted(3.0, 4.53, 1.0, 20.0, |a| Some(a.round()));
        let Found::At(point) = found else { panic!("{found:?}") };
        assert!(runs < MOST_RUNS && (point.metric == 4.0 || point.metric == 5.0), "{runs} {point:?}");
    }

    #[test]
    fn nothing_driven_is_nothing_to_match() {
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |_| None).0, Found::Unmeasured);
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |_| Some(0.0)).0, Found::Unmeasured);
        assert_eq!(counted(3.0, 1.0, 1.0, 20.0, |a| (a == 3.0).then_some(0.5)).0, Found::Unmeasured);
    }
}
