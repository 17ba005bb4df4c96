//! NumPy files: a plain array, or rows as an array of records, so that
//! `numpy.load("trace.npy")["friction_n"]` is a column.
//!
//! Format version 1.0: a magic number, the length of the header, the header as a Python dictionary
//! padded to a multiple of 64 bytes, then the records
//! (<https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>).

use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;

/// Magic number: a name, and the version.
const MAGIC: [u8; 8] = *b"\x93NUMPY\x01\x00";
/// Alignment of the records, bytes.
const ALIGN: usize = 64;

/// Writes rows of numbers under these names.
pub(super) fn write(columns: &[String], rows: &[Vec<f64>], path: &Path) -> io::Result<()> {
    let mut file = BufWriter::new(File::create(path)?);
    file.write_all(&head(columns, rows.len())?)?;
    for value in rows.iter().flatten() {
        file.write_all(&value.to_le_bytes())?;
    }
    file.flush()
}

/// Writes numbers as an array of this shape, the last dimension fastest.
///
/// # Errors
/// If the array cannot be written.
pub fn write_array(shape: &[usize], values: &[f64], file: &mut impl Write) -> io::Result<()> {
    let shape: String = shape.iter().map(|length| format!("{length}, ")).collect();
    file.write_all(&padded(format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({}), }}", shape.trim_end()))?)?;
    values.iter().try_for_each(|value| file.write_all(&value.to_le_bytes()))
}

fn head(columns: &[String], rows: usize) -> io::Result<Vec<u8>> {
    let fields: String = columns.iter().map(|name| format!("('{name}', '<f8'), ")).collect();
    padded(format!("{{'descr': [{fields}], 'fortran_order': False, 'shape': ({rows},), }}"))
}

/// Returns a header with its prefix and padding.
fn padded(mut header: String) -> io::Result<Vec<u8>> {
    let begin = MAGIC.len() + 2;
    let padding = (begin + header.len() + 1).next_multiple_of(ALIGN) - (begin + header.len() + 1);
    header += &" ".repeat(padding);
    header.push('\n');
    let length = u16::try_from(header.len()).map_err(|_| io::Error::other("too many columns for a NumPy file"))?;
    Ok([&MAGIC[..], &length.to_le_bytes(), header.as_bytes()].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_array_has_its_shape() {
        let mut bytes = Vec::new();
        write_array(&[2, 1], &[1.0, 2.0], &mut bytes).expect("written");
        assert_eq!(
            (bytes.len() % ALIGN, &bytes[bytes.len() - 16..]),
            (16, &[1f64.to_le_bytes(), 2f64.to_le_bytes()].concat()[..])
        );
        let text = String::from_utf8_lossy(&bytes[10..]);
        assert!(text.starts_with("{'descr': '<f8', 'fortran_order': False, 'shape': (2, 1,), }"), "{text}");
    }

    #[test]
    fn header_has_the_numpy_format() {
        let columns = ["time_s", "v_code"].map(String::from);
        let head = head(&columns, 3).expect("a header");
        assert_eq!((&head[..8], head.len() % ALIGN, head.last()), (&MAGIC[..], 0, Some(&b'\n')));
        assert_eq!(usize::from(u16::from_le_bytes([head[8], head[9]])), head.len() - 10);
        let text = String::from_utf8_lossy(&head[10..]);
        assert!(
            text.starts_with("{'descr': [('time_s', '<f8'), ('v_code', '<f8'), ], 'fortran_order': False, 'shape': (3,), }"),
            "{text}"
        );
    }
}
