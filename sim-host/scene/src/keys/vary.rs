//! `[[vary]]`: numbers that are drawn anew in each run of a scene with several `runs`: true values
//! of the plant, or nominal values of the controller.
//!
//! With a number `x` of the scene and `u`, uniform in `[0, 1)`:
//!
//! ```text
//! spread = s      x (1 + s (2 u - 1))      uniform within s of the value, relative
//! factor = k      x k^(2 u - 1)            log-uniform from x / k to x k
//! from, to        from + (to - from) u     uniform
//! ```

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A number of the scene that is drawn anew in each of its `runs`; without effect if `runs` is 1.
/// Give `spread`, or `factor`, or `from` and `to`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Vary {
    /// Path of the number, a true value of the plant or a nominal value of the controller: tables
    /// and key, separated by dots.
    pub key: String,
    /// Uniform within this part of the scene's value on either side.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1e-9, max = 10.0))]
    pub spread: Option<f64>,
    /// Log-uniform, from the scene's value divided by this factor to the value times this factor.
    #[serde(skip_serializing_if = "Option::is_none")]
    #[schemars(range(min = 1.0, max = 1e3))]
    pub factor: Option<f64>,
    /// Lower end of a uniform distribution, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub from: Option<f64>,
    /// Upper end of the uniform distribution, in the unit of the key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub to: Option<f64>,
}

impl Vary {
    /// Returns the number at `part` of its range, from 0 to 1; `own` is the scene's own value.
    pub fn value(&self, own: f64, part: f64) -> f64 {
        let sided = 2.0 * part - 1.0;
        match (self.spread, self.factor, self.from, self.to) {
            (Some(spread), ..) => own * (1.0 + spread * sided),
            (None, Some(factor), ..) => own * libm::pow(factor, sided),
            (None, None, Some(from), Some(to)) => from + (to - from) * part,
            _ => own,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn vary(spread: Option<f64>, factor: Option<f64>, range: Option<(f64, f64)>) -> Vary {
        let (from, to) = range.unzip();
        Vary { key: "stack.bvd.q".into(), spread, factor, from, to }
    }

    #[test]
    fn values_match_the_distributions() {
        let at = |vary: &Vary| [0.0, 0.5, 1.0].map(|part| vary.value(-50.0, part));
        assert_eq!(at(&vary(Some(0.1), None, None)), [-45.0, -50.0, -55.00000000000001]);
        assert_eq!(at(&vary(None, Some(2.0), None)), [-25.0, -50.0, -100.0]);
        assert_eq!(at(&vary(None, None, Some((1.0, 4.0)))), [1.0, 2.5, 4.0]);
    }
}
