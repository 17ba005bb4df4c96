//! Tables of measured data. Columns may contain words, such as the condition of a measurement.
//!
//! ```text
//! preamble | comments | names | [units] | rows | [footer]
//! ```
//!
//! The rows are the lines with a number that have the most frequent number of cells. The line
//! directly above them has the names, or the units below the names. A line within or after the rows
//! that looks like a row but is not one is an error, never the end of the table.

use crate::error::TableError;
use crate::form::{Form, without_comment};
use crate::heading::is_time_name;
use crate::text::{beginning, is_overflow, number};
use crate::unit::Unit;

/// Largest number of lines, which bounds the time and the memory of a read.
const MAX_LINES: usize = 10_000_000;

/// A table.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Names of the columns; a unit in a line of its own is appended as `name [unit]`.
    pub names: Option<Vec<String>>,
    /// Number of the line of each row, from 1; empty for a binary file.
    pub lines: Vec<usize>,
    /// The columns; all have the same number of rows. A column without any content is left out, and
    /// one without a name that is mostly empty.
    pub columns: Vec<Column>,
    /// Description of the form, for a reader.
    pub found: String,
}

/// A column of a table.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Column {
    /// Number in each row; NaN if the cell is not a number.
    pub values: Vec<f64>,
    /// Rows, from 0, whose cell is not a number, with its content.
    pub words: Vec<(usize, String)>,
}

/// A cell that is not a number.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BadCell {
    /// Row, from 0.
    pub row: usize,
    /// Content of the cell, for a message.
    pub what: String,
}

impl Column {
    /// Returns the numbers of the column.
    ///
    /// # Errors
    /// Returns the first cell that is not a number.
    pub fn numbers(&self) -> Result<&[f64], BadCell> {
        match self.words.first() {
            None => match self.values.iter().position(|value| !value.is_finite()) {
                Some(row) => Err(BadCell { row, what: "not a finite number".to_owned() }),
                None => Ok(&self.values),
            },
            Some((row, text)) => {
                let what = match text.as_str() {
                    "" => "empty".to_owned(),
                    text if is_overflow(text) => format!("`{}`, the overflow value of an instrument", beginning(text)),
                    text => format!("`{}`", beginning(text)),
                };
                Err(BadCell { row: *row, what })
            }
        }
    }

    /// Returns the text of a cell that is not a number.
    pub fn word(&self, row: usize) -> Option<&str> {
        let at = self.words.binary_search_by_key(&row, |(row, _)| *row).ok()?;
        Some(&self.words[at].1)
    }

    /// Returns the number of cells with content.
    pub fn filled(&self) -> usize {
        self.values.len() - self.words.iter().filter(|(_, text)| text.is_empty()).count()
    }

    /// Adds a cell.
    fn push(&mut self, number: Option<f64>, text: &str) {
        if number.is_none() {
            self.words.push((self.values.len(), text.to_owned()));
        }
        self.values.push(number.unwrap_or(f64::NAN));
    }
}

impl Table {
    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// Returns the place of a row in the file, as text.
    pub fn place(&self, row: usize) -> String {
        self.lines.get(row).map_or_else(|| format!("row {}", row + 1), |line| format!("line {line}"))
    }

    /// Returns the table of these rows, in ascending order.
    #[must_use]
    pub fn selected(&self, rows: &[usize]) -> Self {
        let column = |column: &Column| {
            let mut selected = Column::default();
            for &row in rows {
                let value = column.values[row];
                selected.push((!value.is_nan()).then_some(value), column.word(row).unwrap_or_default());
            }
            selected
        };
        let lines = rows.iter().filter_map(|row| self.lines.get(*row).copied()).collect();
        Table { names: self.names.clone(), lines, columns: self.columns.iter().map(column).collect(), found: self.found.clone() }
    }

    /// Replaces the names of the columns by given ones, separated by commas.
    ///
    /// # Errors
    /// If their number is wrong.
    pub(crate) fn renamed(self, names: Option<&str>) -> Result<Self, TableError> {
        let Some(names) = names else { return Ok(self) };
        let names: Vec<String> = names.split(',').map(|name| name.trim().to_owned()).collect();
        if names.len() == self.columns.len() {
            return Ok(Table { names: Some(names), ..self });
        }
        Err(TableError::Width { line: 1, columns: self.columns.len(), names: names.len(), decimal_comma: false })
    }

    /// Returns the names of the columns; `column 1` and so on if they have none.
    pub fn headings(&self) -> Vec<String> {
        self.names.clone().unwrap_or_else(|| (1..=self.columns.len()).map(|place| format!("column {place}")).collect())
    }
}

/// A line of a text that has content and is not a comment.
struct Line<'a> {
    /// Index in the text, from 0.
    at: usize,
    text: &'a str,
    /// Number of cells.
    cells: usize,
    /// Number of cells up to the last one with content.
    filled: usize,
    /// `true` if a cell is a number.
    has_number: bool,
}

/// Finds the table of a text. `names`, separated by commas, replaces the heading if given.
///
/// # Errors
/// [`TableError`], with the line that causes it.
pub fn read(text: &str, names: Option<&str>) -> Result<Table, TableError> {
    let lines = text.bytes().filter(|byte| *byte == b'\n').count();
    if lines > MAX_LINES {
        return Err(TableError::Long { lines, most: MAX_LINES });
    }
    let all: Vec<&str> = text.lines().collect();
    let form = Form::find(&all);
    let lines: Vec<Line> = all
        .iter()
        .enumerate()
        .filter(|(_, text)| !text.trim().is_empty() && !without_comment(text).1)
        .map(|(at, text)| Line::new(form, at, text))
        .collect();
    let Some(first) = lines.first() else { return Err(TableError::Empty) };
    let with_number = || lines.iter().filter(|line| line.has_number);
    let Some(cells) = most_frequent(with_number().map(|line| line.cells)) else {
        return Err(TableError::NoNumbers { begins: beginning(first.text) });
    };
    let width = with_number().filter(|line| line.cells == cells).map(|line| line.filled).max().unwrap_or(cells);
    let is_row = |line: &Line| line.has_number && line.cells >= width && line.filled <= width;
    let last = lines.iter().rposition(is_row).unwrap_or(0);
    let begin = lines[..=last].iter().rposition(|line| !is_row(line)).map_or(0, |at| at + 1);
    let rows = &lines[begin..=last];

    let mut columns = vec![Column::default(); width];
    for row in rows {
        let mut cells = form.cells(row.text);
        for column in &mut columns {
            let cell = cells.next().unwrap_or_default();
            column.push(form.number(cell), cell);
        }
    }
    check_outside(&lines, begin, last, width, &columns, form)?;
    check_commas(rows, form)?;
    let width_error = |names: usize| TableError::Width {
        line: rows[0].at + 1,
        columns: width,
        names,
        decimal_comma: form.has_commas() && width == 2 * names,
    };
    let mut found_names = heading(&all, rows[0].at, width, cells, form).map_err(width_error)?;
    // Without names, a column that is filled in a few rows describes the instrument.
    let least = if found_names.is_some() { 1 } else { rows.len().div_ceil(2) };
    let filled: Vec<bool> = columns.iter().map(|column| column.filled() >= least).collect();
    let keep = |at: usize| filled.get(at).copied().unwrap_or(false);
    let mut at = 0..;
    columns.retain(|_| at.next().is_some_and(keep));
    if let Some(names) = &mut found_names {
        let mut at = 0..;
        names.retain(|_| at.next().is_some_and(keep));
    }
    Table { names: found_names, lines: rows.iter().map(|row| row.at + 1).collect(), columns, found: form.to_string() }
        .renamed(names)
        .map_err(|error| match error {
            TableError::Width { names, .. } => width_error(names),
            error => error,
        })
}

impl<'a> Line<'a> {
    fn new(form: Form, at: usize, text: &'a str) -> Self {
        let (mut cells, mut filled, mut has_number) = (0, 0, false);
        for cell in form.cells(text) {
            cells += 1;
            if !cell.is_empty() {
                filled = cells;
                has_number = has_number || form.number(cell).is_some();
            }
        }
        Line { at, text, cells, filled, has_number }
    }
}

/// Returns `true` for the name of a usual axis: a time, a frequency or a displacement.
fn is_axis(name: &str) -> bool {
    is_time_name(name) || ["f", "freq", "frequency", "x"].contains(&name.trim().to_lowercase().as_str())
}

/// Returns the most frequent of some numbers of cells; the larger one if two are equally frequent.
fn most_frequent(widths: impl Iterator<Item = usize>) -> Option<usize> {
    let mut counts = std::collections::BTreeMap::new();
    widths.for_each(|width| *counts.entry(width).or_insert(0) += 1);
    counts.into_iter().max_by_key(|&(_, count)| count).map(|(width, _)| width)
}

/// Refuses a line outside the rows that belongs to them: one above with a number in each column of
/// numbers, one below with numbers or with as many cells as a row.
fn check_outside(
    lines: &[Line],
    begin: usize,
    last: usize,
    width: usize,
    columns: &[Column],
    form: Form,
) -> Result<(), TableError> {
    let refuse = |line: &Line| {
        let at = line.at + 1;
        Err(match line.has_number {
            false => TableError::Interrupted { line: at, begins: beginning(line.text) },
            true => TableError::Cells { line: at, cells: line.cells, columns: width },
        })
    };
    let numeric: Vec<bool> = columns.iter().map(|column| column.words.is_empty()).collect();
    let is_row_above = |line: &Line| {
        let mut cells = form.cells(line.text);
        line.filled == width
            && numeric.iter().all(|numeric| cells.next().is_some_and(|cell| !numeric || form.number(cell).is_some()))
    };
    if let Some(before) = begin.checked_sub(1) {
        // A line of numbers only is a row that was cut, unless it is a single one.
        let is_cut =
            lines[before].filled > 1 && form.cells(lines[before].text).all(|cell| cell.is_empty() || form.number(cell).is_some());
        if is_cut || numeric.contains(&true) && lines[..before].iter().any(is_row_above) {
            return refuse(&lines[before]);
        }
    }
    let below = lines[last + 1..].iter().find(|line| line.has_number || line.filled == width);
    below.map_or(Ok(()), refuse)
}

/// Refuses a table whose commas may all separate thousands, such as `39,000`. A single number that
/// cannot have thousands, such as `0,5` or `1,25`, shows that they are decimal commas.
fn check_commas(rows: &[Line], form: Form) -> Result<(), TableError> {
    if !form.has_decimal_commas() {
        return Ok(());
    }
    let cells = || rows.iter().flat_map(|row| form.cells(row.text).map(move |cell| (row, cell)));
    let mut numbers = cells().filter(|(_, cell)| cell.contains(',') && form.number(cell).is_some()).peekable();
    let Some(&(row, cell)) = numbers.peek() else { return Ok(()) };
    let is_of_thousands = |cell: &str| {
        let digits = cell.trim().trim_start_matches(['+', '-']);
        let (first, rest) = digits.split_once(',').unwrap_or((digits, ""));
        let is_group = |group: &str| group.len() == 3 && group.bytes().all(|digit| digit.is_ascii_digit());
        (1..=3).contains(&first.len()) && !first.starts_with('0') && rest.split(',').all(is_group)
    };
    let mut has_points = cells().map(|(_, cell)| cell).filter(|cell| cell.contains('.') && number(cell, false).is_some());
    match numbers.all(|(_, cell)| is_of_thousands(cell)) || has_points.next().is_some() {
        true => Err(TableError::Comma { line: row.at + 1, cell: beginning(cell) }),
        false => Ok(()),
    }
}

/// Returns the names of the columns from the lines above the first row: the nearest line, with the
/// units of a line in between. A name above `width` belongs to a column without content. Fails with
/// the number of names if it differs from the width.
fn heading(lines: &[&str], first: usize, width: usize, all: usize, form: Form) -> Result<Option<Vec<String>>, usize> {
    let above = lines[..first].iter().rev().filter(|line| !line.trim().is_empty()).map(|line| {
        let (text, comment) = without_comment(line);
        let mut cells: Vec<&str> = form.cells(text).collect();
        if cells.len() == all {
            cells.truncate(width);
        }
        // After the names, some oscilloscopes write settings, as `tInc=1e-6`.
        while cells.len() > width && cells.last().is_some_and(|cell| cell.is_empty() || cell.contains('=')) {
            cells.pop();
        }
        (cells, comment)
    });
    let mut above = above.peekable();
    // Remarks may stand between heading and rows.
    if above.peek().is_some_and(|(cells, comment)| *comment && cells.len() != width) {
        while above.next_if(|(_, comment)| *comment).is_some() {}
    }
    let has_words = |cells: &[&str]| cells.iter().any(|cell| cell.chars().any(char::is_alphabetic));
    let Some((cells, _)) = above.next().filter(|(cells, _)| has_words(cells)) else { return Ok(None) };
    // Between blanks, `Frequency (Hz)` is one name.
    let joined = cells.iter().fold(Vec::new(), |mut names: Vec<String>, cell| {
        match names.last_mut().filter(|_| cell.starts_with(['(', '['])) {
            Some(name) => *name = format!("{name} {cell}"),
            None => names.push((*cell).to_owned()),
        }
        names
    });
    if form.has_blanks() && cells.len() != width && joined.len() == width {
        return Ok(Some(joined));
    }
    if cells.len() != width {
        // The last line of a preamble is not a heading.
        let is_heading = cells.len() > 1 && !form.has_blanks() && cells.iter().all(|cell| form.number(cell).is_none());
        return if is_heading { Err(cells.len()) } else { Ok(None) };
    }
    let bare = |unit: &str| unit.trim_matches(|c| "[](){}".contains(c)).trim().to_owned();
    let is_unit = |cell: &str| matches!(bare(cell).as_str(), "" | "-" | "1") || Unit::parse(&bare(cell)).is_some();
    let (are_units, is_any) =
        (cells.iter().all(|cell| is_unit(cell)), cells.iter().any(|cell| Unit::parse(&bare(cell)).is_some()));
    // An unknown unit among known ones, below names with an axis, must not become a name.
    let has_axis = |names: &[&str]| names.iter().any(|name| is_axis(name)) && !cells.iter().any(|cell| is_axis(cell));
    let is_of_names = |names: &[&str]| names.len() == width && has_words(names) && (are_units || is_any && has_axis(names));
    let names = above.next().filter(|(names, _)| is_of_names(names));
    Ok(Some(match names {
        Some((names, _)) => {
            let joined = |(name, unit): (&&str, &&str)| match bare(unit).as_str() {
                "" | "-" => (*name).to_owned(),
                unit => format!("{name} [{unit}]"),
            };
            names.iter().zip(&cells).map(joined).collect()
        }
        None => cells.into_iter().map(str::to_owned).collect(),
    }))
}

#[cfg(test)]
mod tests;
