//! Allowed difference of two values of a metric.

use std::str::FromStr;

use super::CompareError;
use scene::metrics::known;

/// Number of standard deviations of a measurement by which a value may be off.
const DEVIATIONS: f64 = 2.0;

/// Allowed difference of two values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// In the metric's unit.
    Absolute(f64),
    /// Relative to the larger of the two values.
    Relative(f64),
}

impl Tolerance {
    fn allowed(self, size: f64) -> f64 {
        match self {
            Tolerance::Absolute(most) => most,
            Tolerance::Relative(part) => part * size,
        }
    }
}

/// Tolerances of a comparison: those of named metrics, and one for all others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerances {
    named: Vec<(String, Tolerance)>,
    others: Option<Tolerance>,
}

impl Tolerances {
    /// Parses tolerances: `1%` or `0.01` applies to all metrics, `METRIC=0.5` or `METRIC=2%` to
    /// one. Metrics without a tolerance must be equal.
    ///
    /// # Errors
    /// If one of them cannot be read, or names an unknown metric.
    pub fn parse(texts: &[String]) -> Result<Self, CompareError> {
        let mut tolerances = Tolerances::default();
        for text in texts {
            let wrong = |why: String| CompareError::Tolerance { text: text.clone(), why };
            match text.split_once('=') {
                Some((name, tolerance)) => {
                    let name = known(name.trim()).map_err(wrong)?;
                    tolerances.named.push((name.to_owned(), tolerance.parse().map_err(wrong)?));
                }
                None => tolerances.others = Some(text.parse().map_err(wrong)?),
            }
        }
        Ok(tolerances)
    }

    /// Returns the maximum difference of two values of a metric. `size` is the larger of the two,
    /// and `sd` the measured standard deviation of their difference, which counts if the metric has
    /// no tolerance of its own.
    pub fn allowed(&self, metric: &str, size: f64, sd: f64) -> f64 {
        let named = self.named.iter().rev().find(|(name, _)| name == metric).map(|(_, tolerance)| tolerance.allowed(size));
        named.unwrap_or_else(|| self.others.map_or(0.0, |tolerance| tolerance.allowed(size)).max(DEVIATIONS * sd))
    }
}

impl FromStr for Tolerance {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let (number, part) = text.strip_suffix('%').map_or((text, false), |number| (number.trim(), true));
        match number.parse::<f64>() {
            Ok(number) if number.is_finite() && number >= 0.0 => {
                Ok(if part { Tolerance::Relative(number / 100.0) } else { Tolerance::Absolute(number) })
            }
            _ => Err(format!("`{number}` is not a non-negative number")),
        }
    }
}
