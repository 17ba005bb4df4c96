//! Tables of any file format, found from the content: delimited text, NPY, NPZ, Parquet and WAV,
//! also compressed by gzip.

mod npy;
mod npz;
mod parquet_file;
mod wav;

use std::io::Read;

use crate::file::MAX_DATA_BYTES;
use crate::table::{Column, Table, read};
use crate::{TableError, decode};

/// Known formats, for a message.
const KNOWN: &str = "known are CSV and other delimited text, NPY, NPZ, Parquet and WAV";

/// Reads the table of a file. `names`, separated by commas, replaces the heading if given.
///
/// # Errors
/// [`TableError`], with the line that causes it if the file is text.
pub fn parse(bytes: &[u8], names: Option<&str>) -> Result<Table, TableError> {
    let binary = |table: Result<Table, String>| table.map_err(TableError::Binary)?.renamed(names);
    match bytes {
        [0x1f, 0x8b, ..] => parse(&unpacked(bytes)?, names),
        [b'P', b'A', b'R', b'1', ..] => binary(parquet_file::read(bytes)),
        [0x93, b'N', b'U', b'M', b'P', b'Y', ..] => binary(npy::read(bytes)),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'A', b'V', b'E', ..] => binary(wav::read(bytes)),
        [b'P', b'K', 3, 4, ..] => binary(npz::read(bytes)),
        _ => read(&text(bytes)?, names),
    }
}

/// Decodes the text of a file, also if it is compressed by gzip.
///
/// # Errors
/// If the file is binary or damaged.
pub fn text(bytes: &[u8]) -> Result<String, TableError> {
    let is_wide = bytes.starts_with(&[0xff, 0xfe]) || bytes.starts_with(&[0xfe, 0xff]);
    match bytes {
        [0x1f, 0x8b, ..] => text(&unpacked(bytes)?),
        _ if bytes.contains(&0) && !is_wide => Err(TableError::Binary(format!("a binary file of unknown format; {KNOWN}"))),
        _ => Ok(decode(bytes)),
    }
}

/// Unpacks a file that gzip has compressed once.
fn unpacked(bytes: &[u8]) -> Result<Vec<u8>, TableError> {
    let damaged = |why: &str| Err(TableError::Binary(format!("a gzip file that cannot be unpacked: {why}")));
    let mut unpacked = Vec::new();
    match flate2::read::MultiGzDecoder::new(bytes).take(MAX_DATA_BYTES + 1).read_to_end(&mut unpacked) {
        Err(error) => damaged(&error.to_string()),
        Ok(count) if count as u64 > MAX_DATA_BYTES => damaged(&format!("more than {} MiB", MAX_DATA_BYTES >> 20)),
        Ok(_) if unpacked.starts_with(&[0x1f, 0x8b]) => damaged("it contains another gzip file"),
        Ok(_) => Ok(unpacked),
    }
}

/// Creates a table of a binary file.
fn table(names: Option<Vec<String>>, columns: Vec<Column>, found: &str) -> Table {
    Table { names, lines: Vec::new(), columns, found: found.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    #[test]
    fn compressed_and_foreign_files_are_told_apart() {
        let packed = |bytes: &[u8]| {
            let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
            packer.write_all(bytes).and_then(|()| packer.finish()).unwrap()
        };
        let csv = packed(b"t,v\n0,1\n1,2\n");
        assert_eq!(parse(&csv, None).unwrap().columns[1].values, [1.0, 2.0]);
        let refused = |bytes: &[u8]| parse(bytes, None).unwrap_err().to_string();
        assert!(refused(&csv[..csv.len() / 2]).contains("cannot be unpacked"));
        assert!(refused(&packed(&csv)).contains("another gzip file"));
        assert!(refused(b"PK\x03\x04abc").starts_with("a ZIP archive that cannot be read"));
        assert!(refused(&[1, 0, 2, 0]).starts_with("a binary file of unknown format"));
        assert_eq!(refused(b""), "it is empty");
    }
}
