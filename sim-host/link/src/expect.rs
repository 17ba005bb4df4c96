//! `expect`: a check of the last answer in a script.
//!
//! ```text
//! expect NAME = | != | < | <= | > | >=  VALUE  [+- TOLERANCE]
//! ```
//!
//! NAME is a field as `--format json` shows it; a field within a list is `resonances.0.q`. VALUE is
//! a number, or a word (`run`, `true`, `none`).

use serde_json::Value;

use crate::answer::Answer;
use crate::link_error::LinkError;
use scene::nearest::{listed, nearest};

/// Expected value of one field of the last answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Expect {
    name: String,
    relation: Relation,
    value: Expected,
    tolerance: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Equal,
    Unequal,
    Less,
    AtMost,
    More,
    AtLeast,
}

#[derive(Clone, Debug, PartialEq)]
enum Expected {
    Number(f64),
    Word(String),
}

impl Expect {
    /// Parses the words after `expect`. An error contains the index of the wrong word; an index
    /// after the last word means that a word is missing.
    pub fn parse(words: &[&str]) -> Result<Self, (usize, String)> {
        const FORM: &str = "expect NAME = VALUE [+- TOLERANCE]";
        let name = words.first().ok_or((0, format!("a field is missing: {FORM}")))?;
        let relation = match words.get(1) {
            Some(&"=") => Relation::Equal,
            Some(&"!=") => Relation::Unequal,
            Some(&"<") => Relation::Less,
            Some(&"<=") => Relation::AtMost,
            Some(&">") => Relation::More,
            Some(&">=") => Relation::AtLeast,
            _ => return Err((1, "one of = != < <= > >= is required here".into())),
        };
        let value = words.get(2).ok_or((2, format!("a value is missing: {FORM}")))?;
        let value = value.parse().map_or_else(|_| Expected::Word((*value).to_owned()), Expected::Number);
        if matches!(value, Expected::Word(_)) && !matches!(relation, Relation::Equal | Relation::Unequal) {
            return Err((2, "only numbers can be compared by < <= > >=".into()));
        }
        let tolerance = match words.get(3..) {
            None | Some([]) => 0.0,
            Some(["+-", tolerance]) => match tolerance.parse::<f64>() {
                Ok(tolerance) if tolerance >= 0.0 && relation == Relation::Equal => tolerance,
                _ => return Err((4, "a tolerance must be a non-negative number, and needs `=`".into())),
            },
            Some(_) => return Err((3, format!("only a tolerance may follow the value: {FORM}"))),
        };
        Ok(Expect { name: (*name).to_owned(), relation, value, tolerance })
    }

    /// Compares an answer with the expectation.
    pub fn judge(&self, answer: &Answer) -> Result<Answer, LinkError> {
        let found = find(answer, &self.name).ok_or_else(|| {
            let names = || answer.fields.keys().map(String::as_str);
            let similar = nearest(&self.name, names());
            let which = if similar.is_empty() { names().collect() } else { similar };
            LinkError::Failed(format!("`{}` has no field `{}`; it has {}", answer.command, self.name, listed(which, "and")))
        })?;
        let holds = match (&self.value, found.as_f64()) {
            (Expected::Number(value), Some(number)) => match self.relation {
                Relation::Equal => (number - value).abs() <= self.tolerance,
                Relation::Unequal => number != *value,
                Relation::Less => number < *value,
                Relation::AtMost => number <= *value,
                Relation::More => number > *value,
                Relation::AtLeast => number >= *value,
            },
            (Expected::Number(_), None) => self.relation == Relation::Unequal,
            (Expected::Word(value), _) => (shown(found) == *value) == (self.relation == Relation::Equal),
        };
        let line = format!("{} is {}", self.name, shown(found));
        if holds {
            Ok(Answer::to("expect").line(line).field(&self.name, found.clone()))
        } else {
            Err(LinkError::Failed(format!("{line}, expected {}", self.shown())))
        }
    }

    fn shown(&self) -> String {
        let relation = match self.relation {
            Relation::Equal => "=",
            Relation::Unequal => "!=",
            Relation::Less => "<",
            Relation::AtMost => "<=",
            Relation::More => ">",
            Relation::AtLeast => ">=",
        };
        let value = match &self.value {
            Expected::Number(number) => number.to_string(),
            Expected::Word(word) => word.clone(),
        };
        let tolerance = if self.tolerance > 0.0 { format!(" +- {}", self.tolerance) } else { String::new() };
        format!("{relation} {value}{tolerance}")
    }
}

/// Returns a field by its name, or by its path through lists.
fn find<'a>(answer: &'a Answer, name: &str) -> Option<&'a Value> {
    answer.fields.get(name).or_else(|| {
        let (first, rest) = name.split_once('.')?;
        rest.split('.').try_fold(answer.fields.get(first)?, |value, step| match step.parse::<usize>() {
            Ok(place) => value.get(place),
            Err(_) => value.get(step),
        })
    })
}

fn shown(value: &Value) -> String {
    match value {
        Value::Null => "none".into(),
        Value::String(text) => text.clone(),
        value => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn judged(text: &str) -> Result<(), String> {
        let answer = Answer::to("scan")
            .field("q", 65.2)
            .field("mode", "run")
            .field("fault", Value::Null)
            .field("locked", true)
            .field("limits.voltage_v", 10.0)
            .field("resonances", json!([{ "q": 65.0 }]));
        let words: Vec<&str> = text.split_whitespace().collect();
        let expect = Expect::parse(&words).map_err(|(place, why)| format!("{place}: {why}"))?;
        expect.judge(&answer).map(drop).map_err(|error| error.to_string())
    }

    #[test]
    fn correct_expectations_pass() {
        for text in [
            "q = 65 +- 0.3",
            "q > 65",
            "q >= 65.2",
            "q < 66",
            "q <= 65.2",
            "q != 65",
            "mode = run",
            "mode != idle",
            "fault = none",
            "fault != 12",
            "locked = true",
            "limits.voltage_v = 10",
            "resonances.0.q = 65",
        ] {
            assert_eq!(judged(text), Ok(()), "{text}");
        }
    }

    #[test]
    fn a_failed_expectation_shows_the_actual_value() {
        assert_eq!(judged("q = 65 +- 0.1"), Err("q is 65.2, expected = 65 +- 0.1".into()));
        assert_eq!(judged("mode = idle"), Err("mode is run, expected = idle".into()));
        assert_eq!(judged("fault = 12"), Err("fault is none, expected = 12".into())); // words: a value
        assert_eq!(judged("mod = run"), Err("`scan` has no field `mod`; it has `mode`".into()));
        assert_eq!(judged("q ~ 3"), Err("1: one of = != < <= > >= is required here".into()));
        assert_eq!(judged("mode > run"), Err("2: only numbers can be compared by < <= > >=".into()));
        assert_eq!(
            judged("q = 65 about 3"),
            Err("3: only a tolerance may follow the value: expect NAME = VALUE [+- TOLERANCE]".into())
        );
    }
}
