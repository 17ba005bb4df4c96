//! Published laws, by formulas written here, compared with the models that should obey them.
//!
//! ```text
//! longitudinal   r = (2/pi) asin z                                          by bristles, kappa 1e13, in closed form
//! transverse     r = (2/pi) z/sqrt(1 + z^2) K(1/(1 + z^2)), K by the AGM    by bristles, kappa 1e13, collocation in two dimensions
//! Popov          its approximation                                          by the arcs of the compliant contact
//! critical speed mu kz w a / kx                                             by bisection to the speed at which the arcs no longer stick
//! ```
//!
//! The formulas share no code with the models.

use std::f64::consts::{FRAC_2_PI, FRAC_PI_2};

use super::data::Law;
use crate::evidence::Error;
use crate::precision::hard::directions;
use contact::Numerics;
use contact::closed::coulomb_friction_ratio;
use contact::compliant::{friction_ratio, solve};
use contact::plane::{self, Direction, coulomb};

/// Amplitude in bristle lengths at which bristles count as rigid.
const RIGID_BRISTLE_LENGTHS: f64 = 1e13;
/// Number of bisections of the bracket.
const BISECTIONS: u32 = 60;

/// Law at one point, by its formula and by models of this repository.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Argument of the law.
    pub at: f64,
    /// Value to four digits that was computed elsewhere, if available.
    pub checked: Option<f64>,
    /// Value by the formula.
    pub formula: f64,
    /// Name of each model and its value.
    pub models: Vec<(&'static str, f64)>,
}

impl Row {
    /// Returns the largest deviation of a model from the formula.
    pub fn off(&self) -> f64 {
        // Propagates NaN, which `max` alone would drop.
        let worse = |most: f64, off: f64| if most.is_nan() || off.is_nan() { f64::NAN } else { most.max(off) };
        self.models.iter().map(|(_, value)| (value - self.formula).abs()).fold(0.0, worse)
    }
}

/// Returns `true` if the models are within the law's tolerance of its formula, and the formula
/// matches the values computed elsewhere.
pub fn holds(law: &Law, rows: &[Row]) -> bool {
    let checked = |row: &Row| row.checked.is_none_or(|checked| (checked - row.formula).abs() <= 5e-5);
    rows.iter().all(|row| row.off() <= law.tolerance && checked(row))
}

/// Evaluates a law at its points.
pub fn rows(law: &Law) -> Result<Vec<Row>, Error> {
    law.points.iter().map(|point| row(&law.id, point[0], point.get(1).copied())).collect()
}

fn row(id: &str, at: f64, checked: Option<f64>) -> Result<Row, Error> {
    let (formula, models) = match id {
        "longitudinal" => (
            FRAC_2_PI * at.asin(),
            vec![("Coulomb, closed form", coulomb_friction_ratio(at)), ("bristles, kappa 1e13", bristles(at, 0.0)?)],
        ),
        "transverse" => (
            transverse(at),
            vec![("Coulomb, closed form", coulomb::friction_ratio(at, 90.0)), ("bristles, kappa 1e13", bristles(at, 90.0)?)],
        ),
        "popov" => (1.0 - 0.75 * (1.0 - at).powi(2) - 0.25 * (1.0 - at).powi(4), vec![("arcs", friction_ratio(1.0, at, true))]),
        "critical-speed" | "critical-speed-beyond" => (1.0, vec![("arcs, by bisection", critical(at)?)]),
        other => return Err(Error::Data(format!("no model obeys the law {other:?}"))),
    };
    Ok(Row { at, checked, formula, models })
}

/// Computes the transverse law with `K(m) = (pi / 2) / agm(1, sqrt(1 - m))` and
/// `1 - m = z^2 / (1 + z^2)`.
pub fn transverse(z: f64) -> f64 {
    let part = z / (1.0 + z * z).sqrt();
    let (mut a, mut b) = (1.0, part);
    while (a - b).abs() > 1e-15 * a {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    FRAC_2_PI * part * FRAC_PI_2 / a
}

/// Returns the friction ratio of Dahl's bristles that are far shorter than the vibration.
fn bristles(z: f64, angle_deg: f64) -> Result<f64, Error> {
    let problem = directions::bristles(RIGID_BRISTLE_LENGTHS, z);
    let numerics = Numerics { tolerance: 1e-9, ..Numerics::default() };
    if angle_deg == 0.0 {
        return Ok(contact::solve(&problem, &numerics, &mut |_| ())?.ratios.friction);
    }
    let solved = plane::solve(&problem, Direction::from_degrees(angle_deg), &numerics, (&|| (), None), false)?;
    Ok(solved.solution.ratios.friction)
}

/// Finds the lowest speed at which a contact of A never sticks, over `mu kz w a / kx`.
fn critical(indentations: f64) -> Result<f64, Error> {
    let sticks = |speed: f64| solve(&directions::contact(indentations, speed)).map(|solution| solution.stick_share > 0.0);
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (low + high);
        if sticks(middle)? { low = middle } else { high = middle }
    }
    Ok(0.5 * (low + high))
}
