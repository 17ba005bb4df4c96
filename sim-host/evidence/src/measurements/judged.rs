//! Predictions and their verdicts.

use super::data::{Datum, Kind};
use report::significant;

/// Prediction of a datum by a model.
#[derive(Clone, Debug, PartialEq)]
pub struct Prediction {
    /// Name of the datum.
    pub datum: String,
    /// Model and the origin of its parameters.
    pub model: String,
    /// Names of the data to which its parameters were fitted.
    pub fitted_to: &'static [&'static str],
    /// Result of the model.
    pub found: PredictionResult,
}

/// Result of a model.
#[derive(Clone, Debug, PartialEq)]
pub enum PredictionResult {
    /// Number in the unit of the datum.
    Value(f64),
    /// Verdict on a sentence, with the numbers that support it.
    Sentence {
        /// `true` if the sentence holds.
        holds: bool,
        /// Numbers of the model.
        numbers: String,
    },
    /// Interval of the result, as a parameter is unknown.
    Between {
        /// Lower end.
        from: f64,
        /// Upper end.
        to: f64,
        /// Unknown parameter.
        unknown: &'static str,
    },
}

/// Verdict on a prediction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verdict {
    /// The prediction, with parameters fixed beforehand, is within the uncertainty of the datum, or
    /// the sentence holds.
    Agrees,
    /// The parameters were fitted to this datum and reproduce it, which confirms nothing.
    Fitted,
    /// The prediction, fitted or not, is outside the uncertainty, or the sentence does not hold.
    Misses,
    /// The number to compare with was not available.
    Open,
    /// A parameter is unknown, and the result depends on it.
    Undetermined,
}

impl Verdict {
    /// Returns the word for tables.
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
    /// Returns a prediction of a number with nothing fitted.
    pub fn number(datum: &str, model: impl Into<String>, value: f64) -> Self {
        Self::found(datum, model, PredictionResult::Value(value))
    }

    /// Returns a prediction of an interval, with the name of the unknown parameter.
    pub fn between(datum: &str, model: impl Into<String>, [from, to]: [f64; 2], unknown: &'static str) -> Self {
        Self::found(datum, model, PredictionResult::Between { from, to, unknown })
    }

    fn found(datum: &str, model: impl Into<String>, found: PredictionResult) -> Self {
        Prediction { datum: datum.into(), model: model.into(), fitted_to: &[], found }
    }

    /// Returns a prediction of a sentence, which holds or not, with nothing fitted.
    pub fn sentence(datum: &str, model: impl Into<String>, holds: bool, numbers: String) -> Self {
        Self::found(datum, model, PredictionResult::Sentence { holds, numbers })
    }

    /// Sets the data to which the parameters were fitted.
    pub fn fitted_to(self, fitted_to: &'static [&'static str]) -> Self {
        Prediction { fitted_to, ..self }
    }

    /// Returns the verdict. NaN is a miss.
    pub fn verdict(&self, datum: &Datum) -> Verdict {
        let meets = match (&self.found, datum.value, datum.uncertainty) {
            (PredictionResult::Between { .. }, ..) => return Verdict::Undetermined,
            (PredictionResult::Sentence { holds, .. }, ..) => *holds,
            (PredictionResult::Value(found), Some(value), Some(within)) => (found - value).abs() <= within,
            (PredictionResult::Value(_), None, _) if datum.kind == Kind::Number => return Verdict::Open,
            (PredictionResult::Value(_), ..) => false,
        };
        match (meets, self.fitted_to.contains(&self.datum.as_str())) {
            (true, true) => Verdict::Fitted,
            (true, false) => Verdict::Agrees,
            (false, _) => Verdict::Misses,
        }
    }

    /// Formats the result of the model.
    pub fn shown(&self, datum: &Datum) -> String {
        let unit = datum.unit.as_deref().unwrap_or("%");
        match &self.found {
            PredictionResult::Value(value) => format!("{value:.2} {unit}"),
            PredictionResult::Sentence { numbers, .. } => numbers.clone(),
            PredictionResult::Between { from, to, unknown } => {
                // Adding zero turns -0.0 from round-off into 0.0.
                let shown = |value: f64| format!("{:.1}", (10.0 * value).round() / 10.0 + 0.0);
                format!("{} to {} {unit}; unknown: {unknown}", shown(*from), shown(*to))
            }
        }
    }

    /// Returns the prediction minus the datum, if both are numbers.
    pub fn deviation(&self, datum: &Datum) -> Option<f64> {
        match (&self.found, datum.value) {
            (PredictionResult::Value(found), Some(value)) => Some(found - value),
            _ => None,
        }
    }

    /// Formats the data to which the parameters were fitted.
    pub fn fitted(&self) -> String {
        if self.fitted_to.is_empty() { "nothing".into() } else { self.fitted_to.join(", ") }
    }
}

/// Joins numbers with commas.
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
        let verdict = |value: f64| Prediction::number("x", "m", value).verdict(&measured);
        assert_eq!(
            [61.5, 62.5, 62.51, f64::NAN].map(verdict),
            [Verdict::Agrees, Verdict::Agrees, Verdict::Misses, Verdict::Misses]
        );
    }

    #[test]
    fn agreement_with_fitted_data_confirms_nothing() {
        let measured = datum(Kind::Number, Some(62.0));
        let fitted =
            |to: &'static [&'static str], value: f64| Prediction::number("x", "m", value).fitted_to(to).verdict(&measured);
        assert_eq!(fitted(&["x"], 62.0), Verdict::Fitted);
        assert_eq!(fitted(&["y"], 62.0), Verdict::Agrees);
        assert_eq!(fitted(&["x"], 63.0), Verdict::Misses);
    }

    #[test]
    fn a_missing_number_leaves_the_prediction_open() {
        assert_eq!(Prediction::number("x", "m", 49.9).verdict(&datum(Kind::Number, None)), Verdict::Open);
        let words = datum(Kind::Words, None);
        assert_eq!(Prediction::sentence("x", "m", true, String::new()).verdict(&words), Verdict::Agrees);
        assert_eq!(Prediction::sentence("x", "m", false, String::new()).verdict(&words), Verdict::Misses);
        // A number cannot confirm a sentence.
        assert_eq!(Prediction::number("x", "m", 1.0).verdict(&words), Verdict::Misses);
    }
}
