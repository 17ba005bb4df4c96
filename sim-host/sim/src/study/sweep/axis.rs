//! One key and its values, as written by a user: `key=start:stop:n`, `key=start:stop:n:log` or
//! `key=a,b,c`.
//!
//! ```text
//! even   value i of n = start + (stop - start) i / (n - 1)
//! log    value i of n = start (stop / start)^(i / (n - 1))
//! ```
//!
//! Values between the ends are rounded to fifteen digits.

use std::str::FromStr;

use super::SweepError;
use scene::Over;

/// A key of a scene with the range of a sample, as written by a user: `key=least:most` or
/// `key=least:most:log`.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    /// Path of the key: tables and key, joined by dots.
    pub key: String,
    /// Smallest and largest value.
    pub ends: (f64, f64),
    /// `true` if the logarithm is drawn uniformly, not the value.
    pub log: bool,
}

impl Range {
    /// Returns the value at a fraction of the range, from 0 to 1.
    pub fn value(&self, part: f64) -> f64 {
        between(self.ends.0, self.ends.1, self.log, part)
    }

    /// Returns the fraction of the range at which a value is.
    pub fn part(&self, value: f64) -> f64 {
        let (start, stop) = self.ends;
        if self.log { (value / start).ln() / (stop / start).ln() } else { (value - start) / (stop - start) }
    }
}

/// A key of a scene with its values.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Path of the key: tables and key, joined by dots.
    pub key: String,
    values: Values,
}

#[derive(Clone, Debug, PartialEq)]
enum Values {
    Range { start: f64, stop: f64, count: u64, log: bool },
    List(Vec<f64>),
}

impl From<&Over> for Axis {
    /// Creates an axis of a scene's grid.
    fn from(over: &Over) -> Self {
        let values = match (over.from, over.to, over.points) {
            (Some(start), Some(stop), Some(count)) => Values::Range { start, stop, count: count.into(), log: over.log },
            _ => Values::List(over.values.clone()),
        };
        Axis { key: over.key.clone(), values }
    }
}

impl Axis {
    /// Creates an axis of `count` values of a range.
    pub fn of_range(range: &Range, count: u64) -> Self {
        let (start, stop) = range.ends;
        Axis { key: range.key.clone(), values: Values::Range { start, stop, count, log: range.log } }
    }

    /// Creates an axis of one value.
    pub fn of_value(key: &str, value: f64) -> Self {
        Axis { key: key.to_owned(), values: Values::List(vec![value]) }
    }

    /// Returns the number of values.
    pub fn count(&self) -> u64 {
        match &self.values {
            Values::Range { count, .. } => *count,
            Values::List(list) => list.len() as u64,
        }
    }

    /// Returns one of the values, counted from zero.
    pub fn value(&self, index: u64) -> f64 {
        match &self.values {
            Values::List(list) => list.get(index as usize).copied().unwrap_or(f64::NAN),
            // The end equals the given number to the last bit.
            Values::Range { stop, count, .. } if index + 1 == *count => *stop,
            Values::Range { start, stop, count, log } => {
                let value = between(*start, *stop, *log, index as f64 / (count - 1) as f64);
                // The last digit is rounded: 0.2 reads better than 0.19999999999999996.
                format!("{value:.14e}").parse().unwrap_or(value)
            }
        }
    }

    /// Returns the smallest and the largest value.
    pub fn ends(&self) -> (f64, f64) {
        match &self.values {
            Values::Range { start, stop, .. } => (*start, *stop),
            Values::List(list) => {
                list.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &value| (least.min(value), most.max(value)))
            }
        }
    }

    /// Returns `true` if neighbours have equal ratios, not equal distances.
    pub fn is_log(&self) -> bool {
        matches!(self.values, Values::Range { log: true, .. })
    }

    /// Returns the value at a part of the distance between two values.
    pub fn between(&self, from: f64, to: f64, part: f64) -> f64 {
        between(from, to, self.is_log(), part)
    }

    /// Returns `true` if the values are listed, and so may be unevenly spaced.
    pub fn is_list(&self) -> bool {
        matches!(self.values, Values::List(_))
    }

    /// Returns all values, if there are at most `most`.
    pub fn listed(&self, most: u64) -> Option<Vec<f64>> {
        (self.count() <= most).then(|| (0..self.count()).map(|index| self.value(index)).collect())
    }
}

/// Returns the number at a fraction of a range, from 0 to 1.
fn between(start: f64, stop: f64, log: bool, part: f64) -> f64 {
    // `libm::pow` is identical on every machine; the system's power differs in the last bit.
    if log { start * libm::pow(stop / start, part) } else { start + (stop - start) * part }
}

impl FromStr for Axis {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let (key, values) = split(text)?;
        let values = if values.contains(':') {
            range(text, &values.split(':').collect::<Vec<_>>())?
        } else {
            let list = values.split(',').map(|value| number(text, value)).collect::<Result<Vec<_>, _>>()?;
            if let Some((at, twice)) = list.iter().enumerate().find(|&(at, value)| list[..at].contains(value)) {
                return Err(wrong(text, format!("value {} repeats {twice}", at + 1)));
            }
            Values::List(list)
        };
        Ok(Axis { key, values })
    }
}

impl FromStr for Range {
    type Err = SweepError;

    fn from_str(text: &str) -> Result<Self, SweepError> {
        let (key, values) = split(text)?;
        let parts: Vec<&str> = values.split(':').collect();
        let (ends, log) = match parts[..] {
            [least, most] => ((least, most), false),
            [least, most, way] if way.trim() == "log" => ((least, most), true),
            _ => return Err(wrong(text, "a sample needs a range, least:most or least:most:log".to_owned())),
        };
        Ok(Range { key, ends: self::ends(text, ends, log)?, log })
    }
}

fn wrong(text: &str, why: String) -> SweepError {
    SweepError::Axis { text: text.to_owned(), why }
}

/// Splits an axis into its key and the text after `=`.
fn split(text: &str) -> Result<(String, &str), SweepError> {
    text.split_once('=')
        .map(|(key, values)| (key.trim().to_owned(), values.trim()))
        .filter(|(key, values)| !key.is_empty() && !values.is_empty())
        .ok_or_else(|| wrong(text, "it lacks its key, its `=` or its values".to_owned()))
}

fn number(text: &str, number: &str) -> Result<f64, SweepError> {
    let value = number.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    value.ok_or_else(|| wrong(text, format!("`{}` is not a number", number.trim())))
}

/// Parses the two ends of a range, in order.
fn ends(text: &str, (start, stop): (&str, &str), log: bool) -> Result<(f64, f64), SweepError> {
    let (start, stop) = (number(text, start)?, number(text, stop)?);
    if start >= stop {
        let how = if start == stop { "is empty" } else { "runs backwards" };
        return Err(wrong(text, format!("the range from {start} to {stop} {how}: write the smaller end first")));
    }
    if log && start <= 0.0 {
        return Err(wrong(text, format!("the range from {start} cannot be logarithmic: it must begin above zero")));
    }
    Ok((start, stop))
}

fn range(text: &str, parts: &[&str]) -> Result<Values, SweepError> {
    let (asked, count, log) = match parts {
        [start, stop, count] => ((*start, *stop), count, false),
        [start, stop, count, way] if way.trim() == "log" => ((*start, *stop), count, true),
        [_, _, _, way] => return Err(wrong(text, format!("`{}` is not a spacing: omit it, or write `log`", way.trim()))),
        _ => return Err(wrong(text, "a range is start:stop:n or start:stop:n:log".to_owned())),
    };
    let asked_count = number(text, count)?;
    if asked_count.fract() != 0.0 || !(2.0..=1e15).contains(&asked_count) {
        return Err(wrong(text, format!("`{}` is not a number of values: give a whole number of at least 2", count.trim())));
    }
    let (start, stop) = ends(text, asked, log)?;
    Ok(Values::Range { start, stop, count: asked_count as u64, log })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(text: &str) -> Axis {
        text.parse().unwrap_or_else(|error| panic!("{error}"))
    }

    #[test]
    fn values_are_those_of_the_definition() {
        assert_eq!(axis("a.b=1:2:5").listed(9), Some(vec![1.0, 1.25, 1.5, 1.75, 2.0]));
        assert_eq!(axis("a.b=1e4:1e7:4:log").listed(9), Some(vec![1e4, 1e5, 1e6, 1e7]));
        assert_eq!(axis("a.b = 3, -1,2").listed(9), Some(vec![3.0, -1.0, 2.0]));
        assert_eq!((axis("a=3,-1,2").ends(), axis("a=7").count()), ((-1.0, 3.0), 1));
        // The end is exact although thirds are not.
        assert_eq!(axis("a=0.1:0.7:4").value(3), 0.7);
        assert_eq!(axis("a=0:1:1e12").listed(100), None);
    }

    #[test]
    fn a_sample_is_drawn_from_a_range() {
        let range: Range = "a.b=1:100:log".parse().expect("a range");
        assert_eq!((range.ends, range.value(0.5)), ((1.0, 100.0), 10.0));
        assert_eq!("a=-1:1".parse::<Range>().expect("a range").value(0.25), -0.5);
        for (text, why) in [("a=1:2:3", "least:most"), ("a=1", "least:most"), ("a=2:1", "backwards"), ("a=0:1:log", "above zero")]
        {
            let error = text.parse::<Range>().expect_err(text).to_string();
            assert!(error.contains(why) && error.contains(text), "{text}: {error}");
        }
    }

    #[test]
    fn invalid_axes_are_reported_with_the_reason() {
        for (text, why) in [
            ("a", "lacks its key"),
            ("=1,2", "lacks its key"),
            ("a=", "lacks its key"),
            ("a=1:2", "start:stop:n"),
            ("a=1:2:3:lin", "is not a spacing"),
            ("a=1:x:3", "`x` is not a number"),
            ("a=1:inf:3", "`inf` is not a number"),
            ("a=1:2:1", "whole number of at least 2"),
            ("a=1:2:2.5", "whole number of at least 2"),
            ("a=2:1:3", "backwards"),
            ("a=1:1:3", "empty"),
            ("a=0:1:3:log", "above zero"),
            ("a=1,2,1", "value 3 repeats 1"),
        ] {
            let error = text.parse::<Axis>().expect_err(text).to_string();
            assert!(error.contains(why) && error.contains(text), "{text}: {error}");
        }
    }
}
