//! NumPy arrays: records with named fields, as in this program's traces, or numbers in one or two
//! dimensions.
//!
//! A magic number, version, length of the header, the header as a Python dictionary, then the
//! values (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).

use super::table;
use crate::beginning;
use crate::table::{Column, Table};

/// Type of a stored number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Double,
    Single,
    Signed(usize),
    Unsigned(usize),
}

impl Kind {
    /// Parses a description like `<f8`. Only the byte order of all current processors is supported.
    fn parse(text: &str) -> Result<Self, String> {
        let unknown = || format!("values of the type `{text}`; known are <f8, <f4, and integers such as <i4 or |u1");
        let (order, kind) = text.split_at_checked(1).ok_or_else(unknown)?;
        match (order, kind) {
            ("<" | "|" | "=", "f8") => Ok(Kind::Double),
            ("<" | "|" | "=", "f4") => Ok(Kind::Single),
            ("<" | "|" | "=", "i1" | "i2" | "i4" | "i8") => Ok(Kind::Signed(usize::from(kind.as_bytes()[1] - b'0'))),
            ("<" | "|" | "=", "u1" | "u2" | "u4" | "u8") => Ok(Kind::Unsigned(usize::from(kind.as_bytes()[1] - b'0'))),
            _ => Err(unknown()),
        }
    }

    fn bytes(self) -> usize {
        match self {
            Kind::Double => 8,
            Kind::Single => 4,
            Kind::Signed(bytes) | Kind::Unsigned(bytes) => bytes,
        }
    }

    fn value(self, bytes: &[u8]) -> f64 {
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(bytes);
        match self {
            Kind::Double => f64::from_le_bytes(wide),
            Kind::Single => f32::from_le_bytes([wide[0], wide[1], wide[2], wide[3]]).into(),
            Kind::Unsigned(_) => u64::from_le_bytes(wide) as f64,
            Kind::Signed(count) => {
                let unused = 64 - 8 * count as u32;
                ((i64::from_le_bytes(wide) << unused) >> unused) as f64
            }
        }
    }
}

/// Returns `true` if the file holds one number without dimensions.
pub(super) fn is_scalar(bytes: &[u8]) -> bool {
    let header = String::from_utf8_lossy(&bytes[..bytes.len().min(256)]);
    between(&header, "'shape':", '(', ')').is_some_and(|shape| shape.trim().is_empty())
}

/// Reads the columns of an array.
pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let short = || "a NumPy file that ends within its header".to_owned();
    let length = |at: usize, count: usize| {
        bytes.get(at..at + count).map(|bytes| bytes.iter().rev().fold(0, |sum, &byte| 256 * sum + usize::from(byte)))
    };
    let (begin, length) = match bytes.get(6).copied().ok_or_else(short)? {
        1 => (10, length(8, 2)),
        _ => (12, length(8, 4)),
    };
    let end = begin + length.ok_or_else(short)?;
    let header = std::str::from_utf8(bytes.get(begin..end).ok_or_else(short)?).map_err(|_| short())?;
    let values = &bytes[end..];
    let shape: Vec<usize> = between(header, "'shape':", '(', ')')
        .ok_or("a NumPy file without a shape")?
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| part.parse().map_err(|_| format!("a NumPy file with the length `{}` in its shape", beginning(part))))
        .collect::<Result<_, _>>()?;
    if header.contains("'fortran_order': True") && shape.len() > 1 {
        return Err("a NumPy array in Fortran order: save it with `numpy.ascontiguousarray`".to_owned());
    }
    let rows = shape.first().copied().unwrap_or(0);
    if rows == 0 {
        return Err("a NumPy array without rows".to_owned());
    }
    // The header may state any size: it is compared with the bytes before any memory is reserved.
    let check = |width: usize| match rows.checked_mul(width) {
        Some(needed) if width > 0 && needed <= values.len() => Ok(width),
        _ => Err(format!("a NumPy file with {rows} rows of {width} bytes by its header, but {} bytes after it", values.len())),
    };
    let fields: Vec<(String, Kind)> = match between(header, "'descr':", '[', ']') {
        Some(list) => fields(list)?,
        None => {
            let kind =
                header.split("'descr':").nth(1).and_then(|rest| rest.split('\'').nth(1)).ok_or("a NumPy file without a type")?;
            let kind = Kind::parse(kind)?;
            let width = match shape[..] {
                [_] => 1,
                [_, width] => width,
                _ => return Err(format!("an array with {} dimensions; a signal needs one or two", shape.len())),
            };
            check(width.saturating_mul(kind.bytes()))?;
            (1..=width).map(|place| (format!("column {place}"), kind)).collect()
        }
    };
    let width = check(fields.iter().map(|(_, kind)| kind.bytes()).sum())?;
    let mut at = 0;
    let mut columns = Vec::new();
    for (_, kind) in &fields {
        let column = (0..rows).map(|row| kind.value(&values[row * width + at..row * width + at + kind.bytes()]));
        columns.push(Column { values: column.collect(), words: Vec::new() });
        at += kind.bytes();
    }
    Ok(table(Some(fields.into_iter().map(|(name, _)| name).collect()), columns, "NPY"))
}

/// Returns the text between the brackets after a key; `None` if its value is not in brackets.
fn between<'a>(header: &'a str, key: &str, open: char, close: char) -> Option<&'a str> {
    let rest = header.split(key).nth(1)?.trim_start().strip_prefix(open)?;
    Some(&rest[..rest.find(close)?])
}

/// Parses names and types of `('time_s', '<f8'), …`.
fn fields(list: &str) -> Result<Vec<(String, Kind)>, String> {
    let quoted: Vec<&str> = list.split('\'').skip(1).step_by(2).collect();
    if quoted.len() % 2 == 1 || quoted.is_empty() {
        return Err("a NumPy file with fields that are not pairs of name and type".to_owned());
    }
    quoted.chunks(2).map(|pair| Ok((pair[0].to_owned(), Kind::parse(pair[1])?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(header: &str, values: &[u8]) -> Vec<u8> {
        let length = (header.len() as u16).to_le_bytes();
        [&b"\x93NUMPY\x01\x00"[..], &length, header.as_bytes(), values].concat()
    }

    fn doubles(values: &[f64]) -> Vec<u8> {
        values.iter().flat_map(|value| value.to_le_bytes()).collect()
    }

    fn values(table: &Table) -> Vec<Vec<f64>> {
        table.columns.iter().map(|column| column.values.clone()).collect()
    }

    #[test]
    fn records_and_plain_arrays_are_read() {
        let records = "{'descr': [('time_s', '<f8'), ('force_n', '<f4')], 'fortran_order': False, 'shape': (1,), }\n";
        let table = read(&file(records, &[&doubles(&[0.5])[..], &2.5f32.to_le_bytes()].concat())).unwrap();
        assert_eq!(table.headings(), ["time_s", "force_n"]);
        assert_eq!(values(&table), [vec![0.5], vec![2.5]]);
        let plain = "{'descr': '<f8', 'fortran_order': False, 'shape': (2, 2), }";
        assert_eq!(values(&read(&file(plain, &doubles(&[1.0, 2.0, 3.0, 4.0]))).unwrap()), [vec![1.0, 3.0], vec![2.0, 4.0]]);
        let whole = "{'descr': '<i2', 'fortran_order': False, 'shape': (2,), }";
        assert_eq!(values(&read(&file(whole, &[0xff, 0xff, 5, 0])).unwrap()), [vec![-1.0, 5.0]]);
    }

    #[test]
    fn truncated_and_unknown_files_are_refused() {
        let plain = "{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }";
        assert!(read(&file(plain, &doubles(&[1.0]))).unwrap_err().contains("8 bytes after it"));
        for (shape, why) in [
            ("(0, 4294967296)", "without rows"),
            ("(1, 4294967296)", "bytes after it"),
            ("(4294967296, 4294967296)", "bytes after it"),
            ("(1, 0)", "0 bytes by its header"),
            ("(99999999999999999999, 2)", "the length `99999999999999999999`"),
        ] {
            let refused = read(&file(&plain.replace("(2,)", shape), &doubles(&[1.0, 2.0]))).unwrap_err();
            assert!(refused.contains(why), "{shape}: {refused}");
        }
        assert!(read(&file(&plain.replace("<f8", "<c16"), &[0; 32])).unwrap_err().contains("`<c16`"));
        assert!(read(&file(plain, &[])[..9]).unwrap_err().contains("within its header"));
    }
}
