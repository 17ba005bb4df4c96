//! What the thesis says, and whether its equations say so.
//!
//! A claim is judged by checks: each states under which choice of what the thesis leaves open it was computed, the numbers, and
//! whether the claim holds in them. All hold: reproduced. None holds: refuted. Else the claim is conditional, on what the checks name.

/// How a claim fared.
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
    /// The word for it.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Reproduced => "reproduced",
            Verdict::Conditional => "conditional",
            Verdict::Refuted => "refuted",
        }
    }
}

/// A claim in one computed situation.
#[derive(Clone, Debug, PartialEq)]
pub struct Check {
    /// What was chosen where the thesis leaves it open.
    pub condition: String,
    /// Whether the claim holds there.
    pub holds: bool,
    /// The numbers that say so: name with unit, value.
    pub numbers: Vec<(String, f64)>,
}

/// A claim with its checks.
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
    /// A check with its numbers.
    pub fn new(condition: impl Into<String>, holds: bool, numbers: Vec<(String, f64)>) -> Self {
        Check { condition: condition.into(), holds, numbers }
    }
}

impl Claim {
    /// The verdict of the checks.
    pub fn verdict(&self) -> Verdict {
        let holding = self.checks.iter().filter(|check| check.holds).count();
        match holding {
            0 => Verdict::Refuted,
            _ if holding == self.checks.len() => Verdict::Reproduced,
            _ => Verdict::Conditional,
        }
    }

    /// Conditions under which it holds, or does not.
    pub fn conditions(&self, holds: bool) -> Vec<&str> {
        self.checks.iter().filter(|check| check.holds == holds).map(|check| check.condition.as_str()).collect()
    }
}

/// Numbers that belong to values of a parameter: `r(192 N)`, `r(384 N)`, ...
pub fn series(name: &str, labels: &[String], values: &[f64]) -> Vec<(String, f64)> {
    labels.iter().zip(values).map(|(label, &value)| (format!("{name}({label})"), value)).collect()
}

/// A number with its name.
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
