//! A prediction and the verdict on it.

use super::data::{Datum, Kind};
use report::significant;

/// What a model says of a datum.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// The datum, by its name.
    pub datum: String,
    /// The model and where its parameters are from.
    pub model: String,
    /// Data that its parameters were fitted to, by their names.
    pub fitted_to: &'static [&'static str],
    /// The result of the model.
    pub found: Found,
}

/// Result of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum Found {
    /// A number, in the unit of the datum.
    Value(f64),
    /// Whether a sentence holds, and the numbers that say so.
    Sentence {
        /// Whether the sentence holds.
        holds: bool,
        /// The model's numbers.
        numbers: String,
    },
    /// Numbers between which the model says nothing, as a parameter is unknown.
    Between {
        /// The least.
        from: f64,
        /// The most.
        to: f64,
        /// The parameter that is unknown.
        unknown: &'static str,
    },
}

/// Verdict on a prediction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The prediction, whose parameters were fixed beforehand, is within the uncertainty of the datum; or the sentence holds.
    Agrees,
    /// The parameters were fitted to this datum, and meet it: no confirmation.
    Fitted,
    /// It is not within the uncertainty, fitted or not; or the sentence does not hold.
    Misses,
    /// A prediction of a number that was not at hand.
    Open,
    /// A parameter is unknown, and the result depends on it.
    Undetermined,
}

impl Verdict {
    /// The word in tables.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::Fitted => "FITTED",
            Verdict::Misses => "MISS",
            Verdict::Open => "OPEN PREDICTION",
            Verdict::Undetermined => "undetermined",
        }
    }
}

impl Prediction {
    /// A prediction of a number with nothing fitted.
    pub fn of(datum: &str, model: impl Into<String>, value: f64) -> Self {
        Self::found(datum, model, Found::Value(value))
    }

    /// Numbers between which the model says nothing, by a parameter that is unknown.
    pub fn between(datum: &str, model: impl Into<String>, [from, to]: [f64; 2], unknown: &'static str) -> Self {
        Self::found(datum, model, Found::Between { from, to, unknown })
    }

    fn found(datum: &str, model: impl Into<String>, found: Found) -> Self {
        Prediction { datum: datum.into(), model: model.into(), fitted_to: &[], found }
    }

    /// A sentence that holds or not, with nothing fitted.
    pub fn sentence(datum: &str, model: impl Into<String>, holds: bool, numbers: String) -> Self {
        Self::found(datum, model, Found::Sentence { holds, numbers })
    }

    /// The same with parameters that were fitted to data.
    pub fn fitted_to(self, fitted_to: &'static [&'static str]) -> Self {
        Prediction { fitted_to, ..self }
    }

    /// The verdict. A number that is none misses.
    pub fn verdict(&self, datum: &Datum) -> Verdict {
        let meets = match (&self.found, datum.value, datum.uncertainty) {
            (Found::Between { .. }, ..) => return Verdict::Undetermined,
            (Found::Sentence { holds, .. }, ..) => *holds,
            (Found::Value(found), Some(value), Some(within)) => (found - value).abs() <= within,
            (Found::Value(_), None, _) if datum.kind == Kind::Number => return Verdict::Open,
            (Found::Value(_), ..) => false,
        };
        match (meets, self.fitted_to.contains(&self.datum.as_str())) {
            (true, true) => Verdict::Fitted,
            (true, false) => Verdict::Agrees,
            (false, _) => Verdict::Misses,
        }
    }

    /// The model's number, or numbers.
    pub fn shown(&self, datum: &Datum) -> String {
        let unit = datum.unit.as_deref().unwrap_or("%");
        match &self.found {
            Found::Value(value) => format!("{value:.2} {unit}"),
            Found::Sentence { numbers, .. } => numbers.clone(),
            Found::Between { from, to, unknown } => {
                // Round-off below zero is no reduction.
                let shown = |value: f64| format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0);
                format!("{} to {} {unit}; not known: {unknown}", shown(*from), shown(*to))
            }
        }
    }

    /// Prediction less datum, of numbers.
    pub fn deviation(&self, datum: &Datum) -> Option<f64> {
        match (&self.found, datum.value) {
            (Found::Value(found), Some(value)) => Some(found - value),
            _ => None,
        }
    }

    /// What the parameters were fitted to.
    pub fn fitted(&self) -> String {
        if self.fitted_to.is_empty() { "nothing".into() } else { self.fitted_to.join(", ") }
    }
}

/// Numbers in a row, in per cent.
pub fn list(values: &[f64]) -> String {
    values.iter().map(|&value| significant(value)).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn datum(kind: Kind, value: Option<f64>) -> Datum {
        let of_number = value.map(|_| 0.5);
        Datum {
            id: "x".into(),
            kind,
            says: String::new(),
            conditions: String::new(),
            value,
            unit: None,
            uncertainty: of_number,
            uncertainty_is: None,
            at: None,
            not_comparable: None,
            decides: None,
        }
    }

    #[test]
    fn a_number_agrees_within_its_uncertainty_only() {
        let measured = datum(Kind::Number, Some(62.0));
        let verdict = |value: f64| Prediction::of("x", "m", value).verdict(&measured);
        assert_eq!(
            [61.5, 62.5, 62.51, f64::NAN].map(verdict),
            [Verdict::Agrees, Verdict::Agrees, Verdict::Misses, Verdict::Misses]
        );
    }

    #[test]
    fn what_was_fitted_to_it_confirms_nothing() {
        let measured = datum(Kind::Number, Some(62.0));
        let fitted = |to: &'static [&'static str], value: f64| Prediction::of("x", "m", value).fitted_to(to).verdict(&measured);
        assert_eq!(fitted(&["x"], 62.0), Verdict::Fitted);
        assert_eq!(fitted(&["y"], 62.0), Verdict::Agrees);
        assert_eq!(fitted(&["x"], 63.0), Verdict::Misses);
    }

    #[test]
    fn a_number_that_is_not_at_hand_leaves_the_prediction_open() {
        assert_eq!(Prediction::of("x", "m", 49.9).verdict(&datum(Kind::Number, None)), Verdict::Open);
        let words = datum(Kind::Words, None);
        assert_eq!(Prediction::sentence("x", "m", true, String::new()).verdict(&words), Verdict::Agrees);
        assert_eq!(Prediction::sentence("x", "m", false, String::new()).verdict(&words), Verdict::Misses);
        // A number says nothing of a sentence.
        assert_eq!(Prediction::of("x", "m", 1.0).verdict(&words), Verdict::Misses);
    }
}
