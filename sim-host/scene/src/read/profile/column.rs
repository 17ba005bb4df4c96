//! A column of a measured table, with its time or other axis, converted to the units of a scene.

use std::ops::Range;
use std::path::Path;

use columns::{Heading, Table, Unit, beginning, decode, file};

use crate::nearest::{listed, nearest, short};

/// Largest file, bytes.
const MAX_FILE_BYTES: u64 = 64 << 20;
/// Largest number of rows. A manifest contains all of them as text.
const MAX_ROWS: usize = 200_000;

/// Cause of a refusal: a part of the scene, or a line of the file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum About {
    /// The file as a whole.
    File,
    /// The choice of the column.
    Column,
    /// Unit of the column.
    Unit,
    /// The choice of the time column.
    Axis,
    /// Unit of the time.
    AxisUnit,
    /// A line of the file, from 1.
    Line(usize),
}

/// Reason why a column cannot be read.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Refusal {
    pub(crate) about: About,
    pub(crate) message: String,
    pub(crate) label: String,
    pub(crate) help: Option<String>,
}

impl Refusal {
    fn new(about: About, message: impl Into<String>, label: impl Into<String>) -> Self {
        Refusal { about, message: message.into(), label: label.into(), help: None }
    }

    fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }
}

/// A table and its text.
#[derive(Clone, Debug)]
pub(crate) struct Measured {
    /// Name of the file as the user gave it.
    pub(crate) name: String,
    /// Decoded text of the file.
    pub(crate) text: String,
    table: Table,
}

/// A column in the requested unit.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// Heading of the column.
    pub(crate) heading: String,
    /// Its values, in the requested unit.
    pub(crate) values: Vec<f64>,
    /// `true` if the column holds lengths but a velocity was requested.
    pub(crate) is_path: bool,
}

/// Reads and decodes the text of a file.
pub(crate) fn text_of(path: &Path, asked: &str) -> Result<String, Refusal> {
    let bytes = file::read(path, MAX_FILE_BYTES).map_err(|error| {
        let message = format!("the file `{}` cannot be read", short(asked));
        let label = match near_file(path) {
            Some(name) if error.kind() == std::io::ErrorKind::NotFound => format!("did you mean `{}`?", short(&name)),
            _ => error.to_string(),
        };
        Refusal::new(About::File, message, label).help(format!("the path that was tried is `{}`", path.display()))
    })?;
    let is_wide = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    if bytes.starts_with(&[0x1f, 0x8b]) || !is_wide && bytes.contains(&0) {
        let message = format!("the file `{}` is not a text file", short(asked));
        return Err(Refusal::new(About::File, message, "compressed or binary").help("unpack it, or save it as CSV"));
    }
    Ok(decode(&bytes))
}

/// Returns a file with a similar name in the same folder.
fn near_file(path: &Path) -> Option<String> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let names: Vec<String> =
        std::fs::read_dir(folder).ok()?.filter_map(|entry| entry.ok()?.file_name().into_string().ok()).take(10_000).collect();
    let name = path.file_name()?.to_str()?;
    nearest(name, names.iter().map(String::as_str)).first().map(|name| (*name).to_owned())
}

impl Measured {
    /// Parses the table of a text.
    pub(crate) fn from_text(name: &str, text: String) -> Result<Self, (Refusal, String)> {
        let read = columns::read(&text, None);
        match read {
            Ok(table) if table.lines.len() > MAX_ROWS => {
                let message = format!("`{}` has {} rows", short(name), table.lines.len());
                let label = format!("must have at most {MAX_ROWS} rows");
                Err((Refusal::new(About::File, message, label), text))
            }
            Ok(table) => Ok(Measured { name: name.to_owned(), text, table }),
            Err(error) => {
                let about = error.line().map_or(About::File, About::Line);
                let message = match about {
                    About::Line(_) => error.to_string(),
                    _ => format!("`{}` is not a table of numbers: {error}", short(name)),
                };
                let help = "a table has a heading such as `t [s],v [mm/s]`, and lines of numbers separated by commas, \
                            semicolons, tabs or blanks";
                Err((Refusal::new(about, message, "not a table of numbers").help(help), text))
            }
        }
    }

    /// Returns the bytes of a line of the text; lines are counted from 1.
    pub(crate) fn span(text: &str, line: usize) -> Range<usize> {
        let starts = std::iter::once(0).chain(text.match_indices('\n').map(|(at, _)| at + 1));
        let start = starts.clone().nth(line.saturating_sub(1)).unwrap_or(text.len());
        start..starts.clone().nth(line).map_or(text.len(), |next| next - 1)
    }

    /// Returns the line of a row, from 1.
    pub(crate) fn line(&self, row: usize) -> usize {
        self.table.lines.get(row).copied().unwrap_or(1)
    }

    /// Returns the headings, or the numbers of the columns if there are no headings.
    fn names(&self) -> Vec<String> {
        let numbers = || (1..=self.table.columns.len()).map(|number| number.to_string()).collect();
        self.table.names.clone().unwrap_or_else(numbers)
    }

    /// Returns the numbers of a column.
    fn numbers(&self, index: usize) -> Result<Vec<f64>, Refusal> {
        let Some(column) = self.table.columns.get(index) else { return Ok(Vec::new()) };
        // `-v [m/s]` has the other sign.
        let sign = if parts(&self.names()[index]).negative { -1.0 } else { 1.0 };
        column.numbers().map(|values| values.iter().map(|value| sign * value).collect()).map_err(|cell| {
            let message = format!("`{}` is {}", short(&self.names()[index]), cell.what);
            Refusal::new(About::Line(self.line(cell.row)), message, "not a number")
        })
    }

    /// Returns the column of the time or other axis; `key` is the key that selects it.
    pub(crate) fn axis_index(&self, name: Option<&str>, key: &str) -> Result<usize, Refusal> {
        if let Some(name) = name {
            return self.index(name, About::Axis, key);
        }
        let names = self.names();
        match &self.table.names {
            None => Ok(0),
            Some(_) => names.iter().position(|name| parts(name).is_time()).ok_or_else(|| {
                let message = format!("`{}` has no column `t` or `time`", short(&self.name));
                let help = format!(
                    "`{key} = …` selects another column; the columns are {}",
                    listed(names.iter().map(String::as_str), "and")
                );
                Refusal::new(About::File, message, "which column is the axis?").help(help)
            }),
        }
    }

    /// Returns the selected column; without a name, the only one other than `other`.
    pub(crate) fn value_index(&self, name: Option<&str>, other: usize) -> Result<usize, Refusal> {
        if let Some(name) = name {
            return self.index(name, About::Column, "column");
        }
        let names = self.names();
        match names.len() {
            2 => Ok(1 - other.min(1)),
            count => {
                let rest = names.iter().enumerate().filter(|(at, _)| *at != other).map(|(_, name)| name.as_str());
                let message = format!("`{}` has {} columns other than `{}`", short(&self.name), count - 1, names[other]);
                let help = format!("select one with `column`: {}", listed(rest, "or"));
                Err(Refusal::new(About::File, message, "which column is it?").help(help))
            }
        }
    }

    /// Returns the selected column of a table without an axis; without a name, its only one.
    pub(crate) fn only_index(&self, name: Option<&str>) -> Result<usize, Refusal> {
        let names = self.names();
        match (name, names.len()) {
            (Some(name), _) => self.index(name, About::Column, "column"),
            (None, 1) => Ok(0),
            (None, count) => {
                let message = format!("`{}` has {count} columns", short(&self.name));
                let help = format!("select one with `column`: {}", listed(names.iter().map(String::as_str), "or"));
                Err(Refusal::new(About::File, message, "which column is it?").help(help))
            }
        }
    }

    /// Returns the column with this heading, with or without its unit, or with this number from 1.
    fn index(&self, name: &str, about: About, key: &str) -> Result<usize, Refusal> {
        let (asked, names) = (name.trim(), self.names());
        let plain = |text: &str| text.trim().to_lowercase();
        let whole = names.iter().position(|name| plain(name) == plain(asked));
        let by_name = || {
            let fits = |name: &&String| plain(parts(name).name) == plain(asked);
            let first = names.iter().position(|name| fits(&name));
            first.filter(|_| names.iter().filter(fits).count() == 1)
        };
        let by_number = || asked.parse::<usize>().ok()?.checked_sub(1).filter(|at| *at < names.len());
        whole.or_else(by_name).or_else(by_number).ok_or_else(|| {
            let bare: Vec<&str> = names.iter().map(|name| parts(name).name).collect();
            let near = nearest(asked, names.iter().map(String::as_str)).first().copied();
            let near = near.or_else(|| nearest(asked, bare.iter().copied()).first().copied());
            let label =
                near.map_or(format!("`{key}` must be one of its columns"), |near| format!("did you mean `{}`?", short(near)));
            let message = format!("`{}` has no column `{}`", short(&self.name), short(asked));
            Refusal::new(about, message, label).help(format!("it has {}", listed(names.iter().map(String::as_str), "and")))
        })
    }

    /// Returns a column without conversion, and its unit.
    pub(crate) fn unconverted(&self, index: usize, given: Option<&str>) -> Result<(Column, Option<String>), Refusal> {
        let heading = self.names().get(index).cloned().unwrap_or_default();
        let unit = given.or(parts(&heading).unit).map(str::to_owned);
        Ok((Column { heading, values: self.numbers(index)?, is_path: false }, unit))
    }

    /// Returns a column in a unit; `axis` is the key of the unit of an axis. If a velocity is
    /// requested, a length is also accepted: then `is_path` is `true`.
    pub(crate) fn column(
        &self,
        index: usize,
        given: Option<&str>,
        wanted: Option<&Unit>,
        axis: Option<&str>,
    ) -> Result<Column, Refusal> {
        let heading = self.names().get(index).cloned().unwrap_or_default();
        let (column, unit_key) = axis.map_or((About::Column, "unit"), |key| (About::Axis, key));
        let about_unit = if axis.is_some() { About::AxisUnit } else { About::Unit };
        let values = self.numbers(index)?;
        let written = given.or(parts(&heading).unit).map(str::trim).filter(|unit| !unit.is_empty());
        let shown = short(&beginning(&heading));
        let about = if given.is_some() { about_unit } else { column };
        let Some(wanted) = wanted else {
            // Without a unit there is nothing to convert.
            return match written.filter(|unit| !["1", "-"].contains(unit)) {
                Some(unit) => {
                    let message = format!("`{shown}` is in {}, but a number without a unit is needed", short(unit));
                    Err(Refusal::new(about, message, "expected no unit").help("`unit = \"1\"` declares that it has no unit"))
                }
                None => Ok(Column { heading, values, is_path: false }),
            };
        };
        let Some(written) = written else {
            let message = format!("the column `{shown}` has no unit");
            let label = format!("needs `{unit_key}`");
            let help = format!("write it in the heading, as `{shown} [{0}]`, or give `{unit_key} = \"{0}\"`", wanted.symbol);
            return Err(Refusal::new(column, message, label).help(help));
        };
        let Some(unit) = Unit::parse_like(written, wanted).filter(|unit| !unit.is_ambiguous()) else {
            let message = match Unit::parse(written) {
                Some(_) => format!("`{}` may be milli or mega", short(written)),
                None => format!("there is no unit `{}`", short(written)),
            };
            let label = format!("`{shown}` needs a unit that can be converted to {}", wanted.symbol);
            return Err(Refusal::new(about, message, label)
                .help("use an SI unit, also with a prefix p, n, u, m, c or k: for example `mm/s`, `kN` or `ms`"));
        };
        let velocity = Unit::parse("m/s").filter(|velocity| velocity.measures_like(wanted));
        let length = Unit::parse("m").filter(|length| velocity.is_some() && length.measures_like(&unit));
        let (factor, is_path) = match (unit.factor_to(wanted), &length) {
            (Some(factor), _) => (factor, false),
            (None, Some(metre)) => (unit.factor_to(metre).unwrap_or(1.0), true),
            (None, None) => {
                let message = format!("`{shown}` is in {}, but {} is needed", unit.symbol, wanted.symbol);
                return Err(Refusal::new(about, message, format!("{} cannot be converted to {}", unit.symbol, wanted.symbol)));
            }
        };
        Ok(Column { heading, values: values.iter().map(|value| value * factor).collect(), is_path })
    }
}

/// Splits the heading of a column.
fn parts(heading: &str) -> Heading<'_> {
    Heading::new(heading, columns::heading::is_time_name)
}

/// Returns the speeds of a path, m/s, with their times: the slope between two samples, at the
/// middle between them. The ends have the adjacent slopes.
pub(crate) fn speeds(time_s: &[f64], path_m: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let pairs = time_s.windows(2).zip(path_m.windows(2));
    let slopes: Vec<(f64, f64)> =
        pairs.map(|(time, path)| (0.5 * (time[0] + time[1]), (path[1] - path[0]) / (time[1] - time[0]))).collect();
    let ends = |time: Option<&f64>, slope: Option<&(f64, f64)>| time.copied().zip(slope.map(|slope| slope.1));
    let first = ends(time_s.first(), slopes.first());
    let last = ends(time_s.last(), slopes.last());
    first.into_iter().chain(slopes).chain(last).unzip()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_becomes_its_speeds() {
        let (time, speed) = speeds(&[0.0, 1.0, 3.0], &[0.0, 2.0, 2.0]);
        assert_eq!((time, speed), (vec![0.0, 0.5, 2.0, 3.0], vec![2.0, 2.0, 0.0, 0.0]));
    }

    #[test]
    fn a_minus_in_the_heading_turns_the_sign() {
        let table = Measured::from_text("a.csv", "t [s],-v [mm/s]\n0,1\n1,2\n".to_owned()).unwrap();
        let column = table.column(1, None, Unit::parse("m/s").as_ref(), None).unwrap();
        assert_eq!((column.values, table.unconverted(1, None).unwrap().0.values), (vec![-1e-3, -2e-3], vec![-1.0, -2.0]));
    }

    #[test]
    fn lines_are_found_in_a_text() {
        let text = "a\nbc\n\nd";
        assert_eq!([1, 2, 4].map(|line| &text[Measured::span(text, line)]), ["a", "bc", "d"]);
        assert_eq!(Measured::span(text, 9), 7..7);
    }
}
