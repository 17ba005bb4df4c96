//! Delimited text with any number of columns, some of which may hold words: the program's own CSV files, and those of others.
//!
//! The last line says how many fields a row has and what separates them. Rows are the lines from the last one upwards that have as many; the line
//! before them, or the first of them, is the heading where it names something.

use super::table::{Cells, Columns};
use delimited::{decode, number};

/// What separates fields, in the order in which they are tried; the last are blanks.
const DELIMITERS: [Option<char>; 4] = [Some(';'), Some('\t'), Some(','), None];
/// Signs with which a comment begins.
const COMMENT: [&str; 4] = ["#", "!", "%", "//"];

fn fields(line: &str, delimiter: Option<char>) -> Vec<&str> {
    match delimiter {
        Some(sign) => {
            line.strip_suffix(sign).unwrap_or(line).split(sign).map(|field| field.trim().trim_matches('"').trim()).collect()
        }
        None => line.split_whitespace().collect(),
    }
}

fn bare(line: &str) -> Option<&str> {
    COMMENT.iter().find_map(|sign| line.strip_prefix(sign)).map(str::trim)
}

/// The columns of a text.
pub(super) fn read(bytes: &[u8]) -> Result<Columns, String> {
    if bytes.contains(&0) && !bytes.starts_with(&[0xff, 0xfe]) && !bytes.starts_with(&[0xfe, 0xff]) {
        return Err("a binary file of no known form; known are CSV and other delimited text, NPY and Parquet".to_owned());
    }
    let text = decode(bytes);
    let lines: Vec<(usize, &str)> = text
        .lines()
        .enumerate()
        .map(|(at, line)| (at + 1, line.trim_end()))
        .filter(|(_, line)| !line.trim().is_empty())
        .collect();
    let Some((_, last)) = lines.iter().rev().find(|(_, line)| bare(line).is_none()) else {
        return Err("it is empty".to_owned());
    };
    let delimiter = DELIMITERS.into_iter().find(|&delimiter| fields(last, delimiter).len() > 1).unwrap_or(Some(','));
    let width = fields(last, delimiter).len();
    let data: Vec<(usize, usize, &str)> = lines
        .iter()
        .enumerate()
        .filter(|(_, (_, line))| bare(line).is_none())
        .map(|(place, &(number, line))| (place, number, line))
        .collect();
    let begin = data.iter().rposition(|(_, _, line)| fields(line, delimiter).len() != width).map_or(0, |place| place + 1);
    let mut rows = &data[begin..];
    let is_number = |field: &str| number(field, false).or_else(|| number(field, true)).is_some();
    let mut names: Option<Vec<String>> = None;
    let named = |fields: &[&str]| {
        fields.len() == width && fields.iter().all(|field| !is_number(field)) && fields.iter().any(|field| !field.is_empty())
    };
    // A row of the table has a number; what stands above the first one is the heading, and above that a preamble.
    let above = rows.iter().take_while(|(_, _, line)| named(&fields(line, delimiter))).count();
    if let Some((_, _, heading)) = above.checked_sub(1).map(|last| rows[last]) {
        names = Some(fields(heading, delimiter).into_iter().map(str::to_owned).collect());
        rows = &rows[above..];
    } else if let Some(&(place, ..)) = rows.first() {
        let above = place.checked_sub(1).and_then(|place| bare(lines[place].1)).map(|line| fields(line, delimiter));
        names = above.filter(|above| named(above)).map(|above| above.into_iter().map(str::to_owned).collect());
    }
    let names = names.unwrap_or_else(|| (1..=width).map(|place| format!("column {place}")).collect());
    // A decimal comma is one only where commas separate nothing.
    let comma = delimiter != Some(',') && rows.iter().any(|(_, _, line)| line.contains(','));
    let mut columns = vec![Cells::Numbers(Vec::with_capacity(rows.len())); width];
    for (row, (_, _, line)) in rows.iter().enumerate() {
        for (column, field) in columns.iter_mut().zip(fields(line, delimiter)) {
            if let Cells::Numbers(numbers) = column {
                match number(field, comma).or_else(|| number(field, false)) {
                    Some(value) => numbers.push(value),
                    None => {
                        let what =
                            if field.is_empty() { "empty".to_owned() } else { format!("`{}`", delimited::beginning(field)) };
                        *column = Cells::Other { row, what };
                    }
                }
            }
        }
    }
    if rows.is_empty() || columns.iter().all(|column| matches!(column, Cells::Other { row: 0, .. })) {
        return Err("no table of numbers; known are CSV and other delimited text, NPY and Parquet".to_owned());
    }
    Ok(Columns { names, cells: columns, lines: Some(rows.iter().map(|(_, number, _)| *number).collect()) })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_of_others_are_read() {
        let cases = [
            "Oscilloscope X\nDate;1.1.\nt [ms];U [V]\n0,5;1,25\n1,5;1,5\n",
            "# a remark\n# t [ms],U [V]\n0.5,1.25\n1.5,1.5\n",
            "t[ms]\tU[V]\n0.5\t1.25\n1.5\t1.5\n",
            "\"t [ms]\",\"U [V]\"\r\n0.5,1.25\r\n1.5,1.5\r\n",
        ];
        for text in cases {
            let columns = read(text.as_bytes()).unwrap();
            assert_eq!(columns.cells, [Cells::Numbers(vec![0.5, 1.5]), Cells::Numbers(vec![1.25, 1.5])], "{text}");
            assert!(columns.names[0].starts_with('t') && columns.names[1].starts_with('U'), "{text}: {:?}", columns.names);
        }
    }

    #[test]
    fn without_a_heading_columns_have_numbers() {
        let columns = read(b"1 2\n3 4\n").unwrap();
        assert_eq!((columns.names, columns.lines), (vec!["column 1".to_owned(), "column 2".to_owned()], Some(vec![1, 2])));
    }

    #[test]
    fn what_is_no_table_is_refused() {
        assert_eq!(read(b"").unwrap_err(), "it is empty");
        assert!(read(b"base = \"contact\"\nmu = high\n").unwrap_err().starts_with("no table of numbers"));
        assert!(read(&[1, 0, 2, 0]).unwrap_err().starts_with("a binary file of no known form"));
    }
}
