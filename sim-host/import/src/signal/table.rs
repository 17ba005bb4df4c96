//! Columns of a file in any known format, for a signal: by name or number, and the column of times.

use std::ops::Range;
use std::path::Path;

use columns::{Column, Heading, Table, Unit, heading::is_time_name};

use super::SignalError;

/// Maximum number of names that a message lists.
const MAX_LISTED: usize = 16;
/// Smallest similarity of a suggested name.
const MIN_SIMILARITY: f64 = 0.75;
/// First words of the names of times.
const TIME_WORDS: [&str; 6] = ["time", "t", "zeit", "seconds", "timestamp", "elapsed"];

/// Columns of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    names: Vec<String>,
    table: Table,
}

impl Columns {
    /// Reads a file; its format follows from its contents.
    ///
    /// # Errors
    /// Returns an error if it does not contain a table.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, SignalError> {
        let table = columns::parse(bytes, None).map_err(|error| {
            let line = error.line().map_or_else(String::new, |line| format!("line {line}: "));
            SignalError::Form { path: path.to_owned(), why: format!("{line}{error}") }
        })?;
        Ok(Columns { names: table.headings(), table })
    }

    /// Returns the name of a column.
    pub(super) fn name(&self, place: usize) -> &str {
        &self.names[place]
    }

    /// Lists the names for a message.
    pub(super) fn listed(&self) -> String {
        let mut text = self.names.iter().take(MAX_LISTED).cloned().collect::<Vec<_>>().join(", ");
        if self.names.len() > MAX_LISTED {
            text += &format!(" and {} more", self.names.len() - MAX_LISTED);
        }
        text
    }

    /// Returns the place of a row in the file, as text.
    pub(super) fn at(&self, row: usize) -> String {
        self.table.place(row)
    }

    /// Returns the index of the column with this name, or with this number from 1.
    pub(super) fn place(&self, path: &Path, name: &str) -> Result<usize, SignalError> {
        let exact = self.names.iter().position(|known| known == name);
        let number = |name: &str| {
            name.parse::<usize>().ok().filter(|number| (1..=self.names.len()).contains(number)).map(|number| number - 1)
        };
        // `t [ms]` is the column `t` with its unit, and `t` may be the column `t [ms]`.
        let bare = || {
            let heading = Heading::new(name, is_time_name);
            let is_named = |known: &String| {
                let own = Heading::new(known, is_time_name);
                let fits = own.unit == heading.unit || own.unit.is_none() || heading.unit.is_none();
                known == heading.name || own.name == heading.name && fits
            };
            let mut named = (0..self.names.len()).filter(|at| is_named(&self.names[*at]));
            let only = named.next().filter(|_| named.next().is_none());
            only.or_else(|| number(heading.name).filter(|_| name.ends_with(']')))
        };
        exact.or_else(|| number(name)).or_else(bare).ok_or_else(|| {
            let alike = |known: &&String| strsim::jaro_winkler(&known.to_lowercase(), &name.to_lowercase());
            let nearest =
                self.names.iter().max_by(|a, b| alike(a).total_cmp(&alike(b))).filter(|known| alike(known) > MIN_SIMILARITY);
            let mean = nearest.map_or_else(String::new, |known| format!("did you mean `{known}`? "));
            let known = format!("{mean}It has {}", self.listed());
            let known = if mean.is_empty() { format!("it has {}", self.listed()) } else { known };
            SignalError::Column { path: path.to_owned(), name: name.to_owned(), known }
        })
    }

    /// Returns the index of the only column apart from that of times.
    pub(super) fn only(&self, path: &Path, time: Option<usize>) -> Result<usize, SignalError> {
        let others: Vec<usize> = (0..self.names.len()).filter(|&place| Some(place) != time).collect();
        match others[..] {
            [only] => Ok(only),
            _ => Err(SignalError::Option(format!("{}: which column? Name one with --column: {}", path.display(), self.listed()))),
        }
    }

    /// Returns the index of the first column with a name of a time, or of the only one with a unit
    /// of time.
    pub(super) fn time(&self) -> Option<usize> {
        let mut by_unit = (0..self.names.len()).filter(|at| unit_of_time(Heading::new(&self.names[*at], is_time_name).unit));
        let only = by_unit.next().filter(|_| by_unit.next().is_none());
        let has_unit = |name: &String| is_time(name) && unit_of_time(Heading::new(name, is_time_name).unit);
        self.names.iter().position(has_unit).or_else(|| self.names.iter().position(|name| is_time(name))).or(only)
    }

    /// Returns the number of rows.
    pub(super) fn rows(&self) -> usize {
        self.table.rows()
    }

    /// Returns the rows without those at the beginning and the end in which a column is empty.
    pub(super) fn span(&self, place: usize) -> Range<usize> {
        let is_filled = |row: &usize| self.table.columns[place].word(*row) != Some("");
        let rows = 0..self.table.rows();
        let first = rows.clone().find(is_filled).unwrap_or(0);
        first..rows.rev().find(is_filled).map_or(first, |last| last + 1)
    }

    /// Returns the unit of a column of times, s; `None` if its name has none. `given` is the name
    /// that the user chose it by, and may have a unit too.
    pub(super) fn time_unit_s(&self, path: &Path, place: usize, given: Option<&str>) -> Result<Option<f64>, SignalError> {
        let name = self.name(place);
        let given = given.and_then(|given| Heading::new(given, is_time_name).unit);
        let own = Heading::new(name, is_time_name).unit.or(unit_word(name));
        if let Some((own, given)) = own.zip(given).filter(|(own, given)| Unit::parse(own) != Unit::parse(given)) {
            return Err(SignalError::Option(format!("--time gives the unit `{given}`, but the column `{name}` is in `{own}`")));
        }
        let written = own.or(given);
        let Some((written, second)) = written.zip(Unit::parse("s")) else { return Ok(None) };
        match Unit::parse_like(written, &second).and_then(|unit| unit.factor_to(&second)) {
            Some(factor) => Ok(Some(factor)),
            None => {
                let (path, name) = (path.to_owned(), name.to_owned());
                Err(SignalError::Unit { path, name, unit: written.to_owned() })
            }
        }
    }

    /// Returns the numbers of a column in these rows.
    pub(super) fn numbers(&self, path: &Path, place: usize, rows: &Range<usize>) -> Result<Vec<f64>, SignalError> {
        let column = &self.table.columns[place];
        let words = column.words.iter().filter(|(row, _)| rows.contains(row)).map(|(row, text)| (row - rows.start, text.clone()));
        let part = Column { values: column.values[rows.clone()].to_vec(), words: words.collect() };
        part.numbers().map(<[f64]>::to_vec).map_err(|cell| {
            let (path, name) = (path.to_owned(), self.names[place].clone());
            SignalError::Cell { path, place: self.at(rows.start + cell.row), name, what: cell.what }
        })
    }
}

/// Returns `true` for the heading of a time: a known name, or one that begins with a word for time
/// and has a unit of time.
fn is_time(name: &str) -> bool {
    let heading = Heading::new(name, is_time_name);
    let begins = || {
        heading.name.to_lowercase().split(|c: char| !c.is_alphanumeric()).next().is_some_and(|word| TIME_WORDS.contains(&word))
    };
    is_time_name(heading.name) || unit_of_time(heading.unit) && begins()
}

/// Returns the unit of time that is a word of a heading, as in `Time:ms` or `t_us_abs`; `None` if
/// there are several.
fn unit_word(name: &str) -> Option<&str> {
    let words = name.split(|c: char| !c.is_alphanumeric()).filter(|word| unit_of_time(Some(word)));
    let words: Vec<&str> = words.collect();
    match words[..] {
        [only] => Some(only),
        _ => None,
    }
}

fn unit_of_time(unit: Option<&str>) -> bool {
    let factor = unit.zip(Unit::parse("s")).and_then(|(unit, second)| Unit::parse_like(unit, &second)?.factor_to(&second));
    factor.is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_time_is_in_its_name() {
        let unit = |heading: &str, given: Option<&str>| {
            let columns = Columns::parse(Path::new("a.csv"), format!("{heading},u\n0,1\n1,2\n").as_bytes()).unwrap();
            let place = given.map_or(Ok(0), |given| columns.place(Path::new("a.csv"), given)).unwrap();
            columns.time_unit_s(Path::new("a.csv"), place, given).unwrap()
        };
        for (heading, given, expected) in [
            ("t [ms]", None, Some(1e-3)),
            ("ms", Some("ms"), Some(1e-3)),
            ("Time:ms", None, Some(1e-3)),
            ("t_us_abs", None, Some(1e-6)),
            ("t", Some("t [us]"), Some(1e-6)),
            ("t", None, None),
            ("time", Some("time"), None),
        ] {
            assert_eq!(unit(heading, given), expected, "{heading} {given:?}");
        }
    }

    #[test]
    fn columns_of_times_are_recognised_by_name() {
        for name in ["time_s", "Time [ms]", "t (µs)", "time", "time_from_the_edge_ms", "t", "Time (msec)", "x-axis [second]"] {
            assert!(is_time(name), "{name}");
        }
        for name in ["force_n", "tip_velocity_m_per_s", "temperature", "time_periods_of_the_excitation", ""] {
            assert!(!is_time(name), "{name}");
        }
    }
}
