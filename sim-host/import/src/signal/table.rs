//! Columns of a file in any known format: names, and cells that may be numbers.

use std::path::Path;

use delimited::{Cells, TableError, decode, read_mixed};

use super::{SignalError, npy, parquet_file};

/// Maximum number of names that a message lists.
const MAX_LISTED: usize = 16;
/// Smallest similarity of a suggested name.
const MIN_SIMILARITY: f64 = 0.75;

/// Columns of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Columns {
    pub(super) names: Vec<String>,
    pub(super) cells: Vec<Cells>,
    /// Line number of each row; without it rows are counted.
    pub(super) lines: Option<Vec<usize>>,
}

impl Columns {
    /// Reads a file; its format follows from its contents.
    ///
    /// # Errors
    /// Returns an error if the format is unknown.
    pub fn parse(path: &Path, bytes: &[u8]) -> Result<Self, SignalError> {
        let read = match bytes {
            [b'P', b'A', b'R', b'1', ..] => parquet_file::read(bytes),
            [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => npy::read(bytes),
            _ => text(bytes),
        };
        read.map_err(|why| SignalError::Form { path: path.to_owned(), why })
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
        match self.lines.as_ref().and_then(|lines| lines.get(row)) {
            Some(line) => format!("line {line}"),
            None => format!("row {}", row + 1),
        }
    }

    /// Returns the index of the column with this name, or with this number from 1.
    pub(super) fn place(&self, path: &Path, name: &str) -> Result<usize, SignalError> {
        let exact = self.names.iter().position(|known| known == name);
        let number =
            || name.parse::<usize>().ok().filter(|number| (1..=self.names.len()).contains(number)).map(|number| number - 1);
        exact.or_else(number).ok_or_else(|| {
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

    /// Returns the index of the first column with a name of a time, and its unit in s.
    pub(super) fn time(&self) -> Option<(usize, f64)> {
        self.names.iter().enumerate().find_map(|(place, name)| Some((place, time_scale(name)?)))
    }

    /// Returns the numbers of a column.
    pub(super) fn numbers(&self, path: &Path, place: usize) -> Result<Vec<f64>, SignalError> {
        let cell = |row: usize, what: String| {
            let (path, name) = (path.to_owned(), self.names[place].clone());
            SignalError::Cell { path, place: self.at(row), name, what }
        };
        match &self.cells[place] {
            Cells::Other { row, what } => Err(cell(*row, what.clone())),
            Cells::Numbers(numbers) => match numbers.iter().position(|number| !number.is_finite()) {
                Some(row) => Err(cell(row, "not a finite number".to_owned())),
                None => Ok(numbers.clone()),
            },
        }
    }
}

/// Reads the columns of delimited text.
fn text(bytes: &[u8]) -> Result<Columns, String> {
    const KNOWN: &str = "known are CSV and other delimited text, NPY and Parquet";
    let is_wide = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    if bytes.contains(&0) && !is_wide {
        return Err(format!("a binary file of unknown format; {KNOWN}"));
    }
    let table = read_mixed(&decode(bytes)).map_err(|error| match error {
        TableError::Empty => error.to_string(),
        _ => format!("{error}; {KNOWN}"),
    })?;
    Ok(Columns { names: table.names(), cells: table.columns, lines: Some(table.lines) })
}

/// Returns the unit of a column of times in s, by its name: `time_s`, `time [ms]`, `t (us)`,
/// `Time`; none for another column.
pub(super) fn time_scale(name: &str) -> Option<f64> {
    let words: Vec<String> = name
        .split(|c: char| !c.is_alphanumeric() && !matches!(c, 'µ' | 'μ'))
        .filter(|word| !word.is_empty())
        .map(str::to_lowercase)
        .collect();
    let (first, rest) = words.split_first()?;
    if !matches!(first.as_str(), "time" | "t" | "zeit" | "seconds" | "timestamp") {
        return None;
    }
    match rest.last().map(String::as_str) {
        None | Some("s" | "sec" | "second" | "seconds") => Some(1.0),
        Some("ms") => Some(1e-3),
        Some("us" | "µs" | "μs") => Some(1e-6),
        Some("ns") => Some(1e-9),
        Some("min") => Some(60.0),
        Some("periods" | "excitation") => None,
        Some(_) => Some(1.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_without_a_table_are_refused() {
        assert_eq!(text(b"").unwrap_err(), "it is empty");
        assert!(text(b"base = \"contact\"\nmu = high\n").unwrap_err().starts_with("no table of numbers; known are CSV"));
        assert!(text(&[1, 0, 2, 0]).unwrap_err().starts_with("a binary file of unknown format"));
    }

    #[test]
    fn columns_of_times_are_recognised_by_name() {
        for (name, scale) in
            [("time_s", 1.0), ("Time [ms]", 1e-3), ("t (µs)", 1e-6), ("time", 1.0), ("time_from_the_edge_ms", 1e-3), ("t", 1.0)]
        {
            assert_eq!(time_scale(name), Some(scale), "{name}");
        }
        for name in ["force_n", "tip_velocity_m_per_s", "temperature", "time_periods_of_the_excitation", ""] {
            assert_eq!(time_scale(name), None, "{name}");
        }
    }
}
