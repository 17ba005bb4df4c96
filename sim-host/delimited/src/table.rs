//! Tables of numbers in delimited text, with the delimiter, the decimal sign and the heading found
//! from the text.
//!
//! Every pair of delimiter and decimal sign is tried. The one that reads the longest run of lines
//! as numbers, with the same number of fields, is used. The lines before that run are a preamble,
//! whose last line with the same number of fields is the heading.

use crate::error::TableError;
use crate::form::{Delimiter, heading, without_comment};
use crate::text::{beginning, number};

/// A table of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Headings of the columns, if there are any.
    pub header: Option<Vec<String>>,
    /// Number of the line of each row, from 1.
    pub lines: Vec<usize>,
    /// Columns of the table.
    pub columns: Vec<Vec<f64>>,
    /// Description of the delimiter and decimal sign found, for a reader.
    pub found: String,
}

/// Pairs of delimiter and decimal comma, in the order of preference if they read equally many
/// lines.
const FORMS: [(Delimiter, bool); 7] = [
    (Delimiter::Sign(';'), true),
    (Delimiter::Sign(';'), false),
    (Delimiter::Sign('\t'), true),
    (Delimiter::Sign('\t'), false),
    (Delimiter::Sign(','), false),
    (Delimiter::Blank, true),
    (Delimiter::Blank, false),
];
/// Largest number of columns of a table.
const MAX_COLUMNS: usize = 64;

/// Returns the numbers of a line, if it has nothing else.
fn numbers(line: &str, (delimiter, comma): (Delimiter, bool)) -> Option<Vec<f64>> {
    let fields = delimiter.split(line);
    (2..=MAX_COLUMNS).contains(&fields.len()).then(|| fields.iter().map(|field| number(field, comma)).collect())?
}

/// Returns the longest run of lines of numbers with the same number of fields: index of its first
/// line, of the line after the last, and the number of lines.
fn longest(lines: &[&str], form: (Delimiter, bool)) -> (usize, usize, usize) {
    let (mut best, mut start, mut width, mut rows) = ((0, 0, 0), 0, 0, 0);
    for (at, line) in lines.iter().enumerate() {
        let (text, comment) = without_comment(line);
        if comment || text.is_empty() {
            continue;
        }
        let fields = numbers(line, form).map_or(0, |row| row.len());
        if fields == 0 || fields != width {
            (start, width, rows) = (at, fields, 0);
        }
        rows += usize::from(fields > 0);
        if rows > best.2 {
            best = (start, at + 1, rows);
        }
    }
    best
}

/// Finds the table of a text. `columns`, names separated by commas, replaces the heading if given.
///
/// # Errors
/// [`TableError`], with the line that causes it.
pub fn read(text: &str, columns: Option<&str>) -> Result<Table, TableError> {
    let lines: Vec<&str> = text.lines().collect();
    let runs = FORMS.map(|form| (form, longest(&lines, form)));
    // The first of the pairs that read equally many lines. A comma that separates two columns is
    // not a decimal sign.
    let best = runs.iter().rev().max_by_key(|(_, (.., rows))| *rows).copied();
    let Some((form, (start, end, rows))) = best.filter(|(_, (.., rows))| *rows > 0) else {
        let begins = lines.iter().find(|line| !line.trim().is_empty()).map_or("nothing".to_owned(), |line| beginning(line));
        return Err(TableError::NoTable { begins });
    };
    if rows < 2 {
        return Err(TableError::OneLine { line: start + 1 });
    }
    let header = match columns {
        Some(columns) => Some(columns.split(',').map(|name| name.trim().to_owned()).collect::<Vec<_>>()),
        None => heading(&lines[..start], form.0),
    };
    let mut table = Table {
        header,
        lines: Vec::with_capacity(rows),
        columns: Vec::new(),
        found: format!("{} between the fields, decimal {}", form.0.name(), if form.1 { "comma" } else { "point" }),
    };
    for (at, line) in lines.iter().enumerate().take(end).skip(start) {
        let (text, comment) = without_comment(line);
        if comment || text.is_empty() {
            continue;
        }
        let Some(row) = numbers(line, form) else { continue };
        table.columns.resize(row.len(), Vec::with_capacity(rows));
        table.lines.push(at + 1);
        table.columns.iter_mut().zip(row).for_each(|(column, value)| column.push(value));
    }
    if let Some(rest) = lines[end..].iter().position(|line| numbers(line, form).is_some()) {
        return Err(broken(&lines, end, end + rest));
    }
    if let Some(before) =
        lines[..start].iter().position(|line| numbers(line, form).is_some_and(|row| row.len() == table.columns.len()))
    {
        return Err(broken(&lines, before + 1, start));
    }
    check_width(&table)?;
    Ok(table)
}

/// Returns the error for the line that interrupts a table.
fn broken(lines: &[&str], from: usize, to: usize) -> TableError {
    let at = (from..to).find(|&at| !without_comment(lines[at]).0.is_empty()).unwrap_or(from);
    TableError::Interrupted { line: at + 1, begins: beginning(lines[at]) }
}

fn check_width(table: &Table) -> Result<(), TableError> {
    let Some(header) = &table.header else { return Ok(()) };
    if header.len() == table.columns.len() {
        return Ok(());
    }
    Err(TableError::Width {
        line: table.lines.first().copied().unwrap_or(1),
        numbers: table.columns.len(),
        names: header.len(),
        decimal_comma: table.found.starts_with("commas") && table.columns.len() == 2 * header.len(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiter_decimal_sign_and_heading_are_found() {
        let cases = [
            ("Date;1.1.\nf [Hz];R [ohm]\n40000,5;1,25\n40001,5;1,5\n", "semicolons between the fields, decimal comma"),
            ("# f [Hz],R [ohm]\n40000.5,1.25\n# a remark\n\n40001.5,1.5\n", "commas between the fields, decimal point"),
            ("f[Hz]\tR[ohm]\n40000.5\t1.25\n40001.5\t1.5\n", "tabs between the fields, decimal point"),
            ("f[Hz] R[ohm]\n 40000,5  1,25\n 40001,5 1,5\n", "blanks between the fields, decimal comma"),
        ];
        for (text, found) in cases {
            let table = read(text, None).unwrap();
            assert_eq!((table.found.as_str(), &table.columns), (found, &vec![vec![40000.5, 40001.5], vec![1.25, 1.5]]), "{text}");
            assert_eq!(table.header.map(|header| header.len()), Some(2));
        }
    }

    #[test]
    fn a_decimal_comma_between_commas_is_named() {
        let error = read("f [Hz],R [ohm]\n40000,5,1,25\n40001,5,1,5\n", None).unwrap_err().to_string();
        assert!(error.contains("export with semicolons"), "{error}");
    }

    #[test]
    fn a_line_that_interrupts_the_table_is_named() {
        let error = read("f,r\n1,2\n2,3\n3,overload\n4,5\n", None).unwrap_err();
        assert_eq!(error, TableError::Interrupted { line: 4, begins: "3,overload".to_owned() });
    }
}
