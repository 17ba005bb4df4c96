//! Cost and error of every method at every step count, on the standard case.
//!
//! Times are minima over rounds; in each round every setting has its turn, so that what disturbs the machine disturbs all alike.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::interpolate;
use super::method::{METHODS, Method};
use super::reference::Reference;
use super::sample::{Errors, take};
use contact::table_4_1::{PERIODS, standard};
use contact::{Problem, SolveError};

/// A method at one setting.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Steps a drive period.
    pub steps: u32,
    /// Least time a drive period took, ns.
    pub ns: f64,
    /// Instructions a drive period took, if they were counted.
    pub instructions: Option<f64>,
    /// Errors against the reference.
    pub errors: Errors,
}

/// A method at all its settings, in ascending order of steps.
pub struct Curve {
    /// Method of the curve.
    pub method: &'static Method,
    /// Measured points, one for each setting.
    pub points: Vec<Point>,
}

impl Curve {
    /// Cost against error, as points of a curve.
    pub fn of(&self, cost: impl Fn(&Point) -> Option<f64>, error: impl Fn(&Point) -> f64) -> Vec<interpolate::Point> {
        self.points.iter().filter_map(|point| Some((cost(point)?, error(point)))).collect()
    }

    /// Observed order of an error.
    pub fn order(&self, error: impl Fn(&Point) -> f64) -> Option<f64> {
        interpolate::order(&self.of(|point| Some(f64::from(point.steps)), error))
    }

    /// The point at a number of steps.
    pub fn at(&self, steps: u32) -> Option<&Point> {
        self.points.iter().find(|point| point.steps == steps)
    }
}

/// Errors of every method at every setting; costs are yet to be measured.
pub fn errors(reference: &Reference, quick: bool) -> Result<Vec<Curve>, SolveError> {
    let problem = standard();
    let measure = |method: &'static Method, steps: u32| -> Result<Point, SolveError> {
        let errors = take(&problem, method.watched, steps)?.errors(&reference.sample, problem.coulomb_n);
        Ok(Point { steps, ns: f64::INFINITY, instructions: None, errors })
    };
    let curve = |method: &'static Method| -> Result<Curve, SolveError> {
        let points = method.steps(quick).iter().map(|steps| measure(method, *steps)).collect::<Result<_, _>>()?;
        Ok(Curve { method, points })
    };
    METHODS.iter().map(curve).collect()
}

/// A setting's turn in a round: at least this long, in as many runs as it takes.
const TURN: Duration = Duration::from_millis(2);

/// One round: every setting has its turn, and keeps the least time.
pub fn round(curves: &mut [Curve]) -> Result<(), SolveError> {
    let problem = standard();
    for curve in curves {
        for point in &mut curve.points {
            let turn = Instant::now();
            while turn.elapsed() < TURN {
                point.ns = point.ns.min(once(&problem, curve.method, point.steps)?);
            }
        }
    }
    Ok(())
}

/// Time of a drive period in one run, ns.
fn once(problem: &Problem, method: &Method, steps: u32) -> Result<f64, SolveError> {
    let began = Instant::now();
    black_box((method.run)(black_box(problem), black_box(steps))?);
    Ok(began.elapsed().as_secs_f64() * 1e9 / PERIODS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::precision::reference;

    #[test]
    fn methods_have_the_orders_they_are_known_by() {
        let reference = reference::make(&standard()).unwrap();
        let curves = errors(&reference, true).unwrap();
        let of = |name: &str| curves.iter().find(|curve| curve.method.name == name).unwrap();
        let known = [("rk4-plain", 1.9, 2.1), ("rk4-fair", 1.9, 2.1), ("rk4-events", 3.9, 4.5), ("linexp-4", 3.9, 4.5)];
        for (name, least, most) in known {
            let order = of(name).order(|point| point.errors.force).unwrap();
            assert!((least..most).contains(&order), "{name}: {order}");
        }
        // Without feedback the error does not fall with the step: it is friction's share of the motion.
        assert!(of("frozen").points.iter().all(|point| (5e-3..1e-2).contains(&point.errors.force)));
        // The same steps, scaled: the same errors.
        for (plain, fair) in of("rk4-plain").points.iter().zip(&of("rk4-fair").points) {
            assert!((plain.errors.force / fair.errors.force - 1.0).abs() < 1e-3, "{plain:?} {fair:?}");
        }
    }

    #[test]
    fn a_round_times_every_setting() {
        let method = &METHODS[0];
        let points = vec![Point { steps: 8, ns: f64::INFINITY, instructions: None, errors: Errors::default() }];
        let mut curves = [Curve { method, points }];
        round(&mut curves).unwrap();
        assert!(curves[0].points[0].ns > 1.0 && curves[0].points[0].ns < 1e6);
    }
}
