//! Cost and error of every method at every step count, on the standard case.
//!
//! Times are minima over rounds. In each round every setting has its turn, so that disturbances of
//! the machine affect all settings equally.

use std::hint::black_box;
use std::time::{Duration, Instant};

use super::interpolate;
use super::method::{METHODS, Method};
use super::reference::Reference;
use super::sample::{Errors, take};
use contact::table_4_1::{PERIODS, standard};
use contact::{Problem, SolveError};

/// Method at one setting.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Steps a drive period.
    pub steps: u32,
    /// Shortest time of a drive period, ns.
    pub ns: f64,
    /// Instructions of a drive period, if counted.
    pub instructions: Option<f64>,
    /// Errors against the reference.
    pub errors: Errors,
}

/// Method at all its settings, in ascending order of steps.
pub struct Curve {
    /// Method of the curve.
    pub method: &'static Method,
    /// Measured points, one for each setting.
    pub points: Vec<Point>,
}

impl Curve {
    /// Returns cost against error, as points of a curve.
    pub fn cost_against_error(
        &self,
        cost: impl Fn(&Point) -> Option<f64>,
        error: impl Fn(&Point) -> f64,
    ) -> Vec<interpolate::Point> {
        self.points.iter().filter_map(|point| Some((cost(point)?, error(point)))).collect()
    }

    /// Returns the observed order of an error.
    pub fn order(&self, error: impl Fn(&Point) -> f64) -> Option<f64> {
        interpolate::order(&self.cost_against_error(|point| Some(f64::from(point.steps)), error))
    }

    /// Returns the point at a number of steps.
    pub fn at(&self, steps: u32) -> Option<&Point> {
        self.points.iter().find(|point| point.steps == steps)
    }
}

/// Computes the errors of every method at every setting, with costs not yet measured.
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

/// Shortest turn of a setting in a round; it takes as many runs as fit.
const TURN: Duration = Duration::from_millis(2);

/// Runs one round: every setting has its turn and keeps the shortest time.
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

/// Times one run; ns a drive period.
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
    fn methods_have_their_known_orders() {
        let reference = reference::make(&standard()).unwrap();
        let curves = errors(&reference, true).unwrap();
        let of = |name: &str| curves.iter().find(|curve| curve.method.name == name).unwrap();
        let known = [("rk4-plain", 1.9, 2.1), ("rk4-fair", 1.9, 2.1), ("rk4-events", 3.9, 4.5), ("linexp-4", 3.9, 4.5)];
        for (name, least, most) in known {
            let order = of(name).order(|point| point.errors.force).unwrap();
            assert!((least..most).contains(&order), "{name}: {order}");
        }
        // Without feedback the error does not fall with the step: it is the effect of friction on
        // the motion.
        assert!(of("frozen").points.iter().all(|point| (5e-3..1e-2).contains(&point.errors.force)));
        // Scaling does not change the errors at equal steps.
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
