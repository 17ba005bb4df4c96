//! Delimited text with any number of columns, some of which may contain words: the program's own
//! CSV files, and those of others.
//!
//! The last line determines the number of fields and the delimiter. The rows are the lines from the
//! last one upwards with that number of fields. The heading is the line before them, or the last of
//! the first lines without a number, if it contains names.

use crate::error::TableError;
use crate::form::{DELIMITERS, Delimiter, heading, without_comment};
use crate::text::{beginning, number};

/// A table whose columns may contain words.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedTable {
    /// Headings of the columns, if there are any.
    pub header: Option<Vec<String>>,
    /// Number of the line of each row, from 1.
    pub lines: Vec<usize>,
    /// Columns of the table.
    pub columns: Vec<Cells>,
}

/// The cells of a column.
#[derive(Clone, Debug, PartialEq)]
pub enum Cells {
    /// Numbers.
    Numbers(Vec<f64>),
    /// A column with something else in it: the first such row, and its content for a message.
    Other {
        /// The row, from 0.
        row: usize,
        /// The content.
        what: String,
    },
}

impl MixedTable {
    /// Returns the headings of the columns; `column 1` and so on if there are none.
    pub fn names(&self) -> Vec<String> {
        self.header.clone().unwrap_or_else(|| (1..=self.columns.len()).map(|place| format!("column {place}")).collect())
    }
}

/// Finds the table of a text.
///
/// # Errors
/// [`TableError::Empty`] and [`TableError::NoNumbers`].
pub fn read_mixed(text: &str) -> Result<MixedTable, TableError> {
    // Lines with their numbers from 1; a comment counts only as a possible heading.
    let numbered = || text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty());
    let data: Vec<(usize, &str)> =
        numbered().filter(|(_, line)| !without_comment(line).1).map(|(at, line)| (at + 1, line)).collect();
    let Some((_, last)) = data.last() else { return Err(TableError::Empty) };
    let delimiter = DELIMITERS.into_iter().find(|delimiter| delimiter.split(last).len() > 1).unwrap_or(Delimiter::Sign(','));
    // A delimiter after the last field either ends the line or is followed by an empty field: the
    // choice is the one with more lines like the last.
    let count_of_same_width = |ends: bool| {
        let width = delimiter.fields(last, ends).len();
        data.iter().filter(|(_, line)| delimiter.fields(line, ends).len() == width).count()
    };
    let ends = count_of_same_width(true) >= count_of_same_width(false);
    let width = delimiter.fields(last, ends).len();
    let begin = data.iter().rposition(|(_, line)| delimiter.fields(line, ends).len() != width).map_or(0, |place| place + 1);
    let rows = &data[begin..];
    let is_number = |field: &&str| number(field, false).or_else(|| number(field, true)).is_some();
    let names = |line: &str| {
        let fields = delimiter.fields(line, ends);
        fields.len() == width && !fields.iter().any(is_number) && fields.iter().any(|field| !field.is_empty())
    };
    // A row of the table has a number. The line above the first one is the heading, and lines above
    // that are a preamble.
    let above = rows.iter().take_while(|(_, line)| names(line)).count();
    let header = match (above.checked_sub(1), rows.first()) {
        (Some(last), _) => Some(delimiter.fields(rows[last].1, ends).into_iter().map(str::to_owned).collect()),
        (None, Some((first, _))) => {
            let before: Vec<&str> = text.lines().take(first - 1).collect();
            let is_heading = |line: &str| without_comment(line).1 && names(without_comment(line).0);
            let nearest = before.iter().rev().find(|line| !line.trim().is_empty());
            nearest.filter(|line| is_heading(line)).and_then(|_| heading(&before, delimiter))
        }
        (None, None) => None,
    };
    let rows = &rows[above..];
    // A comma is a decimal sign only if commas do not separate fields.
    let comma = delimiter.leaves_commas() && rows.iter().any(|(_, line)| line.contains(','));
    let mut columns = vec![Cells::Numbers(Vec::with_capacity(rows.len())); width];
    for (row, (_, line)) in rows.iter().enumerate() {
        for (column, field) in columns.iter_mut().zip(delimiter.fields(line, ends)) {
            let Cells::Numbers(numbers) = column else { continue };
            match number(field, comma).or_else(|| number(field, false)) {
                Some(value) => numbers.push(value),
                None => {
                    let what = if field.is_empty() { "empty".to_owned() } else { format!("`{}`", beginning(field)) };
                    *column = Cells::Other { row, what };
                }
            }
        }
    }
    if rows.is_empty() || columns.iter().all(|column| matches!(column, Cells::Other { row: 0, .. })) {
        return Err(TableError::NoNumbers);
    }
    Ok(MixedTable { header, columns, lines: rows.iter().map(|(line, _)| *line).collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_tables_are_read() {
        let cases = [
            "Oscilloscope X\nDate;1.1.\nt [ms];U [V]\n0,5;1,25\n1,5;1,5\n",
            "# a remark\n# t [ms],U [V]\n0.5,1.25\n1.5,1.5\n",
            "t[ms]\tU[V]\n0.5\t1.25\n1.5\t1.5\n",
            "\"t [ms]\",\"U [V]\"\r\n0.5,1.25\r\n1.5,1.5\r\n",
        ];
        for text in cases {
            let table = read_mixed(text).unwrap();
            assert_eq!(table.columns, [Cells::Numbers(vec![0.5, 1.5]), Cells::Numbers(vec![1.25, 1.5])], "{text}");
            let names = table.names();
            assert!(names[0].starts_with('t') && names[1].starts_with('U'), "{text}: {names:?}");
        }
    }

    #[test]
    fn words_stay_in_their_column() {
        let table = read_mixed("t,mode,v\n0,Run,1\n1,Run,\n").unwrap();
        let other = |row: usize, what: &str| Cells::Other { row, what: what.to_owned() };
        assert_eq!(table.columns, [Cells::Numbers(vec![0.0, 1.0]), other(0, "`Run`"), other(1, "empty")]);
    }

    #[test]
    fn a_trailing_delimiter_ends_a_line() {
        for text in ["t;v\n0;1;\n1;2;\n", "t;v;\n0;1;\n1;2;\n", "t\tv\n0\t1\t\n1\t2\t\n"] {
            let table = read_mixed(text).unwrap();
            assert_eq!(table.columns, [Cells::Numbers(vec![0.0, 1.0]), Cells::Numbers(vec![1.0, 2.0])], "{text}");
            assert_eq!(table.names(), ["t", "v"], "{text}");
        }
    }

    #[test]
    fn columns_without_a_heading_are_numbered() {
        let table = read_mixed("1 2\n3 4\n").unwrap();
        assert_eq!((table.names(), table.lines), (vec!["column 1".to_owned(), "column 2".to_owned()], vec![1, 2]));
    }

    #[test]
    fn non_tables_are_refused() {
        assert_eq!(read_mixed("").unwrap_err(), TableError::Empty);
        assert_eq!(read_mixed("base = \"contact\"\nmu = high\n").unwrap_err(), TableError::NoNumbers);
    }
}
