//! Claims of the thesis, and their verdicts by the thesis's equations.
//!
//! A claim is judged by checks. Each gives the choice made for a point that the thesis leaves open,
//! the numbers, and the result. All checks hold: reproduced. None holds: refuted. Otherwise the
//! claim is conditional on the conditions of the checks.

/// Verdict on a claim.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// The claim holds in every check.
    Reproduced,
    /// The claim holds in some checks.
    Conditional,
    /// The claim holds in no check.
    Refuted,
}

impl Verdict {
    /// Returns the word for the verdict.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Reproduced => "reproduced",
            Verdict::Conditional => "conditional",
            Verdict::Refuted => "refuted",
        }
    }
}

/// Check of a claim under one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// Choice made for a point that the thesis leaves open.
    pub condition: String,
    /// `true` if the claim holds under this condition.
    pub holds: bool,
    /// Numbers that support the result: name with unit, value.
    pub numbers: Vec<(String, f64)>,
}

/// Claim with its checks.
#[derive(Clone, Debug, PartialEq)]
pub struct Claim {
    /// Short name of the claim.
    pub id: &'static str,
    /// Section, equation or figure of the thesis.
    pub section: &'static str,
    /// The claim, in our words.
    pub says: &'static str,
    /// Computed checks of the claim.
    pub checks: Vec<Check>,
}

impl Check {
    /// Creates a check from its condition, result and numbers.
    pub fn new(condition: impl Into<String>, holds: bool, numbers: Vec<(String, f64)>) -> Self {
        Check { condition: condition.into(), holds, numbers }
    }
}

impl Claim {
    /// Returns the verdict of the checks.
    pub fn verdict(&self) -> Verdict {
        let holding = self.checks.iter().filter(|check| check.holds).count();
        match holding {
            0 => Verdict::Refuted,
            _ if holding == self.checks.len() => Verdict::Reproduced,
            _ => Verdict::Conditional,
        }
    }

    /// Returns the conditions under which the claim holds, or fails.
    pub fn conditions(&self, holds: bool) -> Vec<&str> {
        self.checks.iter().filter(|check| check.holds == holds).map(|check| check.condition.as_str()).collect()
    }
}

/// Names numbers by the values of a parameter: `r(192 N)`, `r(384 N)`, ...
pub fn series(name: &str, labels: &[String], values: &[f64]) -> Vec<(String, f64)> {
    labels.iter().zip(values).map(|(label, &value)| (format!("{name}({label})"), value)).collect()
}

/// Pairs a number with its name.
pub fn number(name: impl Into<String>, value: f64) -> (String, f64) {
    (name.into(), value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_verdict_follows_the_checks() {
        let claim = |holds: &[bool]| Claim {
            id: "x",
            section: "4",
            says: "x",
            checks: holds.iter().enumerate().map(|(i, &holds)| Check::new(i.to_string(), holds, Vec::new())).collect(),
        };
        assert_eq!(claim(&[true, true]).verdict(), Verdict::Reproduced);
        assert_eq!(claim(&[false, false]).verdict(), Verdict::Refuted);
        let mixed = claim(&[true, false]);
        assert_eq!(
            (mixed.verdict(), mixed.conditions(true), mixed.conditions(false)),
            (Verdict::Conditional, vec!["0"], vec!["1"])
        );
    }
}
