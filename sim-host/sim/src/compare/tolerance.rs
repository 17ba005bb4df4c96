//! How far two values of a metric may be apart.

use std::str::FromStr;

use super::CompareError;
use scene::metrics::known;

/// Standard deviations of a measurement that a value may be off by.
const DEVIATIONS: f64 = 2.0;

/// How far two values may be apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// In the metric's unit.
    Absolute(f64),
    /// Of the larger of the two.
    Relative(f64),
}

impl Tolerance {
    fn of(self, size: f64) -> f64 {
        match self {
            Tolerance::Absolute(most) => most,
            Tolerance::Relative(part) => part * size,
        }
    }
}

/// The tolerances of a comparison: of some metrics, and of all others.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tolerances {
    named: Vec<(String, Tolerance)>,
    others: Option<Tolerance>,
}

impl Tolerances {
    /// Tolerances as they are written: `1%` or `0.01` of all metrics, `METRIC=0.5` or `METRIC=2%` of one. Without one of all metrics they are to be the
    /// same.
    ///
    /// # Errors
    /// If one of them cannot be read, or names no metric.
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

    /// The most that two values of a metric may differ by: `size` is the larger of the two, `sd` the standard deviation of their difference as it was
    /// measured, which counts where the metric has no tolerance of its own.
    pub fn allowed(&self, metric: &str, size: f64, sd: f64) -> f64 {
        let named = self.named.iter().rev().find(|(name, _)| name == metric).map(|(_, tolerance)| tolerance.of(size));
        named.unwrap_or_else(|| self.others.map_or(0.0, |tolerance| tolerance.of(size)).max(DEVIATIONS * sd))
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
            _ => Err(format!("`{number}` is no number that is not below zero")),
        }
    }
}
