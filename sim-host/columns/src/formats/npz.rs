//! NumPy archives (`numpy.savez`): a ZIP archive with one NPY file for each array.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::{npy, table};
use crate::file::MAX_DATA_BYTES;
use crate::table::Table;

/// Reads the arrays of an archive as columns with their names. An array without dimensions, such
/// as a sampling rate, is not a column and is left out.
pub(super) fn read(bytes: &[u8]) -> Result<Table, String> {
    let damaged = |error: &dyn std::fmt::Display| format!("a ZIP archive that cannot be read: {error}");
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| damaged(&error))?;
    let (mut names, mut columns, mut left) = (Vec::new(), Vec::new(), MAX_DATA_BYTES);
    for place in 0..archive.len() {
        let file = archive.by_index(place).map_err(|error| damaged(&error))?;
        let Some(name) = file.name().ok().and_then(|name| name.strip_suffix(".npy").map(str::to_owned)) else {
            return Err("a ZIP archive, but not of NPY arrays; export the table as CSV".to_owned());
        };
        let mut array = Vec::new();
        file.take(left + 1).read_to_end(&mut array).map_err(|error| damaged(&error))?;
        left = left.checked_sub(array.len() as u64).ok_or(format!("an NPZ archive of more than {} MiB", MAX_DATA_BYTES >> 20))?;
        if npy::is_scalar(&array) {
            continue;
        }
        let mut table = npy::read(&array).map_err(|why| format!("array `{name}`: {why}"))?;
        let is_plain = table.columns.len() == 1;
        names.extend(
            table.headings().into_iter().map(|heading| if is_plain { name.clone() } else { format!("{name} {heading}") }),
        );
        columns.append(&mut table.columns);
    }
    let lengths: Vec<usize> = columns.iter().map(|column| column.values.len()).collect();
    match lengths.iter().position(|length| *length != lengths[0]) {
        None if columns.is_empty() => Err("an NPZ archive without an array".to_owned()),
        None => Ok(table(Some(names), columns, "NPZ")),
        Some(other) => Err(format!(
            "an NPZ archive whose arrays `{}` and `{}` have {} and {} values; save those of one table",
            names[0], names[other], lengths[0], lengths[other]
        )),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use zip::write::{SimpleFileOptions, ZipWriter};

    /// Returns an archive of arrays, each with its name, shape and values.
    fn archive(arrays: &[(&str, &str, &[f64])]) -> Vec<u8> {
        let mut writer = ZipWriter::new(Cursor::new(Vec::new()));
        for (name, shape, values) in arrays {
            let header = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': {shape}, }}");
            let values: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
            writer.start_file(*name, SimpleFileOptions::default()).unwrap();
            writer.write_all(b"\x93NUMPY\x01\x00").unwrap();
            writer.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
            writer.write_all(header.as_bytes()).and_then(|()| writer.write_all(&values)).unwrap();
        }
        writer.finish().unwrap().into_inner()
    }

    #[test]
    fn arrays_are_columns_with_their_names() {
        let table = read(&archive(&[
            ("time_s.npy", "(2,)", &[0.0, 0.5]),
            ("rate_hz.npy", "()", &[2.0]),
            ("force_n.npy", "(2, 2)", &[1.0, 2.0, 3.0, 4.0]),
        ]))
        .unwrap();
        assert_eq!(table.headings(), ["time_s", "force_n column 1", "force_n column 2"]);
        assert_eq!(table.columns[2].values, [2.0, 4.0]);
    }

    #[test]
    fn archives_that_are_no_table_are_refused() {
        for (arrays, why) in [
            (&[("t.npy", "(2,)", &[0.0, 0.5][..]), ("v.npy", "(1,)", &[1.0])][..], "`t` and `v` have 2 and 1 values"),
            (&[("xl/workbook.xml", "(1,)", &[0.0])], "not of NPY arrays"),
            (&[("rate_hz.npy", "()", &[2.0])], "without an array"),
            (&[("t.npy", "(9,)", &[0.0])], "array `t`: a NumPy file with 9 rows"),
        ] {
            let refused = read(&archive(arrays)).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
    }
}
